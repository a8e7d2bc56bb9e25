//! Absorption and radiation of the sand around a flush block.

use super::sources::{Grid, extent};
use super::spherical_waves::Follower;
use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::radiation::error::RadiationError;
use nailnoise_meshes::gauss_legendre;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Normalised surface admittance beta = rho0 c0 / Z of a half-space of porous material.
///
/// ```text
/// Z / (rho0 c0) = 1 + 0.070 (f/sigma)^{-0.632} - j 0.107 (f/sigma)^{-0.632}
/// ```
///
/// Y. Miki, J. Acoust. Soc. Jpn. (E) 11, 19 (1990), fitted for 0.01 < f/sigma < 1 and causal below that range.
/// `resistivity` is the flow resistivity sigma \[Pa s/m²\].
pub fn miki_admittance(hz: f64, resistivity: f64) -> Complex<f64> {
    let x = (hz / resistivity).powf(-0.632);
    Complex::new(1.0 + 0.070 * x, -0.107 * x).inv()
}

/// Sand that absorbs sound at grazing incidence.
///
/// Above an infinite locally reacting plane, the power of a compact source in the plane is multiplied by g(f) relative
/// to a rigid plane:
///
/// ```text
/// g(f) = int_0^1 |u / (u + beta)|^2 du       u the cosine of the angle to the normal
/// ```
///
/// The sand in a box is finite, so only the fraction `share` of the loss in decibels is applied.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AbsorbingSand {
    /// Flow resistivity sigma \[Pa s/m²\]; dry sand has 1e5 to 5e5.
    pub resistivity: f64,
    /// Fraction of the loss above an infinite plane in decibels, 0 to 1.
    pub share: f64,
}

impl Default for AbsorbingSand {
    fn default() -> Self {
        Self {
            resistivity: 2.5e5,
            share: 0.5,
        }
    }
}

impl AbsorbingSand {
    /// The power factor g above an infinite plane.
    pub fn infinite_plane_factor(&self, hz: f64) -> f64 {
        let beta = miki_admittance(hz, self.resistivity);
        // The substitution u = t² concentrates the nodes where u ~ beta.
        let value = |t: f64| 2.0 * t * (Complex::from(t * t) / (beta + t * t)).norm_sqr();
        static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(48));
        RULE.iter().map(|(x, w)| 0.5 * w * value(0.5 * (1.0 + x))).sum()
    }

    /// The applied factor g^share.
    pub fn factor(&self, hz: f64) -> f64 {
        self.infinite_plane_factor(hz).powf(self.share)
    }

    pub(super) fn check(&self) -> Result<(), InputError> {
        positive("flow resistivity of the sand [Pa s/m2]", self.resistivity)?;
        if (0.0..=1.0).contains(&self.share) {
            Ok(())
        } else {
            Err(InputError::OutsideRange {
                what: "share of the sand's absorption",
                value: self.share,
                low: 0.0,
                high: 1.0,
            })
        }
    }
}

/// Sand that moves and radiates with the block.
///
/// ```text
/// v(s) = v_edge (2/pi) asin(a / (a + s)) e^{-j k_R s (1 - j eta/2)}      a = sqrt(A/pi),  k_R = omega / c_R
/// ```
///
/// s is the distance from the edge of the block. v_edge is the block's velocity at the nearest point of its edge, and A
/// the area of its top. The law is the static surface displacement around a rigid disc, propagating outward as a
/// Rayleigh wave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MovingSand {
    /// The block's top: intervals of x and y \[m\].
    pub footprint: [[f64; 2]; 2],
    /// The sand's surface: intervals of x and y \[m\].
    pub sand: [[f64; 2]; 2],
    /// Shear wave speed V_s of the sand \[m/s\].
    pub shear_speed: f64,
    /// Poisson's ratio nu of the sand \[-\], 0 to 0.5.
    pub poisson_ratio: f64,
    /// Loss factor eta of the sand.
    pub loss_factor: f64,
    /// Highest frequency at which the sand moves \[Hz\]; its motion fades out over the third of an octave below.
    pub to_hz: f64,
}

/// Relative difference below which lengths count as equal.
const ROUNDING: f64 = 1e-6;

/// Quadrature points on the sand's surface; the motion of each follows a point of the block's edge.
#[derive(Debug, Clone)]
pub(super) struct SandPatch {
    /// Positions, x and y \[m\].
    pub(super) places: Vec<[f64; 2]>,
    /// Bounding rectangle: intervals of x and y \[m\].
    pub(super) extent: [[f64; 2]; 2],
    points: Vec<FollowingPoint>,
    /// Modal displacements of the block at the edge points that the sand follows, edge points x modes.
    pub(super) edge: DMatrix<f64>,
    radius: f64,
    law: MovingSand,
}

/// A point of the sand's surface.
#[derive(Debug, Clone)]
struct FollowingPoint {
    /// Index of the edge point that it follows.
    leader: usize,
    /// Distance from that point \[m\].
    distance: f64,
    /// Its quadrature weight \[m²\].
    weight: f64,
}

impl MovingSand {
    pub(super) fn check(&self) -> Result<(), RadiationError> {
        positive("shear wave speed of the sand [m/s]", self.shear_speed)?;
        if !(0.0..0.5).contains(&self.poisson_ratio) {
            return Err(InputError::OutsideRange {
                what: "Poisson's ratio of the sand",
                value: self.poisson_ratio,
                low: 0.0,
                high: 0.5,
            }
            .into());
        }
        positive("upper frequency of the moving sand [Hz]", self.to_hz)?;
        let inside = |i: usize| {
            let ([a, b], [c, d]) = (self.footprint[i], self.sand[i]);
            c < a && a < b && b < d
        };
        if inside(0) && inside(1) {
            Ok(())
        } else {
            Err(RadiationError::SandBox {
                footprint: self.footprint,
                sand: self.sand,
            })
        }
    }

    /// Gauss points on the eight rectangles around the footprint, dense enough for the shortest Rayleigh wave.
    pub(super) fn patch(&self, air: &Air, block: &[[f64; 2]], displacement: &DMatrix<f64>) -> SandPatch {
        let k = 2.0 * PI * self.to_hz * (1.0 / self.rayleigh_speed() + 1.0 / air.sound_speed);
        let strips = |i: usize| {
            let ([a, b], [c, d]) = (self.footprint[i], self.sand[i]);
            [(c, a), (a, b), (b, d)].map(|(low, high)| {
                // Gauss rules need at least two points per wavelength; the others resolve the amplitude law.
                let n = (k * (high - low) / PI * 1.3).ceil() as usize + 6;
                let half = 0.5 * (high - low);
                gauss_legendre(n)
                    .into_iter()
                    .map(|(x, w)| (low + half * (1.0 + x), half * w))
                    .collect::<Vec<_>>()
            })
        };
        let (xs, ys) = (strips(0), strips(1));
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (i, x_strip) in xs.iter().enumerate() {
            for y_strip in ys
                .iter()
                .enumerate()
                .filter(|(j, _)| (i, *j) != (1, 1))
                .map(|(_, strip)| strip)
            {
                for (x, wx) in x_strip {
                    for (y, wy) in y_strip {
                        points.push([*x, *y]);
                        weights.push(wx * wy);
                    }
                }
            }
        }
        let mut leaders: BTreeMap<[u64; 2], usize> = BTreeMap::new();
        let mut edge = Vec::new();
        let mut follow = |(p, weight): (&[f64; 2], f64)| {
            let at = self.edge(*p);
            let leader = *leaders.entry(at.map(f64::to_bits)).or_insert_with(|| {
                edge.push(plane_fit(block, displacement, at));
                edge.len() - 1
            });
            FollowingPoint {
                leader,
                distance: (p[0] - at[0]).hypot(p[1] - at[1]),
                weight,
            }
        };
        let following = points.iter().zip(weights).map(&mut follow).collect();
        SandPatch {
            extent: extent(&points),
            places: points,
            points: following,
            edge: DMatrix::from_rows(&edge),
            radius: self.radius(),
            law: *self,
        }
    }
}

/// Displacement at a point of the edge, from a least-squares plane through the nine nearest quadrature points. Further
/// points at the same distance as the ninth are included, so that mirror images of edge points move equally. The plane
/// is exact for rigid motion.
fn plane_fit(block: &[[f64; 2]], displacement: &DMatrix<f64>, at: [f64; 2]) -> nalgebra::RowDVector<f64> {
    let mut near: Vec<(f64, usize)> = block
        .iter()
        .enumerate()
        .map(|(i, p)| ((p[0] - at[0]).hypot(p[1] - at[1]), i))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let ninth = near.get(8).map_or(f64::INFINITY, |(distance, _)| *distance);
    near.retain(|(distance, _)| *distance <= ninth * (1.0 + ROUNDING));
    let rows: Vec<usize> = near.iter().map(|(_, i)| *i).collect();
    let values = displacement.select_rows(&rows);
    let size = if ninth.is_finite() && ninth > 0.0 { ninth } else { 1.0 };
    let basis = DMatrix::from_fn(rows.len(), 3, |i, j| match j {
        0 => 1.0,
        j => (block[rows[i]][j - 1] - at[j - 1]) / size,
    });
    // Collinear points do not determine a plane.
    let factor = (basis.transpose() * &basis).cholesky();
    match factor.filter(|factor| factor.l_dirty().diagonal().min() > ROUNDING) {
        // The plane's value at the edge point is its constant term.
        Some(factor) => (basis * factor.solve(&DVector::from_vec(vec![1.0, 0.0, 0.0]))).transpose() * values,
        None => values.row(0).into_owned(),
    }
}

impl SandPatch {
    /// Motion of each point relative to its edge point at one frequency; `None` above the frequency range of the moving
    /// sand.
    pub(super) fn followers(&self, hz: f64) -> Option<Vec<Follower>> {
        self.law.fade(hz)?;
        let follower = |p: &FollowingPoint| Follower {
            leader: p.leader,
            amplitude: p.weight * self.law.carried(p.distance, self.radius, hz),
        };
        Some(self.points.iter().map(follower).collect())
    }

    /// The points that follow each edge point, as equivalent sources on a grid: real and imaginary part, grid points x
    /// edge points.
    pub(super) fn carried(&self, grid: &Grid, followers: &[Follower]) -> [DMatrix<f64>; 2] {
        let n = grid.len();
        let mut carried = [0, 1].map(|_| DMatrix::zeros(n, self.edge.nrows()));
        let mut shares = vec![0.0; n];
        for (place, follower) in self.places.iter().zip(followers) {
            grid.shares(*place, &mut shares);
            let amplitude = follower.amplitude;
            for (carried, amplitude) in carried.iter_mut().zip([amplitude.re, amplitude.im]) {
                let to = &mut carried.as_mut_slice()[follower.leader * n..][..n];
                to.iter_mut()
                    .zip(&shares)
                    .for_each(|(to, share)| *to += amplitude * share);
            }
        }
        carried
    }

    /// Largest delay of the sand relative to the edge of the block \[s\].
    pub(super) fn lag(&self) -> f64 {
        let farthest = self.points.iter().fold(0.0, |a: f64, p| a.max(p.distance));
        farthest / self.law.rayleigh_speed()
    }

    /// Same as [`MovingSand::fade_hz`].
    pub(super) fn fade_hz(&self) -> [f64; 2] {
        self.law.fade_hz()
    }
}

impl MovingSand {
    /// Rayleigh wave speed c_R \[m/s\], from x = (c_R/V_s)^2 in 0 < x < 1:
    /// x^3 - 8 x^2 + (24 - 16 q) x - 16 (1 - q) = 0, q = (1 - 2 nu)/(2 (1 - nu)).
    ///
    /// Lord Rayleigh (1885), "On waves propagated along the plane surface of an elastic solid", Proceedings of the
    /// London Mathematical Society 17, 4-11; I. A. Viktorov (1967), "Rayleigh and Lamb Waves", Plenum Press.
    pub fn rayleigh_speed(&self) -> f64 {
        let nu = self.poisson_ratio;
        let q = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu));
        let newton = |x: f64, _| {
            let value = ((x - 8.0) * x + 24.0 - 16.0 * q) * x - 16.0 * (1.0 - q);
            x - value / ((3.0 * x - 16.0) * x + 24.0 - 16.0 * q)
        };
        // Viktorov's approximation is within 0.5 %: four steps reach the last bit.
        let x = (0..4).fold(((0.87 + 1.12 * nu) / (1.0 + nu)).powi(2), newton);
        self.shear_speed * x.sqrt()
    }

    /// The point of the block's edge nearest to a point (x, y) of the sand's surface \[m\].
    pub fn edge(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| point[i].clamp(self.footprint[i][0], self.footprint[i][1]))
    }

    /// v(s)/v_edge at a point (x, y) of the sand's surface, relative to the velocity of the block at [`Self::edge`]; 0
    /// above the frequency range of the moving sand.
    pub fn ratio(&self, point: [f64; 2], hz: f64) -> Complex<f64> {
        let edge = self.edge(point);
        let distance = (point[0] - edge[0]).hypot(point[1] - edge[1]);
        self.carried(distance, self.radius(), hz)
    }

    fn carried(&self, s: f64, radius: f64, hz: f64) -> Complex<f64> {
        let fade = self.fade(hz).unwrap_or(0.0);
        let k = 2.0 * PI * hz / self.rayleigh_speed();
        let amplitude = 2.0 / PI * (radius / (radius + s)).asin() * (-0.5 * self.loss_factor * k * s).exp();
        Complex::from_polar(fade * amplitude, -k * s)
    }

    /// a = sqrt(A/pi) of the block's top.
    fn radius(&self) -> f64 {
        let [[x0, x1], [y0, y1]] = self.footprint;
        ((x1 - x0) * (y1 - y0) / PI).sqrt()
    }

    /// Frequency range of one third of an octave over which the motion fades out \[Hz\]. Its second derivative is
    /// discontinuous at both ends.
    fn fade_hz(&self) -> [f64; 2] {
        [self.to_hz * 10f64.powf(-0.1), self.to_hz]
    }

    /// 1 up to one third of an octave below `to_hz`, then a smooth decrease to 0 at `to_hz`.
    fn fade(&self, hz: f64) -> Option<f64> {
        let [start, _] = self.fade_hz();
        match (hz - start) / (self.to_hz - start) {
            x if x <= 0.0 => Some(1.0),
            x if x < 1.0 => Some(0.5 * (1.0 + (PI * x).cos())),
            _ => None,
        }
    }
}

use super::kernel::pairwise;
use super::plane_waves::{Directions, PlanarPoints};
use super::resistance::Resistance;
use super::sampled::{SampledRadiation, Sampling};
use super::sand::{AbsorbingSand, MovingSand, SandPatch};
use super::surface::RadiatingSurface;
use crate::air::Air;
use crate::error::{AcousticsError, positive};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use serde::Serialize;
use std::f64::consts::PI;

/// Rayleigh's integral for a flat surface, flush in an infinite rigid plane, that radiates to its upper side.
///
/// ```text
/// R = rho0 omega^2 / (2 pi c0) Phi_n^T S K S Phi_n       K_ab = sin(k r_ab) / (k r_ab)
/// ```
///
/// S holds the quadrature weights. The kernel is smooth, so a Gauss rule on the faces converges spectrally. It is
/// applied as a sum of plane waves; [`Self::second_evaluation`] compares with the pairwise sum.
#[derive(Debug, Clone)]
pub struct Rayleigh {
    air: Air,
    points: Vec<[f64; 2]>,
    planar: PlanarPoints,
    /// z of all points.
    plane: f64,
    rows: Vec<Vec<usize>>,
    displacement: DMatrix<f64>,
    sources: DMatrix<f64>,
    patches: Vec<String>,
    absorbing: Option<AbsorbingSand>,
    moving: Option<SandPatch>,
}

/// Two evaluations of the same resistance at one frequency: plane waves (far field) and pairs of points (surface).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SecondEvaluation {
    /// Frequency \[Hz\].
    pub hz: f64,
    /// Largest difference of an entry R_ij over sqrt(R_ii R_jj).
    pub difference: f64,
}

impl Rayleigh {
    /// The operator for a flat surface that faces up (+z), with its points in one plane z = const.
    ///
    /// # Errors
    /// [`AcousticsError::NotPlanar`] for any other surface.
    pub fn new(surface: &RadiatingSurface, air: &Air) -> Result<Self, AcousticsError> {
        positive("area of the surface [m2]", surface.area())?;
        let points: Vec<[f64; 2]> = surface.points().iter().map(|p| [p.x, p.y]).collect();
        let planar = PlanarPoints::new(&points);
        let plane = surface.points()[0].z;
        for (point, (p, normal)) in surface.points().iter().zip(surface.normals()).enumerate() {
            let offset = p.z - plane;
            if offset.abs() > 1e-6 * planar.diameter || normal.z < 1.0 - 1e-6 {
                return Err(AcousticsError::NotPlanar {
                    point,
                    offset,
                    plane,
                    normal: normal.z,
                });
            }
        }
        let patches = surface.patch_names().to_vec();
        let rows = (0..patches.len())
            .map(|p| (0..points.len()).filter(|&i| surface.patch()[i] == p).collect())
            .collect();
        let displacement = surface.normal_modes().clone();
        let mut sources = displacement.clone();
        for (row, weight) in surface.weights().iter().enumerate() {
            sources.row_mut(row).scale_mut(*weight);
        }
        Ok(Self {
            air: *air,
            points,
            planar,
            plane,
            rows,
            displacement,
            sources,
            patches,
            absorbing: None,
            moving: None,
        })
    }

    /// With sand around the surface that absorbs part of the power.
    ///
    /// # Errors
    /// A resistivity that is not positive, a share outside 0 to 1.
    pub fn with_absorbing_sand(mut self, sand: AbsorbingSand) -> Result<Self, AcousticsError> {
        sand.check()?;
        self.absorbing = Some(sand);
        Ok(self)
    }

    /// With sand around the surface that moves with it; it becomes one more patch, `sand`.
    ///
    /// # Errors
    /// A footprint outside the box, a speed or frequency that is not positive.
    pub fn with_moving_sand(mut self, sand: MovingSand) -> Result<Self, AcousticsError> {
        sand.check()?;
        self.moving = Some(sand.patch(&self.air, &self.points, &self.displacement));
        if self.patches.len() == self.rows.len() {
            self.patches.push("sand".to_owned());
        }
        Ok(self)
    }

    /// Names of the patches.
    pub fn patches(&self) -> &[String] {
        &self.patches
    }

    /// Resistance of every patch at the frequency `hz`; they add up to the whole, which is positive semidefinite.
    pub fn resistance(&self, hz: f64) -> Vec<Resistance> {
        let omega = 2.0 * PI * hz;
        let k = omega / self.air.sound_speed;
        let sand = self.moving.as_ref().and_then(|sand| Some((sand, sand.sources(hz)?)));
        let sand_diameter = sand.as_ref().map_or(0.0, |(sand, _)| sand.planar.diameter);
        let directions = Directions::new(k, self.planar.diameter.max(sand_diameter));
        let (n, modes) = (2 * directions.len(), self.sources.ncols());
        let mut fields: Vec<(DMatrix<f64>, Option<DMatrix<f64>>)> = Vec::new();
        for rows in &self.rows {
            let mut field = DMatrix::zeros(n, modes);
            directions.add_field(k, &self.planar, rows, &self.sources, &mut field);
            fields.push((field, None));
        }
        if self.moving.is_some() {
            let (mut real, mut imaginary) = (DMatrix::zeros(n, modes), None);
            if let Some((sand, (re, im))) = &sand {
                let rows: Vec<usize> = (0..sand.planar.len()).collect();
                directions.add_field(k, &sand.planar, &rows, re, &mut real);
                let mut field = DMatrix::zeros(n, modes);
                directions.add_field(k, &sand.planar, &rows, im, &mut field);
                imaginary = Some(field);
            }
            fields.push((real, imaginary));
        }
        let factor = self.factor(hz);
        patch_forms(&fields)
            .into_iter()
            .map(|form| form.scaled(factor))
            .collect()
    }

    /// The resistance over a range of frequencies, sampled as finely as `sampling` asks.
    ///
    /// # Errors
    /// An empty range, or a tolerance that the allowed number of samples cannot meet.
    pub fn sampled(&self, sampling: &Sampling) -> Result<SampledRadiation, AcousticsError> {
        self.sampled_telling(sampling, &|| ())
    }

    /// The same; `tell` is called whenever one more frequency has been sampled.
    ///
    /// # Errors
    /// Those of [`Rayleigh::sampled`].
    pub fn sampled_telling(
        &self,
        sampling: &Sampling,
        tell: &(dyn Fn() + Sync),
    ) -> Result<SampledRadiation, AcousticsError> {
        let method = match (&self.absorbing, &self.moving) {
            (None, None) => "Rayleigh",
            (Some(_), None) => "Rayleigh, absorbing sand",
            (None, Some(_)) => "Rayleigh, moving sand",
            (Some(_), Some(_)) => "Rayleigh, absorbing and moving sand",
        };
        let kinks = self
            .moving
            .as_ref()
            .map_or_else(Vec::new, |sand| sand.fade_hz().to_vec());
        let (modes, patches) = (self.sources.ncols(), self.patches.clone());
        SampledRadiation::with_kinks(method, modes, patches, (sampling, &kinks), |hz| {
            let resistance = self.resistance(hz);
            tell();
            resistance
        })
    }

    /// The air above the plane.
    pub fn air(&self) -> &Air {
        &self.air
    }

    /// Pressure at places above the plane per unit of modal acceleration, places x modes \[Pa per m/s²\].
    ///
    /// ```text
    /// p(x) = rho0/(2 pi) sum_a S_a phi_a e^{-jkr}/r,   r = |x - x_a|
    /// ```
    ///
    /// times the root of what absorbing sand leaves of the power.
    ///
    /// # Errors
    /// [`AcousticsError::BelowFloor`] for a place below the plane, [`AcousticsError::NearSurface`] for one closer to it than
    /// the surface's diameter over the root of its number of points.
    pub fn pressure_at(&self, hz: f64, places: &[Point3<f64>]) -> Result<DMatrix<Complex<f64>>, AcousticsError> {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let needed = self.clearance();
        for place in places {
            let distance = place.z - self.plane;
            if distance.is_nan() || distance < 0.0 {
                return Err(AcousticsError::BelowFloor {
                    z: place.z,
                    floor: self.plane,
                });
            }
            if distance < needed {
                return Err(AcousticsError::NearSurface {
                    point: (*place).into(),
                    distance,
                    needed,
                });
            }
        }
        Ok(self.carried_by(hz, places.len(), |i, [x, y]| {
            let p = places[i];
            let r = (p.x - x).hypot(p.y - y).hypot(p.z - self.plane);
            Complex::from_polar(1.0 / r, -k * r)
        }))
    }

    /// Least height above the plane at which the pressure can be evaluated \[m\].
    fn clearance(&self) -> f64 {
        self.planar.diameter / (self.points.len() as f64).sqrt()
    }

    /// Whether the pressure at each point can be evaluated, see [`Rayleigh::pressure_at`].
    pub fn is_clear(&self, points: &[Point3<f64>]) -> Vec<bool> {
        points.iter().map(|p| p.z - self.plane >= self.clearance()).collect()
    }

    /// rho0/(2 pi) sum_a S_a phi_a wave(i, x_a) over block and sand, i x modes, times the root of what absorbing sand
    /// leaves of the power.
    fn carried_by(
        &self,
        hz: f64,
        count: usize,
        wave: impl Fn(usize, [f64; 2]) -> Complex<f64>,
    ) -> DMatrix<Complex<f64>> {
        let waves = |points: &PlanarPoints| {
            let all = DMatrix::from_fn(count, points.len(), |i, j| wave(i, points.at(j)));
            (all.map(|z| z.re), all.map(|z| z.im))
        };
        let (re, im) = waves(&self.planar);
        let mut real = &re * &self.sources;
        let mut imaginary = &im * &self.sources;
        if let Some((sand, (of_re, of_im))) = self.moving.as_ref().and_then(|s| Some((s, s.sources(hz)?))) {
            let (re, im) = waves(&sand.planar);
            real += &re * &of_re - &im * &of_im;
            imaginary += &re * &of_im + &im * &of_re;
        }
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        let factor = self.air.density / (2.0 * PI) * absorption.sqrt();
        real.zip_map(&imaginary, |re, im| Complex::new(factor * re, factor * im))
    }

    /// Points of block and sand with the modes' displacements times area there, real and, where sand moves, imaginary
    /// part.
    pub(super) fn all_sources(&self, hz: f64) -> (Vec<[f64; 2]>, DMatrix<f64>, Option<DMatrix<f64>>) {
        let own = self.points.len();
        let Some((sand, (re, im))) = self.moving.as_ref().and_then(|s| Some((s, s.sources(hz)?))) else {
            return (self.points.clone(), self.sources.clone(), None);
        };
        let points: Vec<[f64; 2]> = self
            .points
            .iter()
            .copied()
            .chain((0..sand.planar.len()).map(|i| sand.planar.at(i)))
            .collect();
        let mut real = DMatrix::zeros(points.len(), self.sources.ncols());
        let mut imaginary = real.clone();
        real.rows_mut(0, own).copy_from(&self.sources);
        real.rows_mut(own, re.nrows()).copy_from(&re);
        imaginary.rows_mut(own, im.nrows()).copy_from(&im);
        (points, real, Some(imaginary))
    }

    /// Middle of all that moves, and how much later than from there waves from any of it can be, as a way in air \[m\]:
    /// sand moves later by what waves in it take from the block's edge.
    pub(crate) fn reach(&self) -> (f64, Point3<f64>) {
        let own = (0..self.planar.len()).map(|i| self.planar.at(i));
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in own {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let middle = Point3::new(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), self.plane);
        let own = 0.5 * self.planar.diameter;
        let sand = self.moving.as_ref().map_or(0.0, |sand| {
            0.5 * sand.planar.diameter + 0.5 * sand.lag() * self.air.sound_speed
        });
        (own.max(sand), middle)
    }

    /// Over which frequencies the sand's motion fades out, where it moves.
    pub(crate) fn fade_hz(&self) -> Option<[f64; 2]> {
        self.moving.as_ref().map(SandPatch::fade_hz)
    }

    /// Far field r p e^{jkr} in directions above the plane per unit of modal acceleration, r from the point (0, 0) of the
    /// plane, directions x modes \[Pa m per m/s²\].
    ///
    /// ```text
    /// r p e^{jkr} = rho0/(2 pi) sum_a S_a phi_a e^{jk d.x_a}
    /// ```
    ///
    /// times the root of what absorbing sand leaves of the power.
    pub fn far_field_at(&self, hz: f64, directions: &[Vector3<f64>]) -> DMatrix<Complex<f64>> {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let wave =
            |i: usize, [x, y]: [f64; 2]| Complex::from_polar(1.0, k * (directions[i].x * x + directions[i].y * y));
        self.carried_by(hz, directions.len(), wave)
    }

    /// Compares the plane waves with the pairwise sum over the surface (without moving sand) at one frequency.
    pub fn second_evaluation(&self, hz: f64) -> SecondEvaluation {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let bare = Self {
            moving: None,
            ..self.clone()
        };
        let mut far = Resistance::zeros(self.sources.ncols());
        bare.resistance(hz).iter().for_each(|patch| far.add_scaled(1.0, patch));
        let near = pairwise(k, &self.points, &self.sources) * self.factor(hz);
        SecondEvaluation {
            hz,
            difference: relative_difference(&far.real, &near),
        }
    }

    /// rho0 omega² / (2 pi c0), times the sand's absorption.
    pub(super) fn factor(&self, hz: f64) -> f64 {
        let omega = 2.0 * PI * hz;
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        absorption * self.air.density * omega * omega / (2.0 * PI * self.air.sound_speed)
    }
}

/// The Hermitian parts of Y_p^H Y for every patch field Y_p, with Y their sum.
fn patch_forms(fields: &[(DMatrix<f64>, Option<DMatrix<f64>>)]) -> Vec<Resistance> {
    let mut real = fields[0].0.clone();
    let mut imaginary: Option<DMatrix<f64>> = None;
    for (re, im) in &fields[1..] {
        real += re;
        imaginary = imaginary.or_else(|| im.clone());
    }
    let form = |(re, im): &(DMatrix<f64>, Option<DMatrix<f64>>)| {
        let mut symmetric = product(re, &real);
        // Y_p^H Y = (A - jB)^T (C + jD) = A^T C + B^T D + j (A^T D - B^T C)
        let mut skew = imaginary.as_ref().map(|d| product(re, d));
        if let (Some(b), Some(d), Some(skew)) = (im, &imaginary, &mut skew) {
            symmetric += product(b, d);
            *skew -= product(b, &real);
        }
        let symmetric = (&symmetric + symmetric.transpose()) * 0.5;
        Resistance {
            real: symmetric,
            imaginary: skew.map(|s| (&s - s.transpose()) * 0.5),
        }
    };
    fields.iter().map(form).collect()
}

/// A^T B through the blocked matrix product, which nalgebra's own `tr_mul` is not.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    a.transpose() * b
}

/// Largest |A_ij - B_ij| / sqrt(A_ii A_jj) over modes that radiate.
fn relative_difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let floor = 1e-12 * a.diagonal().amax();
    let scale = |i: usize| a[(i, i)].max(floor).sqrt();
    let mut worst: f64 = 0.0;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            let difference = (a[(i, j)] - b[(i, j)]).abs();
            if difference > 0.0 {
                worst = worst.max(difference / (scale(i) * scale(j)));
            }
        }
    }
    worst
}

//! Radiation of a plane surface by Rayleigh's integral, with absorbing and moving sand around it.

use super::kernel::outgoing;
use super::sand::{AbsorbingSand, MovingSand, SandPatch};
use super::sources::{Sources, extent};
use super::spherical_waves::{Follower, SphericalWaves};
use crate::air::Air;
use crate::checks::{InputError, ReceiverError, positive};
use crate::error::AcousticsError;
use crate::radiation::error::RadiationError;
use crate::radiation::resistance::Resistance;
use crate::radiation::sampled::{SampledRadiation, Sampling};
use crate::radiation::surface::RadiatingSurface;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use std::f64::consts::PI;

/// Rayleigh's integral for a flat surface flush with an infinite rigid plane, radiating to its upper side.
///
/// ```text
/// R = rho0 omega^2 / (2 pi c0) Phi_n^T S K S Phi_n       K_ab = sin(k r_ab) / (k r_ab)
/// ```
///
/// S contains the quadrature weights. The kernel is smooth, so a Gauss rule on the faces converges spectrally. The
/// kernel is applied as a sum of spherical waves, whereas [`Self::surface_resistance`] sums over pairs of points.
#[derive(Debug, Clone)]
pub struct Rayleigh {
    air: Air,
    sources: Sources,
    /// Bounding rectangle of the surface: intervals of x and y.
    extent: [[f64; 2]; 2],
    /// z of all points.
    plane: f64,
    /// Smallest height above the plane at which the pressure can be evaluated \[m\].
    clearance: f64,
    displacement: DMatrix<f64>,
    patches: Vec<String>,
    absorbing: Option<AbsorbingSand>,
    moving: Option<SandPatch>,
}

impl Rayleigh {
    /// Creates the operator for a flat surface that faces up (+z), with all points in a plane z = const.
    ///
    /// # Errors
    /// [`RadiationError::NotPlanar`] for any other surface.
    pub fn new(surface: &RadiatingSurface, air: &Air) -> Result<Self, RadiationError> {
        positive("area of the surface [m2]", surface.area())?;
        let points: Vec<[f64; 2]> = surface.points().iter().map(|p| [p.x, p.y]).collect();
        let extent = extent(&points);
        let diameter = diameter(extent);
        let plane = surface.points()[0].z;
        for (point, (p, normal)) in surface.points().iter().zip(surface.normals()).enumerate() {
            let offset = p.z - plane;
            if offset.abs() > 1e-6 * diameter || normal.z < 1.0 - 1e-6 {
                return Err(RadiationError::NotPlanar {
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
        let mut strengths = displacement.clone();
        for (row, weight) in surface.weights().iter().enumerate() {
            strengths.row_mut(row).scale_mut(*weight);
        }
        Ok(Self {
            air: *air,
            extent,
            plane,
            clearance: diameter / (points.len() as f64).sqrt(),
            displacement,
            sources: Sources {
                points,
                rows,
                strengths,
            },
            patches,
            absorbing: None,
            moving: None,
        })
    }

    /// Adds surrounding sand that absorbs part of the power.
    ///
    /// # Errors
    /// If the resistivity is not positive or the share is outside 0 to 1.
    pub fn with_absorbing_sand(mut self, sand: AbsorbingSand) -> Result<Self, InputError> {
        sand.check()?;
        self.absorbing = Some(sand);
        Ok(self)
    }

    /// Adds surrounding sand that moves with the surface; it becomes another patch, `sand`.
    ///
    /// # Errors
    /// If the footprint is outside the box, or a speed or frequency is not positive.
    pub fn with_moving_sand(mut self, sand: MovingSand) -> Result<Self, RadiationError> {
        sand.check()?;
        self.moving = Some(sand.patch(&self.air, &self.sources.points, &self.displacement));
        if self.patches.len() == self.sources.rows.len() {
            self.patches.push("sand".to_owned());
        }
        Ok(self)
    }

    /// Names of the patches.
    pub fn patches(&self) -> &[String] {
        &self.patches
    }

    /// The same surface with the smallest number of sources that represents waves up to the frequency `hz`. They are
    /// equivalent to the surface at points that are [far](Self::is_far) from it.
    pub(crate) fn up_to(&self, hz: f64) -> Self {
        Self {
            sources: self.sources.fewer(2.0 * PI * hz / self.air.sound_speed),
            ..self.clone()
        }
    }

    /// Whether a point is farther from the centre of the surface than the diameter of the surface.
    pub(crate) fn is_far(&self, place: &Point3<f64>) -> bool {
        let [x, y] = middle(self.extent);
        (place - Point3::new(x, y, self.plane)).norm() > diameter(self.extent)
    }

    /// Resistance of each patch at the frequency `hz`; the sum is positive semidefinite.
    pub fn resistance(&self, hz: f64) -> Vec<Resistance> {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let Sources {
            points,
            rows,
            strengths,
        } = &self.sources;
        let sand = self.moving_sand(hz);
        let middle = middle(sand.as_ref().map_or(self.extent, |(sand, _)| sand.extent));
        let waves = SphericalWaves::new(k, middle, radius(points, middle));
        let fields: Vec<DMatrix<f64>> = rows.iter().map(|rows| waves.field(points, rows, strengths)).collect();
        let sand = sand.map(|(sand, followers)| {
            let waves = SphericalWaves::new(k, middle, radius(&sand.places, middle));
            let of_sand = waves.field_of_followers(&sand.places, &followers, sand.edge.nrows());
            (of_sand, &sand.edge)
        });
        let mut forms = patch_forms(&fields, sand, self.factor(hz));
        forms.resize(self.patches.len(), Resistance::zeros(strengths.ncols()));
        forms
    }

    /// The moving sand, and the motion of its points relative to the edge of the block; `None` if the sand does not
    /// move.
    pub(super) fn moving_sand(&self, hz: f64) -> Option<(&SandPatch, Vec<Follower>)> {
        self.moving.as_ref().and_then(|sand| Some((sand, sand.followers(hz)?)))
    }

    /// Points of the surface without sand, and modal displacements there times area, points x modes.
    pub(super) fn own_sources(&self) -> (&[[f64; 2]], &DMatrix<f64>) {
        (&self.sources.points, &self.sources.strengths)
    }

    /// Samples the resistance over a range of frequencies to the tolerance of `sampling`; `progress` is called after
    /// each frequency.
    ///
    /// # Errors
    /// If the range is empty, or the tolerance cannot be met with the allowed number of samples.
    pub fn sampled(
        &self,
        sampling: &Sampling,
        progress: &(dyn Fn() + Sync),
    ) -> Result<SampledRadiation, AcousticsError> {
        let method = Self::method(self.absorbing.is_some(), self.moving.is_some());
        let kinks = self
            .moving
            .as_ref()
            .map_or_else(Vec::new, |sand| sand.fade_hz().to_vec());
        let modes = self.displacement.ncols();
        SampledRadiation::new(method, modes, &self.patches, (sampling, &kinks), |hz| {
            let resistance = self.resistance(hz);
            progress();
            resistance
        })
    }

    /// Label of the operator with absorbing or moving sand.
    pub(crate) fn method(absorbing: bool, moving: bool) -> &'static str {
        match (absorbing, moving) {
            (false, false) => "Rayleigh",
            (true, false) => "Rayleigh, absorbing sand",
            (false, true) => "Rayleigh, moving sand",
            (true, true) => "Rayleigh, absorbing and moving sand",
        }
    }

    /// The air above the plane.
    pub fn air(&self) -> &Air {
        &self.air
    }

    /// Pressure at points above the plane per unit of modal acceleration, points x modes \[Pa per m/s²\].
    ///
    /// ```text
    /// p(x) = rho0/(2 pi) sum_a S_a phi_a e^{-jkr}/r,   r = |x - x_a|
    /// ```
    ///
    /// times the square root of the absorbing sand's power factor.
    ///
    /// # Errors
    /// [`ReceiverError::BelowFloor`] for a point below the plane. [`ReceiverError::NearSurface`] for a point closer to
    /// the plane than the surface's diameter divided by the square root of its number of points.
    pub fn pressure_at(&self, hz: f64, places: &[Point3<f64>]) -> Result<DMatrix<Complex<f64>>, ReceiverError> {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let needed = self.clearance;
        for place in places {
            let distance = place.z - self.plane;
            if distance.is_nan() || distance < 0.0 {
                return Err(ReceiverError::BelowFloor {
                    z: place.z,
                    floor: self.plane,
                });
            }
            if distance < needed {
                return Err(ReceiverError::NearSurface {
                    point: (*place).into(),
                    distance,
                    needed,
                });
            }
        }
        Ok(self.carried_by(hz, places.len(), |i, points, waves| {
            let p = places[i];
            outgoing(k, ([p.x, p.y], p.z - self.plane), points, waves);
        }))
    }

    /// Whether the pressure at each point can be evaluated, see [`Rayleigh::pressure_at`].
    pub fn is_clear(&self, points: &[Point3<f64>]) -> Vec<bool> {
        points.iter().map(|p| p.z - self.plane >= self.clearance).collect()
    }

    /// rho0/(2 pi) sum_a S_a phi_a w_i(x_a) over block and sand, i x modes, times the square root of the absorbing
    /// sand's power factor. `fill` writes the real and imaginary parts of w_i at points given by their coordinates.
    fn carried_by(
        &self,
        hz: f64,
        count: usize,
        fill: impl Fn(usize, [&[f64]; 2], [&mut [f64]; 2]),
    ) -> DMatrix<Complex<f64>> {
        let waves = |points: &[[f64; 2]]| {
            let [x, y] = [0, 1].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<f64>>());
            let mut waves = [0, 1].map(|_| DMatrix::zeros(points.len(), count));
            let [re, im] = &mut waves;
            for (i, (mut re, mut im)) in re.column_iter_mut().zip(im.column_iter_mut()).enumerate() {
                fill(i, [&x, &y], [re.as_mut_slice(), im.as_mut_slice()]);
            }
            waves
        };
        let (points, strengths) = self.own_sources();
        let [mut real, mut imaginary] = waves(points).map(|part| product(view(&part), view(strengths)));
        if let Some((sand, followers)) = self.moving_sand(hz) {
            let [re, im] = waves(&sand.places);
            let mut led = [0, 1].map(|_| DMatrix::<f64>::zeros(sand.edge.nrows(), count));
            for i in 0..count {
                for ((re, im), follower) in re.column(i).iter().zip(&im.column(i)).zip(&followers) {
                    let wave = follower.amplitude * Complex::new(*re, *im);
                    led[0][(follower.leader, i)] += wave.re;
                    led[1][(follower.leader, i)] += wave.im;
                }
            }
            let [re, im] = led.map(|part| product(view(&part), view(&sand.edge)));
            real += re;
            imaginary += im;
        }
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        let factor = self.air.density / (2.0 * PI) * absorption.sqrt();
        real.zip_map(&imaginary, |re, im| Complex::new(factor * re, factor * im))
    }

    /// Largest delay of waves from any moving point relative to waves from the centre of the moving surface, expressed
    /// as a distance in air \[m\], and that centre. The delay of sand includes the travel time of the surface wave from
    /// the edge of the block.
    pub(crate) fn reach(&self) -> (f64, Point3<f64>) {
        let [x, y] = middle(self.extent);
        let own = 0.5 * diameter(self.extent);
        let sand = self.moving.as_ref().map_or(0.0, |sand| {
            0.5 * diameter(sand.extent) + 0.5 * sand.lag() * self.air.sound_speed
        });
        (own.max(sand), Point3::new(x, y, self.plane))
    }

    /// Frequency range over which the motion of the sand fades out \[Hz\], if it moves.
    pub(crate) fn fade_hz(&self) -> Option<[f64; 2]> {
        self.moving.as_ref().map(SandPatch::fade_hz)
    }

    /// Far field r p e^{jkr} in directions above the plane per unit of modal acceleration, directions x modes \[Pa m
    /// per m/s²\]. The distance r is measured from the point (0, 0) of the plane.
    ///
    /// ```text
    /// r p e^{jkr} = rho0/(2 pi) sum_a S_a phi_a e^{jk d.x_a}
    /// ```
    ///
    /// times the square root of the absorbing sand's power factor.
    pub fn far_field_at(&self, hz: f64, directions: &[Vector3<f64>]) -> DMatrix<Complex<f64>> {
        let k = 2.0 * PI * hz / self.air.sound_speed;
        self.carried_by(hz, directions.len(), |i, [x, y], [re, im]| {
            for (((x, y), re), im) in x.iter().zip(y).zip(re).zip(im) {
                (*im, *re) = (k * (directions[i].x * x + directions[i].y * y)).sin_cos();
            }
        })
    }

    /// rho0 omega² / (2 pi c0), times the sand's absorption.
    pub(super) fn factor(&self, hz: f64) -> f64 {
        let omega = 2.0 * PI * hz;
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        absorption * self.air.density * omega * omega / (2.0 * PI * self.air.sound_speed)
    }
}

/// Centre of a rectangle.
fn middle(extent: [[f64; 2]; 2]) -> [f64; 2] {
    extent.map(|[low, high]| 0.5 * (low + high))
}

/// Diagonal of a rectangle.
fn diameter([[x0, x1], [y0, y1]]: [[f64; 2]; 2]) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

/// Largest distance of points from a centre.
fn radius(points: &[[f64; 2]], middle: [f64; 2]) -> f64 {
    let distance = |p: &[f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]);
    points.iter().map(distance).fold(0.0, f64::max)
}

/// `factor` times the Hermitian parts of Y_p^H Y for each patch field Y_p, where Y is their sum. The fields of the
/// surface's patches are real. They are followed by that of the sand, Y_s = Z E. Z is the complex field of the points
/// that follow each edge point, and E is the motion of the edge. The field of the sand may have more waves.
fn patch_forms(own: &[DMatrix<f64>], sand: Option<([DMatrix<f64>; 2], &DMatrix<f64>)>, factor: f64) -> Vec<Resistance> {
    let mut surface = own[0].clone();
    own[1..].iter().for_each(|field| surface += field);
    let among = |field: &DMatrix<f64>| product(view(field), view(&surface));
    let Some(([re, im], edge)) = sand else {
        let alone = |field| Resistance {
            real: mirrored(among(field), 1.0, factor),
            imaginary: None,
        };
        return own.iter().map(alone).collect();
    };
    // Z^H Y_p, real and imaginary part
    let felt = |field: &DMatrix<f64>| [&re, &im].map(|part| product(view(part).subrows(0, field.nrows()), view(field)));
    let led = |of_edge: &DMatrix<f64>| product(view(edge), view(of_edge));
    // Y_p^H Y = Y_p^T (Y_own + Re Z E) + j Y_p^T Im Z E
    let beside = |field: &DMatrix<f64>| {
        let [re, im] = felt(field);
        let mut real = among(field);
        real += led(&re);
        Resistance {
            real: mirrored(real, 1.0, factor),
            imaginary: Some(mirrored(led(&im), -1.0, -factor)),
        }
    };
    let mut forms: Vec<Resistance> = own.iter().map(beside).collect();
    // Y_s^H Y = E^T Z^H (Y_own + Z E)
    let within = product(view(&re), view(&re)) + product(view(&im), view(&im));
    let across = product(view(&re), view(&im));
    let [of_re, of_im] = felt(&surface);
    forms.push(Resistance {
        real: mirrored(led(&(of_re + within * edge)), 1.0, factor),
        imaginary: Some(mirrored(
            led(&((&across - across.transpose()) * edge - of_im)),
            -1.0,
            factor,
        )),
    });
    forms
}

/// `factor` times the symmetric part of a matrix (or the antisymmetric part if `sign` is -1), tile by tile for the
/// cache.
fn mirrored(mut m: DMatrix<f64>, sign: f64, factor: f64) -> DMatrix<f64> {
    const TILE: usize = 16;
    let n = m.ncols();
    let tiles = |from: usize| (from..n).step_by(TILE);
    for (first, second) in tiles(0).flat_map(|first| tiles(first).map(move |second| (first, second))) {
        for j in second..n.min(second + TILE) {
            for i in first..n.min(first + TILE).min(j + 1) {
                let value = 0.5 * factor * (m[(i, j)] + sign * m[(j, i)]);
                m[(j, i)] = sign * value;
                m[(i, j)] = value;
            }
        }
    }
    m
}

fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

/// A^T B.
fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.ncols(), b.ncols());
    matmul(
        MatMut::from_column_major_slice_mut(product.as_mut_slice(), a.ncols(), b.ncols()),
        Accum::Replace,
        a.transpose(),
        b,
        1.0,
        Par::Seq,
    );
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares waves, pairs of points and distant receivers, with moving sand, up to the frequency for which the
    /// sources are chosen.
    #[test]
    fn few_sources_radiate_like_all() {
        let grid: Vec<[f64; 2]> = (0..1920)
            .map(|i| {
                [
                    -0.2 + 0.4 * (f64::from(i % 60) + 0.5) / 60.0,
                    -0.08 + 0.16 * (f64::from(i / 60) + 0.5) / 32.0,
                ]
            })
            .collect();
        let n = grid.len();
        let mode =
            |i: usize, j: usize| (8.0 * j as f64 * grid[i][0] + 0.5).cos() * (11.0 * j as f64 * grid[i][1]).cos();
        let surface = RadiatingSurface::new(
            grid.iter().map(|p| Point3::new(p[0], p[1], 0.1)).collect(),
            vec![Vector3::z(); n],
            vec![0.064 / n as f64; n],
            grid.iter().map(|p| usize::from(p[0] > 0.05)).collect(),
            vec!["left".to_owned(), "right".to_owned()],
            DMatrix::from_fn(n, 4, mode),
        );
        let sand = MovingSand {
            footprint: [[-0.2, 0.2], [-0.08, 0.08]],
            sand: [[-0.3, 0.3], [-0.25, 0.35]],
            shear_speed: 112.0,
            poisson_ratio: 0.3,
            loss_factor: 0.1,
            to_hz: 1000.0,
        };
        for temperature in [253.0, 313.0] {
            let air = Air::at(temperature, 9e4).unwrap();
            let all = Rayleigh::new(surface.as_ref().unwrap(), &air)
                .unwrap()
                .with_moving_sand(sand)
                .unwrap();
            let few = all.up_to(1000.0);
            assert!(2 * few.sources.points.len() < n);
            for hz in [45.0, 400.0, 999.0, 1000.0] {
                let close = |few: &Resistance, all: &Resistance, diagonal: &DMatrix<f64>| {
                    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                        let size = (diagonal[(i, i)] * diagonal[(j, j)]).sqrt();
                        let part = |m: &Resistance| m.imaginary.as_ref().map_or(0.0, |m| m[(i, j)]);
                        let off = (few.real[(i, j)] - all.real[(i, j)]).hypot(part(few) - part(all)) / size;
                        assert!(off < 1e-7, "{temperature} K, {hz} Hz, {i} {j}: {off:e}");
                    }
                };
                let pairs = all.surface_resistance(hz);
                for (few, all) in few.resistance(hz).iter().zip(&all.resistance(hz)) {
                    close(few, all, &pairs.real);
                }
                close(&few.surface_resistance(hz), &pairs, &pairs.real);
                let places = [
                    Point3::new(0.5, 0.0, 0.11),
                    Point3::new(-0.3, 0.9, 0.6),
                    Point3::new(0.0, 0.0, 0.6),
                ];
                assert!(places.iter().all(|place| few.is_far(place)));
                let (few, all) = (few.pressure_at(hz, &places), all.pressure_at(hz, &places));
                let (few, all) = (few.unwrap(), all.unwrap());
                assert!(
                    (&few - &all).camax() < 1e-8 * all.camax(),
                    "{hz} Hz: {:e}",
                    (&few - &all).camax() / all.camax()
                );
            }
        }
    }
}

use super::plane_waves::{Directions, Follower, PlanarPoints};
use super::resistance::Resistance;
use super::sampled::{SampledRadiation, Sampling};
use super::sand::{AbsorbingSand, MovingSand, SandPatch};
use super::surface::RadiatingSurface;
use crate::air::Air;
use crate::error::{AcousticsError, positive};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use std::f64::consts::PI;

/// Rayleigh's integral for a flat surface, flush in an infinite rigid plane, that radiates to its upper side.
///
/// ```text
/// R = rho0 omega^2 / (2 pi c0) Phi_n^T S K S Phi_n       K_ab = sin(k r_ab) / (k r_ab)
/// ```
///
/// S holds the quadrature weights. The kernel is smooth, so a Gauss rule on the faces converges spectrally. It is
/// applied as a sum of plane waves; [`Self::surface_resistance`] sums pair by pair instead.
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
        let sand = self.moving_sand(hz);
        let sand_diameter = sand.as_ref().map_or(0.0, |(sand, _)| sand.planar.diameter);
        let directions = Directions::new(k, self.planar.diameter.max(sand_diameter));
        let of_rows = |rows: &Vec<usize>| {
            let mut field = DMatrix::zeros(2 * directions.len(), self.sources.ncols());
            directions.add_field(k, &self.planar, rows, &self.sources, &mut field);
            field
        };
        let fields: Vec<DMatrix<f64>> = self.rows.iter().map(of_rows).collect();
        let sand = sand.map(|(sand, followers)| {
            let leaders = sand.edge.nrows();
            let of_sand = directions.field_of_followers(k, &sand.planar, &followers, leaders);
            (of_sand, &sand.edge)
        });
        let mut forms = patch_forms(&fields, sand);
        forms.resize(self.patches.len(), Resistance::zeros(self.sources.ncols()));
        let factor = self.factor(hz);
        forms.into_iter().map(|form| form.scaled(factor)).collect()
    }

    /// The sand where it moves, and how its points follow the block's edge there.
    pub(super) fn moving_sand(&self, hz: f64) -> Option<(&SandPatch, Vec<Follower>)> {
        self.moving.as_ref().and_then(|sand| Some((sand, sand.followers(hz)?)))
    }

    /// Its own points and the modes' displacements there times area, points x modes.
    pub(super) fn own_sources(&self) -> (&[[f64; 2]], &DMatrix<f64>) {
        (&self.points, &self.sources)
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
        let method = Self::method(self.absorbing.is_some(), self.moving.is_some());
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

    /// Label of the operator, with sand that absorbs or moves.
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
        let waves = DMatrix::from_fn(count, self.points.len(), |i, j| wave(i, self.points[j]));
        let mut real = waves.map(|z| z.re) * &self.sources;
        let mut imaginary = waves.map(|z| z.im) * &self.sources;
        if let Some((sand, followers)) = self.moving_sand(hz) {
            let mut led = DMatrix::<Complex<f64>>::zeros(count, sand.edge.nrows());
            for (point, follower) in followers.into_iter().enumerate() {
                let at = sand.planar.at(point);
                let column = led.column_mut(follower.leader).into_iter().enumerate();
                column.for_each(|(i, to)| *to += follower.amplitude * wave(i, at));
            }
            real += led.map(|z| z.re) * &sand.edge;
            imaginary += led.map(|z| z.im) * &sand.edge;
        }
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        let factor = self.air.density / (2.0 * PI) * absorption.sqrt();
        real.zip_map(&imaginary, |re, im| Complex::new(factor * re, factor * im))
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

    /// rho0 omega² / (2 pi c0), times the sand's absorption.
    pub(super) fn factor(&self, hz: f64) -> f64 {
        let omega = 2.0 * PI * hz;
        let absorption = self.absorbing.map_or(1.0, |sand| sand.factor(hz));
        absorption * self.air.density * omega * omega / (2.0 * PI * self.air.sound_speed)
    }
}

/// The Hermitian parts of Y_p^H Y for every patch field Y_p, with Y their sum: real fields of the surface's own patches,
/// and after them that of sand, Y_s = Z E, from the complex field Z of what follows each edge point and the edge's motion E.
fn patch_forms(own: &[DMatrix<f64>], sand: Option<([DMatrix<f64>; 2], &DMatrix<f64>)>) -> Vec<Resistance> {
    let mut surface = own[0].clone();
    own[1..].iter().for_each(|field| surface += field);
    let symmetric = |m: DMatrix<f64>| (&m + m.transpose()) * 0.5;
    let skew = |m: DMatrix<f64>| (&m - m.transpose()) * 0.5;
    let Some(([re, im], edge)) = sand else {
        let alone = |field| Resistance {
            real: symmetric(product(field, &surface)),
            imaginary: None,
        };
        return own.iter().map(alone).collect();
    };
    // Y_p^H Y = Y_p^T (Y_own + Re Z E) + j Y_p^T Im Z E
    let beside = |field: &DMatrix<f64>| Resistance {
        real: symmetric(product(field, &surface) + product(field, &re) * edge),
        imaginary: Some(skew(product(field, &im) * edge)),
    };
    let mut forms: Vec<Resistance> = own.iter().map(beside).collect();
    // Y_s^H Y = E^T Z^H (Y_own + Z E)
    let (within, across) = (product(&re, &re) + product(&im, &im), product(&re, &im));
    forms.push(Resistance {
        real: symmetric(product(edge, &(product(&re, &surface) + within * edge))),
        imaginary: Some(skew(product(
            edge,
            &((&across - across.transpose()) * edge - product(&im, &surface)),
        ))),
    });
    forms
}

/// A^T B through the blocked matrix product, which nalgebra's own `tr_mul` is not.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    a.transpose() * b
}

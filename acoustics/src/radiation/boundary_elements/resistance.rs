use crate::bem::error::BemError;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::solve::cost::{FrequencyCost, PATTERNS, SurfaceSize};
use crate::bem::solve::far_field::Radiated;
use crate::bem::solve::neumann::{NeumannData, Patterns};
use crate::bem::solve::problem::{Exterior, SurfacePressure, Threads, only};
use crate::radiation::error::RadiationError;
use crate::radiation::{RadiatingSurface, Resistance};
use faer::Mat;
use nalgebra::{Complex, DMatrix, Point3};
use std::f64::consts::TAU;

/// Radiation resistance at one frequency, evaluated in two ways.
#[derive(Clone, Debug)]
pub struct TwoEvaluations {
    /// Frequency \[Hz\].
    pub hz: f64,
    /// From the far field: symmetric and positive semidefinite \[kg/s for velocities in m/s\].
    pub far_field: DMatrix<f64>,
    /// From the intensity on the surface, by patch; symmetric part.
    pub patches: Vec<DMatrix<f64>>,
    /// Added mass X / omega of the complete surface \[kg for velocities in m/s\]; symmetric part. On a covered surface,
    /// that of the air outside the layer.
    pub added_mass: DMatrix<f64>,
    /// On a covered surface, where R is Hermitian: antisymmetric imaginary parts of `far_field` and `patches`.
    pub imaginary: Option<(DMatrix<f64>, Vec<DMatrix<f64>>)>,
    /// Largest |R_ij - R_ji| of the surface evaluation, relative to the largest entry of R. It would be zero by
    /// reciprocity, but the discretisation violates it. On a covered surface, it is the asymmetry of int v_i p_j dS,
    /// where v is the velocity of the layer's outer face without pressure.
    pub asymmetry: f64,
    /// Largest difference between the powers of a pattern from the two evaluations \[dB\], among patterns within 30 dB
    /// of the loudest.
    pub difference_db: f64,
}

impl TwoEvaluations {
    /// Largest difference between the two evaluations \[dB\] among patterns whose resistance is above `floor`.
    pub(crate) fn difference_within(&self, floor: f64) -> f64 {
        let surface = |i: usize| self.patches.iter().map(|p| p[(i, i)]).sum::<f64>();
        let far = self.far_field.diagonal();
        let difference = |i: usize| (10.0 * (surface(i) / far[i]).log10()).abs();
        (0..far.len())
            .filter(|&i| far[i] > floor)
            .map(difference)
            .fold(0.0, f64::max)
    }

    /// R of each patch from the surface, followed by the difference between the far field and their sum; the total is
    /// the R of the far field.
    pub fn split(&self) -> Vec<Resistance> {
        let with_rest = |whole: &DMatrix<f64>, patches: &[DMatrix<f64>]| {
            let rest = patches.iter().fold(whole.clone(), |rest, patch| rest - patch);
            patches.iter().cloned().chain([rest]).collect::<Vec<_>>()
        };
        let real = with_rest(&self.far_field, &self.patches);
        let skew = self
            .imaginary
            .as_ref()
            .map(|(whole, patches)| with_rest(whole, patches));
        let part = |(number, real): (usize, DMatrix<f64>)| Resistance {
            real,
            imaginary: skew.as_ref().map(|skew: &Vec<DMatrix<f64>>| skew[number].clone()),
        };
        real.into_iter().enumerate().map(part).collect()
    }
}

/// Cost of one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Pressure unknowns.
    pub unknowns: usize,
    /// Panels.
    pub panels: usize,
    /// Whether the matrix is compressed.
    pub compressed: bool,
    /// Memory for one frequency and a hundred patterns \[bytes\]; multiply by the number of threads.
    pub bytes: f64,
    /// Memory for each further pattern \[bytes\].
    pub bytes_per_pattern: f64,
    /// Memory shared by all frequencies, with [`Exterior::with_near_field_cache`] \[bytes\].
    pub bytes_shared: f64,
    /// Time for one frequency and one pattern on one core \[s\], with the same cache.
    pub seconds: f64,
    /// Time for each further pattern of the complete body \[s\].
    pub seconds_per_pattern: f64,
    /// Time on one core for the integrals shared by all frequencies \[s\].
    pub seconds_shared: f64,
    /// Highest frequency resolved by the mesh \[Hz\].
    pub highest_hz: f64,
    /// Lowest frequency at which a method without the coupled derivative equation may fail \[Hz\], see
    /// [`Exterior::lowest_resonance`].
    pub irregular_hz: f64,
}

impl Estimate {
    /// Time for one frequency on one core with this many patterns in every parity \[s\].
    pub fn seconds_with(&self, patterns: usize) -> f64 {
        self.seconds + self.seconds_per_pattern * patterns as f64
    }

    /// Memory for one frequency with this many patterns in every parity \[bytes\].
    pub fn bytes_with(&self, patterns: usize) -> f64 {
        self.bytes + self.bytes_per_pattern * (patterns as f64 - PATTERNS)
    }
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} panels, {} unknowns{}: about {:.1} s (with a hundred modes) and {:.0} MB a frequency, {:.0} MB for \
             all; \
             resolved up to {:.0} Hz; irregular frequencies of the inside from about {:.0} Hz (coupled formulation)",
            self.panels,
            self.unknowns,
            if self.compressed { " (compressed matrix)" } else { "" },
            self.seconds_with(PATTERNS as usize),
            self.bytes / 1e6,
            self.bytes_shared / 1e6,
            self.highest_hz,
            self.irregular_hz
        )
    }
}

impl Exterior {
    /// Radiation resistance for `velocities` (corner values x patterns) at `hz`, evaluated on the surface and in the
    /// far field.
    ///
    /// # Errors
    /// See [`Exterior::solve`].
    pub fn resistance(&self, hz: f64, velocities: &DMatrix<f64>) -> Result<TwoEvaluations, BemError> {
        only(self.resistance_parities(hz, &[Patterns::even(velocities)])?)
    }

    /// The same for patterns of several parities, which radiate independently.
    ///
    /// # Errors
    /// See [`Exterior::solve`].
    pub fn resistance_parities(&self, hz: f64, patterns: &[Patterns]) -> Result<Vec<TwoEvaluations>, BemError> {
        let data = self.prepared(hz, patterns)?;
        let solutions = self.solve_prepared(hz, &data, Threads::One)?;
        self.two_evaluations(&data, &solutions, Threads::One)
    }

    /// Both evaluations for solutions at one frequency, by parity.
    pub(crate) fn two_evaluations(
        &self,
        data: &[NeumannData],
        solutions: &[SurfacePressure],
        threads: Threads,
    ) -> Result<Vec<TwoEvaluations>, BemError> {
        if self.cover().is_some() {
            return self.covered_evaluations(data, solutions);
        }
        let all: Vec<(&Mat<f32>, &SurfacePressure)> = data.iter().map(NeumannData::at_points).zip(solutions).collect();
        let far_fields = self.far_field_resistances(&all, threads)?;
        let both: Vec<_> = data.iter().zip(solutions).zip(far_fields).collect();
        let evaluated = threads.map(both, |((data, solution), far_field)| {
            self.evaluated_twice(data, solution, far_field)
        });
        evaluated.into_iter().collect()
    }

    /// Both evaluations on a covered surface. R gives the radiated power and excludes the power that the layer absorbs.
    fn covered_evaluations(
        &self,
        data: &[NeumannData],
        solutions: &[SurfacePressure],
    ) -> Result<Vec<TwoEvaluations>, BemError> {
        let all: Vec<Radiated<'_>> = data.iter().map(NeumannData::velocities).zip(solutions).collect();
        let far_fields = self.far_field_powers(&all);
        let of_parity = |((data, solution), [far_field, skew]): ((&NeumannData, _), [DMatrix<f64>; 2])| {
            let powers = self.powers(data.velocities(), solution)?.into_iter();
            let patches: Vec<_> = powers.map(|p| (&p + p.adjoint()) * Complex::from(0.5)).collect();
            let reciprocal = self.reciprocal_impedance(data, solution)?;
            let asymmetry = (&reciprocal - reciprocal.transpose()).map(Complex::norm).amax();
            let mass = reciprocal.map(|z| z.im) / (TAU * solution.hz);
            let mut two = TwoEvaluations {
                hz: solution.hz,
                asymmetry: asymmetry / far_field.amax().max(f64::MIN_POSITIVE),
                difference_db: 0.0,
                patches: patches.iter().map(|p| p.map(|z| z.re)).collect(),
                added_mass: (&mass + mass.transpose()) * 0.5,
                imaginary: Some((skew, patches.iter().map(|p| p.map(|z| z.im)).collect())),
                far_field,
            };
            two.difference_db = two.difference_within(1e-3 * two.far_field.amax());
            Ok(two)
        };
        data.iter().zip(solutions).zip(far_fields).map(of_parity).collect()
    }

    fn evaluated_twice(
        &self,
        data: &NeumannData,
        solution: &SurfacePressure,
        far_field: DMatrix<f64>,
    ) -> Result<TwoEvaluations, BemError> {
        let hz = solution.hz;
        let impedances = self.impedances(data.by_patch(), solution)?;
        let zeros = || DMatrix::zeros(data.count(), data.count());
        let mass = impedances.iter().fold(zeros(), |sum, z| sum + z.map(|z| z.im)) / (TAU * hz);
        let raw: Vec<DMatrix<f64>> = impedances.into_iter().map(|z| z.map(|z| z.re)).collect();
        let whole = raw.iter().fold(zeros(), |sum, r| sum + r);
        let largest = far_field.amax().max(f64::MIN_POSITIVE);
        let mut two = TwoEvaluations {
            hz,
            asymmetry: (&whole - whole.transpose()).amax() / largest,
            difference_db: 0.0,
            patches: raw.iter().map(|r| (r + r.transpose()) * 0.5).collect(),
            added_mass: (&mass + mass.transpose()) * 0.5,
            imaginary: None,
            far_field,
        };
        two.difference_db = two.difference_within(1e-3 * two.far_field.amax());
        Ok(two)
    }

    /// Estimates memory, time and limits in advance. Times are those of one core at about 3 GHz with AVX-512; with AVX2
    /// they are up to twice as long. A shape of close pairs takes 7 us, or 1 us once cached; caching takes 110 us.
    pub fn estimate(&self) -> Estimate {
        let cost = self.frequency_cost();
        let boundary = self.boundary();
        let (close, shapes) = (self.close_pairs() as f64, self.close_shapes() as f64);
        let is_kept = self.near().is_kept();
        Estimate {
            unknowns: boundary.nodes(),
            panels: boundary.mesh().panels.len(),
            compressed: cost.compressed,
            bytes: cost.bytes,
            bytes_per_pattern: cost.bytes_per_pattern,
            bytes_shared: self.near().bytes_shared(),
            seconds: cost.seconds + if is_kept { 1e-6 } else { 7e-6 } * shapes + 1e-6 * close,
            seconds_per_pattern: cost.seconds_per_pattern,
            seconds_shared: if is_kept {
                0.0
            } else {
                110e-6 * self.near().costly() as f64
            },
            highest_hz: boundary.highest_hz(self.air().sound_speed, self.panels_per_wavelength()),
            irregular_hz: self.lowest_resonance(),
        }
    }

    /// Memory and time without close pairs.
    pub(crate) fn frequency_cost(&self) -> FrequencyCost {
        let boundary = self.boundary();
        let size = SurfaceSize {
            unknowns: boundary.nodes() as f64,
            panels: boundary.mesh().panels.len() as f64,
            values: boundary.velocity_values() as f64,
            copies: boundary.copies() as f64,
            images: boundary.images().len() as f64,
        };
        self.with_cost_of_cover(size.cost(self.equation_solver()))
    }

    /// The surface with its modes at quadrature points, for operators that do not solve equations. With mirror planes,
    /// the weight of each point includes its images.
    pub(crate) fn radiating_surface(&self, velocities: &DMatrix<f64>) -> Result<RadiatingSurface, RadiationError> {
        let mesh = self.boundary().mesh();
        let (mut points, mut normals, mut weights, mut patch) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut rows, mut first) = (Vec::new(), 0);
        for (p, panel) in mesh.panels.iter().enumerate() {
            let corners = panel.corners().len();
            for (xi, w) in crate::bem::mesh::rules::fine(panel.kind()) {
                let point = mesh.point_at(p, xi);
                let area = point.area_vector();
                points.push(Point3::from(point.position));
                normals.push(area.normalize());
                weights.push(w * area.norm() * self.boundary().copies() as f64);
                patch.push(panel.patch);
                rows.push((first, corners, panel.kind().linear().at(xi).n));
            }
            first += corners;
        }
        let modes = DMatrix::from_fn(points.len(), velocities.ncols(), |i, m| {
            let (first, corners, n) = rows[i];
            (0..corners).map(|j| n[j] * velocities[(first + j, m)]).sum()
        });
        RadiatingSurface::new(points, normals, weights, patch, mesh.patches.clone(), modes)
    }
}

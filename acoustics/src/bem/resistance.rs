use super::panel::PanelShape;
use super::problem::Exterior;
use crate::error::AcousticsError;
use crate::radiation::{Erp, ModalRadiation, RadiatingSurface, Resistance, SampledRadiation, Sampling};
use nalgebra::{Complex, DMatrix, Point3};
use std::f64::consts::PI;

/// Radiation resistance at one frequency, evaluated twice.
#[derive(Clone, Debug)]
pub struct TwoEvaluations {
    /// Frequency \[Hz\].
    pub hz: f64,
    /// From the far field: symmetric and positive semidefinite \[kg/s for velocities in m/s\].
    pub far_field: DMatrix<f64>,
    /// From the intensity on the surface, patch by patch, symmetric part.
    pub patches: Vec<DMatrix<f64>>,
    /// Largest |R_ij - R_ji| of the surface's evaluation, relative to the largest entry of R. Reciprocity makes it zero;
    /// the discretisation does not.
    pub asymmetry: f64,
    /// Largest difference of a pattern's power between the two \[dB\], among patterns within 30 dB of the loudest.
    pub difference_db: f64,
}

impl TwoEvaluations {
    /// R of every patch, such that the patches add up to the far field's R: the difference of the two evaluations is
    /// shared out by area.
    pub fn shared(&self, areas: &[f64]) -> Vec<Resistance> {
        let surface = self.patches.iter().fold(
            DMatrix::zeros(0, 0),
            |sum: DMatrix<f64>, p| {
                if sum.is_empty() { p.clone() } else { sum + p }
            },
        );
        let total: f64 = areas.iter().sum();
        let rest = &self.far_field - surface;
        let part = |(p, area): (&DMatrix<f64>, &f64)| Resistance {
            real: p + &rest * (area / total),
            imaginary: None,
        };
        self.patches.iter().zip(areas).map(part).collect()
    }
}

/// What a frequency of a surface costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Pressure unknowns.
    pub unknowns: usize,
    /// Panels.
    pub panels: usize,
    /// Memory of one frequency \[bytes\], times the number of threads.
    pub bytes: f64,
    /// Time of one frequency on one core \[s\].
    pub seconds: f64,
    /// Highest frequency the mesh resolves \[Hz\].
    pub highest_hz: f64,
    /// Lowest frequency at which a method without the coupled derivative equation can fail \[Hz\], see
    /// [`Exterior::lowest_resonance`].
    pub irregular_hz: f64,
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} panels, {} unknowns: about {:.1} s and {:.0} MB a frequency; resolved up to {:.0} Hz; irregular \
             frequencies of the inside from about {:.0} Hz (coupled formulation)",
            self.panels,
            self.unknowns,
            self.seconds,
            self.bytes / 1e6,
            self.highest_hz,
            self.irregular_hz
        )
    }
}

impl Exterior {
    /// Radiation resistance for `velocities` (corner values x patterns) at `hz`, from the surface and from the far field.
    ///
    /// # Errors
    /// See [`Exterior::solve`].
    pub fn resistance(&self, hz: f64, velocities: &DMatrix<f64>) -> Result<TwoEvaluations, AcousticsError> {
        let solution = self.solve(hz, velocities)?;
        let far_field = self.far_field_resistance(velocities, &solution)?;
        let raw: Vec<DMatrix<f64>> = self
            .impedance(velocities, &solution)?
            .into_iter()
            .map(|z| z.map(|z| z.re))
            .collect();
        let whole = raw
            .iter()
            .fold(DMatrix::zeros(velocities.ncols(), velocities.ncols()), |sum, r| sum + r);
        let largest = far_field.amax().max(f64::MIN_POSITIVE);
        let loudest = far_field.diagonal().max();
        let difference_db = (0..velocities.ncols())
            .filter(|&i| far_field[(i, i)] > 1e-3 * loudest)
            .map(|i| (10.0 * (whole[(i, i)] / far_field[(i, i)]).log10()).abs())
            .fold(0.0, f64::max);
        Ok(TwoEvaluations {
            hz,
            asymmetry: (&whole - whole.transpose()).amax() / largest,
            difference_db,
            patches: raw.iter().map(|r| (r + r.transpose()) * 0.5).collect(),
            far_field,
        })
    }

    /// Memory, time and limits, before any is spent. Times are those of one core at about 3 GHz with AVX2: 7 ns a
    /// kernel pair, 20 GFlop/s.
    pub fn estimate(&self) -> Estimate {
        let boundary = self.boundary();
        let mesh = boundary.mesh();
        let (n, values) = (boundary.nodes() as f64, boundary.velocity_values() as f64);
        let images = if boundary.floor().is_some() { 2.0 } else { 1.0 };
        let far = 0.5 * values * values * images;
        let factorisation = 8.0 / 3.0 * n.powi(3);
        Estimate {
            unknowns: boundary.nodes(),
            panels: mesh.panels.len(),
            bytes: 16.0 * n * n,
            seconds: 7e-9 * far + 10e-6 * self.close_pairs() as f64 + factorisation / 20e9,
            highest_hz: boundary.highest_hz(self.air().sound_speed, self.panels_per_wavelength()),
            irregular_hz: self.lowest_resonance(),
        }
    }

    /// The modes' radiation resistance over a range of frequencies, sampled where an error estimate asks for it and
    /// interpolated, with the equivalent radiated power above; frequencies in parallel.
    ///
    /// * `velocities`: corner values of every panel x modes, see [`Boundary::project_displacements`](super::Boundary)
    /// * `sampling.range_hz`: its upper end lies within what the mesh resolves
    /// * the two laws are blended over the range's uppermost third of an octave
    ///
    /// # Errors
    /// [`AcousticsError::TooCoarse`], [`AcousticsError::Unresolved`], a number of rows that does not fit.
    pub fn modal_radiation(
        &self,
        velocities: &DMatrix<f64>,
        sampling: &Sampling,
    ) -> Result<BlendedRadiation, AcousticsError> {
        let [_, high] = sampling.range_hz;
        self.check_resolution(high)?;
        crate::error::same_length(
            "rows of the normal velocities",
            velocities.nrows(),
            self.boundary().velocity_values(),
        )?;
        let mesh = self.boundary().mesh();
        let mut areas = vec![0.0; mesh.patches.len()];
        for (p, panel) in mesh.panels.iter().enumerate() {
            areas[panel.patch] += mesh.panel_area(p);
        }
        let worst = std::sync::Mutex::new((0.0f64, 0.0f64));
        let modes = velocities.ncols();
        let at = |hz: f64| match self.resistance(hz, velocities) {
            Ok(two) => {
                // A poisoned lock still holds the largest values seen.
                let mut worst = worst.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                *worst = (worst.0.max(two.difference_db), worst.1.max(two.asymmetry));
                two.shared(&areas)
            }
            // Lengths and frequencies were checked above.
            Err(_) => vec![Resistance::zeros(modes); areas.len()],
        };
        let sampled = SampledRadiation::new("BEM", modes, mesh.patches.clone(), sampling, at)?;
        let (difference_db, asymmetry) = worst.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        let erp = Erp::new(&self.radiating_surface(velocities)?, self.air());
        let mut blended = BlendedRadiation {
            from_hz: high * 2f64.powf(-1.0 / 3.0),
            to_hz: high,
            sampled,
            erp,
            difference_db,
            asymmetry,
            step_db: [0.0; 2],
        };
        blended.step_db = blended.steps();
        Ok(blended)
    }

    /// The surface with its modes at the points of the far rule, for the operators that need no equation solved.
    fn radiating_surface(&self, velocities: &DMatrix<f64>) -> Result<RadiatingSurface, AcousticsError> {
        let mesh = self.boundary().mesh();
        let (mut points, mut normals, mut weights, mut patch) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut rows, mut first) = (Vec::new(), 0);
        for (p, panel) in mesh.panels.iter().enumerate() {
            let corners = panel.corners().len();
            for (xi, w) in super::rules::fine(panel.kind()) {
                let point = mesh.point_at(p, xi);
                let area = point.area_vector();
                points.push(Point3::from(point.position));
                normals.push(area.normalize());
                weights.push(w * area.norm());
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

/// Radiation resistance from boundary elements, with the equivalent radiated power above their range.
#[derive(Debug, Clone)]
pub struct BlendedRadiation {
    sampled: SampledRadiation,
    erp: Erp,
    from_hz: f64,
    to_hz: f64,
    /// Largest difference between the power from the surface and from the far field \[dB\].
    pub difference_db: f64,
    /// Largest asymmetry of R, relative to its largest entry.
    pub asymmetry: f64,
    /// Where the laws meet, 10 lg of the equivalent radiated power over the boundary elements' \[dB\], lowest and highest
    /// among the modes: the error that the blend leaves above the range.
    pub step_db: [f64; 2],
}

impl BlendedRadiation {
    /// The sampled part.
    pub fn sampled(&self) -> &SampledRadiation {
        &self.sampled
    }

    fn steps(&self) -> [f64; 2] {
        let (bem, erp) = (
            self.sampled.resistance(self.to_hz).real,
            self.erp.resistance(self.to_hz).real,
        );
        (0..bem.nrows())
            .map(|i| 10.0 * (erp[(i, i)] / bem[(i, i)].max(f64::MIN_POSITIVE)).log10())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], step| {
                [a.min(step), b.max(step)]
            })
    }

    /// Share of the equivalent radiated power: 0 below the blend, 1 above it, sin² of the logarithmic frequency between.
    fn share(&self, hz: f64) -> f64 {
        let t = ((hz / self.from_hz).ln() / (self.to_hz / self.from_hz).ln()).clamp(0.0, 1.0);
        (0.5 * PI * t).sin().powi(2)
    }
}

impl ModalRadiation for BlendedRadiation {
    fn method(&self) -> &str {
        "BEM, ERP above its range"
    }

    fn modes(&self) -> usize {
        self.sampled.modes()
    }

    fn patches(&self) -> &[String] {
        self.sampled.patches()
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        let share = self.share(hz);
        let mut whole = Resistance::zeros(self.modes());
        if share < 1.0 {
            whole.add_scaled(1.0 - share, &self.sampled.resistance(hz));
        }
        if share > 0.0 {
            whole.add_scaled(share, &self.erp.resistance(hz));
        }
        whole
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let capped: Vec<f64> = frequency.iter().map(|hz| hz.min(self.to_hz)).collect();
        let mut forms = self.sampled.energy_forms(&capped, accelerations);
        let high = self.erp.energy_forms(frequency, accelerations);
        for (bin, &hz) in frequency.iter().enumerate() {
            let share = self.share(hz);
            for p in 0..forms.nrows() {
                forms[(p, bin)] = if share < 1.0 {
                    (1.0 - share) * forms[(p, bin)] + share * high[(p, bin)]
                } else {
                    high[(p, bin)]
                };
            }
        }
        forms
    }
}

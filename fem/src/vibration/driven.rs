//! Time integration coupled to its loads, which depend on the motion that they cause.

use nalgebra::DMatrix;

use super::error::TransientError;
use super::model::{Loads, ModalBody, Settings, Support};
use super::recurrence::Recurrence;
use super::response::{Ending, ModalResponse};
use super::system::{add_gram, effective_zeta, validate};
use super::time_integration::{Run, Watch};

/// A run whose loads are not known in advance.
///
/// At the end of a step, the motion u along the loads depends on the load values F and support forces f there. The
/// relations are
///
///   u = u_free + C_LL F - C_LS f,    d = d_free + C_SL F - C_SS f,    C = P^T diag(c1) P   (rates: c2).
///
/// A [`trial`](Self::trial) thus costs one contact solution and a few small products, whatever the number of modes. The
/// driver tries loads until they are consistent with the motion, and then [`accept`](Self::accept)s them; the step is
/// then the same as one of [`respond`](super::respond) with these loads. After the last step, [`finish`](Self::finish)
/// moves the loads to their final values and continues to the end.
///
/// ```
/// use nailnoise_fem::vibration::{Driven, ModalBody, Motion, Settings, Support, SupportLaw};
/// use nalgebra::DMatrix;
///
/// // A mass of 1 kg between a spring to the ground and a driver that acts as another spring of 1e6 N/m.
/// let mass = ModalBody {
///     name: "mass".into(),
///     omega: vec![0.0],
///     zeta: vec![0.0],
///     loads: DMatrix::from_element(1, 1, 1.0),
///     supports: DMatrix::from_element(1, 1, 1.0),
/// };
/// let spring = Support { stiffness: 1e6, damping: 0.0, gap: 0.0, law: SupportLaw::Bonded };
/// let settings = Settings { duration: 0.01, ..Settings::default() };
/// let (bodies, springs) = ([mass], [spring]);
/// let mut run = Driven::new(&bodies, &springs, &[10.0], &[0.0], &settings)?;
/// for _ in 0..100 {
///     let mut force = 0.0;
///     for _ in 0..3 {
///         run.trial(&[force])?;
///         force = -1e6 * (run.motion()[0] - 2e-5);
///     }
///     run.accept(&[force])?;
/// }
/// assert!((run.motion()[0] - 1e-5).abs() < 1e-12);
/// # Ok::<(), nailnoise_fem::vibration::TransientError>(())
/// ```
pub struct Driven<'a> {
    run: Run<'a>,
    watch: Watch,
    final_values: Vec<f64>,
    /// Current sample.
    sample: usize,
    ending: Option<Ending>,
    /// Compliance C of supports, then loads: for displacements and for rates.
    compliance: [DMatrix<f64>; 2],
    /// Penetrations and motion along the loads at the end of the step without forces there, and their rates.
    free: [Vec<f64>; 4],
    scratch: [Vec<f64>; 2],
    motion: Vec<f64>,
    rate: Vec<f64>,
}

impl<'a> Driven<'a> {
    /// Starts at rest under the initial loads.
    ///
    /// # Errors
    /// Same as [`respond`](super::respond).
    pub fn new(
        bodies: &'a [ModalBody],
        supports: &'a [Support],
        start: &[f64],
        final_values: &[f64],
        settings: &'a Settings,
    ) -> Result<Self, TransientError> {
        let loads = Loads {
            final_values: final_values.to_vec(),
            ..Loads::constant(start)
        };
        validate(bodies, supports, &loads, settings)?;
        let watch = Watch::new(bodies, supports, &loads, settings);
        let constant = Loads::constant(start);
        let run = Run::new(bodies, supports, &constant, settings)?;
        let compliance = joint_compliance(bodies, supports.len(), settings.step);
        let (n, l) = (supports.len(), loads.count());
        let mut driven = Self {
            motion: run.load_motion.clone(),
            rate: run.load_rate.clone(),
            run,
            watch,
            final_values: final_values.to_vec(),
            sample: 0,
            ending: None,
            compliance,
            free: [vec![0.0; n], vec![0.0; n], vec![0.0; l], vec![0.0; l]],
            scratch: [vec![0.0; n], vec![0.0; n]],
        };
        driven.begin_step();
        Ok(driven)
    }

    /// Displacement along each load \[m\], at the current sample or of the latest trial.
    pub fn motion(&self) -> &[f64] {
        &self.motion
    }

    /// Velocity along each load \[m/s\], at the current sample or of the latest trial.
    pub fn rate(&self) -> &[f64] {
        &self.rate
    }

    /// Force of each support \[N\], at the current sample or of the latest trial.
    pub fn support_forces(&self) -> &[f64] {
        &self.run.contact.force
    }

    /// Displacement \[m/N\] or, if `rate`, velocity \[m/(N s)\] along load `row` due to load `column` at the end of a
    /// step, without supports.
    pub fn compliance(&self, rate: bool, row: usize, column: usize) -> f64 {
        let supports = self.scratch[0].len();
        self.compliance[usize::from(rate)][(supports + row, supports + column)]
    }

    /// Whether the longest duration has been reached.
    pub fn is_over(&self) -> bool {
        self.sample + 1 >= self.run.applied.ncols()
    }

    /// Motion at the end of the next step without forces there.
    fn begin_step(&mut self) {
        if self.is_over() {
            return;
        }
        let next = self.sample + 1;
        self.run.applied.column_mut(next).fill(0.0);
        self.run.predict(next);
        self.run.project_supports(true);
        let n = self.scratch[0].len();
        let (motion, rate) = self.run.predicted_loads();
        self.free[0].copy_from_slice(&self.run.free.as_flattened()[..n]);
        self.free[1].copy_from_slice(&self.run.free_rate.as_flattened()[..n]);
        self.free[2] = motion;
        self.free[3] = rate;
    }

    /// Computes the motion along the loads for these load values at the end of the next step.
    ///
    /// # Errors
    /// [`TransientError`] if the contact problem has no solution or the result is not finite.
    pub fn trial(&mut self, loads: &[f64]) -> Result<(), TransientError> {
        let n = self.scratch[0].len();
        for half in 0..2 {
            let c = &self.compliance[half];
            for i in 0..n {
                let pushed: f64 = loads.iter().enumerate().map(|(l, f)| c[(n + l, i)] * f).sum();
                self.scratch[half][i] = self.free[half][i] + pushed;
            }
        }
        let time = (self.sample + 1) as f64 * self.run.settings.step;
        let (free, rate) = (&self.scratch[0], &self.scratch[1]);
        self.run.contact.solve(free, rate, time, &mut self.run.work)?;
        for half in 0..2 {
            let (c, contact) = (&self.compliance[half], &self.run.contact);
            let out = if half == 0 { &mut self.motion } else { &mut self.rate };
            for (l, out) in out.iter_mut().enumerate() {
                let column = c.column(n + l);
                let pushed: f64 = loads.iter().enumerate().map(|(k, f)| column[n + k] * f).sum();
                let held: f64 = contact.touching().iter().map(|&i| column[i] * contact.force[i]).sum();
                *out = self.free[2 + half][l] + pushed - held;
            }
        }
        Ok(())
    }

    /// Completes the step with these loads.
    ///
    /// # Errors
    /// [`TransientError`] if the contact problem has no solution, the response is not finite, or the longest duration
    /// has passed.
    pub fn accept(&mut self, loads: &[f64]) -> Result<(), TransientError> {
        if self.is_over() {
            return Err(TransientError::Value {
                what: "the duration of a driven run".into(),
                value: self.run.settings.duration,
                range: "longer than what drives it",
            });
        }
        let next = self.sample + 1;
        self.run.applied.column_mut(next).copy_from_slice(loads);
        self.run.predict(next);
        self.run.advance(next)?;
        self.sample = next;
        // A driven run ends only when its time is over.
        self.ending = self.watch.see(&mut self.run, next, f64::INFINITY)?;
        self.motion.copy_from_slice(&self.run.load_motion);
        self.rate.copy_from_slice(&self.run.load_rate);
        self.begin_step();
        Ok(())
    }

    /// Moves the loads to their final values and continues to the end.
    ///
    /// # Errors
    /// Same as [`respond`](super::respond).
    pub fn finish(self) -> Result<ModalResponse, TransientError> {
        let Self {
            mut run,
            watch,
            final_values,
            sample,
            ending,
            ..
        } = self;
        if let Some(ending) = ending {
            return run.into_response(sample, ending, &watch);
        }
        let settings = run.settings;
        let loads = Loads {
            interval: settings.step,
            history: run.applied.columns(0, sample + 1).into_owned(),
            final_values,
        };
        run.applied = loads.sampled(settings.step, run.applied.ncols(), settings.taper);
        run.predict(sample + 1);
        run.march(watch, sample + 1, loads.record_end() + settings.taper)
    }
}

/// P^T diag(c1) P and P^T diag(c2) P over all bodies, where P contains the supports and then the loads.
fn joint_compliance(bodies: &[ModalBody], supports: usize, step: f64) -> [DMatrix<f64>; 2] {
    let loads = bodies.first().map_or(0, |body| body.loads.ncols());
    let size = supports + loads;
    let (mut c_d, mut c_v) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    for body in bodies {
        let mut joined = DMatrix::zeros(body.modes(), size);
        joined.columns_mut(0, supports).copy_from(&body.supports);
        joined.columns_mut(supports, loads).copy_from(&body.loads);
        let step_of =
            |j: usize| Recurrence::new(body.omega[j], effective_zeta(body.omega[j], body.zeta[j], step), step);
        let steps: Vec<Recurrence> = (0..body.modes()).map(step_of).collect();
        add_gram(&mut c_d, &joined, |j| steps[j].c1);
        add_gram(&mut c_v, &joined, |j| steps[j].c2);
    }
    [c_d, c_v]
}

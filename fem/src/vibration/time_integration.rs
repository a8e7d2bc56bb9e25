//! Time integration.

use nailnoise_quantities::Check;
use nalgebra::DMatrix;

use super::contact::ContactSolver;
use super::energy::{EnergyHistory, Ledger, Unresolved, elastic_energy};
use super::error::TransientError;
use super::kernels::{Arch, Lane, State, combine, finish, lanes, predict, project};
use super::model::{Loads, ModalBody, ModalState, Settings, Start, Support, SupportLaw};
use super::response::{Ending, MARK, ModalResponse, Work};
use super::statics::{Equilibrium, equilibrium};
use super::system::{System, any_unilateral, validate};

/// Response of one or two bodies to applied loads, on supports that can open.
///
/// Every mode responds exactly to forces that are linear over a step; the support forces at the end of a step are
/// implicit. After the record of the loads ends, each load changes smoothly to its final value. The run continues until
/// `settings.duration` or until the energy has decreased by `settings.decay`. The result does not depend on the number
/// of threads.
///
/// # Errors
/// [`TransientError`] for invalid sizes or values of the inputs, no static equilibrium at the start, supports too stiff
/// for the step, a contact problem without solution, or supports that never touch.
pub fn respond(
    bodies: &[ModalBody],
    supports: &[Support],
    loads: &Loads,
    settings: &Settings,
) -> Result<ModalResponse, TransientError> {
    validate(bodies, supports, loads, settings)?;
    let run = Run::new(bodies, supports, loads, settings)?;
    let watch = Watch::new(bodies, supports, loads, settings);
    run.march(watch, 1, loads.record_end() + settings.taper)
}

/// A run in progress.
pub(super) struct Run<'a> {
    arch: Arch,
    pub(super) bodies: &'a [ModalBody],
    pub(super) supports: &'a [Support],
    pub(super) settings: &'a Settings,
    pub(super) system: System,
    pub(super) state: State,
    pub(super) contact: ContactSolver,
    /// Loads x samples.
    pub(super) applied: DMatrix<f64>,
    /// Supports x samples.
    pub(super) forces: DMatrix<f64>,
    start: Vec<ModalState>,
    unsupported: f64,
    all_supports: Vec<usize>,
    /// The negative support forces.
    back: Vec<f64>,
    pub(super) free: Vec<Lane>,
    pub(super) free_rate: Vec<Lane>,
    load_scratch: [Vec<Lane>; 2],
    pub(super) load_motion: Vec<f64>,
    pub(super) load_rate: Vec<f64>,
    /// Motion along the loads at t = 0.
    first_motion: Vec<f64>,
    load_ledger: Ledger,
    contact_ledger: Ledger,
    unresolved: Unresolved,
    energy: EnergyHistory,
    /// q and q' at every [`MARK`]th sample.
    marks: Vec<[Vec<Lane>; 2]>,
    open_samples: usize,
    /// Unilateral support that came closest, and its gap.
    nearest: (usize, f64),
    momentum_error: f64,
    pub(super) work: Work,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        bodies: &'a [ModalBody],
        supports: &'a [Support],
        loads: &Loads,
        settings: &'a Settings,
    ) -> Result<Self, TransientError> {
        let arch = Arch::new();
        let h = settings.step;
        let samples = (settings.duration / h + 1e-9).floor() as usize + 1;
        let applied = loads.sampled(h, samples, settings.taper);
        let system = System::new(bodies, loads.count(), supports.len(), h);
        let compliance = system.compliance(bodies, supports.len(), h);
        let contact = ContactSolver::new(arch, supports, compliance, settings.max_contact_iterations);
        let mut work = Work {
            modes_beyond_step: system.modes_beyond_step,
            ..Work::default()
        };
        let (start, unsupported) = starting_states(bodies, supports, &applied, settings, &mut work)?;
        let mut state = State::rest(system.height);
        state.q = system.gather(start.iter().map(|s| s.displacement.as_slice()));
        state.v = system.gather(start.iter().map(|s| s.velocity.as_slice()));
        let (n, l) = (supports.len(), loads.count());
        let nothing = Ledger::new(h, &[], &[], &[]);
        let mut run = Self {
            arch,
            bodies,
            supports,
            settings,
            state,
            contact,
            forces: DMatrix::zeros(n, samples),
            applied,
            start,
            unsupported,
            all_supports: (0..n).collect(),
            back: vec![0.0; n],
            free: vec![[0.0; 4]; lanes(n)],
            free_rate: vec![[0.0; 4]; lanes(n)],
            load_scratch: std::array::from_fn(|_| vec![[0.0; 4]; lanes(l)]),
            load_motion: vec![0.0; l],
            load_rate: vec![0.0; l],
            first_motion: Vec::new(),
            load_ledger: nothing.clone(),
            contact_ledger: nothing,
            unresolved: Unresolved::new(bodies, &system, h),
            energy: EnergyHistory::new(bodies.len()),
            marks: Vec::new(),
            open_samples: 0,
            nearest: (0, f64::INFINITY),
            momentum_error: 0.0,
            work,
            system,
        };
        run.begin()?;
        Ok(run)
    }

    /// Integrates from sample `first` to the end of the run.
    pub(super) fn march(
        mut self,
        mut watch: Watch,
        first: usize,
        tapered: f64,
    ) -> Result<ModalResponse, TransientError> {
        let last = self.applied.ncols() - 1;
        for n in first..=last {
            self.advance(n)?;
            if let Some(ending) = watch.see(&mut self, n, tapered)? {
                return self.into_response(n, ending, &watch);
            }
        }
        // Not reached: the watch ends a run at its last sample.
        let ending = watch.ending(0.0);
        self.into_response(last, ending, &watch)
    }

    /// Computes forces and ledgers at t = 0, and the prediction for the first step.
    fn begin(&mut self) -> Result<(), TransientError> {
        let h = self.settings.step;
        self.project_supports(false);
        let n = self.supports.len();
        self.contact
            .start(&self.free.as_flattened()[..n], &self.free_rate.as_flattened()[..n]);
        self.project_loads();
        self.first_motion = self.load_motion.clone();
        let first = self.applied.column(0).into_owned();
        self.load_ledger = Ledger::new(h, first.as_slice(), &self.load_motion, &self.load_rate);
        let c = &self.contact;
        self.contact_ledger = Ledger::new(h, &c.force, &c.penetration, &c.rate);
        self.apply_loads(0);
        self.apply_supports();
        self.unresolved.begin(&self.state);
        for (g, (a, c)) in self
            .state
            .g
            .iter_mut()
            .zip(self.state.applied.iter().zip(&self.state.contact))
        {
            for l in 0..4 {
                g[l] = a[l] + c[l];
            }
        }
        self.after(0);
        self.record(0)?;
        if self.applied.ncols() > 1 {
            self.predict(1);
        }
        Ok(())
    }

    /// Computes the step that ends at sample n.
    pub(super) fn advance(&mut self, n: usize) -> Result<(), TransientError> {
        let time = n as f64 * self.settings.step;
        self.project_supports(true);
        let n_supports = self.supports.len();
        let (free, rate) = (
            &self.free.as_flattened()[..n_supports],
            &self.free_rate.as_flattened()[..n_supports],
        );
        self.contact.solve(free, rate, time, &mut self.work)?;
        self.apply_supports();
        finish(self.arch, &self.system.coefficients, &mut self.state);
        let [of_loads, of_supports] = self.unresolved.add(&self.state);
        self.project_loads();
        self.load_ledger
            .add(self.applied.column(n).as_slice(), &self.load_motion, &self.load_rate);
        let c = &self.contact;
        self.contact_ledger.add(&c.force, &c.penetration, &c.rate);
        self.load_ledger.work += of_loads;
        // Work that the supports do on the bodies but do not receive themselves.
        self.contact_ledger.work -= of_supports;
        self.after(n);
        self.work.steps += 1;
        self.work.contact_steps += usize::from(!self.contact.touching().is_empty());
        if n + 1 < self.applied.ncols() {
            self.predict(n + 1);
        }
        Ok(())
    }

    /// Predicts the state at sample n without support forces there.
    pub(super) fn predict(&mut self, n: usize) {
        self.apply_loads(n);
        predict(self.arch, &self.system.coefficients, &mut self.state);
    }

    /// Motion along the loads, and its rates, of the state computed by [`predict`](Self::predict).
    pub(super) fn predicted_loads(&mut self) -> (Vec<f64>, Vec<f64>) {
        self.read_loads(true);
        let found = (self.load_motion.clone(), self.load_rate.clone());
        self.read_loads(false);
        found
    }

    /// Penetrations and rates of the predicted state, or of the current one.
    pub(super) fn project_supports(&mut self, predicted: bool) {
        let s = &self.state;
        let motion = if predicted {
            (&s.q_free[..], &s.v_free[..])
        } else {
            (&s.q[..], &s.v[..])
        };
        let out = (&mut self.free[..], &mut self.free_rate[..]);
        project(self.arch, &self.system.support_rows, motion, out);
        for (free, support) in self.free.as_flattened_mut().iter_mut().zip(self.supports) {
            *free -= support.gap;
        }
    }

    fn project_loads(&mut self) {
        self.read_loads(false);
    }

    /// Motion along the loads, and its rates, of the predicted state or of the current one.
    fn read_loads(&mut self, predicted: bool) {
        self.load_motion.fill(0.0);
        self.load_rate.fill(0.0);
        let s = &self.state;
        let (q, v) = if predicted {
            (&s.q_free, &s.v_free)
        } else {
            (&s.q, &s.v)
        };
        for part in &self.system.parts {
            let motion = (&q[part.lanes.clone()], &v[part.lanes.clone()]);
            let height = part.load_rows.height;
            let [u, rate] = &mut self.load_scratch;
            let (u, rate) = (&mut u[..height], &mut rate[..height]);
            project(self.arch, &part.load_rows, motion, (&mut *u, &mut *rate));
            for (k, &l) in part.loads.iter().enumerate() {
                self.load_motion[l] += u[k / 4][k % 4];
                self.load_rate[l] += rate[k / 4][k % 4];
            }
        }
    }

    fn apply_loads(&mut self, n: usize) {
        let column = self.applied.column(n);
        for part in &self.system.parts {
            let out = &mut self.state.applied;
            combine(
                self.arch,
                &self.system.loads,
                part.lanes.clone(),
                &part.loads,
                column.as_slice(),
                out,
            );
        }
    }

    fn apply_supports(&mut self) {
        for (back, force) in self.back.iter_mut().zip(&self.contact.force) {
            *back = -force;
        }
        let which = if self.work.steps == 0 {
            &self.all_supports[..]
        } else {
            self.contact.touching()
        };
        let all = 0..self.system.height;
        combine(
            self.arch,
            &self.system.supports,
            all,
            which,
            &self.back,
            &mut self.state.contact,
        );
    }

    /// Stores the support forces of sample n and, at every [`MARK`]th sample, the state. Records which supports touch.
    fn after(&mut self, n: usize) {
        if n.is_multiple_of(MARK) {
            self.marks.push([self.state.q.clone(), self.state.v.clone()]);
        }
        self.forces.column_mut(n).copy_from_slice(&self.contact.force);
        let mut open = true;
        for (i, support) in self.supports.iter().enumerate() {
            if support.law == SupportLaw::Unilateral {
                open &= self.contact.force[i] == 0.0;
                if -self.contact.penetration[i] < self.nearest.1 {
                    self.nearest = (i, -self.contact.penetration[i]);
                }
            }
        }
        self.open_samples += usize::from(open);
    }

    fn record(&mut self, n: usize) -> Result<(), TransientError> {
        let time = n as f64 * self.settings.step;
        let elastic = elastic_energy(self.supports, &self.contact.penetration);
        let (into_contact, work) = (self.contact_ledger.work, self.load_ledger.work);
        self.energy
            .record(time, &self.system, &self.state, elastic, into_contact, work);
        if !self.energy.mechanical(self.energy.time.len() - 1).is_finite() {
            return Err(TransientError::NotFinite { time });
        }
        self.check_momentum();
        Ok(())
    }

    /// Compares the momentum of each rigid mode since t = 0 with the separately summed impulses of loads and supports.
    fn check_momentum(&mut self) {
        for ((body, part), start) in self.bodies.iter().zip(&self.system.parts).zip(&self.start) {
            let velocity = self.state.v[part.lanes.clone()].as_flattened();
            for j in (0..body.modes()).filter(|&j| body.omega[j] == 0.0) {
                let change = velocity[j] - start.velocity[j];
                let (mut sum, mut size) = (0.0, change.abs() + start.velocity[j].abs());
                for (l, impulse) in self.load_ledger.impulse.iter().enumerate() {
                    sum += body.loads[(j, l)] * impulse;
                    size += (body.loads[(j, l)] * impulse).abs();
                }
                for (i, impulse) in self.contact_ledger.impulse.iter().enumerate() {
                    sum -= body.supports[(j, i)] * impulse;
                    size += (body.supports[(j, i)] * impulse).abs();
                }
                if size > 0.0 {
                    self.momentum_error = self.momentum_error.max((change - sum).abs() / size);
                }
            }
        }
    }

    pub(super) fn into_response(
        self,
        last: usize,
        ending: Ending,
        watch: &Watch,
    ) -> Result<ModalResponse, TransientError> {
        let samples = last + 1;
        let never = self.open_samples == samples;
        if any_unilateral(self.supports) && self.settings.require_contact && never {
            return Err(TransientError::SupportNeverTouches {
                supports: self.supports.iter().filter(|s| s.law == SupportLaw::Unilateral).count(),
                nearest: self.nearest.0,
                gap: self.nearest.1,
                duration: last as f64 * self.settings.step,
            });
        }
        let least = self.contact_least_lost();
        let checks = vec![
            Check::at_most("contact energy", self.energy.imbalance(), 1e-4),
            Check::at_most("contact force law", self.contact.law_error, 1e-9),
            Check::at_most("force balance between bodies", self.momentum_error, 1e-9),
            Check::at_most("contact gains no energy", least, 1e-4),
        ];
        let unilateral = any_unilateral(self.supports);
        Ok(ModalResponse {
            step: self.settings.step,
            loads: self.applied.columns(0, samples).into_owned(),
            contact_forces: self.forces.columns(0, samples).into_owned(),
            end: self.system.states(&self.state.q, &self.state.v),
            marks: self.marks.iter().map(|[q, v]| self.system.states(q, v)).collect(),
            start: self.start,
            energy: self.energy,
            open_fraction: if unilateral {
                self.open_samples as f64 / samples as f64
            } else {
                0.0
            },
            unsupported_load: self.unsupported.max(watch.unsupported),
            ending,
            checks,
            work: self.work,
            bodies: self.bodies.to_vec(),
            added: None,
        })
    }

    /// Net energy supplied by the supports, relative to the peak of kinetic energy or work.
    fn contact_least_lost(&self) -> f64 {
        let e = &self.energy;
        let least = e.contact_lost.iter().fold(0.0, |m: f64, x| m.min(*x));
        let peak = (0..e.time.len()).fold(1e-9 * e.mechanical(0), |m, k| {
            m.max(e.kinetic_total(k)).max(e.work[k].abs())
        });
        if least == 0.0 { 0.0 } else { -least / peak }
    }
}

fn starting_states(
    bodies: &[ModalBody],
    supports: &[Support],
    applied: &DMatrix<f64>,
    settings: &Settings,
    work: &mut Work,
) -> Result<(Vec<ModalState>, f64), TransientError> {
    match &settings.start {
        Start::Rest => Ok((bodies.iter().map(|b| ModalState::rest(b.modes())).collect(), 0.0)),
        Start::State(states) => Ok((states.clone(), 0.0)),
        Start::Equilibrium => {
            let found = equilibrium(bodies, supports, applied.column(0).as_slice())?;
            work.static_iterations += found.iterations;
            let rest = |displacement: Vec<f64>| ModalState {
                velocity: vec![0.0; displacement.len()],
                displacement,
            };
            Ok((found.displacement.into_iter().map(rest).collect(), found.unsupported))
        }
    }
}

/// Monitors the decay of the energy above the final equilibrium (or, without an equilibrium, of the kinetic energy).
pub(super) struct Watch {
    final_values: Vec<f64>,
    fall: f64,
    /// Number of steps between checks.
    stride: usize,
    /// Potential energy of the final equilibrium.
    potential: Option<f64>,
    unsupported: f64,
    iterations: usize,
    largest: f64,
    below: usize,
    started: bool,
}

impl Watch {
    pub(super) fn new(bodies: &[ModalBody], supports: &[Support], loads: &Loads, settings: &Settings) -> Self {
        let found = equilibrium(bodies, supports, &loads.final_values).ok();
        let iterations = found.as_ref().map_or(0, |e| e.iterations);
        let unsupported = found.as_ref().map_or(0.0, |e| e.unsupported);
        let potential = found.map(|Equilibrium { potential, .. }| potential);
        Self {
            final_values: loads.final_values.clone(),
            fall: settings.decay,
            stride: ((settings.energy_interval / settings.step).round() as usize).max(1),
            potential,
            unsupported,
            iterations,
            largest: 0.0,
            below: 0,
            started: false,
        }
    }

    /// Checks sample n, which has just been reached; returns the reason if the run ends there.
    pub(super) fn see(&mut self, run: &mut Run<'_>, n: usize, tapered: f64) -> Result<Option<Ending>, TransientError> {
        if !self.started {
            self.started = true;
            self.level(run, 0);
            run.work.static_iterations += self.iterations;
        }
        let last = run.applied.ncols() - 1;
        if !n.is_multiple_of(self.stride) && n != last {
            return Ok(None);
        }
        run.record(n)?;
        let level = self.level(run, run.energy.time.len() - 1);
        if n == last {
            return Ok(Some(self.ending(level)));
        }
        let settled = n as f64 * run.settings.step >= tapered && self.settled(level);
        Ok(settled.then_some(Ending::Decayed {
            level,
            over_equilibrium: self.potential.is_some(),
        }))
    }

    fn ending(&self, level: f64) -> Ending {
        Ending::Duration {
            level,
            over_equilibrium: self.potential.is_some(),
        }
    }

    /// Energy level of entry k, relative to the largest so far \[dB\].
    fn level(&mut self, run: &Run<'_>, k: usize) -> f64 {
        let energy = match self.potential {
            Some(lowest) => {
                // The motion is that of the current sample, except at t = 0, which is checked one step late.
                let motion = if k == 0 { &run.first_motion } else { &run.load_motion };
                let along: f64 = self.final_values.iter().zip(motion).map(|(f, u)| f * u).sum();
                run.energy.mechanical(k) - along - lowest
            }
            None => run.energy.kinetic_total(k),
        };
        self.largest = self.largest.max(energy);
        10.0 * (energy.max(0.0) / self.largest).log10()
    }

    /// Whether the energy has decreased enough; since kinetic energy oscillates, it must stay low for a while.
    fn settled(&mut self, level: f64) -> bool {
        const STAY: usize = 20;
        let low = level <= -self.fall || self.largest == 0.0;
        self.below = if low { self.below + 1 } else { 0 };
        self.below >= if self.potential.is_some() { 1 } else { STAY }
    }
}

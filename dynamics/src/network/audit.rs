//! Checks conservation of mass, energy and momentum during a run.

use nailnoise_quantities::Check;

use super::assembly::{ForceLaw, Space};
use super::mode::{Mode, friction, head};
use super::plan::{FastenerPlan, Plan};
use super::rates::Workspace;

/// Largest residual of the energy of gas and bodies \[J\], and as a fraction of the energy exchanged during the run
/// \[-\].
const SHOT: f64 = 1e-3;
const PART: f64 = 1e-6;
/// Name of the work of gravity in the ledger.
const GRAVITY: &str = "gravity";

/// Energies of a state, and work of forces that have a potential \[J\].
#[derive(Debug, Clone, Copy)]
struct Stock {
    gas: f64,
    kinetic: f64,
    elastic: f64,
    /// Work of gravity, reservoirs and constant forces from the origin.
    outer: f64,
    /// Momentum of all bodies \[N s\].
    momentum: f64,
    /// Gas in all volumes \[kg\].
    mass: f64,
}

/// Energy that an event removed from the bodies.
#[derive(Debug, Clone, PartialEq)]
struct Lost {
    name: String,
    energy: f64,
}

/// Balance residuals tracked during a run.
#[derive(Debug, Clone)]
pub(crate) struct Audit {
    start: Stock,
    /// Work of gravity, reservoirs and constant forces from the origin to the start, by name.
    potentials: Vec<(String, f64)>,
    lost: Vec<Lost>,
    momentum_jump: f64,
    outer_jump: f64,
    worst_mass: f64,
    worst_gas: f64,
    worst_mechanics: f64,
    /// Of gas and bodies together.
    worst_shot: f64,
    worst_momentum: f64,
    /// Largest residuals of mass and energy of individual volumes (full ledger).
    worst_volume: [f64; 2],
    volumes: Vec<[f64; 2]>,
    /// Largest sum of exchanged energies, which scales the mechanical residual.
    turnover: f64,
}

impl Plan {
    /// Energies of a state in the workspace.
    fn stock(&self, y: &[f64], mode: &Mode, w: &Workspace) -> Stock {
        let (energy, mass, states) = (self.energy(), self.mass(), self.states());
        let mut stock = Stock {
            gas: y[energy..mass].iter().sum(),
            kinetic: 0.0,
            elastic: 0.0,
            outer: 0.0,
            momentum: 0.0,
            mass: y[mass..states].iter().sum(),
        };
        for (body, plan) in self.bodies.iter().enumerate() {
            let (m, v) = (self.moving_mass(body, mode), w.velocity[body]);
            stock.kinetic += 0.5 * m * v * v;
            stock.momentum += m * v;
            stock.outer += m * plan.gravity * w.position[body];
        }
        for contact in self.contacts.iter().filter(|c| mode.is_on(c.switch)) {
            stock.elastic += contact.energy(contact.overlap(w.travel(contact.pair), 0.0).0);
        }
        for spring in &self.springs {
            if !spring.carries && spring.switch.is_none_or(|switch| mode.is_on(switch)) {
                stock.elastic += spring.energy(w.travel(spring.pair));
            }
        }
        for hold in self.holds.iter().filter(|h| mode.is_on(h.switch)) {
            let u = w.travel(hold.pair) - mode.memory[hold.place];
            stock.elastic += 0.5 * hold.stiffness * u * u;
        }
        for friction in &self.frictions {
            if let Some(stick) = &friction.stick
                && mode.switches[stick.switch] == friction::STUCK
            {
                let u = w.travel(friction.pair) - mode.memory[stick.place];
                stock.elastic += 0.5 * stick.stiffness * u * u;
            }
        }
        for face in self.faces.iter().filter(|f| f.pressed.is_none()) {
            stock.outer += w.pressure[face.gas] * face.area * w.travel(face.pair);
        }
        for imposed in &self.forces {
            if let ForceLaw::Constant(force) = imposed.law {
                stock.outer += force * w.travel(imposed.pair);
            }
        }
        stock
    }

    /// Work of gravity, of each reservoir and of each constant force from the origin to a state in the workspace \[J\].
    fn potentials(&self, mode: &Mode, w: &Workspace) -> Vec<(String, f64)> {
        let bodies = self.bodies.iter().enumerate();
        let weights = bodies.map(|(body, plan)| self.moving_mass(body, mode) * plan.gravity * w.position[body]);
        let mut found = vec![(GRAVITY.to_owned(), weights.sum())];
        for (index, reservoir) in self.assembly.reservoirs.iter().enumerate() {
            let gas = self.volumes.len() + index;
            let faces = self.faces.iter().filter(|face| face.gas == gas);
            let work = faces.map(|face| w.pressure[gas] * face.area * w.travel(face.pair));
            found.push((format!("work.{}", reservoir.name), work.sum()));
        }
        for (imposed, described) in self.forces.iter().zip(&self.assembly.forces) {
            if let ForceLaw::Constant(force) = imposed.law {
                found.push((format!("work.{}", described.name), force * w.travel(imposed.pair)));
            }
        }
        found
    }

    /// Sum of selected integrals; `of` returns the factor for a name.
    fn integrals(&self, y: &[f64], of: impl Fn(&str) -> f64) -> f64 {
        let values = &y[self.states()..];
        self.ledger
            .iter()
            .zip(values)
            .map(|(item, value)| of(&item.name) * value)
            .sum()
    }

    /// Mass and enthalpy that entered through the openings, minus those that left.
    fn through_openings(&self, y: &[f64]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (passage, described) in self.passages.iter().zip(&self.assembly.passages) {
            let sign = match (described.from, described.to) {
                (Space::Reservoir(_), Space::Volume(_)) => 1.0,
                (Space::Volume(_), Space::Reservoir(_)) => -1.0,
                _ => continue,
            };
            if let Some(ledger) = passage.ledger {
                sum[0] += sign * y[ledger.mass];
                sum[1] += sign * y[ledger.enthalpy];
            }
        }
        sum
    }

    /// Work of the gas on all bodies.
    fn gas_work(&self, y: &[f64]) -> f64 {
        let swept = self.faces.iter().filter(|face| face.volume.is_some());
        let mut places: Vec<usize> = swept.filter_map(|face| face.work).collect();
        places.sort_unstable();
        places.dedup();
        places.into_iter().map(|place| y[place]).sum()
    }

    /// Work of motors, tabulated forces, jets and faces that sweep no volume, minus dissipation and the work on an
    /// external workpiece.
    fn work_less_losses(&self, y: &[f64]) -> f64 {
        let forces = self.forces.iter().filter_map(|force| force.work);
        let motors = self.motors.iter().map(|motor| motor.work);
        let unswept = self.faces.iter().filter(|face| face.volume.is_none());
        let driven = forces.chain(motors).chain(unswept.filter_map(|face| face.work));
        let losing = |name: &str| {
            let lost = ["dashpot.", "friction.", "penetration.", "guide.", "coupling."];
            if lost.iter().any(|prefix| name.starts_with(prefix)) {
                1.0
            } else {
                0.0
            }
        };
        driven.map(|place| y[place]).sum::<f64>() - self.integrals(y, losing)
    }
}

impl Audit {
    pub(crate) fn new(plan: &Plan, y: &[f64], mode: &Mode, w: &Workspace) -> Self {
        let mut audit = Self {
            start: plan.stock(y, mode, w),
            potentials: plan.potentials(mode, w),
            lost: Vec::new(),
            momentum_jump: 0.0,
            outer_jump: 0.0,
            worst_mass: 0.0,
            worst_gas: 0.0,
            worst_mechanics: 0.0,
            worst_shot: 0.0,
            worst_momentum: 0.0,
            worst_volume: [0.0; 2],
            volumes: Vec::new(),
            turnover: 0.0,
        };
        audit.volumes = (0..plan.volumes.len()).map(|i| audit.volume(plan, y, i)).collect();
        audit
    }

    /// Mass and energy of a volume minus the inflow; zero without a full ledger.
    fn volume(&self, plan: &Plan, y: &[f64], volume: usize) -> [f64; 2] {
        let Some(ledger) = plan.volumes[volume].ledger else {
            return [0.0; 2];
        };
        let mut mass = y[plan.mass() + volume];
        let mut energy = y[plan.energy() + volume] - y[ledger.heat] + y[ledger.work];
        for passage in &plan.passages {
            let Some(ledger) = passage.ledger else { continue };
            for (end, sign) in [(passage.from, 1.0), (passage.to, -1.0)] {
                if end == volume {
                    mass += sign * y[ledger.mass];
                    energy += sign * y[ledger.enthalpy];
                }
            }
        }
        [mass, energy]
    }

    /// Updates the residuals; `w` contains the positions and gas of the state.
    pub(crate) fn follow(&mut self, plan: &Plan, y: &[f64], mode: &Mode, w: &Workspace) {
        let now = plan.stock(y, mode, w);
        let [mass, enthalpy] = plan.through_openings(y);
        let work = plan.gas_work(y);
        let heat = plan.heat.map_or(0.0, |place| y[place]);
        let worst = |worst: &mut f64, residual: f64| *worst = worst.max(residual.abs());
        worst(&mut self.worst_mass, now.mass - self.start.mass - mass);
        let gas = now.gas - self.start.gas - enthalpy - heat + work;
        worst(&mut self.worst_gas, gas);
        let stored = now.kinetic + now.elastic - self.start.kinetic - self.start.elastic;
        let outer = now.outer - self.start.outer + self.outer_jump;
        let lost: f64 = self.lost.iter().map(|lost| lost.energy).sum();
        let driven = plan.work_less_losses(y);
        let mechanics = stored - outer - work - driven + lost;
        worst(&mut self.worst_mechanics, mechanics);
        worst(&mut self.worst_shot, mechanics + gas);
        self.turnover = self.turnover.max(work.abs() + outer.abs() + now.kinetic + now.elastic);
        let impulse = y[plan.outer_impulse] - y[plan.ground_impulse];
        worst(
            &mut self.worst_momentum,
            now.momentum - self.start.momentum - impulse - self.momentum_jump,
        );
        for (i, start) in self.volumes.iter().enumerate() {
            if plan.volumes[i].ledger.is_some() {
                let found = self.volume(plan, y, i);
                for (k, worst) in self.worst_volume.iter_mut().enumerate() {
                    *worst = worst.max((found[k] - start[k]).abs());
                }
            }
        }
    }

    /// Accounts for a block's event that changed mode and velocities; `w` contains the positions.
    pub(crate) fn cross(
        &mut self,
        plan: &Plan,
        name: &str,
        before: (&Mode, &[f64]),
        after: (&Mode, &[f64]),
        w: &mut Workspace,
    ) {
        plan.instant(before.1, before.0, w);
        let old = plan.stock(before.1, before.0, w);
        plan.instant(after.1, after.0, w);
        let new = plan.stock(after.1, after.0, w);
        let lost = old.kinetic + old.elastic - new.kinetic - new.elastic;
        self.outer_jump += old.outer - new.outer;
        let changed = |f: &FastenerPlan| before.0.switches[f.head] != after.0.switches[f.head];
        let left = plan
            .fasteners
            .iter()
            .any(|f| changed(f) && after.0.switches[f.head] == head::LEFT);
        if left || plan.fasteners.iter().any(|f| changed(f) && !f.impact) {
            // A fastener that is left behind takes its momentum with it. Without an impact, the fastener gains its
            // momentum from no other body.
            self.momentum_jump += new.momentum - old.momentum;
        }
        if lost == 0.0 {
            return;
        }
        // A fastener that is left behind takes its energy with it.
        let name = format!("{}.{name}", if left { "left" } else { "lost" });
        match self.lost.iter_mut().find(|entry| entry.name == name) {
            Some(entry) => entry.energy += lost,
            None => self.lost.push(Lost { name, energy: lost }),
        }
    }

    /// Names and values of the terms that close the energy balance together with the integrals \[J\]. They are the
    /// energies at start and end, the work of gravity, reservoirs and constant forces, and the energy that events
    /// removed; `w` contains the final state.
    pub(crate) fn energies(&self, plan: &Plan, y: &[f64], mode: &Mode, w: &Workspace) -> Vec<(String, f64)> {
        let end = plan.stock(y, mode, w);
        let mut energies = Vec::new();
        for (at, stock) in [("start", &self.start), ("end", &end)] {
            for (name, energy) in [
                ("gas", stock.gas),
                ("kinetic", stock.kinetic),
                ("elastic", stock.elastic),
            ] {
                energies.push((format!("{name}.{at}"), energy));
            }
        }
        for ((name, end), (_, start)) in plan.potentials(mode, w).into_iter().zip(&self.potentials) {
            let jump = if name == GRAVITY { self.outer_jump } else { 0.0 };
            energies.push((name, end - start + jump));
        }
        energies.extend(self.lost.iter().map(|lost| (lost.name.clone(), lost.energy)));
        energies
    }

    pub(crate) fn checks(&self, plan: &Plan) -> Vec<Check> {
        let gas = self.start.gas.abs().max(1e-3);
        // A polytropic gas violates some balances, and so does a passage whose outflow differs from the flow that
        // arrives.
        let mass_kept = plan.passages.iter().all(|passage| passage.undelayed.is_none());
        let energy_kept = mass_kept && plan.temperature.is_none();
        let mut checks = Vec::new();
        if mass_kept {
            let limit = 1e-12 + 1e-10 * self.start.mass;
            checks.push(Check::at_most("mass balance [kg]", self.worst_mass, limit));
        }
        if energy_kept {
            checks.push(Check::at_most(
                "gas energy balance [J]",
                self.worst_gas,
                1e-6 + 1e-9 * gas,
            ));
        }
        let (scope, residual) = if energy_kept {
            ("whole-shot", self.worst_shot)
        } else {
            ("mechanical", self.worst_mechanics)
        };
        checks.extend([
            Check::at_most(format!("{scope} energy balance [J]"), residual, SHOT),
            Check::at_most(
                format!("{scope} energy balance, part of the energy of gas and bodies [-]"),
                residual / gas.max(self.turnover),
                PART,
            ),
            Check::at_most("momentum balance [N s]", self.worst_momentum, 1e-9),
        ]);
        if energy_kept && plan.volumes.iter().any(|volume| volume.ledger.is_some()) {
            checks.push(Check::at_most(
                "mass balance of a volume [kg]",
                self.worst_volume[0],
                1e-12,
            ));
            checks.push(Check::at_most(
                "energy balance of a volume [J]",
                self.worst_volume[1],
                1e-6,
            ));
        }
        checks
    }
}

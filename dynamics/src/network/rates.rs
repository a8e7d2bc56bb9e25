//! The right-hand side: loops over the kinds of blocks. Each block reads from and adds to a common workspace.

use std::cell::RefCell;
use std::rc::Rc;

use super::assembly::ForceLaw;
use super::drive::Carrier;
use super::gas::Gas;
use super::kernels::{Damped, Ends, Flow};
use super::mode::{Mode, head};
use super::past_flows::PastFlows;
use super::plan::{Pair, Plan};
use super::resistance::interpolate;

/// Quantities of a state; reused between calls.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    /// Positions and velocities of the bodies, then those of the ground.
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    /// Forces on bodies and ground, down.
    pub(crate) force: Vec<f64>,
    /// External force on the bodies, excluding the ground's reactions.
    pub(crate) outer: f64,
    pub(crate) volume: Vec<f64>,
    /// Rates of change of the volumes, and areas of their walls.
    pub(crate) growth: Vec<f64>,
    pub(crate) wall: Vec<f64>,
    pub(crate) heat: Vec<f64>,
    /// Of volumes, then of reservoirs.
    pub(crate) pressure: Vec<f64>,
    pub(crate) temperature: Vec<f64>,
    pub(crate) flow: Vec<Flow<f64>>,
    pub(crate) thrust: Vec<f64>,
    /// Forces of the contacts, nonnegative except for a dashpot just before opening.
    pub(crate) contact: Vec<Damped<f64>>,
    /// Forces on the body that is `on`, down.
    pub(crate) spring: Vec<Damped<f64>>,
    pub(crate) hold: Vec<Damped<f64>>,
    /// Friction, opposing the motion.
    pub(crate) friction: Vec<Damped<f64>>,
    pub(crate) imposed: Vec<f64>,
    pub(crate) motor: Vec<f64>,
    /// Force of the workpiece on the driver, upwards, and friction of the guide.
    pub(crate) fastener: Vec<[f64; 2]>,
    /// Mass of the gas in each volume.
    pub(crate) mass: Vec<f64>,
    /// Time since the start of the window, and force of the support, of a workpiece that an external structure moves.
    pub(crate) clock: f64,
    pub(crate) support: f64,
    /// Flow that leaves the first space of a passage, if it differs from the flow that arrives.
    pub(crate) leaving: Vec<Flow<f64>>,
    /// Past flows of delayed passages.
    pub(crate) past: PastFlows,
    /// Net mass flow and enthalpy flow into each volume.
    inflow: Vec<[f64; 2]>,
}

impl Workspace {
    pub(crate) fn new(plan: &Plan) -> Self {
        // A driven body has three more places: its grip, and surface and grip without their forces.
        let places = plan.bodies.len() + if plan.driven.is_some() { 4 } else { 1 };
        let volumes = plan.volumes.len();
        let mut pressure = vec![0.0; volumes];
        let mut temperature = vec![0.0; volumes];
        for reservoir in &plan.assembly.reservoirs {
            pressure.push(reservoir.pressure);
            temperature.push(reservoir.temperature);
        }
        let still = Flow::none(0.0);
        Self {
            position: vec![0.0; places],
            velocity: vec![0.0; places],
            acceleration: vec![0.0; places],
            force: vec![0.0; places],
            outer: 0.0,
            volume: vec![0.0; volumes],
            growth: vec![0.0; volumes],
            wall: vec![0.0; volumes],
            heat: vec![0.0; volumes],
            pressure,
            temperature,
            flow: vec![still; plan.passages.len()],
            leaving: vec![still; plan.passages.len()],
            past: Rc::new(RefCell::new(vec![Vec::new(); plan.passages.len()])),
            thrust: vec![0.0; plan.passages.len()],
            contact: vec![Damped::none(); plan.contacts.len()],
            spring: vec![Damped::none(); plan.springs.len()],
            hold: vec![Damped::none(); plan.holds.len()],
            friction: vec![Damped::none(); plan.frictions.len()],
            imposed: vec![0.0; plan.forces.len()],
            motor: vec![0.0; plan.motors.len()],
            fastener: vec![[0.0; 2]; plan.fasteners.len()],
            mass: vec![0.0; volumes],
            clock: 0.0,
            support: 0.0,
            inflow: vec![[0.0; 2]; volumes],
        }
    }

    /// Travel of a pair.
    #[inline]
    pub(crate) fn travel(&self, pair: Pair) -> f64 {
        self.position[pair.on] - self.position[pair.against]
    }

    /// Rate of a pair's travel.
    #[inline]
    pub(crate) fn speed(&self, pair: Pair) -> f64 {
        self.velocity[pair.on] - self.velocity[pair.against]
    }

    /// Applies a force to `on` and its reaction to the other body.
    #[inline]
    fn act(&mut self, pair: Pair, force: f64) {
        self.force[pair.on] += force;
        self.force[pair.against] -= force;
    }

    pub(crate) fn gas(&self, index: usize) -> Gas<f64> {
        Gas {
            pressure: self.pressure[index],
            temperature: self.temperature[index],
        }
    }
}

impl Plan {
    /// Mass that moves with a body.
    #[inline]
    pub(crate) fn moving_mass(&self, body: usize, mode: &Mode) -> f64 {
        let plan = &self.bodies[body];
        match plan.fastener.map(|f| &self.fasteners[f]) {
            Some(fastener) if mode.switches[fastener.head] == head::ATTACHED => plan.mass + fastener.mass,
            _ => plan.mass,
        }
    }

    /// Positions, volumes, pressures and temperatures.
    #[inline]
    pub(crate) fn instant(&self, y: &[f64], mode: &Mode, w: &mut Workspace) {
        self.stand(y, mode.wood.as_ref(), w);
        for (i, plan) in self.volumes.iter().enumerate() {
            w.volume[i] = plan.dead;
            w.growth[i] = 0.0;
            w.wall[i] = plan.wall_area;
        }
        for face in &self.faces {
            if let Some(i) = face.volume {
                let swept = w.travel(face.pair) - face.zero;
                w.volume[i] += face.area * swept;
                w.growth[i] += face.area * w.speed(face.pair);
                w.wall[i] += face.perimeter * swept;
            }
        }
        let (energy, mass) = (self.energy(), self.mass());
        let k = self.gamma - 1.0;
        for i in 0..self.volumes.len() {
            let (u, m) = (y[energy + i], y[mass + i]);
            w.mass[i] = m;
            w.pressure[i] = k * u / w.volume[i];
            w.temperature[i] = match self.temperature {
                Some(temperature) => temperature,
                None => k * u / (m * self.gas_constant),
            };
        }
    }

    pub(crate) fn ends(&self, passage: usize, w: &Workspace) -> Ends<f64> {
        let plan = &self.passages[passage];
        Ends {
            from: w.gas(plan.from),
            to: w.gas(plan.to),
            travel: plan.travels.map(|pair| pair.map_or(0.0, |pair| w.travel(pair))),
        }
    }

    /// Flows through all passages; requires [`Self::instant`].
    #[inline]
    pub(crate) fn flows(&self, t: f64, mode: &Mode, w: &mut Workspace) {
        for passage in 0..self.passages.len() {
            self.flow_through(passage, t, mode, w, None);
        }
    }

    /// Flow through a passage; requires [`Self::instant`]. `near` is an initial guess of the pressure inside a series.
    #[inline]
    pub(crate) fn flow_through(&self, index: usize, t: f64, mode: &Mode, w: &mut Workspace, near: Option<f64>) {
        let passage = &self.passages[index];
        if !passage.is_open(mode) && passage.delay.is_none() && passage.undelayed.is_none() {
            w.flow[index] = Flow::none(w.pressure[passage.to]);
            w.thrust[index] = 0.0;
            return;
        }
        let air = &self.airs[passage.air];
        let ends = self.ends(index, w);
        w.flow[index] = match passage.delay {
            None => passage.flow(air, mode, &ends, t, near),
            Some(delay) => self.arriving(index, delay, t, mode, w),
        };
        if passage.undelayed.is_some() {
            w.leaving[index] = self.leaving(passage, mode, &ends, t, &w.flow[index]);
        }
        if passage.jet {
            w.thrust[index] = passage.thrust(air, &ends, &w.flow[index], t);
        }
    }

    /// Forces of all blocks and accelerations; requires [`Self::instant`] and [`Self::flows`].
    #[inline]
    pub(crate) fn forces(&self, t: f64, mode: &Mode, w: &mut Workspace) {
        w.force.fill(0.0);
        w.outer = 0.0;
        for face in &self.faces {
            let force = w.pressure[face.gas] * face.area;
            w.act(face.pair, force);
        }
        self.contact_forces(mode, w);
        for (i, contact) in self.contacts.iter().enumerate() {
            // Most contacts are open.
            if !contact.carries && w.contact[i].force != 0.0 {
                let force = -contact.side * w.contact[i].force;
                w.act(contact.pair, force);
            }
        }
        for (i, spring) in self.springs.iter().enumerate() {
            if spring.carries {
                w.spring[i] = self.carrier(Carrier::Spring(i), -w.support);
                continue;
            }
            w.spring[i] = if spring.switch.is_none_or(|switch| mode.is_on(switch)) {
                spring.force(w.travel(spring.pair), w.speed(spring.pair))
            } else {
                Damped::none()
            };
            let force = w.spring[i].force;
            w.act(spring.pair, force);
        }
        for (i, friction) in self.frictions.iter().enumerate() {
            w.friction[i] = friction.force(mode, w.travel(friction.pair), w.speed(friction.pair));
            let force = -w.friction[i].force;
            w.act(friction.pair, force);
        }
        for (i, imposed) in self.forces.iter().enumerate() {
            let force = match &imposed.law {
                ForceLaw::Constant(force) => *force,
                ForceLaw::Table(points) => interpolate(points, t).0,
                ForceLaw::Jet { passage, share } => w.thrust[*passage] * share,
            };
            w.imposed[i] = force;
            w.force[imposed.pair.on] += force;
            if imposed.pair.against == self.ground() {
                w.outer += force;
            } else {
                w.force[imposed.pair.against] -= force;
            }
        }
        for (i, motor) in self.motors.iter().enumerate() {
            w.motor[i] = if mode.is_on(motor.switch) {
                motor.force(w.speed(motor.pair))
            } else {
                0.0
            };
            let force = w.motor[i];
            w.act(motor.pair, force);
        }
        for (i, hold) in self.holds.iter().enumerate() {
            w.hold[i] = if mode.is_on(hold.switch) {
                hold.force(mode.memory[hold.place], w.travel(hold.pair), w.speed(hold.pair))
            } else {
                Damped::none()
            };
            let force = w.hold[i].force;
            w.act(hold.pair, force);
        }
        for (i, fastener) in self.fasteners.iter().enumerate() {
            let [resistance, guide] = w.fastener[i];
            w.act(fastener.work, -resistance);
            w.act(fastener.guide, -guide);
        }
        for (body, plan) in self.bodies.iter().enumerate() {
            let mass = self.moving_mass(body, mode);
            w.acceleration[body] = w.force[body] / mass + plan.gravity;
            w.outer += mass * plan.gravity;
        }
        if let (Some(driven), Some(drive)) = (&self.driven, &mode.wood) {
            [w.acceleration[driven.body], w.acceleration[self.grip()]] = drive.accelerations(w.clock);
        }
    }

    /// Force output for a block that carries the lumped workpiece.
    fn carrier(&self, own: Carrier, support: f64) -> Damped<f64> {
        let shown = self.driven.is_some_and(|driven| driven.shown == Some(own));
        Damped {
            force: if shown { support } else { 0.0 },
            dashpot: 0.0,
        }
    }

    /// Forces of contacts and fasteners; requires [`Self::instant`].
    #[inline]
    pub(crate) fn contact_forces(&self, mode: &Mode, w: &mut Workspace) {
        for (i, contact) in self.contacts.iter().enumerate() {
            w.contact[i] = if contact.carries {
                self.carrier(Carrier::Contact(i), w.support)
            } else if mode.is_on(contact.switch) {
                let (u, rate) = contact.overlap(w.travel(contact.pair), w.speed(contact.pair));
                contact.push(u, rate)
            } else {
                Damped::none()
            };
        }
        for (i, fastener) in self.fasteners.iter().enumerate() {
            let (x, v) = (w.travel(fastener.work), w.speed(fastener.work));
            let resistance = fastener.force(mode, x - fastener.tip_at, v);
            let guided = fastener.guide_loss.is_some() && mode.switches[fastener.head] == head::ATTACHED;
            let guide = if guided {
                fastener.guide(w.speed(fastener.guide))
            } else {
                0.0
            };
            w.fastener[i] = [resistance, guide];
        }
    }

    /// Heat from the walls; requires [`Self::instant`].
    #[inline]
    fn walls(&self, w: &mut Workspace) {
        for (i, volume) in self.volumes.iter().enumerate() {
            w.heat[i] = volume.transfer * w.wall[i] * (volume.wall_temperature - w.temperature[i]);
        }
    }

    /// dy/dt of states and ledger.
    pub(crate) fn rates(&self, t: f64, y: &[f64], mode: &Mode, w: &mut Workspace, rate: &mut [f64]) {
        self.instant(y, mode, w);
        self.flows(t, mode, w);
        self.forces(t, mode, w);
        self.walls(w);
        rate[self.states()..].fill(0.0);
        for body in 0..self.bodies.len() {
            rate[2 * body] = w.velocity[body];
            rate[2 * body + 1] = w.acceleration[body];
        }
        w.inflow.fill([0.0; 2]);
        for (i, (passage, flow)) in self.passages.iter().zip(&w.flow).enumerate() {
            let leaving = if passage.undelayed.is_some() {
                &w.leaving[i]
            } else {
                flow
            };
            let [out, into] = passage.carried(leaving, flow);
            if let Some(inflow) = w.inflow.get_mut(passage.from) {
                inflow[0] -= out[0];
                inflow[1] -= out[1];
            }
            if let Some(inflow) = w.inflow.get_mut(passage.to) {
                inflow[0] += into[0];
                inflow[1] += into[1];
            }
            if let Some(ledger) = passage.ledger {
                rate[ledger.mass] = flow.mass;
                rate[ledger.enthalpy] = flow.enthalpy;
            }
        }
        let (energy, mass) = (self.energy(), self.mass());
        let cv = self.cp - self.gas_constant;
        for (i, volume) in self.volumes.iter().enumerate() {
            let [dm, enthalpy] = w.inflow[i];
            let work = w.pressure[i] * w.growth[i];
            let rise = match volume.isothermal {
                // The heat from the wall maintains a constant temperature.
                Some(temperature) => {
                    w.heat[i] = cv * temperature * dm - (enthalpy - work);
                    cv * temperature * dm
                }
                None => enthalpy + w.heat[i] - work * self.expansion,
            };
            rate[energy + i] = rise;
            rate[mass + i] = dm;
            if let Some(ledger) = volume.ledger {
                rate[ledger.heat] = w.heat[i];
                rate[ledger.work] = work;
            }
        }
        if let Some(heat) = self.heat {
            rate[heat] = w.heat.iter().sum();
        }
        self.losses(w, rate);
        rate[self.ground_impulse] = w.force[self.ground()];
        if let Some(driven) = &self.driven {
            // The other bodies rest on the workpiece itself.
            let (seat, grip) = (driven.body, self.grip());
            rate[2 * seat] = y[2 * seat + 1];
            rate[2 * seat + 1] = 0.0;
            rate[self.ground_impulse] += w.force[seat] + w.force[grip];
            rate[driven.work] = w.force[seat] * w.velocity[seat] + w.force[grip] * w.velocity[grip];
        }
        rate[self.outer_impulse] = w.outer;
    }

    /// Rates of the work of gas, motors and forces, and of the dissipation in dashpots, friction and fasteners.
    #[inline]
    fn losses(&self, w: &Workspace, rate: &mut [f64]) {
        for face in &self.faces {
            if let Some(work) = face.work {
                rate[work] += w.pressure[face.gas] * face.area * w.speed(face.pair);
            }
        }
        for (contact, push) in self.contacts.iter().zip(&w.contact) {
            if let Some(loss) = contact.loss {
                rate[loss] = push.dashpot * contact.side * w.speed(contact.pair);
            }
        }
        for (spring, force) in self.springs.iter().zip(&w.spring) {
            if let Some(loss) = spring.loss {
                rate[loss] = -force.dashpot * w.speed(spring.pair);
            }
        }
        for (hold, force) in self.holds.iter().zip(&w.hold) {
            if let Some(loss) = hold.loss {
                rate[loss] = -force.dashpot * w.speed(hold.pair);
            }
        }
        for (friction, force) in self.frictions.iter().zip(&w.friction) {
            rate[friction.loss] = force.dashpot * w.speed(friction.pair);
        }
        for (imposed, force) in self.forces.iter().zip(&w.imposed) {
            if let Some(work) = imposed.work {
                rate[work] = force * w.speed(imposed.pair);
            }
        }
        for (motor, force) in self.motors.iter().zip(&w.motor) {
            rate[motor.work] = force * w.speed(motor.pair);
        }
        for (fastener, [resistance, guide]) in self.fasteners.iter().zip(&w.fastener) {
            rate[fastener.penetration] = resistance * w.speed(fastener.work);
            if let Some(loss) = fastener.guide_loss {
                rate[loss] = guide * w.speed(fastener.guide);
            }
        }
    }
}

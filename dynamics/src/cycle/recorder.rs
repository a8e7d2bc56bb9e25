//! Histories on the uniform grid, and peaks.

use super::forces::Forces;
use super::history::Past;
use super::mode::{Contact, Mode};
use super::state::*;
use super::switching::deepest;
use super::system::{Instant, System};
use crate::{Body, ExhaustFlow, Motion, Summary, VentFlow, Volume};

/// Histories under construction.
#[derive(Debug, Default)]
pub(crate) struct Recorder {
    pub(crate) interval: f64,
    pub(crate) bodies: [Body; 4],
    pub(crate) motion: Motion,
    pub(crate) volumes: [Volume; VOLUMES],
    pub(crate) forces: crate::Forces,
    pub(crate) exhaust: ExhaustFlow,
    pub(crate) vent: VentFlow,
    peaks: Summary,
}

impl Recorder {
    pub(crate) fn new(interval: f64) -> Self {
        Self {
            interval,
            ..Self::default()
        }
    }

    /// Allocates memory for the samples up to `end`.
    pub(crate) fn reserve(&mut self, end: f64) {
        let n = (end / self.interval) as usize + 2;
        let (m, f, x, v) = (&mut self.motion, &mut self.forces, &mut self.exhaust, &mut self.vent);
        let bodies = self
            .bodies
            .iter_mut()
            .flat_map(|b| [&mut b.position, &mut b.velocity, &mut b.acceleration]);
        let volumes = self
            .volumes
            .iter_mut()
            .flat_map(|v| [&mut v.pressure, &mut v.temperature, &mut v.mass]);
        let others = [
            &mut m.piston_travel,
            &mut m.valve_lift,
            &mut m.tip_depth,
            &mut m.nail_depth,
            &mut m.moving_mass,
            &mut f.piston_gas,
            &mut f.valve_gas,
            &mut f.bumper,
            &mut f.stopper,
            &mut f.cap,
            &mut f.seat,
            &mut f.spring,
            &mut f.piston_friction,
            &mut f.valve_friction,
            &mut f.penetration,
            &mut f.nose,
            &mut f.guard,
            &mut f.support,
            &mut f.hand,
            &mut f.magazine,
            &mut f.thrust,
            &mut x.mass_flow,
            &mut x.plenum_pressure,
            &mut x.stagnation_temperature,
            &mut x.intake_mass_flow,
            &mut v.mass_flow,
            &mut v.pressure,
            &mut v.temperature,
        ];
        // If columns were whole pages apart, one sample would occupy a single set of the cache; offsetting each column
        // by a cache line avoids this.
        bodies
            .chain(volumes)
            .chain(others)
            .enumerate()
            .for_each(|(i, column)| column.reserve_exact(n + 8 * i));
        x.choked.reserve_exact(n);
        x.intake_choked.reserve_exact(n);
    }

    /// Number of samples so far.
    pub(crate) fn len(&self) -> usize {
        self.motion.piston_travel.len()
    }

    /// Time of the next sample.
    pub(crate) fn next_time(&self) -> f64 {
        self.len() as f64 * self.interval
    }

    /// Appends a sample.
    pub(crate) fn push(&mut self, system: &System, mode: &Mode, past: &Past, y: &[f64]) {
        let now = system.instant(y);
        let e = system.forces(y, &now, mode);
        self.peak(&e, mode, y);
        // Extrapolated from the last two samples.
        let near = match self.exhaust.plenum_pressure[..] {
            [.., before, last] => Some(2.0 * last - before),
            _ => None,
        };
        let exhaust = system.exhaust(&now, mode, near);
        let acceleration = system.accelerations(&e, exhaust.thrust, mode);
        let Instant { travel, valve, gas, .. } = now;
        for (body, history) in self.bodies.iter_mut().enumerate() {
            let motion = match &mode.wood {
                Some(wood) if 2 * body == Y_W => wood.seat_at(y[Y_W]),
                _ => [y[2 * body], y[2 * body + 1], acceleration[body]],
            };
            history.position.push(motion[0]);
            history.velocity.push(motion[1]);
            history.acceleration.push(motion[2]);
        }
        let m = &mut self.motion;
        m.piston_travel.push(travel);
        m.valve_lift.push(system.p.head_valve.lift - valve);
        m.tip_depth.push(system.depth(mode, y));
        m.nail_depth.push(deepest(system, mode, y));
        m.moving_mass.push(system.moving_mass(mode));
        for (i, history) in self.volumes.iter_mut().enumerate() {
            history.pressure.push(gas[i].pressure);
            history.temperature.push(gas[i].temperature);
            history.mass.push(y[MASS + i]);
        }
        let f = &mut self.forces;
        let push = |contact: Contact| e.push[contact as usize];
        f.piston_gas.push(e.piston_gas);
        f.valve_gas.push(e.valve_gas);
        f.bumper.push(push(Contact::Bumper));
        f.stopper.push(-push(Contact::Stopper));
        f.cap.push(-push(Contact::Cap));
        f.seat.push(push(Contact::Seat));
        f.spring.push(e.spring);
        f.piston_friction.push(e.piston_friction);
        f.valve_friction.push(e.valve_friction);
        f.penetration.push(e.penetration);
        f.nose.push(push(Contact::Nose));
        f.guard.push(e.guard);
        f.support.push(match &mode.wood {
            Some(wood) => wood.support_at(y[Y_W]),
            None => push(Contact::Support),
        });
        f.hand.push(e.hand);
        f.magazine.push(e.magazine);
        f.thrust.push(exhaust.thrust);
        let x = &mut self.exhaust;
        x.mass_flow.push(exhaust.mass);
        x.plenum_pressure.push(exhaust.plenum);
        x.back_pressure.push(exhaust.behind);
        x.stagnation_temperature.push(if exhaust.mass >= 0.0 {
            gas[ABOVE].temperature
        } else {
            system.p.ambient.temperature
        });
        x.choked
            .push(mode.exhaust && exhaust.behind < system.air.critical * exhaust.plenum);
        x.intake_choked
            .push(mode.intake && gas[ABOVE].pressure < system.air.critical * gas[SUPPLY].pressure);
        x.intake_mass_flow.push(system.intake(&now, mode));
        let v = &mut self.vent;
        v.mass_flow.push(system.channel(&gas, mode, past).vent.mass);
        v.pressure.push(gas[CONTROL].pressure);
        v.temperature.push(gas[CONTROL].temperature);
    }

    /// Updates the peaks between samples.
    pub(crate) fn follow(&mut self, system: &System, mode: &Mode, y: &State) {
        self.peak(&system.forces(y, &system.instant(y), mode), mode, y);
    }

    fn peak(&mut self, e: &Forces<f64>, mode: &Mode, y: &[f64]) {
        let push = |contact: Contact| e.push[contact as usize];
        let s = &mut self.peaks;
        let highest = |peak: &mut f64, value: f64| *peak = peak.max(value);
        highest(&mut s.peak_penetration_force, e.penetration);
        highest(&mut s.peak_bumper_force, push(Contact::Bumper));
        highest(&mut s.peak_stopper_force, push(Contact::Stopper));
        highest(&mut s.peak_cap_force, push(Contact::Cap));
        highest(&mut s.peak_seat_force, push(Contact::Seat));
        highest(&mut s.peak_nose_force, push(Contact::Nose));
        let lumped = push(Contact::Support);
        let support = mode.wood.map_or(lumped, |wood| wood.support_at(y[Y_W]));
        highest(&mut s.peak_support_force, support);
    }

    /// Peaks so far, with everything else empty.
    pub(crate) fn peaks(&self) -> Summary {
        self.peaks.clone()
    }
}

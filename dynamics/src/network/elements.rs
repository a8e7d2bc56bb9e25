//! Forces of the blocks between two bodies with their derivatives, in dual numbers of travel and speed.

use super::mode::{Mode, head};
use super::plan::{Pair, Plan};
use super::rates::Workspace;
use nailnoise_penetration::Dual;

fn seeded(x: f64, v: f64) -> [Dual<2>; 2] {
    [
        Dual {
            value: x,
            slope: [1.0, 0.0],
        },
        Dual {
            value: v,
            slope: [0.0, 1.0],
        },
    ]
}

/// Contribution of a block between two bodies.
pub(crate) struct Element {
    pub(crate) pair: Pair,
    /// Force on `on`, down, over travel and speed.
    pub(crate) force: Dual<2>,
    /// Integral whose rate is a power of the block, and that power.
    pub(crate) power: Option<(usize, Dual<2>)>,
}

impl Plan {
    /// Passes the forces of all blocks between two bodies to `visit`, with their derivatives.
    pub(crate) fn pair_elements(&self, mode: &Mode, w: &Workspace, visit: &mut impl FnMut(&Element)) {
        let mut add = |pair, force, power| visit(&Element { pair, force, power });
        for contact in self.contacts.iter().filter(|c| mode.is_on(c.switch)) {
            let [x, v] = seeded(w.travel(contact.pair), w.speed(contact.pair));
            let (u, rate) = contact.overlap(x, v);
            let push = contact.push(u, rate);
            let power = contact.loss.map(|row| (row, push.dashpot * rate));
            add(contact.pair, push.force * -contact.side, power);
        }
        for spring in self.springs.iter().filter(|spring| !spring.carries) {
            if spring.switch.is_none_or(|switch| mode.is_on(switch)) {
                let [x, v] = seeded(w.travel(spring.pair), w.speed(spring.pair));
                let found = spring.force(x, v);
                let power = spring.loss.map(|row| (row, -found.dashpot * v));
                add(spring.pair, found.force, power);
            }
        }
        for friction in &self.frictions {
            let [x, v] = seeded(w.travel(friction.pair), w.speed(friction.pair));
            let found = friction.force(mode, x, v);
            add(friction.pair, -found.force, Some((friction.loss, found.dashpot * v)));
        }
        for motor in self.motors.iter().filter(|m| mode.is_on(m.switch)) {
            let [_, v] = seeded(0.0, w.speed(motor.pair));
            let force = motor.force(v);
            add(motor.pair, force, Some((motor.work, force * v)));
        }
        for hold in self.holds.iter().filter(|h| mode.is_on(h.switch)) {
            let [x, v] = seeded(w.travel(hold.pair), w.speed(hold.pair));
            let found = hold.force(mode.memory[hold.place], x, v);
            let power = hold.loss.map(|row| (row, -found.dashpot * v));
            add(hold.pair, found.force, power);
        }
        for fastener in &self.fasteners {
            let [x, v] = seeded(w.travel(fastener.work), w.speed(fastener.work));
            let force = fastener.force(mode, x - fastener.tip_at, v);
            add(fastener.work, -force, Some((fastener.penetration, force * v)));
            if let Some(row) = fastener.guide_loss
                && mode.switches[fastener.head] == head::ATTACHED
            {
                let [_, v] = seeded(0.0, w.speed(fastener.guide));
                let force = fastener.guide(v);
                add(fastener.guide, -force, Some((row, force * v)));
            }
        }
    }
}

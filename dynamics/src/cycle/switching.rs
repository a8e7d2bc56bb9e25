//! When the mode changes, and what it changes to.
//!
//! Each slot monitors one condition of the current mode through a margin that is positive while the condition is true;
//! the event occurs when the margin falls through zero.

use super::mode::{Contact, Mode, NailState, Penetration};
use super::state::*;
use super::system::System;
use crate::{Crossing, Form};

/// Number of monitored conditions.
pub(crate) const SLOTS: usize = 13;

const GUARD: usize = 6;
const INTAKE: usize = 7;
const EXHAUST: usize = 8;
const CHECK_HOLES: usize = 9;
const NAIL: usize = 10;
const DEPTH_UP: usize = 11;
const DEPTH_DOWN: usize = 12;

/// Name of the object monitored by a slot, for messages.
pub(crate) fn slot_name(slot: usize) -> &'static str {
    match slot {
        GUARD => "the guard spring",
        INTAKE => "the intake",
        EXHAUST => "the exhaust",
        CHECK_HOLES => "the check-ring holes",
        NAIL => "the rod on the nail",
        DEPTH_UP | DEPTH_DOWN => "the nail in the wood",
        contact => Contact::ALL[contact].name(),
    }
}

/// The log entry for the event of `slot` between two modes, unless it is only a level crossing.
pub(crate) fn entry(slot: usize, before: &Mode, after: &Mode) -> Option<(Crossing, bool)> {
    let loading = |mode: &Mode| matches!(mode.penetration, Penetration::Loading { .. });
    let pressing = |mode: &Mode| !matches!(mode.penetration, Penetration::Free { .. });
    match slot {
        GUARD | INTAKE | EXHAUST | CHECK_HOLES => None,
        NAIL => Some((Crossing::NailDriven, after.nail == NailState::Attached)),
        DEPTH_UP | DEPTH_DOWN if pressing(before) != pressing(after) && !loading(before) && !loading(after) => {
            Some((Crossing::NailContact, pressing(after)))
        }
        DEPTH_UP | DEPTH_DOWN => (loading(before) != loading(after)).then(|| (Crossing::Penetration, loading(after))),
        contact => Some((CONTACTS[contact], after.closed[contact])),
    }
}

/// Contacts in the log, indexed by [`Contact`].
const CONTACTS: [Crossing; Contact::COUNT] = [
    Crossing::BumperContact,
    Crossing::StopperContact,
    Crossing::CapContact,
    Crossing::SeatContact,
    Crossing::NoseContact,
    Crossing::SupportContact,
];

/// Margins of all conditions of `mode` at `y`; infinite if nothing is monitored.
pub(crate) fn margins(system: &System, mode: &Mode, y: &State) -> [f64; SLOTS] {
    let mut margin = [f64::INFINITY; SLOTS];
    let p = &system.p;
    for contact in Contact::ALL {
        if contact == Contact::Support && mode.wood.is_some() {
            continue;
        }
        let (u, rate) = match (contact, mode.wood) {
            (Contact::Nose, Some(wood)) if !mode.closed(contact) => wood.seat_gap(y),
            _ => system.overlap(contact, mode, y),
        };
        let spring = system.springs[contact as usize];
        let push = u + spring.damping / spring.stiffness * rate;
        // Closing requires overlap and a pushing force; a contact that overlaps while its force is negative remains
        // open. Published contacts may pull, so only overlap counts (C-13).
        let push = if p.model.contacts == Form::Published { u } else { push };
        margin[contact as usize] = if mode.closed(contact) { push } else { -u.min(push) };
    }
    if mode.wood.is_some_and(|wood| wood.caught) {
        margin[Contact::Nose as usize] = f64::INFINITY;
    }
    let signed = |inside: bool, x: f64| if inside { x } else { -x };
    let lift = p.head_valve.lift - (y[Y_H] - y[Y_G]);
    let travel = y[Y_P] - y[Y_G];
    margin[GUARD] = signed(mode.guard, y[Y_G] - mode.seat_motion(y).0 + p.contacts.guard_travel);
    margin[INTAKE] = signed(mode.intake, lift - p.head_valve.intake_lap);
    margin[EXHAUST] = signed(mode.exhaust, p.head_valve.exhaust_lap - lift);
    margin[CHECK_HOLES] = signed(mode.check_holes, travel - p.chambers.check_hole_position);
    margin[NAIL] = match mode.nail {
        NailState::Waiting => system.geometry.head_gap - travel,
        NailState::Attached => y[V_P],
        NailState::Left => f64::INFINITY,
    };
    let z = system.depth(mode, y);
    // The contact test of the tip uses the motion without its own force, like that of the nose.
    let touching = mode
        .wood
        .map_or(z, |wood| y[Y_P] - wood.free_nail(y) - system.geometry.tip_gap);
    if p.model.nail == Form::Published {
        // Reversible: the force is a function of depth until the first reversal, and zero afterwards (C-09).
        match mode.penetration {
            Penetration::Loading { seated: false } => {
                margin[DEPTH_UP] = p.nail.length - z;
                margin[DEPTH_DOWN] = z;
            }
            Penetration::Loading { seated: true } => margin[DEPTH_DOWN] = z - p.nail.length,
            Penetration::Free { .. } | Penetration::Unloading { .. } if mode.nail != NailState::Left => {
                margin[DEPTH_UP] = -touching;
            }
            Penetration::Free { .. } | Penetration::Unloading { .. } => {}
        }
        return margin;
    }
    match mode.penetration {
        Penetration::Free { deepest, force: 0.0 } => margin[DEPTH_UP] = deepest - touching,
        Penetration::Free { deepest, force } => margin[DEPTH_UP] = deepest - force / p.wood.unloading_stiffness - z,
        Penetration::Loading { seated } => {
            if !seated {
                margin[DEPTH_UP] = p.nail.length - z;
            }
            margin[DEPTH_DOWN] = y[V_P] - mode.nail_motion(y).1;
        }
        Penetration::Unloading { deepest, force } => {
            margin[DEPTH_UP] = deepest - z;
            margin[DEPTH_DOWN] = z - (deepest - force / p.wood.unloading_stiffness);
        }
    }
    margin
}

/// Rounding error of the margins' terms; a condition is monitored once its margin has exceeded this.
///
/// A damped contact grazes if it lets go just as it is pressed shut again: its force touches zero and rises. The
/// overlap, 1e-9 m on a cap of 1e11 N/m, is a difference between positions of centimetres. Rounding of these would open
/// and close the contact thousands of times before its force has risen above the noise.
pub(crate) fn event_tolerances(system: &System) -> [f64; SLOTS] {
    let mut tolerances = [0.0; SLOTS];
    tolerances[..Contact::COUNT].fill(16.0 * f64::EPSILON * system.p.piston.stroke);
    tolerances
}

/// Whether `slot` monitors the rod on the nail.
pub(crate) fn is_nail(slot: usize) -> bool {
    slot == NAIL
}

/// Whether the event of `slot` is the impact of the rod on the nail.
pub(crate) fn is_impact(slot: usize, mode: &Mode) -> bool {
    slot == NAIL && mode.nail == NailState::Waiting
}

/// Changes mode and state at the event of `slot`.
pub(crate) fn cross(system: &System, slot: usize, mode: &mut Mode, y: &mut State) {
    match slot {
        GUARD => {
            mode.guard = !mode.guard;
            mode.released |= !mode.guard;
        }
        INTAKE => mode.intake = !mode.intake,
        EXHAUST => mode.exhaust = !mode.exhaust,
        CHECK_HOLES => mode.check_holes = !mode.check_holes,
        NAIL => match mode.nail {
            NailState::Waiting => {
                mode.impact = y[V_P] - mode.nail_motion(y).1;
                // Plastic impact of the rod on the nail at rest; in the published form, the nail acquires its speed
                // without it (C-08).
                if system.p.model.impact == Form::Corrected {
                    y[V_P] *= system.p.piston.mass / (system.p.piston.mass + system.geometry.nail_mass);
                }
                mode.nail = NailState::Attached;
            }
            NailState::Attached | NailState::Left => {
                mode.nail = NailState::Left;
                if system.p.model.nail == Form::Published {
                    mode.penetration = Penetration::Free {
                        deepest: deepest(system, mode, y),
                        force: 0.0,
                    };
                }
            }
        },
        DEPTH_UP => {
            mode.penetration = match mode.penetration {
                Penetration::Free { deepest, force } if force > 0.0 => Penetration::Unloading { deepest, force },
                Penetration::Free { .. } => Penetration::Loading { seated: false },
                Penetration::Loading { .. } => Penetration::Loading { seated: true },
                Penetration::Unloading { deepest, .. } => Penetration::Loading {
                    seated: deepest >= system.p.nail.length,
                },
            }
        }
        DEPTH_DOWN => {
            mode.penetration = match mode.penetration {
                Penetration::Loading { seated } if system.p.model.nail == Form::Published => {
                    if seated {
                        Penetration::Loading { seated: false }
                    } else {
                        Penetration::Free {
                            deepest: 0.0,
                            force: 0.0,
                        }
                    }
                }
                Penetration::Loading { .. } => {
                    let deepest = system.depth(mode, y);
                    Penetration::Unloading {
                        deepest,
                        force: system.envelope.at_rest(deepest, mode.impact),
                    }
                }
                Penetration::Unloading { deepest, force } => Penetration::Free { deepest, force },
                free @ Penetration::Free { .. } => free,
            }
        }
        contact => {
            mode.closed[contact] = !mode.closed[contact];
            if let Some(wood) = &mut mode.wood
                && contact == Contact::Nose as usize
            {
                wood.caught = mode.closed[contact] && wood.open_at_start;
            }
        }
    }
}

/// z_max, largest nail tip depth so far, at least 0.
pub(crate) fn deepest(system: &System, mode: &Mode, y: &[f64]) -> f64 {
    match mode.penetration {
        Penetration::Free { deepest, .. } | Penetration::Unloading { deepest, .. } => deepest,
        Penetration::Loading { .. } => system.depth(mode, y).max(0.0),
    }
}

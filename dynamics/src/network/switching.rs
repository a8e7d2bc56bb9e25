//! Conditions for changes of the mode, and the modes after the changes.
//!
//! Each slot monitors one condition of the current mode through a margin that is positive while the condition is true;
//! the event occurs when the margin falls through zero.

use super::assembly::{Action, BlockRef, Family, Word};
use super::error::RunError;
use super::mode::{Mode, depth, friction, head};
use super::plan::{AreaPlan, Plan};
use super::probe::{Need, Program};
use super::rates::Workspace;

/// A monitored condition.
#[derive(Debug, Clone)]
pub(crate) enum Slot {
    /// A contact, by index.
    Contact(usize),
    /// A spring that only pushes.
    Spring(usize),
    /// A seat or holes of a passage.
    Opening { passage: usize, restriction: usize },
    /// The further condition of a passage's gate.
    Condition { passage: usize, program: Program },
    /// Friction that may stick.
    Stick(usize),
    /// The driver on a fastener's head.
    Head(usize),
    /// A fastener moving deeper.
    Deeper(usize),
    /// A fastener moving back.
    Back(usize),
}

/// All slots of a plan.
#[derive(Debug, Clone)]
pub(crate) struct Slots {
    pub(crate) list: Vec<Slot>,
    /// Margin above which a slot is armed.
    pub(crate) event_tolerances: Vec<f64>,
    /// How far a state must be evaluated for the margins.
    pub(crate) need: Need,
}

impl Slots {
    pub(crate) fn new(plan: &Plan) -> Result<Self, RunError> {
        let mut list: Vec<Slot> = (0..plan.contacts.len()).map(Slot::Contact).collect();
        let springs = plan.springs.iter().enumerate().filter(|(_, s)| s.switch.is_some());
        list.extend(springs.map(|(i, _)| Slot::Spring(i)));
        let mut need = Need::Instant;
        for (passage, p) in plan.passages.iter().enumerate() {
            for (restriction, r) in p.restrictions.iter().enumerate() {
                if r.travel().is_some() {
                    list.push(Slot::Opening { passage, restriction });
                }
            }
            let described = &plan.assembly.passages[passage];
            if let Some(also) = described.gate.as_ref().and_then(|gate| gate.also.as_ref()) {
                let program = Program::new(plan, &format!("passage \"{}\"", described.name), also)?;
                need = need.max(program.need);
                list.push(Slot::Condition { passage, program });
            }
        }
        let sticking = plan.frictions.iter().enumerate().filter(|(_, f)| f.stick.is_some());
        list.extend(sticking.map(|(i, _)| Slot::Stick(i)));
        for i in 0..plan.fasteners.len() {
            list.extend([Slot::Head(i), Slot::Deeper(i), Slot::Back(i)]);
        }
        // The overlap of a stiff contact is a difference between positions of centimetres. Their rounding would open
        // and close a grazing contact thousands of times before its force has risen above the noise.
        let rounding = 16.0 * f64::EPSILON * plan.reach;
        let event_tolerances = list
            .iter()
            .map(|slot| {
                if matches!(slot, Slot::Contact(_)) {
                    rounding
                } else {
                    0.0
                }
            })
            .collect();
        Ok(Self {
            list,
            event_tolerances,
            need,
        })
    }

    /// Margins of a state evaluated as far as necessary; infinite if nothing is monitored.
    pub(crate) fn margins(&self, plan: &Plan, mode: &Mode, w: &Workspace, margin: &mut [f64]) {
        for (slot, margin) in self.list.iter().zip(margin) {
            *margin = slot.margin(plan, mode, w);
        }
    }
}

/// `x` while a switch is on, else `-x`.
fn signed(on: bool, x: f64) -> f64 {
    if on { x } else { -x }
}

impl Slot {
    /// Name of the block, for messages.
    pub(crate) fn name<'a>(&self, plan: &'a Plan) -> &'a str {
        let assembly = &plan.assembly;
        match self {
            Self::Contact(i) => &assembly.contacts[*i].name,
            Self::Spring(i) => &assembly.springs[*i].name,
            Self::Opening { passage, .. } | Self::Condition { passage, .. } => &assembly.passages[*passage].name,
            Self::Stick(i) => &assembly.frictions[*i].name,
            Self::Head(i) | Self::Deeper(i) | Self::Back(i) => &assembly.fasteners[*i].name,
        }
    }

    /// Margin of the condition in a mode.
    pub(crate) fn margin(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        match self {
            Self::Contact(i) => {
                let contact = &plan.contacts[*i];
                if contact.carries || contact.landing.is_some_and(|[_, caught]| mode.is_on(caught)) {
                    return f64::INFINITY;
                }
                let (u, rate) = plan.approach(contact, mode, w);
                let push = contact.pressing(u, rate);
                // Closing requires overlap and a pushing force; a contact that overlaps while its force is negative
                // remains open (C-13).
                if mode.is_on(contact.switch) { push } else { -u.min(push) }
            }
            Self::Spring(i) => {
                let spring = &plan.springs[*i];
                let on = spring.switch.is_some_and(|switch| mode.is_on(switch));
                signed(on, spring.compression(w.travel(spring.pair)))
            }
            Self::Opening { passage, restriction } => {
                match plan.passages[*passage].restrictions[*restriction].travel() {
                    Some(way) => signed(mode.is_on(way.switch), way.sign * (w.travel(way.pair) - way.at)),
                    None => f64::INFINITY,
                }
            }
            Self::Condition { passage, program } => {
                let on = plan.passages[*passage]
                    .condition
                    .is_some_and(|switch| mode.is_on(switch));
                signed(on, program.value(plan, mode, w))
            }
            Self::Stick(i) => {
                let plan = &plan.frictions[*i];
                let (x, v) = (w.travel(plan.pair), w.speed(plan.pair));
                match plan.stick.as_ref().map(|stick| mode.switches[stick.switch]) {
                    Some(friction::FORTH) => v,
                    Some(friction::BACK) => -v,
                    Some(friction::STUCK) => plan.static_force - plan.force(mode, x, v).force.abs(),
                    _ => f64::INFINITY,
                }
            }
            Self::Head(i) => {
                let fastener = &plan.fasteners[*i];
                match mode.switches[fastener.head] {
                    head::WAITING => fastener.head_at - w.travel(fastener.stroke),
                    head::ATTACHED if !fastener.leaves_unloaded => w.velocity[fastener.stroke.on],
                    _ => f64::INFINITY,
                }
            }
            Self::Deeper(i) => deeper(plan, *i, mode, w),
            Self::Back(i) => back(plan, *i, mode, w),
        }
    }

    /// Changes mode and state at the event; `w` contains the state. Returns the word that the block logs.
    pub(crate) fn cross(&self, plan: &Plan, mode: &mut Mode, y: &mut [f64], w: &Workspace) -> Option<Word> {
        let word = |family, index: usize, restriction, action| Word {
            block: BlockRef { family, index },
            restriction,
            action,
        };
        match self {
            Self::Contact(i) => {
                let contact = &plan.contacts[*i];
                let on = toggle(mode, contact.switch);
                if let Some([open, caught]) = contact.landing {
                    mode.switches[caught] = u8::from(on && mode.is_on(open));
                }
                let action = if on { Action::Closes } else { Action::Opens };
                Some(word(Family::Contact, *i, 0, action))
            }
            Self::Spring(i) => {
                if let Some(switch) = plan.springs[*i].switch {
                    toggle(mode, switch);
                }
                None
            }
            Self::Opening { passage, restriction } => {
                let plan = &plan.passages[*passage].restrictions[*restriction];
                let on = plan.travel().is_some_and(|way| toggle(mode, way.switch));
                let holes = matches!(plan.area, AreaPlan::Holes { .. });
                let action = match (holes, on) {
                    (true, true) => Action::Uncovered,
                    (true, false) => Action::Covered,
                    (false, true) => Action::Opens,
                    (false, false) => Action::Shuts,
                };
                Some(word(Family::Passage, *passage, *restriction, action))
            }
            Self::Condition { passage, .. } => {
                let on = plan.passages[*passage]
                    .condition
                    .is_some_and(|switch| toggle(mode, switch));
                let action = if on { Action::GateOpens } else { Action::GateShuts };
                Some(word(Family::Passage, *passage, 0, action))
            }
            Self::Stick(i) => {
                let plan = &plan.frictions[*i];
                let stick = plan.stick.as_ref()?;
                let (x, v) = (w.travel(plan.pair), w.speed(plan.pair));
                let action = if mode.switches[stick.switch] == friction::STUCK {
                    let forth = plan.force(mode, x, v).force > 0.0;
                    mode.switches[stick.switch] = if forth { friction::FORTH } else { friction::BACK };
                    Action::Slips
                } else {
                    mode.switches[stick.switch] = friction::STUCK;
                    mode.memory[stick.place] = x;
                    Action::Sticks
                };
                Some(word(Family::Friction, *i, 0, action))
            }
            Self::Head(i) => {
                let fastener = &plan.fasteners[*i];
                let action = if mode.switches[fastener.head] == head::WAITING {
                    mode.memory[fastener.impact_speed] = w.speed(fastener.work);
                    if fastener.impact {
                        // Plastic impact on the fastener at rest.
                        let mass = plan.bodies[fastener.stroke.on].mass;
                        y[2 * fastener.stroke.on + 1] *= mass / (mass + fastener.mass);
                    }
                    mode.switches[fastener.head] = head::ATTACHED;
                    Action::Struck
                } else {
                    mode.switches[fastener.head] = head::LEFT;
                    if fastener.reversible {
                        mode.memory[fastener.deepest] = plan.deepest(*i, mode, w);
                        mode.memory[fastener.deepest + 1] = 0.0;
                        mode.switches[fastener.depth] = depth::FREE;
                    }
                    Action::Left
                };
                Some(word(Family::Fastener, *i, 0, action))
            }
            Self::Deeper(i) => {
                let fastener = &plan.fasteners[*i];
                let [deepest, force] = [mode.memory[fastener.deepest], mode.memory[fastener.deepest + 1]];
                let (state, action) = match mode.switches[fastener.depth] {
                    depth::FREE if force > 0.0 => (depth::UNLOADING, None),
                    depth::FREE => (depth::LOADING, Some(Action::Enters)),
                    depth::UNLOADING if deepest >= fastener.length => (depth::SEATED, Some(Action::Reloads)),
                    depth::UNLOADING => (depth::LOADING, Some(Action::Reloads)),
                    _ => (depth::SEATED, Some(Action::Seats)),
                };
                mode.switches[fastener.depth] = state;
                action.map(|action| word(Family::Fastener, *i, 0, action))
            }
            Self::Back(i) => {
                let fastener = &plan.fasteners[*i];
                match mode.switches[fastener.depth] {
                    depth::SEATED if fastener.reversible => mode.switches[fastener.depth] = depth::LOADING,
                    depth::LOADING if fastener.reversible => {
                        mode.memory[fastener.deepest] = 0.0;
                        mode.memory[fastener.deepest + 1] = 0.0;
                        mode.switches[fastener.depth] = depth::FREE;
                    }
                    depth::LOADING | depth::SEATED => {
                        let z = plan.depth(*i, w);
                        mode.memory[fastener.deepest] = z;
                        mode.memory[fastener.deepest + 1] = fastener.envelope(mode, z);
                        mode.switches[fastener.depth] = depth::UNLOADING;
                        return Some(word(Family::Fastener, *i, 0, Action::Unloads));
                    }
                    _ => {
                        mode.switches[fastener.depth] = depth::FREE;
                        // The driver only pushes the fastener, so the force between them is zero if that of the work is
                        // zero.
                        if fastener.leaves_unloaded && mode.switches[fastener.head] == head::ATTACHED {
                            mode.switches[fastener.head] = head::LEFT;
                            return Some(word(Family::Fastener, *i, 0, Action::Left));
                        }
                    }
                }
                None
            }
        }
    }
}

/// Toggles a switch; returns its new state.
fn toggle(mode: &mut Mode, switch: usize) -> bool {
    mode.switches[switch] ^= 1;
    mode.is_on(switch)
}

/// Margin for a fastener to stop moving deeper.
fn deeper(plan: &Plan, fastener: usize, mode: &Mode, w: &Workspace) -> f64 {
    let (z, touching) = (plan.depth(fastener, w), plan.touching(fastener, w));
    let fastener = &plan.fasteners[fastener];
    let [deepest, force] = [mode.memory[fastener.deepest], mode.memory[fastener.deepest + 1]];
    match mode.switches[fastener.depth] {
        depth::LOADING => fastener.length - z,
        depth::SEATED => f64::INFINITY,
        // Reversible: the force is a function of depth until the first reversal, and zero afterwards.
        _ if fastener.reversible && mode.switches[fastener.head] == head::LEFT => f64::INFINITY,
        _ if fastener.reversible => -touching,
        depth::UNLOADING => deepest - z,
        _ if force == 0.0 => deepest - touching,
        _ => deepest - force / fastener.unloading - z,
    }
}

/// Margin for a fastener to stop moving back.
fn back(plan: &Plan, fastener: usize, mode: &Mode, w: &Workspace) -> f64 {
    let z = plan.depth(fastener, w);
    let fastener = &plan.fasteners[fastener];
    let [deepest, force] = [mode.memory[fastener.deepest], mode.memory[fastener.deepest + 1]];
    match mode.switches[fastener.depth] {
        depth::LOADING if fastener.reversible => z,
        depth::SEATED if fastener.reversible => z - fastener.length,
        depth::LOADING | depth::SEATED => w.speed(fastener.work),
        depth::UNLOADING => z - (deepest - force / fastener.unloading),
        _ => f64::INFINITY,
    }
}

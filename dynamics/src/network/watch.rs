//! Changes that do not switch the right-hand side: reversals of bodies and flows, and choking of flows. They are
//! logged, and a step ends where a trigger waits for one.

use super::assembly::{Action, BlockRef, Family, Word};
use super::mode::Mode;
use super::plan::{Pair, Plan};
use super::rates::Workspace;

/// Smallest speed of a body for a genuine reversal; slower reversals are the settling of a contact \[m/s\].
const REVERSAL_SPEED: f64 = 10e-3;

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Speed of a body.
    Turn { body: usize, pair: Pair },
    /// Pressure difference across a passage.
    Direction(usize),
    /// Flow of a passage relative to its choked flow.
    Choking(usize),
}

/// A logged change.
#[derive(Debug, Clone)]
pub(crate) struct Note {
    pub(crate) time: f64,
    pub(crate) word: Word,
    /// State at that time, for the log.
    pub(crate) state: Vec<f64>,
}

/// A change that switches a trigger.
#[derive(Debug, Clone, Copy)]
struct Awaited {
    /// Its quantity.
    index: usize,
    /// Direction of the change of sign; both if `None`.
    rising: Option<bool>,
    /// Switch of the trigger, and its state afterwards.
    switch: usize,
    state: bool,
}

/// Quantities whose sign changes are logged.
#[derive(Debug, Clone)]
pub(crate) struct Watch {
    list: Vec<Kind>,
    awaited: Vec<Awaited>,
    /// Heights at the last point.
    pub(crate) last: Vec<f64>,
    /// For each body, the largest speed since its last reversal, and the last reversal after slow motion, which counts
    /// if fast motion follows.
    swing: Vec<f64>,
    slow: Vec<Option<(f64, Vec<f64>)>>,
}

impl Watch {
    pub(crate) fn new(plan: &Plan) -> Self {
        let mut list: Vec<Kind> = Vec::new();
        for (body, described) in plan.bodies.iter().enumerate() {
            let pair = Pair {
                on: body,
                against: described.parent,
            };
            list.push(Kind::Turn { body, pair });
        }
        for (i, passage) in plan.passages.iter().enumerate().filter(|(_, passage)| !passage.shut) {
            list.push(Kind::Choking(i));
            if !passage.one_way {
                list.push(Kind::Direction(i));
            }
        }
        Self {
            last: vec![0.0; list.len()],
            awaited: awaited(plan, &list),
            list,
            swing: vec![0.0; plan.bodies.len()],
            slow: vec![None; plan.bodies.len()],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// Quantities that change their sign between two points such that a trigger switches.
    pub(crate) fn switching<'a>(
        &'a self,
        before: &'a [f64],
        after: &'a [f64],
        mode: &'a Mode,
    ) -> impl Iterator<Item = usize> + 'a {
        let switches = move |own: &&Awaited| {
            let [from, to] = [before, after].map(|heights| heights[own.index] > 0.0);
            from != to && own.rising.is_none_or(|rising| rising == to) && mode.is_on(own.switch) != own.state
        };
        self.awaited.iter().filter(switches).map(|own| own.index)
    }

    /// Heights of a state in the workspace.
    pub(crate) fn measure(&self, t: f64, plan: &Plan, mode: &Mode, w: &Workspace, heights: &mut [f64]) {
        for (i, height) in heights.iter_mut().enumerate() {
            *height = self.height(i, t, plan, mode, w);
        }
    }

    /// Height of one quantity.
    pub(crate) fn height(&self, i: usize, t: f64, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        match self.list[i] {
            Kind::Turn { pair, .. } => w.speed(pair),
            Kind::Direction(i) => w.pressure[plan.passages[i].from] - w.pressure[plan.passages[i].to],
            Kind::Choking(i) => {
                let passage = &plan.passages[i];
                if !passage.is_open(mode) {
                    return -1.0;
                }
                passage.choking(&plan.airs[passage.air], mode, &plan.ends(i, w), t)
            }
        }
    }

    /// Tracks the speeds of the bodies.
    pub(crate) fn settle(&mut self, heights: &[f64]) {
        for (swing, speed) in self.swing.iter_mut().zip(heights) {
            *swing = swing.max(speed.abs());
        }
        self.last.copy_from_slice(heights);
    }

    /// Processes a change of sign at a state; a reversal of a body counts only if the motion is fast before or after
    /// it.
    pub(crate) fn pass(&mut self, i: usize, at: (f64, Vec<f64>), rising: bool, plan: &Plan, mode: &Mode) -> Vec<Note> {
        let note = |(time, state), family, index, action| Note {
            time,
            word: Word {
                block: BlockRef { family, index },
                restriction: 0,
                action,
            },
            state,
        };
        match self.list[i] {
            Kind::Turn { body, .. } => {
                let turn = |at| note(at, Family::Body, body, Action::Reverses);
                let slow = std::mem::replace(&mut self.swing[body], 0.0) < REVERSAL_SPEED;
                match (slow, self.slow[body].take()) {
                    // Two successive slow reversals do not count.
                    (true, Some(_)) => Vec::new(),
                    (true, None) => {
                        self.slow[body] = Some(at);
                        Vec::new()
                    }
                    (false, earlier) => earlier.into_iter().chain([at]).map(turn).collect(),
                }
            }
            Kind::Direction(i) if plan.passages[i].is_open(mode) => {
                vec![note(at, Family::Passage, i, Action::Reverses)]
            }
            Kind::Direction(_) => Vec::new(),
            Kind::Choking(i) => {
                let action = if rising { Action::Choked } else { Action::Unchoked };
                vec![note(at, Family::Passage, i, action)]
            }
        }
    }
}

/// The changes for which triggers wait.
fn awaited(plan: &Plan, list: &[Kind]) -> Vec<Awaited> {
    let mut awaited = Vec::new();
    for (trigger, switch) in plan.assembly.triggers.iter().zip(&plan.triggers) {
        for (words, state) in [(&trigger.set, true), (&trigger.clear, false)] {
            for word in words {
                let is_of = |kind: &Kind| {
                    let (family, index) = match *kind {
                        Kind::Turn { body, .. } => (Family::Body, body),
                        Kind::Direction(passage) | Kind::Choking(passage) => (Family::Passage, passage),
                    };
                    let is_choking = matches!(word.action, Action::Choked | Action::Unchoked);
                    let is_change = is_choking || word.action == Action::Reverses;
                    is_change
                        && is_choking == matches!(kind, Kind::Choking(_))
                        && word.block == BlockRef { family, index }
                };
                let rising = match word.action {
                    Action::Choked => Some(true),
                    Action::Unchoked => Some(false),
                    _ => None,
                };
                awaited.extend(list.iter().position(is_of).map(|index| Awaited {
                    index,
                    rising,
                    switch: *switch,
                    state,
                }));
            }
        }
    }
    awaited
}

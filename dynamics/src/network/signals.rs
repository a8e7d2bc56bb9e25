//! Triggers, and the gates, motors and latches that follow them.

use super::assembly::{Action, BlockRef, Family, ForceLaw, Word};
use super::error::RunError;
use super::mode::Mode;
use super::plan::{AreaPlan, Plan};
use super::rates::Workspace;

/// Tolerance of a switching time \[s\].
const DUE: f64 = 1e-13;
/// Number of changes of one gate at one instant that counts as an endless loop.
const LOOP: usize = 8;

/// A block that follows a trigger.
#[derive(Debug, Clone)]
struct Follower {
    block: BlockRef,
    trigger: usize,
    inverted: bool,
    delay: f64,
    switch: usize,
    /// Time of the last change, and number of changes at that time.
    last: f64,
    count: usize,
}

/// A pending change.
#[derive(Debug, Clone, Copy)]
struct Pending {
    time: f64,
    follower: usize,
    on: bool,
}

/// Triggers over time.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    followers: Vec<Follower>,
    pending: Vec<Pending>,
    /// Schedules of all triggers: time, trigger, state; ordered by time.
    schedule: Vec<(f64, usize, bool)>,
    /// Number of schedule entries that have passed.
    over: usize,
    /// Times at which an imposed force or an area has a kink, in ascending order.
    corners: Vec<f64>,
}

impl Signals {
    /// The state at t = 0; sets the switches of triggers and of the blocks that follow them.
    pub(crate) fn new(plan: &Plan, mode: &mut Mode) -> Self {
        let assembly = &plan.assembly;
        for (trigger, switch) in assembly.triggers.iter().zip(&plan.triggers) {
            mode.switches[*switch] = u8::from(trigger.starts);
        }
        let mut followers = Vec::new();
        let mut pending = Vec::new();
        let mut follow = |family, index, trigger, switch| {
            followers.push(Follower {
                block: BlockRef { family, index },
                trigger,
                inverted: false,
                delay: 0.0,
                switch,
                last: f64::NEG_INFINITY,
                count: 0,
            });
        };
        for (i, motor) in assembly.motors.iter().enumerate() {
            follow(Family::Motor, i, motor.trigger, plan.motors[i].switch);
        }
        for (i, hold) in assembly.holds.iter().enumerate() {
            follow(Family::Hold, i, hold.trigger, plan.holds[i].switch);
        }
        for follower in &followers {
            mode.switches[follower.switch] = u8::from(assembly.triggers[follower.trigger].starts);
        }
        for (i, passage) in assembly.passages.iter().enumerate() {
            if let (Some(gate), Some(switch)) = (&passage.gate, plan.passages[i].gate) {
                let wanted = assembly.triggers[gate.trigger].starts != gate.inverted;
                let now = if gate.delay > 0.0 { gate.before } else { wanted };
                mode.switches[switch] = u8::from(now);
                if wanted != now {
                    pending.push(Pending {
                        time: gate.delay,
                        follower: followers.len(),
                        on: wanted,
                    });
                }
                followers.push(Follower {
                    block: BlockRef {
                        family: Family::Passage,
                        index: i,
                    },
                    trigger: gate.trigger,
                    inverted: gate.inverted,
                    delay: gate.delay,
                    switch,
                    last: f64::NEG_INFINITY,
                    count: 0,
                });
            }
        }
        let mut schedule: Vec<(f64, usize, bool)> = Vec::new();
        for (i, trigger) in assembly.triggers.iter().enumerate() {
            schedule.extend(trigger.schedule.iter().map(|(time, state)| (*time, i, *state)));
        }
        schedule.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut corners = corners(plan);
        corners.sort_by(f64::total_cmp);
        Self {
            followers,
            pending,
            schedule,
            over: 0,
            corners,
        }
    }

    /// Whether a switch changes by `t`.
    pub(crate) fn is_due(&self, t: f64) -> bool {
        let scheduled = self.schedule.get(self.over).is_some_and(|entry| t >= entry.0 - DUE);
        scheduled || self.pending.iter().any(|pending| t >= pending.time - DUE)
    }

    /// Next time after `t` at which a switch changes or a law has a kink.
    pub(crate) fn next(&self, t: f64) -> f64 {
        let scheduled = self.schedule.get(self.over).map_or(f64::INFINITY, |entry| entry.0);
        let pending = self.pending.iter().map(|p| p.time).fold(f64::INFINITY, f64::min);
        let corner = self.corners.iter().copied().find(|corner| *corner > t + DUE);
        scheduled.min(pending).min(corner.unwrap_or(f64::INFINITY))
    }

    /// Applies one change that is due at `t`, if any; `w` contains the state.
    ///
    /// # Errors
    /// [`RunError::Switching`] for gates that change endlessly.
    pub(crate) fn due(
        &mut self,
        plan: &Plan,
        t: f64,
        mode: &mut Mode,
        w: &Workspace,
    ) -> Result<Option<Word>, RunError> {
        loop {
            if let Some((time, trigger, state)) = self.schedule.get(self.over).copied()
                && t >= time - DUE
            {
                self.over += 1;
                match self.change(plan, t, mode, trigger, state) {
                    Some(word) => return Ok(Some(word)),
                    None => continue,
                }
            }
            let Some(place) = self.pending.iter().position(|p| t >= p.time - DUE) else {
                return Ok(None);
            };
            let Pending { follower, on, .. } = self.pending.remove(place);
            let follower = &mut self.followers[follower];
            if mode.is_on(follower.switch) == on {
                continue;
            }
            if t - follower.last > DUE {
                follower.count = 0;
            }
            follower.last = t;
            follower.count += 1;
            let block = follower.block;
            // Other followers of a trigger in a loop switch as often, but do not cause the loop.
            let is_heard = || {
                let mut words = plan
                    .assembly
                    .triggers
                    .iter()
                    .flat_map(|own| own.set.iter().chain(&own.clear));
                words.any(|own| own.block == block)
            };
            if follower.count > LOOP && is_heard() {
                return Err(RunError::Switching {
                    trigger: plan.assembly.triggers[follower.trigger].name.clone(),
                    gate: plan.assembly.name_of(block).to_owned(),
                    remedy: match block.family {
                        Family::Passage => "give open.delay",
                        _ => "let another word or a schedule switch the trigger: a motor or latch has no delay",
                    },
                    count: follower.count,
                    time: t,
                });
            }
            mode.switches[follower.switch] = u8::from(on);
            if block.family == Family::Hold && on {
                let hold = &plan.holds[block.index];
                mode.memory[hold.place] = w.travel(hold.pair);
            }
            let action = match (block.family, on) {
                (Family::Motor, true) => Action::Runs,
                (Family::Motor, false) => Action::Stops,
                (Family::Hold, true) => Action::Catches,
                (Family::Hold, false) => Action::Releases,
                (_, true) => Action::GateOpens,
                (_, false) => Action::GateShuts,
            };
            return Ok(Some(Word {
                block,
                restriction: 0,
                action,
            }));
        }
    }

    /// Passes a word to the triggers; returns the words of those that change.
    pub(crate) fn pass(&mut self, plan: &Plan, t: f64, mode: &mut Mode, word: Word) -> Vec<Word> {
        let mut words = Vec::new();
        for (i, trigger) in plan.assembly.triggers.iter().enumerate() {
            for (list, state) in [(&trigger.set, true), (&trigger.clear, false)] {
                if list.contains(&word) {
                    words.extend(self.change(plan, t, mode, i, state));
                }
            }
        }
        words
    }

    /// Switches a trigger; returns the word that it logs if its state changes.
    fn change(&mut self, plan: &Plan, t: f64, mode: &mut Mode, trigger: usize, state: bool) -> Option<Word> {
        let switch = plan.triggers[trigger];
        if mode.is_on(switch) == state {
            return None;
        }
        mode.switches[switch] = u8::from(state);
        let described = &plan.assembly.triggers[trigger];
        if described.clear.is_empty() && described.schedule.iter().all(|(_, on)| *on) {
            // The trigger remains set, so later changes that would set it again must not end a step of the integration.
            let first = self.over;
            let mut place = 0;
            self.schedule.retain(|(_, own, _)| {
                place += 1;
                place <= first || *own != trigger
            });
        }
        for (i, follower) in self.followers.iter().enumerate() {
            if follower.trigger == trigger {
                self.pending.push(Pending {
                    time: t + follower.delay,
                    follower: i,
                    on: state != follower.inverted,
                });
            }
        }
        self.pending.sort_by(|a, b| a.time.total_cmp(&b.time));
        Some(Word {
            block: BlockRef {
                family: Family::Trigger,
                index: trigger,
            },
            restriction: 0,
            action: if state { Action::SwitchesOn } else { Action::SwitchesOff },
        })
    }
}

/// Times of kinks in force tables and ramps.
fn corners(plan: &Plan) -> Vec<f64> {
    let mut corners = Vec::new();
    for force in &plan.forces {
        if let ForceLaw::Table(points) = &force.law {
            corners.extend(points.iter().map(|point| point[0]));
        }
    }
    for restriction in plan.passages.iter().flat_map(|passage| &passage.restrictions) {
        if let AreaPlan::Ramp { time, .. } = restriction.area {
            corners.push(time);
        }
    }
    corners
}

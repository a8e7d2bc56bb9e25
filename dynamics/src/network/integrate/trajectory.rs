//! Conditions, levels and changes on the trajectory of a step.

use super::{POINTS, Run};
use crate::network::assembly::Word;
use crate::network::error::RunError;
use crate::network::locate::locate;
use crate::network::record::{LogEntry, logged_state, restriction_name};

/// A step up to the first condition that becomes false, or the first change that switches a trigger.
pub(super) struct Stretch {
    pub(super) used: usize,
    /// Whether it ends before the step does.
    pub(super) is_cut: bool,
    /// Slot of the event that ends it.
    pub(super) event: Option<usize>,
}

/// Whether all values exceed their limits; without an early exit, which would prevent vector instructions.
fn exceed(values: &[f64], limits: &[f64]) -> bool {
    values
        .iter()
        .zip(limits)
        .fold(true, |all, (value, limit)| all & (value > limit))
}

/// Largest number of halvings of an interval when a positive margin is sought in it.
const HALVINGS: i32 = 12;

/// A time in the interval at which the margin exceeds its tolerance, and the margin at that time. The search halves the
/// interval towards its start and returns the first such time.
///
/// The margin of a slot is zero directly after an event of the slot. If a bounce is shorter than the interval, the
/// margin is positive inside the interval and negative again at its end.
fn rise<E>(
    start: f64,
    end: f64,
    tolerance: f64,
    margin: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<Option<(f64, f64)>, E> {
    for halvings in 1..=HALVINGS {
        let t = start + (end - start) * 0.5f64.powi(halvings);
        let height = margin(t)?;
        if height > tolerance {
            return Ok(Some((t, height)));
        }
    }
    Ok(None)
}

/// Whether heights are on the same sides of their levels.
fn have_equal_signs(a: &[f64], b: &[f64]) -> bool {
    a.iter()
        .zip(b)
        .fold(true, |all, (a, b)| all & ((*a > 0.0) == (*b > 0.0)))
}

impl Run<'_> {
    /// Logs a word at the current state and passes it to triggers and events.
    pub(super) fn announce_now(&mut self, word: Word) {
        self.plan.instant(&self.y, &self.mode, &mut self.w);
        let state = logged_state(self.plan, &self.w);
        self.announce(word, self.t, state);
    }

    /// Logs a word at a given time and state and passes it to triggers and events.
    pub(super) fn announce(&mut self, word: Word, time: f64, state: Vec<f64>) {
        let plan = self.plan;
        if self.recording {
            self.note(word, time, state.clone());
        }
        for word in self.signals.pass(plan, time, &mut self.mode, word) {
            if self.recording {
                self.note(word, time, state.clone());
            }
        }
    }

    /// Logs a word and passes it to the events.
    pub(super) fn note(&mut self, word: Word, time: f64, state: Vec<f64>) {
        let plan = self.plan;
        let place = self.log.partition_point(|entry| entry.time <= time);
        plan.observe(self.events.at_edges(), time, &self.y, &self.mode, &mut self.w);
        let entry = LogEntry {
            state,
            time,
            block: plan.assembly.name_of(word.block).to_owned(),
            restriction: restriction_name(plan, word),
            word: word.action.word(),
        };
        self.log.insert(place, entry);
        self.events.record_word(word, time, plan, &self.mode, &self.w);
    }

    /// The step from `from` to `to`, up to the first condition that becomes false or the first change that switches a
    /// trigger, stored in `points`.
    pub(super) fn stretch(
        &mut self,
        from: f64,
        to: f64,
        at: &mut impl FnMut(f64, &mut [f64]) -> Result<(), RunError>,
    ) -> Result<Stretch, RunError> {
        let (plan, slots, mode) = (self.plan, self.slots, &self.mode);
        for (k, (time, y)) in self.points.iter_mut().enumerate() {
            *time = if k + 1 == POINTS {
                to
            } else {
                from + (to - from) * (k + 1) as f64 / POINTS as f64
            };
            at(*time, y)?;
        }
        let mut left = from;
        let mut found: Option<(f64, Option<usize>)> = None;
        for k in 0..POINTS {
            let t = self.points[k].0;
            plan.observe(self.need, t, &self.points[k].1, mode, &mut self.w);
            self.fresh = true;
            slots.margins(plan, mode, &self.w, &mut self.right);
            self.events.measure(plan, mode, &self.w, &mut self.heights[k]);
            self.watch.measure(t, plan, mode, &self.w, &mut self.watched[k]);
            let watched = if k == 0 { &self.watch.last } else { &self.watched[k - 1] };
            for i in self.watch.switching(watched, &self.watched[k], mode) {
                let (watch, w, scratch) = (&self.watch, &mut self.w, &mut self.y);
                let height = |t: f64| {
                    at(t, scratch)?;
                    plan.instant(scratch, mode, w);
                    Ok(watch.height(i, t, plan, mode, w))
                };
                let time = locate(left, t, watched[i], self.watched[k][i], height)?;
                self.fresh = false;
                if found.is_none_or(|(earliest, _)| time < earliest) {
                    found = Some((time, None));
                }
            }
            if found.is_none() && exceed(&self.right, &slots.event_tolerances) {
                self.armed.fill(true);
                left = t;
                std::mem::swap(&mut self.margin, &mut self.right);
                continue;
            }
            for (slot, (before, after)) in self.margin.iter().zip(&self.right).enumerate() {
                if *after > slots.event_tolerances[slot] {
                    self.armed[slot] = true;
                } else if *after <= 0.0 {
                    let w = &mut self.w;
                    let scratch = &mut self.y;
                    let mut margin = |t: f64| {
                        at(t, scratch)?;
                        plan.observe(slots.need, t, scratch, mode, w);
                        Ok(slots.list[slot].margin(plan, mode, w))
                    };
                    let positive = if self.armed[slot] && *before > 0.0 {
                        Some((left, *before))
                    } else {
                        self.fresh = false;
                        rise(left, t, slots.event_tolerances[slot], &mut margin)?
                    };
                    let time = match positive {
                        Some((start, height)) => locate(start, t, height, *after, margin)?,
                        None if self.armed[slot] || before.min(*after) < 0.0 && *before <= 0.0 => left,
                        None => continue,
                    };
                    if found.is_none_or(|(earliest, _)| time < earliest) {
                        found = Some((time, Some(slot)));
                    }
                }
            }
            left = t;
            std::mem::swap(&mut self.margin, &mut self.right);
            if let Some((time, event)) = found {
                self.points[k].0 = time;
                at(time, &mut self.points[k].1)?;
                plan.observe(self.need, time, &self.points[k].1, mode, &mut self.w);
                self.fresh = true;
                self.events.measure(plan, mode, &self.w, &mut self.heights[k]);
                self.watch.measure(time, plan, mode, &self.w, &mut self.watched[k]);
                return Ok(Stretch {
                    used: k + 1,
                    is_cut: true,
                    event,
                });
            }
        }
        Ok(Stretch {
            used: POINTS,
            is_cut: false,
            event: None,
        })
    }

    /// Records where the trajectory from `from` through the points crosses the levels of events.
    pub(super) fn note_levels(
        &mut self,
        from: f64,
        used: usize,
        at: &mut impl FnMut(f64, &mut [f64]) -> Result<(), RunError>,
    ) -> Result<(), RunError> {
        let (plan, mode, need) = (self.plan, &self.mode, self.events.need);
        let admission = need.max(self.events.at_edges());
        let mut left = from;
        for k in 0..used {
            let t = self.points[k].0;
            let heights = &self.heights[k];
            if have_equal_signs(self.events.last(), heights) {
                self.events.settle(heights);
                left = t;
                continue;
            }
            let mut passed: Vec<(f64, usize)> = Vec::new();
            for (level, (before, after)) in self.events.last().iter().zip(heights).enumerate() {
                let (before, after) = (*before, *after);
                if (before > 0.0) == (after > 0.0) {
                    continue;
                }
                let (events, w, y) = (&self.events, &mut self.w, &mut self.y);
                let height = |t: f64| {
                    at(t, y)?;
                    plan.observe(need, t, y, mode, w);
                    Ok(events.height(level, plan, mode, w))
                };
                passed.push((locate(left, t, before, after, height)?, level));
            }
            passed.sort_by(|a, b| a.0.total_cmp(&b.0));
            self.fresh &= passed.is_empty();
            for (time, level) in passed {
                at(time, &mut self.y)?;
                plan.observe(admission, time, &self.y, mode, &mut self.w);
                self.events.pass(level, time, heights[level], plan, mode, &self.w);
            }
            self.events.settle(heights);
            left = t;
        }
        Ok(())
    }

    /// Logs changes that do not affect the mode, between `from` and the last point.
    pub(super) fn note_changes(
        &mut self,
        from: f64,
        used: usize,
        at: &mut impl FnMut(f64, &mut [f64]) -> Result<(), RunError>,
    ) -> Result<(), RunError> {
        let plan = self.plan;
        let mut left = from;
        for k in 0..used {
            let t = self.points[k].0;
            if have_equal_signs(&self.watch.last, &self.watched[k]) {
                self.watch.settle(&self.watched[k]);
                left = t;
                continue;
            }
            for i in 0..self.watch.len() {
                let (before, after) = (self.watch.last[i], self.watched[k][i]);
                if (before > 0.0) == (after > 0.0) {
                    continue;
                }
                self.fresh = false;
                let (watch, mode, w, y) = (&self.watch, &self.mode, &mut self.w, &mut self.y);
                let height = |t: f64| {
                    at(t, y)?;
                    plan.instant(y, mode, w);
                    Ok(watch.height(i, t, plan, mode, w))
                };
                let time = locate(left, t, before, after, height)?;
                at(time, &mut self.y)?;
                plan.instant(&self.y, &self.mode, &mut self.w);
                let here = (time, logged_state(plan, &self.w));
                for note in self.watch.pass(i, here, after > 0.0, plan, &self.mode) {
                    self.announce(note.word, note.time, note.state);
                }
            }
            self.watch.settle(&self.watched[k]);
            left = t;
        }
        Ok(())
    }
}

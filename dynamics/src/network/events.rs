//! Named events: edges of conditions on the accepted trajectory, and the resulting times.

use super::assembly::{Condition, Edge, OutcomeTest, Pick, Word};
use super::error::RunError;
use super::mode::Mode;
use super::plan::Plan;
use super::probe::{Level, Need};
use super::rates::Workspace;
use super::record::{ConditionChange, logged_state};

/// A change of an event's condition.
#[derive(Debug, Clone)]
struct Change {
    time: f64,
    rising: bool,
    /// Whether the further condition is satisfied at that point.
    admitted: bool,
    state: Vec<f64>,
}

/// A condition whose edges are recorded, and the events that it defines.
#[derive(Debug, Clone)]
struct Watched {
    /// Indices of comparisons that must all be satisfied.
    levels: Vec<usize>,
    satisfied: bool,
    events: Vec<usize>,
}

/// Edges of one event.
#[derive(Debug, Clone, Default)]
struct Trace {
    satisfied_at_start: bool,
    changes: Vec<Change>,
    /// Further condition at the edge.
    admits: Vec<Level>,
}

/// State of all events.
#[derive(Debug, Clone)]
pub(crate) struct Events {
    levels: Vec<Level>,
    /// Height above each level at the last point.
    heights: Vec<f64>,
    watched: Vec<Watched>,
    traces: Vec<Trace>,
    pub(crate) need: Need,
    /// How far a state must be evaluated for the further conditions.
    admission: Need,
    /// Whether an edge was recorded since the last check.
    changed: bool,
}

impl Events {
    pub(crate) fn new(plan: &Plan) -> Result<Self, RunError> {
        let mut events = Self {
            levels: Vec::new(),
            heights: Vec::new(),
            watched: Vec::new(),
            traces: Vec::new(),
            need: Need::Instant,
            admission: Need::Instant,
            changed: true,
        };
        let mut conditions: Vec<&Condition> = Vec::new();
        for (i, event) in plan.assembly.events.iter().enumerate() {
            let owner = format!("event \"{}\"", event.name);
            let mut trace = Trace::default();
            if let Some(condition) = &event.condition {
                trace.admits = Level::all(plan, &owner, condition)?;
                for level in &trace.admits {
                    events.admission = events.admission.max(level.need());
                }
            }
            events.traces.push(trace);
            let (Edge::Becomes(condition) | Edge::Is(condition)) = &event.edge else {
                continue;
            };
            if let Some(place) = conditions.iter().position(|other| *other == condition) {
                events.watched[place].events.push(i);
                continue;
            }
            conditions.push(condition);
            let mut levels = Vec::new();
            for level in Level::all(plan, &owner, condition)? {
                events.need = events.need.max(level.need());
                let place = events.levels.iter().position(|other| *other == level);
                levels.push(place.unwrap_or(events.levels.len()));
                if place.is_none() {
                    events.levels.push(level);
                }
            }
            events.watched.push(Watched {
                levels,
                satisfied: false,
                events: vec![i],
            });
        }
        Ok(events)
    }

    /// Number of levels.
    pub(crate) fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Computes the heights of a state, which must be evaluated as far as necessary.
    pub(crate) fn measure(&self, plan: &Plan, mode: &Mode, w: &Workspace, heights: &mut [f64]) {
        for (level, height) in self.levels.iter().zip(heights) {
            *height = level.height(plan, mode, w);
        }
    }

    /// Height above one level.
    pub(crate) fn height(&self, level: usize, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        self.levels[level].height(plan, mode, w)
    }

    /// Heights at the last point.
    pub(crate) fn last(&self) -> &[f64] {
        &self.heights
    }

    /// Sets the initial heights, those of the state at t = 0.
    pub(crate) fn begin(&mut self, heights: Vec<f64>) {
        self.heights = heights;
        for watched in &mut self.watched {
            watched.satisfied = all_satisfied(&self.levels, &watched.levels, &self.heights);
            for event in &watched.events {
                self.traces[*event].satisfied_at_start = watched.satisfied;
            }
        }
    }

    /// How far a state must be evaluated when a condition changes.
    pub(crate) fn at_edges(&self) -> Need {
        self.admission
    }

    /// Records the crossing of one level to a height with the new sign; the workspace contains the state there.
    pub(crate) fn pass(&mut self, level: usize, time: f64, height: f64, plan: &Plan, mode: &Mode, w: &Workspace) {
        self.heights[level] = height;
        for watched in self
            .watched
            .iter_mut()
            .filter(|watched| watched.levels.contains(&level))
        {
            let satisfied = all_satisfied(&self.levels, &watched.levels, &self.heights);
            if satisfied == watched.satisfied {
                continue;
            }
            watched.satisfied = satisfied;
            for event in &watched.events {
                let trace = &mut self.traces[*event];
                let admitted = trace.admits.iter().all(|l| l.is_satisfied(l.height(plan, mode, w)));
                trace.changes.push(Change {
                    time,
                    rising: satisfied,
                    admitted,
                    state: logged_state(plan, w),
                });
                self.changed = true;
            }
        }
    }

    /// Sets the heights at the end of a step.
    pub(crate) fn settle(&mut self, heights: &[f64]) {
        self.heights.copy_from_slice(heights);
    }

    /// Processes a word logged by a block; the workspace contains the state.
    pub(crate) fn record_word(&mut self, word: Word, time: f64, plan: &Plan, mode: &Mode, w: &Workspace) {
        for (event, trace) in plan.assembly.events.iter().zip(&mut self.traces) {
            if event.edge == Edge::Logged(word) {
                let admitted = trace.admits.iter().all(|l| l.is_satisfied(l.height(plan, mode, w)));
                trace.changes.push(Change {
                    time,
                    rising: true,
                    admitted,
                    state: logged_state(plan, w),
                });
                self.changed = true;
            }
        }
    }

    /// Whether an edge was recorded since the last call.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Times of all events, as far as known at `now`.
    pub(crate) fn times(&self, plan: &Plan, now: f64) -> Vec<Option<f64>> {
        let mut known = vec![None; self.traces.len()];
        (0..self.traces.len())
            .map(|i| self.time(plan, i, now, &mut known, 0))
            .collect()
    }

    /// Time of one event, as far as known at `now`.
    pub(crate) fn time_of(&self, plan: &Plan, event: usize, now: f64) -> Option<f64> {
        self.time(plan, event, now, &mut vec![None; self.traces.len()], 0)
    }

    fn time(&self, plan: &Plan, i: usize, now: f64, known: &mut [Option<Option<f64>>], depth: usize) -> Option<f64> {
        if let Some(known) = known[i] {
            return known;
        }
        // Events that wait for each other in a cycle never occur.
        if depth > self.traces.len() {
            return None;
        }
        let mut other = |event: usize| self.time(plan, event, now, known, depth + 1);
        let event = plan.assembly.events.get(i)?;
        let after = event.after.map(&mut other);
        let before = event.before.map(&mut other);
        let until = event.until.and_then(&mut other);
        let found = match (&event.edge, after, before) {
            (_, Some(None), _) => None,
            // The last edge before an event is only known once that event has occurred.
            (_, _, Some(None)) if event.pick == Pick::Last => None,
            (Edge::At(time), ..) => Some(*time).filter(|time| *time <= now),
            _ => {
                let start = after.flatten().map_or(f64::NEG_INFINITY, |t| t + event.delay);
                let before = before.flatten().unwrap_or(f64::INFINITY);
                self.search(plan, i, [start, before], [until.unwrap_or(f64::INFINITY), now])
            }
        };
        known[i] = Some(found);
        found
    }

    /// The edge of an event from `start` onwards that precedes `before` and `until`.
    fn search(&self, plan: &Plan, i: usize, [start, before]: [f64; 2], [until, now]: [f64; 2]) -> Option<f64> {
        let event = &plan.assembly.events[i];
        let trace = &self.traces[i];
        let end = until.min(now);
        let first = trace.changes.partition_point(|change| change.time <= start);
        let at_once = matches!(event.edge, Edge::Is(_)) && start <= now && {
            let last = first.checked_sub(1).map(|last| &trace.changes[last]);
            last.map_or(trace.satisfied_at_start, |last| last.rising)
        };
        let from = match event.edge {
            Edge::Is(_) => first,
            _ => trace.changes.partition_point(|change| change.time < start),
        };
        let begins = at_once.then_some((start.max(0.0), first));
        let rising = trace.changes[from..]
            .iter()
            .enumerate()
            .filter(|(_, c)| c.rising && c.admitted);
        let rising = rising.map(|(k, c)| (c.time, from + k + 1));
        let fits = |(time, next): &(f64, usize)| {
            let over = trace.changes.get(*next..).into_iter().flatten().find(|c| !c.rising);
            let lasts = over.map_or(end, |c| c.time) - time >= event.lasting;
            *time < before
                && *time <= end
                && (until == f64::INFINITY || *time < until)
                && (event.lasting == 0.0 || lasts)
        };
        let mut candidates = begins.into_iter().chain(rising).filter(fits);
        let found = match event.pick {
            Pick::First => candidates.next(),
            Pick::Last => candidates.next_back(),
        };
        found.map(|(time, _)| time)
    }

    /// Changes of the conditions of all events; those of words that blocks log are in the log.
    pub(crate) fn into_changes(self, plan: &Plan) -> Vec<ConditionChange> {
        let events = plan.assembly.events.iter().zip(self.traces);
        let of_conditions = events.filter(|(event, _)| matches!(event.edge, Edge::Becomes(_) | Edge::Is(_)));
        of_conditions
            .flat_map(|(event, trace)| {
                trace.changes.into_iter().map(|change| ConditionChange {
                    event: event.name.clone(),
                    time: change.time,
                    satisfied: change.rising,
                    state: change.state,
                })
            })
            .collect()
    }

    /// The first outcome whose test is satisfied; the workspace contains the final state.
    pub(crate) fn outcome(
        plan: &Plan,
        times: &[Option<f64>],
        mode: &Mode,
        w: &Workspace,
    ) -> Result<Option<String>, RunError> {
        for outcome in &plan.assembly.outcomes {
            let time = |i: usize| times.get(i).copied().flatten();
            let holds = match &outcome.test {
                OutcomeTest::Happened(i) => time(*i).is_some(),
                OutcomeTest::Missing(i) => time(*i).is_none(),
                OutcomeTest::Before(a, b) => time(*a).is_some_and(|a| time(*b).is_none_or(|b| a < b)),
                OutcomeTest::AtEnd(condition) => {
                    let levels = Level::all(plan, &format!("outcome \"{}\"", outcome.name), condition)?;
                    levels.iter().all(|l| l.is_satisfied(l.height(plan, mode, w)))
                }
            };
            if holds {
                return Ok(Some(outcome.name.clone()));
            }
        }
        Ok(None)
    }
}

fn all_satisfied(levels: &[Level], of: &[usize], heights: &[f64]) -> bool {
    of.iter().all(|i| levels[*i].is_satisfied(heights[*i]))
}

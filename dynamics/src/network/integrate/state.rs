//! Changes of an accepted state: balances, limits of the model, the end of the record, events of the mode.

use super::Run;
use crate::network::assembly::{Action, Family};
use crate::network::error::RunError;
use crate::network::plan::ContactPlan;
use crate::network::record::Strike;

/// Number of changes of one block within [`CHATTER_WINDOW`] that counts as chatter; a contact at 200 kHz makes 400.
const CHATTER_CHANGES: usize = 2000;
const CHATTER_WINDOW: f64 = 1e-3;

/// Fraction of the dead volume below which a volume counts as vanished.
const VANISHED: f64 = 1e-3;

/// Permitted compression of a spring beyond its law due to the overlap of its stops, as a fraction of the limit.
const SPRING_SLACK: f64 = 1e-9;

impl Run<'_> {
    /// Updates the quantities that depend on an accepted state: balances, peaks, limits of the model.
    pub(super) fn accept(&mut self) -> Result<(), RunError> {
        if !self.fresh {
            self.plan.instant(&self.y, &self.mode, &mut self.w);
        }
        self.remember();
        self.audit.follow(self.plan, &self.y, &self.mode, &self.w);
        self.guard()?;
        // At an event that the record must not pass, a contact may already be closed.
        if !(self.cut && self.t >= self.end) {
            self.plan.contact_forces(&self.mode, &mut self.w);
            self.follow_peaks();
        }
        Ok(())
    }

    pub(super) fn follow_peaks(&mut self) {
        let contacts = self.w.contact.iter().map(|contact| contact.force);
        let forces = contacts.chain(self.w.fastener.iter().map(|fastener| fastener[0]));
        for (peak, force) in self.peaks.iter_mut().zip(forces) {
            peak.force = peak.force.max(force);
        }
    }

    /// Ends the run where the model becomes invalid.
    pub(super) fn guard(&self) -> Result<(), RunError> {
        let plan = self.plan;
        for (i, volume) in plan.volumes.iter().enumerate() {
            let (size, mass) = (self.w.volume[i], self.w.mass[i]);
            // A polytropic law does not relate the gas to its mass.
            let massless = mass <= 0.0 && plan.temperature.is_none();
            if size > VANISHED * volume.dead && !massless && self.y[plan.energy() + i] > 0.0 {
                continue;
            }
            let face = plan.faces.iter().find(|face| face.volume == Some(i));
            let body = face.map_or_else(
                || "no body".to_owned(),
                |face| {
                    let name = &plan.assembly.bodies[face.pair.on].name;
                    format!("\"{name}\" at {:.3} mm", 1e3 * self.w.travel(face.pair))
                },
            );
            return Err(RunError::Collapse {
                volume: plan.assembly.volumes[i].name.clone(),
                body,
                size,
                mass,
                time: self.t,
            });
        }
        for (i, spring) in plan.springs.iter().enumerate() {
            let Some(limit) = spring.limit else { continue };
            let compression = spring.compression(self.w.travel(spring.pair));
            let stops = plan.contacts.iter().filter(|c| c.pair == spring.pair);
            let overlap = |c: &ContactPlan| c.overlap(self.w.travel(c.pair), 0.0).0.max(0.0);
            if compression - stops.map(overlap).fold(0.0, f64::max) > limit * (1.0 + SPRING_SLACK) {
                return Err(RunError::SpringLimit {
                    spring: plan.assembly.springs[i].name.clone(),
                    compression,
                    limit,
                    place: format!("at {:.3} ms", 1e3 * self.t),
                });
            }
        }
        Ok(())
    }

    /// Sets the end of the record from the events up to `now`, but not before the current step.
    pub(super) fn schedule(&mut self, now: f64) {
        let plan = self.plan;
        let Some(finish) = &plan.assembly.finish else { return };
        if self.events.take_changed() {
            if let Some(last) = finish.never_past
                && let Some(time) = self.events.time_of(plan, last, now)
            {
                self.end = self.end.min(time.max(self.t));
                self.cut = true;
            }
            let after = plan.assembly.events.get(finish.event).and_then(|event| event.after);
            self.finish_after = match after {
                Some(after) => self.events.time_of(plan, after, now),
                None => Some(0.0),
            };
        }
        if self.finish_after.is_some()
            && let Some(time) = self.events.time_of(plan, finish.event, now)
        {
            self.end = self.end.min((time + finish.tail).max(self.t));
        }
    }

    /// Applies the event of a slot at the current time.
    pub(super) fn cross(&mut self, slot: usize) -> Result<(), RunError> {
        let plan = self.plan;
        let described = &self.slots.list[slot];
        let (window, count) = &mut self.chatter[slot];
        if self.t - *window > CHATTER_WINDOW {
            (*window, *count) = (self.t, 0);
        }
        *count += 1;
        if *count > CHATTER_CHANGES {
            return Err(RunError::Chatter {
                block: described.name(plan).to_owned(),
                count: *count,
                window: CHATTER_WINDOW,
                time: self.t,
            });
        }
        let before = (self.mode.clone(), self.y.clone());
        plan.instant(&self.y, &self.mode, &mut self.w);
        let word = described.cross(plan, &mut self.mode, &mut self.y, &self.w);
        if self.recording {
            self.audit.cross(
                plan,
                described.name(plan),
                (&before.0, &before.1),
                (&self.mode, &self.y),
                &mut self.w,
            );
            self.work.events += 1;
        }
        if let Some(word) = word {
            if word.action == Action::Struck {
                self.check_fit(word.block.index)?;
            }
            if self.recording && word.action == Action::Struck && word.block.family == Family::Fastener {
                let driver = 2 * plan.fasteners[word.block.index].stroke.on + 1;
                self.strikes.push(Strike {
                    fastener: plan.assembly.fasteners[word.block.index].name.clone(),
                    time: self.t,
                    before: before.1[driver],
                    after: self.y[driver],
                });
            }
            self.announce_now(word);
        }
        plan.observe(self.slots.need, self.t, &self.y, &self.mode, &mut self.w);
        self.slots.margins(plan, &self.mode, &self.w, &mut self.right);
        for (other, armed) in self.armed.iter_mut().enumerate() {
            *armed = self.right[other] > self.slots.event_tolerances[other] || (other != slot && *armed);
        }
        Ok(())
    }

    /// Rejects an impact speed outside the data of a fitted law.
    pub(super) fn check_fit(&self, fastener: usize) -> Result<(), RunError> {
        let plan = &self.plan.fasteners[fastener];
        let Some(law) = plan.law.fitted() else { return Ok(()) };
        let ([lowest, highest], speed) = (law.impacts(), self.mode.memory[plan.impact_speed]);
        if (lowest..=highest).contains(&speed) {
            return Ok(());
        }
        Err(RunError::BeyondFit {
            fastener: self.plan.assembly.fasteners[fastener].name.clone(),
            speed,
            lowest,
            highest,
        })
    }
}

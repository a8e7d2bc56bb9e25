//! Results of a run: named channels on a uniform grid, events, log, ledger and checks.

use std::collections::HashMap;

use nailnoise_quantities::Check;
use serde::Serialize;

use super::assembly::{Family, Word};
use super::plan::Plan;
use super::rates::Workspace;
use super::recorder::Recorder;

/// History of a quantity at the sampling times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// `block.quantity`, or the name of a sensor.
    pub name: String,
    /// Name of its column in files; empty if it has none, because another channel has this name.
    pub column: String,
    /// SI unit.
    pub unit: String,
    /// Values at multiples of the sample interval.
    pub values: Vec<f64>,
}

/// Time of a named event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventTime {
    /// Name.
    pub name: String,
    /// Description; empty if there is none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Time \[s\]; none if it did not happen.
    pub time: Option<f64>,
}

/// A change of a block.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogEntry {
    /// Time \[s\].
    pub time: f64,
    /// Name of the block.
    pub block: String,
    /// Name of the restriction of a series; empty elsewhere.
    pub restriction: String,
    /// What happened.
    pub word: &'static str,
    /// State there, in the order of [`Record::state_columns`].
    pub state: Vec<f64>,
}

/// A change of an event's condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionChange {
    /// Name of the event.
    pub event: String,
    /// Time \[s\].
    pub time: f64,
    /// Whether the condition is satisfied from then on.
    pub satisfied: bool,
    /// State there, in the order of [`Record::state_columns`].
    pub state: Vec<f64>,
}

/// Name and SI unit of a quantity of a logged state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateColumn {
    /// `block.quantity`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
}

/// Flow through an opening to the atmosphere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlowHistory {
    /// Name of the opening.
    pub name: String,
    /// Outward mass flow from the tool \[kg/s\].
    pub mass_flow: Vec<f64>,
    /// Pressure upstream of the restriction \[Pa\].
    pub pressure: Vec<f64>,
    /// Pressure downstream of it \[Pa\].
    pub back_pressure: Vec<f64>,
    /// Temperature of the gas upstream of the flow \[K\].
    pub temperature: Vec<f64>,
    /// Whether the restriction is choked.
    pub choked: Vec<bool>,
}

/// Force on a named surface of a body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadHistory {
    /// Name of the body.
    pub body: String,
    /// Name of the surface.
    pub surface: String,
    /// Force, down \[N\].
    pub force: Vec<f64>,
}

/// Pressure on a wall that leaves no net force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressureHistory {
    /// Name of the body.
    pub body: String,
    /// Name of the surface.
    pub surface: String,
    /// Pressure, above the divide if there is one \[Pa\].
    pub pressure: Vec<f64>,
    /// Pressure below the divide \[Pa\]; empty without one.
    pub below: Vec<f64>,
    /// Position of the divide \[m\]; empty without one.
    pub divide: Vec<f64>,
}

/// An integral over the run, or an energy lost at events.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LedgerEntry {
    /// Its name: `mass.PASSAGE`, `enthalpy.PASSAGE`, `heat`, `work.BODY`, `dashpot.BLOCK`, `lost.BLOCK`, ...
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value at the end.
    pub value: f64,
}

/// Largest force of a contact or resistance of a fastener, over all steps and samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Peak {
    /// Name of the block.
    pub block: String,
    /// Force \[N\].
    pub force: f64,
}

/// The impact of a driver on a fastener.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Strike {
    /// Name of the fastener.
    pub fastener: String,
    /// Time \[s\].
    pub time: f64,
    /// Velocity of the driver before the impact \[m/s\].
    pub before: f64,
    /// Velocity of the driver after the impact \[m/s\].
    pub after: f64,
}

/// Work counters of the integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Effort {
    /// Accepted steps.
    pub steps: usize,
    /// Steps rejected for their error.
    pub rejected: usize,
    /// Failures of Newton's method.
    pub newton_failures: usize,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Right-hand sides.
    pub evaluations: usize,
    /// Jacobians.
    pub jacobians: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of the mode.
    pub events: usize,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// Sampling interval \[s\]; none if nothing was sampled.
    pub interval: Option<f64>,
    /// End of the run \[s\].
    pub end: f64,
    /// Histories.
    pub channels: Vec<Channel>,
    /// Times of the named events, in the order of the assembly.
    pub events: Vec<EventTime>,
    /// Changes of blocks in chronological order.
    pub log: Vec<LogEntry>,
    /// Changes of the events' conditions, event by event in chronological order.
    pub condition_changes: Vec<ConditionChange>,
    /// Quantities of the logged states: position and velocity of each body, pressure of each volume, depth
    /// of each fastener's tip.
    pub state_columns: Vec<StateColumn>,
    /// Name of the outcome whose test is satisfied, if any.
    pub outcome: Option<String>,
    /// Flows through the openings that make noise.
    pub openings: Vec<FlowHistory>,
    /// Forces on surfaces.
    pub loads: Vec<LoadHistory>,
    /// Pressures on surfaces.
    pub pressures: Vec<PressureHistory>,
    /// Integrals.
    pub ledger: Vec<LedgerEntry>,
    /// Peaks of contact and fastener forces.
    pub peaks: Vec<Peak>,
    /// Impacts on fasteners.
    pub strikes: Vec<Strike>,
    /// Conservation checks of the run.
    pub checks: Vec<Check>,
    /// Work of the integration.
    pub work: Effort,
    #[serde(skip)]
    index: HashMap<String, usize>,
}

impl Record {
    /// History of a quantity by its name, `piston.travel`.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.index.get(name).map(|i| &self.channels[*i].values[..])
    }

    /// History of a quantity by its name; empty for a block that the assembly switches off or does not have.
    pub fn history(&self, name: &str) -> &[f64] {
        self.get(name).unwrap_or_default()
    }

    /// Adds a channel that is zero, unless the record has one of this name.
    pub(crate) fn add_zero(&mut self, name: &str, column: &str, unit: &str) {
        if !self.index.contains_key(name) {
            self.index.insert(name.to_owned(), self.channels.len());
            self.channels.push(Channel {
                name: name.to_owned(),
                column: column.to_owned(),
                unit: unit.to_owned(),
                values: vec![0.0; self.len()],
            });
        }
    }

    /// Puts the channels in an order; those that it does not contain follow.
    pub(crate) fn arrange(&mut self, order: &[&str]) {
        let place = |channel: &Channel| order.iter().position(|name| *name == channel.name);
        self.channels
            .sort_by_cached_key(|channel| place(channel).unwrap_or(order.len()));
        self.index = index_of(&self.channels);
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.values.len())
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time of sample `index` \[s\].
    pub fn time(&self, index: usize) -> f64 {
        index as f64 * self.interval.unwrap_or_default()
    }

    /// Flow through the opening with this name.
    pub fn opening(&self, name: &str) -> Option<&FlowHistory> {
        self.openings.iter().find(|opening| opening.name == name)
    }

    /// Time of an event by its name; none if it did not happen or is not defined.
    pub fn event(&self, name: &str) -> Option<f64> {
        self.events
            .iter()
            .find(|event| event.name == name)
            .and_then(|event| event.time)
    }

    /// An integral by its name.
    pub fn integral(&self, name: &str) -> Option<f64> {
        self.ledger
            .iter()
            .find(|entry| entry.name == name)
            .map(|entry| entry.value)
    }

    /// Largest force of a contact or a fastener \[N\].
    pub fn peak(&self, block: &str) -> Option<f64> {
        self.peaks
            .iter()
            .find(|peak| peak.block == block)
            .map(|peak| peak.force)
    }

    /// Whether mass, energy and momentum are conserved.
    pub fn is_certified(&self) -> bool {
        self.checks.iter().all(|check| check.ok)
    }

    /// A record from its parts.
    pub(crate) fn new(parts: Parts, mut recorder: Recorder) -> Self {
        recorder.flush();
        let Recorder {
            interval,
            mut histories,
            columns,
            openings,
            loads,
            pressures,
            ..
        } = recorder;
        // Histories shared by several results are copied, others are moved.
        let mut uses = vec![0usize; histories.len()];
        let surfaces = || loads.iter().chain(&pressures);
        let of_openings = openings.iter().flat_map(|opening| {
            [
                opening.mass_flow,
                opening.pressure,
                opening.back_pressure,
                opening.temperature,
                opening.choked,
            ]
        });
        let places = columns.iter().map(|column| column.place).chain(of_openings);
        let divided = surfaces().filter_map(|surface| surface.divided).flatten();
        for place in places.chain(surfaces().map(|surface| surface.place)).chain(divided) {
            uses[place] += 1;
        }
        let mut of = |place: usize| {
            uses[place] -= 1;
            if uses[place] == 0 {
                std::mem::take(&mut histories[place])
            } else {
                histories[place].clone()
            }
        };
        let mut channels = Vec::with_capacity(columns.len());
        for column in columns {
            channels.push(Channel {
                name: column.name,
                column: column.column,
                unit: column.unit,
                values: of(column.place),
            });
        }
        let mut flows = Vec::with_capacity(openings.len());
        for opening in openings {
            flows.push(FlowHistory {
                name: opening.name,
                mass_flow: of(opening.mass_flow),
                pressure: of(opening.pressure),
                back_pressure: of(opening.back_pressure),
                temperature: of(opening.temperature),
                choked: of(opening.choked).into_iter().map(|choked| choked != 0.0).collect(),
            });
        }
        let mut forces = Vec::with_capacity(loads.len());
        for load in loads {
            forces.push(LoadHistory {
                body: load.body,
                surface: load.surface,
                force: of(load.place),
            });
        }
        let mut walls = Vec::with_capacity(pressures.len());
        for surface in pressures {
            let [below, divide] = match surface.divided {
                Some(places) => places.map(&mut of),
                None => [Vec::new(), Vec::new()],
            };
            walls.push(PressureHistory {
                body: surface.body,
                surface: surface.surface,
                pressure: of(surface.place),
                below,
                divide,
            });
        }
        let Parts {
            end,
            events,
            log,
            condition_changes,
            state_columns,
            outcome,
            ledger,
            peaks,
            strikes,
            checks,
            work,
        } = parts;
        Self {
            interval,
            end,
            index: index_of(&channels),
            openings: flows,
            loads: forces,
            pressures: walls,
            channels,
            events,
            log,
            condition_changes,
            state_columns,
            outcome,
            ledger,
            peaks,
            strikes,
            checks,
            work,
        }
    }
}

/// Contents of a record other than histories.
pub(crate) struct Parts {
    pub(crate) end: f64,
    pub(crate) events: Vec<EventTime>,
    pub(crate) log: Vec<LogEntry>,
    pub(crate) condition_changes: Vec<ConditionChange>,
    pub(crate) state_columns: Vec<StateColumn>,
    pub(crate) outcome: Option<String>,
    pub(crate) ledger: Vec<LedgerEntry>,
    pub(crate) peaks: Vec<Peak>,
    pub(crate) strikes: Vec<Strike>,
    pub(crate) checks: Vec<Check>,
    pub(crate) work: Effort,
}

/// Quantities of the logged states.
pub(crate) fn state_columns(plan: &Plan) -> Vec<StateColumn> {
    let column = |block: &str, quantity: &str, unit| StateColumn {
        name: format!("{block}.{quantity}"),
        unit,
    };
    let bodies = plan.assembly.bodies.iter();
    let motions = bodies.flat_map(|own| [column(&own.name, "position", "m"), column(&own.name, "velocity", "m/s")]);
    let volumes = plan.assembly.volumes.iter();
    let fasteners = plan.assembly.fasteners.iter();
    motions
        .chain(volumes.map(|own| column(&own.name, "pressure", "Pa")))
        .chain(fasteners.map(|own| column(&own.name, "tip", "m")))
        .collect()
}

/// A state for the log; the workspace contains its instant.
pub(crate) fn logged_state(plan: &Plan, w: &Workspace) -> Vec<f64> {
    let motions = (0..plan.bodies.len()).flat_map(|body| [w.position[body], w.velocity[body]]);
    let tips = (0..plan.fasteners.len()).map(|fastener| plan.depth(fastener, w));
    let pressures = w.pressure[..plan.volumes.len()].iter().copied();
    motions.chain(pressures).chain(tips).collect()
}

/// Names of the blocks whose peaks are tracked.
pub(crate) fn peaked(plan: &Plan) -> Vec<Peak> {
    let a = &plan.assembly;
    let contacts = a.contacts.iter().map(|contact| &contact.name);
    contacts
        .chain(a.fasteners.iter().map(|fastener| &fastener.name))
        .map(|block| Peak {
            block: block.clone(),
            force: 0.0,
        })
        .collect()
}

/// Name of the restriction that logs a word; empty if the passage itself or another block logs it.
pub(crate) fn restriction_name(plan: &Plan, word: Word) -> String {
    if word.block.family != Family::Passage || !word.action.is_of_restriction() {
        return String::new();
    }
    let passage = plan.assembly.passages.get(word.block.index);
    let found = passage.and_then(|passage| passage.restrictions.get(word.restriction));
    found.map_or_else(String::new, |restriction| restriction.name.clone())
}

/// Places of the channels by name.
fn index_of(channels: &[Channel]) -> HashMap<String, usize> {
    let names = channels.iter().map(|channel| channel.name.clone());
    names.zip(0..).collect()
}

//! The shot: the results of a cycle that sources, bodies and results use.

use std::collections::BTreeMap;

use nailnoise_dynamics::network::{EventTime, LoadHistory, PressureHistory, Record};
use nailnoise_dynamics::{CycleRecord, NailerFigures, Summary};
use nailnoise_quantities::Check;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

/// The body that is the housing of a tool.
pub(crate) const TOOL: &str = "tool";
/// Wall of the cylinder, which the piston divides.
pub const BORE: &str = "bore";
/// Wall of the return volume.
pub const RETURN_WALL: &str = "return";

/// A cycle in the form used by the chain.
///
/// Every history has [`len`](Self::len) samples at t = 0, dt, 2 dt, ... Positions, velocities and forces point down,
/// towards the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotRecord {
    /// dt, interval of the samples \[s\].
    pub sample_interval: f64,
    /// Pressure of the atmosphere \[Pa\].
    pub ambient_pressure: f64,
    /// Name of the outcome; `unnamed` if no outcome of an assembly applies.
    pub outcome: String,
    /// Times of the named events.
    pub events: Vec<EventTime>,
    /// Figures of the shot.
    pub figures: SummaryFigures,
    /// Motion of the tool's housing; `None` for a tool without one.
    pub tool: Option<Body>,
    /// Means of stiff contact forces around each sample, minus the sampled forces, on surfaces of the housing.
    pub impulse_corrections: Vec<LoadHistory>,
    /// Motion of the workpiece and the forces on it; `None` for a tool without one.
    pub workpiece: Option<OnWorkpiece>,
    /// Checks of the cycle, each with its limit.
    pub checks: Vec<Check>,
    /// All histories, and the flows through the openings to the atmosphere that make noise.
    pub record: Box<Record>,
    /// The shot in terms of the nailer, for the tool described by keys.
    pub nailer: Option<Box<NailerFigures>>,
}

/// A shot of the tool described by keys.
#[derive(Debug, Clone, Copy)]
pub struct NailerShot<'a> {
    /// Its histories.
    pub record: &'a Record,
    /// The shot in terms of the nailer.
    pub figures: &'a NailerFigures,
}

impl<'a> From<&'a CycleRecord> for NailerShot<'a> {
    fn from(cycle: &'a CycleRecord) -> Self {
        Self {
            record: &cycle.record,
            figures: &cycle.figures,
        }
    }
}

/// Motion of one body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Body {
    /// y \[m\].
    pub position: Vec<f64>,
    /// v \[m/s\].
    pub velocity: Vec<f64>,
    /// dv/dt \[m/s2\]; excludes the jump at an impact.
    pub acceleration: Vec<f64>,
}

/// Motion of the workpiece and the forces of the tool on it.
#[derive(Debug, Clone, PartialEq)]
pub struct OnWorkpiece {
    /// Motion of the lumped workpiece.
    pub motion: Body,
    /// Force at the nose, guard included \[N\].
    pub seat: Vec<f64>,
    /// Force of the nose without the guard \[N\].
    pub nose: Vec<f64>,
    /// Force of the fastener \[N\].
    pub fastener: Vec<f64>,
    /// Deepest depth of the fastener's tip so far \[m\].
    pub deepest: Vec<f64>,
    /// Speed of the fastener into the workpiece \[m/s\]; `None` if its resistance does not depend on speed.
    pub fastener_speed: Option<Vec<f64>>,
}

impl ShotRecord {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.record.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.record.is_empty()
    }

    /// Time of sample `index` \[s\].
    pub fn time(&self, index: usize) -> f64 {
        index as f64 * self.sample_interval
    }

    /// Time of an event \[s\]; `None` if it does not occur.
    pub fn event(&self, name: &str) -> Option<f64> {
        self.events.iter().find(|event| event.name == name)?.time
    }

    /// The shot of the tool described by keys; `None` for an assembly.
    pub fn of_nailer(&self) -> Option<NailerShot<'_>> {
        self.nailer.as_deref().map(|figures| NailerShot {
            record: &self.record,
            figures,
        })
    }

    /// Absolute pressure of a volume of the cycle \[Pa\]; `None` if it has none of this name.
    pub fn volume_pressure(&self, name: &str) -> Option<&[f64]> {
        self.record.get(&format!("{name}.pressure"))
    }

    /// Forces on surfaces of the housing.
    pub fn loads(&self) -> impl Iterator<Item = &LoadHistory> {
        self.record.loads.iter().filter(|own| own.body == TOOL)
    }

    /// Absolute pressures on walls of the housing that leave no net force.
    pub fn pressures(&self) -> impl Iterator<Item = &PressureHistory> {
        self.record.pressures.iter().filter(|own| own.body == TOOL)
    }

    /// Acceleration of the housing \[m/s2\]; empty for a tool without one.
    pub fn tool_acceleration(&self) -> &[f64] {
        self.tool.as_ref().map_or(&[], |tool| &tool.acceleration)
    }

    /// Deepest depth of the fastener's tip \[m\]; zero for a tool that drives none.
    pub fn fastener_depth(&self) -> f64 {
        let deepest = self.workpiece.as_ref().and_then(|own| own.deepest.last());
        deepest.copied().unwrap_or(0.0)
    }

    /// Mass that leaves through all openings \[kg\].
    pub fn discharged_mass(&self) -> f64 {
        let of_figures = |figures: &BTreeMap<String, f64>| {
            let masses = self.record.openings.iter();
            masses
                .filter_map(|own| figures.get(&format!("{}_mass", own.name)))
                .sum()
        };
        match &self.figures {
            SummaryFigures::Keys(summary) => summary.exhaust_mass + summary.vent_mass,
            SummaryFigures::Assembly(figures) => of_figures(figures),
        }
    }
}

/// Figures of a shot (SI).
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum SummaryFigures {
    /// Figures of the tool described by keys.
    Keys(Box<Summary>),
    /// Figures of an assembly, named after its blocks: `peak_BLOCK_force`, `OPENING_mass`, `BLOCK_depth`,
    /// `VOLUME_choked_fraction` of a volume of the exhaust's path.
    Assembly(BTreeMap<String, f64>),
}

impl SummaryFigures {
    /// The figure with this name; `None` if its phase does not occur.
    pub fn get(&self, name: &str) -> Option<f64> {
        match self {
            Self::Keys(summary) => serde_json::to_value(summary).ok()?.get(name)?.as_f64(),
            Self::Assembly(figures) => figures.get(name).copied(),
        }
    }
}

/// Event times by name \[s\], in the order of the tool; null if an event does not occur.
#[derive(Debug, Clone, PartialEq)]
pub struct EventTimes(pub Vec<EventTime>);

impl Serialize for EventTimes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for event in &self.0 {
            map.serialize_entry(&event.name, &event.time)?;
        }
        map.end()
    }
}

/// Descriptions of events by name; those without a description are absent.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct EventWords(BTreeMap<String, String>);

impl EventWords {
    /// The descriptions of the events of a shot.
    pub fn of(events: &[EventTime]) -> Self {
        let described = events.iter().filter(|event| !event.description.is_empty());
        Self(
            described
                .map(|event| (event.name.clone(), event.description.clone()))
                .collect(),
        )
    }

    /// The descriptions of several shots; for an event of several shots that of the first.
    pub fn joined<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        let mut words = BTreeMap::new();
        for (name, description) in all.flat_map(|own| &own.0) {
            words.entry(name.clone()).or_insert_with(|| description.clone());
        }
        Self(words)
    }

    /// Whether no event has a description.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Description of an event, if it has one.
    pub fn of_event(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// An event by name and description: see [`event_in_words`].
    pub fn in_words(&self, name: &str) -> String {
        event_in_words(name, self.of_event(name).unwrap_or_default())
    }
}

/// An event by name and description, as in "t12 trigger valve released" or "strike: driver meets the staple"; by its
/// name alone if it has no description, or if the name says the same.
pub fn event_in_words(name: &str, description: &str) -> String {
    let plain = name.replace('_', " ");
    let is_number = |number: &str| !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit());
    match description {
        "" => plain,
        same if same == plain => plain,
        words if name.strip_prefix('t').is_some_and(is_number) => format!("{plain} {words}"),
        words => format!("{plain}: {words}"),
    }
}

impl JsonSchema for EventTimes {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "EventTimes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": { "type": ["number", "null"], "format": "double" } })
    }
}

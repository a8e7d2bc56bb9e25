//! Figures of the shot of an assembly whose sensitivity can be requested, named after its blocks.

use nailnoise_dynamics::network::assembly::{Space, Stop};
use nailnoise_dynamics::network::{Assembly, Record};
use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{
    ACCELERATION, FORCE, LENGTH, MASS, MASS_FLOW, PRESSURE, TEMPERATURE, VELOCITY, VOLUME,
};

use super::outputs::{peak, smoothly_interpolated};
use crate::error::Error;

/// The group of the figures of histories.
const HISTORIES: &str = "histories";

/// A figure of the shot of an assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct AssemblyOutput {
    /// Its name in the output: that of an event, `speed_before_FASTENER`, `FASTENER_depth`, `peak_BLOCK_force`,
    /// `OPENING_mass`, `peak BLOCK.QUANTITY`, `BLOCK.QUANTITY at EVENT`.
    pub name: String,
    /// The group by which it can be chosen: `speed`, `penetration`, `events`, `forces` or `masses`; that of a history
    /// is `histories`, which is chosen by single names only.
    pub group: &'static str,
    /// SI unit.
    pub unit: &'static str,
    read: Read,
}

/// Where a figure is in a record.
#[derive(Debug, Clone, PartialEq)]
enum Read {
    Event(String),
    /// Velocity of a driver before its first impact on a fastener.
    Before(String),
    /// The same after the impact.
    After(String),
    /// Last value of a channel.
    Last(String),
    /// Largest value of a channel times a sign.
    Peak(String, f64),
    /// Value of a channel at an event.
    At(String, String),
    /// An integral times a sign.
    Integral(String, f64),
}

impl AssemblyOutput {
    /// Its value in a record; `None` if its phase does not occur.
    pub fn of(&self, record: &Record) -> Option<f64> {
        let strike = |fastener: &str| record.strikes.iter().find(|strike| strike.fastener == fastener);
        match &self.read {
            Read::Event(name) => record.event(name),
            Read::Before(fastener) => Some(strike(fastener)?.before),
            Read::After(fastener) => Some(strike(fastener)?.after),
            Read::Last(channel) => record.get(channel)?.last().copied(),
            Read::Peak(channel, sign) => Some(peak(record.get(channel)?, *sign)),
            Read::At(channel, event) => {
                smoothly_interpolated(record.get(channel)?, record.interval?, record.event(event)?)
            }
            Read::Integral(name, sign) => record.integral(name).map(|value| sign * value),
        }
    }

    /// All figures of an assembly.
    pub fn all(assembly: &Assembly) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        let mut add = |group, unit, name: String, read| {
            if all.iter().all(|own| own.name != name) {
                all.push(Self {
                    name,
                    group,
                    unit,
                    read,
                });
            }
        };
        for fastener in &assembly.fasteners {
            let name = &fastener.name;
            add(
                "speed",
                "m/s",
                format!("speed_before_{name}"),
                Read::Before(name.clone()),
            );
            add("speed", "m/s", format!("speed_after_{name}"), Read::After(name.clone()));
        }
        for fastener in &assembly.fasteners {
            let name = &fastener.name;
            let work = Read::Integral(format!("penetration.{name}"), 1.0);
            add(
                "penetration",
                "m",
                format!("{name}_depth"),
                Read::Last(format!("{name}.deepest")),
            );
            add("penetration", "J", format!("{name}_work"), work);
        }
        for event in &assembly.events {
            add("events", "s", event.name.clone(), Read::Event(event.name.clone()));
        }
        let contacts = assembly.contacts.iter().map(|own| match own.stop {
            Stop::Below => (&own.name, 1.0),
            Stop::Above => (&own.name, -1.0),
        });
        let fasteners = assembly.fasteners.iter().map(|own| (&own.name, 1.0));
        for (name, sign) in contacts.chain(fasteners) {
            let force = Read::Peak(format!("{name}.force"), sign);
            add("forces", "N", format!("peak_{name}_force"), force);
        }
        for (index, passage) in assembly.passages.iter().enumerate() {
            let opening = assembly.openings.iter().find(|own| own.passage == index);
            // Through an opening, the flow out of the tool is positive.
            let sign = match (passage.from, passage.to, opening) {
                (Space::Reservoir(_), Space::Volume(_), Some(_)) => -1.0,
                (Space::Volume(_), Space::Reservoir(_), _) | (Space::Reservoir(_), Space::Volume(_), _) => 1.0,
                _ => continue,
            };
            let name = opening.map_or(&passage.name, |own| &own.name);
            let mass = Read::Integral(format!("mass.{}", passage.name), sign);
            add("masses", "kg", format!("{name}_mass"), mass);
        }
        all
    }

    /// The figure of a history: `peak BLOCK.QUANTITY`, or `BLOCK.QUANTITY at EVENT`.
    fn of_history(assembly: &Assembly, name: &str) -> Option<Self> {
        let (channel, event) = match name.strip_prefix("peak ") {
            Some(channel) => (channel.trim(), None),
            None => name
                .split_once(" at ")
                .map(|(channel, event)| (channel.trim(), Some(event.trim())))?,
        };
        let (_, dimension) = assembly.quantities().into_iter().find(|(own, _)| own == channel)?;
        let read = match event {
            None => Read::Peak(channel.to_owned(), 1.0),
            Some(event) => {
                assembly.events.iter().find(|own| own.name == event)?;
                Read::At(channel.to_owned(), event.to_owned())
            }
        };
        Some(Self {
            name: name.to_owned(),
            group: HISTORIES,
            unit: unit(dimension),
            read,
        })
    }

    /// The figures of an assembly with these names or in these groups; `all` selects every figure but those of
    /// histories. Without names, the groups `speed`, `penetration` and `masses`.
    ///
    /// # Errors
    /// [`Error::NoSuchOutput`] for the first name that is neither a figure nor a group.
    pub fn choose(assembly: &Assembly, names: &[impl AsRef<str>]) -> Result<Vec<Self>, Error> {
        let mut all = Self::all(assembly);
        let names: Vec<&str> = match names.is_empty() {
            true => vec!["speed", "penetration", "masses"],
            false => names.iter().map(|name| name.as_ref().trim()).collect(),
        };
        all.extend(names.iter().filter_map(|name| Self::of_history(assembly, name)));
        let groups = ["speed", "penetration", "events", "forces", "masses", "all"];
        let is =
            |own: &Self, name: &str| own.name == name || own.group == name || (name == "all" && own.group != HISTORIES);
        let known = |name: &str| groups.contains(&name) || all.iter().any(|own| own.name == name);
        if let Some(name) = names.iter().find(|name| !known(name)) {
            let known = all.iter().map(|own| own.name.as_str());
            let known: Vec<&str> = known
                .chain(["peak BLOCK.QUANTITY", "BLOCK.QUANTITY at EVENT"])
                .collect();
            return Err(Error::NoSuchOutput {
                name: (*name).to_owned(),
                known: known.join(", "),
            });
        }
        Ok(all
            .iter()
            .filter(|own| names.iter().any(|name| is(own, name)))
            .cloned()
            .collect())
    }
}

/// SI unit of a history.
fn unit(dimension: Dimension) -> &'static str {
    const UNITS: [(Dimension, &str); 9] = [
        (LENGTH, "m"),
        (VELOCITY, "m/s"),
        (ACCELERATION, "m/s2"),
        (MASS, "kg"),
        (MASS_FLOW, "kg/s"),
        (PRESSURE, "Pa"),
        (TEMPERATURE, "K"),
        (VOLUME, "m3"),
        (FORCE, "N"),
    ];
    let own = UNITS.iter().find(|(own, _)| *own == dimension);
    own.map_or("-", |(_, unit)| unit)
}

//! The quantity of a measurement of the cycle, by the names of the tool: those of the keys, or those of a design's own
//! assembly.

use nailnoise_documents::{KeyError, Keys};
use nailnoise_dynamics::network::Assembly;
use nailnoise_quantities::dimension::TIME;
use nailnoise_quantities::measure;

use super::assembly_quantities::{AssemblyMoment, AssemblyQuantity, START, air_per_shot, figures};
use super::fields::{place, words};
use super::level_quantities;
use super::measurements::Condition;
use super::quantities::{Chamber, Moment, NAMES, Quantity, event};

/// Keys for measurements of modes, which are not supported.
const OF_NOT_BUILT: [&str; 3] = ["body", "hz", "mounted"];

/// The quantity of a mode.
const MODE: &str = "mode";

/// A key that is often looked for among the quantities.
const LOSS_FACTOR: &str = "loss_factor";

/// Quantities whose recorded history can be read.
pub(super) const OF_TRACE: [&str; 3] = ["pressure", "piston_travel", "travel"];

/// Keys that only a recorded history has.
const ONLY_OF_TRACE: [&str; 6] = ["file", "column", "align", "from", "to", "points"];

/// Quantities of any assembly besides its figures, with their fields.
const OF_ANY_ASSEMBLY: [&str; 5] = ["interval", "travel", "pressure", "peak_pressure", "air_per_shot"];

/// Latest time of a reading \[s\].
const LATEST: f64 = 10.0;

/// A reader of the quantity in the table of a measurement.
pub(super) struct QuantityReader<'a, 't, 'i> {
    pub(super) table: &'a Keys<'t, 'i>,
    /// The assembly of the design; none for the tool of the keys.
    pub(super) assembly: Option<&'a Assembly>,
    /// Whether the table names a recorded history, whose time zero is the event in `align`.
    pub(super) is_trace: bool,
}

impl QuantityReader<'_, '_, '_> {
    /// Refuses, in the table of a single value, fields of measurements that are not supported and those of a history.
    ///
    /// # Errors
    /// The first such field.
    pub(super) fn refuse_other_kinds(&self) -> Result<(), KeyError> {
        let given = |key: &&&str| self.table.get(key).is_some();
        if let Some(key) = OF_NOT_BUILT.iter().find(given) {
            return Err(self.not_built(key));
        }
        match ONLY_OF_TRACE.iter().find(given) {
            Some(key) => {
                let of_tool = if self.assembly.is_some() {
                    "travel"
                } else {
                    "piston_travel"
                };
                let help = format!("give `file` and the quantity `pressure` or `{of_tool}`, or remove it");
                Err(self.table.error(key, "belongs to a recorded history", help))
            }
            None => Ok(()),
        }
    }

    /// The quantity.
    ///
    /// # Errors
    /// The first invalid field, with its place and remedy.
    pub(super) fn quantity(&self) -> Result<Quantity, KeyError> {
        let table = self.table;
        let names = self.names();
        let example = format!("\"{}\"", names[0]);
        table.required("quantity", &example)?;
        let name = table.text("quantity", &example)?.unwrap_or_default();
        if name == MODE {
            return Err(self.not_built("quantity"));
        }
        if name == LOSS_FACTOR {
            let help = "give the loss factor under [direct]: \"wood.loss_factor\" = { value = 0.02, error = 0.003 }";
            return Err(table.error("quantity", "is a key of the design, not a quantity of a shot", help));
        }
        let known = names.iter().map(String::as_str).chain(level_quantities::NAMES);
        place(table, "quantity", name, known, "quantity")?;
        let fields: &[&str] = match name {
            "interval" => &["events"],
            "travel" | "pressure" if self.is_trace => &["of"],
            "piston_travel" if !self.is_trace => &["at"],
            "travel" | "pressure" => &["of", "at"],
            "peak_pressure" => &["of"],
            _ => &[],
        };
        let other = ["events", "at", "of"];
        if let Some(other) = other
            .iter()
            .find(|key| table.get(key).is_some() && !fields.contains(key))
        {
            return Err(table.error(other, format!("does not belong to `{name}`"), "remove it"));
        }
        match self.assembly {
            Some(assembly) => self.of_assembly(assembly, name).map(Quantity::OfAssembly),
            None => self.of_keys(name),
        }
    }

    /// Refuses a quantity that is read outside the record of the shot; `key` states its time.
    ///
    /// # Errors
    /// The time, with its remedy.
    pub(super) fn within_the_record(&self, key: &str, of: &Quantity, condition: &Condition) -> Result<(), KeyError> {
        let (end, of_end) = match self.assembly {
            Some(own) => (own.end, "cycle.end"),
            None => (condition.design.analysis.cycle_end, "analysis.cycle_end"),
        };
        let offset = of.offset();
        match of.time() {
            Some(time) if time > of.end(end) => {
                let problem = format!("is {time} s, after the end of the record at {end} s");
                let help = format!("give an earlier time, or raise `{of_end}`");
                Err(self.table.error(key, problem, help))
            }
            Some(time) if time < 0.0 => {
                let problem = format!("is {time} s, before the trigger pull");
                let help = format!("give a later `{key}`, or in `align` the event at time 0 of the file");
                Err(self.table.error(key, problem, help))
            }
            None if offset.abs() > end => {
                let problem = format!("is {offset} s from its event, more than the record of {end} s");
                Err(self
                    .table
                    .error(key, problem, format!("give a time nearer to the event as `{key}`")))
            }
            _ => Ok(()),
        }
    }

    /// Names of the quantities of the cycle.
    fn names(&self) -> Vec<String> {
        match self.assembly {
            Some(assembly) => {
                let figures = figures(assembly).into_iter().map(|own| own.name);
                figures.chain(OF_ANY_ASSEMBLY.map(str::to_owned)).collect()
            }
            None => NAMES.map(str::to_owned).to_vec(),
        }
    }

    fn not_built(&self, key: &str) -> KeyError {
        let problem = "belongs to a measurement of a mode, with which this version cannot calibrate";
        let names = self.names().join(", ");
        let help = format!("choose from {names}, {}", level_quantities::NAMES.join(", "));
        self.table.error(key, problem, help)
    }

    fn of_keys(&self, name: &str) -> Result<Quantity, KeyError> {
        Ok(match name {
            "head_depth" => Quantity::HeadDepth,
            "air_per_shot" => Quantity::AirPerShot,
            "interval" => self.interval_of_keys()?,
            "mean_drive_speed" => Quantity::MeanDriveSpeed,
            "speed_before_impact" => Quantity::SpeedBeforeImpact,
            "piston_travel" => Quantity::PistonTravel(self.moment_of_keys()?),
            "pressure" => Quantity::Pressure(self.chamber()?, self.moment_of_keys()?),
            "peak_pressure" => Quantity::PeakPressure(self.chamber()?),
            _ => Quantity::SupplyDrop,
        })
    }

    fn interval_of_keys(&self) -> Result<Quantity, KeyError> {
        const EXAMPLE: &str = "[\"t6\", \"t9\"]";
        self.table.required("events", EXAMPLE)?;
        let words = words(self.table, "events", EXAMPLE)?;
        let events: Option<Vec<usize>> = words.iter().map(|word| event(word)).collect();
        match events.as_deref() {
            Some(&[from, to]) if from < to => Ok(Quantity::Interval { from, to }),
            Some(_) => Err(self
                .table
                .error("events", "must be two events in their order", format!("as {EXAMPLE}"))),
            None => Err(self.unknown_event("events")),
        }
    }

    fn unknown_event(&self, key: &str) -> KeyError {
        let help = "give t0 to t18; docs/nailing-cycle.md explains them".to_owned();
        self.table.error(key, "names an event that does not exist", help)
    }

    fn moment_of_keys(&self) -> Result<Moment, KeyError> {
        if self.is_trace {
            let word = self.table.text("align", "\"t9\"")?.unwrap_or("t0");
            return event(word)
                .map(Moment::event)
                .ok_or_else(|| self.unknown_event("align"));
        }
        let value = self.table.required("at", "\"t9\", or a time from the trigger pull")?;
        if let Some(word) = value.get_ref().as_str().filter(|word| word.starts_with('t')) {
            return event(word).map(Moment::event).ok_or_else(|| self.unknown_event("at"));
        }
        self.time().map(Moment::time)
    }

    /// The time in `at` \[s\].
    fn time(&self) -> Result<f64, KeyError> {
        let value = self.table.required("at", "\"10 ms\"")?;
        let time = self.table.number("at", value, |text| measure(text, TIME))?;
        self.table.within("at", time, [0.0, LATEST], "s")
    }

    fn chamber(&self) -> Result<Chamber, KeyError> {
        self.table.required("of", "\"above_piston\"")?;
        let name = self.table.text("of", "\"above_piston\"")?.unwrap_or_default();
        let known = Chamber::NAMES.into_iter().map(|(own, _)| own);
        place(self.table, "of", name, known, "chamber").map(|place| Chamber::NAMES[place].1)
    }

    fn of_assembly(&self, assembly: &Assembly, name: &str) -> Result<AssemblyQuantity, KeyError> {
        let volumes = assembly.volumes.iter().map(|own| own.name.as_str());
        let bodies = assembly.bodies.iter().map(|own| own.name.as_str());
        Ok(match name {
            "interval" => self.interval_of_assembly(assembly)?,
            "travel" => AssemblyQuantity::Travel {
                body: self.block(bodies, "body")?,
                at: self.moment_of_assembly(assembly)?,
            },
            "pressure" => AssemblyQuantity::Pressure {
                volume: self.block(volumes, "volume")?,
                at: self.moment_of_assembly(assembly)?,
            },
            "peak_pressure" => AssemblyQuantity::PeakPressure {
                volume: self.block(volumes, "volume")?,
            },
            "air_per_shot" => air_per_shot(assembly).ok_or_else(|| {
                let help = "leave out the measurement";
                self.table.error(
                    "quantity",
                    "needs a passage to the surroundings, which the assembly does not have",
                    help,
                )
            })?,
            _ => {
                let figure = figures(assembly).into_iter().find(|own| own.name == name);
                AssemblyQuantity::Figure(figure.ok_or_else(|| self.not_built("quantity"))?)
            }
        })
    }

    /// The block in `of`.
    fn block<'n>(&self, names: impl Iterator<Item = &'n str> + Clone, what: &str) -> Result<String, KeyError> {
        let example = format!("\"{}\"", names.clone().next().unwrap_or(what));
        self.table.required("of", &example)?;
        let name = self.table.text("of", &example)?.unwrap_or_default();
        place(self.table, "of", name, names, what)?;
        Ok(name.to_owned())
    }

    fn interval_of_assembly(&self, assembly: &Assembly) -> Result<AssemblyQuantity, KeyError> {
        let last = assembly.events.last().map_or("EVENT", |event| event.name.as_str());
        let example = format!("[\"{START}\", \"{last}\"]");
        self.table.required("events", &example)?;
        let words = words(self.table, "events", &example)?;
        let known = || std::iter::once(START).chain(assembly.events.iter().map(|own| own.name.as_str()));
        for word in &words {
            place(self.table, "events", word, known(), "event")?;
        }
        match &words[..] {
            [from, to] if from != to => Ok(AssemblyQuantity::Interval {
                from: from.clone(),
                to: to.clone(),
            }),
            _ => Err(self
                .table
                .error("events", "must be two events", format!("as {example}"))),
        }
    }

    fn moment_of_assembly(&self, assembly: &Assembly) -> Result<AssemblyMoment, KeyError> {
        let known = assembly.events.iter().map(|own| own.name.as_str());
        if self.is_trace {
            let word = self.table.text("align", "the name of an event")?.unwrap_or(START);
            place(self.table, "align", word, std::iter::once(START).chain(known), "event")?;
            return Ok(AssemblyMoment::event(word));
        }
        let value = self.table.required("at", "\"10 ms\", or the name of an event")?;
        let word = value.get_ref().as_str().unwrap_or_default();
        let is_time = word.is_empty() || word.starts_with(|first: char| first.is_ascii_digit() || first == '.');
        if is_time {
            return self.time().map(AssemblyMoment::time);
        }
        place(self.table, "at", word, known, "event")?;
        Ok(AssemblyMoment::event(word))
    }
}

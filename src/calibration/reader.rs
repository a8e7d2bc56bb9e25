//! Reads the measurement file, `nailnoise-calibration/1`.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_calibration::likelihood::Reading;
use nailnoise_documents::{Document, KeyError, Keys, Value, found, nearest, read_regular};
use nailnoise_dynamics::Outcome;
use nailnoise_dynamics::network::Assembly;
use nailnoise_quantities::dimension::{NUMBER, PRESSURE};
use nailnoise_quantities::{Dimension, Group, Kind, measure, quantity};
use toml::de::DeValue;

use super::error::CalibrationError;
use super::fields::{
    MOST_SHOTS, Repeats, condition_of, error, instrument_of, mean_and_scatter, named, of_given, place, reading,
    repeated, spread, stated_spread, tables, words,
};
use super::level_file::OfFile;
use super::level_reader::OfLevel;
use super::measurements::{
    Condition, Correlation, Direct, InstrumentError, Measured, MeasuredLevel, Measurements, Shown,
};
use super::next;
use super::quantities::Quantity;
use super::quantity_reader::QuantityReader;
use super::trace::TraceReader;
use crate::design::{Assignment, Design, DesignError};

/// Name and version of the layout.
pub(super) const SCHEMA: &str = "nailnoise-calibration/1";

/// Largest file accepted \[byte\].
const LARGEST: u64 = 1 << 20;

/// Number of standard deviations at which the distribution of a measured key is truncated.
const CUT: f64 = 3.0;

/// Keys of a measurement.
const MEASURED: [&str; 16] = [
    "condition",
    "quantity",
    "of",
    "at",
    "events",
    "value",
    "values",
    "at_most",
    "at_least",
    "shots",
    "scatter",
    "error",
    "rounding",
    "k",
    "instrument",
    "discrepancy",
];

/// A reader of the file for one design.
pub(super) struct Reader<'a> {
    /// The design.
    pub(super) design: &'a Design,
    /// Its own assembly; none for the tool of the keys.
    pub(super) assembly: Option<&'a Assembly>,
    /// The design with further assignments.
    pub(super) with: &'a dyn Fn(&[Assignment]) -> Result<Design, DesignError>,
}

/// Reads the text of a file of measurements.
///
/// # Errors
/// If the file cannot be read or is not UTF-8.
pub(super) fn text(path: &Path) -> Result<Document, CalibrationError> {
    let bytes = read_regular(path, LARGEST).map_err(|error| CalibrationError::Unreadable {
        path: path.to_owned(),
        cause: error.to_string(),
    })?;
    Ok(Document::from_bytes(path, bytes)?)
}

impl Reader<'_> {
    /// Reads measurements.
    ///
    /// # Errors
    /// The first invalid key, with its place and remedy.
    pub(super) fn read(&self, document: &Document) -> Result<Measurements, CalibrationError> {
        let keys = document.table()?;
        let root = Keys::of_document(document, &keys, "file of measurements");
        root.only(&[
            "schema",
            "correlation",
            "direct",
            "instrument",
            "condition",
            "measured",
            "effort",
        ])?;
        root.required("schema", &format!("\"{SCHEMA}\""))?;
        if root.text("schema", &format!("\"{SCHEMA}\""))? != Some(SCHEMA) {
            return Err(root
                .error("schema", "is another layout", format!("give \"{SCHEMA}\""))
                .into());
        }
        let direct = self.direct(&root)?;
        let instruments = tables(&root, "instrument", "{ error = \"1 %\" }")?;
        for (_, table) in &instruments {
            table.only(&["error"])?;
            let value = table.required("error", "\"1 %\"")?;
            // The unit is that of the readings, so only the digits can be checked here.
            let is_zero = |text: &str| !text.contains(|digit: char| ('1'..='9').contains(&digit));
            if value
                .get_ref()
                .as_str()
                .is_some_and(|text| text.contains('0') && is_zero(text))
            {
                return Err(table
                    .error("error", "is 0", "no instrument is exact: give its error")
                    .into());
            }
        }
        let conditions = tables(&root, "condition", "{ set = { \"supply.pressure\" = \"96 psig\" } }")?;
        let conditions: Vec<Condition> = conditions
            .iter()
            .map(|(name, table)| self.condition(name, table, &instruments, &direct))
            .collect::<Result<_, KeyError>>()?;
        let mut notes = Vec::new();
        let measured = tables(
            &root,
            "measured",
            "{ condition = \"96 psig\", quantity = \"head_depth\", .. }",
        )?;
        if measured.is_empty() {
            let problem = "has no measurement";
            let help = "add one, as depth = { condition = \"96 psig\", quantity = \"head_depth\", value = \"2 mm\", \
                error = \"0.2 mm\" }; without measurements `nailnoise study` is enough";
            return Err(root.error("measured", problem, help).into());
        }
        let (mut data, mut levels, mut files) = (Vec::new(), Vec::new(), Vec::new());
        // Errors that the levels of a file share are variables like those of the instruments.
        let mut tests = Vec::new();
        for (name, table) in &measured {
            let conditions = conditions.as_slice();
            let instruments = instruments.as_slice();
            files.extend(
                table
                    .get("file")
                    .and_then(|own| Some(document.sibling(own.get_ref().as_str()?))),
            );
            if OfFile::is_file(table) {
                let at = OfFile {
                    table,
                    document,
                    conditions,
                    instrument: instruments.len() + tests.len(),
                };
                levels.extend(at.measured(name, &mut notes)?);
                tests.push(format!("{name}.method"));
            } else if TraceReader::is_trace(table) {
                let at = TraceReader {
                    table,
                    document,
                    assembly: self.assembly,
                    conditions,
                    instruments,
                };
                data.extend(at.measured(name, &mut notes)?);
            } else if OfLevel::is_level(table) {
                let at = OfLevel {
                    table,
                    conditions,
                    instruments,
                };
                levels.push(at.measured(name, &mut notes)?);
            } else {
                let at = Of {
                    table,
                    assembly: self.assembly,
                    conditions,
                    instruments,
                };
                data.push(at.measured(name, &mut notes)?);
            }
        }
        distinct(
            &measured,
            data.iter()
                .map(|own| &own.name)
                .chain(levels.iter().map(|own| &own.name)),
        )?;
        for (condition, (_, table)) in conditions.iter().zip(tables(&root, "condition", "")?) {
            let of_cycle = data.iter().map(|own: &Measured| own.condition);
            let mut read = of_cycle.chain(levels.iter().map(|own: &MeasuredLevel| own.condition));
            let is_read = read.any(|own| conditions[own].name == condition.name);
            if !is_read && condition.outcomes.is_empty() {
                let help = "add `outcome`, a measurement under it, or remove it";
                return Err(table.error("", "has neither an outcome nor a measurement", help).into());
            }
        }
        Ok(Measurements {
            direct,
            instruments: instruments.into_iter().map(|(name, _)| name).chain(tests).collect(),
            conditions,
            correlations: correlations(&root, &data)?,
            effort: effort(&root)?,
            data,
            levels,
            files,
            narrowed: Vec::new(),
            notes,
        })
    }

    fn direct(&self, root: &Keys<'_, '_>) -> Result<Vec<Direct>, KeyError> {
        let all = tables(root, "direct", "{ value = \"11.4 mm\", error = \"0.1 mm\" }")?;
        let read = |(key, table): &(String, Keys<'_, '_>)| {
            if let Some(inner) = table.keys().iter().find(|(_, value)| value.get_ref().is_table()) {
                let name = inner.0.get_ref();
                let help = format!("write the whole key in quotes: \"{key}.{name}\" = {{ .. }}");
                return Err(table.error(name, "is not a key of a measured value", help));
            }
            table.only(&["value", "error", "rounding", "k"])?;
            let entry = self.design.entries().into_iter().find(|entry| entry.key == *key);
            let dimension = self.dimension(key).ok_or_else(|| match &entry {
                Some(_) => table.error("", "is not a quantity", "set it in the design, or under each condition"),
                None => self.unknown(table, key),
            })?;
            let Some([low, high]) = entry.and_then(|entry| entry.range).filter(|[low, high]| low < high) else {
                let help = "give it a range in the design, or set its value there";
                return Err(table.error("", "has no range in the design, so that nothing can be narrowed", help));
            };
            let value = table.required("value", "\"11.4 mm\"")?;
            let value = scalar(table, "value", value, dimension, Some(self.design.ambient.pressure))?;
            let deviation = error(table, dimension)?.at(value);
            if (value - value.clamp(low, high)).abs() >= CUT * deviation {
                let problem = format!("is more than three standard deviations outside the design's {low} .. {high}");
                return Err(table.error("value", problem, "correct the value, or widen the range in the design"));
            }
            Ok(Direct {
                key: key.clone(),
                value,
                deviation,
            })
        };
        all.iter().map(read).collect()
    }

    /// The dimension of a key of the design, if it is a quantity or a count.
    fn dimension(&self, key: &str) -> Option<Dimension> {
        let mut dimension = None;
        self.design.visit("", &mut |own, spec, _| {
            if own == key {
                dimension = match spec.kind {
                    Kind::Quantity { dimension, .. } => Some(dimension),
                    Kind::Count(_) => Some(NUMBER),
                    _ => None,
                };
            }
        });
        dimension
    }

    fn unknown(&self, table: &Keys<'_, '_>, key: &str) -> KeyError {
        let entries = self.design.entries();
        let near = nearest(entries.iter().map(|entry| entry.key.as_str()), key);
        let help = near.map_or_else(
            || "`nailnoise check DESIGN` lists the keys".to_owned(),
            |near| format!("is it `{near}`?"),
        );
        table.error("", "is not a quantity of the design", help)
    }

    fn condition(
        &self,
        name: &str,
        table: &Keys<'_, '_>,
        instruments: &[(String, Keys<'_, '_>)],
        direct: &[Direct],
    ) -> Result<Condition, KeyError> {
        table.only(&["set", "instrument", "outcome"])?;
        let set = table.table("set", "{ \"supply.pressure\" = \"96 psig\" }")?;
        let mut assignments = Vec::new();
        let mut keys = Vec::new();
        for (key, value) in set
            .iter()
            .flat_map(|set| set.keys().iter().map(move |pair| (set, pair)))
            .map(|(_, p)| p)
        {
            let key = key.get_ref().to_string();
            let wrong = |problem: String, help: &str| table.wrong(&key, value.span(), problem, help.to_owned());
            if direct.iter().any(|own| own.key == key) {
                return Err(wrong(
                    "is set here and measured in [direct]".to_owned(),
                    "leave out one of the two: a set value has the error of its instrument",
                ));
            }
            let text = match value.get_ref() {
                DeValue::String(text) => toml::Value::String(text.to_string()).to_string(),
                DeValue::Integer(number) => number.as_str().to_owned(),
                DeValue::Float(number) => number.as_str().to_owned(),
                DeValue::Boolean(on) => on.to_string(),
                other => {
                    let help = "write the whole key in quotes and give one value, as \"supply.pressure\" = \"96 psig\"";
                    return Err(wrong(format!("is {}", found(other)), help));
                }
            };
            let assignment: Assignment = format!("{key}={text}")
                .parse()
                .map_err(|error| wrong(format!("cannot be set: {error}"), "correct the key"))?;
            // Each value is first applied separately, so that a message shows its place.
            (self.with)(std::slice::from_ref(&assignment)).map_err(|error| {
                let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
                wrong(
                    format!("cannot be set: {error}"),
                    &help.unwrap_or_else(|| "correct the value".to_owned()),
                )
            })?;
            assignments.push(assignment);
            keys.push(key);
        }
        let design = (self.with)(&assignments)
            .map_err(|error| table.error("set", format!("is not possible: {error}"), "correct the values"))?;
        let mut shown = Vec::new();
        if let (Some(by), Some(set)) = (table.table("instrument", "{ \"supply.pressure\" = \"gauge\" }")?, &set) {
            for key in by.keys().keys().map(|key| key.get_ref().to_string()) {
                let Some(value) = set.get(&key) else {
                    return Err(by.error(&key, "is not set under this condition", "set it, or remove it here"));
                };
                let instrument = named(&by, &key, instruments)?;
                let dimension = self.dimension(&key).ok_or_else(|| self.unknown(&by, &key))?;
                // A gauge's error is relative to its reading.
                let reading = scalar(set, &key, value, dimension, None)?;
                let (_, of) = &instruments[instrument];
                shown.push(Shown {
                    deviation: spread(of, "error", dimension)?.at(reading),
                    key,
                    instrument,
                });
            }
        }
        Ok(Condition {
            name: name.to_owned(),
            design,
            set: keys,
            shown,
            outcomes: self.outcomes(table)?,
        })
    }

    /// Outcomes that a shot may have had.
    fn outcomes(&self, table: &Keys<'_, '_>) -> Result<Vec<String>, KeyError> {
        let known: Vec<&str> = match self.assembly {
            Some(own) => own.outcomes.iter().map(|outcome| outcome.name.as_str()).collect(),
            None => Outcome::ALL.map(Outcome::name).to_vec(),
        };
        let words = words(table, "outcome", "\"drives\", or a list of outcomes")?;
        let outcome = |word: &String| {
            let place = place(table, "outcome", word, known.iter().copied(), "outcome")?;
            Ok(known[place].to_owned())
        };
        words.iter().map(outcome).collect()
    }
}

/// A value in SI units; a gauge pressure is relative to `ambient`, or is returned as shown.
fn scalar(
    table: &Keys<'_, '_>,
    key: &str,
    value: &Value<'_>,
    dimension: Dimension,
    ambient: Option<f64>,
) -> Result<f64, KeyError> {
    table.number(key, value, |text| {
        match quantity(text, dimension, dimension == PRESSURE) {
            Ok(read) => Ok(ambient.map_or(read.si, |ambient| read.absolute(ambient))),
            Err(_) => measure(text, dimension),
        }
    })
}

/// Refuses a measurement with the name of a level that a file contains.
fn distinct<'n>(measured: &[(String, Keys<'_, '_>)], names: impl Iterator<Item = &'n String>) -> Result<(), KeyError> {
    let mut known = std::collections::BTreeSet::new();
    let Some(twice) = names.into_iter().find(|name| !known.insert(*name)) else {
        return Ok(());
    };
    let help = "rename one of the two";
    let at = measured.iter().find(|(name, _)| name == twice).or(measured.first());
    at.map_or(Ok(()), |(_, table)| {
        Err(table.error("", format!("has the name of a reading from a file, `{twice}`"), help))
    })
}

/// Minutes of further measurements.
fn effort(root: &Keys<'_, '_>) -> Result<BTreeMap<String, f64>, KeyError> {
    let mut found = BTreeMap::new();
    let Some(table) = root.table("effort", "{ head_depth = 5 }")? else {
        return Ok(found);
    };
    let known: Vec<&str> = next::efforts().collect();
    for (key, value) in table.keys() {
        let name = key.get_ref().to_string();
        place(&table, &name, &name, known.iter().copied(), "further measurement")?;
        let minutes = table.number(&name, value, |text| measure(text, NUMBER))?;
        if minutes <= 0.0 {
            return Err(table.error(&name, format!("is {minutes} min"), "give minutes above 0"));
        }
        found.insert(name, minutes);
    }
    Ok(found)
}

fn correlations(root: &Keys<'_, '_>, data: &[Measured]) -> Result<Vec<Correlation>, KeyError> {
    const EXAMPLE: &str = "[{ ids = [\"drive\", \"p1\"], r = 0.3 }]";
    let Some(value) = root.get("correlation") else {
        return Ok(Vec::new());
    };
    let help = format!("give it as correlation = {EXAMPLE}");
    let wrong = |problem: String| root.wrong("correlation", value.span(), problem, help.clone());
    let Some(list) = value.get_ref().as_array() else {
        return Err(wrong(format!("is {}", found(value.get_ref()))));
    };
    let mut all = Vec::new();
    for own in list {
        let table = own.get_ref().as_table();
        let is_known = |key: &str| ["ids", "r"].contains(&key);
        if let Some(key) = table.and_then(|own| own.keys().find(|key| !is_known(key.get_ref()))) {
            return Err(wrong(format!("has the unknown key `{}`", key.get_ref())));
        }
        let entry = |key: &str| table.and_then(|own| own.get(key));
        let names = entry("ids").and_then(|own| own.get_ref().as_array());
        let names = names.and_then(|own| own.iter().map(|own| own.get_ref().as_str()).collect::<Option<Vec<_>>>());
        let (Some(names), Some(r)) = (names, entry("r")) else {
            return Err(wrong("lacks `ids` or `r`".to_owned()));
        };
        let known = data.iter().map(|own| own.name.as_str());
        let place = |name: &str| place(root, "correlation", name, known.clone(), "measurement");
        let places: Vec<usize> = names.into_iter().map(place).collect::<Result<_, KeyError>>()?;
        if places.iter().any(|&own| data[own].is_point) {
            return Err(wrong("names a point of a recorded history".to_owned()));
        }
        let distinct: std::collections::BTreeSet<usize> = places.iter().copied().collect();
        if distinct.len() < places.len() {
            return Err(wrong("names a measurement twice".to_owned()));
        }
        let r = root.number("correlation", r, |text| measure(text, NUMBER))?;
        if places.len() < 2 || !(-1.0..1.0).contains(&r) {
            return Err(wrong(
                "needs two measurements or more, and r between -1 and 1".to_owned(),
            ));
        }
        all.push(Correlation { data: places, r });
    }
    Ok(all)
}

/// The table of a measurement of the cycle.
struct Of<'a, 't, 'i> {
    table: &'a Keys<'t, 'i>,
    assembly: Option<&'a Assembly>,
    conditions: &'a [Condition],
    instruments: &'a [(String, Keys<'t, 'i>)],
}

impl Of<'_, '_, '_> {
    fn measured(&self, name: &str, notes: &mut Vec<String>) -> Result<Measured, KeyError> {
        let table = self.table;
        let reader = QuantityReader {
            table,
            assembly: self.assembly,
            is_trace: false,
        };
        reader.refuse_other_kinds()?;
        table.only(&MEASURED)?;
        let condition = condition_of(table, self.conditions)?;
        let quantity = reader.quantity()?;
        reader.within_the_record("at", &quantity, &self.conditions[condition])?;
        let dimension = quantity.dimension();
        let repeats = self.repeats(&quantity, &self.conditions[condition])?;
        let own = error(table, dimension)?.at(repeats.typical);
        let scatter = repeats.scatter.unwrap_or_else(|| {
            notes.push(format!(
                "`{name}` states no scatter of its shots: {} is assumed",
                shown(quantity.scatter(repeats.typical), dimension)
            ));
            quantity.scatter(repeats.typical)
        });
        // A sum over many shots is a single reading.
        let is_sum = quantity.is_air_consumption() && repeats.shots > 1.0 && table.get("values").is_none();
        let (own, repeated) = match is_sum {
            true => (own / repeats.shots, 1.0),
            false => (own, repeats.shots),
        };
        let variance = own.powi(2) / repeated + scatter.powi(2) / repeats.shots;
        if quantity.depends_on_the_hand() {
            notes.push(format!("`{name}` depends on hand and trigger, whose errors are wide"));
        }
        let discrepancy = stated_spread(table, "discrepancy", dimension)?;
        let discrepancy =
            discrepancy.map_or_else(|| quantity.discrepancy(repeats.typical), |own| own.at(repeats.typical));
        if variance + discrepancy * discrepancy <= 0.0 {
            let help = "give the error as an amount: percentages of 0 are 0";
            return Err(table.error("error", "is 0 at this value", help));
        }
        let instrument = instrument_of(table, self.instruments, dimension)?;
        let instrument = instrument.map(|(instrument, error)| InstrumentError {
            instrument,
            deviation: error.at(repeats.typical),
        });
        Ok(Measured {
            name: name.to_owned(),
            condition,
            quantity,
            reading: repeats.reading,
            is_point: false,
            error: variance.sqrt(),
            discrepancy,
            instrument,
        })
    }

    fn repeats(&self, quantity: &Quantity, condition: &Condition) -> Result<Repeats, KeyError> {
        let table = self.table;
        let dimension = quantity.dimension();
        let ambient = quantity
            .is_absolute_pressure()
            .then_some(condition.design.ambient.pressure);
        let read = |key: &str, value: &Value<'_>| {
            let own = scalar(table, key, value, dimension, ambient)?;
            if own < 0.0 && quantity.is_positive() {
                let problem = format!("is {}, below 0", found(value.get_ref()));
                return Err(table.wrong(key, value.span(), problem, "correct the sign".to_owned()));
            }
            Ok(own)
        };
        let get = |key: &str| table.get(key).map(|value| read(key, value)).transpose();
        let (value, most, least) = (get("value")?, get("at_most")?, get("at_least")?);
        of_given(table)?;
        let scatter =
            stated_spread(table, "scatter", dimension)?.map(|own| own.at(value.or(most).or(least).unwrap_or_default()));
        if let Some(list) = repeated(table, &read)? {
            let (mean, scatter) = mean_and_scatter(&list, |mean| quantity.scatter(mean));
            return Ok(Repeats {
                reading: Reading::Value(mean),
                typical: mean,
                shots: list.len() as f64,
                scatter: Some(scatter),
            });
        }
        let shots = table.count("shots", MOST_SHOTS)?.unwrap_or(1) as f64;
        let of_one = if quantity.is_air_consumption() {
            1.0 / shots
        } else {
            1.0
        };
        let reading = reading(table, [value, most, least], |own| of_one * own)?;
        let typical = match reading {
            Reading::Value(value) | Reading::AtMost(value) | Reading::AtLeast(value) => value,
            Reading::Within([low, high]) => 0.5 * (low + high),
        };
        Ok(Repeats {
            reading,
            typical,
            shots,
            scatter,
        })
    }
}

/// Formats a value with the unit of its dimension.
fn shown(value: f64, dimension: Dimension) -> String {
    format!("{} {}", nailnoise_quantities::rounded(value, 3, 1e5), dimension.unit())
}

#[cfg(test)]
mod tests;

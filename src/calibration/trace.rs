//! Reads a recorded history as measurements: points of a pressure or a travel over time.

use nailnoise_calibration::likelihood::Reading;
use nailnoise_documents::tables::{Heading, Table, TableFault, si_of, spelled, time};
use nailnoise_documents::{Document, KeyError, Keys, read_regular};
use nailnoise_dynamics::network::Assembly;
use nailnoise_quantities::dimension::{PRESSURE, TIME};
use nailnoise_quantities::{measure, quantity};

use super::fields::{condition_of, error, instrument_of, place, stated_spread};
use super::measurements::{COMMON, Condition, InstrumentError, Measured};
use super::quantities::Quantity;
use super::quantity_reader::{OF_TRACE, QuantityReader};

/// Keys of such a measurement.
const MEASURED: [&str; 15] = [
    "condition",
    "quantity",
    "of",
    "file",
    "column",
    "align",
    "from",
    "to",
    "points",
    "scatter",
    "error",
    "rounding",
    "k",
    "instrument",
    "discrepancy",
];

/// Largest file accepted \[byte\].
const LARGEST: u64 = 64 << 20;

/// Largest number of points; a record of a slow change does not contain more independent values.
const MOST_POINTS: usize = 100;

/// Number of points, if the file of measurements does not state it.
const POINTS: usize = 8;

/// Latest time of a point before or after its event \[s\].
const LATEST: f64 = 10.0;

/// The table of a measurement that names a recorded history.
pub(super) struct TraceReader<'a, 't, 'i> {
    pub(super) table: &'a Keys<'t, 'i>,
    pub(super) document: &'a Document,
    /// The assembly of the design; none for the tool of the keys.
    pub(super) assembly: Option<&'a Assembly>,
    pub(super) conditions: &'a [Condition],
    pub(super) instruments: &'a [(String, Keys<'t, 'i>)],
}

/// A recorded history in SI units.
#[derive(Debug, PartialEq)]
struct History {
    /// Times \[s\], ascending.
    times: Vec<f64>,
    values: Vec<f64>,
}

impl TraceReader<'_, '_, '_> {
    /// Whether a table names a recorded history.
    pub(super) fn is_trace(table: &Keys<'_, '_>) -> bool {
        let name = table.get("quantity").and_then(|own| own.get_ref().as_str());
        table.get("file").is_some() && name.is_some_and(|name| OF_TRACE.contains(&name))
    }

    /// Reads the points. All of them together count as one reading of the model error and of the scatter between
    /// shots: both change slowly, so that the points of one history do not average them out.
    ///
    /// # Errors
    /// The first invalid key, with its place and remedy; or if the file does not contain the history.
    pub(super) fn measured(&self, name: &str, notes: &mut Vec<String>) -> Result<Vec<Measured>, KeyError> {
        let table = self.table;
        table.only(&MEASURED)?;
        let condition = condition_of(table, self.conditions)?;
        let reader = QuantityReader {
            table,
            assembly: self.assembly,
            is_trace: true,
        };
        let template = reader.quantity()?;
        let history = self.history(&template, &self.conditions[condition])?;
        let times = self.times(&history)?;
        for (key, place) in [("from", 0), ("to", times.len() - 1)] {
            let end = template.clone().after(times[place]);
            reader.within_the_record(key, &end, &self.conditions[condition])?;
        }
        let dimension = template.dimension();
        let own = error(table, dimension)?;
        let stated = stated_spread(table, "scatter", dimension)?;
        if stated.is_none() {
            notes.push(format!(
                "`{name}` states no scatter between shots: that of its quantity is assumed"
            ));
        }
        let discrepancy = stated_spread(table, "discrepancy", dimension)?;
        let instrument = instrument_of(table, self.instruments, dimension)?;
        let count = times.len() as f64;
        let point = |(number, time): (usize, f64)| {
            let value = history.at(time);
            let quantity = template.clone().after(time);
            let discrepancy = discrepancy.map_or_else(|| quantity.discrepancy(value), |own| own.at(value));
            let scatter = stated.map_or_else(|| quantity.scatter(value), |own| own.at(value));
            let independent = if quantity.family().is_some() { 1.0 - COMMON } else { 1.0 };
            let of_shot = scatter.powi(2) + independent * discrepancy.powi(2);
            let variance = own.at(value).powi(2) + count * of_shot - independent * discrepancy.powi(2);
            let error = variance.sqrt();
            if error + discrepancy <= 0.0 {
                let help = "give the error as an amount: percentages of 0 are 0";
                return Err(table.error("error", "is 0 at a point of the history", help));
            }
            let instrument = instrument.map(|(instrument, error)| InstrumentError {
                instrument,
                deviation: error.at(value),
            });
            Ok(Measured {
                name: format!("{name}-{}", number + 1),
                condition,
                quantity,
                reading: Reading::Value(value),
                is_point: true,
                error,
                discrepancy,
                instrument,
            })
        };
        times.into_iter().enumerate().map(point).collect()
    }

    /// Times of the points in the file \[s\].
    fn times(&self, history: &History) -> Result<Vec<f64>, KeyError> {
        let table = self.table;
        let ends = [history.times[0], history.times[history.times.len() - 1]];
        let time = |key: &str, default: f64| {
            let Some(value) = table.get(key) else {
                return Ok(default);
            };
            let time = table.number(key, value, |text| measure(text, TIME))?;
            if time < ends[0] || time > ends[1] {
                let problem = format!("is {time} s, outside the history from {} to {} s", ends[0], ends[1]);
                return Err(table.error(key, problem, "give a time of the file"));
            }
            table.within(key, time, [-LATEST, LATEST], "s")
        };
        let [from, to] = [time("from", ends[0])?, time("to", ends[1])?];
        let points = table.count("points", MOST_POINTS)?.unwrap_or(POINTS);
        if points > 1 && from >= to {
            return Err(table.error(
                "from",
                format!("is {from} s, not before the last time, {to} s"),
                "give times in their order",
            ));
        }
        let step = (to - from) / points.saturating_sub(1).max(1) as f64;
        // Rounding must not move the last point beyond the end.
        Ok((0..points)
            .map(|k| (from + step * k as f64).min(to.max(from)))
            .collect())
    }

    fn history(&self, quantity: &Quantity, condition: &Condition) -> Result<History, KeyError> {
        let table = self.table;
        const EXAMPLE: &str = "\"pressure.csv\"";
        let path = self.document.sibling(table.text("file", EXAMPLE)?.unwrap_or_default());
        let unusable = |problem: String, help: &str| {
            table.error("file", format!("cannot be used: {}: {problem}", path.display()), help)
        };
        let columns = |fault: &TableFault| unusable(fault.to_string(), "give a CSV file with times and this quantity");
        let bytes = read_regular(&path, LARGEST).map_err(|error| unusable(error.to_string(), "correct the path"))?;
        let found = Table::read(&bytes, |headings| time(headings).is_some()).map_err(|fault| columns(&fault))?;
        let Some(of_time) = time(&found.headings) else {
            let problem = format!("no column of {} is the time", found.known());
            return Err(unusable(problem, "name it \"time [s]\", or with another unit of time"));
        };
        let of_value = self.column(&found, of_time)?;
        let seconds = match found.headings[of_time].unit.as_str() {
            "" => Ok(1.0),
            unit => si_of(unit, TIME),
        };
        let seconds = seconds.map_err(|problem| {
            let unit = &found.headings[of_time].unit;
            unusable(
                format!("the unit \"{unit}\" of the times: {problem}"),
                "give a unit of time, as \"time [ms]\"",
            )
        })?;
        let [factor, zero] = unit(&found.headings[of_value], quantity, condition).map_err(|problem| {
            let heading = &found.headings[of_value].text;
            unusable(
                format!("the column \"{heading}\": {problem}"),
                "give its unit in the heading, as \"p1 [kPa]\"",
            )
        })?;
        let read = found.columns(&[of_time, of_value]).map_err(|fault| columns(&fault))?;
        let [times, values] = [0, 1].map(|place| &read.values[place]);
        if times.len() != values.len() || times.len() < 2 {
            let problem = format!("it has {} times and {} values", times.len(), values.len());
            return Err(unusable(problem, "give a value for each of two times or more"));
        }
        if let Some(place) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let problem = format!("line {}: the time does not increase", read.lines[place + 1]);
            return Err(unusable(problem, "sort the rows by time, one row for each"));
        }
        if let Some(place) = values
            .iter()
            .position(|own| quantity.is_positive() && zero + factor * own < 0.0)
        {
            let problem = format!("line {}: the value is below 0", read.lines[place]);
            return Err(unusable(
                problem,
                "correct the sign; a gauge pressure has the unit barg, kPag or psig",
            ));
        }
        Ok(History {
            times: times.iter().map(|own| seconds * own).collect(),
            values: values.iter().map(|own| zero + factor * own).collect(),
        })
    }

    /// The column of the history: the one named, or the only one besides the times.
    fn column(&self, found: &Table, of_time: usize) -> Result<usize, KeyError> {
        let table = self.table;
        let others: Vec<usize> = (0..found.headings.len()).filter(|own| *own != of_time).collect();
        let Some(name) = table.text("column", "\"p1 [kPa]\"")? else {
            return match others[..] {
                [only] => Ok(only),
                _ => {
                    let help = format!("choose from {}", found.known());
                    Err(table.error("column", "is missing, and the file has several", help))
                }
            };
        };
        let is_named = |own: &usize| {
            let heading = &found.headings[*own];
            heading.text == name || heading.name == name
        };
        let mut named = others.iter().copied().filter(is_named);
        match (named.next(), named.next()) {
            (Some(only), None) => Ok(only),
            (Some(_), Some(_)) => Err(table.error("column", "names several columns", "give the complete heading")),
            _ => {
                let known = others.iter().map(|own| found.headings[*own].text.as_str());
                place(table, "column", name, known, "column").map(|at| others[at])
            }
        }
    }
}

impl History {
    /// The value at a time, linear between the samples.
    fn at(&self, time: f64) -> f64 {
        let after = self
            .times
            .partition_point(|own| *own < time)
            .clamp(1, self.times.len() - 1);
        let [t0, t1] = [self.times[after - 1], self.times[after]];
        let share = (time - t0) / (t1 - t0);
        (1.0 - share) * self.values[after - 1] + share * self.values[after]
    }
}

/// Factor from the unit of a column to SI, and the value of its zero: the ambient pressure for a gauge pressure.
fn unit(heading: &Heading, of: &Quantity, condition: &Condition) -> Result<[f64; 2], String> {
    if heading.unit.is_empty() {
        return Err("it has no unit".to_owned());
    }
    let dimension = of.dimension();
    let text = format!("1 {}", spelled(&heading.unit));
    match quantity(&text, dimension, dimension == PRESSURE) {
        Ok(read) => Ok([read.si, read.absolute(condition.design.ambient.pressure) - read.si]),
        Err(_) => si_of(&heading.unit, dimension).map(|factor| [factor, 0.0]),
    }
}

#[cfg(test)]
mod tests;

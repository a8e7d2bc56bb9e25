//! Reads measurements of sound and vibration in the file of measurements. All become levels in decibels.

use nailnoise_calibration::likelihood::Reading;
use nailnoise_documents::{KeyError, Keys, Value, found};
use nailnoise_quantities::dimension::ACCELERATION;
use nailnoise_quantities::measure;

use super::fields::{
    MOST_SHOTS, Repeats, condition_of, error_by, mean_and_scatter, named, of_given, place, reading, repeated, spread_by,
};
use super::level_bands::band;
use super::level_quantities::{LevelQuantity, NAMES, Position, STANDARD_GRAVITY};
use super::measurements::{Condition, InstrumentError, MeasuredLevel};
use super::spread::Spread;
use crate::design::inputs;
use crate::model::sources;

/// Keys of a measurement.
const MEASURED: [&str; 17] = [
    "condition",
    "quantity",
    "of",
    "source",
    "sensor",
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
    "band",
];

/// Name of all sources together.
const TOTAL: &str = crate::result::TOTAL;

/// Relative change of an amplitude that is 1 dB, for small changes.
const DECIBELS: f64 = 20.0 * std::f64::consts::LOG10_E;

/// The table of a measurement of sound or vibration.
pub(super) struct OfLevel<'a, 't, 'i> {
    pub(super) table: &'a Keys<'t, 'i>,
    pub(super) conditions: &'a [Condition],
    pub(super) instruments: &'a [(String, Keys<'t, 'i>)],
}

/// Quantity in which the values of a measurement are given.
#[derive(Clone, Copy)]
enum Given {
    Decibels,
    Acceleration,
}

impl Given {
    /// A number of the file.
    fn parse(self, text: &str) -> Result<f64, String> {
        let number = |text: &str| {
            let number = text.trim().parse::<f64>().ok();
            number.filter(|own| own.is_finite())
        };
        match self {
            Self::Decibels => {
                let own = text.trim();
                let own = own.strip_suffix("dB").unwrap_or(own);
                number(own).ok_or_else(|| "expected a level in dB".to_owned())
            }
            // For accelerometers, `g` is the acceleration due to gravity; in other keys, it is the gram.
            Self::Acceleration => match text.trim().strip_suffix('g').and_then(number) {
                Some(own) => Ok(own * STANDARD_GRAVITY),
                None => measure(text, ACCELERATION).map_err(|problem| format!("{problem}, or g")),
            },
        }
    }

    /// A value as a level \[dB\].
    fn level(self, value: f64) -> f64 {
        match self {
            Self::Decibels => value,
            Self::Acceleration => 20.0 * value.log10(),
        }
    }

    /// A standard deviation of a value \[dB\].
    fn deviation(self, spread: Spread, value: f64) -> f64 {
        match self {
            Self::Decibels => spread.amount,
            Self::Acceleration => DECIBELS * spread.at(value) / value,
        }
    }
}

/// A standard deviation of a level \[dB\].
///
/// # Errors
/// If it is not a number, or a percentage.
pub(super) fn decibels(table: &Keys<'_, '_>, key: &str) -> Result<f64, KeyError> {
    let own = spread_by(table, key, &|text| Given::Decibels.parse(text))?;
    match own.share > 0.0 {
        true => Err(table.error(key, "is a percentage of a level", "give it in dB")),
        false => Ok(own.amount),
    }
}

impl OfLevel<'_, '_, '_> {
    /// Whether a table is a measurement of sound or vibration.
    pub(super) fn is_level(table: &Keys<'_, '_>) -> bool {
        let name = table.get("quantity").and_then(|own| own.get_ref().as_str());
        name.is_some_and(|name| NAMES.contains(&name))
    }

    /// Reads the measurement.
    ///
    /// # Errors
    /// The first invalid key, with its place and remedy.
    pub(super) fn measured(&self, name: &str, notes: &mut Vec<String>) -> Result<MeasuredLevel, KeyError> {
        let table = self.table;
        table.only(&MEASURED)?;
        let condition = condition_of(table, self.conditions)?;
        let (quantity, given) = self.quantity(&self.conditions[condition])?;
        let repeats = self.repeats(&quantity, given)?;
        let spread = |table: &Keys<'_, '_>, key: &str| match given {
            Given::Decibels => decibels(table, key),
            Given::Acceleration => {
                let own = spread_by(table, key, &|text| given.parse(text))?;
                Ok(given.deviation(own, repeats.typical))
            }
        };
        let own = error_by(table, &|text| given.parse(text))?;
        if own.share > 0.0 && matches!(given, Given::Decibels) {
            return Err(table.error("error", "is a percentage of a level", "give it in dB"));
        }
        let own = given.deviation(own, repeats.typical);
        let scatter = match (repeats.scatter, table.get("scatter")) {
            (Some(scatter), _) => scatter,
            (None, Some(_)) => spread(table, "scatter")?,
            (None, None) => {
                notes.push(format!(
                    "`{name}` states no scatter of its shots: {} dB is assumed",
                    quantity.scatter()
                ));
                quantity.scatter()
            }
        };
        let discrepancy = match table.get("discrepancy") {
            Some(_) => spread(table, "discrepancy")?,
            None => quantity.discrepancy(),
        };
        let instrument = match table.get("instrument") {
            Some(_) => {
                let instrument = named(table, "instrument", self.instruments)?;
                Some(InstrumentError {
                    instrument,
                    deviation: spread(&self.instruments[instrument].1, "error")?,
                })
            }
            None => None,
        };
        Ok(MeasuredLevel {
            name: name.to_owned(),
            condition,
            quantity,
            reading: repeats.reading,
            error: ((own * own + scatter * scatter) / repeats.shots).sqrt(),
            discrepancy,
            instrument,
        })
    }

    fn quantity(&self, condition: &Condition) -> Result<(LevelQuantity, Given), KeyError> {
        let table = self.table;
        let name = table.text("quantity", "\"level\"")?.unwrap_or_default();
        let foreign: &[&str] = if name == "level" {
            &["sensor"]
        } else {
            &["source", "of", "band"]
        };
        if let Some(other) = foreign.iter().find(|key| table.get(key).is_some()) {
            return Err(table.error(other, format!("does not belong to `{name}`"), "remove it"));
        }
        if name != "level" {
            table.required("sensor", "\"block_top\", a sensor of the design")?;
            let sensor = table.text("sensor", "\"block_top\"")?.unwrap_or_default();
            let known = inputs::sensors::accelerometers(&condition.design);
            let known = known.map_err(|error| table.error("sensor", error.to_string(), "correct the design"))?;
            let names = known.iter().map(|own| own.name.as_str());
            if known.is_empty() {
                let help = "add [sensors.NAME] to the design; docs/design-file.md describes its keys";
                return Err(table.error("sensor", "needs a sensor on a body of the design, which has none", help));
            }
            place(table, "sensor", sensor, names, "sensor of the design")?;
            let quantity = LevelQuantity::Acceleration {
                sensor: sensor.to_owned(),
                is_peak: name == "peak_acceleration",
            };
            return Ok((quantity, Given::Acceleration));
        }
        let source = match table.text("source", "\"exhaust\"")? {
            None | Some(TOTAL) => None,
            Some(source) => {
                let known: Vec<&str> = sources::names().chain([TOTAL]).collect();
                place(table, "source", source, known.iter().copied(), "source")?;
                Some(source.to_owned())
            }
        };
        let position = match table.text("of", "\"microphone-3\"")? {
            None => Position::Power,
            Some(name) => {
                let array = inputs::microphones::array(&condition.design);
                let array = array.map_err(|error| table.error("of", error.to_string(), "correct the design"))?;
                let known = Position::all(array.positions().len());
                let names = known.iter().map(|(name, _)| name.as_str());
                known[place(table, "of", name, names, "position of a level")?].1
            }
        };
        let band = match table.get("band") {
            Some(value) => Some(band(table, value, &condition.design)?),
            None => None,
        };
        let quantity = LevelQuantity::Sound { source, position, band };
        Ok((quantity, Given::Decibels))
    }

    fn repeats(&self, quantity: &LevelQuantity, given: Given) -> Result<Repeats, KeyError> {
        let table = self.table;
        let read = |key: &str, value: &Value<'_>| {
            let own = table.number(key, value, |text| given.parse(text))?;
            if own <= 0.0 && matches!(given, Given::Acceleration) {
                let problem = format!("is {}, not above 0", found(value.get_ref()));
                return Err(table.wrong(key, value.span(), problem, "correct the sign".to_owned()));
            }
            Ok(own)
        };
        of_given(table)?;
        if let Some(list) = repeated(table, &read)? {
            let levels: Vec<f64> = list.iter().map(|own| given.level(*own)).collect();
            let (mean, scatter) = mean_and_scatter(&levels, |_| quantity.scatter());
            return Ok(Repeats {
                reading: Reading::Value(mean),
                typical: list.iter().sum::<f64>() / list.len() as f64,
                shots: list.len() as f64,
                scatter: Some(scatter),
            });
        }
        let get = |key: &str| table.get(key).map(|value| read(key, value)).transpose();
        let (value, most, least) = (get("value")?, get("at_most")?, get("at_least")?);
        Ok(Repeats {
            reading: reading(table, [value, most, least], |own| given.level(own))?,
            typical: value.or(most).or(least).unwrap_or_default(),
            shots: table.count("shots", MOST_SHOTS)?.unwrap_or(1) as f64,
            scatter: None,
        })
    }
}

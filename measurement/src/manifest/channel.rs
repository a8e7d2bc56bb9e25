//! `[channels]` of a manifest: where each channel is recorded, and what its numbers mean.

use nailnoise_quantities::dimension::FREQUENCY;

use crate::recordings::{Calibration, Calibrator, FullScale, Quantity, Selector, calibrator_rms};
use nailnoise_documents::KeyError;
use nailnoise_documents::Keys;

/// Kinds of channels by their names in a manifest.
const KINDS: [(&str, Kind); 4] = [
    ("microphone", Kind::Microphone),
    ("accelerometer", Kind::Accelerometer),
    ("pressure", Kind::Pressure),
    ("trigger", Kind::Trigger),
];

/// Keys of a channel.
const KEYS: [&str; 9] = [
    "file",
    "channel",
    "column",
    "kind",
    "position",
    "sensitivity",
    "full_scale",
    "unit",
    "calibrator",
];

/// Largest number of channels in a file.
const MOST_CHANNELS: usize = 65_535;

/// Kind of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Microphone,
    Accelerometer,
    Pressure,
    /// A switch, whose voltage marks the start of the shot.
    Trigger,
}

impl Kind {
    pub(super) fn quantity(self) -> Quantity {
        match self {
            Self::Microphone | Self::Pressure => Quantity::Pressure,
            Self::Accelerometer => Quantity::Acceleration,
            Self::Trigger => Quantity::Voltage,
        }
    }
}

/// A channel of the manifest.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// File name, with `{c}` and `{k}` for configuration and repeat.
    pub(super) file: String,
    pub(super) selector: Selector,
    pub(super) calibration: Calibration,
    /// Position of a microphone \[m\].
    pub(super) position: Option<[f64; 3]>,
}

/// The number in a microphone's name: `mic` followed by digits.
fn microphone(name: &str) -> Option<&str> {
    let digits = name.strip_prefix("mic")?;
    digits.chars().all(|digit| digit.is_ascii_digit()).then_some(digits)
}

impl Channel {
    /// Reads the channel of a name.
    pub(super) fn read(channels: &Keys<'_, '_>, name: &str) -> Result<Self, KeyError> {
        let table = channels.table(name, "{ file = \"{c}-{k}.wav\", channel = 1, ... }")?;
        let Some(table) = table else {
            return Err(channels.error(name, "is missing", "add the channel"));
        };
        table.only(&KEYS)?;
        let kind = kind(&table, name)?;
        let file = file(&table)?;
        if let Some(mark) = placeholders(&file).find(|mark| !["c", "k"].contains(mark)) {
            let help = "{c} is the name of the configuration, {k} the repeat from 1";
            return Err(table.error("file", format!("has the placeholder {{{mark}}}"), help));
        }
        let position = match (kind, table.get("position")) {
            (Kind::Microphone, _) => {
                let value = table.required("position", "[1, 0, 0.969]")?;
                Some(table.point("position", value)?)
            }
            (_, Some(_)) => {
                let help = "remove it; `kind = \"microphone\"` makes a channel mic1 to mic9 a microphone";
                return Err(table.error("position", "belongs to microphones", help));
            }
            (_, None) => None,
        };
        Ok(Self {
            name: name.to_owned(),
            kind,
            selector: selector(&table)?,
            calibration: calibration(&table, kind.quantity())?,
            file,
            position,
        })
    }

    /// The file of a shot, relative to the manifest.
    pub(super) fn file(&self, configuration: &str, repeat: usize) -> String {
        // Replaced in one pass, so that a name cannot contain placeholders.
        let mut path = String::new();
        let mut rest = self.file.as_str();
        while let Some((before, mark, after)) = placeholder(rest) {
            path.push_str(before);
            match mark {
                "c" => path.push_str(configuration),
                _ => path.push_str(&repeat.to_string()),
            }
            rest = after;
        }
        path.push_str(rest);
        path
    }

    /// Whether the file name contains the placeholder.
    pub(super) fn has(&self, mark: &str) -> bool {
        placeholders(&self.file).any(|own| own == mark)
    }
}

/// The first `{mark}` in a text, with the text before and after it.
fn placeholder(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once('{')?;
    let (mark, after) = rest.split_once('}')?;
    Some((before, mark, after))
}

fn placeholders(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (_, mark, after) = placeholder(rest)?;
        rest = after;
        Some(mark)
    })
}

fn kind(table: &Keys<'_, '_>, name: &str) -> Result<Kind, KeyError> {
    let given = table.text("kind", "\"accelerometer\"")?;
    let given = given.map(|word| {
        let kind = KINDS.into_iter().find(|(own, _)| *own == word);
        kind.map(|(_, kind)| kind).ok_or_else(|| {
            let known = KINDS.map(|(own, _)| own).join(", ");
            table.error("kind", format!("is \"{word}\""), format!("choose from {known}"))
        })
    });
    let given = given.transpose()?;
    let number = microphone(name);
    if given == Some(Kind::Microphone) || (given.is_none() && number.is_some()) {
        let known = number.is_some_and(|digits| digits.len() == 1 && digits != "0");
        return if known {
            Ok(Kind::Microphone)
        } else {
            let help = "name the microphones of EN 12549 mic1 to mic9, and give other channels another `kind`";
            Err(table.wrong(
                "",
                table.span(),
                "is not a microphone of EN 12549".to_owned(),
                help.to_owned(),
            ))
        };
    }
    Ok(given.unwrap_or(if name.starts_with("PT-") {
        Kind::Pressure
    } else {
        Kind::Accelerometer
    }))
}

fn file(table: &Keys<'_, '_>) -> Result<String, KeyError> {
    table.required("file", "\"{c}-{k}.wav\"")?;
    Ok(table.text("file", "\"{c}-{k}.wav\"")?.unwrap_or_default().to_owned())
}

fn selector(table: &Keys<'_, '_>) -> Result<Selector, KeyError> {
    let number = table.count("channel", MOST_CHANNELS)?;
    match (number, table.text("column", "\"N [g]\"")?) {
        (Some(_), Some(_)) => {
            let help = "keep `channel` for WAV and universal files, `column` for CSV files";
            Err(table.error("column", "is given in addition to `channel`", help))
        }
        (None, Some(column)) => Ok(Selector::Column(column.trim().to_owned())),
        (number, None) => Ok(Selector::Channel(number.unwrap_or(1))),
    }
}

fn calibration(table: &Keys<'_, '_>, quantity: Quantity) -> Result<Calibration, KeyError> {
    let refused = |key: &str, text: &str, problem: String| {
        let help = format!("give a unit of {}", quantity.examples());
        table.error(key, format!("is \"{text}\": {problem}"), help)
    };
    let sensitivity = table.text("sensitivity", "\"50 mV/Pa\"")?;
    let sensitivity = sensitivity.map(|text| {
        let read = quantity
            .sensitivity(text)
            .map_err(|problem| refused("sensitivity", text, problem))?;
        stated(table, "sensitivity", text)?;
        let magnitude = within(
            table,
            "sensitivity",
            read.abs(),
            SENSITIVITIES,
            of_sensitivity(quantity),
        );
        magnitude.map(|_| read)
    });
    let sensitivity = sensitivity.transpose()?;
    let full_scale = table.text("full_scale", "\"10 V\"")?.map(|text| {
        let own = quantity.read(text).map(FullScale::Quantity);
        let read = own.or_else(|problem| Quantity::Voltage.read(text).map(FullScale::Volts).map_err(|_| problem));
        let read = read.map_err(|problem| refused("full_scale", text, problem))?;
        stated(table, "full_scale", text)?;
        let (value, of) = match read {
            FullScale::Quantity(value) => (value, quantity),
            FullScale::Volts(value) => (value, Quantity::Voltage),
        };
        within(table, "full_scale", value, of.limits(), of.unit())?;
        Ok(read)
    });
    let full_scale = full_scale.transpose()?;
    match (sensitivity, full_scale) {
        (None, Some(FullScale::Volts(_))) => {
            let help = "give `sensitivity`, as \"50 mV/Pa\", or `full_scale` in the quantity of the channel";
            return Err(table.error("full_scale", "is in V, and `sensitivity` is missing", help));
        }
        (Some(_), Some(FullScale::Quantity(_))) => {
            let help = "give `full_scale` in V, or remove `sensitivity`";
            return Err(table.error("full_scale", "is not a voltage, and `sensitivity` is given", help));
        }
        _ => {}
    }
    let unit = table.text("unit", "\"Pa\"")?;
    if let Some(unit) = unit {
        Calibration::check_unit(unit, quantity).map_err(|problem| refused("unit", unit, problem))?;
    }
    let calibrator = calibrator(table, quantity)?;
    let others = [
        ("sensitivity", sensitivity.is_some()),
        ("full_scale", full_scale.is_some()),
        ("unit", unit.is_some()),
    ];
    if calibrator.is_some()
        && let Some((key, _)) = others.iter().find(|(_, given)| *given)
    {
        return Err(table.error(
            key,
            "is given in addition to `calibrator`",
            "keep one of both: the calibrator's record determines the scale",
        ));
    }
    Ok(Calibration {
        sensitivity,
        full_scale,
        unit: unit.map(str::to_owned),
        calibrator,
    })
}

/// SI unit of a sensitivity.
fn of_sensitivity(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Pressure => "V/Pa",
        Quantity::Acceleration => "V/(m/s2)",
        Quantity::Voltage => "V/V",
    }
}

/// Smallest and largest sensitivity \[V per SI unit\]: 1 pV/Pa is below that of blast gauges, 1 kV/(m/s²) above that of
/// seismometers.
const SENSITIVITIES: [f64; 2] = [1e-12, 1e3];

/// Rejects a text without a unit, because the number could be meant in V, Pa or dB.
fn stated(table: &Keys<'_, '_>, key: &str, text: &str) -> Result<(), KeyError> {
    if text.trim().parse::<f64>().is_ok() {
        let help = "give the unit, as \"200 Pa\", \"500 g\", \"10 V\"; a sensitivity as \"50 mV/Pa\"";
        return Err(table.error(key, format!("is \"{text}\", which has no unit"), help));
    }
    Ok(())
}

/// A value within limits, in SI units.
fn within(table: &Keys<'_, '_>, key: &str, value: f64, [low, high]: [f64; 2], unit: &str) -> Result<f64, KeyError> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    let problem = format!("is {value:e} {unit}, outside {low:e} to {high:e} {unit}");
    Err(table.error(key, problem, "correct the value, or its unit"))
}

fn calibrator(table: &Keys<'_, '_>, quantity: Quantity) -> Result<Option<Calibrator>, KeyError> {
    let example = "{ file = \"calibrator.wav\", level = \"94 dB\", frequency = \"1 kHz\" }";
    let Some(table) = table.table("calibrator", example)? else {
        return Ok(None);
    };
    table.only(&["file", "channel", "column", "level", "frequency"])?;
    let file = file(&table)?;
    if placeholders(&file).next().is_some() {
        return Err(table.error("file", "has a placeholder", "name the one record of the calibrator"));
    }
    table.required("level", "\"94 dB\"")?;
    // A number alone could be meant in Pa or in dB.
    let level = table.text("level", "\"94 dB\"")?.unwrap_or_default();
    let rms = calibrator_rms(level, quantity).map_err(|problem| {
        let help = "give a level, as \"94 dB\", or an RMS, as \"10 m/s2\"";
        table.error("level", format!("is \"{level}\": {problem}"), help)
    })?;
    stated(&table, "level", level)?;
    let frequency = table.quantity("frequency", FREQUENCY, [20.0, 10e3])?;
    Ok(Some(Calibrator {
        rms: within(&table, "level", rms, quantity.limits(), quantity.unit())?,
        selector: selector(&table)?,
        // IEC 60942: 1 kHz is the usual frequency of a sound calibrator.
        frequency: frequency.unwrap_or(1e3),
        file,
        factor: None,
    }))
}

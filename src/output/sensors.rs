//! What the sensors recorded: `sensors.csv`, `sensors-spectrum.csv`, `transducers.csv`, and `sensors.uff` and `transducers.uff`
//! for modal-test software.

use std::fmt::Write;

use nailnoise_acoustics::fourier::{Transform, TransformSettings};

use super::File;
use super::digits::exponential;
use super::table::numbers;
use crate::error::Error;
use crate::run::Run;
use crate::stages::sensors::SensorRecord;
use crate::stages::transducers::PressureRecord;

/// Lowest frequency of the spectra \[Hz\].
const SPECTRUM_FROM: f64 = 5.0;

/// Highest frequency of the spectra \[Hz\].
const SPECTRUM_TO: f64 = 20e3;

/// A time history in a universal file.
struct TimeHistory<'a> {
    /// Name of the sensor.
    name: &'a str,
    /// Where it is.
    place: &'static str,
    /// Specific data type, name and unit of what it measures.
    quantity: (u8, &'static str, &'static str),
    /// Sampling interval \[s\].
    interval: f64,
    /// Readings in that unit.
    values: &'a [f64],
}

impl<'a> From<&'a SensorRecord> for TimeHistory<'a> {
    fn from(sensor: &'a SensorRecord) -> Self {
        Self {
            name: &sensor.name,
            place: sensor.body.as_str(),
            quantity: (12, "acceleration", "m/s2"),
            interval: sensor.interval,
            values: &sensor.acceleration,
        }
    }
}

impl<'a> From<&'a PressureRecord> for TimeHistory<'a> {
    fn from(transducer: &'a PressureRecord) -> Self {
        Self {
            name: &transducer.name,
            place: transducer.chamber.as_str(),
            quantity: (15, "pressure", "Pa"),
            interval: transducer.interval,
            values: &transducer.values,
        }
    }
}

/// The files of accelerometers and pressure transducers; none of a kind that the design does not have.
pub(super) fn files(run: &Run) -> Result<Vec<File>, Error> {
    let mut files = of_accelerometers(run)?;
    files.extend(of_transducers(run)?);
    Ok(files)
}

/// Name of a sensor and where it is.
fn title(name: &str, place: &str) -> String {
    format!("{name} ({place})")
}

fn of_transducers(run: &Run) -> Result<Vec<File>, Error> {
    let transducers = &run.transducers;
    let Some(interval) = transducers.first().map(|first| first.interval) else {
        return Ok(Vec::new());
    };
    let titles = transducers
        .iter()
        .map(|own| title(&own.name, own.chamber.as_str()) + " [Pa]");
    let columns: Vec<&[f64]> = transducers.iter().map(|own| own.values.as_slice()).collect();
    let table = numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|sample| sample as f64 * interval, 7),
        (&columns, 6),
    )?;
    Ok(vec![
        File::new("transducers.csv", table),
        File::new("transducers.uff", universal(run, transducers.iter().map(Into::into))),
    ])
}

/// Time histories as a universal file.
fn universal<'a>(run: &Run, histories: impl Iterator<Item = TimeHistory<'a>>) -> Vec<u8> {
    let origin = format!("nailnoise design {}", run.result.design.digest);
    let mut text = Vec::new();
    for (index, history) in histories.enumerate() {
        dataset_58(&mut text, &history, index + 1, &origin);
    }
    text
}

fn of_accelerometers(run: &Run) -> Result<Vec<File>, Error> {
    let sensors = &run.sensors;
    let Some(first) = sensors.first() else {
        return Ok(Vec::new());
    };
    let settings = TransformSettings {
        range_hz: [SPECTRUM_FROM, SPECTRUM_TO.min(0.5 / first.interval)],
        padding: 1.0,
        ..TransformSettings::default()
    };
    let transform = Transform::new(first.acceleration.len(), first.interval, &settings)?;
    Ok(vec![
        File::new("sensors.csv", histories(sensors)?),
        File::new("sensors-spectrum.csv", spectra(sensors, &transform)?),
        File::new("sensors.uff", universal(run, sensors.iter().map(Into::into))),
    ])
}

fn header(abscissa: &str, sensors: &[SensorRecord], unit: &'static str) -> impl Iterator<Item = String> {
    let title = move |sensor: &SensorRecord| title(&sensor.name, sensor.body.as_str()) + &format!(" [{unit}]");
    [abscissa.to_owned()].into_iter().chain(sensors.iter().map(title))
}

fn histories(sensors: &[SensorRecord]) -> Result<Vec<u8>, Error> {
    let columns: Vec<&[f64]> = sensors.iter().map(|sensor| sensor.acceleration.as_slice()).collect();
    let interval = sensors[0].interval;
    numbers(
        header("time [s]", sensors, "m/s2"),
        (|sample| sample as f64 * interval, 7),
        (&columns, 6),
    )
}

/// Energy spectral densities E = 2 |A(f)|^2, whose integral over f is int a^2 dt.
fn spectra(sensors: &[SensorRecord], transform: &Transform) -> Result<Vec<u8>, Error> {
    let density = |sensor: &SensorRecord| -> Result<Vec<f64>, Error> {
        let amplitudes = transform.apply(&sensor.acceleration)?;
        Ok(amplitudes.iter().map(|a| 2.0 * a.norm_sqr()).collect())
    };
    let densities = sensors.iter().map(density).collect::<Result<Vec<_>, _>>()?;
    let columns: Vec<&[f64]> = densities.iter().map(Vec::as_slice).collect();
    let frequencies = transform.frequencies();
    numbers(
        header("frequency [Hz]", sensors, "(m/s2)2 s/Hz"),
        (|bin| frequencies[bin], 4),
        (&columns, 6),
    )
}

/// Appends a time history as dataset 58, "function at nodal DOF", of the Universal File Format (SDRC), in text.
///
/// Function type 1 is a time response, data type 4 real double precision, abscissa spacing 1 even; specific data type 17 is
/// time, 12 acceleration, 15 pressure. Node numbers count the sensors; reference direction 0 is a scalar, which a sensor's axis is.
fn dataset_58(text: &mut Vec<u8>, history: &TimeHistory<'_>, node: usize, origin: &str) {
    text.extend_from_slice(records(history, node, origin).as_bytes());
    for line in history.values.chunks(4) {
        line.iter().for_each(|value| fortran(text, *value, [20, 12]));
        text.push(b'\n');
    }
    text.extend_from_slice(b"    -1\n");
}

/// The records of a dataset before its values.
fn records(history: &TimeHistory<'_>, node: usize, origin: &str) -> String {
    let (kind, quantity, unit) = history.quantity;
    let mut text = format!("{:>6}\n{:>6}\n", -1, 58);
    for line in [
        &title(history.name, history.place),
        origin,
        "NONE",
        &format!("{quantity} of one shot"),
        "NONE",
    ] {
        let _ = writeln!(text, "{line:.80}");
    }
    let _ = writeln!(
        text,
        "{:>5}{:>10}{:>5}{:>10} {:<10.10}{:>10}{:>4} {:<10.10}{:>10}{:>4}",
        1, 0, 0, 0, history.name, node, 0, "NONE", 0, 0
    );
    let mut abscissa = Vec::new();
    [0.0, history.interval, 0.0]
        .iter()
        .for_each(|value| fortran(&mut abscissa, *value, [13, 5]));
    let count = history.values.len();
    let abscissa = String::from_utf8_lossy(&abscissa);
    let _ = writeln!(text, "{:>10}{count:>10}{:>10}{abscissa}", 4, 1);
    for (kind, label, unit) in [
        (17, "time", "s"),
        (kind, quantity, unit),
        (0, "NONE", "NONE"),
        (0, "NONE", "NONE"),
    ] {
        let _ = writeln!(text, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
    }
    text
}

/// Appends a number as Fortran's 1PEwidth.digits writes and reads it: a sign and at least two digits in its exponent.
fn fortran(text: &mut Vec<u8>, value: f64, [width, digits]: [usize; 2]) {
    let mut number = Vec::with_capacity(width);
    exponential(&mut number, value, digits);
    if let Some(mark) = number.iter().position(|&c| c == b'e') {
        if number.get(mark + 1) != Some(&b'-') {
            number.insert(mark + 1, b'+');
        }
        if number.len() == mark + 3 {
            number.insert(mark + 2, b'0');
        }
    }
    text.resize(text.len() + width.saturating_sub(number.len()), b' ');
    text.extend_from_slice(&number);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Carrier;

    #[test]
    fn numbers_have_fortrans_width_and_exponent() {
        let written = |value: f64, form| {
            let mut text = Vec::new();
            fortran(&mut text, value, form);
            String::from_utf8(text).unwrap_or_default()
        };
        assert_eq!(written(4e-6, [13, 5]), "  4.00000e-06");
        assert_eq!(written(-1.5, [20, 12]), " -1.500000000000e+00");
        assert_eq!(written(2.5e-120, [20, 12]).len(), 20);
        assert_eq!(written(0.0, [13, 5]), "  0.00000e+00");
    }

    #[test]
    fn a_history_becomes_one_dataset_of_four_values_a_line() {
        let sensor = SensorRecord {
            name: "block_top".to_owned(),
            body: Carrier::Workpiece,
            interval: 4e-6,
            acceleration: vec![1.0, -2.0, 3.0, 4.0, 5.0],
        };
        let mut text = Vec::new();
        dataset_58(&mut text, &(&sensor).into(), 1, "nailnoise");
        let text = String::from_utf8(text).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            (lines[0], lines[1], lines[lines.len() - 1]),
            ("    -1", "    58", "    -1")
        );
        assert_eq!(lines[2], "block_top (workpiece)");
        assert_eq!(lines.len(), 2 + 5 + 2 + 4 + 2 + 1);
        assert_eq!(lines[8].split_whitespace().nth(1), Some("5"));
        let values: Vec<f64> = lines[13..15]
            .iter()
            .flat_map(|l| l.split_whitespace())
            .map(|v| v.parse().unwrap_or(f64::NAN))
            .collect();
        assert_eq!(values, sensor.acceleration);
    }
}

//! What the sensors recorded: `sensors.csv`, `sensors-spectrum.csv`, and `sensors.uff` for modal-test software.

use std::fmt::Write;
use std::path::Path;

use nailnoise_acoustics::fourier::{Transform, TransformSettings};

use crate::error::Error;
use crate::pipeline::{Run, SensorRecord};

/// Lowest frequency of the spectra \[Hz\].
const SPECTRUM_FROM: f64 = 5.0;

/// Highest frequency of the spectra \[Hz\].
const SPECTRUM_TO: f64 = 20e3;

/// Writes the sensors' files into `folder`; none when the design has no sensors.
pub(super) fn write(folder: &Path, run: &Run) -> Result<(), Error> {
    let sensors = &run.sensors;
    let Some(first) = sensors.first() else { return Ok(()) };
    super::write(&folder.join("sensors.csv"), histories(sensors).as_bytes())?;
    let settings = TransformSettings {
        range_hz: [SPECTRUM_FROM, SPECTRUM_TO.min(0.5 / first.interval)],
        padding: 1.0,
        ..TransformSettings::default()
    };
    let transform = Transform::new(first.acceleration.len(), first.interval, &settings)?;
    super::write(
        &folder.join("sensors-spectrum.csv"),
        spectra(sensors, &transform)?.as_bytes(),
    )?;
    let digest = &run.result.design.digest;
    let mut uff = String::new();
    for (index, sensor) in sensors.iter().enumerate() {
        dataset_58(&mut uff, sensor, index + 1, &format!("nailnoise design {digest}"));
    }
    super::write(&folder.join("sensors.uff"), uff.as_bytes())
}

fn heading(text: &mut String, abscissa: &str, sensors: &[SensorRecord], unit: &str) {
    text.push_str(abscissa);
    for sensor in sensors {
        let _ = write!(text, ",{} ({}) [{unit}]", sensor.name, sensor.body.as_str());
    }
    text.push('\n');
}

fn histories(sensors: &[SensorRecord]) -> String {
    let mut text = String::new();
    heading(&mut text, "time [s]", sensors, "m/s2");
    for sample in 0..sensors[0].acceleration.len() {
        let _ = write!(text, "{:.7}", sample as f64 * sensors[0].interval);
        for sensor in sensors {
            let _ = write!(text, ",{:.6e}", sensor.acceleration[sample]);
        }
        text.push('\n');
    }
    text
}

/// Energy spectral densities E = 2 |A(f)|^2, whose integral over f is int a^2 dt.
fn spectra(sensors: &[SensorRecord], transform: &Transform) -> Result<String, Error> {
    let mut text = String::new();
    heading(&mut text, "frequency [Hz]", sensors, "(m/s2)2 s/Hz");
    let columns = sensors
        .iter()
        .map(|sensor| transform.apply(&sensor.acceleration))
        .collect::<Result<Vec<_>, _>>()?;
    for (bin, hz) in transform.frequencies().iter().enumerate() {
        let _ = write!(text, "{hz:.4}");
        for column in &columns {
            let _ = write!(text, ",{:.6e}", 2.0 * column[bin].norm_sqr());
        }
        text.push('\n');
    }
    Ok(text)
}

/// Appends a time history as dataset 58, "function at nodal DOF", of the Universal File Format (SDRC), in text.
///
/// Function type 1 is a time response, data type 4 real double precision, abscissa spacing 1 even; specific data type 17 is
/// time, 12 acceleration. Node numbers count the sensors; reference direction 0 is a scalar, which a sensor's axis is.
fn dataset_58(text: &mut String, sensor: &SensorRecord, node: usize, origin: &str) {
    let count = sensor.acceleration.len();
    let _ = writeln!(text, "{:>6}\n{:>6}", -1, 58);
    for line in [
        &format!("{} ({})", sensor.name, sensor.body.as_str()),
        origin,
        "NONE",
        "acceleration of one shot",
        "NONE",
    ] {
        let _ = writeln!(text, "{line:.80}");
    }
    let _ = writeln!(
        text,
        "{:>5}{:>10}{:>5}{:>10} {:<10.10}{:>10}{:>4} {:<10.10}{:>10}{:>4}",
        1, 0, 0, 0, sensor.name, node, 0, "NONE", 0, 0
    );
    let _ = writeln!(
        text,
        "{:>10}{:>10}{:>10}{}{}{}",
        4,
        count,
        1,
        exponent(0.0),
        exponent(sensor.interval),
        exponent(0.0)
    );
    let axis = |text: &mut String, kind: usize, label: &str, unit: &str| {
        let _ = writeln!(text, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
    };
    axis(text, 17, "time", "s");
    axis(text, 12, "acceleration", "m/s2");
    axis(text, 0, "NONE", "NONE");
    axis(text, 0, "NONE", "NONE");
    for line in sensor.acceleration.chunks(4) {
        for value in line {
            let _ = write!(text, "{}", double(*value));
        }
        text.push('\n');
    }
    let _ = writeln!(text, "{:>6}", -1);
}

/// Fortran's 1PE13.5.
fn exponent(value: f64) -> String {
    format!("{:>13}", fortran(value, 5))
}

/// Fortran's 1PE20.12.
fn double(value: f64) -> String {
    format!("{:>20}", fortran(value, 12))
}

/// A number with a sign and at least two digits in its exponent, as Fortran writes and reads it.
fn fortran(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let (sign, digits) = exponent
                .strip_prefix('-')
                .map_or(('+', exponent), |digits| ('-', digits));
            format!("{mantissa}e{sign}{digits:0>2}")
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Carrier;

    #[test]
    fn numbers_have_fortrans_width_and_exponent() {
        assert_eq!(exponent(4e-6), "  4.00000e-06");
        assert_eq!(double(-1.5), " -1.500000000000e+00");
        assert_eq!(double(2.5e-120).len(), 20);
    }

    #[test]
    fn a_history_becomes_one_dataset_of_four_values_a_line() {
        let sensor = SensorRecord {
            name: "block_top".to_owned(),
            body: Carrier::Workpiece,
            interval: 4e-6,
            acceleration: vec![1.0, -2.0, 3.0, 4.0, 5.0],
        };
        let mut text = String::new();
        dataset_58(&mut text, &sensor, 1, "nailnoise");
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

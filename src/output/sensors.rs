//! Records of the sensors: `sensors.csv`, `sensors-spectrum.csv`, `transducers.csv`, and `sensors.uff` and
//! `transducers.uff` for modal-test software.

use nailnoise_acoustics::fourier::{Transform, TransformSettings};
use nailnoise_meshes::uff::{History, Ordinate};

use super::file::File;
use super::table::{coarse, numbers};
use crate::error::Error;
use crate::run::Run;
use crate::stages::sensors::SensorRecord;

/// Lowest frequency of the spectra \[Hz\].
const SPECTRUM_FROM: f64 = 5.0;

/// Highest frequency of the spectra \[Hz\].
const SPECTRUM_TO: f64 = 20e3;

/// The files of accelerometers and pressure transducers; only of kinds in the design. Tables have `all` samples, or
/// every so many; universal files have all of them, binary.
pub(super) fn files(run: &Run, all: bool) -> Result<Vec<File>, Error> {
    let mut files = of_accelerometers(run, all)?;
    files.extend(of_transducers(run, all)?);
    Ok(files)
}

/// Name and place of a sensor.
fn title(name: &str, place: &str) -> String {
    format!("{name} ({place})")
}

fn of_transducers(run: &Run, all: bool) -> Result<Vec<File>, Error> {
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
        if all { 1 } else { coarse(interval) },
    )?;
    let mut uff = Vec::new();
    for (index, own) in transducers.iter().enumerate() {
        History {
            title: &title(&own.name, own.chamber.as_str()),
            origin: &format!("nailnoise design {}", run.result.design.digest),
            sensor: &own.name,
            node: index + 1,
            ordinate: Ordinate::Pressure,
            interval,
            values: &own.values,
        }
        .write_binary(&mut uff);
    }
    Ok(vec![
        File::new("transducers.csv", table),
        File::new("transducers.uff", uff),
    ])
}

fn of_accelerometers(run: &Run, all: bool) -> Result<Vec<File>, Error> {
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
    let origin = format!("nailnoise design {}", run.result.design.digest);
    let mut uff = Vec::new();
    for (index, sensor) in sensors.iter().enumerate() {
        History {
            title: &title(&sensor.name, sensor.body.as_str()),
            origin: &origin,
            sensor: &sensor.name,
            node: index + 1,
            ordinate: Ordinate::Acceleration,
            interval: sensor.interval,
            values: &sensor.acceleration,
        }
        .write_binary(&mut uff);
    }
    Ok(vec![
        File::new("sensors.csv", histories(sensors, all)?),
        File::new("sensors-spectrum.csv", spectra(sensors, &transform)?),
        File::new("sensors.uff", uff),
    ])
}

fn header(abscissa: &str, sensors: &[SensorRecord], unit: &'static str) -> impl Iterator<Item = String> {
    let title = move |sensor: &SensorRecord| title(&sensor.name, sensor.body.as_str()) + &format!(" [{unit}]");
    [abscissa.to_owned()].into_iter().chain(sensors.iter().map(title))
}

fn histories(sensors: &[SensorRecord], all: bool) -> Result<Vec<u8>, Error> {
    let columns: Vec<&[f64]> = sensors.iter().map(|sensor| sensor.acceleration.as_slice()).collect();
    let interval = sensors[0].interval;
    numbers(
        header("time [s]", sensors, "m/s2"),
        (|sample| sample as f64 * interval, 7),
        (&columns, 6),
        if all { 1 } else { coarse(interval) },
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
        1,
    )
}

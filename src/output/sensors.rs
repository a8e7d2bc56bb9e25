//! What the sensors recorded: `sensors.csv`, `sensors-spectrum.csv`, and `sensors.uff` for modal-test software.

use nailnoise_acoustics::fourier::{Transform, TransformSettings};
use nailnoise_meshes::uff::{History, Ordinate};

use super::File;
use super::table::numbers;
use crate::error::Error;
use crate::run::Run;
use crate::stages::sensors::SensorRecord;

/// Lowest frequency of the spectra \[Hz\].
const SPECTRUM_FROM: f64 = 5.0;

/// Highest frequency of the spectra \[Hz\].
const SPECTRUM_TO: f64 = 20e3;

/// The sensors' files; none when the design has no sensors.
pub(super) fn files(run: &Run) -> Result<Vec<File>, Error> {
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
            title: &format!("{} ({})", sensor.name, sensor.body.as_str()),
            origin: &origin,
            sensor: &sensor.name,
            node: index + 1,
            ordinate: Ordinate::Acceleration,
            interval: sensor.interval,
            values: &sensor.acceleration,
        }
        .write(&mut uff);
    }
    Ok(vec![
        File::new("sensors.csv", histories(sensors)?),
        File::new("sensors-spectrum.csv", spectra(sensors, &transform)?),
        File::new("sensors.uff", uff),
    ])
}

fn header(abscissa: &str, sensors: &[SensorRecord], unit: &'static str) -> impl Iterator<Item = String> {
    let title = move |sensor: &SensorRecord| format!("{} ({}) [{unit}]", sensor.name, sensor.body.as_str());
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

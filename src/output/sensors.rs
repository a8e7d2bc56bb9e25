//! `sensors*`: histories and spectra of the accelerometers.

use nailnoise_acoustics::signals::fourier::{Transform, TransformSettings};
use nailnoise_meshes::uff::{History, Ordinate};

use super::table::{numbers, stride};
use super::{Output, RunView};
use crate::error::Error;
use crate::stages::sensors::SensorRecord;

/// Accelerations over time.
pub(super) const HISTORIES: Output = Output::of_run("sensors.csv", histories).only_if(exist);

/// Their energy spectra.
pub(super) const SPECTRA: Output = Output::of_run("sensors-spectrum.csv", spectra).only_if(exist);

/// All samples in binary form, for modal-test software.
pub(super) const UNIVERSAL: Output = Output::of_run("sensors.uff", universal).only_if(exist);

/// Lowest frequency of the spectra \[Hz\].
const SPECTRUM_FROM: f64 = 5.0;

/// Highest frequency of the spectra \[Hz\].
const SPECTRUM_TO: f64 = 20e3;

fn exist(of: &RunView<'_>) -> bool {
    !of.run.sensors.is_empty()
}

/// Name and place of a sensor.
pub(super) fn title(name: &str, place: &str) -> String {
    format!("{name} ({place})")
}

fn universal(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let origin = format!("nailnoise design {}", of.run.result.design.digest);
    let mut uff = Vec::new();
    for (index, sensor) in of.run.sensors.iter().enumerate() {
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
    Ok(uff)
}

fn header(abscissa: &str, sensors: &[SensorRecord], unit: &'static str) -> impl Iterator<Item = String> {
    let title = move |sensor: &SensorRecord| title(&sensor.name, sensor.body.as_str()) + &format!(" [{unit}]");
    [abscissa.to_owned()].into_iter().chain(sensors.iter().map(title))
}

fn histories(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let sensors = &of.run.sensors;
    let columns: Vec<&[f64]> = sensors.iter().map(|sensor| sensor.acceleration.as_slice()).collect();
    let interval = sensors.first().map_or(1.0, |first| first.interval);
    numbers(
        header("time [s]", sensors, "m/s2"),
        (|sample| sample as f64 * interval, 7),
        (&columns, 6),
        stride(interval, of.exports),
    )
}

/// Energy spectral densities E = 2 |A(f)|^2, whose integral over f is int a^2 dt.
fn spectra(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let sensors = &of.run.sensors;
    let (samples, interval) = sensors
        .first()
        .map_or((0, 1.0), |first| (first.acceleration.len(), first.interval));
    let settings = TransformSettings {
        range_hz: [SPECTRUM_FROM, SPECTRUM_TO.min(0.5 / interval)],
        padding: 1.0,
        ..TransformSettings::default()
    };
    let transform = Transform::new(samples, interval, &settings)?;
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

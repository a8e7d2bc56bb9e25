//! Recordings of a virtual test: sounds, sensors, and the manifest from which `nailnoise measure` reads them.

use std::fmt::Write as _;
use std::path::PathBuf;

use nailnoise_acoustics::Air;
use nailnoise_meshes::uff::{History, Ordinate};

use crate::design::Design;
use crate::error::Error;
use crate::measurement::Shot;
use crate::measurement::arrangement::Arrangement;
use crate::measurement::markers::MarkerEvents;
use crate::measurement::recordings::wav::{Coding, encode};
use crate::measurement::wrapping::Configuration;

/// Voltage of the push-button below the trigger \[V\], full scale of its channel, and threshold.
const BUTTON: [f64; 3] = [5.0, 10.0, 2.5];

/// Minimum ratio of the full scale of a sensor to the largest value in the test.
const HEADROOM: f64 = 2.0;

/// The microphones of a shot as a sound file with one channel each, and the push-button below the trigger as the last
/// channel.
///
/// # Errors
/// [`Error::Write`] if the file cannot store them.
pub fn sounds(shot: &Shot, full_scale: f64, stem: &str) -> Result<Vec<u8>, Error> {
    let [pressed, button_scale, _] = BUTTON;
    let at = (shot.trigger * shot.rate).round() as usize;
    let samples = shot.microphones.first().map_or(0, Vec::len);
    // All channels of the file have the same full scale.
    let closed = pressed / button_scale * full_scale;
    let button: Vec<f64> = (0..samples).map(|n| if n < at { 0.0 } else { closed }).collect();
    let mut signals: Vec<&[f64]> = shot.microphones.iter().map(Vec::as_slice).collect();
    signals.push(&button);
    encode(&signals, shot.rate.round() as u32, full_scale, Coding::Integer24).map_err(|source| Error::Write {
        path: PathBuf::from(format!("{stem}.wav")),
        source,
    })
}

/// Accelerometers, then pressure transducers, as a binary universal file.
pub fn sensors(arrangement: &Arrangement, shot: &Shot, origin: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let accelerations = arrangement.accelerometers.iter().zip(&shot.accelerations);
    let pressures = arrangement.transducers.iter().zip(&shot.pressures);
    let all = accelerations
        .map(|own| (own, Ordinate::Acceleration))
        .chain(pressures.map(|own| (own, Ordinate::Pressure)));
    for (place, ((name, values), ordinate)) in all.enumerate() {
        let history = History {
            title: name,
            origin,
            sensor: name,
            node: place + 1,
            ordinate,
            interval: 1.0 / shot.rate,
            values,
        };
        history.write_binary(&mut bytes);
    }
    bytes
}

/// Largest values of the sensors of a test.
#[derive(Debug, Clone, Copy, Default)]
pub struct SensorPeaks {
    acceleration: f64,
    pressure: f64,
}

impl SensorPeaks {
    /// Includes the values of a shot.
    pub fn add(&mut self, shot: &Shot) {
        let peak = |records: &[Vec<f64>]| records.iter().flatten().fold(0.0, |peak: f64, x| peak.max(x.abs()));
        self.acceleration = self.acceleration.max(peak(&shot.accelerations));
        self.pressure = self.pressure.max(peak(&shot.pressures));
    }
}

/// The manifest of a test with this number of repeats of each configuration, from the full scale of the microphones
/// \[Pa\] and the largest values of the sensors.
pub fn manifest(
    design: &Design,
    arrangement: &Arrangement,
    (full_scale, peaks): (f64, &SensorPeaks),
    repeats: usize,
) -> String {
    let mut text = String::new();
    let air = &arrangement.air;
    let [x, y, z] = [arrangement.centre.x, arrangement.centre.y, arrangement.centre.z];
    let _ = writeln!(
        text,
        "# Virtual wrapping test of the design {}, made by `nailnoise test`.\n",
        design.name()
    );
    let _ = writeln!(text, "setup = \"{}\"", arrangement.setup.as_str());
    let _ = writeln!(text, "centre = [{x}, {y}, {z}]");
    let _ = writeln!(text, "plane = {}", arrangement.plane);
    let _ = writeln!(text, "temperature = \"{} K\"", air.temperature);
    let _ = writeln!(text, "static_pressure = \"{} Pa\"", air.pressure);
    // Recordings in dry air need no gas in the manifest; a rounded constant in a design also means dry air.
    let standard = Air::default();
    if (air.gas_constant / standard.gas_constant - 1.0).abs() > 1e-4 || air.heat_ratio != standard.heat_ratio {
        let _ = writeln!(text, "gas_constant = \"{} J/(kg K)\"", air.gas_constant);
        let _ = writeln!(text, "heat_capacity_ratio = {}", air.heat_ratio);
    }
    if let Some(absorption) = arrangement.absorption {
        let _ = writeln!(text, "absorption = \"{absorption} m2\"");
    }
    if arrangement.events != MarkerEvents::default() {
        // Events of a tool with other events than the N80CB; without any, the markers have no events.
        let _ = writeln!(text, "\n[markers]");
        for (marker, event) in arrangement.events.iter() {
            let _ = writeln!(text, "{marker} = \"{event}\"");
        }
    }
    let _ = writeln!(text, "\n[channels]");
    for (place, at) in arrangement.microphones.iter().enumerate() {
        let number = place + 1;
        let _ = writeln!(
            text,
            "mic{number} = {{ file = \"{{c}}-{{k}}.wav\", channel = {number}, full_scale = \"{full_scale} Pa\", \
             position = [{}, {}, {}] }}",
            at.x, at.y, at.z
        );
    }
    let accelerometers = arrangement
        .accelerometers
        .iter()
        .map(|name| (name, "accelerometer", "m/s2", peaks.acceleration));
    let transducers = arrangement
        .transducers
        .iter()
        .map(|name| (name, "pressure", "Pa", peaks.pressure));
    for (place, (name, kind, unit, peak)) in accelerometers.chain(transducers).enumerate() {
        let _ = writeln!(
            text,
            "{name} = {{ file = \"{{c}}-{{k}}.uff\", channel = {}, unit = \"{unit}\", full_scale = \"{} {unit}\", \
             kind = \"{kind}\" }}",
            place + 1,
            crate::stages::microphones::full_scale(HEADROOM * peak)
        );
    }
    let _ = writeln!(
        text,
        "button = {{ file = \"{{c}}-{{k}}.wav\", channel = {}, full_scale = \"{} V\", kind = \"trigger\" }}",
        arrangement.microphones.len() + 1,
        BUTTON[1]
    );
    let _ = writeln!(text, "\n[configurations]");
    let threshold = BUTTON[2];
    for configuration in Configuration::ALL {
        let name = arrangement.setup.configuration(configuration.number());
        let _ = writeln!(
            text,
            "{name} = {{ repeats = {repeats}, trigger = {{ channel = \"button\", threshold = \"{threshold} V\" }} }}"
        );
    }
    text
}

//! `MANIFEST.toml`: lists the recordings of a test and what their numbers mean.
//!
//! ```toml
//! setup = "worktable"                # or "sandbox"
//! centre = [0, 0, 0.938]             # centre of the machine [m]
//! plane = "floor"                    # z of the reflecting plane: "floor" is 0, "sand" is `sand_height`, or a length
//! temperature = "21 degC"
//! static_pressure = "101.3 kPa"      # optional
//! absorption = "120 m2"              # optional: equivalent absorption area of the room
//! [channels]
//! mic5 = { file = "{c}-{k}.wav", channel = 5, sensitivity = "50 mV/Pa", full_scale = "10 V", position = [1, 1, 1.9] }
//! N = { file = "{c}-{k}.uff", channel = 1, unit = "g" }
//! [configurations]
//! W-1 = { repeats = 5, trigger = "12.5 ms" }
//! W-2 = { repeats = 5, trigger = { channel = "button", threshold = "2.5 V" } }
//! ```

mod channel;
mod checks;
mod load;

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::channel::{Channel, Kind};
use super::error::MeasurementError;
use super::markers::MarkerEvents;
use super::recordings::{Fault, Shot, Signals, Source, crossing, dead, read_shot};

/// Number of the configuration in which everything is wrapped.
const RESIDUAL: usize = 2;

/// Support of the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Setup {
    /// A worktable; the configurations are W-1 to W-5.
    Worktable,
    /// A box of sand; the configurations are S-1 to S-5.
    Sandbox,
}

impl Setup {
    /// Its name in a manifest.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Worktable => "worktable",
            Self::Sandbox => "sandbox",
        }
    }

    /// Name of its configuration with the given number, from 1: `W-1`.
    pub fn configuration(self, number: usize) -> String {
        match self {
            Self::Worktable => format!("W-{number}"),
            Self::Sandbox => format!("S-{number}"),
        }
    }
}

/// A microphone on the measurement surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Microphone {
    /// `mic1` to `mic9`, the numbers of EN 12549.
    pub name: String,
    /// Its position in the coordinates of [`Manifest::centre`] \[m\].
    pub position: [f64; 3],
}

/// How the start of a shot is determined.
#[derive(Debug, Clone, PartialEq)]
pub enum Trigger {
    /// At a time from the record's start \[s\].
    At(f64),
    /// When a channel first crosses a threshold away from zero.
    Channel {
        /// Its name.
        name: String,
        /// The threshold in the SI unit of the channel: V for a trigger, else Pa or m/s².
        threshold: f64,
    },
}

/// A configuration of the wrapping test.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// `W-1` to `W-5` or `S-1` to `S-5`.
    pub name: String,
    /// 1 total, 2 residual, 3 exhaust, 4 body, 5 workpiece.
    pub number: usize,
    /// Number of shots.
    pub repeats: usize,
    /// How the start of a shot is determined.
    pub trigger: Trigger,
}

/// A test as described by its manifest.
#[derive(Debug, Clone)]
pub struct Manifest {
    /// The file.
    pub path: PathBuf,
    /// Support of the workpiece.
    pub setup: Setup,
    /// Centre of the machine, z up \[m\].
    pub centre: [f64; 3],
    /// Height z of the reflecting plane \[m\].
    pub plane: f64,
    /// Temperature of the air \[K\].
    pub temperature: f64,
    /// Static pressure of the air \[Pa\]; the standard atmosphere unless stated.
    pub static_pressure: f64,
    /// Specific gas constant of the air \[J/(kg K)\]; that of dry air unless stated.
    pub gas_constant: f64,
    /// Ratio of the specific heats of the air; that of dry air unless stated.
    pub heat_capacity_ratio: f64,
    /// Equivalent absorption area of the room \[m²\]; none outdoors or in a semi-anechoic room.
    pub absorption: Option<f64>,
    /// The microphones in the order of their numbers.
    pub microphones: Vec<Microphone>,
    /// Names of the accelerometers, in the order of the file.
    pub accelerometers: Vec<String>,
    /// Names of the pressure transducers, in the order of the file.
    pub pressures: Vec<String>,
    /// The configurations in the order of their numbers.
    pub configurations: Vec<Configuration>,
    /// Events of the markers; those of the N80CB unless stated.
    pub events: MarkerEvents,
    /// Conditions that reduce the value of the test without invalidating it.
    pub warnings: Vec<String>,
    /// All channels, in the order of the file.
    channels: Vec<Channel>,
    /// Sampling rate of the first recording \[Hz\], which all others must have, and its file.
    rate: Option<(f64, PathBuf)>,
}

impl Manifest {
    /// Reads one shot: `configuration` is an index into [`Self::configurations`], `repeat` counts from 0.
    ///
    /// Each file is read once; all channels are truncated to the shortest one.
    ///
    /// # Errors
    /// [`MeasurementError::NoShot`]; or an error for a recording that cannot be read or used, with file, channel and
    /// value.
    pub fn shot(&self, configuration: usize, repeat: usize) -> Result<Shot, MeasurementError> {
        let Some(own) = self
            .configurations
            .get(configuration)
            .filter(|own| repeat < own.repeats)
        else {
            return Err(MeasurementError::NoShot { configuration, repeat });
        };
        let source = |channel: &Channel| (self.beside(&channel.file(&own.name, repeat + 1)), channel.clone());
        let needed = |channel: &&Channel| {
            let starts = matches!(&own.trigger, Trigger::Channel { name, .. } if *name == channel.name);
            channel.kind != Kind::Trigger || starts
        };
        let channels: Vec<(PathBuf, Channel)> = self.channels.iter().filter(needed).map(source).collect();
        let sources: Vec<(PathBuf, Source<'_>)> = channels
            .iter()
            .map(|(path, channel)| (path.clone(), channel.source()))
            .collect();
        let expected = self.rate.as_ref().map(|(rate, path)| (*rate, path.as_path()));
        let mut signals = read_shot(&sources, expected)?;
        let place = |name: &str| channels.iter().position(|(_, channel)| channel.name == name);
        alive(&channels, &signals, own.number)?;
        let trigger = match &own.trigger {
            Trigger::At(time) => *time,
            Trigger::Channel { name, threshold } => {
                let index = place(name).unwrap_or_default();
                let signal = &signals.channels[index];
                crossing(signal, signals.rate, *threshold).ok_or_else(|| {
                    let fault = Fault::NoTrigger {
                        threshold: *threshold,
                        least: signal.iter().copied().fold(f64::INFINITY, f64::min),
                        most: signal.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                        unit: channels[index].1.kind.quantity().unit(),
                    };
                    signals.refuse(index, name, fault)
                })?
            }
        };
        let names: Vec<&str> = channels.iter().map(|(_, channel)| channel.name.as_str()).collect();
        signals.cut(trigger, &names)?;
        let mut take = |names: &[String]| {
            let own = names.iter().filter_map(|name| place(name));
            own.map(|index| std::mem::take(&mut signals.channels[index])).collect()
        };
        let microphones: Vec<String> = self.microphones.iter().map(|own| own.name.clone()).collect();
        Ok(Shot {
            rate: signals.rate,
            trigger,
            microphones: take(&microphones),
            accelerations: take(&self.accelerometers),
            pressures: take(&self.pressures),
        })
    }

    fn beside(&self, name: &str) -> PathBuf {
        self.path.with_file_name("").join(name)
    }
}

/// Checks that every microphone, accelerometer and pressure transducer has a signal. In configuration 2, with
/// everything wrapped, all microphones together may be silent, as in a virtual test with perfect wraps and without
/// background noise.
fn alive(channels: &[(PathBuf, Channel)], signals: &Signals, configuration: usize) -> Result<(), MeasurementError> {
    let fault = |index: usize| dead(&signals.channels[index], channels[index].1.kind.quantity().unit());
    let is_microphone = |index: &usize| channels[*index].1.kind == Kind::Microphone;
    let mut microphones = (0..channels.len()).filter(is_microphone);
    let silent = configuration == RESIDUAL && microphones.all(|index| fault(index).is_some());
    let is_needed = |index: &usize| channels[*index].1.kind != Kind::Trigger && !(silent && is_microphone(index));
    let mut faults = (0..channels.len())
        .filter(is_needed)
        .filter_map(|index| Some((index, fault(index)?)));
    let Some((index, mut first)) = faults.next() else {
        return Ok(());
    };
    if let Fault::Dead { others, .. } = &mut first {
        others.extend(faults.map(|(index, _)| channels[index].1.name.clone()));
    }
    Err(signals.refuse(index, &channels[index].1.name, first))
}

impl Channel {
    fn source(&self) -> Source<'_> {
        Source {
            name: &self.name,
            quantity: self.kind.quantity(),
            selector: &self.selector,
            calibration: &self.calibration,
        }
    }
}

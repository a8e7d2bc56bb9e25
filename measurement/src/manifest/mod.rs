//! `MANIFEST.toml`: which recordings a test made, and what their numbers mean.
//!
//! ```toml
//! setup = "worktable"                # or "sandbox"
//! centre = [0, 0, 0.938]             # centre of the machine [m]
//! plane = "floor"                    # z of the reflecting plane: "floor" is 0, "sand" that of `sand_height`, or a length
//! temperature = "21 degC"
//! static_pressure = "101.3 kPa"      # optional
//! absorption = "120 m2"              # optional: equivalent absorption area of the room
//! [channels]
//! mic5 = { file = "{c}-{k}.wav", channel = 5, sensitivity = "50 mV/Pa", full_scale = "10 V", position = [1, 1, 1.938] }
//! N = { file = "{c}-{k}.uff", channel = 1, unit = "g" }
//! [configurations]
//! W-1 = { repeats = 5, trigger = "12.5 ms" }
//! W-2 = { repeats = 5, trigger = { channel = "button", threshold = "2.5 V" } }
//! ```

mod channel;
mod checks;

use std::path::{Path, PathBuf};

use nailnoise_acoustics::{GAS_CONSTANT, HEAT_RATIO};
use nailnoise_documents::read_regular;
use nailnoise_quantities::dimension::{self, AREA, LENGTH, NUMBER, PRESSURE, TEMPERATURE};
use nailnoise_quantities::measure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::channel::{Channel, Kind};
use super::error::MeasurementError;
use super::recordings::{Calibrator, Fault, Quantity, Shot, Signals, Source, crossing, dead, read, read_shot, refuse};
use nailnoise_documents::{Document, KeyError, Keys};

/// The largest manifest that is read \[byte\].
const LARGEST: u64 = 1 << 20;

/// Standard atmosphere \[Pa\] (ISO 2533).
const STANDARD_PRESSURE: f64 = 101_325.0;

/// Temperatures of the air in a room or outdoors \[K\].
const TEMPERATURES: [f64; 2] = [233.15, 333.15];

/// Static pressures of the air where people work \[Pa\].
const PRESSURES: [f64; 2] = [50e3, 110e3];

/// Specific gas constants and ratios of specific heats of gases, those that a design may have \[J/(kg K), -\].
const GAS_CONSTANTS: [f64; 2] = [50.0, 5000.0];
const HEAT_RATIOS: [f64; 2] = [1.01, 1.7];

/// Equivalent absorption areas of rooms \[m²\].
const ABSORPTIONS: [f64; 2] = [0.1, 1e6];

/// Coordinates of the machine \[m\].
const PLACES: [f64; 2] = [-1e3, 1e3];

/// Heights of a reflecting plane, and of the sand above the floor \[m\].
const HEIGHTS: [f64; 2] = [-10.0, 10.0];

/// Repeats of a configuration at most.
const MOST_REPEATS: usize = 1000;

/// Number of the configuration with everything wrapped.
const RESIDUAL: usize = 2;

/// Longest time before a trigger \[s\].
const LATEST: f64 = 1e3;

/// What the workpiece stands on.
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

    /// Name of its configuration with a number from 1: `W-1`.
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
    /// Its position in the axes of [`Manifest::centre`] \[m\].
    pub position: [f64; 3],
}

/// When a shot begins.
#[derive(Debug, Clone, PartialEq)]
pub enum Trigger {
    /// At a time from the record's start \[s\].
    At(f64),
    /// When a channel first crosses a threshold away from zero.
    Channel {
        /// Its name.
        name: String,
        /// The threshold in the SI unit of the channel: V of a trigger, else Pa or m/s².
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
    /// When they begin.
    pub trigger: Trigger,
}

/// A test by its manifest.
#[derive(Debug, Clone)]
pub struct Manifest {
    /// The file.
    pub path: PathBuf,
    /// What the workpiece stands on.
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
    /// The microphones by their numbers.
    pub microphones: Vec<Microphone>,
    /// Names of the accelerometers, in the order of the file.
    pub accelerometers: Vec<String>,
    /// Names of the pressure transducers, in the order of the file.
    pub pressures: Vec<String>,
    /// The configurations by their numbers.
    pub configurations: Vec<Configuration>,
    /// What lowers the value of the test without forbidding it.
    pub warnings: Vec<String>,
    /// All channels, in the order of the file.
    channels: Vec<Channel>,
    /// Sampling rate of the first recording \[Hz\], which all others have, and its file.
    rate: Option<(f64, PathBuf)>,
}

impl Manifest {
    /// Reads a manifest, checks that all its recordings are there, reads those of calibrators and the rate of the first
    /// one.
    ///
    /// # Errors
    /// [`MeasurementError`] with file, line and key, or with file and channel.
    pub fn load(path: &Path) -> Result<Self, MeasurementError> {
        let unreadable = |cause: String| MeasurementError::Unreadable {
            path: path.to_owned(),
            channel: None,
            cause,
            help: "name the TOML file of a test; docs/measurement.md describes it".to_owned(),
        };
        let bytes = read_regular(path, LARGEST).map_err(|error| unreadable(error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|error| unreadable(error.to_string()))?;
        let mut manifest = Self::parse(&text, path)?;
        manifest.find_files()?;
        manifest.calibrate()?;
        if let (Some(configuration), Some(channel)) = (manifest.configurations.first(), manifest.channels.first()) {
            let file = manifest.beside(&channel.file(&configuration.name, 1));
            let track = read(&file, &[channel.source()])?;
            manifest.rate = track.first().map(|track| (track.rate, file));
        }
        Ok(manifest)
    }

    /// Reads the text of a manifest; no recording is opened. `path` is for messages and its folder for the recordings.
    ///
    /// # Errors
    /// [`MeasurementError::Document`] or [`MeasurementError::Manifest`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, MeasurementError> {
        let document = Document::new(path, text);
        let keys = document.table()?;
        let root = Keys::of_document(&document, &keys, "manifest");
        root.only(&[
            "setup",
            "centre",
            "plane",
            "sand_height",
            "temperature",
            "static_pressure",
            "gas_constant",
            "heat_capacity_ratio",
            "absorption",
            "channels",
            "configurations",
        ])?;
        let setup = setup(&root)?;
        let centre = root.point("centre", root.required("centre", "[0, 0, 0.938]")?)?;
        for coordinate in centre {
            root.within("centre", coordinate, PLACES, "m")?;
        }
        let plane = plane(&root, setup)?;
        root.required("temperature", "\"21 degC\"")?;
        let channels = channels(&root)?;
        let of = |kind: Kind| channels.iter().filter(move |channel| channel.kind == kind);
        let names = |kind: Kind| of(kind).map(|channel| channel.name.clone()).collect();
        let microphones = of(Kind::Microphone).filter_map(|channel| {
            Some(Microphone {
                name: channel.name.clone(),
                position: channel.position?,
            })
        });
        checks::names(&channels, &root)?;
        let mut manifest = Self {
            path: path.to_owned(),
            setup,
            centre,
            plane,
            temperature: root
                .quantity("temperature", TEMPERATURE, TEMPERATURES)?
                .unwrap_or_default(),
            static_pressure: root
                .quantity("static_pressure", PRESSURE, PRESSURES)?
                .unwrap_or(STANDARD_PRESSURE),
            gas_constant: root
                .quantity("gas_constant", dimension::GAS_CONSTANT, GAS_CONSTANTS)?
                .unwrap_or(GAS_CONSTANT),
            heat_capacity_ratio: root
                .quantity("heat_capacity_ratio", NUMBER, HEAT_RATIOS)?
                .unwrap_or(HEAT_RATIO),
            absorption: root.quantity("absorption", AREA, ABSORPTIONS)?,
            microphones: microphones.collect(),
            accelerometers: names(Kind::Accelerometer),
            pressures: names(Kind::Pressure),
            configurations: configurations(&root, setup, &channels)?,
            warnings: Vec::new(),
            channels,
            rate: None,
        };
        manifest.microphones.sort_by(|a, b| a.name.cmp(&b.name));
        manifest
            .configurations
            .sort_by_key(|configuration| configuration.number);
        checks::microphones(&root, &manifest)?;
        checks::residual(&root, &manifest)?;
        checks::placeholders(&root, &manifest)?;
        manifest.warnings = checks::warnings(&manifest);
        Ok(manifest)
    }

    /// Reads one shot: `configuration` is an index into [`Self::configurations`], `repeat` counts from 0.
    ///
    /// Each file is read once; all channels are cut to the shortest one.
    ///
    /// # Errors
    /// [`MeasurementError::NoShot`]; a recording that cannot be read or used, with file, channel and value.
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

    /// All recordings are there, and are files.
    fn find_files(&self) -> Result<(), MeasurementError> {
        for configuration in &self.configurations {
            for repeat in 1..=configuration.repeats {
                for channel in &self.channels {
                    checks::is_file(&self.beside(&channel.file(&configuration.name, repeat)), &channel.name)?;
                }
            }
        }
        Ok(())
    }

    /// Reads the records of calibrators.
    fn calibrate(&mut self) -> Result<(), MeasurementError> {
        let folder = self.path.with_file_name("");
        for channel in &mut self.channels {
            let Some(calibrator) = channel.calibration.calibrator.clone() else {
                continue;
            };
            let path = folder.join(&calibrator.file);
            let source = Source {
                selector: &calibrator.selector,
                ..channel.source()
            };
            let factor = read(&path, &[source])?
                .first()
                .map(|track| calibrator.measured(track))
                .transpose()
                .map_err(|fault| refuse(&path, &channel.name, fault))?;
            channel.calibration.calibrator = Some(Calibrator { factor, ..calibrator });
        }
        Ok(())
    }
}

/// Every microphone, accelerometer and pressure transducer has a signal. With everything wrapped, in configuration 2,
/// all microphones together may have none, as in a virtual test of perfect wraps without background noise.
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

fn setup(root: &Keys<'_, '_>) -> Result<Setup, KeyError> {
    root.required("setup", "\"worktable\"")?;
    let word = root.text("setup", "\"worktable\"")?.unwrap_or_default();
    let setup = [Setup::Worktable, Setup::Sandbox]
        .into_iter()
        .find(|setup| setup.as_str() == word);
    setup.ok_or_else(|| root.error("setup", format!("is \"{word}\""), "choose from worktable, sandbox"))
}

/// Height of the reflecting plane \[m\].
fn plane(root: &Keys<'_, '_>, setup: Setup) -> Result<f64, KeyError> {
    let sand = root.quantity("sand_height", LENGTH, HEIGHTS)?;
    if sand.is_some() && setup != Setup::Sandbox {
        return Err(root.error("sand_height", "belongs to setup = \"sandbox\"", "remove it"));
    }
    let value = root.required("plane", "\"floor\"")?;
    match (value.get_ref().as_str(), sand) {
        (Some("floor"), _) => Ok(0.0),
        (Some("sand"), Some(height)) => Ok(height),
        (Some("sand"), None) => {
            let help =
                "give `sand_height`, the height of the sand above the floor, as \"400 mm\", with setup = \"sandbox\"";
            Err(root.error("plane", "is \"sand\", whose height is missing", help))
        }
        _ => {
            let read = |text: &str| {
                measure(text, LENGTH).map_err(|problem| format!("{problem}; or choose \"floor\" or \"sand\""))
            };
            let height = root.number("plane", value, read)?;
            root.within("plane", height, HEIGHTS, "m")
        }
    }
}

fn channels(root: &Keys<'_, '_>) -> Result<Vec<Channel>, KeyError> {
    root.required("channels", "{ mic1 = { ... } }")?;
    let Some(table) = root.table("channels", "[channels]")? else {
        return Ok(Vec::new());
    };
    table
        .keys()
        .keys()
        .map(|name| Channel::read(&table, name.get_ref()))
        .collect()
}

fn configurations(root: &Keys<'_, '_>, setup: Setup, channels: &[Channel]) -> Result<Vec<Configuration>, KeyError> {
    root.required("configurations", "{ W-1 = { repeats = 5, trigger = \"12.5 ms\" } }")?;
    let Some(all) = root.table("configurations", "[configurations]")? else {
        return Ok(Vec::new());
    };
    let known: Vec<String> = (1..=5).map(|number| setup.configuration(number)).collect();
    all.only(&known.iter().map(String::as_str).collect::<Vec<_>>())?;
    let mut found = Vec::new();
    for (index, name) in known.iter().enumerate() {
        let Some(table) = all.table(name, "{ repeats = 5, trigger = \"12.5 ms\" }")? else {
            continue;
        };
        table.only(&["repeats", "trigger"])?;
        table.required("repeats", "5")?;
        found.push(Configuration {
            name: name.clone(),
            number: index + 1,
            repeats: table.count("repeats", MOST_REPEATS)?.unwrap_or_default(),
            trigger: trigger(&table, channels)?,
        });
    }
    if found.is_empty() {
        let help = format!("list those that were recorded: {}", known.join(", "));
        return Err(root.error("configurations", "has no configuration", help));
    }
    Ok(found)
}

fn trigger(table: &Keys<'_, '_>, channels: &[Channel]) -> Result<Trigger, KeyError> {
    const EXAMPLE: &str = "\"12.5 ms\", or { channel = \"button\", threshold = \"2.5 V\" }";
    let value = table.required("trigger", EXAMPLE)?;
    if value.get_ref().as_table().is_none() {
        let time = table.number("trigger", value, |text| {
            measure(text, nailnoise_quantities::dimension::TIME)
        })?;
        return table.within("trigger", time, [0.0, LATEST], "s").map(Trigger::At);
    }
    let Some(own) = table.table("trigger", EXAMPLE)? else {
        return Ok(Trigger::At(0.0));
    };
    own.only(&["channel", "threshold"])?;
    own.required("channel", "\"button\"")?;
    let name = own.text("channel", "\"button\"")?.unwrap_or_default();
    let quantity: Quantity = match channels.iter().find(|channel| channel.name == name) {
        Some(channel) => channel.kind.quantity(),
        None => {
            let known: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
            let help = format!(
                "the channels are {}; that of a switch has kind = \"trigger\"",
                known.join(", ")
            );
            return Err(own.error("channel", format!("is \"{name}\", which is no channel"), help));
        }
    };
    let value = own.required("threshold", "\"2.5 V\"")?;
    let threshold = own.number("threshold", value, |text| quantity.read(text))?;
    let [low, high] = quantity.limits();
    if !(low..=high).contains(&threshold.abs()) {
        let unit = quantity.unit();
        let problem = format!("is {threshold:e} {unit}, beyond {low:e} to {high:e} {unit} on either side of 0");
        return Err(own.error("threshold", problem, "give a value between rest and shot"));
    }
    Ok(Trigger::Channel {
        name: name.to_owned(),
        threshold,
    })
}

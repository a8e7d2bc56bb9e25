//! Reads manifests from files.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_acoustics::{GAS_CONSTANT, HEAT_RATIO};
use nailnoise_documents::{Document, KeyError, Keys, read_regular};
use nailnoise_quantities::dimension::{self, AREA, LENGTH, NUMBER, PRESSURE, TEMPERATURE};
use nailnoise_quantities::measure;

use super::channel::{Channel, Kind};
use super::{Configuration, Manifest, Microphone, Setup, Trigger, checks};
use crate::error::MeasurementError;
use crate::markers::{MARKERS, MarkerEvents};
use crate::recordings::{Calibrator, Quantity, Source, read, refuse};

/// Largest manifest accepted \[byte\].
const LARGEST: u64 = 1 << 20;

/// Standard atmosphere \[Pa\] (ISO 2533).
const STANDARD_PRESSURE: f64 = 101_325.0;

/// Range of air temperatures in a room or outdoors \[K\].
const TEMPERATURES: [f64; 2] = [233.15, 333.15];

/// Range of static air pressures at workplaces \[Pa\].
const PRESSURES: [f64; 2] = [50e3, 110e3];

/// Ranges of the specific gas constant and heat capacity ratio, the same as in a design \[J/(kg K), -\].
const GAS_CONSTANTS: [f64; 2] = [50.0, 5000.0];
const HEAT_RATIOS: [f64; 2] = [1.01, 1.7];

/// Range of equivalent absorption areas of rooms \[m²\].
const ABSORPTIONS: [f64; 2] = [0.1, 1e6];

/// Range of the machine's coordinates \[m\].
const PLACES: [f64; 2] = [-1e3, 1e3];

/// Range of heights of the reflecting plane, and of the sand above the floor \[m\].
const HEIGHTS: [f64; 2] = [-10.0, 10.0];

/// Largest number of repeats per configuration.
const MOST_REPEATS: usize = 1000;

/// Longest time before the trigger \[s\].
const LATEST: f64 = 1e3;

impl Manifest {
    /// Reads a manifest, checks that all its recordings exist, and reads the calibrator recordings and the sampling
    /// rate of the first recording.
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
        let mut manifest = Self::of_document(&Document::from_bytes(path, bytes)?)?;
        manifest.find_files()?;
        manifest.calibrate()?;
        if let (Some(configuration), Some(channel)) = (manifest.configurations.first(), manifest.channels.first()) {
            let file = manifest.beside(&channel.file(&configuration.name, 1));
            let track = read(&file, &[channel.source()])?;
            manifest.rate = track.first().map(|track| (track.rate, file));
        }
        Ok(manifest)
    }

    /// Parses the text of a manifest without opening recordings. `path` is for messages, and its folder is where
    /// recordings are found.
    ///
    /// # Errors
    /// [`MeasurementError::Document`] or [`MeasurementError::Manifest`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, MeasurementError> {
        Self::of_document(&Document::new(path, text))
    }

    fn of_document(document: &Document) -> Result<Self, MeasurementError> {
        let path = document.path();
        let keys = document.table()?;
        let root = Keys::of_document(document, &keys, "manifest");
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
            "markers",
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
            events: events(&root)?,
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

    /// Checks that all recordings exist and are regular files.
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

    /// Reads the calibrator recordings.
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

/// Events of the markers of a tool whose events differ from those of the N80CB.
fn events(root: &Keys<'_, '_>) -> Result<MarkerEvents, KeyError> {
    let Some(table) = root.table("markers", "[markers]")? else {
        return Ok(MarkerEvents::default());
    };
    table.only(&MARKERS.map(|marker| marker.name))?;
    let mut events = BTreeMap::new();
    for marker in MARKERS {
        if let Some(event) = table.text(marker.name, "\"strike\"")? {
            events.insert(marker.name.to_owned(), event.to_owned());
        }
    }
    Ok(MarkerEvents::new(events))
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
            return Err(own.error("channel", format!("is \"{name}\", which is not a channel"), help));
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

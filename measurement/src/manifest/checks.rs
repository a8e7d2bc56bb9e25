//! Consistency between the keys of a manifest, and conditions that reduce the value of a test.

use std::path::Path;

use nailnoise_acoustics::radiation::sound::Iso3744Box;

use super::channel::{Channel, Kind};
use super::{Manifest, Microphone};
use crate::error::MeasurementError;
use crate::recordings::{Selector, unreadable};
use nailnoise_documents::{KeyError, Keys};

/// Largest distance of a microphone from the measurement surface \[m\]: at 1 m from a source, 5 cm change the level by
/// 0.42 dB.
const OFF_SURFACE: f64 = 0.05;

/// Smallest distance between microphones \[m\]: twice the position tolerance. Those of EN 12549 are at least 0.7 m
/// apart.
const APART: f64 = 2.0 * OFF_SURFACE;

/// Number of microphones in EN 12549.
const MICROPHONES: usize = 9;

/// Minimum number of shots per configuration for a useful uncertainty of the mean.
const REPEATS: usize = 5;

/// The source that each configuration measures, indexed by its number minus one.
const MEASURED: [&str; 5] = ["the total", "the residual", "the exhaust", "the body", "the workpiece"];

/// Distance of a point from the five faces of the box other than the reflecting plane \[m\]; `point` is relative to the
/// base of the box on the plane.
fn distance(surface: &Iso3744Box, point: [f64; 3]) -> f64 {
    let [a, b, c] = surface.sides;
    let [x, y, z] = point;
    let over = [x.abs() - a, y.abs() - b, z - c];
    let outside = over.map(|over| over.max(0.0));
    let below = (-z).max(0.0);
    let outside = (outside.iter().map(|over| over * over).sum::<f64>() + below * below).sqrt();
    if outside > 0.0 {
        return outside;
    }
    -over.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Checks that there are microphones, and that they are on the measurement surface above the reflecting plane.
pub(super) fn microphones(root: &Keys<'_, '_>, manifest: &Manifest) -> Result<(), KeyError> {
    let [x, y, z] = manifest.centre;
    let height = z - manifest.plane;
    if height <= 0.0 {
        let problem = format!("is {:.3} m below the reflecting plane", -height);
        return Err(root.error(
            "centre",
            problem,
            "correct `centre` or `plane`; both are in the same axes, z up",
        ));
    }
    if manifest.microphones.is_empty() {
        return Err(root.error(
            "channels",
            "has no microphone",
            "name the channels of microphones mic1 to mic9",
        ));
    }
    let surface = Iso3744Box::around(height);
    for (index, microphone) in manifest.microphones.iter().enumerate() {
        let distance_to = |other: &Microphone| {
            let squares = other
                .position
                .iter()
                .zip(microphone.position)
                .map(|(a, b)| (a - b).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let near = manifest.microphones[..index]
            .iter()
            .find(|other| distance_to(other) < APART);
        if let Some(other) = near {
            let own = root.table("channels", "[channels]")?;
            let own = own
                .map(|all| all.table(&microphone.name, "{ ... }"))
                .transpose()?
                .flatten();
            let problem = format!(
                "is {:.3} m from {}, less than {APART} m",
                distance_to(other),
                other.name
            );
            let help = "each microphone counts for its own part of the surface; correct the position of one of them";
            return Err(own.as_ref().unwrap_or(root).error("position", problem, help));
        }
        let [u, v, w] = microphone.position;
        let off = distance(&surface, [u - x, v - y, w - manifest.plane]);
        if off > OFF_SURFACE {
            let [a, b, c] = surface.sides;
            let Some(own) = root.table("channels", "[channels]")? else {
                break;
            };
            let Some(own) = own.table(&microphone.name, "{ ... }")? else {
                break;
            };
            let problem = format!("is {off:.3} m off the measurement surface, more than {OFF_SURFACE} m");
            let help = format!(
                "the surface of EN 12549 is the box within {a} m and {b} m of x = {x}, y = {y} m and up to {:.3} m, \
                 {c:.3} m above the plane; correct the position, `centre` or `plane`",
                manifest.plane + c
            );
            return Err(own.error("position", problem, help));
        }
    }
    Ok(())
}

/// Checks that channel names, which appear in tables, pages and terminals, consist of plain characters.
pub(super) fn names(channels: &[Channel], root: &Keys<'_, '_>) -> Result<(), KeyError> {
    let plain = |letter: char| {
        letter.is_alphanumeric() || matches!(letter, ' ' | '_' | '-' | '.' | '/' | '(' | ')' | '+' | '#')
    };
    for channel in channels {
        let begins = channel
            .name
            .starts_with(|letter: char| letter.is_alphanumeric() || letter == '_');
        if !begins || !channel.name.chars().all(plain) {
            let all = root.table("channels", "[channels]")?;
            let help = "begin it with a letter or a digit, and use letters, digits, spaces and _ - . / ( ) + #";
            let problem = "is not a valid channel name: a spreadsheet or a terminal may execute it".to_owned();
            return Err(all.as_ref().unwrap_or(root).error(&channel.name, problem, help));
        }
    }
    Ok(())
}

/// Finds channels that read the same channel of the same file.
fn shared(manifest: &Manifest) -> Vec<String> {
    let mut found: Vec<(&Channel, Vec<&str>)> = Vec::new();
    for own in &manifest.channels {
        match found
            .iter_mut()
            .find(|(first, _)| first.file == own.file && first.selector == own.selector)
        {
            Some((_, names)) => names.push(&own.name),
            None => found.push((own, vec![&own.name])),
        }
    }
    let several = found.into_iter().filter(|(_, names)| names.len() > 1);
    several
        .map(|(own, names)| {
            let place = match &own.selector {
                Selector::Channel(number) => format!("channel {number}"),
                Selector::Column(column) => format!("column \"{column}\""),
            };
            format!("{} read the same record: {place} of {}", names.join(", "), own.file)
        })
        .collect()
}

/// Checks that the residual is present if it is to be subtracted.
pub(super) fn residual(root: &Keys<'_, '_>, manifest: &Manifest) -> Result<(), KeyError> {
    let has = |number: usize| manifest.configurations.iter().find(|own| own.number == number);
    let subtracted = (3..=5).find_map(has);
    match (subtracted, has(2)) {
        (Some(own), None) => {
            let Some(all) = root.table("configurations", "[configurations]")? else {
                return Ok(());
            };
            let residual = manifest.setup.configuration(2);
            let problem = format!("needs the residual {residual}, which is not in the manifest");
            let help = format!(
                "record {residual}, everything wrapped: it is subtracted from {}",
                own.name
            );
            Err(all.error(&own.name, problem, help))
        }
        _ => Ok(()),
    }
}

/// Checks that each shot has its own file or, through `{c}` and `{k}`, its own name.
pub(super) fn placeholders(root: &Keys<'_, '_>, manifest: &Manifest) -> Result<(), KeyError> {
    let several = manifest.configurations.len() > 1;
    let repeated = manifest.configurations.iter().any(|own| own.repeats > 1);
    for channel in &manifest.channels {
        for (mark, needed, what) in [("c", several, "configurations"), ("k", repeated, "repeats")] {
            if needed && !channel.has(mark) {
                let Some(own) = root.table("channels", "[channels]")? else {
                    return Ok(());
                };
                let Some(own) = own.table(&channel.name, "{ ... }")? else {
                    return Ok(());
                };
                let problem = format!("is \"{}\" for all {what}", channel.file);
                let help = format!("name a file for each of the {what} with {{{mark}}}");
                return Err(own.error("file", problem, help));
            }
        }
    }
    Ok(())
}

/// Checks that a recording exists and is a regular file.
pub(super) fn is_file(path: &Path, channel: &str) -> Result<(), MeasurementError> {
    let refuse = |error: &std::io::Error| Err(unreadable(path, channel, error));
    match std::fs::metadata(path) {
        Ok(data) if data.is_file() => Ok(()),
        Ok(_) => refuse(&std::io::Error::other("it is not a regular file")),
        Err(error) => refuse(&error),
    }
}

/// Conditions that reduce the value of the test without invalidating it.
pub(super) fn warnings(manifest: &Manifest) -> Vec<String> {
    let mut warnings = Vec::new();
    for own in manifest.configurations.iter().filter(|own| own.repeats < REPEATS) {
        let shots = if own.repeats == 1 { "shot" } else { "shots" };
        warnings.push(format!(
            "{} has {} {shots}; {REPEATS} at least are usual, fewer leave the uncertainty of the mean wide",
            own.name, own.repeats
        ));
    }
    for (index, measured) in MEASURED.iter().enumerate() {
        if !manifest.configurations.iter().any(|own| own.number == index + 1) {
            let name = manifest.setup.configuration(index + 1);
            warnings.push(format!("{name} is not in the manifest: {measured} is not measured"));
        }
    }
    if manifest.microphones.len() < MICROPHONES {
        warnings.push(format!(
            "{} of the {MICROPHONES} microphones of EN 12549 are in the manifest; the mean over the surface lacks the \
             others",
            manifest.microphones.len()
        ));
    }
    warnings.extend(shared(manifest));
    // A switch may reach full scale.
    let unlimited = manifest
        .channels
        .iter()
        .filter(|own| own.kind != Kind::Trigger && !own.calibration.limited());
    let unlimited: Vec<&str> = unlimited.map(|own| own.name.as_str()).collect();
    if !unlimited.is_empty() {
        warnings.push(format!(
            "without `full_scale` a clipped record is not recognised: {}",
            unlimited.join(", ")
        ));
    }
    warnings
}

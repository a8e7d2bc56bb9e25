//! Universal files: datasets 58 in text or binary form, numbered from 1.

use std::path::Path;

use nailnoise_meshes::uff::{Function, UffError, functions};
use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{ACCELERATION, FORCE, LENGTH, PRESSURE, TEMPERATURE, TIME, VELOCITY};

use super::axis::even_axis;
use super::fault::Fault;
use super::track::{Numbers, Refusal, Selector, Track, numbers};
use nailnoise_documents::tables::si_of;

/// Specific data types of an abscissa that is time, or unknown.
const TIMES: [i64; 2] = [17, 0];

/// Reads datasets 58 of a universal file. An unreadable dataset is an error only if it is requested.
pub(super) fn decode(bytes: &[u8], path: &Path, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let wanted = numbers(channels, "a universal file")?;
    let all = functions(bytes, path);
    let histories = histories(&all);
    let channels = all.len();
    let mut all: Vec<Option<Result<Function, UffError>>> = all.into_iter().map(Some).collect();
    let mut tracks: Vec<Track> = Vec::with_capacity(wanted.len());
    for (index, &channel) in wanted.iter().enumerate() {
        let missing = || (index, Fault::NoChannel { channel, channels });
        let place = channel.checked_sub(1).ok_or_else(missing)?;
        let track = match all.get_mut(place).ok_or_else(missing)?.take() {
            Some(Ok(function)) => track(function, channel, &histories).map_err(|fault| (index, fault))?,
            Some(Err(error)) => {
                // The error of the recording already names the file.
                let problem = error.to_string().replacen(&path.display().to_string(), "the file", 1);
                let problem = format!("{problem}{histories}");
                return Err((index, Fault::Universal { problem }));
            }
            // The dataset was requested twice.
            None => {
                let earlier = wanted.iter().position(|other| *other == channel).unwrap_or(0);
                tracks[earlier].clone()
            }
        };
        tracks.push(track);
    }
    Ok(tracks)
}

/// Lists the datasets that are time histories, for the end of a message; empty if all or none are.
fn histories(all: &[Result<Function, UffError>]) -> String {
    /// Largest number of datasets listed in a message.
    const SHOWN: usize = 12;
    let is_history =
        |function: &Result<Function, UffError>| function.as_ref().is_ok_and(|own| TIMES.contains(&own.kinds[0]));
    let found: Vec<String> = all
        .iter()
        .enumerate()
        .filter(|(_, function)| is_history(function))
        .map(|(index, _)| (index + 1).to_string())
        .collect();
    match found.len() {
        0 => "; the file has no time history".to_owned(),
        count if count == all.len() => String::new(),
        count if count > SHOWN => format!("; {} and others are time histories", found[..SHOWN].join(", ")),
        1 => format!("; {} is a time history", found[0]),
        _ => format!("; {} are time histories", found.join(", ")),
    }
}

/// The quantity of an ordinate according to its specific data type; none for general and unknown types.
fn measures(kind: i64) -> Option<Dimension> {
    Some(match kind {
        5 => TEMPERATURE,
        8 => LENGTH,
        9 | 13 => FORCE,
        11 => VELOCITY,
        12 => ACCELERATION,
        15 => PRESSURE,
        _ => return None,
    })
}

fn track(function: Function, channel: usize, histories: &str) -> Result<Track, Fault> {
    let [unit_of_time, unit] = function.units;
    let kind = function.kinds[0];
    let seconds = match unit_of_time.as_str() {
        "" => Ok(1.0),
        label => si_of(label, TIME),
    };
    if !TIMES.contains(&kind) {
        return Err(Fault::NotTime {
            channel,
            abscissa: match kind {
                18 => "a frequency".to_owned(),
                _ => format!("of the specific data type {kind}, in \"{unit_of_time}\""),
            },
            histories: histories.to_owned(),
        });
    }
    let seconds = seconds.map_err(|problem| Fault::TimeUnit {
        unit: unit_of_time,
        problem,
    })?;
    let times: Vec<f64> = function.abscissa.iter().map(|time| seconds * time).collect();
    let (rate, start) = even_axis(&times)?;
    Ok(Track {
        rate,
        start: Some(start),
        samples: function.ordinate,
        numbers: Numbers::InUnit,
        unit,
        measures: measures(function.kinds[1]),
    })
}

//! Universal files: datasets 58 in text or binary, counted from 1.

use std::path::Path;

use nailnoise_meshes::uff::{Function, functions};
use nailnoise_quantities::dimension::TIME;
use nailnoise_quantities::measure;

use super::fault::Fault;
use super::{Numbers, Refusal, Selector, Track, even_axis, numbers};

/// Specific data types of an abscissa that is time, or unknown.
const TIMES: [i64; 2] = [17, 0];

/// Reads datasets 58 of a universal file.
pub(super) fn decode(bytes: &[u8], path: &Path, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let wanted = numbers(channels, "a universal file")?;
    let universal = |problem: String| {
        // The error of the recording names the file already.
        let problem = problem.replacen(&path.display().to_string(), "the file", 1);
        (0, Fault::Universal { problem })
    };
    let mut all: Vec<Option<Function>> = functions(bytes, path)
        .map_err(|error| universal(error.to_string()))?
        .into_iter()
        .map(Some)
        .collect();
    let channels = all.len();
    let mut tracks: Vec<Track> = Vec::with_capacity(wanted.len());
    for (index, &channel) in wanted.iter().enumerate() {
        let missing = || (index, Fault::NoChannel { channel, channels });
        let place = channel.checked_sub(1).ok_or_else(missing)?;
        let track = match all.get_mut(place).ok_or_else(missing)?.take() {
            Some(function) => track(function).map_err(|fault| (index, fault))?,
            // Asked for twice.
            None => {
                let earlier = wanted.iter().position(|other| *other == channel).unwrap_or(0);
                tracks[earlier].clone()
            }
        };
        tracks.push(track);
    }
    Ok(tracks)
}

fn track(function: Function) -> Result<Track, Fault> {
    let [unit_of_time, unit] = function.units;
    let seconds = match unit_of_time.as_str() {
        "" => Ok(1.0),
        label => measure(&format!("1 {label}"), TIME),
    };
    let seconds = seconds.ok().filter(|_| TIMES.contains(&function.kinds[0]));
    let seconds = seconds.ok_or(Fault::NotTime {
        kind: function.kinds[0],
        unit: unit_of_time,
    })?;
    let times: Vec<f64> = function.abscissa.iter().map(|time| seconds * time).collect();
    let (rate, start) = even_axis(&times)?;
    Ok(Track {
        rate,
        start: Some(start),
        samples: function.ordinate,
        numbers: Numbers::InUnit,
        unit,
    })
}

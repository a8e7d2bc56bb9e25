//! Files of a wrapping test: tables of levels, markers and accelerations, and the corrected signals.

use std::path::{Path, PathBuf};

use super::table::{optional, table};
use crate::error::Error;
use crate::measurement::processing::CorrectedShot;
use crate::measurement::recordings::wav::{Coding, encode};
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::{MeasuredBand, MeasuredInterval, MeasurementResult};
use crate::measurement::wrapping::Role;

/// The corrected signals of a shot as a sound file with a channel for each microphone: path, content and full scale
/// \[Pa\].
///
/// # Errors
/// [`Error::Write`] if the file cannot store them.
pub fn corrected_signal(shot: &CorrectedShot) -> Result<(PathBuf, Vec<u8>, f64), Error> {
    let path = PathBuf::from(format!("signals/{}-{}.wav", shot.source, shot.repeat + 1));
    let signals: Vec<&[f64]> = shot.microphones.iter().map(Vec::as_slice).collect();
    let peak = signals
        .iter()
        .flat_map(|signal| signal.iter())
        .fold(0.0, |peak: f64, p| peak.max(p.abs()));
    let full_scale = if peak > 0.0 { peak } else { 1.0 };
    let bytes = encode(&signals, shot.rate.round() as u32, full_scale, Coding::Integer24);
    let bytes = bytes.map_err(|source| Error::Write {
        path: path.clone(),
        source,
    })?;
    Ok((path, bytes, full_scale))
}

/// `levels.csv`, `bands.csv`, `intervals.csv`, `markers.csv`, `accelerations.csv`, and `signals.csv` with the full
/// scale of each sound file \[Pa\].
///
/// # Errors
/// The errors of the tables.
pub fn tables(result: &MeasurementResult, signals: &[(PathBuf, f64)]) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
    Ok(vec![
        ("levels.csv", levels(result)?),
        ("bands.csv", bands(result)?),
        ("intervals.csv", intervals(result)?),
        ("markers.csv", markers(result)?),
        ("accelerations.csv", accelerations(result)?),
        ("signals.csv", scales(signals)?),
    ])
}

fn levels(result: &MeasurementResult) -> Result<Vec<u8>, Error> {
    let row = |kind: &str, name: &str, level: Option<&RepeatedLevel>, by_energy: Option<f64>, floor: Option<f64>| {
        [
            kind.to_owned(),
            name.to_owned(),
            level.map_or(0, |own| own.repeats).to_string(),
            optional(level.map(|own| own.db), 3),
            optional(level.and_then(|own| own.standard_db), 3),
            optional(level.and_then(|own| own.half_width_db), 3),
            optional(level.map(|own| own.expanded_db), 3),
            optional(by_energy, 3),
            optional(floor, 3),
        ]
    };
    let recorded = result
        .configurations
        .iter()
        .map(|own| row("recorded", &own.name, own.level.as_ref(), None, None));
    let sources = result.sources.iter().map(|own| {
        row(
            "less residual",
            &own.source,
            own.level.as_ref(),
            own.by_energy_db,
            own.floor_db,
        )
    });
    let bound = result.bound.iter().map(|own| {
        row(
            "upper bound",
            Role::Workpiece.name(),
            own.level.as_ref(),
            own.by_energy_db,
            None,
        )
    });
    table(
        [
            "kind",
            "name",
            "shots",
            "L_WA,1s [dB]",
            "standard uncertainty of the mean [dB]",
            "half of the 95 % interval [dB]",
            "expanded uncertainty with method, k = 2 [dB]",
            "by energy [dB]",
            "floor [dB]",
        ],
        recorded.chain(sources).chain(bound),
    )
}

fn bands(result: &MeasurementResult) -> Result<Vec<u8>, Error> {
    let rows = |kind: &'static str, name: &str, bands: &[MeasuredBand]| {
        let name = name.to_owned();
        let row = move |band: &MeasuredBand| {
            [
                kind.to_owned(),
                name.clone(),
                band.hz.to_string(),
                optional(band.lwa_db, 3),
            ]
        };
        bands.iter().map(row).collect::<Vec<_>>()
    };
    let recorded = result
        .configurations
        .iter()
        .flat_map(|own| rows("recorded", &own.name, &own.bands));
    let sources = result.sources.iter().flat_map(|own| {
        let mut all = rows("less residual", &own.source, &own.bands);
        all.extend(rows("by energy", &own.source, &own.bands_by_energy));
        all
    });
    let bound = result
        .bound
        .iter()
        .flat_map(|own| rows("upper bound", Role::Workpiece.name(), &own.bands));
    table(
        ["kind", "name", "band [Hz]", "L_WA,1s [dB]"],
        recorded.chain(sources).chain(bound),
    )
}

fn intervals(result: &MeasurementResult) -> Result<Vec<u8>, Error> {
    let rows = |kind: &'static str, name: &str, intervals: &[MeasuredInterval]| {
        let name = name.to_owned();
        let row = move |own: &MeasuredInterval| {
            [
                kind.to_owned(),
                name.clone(),
                own.from.clone(),
                own.to.clone(),
                format!("{:.6}", own.seconds[0]),
                format!("{:.6}", own.seconds[1]),
                optional(own.lwa_db, 3),
            ]
        };
        intervals.iter().map(row).collect::<Vec<_>>()
    };
    let recorded = result
        .configurations
        .iter()
        .flat_map(|own| rows("recorded", &own.name, &own.intervals));
    let sources = result
        .sources
        .iter()
        .flat_map(|own| rows("less residual", &own.source, &own.intervals));
    table(
        ["kind", "name", "from", "to", "from [s]", "to [s]", "L_WA,1s [dB]"],
        recorded.chain(sources),
    )
}

fn markers(result: &MeasurementResult) -> Result<Vec<u8>, Error> {
    let rows = result.configurations.iter().flat_map(|own| {
        own.markers.iter().map(|marker| {
            [
                own.name.clone(),
                marker.name.clone(),
                marker.event.clone().unwrap_or_default(),
                marker.meaning.clone(),
                marker.repeats.to_string(),
                format!("{:.7}", marker.seconds),
                marker.deviation_s.map_or_else(String::new, |own| format!("{own:.7}")),
            ]
        })
    });
    table(
        [
            "configuration",
            "marker",
            "event of the cycle",
            "meaning",
            "shots",
            "mean [s]",
            "deviation [s]",
        ],
        rows,
    )
}

fn accelerations(result: &MeasurementResult) -> Result<Vec<u8>, Error> {
    let rows = result.configurations.iter().flat_map(|own| {
        own.accelerations.iter().map(|sensor| {
            [
                own.name.clone(),
                sensor.name.clone(),
                format!("{:.4}", sensor.rms_g),
                format!("{:.2}", sensor.peak_g),
            ]
        })
    });
    table(["configuration", "accelerometer", "RMS over 1 s [g]", "peak [g]"], rows)
}

fn scales(signals: &[(PathBuf, f64)]) -> Result<Vec<u8>, Error> {
    let text = |path: &Path| path.display().to_string();
    table(
        ["file", "full scale [Pa]"],
        signals.iter().map(|(path, scale)| [text(path), format!("{scale:.6e}")]),
    )
}

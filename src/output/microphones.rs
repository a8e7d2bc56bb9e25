//! What the virtual microphones hear: tables of levels, and a calibrated sound file for each source and microphone.

use std::path::PathBuf;

use super::File;
use super::table::{optional, table};
use crate::error::Error;
use crate::measurement::recordings::wav::{Coding, encode};
use crate::result::MicrophoneReport;
use crate::run::Run;
use crate::stages::microphones::SAMPLE_RATE;

/// `microphones.csv`, `microphones-bands.csv` and `microphones/SOURCE-N.wav`: mono, 48 kHz, 24 bits, full scale as the table
/// states.
pub(super) fn files(run: &Run) -> Result<Vec<File>, Error> {
    let microphones = &run.microphones;
    let report = &microphones.report;
    let mut files = vec![
        File::new("microphones.csv", levels(report)?),
        File::new("microphones-bands.csv", bands(report)?),
    ];
    for (source, signals) in &microphones.signals {
        for (number, signal) in signals.iter().enumerate() {
            let path = sound(source, number);
            let wave = encode(&[signal], SAMPLE_RATE, report.full_scale_pa, Coding::Integer24);
            let wave = wave.map_err(|source| Error::Write {
                path: path.clone(),
                source,
            })?;
            files.push(File::new(path, wave));
        }
    }
    Ok(files)
}

/// The sound file of a source at a microphone, counted from 0.
pub(crate) fn sound(source: &str, microphone: usize) -> PathBuf {
    format!("microphones/{source}-{}.wav", microphone + 1).into()
}

/// Levels by source and microphone.
fn levels(report: &MicrophoneReport) -> Result<Vec<u8>, Error> {
    let header = [
        "source",
        "microphone",
        "x [m]",
        "y [m]",
        "z above the plane [m]",
        "L_AE [dB]",
        "L_E [dB]",
        "peak [Pa]",
        "full scale of the file [Pa]",
    ];
    let sources = report.sources.iter().map(|s| (s.source.as_str(), &s.levels));
    let rows = sources
        .chain([("total", &report.total.levels)])
        .flat_map(|(source, levels)| {
            let places = levels.iter().zip(&report.positions_m).enumerate();
            places.map(move |(number, (m, [x, y, z]))| {
                [
                    source.to_owned(),
                    (number + 1).to_string(),
                    x.to_string(),
                    y.to_string(),
                    format!("{z:.4}"),
                    optional(m.lae_db, 3),
                    optional(m.le_db, 3),
                    format!("{:.4e}", m.peak_pa),
                    report.full_scale_pa.to_string(),
                ]
            })
        });
    table(header, rows)
}

/// Bands by the array and radiated, source by source.
fn bands(report: &MicrophoneReport) -> Result<Vec<u8>, Error> {
    let rows = report.sources.iter().flat_map(|received| {
        received.bands.iter().map(|band| {
            let [array, radiated] = [band.lw_db, band.true_lw_db].map(|level| optional(level, 3));
            [received.source.clone(), band.hz.to_string(), array, radiated]
        })
    });
    table(
        ["source", "band [Hz]", "microphones L_W [dB]", "radiated L_W [dB]"],
        rows,
    )
}

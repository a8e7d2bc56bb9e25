//! Sound at the virtual microphones: tables of levels, and a calibrated sound file for each source and microphone.

use std::path::PathBuf;

use super::file::File;
use super::table::{optional, table};
use crate::error::Error;
use crate::measurement::recordings::wav::{Coding, encode};
use crate::result::MicrophoneReport;
use crate::run::Run;
use crate::stages::microphones::SAMPLE_RATE;

/// `microphones.csv`, `microphones-bands.csv`, `microphones/SOURCE-N.wav`: mono, 48 kHz, 24 bits, full scale as the table
/// states; and `microphones/about.txt`.
pub(super) fn files(run: &Run) -> Result<Vec<File>, Error> {
    let microphones = &run.microphones;
    let report = &microphones.report;
    let mut files = vec![
        File::new("microphones.csv", levels(report)?),
        File::new("microphones-bands.csv", bands(report)?),
        File::new("microphones/about.txt", note(report)),
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

/// Frequency above which a source in the sum of all is synthetic \[Hz\].
fn synthetic_from(report: &MicrophoneReport) -> Option<f64> {
    report
        .sources
        .iter()
        .filter_map(|source| source.synthetic_from_hz)
        .reduce(f64::min)
}

/// Content of the sound files, in words next to them.
fn note(report: &MicrophoneReport) -> String {
    let [low, high] = report.range_hz;
    let mut text = format!(
        "Sound pressure from the trigger on, {SAMPLE_RATE} samples a second, 24 bits; a full-scale sample is {} Pa.\n\
         All files hold {low} Hz to {high} Hz and nothing outside, with the energy that microphones.csv states. By the convention\n\
         of wrapping, exhaust and body have parts that sound together with the other source: there only the total does.\n\n",
        report.full_scale_pa
    );
    for source in &report.sources {
        let phases = match source.synthetic_from_hz {
            None => "no synthetic part".to_owned(),
            Some(from) if from <= low * (1.0 + 1e-9) => "synthetic: energies of the model, phases chosen".to_owned(),
            Some(from) => {
                format!("synthetic above {from:.0} Hz: noise with the energy and the power over time of the model")
            }
        };
        text.push_str(&format!("{}: {}; {phases}.\n", source.source, source.how));
    }
    text.push_str(
        "\nJet noise is random: the exhaust files hold one realisation. Peaks of synthetic parts and of jets are those of one realisation.\n",
    );
    text
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
        "range from [Hz]",
        "range to [Hz]",
        "synthetic from [Hz]",
    ];
    let sources = (report.sources.iter()).map(|s| (s.source.as_str(), &s.levels, s.synthetic_from_hz));
    let [low, high] = report.range_hz;
    let rows = sources
        .chain([("total", &report.total.levels, synthetic_from(report))])
        .flat_map(|(source, levels, synthetic)| {
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
                    low.to_string(),
                    high.to_string(),
                    optional(synthetic, 0),
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

//! Sound at the virtual microphones: tables of levels, and a calibrated sound file for each source and microphone.

use std::path::PathBuf;

use super::table::{optional, table};
use super::{File, Output, RunView};
use crate::error::Error;
use crate::measurement::recordings::wav::{Coding, encode};
use crate::result::MicrophoneReport;
use crate::run::Run;
use crate::stages::microphones::SAMPLE_RATE;

/// Levels at each microphone.
pub(super) const LEVELS: Output = Output::of_run("microphones.csv", |of| levels(report(of)));

/// Band powers from the microphones, next to the radiated ones.
pub(super) const BANDS: Output = Output::of_run("microphones-bands.csv", |of| bands(report(of)));

/// Description of the sound files.
pub(super) const NOTE: Output = Output::of_run("microphones/about.txt", |of| Ok(note(report(of)).into_bytes()));

/// Sound of each source at each microphone: mono, 48 kHz, 24 bits; the table states the full scale.
pub(super) const SOUNDS: Output = Output::files("microphones/*.wav", |of| {
    let microphones = 0..report(of).positions_m.len();
    Ok(microphones
        .map(|number| sounds(of.run, number))
        .collect::<Result<Vec<_>, _>>()?
        .concat())
});

fn report<'a>(of: &RunView<'a>) -> &'a MicrophoneReport {
    &of.run.microphones.report
}

/// The sound files of all sources at one microphone, counted from 0.
///
/// # Errors
/// [`Error::Write`] if a file cannot store the samples.
pub fn sounds(run: &Run, microphone: usize) -> Result<Vec<File>, Error> {
    let microphones = &run.microphones;
    let of_source = microphones.signals.iter();
    let of_source = of_source.filter_map(|(source, signals)| Some((source, signals.get(microphone)?)));
    let file = |(source, signal): (&String, &Vec<f64>)| {
        let path = sound(source, microphone);
        let full_scale = microphones.report.full_scale_pa;
        match encode(&[signal], SAMPLE_RATE, full_scale, Coding::Integer24) {
            Ok(wave) => Ok(File::new(path, wave)),
            Err(source) => Err(Error::Write { path, source }),
        }
    };
    of_source.map(file).collect()
}

/// The sound file of a source at a microphone, counted from 0.
fn sound(source: &str, microphone: usize) -> PathBuf {
    format!("microphones/{source}-{}.wav", microphone + 1).into()
}

/// Frequency above which any source in the sum of all is synthetic \[Hz\].
fn synthetic_from(report: &MicrophoneReport) -> Option<f64> {
    report
        .sources
        .iter()
        .filter_map(|source| source.synthetic_from_hz)
        .reduce(f64::min)
}

/// Description of the sound files, written next to them.
fn note(report: &MicrophoneReport) -> String {
    let [low, high] = report.range_hz;
    let mut text = format!(
        "Sound pressure from the trigger on, {SAMPLE_RATE} samples a second, 24 bits; a full-scale sample is {} Pa.\n\
         All files hold {low} Hz to {high} Hz and nothing outside, with the energy that microphones.csv states. \
         By the convention\n\
         of wrapping, exhaust and body have parts that sound together with the other source: \
         there only the total does.\n\n",
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
        "\nJet noise is random: the exhaust files hold one realisation. Peaks of synthetic parts and of jets are those \
         of one realisation.\n",
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

/// Bands from the array and radiated, for each source.
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

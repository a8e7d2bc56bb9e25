//! From recordings to levels: alignment, subtraction of the residual, levels by band and interval, uncertainty.

mod channels;
mod shots;
mod summary;

use std::cell::Cell;

use super::alignment::delay;
use super::arrangement::{Arrangement, Part};
use super::error::MeasurementError;
use super::manifest::Manifest;
use super::recordings::Shot;
use super::result::{MeasurementResult, Processing};
use super::wrapping::Configuration;
use channels::ChannelChecks;
pub use shots::ShotSignals;
use shots::{Context, ProcessedShot, Residual};
use summary::Summary;
pub use summary::{LEAST_REPEATS, Recorded};

/// Largest delay between shots considered \[s\].
const MOST_DELAY: f64 = 0.02;

/// The corrected signals of one shot of a source.
#[derive(Debug, Clone)]
pub struct CorrectedShot {
    /// The source.
    pub source: &'static str,
    /// Repeat, from 0.
    pub repeat: usize,
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Pressure at each microphone from 10 ms before the trigger onwards \[Pa\].
    pub microphones: Vec<Vec<f64>>,
}

/// Results of a test, with signals.
pub struct Measured {
    /// Levels.
    pub result: MeasurementResult,
    /// The first shot of each configuration.
    pub signals: Vec<ShotSignals>,
    /// Names of the accelerometers.
    pub accelerometers: Vec<String>,
    /// Names of the pressure transducers.
    pub transducers: Vec<String>,
}

/// Processes the recordings listed in a manifest. `read` is called after each shot with the number of shots read and
/// the total number. `keep` is called with the corrected signals of each shot of a source.
///
/// # Errors
/// Those of the recordings, of `keep` and of [`process`].
pub fn process_recordings<E: From<MeasurementError>>(
    manifest: &Manifest,
    arrangement: &Arrangement,
    processing: Processing,
    read: impl Fn(u64, u64),
    keep: impl FnMut(CorrectedShot) -> Result<(), E>,
) -> Result<Measured, E> {
    let named = || manifest.configurations.iter();
    let recorded = named().filter_map(|own| {
        Some(Recorded {
            configuration: Configuration::from_number(own.number)?,
            repeats: own.repeats,
        })
    });
    let recorded: Vec<Recorded> = recorded.collect();
    let shots: usize = recorded.iter().map(|own| own.repeats).sum();
    let done = Cell::new(0);
    let shot = |configuration: Configuration, repeat: usize| {
        let place = named().position(|own| own.number == configuration.number());
        let shot = manifest.shot(place.unwrap_or_default(), repeat)?;
        done.set(done.get() + 1);
        read(done.get(), shots as u64);
        Ok(shot)
    };
    process(arrangement, processing, &recorded, shot, keep)
}

/// Processes a test. `shot` reads a repeat, counted from 0, of a configuration; `keep` receives the corrected signals
/// of each shot of a source.
///
/// # Errors
/// Those of `shot` and `keep`; [`MeasurementError::Shot`] for markers in the wrong order.
pub fn process<E: From<MeasurementError>>(
    arrangement: &Arrangement,
    processing: Processing,
    recorded: &[Recorded],
    shot: impl Fn(Configuration, usize) -> Result<Shot, E>,
    mut keep: impl FnMut(CorrectedShot) -> Result<(), E>,
) -> Result<Measured, E> {
    let room = arrangement.room_correction()?;
    let mut context: Option<Context<'_>> = None;
    let mut residual: Option<Residual> = None;
    let mut signals = Vec::new();
    let mut reference: Option<Vec<f64>> = None;
    let mut all: Vec<(Recorded, Vec<ProcessedShot>, Vec<Option<f64>>)> = Vec::new();
    let mut checks = ChannelChecks::new(arrangement);
    // The residual comes first, because the others need it. Delays refer to the first shot read.
    let mut order: Vec<Recorded> = recorded.to_vec();
    order.sort_by_key(|one| (one.configuration != Configuration::Residual, one.configuration));
    for one in order {
        let (mut shots, mut delays) = (Vec::new(), Vec::new());
        for repeat in 0..one.repeats {
            let mut recording = shot(one.configuration, repeat)?;
            checks.see(one.configuration, &mut recording);
            let context = context.get_or_insert_with(|| Context::new(arrangement, processing, recording.rate));
            let lines = context.lines(&recording);
            if one.configuration == Configuration::Residual {
                let made = residual.get_or_insert_with(|| Residual {
                    squares: Vec::new(),
                    shots: if processing.paired { 1 } else { one.repeats as u32 },
                });
                context.accumulate_residual(made, &lines, one.repeats);
            }
            let own = residual.as_ref().map(|residual| residual.of(repeat));
            let subtracted = match one.configuration {
                Configuration::Residual => None,
                Configuration::Total => own.filter(|_| processing.total_less_residual),
                _ => own,
            };
            let (processed, corrected) = context.process(one.configuration, &recording, &lines, subtracted);
            if let Some(pair) = processed.markers.out_of_order() {
                return Err(out_of_order(arrangement, one.configuration, repeat, pair).into());
            }
            if let Some((source, microphones)) = one.configuration.source().zip(corrected) {
                let rate = recording.rate;
                keep(CorrectedShot {
                    source: source.name(),
                    repeat,
                    rate,
                    microphones,
                })?;
            }
            let moving = arrangement.accelerometer(&[Part::Handle, Part::Table, Part::Block]);
            let moving = moving.and_then(|place| recording.accelerations.get(place));
            let piece = moving.map(|record| context.transform.cut(record, recording.trigger));
            delays.push(match (&reference, &piece) {
                (Some(reference), Some(piece)) => delay(reference, piece, recording.rate, MOST_DELAY),
                _ => None,
            });
            if reference.is_none() {
                reference = piece;
            }
            if repeat == 0 {
                signals.push(context.signals(one.configuration, &recording, processed.markers));
            }
            shots.push(processed);
        }
        all.push((one, shots, delays));
    }
    all.sort_by_key(|(one, ..)| one.configuration);
    signals.sort_by_key(|shown: &ShotSignals| shown.configuration);
    let summary = Summary {
        arrangement,
        room,
        processing,
        hz: context
            .as_ref()
            .map_or_else(Vec::new, |context| context.bands.nominal_hz()),
        channels: checks.notes(),
        residual_shots: residual.as_ref().map_or(1, |residual| residual.shots),
        all,
    };
    Ok(Measured {
        result: summary.result(),
        signals,
        accelerometers: arrangement.accelerometers.clone(),
        transducers: arrangement.transducers.clone(),
    })
}

fn out_of_order(
    arrangement: &Arrangement,
    configuration: Configuration,
    repeat: usize,
    [first, second]: [(&'static str, f64); 2],
) -> MeasurementError {
    MeasurementError::Shot {
        configuration: arrangement.setup.configuration(configuration.number()),
        repeat: repeat + 1,
        problem: format!(
            "marker {} at {:.2} ms lies before {} at {:.2} ms",
            second.0,
            1e3 * second.1,
            first.0,
            1e3 * first.1
        ),
        help: "check the names of the channels and the trigger: N is on the handle, W on the block, TC under the \
            table, PT-I \
               in the cylinder"
            .to_owned(),
    }
}

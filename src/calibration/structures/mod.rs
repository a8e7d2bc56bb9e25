//! Calibration of plates by tap tests. Dimensions, mass and the first peaks determine elastic constants; these predict
//! the higher modes.

mod plate;
mod posterior;
mod reader;
mod result;
mod tap_test;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use nailnoise_calibration::sampler::Settings;
use rayon::prelude::*;

pub use result::{ModeRow, PeakRow, PlateInput, PlateResult, StructuresResult};

use super::error::CalibrationError;
use super::reader::text;
use crate::stages::Progress;

/// Degrees of the polynomials along and across the grain.
const DEGREES: [usize; 2] = [10, 7];

/// Settings of a calibration of plates.
#[derive(Debug, Clone, Copy)]
pub struct StructuresRequest {
    /// Number of draws from each posterior; even.
    pub draws: usize,
    /// Largest number of moves per step of the sampler.
    pub moves: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Calibrates the plates of a file of tap tests.
///
/// # Errors
/// The first fault in the file, with its place; or if a mode up to the highest frequency has more nodal lines than the
/// polynomials resolve.
pub fn calibrate_structures(
    path: &Path,
    request: &StructuresRequest,
    progress: &Progress,
) -> Result<StructuresResult, CalibrationError> {
    let document = text(path)?;
    let tests = reader::read(&document)?;
    let ritz = plate::Ritz::new(DEGREES);
    let settings = Settings {
        moves: request.moves,
        seed: request.seed,
    };
    progress.stage("elastic constants of plates");
    let (total, done) = (tests.tests.len() as u64, AtomicU64::new(0));
    let plates = tests.tests.par_iter().map(|test| {
        let posterior = posterior::posterior(&ritz, test, request.draws, settings)?;
        progress.done(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        Ok(result::plate_result(
            &ritz,
            test,
            &posterior,
            tests.max_frequency,
            request.seed,
        ))
    });
    let plates = plates.collect::<Result<Vec<PlateResult>, CalibrationError>>()?;
    let [most_across, most_along] = result::RESOLVED;
    for own in &plates {
        let is_beyond = |mode: &&ModeRow| mode.nodal_lines[0] > most_across || mode.nodal_lines[1] > most_along;
        if let Some(mode) = own.modes.iter().find(is_beyond) {
            return Err(CalibrationError::Unresolved {
                plate: own.name.clone(),
                hz: mode.hz[1],
            });
        }
    }
    Ok(StructuresResult {
        schema: result::SCHEMA,
        file: path.display().to_string(),
        draws: request.draws,
        seed: request.seed,
        modes_up_to: tests.max_frequency,
        plates,
    })
}

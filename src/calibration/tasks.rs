//! Tasks of a calibration: shots of candidates and of proposals, which other processes can compute.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use nailnoise_calibration::sampler::{Proposal, Sampler, Settings};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::error::CalibrationError;
use super::inputs::read;
use super::key::key;
use super::measurements::Measurements;
use super::start::tried;
use super::tool::{Tool, likelihood};
use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::stages::{Codec, Digest, Postcard};

/// Largest number of points of a task.
pub(super) const POINTS_PER_TASK: usize = 64;

/// Other processes that compute tasks by [`Worker::result`].
pub trait Workers: Sync {
    /// Number of tasks that they compute at the same time.
    fn count(&self) -> usize;

    /// Results of tasks, in their order.
    ///
    /// # Errors
    /// If the result of a task is missing.
    fn results(&self, tasks: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, CalibrationError>;
}

/// Points that a task simulates.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) enum Points {
    /// Candidates by their indices; all readings but those `left_out` must have a value.
    Candidates { left_out: Vec<usize>, indices: Range<u64> },
    /// Proposals of a move of the sampler.
    Proposals {
        left_out: Vec<usize>,
        factors: BTreeMap<usize, f64>,
        proposals: Vec<Proposal>,
    },
}

/// A task.
#[derive(Debug, Serialize, Deserialize)]
struct Task {
    /// Key of the calibration.
    calibration: Digest,
    points: Points,
}

/// The `count` results of the points of tasks, in their order.
///
/// # Errors
/// Errors of the workers, and if they do not return one result per point.
pub(super) fn distributed<R: Serialize + DeserializeOwned>(
    workers: &dyn Workers,
    calibration: &Digest,
    tasks: impl Iterator<Item = Points>,
    count: usize,
) -> Result<Vec<R>, CalibrationError> {
    let task = |points: Points| {
        bytes(&Task {
            calibration: *calibration,
            points,
        })
    };
    let results = workers.results(tasks.map(task).collect::<Result<_, _>>()?)?;
    let parts = results.iter().map(|own| value::<Vec<R>>(own));
    let all: Vec<R> = parts.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    (all.len() == count).then_some(all).ok_or(CalibrationError::NoResults)
}

/// A calibration in a process that computes tasks for another one.
pub struct Worker {
    tool: Tool,
    measured: Measurements,
    seed: u64,
    calibration: Digest,
}

impl Worker {
    /// Reads the design and the measurements of a calibration with `draws` draws and a seed.
    ///
    /// # Errors
    /// Those of [`super::calibrate`].
    pub fn new(
        design: &Design,
        assignments: &[Assignment],
        measured: &Path,
        (draws, seed): (usize, u64),
    ) -> Result<Self, Error> {
        let (design, measured) = read(design, assignments, Some(measured))?;
        let tool = Tool::new(&design, &measured, seed)?;
        let calibration = key(&design, &tool, &measured, (draws, seed)).digest();
        Ok(Self {
            tool,
            measured,
            seed,
            calibration,
        })
    }

    /// The result of a task.
    ///
    /// # Errors
    /// If the task belongs to another calibration, or to another version of the program.
    pub fn result(&self, task: &[u8]) -> Result<Vec<u8>, Error> {
        let Task { calibration, points } = value(task)?;
        if calibration != self.calibration {
            return Err(CalibrationError::OtherCalibration.into());
        }
        let none = BTreeMap::new();
        let result = match points {
            Points::Candidates { left_out, indices } => {
                let likelihood = likelihood(&self.tool, &self.measured, &left_out, &none)?;
                bytes(&tried(&self.tool, &likelihood, self.seed, indices))
            }
            Points::Proposals {
                left_out,
                factors,
                proposals,
            } => {
                // They affect the proposals only.
                let settings = Settings { moves: 0, seed: 0 };
                let likelihood = likelihood(&self.tool, &self.measured, &left_out, &factors)?;
                bytes(&Sampler::new(&self.tool, &likelihood, settings).simulate(proposals))
            }
        };
        Ok(result?)
    }
}

/// A file of measurements, and the files that it names.
///
/// # Errors
/// Those of [`super::calibrate`].
pub fn files_of(design: &Design, assignments: &[Assignment], measured: &Path) -> Result<Vec<PathBuf>, Error> {
    let (_, read) = read(design, assignments, Some(measured))?;
    Ok(std::iter::once(measured.to_owned()).chain(read.files).collect())
}

fn bytes<T: Serialize + DeserializeOwned>(value: &T) -> Result<Vec<u8>, CalibrationError> {
    let mut bytes = Vec::new();
    Postcard::write(value, &mut bytes).map_err(|_| CalibrationError::OtherCalibration)?;
    Ok(bytes)
}

fn value<T: Serialize + DeserializeOwned>(mut bytes: &[u8]) -> Result<T, CalibrationError> {
    let length = bytes.len();
    Postcard::read(&mut bytes, length).map_err(|_| CalibrationError::OtherCalibration)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::start::Tried;
    use super::*;

    const MEASURED: &str = r#"
        schema = "nailnoise-calibration/1"
        condition = { own = { outcome = "drives" } }
        measured = { depth = { condition = "own", quantity = "head_depth", value = "2 mm", error = "1 mm" } }
    "#;

    struct Here(Worker);

    impl Workers for Here {
        fn count(&self) -> usize {
            2
        }

        fn results(&self, tasks: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, CalibrationError> {
            let results = tasks.iter().map(|own| self.0.result(own));
            results
                .collect::<Result<_, _>>()
                .map_err(|_| CalibrationError::NoResults)
        }
    }

    #[test]
    fn workers_try_the_same_candidates_and_refuse_those_of_another_calibration() {
        let file = std::env::temp_dir().join(format!("nailnoise-tasks-{}.toml", std::process::id()));
        std::fs::write(&file, MEASURED).unwrap();
        let design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let workers = [1, 2].map(|seed| Here(Worker::new(&design, &[], &file, (64, seed)).unwrap()));
        std::fs::remove_file(&file).unwrap();
        let points = |indices: Range<u64>| Points::Candidates {
            left_out: Vec::new(),
            indices,
        };
        let [own, other] = &workers;
        let tasks = || [0..16, 16..24].into_iter().map(points);
        let all: Vec<Option<Tried>> = distributed(own, &own.0.calibration, tasks(), 24).unwrap();
        let likelihood = likelihood(&own.0.tool, &own.0.measured, &[], &BTreeMap::new()).unwrap();
        assert_eq!(all, tried(&own.0.tool, &likelihood, 1, 0..24));
        let refused = distributed::<Option<Tried>>(other, &own.0.calibration, tasks(), 24);
        assert!(matches!(refused, Err(CalibrationError::NoResults)));
        let too_few = distributed::<Option<Tried>>(own, &own.0.calibration, tasks(), 25);
        assert!(matches!(too_few, Err(CalibrationError::NoResults)));
    }
}

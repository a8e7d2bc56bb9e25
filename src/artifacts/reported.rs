//! A run, with the inputs of its report.

use std::sync::Arc;

use crate::chain::{Chain, Options};
use crate::design::Design;
use crate::design::inputs::{self, located};
use crate::error::Error;
use crate::graph::Graph;
use crate::output::{self, Exports, RunView};
use crate::report::{self, BodyPictures, Pictures, Recording};
use crate::run::Run;
use crate::stages::Stored;
use crate::study::StudySource;
use crate::units::Units;

/// Index of the microphone whose sound is in the report: in front of the device, at half height.
const IN_THE_REPORT: usize = 0;

/// A run, with the inputs of its report.
pub struct ReportedRun {
    /// The run.
    pub run: Run,
    pictures: Arc<Pictures>,
    recordings: Vec<Recording>,
}

impl ReportedRun {
    /// Runs a design without writing files. The result includes the known figures of its study.
    ///
    /// # Errors
    /// The errors of [`Chain::run`].
    pub fn new(graph: &Graph, design: &Design, study: &StudySource) -> Result<Self, Error> {
        let made = || {
            let (chain, pictures) = with_pictures(graph, design)?;
            let mut outputs = chain.outputs();
            outputs.push(&pictures);
            graph.prepare(&outputs)?;
            let mut own = Self::of(chain.run(design)?, pictures.get()?)?;
            own.state(design, study);
            Ok(own)
        };
        made().map_err(|error| located(design, error))
    }

    /// Adds the sounds of a run.
    pub(super) fn of(run: Run, pictures: Arc<Pictures>) -> Result<Self, Error> {
        let sounds = output::sounds(&run, IN_THE_REPORT)?;
        let named = run.microphones.signals.iter().zip(sounds);
        let recordings = named.map(|((source, _), file)| Recording {
            name: source.clone(),
            wav: file.content,
        });
        Ok(Self {
            recordings: recordings.rev().collect(),
            pictures,
            run,
        })
    }

    /// Adds the known figures of the study to the result.
    pub fn state(&mut self, design: &Design, study: &StudySource) {
        let study = study.of_run(design, &self.run.result);
        self.run.result.state_study(study);
    }

    /// The sound of all sources together in the report.
    pub fn sound_of_all(&self) -> Option<&Recording> {
        self.recordings.first()
    }

    /// The report page for the current result in these units.
    pub fn page(&self, design: &Design, units: Units) -> String {
        report::run(design, &self.run, &self.pictures, &self.recordings, units)
    }

    /// Gives outputs access to the run.
    pub(super) fn show<T>(&self, design: &Design, exports: Exports, outputs: impl FnOnce(&RunView<'_>) -> T) -> T {
        outputs(&RunView {
            design,
            run: &self.run,
            exports,
            report: &|| self.page(design, exports.units),
        })
    }
}

/// The chain of a design whose bodies can be used in a run, and the pictures of its report.
pub(super) fn with_pictures(graph: &Graph, design: &Design) -> Result<(Chain, Stored<Pictures>), Error> {
    let chain = Chain::new(graph, design, Options::default())?;
    let pictures = graph.add(BodyPictures {
        moving: chain.moving.clone(),
        efficiencies: chain.efficiencies.clone(),
        surroundings: inputs::exports::surroundings(design)?,
    });
    chain.check_bodies()?;
    Ok((chain, pictures))
}

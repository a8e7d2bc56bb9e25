//! A source of sound, and its stages in a shot.

use nailnoise_acoustics::signals::SourceSpectrum;

use crate::chain::ShotStages;
use crate::error::Error;
use crate::measurement::wrapping::Role;
use crate::result::Starts;
use crate::stages::apart::Apart;
use crate::stages::bodies::BodyKind;
use crate::stages::cycle::Engine;
use crate::stages::notes::SourceNotes;
use crate::stages::response::ResponseChecks;
use crate::stages::sources::{AnalysedSource, SourceSound};
use crate::stages::{Code, Input, Stored};

/// A source of sound.
pub(crate) trait Source: Sync {
    /// Its name in results, files and commands.
    fn name(&self) -> &'static str;

    /// Its colour in charts, as a place in the palette.
    fn colour(&self) -> usize;

    /// Its role in a wrapping test: the source of the test that includes its sound.
    fn role(&self) -> Role;

    /// Digests of the code that makes its sound.
    fn code(&self) -> Code;

    /// The bodies whose vibration it radiates.
    fn bodies(&self) -> &'static [BodyKind] {
        &[]
    }

    /// Name of its table of radiation, without the extension.
    fn radiation_table(&self) -> String {
        format!("radiation-{}", self.name())
    }

    /// Title of the chart of its parts, if it has one.
    fn chart_of_parts(&self) -> Option<&'static str> {
        None
    }

    /// Whether a tool with this engine has it.
    fn is_present(&self, engine: &Engine) -> bool;

    /// Adds its stages to those of a shot.
    ///
    /// # Errors
    /// If the values of the design do not yield valid inputs.
    fn add(&self, shot: &ShotStages<'_>) -> Result<SourceStages, Error>;
}

/// The stages of a source in a shot.
pub(crate) struct SourceStages {
    /// The source.
    pub(crate) source: &'static dyn Source,
    /// Its energy over frequency and time, without its sound at the microphones.
    pub(crate) analysis: Stored<AnalysedSource>,
    /// All that the result of a run reads of it.
    pub(crate) sound: Stored<SourceSound>,
    /// Reference with which a run compares it.
    pub(crate) compared: Compared,
    /// Notes on it, given its sound.
    pub(crate) notes: Box<dyn Fn(&SourceSound) -> Result<SourceNotes, Error> + Send + Sync>,
}

/// The same source in other shots of the design, for comparison.
#[derive(Default)]
pub(crate) struct Compared {
    /// Its energy if the bodies do not act back on the cycle, for a shot where they do.
    pub(crate) one_way: Option<Stored<Apart<SourceSpectrum>>>,
    /// Its energy with two impedances of the air, if the air's mass acts.
    pub(crate) impedance: Option<ImpedanceComparison>,
    /// Its levels for other starts, for a body that can lose contact.
    pub(crate) starts: Option<Stored<Option<Starts>>>,
}

/// Energies in linear motion with the impedance of the air frozen at each mode's resonance, and with the complete one.
pub(crate) struct ImpedanceComparison {
    /// With the frozen one.
    pub(crate) frozen: Stored<Apart<SourceSpectrum>>,
    /// With the complete one.
    pub(crate) complete: Stored<Apart<SourceSpectrum>>,
    /// Whether the complete one acts in the run. Otherwise a contact opens or acts back on the cycle, and both energies
    /// are those of the same shot with one-way coupling and the contact bonded.
    pub(crate) complete_acts: bool,
    /// Checks of the bonded motion, if it is not that of the run.
    pub(crate) report: Option<Stored<ResponseChecks>>,
}

impl SourceStages {
    /// All that the result of a run reads.
    pub(crate) fn outputs(&self) -> Vec<&dyn Input<Error>> {
        let mut all: Vec<&dyn Input<Error>> = vec![&self.sound];
        let Compared {
            one_way,
            impedance,
            starts,
        } = &self.compared;
        all.extend(one_way.iter().map(|energy| energy as &dyn Input<Error>));
        all.extend(starts.iter().map(|starts| starts as &dyn Input<Error>));
        if let Some(impedance) = impedance {
            all.extend([&impedance.frozen as &dyn Input<Error>, &impedance.complete]);
            all.extend(impedance.report.iter().map(|report| report as &dyn Input<Error>));
        }
        all
    }
}

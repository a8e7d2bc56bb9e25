//! What a source gives to a shot: its energy over frequency and time, and its sound at the microphones.
//!
//! A source implements [`Emission`]; [`Energy`] and [`Analysis`] are stages of any source.

use nailnoise_acoustics::signals::SourceSpectrum;
use serde::{Deserialize, Serialize};

use super::apart::Apart;
use super::intervals::EventEdges;
use super::microphones::Heard;
use super::sound::{SoundSource, SourceHistory};
use super::truncation::Truncation;
use super::{Code, Postcard, Progress, Stage, Stored, Uncached};
use crate::error::Error;
use crate::result::Check;
use crate::stages::cycle::ShotRecord;

/// Inputs of the sound that a source emits in a shot.
pub trait Emission: Clone + Serialize + Send + Sync + 'static {
    /// Digests of the code that makes its sound.
    const CODE: Code;

    /// Energy over frequency, without signals.
    ///
    /// # Errors
    /// Those of its inputs and of its method.
    fn energy(&self) -> Result<Apart<SourceSpectrum>, Error>;

    /// Energy over frequency, and over time between the events, within `range_hz`.
    ///
    /// # Errors
    /// Those of its inputs and of its method.
    fn analysed(&self, edges: &EventEdges, range_hz: [f64; 2]) -> Result<Apart<SoundSource>, Error>;

    /// Checks of its inputs that are not checks of the shot.
    ///
    /// # Errors
    /// Those of its inputs.
    fn checks(&self) -> Result<Vec<Check>, Error> {
        Ok(Vec::new())
    }
}

/// Energy of a source over frequency.
#[derive(Serialize)]
pub struct Energy<E>(pub E);

impl<E: Emission> Stage for Energy<E> {
    type Output = Apart<SourceSpectrum>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "energy of a source";
    const CODE: Code = E::CODE;

    fn compute(&self, _: &Progress) -> Result<Apart<SourceSpectrum>, Error> {
        self.0.energy()
    }
}

/// Energy of a source over frequency and time, without its sound at the microphones.
#[derive(Serialize)]
pub struct Analysis<E> {
    /// The source.
    pub emission: E,
    /// The shot, whose events separate the intervals.
    pub cycle: Stored<ShotRecord>,
    /// End of all records \[s\].
    pub end: Stored<f64>,
    /// Range over which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
}

/// Output of [`Analysis`].
#[derive(Debug, Clone)]
pub struct AnalysedSource {
    /// Energy over frequency and time.
    pub sound: Apart<SoundSource>,
    /// Checks of the source that are not checks of the shot.
    pub checks: Vec<Check>,
}

impl<E: Emission> Stage for Analysis<E> {
    type Output = AnalysedSource;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "analysis of a source";
    const CODE: Code = E::CODE;

    fn compute(&self, _: &Progress) -> Result<AnalysedSource, Error> {
        let edges = EventEdges::new(&self.cycle.get()?.events, *self.end.get()?);
        Ok(AnalysedSource {
            sound: self.emission.analysed(&edges, self.range_hz)?,
            checks: self.emission.checks()?,
        })
    }
}

/// A source with all that the result of a run reads of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SourceSound {
    /// Its energy and its sound at the microphones.
    pub heard: Apart<Heard>,
    /// Energy that is missing from its model above top frequencies, including parts that count to another source.
    pub truncations: Vec<Truncation>,
    /// Checks of the source, in addition to [`SoundSource::surface_check`].
    pub checks: Vec<Check>,
    /// Quantities of the source over the cycle.
    pub histories: Vec<SourceHistory>,
}

impl SourceSound {
    /// Its energy over frequency and time, without the part that counts to another source.
    pub fn source(&self) -> &SoundSource {
        &self.heard.own.source
    }
}

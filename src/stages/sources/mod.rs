//! The vibrating surfaces as sources: the workpiece with its support, and the tool's body.

mod body;
mod workpiece;

use nailnoise_dynamics::Events;
use serde::{Deserialize, Serialize};

pub use body::{BodyEnergy, BodySound, BodySource, Housing, HousingAtMicrophones};
pub use workpiece::{Radiated, WorkpieceEnergy, WorkpieceRadiated, WorkpieceSound, WorkpieceSource};

use super::convention::MovedPart;
use super::intervals::EventEdges;
use super::microphones::AtMicrophones;
use super::sound::{Sound, SoundSource};
use super::truncation::{Part, Truncation, truncations};
use super::{Code, code};
use crate::result::Check;

/// Code that the stages of this module call.
const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    stages_bodies,
    stages_convention,
    stages_intervals,
    stages_microphones,
    stages_radiation,
    stages_response,
    stages_sound,
    stages_sources,
    stages_spectra,
    stages_truncation
);

/// Largest difference between the two evaluations of the A-weighted level \[dB\].
const DIFFERENCE: f64 = 0.1;

/// A vibrating surface as a source.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SurfaceSource {
    /// Its energy over frequency and time.
    pub source: SoundSource,
    /// Its sound at the microphones.
    pub received: AtMicrophones,
    /// Energy that is missing from its model above top frequencies, including those parts that count to another source.
    pub truncations: Vec<Truncation>,
    /// The part that counts to another source and not to this one.
    pub moved: Option<MovedPart>,
}

impl SurfaceSource {
    /// A source with its sound at the microphones, whose model ends at the top frequencies of its `parts`; intervals lie
    /// between the events of a shot whose records last until `end` \[s\].
    fn new(
        (name, sound): (&'static str, Sound),
        received: AtMicrophones,
        parts: impl IntoIterator<Item = Part>,
        (events, end): (&Events, f64),
        range_hz: [f64; 2],
    ) -> Self {
        Self {
            truncations: truncations((name, &sound.spectrum), range_hz, parts),
            source: SoundSource::new(sound, &EventEdges::new(events, end), range_hz),
            received,
            moved: None,
        }
    }

    /// Check that both evaluations of its power agree.
    pub fn check(&self) -> Option<Check> {
        let difference = self.source.radiation.as_ref()?.surface_difference_db?;
        let source = &self.source.spectrum.source;
        let name = format!("{source}: power by the surface less that by the far field [dB]");
        Some(Check::at_most(name, difference, DIFFERENCE))
    }
}

//! The vibrating surfaces as sources: the workpiece with its support, and the tool's body.

mod body;
mod workpiece;

use serde::{Deserialize, Serialize};

pub use body::{BodyEnergy, BodySound, BodySource, Housing};
pub use workpiece::{WorkpieceEnergy, WorkpieceSource};

use super::microphones::AtMicrophones;
use super::sound::SoundSource;
use super::truncation::Truncation;
use super::{Code, code};
use crate::result::Check;

/// Code that the stages of this module call.
const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    stages_bodies,
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
    /// Energy that its model lacks above top frequencies.
    pub truncations: Vec<Truncation>,
}

impl SurfaceSource {
    /// Check that both evaluations of its power agree.
    pub fn check(&self) -> Option<Check> {
        let difference = self.source.radiation.as_ref()?.surface_difference_db?;
        let source = &self.source.spectrum.source;
        let name = format!("{source}: power by the surface less that by the far field [dB]");
        Some(Check::at_most(name, difference, DIFFERENCE))
    }
}

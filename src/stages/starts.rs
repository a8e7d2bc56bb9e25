//! Scatter of the level of a bouncing workpiece.
//!
//! A block that leaves its support and lands amplifies small differences that no design specifies: gaps of a micrometre
//! change when and how it lands, and thus its vibration. The response is computed for several such starts; the standard
//! deviation is part of the level's uncertainty.

use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};
use serde::Serialize;

use super::apart::Apart;
use super::sources::SourceSound;
use super::{Code, OnDemand, Postcard, Progress, Stage, Stored, code};
use crate::error::Error;
use crate::result::Starts;

/// A-weighted levels of the workpiece for several starts.
#[derive(Serialize)]
pub struct OtherStarts {
    /// The workpiece of the run, which uses the first start.
    pub first: Stored<SourceSound>,
    /// Energies of the other starts.
    pub others: OnDemand<Vec<Stored<Apart<SourceSpectrum>>>>,
    /// Range over which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
}

impl Stage for OtherStarts {
    /// `None` for a silent workpiece.
    type Output = Option<Starts>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "other starts";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_apart,
        stages_intervals,
        stages_microphones,
        stages_radiation,
        stages_response,
        stages_sound,
        stages_sources,
        stages_spectra,
        stages_starts,
        stages_truncation
    );

    fn compute(&self, _: &Progress) -> Result<Option<Starts>, Error> {
        let level = |spectrum: &SourceSpectrum| spectrum.level(self.range_hz, Weighting::A);
        let Some(first) = level(&self.first.get()?.source().spectrum) else {
            return Ok(None);
        };
        let mut levels = vec![first];
        for other in self.others.iter() {
            levels.extend(level(&other.get()?.own));
        }
        let count = levels.len() as f64;
        let mean = levels.iter().sum::<f64>() / count;
        let squares: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
        Ok(Some(Starts {
            mean_lwa_db: mean,
            deviation_db: (squares / (count - 1.0)).sqrt(),
            lwa_db: levels,
        }))
    }
}

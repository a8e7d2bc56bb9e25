//! Sound at the operator's ear: exposure and C-weighted peak of the emission sound pressure.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::{Weighting, energy_level, peak_level};
use nalgebra::{Point3, distance};
use serde::{Deserialize, Serialize};

use super::sources::SPREAD_EVENLY;
use super::{AtMicrophones, MicrophoneArray, REFERENCE, SAMPLE_RATE};
use crate::error::Error;
use crate::result::EarReport;

/// Sound of a source, or of a part of one, at the ear.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct AtEar {
    /// A-weighted exposure \[Pa² s\].
    pub exposure: f64,
    /// Pressure at 48 kHz from the trigger on \[Pa\].
    pub signal: Vec<f64>,
}

impl AtEar {
    /// Adds `factor` times a part.
    pub(super) fn add(&mut self, part: &Self, factor: f64) {
        self.exposure += factor * part.exposure;
        self.signal
            .iter_mut()
            .zip(&part.signal)
            .for_each(|(own, p)| *own += factor * p);
    }
}

impl MicrophoneArray {
    /// Levels at the ear. `radiated` is the A-weighted energy of all sources over the whole range \[J\]: what lies outside the
    /// ranges over which pressures are known is spread evenly from the device's centre, with its image in the plane.
    ///
    /// # Errors
    /// Pressures that are not finite.
    pub(super) fn at_ear(&self, sources: &[&AtMicrophones], radiated: f64) -> Result<EarReport, Error> {
        let known: f64 = sources.iter().map(|source| source.energies[1]).sum();
        let rest = (radiated - known).max(0.0);
        let exposure = sources.iter().map(|source| source.ear.exposure).sum::<f64>().max(0.0);
        let evenly = rest * self.spreading(&self.air);
        let mut signal: Vec<f64> = Vec::new();
        for source in sources {
            signal.resize(signal.len().max(source.ear.signal.len()), 0.0);
            signal.iter_mut().zip(&source.ear.signal).for_each(|(sum, p)| *sum += p);
        }
        let peak_db = peak_level(&signal, 1.0 / f64::from(SAMPLE_RATE), Weighting::C)?;
        // A source whose pressure ends below the range lacks part of every pulse; one without phases has no pulses at all.
        let lacking = |source: &&AtMicrophones| match source.range_hz[1] < self.range_hz[1] * (1.0 - 1e-9) {
            true => Some(format!("{} known to {:.0} Hz", source.source, source.range_hz[1])),
            false if source.how.starts_with(SPREAD_EVENLY) => Some(format!("{} has no phases", source.source)),
            false => None,
        };
        let lacking: Vec<String> = sources.iter().filter_map(lacking).collect();
        Ok(EarReport {
            position_m: self.ear,
            lpa_1s_db: energy_level((exposure + evenly) / REFERENCE),
            spread_share: if exposure + evenly > 0.0 {
                evenly / (exposure + evenly)
            } else {
                0.0
            },
            lpc_peak_db: peak_db.filter(|_| lacking.is_empty()),
            lpc_peak_known_db: peak_db,
            not_stated: (!lacking.is_empty()).then(|| lacking.join(", ")),
        })
    }

    /// Exposure at the ear of 1 J that is radiated evenly from the device's centre over the reflecting plane \[Pa² s/J\].
    fn spreading(&self, air: &Air) -> f64 {
        let [x, y, foot] = self.foot;
        let height = foot + self.centre_height;
        let ear = Point3::from(self.ear);
        let paths = [height, 2.0 * self.reflecting_plane - height].map(|z| distance(&ear, &Point3::new(x, y, z)));
        air.impedance() / (4.0 * PI) * paths.iter().map(|path| 1.0 / (path * path)).sum::<f64>()
    }
}

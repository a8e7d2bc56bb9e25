//! Only the levels of a shot, without sound at microphones and histories: the record of a draw in a study.

use serde::{Deserialize, Serialize};

use super::apart::Apart;
use super::bodies::Body;
use super::convention::counted;
use super::ranking::rank;
use super::response::Vibration;
use super::sensors::{SensorRecord, Sensors};
use super::sound::SoundSource;
use super::sources::AnalysedSource;
use super::{Code, Postcard, Progress, Stage, Stored, all, code};
use crate::error::Error;
use crate::stages::cycle::ShotRecord;

/// Inputs of the levels of a shot.
#[derive(Serialize)]
pub struct ShotLevels {
    /// The sources.
    pub sources: Vec<Stored<AnalysedSource>>,
    /// The cycle of the shot.
    pub cycle: Stored<ShotRecord>,
    /// Range over which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
    /// Elastic bodies, whose checks are included.
    pub bodies: Vec<Stored<Body>>,
    /// Their responses, whose checks are included.
    pub responses: Vec<Stored<Vibration>>,
    /// Sensors, if the design has any.
    pub sensors: Option<Sensors>,
}

/// Levels of a shot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Levels {
    /// Name of the outcome.
    pub outcome: String,
    /// The sources, in the order of their list.
    pub sources: Vec<SourceLevels>,
    /// Failed checks of cycle, bodies and responses.
    pub failed_checks: Vec<String>,
    /// Name of each sensor and its RMS acceleration over 1 s \[g\].
    pub sensors: Vec<(String, f64)>,
}

/// Levels of a source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceLevels {
    /// Its name.
    pub source: String,
    /// A-weighted single-event sound power level \[dB re 1 pW s\]; `None` when silent.
    pub lwa_db: Option<f64>,
    /// Bounds of the method's error \[dB\], both positive; `None` if the method gives no bound.
    pub method_db: [Option<f64>; 2],
    /// Nominal mid-band frequency \[Hz\] and A-weighted level \[dB re 1 pW s\] of each one-third-octave band.
    pub bands: Vec<(f64, Option<f64>)>,
    /// Events on either side, and the A-weighted level between them \[dB re 1 pW s\].
    pub intervals: Vec<(String, Option<f64>)>,
}

impl Stage for ShotLevels {
    type Output = Levels;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "levels of a draw";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_apart,
        stages_bodies,
        stages_convention,
        stages_cycle,
        stages_intervals,
        stages_levels,
        stages_microphones,
        stages_radiation,
        stages_ranking,
        stages_response,
        stages_sensors,
        stages_sound,
        stages_sources,
        stages_spectra,
        stages_truncation
    );

    fn compute(&self, _: &Progress) -> Result<Levels, Error> {
        let record = self.cycle.get()?;
        let analysed = all(&self.sources)?;
        let sounds: Vec<Apart<&SoundSource>> = analysed.iter().map(|own| own.sound.map(|sound| sound)).collect();
        let sources = counted(&sounds, self.range_hz);
        let (ranking, _) = rank(&sources.iter().collect::<Vec<_>>(), self.range_hz);
        let levels = |source: &SoundSource| {
            let ranked = ranking.iter().find(|own| own.source == source.spectrum.source)?;
            let between = |from: &str, to: &str| format!("{from} - {to}");
            Some(SourceLevels {
                source: ranked.source.clone(),
                lwa_db: ranked.lwa_db,
                method_db: source.uncertainty.bounds(),
                bands: ranked.bands.iter().map(|band| (band.hz, band.lwa_db)).collect(),
                intervals: ranked
                    .intervals
                    .iter()
                    .filter(|interval| interval.to_s > interval.from_s)
                    .map(|interval| (between(&interval.from, &interval.to), interval.lwa_db))
                    .collect(),
            })
        };
        let mut checks = record.checks.clone();
        checks.extend(analysed.iter().flat_map(|source| source.checks.iter().cloned()));
        for body in all(&self.bodies)? {
            checks.extend(body.checks());
        }
        for response in all(&self.responses)? {
            checks.extend(response.checks.iter().cloned());
        }
        let failed = checks.iter().filter(|check| !check.ok);
        let records = self.sensors.as_ref().map(Sensors::records).transpose()?;
        let rms = |record: &SensorRecord| (record.name.clone(), record.level().rms_g);
        Ok(Levels {
            outcome: record.outcome.clone(),
            sources: sources.iter().filter_map(levels).collect(),
            failed_checks: failed.map(|check| check.name.to_string()).collect(),
            sensors: records.iter().flatten().map(rms).collect(),
        })
    }
}

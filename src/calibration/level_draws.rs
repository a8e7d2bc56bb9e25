//! Levels of the shots of joint draws, under the conditions of measured levels and of the design itself.

use std::sync::Arc;

use nailnoise_acoustics::signals::bands_of;
use serde::{Deserialize, Serialize};

use super::level_quantities::{STANDARD_GRAVITY, ShotSound, Spectrum};
use super::measurements::Measurements;
use crate::chain::Chain;
use crate::design::{Design, JointDraws, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::levels::SourceLevels;
use crate::stages::microphones::AtMicrophones;
use crate::stages::{Digest, Postcard, Progress};
use crate::store::Key;
use crate::study::{
    Draws, Request, Scope, StudyError, Variable, VariableKind, common_draws, method_errors, outputs_of_draws, value_at,
};

/// Name of its store entries.
const SOUND: &str = "bands of a draw at microphones";

/// (20 uPa)2 s \[Pa2 s\].
const REFERENCE: f64 = 4e-10;

/// Shots of joint draws.
pub(super) struct LevelDraws {
    /// Row of the joint draws of each shot.
    pub(super) rows: Vec<usize>,
    /// Draws of the design itself, then of each condition with measured levels.
    made: Vec<Draws>,
    /// Sound of each shot, by the same designs.
    sounds: Vec<Vec<ShotSound>>,
    /// Place of each condition's design.
    places: Vec<Option<usize>>,
    sources: Vec<String>,
    /// Indices of the further variables that are drawn.
    further: Vec<usize>,
}

/// Sound that is stored for a draw.
#[derive(Serialize, Deserialize)]
struct Observed {
    /// A-weighted exposure of each source at each receiver in each one-third octave \[Pa2 s\].
    received: Vec<Vec<Vec<f64>>>,
    sensors: Vec<(String, [f64; 2])>,
}

/// The shots of `count` joint draws.
///
/// # Errors
/// The errors of a study; [`StudyError::NoLevels`] if the sound of no draw can be computed.
pub(super) fn level_draws(
    graph: &Graph,
    (design, joint): (&Design, Arc<JointDraws>),
    measured: &Measurements,
    (count, seed): (usize, u64),
    progress: &Progress,
) -> Result<LevelDraws, Error> {
    let mut designs = vec![design.with_joint_draws(Arc::clone(&joint))];
    let mut places = vec![None; measured.conditions.len()];
    for (number, condition) in measured.conditions.iter().enumerate() {
        if measured.levels.iter().any(|own| own.condition == number) {
            places[number] = Some(designs.len());
            let own = condition.design.with_required(&condition.outcomes);
            designs.push(own.with_joint_draws(Arc::clone(&joint)));
        }
    }
    let all: Vec<&Design> = designs.iter().collect();
    let made = common_draws(graph, &all, &Request::new(count, seed), progress)?;
    let sound = |place: usize| {
        let own = |number: &usize| places[*number] == Some(place);
        let levels = measured.levels.iter().filter(|level| own(&level.condition));
        let wanted = levels.fold([false; 2], |[microphones, sensors], own| {
            [
                microphones || own.quantity.needs_microphones(),
                sensors || own.quantity.needs_sensors(),
            ]
        });
        observed(graph, (&designs[0], &designs[place]), &made[place], wanted, progress)
    };
    let observed: Vec<Vec<Result<Observed, String>>> = (0..designs.len()).map(sound).collect();
    let failure = observed.iter().flatten().find_map(|own| own.as_ref().err());
    let is_whole = |draw: &usize| observed.iter().all(|own| own[*draw].is_ok());
    let whole: Vec<usize> = (0..made[0].draws.len()).filter(is_whole).collect();
    if let (true, Some(reason)) = (whole.is_empty(), failure) {
        return Err(StudyError::NoLevels {
            draws: observed[0].len(),
            reason: reason.clone(),
        }
        .into());
    }
    let made: Vec<Draws> = made
        .into_iter()
        .map(|own| Draws {
            draws: whole.iter().map(|&draw| own.draws[draw].clone()).collect(),
            ..own
        })
        .collect();
    let mut sounds = Vec::new();
    for (place, own) in observed.into_iter().enumerate() {
        let area_db = 10.0 * inputs::microphones::area(&designs[place]).log10();
        let analysis = &designs[place].analysis;
        let bands: Vec<f64> = bands_of([analysis.range_low, analysis.range_high])
            .iter()
            .map(|own| own.nominal_hz())
            .collect();
        let mut own: Vec<Option<Observed>> = own.into_iter().map(Result::ok).collect();
        let shot = |(draw, &place_of_draw): (usize, &usize)| {
            let found = own[place_of_draw].take();
            let (received, sensors) = found.map_or_else(Default::default, |own| (own.received, own.sensors));
            let levels = &made[place].draws[draw].levels;
            let power = levels.sources.iter().map(|own| (own.source.clone(), power_of(own)));
            let at_receivers = |own: &Vec<Vec<f64>>| own.iter().map(|own| spectrum_of(own, &bands)).collect();
            ShotSound {
                power: power.collect(),
                received: received.iter().map(at_receivers).collect(),
                area_db,
                sensors,
            }
        };
        sounds.push(whole.iter().enumerate().map(shot).collect());
    }
    let first = &made[0];
    let sources = first.draws.first().map_or(&[][..], |own| &own.levels.sources);
    let is_further = |&place: &usize| {
        let variable: &Variable = &first.variables[place];
        let is_drawn = first.draws.iter().all(|own| !own.shares[place].is_nan());
        let is_number = matches!(variable.kind, VariableKind::Quantity(_) | VariableKind::LawScore);
        is_drawn && is_number && variable.scope == Scope::Shot && !joint.names.contains(&variable.name)
    };
    Ok(LevelDraws {
        rows: first
            .draws
            .iter()
            .map(|own| joint.row_of(own.candidate, seed))
            .collect(),
        sources: sources.iter().map(|own| own.source.clone()).collect(),
        further: (0..first.variables.len()).filter(is_further).collect(),
        sounds,
        places,
        made,
    })
}

/// Sound at the microphones, and at the sensors, of a design's draws.
fn observed(
    graph: &Graph,
    (common, design): (&Design, &Design),
    made: &Draws,
    [microphones, sensors]: [bool; 2],
    progress: &Progress,
) -> Vec<Result<Observed, String>> {
    let nothing = || Observed {
        received: Vec::new(),
        sensors: Vec::new(),
    };
    if !microphones && !sensors {
        return made.draws.iter().map(|_| Ok(nothing())).collect();
    }
    progress.stage("sound of the draws at microphones and sensors");
    let of = |chain: &Chain| -> Result<Observed, Error> {
        let key: Digest = Key::empty()
            .with(chain.levels.key())
            .with(chain.sensors.key())
            .with(&[microphones, sensors])
            .with(SOUND)
            .digest();
        if let Some(known) = graph.store().load::<Observed, Postcard>(SOUND, &key) {
            return Ok(known);
        }
        let mut own = nothing();
        if microphones {
            let received = chain.received(design)?;
            own.received = received.iter().map(weighted).collect();
        }
        if sensors {
            let level = |g: f64| 20.0 * (g * STANDARD_GRAVITY).log10();
            let records = chain.sensors.get()?;
            own.sensors = records
                .iter()
                .map(|record| {
                    let own = record.level();
                    (own.name, [own.rms_g, own.peak_g].map(level))
                })
                .collect();
        }
        graph.store().save::<_, Postcard>(SOUND, &key, &own);
        Ok(own)
    };
    let all = outputs_of_draws(graph, (common, design), made, progress, of);
    all.into_iter()
        .map(|own| own.map_err(|error| error.in_words()))
        .collect()
}

/// A-weighted exposures of a source at each receiver in each one-third octave \[Pa2 s\].
fn weighted(source: &AtMicrophones) -> Vec<Vec<f64>> {
    let exposures = source.exposures.iter();
    exposures.map(|bands| bands.iter().map(|[a, _]| *a).collect()).collect()
}

/// Levels of exposures in one-third octaves \[dB re (20 uPa)2 s\]. Parts of a source may take energy from a band.
fn spectrum_of(exposures: &[f64], bands: &[f64]) -> Spectrum {
    let level = |exposure: f64| 10.0 * (exposure.max(0.0) / REFERENCE).log10();
    Spectrum {
        level: level(exposures.iter().sum()),
        bands: bands
            .iter()
            .copied()
            .zip(exposures.iter().map(|own| level(*own)))
            .collect(),
    }
}

/// Sound power levels of a source \[dB re 1 pW s\].
fn power_of(source: &SourceLevels) -> Spectrum {
    let level = |own: Option<f64>| own.unwrap_or(f64::NEG_INFINITY);
    Spectrum {
        level: level(source.lwa_db),
        bands: source.bands.iter().map(|(hz, own)| (*hz, level(*own))).collect(),
    }
}

impl LevelDraws {
    /// Number of shots.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Names of the sources.
    pub(super) fn sources(&self) -> &[String] {
        &self.sources
    }

    fn place(&self, condition: usize) -> usize {
        self.places[condition].unwrap_or(0)
    }

    /// Sound of a shot under a condition.
    pub(super) fn sound(&self, condition: usize, shot: usize) -> &ShotSound {
        &self.sounds[self.place(condition)][shot]
    }

    /// Errors of the methods in a shot under a condition, at these places between their bounds \[dB\].
    pub(super) fn method_errors(&self, condition: usize, shot: usize, shares: &[f64]) -> Vec<f64> {
        self.errors_in(self.place(condition), shot, shares)
    }

    fn errors_in(&self, place: usize, shot: usize, shares: &[f64]) -> Vec<f64> {
        let made = &self.made[place];
        let draw = &made.draws[shot];
        method_errors(&made.variables, &self.with_methods(made, shot, shares), &draw.levels)
    }

    /// Shares of all variables with these places of the methods' errors.
    fn with_methods(&self, made: &Draws, shot: usize, shares: &[f64]) -> Vec<f64> {
        let own = made.variables.iter().zip(&made.draws[shot].shares);
        own.map(|(variable, share)| self.share_of_method(variable, shares).unwrap_or(*share))
            .collect()
    }

    fn share_of_method(&self, variable: &Variable, shares: &[f64]) -> Option<f64> {
        if !matches!(variable.kind, VariableKind::Method(_)) {
            return None;
        }
        let name = variable.name.strip_prefix("method.")?;
        Some(shares[self.sources.iter().position(|own| own == name)?])
    }

    /// Level of each source in a shot of the design itself, with errors of the methods \[dB re 1 pW s\].
    pub(super) fn of_design(&self, shot: usize, shares: &[f64]) -> Vec<f64> {
        let errors = self.errors_in(0, shot, shares);
        let power = self.sounds[0][shot].power.iter().zip(errors);
        power.map(|((_, own), error)| own.level + error).collect()
    }

    /// Names of inputs that are not in the joint draws, and of the methods' errors.
    pub(super) fn further_names(&self) -> Vec<String> {
        let keys = self
            .further
            .iter()
            .map(|&place| self.made[0].variables[place].name.clone());
        keys.chain(self.sources.iter().map(|source| format!("method.{source}")))
            .collect()
    }

    /// Values of these inputs in a shot.
    pub(super) fn further(&self, shot: usize, shares: &[f64]) -> Vec<f64> {
        let draw = &self.made[0].draws[shot];
        let value = |&place: &usize| {
            let variable = &self.made[0].variables[place];
            value_at(variable, draw.shares[place]).unwrap_or(f64::NAN)
        };
        self.further.iter().map(value).chain(shares.iter().copied()).collect()
    }
}

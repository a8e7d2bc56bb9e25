//! The result of tap tests: elastic constants, peaks and predicted modes of each plate.

use std::collections::BTreeMap;

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::conflict::{CONFLICT, left_out_probability, left_over};
use nailnoise_calibration::likelihood::ErrorLaw;
use serde::Serialize;

use super::super::result::{MOVED, Verdict, percentiles};
use super::plate::{PlateMode, Ritz};
use super::posterior::Posterior;
use super::tap_test::{INPUTS, LENGTH, MASS, THICKNESS, TapTest, UNSEEN, WIDTH};

/// Name and version of the layout.
pub(super) const SCHEMA: &str = "nailnoise-structures-calibrated/1";

/// A mode is listed if at least this share of the draws has it below the highest frequency.
const PRESENT: f64 = 0.5;

/// Maximum number of nodal lines, across and along the grain, of a mode that the polynomials resolve.
pub(super) const RESOLVED: [usize; 2] = [8, 5];

/// Apart from the seeds of the sampler.
const ERRORS: u64 = 0x5EED_E7707;

/// Results of all plates of a file.
#[derive(Debug, Clone, Serialize)]
pub struct StructuresResult {
    /// Name and version of the layout.
    pub schema: &'static str,
    /// The file of tap tests.
    pub file: String,
    /// Draws from each posterior.
    pub draws: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Modes are predicted up to this frequency \[Hz\].
    pub modes_up_to: f64,
    /// The plates in the order of the file.
    pub plates: Vec<PlateResult>,
}

impl StructuresResult {
    /// Whether the draws of every plate have converged.
    pub fn converged(&self) -> bool {
        self.plates.iter().all(|own| own.faults.is_empty())
    }

    /// Whether any peak contradicts others.
    pub fn has_conflict(&self) -> bool {
        let mut peaks = self.plates.iter().flat_map(|own| &own.peaks);
        peaks.any(|own| own.verdict.is_conflict())
    }

    /// Names of the plates whose draws have not converged, with each diagnostic that exceeds its limit.
    pub fn faults(&self) -> impl Iterator<Item = (&str, &str)> {
        let plates = self.plates.iter();
        plates.flat_map(|own| own.faults.iter().map(|fault| (own.name.as_str(), fault.as_str())))
    }

    /// Names of the inputs whose ranges no plate narrows.
    pub fn undetermined(&self) -> Vec<&'static str> {
        let Some(first) = self.plates.first() else {
            return Vec::new();
        };
        let is_wide = |k: usize| self.plates.iter().all(|own| own.inputs[k].ratio > MOVED);
        let inputs = first.inputs.iter().enumerate();
        inputs.filter(|(k, _)| is_wide(*k)).map(|(_, own)| own.name).collect()
    }
}

/// Result of one plate. Intervals contain P5, P50 and P95.
#[derive(Debug, Clone, Serialize)]
pub struct PlateResult {
    /// Its name.
    pub name: String,
    /// Density \[kg/m³\].
    pub density: [f64; 3],
    /// Diagnostics that exceed their limits.
    pub faults: Vec<String>,
    /// Number of candidates from which the draws descend.
    pub ancestors: usize,
    /// Inputs.
    pub inputs: Vec<PlateInput>,
    /// Peaks in ascending order, and the number of modes without a peak.
    pub peaks: Vec<PeakRow>,
    /// Modes up to the highest frequency.
    pub modes: Vec<ModeRow>,
}

/// An input of a plate, before and after.
#[derive(Debug, Clone, Serialize)]
pub struct PlateInput {
    /// Its name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// P5, P50 and P95 of its range.
    pub before: [f64; 3],
    /// P5, P50 and P95 of the draws.
    pub now: [f64; 3],
    /// Ratio of the widths; of the logarithms' for a modulus.
    pub ratio: f64,
}

/// A peak and its mode.
#[derive(Debug, Clone, Serialize)]
pub struct PeakRow {
    /// Name: the frequency, or the number of modes without a peak.
    pub name: String,
    /// The reading \[Hz\], or 0 for that number.
    pub reading: f64,
    /// Nodal lines across and along the grain of the mode in most draws; null for the number.
    pub nodal_lines: Option<[usize; 2]>,
    /// Share of the draws in which it is this mode.
    pub share: f64,
    /// P5, P50 and P95 of the mode's frequency \[Hz\], without the error of the model.
    pub now: [f64; 3],
    /// Reading minus mean prediction, in combined standard deviations.
    pub left_over: f64,
    /// Predictive probability given the other readings. For a reading that was left out, it is the value at that time.
    pub probability: f64,
    /// The reading that it contradicts; null if it contradicts the others together, or none.
    pub partner: Option<String>,
    /// Whether it conditions the inputs.
    pub counts: bool,
    /// Its status.
    pub verdict: Verdict,
}

/// A predicted mode.
#[derive(Debug, Clone, Serialize)]
pub struct ModeRow {
    /// Nodal lines across and along the grain.
    pub nodal_lines: [usize; 2],
    /// P5, P50 and P95 of its frequency \[Hz\], with the error of the model.
    pub hz: [f64; 3],
    /// Whether it has a peak in most draws.
    pub has_peak: bool,
}

/// The result of a plate.
pub(super) fn plate_result(
    ritz: &Ritz,
    test: &TapTest,
    posterior: &Posterior,
    max_frequency: f64,
    seed: u64,
) -> PlateResult {
    let particles = &posterior.state.particles;
    let points: Vec<&[f64]> = particles.iter().map(|own| own.z.as_slice()).collect();
    let modes: Vec<Vec<PlateMode>> = points
        .iter()
        .map(|z| ritz.modes(&test.plate(z)).unwrap_or_default())
        .collect();
    let peaks = peaks(test, posterior, &modes);
    let density = points.iter().map(|z| {
        let at = |k: usize| test.inputs[k].law.at(z[k]);
        at(MASS) / (at(LENGTH) * at(WIDTH) * at(THICKNESS))
    });
    PlateResult {
        name: test.name.clone(),
        density: percentiles(density),
        faults: posterior.diagnostics.faults.iter().map(ToString::to_string).collect(),
        ancestors: posterior.diagnostics.ancestors,
        inputs: (0..INPUTS).map(|k| input(test, posterior, k)).collect(),
        modes: predicted(test, &modes, &peaks, max_frequency, seed),
        peaks,
    }
}

fn input(test: &TapTest, posterior: &Posterior, k: usize) -> PlateInput {
    let own = test.inputs[k];
    let before = percentiles(posterior.candidates.iter().map(|draw| own.law.at(draw.z[k])));
    let now = percentiles(posterior.state.particles.iter().map(|draw| own.law.at(draw.z[k])));
    let is_modulus = own.unit == "Pa";
    let width = |[low, _, high]: [f64; 3]| if is_modulus { (high / low).ln() } else { high - low };
    PlateInput {
        name: own.name,
        unit: own.unit,
        before,
        now,
        ratio: width(now) / width(before),
    }
}

fn peaks(test: &TapTest, posterior: &Posterior, modes: &[Vec<PlateMode>]) -> Vec<PeakRow> {
    let particles = &posterior.state.particles;
    let assigned: Vec<_> = modes
        .iter()
        .map(|modes| test.assigned(modes, &posterior.counts))
        .collect();
    let row = |k: usize| {
        let mut of_lines: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        if k < test.peaks.len() {
            for (modes, assigned) in modes.iter().zip(&assigned) {
                let mode = modes.get(assigned.of_peak[k]);
                mode.into_iter()
                    .for_each(|mode| *of_lines.entry(mode.nodal_lines).or_default() += 1);
            }
        }
        let most = of_lines.iter().max_by_key(|(_, count)| **count);
        let mut conflicts = posterior.conflicts.iter();
        let found = conflicts.find(|own| own.datum == k || own.partner == Some(k));
        let other = found.and_then(|own| if own.datum == k { own.partner } else { Some(own.datum) });
        let probability = match found {
            Some(own) => own.probability,
            None => left_out_probability(&posterior.likelihood, particles, k, &[]),
        };
        let is_check = test.is_check.get(k).copied().unwrap_or(false);
        let is_conflict = found.is_some() || probability < CONFLICT;
        PeakRow {
            name: posterior.likelihood.data()[k].name.clone(),
            reading: test.peaks.get(k).copied().unwrap_or(0.0),
            nodal_lines: most.map(|(lines, _)| *lines),
            share: most.map_or(1.0, |(_, count)| *count as f64 / modes.len().max(1) as f64),
            now: percentiles(particles.iter().map(|own| own.predictions[k].value())),
            left_over: left_over(&posterior.likelihood, k, particles),
            probability,
            partner: other.map(|other| posterior.likelihood.data()[other].name.clone()),
            counts: posterior.counts[k],
            verdict: match (is_conflict, is_check) {
                (true, _) => Verdict::Conflict,
                (false, true) => Verdict::Predicted,
                (false, false) => Verdict::Met,
            },
        }
    };
    (0..=test.peaks.len()).map(row).collect()
}

/// Modes that most draws have below the highest frequency, with the error of the model.
fn predicted(
    test: &TapTest,
    modes: &[Vec<PlateMode>],
    peaks: &[PeakRow],
    max_frequency: f64,
    seed: u64,
) -> Vec<ModeRow> {
    let mut of_lines: BTreeMap<[usize; 2], Vec<f64>> = BTreeMap::new();
    for (draw, modes) in modes.iter().enumerate() {
        for mode in modes {
            let [m, n] = mode.nodal_lines;
            let error = ErrorLaw::Student.quantile(uniform(seed ^ ERRORS, draw as u64, (m * 1000 + n) as u64));
            let hz = mode.hz * (1.0 + test.discrepancy * error);
            of_lines.entry(mode.nodal_lines).or_default().push(hz);
        }
    }
    let is_listed =
        |hz: &[f64]| hz.iter().filter(|own| **own <= max_frequency).count() as f64 >= PRESENT * modes.len() as f64;
    let listed = of_lines.into_iter().filter(|(_, hz)| is_listed(hz));
    let with_peak = |lines: [usize; 2]| {
        peaks
            .iter()
            .any(|own| own.nodal_lines == Some(lines) && own.name != UNSEEN)
    };
    let mut rows: Vec<ModeRow> = listed
        .map(|(nodal_lines, hz)| ModeRow {
            nodal_lines,
            hz: percentiles(hz.into_iter()),
            has_peak: with_peak(nodal_lines),
        })
        .collect();
    rows.sort_by(|a, b| a.hz[1].total_cmp(&b.hz[1]));
    rows
}

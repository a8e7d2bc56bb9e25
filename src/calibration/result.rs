//! The result of a calibration: readings, inputs and figures of the shot, before and after.

use nailnoise_calibration::conflict::{CONFLICT, left_out_probability, left_over};
use nailnoise_calibration::likelihood::Reading;
use nailnoise_calibration::sampler::Step;
use nailnoise_calibration::statistics::{quantile_of, rank_correlation};
use serde::Serialize;

use super::levels::{LevelRow, LevelWork};
use super::measurements::Measurements;
use super::next::NextRow;
use super::posterior::{Found, Posterior, Work};
use super::request::Request;
use super::tool::Tool;
use crate::design::{Design, Value};
use crate::result::DesignId;
use crate::study::VariableKind;
use crate::wording::in_one_unit;

/// Name and version of the layout.
const SCHEMA: &str = "nailnoise-calibrated/1";

/// Largest ratio of the widths after and before at which an input counts as moved.
pub(super) const MOVED: f64 = 0.9;

/// Remedy for draws that have not converged.
pub const NOT_CONVERGED: &str = "do not rely on these intervals; double --draws, then --moves 48";

/// Smallest rank correlation of a pair of inputs that is reported.
const CORRELATED: f64 = 0.3;

/// Relative standard error of the width between P5 and P95 of n normal draws, and standard error of a rank correlation;
/// both multiplied by the square root of n.
const ERROR_OF_WIDTH: f64 = 0.9;
const ERROR_OF_CORRELATION: f64 = 1.0;

/// Number of standard errors by which a change must exceed the random variation of unchanged inputs.
const BEYOND_CHANCE: f64 = 2.0;

/// The same for a pair, as a multiple: of 4000 pairs, ten exceed three standard errors by chance.
const OF_A_PAIR: f64 = 2.0;

/// Largest number of pairs listed.
const MOST_PAIRS: usize = 12;

/// Results of a calibration.
#[derive(Debug, Clone, Serialize)]
pub struct CalibrationResult {
    /// Name and version of the layout.
    pub schema: &'static str,
    /// The design.
    pub design: DesignId,
    /// The file of measurements.
    pub measured: String,
    /// Draws from the posterior.
    pub draws: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Whether every diagnostic is within its limit.
    pub converged: bool,
    /// Diagnostics that exceed their limits.
    pub faults: Vec<String>,
    /// Number of candidates drawn from the ranges to obtain those with the observed outcomes.
    pub candidates: u64,
    /// Log evidence of the readings, over all candidates and excluding normalisation constants.
    pub log_evidence: f64,
    /// Difference in log evidence between the two halves of the draws.
    pub halves_apart: f64,
    /// Number of candidates from which the draws descend.
    pub ancestors: usize,
    /// Work counters of the sampler.
    pub work: Work,
    /// Steps of the last run.
    pub steps: Vec<Step>,
    /// The measurements, in the order of the file.
    pub measurements: Vec<MeasurementRow>,
    /// Measurements that contradict each other or the ranges.
    pub conflicts: Vec<ConflictRow>,
    /// Ratio of widths below which an input counts as moved. The number of ancestors counts as the number of draws, so
    /// with few ancestors a larger change is required.
    pub moved_below: f64,
    /// Inputs, in descending order of change.
    pub inputs: Vec<InputRow>,
    /// Pairs of inputs that are constrained more jointly than individually.
    pub pairs: Vec<PairRow>,
    /// Number of inputs that are neither narrower nor in a pair.
    pub unidentified: usize,
    /// Figures of the design's own shot.
    pub figures: Vec<FigureRow>,
    /// Levels of the design's own shot; empty without measured levels.
    pub levels: Vec<LevelRow>,
    /// Work on the levels; null without measured levels.
    pub level_work: Option<LevelWork>,
    /// What to measure next, in the order of the gain per hour of work; empty if not requested.
    pub next: Vec<NextRow>,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

impl CalibrationResult {
    /// Whether any measurement, including held-out ones, contradicts others or is out of reach.
    pub fn has_conflict(&self) -> bool {
        self.measurements.iter().any(|own| own.verdict.is_conflict())
    }
}

/// Status of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It conditions the inputs and is consistent with the other measurements.
    Met,
    /// It was held out, and the posterior predicts it.
    Predicted,
    /// Others contradict it.
    Conflict,
    /// No candidate comes near it.
    NotReached,
}

impl Verdict {
    /// Describes it in words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Predicted => "predicted",
            Self::Conflict => "conflict",
            Self::NotReached => "not reached",
        }
    }

    /// Whether others contradict it, or no candidate comes near it.
    pub(super) fn is_conflict(self) -> bool {
        matches!(self, Self::Conflict | Self::NotReached)
    }
}

/// A measurement and its predictions.
#[derive(Debug, Clone, Serialize)]
pub struct MeasurementRow {
    /// Its name.
    pub name: String,
    /// Name of the condition.
    pub condition: String,
    /// SI unit.
    pub unit: String,
    /// The reading: its bounds, equal for a single value; null for an open end.
    pub reading: [Option<f64>; 2],
    /// P5 and P95 of the candidates' predictions.
    pub before: [f64; 2],
    /// P5 and P95 of the draws' predictions.
    pub now: [f64; 2],
    /// Reading minus mean prediction, in combined standard deviations.
    pub left_over: f64,
    /// Predictive probability given the other measurements.
    pub probability: f64,
    /// Whether it conditions the inputs.
    pub counts: bool,
    /// Its status.
    pub verdict: Verdict,
}

/// A conflict, and possible resolutions.
#[derive(Debug, Clone, Serialize)]
pub struct ConflictRow {
    /// The measurement.
    pub measurement: String,
    /// The measurement that it contradicts; null if it contradicts the others together, or the ranges.
    pub partner: Option<String>,
    /// Predictive probability given the others; 0 if out of reach.
    pub probability: f64,
    /// The nearest value of any candidate, if out of reach.
    pub nearest: Option<f64>,
    /// SI unit of the nearest value.
    pub unit: String,
    /// Distance of that value in standard deviations.
    pub distance: Option<f64>,
    /// Increase in log evidence without the measurements.
    pub gain: Option<f64>,
    /// Factor by which their errors were widened; null if they are excluded.
    pub widened: Option<f64>,
    /// Assumptions that would have to change, in words.
    pub remedies: Vec<String>,
}

/// An input, before and after.
#[derive(Debug, Clone, Serialize)]
pub struct InputRow {
    /// Its key, or the name of a shared error.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// P5 and P95 of candidates: of its distribution in the design, given the rules between values and the observed
    /// outcomes.
    pub before: [f64; 2],
    /// P5 and P95 of the draws.
    pub now: [f64; 2],
    /// Ratio of the widths.
    pub ratio: f64,
    /// Value of the medoid, the most central draw.
    pub medoid: f64,
}

/// Correlated inputs.
#[derive(Debug, Clone, Serialize)]
pub struct PairRow {
    /// Names.
    pub inputs: [String; 2],
    /// Rank correlation of the draws.
    pub rank_correlation: f64,
}

/// A figure of the shot, before and after.
#[derive(Debug, Clone, Serialize)]
pub struct FigureRow {
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// P5, P50 and P95 of candidates.
    pub before: [f64; 3],
    /// P5, P50 and P95 of the draws.
    pub now: [f64; 3],
}

/// A quantile of the finite values.
fn quantile(values: impl Iterator<Item = f64>, p: f64) -> f64 {
    quantile_of(&mut values.filter(|own| own.is_finite()).collect::<Vec<_>>(), p)
}

/// P5, P50 and P95 of the finite values.
pub(super) fn percentiles(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.filter(|own| own.is_finite()).collect();
    [0.05, 0.5, 0.95].map(|p| quantile_of(&mut values, p))
}

fn interval(values: &[f64]) -> [f64; 2] {
    [0.05, 0.95].map(|p| quantile(values.iter().copied(), p))
}

/// The index of the most central draw: the one closest to the mean in the inputs that moved, each scaled by its
/// standard deviation.
pub(super) fn medoid(posterior: &Posterior, moved: &[usize]) -> usize {
    let particles = &posterior.state.particles;
    let moments: Vec<[f64; 2]> = moved
        .iter()
        .map(|&k| nailnoise_calibration::statistics::moments(&particles.iter().map(|own| own.z[k]).collect::<Vec<_>>()))
        .collect();
    let distance = |z: &[f64]| -> f64 {
        let terms = moved.iter().zip(&moments);
        terms
            .map(|(&k, [mean, deviation])| ((z[k] - mean) / deviation.max(1e-9)).powi(2))
            .sum()
    };
    let order = (0..particles.len()).min_by(|&a, &b| distance(&particles[a].z).total_cmp(&distance(&particles[b].z)));
    order.unwrap_or(0)
}

/// Draws of a posterior with their values, for files.
pub(super) struct Table {
    /// Names of the columns.
    pub(super) names: Vec<String>,
    /// One row per draw.
    pub(super) rows: Vec<Vec<f64>>,
}

/// The result of a posterior, and the table of its draws.
pub(super) fn result(
    posterior: &Posterior,
    design: &Design,
    measured: &Measurements,
    request: &Request,
    file: &str,
) -> (CalibrationResult, Table) {
    let particles = &posterior.state.particles;
    let variables = particles.first().map_or(0, |own| own.z.len());
    let values: Vec<Vec<f64>> = (0..variables)
        .map(|k| particles.iter().map(|own| posterior.tool.value(k, &own.z)).collect())
        .collect();
    let rows: Vec<InputRow> = (0..variables).map(|k| input(posterior, k, &values[k])).collect();
    let parts = [posterior.diagnostics.ancestors, posterior.start.accepted.len()];
    let by_chance = BEYOND_CHANCE * parts.map(|n| 1.0 / n.max(1) as f64).iter().sum::<f64>().sqrt();
    let moved_below = MOVED.min(1.0 - ERROR_OF_WIDTH * by_chance);
    let mut moved: Vec<usize> = (0..variables).filter(|&k| rows[k].ratio < moved_below).collect();
    moved.sort_by(|&a, &b| rows[a].ratio.total_cmp(&rows[b].ratio));
    let middle = medoid(posterior, &moved);
    let pairs = pairs(
        posterior,
        &values,
        CORRELATED.max(OF_A_PAIR * ERROR_OF_CORRELATION * by_chance),
    );
    let in_pair = |name: &String| pairs.iter().any(|own| own.inputs.contains(name));
    let unidentified = rows[..posterior.tool.keys().min(rows.len())]
        .iter()
        .filter(|own| own.ratio >= moved_below && !in_pair(&own.name))
        .count();
    let mut inputs: Vec<InputRow> = rows
        .into_iter()
        .zip(&values)
        .map(|(own, values)| InputRow {
            medoid: values[middle],
            ..own
        })
        .collect();
    inputs.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let before = posterior
        .tool
        .figures_at(design, posterior.start.accepted.iter().map(|own| own.z.as_slice()));
    let now = posterior
        .tool
        .figures_at(design, particles.iter().map(|own| own.z.as_slice()));
    let figures = posterior.tool.figures.iter().enumerate().map(|(k, figure)| FigureRow {
        name: figure.name.clone(),
        unit: figure.unit.to_owned(),
        before: percentiles(before.iter().map(|row| row[k])),
        now: percentiles(now.iter().map(|row| row[k])),
    });
    let measurements = (0..measured.data.len()).map(|k| row(posterior, measured, k)).collect();
    let share = posterior.start.accepted.len() as f64 / posterior.start.drawn.max(1) as f64;
    let result = CalibrationResult {
        schema: SCHEMA,
        design: DesignId::from(design),
        measured: file.to_owned(),
        draws: particles.len(),
        seed: request.seed,
        converged: posterior.diagnostics.faults.is_empty(),
        faults: posterior.diagnostics.faults.iter().map(ToString::to_string).collect(),
        candidates: posterior.start.drawn,
        log_evidence: posterior.diagnostics.log_evidence + share.ln(),
        halves_apart: posterior.diagnostics.halves_apart,
        ancestors: posterior.diagnostics.ancestors,
        work: posterior.work,
        steps: posterior.state.steps.clone(),
        measurements,
        conflicts: posterior
            .conflicts
            .iter()
            .map(|own| conflict(posterior, measured, own))
            .collect(),
        moved_below,
        inputs,
        pairs,
        unidentified,
        figures: figures.collect(),
        levels: Vec::new(),
        level_work: None,
        next: Vec::new(),
        notes: notes(posterior, measured),
    };
    let names = (0..variables).map(|k| posterior.tool.name(k).to_owned());
    let names = names.chain(measured.data.iter().map(|own| format!("predicted.{}", own.name)));
    let names = names
        .chain(posterior.tool.figures.iter().map(|own| own.name.replace(' ', "_")))
        .collect();
    let table = (0..particles.len()).map(|draw| {
        let own = values.iter().map(|own| own[draw]);
        let predicted = particles[draw].predictions.iter().map(|own| own.value());
        own.chain(predicted).chain(now[draw].iter().copied()).collect()
    });
    let table = Table {
        names,
        rows: table.collect(),
    };
    (result, table)
}

fn input(posterior: &Posterior, variable: usize, values: &[f64]) -> InputRow {
    let candidates = posterior.start.accepted.iter();
    let before = interval(
        &candidates
            .map(|own| posterior.tool.value(variable, &own.z))
            .collect::<Vec<_>>(),
    );
    let now = interval(values);
    let own = posterior.tool.sampler.variables().get(variable);
    let ratio = (now[1] - now[0]) / (before[1] - before[0]);
    InputRow {
        name: posterior.tool.name(variable).to_owned(),
        unit: own.map_or_else(String::new, |own| own.unit().to_owned()),
        before,
        now,
        // A count that had only one value before has not moved.
        ratio: if ratio.is_finite() { ratio } else { 1.0 },
        medoid: f64::NAN,
    }
}

/// Pairs that the measurements correlate. Rules also correlate inputs of the candidates, as do the points of a
/// low-discrepancy sequence if there are few of them.
fn pairs(posterior: &Posterior, values: &[Vec<f64>], least: f64) -> Vec<PairRow> {
    let column = |k: usize| posterior.start.accepted.iter().map(|own| own.z[k]).collect();
    let before: Vec<Vec<f64>> = (0..values.len()).map(column).collect();
    let mut found = Vec::new();
    for a in 0..values.len() {
        for b in 0..a {
            let [now, then] = [values, before.as_slice()].map(|own| rank_correlation(&own[a], &own[b]));
            if now.abs() > least && (now - then).abs() > least {
                let inputs = [b, a].map(|k| posterior.tool.name(k).to_owned());
                found.push(PairRow {
                    inputs,
                    rank_correlation: now,
                });
            }
        }
    }
    found.sort_by(|a, b| b.rank_correlation.abs().total_cmp(&a.rank_correlation.abs()));
    found.truncate(MOST_PAIRS);
    found
}

fn row(posterior: &Posterior, measured: &Measurements, k: usize) -> MeasurementRow {
    let own = &measured.data[k];
    let particles = &posterior.state.particles;
    let datum = &posterior.likelihood.data()[k];
    let before: Vec<f64> = posterior
        .start
        .accepted
        .iter()
        .map(|own| own.predictions[k].value())
        .collect();
    let now: Vec<f64> = particles.iter().map(|own| own.predictions[k].value()).collect();
    let probability = left_out_probability(&posterior.likelihood, particles, k, &[]);
    let in_conflict = |found: &&Found| found.datum == k || found.partner == Some(k);
    let verdict = match posterior.conflicts.iter().find(in_conflict) {
        Some(found) if found.unreached.is_some() => Verdict::NotReached,
        Some(_) => Verdict::Conflict,
        None if probability < CONFLICT => Verdict::Conflict,
        None if posterior.held_out.contains(&k) => Verdict::Predicted,
        None => Verdict::Met,
    };
    MeasurementRow {
        name: own.name.clone(),
        condition: measured.conditions[own.condition].name.clone(),
        unit: own.quantity.dimension().unit(),
        reading: match own.reading {
            Reading::Value(value) => [Some(value); 2],
            Reading::AtMost(most) => [None, Some(most)],
            Reading::AtLeast(least) => [Some(least), None],
            Reading::Within(ends) => ends.map(Some),
        },
        before: interval(&before),
        now: interval(&now),
        left_over: left_over(&posterior.likelihood, k, particles),
        probability,
        counts: datum.counts,
        verdict,
    }
}

/// States the key of the design that limits an outcome, after a semicolon; empty without one.
fn bound_of(tool: &Tool, outcome: &str) -> String {
    let key = match outcome {
        "dry_fire" | "refused" | "solver_failure" | "no such event" => return String::new(),
        _ if tool.assembly.is_some() => return format!("; `cycle.outcome.{outcome}` defines it"),
        "overdriven" => "nail.overdrive_limit",
        "strikes_bumper" => "piston.stroke",
        "underdriven" => "wood.resistance_scale",
        "does_not_open" | "does_not_exhaust" => "head_valve",
        "does_not_release" => "trigger",
        _ => return String::new(),
    };
    format!("; `{key}` bounds that outcome")
}

fn conflict(posterior: &Posterior, measured: &Measurements, found: &Found) -> ConflictRow {
    let name = |k: usize| measured.data[k].name.clone();
    let mut remedies = Vec::new();
    for own in &found.pressed {
        let end = if own.is_upper { "upper" } else { "lower" };
        let variable = posterior.tool.name(own.variable);
        remedies.push(match own.variable < posterior.tool.keys() {
            true => format!(
                "widen the range of `{variable}`: {:.0} % of the draws are at its {end} end",
                100.0 * own.share
            ),
            false => format!("the error `{variable}` would have to exceed two standard deviations"),
        });
    }
    let reading = posterior.likelihood.data()[found.datum].reading;
    let unit = measured.data[found.datum].quantity.dimension().unit();
    let allowed = &posterior.tool.conditions[measured.data[found.datum].condition].outcomes;
    for (outcome, &[low, high]) in &posterior.start.reached[found.datum] {
        let Some(unreached) = found.unreached.filter(|_| !allowed.contains(outcome)) else {
            continue;
        };
        // The value of these shots that is nearest to the reading.
        let wanted = reading.nearest(unreached.nearest);
        let nearest = wanted.clamp(low, high);
        if (wanted - nearest).abs() < (wanted - unreached.nearest).abs() {
            let how = match nearest == wanted {
                true => "reach it".to_owned(),
                false => {
                    let ([nearest], unit) = in_one_unit(&unit, [nearest]);
                    format!("come nearer, to {nearest} {unit}")
                }
            };
            let bound = bound_of(&posterior.tool, outcome);
            remedies.push(format!(
                "shots with the outcome \"{}\" {how}{bound}",
                outcome.replace('_', " ")
            ));
        }
    }
    if let Some((outcome, count)) = found.refusals.iter().max_by_key(|(_, count)| **count) {
        let bound = bound_of(&posterior.tool, outcome);
        remedies.push(format!(
            "{count} proposals were refused for the outcome \"{}\"{bound}",
            outcome.replace('_', " ")
        ));
    }
    ConflictRow {
        measurement: name(found.datum),
        partner: found.partner.map(name),
        probability: found.probability,
        nearest: found.unreached.map(|own| own.nearest),
        unit,
        distance: found.unreached.map(|own| own.distance),
        gain: found.gain,
        widened: found.factor,
        remedies,
    }
}

fn notes(posterior: &Posterior, measured: &Measurements) -> Vec<String> {
    let mut notes = measured.notes.clone();
    if measured.data.is_empty() {
        return notes;
    }
    notes.push(
        "the draws are of this tool with the wood, nails and support as measured; keys of bodies (bore, valve \
         diameters, masses) are drawn for the cycle"
            .to_owned(),
    );
    if posterior.tool.assembly.is_some() {
        notes.push(
            "the errors of the model are assumed as large as those of the built-in tool, which was compared with \
             measurements; state `discrepancy` where you know better"
                .to_owned(),
        );
    }
    let left_out: Vec<&str> = posterior
        .conflicts
        .iter()
        .filter(|own| own.factor.is_none())
        .flat_map(|own| [Some(own.datum), own.partner])
        .flatten()
        .map(|k| measured.data[k].name.as_str())
        .collect();
    if !left_out.is_empty() {
        notes.push(format!(
            "all intervals leave out {} because of the conflict",
            left_out.join(", ")
        ));
    }
    for own in posterior.conflicts.iter().filter_map(|own| Some((own, own.factor?))) {
        let names = [Some(own.0.datum), own.0.partner].into_iter().flatten();
        let names: Vec<&str> = names.map(|k| measured.data[k].name.as_str()).collect();
        notes.push(format!(
            "the independent errors of {} were widened by a factor {:.1}",
            names.join(" and "),
            own.1
        ));
    }
    notes
}

/// The keys of the design that moved. The normal distribution over a range is cut at 3/4 of its width from its middle;
/// the ends are P2.5 and P97.5, further apart where the cut would exclude a draw.
pub(super) struct MovedKey<'a> {
    pub(super) key: &'a str,
    pub(super) value: Value,
    pub(super) ends: [f64; 2],
}

/// Keys that moved, for a design file.
pub(super) fn moved_keys<'a>(posterior: &'a Posterior, result: &CalibrationResult, table: &Table) -> Vec<MovedKey<'a>> {
    let variables = posterior.tool.sampler.variables().iter().enumerate();
    let moved = variables.filter_map(|(k, variable)| {
        let VariableKind::Quantity(parameter) = &variable.kind else {
            return None;
        };
        let row = result.inputs.iter().find(|own| own.name == variable.name)?;
        let values = table.rows.iter().map(|row| row[k]);
        let [low, high] = [0.025, 0.975].map(|p| quantile(values.clone(), p));
        let middle = 0.5 * (low + high);
        let furthest = values.map(|value| (value - middle).abs()).fold(0.0, f64::max);
        let half = (0.5 * (high - low)).max(furthest / 1.499);
        let ends = [middle - half, middle + half];
        (row.ratio < result.moved_below).then(|| MovedKey {
            key: &variable.name,
            value: parameter.hold(row.medoid),
            ends,
        })
    });
    moved.collect()
}

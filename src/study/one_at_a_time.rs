//! Effect of each input on the levels of the design itself: levels at the 5th and the 95th percentile of its
//! distribution, with all other inputs as in the design.
//!
//! Such changes are valid only at the design. If inputs interact, or a shot no longer drives the nail, they do not
//! apply to other designs; contributions to the variance do.

use std::sync::atomic::{AtomicUsize, Ordering};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::draws::{Draws, method_errors};
use super::jobs::{levels_of_shot, on_threads, reason};
use super::level_table::number;
use super::request::Request;
use super::sampling::{Point, Sampler};
use super::screening::drawn;
use super::variables::{Scope, Variable, without_sensors};
use crate::chain::{Chain, Options};
use crate::decibels::energy_sum;
use crate::design::{Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::output;
use crate::result::TOTAL;
use crate::stages::Progress;
use crate::stages::levels::Levels;
use crate::study::StudyError;

/// Quantiles of its distribution at which an input is set.
const SHARES: [f64; 2] = [0.05, 0.95];

/// Effect of each drawn input on the levels of the design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OneAtATime {
    /// Names of the levels: `total`, then the sources.
    pub outputs: Vec<String>,
    /// The inputs of shots and the errors of methods, largest change of the total first.
    pub inputs: Vec<InputChanges>,
    /// Number of inputs of structures, which are omitted.
    pub left_out: usize,
}

/// Effect of an input on the levels of the design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InputChanges {
    /// The variable.
    pub variable: String,
    /// Its SI unit; empty if it has none.
    pub unit: String,
    /// With the input at the 5th and at the 95th percentile of its distribution.
    pub ends: [InputEnd; 2],
}

/// The shot with an input at one end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InputEnd {
    /// Value of the input; for a choice, the number of the alternative; for the error of a method, its position in its
    /// range.
    pub value: Option<f64>,
    /// Outcome of the shot; empty if there are no levels.
    pub outcome: String,
    /// Reason why there are no levels; empty if there are.
    pub refused: String,
    /// Change of each level from that of the design \[dB\], in the order of `outputs`; null if either is silent.
    pub change_db: Vec<Option<f64>>,
}

impl InputChanges {
    /// The largest change of the level at an index of the outputs \[dB\].
    pub fn largest(&self, output: usize) -> f64 {
        let changes = self.ends.iter().filter_map(|end| *end.change_db.get(output)?);
        changes.fold(0.0, |largest, change| change.abs().max(largest))
    }
}

/// Levels of the total and each source, including errors of methods; `None` for silence.
fn outputs(levels: &Levels, errors: &[f64]) -> Vec<Option<f64>> {
    let sources = levels.sources.iter().zip(errors);
    let sources: Vec<Option<f64>> = sources
        .map(|(source, error)| source.lwa_db.map(|level| level + error))
        .collect();
    let total = energy_sum(sources.iter().flatten().copied());
    std::iter::once(Some(total).filter(|total| total.is_finite()))
        .chain(sources)
        .collect()
}

/// Changes of the levels of the design, which are `nominal`, when each drawn input is at the ends of its distribution.
///
/// # Errors
/// The errors of the chain of the design itself.
pub fn one_at_a_time(
    graph: &Graph,
    design: &Design,
    request: &Request,
    (made, nominal): (&Draws, &Levels),
    progress: &Progress,
) -> Result<OneAtATime, Error> {
    progress.stage("one input at a time");
    let design = without_sensors(design);
    let sampler = Sampler::new(&design, made.variables.clone(), request.seed);
    let base = Values::clone(&design);
    let inputs: Vec<usize> = (0..made.variables.len())
        .filter(|&place| made.variables[place].scope != Scope::Structure)
        .collect();
    let point = |job: usize| {
        let mut shares = vec![f64::NAN; made.variables.len()];
        shares[inputs[job / 2]] = SHARES[job % 2];
        Point { shares }
    };
    // Structures are kept while shots come and go.
    let anchor = Chain::new(graph, &design, Options::default())?;
    let (total, done) = (2 * inputs.len(), AtomicUsize::new(0));
    let results = on_threads(total, |job| {
        let own = drawn(&design, &sampler, &base, &point(job)).map_err(|reason| StudyError::NoDesign { reason }.into());
        let levels = own.and_then(|own| levels_of_shot(Chain::new(graph, &own, Options::default())));
        progress.done(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total as u64);
        levels
    });
    drop(anchor);
    let at_design = outputs(nominal, &vec![0.0; nominal.sources.len()]);
    let failures = || results.iter().filter_map(|result| result.as_ref().err());
    let end = |job: usize| {
        let variable = &made.variables[inputs[job / 2]];
        let value = number(variable.drawn(SHARES[job % 2]));
        match &results[job] {
            Ok(levels) => {
                let own = outputs(levels, &method_errors(&made.variables, &point(job).shares, levels));
                let change = |(own, base): (Option<f64>, &Option<f64>)| Some(own? - (*base)?);
                InputEnd {
                    value,
                    outcome: levels.outcome.clone(),
                    refused: String::new(),
                    change_db: own.into_iter().zip(&at_design).map(change).collect(),
                }
            }
            Err(error) => InputEnd {
                value,
                outcome: String::new(),
                refused: reason(error, failures()),
                change_db: vec![None; at_design.len()],
            },
        }
    };
    let changes = |(place, &input): (usize, &usize)| {
        let variable: &Variable = &made.variables[input];
        InputChanges {
            variable: variable.name.clone(),
            unit: variable.unit().to_owned(),
            ends: [2 * place, 2 * place + 1].map(end),
        }
    };
    let mut stated: Vec<InputChanges> = inputs.iter().enumerate().map(changes).collect();
    stated.sort_by(|a, b| b.largest(0).total_cmp(&a.largest(0)));
    let sources = nominal.sources.iter().map(|source| source.source.clone());
    Ok(OneAtATime {
        outputs: std::iter::once(TOTAL.to_owned()).chain(sources).collect(),
        left_out: made.variables.len() - inputs.len(),
        inputs: stated,
    })
}

/// A table with one row per input.
///
/// # Errors
/// If the format cannot represent the values.
pub fn one_at_a_time_csv(own: &OneAtATime) -> Result<Vec<u8>, Error> {
    let ends = ["at P5", "at P95"];
    let of_end = |end: &str| -> Vec<String> {
        let changes = own
            .outputs
            .iter()
            .map(|output| format!("change of {output} {end} [dB]"));
        let about = ["value", "outcome", "refused"].map(|what| format!("{what} {end}"));
        about.into_iter().chain(changes).collect()
    };
    let header = ["input", "unit"].map(str::to_owned);
    let header = header.into_iter().chain(ends.iter().flat_map(|end| of_end(end)));
    let decibels = |change: &Option<f64>| change.map_or_else(String::new, |change| format!("{change:.4}"));
    let row = |input: &InputChanges| -> Vec<String> {
        let of_end = |end: &InputEnd| -> Vec<String> {
            let value = end.value.map_or_else(String::new, |value| format!("{value:.6e}"));
            let about = [value, end.outcome.clone(), end.refused.clone()];
            about.into_iter().chain(end.change_db.iter().map(decibels)).collect()
        };
        let name = [input.variable.clone(), input.unit.clone()];
        name.into_iter().chain(input.ends.iter().flat_map(of_end)).collect()
    };
    output::table(header, own.inputs.iter().map(row))
}

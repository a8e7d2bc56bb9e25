//! A polynomial surrogate of each level: the fraction of the variance that all inputs together explain and, if this is
//! large enough, the indices of the inputs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::contributions::FEWEST;
use super::draws::Draws;
use super::level_table::{LevelTable, outputs};
use super::polynomial::{Candidates, Polynomial, fold_of};
use super::statistics::{Bootstrap, Estimate};
use crate::design::Design;

/// Minimum Q2 for indices to be stated.
const ENOUGH: f64 = 0.8;

/// Maximum number of draws used, starting with the first; more would need much memory for little benefit.
const MOST_DRAWS: usize = 1000;

/// A polynomial surrogate of a level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Surrogate {
    /// Source, `total`, or the difference of two sources.
    pub output: String,
    /// Number of draws used.
    pub draws: usize,
    /// Maximum total degree of the products from which its terms are chosen.
    pub degree: usize,
    /// Number of its terms in addition to the constant.
    pub terms: usize,
    /// Fraction of the variance of omitted draws that it predicts \[-\]; its error is 1 minus this.
    pub q2: f64,
    /// Reason why no indices are stated; null if they are.
    pub not_resolved: Option<String>,
    /// Indices of the inputs in its terms, largest total first; empty if the surrogate does not predict enough.
    pub inputs: Vec<SurrogateIndex>,
}

/// Sobol' indices of an input from a surrogate. The intervals are those of the coefficients over resampled draws; the
/// choice of terms is not repeated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SurrogateIndex {
    /// The variable.
    pub variable: String,
    /// Fraction of the surrogate's variance that the input explains alone \[-\].
    pub first_order: Estimate,
    /// Fraction that it explains alone and together with others \[-\].
    pub total: Estimate,
}

/// Surrogates of the total, each source, and the difference of the two loudest; `names` are the sources in their order.
/// Empty if there are too few draws.
pub(super) fn surrogates(design: &Design, made: &Draws, names: &[String]) -> Vec<Surrogate> {
    let draws = &made.draws[..made.draws.len().min(MOST_DRAWS)];
    if draws.len() < FEWEST {
        return Vec::new();
    }
    let varies = |place: &usize| {
        let first = draws[0].shares[*place];
        !first.is_nan() && draws.iter().any(|draw| draw.shares[*place] != first)
    };
    let inputs: Vec<usize> = (0..made.variables.len()).filter(varies).collect();
    let points: Vec<Vec<f64>> = draws
        .iter()
        .map(|draw| inputs.iter().map(|&place| draw.shares[place]).collect())
        .collect();
    let candidates = Candidates::new(&points, inputs.len());
    // Draws of one structure are predicted together.
    let unit = |(number, structure): (usize, usize)| if made.structures > 0 { structure } else { number };
    let folds: Vec<u64> = draws
        .iter()
        .enumerate()
        .map(|(number, draw)| fold_of(unit((number, draw.structure))))
        .collect();
    let dependent = dependence(design, made);
    let of_output = |(output, levels): (String, Vec<f64>)| {
        let polynomial = candidates.fitted(&levels[..draws.len()], &folds);
        let not_resolved = match dependent {
            Some(reason) => Some(reason.to_owned()),
            None if polynomial.q2 < ENOUGH => Some(format!("Q2 is below {ENOUGH}")),
            None => None,
        };
        let mut indices = match not_resolved {
            None => indices(&candidates, &polynomial, &levels[..draws.len()], |place| {
                made.variables[inputs[place]].name.clone()
            }),
            Some(_) => Vec::new(),
        };
        let total = |index: &SurrogateIndex| index.total.value.unwrap_or_default();
        indices.sort_by(|a, b| total(b).total_cmp(&total(a)));
        Surrogate {
            output,
            draws: draws.len(),
            degree: candidates.degree,
            terms: polynomial.terms.len(),
            q2: polynomial.q2,
            not_resolved,
            inputs: indices,
        }
    };
    outputs(&LevelTable::new(&made.draws), names)
        .into_iter()
        .map(of_output)
        .collect()
}

/// The reason why none of them states indices, if it is the same for all.
pub fn common_reason(surrogates: &[Surrogate]) -> Option<&str> {
    let reason = surrogates.first()?.not_resolved.as_deref()?;
    let same = |own: &Surrogate| own.not_resolved.as_deref() == Some(reason);
    surrogates.iter().all(same).then_some(reason)
}

/// Indices of the inputs in a polynomial's terms.
fn indices(
    candidates: &Candidates,
    polynomial: &Polynomial,
    levels: &[f64],
    name: impl Fn(usize) -> String,
) -> Vec<SurrogateIndex> {
    let own = candidates.indices(polynomial);
    let bootstrap = Bootstrap::new(&vec![0; levels.len()]);
    let intervals = bootstrap.intervals(|counts| match candidates.refitted(polynomial, levels, counts) {
        Some(again) => candidates
            .indices(&again)
            .into_iter()
            .flat_map(|(_, own)| own)
            .collect(),
        None => vec![f64::NAN; 2 * own.len()],
    });
    let index = |((place, values), intervals): (&(usize, [f64; 2]), &[[Option<f64>; 2]])| {
        let estimate = |kind: usize| Estimate {
            value: Some(values[kind]),
            interval: intervals[kind],
        };
        SurrogateIndex {
            variable: name(*place),
            first_order: estimate(0),
            total: estimate(1),
        }
    };
    own.iter().zip(intervals.chunks(2)).map(index).collect()
}

/// The reason why the inputs of the draws depend on each other; `None` if they do not.
fn dependence(design: &Design, made: &Draws) -> Option<&'static str> {
    if !design.study().correlations.is_empty() {
        return Some("inputs are correlated");
    }
    if !made.tally.rejections.is_empty() {
        return Some("values that do not go together are left out, so that inputs depend on each other");
    }
    if made.structures > 0 {
        return Some("shots on one structure share its values");
    }
    (made.tally.candidates > (made.draws.len() + made.failures.len()) as u64)
        .then_some("shots that do not count are left out, so that inputs depend on each other")
}

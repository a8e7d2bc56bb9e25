//! Facts that a reader of a study needs in addition to its numbers.

use std::collections::BTreeSet;

use super::draws::{Draw, Draws};
use super::request::Request;
use super::tolerance::{STATED_FROM, content, draws_for, next_within};
use super::variable_report::VariableReport;
use super::variables::VariableKind;
use crate::design::Design;

/// Fraction of a distribution at its ends within which a value is reported to be at an end.
const AT_THE_END: f64 = 0.02;

/// Shift of a variable's mean due to the condition, in standard errors, above which it is reported.
const SHIFTED: f64 = 4.0;

/// The notes on draws of a design.
pub(super) fn notes(design: &Design, request: &Request, made: &Draws, variables: &[VariableReport]) -> Vec<String> {
    let mut notes = Vec::new();
    let draws = made.draws.len();
    if (2..STATED_FROM).contains(&draws) && made.structures == 0 {
        notes.push(format!(
            "{draws} draws state no percentiles: a further draw lies between the lowest and the highest with a \
             probability of {:.0} %, \
             and with 90 % confidence these contain {:.0} % of all draws (Wilks 1941); {STATED_FROM} draws state P5 \
             and P95, and the \
             range of {} contains 90 % of all with 90 % confidence",
            100.0 * next_within(draws),
            (100.0 * content(draws).unwrap_or(0.0)).floor(),
            draws_for(0.9)
        ));
    }
    let held: Vec<&str> = variables
        .iter()
        .filter(|own| !own.drawn)
        .map(|own| own.name.as_str())
        .collect();
    if request.shots_a_structure.is_none() && !held.is_empty() {
        notes.push(format!(
            "the structures are held as in the design: {} quantities of bodies are not drawn ({}, ...), so that the \
             intervals are \
             too narrow; `--structures` draws them",
            held.len(),
            held.iter().take(3).copied().collect::<Vec<_>>().join(", ")
        ));
    }
    if let Some(joint) = &design.study().draws {
        let keys = made.variables.iter().filter(|own| joint.names.contains(&own.name));
        notes.push(format!(
            "{} quantities have the joint draws of a calibration with {} ({} draws), the others their ranges; \
             dimensions of bodies are drawn for the cycle, and held for modes and radiation",
            keys.count(),
            joint.measured,
            joint.rows.len()
        ));
    }
    if made
        .variables
        .iter()
        .any(|variable| matches!(variable.kind, VariableKind::LawScore))
    {
        notes.push(
            "the fitted penetration law is drawn by its covariance and the scatter of its specimens; \
             wood.hardness_modulus is \
             held, because that scatter includes it; wood.resistance_scale is drawn if it has a range"
                .to_owned(),
        );
    }
    if !made.open_ends.is_empty() {
        notes.push(format!(
            "the error of these methods has no bound and counts as 0 dB there: {}; give it in [study.model]",
            made.open_ends.join(", ")
        ));
    }
    let shots = made.tally.shots();
    if !design.study().require.is_empty() && shots > 0 {
        let count = |word: &String| made.tally.outcomes.get(word).copied().unwrap_or(0);
        let counted: u64 = design.study().require.iter().map(count).sum();
        notes.push(format!(
            "only these outcomes count: {}, {:.1} % of {shots} shots; all results hold on that condition",
            design.study().require.join(", ").replace('_', " "),
            100.0 * counted as f64 / shots as f64
        ));
    }
    let limit = SHIFTED / (12.0 * made.draws.len().max(1) as f64).sqrt();
    let mut shifted: Vec<(&str, f64)> = variables
        .iter()
        .filter_map(|own| Some((own.name.as_str(), own.mean_place?)))
        .filter(|(_, place)| (place - 0.5).abs() > limit)
        .collect();
    shifted.sort_by(|a, b| (b.1 - 0.5).abs().total_cmp(&(a.1 - 0.5).abs()));
    if !shifted.is_empty() {
        let list = shifted
            .iter()
            .take(6)
            .map(|(name, place)| format!("{name} to {place:.2}"));
        notes.push(format!(
            "rejection of values and shots shifts the mean quantile of {} quantities from 0.50: {}{}",
            shifted.len(),
            list.collect::<Vec<_>>().join(", "),
            if shifted.len() > 6 { ", ..." } else { "" }
        ));
    }
    let ends: Vec<&str> = variables
        .iter()
        .filter(|own| {
            own.nominal_place
                .is_some_and(|place| !(AT_THE_END..=1.0 - AT_THE_END).contains(&place))
        })
        .map(|own| own.name.as_str())
        .collect();
    if !ends.is_empty() {
        notes.push(format!(
            "{} values of the design lie at an end of the range that is drawn: {}",
            ends.len(),
            ends.join(", ")
        ));
    }
    let failed = |draw: &&Draw| !draw.levels.failed_checks.is_empty();
    let failed = made.draws.iter().filter(failed).count();
    if failed > 0 {
        let names = made.draws.iter().flat_map(|draw| &draw.levels.failed_checks);
        let names: BTreeSet<&str> = names.map(String::as_str).collect();
        notes.push(format!(
            "a check fails in {failed} of the draws ({}): do not rely on them",
            names.into_iter().collect::<Vec<_>>().join(", ")
        ));
    }
    let other = made
        .draws
        .iter()
        .filter(|draw| draw.levels.outcome != draw.shot.outcome)
        .count();
    if other > 0 {
        notes.push(format!(
            "{other} draws have another outcome with two-way coupling than with the lumped workpiece"
        ));
    }
    notes
}

//! Formats the result of `nailnoise study` as text.

use std::fmt::Write as _;

use super::progress::noted;
use super::table;
use crate::study::{Condition, Contributions, GroupStudy, OneAtATime, StudyResult, Surrogate};
use crate::tables::study as tables;
use crate::wording::drawn_structures;

/// Number of inputs printed for each level.
const PRINTED: usize = 6;

/// Surrogates: how well they predict, and the total indices of the inputs if that is good enough.
fn of_surrogates(surrogates: &[Surrogate]) -> String {
    let Some(degree) = surrogates.iter().map(|own| own.degree).max() else {
        return String::new();
    };
    format!(
        "\n  polynomial in all inputs, degree {degree}; Q2: part of the variance of draws left out that it \
         predicts\n{}",
        table::text(&tables::surrogates(surrogates, PRINTED))
    )
}

/// The threshold that the largest contribution exceeds by chance.
fn by_chance(own: &Contributions) -> String {
    match own.by_chance_of_structures {
        None => format!("{:.2}", own.by_chance),
        Some(limit) => format!("{:.2} of shots, {limit:.2} of structures", own.by_chance),
    }
}

/// Effects of single inputs on the levels of the design.
fn of_single_inputs(own: &OneAtATime) -> String {
    format!(
        "\n  one input at a time, at the 5th and the 95th percentile of its distribution, all others as in the design; \
         changes in dB\n{}",
        table::text(&tables::one_at_a_time(own, PRINTED))
    )
}

/// The inputs that determine whether a shot counts.
fn of_condition(own: &Condition) -> String {
    let text = format!(
        "\n  {:.1} % of {} shots count; inputs that decide it by more than chance ({:.3}):\n",
        100.0 * own.share,
        own.shots,
        own.by_chance
    );
    if own.inputs.is_empty() {
        return text + "  not resolved with so many shots\n";
    }
    text + &table::text(&tables::condition(own, PRINTED)) + "\n"
}

/// The groups of inputs that determine each level.
fn of_groups(study: &GroupStudy) -> String {
    let mut text = format!(
        "\n  groups of inputs, by {} draws with two partners for each group; first-order index: part of the variance \
         that\n  knowing the group takes off; total index: part that remains where all else is known\n",
        study.rows
    );
    if study.incomplete > 0 {
        let _ = writeln!(text, "  {} draws have no partner and are left out", study.incomplete);
    }
    for own in &study.outputs {
        let _ = writeln!(text, "\n  {}: variance {:.1} dB2", own.output, own.variance_db2);
        text.push_str(&table::text(&tables::groups(study, own)));
    }
    text
}

/// Levels, rankings, and the inputs that determine them.
pub(super) fn text(result: &StudyResult) -> String {
    let structures = drawn_structures(result.structures);
    let drawn = result.variables.iter().filter(|variable| variable.drawn).count();
    let mut text = format!(
        "{}: {} draws of {drawn} quantities, {structures} (seed {})\n\
         A-weighted single-event sound power levels, dB re 1 pW s; +-: half of the 90 % interval of the estimate\n\n",
        result.design.name, result.draws, result.seed
    );
    let parts = [tables::levels(result), tables::orders(result), tables::pairs(result)];
    text.push_str(&parts.map(|part| table::text(&part)).join("\n"));
    for own in &result.contributions {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "\n  {}: variance {:.1} dB2; inputs that explain more of it than chance ({}):",
            own.output,
            own.variance_db2,
            by_chance(own)
        );
        if own.inputs.is_empty() {
            text.push_str("  not resolved with so many draws\n");
        } else {
            text.push_str(&table::text(&tables::contributions(own, PRINTED)));
        }
    }
    text.push_str(&of_surrogates(&result.surrogates));
    if let Some(groups) = &result.groups {
        text.push_str(&of_groups(groups));
    }
    if let Some(own) = &result.one_at_a_time {
        text.push_str(&of_single_inputs(own));
    }
    let shots: u64 = result.candidates.outcomes.values().sum();
    let _ = writeln!(text, "\n  {} candidates, {shots} shots", result.candidates.drawn);
    text.push_str(&table::text(&tables::outcomes(result)));
    if let Some(condition) = &result.condition {
        text.push_str(&of_condition(condition));
    }
    let incompatible = tables::incompatible(&result.candidates);
    if !incompatible.rows.is_empty() {
        text.push_str(&table::text(&incompatible));
    }
    text.push('\n');
    text + &noted(&result.notes)
}

//! The result of `nailnoise study` as a person reads it.

use std::fmt::Write as _;

use super::progress::noted;
use super::table::{dash, decibels, fixed, table};
use crate::study::{
    Condition, Contributions, Estimate, GroupStudy, InputChanges, InputEnd, LevelStudy, OneAtATime, StudyResult,
    Surrogate, SurrogateIndex, common_reason, names_of_ends,
};
use crate::wording::drawn_structures;

/// Inputs printed for each level.
const PRINTED: usize = 6;

/// A probability with the half width of its interval, `0.83 +-0.04`, or its bound, `1.00, > 0.69`.
pub(super) fn probability(estimate: &Estimate) -> String {
    let value = fixed(estimate.value, 2);
    match (estimate.value, estimate.interval, estimate.half_width()) {
        // All draws or none: the interval lies on one side.
        (Some(1.0), [Some(low), _], _) => format!("{value}, > {low:.2}"),
        (Some(0.0), [_, Some(high)], _) => format!("{value}, < {high:.2}"),
        (_, _, Some(half)) => format!("{value} +-{half:.2}"),
        _ => value,
    }
}

/// A level with the half width of its interval.
fn level(estimate: &Estimate) -> String {
    match (estimate.value, estimate.half_width()) {
        (Some(value), Some(half)) => format!("{value:.1} +-{half:.1}"),
        (value, _) => decibels(value),
    }
}

/// A difference of levels with its sign.
fn signed(difference: &Estimate) -> String {
    match difference.value {
        Some(value) if value > 0.0 => format!("+{}", level(difference)),
        _ => level(difference),
    }
}

fn percent(part: u64, whole: u64) -> String {
    format!("{:.1}", 100.0 * part as f64 / whole.max(1) as f64)
}

/// Surrogates: how much they predict, and the total indices of the inputs where that is enough.
fn of_surrogates(surrogates: &[Surrogate]) -> String {
    if surrogates.is_empty() {
        return String::new();
    }
    let degree = surrogates.iter().map(|own| own.degree).max().unwrap_or(0);
    let mut text = format!(
        "\n  polynomial in all inputs, degree {degree}; Q2: part of the variance of draws left out that it predicts\n"
    );
    let common = common_reason(surrogates);
    let row = |own: &Surrogate| {
        let total = |input: &SurrogateIndex| format!("{} {}", input.variable, probability(&input.total));
        let indices = match &own.not_resolved {
            Some(reason) => format!("not stated: {reason}"),
            None => own
                .inputs
                .iter()
                .take(PRINTED)
                .map(total)
                .collect::<Vec<_>>()
                .join(", "),
        };
        let mut row = vec![own.output.clone(), format!("{:.2}", own.q2), own.terms.to_string()];
        row.extend(common.is_none().then_some(indices));
        row
    };
    let rows: Vec<Vec<String>> = surrogates.iter().map(row).collect();
    let headings = ["output", "Q2", "terms", "total indices"];
    text.push_str(&table(&headings[..rows[0].len()], &rows));
    if let Some(reason) = common {
        let _ = writeln!(text, "  indices of single inputs are not stated: {reason}");
    }
    text
}

/// The value that the largest contribution exceeds by chance.
fn by_chance(own: &Contributions) -> String {
    match own.by_chance_of_structures {
        None => format!("{:.2}", own.by_chance),
        Some(limit) => format!("{:.2} of shots, {limit:.2} of structures", own.by_chance),
    }
}

/// Effects of single inputs on the levels of the design.
fn of_single_inputs(own: &OneAtATime) -> String {
    let mut text = String::from(
        "\n  one input at a time, at the 5th and the 95th percentile of its distribution, all others as in the \
         design; changes in dB\n",
    );
    let change = |change: &Option<f64>| dash(*change, |change| format!("{change:+.1}"));
    let row = |input: &InputChanges| {
        let [low, high] = &input.ends;
        let changes = low.change_db.iter().zip(&high.change_db);
        let mut row = vec![input.variable.clone()];
        row.extend(changes.map(|(low, high)| format!("{} / {}", change(low), change(high))));
        let shot = |end: &InputEnd| match &end.refused {
            reason if reason.is_empty() => end.outcome.replace('_', " "),
            reason => reason.clone(),
        };
        let shots = [low, high].map(shot);
        row.push(if shots[0] == shots[1] {
            shots[0].clone()
        } else {
            shots.join(" / ")
        });
        row
    };
    let rows: Vec<Vec<String>> = own.inputs.iter().take(PRINTED).map(row).collect();
    let outputs = own.outputs.iter().map(String::as_str);
    let headings: Vec<&str> = std::iter::once("input").chain(outputs).chain(["shot"]).collect();
    text.push_str(&table(&headings, &rows));
    if own.left_out > 0 {
        let _ = writeln!(text, "  {} quantities of bodies are left out", own.left_out);
    }
    text
}

/// The inputs that decide whether a shot counts.
fn of_condition(own: &Condition) -> String {
    let mut text = format!(
        "\n  {:.1} % of {} shots count; inputs that decide it by more than chance ({:.3}):\n",
        100.0 * own.share,
        own.shots,
        own.by_chance
    );
    if own.inputs.is_empty() {
        return text + "  not resolved with so many shots\n";
    }
    let rows = own.inputs.iter().take(PRINTED).map(|input| {
        let [lower, upper] = input.halves.map(|share| format!("{:.1} %", 100.0 * share));
        vec![input.variable.clone(), probability(&input.first_order), lower, upper]
    });
    let headings = [
        "input",
        "part of variance",
        "count in its lower half",
        "in its upper half",
    ];
    text.push_str(&table(&headings, &rows.collect::<Vec<_>>()));
    text.push('\n');
    text
}

/// The groups of inputs that decide each level.
fn of_groups(study: &GroupStudy) -> String {
    let mut text = format!(
        "\n  groups of inputs, by {} draws with two partners for each group; first-order index: part of the variance \
         that\n  \
         knowing the group takes off; total index: part that remains where all else is known\n",
        study.rows
    );
    if study.incomplete > 0 {
        let _ = writeln!(text, "  {} draws lack a partner and are left out", study.incomplete);
    }
    for own in &study.outputs {
        let _ = writeln!(text, "\n  {}: variance {:.1} dB2", own.output, own.variance_db2);
        let rows = own.groups.iter().map(|group| {
            let quantities = study.groups.iter().find(|known| known.name == group.group);
            vec![
                group.group.clone(),
                quantities.map_or(0, |known| known.variables.len()).to_string(),
                probability(&group.first_order),
                probability(&group.total),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        text.push_str(&table(
            &["group", "quantities", "first-order index", "total index"],
            &rows,
        ));
    }
    text
}

/// Levels, orders, and the inputs that decide them.
pub(super) fn text(result: &StudyResult) -> String {
    let structures = drawn_structures(result.structures);
    let drawn = result.variables.iter().filter(|variable| variable.drawn).count();
    let mut text = format!(
        "{}: {} draws of {drawn} quantities, {structures} (seed {})\n\
         A-weighted single-event sound power levels, dB re 1 pW s; +-: half of the 90 % interval of the estimate\n\n",
        result.design.name, result.draws, result.seed
    );
    let place = |share: Option<f64>| dash(share, |share| format!("{:.0} %", 100.0 * share));
    let row = |name: &str, own: &LevelStudy| {
        let [low, high] = own.ends(result.draws);
        vec![
            name.to_owned(),
            decibels(own.nominal_db),
            place(own.below_nominal),
            level(&low),
            level(&own.level_db.p50),
            level(&high),
        ]
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    for source in &result.sources {
        let mut cells = row(&source.source, &source.level);
        cells.push(probability(&source.first));
        cells.push(level(&source.loss_db));
        cells.push(level(&source.silencing_db));
        rows.push(cells);
    }
    rows.push(row("total", &result.total));
    let [low, high] = names_of_ends(result.draws);
    let headings = [
        "source",
        "design",
        "draws below",
        low,
        "P50",
        high,
        "P(first)",
        "loss dB",
        "silenced dB",
    ];
    text.push_str(&table(&headings, &rows));
    text.push_str(
        "\n  loss: expected distance to the loudest source; silenced: expected fall of the total without \
        the source\n\n",
    );
    let orders = result
        .orders
        .iter()
        .map(|own| vec![own.order.join(" > "), probability(&own.probability)]);
    text.push_str(&table(&["order", "probability"], &orders.collect::<Vec<_>>()));
    text.push('\n');
    let louder = result.louder.iter().map(|own| {
        vec![
            format!("{} louder than {}", own.source, own.than),
            probability(&own.probability),
        ]
    });
    text.push_str(&table(&["pair", "probability"], &louder.collect::<Vec<_>>()));
    for own in &result.contributions {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "\n  {}: variance {:.1} dB2; inputs that explain more of it than chance ({}):",
            own.output,
            own.variance_db2,
            by_chance(own)
        );
        let rows = own.inputs.iter().take(PRINTED).map(|input| {
            vec![
                input.variable.clone(),
                probability(&input.part()),
                signed(&input.effect()),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.is_empty() {
            text.push_str("  not resolved with so many draws\n");
        } else {
            text.push_str(&table(
                &["input", "part of variance", "upper less lower third dB"],
                &rows,
            ));
        }
    }
    text.push_str(&of_surrogates(&result.surrogates));
    if let Some(groups) = &result.groups {
        text.push_str(&of_groups(groups));
    }
    if let Some(own) = &result.one_at_a_time {
        text.push_str(&of_single_inputs(own));
    }
    let candidates = &result.candidates;
    let shots: u64 = candidates.outcomes.values().sum();
    let _ = writeln!(text, "\n  {} candidates, {shots} shots", candidates.drawn);
    let mut counts: Vec<(&String, &u64)> = candidates.outcomes.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1));
    let rows = counts.into_iter().map(|(name, count)| {
        let counts = result.require.is_empty() || result.require.contains(name);
        let mark = if counts { "counts" } else { "" };
        vec![
            name.replace('_', " "),
            count.to_string(),
            percent(*count, shots),
            mark.to_owned(),
        ]
    });
    text.push_str(&table(&["the shot", "candidates", "%", ""], &rows.collect::<Vec<_>>()));
    if let Some(condition) = &result.condition {
        text.push_str(&of_condition(condition));
    }
    let reasons = candidates.refused.iter().chain(&candidates.rejections);
    let rows: Vec<Vec<String>> = reasons
        .map(|(keys, count)| vec![keys.clone(), count.to_string()])
        .collect();
    if !rows.is_empty() {
        text.push_str(&table(&["incompatible values", "drawn anew"], &rows));
    }
    text.push('\n');
    text + &noted(&result.notes)
}

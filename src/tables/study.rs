//! Tables of a study, the same for the terminal and the page.

use super::{Cell, Column, Table, dash, decibels, fixed};
use crate::study::{
    Candidates, Change, Condition, Contributions, Estimate, Group, GroupContributions, GroupStudy, InputChanges,
    InputEnd, LevelStudy, Louder, OneAtATime, PairedStudy, StudyResult, Surrogate, SurrogateIndex, common_reason,
    names_of_ends,
};
use crate::wording::{change, in_one_unit};

/// A probability, or a fraction of a variance, with the half-width of its interval or with its bound.
pub(crate) fn probability(estimate: &Estimate) -> Cell {
    let spread = match (estimate.value, estimate.interval, estimate.half_width()) {
        // All draws or none: the interval is on one side.
        (Some(1.0), [Some(low), _], _) => format!("> {low:.2}"),
        (Some(0.0), [_, Some(high)], _) => format!("< {high:.2}"),
        (_, _, Some(half)) => format!("+-{half:.2}"),
        _ => String::new(),
    };
    Cell::estimate(fixed(estimate.value, 2), spread)
}

/// A level \[dB\] with the half-width of its interval.
pub(crate) fn level(estimate: &Estimate) -> Cell {
    let half = estimate.value.and(estimate.half_width());
    let spread = half.map_or_else(String::new, |half| format!("+-{half:.1}"));
    Cell::estimate(decibels(estimate.value), spread)
}

/// A difference of levels \[dB\], with its sign.
fn signed(difference: &Estimate) -> Cell {
    let mut cell = level(difference);
    if difference.value.is_some_and(|value| value > 0.0) {
        cell.text.insert(0, '+');
    }
    cell
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Levels of the sources and of the total over the draws.
pub(crate) fn levels(result: &StudyResult) -> Table {
    let row = |name: &str, own: &LevelStudy| {
        let [low, high] = own.ends(result.draws);
        vec![
            name.into(),
            decibels(own.nominal_db).into(),
            dash(own.below_nominal, |share| format!("{:.0} %", 100.0 * share)).into(),
            level(&low),
            level(&own.level_db.p50),
            level(&high),
        ]
    };
    let sources = result.sources.iter().map(|own| {
        let mut row = row(&own.source, &own.level);
        row.extend([probability(&own.first), level(&own.loss_db), level(&own.silencing_db)]);
        row
    });
    let [low, high] = names_of_ends(result.draws);
    let numbers = [
        "design",
        "draws below",
        low,
        "P50",
        high,
        "P(first)",
        "loss dB",
        "silenced dB",
    ];
    let columns = std::iter::once(Column::words("source")).chain(numbers.map(Column::number));
    Table::new(columns, sources.chain([row("total", &result.total)]))
        .with_sum()
        .with_legend([
            "loss: expected distance to the loudest source; silenced: expected fall of the total without the \
                       source"
                .to_owned(),
        ])
}

/// Probability of each order of the sources.
pub(crate) fn orders(result: &StudyResult) -> Table {
    let row = |(name, value): (String, &Estimate)| vec![name.into(), probability(value)];
    let orders = result
        .orders
        .iter()
        .map(|own| (own.order.join(" > "), &own.probability));
    Table::new([Column::words("order"), Column::number("probability")], orders.map(row))
}

/// Probability that one source is louder than another.
pub(crate) fn pairs(result: &StudyResult) -> Table {
    let row = |own: &Louder| {
        vec![
            format!("{} louder than {}", own.source, own.than).into(),
            probability(&own.probability),
        ]
    };
    Table::new(
        [Column::words("pair"), Column::number("probability")],
        result.louder.iter().map(row),
    )
}

/// The first `most` inputs that affect a level.
pub(crate) fn contributions(own: &Contributions, most: usize) -> Table {
    let rows = own.inputs.iter().take(most).map(|input| {
        let bar = Cell::bar(input.first_order);
        vec![
            input.variable.as_str().into(),
            probability(&input.part()),
            bar,
            signed(&input.effect()),
        ]
    });
    let columns = [
        Column::keys("input"),
        Column::number("part of variance"),
        Column::bars(),
        Column::number("upper less lower third dB"),
    ];
    Table::new(columns, rows)
}

/// Surrogates in all inputs, one row per output, with the total indices of the first `most` inputs if they are
/// resolved.
pub(crate) fn surrogates(surrogates: &[Surrogate], most: usize) -> Table {
    let common = common_reason(surrogates);
    let indices = |own: &Surrogate| {
        let index = |input: &SurrogateIndex| {
            let total = probability(&input.total);
            format!("{} {} {}", input.variable, total.text, total.spread)
        };
        match &own.not_resolved {
            Some(reason) => format!("not stated: {reason}"),
            None => own.inputs.iter().take(most).map(index).collect::<Vec<_>>().join(", "),
        }
    };
    let row = |own: &Surrogate| {
        let mut row: Vec<Cell> = vec![
            own.output.as_str().into(),
            format!("{:.2}", own.q2).into(),
            own.terms.to_string().into(),
        ];
        row.extend(common.is_none().then(|| indices(own).into()));
        row
    };
    let columns = [Column::words("output"), Column::number("Q2"), Column::number("terms")];
    let columns = columns
        .into_iter()
        .chain(common.is_none().then(|| Column::words("total indices")));
    let reason = common.map(|reason| format!("indices of single inputs are not stated: {reason}"));
    Table::new(columns, surrogates.iter().map(row)).with_legend(reason)
}

/// Indices of the groups of inputs for one output.
pub(crate) fn groups(study: &GroupStudy, own: &GroupContributions) -> Table {
    let rows = own.groups.iter().map(|group| {
        let known = study.groups.iter().find(|known| known.name == group.group);
        let quantities = known.map_or(0, |known| known.variables.len()).to_string();
        vec![
            group.group.as_str().into(),
            quantities.into(),
            probability(&group.first_order),
            probability(&group.total),
            Cell::bar(group.total.value.unwrap_or(0.0)),
        ]
    });
    let columns = [
        Column::keys("group"),
        Column::number("quantities"),
        Column::number("first-order index"),
        Column::number("total index"),
        Column::bars(),
    ];
    Table::new(columns, rows)
}

/// The quantities in each group of inputs.
pub(crate) fn members(study: &GroupStudy) -> Table {
    let row = |own: &Group| vec![own.name.as_str().into(), own.variables.join(", ").into()];
    Table::new(
        [Column::keys("group"), Column::words("quantities")],
        study.groups.iter().map(row),
    )
}

/// Effects of the first `most` single inputs on the levels of the design.
pub(crate) fn one_at_a_time(own: &OneAtATime, most: usize) -> Table {
    let changed = |db: &Option<f64>| dash(*db, |db| format!("{db:+.1}"));
    let shot = |end: &InputEnd| match end.refused.as_str() {
        "" => end.outcome.replace('_', " "),
        reason => reason.to_owned(),
    };
    let row = |input: &InputChanges| {
        let [low, high] = &input.ends;
        let changes = low.change_db.iter().zip(&high.change_db);
        let changes = changes.map(|(low, high)| Cell::from(format!("{} / {}", changed(low), changed(high))));
        let shots = match [low, high].map(shot) {
            [low, high] if low == high => low,
            shots => shots.join(" / "),
        };
        let name = std::iter::once(Cell::from(input.variable.as_str()));
        name.chain(changes).chain([shots.into()]).collect()
    };
    let outputs = own.outputs.iter().map(Column::number);
    let columns = std::iter::once(Column::keys("input"))
        .chain(outputs)
        .chain([Column::short("shot")]);
    let left_out = (own.left_out > 0).then(|| format!("{} quantities of bodies are left out", own.left_out));
    Table::new(columns, own.inputs.iter().take(most).map(row)).with_legend(left_out)
}

/// Outcomes of the shots of all candidates.
pub(crate) fn outcomes(result: &StudyResult) -> Table {
    let outcomes = &result.candidates.outcomes;
    let shots: u64 = outcomes.values().sum();
    let mut counts: Vec<(&String, &u64)> = outcomes.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1));
    let rows = counts.into_iter().map(|(name, count)| {
        let counts = result.require.is_empty() || result.require.contains(name);
        vec![
            name.replace('_', " ").into(),
            count.to_string().into(),
            format!("{:.1}", 100.0 * *count as f64 / shots.max(1) as f64).into(),
            if counts { "counts" } else { "" }.into(),
        ]
    });
    let numbers = ["candidates", "%"].map(Column::number);
    let columns = std::iter::once(Column::words("the shot"))
        .chain(numbers)
        .chain([Column::short("")]);
    Table::new(columns, rows)
}

/// The first `most` inputs that determine whether a shot counts.
pub(crate) fn condition(own: &Condition, most: usize) -> Table {
    let rows = own.inputs.iter().take(most).map(|input| {
        let [lower, upper] = input.halves.map(|share| percent(share).into());
        vec![
            input.variable.as_str().into(),
            probability(&input.first_order),
            lower,
            upper,
        ]
    });
    let numbers = ["part of variance", "count in its lower half", "in its upper half"];
    Table::new(
        std::iter::once(Column::keys("input")).chain(numbers.map(Column::number)),
        rows,
    )
}

/// Candidates that are not valid designs, by reason, and values that are drawn again.
pub(crate) fn incompatible(candidates: &Candidates) -> Table {
    let reasons = candidates.refused.iter().chain(&candidates.rejections);
    let rows = reasons.map(|(keys, count)| vec![keys.as_str().into(), count.to_string().into()]);
    Table::new(
        [Column::keys("incompatible values"), Column::number("drawn anew")],
        rows,
    )
}

/// The quantities of the study with their distributions.
pub(crate) fn variables(result: &StudyResult) -> Table {
    let rows = result.variables.iter().map(|own| {
        let held = if own.drawn { "" } else { ", held" };
        let range = own.range.map_or_else(
            || "own".to_owned(),
            |ends| {
                let ([low, high], unit) = in_one_unit(&own.unit, ends);
                format!("{low} .. {high} {unit}").trim_end().to_owned()
            },
        );
        vec![
            own.name.as_str().into(),
            format!("{}{held}", own.scope).into(),
            range.into(),
            own.distribution.to_string().into(),
            fixed(own.nominal_place, 2).into(),
            fixed(own.mean_place, 2).into(),
        ]
    });
    let words = ["changes", "range", "distribution"].map(Column::words);
    let numbers = ["quantile of the design", "mean quantile of draws"].map(Column::number);
    Table::new(
        std::iter::once(Column::keys("quantity")).chain(words).chain(numbers),
        rows,
    )
}

/// Changes from the reference to a design over common draws.
pub(crate) fn changes(paired: &PairedStudy) -> Table {
    let row = |own: &Change| {
        let quantiles = &own.change_db;
        let quantiles = [quantiles.p05, quantiles.p50, quantiles.p95];
        let quantiles = quantiles.map(|own| Cell::from(dash(own.value, change)));
        let widths = [own.width_db, own.level_width_db].map(|width| decibels(width).into());
        let name = std::iter::once(Cell::from(own.source.as_str()));
        name.chain(quantiles)
            .chain([probability(&own.quieter)])
            .chain(widths)
            .collect()
    };
    let numbers = [
        "P5 dB",
        "P50 dB",
        "P95 dB",
        "P(quieter)",
        "width dB",
        "width of the level dB",
    ];
    let columns = std::iter::once(Column::words("change")).chain(numbers.map(Column::number));
    Table::new(columns, paired.changes.iter().map(row)).with_sum()
}

//! Tables of an optimisation.

use super::{Cell, Column, Table, dash, decibels, performance};
use crate::optimisation::{Objective, Optimisation, Trial};
use crate::result::TOTAL;
use crate::wording;

/// Names of the sources, in the order of the levels.
fn sources(found: &Optimisation) -> Vec<String> {
    let all = std::iter::once(&found.start).chain(&found.trials);
    let levels = all.filter_map(|own| own.shot.as_ref()?.levels.as_ref()).next();
    levels.map_or_else(Vec::new, |levels| {
        levels.sources.iter().map(|own| own.source.clone()).collect()
    })
}

/// A figure of a trial in the customary unit, or a level in dB.
fn figure(trial: &Trial, name: &str) -> String {
    let value = trial.shot.as_ref().and_then(|shot| shot.figure(name));
    match crate::optimisation::is_level(name) {
        true => decibels(value),
        false => dash(value, |value| wording::figure(name, value)),
    }
}

/// Objectives that are not levels. Levels have separate columns.
fn figures(found: &Optimisation) -> Vec<&str> {
    let own = found.objectives.iter().map(|own: &Objective| own.figure.as_str());
    own.filter(|name| !crate::optimisation::is_level(name)).collect()
}

/// The name, values, levels, other objectives and the costs of noise reduction.
fn columns(found: &Optimisation, first: &str) -> Vec<Column> {
    let keys = found.variables.iter().map(|own| Column::number(&own.key));
    let levels = sources(found)
        .into_iter()
        .map(|name| Column::number(format!("{name} dB")).page_only());
    let figures = figures(found)
        .into_iter()
        .map(|name| Column::number(name.replace('_', " ")));
    std::iter::once(Column::words(first))
        .chain(keys)
        .chain([Column::number("total dB"), Column::number("change dB")])
        .chain(levels)
        .chain(figures)
        .chain(performance::HEADINGS.map(Column::number))
        .collect()
}

fn row(found: &Optimisation, name: Cell, trial: &Trial) -> Vec<Cell> {
    let total = |own: &Trial| own.shot.as_ref().and_then(|shot| shot.total_db);
    let change = total(trial).zip(total(&found.start)).map(|(own, start)| own - start);
    let is_start = std::ptr::eq(trial, &found.start);
    let values = trial.values.iter().map(|value| Cell::from(value.as_str()));
    let levels = sources(found)
        .into_iter()
        .map(|source| Cell::from(figure(trial, &source)));
    std::iter::once(name)
        .chain(values)
        .chain([
            Cell::from(figure(trial, TOTAL)).strong(),
            dash(change.filter(|_| !is_start), wording::change).into(),
        ])
        .chain(levels)
        .chain(figures(found).into_iter().map(|name| Cell::from(figure(trial, name))))
        .chain(performance::cells(trial.shot.as_ref().map(|shot| &shot.performance)))
        .collect()
}

/// The design itself and the designs of the front. `reports` are the files that open for them.
pub(crate) fn best(found: &Optimisation, reports: &[Option<String>]) -> Table {
    let own = row(found, Cell::from("the design itself"), &found.start);
    let others = found.best().enumerate().map(|(place, trial)| {
        let name = Cell {
            opens: reports.get(place).cloned().flatten(),
            ..Cell::from(format!("{}-{}", found.design.name, place + 1))
        };
        row(found, name, trial)
    });
    Table::new(columns(found, "design"), std::iter::once(own).chain(others))
}

/// All candidates in their order, with the reason for excluding them.
pub(crate) fn candidates(found: &Optimisation) -> Table {
    let rows = found.trials.iter().enumerate().map(|(place, trial)| {
        let mut cells = row(found, Cell::from((place + 1).to_string()), trial);
        cells.push(excluded(found, trial).into());
        cells
    });
    let last = Column::short("not feasible because");
    Table::new(columns(found, "candidate").into_iter().chain([last]), rows)
}

/// Reason why a candidate is not feasible; empty for a feasible one.
pub(crate) fn excluded(found: &Optimisation, trial: &Trial) -> String {
    let broken = found.constraints.iter().zip(&trial.excesses);
    let broken = broken.filter(|(_, excess)| excess.is_some_and(|excess| excess > 0.0));
    let broken: Vec<String> = broken.map(|(own, _)| format!("not {}", own.text)).collect();
    match trial.refused.as_str() {
        "" => broken.join(", "),
        refused => format!("no design: {refused}"),
    }
}

//! Tables of a sweep.

use super::performance::{self, cells};
use super::study::probability;
use super::{Cell, Column, Table, decibels};
use crate::study::{Axis, Quantiles, SweptPoint};

/// Names of the sources, in the order of the levels.
pub(crate) fn sources(points: &[SweptPoint]) -> Vec<String> {
    let levels = points.iter().find_map(|point| point.levels.as_ref());
    levels.map_or_else(Vec::new, |levels| {
        levels.sources.iter().map(|source| source.source.clone()).collect()
    })
}

/// A column of words for the first axis, one of numbers for each of the others.
fn axis_columns(axes: &[Axis]) -> impl Iterator<Item = Column> {
    axes.iter().enumerate().map(|(place, axis)| match place {
        0 => Column::words(&axis.key),
        _ => Column::short(&axis.key),
    })
}

/// Levels of the design at each point, with the remaining energy, the consumption and the outcome of its shot.
pub(crate) fn points(axes: &[Axis], points: &[SweptPoint]) -> Table {
    let sources = sources(points);
    let row = |point: &SweptPoint| {
        let values = point.values.iter().map(|value| Cell::from(value.as_str()));
        let mut row: Vec<Cell> = values.collect();
        if let (Some(first), Some(folder)) = (row.first_mut(), &point.folder) {
            first.opens = Some(format!("{folder}/report.html"));
        }
        match &point.levels {
            Some(levels) => {
                row.extend(levels.sources.iter().map(|source| Cell::from(decibels(source.lwa_db))));
                let shot = match &point.headline {
                    Some(headline) => Cell {
                        alarm: true,
                        ..headline.text.as_str().into()
                    },
                    None => levels.outcome.replace('_', " ").into(),
                };
                row.push(decibels(point.total_db).into());
                row.extend(cells(point.performance.as_ref()));
                row.push(shot);
            }
            None => {
                row.extend(vec![Cell::from("-"); sources.len() + 1 + performance::HEADINGS.len()]);
                row.push(format!("no design: {}", point.refused).into());
            }
        }
        row
    };
    let levels = sources
        .iter()
        .map(String::as_str)
        .chain(["total"])
        .chain(performance::HEADINGS);
    let levels = levels.map(Column::number);
    Table::new(
        axis_columns(axes).chain(levels).chain([Column::short("shot")]),
        points.iter().map(row),
    )
}

/// Levels over the common draws of all points; `None` without draws.
pub(crate) fn over_draws(axes: &[Axis], points: &[SweptPoint]) -> Option<Table> {
    let first = points.iter().find_map(|point| point.drawn.as_ref())?;
    let span = |own: &Quantiles| Cell::from(format!("{} .. {}", decibels(own.p05.value), decibels(own.p95.value)));
    let row = |point: &SweptPoint| {
        let drawn = point.drawn.as_ref()?;
        let total = drawn.last()?;
        let values = point.values.iter().map(|value| Cell::from(value.as_str()));
        let levels = drawn.iter().map(|change| span(&change.level_db));
        Some(
            values
                .chain(levels)
                .chain([span(&total.change_db), probability(&total.quieter)])
                .collect(),
        )
    };
    let levels = first.iter().map(|change| change.source.as_str());
    let levels = levels.chain(["change of the total", "P(quieter)"]).map(Column::number);
    Some(Table::new(
        axis_columns(axes).chain(levels),
        points.iter().filter_map(row),
    ))
}

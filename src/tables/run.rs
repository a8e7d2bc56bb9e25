//! Tables of a run, the same for the terminal and the page.

use super::{Bar, Cell, Column, Table, dash, decibels};
use crate::figures::in_palette;
use crate::result::{BandLevel, Check, Component, RankedSource, RunResult, loudest};
use crate::study::legend;
use crate::wording::{band, change};

/// The sources, loudest first, with the intervals of their levels if a study states them.
pub(crate) fn ranking(result: &RunResult) -> Table {
    let study = result.study.known();
    let of_study = |source: &str| {
        let cells = study.map(|study| legend::cells(study, source).map(Cell::from));
        cells.into_iter().flatten()
    };
    let rows = result.ranking.iter().enumerate().map(|(place, source)| {
        let colour = in_palette(&source.source, place);
        let name = Cell {
            dot: Some(colour),
            ..source.source.as_str().into()
        };
        let share = Cell {
            bar: Some(Bar {
                length: source.share,
                colour,
            }),
            ..format!("{:.1} %", 100.0 * source.share).into()
        };
        let interval = loudest(&source.intervals, |interval| interval.lwa_db);
        let level = Cell::from(decibels(source.lwa_db)).strong();
        let behind = [
            share,
            match result.ranking.len() {
                1 => "-".into(),
                _ => format!("{} dB", change(-without(source.share))).into(),
            },
            loudest_band(&source.bands),
            dash(interval, |interval| result.event_words.in_words(&interval.from)).into(),
        ];
        [name, level]
            .into_iter()
            .chain(of_study(&source.source))
            .chain(behind)
            .collect()
    });
    let total = ["total".into(), Cell::from(decibels(result.total.lwa_db)).strong()];
    let total = total.into_iter().chain(of_study("total")).collect();
    let columns = [Column::words("source"), Column::number("L_{WA,1s} dB")].into_iter();
    let intervals = study.into_iter().flat_map(legend::headings).map(Column::number);
    let columns = columns.chain(intervals).chain([
        Column::short("share"),
        Column::number("total without it").page_only(),
        Column::short("band"),
        Column::short("loudest after"),
    ]);
    Table::new(columns, rows.chain([total]))
        .with_sum()
        .with_legend(legend::legend(result))
}

/// Decrease of the total without a source that has this share \[dB\].
pub(crate) fn without(share: f64) -> f64 {
    -10.0 * (1.0 - share).max(1e-12).log10()
}

/// The parts of sources, loudest first for each source.
pub(crate) fn parts<'a>(sources: impl IntoIterator<Item = &'a RankedSource>) -> Table {
    let row = |source: &RankedSource, part: &Component| {
        vec![
            source.source.as_str().into(),
            named(&part.name).into(),
            decibels(part.lwa_db).into(),
            decibels(part.lw_db).into(),
            loudest_band(&part.bands),
        ]
    };
    let parts = sources
        .into_iter()
        .flat_map(|source| source.parts().into_iter().map(move |part| row(source, part)));
    let columns = [
        Column::words("source"),
        Column::words("part"),
        Column::number("L_{WA,1s} dB"),
        Column::number("L_{W,1s} dB"),
        Column::short("loudest band (A)"),
    ];
    Table::new(columns, parts)
}

/// A part in words: faces without a name in the mesh are the rest of their body.
fn named(part: &str) -> &str {
    match part {
        "unnamed" => "rest of the surface",
        name => name,
    }
}

fn loudest_band(bands: &[BandLevel]) -> Cell {
    dash(loudest(bands, |band| band.lwa_db), |band| format!("{} Hz", band.hz)).into()
}

/// The method for the level of each source.
pub(crate) fn methods(result: &RunResult) -> Table {
    let rows = result.ranking.iter().map(|source| {
        vec![
            source.source.as_str().into(),
            decibels(source.lw_db).into(),
            band(source.uncertainty_db.bounds()).into(),
            format!("{:.0} - {:.0} Hz", source.range_hz[0], source.range_hz[1]).into(),
            source.method.as_str().into(),
        ]
    });
    let numbers = ["L_{W,1s} dB", "error of the method dB", "computed over"].map(Column::number);
    let columns = std::iter::once(Column::words("source"))
        .chain(numbers)
        .chain([Column::words("method")]);
    Table::new(columns, rows)
}

/// Checks with their limits, in this order.
pub(crate) fn checks<'a>(checks: impl IntoIterator<Item = &'a Check>) -> Table {
    let row = |check: &Check| {
        let verdict = if check.ok { "ok" } else { "FAILED" };
        vec![
            check.name.to_string().into(),
            format!("{:.2e}", check.value).into(),
            format!("{:.0e}", check.limit).into(),
            Cell {
                alarm: !check.ok,
                ..verdict.into()
            },
        ]
    };
    let columns = [
        Column::words("check"),
        Column::number("value"),
        Column::number("limit"),
        Column::short(""),
    ];
    Table::new(columns, checks.into_iter().map(row))
}

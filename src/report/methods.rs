//! How each source was computed: parts, method, radiation.

use maud::{Markup, html};

use super::table;
use super::tables::{self, decibels};
use super::typography::{capitalised, typeset, with_code};
use crate::result::{CrossCheck, FluidLoading, Loading, ModeShare, RadiationReport, RankedSource, RunResult};
use crate::tables::{Column, Table, dash, run};
use crate::wording::{band, change};

/// Modes in a table, the largest contributions first.
const MODES: usize = 15;

/// Parts and method of each source, and notes on methods.
pub(super) fn section(result: &RunResult, value: &serde_json::Value) -> Markup {
    html! {
        @for (source, value) in result.ranking.iter().zip(value["ranking"].as_array().into_iter().flatten()) {
            details {
                summary { (source.source) ": parts and method" }
                (of_source(source))
                @if let Some(more) = tables::further(value, &tables::SOURCE) { (more) }
            }
        }
        details {
            summary { "Notes on methods, their ranges and limits" }
            ul.notes { @for note in &result.method_notes { li { (with_code(&capitalised(note))) } } }
        }
    }
}

fn of_source(source: &RankedSource) -> Markup {
    let parts = run::parts([source]);
    html! {
        p.quiet {
            (source.method) ", computed over " (format!("{:.0} to {:.0} Hz", source.range_hz[0], source.range_hz[1]))
            ". Without A-weighting " (decibels(source.lw_db)) " dB. Error of the method alone "
            (typeset(&band(source.uncertainty_db.bounds()))) " dB: " (source.uncertainty_db.basis) "."
        }
        @if !parts.rows.is_empty() { (table::markup(&parts)) }
        @if let Some(own) = &source.cross_check { p { (compared(own)) } }
        @if let Some(own) = &source.radiation { (radiation(own)) }
    }
}

fn compared(own: &CrossCheck) -> String {
    format!(
        "Check of the {}: {} dB by the method of the ranking, {} dB by {} (unweighted).",
        own.quantity,
        decibels(own.lw_db),
        decibels(own.other_lw_db),
        own.other
    )
}

fn radiation(own: &RadiationReport) -> Markup {
    let share = |part: f64| format!("{:.1} %", 100.0 * part);
    let facts = [
        (
            "frequencies solved one by one",
            format!("{} up to {:.0} Hz", own.frequencies, own.solved_hz[0]),
        ),
        ("known in the mean up to", format!("{:.0} Hz", own.solved_hz[1])),
        (
            "change to the limit of high frequencies",
            format!("{:.0} to {:.0} Hz", own.join_hz[0], own.join_hz[1]),
        ),
        ("interpolation error over frequency", share(own.interpolation_error)),
        (
            "power on the surface less power in the far field",
            dash(own.surface_difference_db, |db| format!("{} dB", change(db))),
        ),
        (
            "limit less boundary elements, last three bands",
            format!(
                "{} .. {} dB",
                change(own.limit_error_db[0]),
                change(own.limit_error_db[1])
            ),
        ),
        (
            "the same in the last third of an octave",
            dash(own.blend_error_db, |db| format!("{} dB", change(db))),
        ),
        (
            "level at radiation efficiency 1",
            format!("{} dB(A)", decibels(own.erp_lwa_db)),
        ),
    ];
    let loading = own.fluid_loading.as_ref().map(loading).into_iter().flatten();
    html! {
        h4 { "Radiation" }
        table.facts { @for (name, value) in facts.into_iter().chain(loading) {
            tr { th scope="row" { (name) } td { (typeset(&value)) } }
        } }
        h4 { "Radiation in bands" }
        (table::markup(&band_table(own)))
        @if !own.modes.is_empty() { h4 { "Modes that radiate most" } (table::markup(&modes(&own.modes))) }
    }
}

/// Effect of the reaction of the air on the modes.
fn loading(own: &FluidLoading) -> [(&'static str, String); 4] {
    let acts = match own.acts {
        Loading::None => "none",
        Loading::Damping => "damping",
        Loading::Full => "damping and added mass",
    };
    let relative = |part: Option<f64>| dash(part, |part| format!("{:+.2} %", 100.0 * part));
    [
        ("fluid loading that acts", acts.to_owned()),
        (
            "change of the level by damping",
            format!("{} dB", change(own.damping_db)),
        ),
        (
            "change of the level by added mass",
            dash(own.mass_db, |db| format!("{} dB", change(db))),
        ),
        ("largest shift of a frequency", relative(own.largest_shift)),
    ]
}

fn band_table(own: &RadiationReport) -> Table {
    let row = |band: &crate::result::RadiationBand| {
        let levels = [band.lw_db, band.surface_lw_db, band.limit_lw_db, band.erp_lw_db];
        std::iter::once(band.hz.to_string().into())
            .chain(levels.map(|level| crate::tables::decibels(level).into()))
            .collect()
    };
    let columns = [
        "band Hz",
        "L_{W,1s} far field dB",
        "on the surface dB",
        "limit of high frequencies dB",
        "at radiation efficiency 1 dB",
    ];
    Table::new(columns.map(Column::number), own.bands.iter().map(row))
}

/// The modes with the largest parts of the energy, with their radiation damping and added mass.
fn modes(all: &[ModeShare]) -> Table {
    let mut largest: Vec<&ModeShare> = all.iter().collect();
    largest.sort_by(|a, b| b.share.abs().total_cmp(&a.share.abs()));
    let percent = |part: Option<f64>, decimals: usize| crate::tables::fixed(part.map(|part| 100.0 * part), decimals);
    let row = |own: &&ModeShare| {
        vec![
            own.body.as_ref().into(),
            own.mode
                .map_or_else(|| "static".to_owned(), |mode| mode.to_string())
                .into(),
            crate::tables::fixed(own.hz, 0).into(),
            percent(Some(own.share), 1).into(),
            percent(own.radiation_damping, 3).into(),
            percent(own.added_mass, 2).into(),
            crate::tables::fixed(own.shift_hz, 1).into(),
        ]
    };
    let numbers = [
        "mode",
        "frequency Hz",
        "part of the energy %",
        "radiation damping %",
        "added mass %",
        "shift Hz",
    ];
    let columns = std::iter::once(Column::words("body")).chain(numbers.map(Column::number));
    let more = all.len().checked_sub(MODES).filter(|more| *more > 0);
    Table::new(columns, largest.iter().take(MODES).map(row))
        .with_legend(more.map(|more| format!("and {more} more in `result.json`")))
}

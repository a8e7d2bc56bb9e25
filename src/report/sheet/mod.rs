//! The declaration sheet: one page with the declared noise emission of a design, to be printed.

use maud::{Markup, html};

use super::page::{Page, Section};
use super::table;
use super::typography::{capitalised, typeset, with_subscripts};
use crate::declaration::{Finished, Use};
use crate::tables::{Cell, Column, Table};
use crate::wording::in_one_unit;

pub(super) fn page(of: &Finished, usage: Use) -> Page {
    let sections = vec![
        Section::new("values", "Declared values (ISO 4871, two-number form)", values(of)),
        Section::new("use", "In use", in_use(of, usage)),
        Section::new("conditions", "Operating conditions", conditions(of)),
        Section::new("basis", "Basis", basis(of)),
    ];
    Page {
        title: format!("{}: noise declaration", of.design.name),
        compared: None,
        heading: format!("{}: noise declaration", of.design.name),
        lead: html! {
            p { "Fastener driving tool: noise emission after EN ISO 11148-13 and EN 12549." }
            @if of.outcome != "drives" {
                p.alarm {
                    "The shot of this design " (of.outcome.replace('_', " ")) ": its levels must not be declared."
                }
            }
            p.quiet { "All levels are predictions of the program. A declaration under the Machinery Directive needs \
                measurements of the tool." }
        },
        sections,
    }
}

fn values(of: &Finished) -> Markup {
    let own = &of.declaration;
    let level = |db: Option<i32>| db.map_or_else(|| "silent".to_owned(), |db| format!("{db} dB"));
    let peak = match (&of.ear.not_stated, own.lpc_peak_db) {
        (Some(reason), _) => format!("not stated, because {reason}"),
        (None, db) => level(db),
    };
    let uncertainty = match (own.k_db, &own.k_not_stated) {
        (Some(k), _) => format!("{k} dB"),
        (None, Some(reason)) => format!("not stated: {reason}"),
        (None, None) => "not stated".to_owned(),
    };
    let [along, across, height] = of.ear.position_m;
    let rows = [
        (
            "A-weighted single-event sound power level",
            "L_WA,1s,d",
            level(own.lwa_1s_db),
            "re 1 pW s, one shot".to_owned(),
        ),
        (
            "A-weighted single-event emission sound pressure level at the work station",
            "L_pA,1s,d",
            level(own.lpa_1s_db),
            format!("re 20 \u{b5}Pa over 1 s; ear at x = {along:.2}, y = {across:.2}, z = {height:.2} m"),
        ),
        (
            "C-weighted peak emission sound pressure level at the work station",
            "L_pC,peak",
            peak,
            "re 20 \u{b5}Pa".to_owned(),
        ),
        (
            "Uncertainty of the levels",
            "K",
            uncertainty,
            own.k_basis.clone().unwrap_or_default(),
        ),
    ];
    let rows = rows.map(|(name, symbol, value, remark)| {
        vec![name.into(), symbol.into(), Cell::from(value).strong(), remark.into()]
    });
    let columns = ["quantity", "symbol", "value", "remark"].map(Column::words);
    table::markup(&Table::new(columns, rows))
}

/// Levels at the rate of shots, and the exposure of a working day.
fn in_use(of: &Finished, usage: Use) -> Markup {
    let own = usage.levels(of.total.lwa_db, of.ear.lpa_1s_db);
    let level = |db: Option<f64>| db.map_or_else(|| "silent".to_owned(), |db| format!("{db:.0} dB"));
    let noun = if usage.rate == 1.0 { "shot" } else { "shots" };
    let rate = format!("{} {noun} a second", usage.rate);
    let rows = [
        (format!("Sound power level at {rate}"), "L_WA", level(own.power_db)),
        (
            format!("Sound pressure level at the work station at {rate}"),
            "L_pA",
            level(own.pressure_db),
        ),
        (
            format!(
                "Daily noise exposure of {} shots, other noise left aside",
                usage.shots_a_day
            ),
            "L_EX,8h",
            level(own.exposure_db),
        ),
    ];
    let rows = rows.map(|(name, symbol, value)| vec![name.into(), symbol.into(), Cell::from(value).strong()]);
    let columns = ["quantity", "symbol", "value"].map(Column::words);
    html! {
        (table::markup(&Table::new(columns, rows)))
        p.quiet { "Directive 2003/10/EC: action values of the daily exposure 80 and 85 dB(A), limit value 87 dB(A) at \
            the ear below its protection." }
        @if let Some(rate) = of.performance.and_then(|own| own.shots_per_second).filter(|most| usage.rate > *most) {
            p.alarm { "The cycle of the tool allows " (format!("{rate:.1}")) " shots a second at most." }
        }
    }
}

/// Keys of a design that the test conditions of the standards name, with their names.
const CONDITIONS: [(&str, &str); 10] = [
    ("supply.pressure", "supply pressure, absolute"),
    ("nail.kind", "fastener"),
    ("nail.length", "length of the fastener"),
    ("nail.diameter", "diameter of the fastener"),
    ("wood.species", "workpiece"),
    ("wood.density", "density of the workpiece"),
    ("workpiece.length", "length of the workpiece"),
    ("workpiece.width", "width of the workpiece"),
    ("workpiece.thickness", "thickness of the workpiece"),
    ("support.kind", "support"),
];

fn conditions(of: &Finished) -> Markup {
    let stated = CONDITIONS.iter().filter_map(|(key, name)| {
        let input = of.inputs.iter().find(|input| input.key == *key)?;
        let value = match (&input.value, input.value.as_f64()) {
            (_, Some(number)) => {
                let ([value], unit) = in_one_unit(&input.unit, [number]);
                format!("{value} {unit}")
            }
            (serde_json::Value::String(word), _) => word.clone(),
            (other, _) => other.to_string(),
        };
        Some((*name, value))
    });
    html! {
        table.facts {
            @for (name, value) in stated { tr { th scope="row" { (name) } td { (typeset(&value)) } } }
            @if let Some(own) = &of.performance {
                tr { th scope="row" { "the shot" } td { (capitalised(&own.in_words())) } }
            }
        }
    }
}

fn basis(of: &Finished) -> Markup {
    html! {
        ul.notes {
            li { (with_subscripts("L_WA,1s: sound power of all sources of one shot, normalised to 1 s (EN 12549, ISO \
                3744); \
                L_pA,1s: emission sound pressure at the operator's ear without room and background (ISO 11201).")) }
            li { "K = 1.645 sigma over draws of the inputs and of the errors of the methods; it replaces the scatter \
                of measurements and of machines." }
            li { "Program nailnoise " (env!("CARGO_PKG_VERSION")) "; values of the design (SHA-256): "
                span.digest { (of.design.digest) } }
        }
        table.facts {
            @for field in ["manufacturer", "machine, serial number", "place and date", "name and signature"] {
                tr { th scope="row" { (field) } td { ("\u{2026}".repeat(8)) } }
            }
        }
    }
}

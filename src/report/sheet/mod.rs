//! The declaration sheet: one page with the declared noise emission of a design, to be printed or edited.

mod document;
mod page;

use super::typography::capitalised;
use crate::declaration::{Finished, Use};
use crate::tables::{Cell, Column, Table};
use crate::units::Units;
use crate::wording::in_one_unit;

pub(super) use document::document;
pub(super) use page::page;

/// The texts of the sheet, the same on the page and in the document.
struct Sheet {
    /// Heading, with the name of the design.
    heading: String,
    /// The standards that it follows.
    standards: &'static str,
    /// A shot that must not be declared, if any.
    alarm: Option<String>,
    /// Nature of the figures.
    nature: &'static str,
    /// Declared values.
    values: Table,
    /// Levels at the rate of shots, and the exposure of a working day.
    in_use: Table,
    /// Legal values of the exposure.
    limits: &'static str,
    /// A rate that the tool does not reach, if any.
    too_fast: Option<String>,
    /// Name and value of each operating condition.
    conditions: Vec<(String, String)>,
    /// Origin of the figures.
    basis: [&'static str; 2],
    /// Version of the program.
    program: &'static str,
    /// Digest of the values of the design.
    digest: String,
    /// Fields to be filled in by hand.
    signature: [&'static str; 4],
}

/// Titles of its parts.
const TITLES: [&str; 4] = [
    "Declared values (ISO 4871, two-number form)",
    "In use",
    "Operating conditions",
    "Basis",
];

/// Prefix of the digest of a design.
const DIGEST: &str = "values of the design (SHA-256)";

impl Sheet {
    fn new(of: &Finished, usage: Use) -> Self {
        let own = of.performance.and_then(|own| own.shots_per_second);
        let alarm = (of.outcome != "drives").then(|| {
            let outcome = of.outcome.replace('_', " ");
            format!("The shot of this design {outcome}: its levels must not be declared.")
        });
        Self {
            heading: format!("{}: noise declaration", of.design.name),
            standards: "Fastener driving tool: noise emission after EN ISO 11148-13 and EN 12549.",
            alarm,
            nature: "All levels are predictions of the program. A declaration under the Machinery Directive needs \
                     measurements of the tool.",
            values: values(of),
            in_use: in_use(of, usage),
            limits: "Directive 2003/10/EC: action values of the daily exposure 80 and 85 dB(A), limit value 87 dB(A) \
                     at the ear below its protection.",
            too_fast: own
                .filter(|most| usage.rate > *most)
                .map(|most| format!("The cycle of the tool allows {most:.1} shots a second at most.")),
            conditions: conditions(of),
            basis: [
                "L_WA,1s: sound power of all sources of one shot, normalised to 1 s (EN 12549, ISO 3744); L_pA,1s: \
                 emission sound pressure at the operator's ear without room and background (ISO 11201).",
                "K = 1.645 sigma over draws of the inputs and of the errors of the methods; it replaces the scatter \
                 of measurements and of machines.",
            ],
            program: concat!("Program nailnoise ", env!("CARGO_PKG_VERSION")),
            digest: of.design.digest.clone(),
            signature: [
                "manufacturer",
                "machine, serial number",
                "place and date",
                "name and signature",
            ],
        }
    }

    /// The same sheet with its quantities in these units.
    fn in_units(mut self, units: Units) -> Self {
        let text = |text: &mut String| *text = units.text(text).into_owned();
        self.conditions.iter_mut().for_each(|(_, value)| text(value));
        self.values = self.values.in_units(units);
        self.in_use = self.in_use.in_units(units);
        self
    }
}

/// Declared levels and their uncertainty.
fn values(of: &Finished) -> Table {
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
    Table::new(columns, rows)
}

/// Levels at the rate of shots, and the exposure of a working day.
fn in_use(of: &Finished, usage: Use) -> Table {
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
    Table::new(columns, rows)
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

/// Operating conditions of the standards, and the performance of the shot.
fn conditions(of: &Finished) -> Vec<(String, String)> {
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
        Some(((*name).to_owned(), value))
    });
    let shot = of.performance.as_ref();
    let shot = shot.map(|own| ("the shot".to_owned(), capitalised(&own.in_words())));
    stated.chain(shot).collect()
}

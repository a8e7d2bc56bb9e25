//! The declaration sheet as a page to print.

use maud::{Markup, html};

use super::super::page::{Page, Section};
use super::super::table;
use super::super::typography::{typeset, with_subscripts};
use super::{DIGEST, Sheet, TITLES};
use crate::declaration::{Finished, Use};

/// Names of the parts in links.
const LINKS: [&str; 4] = ["values", "use", "conditions", "basis"];

/// Conditions in one of the tables side by side.
const CONDITIONS: usize = 5;

/// Fields to be filled in by hand, likewise.
const FIELDS: usize = 2;

/// The page, in metric units.
pub(in super::super) fn page(of: &Finished, usage: Use) -> Page {
    let sheet = Sheet::new(of, usage);
    let parts = [
        table::markup(&sheet.values),
        in_use(&sheet),
        conditions(&sheet),
        basis(&sheet),
    ];
    let parts = LINKS.into_iter().zip(TITLES).zip(parts);
    Page {
        title: sheet.heading.clone(),
        compared: None,
        lead: html! {
            p { (sheet.standards) }
            @if let Some(alarm) = &sheet.alarm { p.alarm { (alarm) } }
            p.quiet { (sheet.nature) }
        },
        heading: sheet.heading,
        sections: parts
            .map(|((link, title), part)| Section::new(link, title, part))
            .collect(),
    }
}

fn in_use(sheet: &Sheet) -> Markup {
    html! {
        (table::markup(&sheet.in_use))
        p.quiet { (sheet.limits) }
        @if let Some(rate) = &sheet.too_fast { p.alarm { (rate) } }
    }
}

fn conditions(sheet: &Sheet) -> Markup {
    html! {
        div.columns { @for some in sheet.conditions.chunks(CONDITIONS) {
            table.facts { @for (name, value) in some { tr { th scope="row" { (name) } td { (typeset(value)) } } } }
        } }
    }
}

fn basis(sheet: &Sheet) -> Markup {
    html! {
        ul.notes {
            @for line in sheet.basis { li { (with_subscripts(line)) } }
            li { (sheet.program) "; " (DIGEST) ": " span.digest { (sheet.digest) } }
        }
        div.columns { @for some in sheet.signature.chunks(FIELDS) {
            table.facts.by-hand {
                @for field in some { tr { th scope="row" { (field) } td { ("\u{2026}".repeat(12)) } } }
            }
        } }
    }
}

//! The head of a run's report: the subject of the computation, and the result in one sentence.

use std::time::{SystemTime, UNIX_EPOCH};

use maud::{Markup, html};

use super::{table, tables};
use crate::design::{Design, Value};
use crate::model::supports;
use crate::result::RunResult;
use crate::stages::headline::Headline;
use crate::study::legend;
use crate::tables::run::without;

/// Pressure of 1 psi \[Pa\].
const PSI: f64 = 6894.757;

/// The heading: the title given by the design, or its name.
pub(super) fn heading(design: &Design) -> String {
    match design.report().title.as_str() {
        "" => design.name().to_owned(),
        title => title.to_owned(),
    }
}

/// The most important facts for a reader.
pub(super) fn lead(design: &Design, result: &RunResult) -> Markup {
    let first = result.ranking.first().filter(|source| source.lwa_db.is_some());
    let note = &design.report().note;
    let over_draws = |source: &str| {
        let study = result.study.known()?;
        Some((legend::headings(study), legend::cells(study, source)))
    };
    let numerical_failure = result.numerical_checks().any(|check| !check.ok);
    html! {
        (missed(result.headline.as_ref()))
        (byline(design))
        (given(design))
        @if !note.is_empty() { p { (note) } }
        div.total {
            span.number { (tables::decibels(result.total.lwa_db)) }
            span.unit { "dB" }
            span.what {
                "L" sub { "WA,1s" } " re 1 pW s: A-weighted sound energy of one shot"
                @if let Some(([heading, _], [interval, _])) = over_draws("total") {
                    "; " (heading.trim_end_matches(" dB")) " " (interval) " dB"
                }
            }
        }
        @if let Some(first) = first {
            p.verdict {
                "The " b { (first.source) } " radiates most, " (format!("{:.0} %", 100.0 * first.share))
                " of the A-weighted energy. Without it the total would be "
                (format!("{:.1} dB", without(first.share))) " lower."
                @if let Some(([_, heading], [_, cell])) = over_draws(&first.source).filter(|own| !own.1[1].is_empty()) {
                    " " (heading) " " (cell) "."
                }
            }
        }
        p.quiet {
            "Absolute levels are predictions; the page Validation of the documentation compares those of one tool with \
             published tests. Differences between designs of one tool are more reliable than levels. "
            a href="#assumptions" { "Assumptions" } " lists what is estimated."
        }
        @if numerical_failure {
            p.alarm { "A check of this run failed. Do not rely on the result. " a href="#checks" { "Checks" } }
        }
    }
}

/// The outcome of a shot that does not drive its nail, shown above all levels; empty otherwise.
pub(crate) fn missed(headline: Option<&Headline>) -> Markup {
    html! {
        @if let Some(headline) = headline {
            div.missed role="alert" {
                @for (place, line) in headline.lines().iter().enumerate() {
                    p.alarm[place == 0] { (table::with_code(&capitalised(line))) "." }
                }
            }
        }
    }
}

/// A sentence with a capital first letter.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Client and author, according to the design.
fn byline(design: &Design) -> Markup {
    let report = design.report();
    let said = [
        ("for ", &report.client),
        ("by ", &report.author),
        ("revision ", &report.revision),
    ];
    let said: Vec<String> = said
        .iter()
        .filter(|(_, text)| !text.is_empty())
        .map(|(before, text)| format!("{before}{text}"))
        .collect();
    html! { @if !said.is_empty() { p.byline { (said.join(" \u{b7} ")) } } }
}

/// Tool, pressure, nail, wood, support, date and program.
fn given(design: &Design) -> Markup {
    let [supply, ambient] = [design.supply.pressure, design.ambient.pressure];
    let nail = format!(
        "{}{:.1} \u{d7} {:.2} mm",
        named(design, "nail.kind"),
        1e3 * design.nail.length,
        1e3 * design.nail.diameter
    );
    let block = &design.workpiece;
    let wood = format!(
        "{}{:.0} kg/m\u{b3}; {:.0} \u{d7} {:.0} \u{d7} {:.0} mm",
        named(design, "wood.species"),
        design.wood.density,
        1e3 * block.length,
        1e3 * block.width,
        1e3 * block.thickness
    );
    let facts = [
        ("tool", design.name().to_owned()),
        (
            "supply pressure",
            format!("{:.0} kPa, {:.0} psi gauge", 1e-3 * supply, (supply - ambient) / PSI),
        ),
        ("nail", nail),
        ("wood, block", wood),
        ("support", supports::of(design).name()),
        ("computed", format!("{} (UTC)", today())),
        ("program", format!("nailnoise {}", env!("CARGO_PKG_VERSION"))),
    ];
    html! { dl.given { @for (what, value) in facts { div { dt { (what) } dd { (value) } } } } }
}

/// The name that a key selects, followed by a separator; empty if the design lacks the key or no name is chosen.
fn named(design: &Design, key: &str) -> String {
    let entry = design.entries().into_iter().find(|entry| entry.key == key);
    match entry.map(|entry| entry.value) {
        Some(Value::Choice(word)) if word != "none" && word != "own" => format!("{word}, "),
        _ => String::new(),
    }
}

fn today() -> String {
    let seconds = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |time| time.as_secs());
    let [year, month, day] = date((seconds / 86_400) as i64);
    format!("{year}-{month:02}-{day:02}")
}

/// Year, month and day in the Gregorian calendar, from the number of days since 1 January 1970; computed with eras of
/// 400 years that begin on 1 March.
fn date(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    [year + 400 * era + i64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_dates_of_the_calendar() {
        assert_eq!(date(0), [1970, 1, 1]);
        assert_eq!(date(11_016), [2000, 2, 29]);
        assert_eq!(date(20_454), [2026, 1, 1]);
    }
}

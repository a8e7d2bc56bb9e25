//! The head of a run's report: the subject of the computation, and the result in one sentence.

use std::time::{SystemTime, UNIX_EPOCH};

use maud::{Markup, html};
use nailnoise_quantities::rounded;

use super::tables;
use super::typography::{capitalised, with_code, with_subscripts};
use crate::design::{Design, Value, inputs};
use crate::model::supports;
use crate::result::{Ends, RankedSource, RunResult, pressures};
use crate::stages::headline::Headline;
use crate::study::legend;
use crate::tables::run::without;

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
                "A-weighted sound energy of one shot, L" sub { "WA,1s" } " re 1 pW s"
                @if let Some(([heading, _], [interval, _])) = over_draws("total") {
                    "; " (heading.trim_end_matches(" dB")) " " (interval) " dB"
                }
            }
        }
        @if let Some(first) = first {
            p.verdict {
                @if result.ranking.len() > 1 {
                    "The " b { (first.source) } " is loudest, with " (format!("{:.0} %", 100.0 * first.share))
                    " of the sound energy"
                } @else {
                    "The " b { (first.source) } " is the only source"
                }
                @if let Some(draws) = draws_as_loudest(result, &first.source) {
                    " " (draws)
                }
                "."
            }
            @if result.ranking.len() > 1 {
                ul.verdict { @for source in result.ranking.iter().filter(|own| own.lwa_db.is_some()) {
                    li { (silencing(result, source)) }
                } }
            }
        }
        p.quiet { (with_subscripts(&in_words(result))) }
        @if let Some(performance) = &result.performance {
            p.quiet { "What this shot has in reserve, before anything is made quieter: " (performance.in_words()) "." }
        }
        p.quiet {
            "Absolute levels are predictions; the page Validation of the documentation compares those of one tool with \
             published tests. Differences between designs of one tool are more reliable than levels. "
            a href="#assumptions" { "Assumptions" } " lists the estimated values."
        }
        @if numerical_failure {
            p.alarm { "A check of this run failed. Do not rely on the result. " a href="#checks" { "Checks" } }
        }
    }
}

/// Fraction of the draws with a source as the loudest; none if it is not stated, or for a single source.
fn draws_as_loudest(result: &RunResult, source: &str) -> Option<String> {
    let study = result.study.known().filter(|_| result.ranking.len() > 1)?;
    let share = study.spread(source).first?;
    Some(match study.ends {
        Ends::Percentiles => format!("(loudest in {:.0} % of the draws)", 100.0 * share),
        Ends::Extremes => format!(
            "(loudest in {:.0} of {} draws)",
            share * study.draws as f64,
            study.draws
        ),
    })
}

/// Gain from silencing only one source, in the design and over the draws.
fn silencing(result: &RunResult, source: &RankedSource) -> String {
    let study = result.study.known();
    let ends = study.and_then(|study| Some((study, study.spread(&source.source).silencing_db?)));
    let over_draws = ends.map_or_else(String::new, |(study, [low, high])| {
        let of = match study.ends {
            Ends::Percentiles => "in 90 % of the draws".to_owned(),
            Ends::Extremes => format!("in {} draws", study.draws),
        };
        format!(" ({low:.1} to {high:.1} dB {of})")
    });
    format!(
        "Silencing the {} alone gains {:.1} dB{over_draws}.",
        source.source,
        without(source.share)
    )
}

/// Upper exposure action value of Directive 2003/10/EC, Article 3, over a working day \[dB(A)\], and that day \[s\].
const ACTION_DB: f64 = 85.0;
const DAY: f64 = 28_800.0;

/// Meaning of a decibel, and of the level at the ear for a working day.
fn in_words(result: &RunResult) -> String {
    let day = result.ear.lpa_1s_db.map_or_else(String::new, |level| {
        let shots = DAY * 10f64.powf(0.1 * (ACTION_DB - level));
        let digits = 10f64.powf(shots.max(1.0).log10().floor() - 1.0);
        format!(
            " At the operator's ear one shot is L_pA,1s {level:.0} dB: about {:.0} shots a day reach the upper action \
             value of {ACTION_DB:.0} dB(A) (Directive 2003/10/EC), other noise left aside.",
            (shots / digits).round() * digits
        )
    });
    format!("3 dB less is half of the sound energy; 10 dB less is a tenth of it, and sounds about half as loud.{day}")
}

/// The outcome of a shot that does not drive its nail, shown above all levels; empty otherwise.
pub(crate) fn missed(headline: Option<&Headline>) -> Markup {
    html! {
        @if let Some(headline) = headline {
            div.missed role="alert" {
                @for (place, line) in headline.lines().iter().enumerate() {
                    p.alarm[place == 0] { (with_code(&capitalised(line))) "." }
                }
            }
        }
    }
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

/// Tool, pressure, nail, wood, support, date and program; for an assembly, its fasteners and only the facts that apply
/// to it.
fn given(design: &Design) -> Markup {
    let [supply, ambient] = [design.supply.pressure, design.ambient.pressure];
    let own = inputs::assembly::facts(design);
    let nails = match &own {
        None => {
            let nail = format!(
                "{}{:.1} \u{d7} {:.2} mm",
                named(design, "nail.kind"),
                1e3 * design.nail.length,
                1e3 * design.nail.diameter
            );
            vec![("nail".to_owned(), nail)]
        }
        Some(own) => {
            let fastener = |(name, length, mass): &(String, f64, f64)| {
                let size = format!("{:.1} mm, {} g", 1e3 * length, rounded(1e3 * mass, 3, 1e6));
                (name.replace('_', " "), size)
            };
            own.fasteners.iter().map(fastener).collect()
        }
    };
    let has_workpiece = own.as_ref().is_none_or(|own| own.has_workpiece);
    let is_supplied = own.as_ref().is_none_or(|own| own.supplied);
    let block = &design.workpiece;
    let wood = format!(
        "{}{:.0} kg/m\u{b3}; {:.0} \u{d7} {:.0} \u{d7} {:.0} mm",
        named(design, "wood.species"),
        design.wood.density,
        1e3 * block.length,
        1e3 * block.width,
        1e3 * block.thickness
    );
    let mut facts = vec![("tool".to_owned(), design.name().to_owned())];
    if is_supplied {
        facts.push(("supply pressure".to_owned(), pressures(supply, ambient)));
    }
    facts.extend(nails);
    if has_workpiece {
        facts.push(("wood, block".to_owned(), wood));
        facts.push(("support".to_owned(), supports::of(design).name()));
    }
    facts.extend([
        ("computed".to_owned(), format!("{} (UTC)", today())),
        ("program".to_owned(), format!("nailnoise {}", env!("CARGO_PKG_VERSION"))),
    ]);
    html! { dl.given { @for (what, value) in facts { div { dt { (what) } dd { (value) } } } } }
}

/// The name that a key selects, followed by a separator; empty if the design does not have the key or no name is
/// chosen.
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

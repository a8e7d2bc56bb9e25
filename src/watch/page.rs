//! The page around the report: a bar with levels and changes, and the report below it.

use maud::{DOCTYPE, Markup, html};
use serde_json::json;

use super::board::{Board, State};
use super::shot::{Differences, FinishedRun};
use crate::report::{capitalised, missed_shot, with_code};
use crate::wording;

pub(super) const STYLE: &str = include_str!("watch.css");
pub(super) const SCRIPT: &str = include_str!("watch.js");

/// Maximum number of changed values that are named; exchanging a base changes dozens.
const NAMED: usize = 4;

/// The page as opened; its script then follows the [events](event).
pub(super) fn page(board: &Board) -> String {
    let state = board.now();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                link rel="icon" href="data:,";
                title { (board.name) ": watched" }
                link rel="stylesheet" href="watch.css";
                script src="watch.js" defer {}
            }
            body {
                header {
                    div.line {
                        h1 { (board.name) }
                        p #status role="status" { (status(&state)) }
                    }
                    pre #failure role="alert" hidden[state.failure.is_none()] {
                        (state.failure.as_deref().unwrap_or_default()) }
                    div #bar { (bar(&state)) }
                    form #sliders hidden aria-label="values of the design" {}
                }
                main #report { noscript { p { a href="report" { "The report of the last run" }
                    ", without updates after a save." } } }
            }
        }
    }
    .into_string()
}

/// Content that the script inserts into the page, as one line of JSON.
pub(super) fn event(name: &str, state: &State) -> String {
    let level = state.last.as_ref().and_then(|last| last.level("total"));
    let missed = state.last.as_ref().and_then(|last| last.headline.as_ref());
    let missed = missed.map_or_else(String::new, |headline| {
        format!("{}, ", headline.outcome.replace('_', " "))
    });
    let title = level.map_or_else(String::new, |level| format!("{missed}{level:.1} dB "));
    json!({
        "title": format!("{title}{name}: watched"),
        "status": status(state),
        "failure": state.failure,
        "bar": bar(state).into_string(),
        "report": state.report.as_ref().map(|(number, _)| number),
        "sliders": state.sliders,
        "basis": state.basis,
        "moved": state.moved.iter().map(|(key, _)| key).collect::<Vec<_>>(),
        "saved": state.saved,
    })
    .to_string()
}

fn status(state: &State) -> String {
    match (&state.doing, &state.failure, &state.last) {
        (Some(doing), ..) => format!("computing: {doing}"),
        (None, Some(_), Some(last)) => format!("the last save has no result; run {} is shown", last.number),
        (None, Some(_), None) => "the last save has no result".to_owned(),
        (None, None, Some(last)) => format!("run {}, computed in {:.1} s", last.number, last.seconds),
        (None, None, None) => "waits".to_owned(),
    }
}

fn bar(state: &State) -> Markup {
    let Some(last) = &state.last else {
        return html! { p.quiet { "The first run of a tool takes minutes; later ones a second or two, where only \
        pressure, exhaust or air change." } };
    };
    let mut names: Vec<&str> = last.levels.iter().skip(1).map(|(name, _)| name.as_str()).collect();
    names.sort_unstable();
    names.insert(0, "total");
    let [before, pinned] = state.differences();
    // The pinned run may be the previous one, or this one.
    let pinned = pinned.filter(|pinned| pinned.from != last.number);
    let before = before.filter(|before| pinned.as_ref().is_none_or(|pinned| pinned.from != before.from));
    let compared = [before.as_ref(), pinned.as_ref()];
    html! {
        (missed_shot(last.headline.as_ref()))
        @for unlike in compared.into_iter().flatten().filter_map(|own| own.unlike.as_ref()) { p.alarm
            role="alert" { (capitalised(unlike)) "." } }
        div.scroll tabindex="0" role="region" aria-label="levels and changes" { table {
            thead { tr {
                th scope="col" { "L" sub { "WA,1s" } }
                @for name in &names { th.n scope="col" { (name) } }
                th scope="col" { "changed values" }
            } }
            tbody {
                tr.now {
                    th scope="row" { "run " (last.number) @if state.is_pinned(last.number) { ", pinned" } }
                    @for name in &names { td.n { (level(last, name)) } }
                    td { (remarks(last, &state.warnings)) }
                }
                @if let Some(before) = &before { (row("from run", before, "", &names)) }
                @if let Some(pinned) = &pinned { (row("from run", pinned, ", pinned", &names)) }
            }
        } }
        p.line.quiet {
            @if state.is_pinned(last.number) {
                button type="button" data-post="unpin" { "Unpin run " (last.number) }
            } @else {
                button type="button" data-post="pin" { "Pin run " (last.number) }
                @if state.pinned.is_some() { button type="button" data-post="unpin" { "Unpin" } }
            }
            @if let Some(scales) = state.scales() {
                button type="button" data-listen data-pinned=(scales[0]) data-last=(scales[1]) { "Listen to both" }
                output #heard {}
            }
            a href="report" target="_blank" rel="noopener" { "Report alone, to print" }
            span { "Changes of one shot in dB; most errors cancel in them. " code { "nailnoise compare --draws" }
                " says how sure they are." }
        }
    }
}

impl State {
    /// Loudness at full scale of the sounds of the pinned and of the last run, relative to the louder one; none if
    /// there are not two.
    fn scales(&self) -> Option<[f64; 2]> {
        let [pinned, last] = [self.pinned.as_ref()?, self.last.as_ref()?];
        let both = [pinned.sound.as_ref()?, last.sound.as_ref()?].map(|sound| sound.full_scale_pa);
        let most = both[0].max(both[1]);
        (pinned.number != last.number).then(|| both.map(|own| own / most))
    }

    fn is_pinned(&self, number: u32) -> bool {
        self.pinned.as_ref().is_some_and(|pinned| pinned.number == number)
    }
}

fn level(shot: &FinishedRun, name: &str) -> String {
    let level = shot.level(name);
    level.map_or_else(|| "silent".to_owned(), |level| format!("{level:.1} dB"))
}

/// Remarks for the user before the numbers are used.
fn remarks(shot: &FinishedRun, warnings: &[String]) -> Markup {
    html! {
        @if !shot.failed.is_empty() {
            strong.alarm { "Do not rely on this run: check failed: " (with_code(&shot.failed.join(", "))) }
        }
        @if !warnings.is_empty() {
            details {
                summary { (warnings.len()) @if warnings.len() == 1 { " warning" } @else { " warnings" } }
                @for warning in warnings { pre { (warning) } }
            }
        }
    }
}

fn row(what: &str, differences: &Differences, behind: &str, names: &[&str]) -> Markup {
    let change = |name: &str| {
        let own = differences.levels.iter().find(|(own, _)| own == name);
        let change = own.and_then(|(_, change)| *change);
        change.map_or_else(
            || "\u{2013}".to_owned(),
            |db| wording::change(db).replace('-', "\u{2212}"),
        )
    };
    // A difference between shots with different outcomes is neither better nor worse.
    let sign = |name: &str| match change(name).chars().next().filter(|_| differences.unlike.is_none()) {
        Some('+') => "n louder",
        Some('\u{2212}') => "n quieter",
        _ => "n",
    };
    html! {
        tr {
            th scope="row" { (what) " " (differences.from) (behind) }
            @for name in names { td class=(sign(name)) { (change(name)) } }
            td {
                @if differences.unlike.is_some() { strong.alarm { "not comparable" } "; " }
                (values(differences))
            }
        }
    }
}

fn values(differences: &Differences) -> Markup {
    let all = &differences.values;
    html! {
        @if all.is_empty() { "none" }
        @for (place, (key, before, now)) in all.iter().take(NAMED).enumerate() {
            @if place > 0 { ", " }
            code { (key) } " " (before) " \u{2192} " (now)
        }
        @if all.len() > NAMED { " and " (all.len() - NAMED) " more" }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::stages::headline::{Figure, Headline};
    use std::sync::Arc;

    fn shot(number: u32, total: f64, pressure: &str) -> FinishedRun {
        let levels = [("total", total), ("workpiece", total - 2.0), ("exhaust", total - 6.0)];
        FinishedRun {
            number,
            seconds: 1.25,
            values: vec![("supply.pressure".to_owned(), pressure.to_owned())],
            levels: levels.map(|(name, level)| (name.to_owned(), Some(level))).to_vec(),
            failed: Vec::new(),
            headline: None,
            sound: None,
        }
    }

    fn state() -> State {
        State {
            last: Some(Arc::new(shot(2, 101.5, "650 kPa"))),
            before: Some(Arc::new(shot(1, 102.3, "<763 kPa>"))),
            ..State::default()
        }
    }

    #[test]
    fn the_bar_shows_levels_changes_and_values() {
        let text = bar(&state()).into_string();
        for part in [
            "101.5 dB",
            "\u{2212}0.8",
            "&lt;763 kPa&gt; \u{2192} 650 kPa",
            "from run 1",
            "Pin run 2",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
    }

    #[test]
    fn a_failed_check_is_named_beside_the_levels() {
        let mut state = state();
        let mut last = shot(2, 101.5, "650 kPa");
        last.failed = vec!["mass balance".to_owned()];
        state.last = Some(Arc::new(last));
        assert!(bar(&state).into_string().contains("check failed: mass balance"));
    }

    fn underdriven() -> Headline {
        Headline {
            outcome: "underdriven".to_owned(),
            text: "the nail is not driven to its length: 23.3 mm of the nail protrude".to_owned(),
            exhaust_opens: true,
            figure: Figure {
                name: "protrusion of the nail".to_owned(),
                value: 0.0233,
                unit: "m".to_owned(),
            },
            inputs: Vec::new(),
        }
    }

    #[test]
    fn a_shot_that_does_less_is_not_a_quieter_one() {
        let mut state = state();
        assert!(bar(&state).into_string().contains("quieter"));
        let mut last = shot(2, 95.8, "400 kPa");
        last.headline = Some(underdriven());
        state.last = Some(Arc::new(last));
        let text = bar(&state).into_string();
        assert!(!text.contains("quieter"), "{text}");
        let (alarm, level) = (
            text.find("23.3 mm of the nail protrude").unwrap(),
            text.find("95.8 dB").unwrap(),
        );
        assert!(alarm < level, "{text}");
        assert!(
            text.contains("The shots do not end alike (run 1 drives, run 2 is underdriven)"),
            "{text}"
        );
    }

    #[test]
    fn an_event_is_one_line() {
        let mut state = state();
        state.failure = Some("line 1\nline 2".to_owned());
        let event = event("own", &state);
        assert!(!event.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&event).expect("JSON");
        assert_eq!(value["failure"], "line 1\nline 2");
        assert_eq!(value["status"], "the last save has no result; run 2 is shown");
    }
}

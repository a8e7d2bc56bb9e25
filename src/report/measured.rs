//! The page of predictions next to measurements.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::table;
use crate::figures::{Axis, BLACK, Chart, Panel, Series, Shape};
use crate::tables::measured::quantities;
use crate::virtual_test::comparison::{ComparedQuantity, MeasuredComparison};
use crate::wording::drawn_structures;

/// Margin of levels below and above those in the chart \[dB\].
const MARGIN: f64 = 3.0;

pub(super) fn page(comparison: &MeasuredComparison) -> Page {
    let sections = vec![
        Section::new("levels", "Levels", html! { (markup(&chart(comparison))) }),
        Section::new("quantities", "Quantities", table::markup(&quantities(comparison))),
        Section::new("open", "What stays open", open(comparison)),
    ];
    Page {
        title: "measured and predicted".to_owned(),
        compared: None,
        heading: "Measured and predicted".to_owned(),
        lead: html! {
            p { (comparison.tool) ". " (comparison.source) }
            ul { @for own in &comparison.designs { li { "predicted by " b { (own.name) } ", " (own.draws)
                " draws of its ranges and of the wraps, " (drawn_structures(own.structures)) } } }
            p.quiet { "Like is compared with like: the prediction goes through the microphones, wraps and subtraction \
                of the test. No \
                       parameter of the design was fitted to these measurements." }
        },
        sections,
    }
}

/// Only levels, because other quantities have other units.
fn chart(comparison: &MeasuredComparison) -> Chart {
    let rows: Vec<&ComparedQuantity> = comparison.rows.iter().filter(|own| own.level).collect();
    let lowest = rows
        .iter()
        .flat_map(|own| {
            own.interval
                .map(|[low, _]| low)
                .into_iter()
                .chain(own.measured[0])
                .chain([own.predicted])
        })
        .fold(f64::INFINITY, f64::min);
    // A bound without a lower end begins at the end of the axis.
    let floor = lowest - MARGIN;
    let ends = |own: &ComparedQuantity| [own.measured[0].unwrap_or(floor), own.measured[1].unwrap_or(f64::NAN)];
    let measured = Series {
        shape: Shape::Whiskers(rows.iter().map(|own| ends(own)).collect()),
        ..Series::over(
            "measured",
            BLACK,
            Shape::Line,
            rows.iter()
                .map(|own| own.measured[1].map(|high| 0.5 * (high + own.measured[0].unwrap_or(high)))),
        )
    };
    let predicted = Series {
        shape: Shape::Whiskers(
            rows.iter()
                .map(|own| own.interval.unwrap_or([own.predicted; 2]))
                .collect(),
        ),
        ..Series::over("predicted", 0, Shape::Line, rows.iter().map(|own| Some(own.predicted)))
    };
    let highest = rows
        .iter()
        .flat_map(|own| own.interval.map(|[_, high]| high).into_iter().chain(own.measured[1]))
        .fold(f64::NEG_INFINITY, f64::max);
    Chart {
        name: "measured-predicted".to_owned(),
        title: "Measured and predicted levels",
        subject: String::new(),
        caption:
            "Intervals of the measured levels (rounding, or a bound from above) beside 5 to 95 % of the draws of the \
                  prediction; the line across is the design as it is."
                .to_owned(),
        panels: vec![Panel {
            x: Axis::categories(
                "Row of the table below",
                "",
                (1..=rows.len()).map(|n| n.to_string()).collect(),
            ),
            y: Axis::new("Level", "dB(A)", [floor, highest + MARGIN]),
            height: 70,
            series: vec![measured, predicted],
        }],
        events: Vec::new(),
    }
}

fn open(comparison: &MeasuredComparison) -> Markup {
    html! {
        ul {
            @for own in comparison.rows.iter().filter(|own| !own.note.is_empty()) { li { (own.quantity) ": "
                (own.note) } }
            @for own in &comparison.open { li { "not compared: " (own) } }
        }
    }
}

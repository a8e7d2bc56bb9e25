//! The page of a sweep.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::table;
use super::typography::{capitalised, with_code};
use crate::figures::Chart;
use crate::headline::alarms;
use crate::study::{Axis, SweptPoint};
use crate::tables::{decibels, sweep as tables};
use crate::units::Units;

pub(super) fn page(design: &str, axes: &[Axis], points: &[SweptPoint], chart: &Chart, units: Units) -> Page {
    let keys: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
    let mut sections = vec![
        Section::new("trend", "Trend", markup(chart)),
        Section::new(
            "points",
            "Points",
            html! { (table::markup(&tables::points(axes, points).in_units(units)))
            p.quiet { "A-weighted single-event sound power levels, dB re 1 pW s." } },
        ),
    ];
    if let Some(drawn) = tables::over_draws(axes, points) {
        sections.push(Section::new(
            "draws",
            "How sure",
            html! {
                (table::markup(&drawn))
                p.quiet { "90 % of the common draws that count at all points lie between these levels; structures as \
                    in the design; changes from the first point." }
            },
        ));
    }
    Page {
        title: format!("{design}: sweep of {}", keys.join(", ")),
        compared: None,
        heading: format!("{design}: levels over {}", keys.join(", ")),
        lead: lead(axes, points),
        sections,
    }
}

/// A sentence on the quietest and the loudest point whose nail is driven.
fn lead(axes: &[Axis], points: &[SweptPoint]) -> Markup {
    let name = |point: &SweptPoint| {
        let values = axes.iter().zip(&point.values);
        let values: Vec<String> = values
            .map(|(axis, value)| format!("`{}` = {value}", axis.key))
            .collect();
        values.join(", ")
    };
    let drives = points
        .iter()
        .filter(|point| point.headline.is_none() && point.total_db.is_some());
    let by = |a: &&SweptPoint, b: &&SweptPoint| {
        a.total_db
            .unwrap_or_default()
            .total_cmp(&b.total_db.unwrap_or_default())
    };
    let ends = drives.clone().min_by(by).zip(drives.clone().max_by(by));
    html! {
        @let alarms = alarms(points);
        @if !alarms.is_empty() {
            div.missed role="alert" {
                @for (place, line) in alarms.iter().enumerate() {
                    p.alarm[place == 0] { (with_code(&if place == 0 { capitalised(line) } else { line.clone() })) "." }
                }
            }
        }
        @if let Some((quiet, loud)) = ends {
            p.verdict { "The total is lowest with " (with_code(&name(quiet))) ": " (decibels(quiet.total_db))
                " dB, and highest with " (with_code(&name(loud))) ": " (decibels(loud.total_db)) " dB"
                @if drives.clone().count() < points.len() { ", of the points that drive the nail" } "." }
        }
        p { (points.len()) " points of the design itself; "
            @if points.iter().any(|point| point.drawn.is_some()) { "intervals over common draws are below." }
            @else { code { "--draws" } " states how sure a change is." } }
    }
}

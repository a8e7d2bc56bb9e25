//! Reports: one HTML file that opens without a network, for people who do not run the program.
//!
//! A report of a run shows whatever its result holds: every source, check, note and sensor by itself, and what a newer
//! result adds as tables of their own. Charts are drawn by plotly.js, whose script is in the file; printed, the page
//! is a clean document.

mod assumptions;
mod chart;
mod compared;
mod measured;
mod measurement;
mod modes;
mod page;
mod picture;
mod scene;
mod sound;
mod study;
mod surface;
mod tables;

use maud::{Markup, PreEscaped, html};
use serde::{Deserialize, Serialize};

use crate::comparison::Comparison;
use crate::design::Design;
use crate::error::Error;
use crate::figures;
use crate::measurement::comparison::MeasuredComparison;
use crate::measurement::result::MeasurementResult;
use crate::result::RunResult;
use crate::run::Run;
use crate::stages::spectra::{Driven, MovingBody};
use crate::stages::{Code, Input, Postcard, Progress, Stage, code};
use crate::study::StudyResult;

pub use sound::Recording;

pub(crate) use page::compared_by;
use page::{Page, Section};
use surface::Painted;
pub use surface::Surroundings;

/// Keys of a result that the report shows in a form of their own.
const SHOWN: [&str; 13] = [
    "schema",
    "design",
    "inputs",
    "ranking",
    "total",
    "outcome",
    "cycle",
    "events",
    "sensors",
    "microphones",
    "checks",
    "notes",
    "timing",
];

/// The parts of a report that show the bodies in motion, ready for the page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// The surfaces in space; none where there are none.
    scene: Option<String>,
    /// Sources whose surface is shown.
    sources: Vec<String>,
    /// Table and pictures of the loudest modes.
    modes: String,
}

/// Makes the parts of a report that show the bodies in motion.
#[derive(Serialize)]
pub struct BodyPictures {
    /// The bodies.
    pub moving: Vec<MovingBody>,
    /// What they stand in and on.
    pub surroundings: Surroundings,
}

impl Stage for BodyPictures {
    type Output = Pictures;
    type Codec = Postcard;
    const NAME: &'static str = "pictures of the bodies";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_intervals,
        stages_microphones,
        stages_radiation,
        stages_response,
        stages_sensors,
        stages_sound,
        stages_sound_fields,
        stages_spectra,
        output,
        stages_ranking,
        report
    );

    fn inputs(&self) -> Vec<&dyn Input> {
        self.moving.iter().flat_map(MovingBody::inputs).collect()
    }

    fn compute(&self, _: &Progress) -> Result<Pictures, Error> {
        let moving: Vec<Driven> = self.moving.iter().map(MovingBody::get).collect::<Result<_, _>>()?;
        let paint = |driven| Painted::new(&self.surroundings, driven);
        let bodies: Vec<Painted<'_>> = moving.iter().map(paint).collect();
        Ok(Pictures {
            scene: scene::chart(&bodies)
                .map(|view| html! { figure.chart { (view.markup()) figcaption { (view.description) } } }.into_string()),
            sources: bodies.iter().map(|painted| painted.source().to_owned()).collect(),
            modes: modes::section(&bodies).into_string(),
        })
    }
}

/// The report of a run, with the pictures and sounds that belong to it.
pub fn run(design: &Design, run: &Run, pictures: &Pictures, recordings: &[Recording]) -> String {
    let (result, subject) = (&run.result, run.result.design.name.as_str());
    let value = serde_json::to_value(result).unwrap_or_default();
    let mut sections = vec![Section::new("ranking", "Ranking", ranking(result, &value))];
    sections.push(Section::new(
        "levels",
        "Levels",
        html! { @for chart in figures::levels(subject, result) { (chart::markup(&chart)) } },
    ));
    sections.push(Section::new(
        "sound",
        "Sound",
        sound::section(&result.microphones, recordings),
    ));
    if let Some(view) = &pictures.scene {
        let without: Vec<&str> = result
            .ranking
            .iter()
            .map(|source| source.source.as_str())
            .filter(|source| !pictures.sources.iter().any(|shown| shown == source))
            .collect();
        sections.push(Section::new(
            "surfaces",
            "Surfaces",
            html! {
                (PreEscaped(view))
                @if !without.is_empty() {
                    p.quiet { "Sources without a vibrating surface in this model: " (without.join(", ")) "." }
                }
            },
        ));
    }
    sections.push(Section::new(
        "modes",
        "Loudest modes",
        html! { (PreEscaped(&pictures.modes)) },
    ));
    let mut cycle = figures::cycle(subject, design, &run.record);
    let energy = cycle.pop();
    sections.push(Section::new(
        "cycle",
        "Nailing cycle",
        html! {
            (chart::markup(&figures::power(subject, &run.record, &run.powers)))
            @for chart in &cycle { (chart::markup(chart)) }
            div.columns { (tables::events(&run.record)) (tables::figures(&value["cycle"])) }
        },
    ));
    sections.push(Section::new(
        "energy",
        "Energy flow",
        html! { @if let Some(chart) = &energy { (chart::markup(chart)) } },
    ));
    if !result.sensors.is_empty() {
        sections.push(Section::new(
            "sensors",
            "Accelerometers",
            tables::generic(&value["sensors"]),
        ));
    }
    let further = tables::further(&value, &SHOWN);
    if let Some(further) = further {
        sections.push(Section::new("further", "Further results", further));
    }
    sections.push(Section::new("assumptions", "Assumptions", assumptions::section(design)));
    sections.push(Section::new("checks", "Checks", tables::checks(result)));
    sections.push(Section::new("origin", "Origin", origin(result)));
    Page {
        title: format!("{}: sound power of a nailer", result.design.name),
        compared: None,
        heading: result.design.name.clone(),
        lead: lead(result),
        sections,
    }
    .html()
}

/// Where the report of a run holds the intervals of its levels.
const INTERVALS: &str = "<!-- intervals of the levels -->";

/// Intervals of the levels of a run, as the command prints them.
pub struct Intervals {
    /// Headings behind "source" and "level".
    pub headings: [String; 2],
    /// Source, level, interval \[dB\] and probability of being the loudest; the total comes last.
    pub rows: Vec<[String; 4]>,
    /// What the columns hold, and what not.
    pub legend: String,
}

/// The report of a run with the intervals of its levels, which follow from a study and not from the run.
pub fn with_intervals(report: &str, intervals: &Intervals) -> String {
    let table = html! {
        h3 { "How sure the levels are" }
        div.scroll { table {
            thead { tr { th { "source" } th.n { "level" } @for heading in &intervals.headings { th.n { (heading) } } } }
            tbody { @for [source, cells @ ..] in &intervals.rows { tr.sum[source == "total"] {
                td { (source) } @for cell in cells { td.n { (cell) } }
            } } }
        } }
        @for line in intervals.legend.trim().lines() { p.quiet { (line.trim()) } }
    };
    report.replacen(INTERVALS, &table.into_string(), 1)
}

/// The report of a study with these charts.
pub fn study(result: &StudyResult, charts: &[figures::Chart], scatter: &[figures::Chart]) -> String {
    study::page(result, charts, scatter).html()
}

/// The page of predictions beside measurements.
pub fn measured(comparison: &MeasuredComparison) -> String {
    measured::page(comparison).html()
}

/// The page of a wrapping test with these charts.
pub fn measurement(result: &MeasurementResult, charts: &[figures::Chart]) -> String {
    measurement::page(result, charts).html()
}

/// The report of a comparison of the files with this identity.
pub fn comparison(comparison: &Comparison, identity: &str) -> String {
    compared::page(comparison, identity).html()
}

/// What a reader must know first.
fn lead(result: &RunResult) -> Markup {
    let first = result.ranking.first().filter(|source| source.lwa_db.is_some());
    html! {
        div.total {
            span.number { (tables::decibels(result.total.lwa_db)) }
            span.unit { "dB" }
            span.what { "L" sub { "WA,1s" } " re 1 pW s: A-weighted sound energy of one shot" }
        }
        @if let Some(first) = first {
            p.verdict {
                "The " b { (first.source) } " radiates most, " (format!("{:.0} %", 100.0 * first.share))
                " of the A-weighted energy. Without it the total would be "
                (format!("{:.1} dB", without(first.share))) " lower."
            }
        }
        p.quiet {
            "Absolute levels are predictions; those of one tool stand beside published tests on the page Validation of the \
             documentation. Differences between designs of one tool are more reliable than levels. " a href="#assumptions" { "Assumptions" } " lists what is estimated."
        }
        @if result.checks.iter().any(|check| !check.ok) {
            p.alarm { "A check of this run failed. Do not rely on the result. " a href="#checks" { "Checks" } }
        }
    }
}

/// How much lower the total would be without a source that has this share \[dB\].
fn without(share: f64) -> f64 {
    -10.0 * (1.0 - share).max(1e-12).log10()
}

fn ranking(result: &RunResult, value: &serde_json::Value) -> Markup {
    let range = result.ranking.first().and_then(|source| {
        let (first, last) = (source.bands.first()?, source.bands.last()?);
        Some(format!("{} to {} Hz", first.hz, last.hz))
    });
    html! {
        (tables::ranking(result))
        @if let Some(range) = range {
            p.quiet {
                "Levels in dB re 1 pW s over the one-third-octave bands " (range) ", the same for all sources. The \
                 uncertainty is that of the method alone; \u{201c}open\u{201d} means no bound. The uncertainty of the design's \
                 values is not included."
            }
        }
        (PreEscaped(INTERVALS))
        @for (source, value) in result.ranking.iter().zip(value["ranking"].as_array().into_iter().flatten()) {
            details {
                summary { (source.source) ": parts and method" }
                (tables::source(source))
                @if let Some(more) = tables::further(value, &tables::SOURCE) { (more) }
            }
        }
        @if !result.notes.is_empty() {
            h3 { "Notes" }
            ul.notes { @for note in &result.notes { li { (note) } } }
        }
    }
}

fn origin(result: &RunResult) -> Markup {
    let total = result.timing.whole();
    let stages: Vec<String> = result
        .timing
        .stages()
        .filter(|stage| stage.1 >= 0.05)
        .map(|(stage, seconds)| format!("{stage} {seconds:.1} s"))
        .collect();
    html! {
        table.facts {
            tr { th { "program" } td { "nailnoise " (env!("CARGO_PKG_VERSION")) } }
            tr { th { "its sources (SHA-256)" } td.digest { (env!("NAILNOISE_SOURCES")) } }
            tr { th { "layout of result.json" } td { (result.schema) } }
            tr { th { "design" } td { (result.design.name) } }
            tr { th { "its values (SHA-256)" } td.digest { (result.design.digest) } }
            tr { th { "computed in" } td { (format!("{total:.1} s")) @if !stages.is_empty() { ": " (stages.join(", ")) } } }
            tr { th { "physics after" } td {
                "Z. Nili Ahmadabadi, " i { "Noise source identification and dynamic modeling of a pneumatic nailing device" }
                " (\u{c9}TS Montr\u{e9}al, 2016), with corrections that close mass, energy and momentum"
            } }
        }
    }
}

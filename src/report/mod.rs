//! Reports: one HTML file that opens without a network, for readers who do not run the program.
//!
//! A report of a run shows everything in its result: every source, check, note and sensor separately, and fields that
//! newer results add as separate tables. Charts and pictures are part of the page, which is therefore complete without
//! a script, with light and dark colours and in print. Scripts add values under the pointer, zooming, and a
//! three-dimensional view that can be rotated.

mod assumptions;
mod axis;
mod calibration;
mod chart;
mod compared;
mod declared;
mod drawing;
mod events;
mod head;
mod legend;
mod measured;
mod measurement;
mod methods;
mod modes;
mod optimised;
mod page;
mod picture;
mod raster;
mod rows;
mod scene;
mod sheet;
mod sound;
mod study;
mod surface;
mod swept;
mod table;
mod tables;
mod typography;

use maud::{Markup, PreEscaped, html};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::calibration::CalibrationResult;
use crate::comparison::Comparison;
use crate::declaration;
use crate::design::Design;
use crate::error::Error;
use crate::figures;
use crate::measurement::result::MeasurementResult;
use crate::model::sources::by_name;
use crate::optimisation::Optimisation;
use crate::result::RunResult;
use crate::run::Run;
use crate::stages::cycle::SummaryFigures;
use crate::stages::modal_efficiency::BodyEfficiencies;
use crate::stages::spectra::{BodyInMotion, MovingBody};
use crate::stages::{Code, Postcard, Progress, Stage, Stored, all, code};
use crate::study::{Axis, PairedStudy, StudyResult, SweptPoint};
use crate::tables::cycle::figures as figures_of;
use crate::tables::run as run_tables;
use crate::units::Units;
use crate::virtual_test::comparison::MeasuredComparison;

pub(crate) use head::missed as missed_shot;
pub use sound::Recording;
pub(crate) use typography::{capitalised, with_code};

pub(crate) use page::compared_by;
use page::{Page, Section};
use surface::ColouredSurface;
pub use surface::Surroundings;

/// Keys of a result with a dedicated form in the report.
const SHOWN: [&str; 23] = [
    "schema",
    "design",
    "inputs",
    "ranking",
    "total",
    "study",
    "outcome",
    "headline",
    "cycle",
    "performance",
    "radiation_efficiencies",
    "motion",
    "events",
    "event_words",
    "sensors",
    "transducers",
    "microphones",
    "ear",
    "declaration",
    "checks",
    "notes",
    "method_notes",
    "timing",
];

/// The parts of a report that show the moving bodies, ready for the page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// The surfaces in space, if any.
    scene: Option<String>,
    /// Sources whose surface is shown.
    sources: Vec<String>,
    /// Table and pictures of the loudest modes.
    modes: String,
}

/// Makes the parts of a report that show the moving bodies.
#[derive(Serialize)]
pub struct BodyPictures {
    /// The bodies.
    pub moving: Vec<MovingBody>,
    /// Radiation efficiencies of their modes.
    pub efficiencies: Vec<Stored<Vec<BodyEfficiencies>>>,
    /// Surroundings and supports of the bodies.
    pub surroundings: Surroundings,
}

impl Stage for BodyPictures {
    type Output = Pictures;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "pictures of the bodies";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_apart,
        stages_bodies,
        stages_cycle,
        stages_headline,
        stages_intervals,
        stages_microphones,
        stages_modal_efficiency,
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

    fn compute(&self, _: &Progress) -> Result<Pictures, Error> {
        let moving: Vec<BodyInMotion> = self.moving.iter().map(MovingBody::get).collect::<Result<_, _>>()?;
        let efficiencies = all(&self.efficiencies)?;
        let of_body = |name: &str| efficiencies.iter().flat_map(|own| &**own).find(|own| own.body == name);
        let bodies: Vec<ColouredSurface<'_>> = moving
            .par_iter()
            .map(|driven| ColouredSurface::new(&self.surroundings, driven, of_body(driven.body.name)))
            .collect();
        let (scene, modes) = rayon::join(
            || scene::figure(&bodies).map(Markup::into_string),
            || modes::section(&bodies).into_string(),
        );
        Ok(Pictures {
            scene,
            sources: bodies.iter().map(|painted| painted.source().to_owned()).collect(),
            modes,
        })
    }
}

/// The report of a run, with the pictures and sounds that belong to it. It begins with a summary, followed by an
/// appendix.
pub fn run(design: &Design, run: &Run, pictures: &Pictures, recordings: &[Recording], units: Units) -> String {
    let (result, subject) = (&run.result, run.result.design.name.as_str());
    let value = serde_json::to_value(result).unwrap_or_default();
    let mut levels = figures::in_units(figures::levels(subject, result), units);
    let mut more = levels.iter_mut().find_map(more_panels);
    for (chart, weighting) in levels
        .first_mut()
        .into_iter()
        .zip(["A-weighted"])
        .chain(more.iter_mut().zip(["unweighted"]))
    {
        chart.caption = format!("One-third-octave levels of each source, {weighting}, dB re 1 pW s.");
    }
    let place = levels.iter().position(|chart| chart.name == "intervals");
    let intervals = place.map(|place| levels.remove(place));
    let loud = events::loudest(result);
    let of_parts = |chart: &figures::Chart| by_name(&chart.name).is_some();
    let mut cycle = figures::in_units(figures::shot(subject, design, &run.record), units);
    let energy = cycle.pop_if(|chart| chart.name == "energy");
    let power = figures::power(subject, &run.record, &run.powers).in_units(units);
    let mut sections = vec![
        Section::new("ranking", "Ranking", ranking(result)),
        Section::new(
            "levels",
            "Levels",
            html! {
                @for chart in levels.iter().filter(|own| !of_parts(own)) { (chart::markup(chart)) }
                @if let Some(chart) = &intervals { (events::intervals(chart, &loud, &result.event_words)) }
            },
        )
        .on_a_page(),
    ];
    if let Some(view) = &pictures.scene {
        sections.push(Section::new("surfaces", "Surfaces", surfaces(result, pictures, view)).on_a_page());
    }
    sections.extend([
        Section::new(
            "shot",
            "Over the shot",
            html! { (chart::markup(&power)) (events::key(&power.events, &loud)) },
        )
        .on_a_page(),
        Section::new("listen", "Listen", sound::players(recordings)),
        Section::new(
            "more-levels",
            "More levels",
            html! {
                @if let Some(chart) = &more { (chart::markup(chart)) }
                @for chart in levels.iter().filter(|own| of_parts(own)) { (chart::markup(chart)) }
                @if let Some(chart) = figures::motion(subject, result) { (chart::markup(&chart)) }
            },
        )
        .in_the_appendix(),
        Section::new("microphones", "Microphones", sound::measured(result)).in_the_appendix(),
    ]);
    if !pictures.modes.is_empty() {
        let modes = html! { (PreEscaped(&pictures.modes)) };
        sections.push(Section::new("modes", "Loudest modes", modes).in_the_appendix());
    }
    sections.extend([
        Section::new("drawing", "Drawing", drawing::section(design)).in_the_appendix(),
        Section::new(
            "cycle",
            "Nailing cycle",
            html! {
                @for chart in &cycle { (chart::markup(chart)) }
                div.columns { (events::times(&run.record.events, &loud)) (figures_of_shot(run, &value["cycle"])) }
            },
        )
        .in_the_appendix(),
    ]);
    if let Some(chart) = &energy {
        sections.push(Section::new("energy", "Energy flow", chart::markup(chart)).in_the_appendix());
    }
    if !result.sensors.is_empty() || !result.transducers.is_empty() {
        sections.push(
            Section::new(
                "sensors",
                "Sensors",
                html! {
                    @for kind in ["sensors", "transducers"] {
                        @if value[kind].as_array().is_some_and(|own| !own.is_empty()) { (tables::generic(&value[kind]))
                            }
                    }
                },
            )
            .in_the_appendix(),
        );
    }
    if let Some(further) = tables::further(&value, &SHOWN) {
        sections.push(Section::new("further", "Further results", further).in_the_appendix());
    }
    sections.extend([
        Section::new("methods", "Methods", methods::section(result, &value)).in_the_appendix(),
        Section::new("assumptions", "Assumptions", assumptions::section(design)).in_the_appendix(),
        Section::new("checks", "Checks", tables::checks(result, units)).in_the_appendix(),
        Section::new("origin", "Origin", origin(result)).in_the_appendix(),
    ]);
    Page {
        title: format!("{}: sound power of a nailer", head::heading(design)),
        compared: None,
        heading: head::heading(design),
        lead: head::lead(design, result),
        sections,
    }
    .html(units)
}

/// Removes all panels but the first from a chart and returns them as a separate chart.
fn more_panels(chart: &mut figures::Chart) -> Option<figures::Chart> {
    let panels = chart.panels.split_off(1);
    (!panels.is_empty()).then(|| figures::Chart {
        name: format!("{}-more", chart.name),
        panels,
        ..chart.clone()
    })
}

fn surfaces(result: &RunResult, pictures: &Pictures, view: &str) -> Markup {
    let sources = result.ranking.iter().map(|source| source.source.as_str());
    let without: Vec<&str> = sources
        .filter(|source| !pictures.sources.iter().any(|shown| shown == source))
        .collect();
    html! {
        (PreEscaped(view))
        @if !without.is_empty() { p.quiet { "Sources without a vibrating surface in this model: " (without.join(", "))
            "." } }
    }
}

/// The report of a study, with these charts.
pub fn study(result: &StudyResult, charts: &[figures::Chart], scatter: &[figures::Chart], units: Units) -> String {
    study::page(result, charts, scatter).html(units)
}

/// The page of a calibration, whose result is shown in these units, with these charts.
pub fn calibration(result: &CalibrationResult, charts: &[figures::Chart], units: Units) -> String {
    calibration::page(result, charts).html(units)
}

/// The page of an optimisation with these charts; `reports` are the files of the designs of its front, if any.
pub fn optimised(found: &Optimisation, charts: &[figures::Chart], reports: &[Option<String>], units: Units) -> String {
    optimised::page(found, charts, reports, units).html(units)
}

/// Figures of a shot: those of the tool of the keys in plain words, those of an assembly by their names.
fn figures_of_shot(run: &Run, value: &serde_json::Value) -> maud::Markup {
    match &run.record.figures {
        SummaryFigures::Keys(summary) => table::markup(&figures_of(summary)),
        SummaryFigures::Assembly(_) => tables::generic(value),
    }
}

/// The page of a sweep with its chart.
pub fn swept(design: &str, axes: &[Axis], points: &[SweptPoint], chart: &figures::Chart, units: Units) -> String {
    swept::page(design, axes, points, chart, units).html(units)
}

/// The page of predictions next to measurements.
pub fn measured(comparison: &MeasuredComparison, units: Units) -> String {
    measured::page(comparison).html(units)
}

/// The page of a wrapping test, with these charts.
pub fn measurement(result: &MeasurementResult, charts: &[figures::Chart], units: Units) -> String {
    measurement::page(result, charts).html(units)
}

/// The report of a comparison. `identity` identifies the files compared; the report includes the changes over common
/// draws, if any, and a sound for each design that has one.
pub fn comparison(
    comparison: &Comparison,
    paired: &[PairedStudy],
    identity: &str,
    recordings: &[Recording],
    units: Units,
) -> String {
    compared::page(comparison, paired, (identity, units), recordings).html(units)
}

/// The declaration sheet of a finished result as a page, for a use of the tool.
pub fn declaration(of: &declaration::Finished, usage: declaration::Use, units: Units) -> String {
    sheet::page(of, usage).html(units)
}

/// The declaration sheet of a finished result as a document of a word processor, for a use of the tool.
///
/// # Errors
/// [`Error::Document`].
pub fn declaration_document(
    of: &declaration::Finished,
    usage: declaration::Use,
    units: Units,
) -> Result<Vec<u8>, Error> {
    sheet::document(of, usage, units).map_err(Error::Document)
}

fn ranking(result: &RunResult) -> Markup {
    html! {
        (table::markup(&run_tables::ranking(result)))
        @if let Some(range) = result.range() {
            p.quiet {
                "Levels in dB re 1 pW s over the one-third-octave bands " (range) ", the same for all sources. "
                a href="#methods" { "Methods" } " says how each was computed, of which parts it consists, and what \
                    limits it."
            }
        }
        (declared::section(result))
        ul.notes { @for note in &result.notes { li { (typography::with_code(&typography::capitalised(note))) } } }
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
            tr { th { "computed in" } td { (format!("{total:.1} s"))
                @if !stages.is_empty() { ": " (stages.join(", ")) } } }
            tr { th { "physics after" } td {
                "Z. Nili Ahmadabadi, " i { "Noise source identification and dynamic modeling of a pneumatic nailing \
                    device" }
                " (\u{c9}TS Montr\u{e9}al, 2016), with corrections that close mass, energy and momentum"
            } }
        }
    }
}

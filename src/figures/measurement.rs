//! Charts of a wrapping test: levels with uncertainty, bands as recorded and corrected, intervals, and signals with
//! markers.

use super::chart::{Axis, Chart, Event, Panel, Series, Shape, symbol};
use super::levels::{SHOWN, in_palette};
use super::palette::BLACK;
use crate::measurement::lines::BEFORE;
use crate::measurement::markers::{MARKERS, STANDARD_GRAVITY};
use crate::measurement::processing::Measured;
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::{MeasuredBand, MeasurementResult};
use crate::measurement::wrapping::Configuration;

/// End of the time axis of the signals \[ms\].
const SHOWN_MS: f64 = 160.0;

/// Charts of a test.
pub fn measurement(measured: &Measured) -> Vec<Chart> {
    let result = &measured.result;
    let mut charts = vec![levels(result), bands(result)];
    charts.extend(intervals(result));
    charts.extend(signals(measured));
    charts
}

fn chart(result: &MeasurementResult, name: &str, title: &'static str, caption: &str, panels: Vec<Panel>) -> Chart {
    Chart {
        name: name.to_owned(),
        title,
        subject: result.manifest.clone(),
        caption: caption.to_owned(),
        panels,
        events: Vec::new(),
    }
}

fn levels(result: &MeasurementResult) -> Chart {
    let recorded = result
        .configurations
        .iter()
        .map(|own| (own.name.clone(), own.level.as_ref()));
    let sources = result
        .sources
        .iter()
        .map(|own| (own.source.clone(), own.level.as_ref()));
    let bound = result.bound.iter().map(|own| ("bound".to_owned(), own.level.as_ref()));
    let rows: Vec<(String, Option<&RepeatedLevel>)> = recorded.chain(sources).chain(bound).collect();
    let ends = |level: Option<&RepeatedLevel>, sign: f64| level.map_or(f64::NAN, |own| own.db + sign * own.expanded_db);
    let note = |level: Option<&RepeatedLevel>| {
        level.map_or_else(String::new, |own| format!("{:.1} ± {:.1} dB", own.db, own.expanded_db))
    };
    let series = Series {
        shape: Shape::Whiskers(
            rows.iter()
                .map(|(_, level)| [ends(*level, -1.0), ends(*level, 1.0)])
                .collect(),
        ),
        notes: rows.iter().map(|(_, level)| note(*level)).collect(),
        ..Series::over(
            "",
            BLACK,
            Shape::Line,
            rows.iter().map(|(_, level)| level.map(|own| own.db)),
        )
    };
    let upper = rows.iter().map(|(_, level)| level.map(|own| own.db + own.expanded_db));
    let panel = Panel {
        x: Axis::categories(
            "Configuration, source, bound of the workpiece",
            "",
            rows.iter().map(|row| row.0.clone()).collect(),
        ),
        y: Axis::levels("L_{WA,1s}", "dB", SHOWN, &[Series::over("", 0, Shape::Line, upper)]),
        height: 62,
        series: vec![series],
    };
    chart(
        result,
        "measured-levels",
        "Measured levels",
        "A-weighted single-event sound power levels, dB re 1 pW s, with the expanded uncertainty (k = 2) of repeats \
         and method.",
        vec![panel],
    )
}

fn steps<'a>(name: &str, colour: usize, bands: impl IntoIterator<Item = &'a MeasuredBand>) -> Series {
    Series::over(name, colour, Shape::Steps, bands.into_iter().map(|band| band.lwa_db))
}

fn bands(result: &MeasurementResult) -> Chart {
    let hz: Vec<f64> = result
        .configurations
        .first()
        .map_or_else(Vec::new, |own| own.bands.iter().map(|band| band.hz).collect());
    let octave = |place: &usize| (10.0 * (hz[*place] / 1000.0).log10()).round() as i32 % 3 == 0;
    let panel = |label: &str, series: Vec<Series>| Panel {
        x: Axis {
            ticks: (0..hz.len()).filter(octave).collect(),
            ..Axis::categories("Mid-band frequency", "Hz", hz.iter().map(f64::to_string).collect())
        },
        y: Axis::levels(label, "dB", SHOWN, &series),
        height: 62,
        series,
    };
    let recorded = result
        .configurations
        .iter()
        .enumerate()
        .map(|(place, own)| steps(&own.name, place, &own.bands));
    let sources = result.sources.iter().enumerate().map(|(place, own)| {
        let colour = in_palette(&own.source, place);
        steps(&own.source, colour, &own.bands)
    });
    let bound = result
        .bound
        .iter()
        .map(|own| steps("bound of the workpiece", BLACK, &own.bands));
    let panels = vec![
        panel("L_{WA,1s} as recorded", recorded.collect()),
        panel("L_{WA,1s} less residual", sources.chain(bound).collect()),
    ];
    chart(
        result,
        "measured-bands",
        "Measured bands",
        "A-weighted one-third-octave levels, dB re 1 pW s: the configurations as recorded, and the sources after \
         subtraction of the \
         residual.",
        panels,
    )
}

/// Levels of the sources between the markers of their configurations.
fn intervals(result: &MeasurementResult) -> Option<Chart> {
    let mut names: Vec<(String, f64)> = Vec::new();
    for own in result.sources.iter().flat_map(|source| &source.intervals) {
        let name = format!("{} - {}", symbol(&own.from), symbol(&own.to));
        if !names.iter().any(|(known, _)| *known == name) {
            names.push((name, own.seconds[0]));
        }
    }
    if names.is_empty() {
        return None;
    }
    names.sort_by(|a, b| a.1.total_cmp(&b.1));
    let bars = |(place, source): (usize, &crate::measurement::result::MeasuredSource)| {
        let level = |(name, _): &(String, f64)| {
            let mut all = source.intervals.iter();
            all.find(|own| format!("{} - {}", symbol(&own.from), symbol(&own.to)) == *name)?
                .lwa_db
        };
        Series::over(
            &source.source,
            in_palette(&source.source, place),
            Shape::Bars(Vec::new()),
            names.iter().map(level),
        )
    };
    let series: Vec<Series> = result.sources.iter().enumerate().map(bars).collect();
    let panel = Panel {
        x: Axis::categories(
            "Markers on either side",
            "",
            names.iter().map(|own| own.0.clone()).collect(),
        ),
        y: Axis::levels("L_{WA,1s}", "dB", SHOWN, &series),
        height: 62,
        series,
    };
    Some(chart(
        result,
        "measured-intervals",
        "Level between markers",
        "A-weighted levels of the corrected signals cut at both markers, dB re 1 pW s. Edges are good to 1.5 ms.",
        vec![panel],
    ))
}

/// Signals of the first shot of the total (otherwise of the first configuration), with its markers.
fn signals(measured: &Measured) -> Option<Chart> {
    let total = |own: &&crate::measurement::processing::ShotSignals| own.configuration == Configuration::Total;
    let shown = measured
        .signals
        .iter()
        .find(total)
        .or_else(|| measured.signals.first())?;
    let time: Vec<f64> = (0..shown.microphone.len())
        .map(|n| 1e3 * (n as f64 / shown.rate - BEFORE))
        .take_while(|at| *at < SHOWN_MS)
        .collect();
    let axis = || Axis::new("Time from the trigger on", "ms", [-1e3 * BEFORE, SHOWN_MS]);
    let panel = |label: &str, unit: &'static str, lines: Vec<(String, Vec<f64>)>| {
        let line = |(place, (name, values)): (usize, &(String, Vec<f64>))| Series::line(name, place, &time, values);
        let series: Vec<Series> = lines.iter().enumerate().map(line).collect();
        Panel {
            x: axis(),
            y: Axis::around(label, unit, &series),
            height: 40,
            series,
        }
    };
    let scaled = |values: &[f64], factor: f64| values.iter().take(time.len()).map(|x| factor * x).collect::<Vec<f64>>();
    let mut panels = vec![panel(
        "Sound pressure",
        "Pa",
        vec![("microphone 1".to_owned(), scaled(&shown.microphone, 1.0))],
    )];
    let acceleration = |(name, values): (&String, &Vec<f64>)| (name.clone(), scaled(values, 1.0 / STANDARD_GRAVITY));
    let names = &measured.accelerometers;
    if !shown.accelerations.is_empty() {
        panels.push(panel(
            "Acceleration",
            "g",
            names.iter().zip(&shown.accelerations).map(acceleration).collect(),
        ));
    }
    if !shown.pressures.is_empty() {
        let pressure = |(name, values): (&String, &Vec<f64>)| (name.clone(), scaled(values, 1e-3));
        let names = &measured.transducers;
        panels.push(panel(
            "Pressure",
            "kPa",
            names.iter().zip(&shown.pressures).map(pressure).collect(),
        ));
    }
    let meaning = |name: &str| {
        MARKERS
            .iter()
            .find(|own| own.name == name)
            .map_or("", |own| own.meaning)
    };
    let mut chart = chart(
        &measured.result,
        "measured-signals",
        "Signals and markers",
        "The first shot with nothing wrapped: sound pressure at microphone 1, accelerations and pressures over time, \
         with the markers \
         that were found.",
        panels,
    );
    chart.events = shown
        .markers
        .found()
        .into_iter()
        .map(|(name, at)| Event {
            at: 1e3 * at,
            symbol: symbol(name),
            name: meaning(name).to_owned(),
        })
        .collect();
    Some(chart)
}

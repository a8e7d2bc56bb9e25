//! Charts of levels: third-octave bands of the sources and of parts of a source, intervals between events, power over
//! time.

use nailnoise_acoustics::signals::{energy_level, level_energy};

use super::chart::{Axis, Chart, Panel, Series, Shape, events, symbol};
use super::palette::BLACK;
use crate::model::sources::{ALL, by_name};
use crate::result::{BandLevel, BodyBands, IntervalLevel, RunResult};
use crate::stages::cycle::{EventWords, ShotRecord};
use crate::stages::ranking::SoundPower;

/// Range of levels shown below the highest \[dB\].
pub(crate) const SHOWN: f64 = 60.0;

/// Index of a source in the palette, the same in every chart; sources without a fixed colour take the remaining ones in
/// turn.
pub(crate) fn in_palette(source: &str, place: usize) -> usize {
    by_name(source).map_or(3 + place % 3, |source| source.colour())
}

/// The charts of a result's levels: `bands` of each source, a chart of the parts of each source that has parts, named
/// after the source, and `intervals` between events. `subject` names the design.
pub fn levels(subject: &str, result: &RunResult) -> Vec<Chart> {
    let chart = |name: &str, title, caption: &str, panels| Chart {
        name: name.to_owned(),
        title,
        subject: subject.to_owned(),
        caption: caption.to_owned(),
        panels,
        events: Vec::new(),
    };
    let weighted = |band: &BandLevel| band.lwa_db;
    let mut charts = vec![chart(
        "bands",
        "Level of each source",
        "One-third-octave levels of each source, A-weighted and unweighted, dB re 1 pW s.",
        vec![
            bands("L_{WA,1s} per 1/3 octave", result, sources(result, weighted)),
            bands("L_{W,1s} per 1/3 octave", result, sources(result, |band| band.lw_db)),
        ],
    )];
    let ranked = |name: &str| result.ranking.iter().find(|ranked| ranked.source == name);
    let with_parts = ALL
        .into_iter()
        .filter_map(|own| Some((own.chart_of_parts()?, ranked(own.name())?)));
    for (title, source) in with_parts {
        let parts = source.components.iter().enumerate();
        let audible = parts.filter(|(_, part)| part.lwa_db.is_some());
        let steps = |name: &str, colour, bands: &[BandLevel]| {
            Series::over(name, colour, Shape::Steps, bands.iter().map(weighted))
        };
        let mut series: Vec<Series> = audible
            .map(|(place, part)| steps(&part.name, place % BLACK, &part.bands))
            .collect();
        series.push(steps(&source.source, BLACK, &source.bands));
        charts.push(chart(
            &source.source,
            title,
            &format!(
                "A-weighted one-third-octave levels of the parts of the {}, dB re 1 pW s.",
                source.source
            ),
            vec![bands("L_{WA,1s} per 1/3 octave", result, series)],
        ));
    }
    charts.push(chart(
        "intervals",
        "Level between events",
        "A-weighted levels of the energy radiated from each event to the next, dB re 1 pW s; lines across the bars: \
         levels of \
         the signal cut at both events, as a measurement finds them. The energies of a source's intervals sum to its \
         total.",
        vec![intervals(result)],
    ));
    charts
}

/// Reference of velocity levels, 1 nm/s \[m/s\] (ISO 1683).
const REFERENCE_VELOCITY: f64 = 1e-9;

/// Chart of the velocity level of each elastic body by third octaves; `None` if all bodies are rigid.
pub(crate) fn motion(subject: &str, result: &RunResult) -> Option<Chart> {
    let shown = result.ranking.first()?.bands.len();
    let level = |velocity: f64| (velocity > 0.0).then(|| 20.0 * (velocity / REFERENCE_VELOCITY).log10());
    let body = |(place, own): (usize, &BodyBands)| {
        let levels = own.bands.iter().take(shown).map(|band| level(band.rms_velocity_m_s));
        Series::over(&own.body, in_palette(&own.body, place), Shape::Steps, levels)
    };
    let series: Vec<Series> = result.motion.iter().enumerate().map(body).collect();
    (!series.is_empty()).then(|| Chart {
        name: "velocities".to_owned(),
        title: "Motion of the bodies",
        subject: subject.to_owned(),
        caption: "One-third-octave levels of the normal velocity of each elastic body, RMS over its outer surface and \
                  1 s, dB re 1 nm/s. Values: motion.csv."
            .to_owned(),
        panels: vec![bands("L_v per 1/3 octave", result, series)],
        events: Vec::new(),
    })
}

/// A panel of one-third-octave bands with one tick per octave.
fn bands(label: &str, result: &RunResult, series: Vec<Series>) -> Panel {
    let bands = result.ranking.first().map_or(&[][..], |source| &source.bands);
    let octave = |place: &usize| (10.0 * (bands[*place].hz / 1000.0).log10()).round() as i32 % 3 == 0;
    let names = bands.iter().map(|band| band.hz.to_string()).collect();
    Panel {
        x: Axis {
            ticks: (0..bands.len()).filter(octave).collect(),
            ..Axis::categories("Mid-band frequency", "Hz", names)
        },
        y: Axis::levels(label, "dB", SHOWN, &series),
        height: 62,
        series,
    }
}

/// A level of each source in each band, and their energetic sum.
fn sources(result: &RunResult, level: fn(&BandLevel) -> Option<f64>) -> Vec<Series> {
    let bands = result.ranking.first().map_or(0, |source| source.bands.len());
    let sum = |band: usize| {
        let levels = result.ranking.iter().filter_map(|source| source.bands.get(band));
        energy_level(levels.map(|band| level_energy(level(band))).sum())
    };
    let own = result.ranking.iter().enumerate().map(|(place, source)| {
        let levels = source.bands.iter().map(level);
        Series::over(&source.source, in_palette(&source.source, place), Shape::Steps, levels)
    });
    own.chain([Series::over("total", BLACK, Shape::Steps, (0..bands).map(sum))])
        .collect()
}

/// Bars show the energy radiated in an interval. Empty intervals are omitted.
fn intervals(result: &RunResult) -> Panel {
    let lasting = |interval: &&IntervalLevel| interval.to_s > interval.from_s;
    let of = |intervals: &[IntervalLevel], value: &dyn Fn(&IntervalLevel) -> Option<f64>| -> Vec<Option<f64>> {
        intervals.iter().filter(lasting).map(value).collect()
    };
    let note = |interval: &IntervalLevel| {
        let level = interval
            .lwa_db
            .map_or_else(|| "silent".to_owned(), |db| format!("{db:.1} dB"));
        format!("{level} in {:.2} ms", 1e3 * (interval.to_s - interval.from_s))
    };
    let bars = |(place, source): (usize, &crate::result::RankedSource)| {
        let cut = of(&source.intervals, &|interval| interval.lwa_cut_db);
        let marks = Shape::Bars(cut.into_iter().map(|level| level.unwrap_or(f64::NAN)).collect());
        let levels = of(&source.intervals, &|interval| interval.lwa_db);
        Series {
            notes: source.intervals.iter().filter(lasting).map(note).collect(),
            ..Series::over(&source.source, in_palette(&source.source, place), marks, levels)
        }
    };
    let series: Vec<Series> = result.ranking.iter().enumerate().map(bars).collect();
    let first = result.ranking.first().map_or(&[][..], |source| &source.intervals);
    let names: Vec<String> = first
        .iter()
        .filter(lasting)
        .map(|own| from_event(&own.from, &result.event_words))
        .collect();
    Panel {
        x: Axis::levels("L_{WA,1s} in the interval", "dB", SHOWN, &series),
        height: 6 * names.len() as u32,
        y: Axis::categories("From this event to the next", "", names),
        series: series.into_iter().map(Series::sideways).collect(),
    }
}

/// The event at the start of an interval, by symbol and name.
pub(crate) fn from_event(name: &str, words: &EventWords) -> String {
    match words.of_event(name) {
        Some(words) if symbol(name) != name => format!("{} {words}", symbol(name)),
        Some(words) => words.to_owned(),
        None if matches!(name, "start" | "end") => format!("{name} of the record"),
        None => name.replace('_', " "),
    }
}

/// A-weighted sound power of every source over time. `subject` names the design.
pub fn power(subject: &str, record: &ShotRecord, powers: &[SoundPower]) -> Chart {
    let curve = |(place, power): (usize, &SoundPower)| {
        let history = &power.history;
        let time = |cell: usize| 1e3 * (history.start + cell as f64 * history.sample_interval);
        let times: Vec<f64> = (0..history.power.len()).map(time).collect();
        // The level of a power re 1 pW is that of its energy in 1 s re 1 pW s.
        let level = |watts: &f64| energy_level(*watts).unwrap_or(f64::NAN);
        let levels: Vec<f64> = history.power.iter().map(level).collect();
        Series::line(&power.source, in_palette(&power.source, place), &times, &levels)
    };
    let series: Vec<Series> = powers.iter().enumerate().map(curve).collect();
    let levels = Axis::levels("A-weighted sound power level", "dB re 1 pW", SHOWN, &series);
    // Up to the last level shown, which is after the end of the cycle if a body rings on.
    let shown = series.iter().flat_map(|own| own.x.iter().zip(&own.y));
    let shown = shown.filter(|(_, level)| **level >= levels.range[0]);
    let end = shown.map(|(time, _)| *time).fold(1.0, f64::max);
    Chart {
        name: "power".to_owned(),
        title: "Sound power over time",
        subject: subject.to_owned(),
        caption: "A-weighted sound power of each source over the shot, means over 0.1 ms.".to_owned(),
        panels: vec![Panel {
            x: Axis::new("Time from the trigger", "ms", [0.0, end]),
            y: levels,
            height: 88,
            series,
        }],
        events: events(&record.events),
    }
}

//! Charts of the levels: sources, bands, intervals, power over time.

use nailnoise_acoustics::levels::level_energy;
use nailnoise_dynamics::Events;
use serde_json::{Value, json};

use super::chart::{Chart, colour, curve, decibel, ink};
use super::cycle::event_marks;
use crate::result::{RankedSource, RunResult};
use crate::stages::ranking::SoundPower;

/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 50.0;

/// The range of an axis of levels whose highest is `highest`.
pub(super) fn range(highest: f64, shown: f64) -> Value {
    let top = 5.0 * ((highest + 2.0) / 5.0).ceil();
    json!([top - shown, top])
}

/// The highest of some levels; 0 where all are silent.
pub(super) fn highest(levels: impl Iterator<Item = Option<f64>>) -> f64 {
    levels.flatten().reduce(f64::max).unwrap_or(0.0)
}

/// Bands of all sources, A-weighted and unweighted by a switch.
pub(super) fn bands(result: &RunResult) -> Chart {
    let labels: Vec<String> = result.ranking.first().map_or_else(Vec::new, |source| {
        source.bands.iter().map(|band| band.hz.to_string()).collect()
    });
    let of = |source: &RankedSource, weighted: bool| -> Vec<Option<f64>> {
        let level = |band: &crate::result::BandLevel| if weighted { band.lwa_db } else { band.lw_db };
        source.bands.iter().map(level).collect()
    };
    let mut data = Vec::new();
    for weighted in [true, false] {
        let mut sums = vec![0.0; labels.len()];
        for (place, source) in result.ranking.iter().enumerate() {
            let levels = of(source, weighted);
            sums.iter_mut()
                .zip(&levels)
                .for_each(|(sum, level)| *sum += level_energy(*level));
            let values: Vec<Value> = levels.into_iter().map(decibel).collect();
            data.push(json!({
                "type": "scatter", "mode": "lines+markers", "name": source.source, "x": labels, "y": values,
                "line": { "color": colour(&source.source, place), "shape": "hvh", "width": 2 },
                "marker": { "size": 5 }, "visible": weighted,
            }));
        }
        let total: Vec<Value> = sums
            .iter()
            .map(|&sum| decibel((sum > 0.0).then(|| 10.0 * (sum / 1e-12).log10())))
            .collect();
        data.push(json!({
            "type": "scatter", "mode": "lines", "name": "total", "x": labels, "y": total, "visible": weighted,
            "line": { "color": ink(6), "shape": "hvh", "width": 1.2, "dash": "dot" },
        }));
    }
    let count = result.ranking.len() + 1;
    let shown = |weighted: bool| -> Vec<bool> { (0..2 * count).map(|i| (i < count) == weighted).collect() };
    let top = |weighted| highest(result.ranking.iter().flat_map(|source| of(source, weighted)));
    let button = |label: &str, title: &str, weighted: bool| {
        json!({
            "label": label, "method": "update",
            "args": [
                { "visible": shown(weighted) },
                { "yaxis.title.text": title, "yaxis.range": range(top(weighted), SHOWN) },
            ],
        })
    };
    let (weighted, plain) = ("L<sub>WA,1s</sub> (dB)", "L<sub>W,1s</sub> (dB)");
    Chart {
        id: "bands".to_owned(),
        caption:
            "One-third-octave levels of each source, dB re 1 pW s. The buttons choose A-weighted or unweighted; a \
                  click on a name hides it."
                .to_owned(),
        data,
        layout: json!({
            "xaxis": { "type": "category", "title": { "text": "Mid-band frequency (Hz)" } },
            "yaxis": { "title": { "text": weighted }, "range": range(top(true), SHOWN) },
            "hovermode": "x unified",
            "updatemenus": [{
                "type": "buttons", "direction": "right", "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom",
                "showactive": true, "buttons": [button("A-weighted", weighted, true), button("unweighted", plain, false)],
            }],
        }),
        height: 420,
        group: "",
    }
}

/// Levels between neighbouring events.
pub(super) fn intervals(result: &RunResult) -> Chart {
    let labels: Vec<String> = result.ranking.first().map_or_else(Vec::new, |source| {
        let label = |interval: &crate::result::IntervalLevel| format!("{}\u{2013}{}", interval.from, interval.to);
        source.intervals.iter().map(label).collect()
    });
    let top = highest(result.ranking.iter().flat_map(|s| s.intervals.iter().map(|i| i.lwa_db)));
    let scale = range(top, SHOWN);
    let floor = scale[0].as_f64().unwrap_or(0.0);
    let data = result.ranking.iter().enumerate().map(|(place, source)| {
        // Bars stand on the lower edge of the axis: a level has no zero of its own.
        let above = source
            .intervals
            .iter()
            .map(|i| decibel(i.lwa_db.map(|level| level - floor).filter(|height| *height > 0.0)));
        let levels = source.intervals.iter().map(|interval| {
            let width = 1e3 * (interval.to_s - interval.from_s);
            let level = interval
                .lwa_db
                .map_or_else(|| "silent".to_owned(), |db| format!("{db:.1} dB"));
            format!("{level}, {width:.2} ms")
        });
        json!({
            "type": "bar", "name": source.source, "x": labels, "base": floor,
            "y": above.collect::<Vec<_>>(), "customdata": levels.collect::<Vec<_>>(),
            "hovertemplate": "%{x}: %{customdata}", "marker": { "color": colour(&source.source, place) },
        })
    });
    Chart {
        id: "intervals".to_owned(),
        caption:
            "Which event makes which noise: A-weighted levels of the energy radiated between neighbouring events, \
                  dB re 1 pW s. The energies of a source's intervals sum to its total."
                .to_owned(),
        data: data.collect(),
        layout: json!({
            "barmode": "group",
            "xaxis": { "type": "category", "title": { "text": "Interval between events" }, "tickangle": -45 },
            "yaxis": { "title": { "text": "L<sub>WA,1s</sub> (dB)" }, "range": scale },
        }),
        height: 380,
        group: "",
    }
}

/// A-weighted sound power over time.
pub(super) fn power(powers: &[SoundPower], events: &Events) -> Chart {
    let mut top = f64::NEG_INFINITY;
    let mut curves = Vec::new();
    for (place, power) in powers.iter().enumerate() {
        let history = &power.history;
        let time: Vec<f64> = (0..history.power.len())
            .map(|cell| 1e3 * (history.start + cell as f64 * history.sample_interval))
            .collect();
        let level = |watts: &f64| {
            if *watts > 0.0 {
                10.0 * (watts / 1e-12).log10()
            } else {
                f64::NAN
            }
        };
        let levels: Vec<f64> = history.power.iter().map(level).collect();
        top = levels.iter().copied().fold(top, f64::max);
        curves.push(curve(&power.source, colour(&power.source, place), &time, &levels));
    }
    let mut layout = json!({
        "xaxis": { "title": { "text": "Time from the trigger (ms)" } },
        "yaxis": { "title": { "text": "L<sub>WA</sub>(t) (dB re 1 pW)" }, "range": range(if top.is_finite() { top } else { 0.0 }, 60.0) },
    });
    event_marks(&mut layout, events);
    Chart {
        id: "power".to_owned(),
        caption: "A-weighted sound power of each source over the shot, means over 0.1 ms.".to_owned(),
        data: curves,
        layout,
        height: 360,
        group: "time",
    }
}

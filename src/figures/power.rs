//! A-weighted sound power of every source over time.

use super::decibels::colour;
use super::sheet::{Curve, Panel};
use super::{Figure, Shot};
use crate::stages::ranking::SoundPower;

/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 60.0;

/// Reference power \[W\].
const REFERENCE: f64 = 1e-12;

pub(super) fn figure(shot: &Shot<'_>, powers: &[SoundPower]) -> Figure {
    let time = |power: &SoundPower| -> Vec<f64> {
        let history = &power.history;
        (0..history.power.len())
            .map(|cell| 1e3 * (history.start + cell as f64 * history.sample_interval))
            .collect()
    };
    let times: Vec<Vec<f64>> = powers.iter().map(time).collect();
    let level = |watts: &f64| {
        if *watts > 0.0 {
            10.0 * (watts / REFERENCE).log10()
        } else {
            f64::NEG_INFINITY
        }
    };
    let histories = powers
        .iter()
        .map(|power| power.history.power.iter().map(level).collect());
    let levels: Vec<Vec<f64>> = histories.collect();
    let highest = levels.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let highest = if highest.is_finite() { highest } else { 0.0 };
    let end = 5.0 * ((highest + 1.0) / 5.0).ceil();
    let curves = powers
        .iter()
        .zip(&times)
        .zip(levels)
        .enumerate()
        .map(|(place, ((power, x), y))| Curve {
            label: power.source.clone(),
            colour: colour(&power.source, place),
            x,
            y: y.into_iter()
                .map(|level| if level > end - SHOWN { level } else { f64::NAN })
                .collect(),
            band: Vec::new(),
        })
        .collect();
    let panel = Panel {
        y_label: "A-weighted sound power level (dB re 1 pW)",
        y_range: [end - SHOWN, end],
        height: 88,
        curves,
        levels: Vec::new(),
        spans: Vec::new(),
    };
    Figure {
        name: "power",
        svg: shot.sheet("Sound power over time", vec![panel]).svg(),
    }
}

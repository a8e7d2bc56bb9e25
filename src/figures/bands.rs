//! Third-octave levels of every source, and of the exhaust's parts.

use plotters::style::RGBColor;

use super::Figure;
use super::canvas::{Anchor, Canvas, draw};
use super::decibels::{HEADING, LEGEND, LevelPanel, entries, heading, legend};
use super::style::*;
use crate::result::{BandLevel, RunResult};

/// Height of a panel.
const PANEL: i32 = 62 * MM;
/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 60.0;
/// Room for the numbers and the label of the horizontal axis.
const FOOT: i32 = 12 * MM;

/// A staircase over the bands.
struct Steps {
    name: String,
    colour: RGBColor,
    levels: Vec<Option<f64>>,
}

/// "1/3-octave level per source": unweighted above, A-weighted below.
pub(super) fn sources(subject: &str, result: &RunResult) -> Figure {
    let of = |level: fn(&BandLevel) -> Option<f64>| -> Vec<Steps> {
        let mut steps: Vec<Steps> = entries(result)
            .into_iter()
            .zip(&result.ranking)
            .map(|((name, colour), source)| Steps {
                name,
                colour,
                levels: source.bands.iter().map(level).collect(),
            })
            .collect();
        steps.push(total(&steps));
        steps
    };
    let panels = [
        ("L_W,1s per 1/3 octave (dB)", of(|band| band.lw_db)),
        ("L_WA,1s per 1/3 octave (dB)", of(|band| band.lwa_db)),
    ];
    page("bands", "Level of each source", subject, &frequencies(result), &panels)
}

/// The parts of the exhaust, A-weighted; nothing where the exhaust is silent.
pub(super) fn exhaust(subject: &str, result: &RunResult) -> Option<Figure> {
    let exhaust = result.ranking.iter().find(|source| source.source == "exhaust")?;
    let mut steps: Vec<Steps> = exhaust
        .components
        .iter()
        .enumerate()
        .filter(|(_, part)| part.lwa_db.is_some())
        .map(|(place, part)| Steps {
            name: part.name.clone(),
            colour: PALETTE[place % 6],
            levels: part.bands.iter().map(|band| band.lwa_db).collect(),
        })
        .collect();
    steps.push(Steps {
        name: "exhaust".to_owned(),
        colour: PALETTE[6],
        levels: exhaust.bands.iter().map(|band| band.lwa_db).collect(),
    });
    let panels = [("L_WA,1s per 1/3 octave (dB)", steps)];
    Some(page(
        "exhaust",
        "Parts of the exhaust",
        subject,
        &frequencies(result),
        &panels,
    ))
}

fn frequencies(result: &RunResult) -> Vec<f64> {
    let bands = result.ranking.first().map(|source| &source.bands);
    bands.map_or_else(Vec::new, |bands| bands.iter().map(|band| band.hz).collect())
}

/// The energy sum of all sources.
fn total(steps: &[Steps]) -> Steps {
    let bands = steps.iter().map(|step| step.levels.len()).max().unwrap_or(0);
    let sum = |band: usize| {
        let energies = steps.iter().filter_map(|step| step.levels.get(band).copied().flatten());
        let energy: f64 = energies.map(|level| 10f64.powf(0.1 * level)).sum();
        (energy > 0.0).then(|| 10.0 * energy.log10())
    };
    Steps {
        name: "total".to_owned(),
        colour: PALETTE[6],
        levels: (0..bands).map(sum).collect(),
    }
}

fn page(
    name: &'static str,
    title: &str,
    subject: &str,
    frequencies: &[f64],
    panels: &[(&'static str, Vec<Steps>)],
) -> Figure {
    let height = HEADING + panels.len() as i32 * (LEGEND + PANEL) + FOOT;
    let svg = draw(height, |canvas| {
        heading(canvas, title, subject);
        let mut top = HEADING;
        for (index, (label, steps)) in panels.iter().enumerate() {
            if panels.len() > 1 {
                let letter = char::from(b'a' + index as u8).to_string();
                canvas.bold(&letter, [3 * MM, top + 4 * MM], Anchor::Start, INK);
            }
            let names: Vec<(String, RGBColor)> = steps.iter().map(|step| (step.name.clone(), step.colour)).collect();
            legend(canvas, &names, top + 4 * MM, false);
            let frame = [top + LEGEND, top + LEGEND + PANEL];
            paint(canvas, label, frame, frequencies, steps, index + 1 == panels.len());
            top += LEGEND + PANEL;
        }
        let middle = (LEFT + RIGHT) / 2;
        canvas.text("Mid-band frequency (Hz)", [middle, top + 8 * MM], Anchor::Middle, INK);
    });
    Figure { name, svg }
}

fn paint(
    canvas: &mut Canvas<'_>,
    label: &'static str,
    frame: [i32; 2],
    frequencies: &[f64],
    steps: &[Steps],
    numbered: bool,
) {
    let levels = steps.iter().flat_map(|step| step.levels.iter().copied().flatten());
    let panel = LevelPanel::new(label, frame, levels, SHOWN);
    panel.grid(canvas);
    let bands = frequencies.len().max(1);
    let edge = |band: usize| LEFT + ((RIGHT - LEFT) as f64 * band as f64 / bands as f64).round() as i32;
    // 31.5, 63, 125 Hz ...: one label an octave, under the middle of its band.
    for (band, hz) in frequencies.iter().enumerate() {
        let octave = (10.0 * (hz / 1000.0).log10()).round() as i32 % 3 == 0;
        let at = (edge(band) + edge(band + 1)) / 2;
        if octave {
            canvas.path([[at, panel.foot()], [at, panel.foot() + TICK]], INK, FRAME);
            if numbered {
                canvas.text(&format!("{hz}"), [at, panel.foot() + 3 * MM], Anchor::Middle, INK);
            }
        }
    }
    for step in steps.iter().rev() {
        let mut line: Vec<[i32; 2]> = Vec::new();
        for band in 0..=step.levels.len() {
            match step.levels.get(band).copied().flatten() {
                Some(level) => line.extend([[edge(band), panel.at(level)], [edge(band + 1), panel.at(level)]]),
                None if line.is_empty() => {}
                None => canvas.path(std::mem::take(&mut line), step.colour, CURVE),
            }
        }
    }
    panel.frame(canvas);
}

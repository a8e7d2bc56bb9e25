//! What figures of levels share: a vertical axis in dB, a legend, and one colour a source.

use plotters::style::RGBColor;

use super::canvas::{Anchor, Canvas};
use super::scale::{Scale, ticks};
use super::style::*;
use crate::result::RunResult;

/// Height of the heading.
pub(super) const HEADING: i32 = 7 * MM;
/// Room over a panel for its legend.
pub(super) const LEGEND: i32 = 8 * MM;
/// Length of a legend's sample, and its distances from its text and of entries from each other.
const SAMPLE: i32 = 6 * MM;
const SAMPLE_GAP: i32 = MM + MM / 2;
const ENTRY_GAP: i32 = 5 * MM;

/// Place of a source in the palette, the same in every figure and report; what has none of its own takes the others in
/// turn.
pub(crate) fn in_palette(source: &str, place: usize) -> usize {
    match source {
        "workpiece" => 0,
        "exhaust" => 1,
        "body" => 2,
        "total" => 6,
        _ => 3 + place % 3,
    }
}

/// Colour of a source.
pub(super) fn colour(source: &str, place: usize) -> RGBColor {
    PALETTE[in_palette(source, place)]
}

/// Names and colours of a result's sources, in the order of the ranking.
pub(super) fn entries(result: &RunResult) -> Vec<(String, RGBColor)> {
    let entry =
        |(place, source): (usize, &crate::result::RankedSource)| (source.source.clone(), colour(&source.source, place));
    result.ranking.iter().enumerate().map(entry).collect()
}

/// A panel with levels upwards.
pub(super) struct LevelPanel {
    y: Scale,
    label: &'static str,
}

impl LevelPanel {
    /// A panel between `top` and `bottom` of the page that shows `shown` dB below the highest of the levels.
    pub(super) fn new(
        label: &'static str,
        [top, bottom]: [i32; 2],
        levels: impl Iterator<Item = f64>,
        shown: f64,
    ) -> Self {
        let highest = levels
            .filter(|level| level.is_finite())
            .fold(f64::NEG_INFINITY, f64::max);
        let highest = if highest.is_finite() { highest } else { 0.0 };
        let end = 5.0 * ((highest + 1.0) / 5.0).ceil();
        Self {
            y: Scale {
                values: [end - shown, end],
                units: [bottom, top],
            },
            label,
        }
    }

    /// Grid unit of a level, no lower than the panel's foot.
    pub(super) fn at(&self, level: f64) -> i32 {
        self.y.at(level.max(self.y.values[0]))
    }

    /// The panel's foot.
    pub(super) fn foot(&self) -> i32 {
        self.y.units[0]
    }

    /// Grid, ticks and label; to be drawn before what the panel shows.
    pub(super) fn grid(&self, canvas: &mut Canvas<'_>) {
        let (round, decimals) = ticks(self.y.values, 7);
        for value in &round {
            let at = self.y.at(*value);
            canvas.path([[LEFT, at], [RIGHT, at]], FAINT, HAIR);
            canvas.path([[LEFT - TICK, at], [LEFT, at]], INK, FRAME);
            let text = format!("{value:.decimals$}").replace('-', "\u{2212}");
            canvas.text(&text, [LEFT - TICK - MM / 2, at], Anchor::End, INK);
        }
        let [bottom, top] = self.y.units;
        canvas.upwards(self.label, [5 * MM, (top + bottom) / 2], INK);
    }

    /// The frame; to be drawn last.
    pub(super) fn frame(&self, canvas: &mut Canvas<'_>) {
        let [bottom, top] = self.y.units;
        let corners = [[LEFT, top], [RIGHT, top], [RIGHT, bottom], [LEFT, bottom], [LEFT, top]];
        canvas.path(corners, INK, FRAME);
    }
}

/// Title and subject of a page.
pub(super) fn heading(canvas: &mut Canvas<'_>, title: &str, subject: &str) {
    canvas.bold(title, [LEFT, 4 * MM], Anchor::Start, INK);
    canvas.text(subject, [RIGHT, 4 * MM], Anchor::End, GREY);
}

/// One row of a legend at the height `y`; samples are bars where `solid`, else lines.
pub(super) fn legend(canvas: &mut Canvas<'_>, entries: &[(String, RGBColor)], y: i32, solid: bool) {
    let mut left = LEFT;
    for (name, colour) in entries {
        if solid {
            canvas.rectangle([left, y - MM], [left + SAMPLE, y + MM], *colour, 1.0);
        } else {
            canvas.path([[left, y], [left + SAMPLE, y]], *colour, CURVE);
        }
        let text = left + SAMPLE + SAMPLE_GAP;
        canvas.text(name, [text, y], Anchor::Start, INK);
        left = text + (name.chars().count() as f64 * f64::from(TYPE) * ADVANCE) as i32 + ENTRY_GAP;
    }
}

//! Penetration laws over depth, published ones with a band of one standard error.

use nailnoise_dynamics::prf::{CurveError, PenetrationCurve};

use super::Figure;
use super::sheet::{Curve, Panel, Sheet};
use super::style::PALETTE;

/// Points of a curve.
const POINTS: usize = 400;

/// The most curves a figure shows: as many as there are colours.
pub(crate) const MOST: usize = PALETTE.len();

/// Compares laws over depth; `labels` name them, `subject` says what they share. Laws beyond the eighth are not drawn.
///
/// # Errors
/// As [`PenetrationCurve::force`].
pub fn penetration(subject: &str, laws: &[PenetrationCurve], labels: &[String]) -> Result<Figure, CurveError> {
    let mut axes: Vec<Vec<f64>> = Vec::new();
    let mut ordinates = Vec::new();
    for law in laws.iter().take(MOST) {
        // The force begins with a step at the surface; the first point stands just below it.
        let depth = |i: usize| law.nail.length * (i as f64 / POINTS as f64).max(1e-9);
        let forces: Result<Vec<f64>, _> = (0..=POINTS)
            .map(|i| law.force(depth(i)).map(|force| 1e-3 * force))
            .collect();
        let bands: Result<Vec<_>, _> = (0..=POINTS).map(|i| law.band(depth(i))).collect();
        let bands: Vec<[f64; 2]> = bands?
            .into_iter()
            .flatten()
            .map(|band| band.map(|force| 1e-3 * force))
            .collect();
        axes.push((0..=POINTS).map(|i| 1e3 * depth(i)).collect());
        ordinates.push((forces?, bands));
    }
    let curves: Vec<Curve<'_>> = axes
        .iter()
        .zip(ordinates)
        .zip(labels.iter().zip(PALETTE))
        .map(|((x, (y, band)), (label, colour))| Curve {
            label: label.clone(),
            colour,
            x,
            y,
            band,
        })
        .collect();
    let highest = curves
        .iter()
        .flat_map(|curve| curve.band.iter().map(|band| band[1]).chain(curve.y.iter().copied()))
        .fold(0.0, f64::max);
    let deepest = laws
        .iter()
        .take(MOST)
        .map(|law| 1e3 * law.nail.length)
        .fold(0.0, f64::max);
    let panel = Panel {
        y_label: "Penetration resistance (kN)",
        y_range: [0.0, 1.05 * highest],
        height: 88,
        curves,
        levels: Vec::new(),
        spans: Vec::new(),
    };
    let sheet = Sheet {
        title: "Penetration resistance",
        subject: if laws.iter().any(|law| law.quality().is_some()) {
            format!("{subject}; bands: one standard error")
        } else {
            subject.to_owned()
        },
        x_label: "Depth of the nail's tip (mm)",
        x_range: [0.0, deepest],
        events: Vec::new(),
        panels: vec![panel],
    };
    Ok(Figure {
        name: "penetration",
        svg: sheet.svg(),
    })
}

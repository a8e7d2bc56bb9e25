//! Penetration laws over depth; published laws have a band of one standard error.

use nailnoise_penetration::{CurveError, PenetrationCurve};

use super::PALETTE;
use super::chart::{Axis, Chart, Panel, Series, Shape};

/// Number of points of a curve.
const POINTS: usize = 400;

/// Maximum number of curves in a chart: as many as there are colours.
pub(crate) const MOST: usize = PALETTE.len();

/// Compares laws over depth; `labels` are their names, `subject` is their common subject. Laws beyond the eighth are
/// not drawn.
///
/// # Errors
/// Same as [`PenetrationCurve::force`].
pub fn penetration(subject: &str, laws: &[PenetrationCurve], labels: &[String]) -> Result<Chart, CurveError> {
    let (mut series, mut areas) = (Vec::new(), Vec::new());
    for (colour, (law, label)) in laws.iter().zip(labels).take(MOST).enumerate() {
        // The force starts with a step at the surface; the first point is just below it.
        let depth = |i: usize| law.nail.length * (i as f64 / POINTS as f64).max(1e-9);
        let curve = |values: Vec<f64>, shape: Shape, name: &str| Series {
            x: (0..=POINTS).map(|i| 1e3 * depth(i)).collect(),
            ..Series::over(name, colour, shape, values.into_iter().map(|force| Some(1e-3 * force)))
        };
        let forces = (0..=POINTS)
            .map(|i| law.force(depth(i)))
            .collect::<Result<Vec<f64>, _>>()?;
        let band = (0..=POINTS)
            .map(|i| law.band(depth(i)))
            .collect::<Result<Option<Vec<_>>, _>>()?;
        series.push(curve(forces, Shape::Line, label));
        if let Some(band) = band {
            let (lower, upper) = band.into_iter().map(|[lower, upper]| (1e-3 * lower, upper)).unzip();
            areas.push(curve(upper, Shape::Band(lower), ""));
        }
    }
    let note = if areas.is_empty() {
        ""
    } else {
        "; bands: one standard error"
    };
    series.extend(areas);
    let deepest = laws
        .iter()
        .take(MOST)
        .map(|law| 1e3 * law.nail.length)
        .fold(0.0, f64::max);
    Ok(Chart {
        name: "penetration".to_owned(),
        title: "Penetration resistance",
        subject: format!("{subject}{note}"),
        caption: "Penetration resistance of the wood over the depth of the nail's tip.".to_owned(),
        panels: vec![Panel {
            x: Axis::new("Depth of the nail's tip", "mm", [0.0, deepest]),
            y: Axis::around("Penetration resistance", "kN", &series),
            height: 88,
            series,
        }],
        events: Vec::new(),
    })
}

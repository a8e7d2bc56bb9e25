//! Energy by direction, on a sphere or its upper half.

use super::{BandField, FieldSeries, FieldShape, decibels};
use crate::radiation::sound::{BandSound, Directions};
use crate::signals::Band;
use nalgebra::Point3;

/// Number of rings of the half sphere, and of directions on each: they integrate the far field of a body up to k a =
/// 46.
pub(crate) const SPHERE: [usize; 2] = [24, 96];

/// Radius of the plotted half sphere \[m\].
const DRAWN: f64 = 1.0;

/// Energy over all directions in each band \[J\].
pub(crate) fn sums(found: &BandSound, directions: &Directions) -> Vec<f64> {
    let of_band =
        |column: nalgebra::DVectorView<'_, f64>| column.iter().zip(&directions.weights).map(|(e, w)| e * w).sum();
    found.directivity.column_iter().map(of_band).collect()
}

/// The sphere of directions, or its upper half, around a point.
pub(crate) fn sphere(
    prefix: &str,
    directions: &Directions,
    found: &BandSound,
    bands: &[Band],
    centre: Point3<f64>,
) -> FieldSeries {
    let (around, count) = (directions.around, directions.vectors.len());
    let mut polygons = Vec::new();
    for ring in (0..count - around).step_by(around) {
        for i in 0..around {
            let next = (i + 1) % around;
            polygons.push(vec![ring + i, ring + next, ring + around + next, ring + around + i]);
        }
    }
    polygons.push((count - around..count).collect());
    let whole: f64 = directions.weights.iter().sum();
    let picture = |(number, band): (usize, &Band)| {
        let energy = found.directivity.column(number);
        let mean = energy.iter().zip(&directions.weights).map(|(e, w)| e * w).sum::<f64>() / whole;
        BandField {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![
                (
                    "energy per solid angle [J/sr]".to_owned(),
                    energy.iter().copied().collect(),
                ),
                (
                    "directivity index [dB]".to_owned(),
                    decibels(energy.iter().copied(), mean.max(f64::MIN_POSITIVE)),
                ),
            ],
            polygons: Vec::new(),
        }
    };
    FieldSeries {
        name: format!("{prefix}-sphere"),
        shapes: vec![FieldShape {
            points: directions.vectors.iter().map(|d| (centre + d * DRAWN).into()).collect(),
            polygons,
        }],
        bands: bands.iter().enumerate().map(picture).collect(),
    }
}

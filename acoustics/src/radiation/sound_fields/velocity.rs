//! Velocity of a body's surface.

use super::{BandField, FieldSeries, FieldShape, MOTION, VELOCITY, bands, decibels};
use crate::air::Air;
use crate::error::AcousticsError;
use crate::radiation::{FACE_POINTS, LowRank, ModalSpectra, RadiatingSurface, quadratic_forms};
use nailnoise_meshes::{Surface, open_faces};
use nalgebra::{DMatrix, Vector3};

/// Velocity of the surface of a body, given the displacement of its points in each mode (3 points x modes). The result
/// also contains the energy that the parts exposed to the open air would radiate with efficiency 1. `at` is the origin
/// of the axes of the body \[m\].
///
/// # Errors
/// Errors of the surface.
pub fn velocity_field(
    name: &str,
    (surface, shapes): (&Surface, &DMatrix<f32>),
    spectra: &ModalSpectra,
    air: &Air,
    at: Vector3<f64>,
) -> Result<FieldSeries, AcousticsError> {
    let open = open_faces(surface, None)?;
    let radiating = RadiatingSurface::of_faces(surface, shapes.as_view(), |point| open[point.face])?;
    let points: Vec<_> = surface
        .quadrature(FACE_POINTS)?
        .into_iter()
        .filter(|p| open[p.face])
        .collect();
    let faces: Vec<usize> = (0..open.len()).filter(|&face| open[face]).collect();
    let mut areas = vec![0.0; open.len()];
    points.iter().for_each(|point| areas[point.face] += point.weight);
    let mut pictures = Vec::new();
    for band in bands(spectra, f64::INFINITY) {
        let Some(covariance) = spectra.velocity_covariance([band.low, band.high], |_| 1.0) else {
            continue;
        };
        let mut normal = vec![0.0; open.len()];
        let forms = quadratic_forms(radiating.normal_modes(), &covariance);
        for (point, form) in points.iter().zip(forms) {
            normal[point.face] += form * point.weight / areas[point.face];
        }
        let nodal = LowRank::forms(&[LowRank::of(&covariance)], shapes).swap_remove(0);
        let vectors = nodal.chunks_exact(3).map(|axes| axes.iter().sum::<f64>());
        let of_faces = faces.iter().map(|&face| normal[face]);
        pictures.push(BandField {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![(MOTION.to_owned(), decibels(vectors, VELOCITY))],
            polygons: vec![
                (format!("normal {MOTION}"), decibels(of_faces.clone(), VELOCITY)),
                (
                    "energy per area with radiation efficiency 1 [J/m2]".to_owned(),
                    of_faces.map(|v| air.impedance() * v).collect(),
                ),
            ],
        });
    }
    Ok(FieldSeries {
        name: name.to_owned(),
        shapes: vec![shape_of(surface, &faces, at)],
        bands: pictures,
    })
}

fn shape_of(surface: &Surface, faces: &[usize], at: Vector3<f64>) -> FieldShape {
    let corners = |&face: &usize| {
        let face = &surface.faces[face];
        face.nodes[..face.kind.corners()].to_vec()
    };
    FieldShape {
        points: surface.points.iter().map(|p| (p + at).into()).collect(),
        polygons: faces.iter().map(corners).collect(),
    }
}

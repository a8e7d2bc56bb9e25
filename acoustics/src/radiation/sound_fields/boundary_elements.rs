//! The field of a body by the boundary element method.

use super::planes::{Cuts, in_planes};
use super::sphere::{SPHERE, sphere, sums};
use super::{
    BandField, EXPOSURE, FieldSeries, FieldShape, MOTION, PRESSURE, SoundField, VELOCITY, balance, bands, decibels,
    energies,
};
use crate::error::AcousticsError;
use crate::radiation::boundary_elements::{BandFields, MeshRange, ModalBem, SurfaceBand, WholeSurface};
use crate::radiation::sound::{Directions, FieldPoints};
use crate::radiation::{ModalSpectra, radiated_energy};
use crate::signals::Band;
use nalgebra::{Point3, Vector3};

/// One or several bodies as a single surface, solved by boundary elements.
pub struct SolvedSurface<'a> {
    /// Name of its source.
    pub source: &'static str,
    /// Prefix of the names of its fields.
    pub prefix: &'static str,
    /// Its meshes.
    pub levels: Vec<MeshRange>,
    /// Its radiation.
    pub bem: &'a ModalBem,
    /// Its motion.
    pub spectra: &'a ModalSpectra,
    /// Origin of its axes in the coordinates of the planes \[m\].
    pub at: Vector3<f64>,
}

/// Computes the field of a body in the bands below the end of single frequencies.
///
/// # Errors
/// Errors of the boundary elements.
pub fn boundary_element_field(body: SolvedSurface<'_>, cuts: &Cuts) -> Result<SoundField, AcousticsError> {
    let SolvedSurface {
        source,
        prefix,
        levels,
        bem,
        spectra,
        at,
    } = body;
    let bands = bands(spectra, bem.solved_hz()[0]);
    let radiated = radiated_energy(source, bem, spectra)?;
    let mut planes = cuts.planes();
    let moved = |points: &[Point3<f64>]| -> Vec<Point3<f64>> { points.iter().map(|p| p - at).collect() };
    for level in &levels {
        planes
            .iter_mut()
            .for_each(|plane| plane.keep(|points| level.problem.is_clear(&moved(points))));
    }
    let floor = levels.first().and_then(|level| level.problem.boundary().floor());
    let rings = if floor.is_some() { SPHERE[0] } else { 2 * SPHERE[0] };
    let directions = Directions::new(rings, SPHERE[1], floor.is_some());
    let points: Vec<Point3<f64>> = planes.iter().flat_map(|plane| plane.points()).collect();
    let points = moved(&points);
    let around = FieldPoints {
        points: &points,
        directions: &directions.vectors,
    };
    let foot = levels
        .first()
        .map_or_else(Point3::origin, |level| level.problem.reach().1);
    let found = BandFields::new(levels, &bands, spectra, &around)?;
    let energies = energies(&radiated, &bands);
    let left = |surface: &SurfaceBand| {
        let areas = &found.surfaces[surface.surface].areas;
        surface
            .intensity
            .iter()
            .zip(areas)
            .map(|(i, area)| i * area)
            .sum::<f64>()
    };
    let left: Vec<f64> = found.bands.iter().map(left).collect();
    let balances = vec![
        ("intensity over the surface", balance(&left, &energies)),
        (
            "directivity over all directions",
            balance(&sums(&found.around, &directions), &energies),
        ),
    ];
    let mut series = vec![on_surface(prefix, &found, &bands, at)];
    series.extend(in_planes(prefix, &planes, &found.around, &bands));
    series.push(sphere(prefix, &directions, &found.around, &bands, foot + at));
    Ok(SoundField {
        series,
        samples: found.around.samples,
        error: found.around.error,
        highest_hz: bands.last().map_or(0.0, Band::nominal_hz),
        balances,
    })
}

/// Pressure, intensity and velocity on the surface.
fn on_surface(prefix: &str, found: &BandFields, bands: &[Band], at: Vector3<f64>) -> FieldSeries {
    let shape = |surface: &WholeSurface| FieldShape {
        points: surface.points.iter().map(|p| (p + at).into()).collect(),
        polygons: surface.panels.clone(),
    };
    let picture = |(band, surface): (&Band, &SurfaceBand)| BandField {
        hz: band.nominal_hz(),
        shape: surface.surface,
        points: vec![(
            PRESSURE.to_owned(),
            decibels(surface.exposure.iter().copied(), EXPOSURE),
        )],
        polygons: vec![
            ("normal intensity [J/m2]".to_owned(), surface.intensity.clone()),
            (
                format!("normal {MOTION}"),
                decibels(surface.velocity.iter().copied(), VELOCITY),
            ),
        ],
    };
    FieldSeries {
        name: format!("{prefix}-surface"),
        shapes: found.surfaces.iter().map(shape).collect(),
        bands: bands.iter().zip(&found.bands).map(picture).collect(),
    }
}

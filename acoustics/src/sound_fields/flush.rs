//! The field of a flush surface by Rayleigh's integral.

use super::planes::{Cuts, in_planes};
use super::sphere::{SPHERE, sphere, sums};
use super::{SoundField, balance, bands, energies};
use crate::error::AcousticsError;
use crate::levels::{Band, SourceSpectrum};
use crate::radiation::{ModalSpectra, Rayleigh};
use crate::sound::{Directions, FieldPoints, band_sound_above_plane};
use nalgebra::Point3;

/// The field of a surface whose energy is `radiated`; names of fields begin with `prefix`.
///
/// # Errors
/// Those of Rayleigh's integral.
pub fn flush_field(
    prefix: &str,
    surface: &Rayleigh,
    spectra: &ModalSpectra,
    radiated: &SourceSpectrum,
    cuts: &Cuts,
) -> Result<SoundField, AcousticsError> {
    let bands = bands(spectra, f64::INFINITY);
    let mut planes = cuts.planes();
    planes
        .iter_mut()
        .for_each(|plane| plane.keep(|points| surface.is_clear(points)));
    let directions = Directions::new(SPHERE[0], SPHERE[1], true);
    let points: Vec<Point3<f64>> = planes.iter().flat_map(|plane| plane.points()).collect();
    let around = FieldPoints {
        points: &points,
        directions: &directions.vectors,
    };
    let found = band_sound_above_plane(surface, &bands, spectra, &around)?;
    let energies = energies(radiated, &bands);
    let mut series = in_planes(prefix, &planes, &found, &bands);
    series.push(sphere(
        prefix,
        &directions,
        &found,
        &bands,
        Point3::new(0.0, 0.0, cuts.top),
    ));
    Ok(SoundField {
        series,
        samples: found.samples,
        error: found.error,
        highest_hz: bands.last().map_or(0.0, Band::nominal_hz),
        balances: vec![(
            "directivity over all directions",
            balance(&sums(&found, &directions), &energies),
        )],
    })
}

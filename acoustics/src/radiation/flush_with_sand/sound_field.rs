//! The field of a flush surface by Rayleigh's integral.

use super::Rayleigh;
use crate::error::AcousticsError;
use crate::radiation::ModalSpectra;
use crate::radiation::sound::{BandSound, Directions, FieldPoints, Fields, bins_of, groups, of_bins, squares};
use crate::radiation::sound_fields::planes::{Cuts, in_planes};
use crate::radiation::sound_fields::sphere::{SPHERE, sphere, sums};
use crate::radiation::sound_fields::{SoundField, balance, bands, energies};
use crate::signals::{Band, SourceSpectrum, Weighting, energy_weights};
use nalgebra::{Complex, Point3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of bins processed at once.
const CHUNK: usize = 64;

/// The field of a surface with the energy `radiated`; names of fields begin with `prefix`.
///
/// # Errors
/// Errors of Rayleigh's integral.
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

/// The sound of a shot above a surface flush with a plane, in bands.
///
/// # Errors
/// [`ReceiverError`](crate::ReceiverError) for points that [`Rayleigh::pressure_at`] rejects.
pub fn band_sound_above_plane(
    surface: &Rayleigh,
    bands: &[Band],
    spectra: &ModalSpectra,
    around: &FieldPoints<'_>,
) -> Result<BandSound, AcousticsError> {
    let mut result = BandSound::zeros(bands, around);
    let (path, middle) = surface.reach();
    let speed = surface.air().sound_speed;
    let travel: Vec<f64> = around.points.iter().map(|p| (p - middle).norm()).collect();
    let fade = surface.fade_hz();
    let kinked = |band: &Band| fade.is_some_and(|[from, to]| band.high > from && band.low < to);
    let mut number = 0;
    for group in groups(bands, kinked) {
        let range = [group[0].low, group[group.len() - 1].high];
        let fields = Fields::new(range, (path, speed), |hz| {
            let mut pressures = surface.pressure_at(hz, around.points)?;
            for (mut row, r) in pressures.row_iter_mut().zip(&travel) {
                let turn = Complex::from_polar(1.0, 2.0 * PI * hz * r / speed);
                row.iter_mut().for_each(|p| *p *= turn);
            }
            Ok(vec![pressures, surface.far_field_at(hz, around.directions)])
        })?;
        result.samples += fields.samples();
        result.error = result.error.max(fields.error());
        for band in group {
            let weights = energy_weights(&spectra.frequency, [band.low, band.high], Weighting::Z);
            let bins = bins_of(&weights);
            let of_chunk = |bins: &[usize]| {
                let frequency: Vec<f64> = bins.iter().map(|&b| spectra.frequency[b]).collect();
                let weights: Vec<f64> = bins.iter().map(|&b| 2.0 * weights[b]).collect();
                let motion = of_bins(spectra, bins);
                [0, 1].map(|field| squares(&fields.product(field, &frequency, &motion), &weights))
            };
            for [exposure, far] in bins.par_chunks(CHUNK).map(of_chunk).collect::<Vec<_>>() {
                result.add(number, &exposure, (&far, 1.0 / surface.air().impedance()));
            }
            number += 1;
        }
    }
    Ok(result)
}

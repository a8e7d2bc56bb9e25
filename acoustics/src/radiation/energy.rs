//! Energies and signals of a surface that moves in modes.

use super::operator::ModalRadiation;
use super::spectra::ModalSpectra;
use crate::checks::{InputError, same_length};
use crate::error::AcousticsError;
use crate::signals::{Contribution, PowerSignals, SourceSpectrum};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::ops::Range;

/// Number of bins evaluated together, so that intermediate results fit in the cache.
const STRETCH: usize = 256;

/// Applies `each` to the frequencies and motions of consecutive groups of bins; results are in order.
fn by_stretches<T: Send>(
    spectra: &ModalSpectra,
    length: usize,
    each: impl Fn(Range<usize>, &[f64], &DMatrix<Complex<f64>>) -> T + Sync,
) -> Vec<T> {
    let bins = spectra.frequency.len();
    let starts: Vec<usize> = (0..bins).step_by(length).collect();
    let of_stretch = |&start: &usize| {
        let stretch = start..bins.min(start + length);
        let motion = spectra.accelerations.columns(start, stretch.len()).into_owned();
        each(stretch.clone(), &spectra.frequency[stretch], &motion)
    };
    starts.par_iter().map(of_stretch).collect()
}

/// Number of bins whose signals are evaluated together; signals need much more memory than energies.
const SIGNAL_BINS: usize = 64;

/// Energy of each mode: its contribution to the quadratic form, twice the real part of conj(V_i) (R V)_i, integrated
/// with the given weight of each bin.
///
/// The energies of the modes add up to the total. A mode that vibrates against the others absorbs sound and has
/// negative energy.
///
/// # Errors
/// If the number of modes differs from the operator's, or the number of weights from the number of bins.
pub fn mode_energies(
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
    weights: &[f64],
) -> Result<Vec<f64>, InputError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    same_length("weights of the bins", weights.len(), spectra.frequency.len())?;
    let of_stretch = |stretch: Range<usize>, frequency: &[f64], motion: &DMatrix<Complex<f64>>| {
        let images = radiation.images(frequency, motion);
        let mut energies = vec![0.0; radiation.modes()];
        let bins = motion.column_iter().zip(images.column_iter());
        for ((a, image), weight) in bins.zip(&weights[stretch]) {
            for ((energy, a), image) in energies.iter_mut().zip(a.iter()).zip(image.iter()) {
                *energy += 2.0 * weight * (a.conj() * image).re;
            }
        }
        energies
    };
    let mut energies = vec![0.0; radiation.modes()];
    for part in by_stretches(spectra, 2 * STRETCH, of_stretch) {
        energies.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    Ok(energies)
}

/// Energy spectrum of a surface that vibrates in modes, with its patches as contributions.
///
/// ```text
/// E(f) = 2 V^H R V = 2 A^H (R / omega^2) A
/// ```
///
/// # Errors
/// If the number of modes differs from the operator's, or the range exceeds the operator's.
pub fn radiated_energy(
    source: impl Into<String>,
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
) -> Result<SourceSpectrum, AcousticsError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    let [low, high] = spectra.range_hz;
    if high > radiation.highest_hz() * (1.0 + 1e-9) {
        let highest = radiation.highest_hz();
        return Err(InputError::OutsideRange {
            what: "analysed frequency [Hz]",
            value: high,
            low: 0.0,
            high: highest,
        }
        .into());
    }
    let mut forms = DMatrix::zeros(radiation.patches().len(), spectra.frequency.len());
    let of_stretch = |stretch: Range<usize>, frequency: &[f64], motion: &DMatrix<Complex<f64>>| {
        (stretch, radiation.energy_forms(frequency, motion))
    };
    for (stretch, found) in by_stretches(spectra, STRETCH, of_stretch) {
        forms.columns_mut(stretch.start, stretch.len()).copy_from(&found);
    }
    forms *= 2.0;
    let mut density = Vec::with_capacity(spectra.frequency.len());
    for mut bin in forms.column_iter_mut() {
        let total = bin.sum();
        // An interpolated R is semidefinite only within the interpolation error: if motions almost cancel, the sum may
        // be negative.
        if total < 0.0 {
            bin.fill(0.0);
        }
        density.push(total.max(0.0));
    }
    let part = |(p, name): (usize, &String)| Contribution {
        name: name.clone(),
        energy_density: forms.row(p).iter().copied().collect(),
    };
    let contributions = radiation.patches().iter().enumerate().map(part).collect();
    let frequency = spectra.frequency.clone();
    let mut spectrum = SourceSpectrum::new(source, radiation.method(), frequency, density, [low, high])?;
    spectrum.contributions = contributions;
    Ok(spectrum)
}

/// The signals of a surface that vibrates in modes, for its energy over time.
///
/// ```text
/// x = L^H V = L^H A / (j omega)       R = L L^H
/// ```
///
/// `spectrum` is the result of [`radiated_energy`] for the same operator and motion.
///
/// # Errors
/// If the number of modes differs from the operator's, or the spectrum has other frequencies.
pub fn radiated_signals(
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
    spectrum: &SourceSpectrum,
) -> Result<PowerSignals, AcousticsError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    let (rows, bins) = (radiation.signals(), spectra.frequency.len());
    let mut signals = DMatrix::zeros(rows, bins);
    let stretches = signals.as_mut_slice().par_chunks_mut((rows * SIGNAL_BINS).max(1));
    stretches.enumerate().for_each(|(number, to)| {
        let start = number * SIGNAL_BINS;
        let stretch = start..bins.min(start + SIGNAL_BINS);
        let motion = spectra.accelerations.columns(start, stretch.len()).into_owned();
        to.copy_from_slice(radiation.root_signals(&spectra.frequency[stretch], &motion).as_slice());
    });
    // The phase of 1/(j omega); its magnitude is in the root of R / omega².
    Ok(PowerSignals::new(spectrum, signals)?.turned(-Complex::<f64>::i()))
}

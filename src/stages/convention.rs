//! Assignment of parts to sources. By the convention of selective wrapping, the outer side of the cap counts towards
//! the exhaust and the trigger vent towards the body; energies move between the two, and their sum is unchanged.

use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};

use super::apart::{Apart, Moved, PartError};
use super::microphones::AtMicrophones;
use super::sound::{SoundSource, sum_with};
use crate::result::Uncertainty;

/// Parts that are assigned to a source, each with the source that makes it.
fn parts_to<'a, T>(sources: &'a [Apart<T>], to: &'a str) -> impl Iterator<Item = (&'a Apart<T>, &'a Moved<T>)> {
    let moved = sources
        .iter()
        .filter_map(|source| Some((source, source.moved.as_ref()?)));
    moved.filter(move |(_, moved)| moved.to == to)
}

/// Each source with the parts that are assigned to it, and without those assigned to another one. Sources are compared
/// over `range_hz`.
pub fn counted(sources: &[Apart<&SoundSource>], range_hz: [f64; 2]) -> Vec<SoundSource> {
    let energy = |source: &SoundSource| source.spectrum.energy(range_hz, Weighting::A);
    let of_whole = |source: &Apart<&SoundSource>| {
        let part = source.moved.as_ref().map_or(0.0, |moved| energy(moved.part));
        errors(energy(source.own) + part, &source.own.uncertainty)
    };
    let of_rest = |source: &Apart<&SoundSource>| match &source.moved {
        Some(moved) if moved.error == PartError::OfWhole => of_whole(source),
        _ => errors(energy(source.own), &source.own.uncertainty),
    };
    let of_part = |(source, moved): (&Apart<&SoundSource>, &Moved<&SoundSource>)| match moved.error {
        PartError::OfPart => errors(energy(moved.part), &moved.part.uncertainty),
        PartError::OfWhole => of_whole(source),
    };
    let with_parts = |source: &Apart<&SoundSource>| {
        let (mut whole, mut errors) = (source.own.clone(), of_rest(source));
        let mut basis = whole.uncertainty.basis.clone();
        let mut changed = matches!(&source.moved, Some(moved) if moved.error == PartError::OfWhole);
        for (origin, moved) in parts_to(sources, &source.own.spectrum.source) {
            whole = whole.with(moved.part);
            errors = sum(errors, of_part((origin, moved)));
            let name = &moved.part.spectrum.source;
            basis += &match moved.error {
                PartError::OfPart => format!("; {name}: as the {}", origin.own.spectrum.source),
                PartError::OfWhole => format!("; {name}: all of the error of the {}", origin.own.spectrum.source),
            };
            changed = true;
        }
        if changed {
            whole.uncertainty = within(energy(&whole), errors, basis);
        }
        whole
    };
    sources.iter().map(with_parts).collect()
}

fn sum(a: [Option<f64>; 2], b: [Option<f64>; 2]) -> [Option<f64>; 2] {
    [0, 1].map(|side| Some(a[side]? + b[side]?))
}

/// Largest decrease and increase of an energy due to its error \[J\].
fn errors(energy: f64, uncertainty: &Uncertainty) -> [Option<f64>; 2] {
    let [minus, plus] = uncertainty.bounds();
    [
        minus.map(|decibels| energy * (1.0 - 10f64.powf(-0.1 * decibels))),
        plus.map(|decibels| energy * (10f64.powf(0.1 * decibels) - 1.0)),
    ]
}

/// The uncertainty of an energy with this possible decrease and increase \[J\]; without a lower bound if the energy may
/// be zero.
fn within(energy: f64, [less, more]: [Option<f64>; 2], basis: String) -> Uncertainty {
    let decibels = |ratio: f64| (energy > 0.0 && ratio > 0.0).then(|| 10.0 * ratio.log10());
    Uncertainty {
        minus: less.and_then(|less| decibels(1.0 - less / energy)).map(|level| -level),
        plus: more.and_then(|more| decibels(1.0 + more / energy)),
        basis,
    }
}

/// Each source at the microphones, with the parts that are assigned to it.
pub fn received(sources: &[Apart<AtMicrophones>]) -> Vec<AtMicrophones> {
    let with_parts = |source: &Apart<AtMicrophones>| {
        let parts = parts_to(sources, &source.own.source);
        parts.fold(source.own.clone(), |sum, (_, moved)| sum.with(&moved.part, 1.0))
    };
    sources.iter().map(with_parts).collect()
}

/// Energy spectrum of each source, with the parts that are assigned to it.
pub fn spectra(sources: &[Apart<SourceSpectrum>]) -> Vec<SourceSpectrum> {
    let with_parts = |source: &Apart<SourceSpectrum>| {
        let parts = parts_to(sources, &source.own.source);
        parts.fold(source.own.clone(), |sum, (_, moved)| sum_with(&sum, &moved.part))
    };
    sources.iter().map(with_parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_the_same_energy_in_decibels_of_a_part() {
        let uncertainty = Uncertainty {
            minus: Some(1.0),
            plus: Some(2.0),
            basis: String::new(),
        };
        let found = errors(2.0, &uncertainty);
        let back = within(2.0, found, String::new());
        assert!((back.minus.unwrap_or(0.0) - 1.0).abs() < 1e-12 && (back.plus.unwrap_or(0.0) - 2.0).abs() < 1e-12);
        // A tenth of the energy may be nothing, or more than six times as large.
        let part = within(0.2, found, String::new());
        assert!(
            part.minus.is_none() && part.plus.is_some_and(|plus| (plus - 8.356).abs() < 0.001),
            "{part:?}"
        );
    }
}

//! Which source a part counts to. By the convention of selective wrapping the outer side of the cap counts to the exhaust and the
//! trigger vent to the body; energies move between the two, and their sum stays.

use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use serde::{Deserialize, Serialize};

use super::microphones::AtMicrophones;
use super::sound::{SoundSource, sum_with};
use crate::result::Uncertainty;

/// A part that counts to another source than the one that makes it; its energies may have either sign.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MovedPart {
    /// Its energy over frequency and time.
    pub source: SoundSource,
    /// Its sound at the microphones.
    pub received: AtMicrophones,
}

/// Exhaust with the cap, and body with the trigger vent, from exhaust without vent and body without cap; unchanged if
/// nothing moves. Sources are compared over `range_hz`.
pub fn counted(
    [exhaust, body]: [&SoundSource; 2],
    [cap, vent]: [Option<&SoundSource>; 2],
    range_hz: [f64; 2],
) -> [SoundSource; 2] {
    let energy = |source: &SoundSource| source.spectrum.energy(range_hz, Weighting::A);
    let of = |source: &SoundSource| errors(energy(source), &source.uncertainty);
    // The error of the body may be all in its cap, or all in the rest.
    let of_body = errors(energy(body) + cap.map_or(0.0, energy), &body.uncertainty);
    let uncertain = |source: SoundSource, errors: [Option<f64>; 2], basis: &str| SoundSource {
        uncertainty: within(energy(&source), errors, source.uncertainty.basis.clone() + basis),
        ..source
    };
    let exhaust = match cap {
        Some(cap) => uncertain(
            exhaust.with(cap),
            sum(of(exhaust), of_body),
            "; cap: all of the error of the body",
        ),
        None => exhaust.clone(),
    };
    let body = match (vent, cap) {
        (Some(vent), _) => uncertain(
            body.with(vent),
            sum(of_body, of(vent)),
            "; trigger vent: as the exhaust",
        ),
        (None, Some(_)) => uncertain(body.clone(), of_body, ""),
        (None, None) => body.clone(),
    };
    [exhaust, body]
}

fn sum(a: [Option<f64>; 2], b: [Option<f64>; 2]) -> [Option<f64>; 2] {
    [0, 1].map(|side| Some(a[side]? + b[side]?))
}

/// How much less and more an energy \[J\] may be.
fn errors(energy: f64, uncertainty: &Uncertainty) -> [Option<f64>; 2] {
    let [minus, plus] = uncertainty.bounds();
    [
        minus.map(|decibels| energy * (1.0 - 10f64.powf(-0.1 * decibels))),
        plus.map(|decibels| energy * (10f64.powf(0.1 * decibels) - 1.0)),
    ]
}

/// The uncertainty of an energy that may be so much less and more \[J\]; without a lower bound where it may be zero.
fn within(energy: f64, [less, more]: [Option<f64>; 2], basis: String) -> Uncertainty {
    let decibels = |ratio: f64| (energy > 0.0 && ratio > 0.0).then(|| 10.0 * ratio.log10());
    Uncertainty {
        minus: less.and_then(|less| decibels(1.0 - less / energy)).map(|level| -level),
        plus: more.and_then(|more| decibels(1.0 + more / energy)),
        basis,
    }
}

/// Exhaust with the cap, and body with the trigger vent, at the microphones.
pub fn received([exhaust, body]: [&AtMicrophones; 2], [cap, vent]: [Option<&AtMicrophones>; 2]) -> [AtMicrophones; 2] {
    let with = |source: &AtMicrophones, part: Option<&AtMicrophones>| match part {
        Some(part) => source.with(part, 1.0),
        None => source.clone(),
    };
    [with(exhaust, cap), with(body, vent)]
}

/// The energy of a source with that of a part that counts to it.
pub fn spectrum_with(source: &SourceSpectrum, part: Option<&SourceSpectrum>) -> SourceSpectrum {
    part.map_or_else(|| source.clone(), |part| sum_with(source, part))
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
        // A tenth of the energy may be nothing, or more than six times itself.
        let part = within(0.2, found, String::new());
        assert!(
            part.minus.is_none() && part.plus.is_some_and(|plus| (plus - 8.356).abs() < 0.001),
            "{part:?}"
        );
    }
}

//! Complete signals of a source: over the same range for all sources, with the exposures stated by the levels.
//!
//! ```text
//! X_b = known exposure + exposure of the fading pressures + share of the power above
//! F(f) = g_b [P(f) + N(f)],   g_b^2 = X_b / int_b 2 |P + N|^2 df
//! ```
//!
//! P is the spectrum of the known signal, N that of the noise that continues it, and b a one-third-octave band. For
//! known pressures, the factors g_b are 1 except for the effect of the ends of the record. For random signals (jets,
//! noise above the known pressures), they scale the energy to the expected value. Frequencies outside the range are
//! removed.

use nalgebra::Complex;
use rayon::prelude::*;

use super::bands::{Integration, Spectra, bands, density, integrals, within};
use super::continuation::Continuation;
use super::{AtMicrophones, Heard, MicrophoneArray, SAMPLE_RATE};
use crate::stages::apart::Apart;
use crate::stages::sound::SoundSource;

/// Number of passes that correct the factors for the energy lost when a signal is cut at the ends of the record.
const PASSES: usize = 6;

/// Exposures \[A, Z\] by band, and signal, of each part at one receiver.
type OfReceiver = (Vec<Vec<[f64; 2]>>, Vec<Vec<f64>>);

impl MicrophoneArray {
    /// The complete signals and exposures of a source, and of the part of it that is assigned to another source, if
    /// any. The noise depends on the seed and the number of the source.
    ///
    /// Parts are continued and scaled like their sum, so that signals and exposures of parts sum to those of the
    /// source, whichever source a part is assigned to. The exposure of one part p_k among several is 2 Re(p_k conj p),
    /// not that of its own signal.
    #[must_use]
    pub fn complete(&self, heard: &Apart<Heard>, noise_seed: u32, number: u64) -> Apart<AtMicrophones> {
        let parts = heard.parts();
        let sources: Vec<&SoundSource> = parts.iter().map(|part| &part.source).collect();
        let known: Vec<&AtMicrophones> = parts.iter().map(|part| &part.received).collect();
        let samples = known
            .iter()
            .flat_map(|part| &part.signals)
            .map(Vec::len)
            .max()
            .unwrap_or(0);
        let top = self.range_hz[1];
        let end = known.iter().map(|part| part.range_hz[1]).fold(top, f64::min);
        let whole: Vec<Vec<f64>> = (0..self.receivers().len())
            .map(|at| sum_at(&known, at, samples))
            .collect();
        let continuation = Continuation::new(&sources, &whole, [end, top]);
        let noise = continuation.as_ref().map(|continuation| {
            let length = (f64::from(SAMPLE_RATE), samples);
            // Distinct from the seeds of the jets, which are small numbers above the same multiple.
            let seed = (u64::from(noise_seed) << 32) + (1 << 31);
            continuation.noise(&self.travel_times(), length, (seed, number))
        });
        let all = bands(self.range_hz);
        let above = within(&all, [end, top]);
        let radiated: Vec<Vec<[f64; 2]>> = (sources.iter())
            .map(|source| radiated_above(source, continuation.as_ref(), &above))
            .collect();
        let shares = shares_of_parts(&radiated);
        let spectra = Spectra::new(samples, f64::from(SAMPLE_RATE));
        let (inside, fading) = (
            Integration::new(&spectra.frequency, &all),
            Integration::new(&spectra.frequency, &above),
        );
        let at = |place: usize| {
            let mut lines: Vec<Vec<Complex<f64>>> =
                known.iter().map(|part| spectra.lines(&part.signals[place])).collect();
            let exposures = exposures_of(&known, place, &lines, (&fading, continuation.as_ref(), &radiated));
            if let Some(noise) = &noise {
                let drawn = spectra.lines(&noise[place]);
                for (lines, shares) in lines.iter_mut().zip(&shares) {
                    each_band(&spectra.frequency, &all, |line, band| {
                        lines[line] += shares[band] * drawn[line];
                    });
                }
            }
            let target: Vec<f64> = (0..all.len())
                .map(|band| exposures.iter().map(|part| part[band][1]).sum())
                .collect();
            let signals = scaled(&spectra, &lines, (&all, &inside, &target), samples);
            (exposures, signals)
        };
        let found: Vec<OfReceiver> = (0..whole.len()).into_par_iter().map(at).collect();
        let mut numbers = 0..;
        heard.map(|part| {
            let number = numbers.next().unwrap_or_default();
            let range_hz = [part.received.range_hz[0], top];
            let spectrum = &part.source.spectrum;
            AtMicrophones {
                range_hz,
                exposures: found.iter().map(|(exposures, _)| exposures[number].clone()).collect(),
                radiated: integrals(&spectrum.frequency, &spectrum.energy_density, &within(&all, range_hz)),
                signals: found.iter().map(|(_, signals)| signals[number].clone()).collect(),
                ..part.received.clone()
            }
        })
    }
}

/// Exposures \[A, Z\] of each part at a receiver in each band: known, of pressures that fade, and of their
/// continuation.
fn exposures_of(
    known: &[&AtMicrophones],
    place: usize,
    lines: &[Vec<Complex<f64>>],
    (fading, continuation, radiated): (&Integration, Option<&Continuation<'_>>, &[Vec<[f64; 2]>]),
) -> Vec<Vec<[f64; 2]>> {
    let share = continuation.map_or(0.0, |continuation| continuation.shares[place]);
    let whole = sum_of(lines);
    let of_part = |((known, lines), radiated): ((&&AtMicrophones, &Vec<Complex<f64>>), &Vec<[f64; 2]>)| {
        let fades = if continuation.is_some() {
            let own: Vec<f64> = lines
                .iter()
                .zip(&whole)
                .map(|(own, all)| 2.0 * (own * all.conj()).re)
                .collect();
            fading.energies(&own)
        } else {
            vec![[0.0; 2]; radiated.len()]
        };
        let bands = known.exposures[place].iter().zip(fades).zip(radiated);
        let sum = |((known, fading), above): ((&[f64; 2], [f64; 2]), &[f64; 2])| {
            [0, 1].map(|weighting| known[weighting] + fading[weighting] + share * above[weighting])
        };
        bands.map(sum).collect()
    };
    known.iter().zip(lines).zip(radiated).map(of_part).collect()
}

/// Energies \[A, Z\] of a source in each band that noise represents \[J\].
fn radiated_above(source: &SoundSource, continuation: Option<&Continuation<'_>>, above: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(continuation) = continuation else {
        return vec![[0.0; 2]; above.len()];
    };
    let spectrum = &source.spectrum;
    let pairs = spectrum.frequency.iter().zip(&spectrum.energy_density);
    let risen: Vec<f64> = pairs.map(|(hz, energy)| continuation.risen(*hz) * energy).collect();
    integrals(&spectrum.frequency, &risen, above)
}

/// Fraction of each part in the noise of the source, for each band: that of its energy, which may have either sign.
fn shares_of_parts(radiated: &[Vec<[f64; 2]>]) -> Vec<Vec<f64>> {
    let share = |own: f64, band: usize| {
        let whole: f64 = radiated.iter().map(|part| part[band][1]).sum();
        if whole > 0.0 { own / whole } else { 0.0 }
    };
    let of_part = |part: &Vec<[f64; 2]>| part.iter().enumerate().map(|(band, own)| share(own[1], band)).collect();
    radiated.iter().map(of_part).collect()
}

/// The signals of parts with these lines, scaled in such a way that their sum, cut at the ends of the record, has the
/// energies `target` in the bands. Outside the bands, it has only the energy added by the cut.
fn scaled(
    spectra: &Spectra,
    lines: &[Vec<Complex<f64>>],
    (bands, integration, target): (&[[f64; 2]], &Integration, &[f64]),
    samples: usize,
) -> Vec<Vec<f64>> {
    let mut factors = vec![1.0; bands.len()];
    let cut = |lines: &[Complex<f64>], factors: &[f64]| {
        let mut kept = vec![Complex::default(); lines.len()];
        each_band(&spectra.frequency, bands, |line, band| {
            kept[line] = factors[band] * lines[line]
        });
        spectra.signal(&kept, samples)
    };
    let whole = sum_of(lines);
    for _ in 0..PASSES {
        let found = integration.energies(&density(&spectra.lines(&cut(&whole, &factors))));
        for (factor, ([_, found], target)) in factors.iter_mut().zip(found.iter().zip(target)) {
            *factor *= if *found > 0.0 {
                (target.max(0.0) / found).sqrt()
            } else {
                0.0
            };
        }
    }
    lines.iter().map(|own| cut(own, &factors)).collect()
}

/// Calls a function for each line inside a band, with the band's number.
fn each_band(frequency: &[f64], bands: &[[f64; 2]], mut call: impl FnMut(usize, usize)) {
    let (mut band, mut line) = (0, 0);
    while line < frequency.len() && band < bands.len() {
        let ([low, high], last) = (bands[band], band + 1 == bands.len());
        if frequency[line] < low {
            line += 1;
        } else if frequency[line] < high || (last && frequency[line] <= high) {
            call(line, band);
            line += 1;
        } else {
            band += 1;
        }
    }
}

fn sum_at(parts: &[&AtMicrophones], place: usize, samples: usize) -> Vec<f64> {
    let mut sum = vec![0.0; samples];
    for part in parts {
        sum.iter_mut().zip(&part.signals[place]).for_each(|(sum, p)| *sum += p);
    }
    sum
}

fn sum_of(lines: &[Vec<Complex<f64>>]) -> Vec<Complex<f64>> {
    let mut parts = lines.iter();
    let mut sum = parts.next().cloned().unwrap_or_default();
    for part in parts {
        sum.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn each_line_of_the_range_lies_in_one_band() {
        let frequency: Vec<f64> = (0..2000).map(|k| 10.0 * f64::from(k)).collect();
        let all = bands([50.0, 10_000.0]);
        let mut found = Vec::new();
        each_band(&frequency, &all, |line, band| {
            assert!(all[band][0] <= frequency[line] && frequency[line] <= all[band][1]);
            found.push(line);
        });
        assert_eq!(found, (5..=1000).collect::<Vec<_>>());
    }

    /// Decaying sines inside the bands and at their ends, cut by the end of the record.
    #[test]
    fn a_scaled_signal_has_the_energies_asked_for_in_each_band_and_none_outside() {
        let (rate, samples) = (48_000.0, 14_400);
        let all = bands([50.0, 10_000.0]);
        let sample = |n: usize| -> f64 {
            let t = n as f64 / rate - 0.02;
            let tone = |hz: &[f64; 2]| (2.0 * PI * hz[0] * t).sin();
            if t < 0.0 {
                0.0
            } else {
                (-t / 0.03).exp() * all.iter().map(tone).sum::<f64>()
            }
        };
        let signal: Vec<f64> = (0..samples).map(sample).collect();
        let spectra = Spectra::new(samples, rate);
        let integration = Integration::new(&spectra.frequency, &all);
        let target: Vec<f64> = (0..all.len()).map(|band| 1.0 + 0.2 * (band as f64).sin()).collect();
        let found = scaled(
            &spectra,
            &[spectra.lines(&signal)],
            (&all, &integration, &target),
            samples,
        );
        let energies = integration.energies(&density(&spectra.lines(&found[0])));
        for ([_, z], target) in energies.iter().zip(&target) {
            assert!((10.0 * (z / target).log10()).abs() < 0.02, "{z} {target}");
        }
        let exposure: f64 = found[0].iter().map(|p| p * p / rate).sum();
        let sum: f64 = target.iter().sum();
        assert!((10.0 * (exposure / sum).log10()).abs() < 0.05, "{exposure} {sum}");
    }
}

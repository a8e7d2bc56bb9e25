//! Gaussian noise with a given density, steady or with a power history.

use std::f64::consts::TAU;

use nailnoise_acoustics::random::uniform;
use nailnoise_acoustics::signals::fourier::RealTransform;
use nalgebra::Complex;

/// A standard normal number for a position in a sequence (Box and Muller 1958).
pub(crate) fn normal(seed: u64, first: u64, second: u64) -> f64 {
    let (u, v) = (uniform(seed, first, 2 * second), uniform(seed, first, 2 * second + 1));
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// Noise whose expected energy has the one-sided density `density(hz)` \[unit2 s/Hz\], modulated by an `envelope` of
/// power over time (one value per sample at `rate` \[1/s\], in any scale); silent where the envelope is zero.
pub(crate) fn under_envelope(
    envelope: &[f64],
    rate: f64,
    density: impl Fn(f64) -> f64,
    (seed, stream): (u64, u64),
) -> Vec<f64> {
    let sum: f64 = envelope.iter().sum();
    if sum <= 0.0 {
        return vec![0.0; envelope.len()];
    }
    // E|sum_n w_n sqrt(p_n) dt e^..|^2 = dt^2 sum p_n = 1/2 for a one-sided density of 1.
    let scale = rate * (0.5 / sum).sqrt();
    let modulated = |(n, power): (usize, &f64)| match *power {
        power if power > 0.0 => scale * power.sqrt() * normal(seed, stream, n as u64),
        _ => 0.0,
    };
    let white: Vec<f64> = envelope.iter().enumerate().map(modulated).collect();
    let transform = RealTransform::new(envelope.len().next_power_of_two());
    let df = rate / transform.length() as f64;
    let mut lines = transform.lines(&white);
    for (k, x) in lines.iter_mut().enumerate() {
        *x *= density(k as f64 * df).max(0.0).sqrt();
    }
    let last = lines.len() - 1;
    (lines[0], lines[last]) = (Complex::default(), Complex::default());
    let mut noise = transform.signal(lines);
    noise.truncate(envelope.len());
    noise
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_energy_of_its_density() {
        // 2e-3 unit2 s/Hz between 1 and 3 kHz give an energy of 4 unit2 s.
        let rate = 16_000.0;
        let envelope = vec![1.0; 16_000];
        let density = |hz: f64| if (1000.0..3000.0).contains(&hz) { 2e-3 } else { 0.0 };
        let noise = under_envelope(&envelope, rate, density, (1, 2));
        let energy: f64 = noise.iter().map(|x| x * x / rate).sum();
        // Two thousand lines with an exponential distribution have a standard deviation of 2.2 %.
        assert!((energy / 4.0 - 1.0).abs() < 0.07, "{energy}");
    }

    #[test]
    fn noise_follows_its_envelope() {
        let rate = 16_000.0;
        let envelope: Vec<f64> = (0..16_000).map(|n| if n < 4000 { 3.0 } else { 1.0 }).collect();
        let noise = under_envelope(&envelope, rate, |_| 1e-3, (5, 0));
        let energy = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>();
        let ratio = energy(&noise[..4000]) / energy(&noise[4000..8000]);
        assert!((ratio / 3.0 - 1.0).abs() < 0.1, "{ratio}");
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let all: Vec<f64> = (0..20_000).map(|n| normal(3, 1, n)).collect();
        let mean = all.iter().sum::<f64>() / 2e4;
        let variance = all.iter().map(|x| x * x).sum::<f64>() / 2e4;
        assert!(mean.abs() < 0.025 && (variance - 1.0).abs() < 0.03, "{mean} {variance}");
    }
}

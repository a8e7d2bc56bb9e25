//! Aligns records on a common time axis: travel times, and delays between records.

use nailnoise_acoustics::signals::fourier::RealTransform;
use std::f64::consts::PI;

use nalgebra::Complex;

/// Delays a record by `delay` \[s\], including fractions of a sample, by multiplying its lines by e^(-j 2 pi f delay).
/// Zeros are shifted in at one end, and samples shifted out at the other end are lost.
pub fn delayed(record: &[f64], rate: f64, delay: f64) -> Vec<f64> {
    if record.is_empty() {
        return Vec::new();
    }
    // Padding, so that nothing wraps around.
    let room = (delay.abs() * rate).ceil() as usize + 1;
    let length = (record.len() + room).next_power_of_two();
    let transform = RealTransform::new(length);
    let mut lines = transform.lines(record);
    let step = -2.0 * PI * delay * rate / length as f64;
    for (k, x) in lines.iter_mut().enumerate() {
        *x *= Complex::from_polar(1.0, step * k as f64);
    }
    let mut moved = transform.signal(lines);
    moved.truncate(record.len());
    moved
}

/// Delay of `record` relative to `reference` \[s\], from the largest correlation within `most` \[s\], to a fraction of
/// a sample by a parabola through the maximum and its neighbours; `None` if either is silent.
pub fn delay(reference: &[f64], record: &[f64], rate: f64, most: f64) -> Option<f64> {
    let reach = (most * rate).ceil() as usize;
    let length = (reference.len().max(record.len()) + reach + 1).next_power_of_two();
    let transform = RealTransform::new(length);
    let lines = transform.lines(record).into_iter().zip(transform.lines(reference));
    let correlation = transform.signal(lines.map(|(b, a)| b * a.conj()).collect());
    let at = |lag: i64| correlation[lag.rem_euclid(length as i64) as usize];
    let reach = reach as i64;
    let best = (-reach..=reach).max_by(|a, b| at(*a).total_cmp(&at(*b)))?;
    let [before, peak, after] = [best - 1, best, best + 1].map(at);
    if peak <= 0.0 {
        return None;
    }
    let bend = before - 2.0 * peak + after;
    let fraction = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some((best as f64 + fraction) / rate)
}

#[cfg(test)]
mod tests {
    use nailnoise_acoustics::random::uniform;

    use super::*;

    const RATE: f64 = 160_000.0;

    fn shot() -> Vec<f64> {
        let sample = |i: usize| {
            let t = i as f64 / RATE - 0.02;
            if t < 0.0 {
                0.0
            } else {
                // Smooth at its beginning, so that shifting by fractions of a sample is exact.
                (t / 1e-3).powi(3).min(1.0) * (-t / 5e-3).exp() * (2.0 * PI * 900.0 * t).sin()
            }
        };
        (0..16_000).map(sample).collect()
    }

    /// Microphone 5 is sqrt(3) m from the centre: 807.48 samples at 160 kHz and 343.2 m/s.
    #[test]
    fn a_travel_time_is_a_fraction_of_samples_and_is_taken_back() {
        let travel = 3f64.sqrt() / 343.2;
        assert!((travel * RATE - 807.48).abs() < 0.005);
        let (clean, late) = (shot(), delayed(&shot(), RATE, travel));
        let back = delayed(&late, RATE, -travel);
        let error = clean.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-6, "{error}");
    }

    #[test]
    fn a_delay_is_found_in_noise_60_db_below_the_peak() {
        let true_delay = 807.48 / RATE;
        let noise = |i: usize| 1e-3 * (2.0 * uniform(1, i as u64, 0) - 1.0);
        let late = delayed(&shot(), RATE, true_delay);
        let noisy: Vec<f64> = late.iter().enumerate().map(|(i, x)| x + noise(i)).collect();
        let found = delay(&shot(), &noisy, RATE, 0.01).unwrap_or(f64::NAN);
        assert!((found - true_delay).abs() * RATE < 0.05, "{}", found * RATE);
    }

    #[test]
    fn an_early_record_has_a_negative_delay_and_a_silent_one_none() {
        let early = delayed(&shot(), RATE, -0.003);
        let found = delay(&shot(), &early, RATE, 0.01).unwrap_or(f64::NAN);
        assert!((found + 0.003).abs() < 1e-6, "{found}");
        assert_eq!(delay(&shot(), &vec![0.0; 16_000], RATE, 0.01), None);
    }
}

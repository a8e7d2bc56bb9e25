use nalgebra::Complex;
use rustfft::FftPlanner;
use std::f64::consts::PI;

/// The signal of a one-sided spectrum on evenly spaced bins, at any sampling rate \[1/s\], from t = 0 on; a row of `spectrum`
/// is a signal.
///
/// ```text
/// x(t_n) = 2 df Re sum_k X(f_k) e^{j 2 pi f_k t_n}
/// ```
///
/// The chirp transform (Rabiner, Schafer and Rader 1969): k n = (k² + n² - (n - k)²) / 2 makes the sum a convolution, so
/// that neither the bins' distance nor the number of samples has to suit the other. The sum repeats itself after 1/df; a
/// record of one event does not, and is zero from there on.
pub fn over_time(frequency: &[f64], spectrum: &[Complex<f64>], rate: f64, samples: usize) -> Vec<f64> {
    let mut record = vec![0.0; samples];
    let bins = frequency.len().min(spectrum.len());
    if bins < 2 {
        return record;
    }
    let df = (frequency[bins - 1] - frequency[0]) / (bins - 1) as f64;
    let samples = samples.min((rate / df).ceil() as usize);
    let step = df / rate;
    // pi step n² modulo 2 pi, n² exact in f64.
    let chirp = |n: usize| Complex::from_polar(1.0, PI * ((n * n) as f64 * step).rem_euclid(2.0));
    let length = (bins + samples - 1).next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut signal = vec![Complex::default(); length];
    for (k, (x, value)) in signal.iter_mut().zip(&spectrum[..bins]).enumerate() {
        *x = value * chirp(k);
    }
    let mut kernel = vec![Complex::default(); length];
    for (n, h) in kernel[..samples].iter_mut().enumerate() {
        *h = chirp(n).conj();
    }
    for k in 1..bins {
        kernel[length - k] = chirp(k).conj();
    }
    forward.process(&mut signal);
    forward.process(&mut kernel);
    signal.iter_mut().zip(&kernel).for_each(|(x, h)| *x *= h);
    inverse.process(&mut signal);
    let scale = 2.0 * df / length as f64;
    let first = frequency[0] / rate;
    for (n, (sample, x)) in record[..samples].iter_mut().zip(&signal).enumerate() {
        let turn = Complex::from_polar(scale, 2.0 * PI * (n as f64 * first).rem_euclid(1.0));
        *sample = (x * chirp(n) * turn).re;
    }
    record
}

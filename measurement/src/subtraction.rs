//! Subtraction of the residual's spectrum, line by line.
//!
//! ```text
//! G^2 = 1 - R^2/|S|^2   where 10 lg(|S|^2/R^2) >= beta,   else G = 0;      X = G S
//! ```
//!
//! S is the spectrum of a shot, R^2 the mean over the residual's shots, and X has the phase of S. For lines of a
//! Gaussian process, the rule overestimates, see [`expected_energy`].

use std::str::FromStr;

use serde::de::{IntoDeserializer, value};
use serde::{Deserialize, Serialize};

use nailnoise_acoustics::signals::REFERENCE_PRESSURE;

/// Least level difference of the survey method \[dB\] (ISO 3746:2010, 8.3.2), whose correction is 3.02 dB.
pub const SURVEY_LIMIT_DB: f64 = 3.0;

/// Which lines the subtraction sets to zero. The published rule, "lines below 3 dB", allows three readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// Lines less than 3 dB above the residual (ISO 3746)
    #[default]
    Margin,
    /// Lines whose corrected level is less than 3 dB above the residual, 4.8 dB before correction
    Corrected,
    /// Lines whose corrected level is less than 3 dB re 20 uPa
    Literal,
}

impl FromStr for Reading {
    type Err = value::Error;

    /// Parses a reading from its name in the result.
    fn from_str(word: &str) -> Result<Self, value::Error> {
        Self::deserialize(word.into_deserializer())
    }
}

impl Reading {
    /// G² for a line of |S|² and R² \[Pa² s²\], whose width is `df` \[Hz\].
    pub fn gain_squared(self, signal: f64, residual: f64, df: f64) -> f64 {
        let corrected = signal - residual;
        let limit = 10f64.powf(0.1 * SURVEY_LIMIT_DB);
        let kept = match self {
            Self::Margin => signal >= limit * residual,
            Self::Corrected => corrected >= limit * residual,
            // The exposure of the line over 1 s, 2 |X|^2 df.
            Self::Literal => 2.0 * corrected * df >= limit * REFERENCE_PRESSURE.powi(2),
        };
        if kept && corrected > 0.0 {
            corrected / signal
        } else {
            0.0
        }
    }
}

/// Mean of |X|² for complex Gaussian lines with mean energies `signal` a = E|S|² and `residual` b = E|R|², in the unit
/// of the energies. R² is the mean of `repeats` K residuals, and the limit is `limit_db` beta. The true value is a - b.
///
/// ```text
/// E|X|^2 = a q^-K + (g - 1) b q^(-K-1),   g = 10^(beta/10),   q = 1 + g b/(K a)
/// ```
///
/// |S|² is exponential with mean a, K R²/b a gamma variable of order K; both integrals of G²|S|² over |S|² > g R² are
/// elementary.
pub fn expected_energy(signal: f64, residual: f64, repeats: u32, limit_db: f64) -> f64 {
    let order = f64::from(repeats);
    let g = 10f64.powf(0.1 * limit_db);
    let q = 1.0 + g * residual / (order * signal);
    signal * q.powf(-order) + (g - 1.0) * residual * q.powf(-order - 1.0)
}

#[cfg(test)]
mod tests {
    use nailnoise_acoustics::random::uniform;

    use super::*;

    #[test]
    fn lines_below_the_margin_are_zero_and_lines_above_lose_the_residual() {
        let gain = |db: f64| Reading::Margin.gain_squared(10f64.powf(0.1 * db), 1.0, 1.0);
        assert_eq!(gain(2.999), 0.0);
        assert!((gain(3.001) - 0.4989).abs() < 5e-5, "{}", gain(3.001));
    }

    #[test]
    fn the_second_reading_begins_at_4_764_db() {
        let gain = |db: f64| Reading::Corrected.gain_squared(10f64.powf(0.1 * db), 1.0, 1.0);
        assert_eq!(gain(4.763), 0.0);
        assert!(gain(4.765) > 0.0);
    }

    #[test]
    fn the_third_reading_does_not_depend_on_the_residual() {
        let line = 0.5 * 10f64.powf(0.3) * REFERENCE_PRESSURE.powi(2);
        assert_eq!(Reading::Literal.gain_squared(0.999 * line, 0.0, 1.0), 0.0);
        assert_eq!(Reading::Literal.gain_squared(1.001 * line, 0.0, 1.0), 1.0);
    }

    #[test]
    fn without_a_residual_the_signal_stays_as_it_is() {
        assert_eq!(Reading::Margin.gain_squared(0.3, 0.0, 1.0), 1.0);
    }

    /// A silent source, a = b.
    #[test]
    fn a_silent_source_reads_a_third_to_a_half_of_the_residual() {
        assert!((expected_energy(1.0, 1.0, 1, 3.0) - 0.445).abs() < 5e-4);
        assert!((expected_energy(1.0, 1.0, 5, 3.0) - 0.319).abs() < 5e-4);
    }

    #[test]
    fn the_bias_falls_with_the_level_of_the_source() {
        let excess = |db: f64, repeats: u32| {
            let source = 10f64.powf(0.1 * db);
            10.0 * (expected_energy(1.0 + source, 1.0, repeats, 3.0) / source).log10()
        };
        let levels = [-3.0, 0.0, 3.0, 6.0, 10.0];
        let by_five = [1.475, 0.567, 0.165, 0.037, 0.004];
        let by_one = [2.180, 0.971, 0.337, 0.089, 0.010];
        for ((db, five), one) in levels.into_iter().zip(by_five).zip(by_one) {
            assert!((excess(db, 5) - five).abs() < 6e-4, "{db}: {}", excess(db, 5));
            assert!((excess(db, 1) - one).abs() < 6e-4, "{db}: {}", excess(db, 1));
        }
    }

    /// The closed form, compared with the rule itself for random lines.
    #[test]
    fn drawn_lines_have_the_expected_energy() {
        const N: u64 = 200_000;
        let (a, b, repeats) = (2.0, 1.0, 5);
        let exponential = |mean: f64, line: u64, place: u64| -mean * (1.0 - uniform(7, line, place)).ln();
        let of_line = |line: u64| {
            let signal = exponential(a, line, 0);
            let residual = (1..=repeats).map(|k| exponential(b, line, k)).sum::<f64>() / repeats as f64;
            signal * Reading::Margin.gain_squared(signal, residual, 1.0)
        };
        let mean = (0..N).map(of_line).sum::<f64>() / N as f64;
        let expected = expected_energy(a, b, repeats as u32, 3.0);
        assert!((mean / expected - 1.0).abs() < 0.02, "{mean} for {expected}");
    }
}

//! One-second spectra: lines 1 Hz apart, band energies, and reconstruction of signals.

use std::f64::consts::PI;

use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_acoustics::signals::{Band, Weighting, energy_weights, third_octaves};
use nalgebra::Complex;

/// Length of the analysed section of a record \[s\].
pub const LENGTH: f64 = 1.0;

/// Part of that section before the trigger \[s\].
pub const BEFORE: f64 = 0.01;

/// Length of the half-cosine tapers at the ends of a record \[s\].
const TAPER: f64 = 5e-3;

/// Transforms of records of one second at one sampling rate.
#[derive(Clone)]
pub struct OneSecond {
    rate: f64,
    transform: RealTransform,
}

impl OneSecond {
    /// For a sampling rate \[1/s\].
    pub fn new(rate: f64) -> Self {
        Self {
            rate,
            transform: RealTransform::new((rate * LENGTH).round() as usize),
        }
    }

    /// Spacing of the lines \[Hz\].
    pub fn df(&self) -> f64 {
        self.rate / self.samples() as f64
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.transform.length()
    }

    /// Frequencies of the lines \[Hz\].
    pub fn frequencies(&self) -> Vec<f64> {
        (0..=self.samples() / 2).map(|k| k as f64 * self.df()).collect()
    }

    /// The second of a record that begins [`BEFORE`] the trigger, which is at `trigger` \[s\] from the record's start;
    /// the record has half-cosine tapers, and is padded with zeros. The first taper ends before the trigger.
    pub fn cut(&self, record: &[f64], trigger: f64) -> Vec<f64> {
        let start = ((trigger - BEFORE) * self.rate).round() as i64;
        let begin = start.max(0) as usize;
        let end = record.len().min((start + self.samples() as i64).max(0) as usize);
        let mut piece = vec![0.0; self.samples()];
        if begin < end {
            let kept = &record[begin..end];
            let at = (begin as i64 - start) as usize;
            piece[at..at + kept.len()].copy_from_slice(kept);
            let lead = ((trigger * self.rate).round() as usize).saturating_sub(begin);
            taper(&mut piece[at..at + kept.len()], self.rate, lead);
        }
        piece
    }

    /// X(f) = dt sum x e^(-j 2 pi f t) \[unit s\] of a one-second section.
    pub fn lines(&self, piece: &[f64]) -> Vec<Complex<f64>> {
        let mut lines = self.transform.lines(piece);
        lines.iter_mut().for_each(|x| *x /= self.rate);
        lines
    }

    /// The one-second section with these lines.
    pub fn signal(&self, lines: &[Complex<f64>]) -> Vec<f64> {
        self.transform.signal(lines.iter().map(|x| x * self.rate).collect())
    }
}

/// Applies half-cosine tapers of 5 ms, shorter for shorter records; the first has at most `lead` samples.
fn taper(record: &mut [f64], rate: f64, lead: usize) {
    let count = ((TAPER * rate).round() as usize).min(record.len() / 2);
    let rise = |i: usize, count: usize| 0.5 * (1.0 - (PI * (i as f64 + 0.5) / count as f64).cos());
    let first = count.min(lead);
    (record.iter_mut().take(first).enumerate()).for_each(|(i, x)| *x *= rise(i, first));
    (record.iter_mut().rev().take(count).enumerate()).for_each(|(i, x)| *x *= rise(i, count));
}

/// Band energies of spectra: A-weighted over a range, and in one-third octaves.
#[derive(Debug, Clone)]
pub struct Bands {
    /// Weights of the lines for the A-weighted energy of the range.
    a_weighted: Vec<f64>,
    /// Nominal mid-band frequency \[Hz\], first line, and weights from there on.
    bands: Vec<(f64, usize, Vec<f64>)>,
}

impl Bands {
    /// Creates bands for lines at these frequencies, within `range` \[Hz\]; a band cut by the range contains only the
    /// part inside.
    pub fn new(frequencies: &[f64], range: [f64; 2]) -> Self {
        let top = frequencies.last().copied().unwrap_or(0.0);
        let range = [range[0], range[1].min(top)];
        let bands = third_octaves()
            .into_iter()
            .filter(|band| band.low.max(range[0]) < band.high.min(range[1]));
        let weights = |band: Band| {
            let cut = [band.low.max(range[0]), band.high.min(range[1])];
            let mut weights = energy_weights(frequencies, cut, Weighting::A);
            let first = weights.iter().position(|w| *w > 0.0).unwrap_or(0);
            let end = weights.iter().rposition(|w| *w > 0.0).map_or(0, |last| last + 1);
            weights.truncate(end);
            weights.drain(..first.min(end));
            (band.nominal_hz(), first, weights)
        };
        Self {
            a_weighted: energy_weights(frequencies, range, Weighting::A),
            bands: bands.map(weights).collect(),
        }
    }

    /// Nominal mid-band frequencies \[Hz\].
    pub fn nominal_hz(&self) -> Vec<f64> {
        self.bands.iter().map(|band| band.0).collect()
    }

    /// A-weighted energy, int 2 |X|² df, of lines \[unit² s\].
    pub fn energy(&self, lines: &[Complex<f64>]) -> f64 {
        weighted(&self.a_weighted, lines)
    }

    /// The same for each band.
    pub fn band_energies(&self, lines: &[Complex<f64>]) -> Vec<f64> {
        let of_band = |(_, first, weights): &(f64, usize, Vec<f64>)| weighted(weights, &lines[*first..]);
        self.bands.iter().map(of_band).collect()
    }
}

fn weighted(weights: &[f64], lines: &[Complex<f64>]) -> f64 {
    weights.iter().zip(lines).map(|(w, x)| w * 2.0 * x.norm_sqr()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn burst(rate: f64, hz: f64) -> Vec<f64> {
        let sample = |i: usize| {
            let t = i as f64 / rate;
            (-t / 0.02).exp() * (2.0 * PI * hz * t).sin()
        };
        (0..(1.2 * rate) as usize).map(sample).collect()
    }

    #[test]
    fn lines_return_the_signal() {
        let transform = OneSecond::new(8000.0);
        let piece = transform.cut(&burst(8000.0, 500.0), BEFORE);
        let back = transform.signal(&transform.lines(&piece));
        assert!(back.iter().zip(&piece).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn lines_hold_the_energy_of_the_signal() {
        let transform = OneSecond::new(8000.0);
        let piece = transform.cut(&burst(8000.0, 500.0), BEFORE);
        let lines = transform.lines(&piece);
        let by_time: f64 = piece.iter().map(|x| x * x / 8000.0).sum();
        let by_lines: f64 = lines.iter().map(|x| 2.0 * x.norm_sqr() * transform.df()).sum();
        assert!((by_lines / by_time - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_signal_after_the_trigger_is_whole_where_the_record_begins_late() {
        let transform = OneSecond::new(1000.0);
        for lead in [0, 1, 4, 5, 9] {
            let piece = transform.cut(&[1.0; 500], 1e-3 * lead as f64);
            assert!(piece[10..].iter().take(400).all(|x| *x == 1.0), "{lead}");
        }
    }

    #[test]
    fn a_record_begins_before_the_trigger_and_is_padded_where_it_lacks_samples() {
        let transform = OneSecond::new(1000.0);
        let piece = transform.cut(&vec![1.0; 500], 0.004);
        // 6 ms of zeros, the record, zeros again.
        assert_eq!(piece.len(), 1000);
        assert!(piece[..6].iter().all(|x| *x == 0.0) && piece[6] > 0.0);
        assert!(piece[505] > 0.0 && piece[506..].iter().all(|x| *x == 0.0));
        assert_eq!(piece[250], 1.0);
    }

    #[test]
    fn pieces_of_a_signal_sum_to_the_whole_over_all_frequencies() {
        let transform = OneSecond::new(8000.0);
        let piece = transform.cut(&burst(8000.0, 500.0), BEFORE);
        let energy = |x: &[f64]| -> f64 { transform.lines(x).iter().map(Complex::norm_sqr).sum() };
        let mut parts = 0.0;
        for cut in [0..300, 300..2000, 2000..8000] {
            let mut part = vec![0.0; piece.len()];
            part[cut.clone()].copy_from_slice(&piece[cut]);
            parts += energy(&part);
        }
        // The lines at 0 Hz and at half the rate count once in the exact sum; here they are negligible.
        assert!((parts / energy(&piece) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn bands_sum_to_the_energy_of_the_range_that_they_cover() {
        let transform = OneSecond::new(48_000.0);
        let lines = transform.lines(&transform.cut(&burst(48_000.0, 700.0), BEFORE));
        let edges = third_octaves();
        let (first, last) = (edges[2], edges[20]);
        let bands = Bands::new(&transform.frequencies(), [first.low, last.high]);
        let sum: f64 = bands.band_energies(&lines).iter().sum();
        assert_eq!(bands.nominal_hz().len(), 19);
        assert!((sum / bands.energy(&lines) - 1.0).abs() < 1e-10);
    }
}

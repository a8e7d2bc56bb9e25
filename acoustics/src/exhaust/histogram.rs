/// Points per decade of the frequency lattice.
const PER_DECADE: f64 = 160.0;
/// lg of the lattice's first frequency, and its number of points: 0.1 Hz to 10 MHz.
const START: f64 = -1.0;
const POINTS: usize = 1281;

/// Energy by the frequency at which its spectrum peaks, on a logarithmic lattice.
///
/// Spectra of one shape that slide along the frequency axis add up to a convolution of this histogram with the shape,
/// so that a record of any length costs one deposit per sample. Sharing a deposit between two lattice points conserves
/// energy exactly and is an interpolation of second order in the lattice width of 1.4 %.
pub(super) struct PeakHistogram {
    energy: Vec<f64>,
}

impl PeakHistogram {
    pub(super) fn new() -> Self {
        Self {
            energy: vec![0.0; POINTS],
        }
    }

    pub(super) fn deposit(&mut self, peak_hz: f64, energy: f64) {
        let x = ((peak_hz.log10() - START) * PER_DECADE).clamp(0.0, (POINTS - 1) as f64);
        let i = (x as usize).min(POINTS - 2);
        let share = x - i as f64;
        self.energy[i] += (1.0 - share) * energy;
        self.energy[i + 1] += share * energy;
    }

    /// Energy density \[J/Hz\] at rising frequencies of spectra with the given shape (per ln f, over f/f_peak).
    pub(super) fn spread(&self, shape: impl Fn(f64) -> f64, frequency: &[f64]) -> Vec<f64> {
        let (Some(&low), Some(&high)) = (frequency.first(), frequency.last()) else {
            return Vec::new();
        };
        let used: Vec<usize> = (0..POINTS).filter(|&i| self.energy[i] > 0.0).collect();
        let (Some(&first), Some(&last)) = (used.first(), used.last()) else {
            return vec![0.0; frequency.len()];
        };
        let place = |hz: f64| (hz.log10() - START) * PER_DECADE;
        let (from, to) = (place(low).floor() as i64, place(high).ceil() as i64 + 1);
        // Shape at every difference of lattice points that occurs.
        let least = from - last as i64;
        let table: Vec<f64> = (least..=to - first as i64)
            .map(|d| shape(10f64.powf(d as f64 / PER_DECADE)))
            .collect();
        let lattice: Vec<f64> = (from..=to)
            .map(|i| {
                let sum: f64 = used
                    .iter()
                    .map(|&b| self.energy[b] * table[(i - b as i64 - least) as usize])
                    .sum();
                sum.ln()
            })
            .collect();
        let value = |&hz: &f64| {
            let x = place(hz) - from as f64;
            let i = (x as usize).min(lattice.len() - 2);
            let share = x - i as f64;
            ((1.0 - share) * lattice[i] + share * lattice[i + 1]).exp() / hz
        };
        frequency.iter().map(value).collect()
    }
}

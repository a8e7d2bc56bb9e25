/// Points per decade of the frequency lattice.
const PER_DECADE: f64 = 160.0;
/// lg of the lattice's first frequency, and its number of points: 0.1 Hz to 10 MHz.
const START: f64 = -1.0;
const POINTS: usize = 1281;

/// Distribution of energy over the peak frequency of its spectrum, on a logarithmic lattice.
///
/// Spectra of the same shape, shifted along the logarithmic frequency axis, sum to a convolution of this histogram with
/// the shape. A record of any length therefore costs one deposit per sample. Each deposit is shared between two lattice
/// points, which conserves energy exactly and amounts to second-order interpolation at the lattice spacing of 1.4 %.
pub(super) struct PeakHistogram {
    energy: Vec<f64>,
}

/// Lattice point below the frequency, and the share of the one above it.
fn place(peak_hz: f64) -> (usize, f64) {
    let x = position(peak_hz).clamp(0.0, (POINTS - 1) as f64);
    let i = (x as usize).min(POINTS - 2);
    (i, x - i as f64)
}

fn position(hz: f64) -> f64 {
    (hz.log10() - START) * PER_DECADE
}

/// Cubic interpolation between lattice points; linear in the lattice's values, so that it has an adjoint.
struct Stencil {
    /// First of the four points, relative to the start of the lattice section.
    first: usize,
    weights: [f64; 4],
}

/// A section of the lattice that covers a range of frequencies, with the shape around every lattice point.
struct Stretch {
    from: i64,
    to: i64,
    least: i64,
    table: Vec<f64>,
}

impl Stretch {
    /// Creates a section for peaks at the lattice points `first` to `last`.
    fn new(shape: impl Fn(f64) -> f64, low: f64, high: f64, first: usize, last: usize) -> Self {
        let (from, to) = (position(low).floor() as i64 - 1, position(high).floor() as i64 + 2);
        let least = from - last as i64;
        let table = (least..=to - first as i64)
            .map(|d| shape(10f64.powf(d as f64 / PER_DECADE)))
            .collect();
        Self { from, to, least, table }
    }

    /// The shape of a peak at lattice point `peak`, evaluated at every point of the section.
    fn around(&self, peak: usize) -> &[f64] {
        let start = (self.from - peak as i64 - self.least) as usize;
        &self.table[start..=start + (self.to - self.from) as usize]
    }

    fn stencil(&self, hz: f64) -> Stencil {
        let x = position(hz) - self.from as f64;
        // Points i - 1 to i + 2 around x; the section has one extra point at either end.
        let i = (x as usize).clamp(1, (self.to - self.from) as usize - 2);
        let s = x - i as f64;
        let weights = [
            -s * (s - 1.0) * (s - 2.0) / 6.0,
            (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
            -(s + 1.0) * s * (s - 2.0) / 2.0,
            (s + 1.0) * s * (s - 1.0) / 6.0,
        ];
        Stencil { first: i - 1, weights }
    }
}

impl PeakHistogram {
    pub(super) fn new() -> Self {
        Self {
            energy: vec![0.0; POINTS],
        }
    }

    pub(super) fn deposit(&mut self, peak_hz: f64, energy: f64) {
        let (i, share) = place(peak_hz);
        self.energy[i] += (1.0 - share) * energy;
        self.energy[i + 1] += share * energy;
    }

    /// Energy density \[J/Hz\] of spectra of the given shape, at the frequencies of `shape`.
    pub(super) fn spread(&self, shape: &Spreading) -> Vec<f64> {
        let Some(stretch) = &shape.stretch else {
            return Vec::new();
        };
        let mut lattice = vec![0.0; (stretch.to - stretch.from + 1) as usize];
        for (peak, &energy) in self.energy.iter().enumerate().filter(|(_, energy)| **energy > 0.0) {
            let shape = stretch.around(peak);
            lattice.iter_mut().zip(shape).for_each(|(sum, g)| *sum += energy * g);
        }
        let value = |(hz, Stencil { first, weights }): &(f64, Stencil)| {
            let points = &lattice[*first..first + 4];
            weights.iter().zip(points).map(|(w, g)| w * g).sum::<f64>() / hz
        };
        shape.stencils.iter().map(value).collect()
    }
}

/// A spectral shape (per ln f, as a function of f/f_peak) at ascending frequencies, for peaks anywhere on the lattice.
pub(super) struct Spreading {
    /// None if there are no frequencies.
    stretch: Option<Stretch>,
    /// Every frequency with its position on the lattice.
    stencils: Vec<(f64, Stencil)>,
}

impl Spreading {
    pub(super) fn new(shape: impl Fn(f64) -> f64, frequency: &[f64]) -> Self {
        let ends = frequency.first().zip(frequency.last());
        let stretch = ends.map(|(&low, &high)| Stretch::new(shape, low, high, 0, POINTS - 1));
        let place = |stretch: &Stretch| frequency.iter().map(|&hz| (hz, stretch.stencil(hz))).collect();
        let stencils = stretch.as_ref().map(place).unwrap_or_default();
        Self { stretch, stencils }
    }
}

/// Weighted sum of a spectrum over frequencies, as a function of its peak frequency.
///
/// The adjoint of [`PeakHistogram::spread`]: the weighted sums for single deposits add up to that of the spread
/// spectrum, to rounding.
pub(super) struct PeakWeights {
    weight: Vec<f64>,
}

impl PeakWeights {
    /// Creates the weights for spectra of the given shape and the sum sum_k w_k E(f_k).
    pub(super) fn new(
        shape: impl Fn(f64) -> f64,
        frequency: &[f64],
        weights: &[f64],
        peaks: impl Iterator<Item = f64>,
    ) -> Self {
        let mut weight = vec![0.0; POINTS];
        let mut wanted = vec![false; POINTS];
        for (i, _) in peaks.map(place) {
            (wanted[i], wanted[i + 1]) = (true, true);
        }
        let used: Vec<usize> = (0..POINTS).filter(|&i| wanted[i]).collect();
        let (Some(&low), Some(&high), Some(&first), Some(&last)) =
            (frequency.first(), frequency.last(), used.first(), used.last())
        else {
            return Self { weight };
        };
        let stretch = Stretch::new(shape, low, high, first, last);
        let mut lattice = vec![0.0; (stretch.to - stretch.from + 1) as usize];
        for (&hz, w) in frequency.iter().zip(weights) {
            let Stencil { first, weights } = stretch.stencil(hz);
            let points = &mut lattice[first..first + 4];
            points.iter_mut().zip(weights).for_each(|(sum, s)| *sum += w / hz * s);
        }
        for peak in used {
            let shape = stretch.around(peak);
            weight[peak] = lattice.iter().zip(shape).map(|(c, g)| c * g).sum();
        }
        Self { weight }
    }

    /// The weighted sum of a unit-energy spectrum that peaks at `peak_hz`.
    pub(super) fn of(&self, peak_hz: f64) -> f64 {
        let (i, share) = place(peak_hz);
        (1.0 - share) * self.weight[i] + share * self.weight[i + 1]
    }
}

//! A sampled resistance in another air, and one that goes on where another ends.

use super::SampledRadiation;
use crate::radiation::interval::Interval;

impl SampledRadiation {
    /// In an air in which every wavelength has its frequency times `speed`, and times `factor` at each frequency \[Hz\] of
    /// that air: R(f) = factor(f) R0(f/speed).
    ///
    /// Named `method` then. The factor is interpolated with R; what that misses adds to
    /// [`SampledRadiation::interpolation_error`].
    #[must_use]
    pub(crate) fn in_air(mut self, method: &str, speed: f64, factor: impl Fn(f64) -> f64) -> Self {
        self.method = method.to_owned();
        for interval in &mut self.intervals {
            *interval = interval.stretched(speed);
        }
        for sample in &mut self.samples {
            sample.hz *= speed;
            sample.patches.scale(factor(sample.hz));
        }
        for (root, sample) in self.roots.iter_mut().zip(&self.samples) {
            root.iter_mut().for_each(|root| root.scale(factor(sample.hz).sqrt()));
        }
        self.error += self.intervals.iter().map(|i| missed(i, &factor)).fold(0.0, f64::max);
        self
    }

    /// This up to its highest frequency, `above` from there on, with the numbers of the samples of `above` that come after
    /// its own, in their order; patches of this that `above` has not are silent there.
    pub(crate) fn continued(mut self, above: Self) -> (Self, Vec<usize>) {
        let end = self.intervals.last().map_or(0.0, |i| i.high);
        let own = self.samples.len();
        let later: Vec<Interval> = above.intervals.into_iter().filter(|i| i.high > end).collect();
        let used = |sample: usize| later.iter().any(|interval| interval.nodes.contains(&sample));
        let (mut numbers, mut taken) = (vec![None; above.samples.len()], Vec::new());
        let mut roots = above.roots.into_iter();
        self.roots.resize_with(own, || None);
        for (number, mut sample) in above.samples.into_iter().enumerate() {
            let root = roots.next().flatten();
            if used(number) {
                numbers[number] = Some(self.samples.len());
                taken.push(number);
                sample.patches.add_silent(self.patches.len());
                self.samples.push(sample);
                self.roots.push(root);
            }
        }
        for mut interval in later {
            interval.nodes = interval.nodes.iter().filter_map(|&node| numbers[node]).collect();
            self.intervals.push(interval);
        }
        self.error = self.error.max(above.error);
        (self, taken)
    }
}

/// Largest relative error of a factor that an interval interpolates, half way between its samples.
fn missed(interval: &Interval, factor: &impl Fn(f64) -> f64) -> f64 {
    let hz = interval.samples_hz();
    let mut rising = hz.to_vec();
    rising.sort_by(f64::total_cmp);
    let known: Vec<f64> = hz.iter().map(|&hz| factor(hz)).collect();
    let at = |ends: &[f64]| {
        let middle = 0.5 * (ends[0] + ends[1]);
        let found: f64 = interval.weights(middle).iter().zip(&known).map(|(w, f)| w * f).sum();
        (found / factor(middle) - 1.0).abs()
    };
    rising.windows(2).map(at).fold(0.0, f64::max)
}

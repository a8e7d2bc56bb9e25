use crate::radiation::{AveragedResistance, Erp, ModalRadiation, Resistance, SampledRadiation};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Width of the transition from single frequencies to averages, in octaves below the upper end of single frequencies.
const FADING: f64 = 1.0 / 12.0;

/// Radiation resistance of one parity over all frequencies. It combines boundary elements at single frequencies, on
/// meshes that become finer with frequency; above these, boundary elements averaged over frequency bands; and finally
/// the high-frequency limit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct CompositeRadiation {
    /// Ranges of single frequencies; each begins where the previous one ends.
    levels: Vec<SampledRadiation>,
    above: AveragedResistance,
    /// Number of nodes of `above` that come from boundary elements; the others come from the limit.
    solved: usize,
    /// The limit at frequencies for which boundary-element results are also available.
    limit: AveragedResistance,
    erp: Erp,
    from_hz: f64,
    to_hz: f64,
}

/// Radiation of a body above the range of single frequencies.
pub(crate) struct HighFrequencyRadiation {
    /// Averages of boundary elements, followed by the limit.
    pub(crate) means: AveragedResistance,
    /// Number of nodes that come from boundary elements.
    pub(crate) solved: usize,
    /// The limit at frequencies for which boundary-element results are also available.
    pub(crate) limit: AveragedResistance,
}

impl CompositeRadiation {
    /// Joins ranges of single frequencies, in ascending order without gaps, with the radiation above them.
    pub(crate) fn new(levels: Vec<SampledRadiation>, above: HighFrequencyRadiation, erp: Erp) -> Self {
        let to_hz = levels.last().map_or(0.0, ModalRadiation::highest_hz);
        Self {
            levels,
            above: above.means,
            solved: above.solved,
            limit: above.limit,
            erp,
            from_hz: to_hz * 2f64.powf(-FADING),
            to_hz,
        }
    }

    /// Combines the first `count` patches into one called `name`.
    #[must_use]
    pub(crate) fn with_sum_of_patches(&self, count: usize, name: &str) -> Self {
        let of_level = |level: &SampledRadiation| level.with_sum_of_patches(count, name);
        Self {
            levels: self.levels.iter().map(of_level).collect(),
            above: self.above.with_sum_of_patches(count),
            limit: self.limit.with_sum_of_patches(count),
            erp: self.erp.with_sum_of_patches(count, name),
            ..*self
        }
    }

    /// The ranges of single frequencies.
    pub(crate) fn levels(&self) -> &[SampledRadiation] {
        &self.levels
    }

    /// The equivalent radiated power.
    pub(crate) fn erp(&self) -> &Erp {
        &self.erp
    }

    /// Transition from single frequencies to averages: start and end \[Hz\].
    pub(crate) fn solved_hz(&self) -> [f64; 2] {
        [self.from_hz, self.to_hz]
    }

    /// Transition from averaged boundary elements to the limit: start and end \[Hz\].
    pub(crate) fn transition_hz(&self) -> [f64; 2] {
        let node = |n: usize| self.above.hz().get(n).or(self.above.hz().last()).map_or(0.0, |hz| *hz);
        [node(self.solved - 1), node(self.solved)]
    }

    /// The lowest frequency at which the limit was evaluated \[Hz\].
    pub(crate) fn limit_from_hz(&self) -> f64 {
        self.limit.hz()[0]
    }

    /// Energy forms from the limit only, where boundary-element results are also available.
    pub(crate) fn limit_alone(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = DMatrix::zeros(self.patches().len(), frequency.len());
        let all = vec![1.0; frequency.len()];
        self.limit.add_forms((frequency, &all), accelerations, &mut forms);
        forms
    }

    /// Weight of the averages: 0 below the transition, 1 above it, sin² of the logarithmic frequency in between.
    fn share(&self, hz: f64) -> f64 {
        let t = ((hz / self.from_hz).ln() / (self.to_hz / self.from_hz).ln()).clamp(0.0, 1.0);
        (0.5 * PI * t).sin().powi(2)
    }

    fn shares(&self, frequency: &[f64]) -> Vec<f64> {
        frequency.iter().map(|&hz| self.share(hz)).collect()
    }

    fn level_at(&self, hz: f64) -> usize {
        let last = self.levels.len() - 1;
        self.levels.iter().position(|l| hz <= l.highest_hz()).unwrap_or(last)
    }

    /// Runs of bins below the end of the transition that use the same range: index of the range, and the half-open
    /// range of bins.
    pub(crate) fn runs(&self, frequency: &[f64]) -> Vec<(usize, usize, usize)> {
        let mut runs: Vec<(usize, usize, usize)> = Vec::new();
        for (bin, &hz) in frequency.iter().enumerate().filter(|(_, hz)| **hz < self.to_hz) {
            let level = self.level_at(hz);
            match runs.last_mut() {
                Some((last, _, end)) if *last == level && *end == bin => *end = bin + 1,
                _ => runs.push((level, bin, bin + 1)),
            }
        }
        runs
    }
}

impl ModalRadiation for CompositeRadiation {
    fn method(&self) -> &str {
        "BEM"
    }

    fn modes(&self) -> usize {
        self.erp.modes()
    }

    fn patches(&self) -> &[String] {
        self.erp.patches()
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        let share = self.share(hz);
        let mut whole = Resistance::zeros(self.modes());
        if share < 1.0 {
            whole.add_scaled(1.0 - share, &self.levels[self.level_at(hz)].resistance(hz));
        }
        if share > 0.0 {
            whole.add_scaled(share, &self.above.resistance(hz));
        }
        whole
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |motion: &(f64, Vec<(usize, f64)>)| {
            let (hz, one) = (motion.0, std::slice::from_ref(motion));
            let of = |radiation: &dyn ModalRadiation| radiation.sparse_forms(one).iter().sum::<f64>();
            let share = self.share(hz);
            let low = (share < 1.0).then(|| (1.0 - share) * of(&self.levels[self.level_at(hz)]));
            let high = (share > 0.0).then(|| share * self.above.sparse_form(hz, &motion.1));
            low.unwrap_or(0.0) + high.unwrap_or(0.0)
        };
        motions.par_iter().map(form).collect()
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = DMatrix::zeros(self.patches().len(), frequency.len());
        self.above
            .add_forms((frequency, &self.shares(frequency)), accelerations, &mut forms);
        for (level, start, end) in self.runs(frequency) {
            let part = accelerations.columns(start, end - start).into_owned();
            let low = self.levels[level].energy_forms(&frequency[start..end], &part);
            for (bin, from) in (start..end).zip(low.column_iter()) {
                forms.column_mut(bin).axpy(1.0 - self.share(frequency[bin]), &from, 1.0);
            }
        }
        forms
    }

    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut images = DMatrix::zeros(self.modes(), frequency.len());
        self.above
            .add_images((frequency, &self.shares(frequency)), accelerations, &mut images);
        for (level, start, end) in self.runs(frequency) {
            let part = accelerations.columns(start, end - start).into_owned();
            let low = self.levels[level].images(&frequency[start..end], &part);
            for (bin, from) in (start..end).zip(low.column_iter()) {
                let share = Complex::from(1.0 - self.share(frequency[bin]));
                images.column_mut(bin).axpy(share, &from, Complex::from(1.0));
            }
        }
        images
    }

    fn signals(&self) -> usize {
        2 * self.modes()
    }

    /// Signals of all parts, weighted with the square roots of their shares, so that energies add exactly. The first
    /// half of the rows contains single frequencies and every second node above, the second half the remaining nodes;
    /// two parts in the same row never overlap in frequency.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let modes = self.modes();
        let shares = self.shares(frequency);
        let mut signals = DMatrix::zeros(2 * modes, frequency.len());
        self.above
            .add_root_signals((frequency, &shares), accelerations, &mut signals);
        for (level, start, end) in self.runs(frequency) {
            let part = accelerations.columns(start, end - start).into_owned();
            let mut low = self.levels[level].root_signals(&frequency[start..end], &part);
            for (mut bin, &hz) in low.column_iter_mut().zip(&frequency[start..end]) {
                bin *= Complex::from((1.0 - self.share(hz)).sqrt());
            }
            let mut to = signals.view_mut((0, start), (modes, end - start));
            to += low;
        }
        signals
    }
}

use crate::error::AcousticsError;
use crate::radiation::{Archive, ArchiveReader, ArchiveWriter, Erp, ModalRadiation, Resistance, SampledRadiation};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of an octave over which boundary elements give way to the equivalent radiated power.
const BLEND_OCTAVES: f64 = 1.0 / 3.0;

/// Radiation resistance from boundary elements on meshes that get finer with frequency, and the equivalent radiated
/// power above their range.
#[derive(Debug, Clone)]
pub struct BlendedRadiation {
    /// Each from where the one before ends.
    levels: Vec<SampledRadiation>,
    erp: Erp,
    from_hz: f64,
    to_hz: f64,
}

impl BlendedRadiation {
    /// Joins ranges of boundary elements, rising, each beginning where the one before ends, with the limit above.
    pub(super) fn new(levels: Vec<SampledRadiation>, erp: Erp) -> Self {
        let to_hz = levels.last().map_or(0.0, ModalRadiation::highest_hz);
        Self {
            levels,
            erp,
            from_hz: to_hz * 2f64.powf(-BLEND_OCTAVES),
            to_hz,
        }
    }

    /// The ranges of boundary elements.
    pub fn levels(&self) -> &[SampledRadiation] {
        &self.levels
    }

    /// The limit above them.
    pub fn erp(&self) -> &Erp {
        &self.erp
    }

    /// Where the blend begins and ends \[Hz\].
    pub fn blend_hz(&self) -> [f64; 2] {
        [self.from_hz, self.to_hz]
    }

    /// Energy forms without the limit, up to the end of the blend.
    pub(super) fn elements_alone(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = DMatrix::zeros(self.patches().len(), frequency.len());
        for (level, start, end) in self.runs(frequency) {
            let part = accelerations.columns(start, end - start).into_owned();
            let found = self.levels[level].energy_forms(&frequency[start..end], &part);
            forms.columns_mut(start, end - start).copy_from(&found);
        }
        forms
    }

    /// Share of the equivalent radiated power: 0 below the blend, 1 above it, sin² of the logarithmic frequency between.
    fn share(&self, hz: f64) -> f64 {
        let t = ((hz / self.from_hz).ln() / (self.to_hz / self.from_hz).ln()).clamp(0.0, 1.0);
        (0.5 * PI * t).sin().powi(2)
    }

    fn level_at(&self, hz: f64) -> usize {
        let last = self.levels.len() - 1;
        self.levels.iter().position(|l| hz <= l.highest_hz()).unwrap_or(last)
    }

    /// Runs of bins below the end of the blend that share a level: the level and the bins' half-open range.
    pub(super) fn runs(&self, frequency: &[f64]) -> Vec<(usize, usize, usize)> {
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

impl ModalRadiation for BlendedRadiation {
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
            whole.add_scaled(share, &self.erp.resistance(hz));
        }
        whole
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |motion: &(f64, Vec<(usize, f64)>)| {
            let (hz, one) = (motion.0, std::slice::from_ref(motion));
            let of = |radiation: &dyn ModalRadiation| radiation.sparse_forms(one).iter().sum::<f64>();
            let share = self.share(hz);
            let low = (share < 1.0).then(|| (1.0 - share) * of(&self.levels[self.level_at(hz)]));
            let high = (share > 0.0).then(|| share * of(&self.erp));
            low.unwrap_or(0.0) + high.unwrap_or(0.0)
        };
        motions.par_iter().map(form).collect()
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = self.erp.energy_forms(frequency, accelerations);
        for (mut bin, &hz) in forms.column_iter_mut().zip(frequency) {
            bin *= self.share(hz);
        }
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
        let mut images = self.erp.images(frequency, accelerations);
        for (mut bin, &hz) in images.column_iter_mut().zip(frequency) {
            bin *= Complex::from(self.share(hz));
        }
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

    /// The signals of both laws, one below the other, with the roots of their shares: energies add up exactly.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let modes = self.modes();
        let high = self.erp.root_signals(frequency, accelerations);
        let mut signals = DMatrix::zeros(2 * modes, frequency.len());
        for (bin, &hz) in frequency.iter().enumerate() {
            let factor = Complex::from(self.share(hz).sqrt());
            signals
                .view_mut((modes, bin), (modes, 1))
                .copy_from(&(high.column(bin) * factor));
        }
        for (level, start, end) in self.runs(frequency) {
            let part = accelerations.columns(start, end - start).into_owned();
            let mut low = self.levels[level].root_signals(&frequency[start..end], &part);
            for (mut bin, &hz) in low.column_iter_mut().zip(&frequency[start..end]) {
                bin *= Complex::from((1.0 - self.share(hz)).sqrt());
            }
            signals.view_mut((0, start), (modes, end - start)).copy_from(&low);
        }
        signals
    }
}

impl Archive for BlendedRadiation {
    fn write(&self, to: &mut ArchiveWriter) {
        to.list(&self.levels);
        self.erp.write(to);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let levels: Vec<SampledRadiation> = from.list()?;
        if levels.is_empty() {
            return Err(from.damaged());
        }
        Ok(Self::new(levels, Erp::read(from)?))
    }
}

//! The power of part of a surface in the sound field of the complete surface.

use super::energy::{radiated_energy, radiated_signals};
use super::operator::ModalRadiation;
use super::spectra::ModalSpectra;
use crate::error::AcousticsError;
use crate::signals::{IntervalLevels, PowerHistory, PowerSignals, SignalAnalysis, SourceSpectrum};
use nalgebra::Complex;

/// The energy of part i of a surface: its own term and half of each cross term with the rest.
///
/// ```text
/// E_i = 2 Re(V_i^H R sum_j V_j) = [E(V + V_i) - E(V - V_i)] / 4,      V = sum_j V_j,   E(V) = 2 V^H R V
/// ```
///
/// R is symmetric. The energies of all parts therefore add up to the total. A part that absorbs more sound from the
/// others than it radiates has negative energy.
#[derive(Debug, Clone)]
pub struct PartOfSurface {
    /// Its energy over frequency, which may have either sign.
    pub spectrum: SourceSpectrum,
    /// V + V_i and V - V_i over time.
    signals: [PowerSignals; 2],
}

impl PartOfSurface {
    /// The part of a surface that moves according to `spectra`. The modes of `radiation` are each mode of the surface,
    /// followed by each mode with only the part in motion.
    ///
    /// # Errors
    /// Those of [`radiated_energy`]; also if the number of modes is not half that of `radiation`.
    pub fn new(
        source: impl Into<String>,
        radiation: &dyn ModalRadiation,
        spectra: &ModalSpectra,
    ) -> Result<Self, AcousticsError> {
        let of = |sign: f64| {
            let part = ModalSpectra {
                accelerations: &spectra.accelerations * Complex::from(sign),
                ..spectra.clone()
            };
            let both = ModalSpectra::side_by_side(&[spectra, &part]);
            let energy = radiated_energy("part", radiation, &both)?;
            let signals = radiated_signals(radiation, &both, &energy)?;
            Ok::<_, AcousticsError>((energy, signals))
        };
        let ((sum, of_sum), (difference, of_difference)) = (of(1.0)?, of(-1.0)?);
        let pairs = sum.energy_density.iter().zip(&difference.energy_density);
        let density = pairs.map(|(sum, difference)| 0.25 * (sum - difference)).collect();
        Ok(Self {
            spectrum: SourceSpectrum::new(source, sum.method, sum.frequency, density, sum.range_hz)?,
            signals: [of_sum, of_difference],
        })
    }

    /// The larger of the two signals' mismatches with their energies, see [`PowerSignals::mismatch`].
    pub fn mismatch(&self) -> f64 {
        self.signals.iter().map(PowerSignals::mismatch).fold(0.0, f64::max)
    }

    /// A-weighted power over time, and energies between adjacent `edges` \[s\] within `range_hz`, which may have either
    /// sign, see [`PowerSignals::analyse`].
    pub fn analyse(&self, edges: &[f64], range_hz: [f64; 2]) -> SignalAnalysis {
        let [sum, difference] = self.signals.each_ref().map(|signals| signals.analyse(edges, range_hz));
        let pairs = sum.history.power.iter().zip(&difference.history.power);
        SignalAnalysis {
            history: PowerHistory {
                power: pairs.map(|(sum, difference)| 0.25 * (sum - difference)).collect(),
                ..sum.history
            },
            intervals: IntervalLevels::sum(&[
                IntervalLevels::scaled(&sum.intervals, 0.25),
                IntervalLevels::scaled(&difference.intervals, -0.25),
            ]),
        }
    }
}

//! The power of a part of a surface in the sound field of the whole.

use super::energy::{radiated_energy, radiated_signals};
use super::operator::ModalRadiation;
use super::spectra::ModalSpectra;
use crate::error::AcousticsError;
use crate::signals::{IntervalLevels, PowerHistory, PowerSignals, SignalAnalysis, SourceSpectrum};
use nalgebra::Complex;

/// The energy of a part i of a surface: its own term and half of each cross term with the rest.
///
/// ```text
/// E_i = 2 Re(V_i^H R sum_j V_j) = [E(V + V_i) - E(V - V_i)] / 4,      V = sum_j V_j,   E(V) = 2 V^H R V
/// ```
///
/// R is symmetric. The energies of all parts therefore add up to that of the whole. A part that absorbs more of the
/// sound of the others than it radiates has a negative energy.
#[derive(Debug, Clone)]
pub struct PartOfSurface {
    /// Its energy over frequency, of either sign.
    pub spectrum: SourceSpectrum,
    /// V + V_i and V - V_i over time.
    signals: [PowerSignals; 2],
}

impl PartOfSurface {
    /// The part of a surface that moves as `spectra` says. `radiation` has each mode of the surface, followed by each
    /// mode with only the part in motion.
    ///
    /// # Errors
    /// As [`radiated_energy`]; a number of modes other than half that of `radiation`.
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

    /// The larger mismatch of both signals with their energies, see [`PowerSignals::mismatch`].
    pub fn mismatch(&self) -> f64 {
        self.signals.iter().map(PowerSignals::mismatch).fold(0.0, f64::max)
    }

    /// A-weighted power over time and energies between neighbouring `edges` \[s\] within `range_hz`, of either sign,
    /// see [`PowerSignals::analyse`].
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

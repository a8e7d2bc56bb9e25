use super::erp::Erp;
use super::operator::ModalRadiation;
use super::resistance::Resistance;
use crate::air::Air;
use crate::checks::{InputError, positive};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

/// Equivalent radiated power times the radiation efficiency of an oscillating sphere, for a body that is small compared
/// with the wavelength and whose opposite sides move in opposite directions.
///
/// ```text
/// sigma = (k a)^4 / (4 + (k a)^4)        a = (3 V / 4 pi)^{1/3},  V the body's volume
/// ```
///
/// This is exact for a rigid sphere (Morse and Ingard 1968, Theoretical Acoustics, sec. 7.1). Modes without net
/// momentum radiate less at low frequencies; vibrating plates radiate more near coincidence.
#[derive(Debug, Clone)]
pub struct CompactErp {
    erp: Erp,
    volume: f64,
    air: Air,
}

/// Radiation efficiency of an oscillating sphere with the given volume \[m3\], see [`CompactErp`].
pub fn sphere_efficiency(volume: f64, air: &Air, hz: f64) -> f64 {
    let ka4 = (2.0 * PI * hz * (0.75 * volume / PI).cbrt() / air.sound_speed).powi(4);
    ka4 / (4.0 + ka4)
}

impl CompactErp {
    /// The operator of a body with the given volume \[m3\], from the equivalent radiated power of its surface.
    ///
    /// # Errors
    /// If the volume is not positive.
    pub fn new(erp: Erp, volume: f64, air: &Air) -> Result<Self, InputError> {
        positive("volume of the body [m3]", volume)?;
        Ok(Self { erp, volume, air: *air })
    }

    /// The sphere's radiation efficiency.
    pub fn efficiency(&self, hz: f64) -> f64 {
        sphere_efficiency(self.volume, &self.air, hz)
    }
}

impl ModalRadiation for CompactErp {
    fn method(&self) -> &str {
        "ERP as compact body"
    }

    fn modes(&self) -> usize {
        self.erp.modes()
    }

    fn patches(&self) -> &[String] {
        self.erp.patches()
    }

    fn highest_hz(&self) -> f64 {
        self.erp.highest_hz()
    }

    fn resistance(&self, hz: f64) -> Resistance {
        let mut whole = self.erp.resistance(hz);
        whole.real *= self.efficiency(hz);
        whole
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = self.erp.energy_forms(frequency, accelerations);
        for (mut bin, &hz) in forms.column_iter_mut().zip(frequency) {
            bin *= self.efficiency(hz);
        }
        forms
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut signals = self.erp.root_signals(frequency, accelerations);
        for (mut bin, &hz) in signals.column_iter_mut().zip(frequency) {
            bin *= Complex::from(self.efficiency(hz).sqrt());
        }
        signals
    }
}

use crate::checks::{InputError, positive};
use serde::{Deserialize, Serialize};

/// Specific gas constant of dry air \[J/(kg K)\] (ISO 2533).
pub const GAS_CONSTANT: f64 = 287.052_874;
/// Ratio of the specific heats of air.
pub const HEAT_RATIO: f64 = 1.4;

/// The air around the tool, a perfect gas at rest.
///
/// ```text
/// rho0 = P_a / (R T_a)        c0 = sqrt(gamma R T_a)
/// ```
///
/// At 20 °C and 101 325 Pa: 1.204 kg/m³ and 343.2 m/s. Humidity is left out: it changes c0 by less than 0.4 % and
/// rho0 by less than 1 % at room temperature, together below 0.05 dB.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Air {
    /// Ambient temperature T_a \[K\].
    pub temperature: f64,
    /// Ambient pressure P_a \[Pa\].
    pub pressure: f64,
    /// Density rho0 \[kg/m³\].
    pub density: f64,
    /// Speed of sound c0 \[m/s\].
    pub sound_speed: f64,
}

impl Air {
    /// Air at `temperature` \[K\] and `pressure` \[Pa\].
    ///
    /// # Errors
    /// [`InputError::NotPositive`] for a temperature or pressure that is not above zero.
    pub fn at(temperature: f64, pressure: f64) -> Result<Self, InputError> {
        positive("ambient temperature [K]", temperature)?;
        positive("ambient pressure [Pa]", pressure)?;
        Ok(Self::perfect_gas(temperature, pressure))
    }

    /// Characteristic impedance rho0 c0 \[Pa s/m\].
    pub fn impedance(&self) -> f64 {
        self.density * self.sound_speed
    }

    pub(crate) fn perfect_gas(temperature: f64, pressure: f64) -> Self {
        Self {
            temperature,
            pressure,
            density: pressure / (GAS_CONSTANT * temperature),
            sound_speed: (HEAT_RATIO * GAS_CONSTANT * temperature).sqrt(),
        }
    }
}

impl Default for Air {
    /// 20 °C and one standard atmosphere.
    fn default() -> Self {
        Self::perfect_gas(293.15, 101_325.0)
    }
}

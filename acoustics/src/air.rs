use crate::checks::{InputError, positive};
use serde::{Deserialize, Serialize};

/// Specific gas constant R of dry air \[J/(kg K)\] (ISO 2533).
pub const GAS_CONSTANT: f64 = 287.052_874;
/// Ratio gamma of the specific heats of air.
pub const HEAT_RATIO: f64 = 1.4;

/// The air around the tool, modelled as a perfect gas at rest.
///
/// ```text
/// rho0 = P_a / (R T_a)        c0 = sqrt(gamma R T_a)
/// ```
///
/// At 20 °C and 101 325 Pa: 1.204 kg/m³ and 343.2 m/s. Humidity is neglected. At room temperature it changes c0 by less
/// than 0.4 % and rho0 by less than 1 %; both together change levels by less than 0.05 dB.
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
    /// Specific gas constant R \[J/(kg K)\].
    pub gas_constant: f64,
    /// Ratio gamma of the specific heats.
    pub heat_ratio: f64,
}

impl Air {
    /// Dry air at `temperature` \[K\] and `pressure` \[Pa\].
    ///
    /// # Errors
    /// [`InputError::NotPositive`] unless temperature and pressure are above zero.
    pub fn at(temperature: f64, pressure: f64) -> Result<Self, InputError> {
        Self::default().in_state(temperature, pressure)
    }

    /// A perfect gas with specific gas constant R \[J/(kg K)\] and heat capacity ratio gamma, in the same state.
    ///
    /// # Errors
    /// [`InputError`] unless the gas constant is above zero and the ratio above 1.
    pub fn of_gas(self, gas_constant: f64, heat_ratio: f64) -> Result<Self, InputError> {
        positive("specific gas constant [J/(kg K)]", gas_constant)?;
        positive("ratio of the specific heats, less 1", heat_ratio - 1.0)?;
        Ok(Self {
            gas_constant,
            heat_ratio,
            ..self
        }
        .perfect_gas(self.temperature, self.pressure))
    }

    /// The same gas at another temperature \[K\] and pressure \[Pa\].
    ///
    /// # Errors
    /// [`InputError::NotPositive`] unless temperature and pressure are above zero.
    pub fn in_state(self, temperature: f64, pressure: f64) -> Result<Self, InputError> {
        positive("ambient temperature [K]", temperature)?;
        positive("ambient pressure [Pa]", pressure)?;
        Ok(self.perfect_gas(temperature, pressure))
    }

    /// Characteristic impedance rho0 c0 \[Pa s/m\].
    pub fn impedance(&self) -> f64 {
        self.density * self.sound_speed
    }

    /// The same gas in a state already known to be valid.
    pub(crate) fn perfect_gas(self, temperature: f64, pressure: f64) -> Self {
        Self {
            temperature,
            pressure,
            density: pressure / (self.gas_constant * temperature),
            sound_speed: (self.heat_ratio * self.gas_constant * temperature).sqrt(),
            ..self
        }
    }
}

impl Default for Air {
    /// 20 °C and one standard atmosphere.
    fn default() -> Self {
        Self {
            temperature: 293.15,
            pressure: 101_325.0,
            density: 0.0,
            sound_speed: 0.0,
            gas_constant: GAS_CONSTANT,
            heat_ratio: HEAT_RATIO,
        }
        .perfect_gas(293.15, 101_325.0)
    }
}

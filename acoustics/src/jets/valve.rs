use super::error::ExhaustError;
use super::opening::FlowHistory;
use crate::air::Air;
use crate::checks::positive;
use serde::{Deserialize, Serialize};
use std::f64::consts::SQRT_2;

/// Ratio of inlet pressure to the jet's recovered pressure above which the acoustical efficiency is constant.
const CONSTANT_EFFICIENCY: f64 = 22.0;

/// Efficiency exponent A_eta and peak Strouhal number St_p of a valve, with its pressure recovery.
///
/// IEC 60534-8-3:2010, table 4, lists typical A_eta and St_p for each type of valve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ValveNoise {
    /// Exponent A_eta of the acoustical efficiency factor 10^A_eta; it includes the share that enters the pipe.
    pub efficiency_exponent: f64,
    /// Strouhal number St_p at the peak of the spectrum in third octaves.
    pub peak_strouhal: f64,
    /// Liquid pressure recovery factor F_L, or F_LP/F_P of a valve with fittings; 1 without recovery.
    pub recovery: f64,
}

impl ValveNoise {
    /// The edition that the formulas follow.
    pub const STANDARD: &str = "IEC 60534-8-3:2010";

    /// A plate with drilled holes (A_eta -4.8, St_p 0.2) that discharges without recovery, like an exhaust.
    pub const DRILLED_PLATE: Self = Self {
        efficiency_exponent: -4.8,
        peak_strouhal: 0.2,
        recovery: 1.0,
    };
}

/// A steady flow of a perfect gas through a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveFlow {
    /// Mass flow \[kg/s\].
    pub mass_flow: f64,
    /// Absolute pressure upstream of the valve \[Pa\].
    pub inlet_pressure: f64,
    /// Absolute pressure downstream of the valve \[Pa\].
    pub outlet_pressure: f64,
    /// Density upstream of the valve \[kg/m³\].
    pub inlet_density: f64,
    /// Ratio of the specific heats.
    pub heat_ratio: f64,
}

/// The five flow regimes, in the order of increasing pressure difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum FlowRegime {
    /// I: subsonic.
    Subsonic,
    /// II: sonic in the vena contracta, with downstream recompression.
    Recompressed,
    /// III: no recompression; turbulent shear flow prevails.
    Choked,
    /// IV: the shock cells end in a Mach disc.
    MachDisc,
    /// V: constant acoustical efficiency.
    ConstantEfficiency,
}

/// Noise of the flow through a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveSound {
    /// Regime of the flow.
    pub regime: FlowRegime,
    /// Mach number of the vena contracta in regime I, otherwise of the freely expanded jet.
    pub mach: f64,
    /// Stream power W_m \[W\].
    pub stream_power: f64,
    /// Acoustical efficiency eta.
    pub efficiency: f64,
    /// Product of the peak frequency and the jet diameter, f_p D_j \[m/s\].
    pub peak_speed: f64,
}

impl ValveSound {
    /// Sound power W_a = eta W_m \[W\].
    pub fn power(&self) -> f64 {
        self.efficiency * self.stream_power
    }
}

impl ValveNoise {
    /// Noise of a flow by IEC 60534-8-3:2010, 5.2 and table 3, with x = (p_1 - p_2)/p_1.
    ///
    /// ```text
    /// x_vcc = 1 - (2/(g+1))^(g/(g-1))     x_C = F_L^2 x_vcc          alpha = (1 - x_vcc)/(1 - x_C)
    /// x_B = 1 - (1/g)^(g/(g-1))/alpha     x_CE = 1 - 1/(22 alpha)
    /// I    x <= x_C     M_vc^2 = 2/(g-1) [(1 - x/F_L^2)^((1-g)/g) - 1]   eta = 10^A F_L^2 M_vc^3
    /// II   x <= x_vcc   M_j^2 = 2/(g-1) [(alpha (1-x))^((1-g)/g) - 1]    eta = 10^A (x/x_vcc) M_j^(6.6 F_L^2)
    /// III  x <= x_B                                                      eta = 10^A M_j^(6.6 F_L^2)
    /// IV   x <= x_CE                                                     eta = 10^A (M_j^2/2) sqrt2^(6.6 F_L^2)
    /// V    above        M_j at alpha (1-x) = 1/22                        as in IV
    /// W_m = m' (M_vc c_vc)^2/2 in I, else m' c_vcc^2/2
    /// f_p D_j = St_p M_vc c_vc (I), St_p M_j c_vcc (II, III), 1.4 St_p c_vcc/(M_j^2 - 1)^1/2 (IV, V)
    /// ```
    ///
    /// # Errors
    /// If a mass flow, pressure or density is not positive, or the heat ratio is not above 1. `None` unless the
    /// pressure falls in the direction of the flow.
    pub fn sound(&self, flow: &ValveFlow) -> Result<Option<ValveSound>, ExhaustError> {
        positive("mass flow through the valve [kg/s]", flow.mass_flow)?;
        positive("pressure before the valve [Pa]", flow.inlet_pressure)?;
        positive("pressure behind the valve [Pa]", flow.outlet_pressure)?;
        positive("density before the valve [kg/m³]", flow.inlet_density)?;
        positive("ratio of the specific heats less one", flow.heat_ratio - 1.0)?;
        Ok((flow.outlet_pressure < flow.inlet_pressure).then(|| self.of(flow)))
    }

    /// Same as `sound` for a flow from a higher to a lower pressure.
    fn of(&self, flow: &ValveFlow) -> ValveSound {
        let (g, f2) = (flow.heat_ratio, self.recovery * self.recovery);
        let x = 1.0 - flow.outlet_pressure / flow.inlet_pressure;
        let sonic = (2.0 / (g + 1.0)).powf(g / (g - 1.0));
        let (x_vcc, x_c) = (1.0 - sonic, f2 * (1.0 - sonic));
        let alpha = sonic / (1.0 - x_c);
        let x_b = 1.0 - (1.0 / g).powf(g / (g - 1.0)) / alpha;
        let x_ce = 1.0 - 1.0 / (CONSTANT_EFFICIENCY * alpha);
        // Mach number after isentropic expansion from the inlet to a fraction of its pressure.
        let mach = |ratio: f64| (2.0 / (g - 1.0) * (ratio.powf((1.0 - g) / g) - 1.0)).sqrt();
        let factor = 10f64.powf(self.efficiency_exponent);
        let stagnation2 = g * flow.inlet_pressure / flow.inlet_density;
        if x <= x_c {
            let ratio = 1.0 - x / f2;
            let m = mach(ratio);
            let speed = m * (stagnation2 * ratio.powf((g - 1.0) / g)).sqrt();
            return ValveSound {
                regime: FlowRegime::Subsonic,
                mach: m,
                stream_power: 0.5 * flow.mass_flow * speed * speed,
                efficiency: factor * f2 * m.powi(3),
                peak_speed: self.peak_strouhal * speed,
            };
        }
        let m = mach((alpha * (1.0 - x)).max(1.0 / CONSTANT_EFFICIENCY));
        let sonic2 = 2.0 / (g + 1.0) * stagnation2;
        let (rising, shocks) = (m.powf(6.6 * f2), 0.5 * m * m * SQRT_2.powf(6.6 * f2));
        let (jet, cells) = (m * sonic2.sqrt(), 1.4 * sonic2.sqrt() / (m * m - 1.0).sqrt());
        let (regime, shape, peak) = match x {
            x if x <= x_vcc => (FlowRegime::Recompressed, x / x_vcc * rising, jet),
            x if x <= x_b => (FlowRegime::Choked, rising, jet),
            x if x <= x_ce => (FlowRegime::MachDisc, shocks, cells),
            _ => (FlowRegime::ConstantEfficiency, shocks, cells),
        };
        ValveSound {
            regime,
            mach: m,
            stream_power: 0.5 * flow.mass_flow * sonic2,
            efficiency: factor * shape,
            peak_speed: self.peak_strouhal * peak,
        }
    }

    /// Sound energy of the outflow of a record \[J\]: a second estimate of the jet noise. Inflow is silent.
    ///
    /// The standard describes valves in pipes; its efficiency for holes in free air is an extrapolation.
    pub fn energy(&self, history: &FlowHistory, air: &Air) -> f64 {
        let power = |sample: usize| {
            let (mass_flow, pressure) = (history.mass_flow[sample], history.pressure[sample]);
            let outlet = history.surroundings(sample, air).pressure;
            let flow = ValveFlow {
                mass_flow,
                inlet_pressure: pressure,
                outlet_pressure: outlet,
                inlet_density: pressure / (air.gas_constant * history.temperature[sample]),
                heat_ratio: air.heat_ratio,
            };
            if mass_flow > 0.0 && pressure > outlet {
                self.of(&flow).power()
            } else {
                0.0
            }
        };
        (0..history.mass_flow.len()).map(power).sum::<f64>() * history.sample_interval
    }
}

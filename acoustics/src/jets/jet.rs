use crate::air::Air;

/// A jet fully expanded to ambient pressure.
///
/// ```text
/// M_j^2 = 2/(g-1) [(P/P_a)^((g-1)/g) - 1]        T_j = T / (1 + (g-1)/2 M_j^2)
/// U_j = M_j sqrt(g R T_j)                        rho_j = P_a / (R T_j)
/// D_j/d = [(1 + (g-1)/2 M_j^2) / ((g+1)/2)]^((g+1)/(4(g-1))) M_j^{-1/2}     for M_j > 1, else 1
/// ```
///
/// The expansion is isentropic and the gas perfect, like the air around the tool; D_j follows from mass conservation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    /// Mach number M_j.
    pub mach: f64,
    /// Static temperature T_j \[K\].
    pub temperature: f64,
    /// Velocity U_j \[m/s\].
    pub velocity: f64,
    /// Density rho_j \[kg/m³\].
    pub density: f64,
    /// Ratio D_j/d of its diameter to that of the hole.
    pub diameter_ratio: f64,
}

impl Jet {
    /// Expands from stagnation pressure \[Pa\] and temperature \[K\]; `None` unless the pressure exceeds the ambient
    /// one.
    pub fn expand(pressure: f64, temperature: f64, air: &Air) -> Option<Self> {
        if pressure.is_nan() || pressure <= air.pressure {
            return None;
        }
        let (g, gas_constant) = (air.heat_ratio, air.gas_constant);
        // 1 + (g-1)/2 M_j^2 is the ratio of stagnation to static temperature.
        let ratio = (pressure / air.pressure).powf((g - 1.0) / g);
        let mach = (2.0 / (g - 1.0) * (ratio - 1.0)).sqrt();
        let static_temperature = temperature / ratio;
        let diameter_ratio = if mach > 1.0 {
            (ratio / (0.5 * (g + 1.0))).powf(0.25 * (g + 1.0) / (g - 1.0)) / mach.sqrt()
        } else {
            1.0
        };
        Some(Self {
            mach,
            temperature: static_temperature,
            velocity: mach * (g * gas_constant * static_temperature).sqrt(),
            density: air.pressure / (gas_constant * static_temperature),
            diameter_ratio,
        })
    }

    /// Total area A_j of the expanded jets, given the effective area A \[m²\].
    pub fn area(&self, effective_area: f64) -> f64 {
        effective_area * self.diameter_ratio * self.diameter_ratio
    }

    /// Mass flow rho_j U_j A_j \[kg/s\].
    pub fn mass_flow(&self, effective_area: f64) -> f64 {
        self.density * self.velocity * self.area(effective_area)
    }

    /// beta² = M_j² - 1, negative below Mach 1.
    pub fn beta_squared(&self) -> f64 {
        self.mach * self.mach - 1.0
    }
}

//! Bars of an elastic impact of a driver on a fastener.

use serde::Serialize;

/// A uniform bar.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rod {
    /// Length \[m\].
    pub length: f64,
    /// A, cross-section \[m2\].
    pub area: f64,
    /// E, Young's modulus \[Pa\].
    pub modulus: f64,
    /// rho, density \[kg/m3\].
    pub density: f64,
}

impl Rod {
    /// c = sqrt(E/rho), speed of longitudinal waves \[m/s\].
    pub fn wave_speed(&self) -> f64 {
        (self.modulus / self.density).sqrt()
    }

    /// rho A L, mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.density * self.area * self.length
    }
}

/// Bars of a driver and a fastener, and the wood around the fastener.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ElasticBlow {
    /// Index in [`Assembly::fasteners`](super::Assembly::fasteners).
    pub fastener: usize,
    /// The section of the driver that strikes the fastener. The rest of the driver's mass is at its upper end.
    pub rod: Rod,
    /// The shanks of the fastener side by side, as one bar. The rest of the fastener's mass is at its upper end.
    pub shank: Rod,
    /// Sum of the shanks' perimeters \[m\].
    pub perimeter: f64,
    /// Area of the head \[m2\].
    pub head_area: f64,
    /// Density of the wood \[kg/m3\].
    pub wood_density: f64,
    /// Speed of shear waves in the wood \[m/s\].
    pub shear_speed: f64,
}

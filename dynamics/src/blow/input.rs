//! Inputs of a blow, from the blocks of an assembly.

use nailnoise_penetration::Shanks;
use serde::Serialize;

use crate::network::assembly::{Assembly, Base, ElasticBlow, Fastener};

/// Elements along the nail; with steel, a step of 0.18 us for a 12d nail.
const NAIL_ELEMENTS: usize = 64;

/// Linear bulk viscosity, which damps the oscillations of single elements after contacts (J. von Neumann and R. D.
/// Richtmyer, J. Appl. Phys. 21, 232, 1950).
const VISCOSITY: f64 = 0.2;

/// Maximum mass of the rod relative to the driver's mass.
const LARGEST_ROD: f64 = 0.9;

/// Inputs of a blow other than the histories of its cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlowInput {
    /// Rod, shank and wood.
    pub bars: ElasticBlow,
    /// The fastener, with the law of the wood's resistance.
    pub fastener: Fastener,
    /// Friction along the shank as a fraction of the resistance at full depth, for laws that do not state it.
    pub friction_share: f64,
    /// Mass of the driver \[kg\].
    pub driver_mass: f64,
    /// Acceleration of gravity on driver and fastener, down \[m/s2\].
    pub gravity: f64,
    /// Number of elements along the shank.
    pub elements: usize,
    /// Linear bulk viscosity b: the stress b rho c h dv/dx of an element of the length h.
    pub viscosity: f64,
    /// Name of the driving body.
    pub driver: String,
    /// Name of the body that the fastener enters; `None` for the ground.
    pub work: Option<String>,
    /// Name of the body that guides the fastener; `None` for the ground.
    pub guide: Option<String>,
}

impl BlowInput {
    /// The blow on a fastener of an assembly, by its index; `None` if its blow is rigid. A rod that is heavier than 0.9
    /// of the driver's mass is shortened to that mass.
    pub fn of(assembly: &Assembly, fastener: usize) -> Option<Self> {
        let mut bars = *assembly.blows.iter().find(|blow| blow.fastener == fastener)?;
        let fastener = assembly.fasteners.get(fastener)?.clone();
        let driver = assembly.bodies.get(fastener.driver)?;
        let longest = bars.rod.length * LARGEST_ROD * driver.mass / bars.rod.mass();
        bars.rod.length = bars.rod.length.min(longest);
        let name = |base: Base| match base {
            Base::Body(index) => assembly.bodies.get(index).map(|body| body.name.clone()),
            Base::Ground => None,
        };
        Some(Self {
            bars,
            driver_mass: driver.mass,
            gravity: driver.gravity,
            friction_share: Shanks::SMOOTH.friction_share,
            elements: NAIL_ELEMENTS,
            viscosity: VISCOSITY,
            driver: driver.name.clone(),
            work: name(fastener.into),
            guide: name(fastener.guide),
            fastener,
        })
    }
}

//! Effects of the fluid on the modes of radiating bodies.

use crate::radiation::ModalRadiation;
use crate::radiation::fluid_loading::{FluidLoadingError, WetModes};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Which part of the radiation impedance Z = R + jX acts on the modes of a structure.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Loading {
    /// None: the motion is that in vacuum.
    None,
    /// R as damping.
    #[default]
    Damping,
    /// R and X: damping and added mass.
    Full,
}

impl Loading {
    /// Whether R acts.
    pub fn damps(self) -> bool {
        self != Self::None
    }
}

/// Returns an error if the mass should act but the method does not model it.
pub(crate) fn needs_no_mass(acts: Loading, method: &'static str) -> Result<(), FluidLoadingError> {
    match acts {
        Loading::Full => Err(FluidLoadingError::NoReactance { method }),
        Loading::None | Loading::Damping => Ok(()),
    }
}

/// The effects of the fluid on each mode of a body, for unit modal mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FluidLoads {
    /// Damping ratio R_jj/(2 omega_j) at the mode's resonance in vacuum \[-\].
    pub damping: Vec<f64>,
    /// Added mass X_jj/omega at the mode's resonance in the fluid \[-\]; none if the method provides no reactance.
    pub mass: Option<Vec<f64>>,
    /// Ratio of R_jj at the resonance in the fluid to that in vacuum \[-\].
    pub resistance_ratio: Vec<f64>,
    /// The modes including the fluid's mass, if it acts on the motion.
    pub wet: Option<WetModes>,
}

impl FluidLoads {
    /// For a method that provides no reactance.
    pub(crate) fn damping_only(damping: Vec<f64>) -> Self {
        Self {
            resistance_ratio: vec![1.0; damping.len()],
            damping,
            mass: None,
            wet: None,
        }
    }

    /// Creates the loads from the damping ratios, from a function that returns a diagonal element of X/omega (given a
    /// mode's index and the frequency in hertz), and from R_jj of `radiation`. `first` is the index of the body's first
    /// mode in `radiation`.
    pub(crate) fn new(
        damping: Vec<f64>,
        omega: &[f64],
        (first, radiation): (usize, &dyn ModalRadiation),
        mass_at: impl Fn(usize, f64) -> f64,
    ) -> Self {
        let lowest = TAU;
        let in_fluid = |w: f64, m: f64| w / (1.0 + m.max(0.0)).sqrt();
        let of_mode = |(j, &w): (usize, &f64)| {
            let dry = mass_at(j, w.max(lowest) / TAU);
            mass_at(j, in_fluid(w, dry).max(lowest) / TAU)
        };
        let mass: Vec<f64> = omega.iter().enumerate().map(of_mode).collect();
        let resistances = |scale: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let at = |(j, w): (usize, &f64)| {
                let hz = (scale(j) * w.max(lowest) / TAU).min(radiation.highest_hz());
                (hz, vec![(first + j, 1.0)])
            };
            radiation.sparse_forms(&omega.iter().enumerate().map(at).collect::<Vec<_>>())
        };
        let (dry, wet) = (resistances(&|_| 1.0), resistances(&|j| in_fluid(1.0, mass[j])));
        let ratio = |(dry, wet): (f64, f64)| if dry > 0.0 { (wet / dry).max(0.0) } else { 1.0 };
        Self {
            resistance_ratio: dry.into_iter().zip(wet).map(ratio).collect(),
            damping,
            mass: Some(mass),
            wet: None,
        }
    }

    /// Ratio of a mode's radiated energy with the fluid's mass to that without.
    ///
    /// An impulse p excites the mode, which then decays at its resonance:
    ///
    /// ```text
    /// E = (p/m)² R(w)/(4 zeta w),  m = 1 + M,  w = Omega/sqrt(m)   =>   E/E_dry = m^-3/2 R(w)/R(Omega)
    /// ```
    pub(crate) fn of_mass(&self, mode: usize) -> f64 {
        let mass = self.mass.as_ref().map_or(0.0, |mass| mass[mode].max(0.0));
        (1.0 + mass).powf(-1.5) * self.resistance_ratio[mode]
    }

    /// Ratio of a mode's radiated energy without radiation damping to that with it: (zeta + zeta_r)/zeta, where zeta is
    /// the damping ratio of the structure.
    pub(crate) fn of_damping(&self, mode: usize, zeta: f64) -> f64 {
        if zeta > 0.0 {
            1.0 + self.damping[mode] / zeta
        } else {
            1.0
        }
    }
}

//! Measured drives, prepared for regression: conditions, and points of depth, speed and force.

use serde::{Deserialize, Serialize};

use super::form::{Values, Variable};
use crate::Specimen;

/// How a nail was driven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Driving {
    /// At constant speed, by a testing machine.
    Constant {
        /// v \[m/s\].
        speed: f64,
    },
    /// By a projectile that hits the nail.
    Impact {
        /// M, mass of the projectile \[kg\].
        mass: f64,
        /// v0, its speed just before it hits the nail \[m/s\].
        speed: f64,
    },
}

impl Driving {
    /// Whether the nail was driven at constant speed.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant { .. })
    }
}

/// The conditions of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Nail and wood.
    pub specimen: Specimen,
    /// How the nail was driven.
    pub driving: Driving,
}

impl Conditions {
    /// The variables at `depth` \[m\] and penetration speed `speed` \[m/s\].
    pub fn values(&self, depth: f64, speed: f64) -> Values {
        let s = &self.specimen;
        let inertia_per_square = s.length * s.density / s.hardness_modulus;
        let mut values = [f64::NAN; _];
        let mut set = |variable: Variable, value: f64| values[variable as usize] = value;
        set(Variable::X, depth / s.length);
        set(Variable::Slender, s.diameter / s.length);
        set(Variable::Rate, inertia_per_square * speed * speed);
        if let Driving::Impact { mass, speed: v0 } = self.driving {
            set(Variable::Inertia, inertia_per_square * v0 * v0);
            set(Variable::Decay, speed / v0);
            set(
                Variable::Energy,
                mass * v0 * v0 / (s.hardness_modulus * s.length * s.length),
            );
        }
        values
    }

    /// H_M NL, force at s = 1 \[N\].
    pub fn force_scale(&self) -> f64 {
        self.specimen.hardness_modulus * self.specimen.length
    }

    /// s = sqrt(F_r/(H_M NL)); zero unless the force is positive.
    pub fn root(&self, force: f64) -> f64 {
        (force.max(0.0) / self.force_scale()).sqrt()
    }
}

/// One point of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// y, depth of the tip \[m\].
    pub depth: f64,
    /// v, speed of penetration \[m/s\].
    pub speed: f64,
    /// s = sqrt(F_r/(H_M NL)) \[-\].
    pub root: f64,
}

/// One recorded drive of a nail.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Its name.
    pub id: String,
    /// Identifier of the test condition; repeats share it.
    pub group: String,
    /// Name of the nail size.
    pub nail: String,
    /// Name of the wood.
    pub wood: String,
    /// Its conditions.
    pub conditions: Conditions,
    /// Its points.
    pub points: Vec<Point>,
}

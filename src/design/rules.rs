//! Rules that several groups of quantities share: the order of lengths, and elastic constants that a solid can have.

use nailnoise_fem::{FemError, Material};
use nalgebra::Matrix3;

use super::conflict::Conflict;
use super::groups::Orthotropic;

/// Returns the conflict if its condition is met.
pub(crate) fn refuse(broken: bool, conflict: Conflict) -> Result<(), Conflict> {
    if broken { Err(conflict) } else { Ok(()) }
}

/// A length in a rule: its key, or a term with keys in backticks, and its value \[m\].
pub(crate) type Length = (&'static str, f64);

/// Conflict unless `value` is below `limit`.
pub(crate) fn below((small, value): Length, (large, limit): Length, because: &'static str) -> Result<(), Conflict> {
    let order = Conflict::Order {
        small,
        value,
        large,
        limit,
        strict: true,
        because,
    };
    refuse(value >= limit, order)
}

/// Conflict unless `value` is at most `limit`.
pub(crate) fn at_most((small, value): Length, (large, limit): Length, because: &'static str) -> Result<(), Conflict> {
    let order = Conflict::Order {
        small,
        value,
        large,
        limit,
        strict: false,
        because,
    };
    refuse(value > limit, order)
}

/// Conflict for elastic constants that no solid can have: [`Material::orthotropic`] states the condition.
pub(crate) fn elastic(group: &'static str, constants: &Orthotropic) -> Result<(), Conflict> {
    match Material::orthotropic(constants, &Matrix3::identity(), 1.0) {
        Err(FemError::NotPositiveDefinite { eigenvalue }) => Err(Conflict::NotElastic { group, eigenvalue }),
        _ => Ok(()),
    }
}

/// Conflict for a Poisson's ratio of 0.5 and more.
pub(crate) fn incompressible(key: &'static str, value: f64) -> Result<(), Conflict> {
    refuse(value >= 0.5, Conflict::Incompressible { key, value })
}

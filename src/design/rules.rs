//! Rules that several groups of quantities share: an order of lengths, and elastic constants that a solid can have.

use super::conflict::Conflict;
use super::groups::Orthotropic;

/// A conflict where its condition is met.
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

/// Positive definiteness of the compliance of an orthotropic solid: with r_ij = nu_ij sqrt(E_j/E_i), every 1 - r_ij^2 >
/// 0 and 1 - r_12^2 - r_13^2 - r_23^2 - 2 r_12 r_13 r_23 > 0; the shear moduli are positive anyway.
pub(crate) fn elastic(group: &'static str, c: &Orthotropic) -> Result<(), Conflict> {
    let r12 = c.nu12 * (c.e2 / c.e1).sqrt();
    let r13 = c.nu13 * (c.e3 / c.e1).sqrt();
    let r23 = c.nu23 * (c.e3 / c.e2).sqrt();
    for (minor, value) in [
        ("1 - nu_12 nu_21", 1.0 - r12 * r12),
        ("1 - nu_13 nu_31", 1.0 - r13 * r13),
        ("1 - nu_23 nu_32", 1.0 - r23 * r23),
        (
            "1 - nu_12 nu_21 - nu_13 nu_31 - nu_23 nu_32 - 2 nu_21 nu_32 nu_13",
            1.0 - r12 * r12 - r13 * r13 - r23 * r23 - 2.0 * r12 * r13 * r23,
        ),
    ] {
        refuse(value <= 0.0, Conflict::NotElastic { group, minor, value })?;
    }
    Ok(())
}

/// Conflict for a Poisson's ratio of 0.5 and more.
pub(crate) fn incompressible(key: &'static str, value: f64) -> Result<(), Conflict> {
    refuse(value >= 0.5, Conflict::Incompressible { key, value })
}

//! Checks that a uniform pressure does not move a body.

use super::place::error_of;
use crate::network::assembly::{Assembly, Push};
use crate::network::text::blocks::unbalanced;
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// Relative difference of areas attributed to rounding.
const ROUNDING: f64 = 1e-9;

/// Checks that the areas that push each body down and up are equal.
pub(super) fn balance(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    let allowed = unbalanced(resolver)?;
    for (index, body) in assembly.bodies.iter().enumerate() {
        let area = |push: Push| -> f64 {
            let of = assembly
                .faces
                .iter()
                .filter(|face| face.body == index && face.push == push);
            of.fold(0.0, |sum, face| sum + face.area)
        };
        let (down, up) = (area(Push::Down), area(Push::Up));
        let is_allowed = allowed.get(index).copied().unwrap_or(false);
        if !is_allowed && (down - up).abs() > ROUNDING * down.max(up) {
            let name = &body.name;
            let body = name.clone();
            let parts = Part::of_faces(assembly, index);
            return Err(error_of(
                resolver,
                "body",
                name,
                Fault::Unbalanced { body, down, up },
                &parts,
            ));
        }
    }
    Ok(())
}

//! Checks that volumes can change and do not collapse.

use super::place::{error, error_of, stop};
use crate::network::assembly::{Assembly, Face, Push, Space, Start, Stop};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// Checks that every volume has a passage or a face.
pub(super) fn are_reachable(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, volume) in assembly.volumes.iter().enumerate() {
        let space = Space::Volume(index);
        let passage = assembly
            .passages
            .iter()
            .any(|passage| passage.from == space || passage.to == space);
        let face = assembly.faces.iter().any(|face| face.gas == space);
        if !passage && !face {
            return Err(error(resolver, "volume", &volume.name, Fault::Isolated));
        }
    }
    Ok(())
}

/// Checks that no volume shrinks to nothing with its bodies at their stops.
pub(super) fn do_not_collapse(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, volume) in assembly.volumes.iter().enumerate() {
        let mut least = volume.dead;
        let mut worst = (0.0, "", 0.0);
        for face in assembly
            .faces
            .iter()
            .filter(|face| face.sweeps && face.gas == Space::Volume(index))
        {
            let travel = smallest_at(assembly, face);
            let swept = face.push.sign() * face.area * (travel - face.zero);
            least += swept;
            if swept <= worst.0 {
                worst = (swept, &assembly.bodies[face.body].name, travel);
            }
        }
        if least <= 0.0 {
            let (_, body, travel) = worst;
            let fault = Fault::Collapse {
                volume: least,
                body: body.to_owned(),
                travel,
            };
            let parts = Part::of_volume(assembly, index);
            return Err(error_of(resolver, "volume", &volume.name, fault, &parts));
        }
    }
    Ok(())
}

/// Travel of a face's body at which the volume is smallest: at the stop or, without one, at the body's start \[m\].
fn smallest_at(assembly: &Assembly, face: &Face) -> f64 {
    let side = match face.push {
        Push::Down => Stop::Above,
        Push::Up => Stop::Below,
    };
    match (
        stop(assembly, face.body, face.against, side),
        assembly.bodies[face.body].start,
    ) {
        (Some(contact), _) => contact.at,
        (None, Start::At { travel, .. }) if assembly.bodies[face.body].parent == face.against => travel,
        (None, _) => face.zero,
    }
}

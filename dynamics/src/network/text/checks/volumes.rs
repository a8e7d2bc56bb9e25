//! Checks that volumes can change and do not collapse.

use super::place::{error_of, stop_position};
use crate::network::assembly::{Assembly, Face, Family, Space, Start, Stop};
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
            let parts = Part::of_block(Family::Volume, &volume.name);
            return Err(error_of(resolver, "volume", &volume.name, Fault::Isolated, &parts));
        }
    }
    Ok(())
}

/// Checks that no volume shrinks to nothing with its bodies at their stops.
pub(super) fn do_not_collapse(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, volume) in assembly.volumes.iter().enumerate() {
        let mut least = volume.dead;
        let mut worst = (0.0, "", 0.0);
        // Faces of one body move together, such as the two ends of a shuttle.
        let mut motions: Vec<(&Face, Vec<&Face>)> = Vec::new();
        let sweeping = assembly.faces.iter().filter(|face| face.sweeps);
        for face in sweeping.filter(|face| face.gas == Space::Volume(index)) {
            let same = |own: &&mut (&Face, Vec<&Face>)| own.0.body == face.body && own.0.against == face.against;
            match motions.iter_mut().find(same) {
                Some((_, faces)) => faces.push(face),
                None => motions.push((face, vec![face])),
            }
        }
        for (first, faces) in motions {
            let travel = smallest_at(assembly, first, &faces);
            let swept = faces
                .iter()
                .map(|face| face.push.sign() * face.area * (travel - face.zero));
            let swept: f64 = swept.sum();
            least += swept;
            if swept <= worst.0 {
                worst = (swept, &assembly.bodies[first.body].name, travel);
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

/// Travel of a body at which a volume with these faces of it is smallest: at the stop or, without one, at the body's
/// start \[m\].
fn smallest_at(assembly: &Assembly, face: &Face, faces: &[&Face]) -> f64 {
    let growth: f64 = faces.iter().map(|face| face.push.sign() * face.area).sum();
    let side = if growth > 0.0 { Stop::Above } else { Stop::Below };
    match (
        stop_position(assembly, face.body, face.against, side),
        assembly.bodies[face.body].start,
    ) {
        (Some(at), _) => at,
        (None, Start::At { travel, .. }) if assembly.bodies[face.body].parent == face.against => travel,
        (None, _) => face.zero,
    }
}

//! Checks where bodies start.

use super::place::error_of;
use crate::network::assembly::{Assembly, Base, Body, Contact, Start, Stop};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// Energy that a stop may store at the start, as that of a preloaded buffer \[J\].
const LARGEST: f64 = 10.0;

/// Checks that a body rests on a contact or spring of its own, and does not start deep inside a stop.
pub(super) fn are_possible(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, body) in assembly.bodies.iter().enumerate() {
        let fault = match body.start {
            Start::RestOn(block) => {
                let own = supports(assembly, index);
                let name = assembly.name_of(block).to_owned();
                (!own.contains(&name)).then(|| Fault::UnknownName {
                    name,
                    wanted: "contact or spring of this body".to_owned(),
                    known: own,
                })
            }
            Start::At { travel, .. } => assembly
                .contacts
                .iter()
                .find_map(|contact| inside(contact, index, body, travel)),
        };
        if let Some(fault) = fault {
            let parts = Part::of_start(assembly, index);
            return Err(error_of(resolver, "body", &body.name, fault, &parts));
        }
    }
    Ok(())
}

/// Names of the contacts and springs of a body.
fn supports(assembly: &Assembly, body: usize) -> Vec<String> {
    let is_own = |on: usize, against: Base| on == body || against == Base::Body(body);
    let contacts = assembly.contacts.iter().filter(|own| is_own(own.on, own.against));
    let springs = assembly.springs.iter().filter(|own| is_own(own.on, own.against));
    let names = contacts.map(|own| &own.name).chain(springs.map(|own| &own.name));
    names.cloned().collect()
}

/// The fault of a body that starts deep inside a stop.
fn inside(contact: &Contact, index: usize, body: &Body, travel: f64) -> Option<Fault> {
    let (side, at) = contact.limit(index, body.parent)?;
    let overlap = match side {
        Stop::Below => travel - at,
        Stop::Above => at - travel,
    };
    let power = contact.exponent + 1.0;
    let energy = contact.stiffness * overlap.max(0.0).powf(power) / power;
    (energy > LARGEST).then(|| Fault::InsideStop {
        stop: contact.name.clone(),
        overlap,
        energy,
    })
}

//! Checks where bodies start.

use super::place::error_of;
use crate::network::assembly::{Assembly, BlockRef, Body, Contact, Family, Fastener, Start, Stop};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// Energy that a stop may store at the start, as that of a preloaded buffer \[J\].
const LARGEST: f64 = 10.0;

/// Checks that a body rests on one of its contacts or springs, and starts neither deep inside a stop nor beyond the
/// head of the fastener that it drives.
pub(super) fn check(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, body) in assembly.bodies.iter().enumerate() {
        let fault = match body.start {
            Start::RestOn(block) => {
                let supports: Vec<BlockRef> = supports(assembly, index).collect();
                let name = |block: BlockRef| assembly.name_of(block).to_owned();
                (!supports.contains(&block)).then(|| Fault::UnknownName {
                    name: name(block),
                    wanted: "contact or spring of this body".to_owned(),
                    known: supports.iter().map(|block| name(*block)).collect(),
                })
            }
            Start::At { travel, .. } => assembly
                .contacts
                .iter()
                .find_map(|contact| overlap_fault(contact, index, body, travel)),
        };
        if let Some(fault) = fault {
            let parts = Part::of_start(assembly, index);
            return Err(error_of(resolver, "body", &body.name, fault, &parts));
        }
    }
    assembly
        .fasteners
        .iter()
        .try_for_each(|own| check_head(resolver, assembly, own))
}

/// Checks that the head of a fastener is ahead of its driver. Otherwise the driver would never strike it.
fn check_head(resolver: &Resolver<'_>, assembly: &Assembly, fastener: &Fastener) -> Result<(), AssemblyError> {
    let driver = &assembly.bodies[fastener.driver];
    let Start::At { travel, .. } = driver.start else {
        return Ok(());
    };
    if travel <= fastener.head_at {
        return Ok(());
    }
    let fault = Fault::PastHead {
        driver: driver.name.clone(),
        beyond: travel - fastener.head_at,
    };
    let mut parts = Part::of_start(assembly, fastener.driver);
    parts.extend(Part::of_block(Family::Fastener, &fastener.name));
    Err(error_of(resolver, "fastener", &fastener.name, fault, &parts))
}

/// Contacts and springs of a body.
fn supports(assembly: &Assembly, body: usize) -> impl Iterator<Item = BlockRef> {
    let own = assembly.connections().filter(move |own| own.acts_on(body));
    let blocks = own.map(|own| own.block);
    blocks.filter(|block| matches!(block.family, Family::Contact | Family::Spring))
}

/// The fault of a body that starts deep inside a stop.
fn overlap_fault(contact: &Contact, index: usize, body: &Body, travel: f64) -> Option<Fault> {
    let (side, at) = contact.stop_for(index, body.parent)?;
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

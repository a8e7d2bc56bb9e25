//! Compression of springs at their stops against the limit of their law.

use super::place::error_of;
use crate::network::assembly::Assembly;
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// Relative excess of the compression attributed to rounding.
const ROUNDING: f64 = 1e-9;

/// Checks that no stop lets a spring be compressed beyond its limit.
pub(super) fn check_range(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, spring) in assembly.springs.iter().enumerate() {
        let Some(limit) = spring.limit else { continue };
        for contact in &assembly.contacts {
            let Some((_, at)) = contact.stop_for(spring.on, spring.against) else {
                continue;
            };
            let compression = spring.compression(at);
            if compression > limit * (1.0 + ROUNDING) {
                let fault = Fault::SpringLimit {
                    stop: contact.name.clone(),
                    compression,
                    limit,
                };
                let parts = Part::of_spring(assembly, index);
                return Err(error_of(resolver, "spring", &spring.name, fault, &parts));
            }
        }
    }
    Ok(())
}

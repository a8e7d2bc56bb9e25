//! The nailing cycle of a design.

use nailnoise_dynamics::CycleRecord;

use crate::design::{Design, inputs};
use crate::error::Error;
use crate::stages::cycle::{Cycle, Engine, ShotRecord};

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] if the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.record()
}

/// Computes the shot of a design, whichever engine computes its cycle.
///
/// # Errors
/// Same as [`cycle`]; [`Error::Network`] for an assembly that cannot be computed.
pub fn shot(design: &Design) -> Result<ShotRecord, Error> {
    engine(design)?.shot()
}

/// The engine of a design's cycle.
///
/// # Errors
/// If the values of the design do not yield valid inputs.
pub(crate) fn engine(design: &Design) -> Result<Engine, Error> {
    Ok(match inputs::assembly::cycle(design)? {
        Some(assembled) => Engine::Assembly(Box::new(assembled)),
        None => Engine::Keys(Box::new(cycle_stage(design)?)),
    })
}

/// The cycle with a lumped workpiece.
///
/// # Errors
/// If the values of the design do not yield valid inputs.
pub(crate) fn cycle_stage(design: &Design) -> Result<Cycle, Error> {
    Ok(Cycle {
        parameters: inputs::cycle::parameters(design)?,
        settings: inputs::cycle::cycle_settings(design),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// They are the stops of the head valve, which does not drive a fastener, and not those of the piston.
    #[test]
    fn the_housing_of_an_assembly_has_the_contacts_of_that_of_the_keys() {
        let contacts = |cycle: &str| {
            let text = format!("base = \"designs/n80cb.toml\"\n{cycle}");
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("contacts.toml");
            let design = Design::parse(&text, path).unwrap();
            inputs::response::tool(&design, &engine(&design).unwrap()).contacts
        };
        let of_keys = contacts("");
        assert_eq!(of_keys.len(), 2);
        assert_eq!(contacts("[cycle]\nassembly = \"n80cb\""), of_keys);
    }
}

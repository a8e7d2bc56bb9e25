//! The built-in assembly of the N80CB with the numbers of the base design.

#[path = "../assembly/keys.rs"]
pub(crate) mod keys;

use nailnoise_dynamics::Parameters;
use nailnoise_dynamics::network::{Assembly, AssemblyText};

/// The assembly of a design, with the end of its record and the time after the last event \[s\].
pub(crate) fn n80cb_assembly(parameters: &Parameters, end: f64, tail: f64) -> Assembly {
    let text = AssemblyText::open_design(&[]).unwrap_or_else(|error| panic!("{error}"));
    let resolved = text.resolve(&keys::keys(parameters));
    let mut assembly = resolved.unwrap_or_else(|error| panic!("{error}")).assembly;
    assembly.set_resistance(
        parameters.penetration_table.as_ref(),
        parameters.penetration_fit.as_ref(),
    );
    assembly.end = end;
    if let Some(finish) = &mut assembly.finish {
        finish.tail = tail;
    }
    assembly
}

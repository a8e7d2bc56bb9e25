//! Values of the base design for assemblies.

use std::collections::BTreeMap;

use nailnoise_dynamics::Parameters;
use nailnoise_dynamics::network::KeyValue;
use nailnoise_quantities::dimension::{LENGTH, TIME};
use nailnoise_quantities::positive;

use crate::common::number;

/// The keys of a design of the cycle with those that only the assembly reads.
pub(crate) fn keys(parameters: &Parameters) -> BTreeMap<String, KeyValue> {
    let mut keys = parameters.keys();
    for (path, dimension) in [
        ("analysis.cycle_end", TIME),
        ("analysis.cycle_tail", TIME),
        ("exhaust.pitch", LENGTH),
    ] {
        let si = number(path, positive(dimension));
        keys.insert(path.to_owned(), KeyValue::Quantity { si, dimension });
    }
    keys
}

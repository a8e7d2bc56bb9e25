//! How the cycle of a design is integrated and recorded.

use nailnoise_dynamics::Settings;

use crate::design::Design;

/// The settings of the cycle that a design asks for.
pub fn cycle_settings(design: &Design) -> Settings {
    let analysis = &design.analysis;
    Settings {
        relative_tolerance: analysis.cycle_tolerance,
        sample_interval: analysis.time_step,
        end: analysis.cycle_end,
        tail: analysis.cycle_tail,
        ..Settings::default()
    }
}

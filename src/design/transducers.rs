//! Virtual pressure transducers: piezoelectric ones in the chambers of the tool.

use nailnoise_quantities::dimension::{LENGTH, TIME};
use nailnoise_quantities::{choice, group, nonnegative, positive};

choice! {
    /// Where a pressure transducer is.
    Chamber {
        /// In the wall of the cylinder: below the piston before the piston passes it, above the piston while that is
        /// lower.
        Cylinder = "cylinder",
        /// In the return chamber.
        Return = "return",
    }
}

group! {
    /// A piezoelectric pressure transducer. It has no effect on the tool. It does not measure static pressure: 0 is the
    /// pressure before the shot, and its charge leaks.
    Transducer {
        /// Where it is.
        chamber: Chamber = Chamber::KIND, "";
        /// Travel of the piston, from the upper stopper, at which it passes a transducer in the cylinder; unused in the
        /// return chamber. The piston has no height: while it covers a transducer, that one reads the volume below.
        position: f64 = nonnegative(LENGTH), "";
        /// Discharge time of its amplifier, a high-pass filter of first order with the limit 1/(2 pi tau).
        discharge_time: f64 = positive(TIME), "tau";
    }
}

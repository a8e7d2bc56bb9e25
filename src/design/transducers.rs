//! Virtual pressure transducers: piezoelectric ones in the chambers of the tool.

use nailnoise_quantities::dimension::{LENGTH, TIME};
use nailnoise_quantities::{Kind, Name, group, nonnegative, positive};

group! {
    /// A piezoelectric pressure transducer. It has no effect on the tool. It does not measure static pressure: 0 is the
    /// pressure before the shot, and its charge leaks.
    Transducer {
        /// Where it is: `"cylinder"`, in its wall, which is below the piston until the piston has passed and above it
        /// while the piston is lower; `"return"`, in the return chamber; or the name of a volume of the cycle, such as
        /// `"above_valve"`.
        chamber: Name = Kind::Name, "";
        /// Travel of the piston, from the upper stopper, at which it passes a transducer in the cylinder; unused
        /// elsewhere. The piston has no height: while it covers a transducer, that one reads the volume below.
        position: f64 = nonnegative(LENGTH), "";
        /// Discharge time of its amplifier, a high-pass filter of first order with the limit 1/(2 pi tau).
        discharge_time: f64 = positive(TIME), "tau";
    }
}

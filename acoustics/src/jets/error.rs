use crate::checks::InputError;
use thiserror::Error;

/// Why the noise of an opening cannot be computed.
#[derive(Debug, Error)]
pub enum ExhaustError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The exhaust's area differs from that of its holes.
    #[error(
        "{count} exhaust holes of {diameter} m have {found:.4e} m2, not the {area:.4e} m2 given; correct one of the \
         three"
    )]
    HoleArea {
        /// Number of holes.
        count: usize,
        /// Diameter of a hole \[m\].
        diameter: f64,
        /// Total area of the holes \[m²\].
        found: f64,
        /// Specified area \[m²\].
        area: f64,
    },
    /// Air leaves against a higher pressure.
    #[error(
        "air leaves at sample {sample} ({flow:.3e} kg/s) from {pressure:.0} Pa into {ambient:.0} Pa; an outflow needs \
         a pressure above ambient before the opening: check the pressures' origin (absolute, not gauge)"
    )]
    BelowAmbient {
        /// Index of the sample.
        sample: usize,
        /// Mass flow outward \[kg/s\].
        flow: f64,
        /// Pressure upstream of the opening \[Pa\].
        pressure: f64,
        /// Ambient pressure \[Pa\].
        ambient: f64,
    },
    /// Exhaust holes are so close that their jets merge.
    #[error(
        "{count} holes of {diameter} m stand {pitch} m apart; below three diameters their jets merge: give a larger \
         pitch, or one hole of {merged:.2e} m"
    )]
    MergingJets {
        /// Number of holes.
        count: usize,
        /// Hole diameter \[m\].
        diameter: f64,
        /// Distance between centres \[m\].
        pitch: f64,
        /// Diameter of one hole of the same area \[m\].
        merged: f64,
    },
}

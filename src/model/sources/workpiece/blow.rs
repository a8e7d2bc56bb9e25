//! Model of the blow of the driver on the fastener, and what the error of the method does not contain of it.

use crate::stages::response::DrivenFastener;

/// Model of the blow on the fastener in the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Blow {
    /// The driver strikes the fastener as a rigid body.
    Rigid(Ground),
    /// Waves travel in driver and fastener.
    Elastic,
}

/// Kind of support under the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    /// An elastic structure.
    Structure,
    /// Sand, flush with the workpiece.
    Sand,
    /// A rigid floor, a clamp, or springs.
    Other,
}

impl Blow {
    /// The model for the fastener of a shot.
    pub(super) fn of(fastener: &DrivenFastener, ground: Ground) -> Self {
        if fastener.blows.is_empty() {
            Self::Rigid(ground)
        } else {
            Self::Elastic
        }
    }

    /// States the differences that the error of the method excludes.
    pub(super) fn note(self) -> String {
        match self {
            Self::Rigid(ground) => {
                let change = match ground {
                    Ground::Structure => "-0.8 to +0.5 dB on a worktable or joists",
                    Ground::Sand => "-1.8 to +1.1 dB in sand",
                    Ground::Other => {
                        "-2.1 to +2.7 dB on a rigid floor, -4.9 to +2.2 dB on straps and -2.5 to +7.8 dB in a clamp"
                    }
                };
                format!(
                    "the driver strikes the fastener as a rigid body; the error of the method does not contain the \
                     waves of the blow, which change the level of the workpiece by {change} (90 % of shots of the \
                     N80CB) and raise its third octaves from 6.3 kHz on; an elastic blow contains them"
                )
            }
            Self::Elastic => {
                "the waves of the blow on the fastener converge up to 3.15 kHz; from 6.3 kHz on, the force \
                              on the wood is known to 10 dB, which the error of the method does not contain"
                    .to_owned()
            }
        }
    }
}

//! Virtual sensors: accelerometers at any point of a body, in any direction, with the band limit of a real one.

use nailnoise_quantities::dimension::{FREQUENCY, LENGTH};
use nailnoise_quantities::{any, choice, component, group, positive};

use super::show::{Short, mm};

choice! {
    /// Body that carries a sensor.
    Carrier {
        /// The block of wood.
        Workpiece = "workpiece",
        /// The worktable.
        Worktable = "worktable",
        /// The surface of the sand around the block.
        Sand = "sand",
        /// The tool: its housing with its modes, or with `body.model = "rigid"` its motion along z.
        Tool = "tool",
    }
}

group! {
    /// An accelerometer. It does not change the vibration of its body. It is ignored if the design does not have that
    /// body. The origin is the centre of the workpiece's underside, x along its length, y along its width, z up; for
    /// the tool, the tip of the nose, x along the handle, z up.
    Sensor {
        /// The body it is fixed to.
        body: Carrier = Carrier::KIND, "";
        /// Position along the workpiece's length, or along the tool's handle.
        x: f64 = any(LENGTH), "x";
        /// Position along the workpiece's width, or along the axis of the tool's magazine.
        y: f64 = any(LENGTH), "y";
        /// Height above the workpiece's underside, or the tool's nose; unused on sand.
        z: f64 = any(LENGTH), "z";
        /// Component along x of its axis, whose length does not matter.
        along_x: f64 = component(), "";
        /// Component along y of its axis.
        along_y: f64 = component(), "";
        /// Component along z of its axis; sand and a rigid tool move along z alone.
        along_z: f64 = component(), "";
        /// Lower limit of its band, -3 dB: the discharge time of its amplifier, a filter of first order.
        band_low: f64 = positive(FREQUENCY), "";
        /// Upper limit of its band, -3 dB: its mounted resonance and the anti-aliasing filter, a Butterworth low-pass
        /// of fourth order; at most the top frequency of its body.
        band_high: f64 = positive(FREQUENCY), "";
    }
}

/// The fault of a sensor, with the numbers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorProblem {
    /// All components of its axis are zero.
    #[error("has no direction: along_x, along_y and along_z are all 0")]
    NoDirection,
    /// Its band is empty or ends above half the sampling frequency of the response.
    #[error("has a band from {} Hz to {} Hz; it must rise and end below {} \
        Hz", Short(*low), Short(*high), Short(*nyquist))]
    Band {
        /// Lower limit \[Hz\].
        low: f64,
        /// Upper limit \[Hz\].
        high: f64,
        /// Half the sampling frequency of the response \[Hz\].
        nyquist: f64,
    },
    /// It is not on its body.
    #[error("at ({}, {}, {}) is {} outside the {body}", mm(point[0]), mm(point[1]), mm(point[2]), mm(*distance))]
    Outside {
        /// Its body.
        body: &'static str,
        /// Where it is \[m\].
        point: [f64; 3],
        /// How far from the body \[m\].
        distance: f64,
    },
}

impl SensorProblem {
    /// The sensor's keys that are at fault.
    pub(crate) fn keys(&self) -> &'static [&'static str] {
        match self {
            Self::NoDirection => &["along_x", "along_y", "along_z"],
            Self::Band { .. } => &["band_low", "band_high"],
            Self::Outside { .. } => &["x", "y", "z", "body"],
        }
    }

    /// The remedy.
    pub(crate) fn remedy(&self) -> String {
        match self {
            Self::NoDirection => "give its axis: along_z = 1 for up".to_owned(),
            Self::Band { nyquist, .. } => {
                format!(
                    "give band_low below band_high and band_high below {} Hz, or lower `analysis.time_step`",
                    Short(*nyquist)
                )
            }
            Self::Outside { .. } => {
                "move x, y and z onto the body; the origin is the centre of the workpiece's underside, on the tool the \
                 nose's tip, z up"
                    .to_owned()
            }
        }
    }
}

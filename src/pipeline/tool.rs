//! The tool's elastic body in motion.

use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::transient::ModalResponse;

use super::Driven;
use super::bodies::GraphBody;
use super::radiator::damping_of;
use super::sensors;
use super::vibration::spectrum_range;
use crate::design::inputs;
use crate::design::{Carrier, Design};
use crate::error::Error;
use crate::result::Check;
use crate::stages::response::modal_spectra;
use crate::stages::sensors::SensorMotion;
use crate::stages::tool_response::Stiffness;

/// The elastic body of the tool and its response to the shot.
pub struct Tool {
    /// Its modes.
    pub body: GraphBody,
    /// Its response.
    pub response: ModalResponse,
    /// Fourier transforms of its modal accelerations.
    pub spectra: ModalSpectra,
    /// Checks of the response.
    pub checks: Vec<Check>,
    /// Its stiffness at cap and cylinder rim beside that of the cycle's contacts \[N/m\].
    pub stiffness: [Stiffness; 2],
    /// Acceleration at the sensors on it.
    pub(super) sensors: SensorMotion,
    /// How it radiates by boundary elements, where the design asks for them.
    pub(super) bem: Option<ModalBem>,
    /// Damping ratio that this adds to its modes, where the design lets radiation damp them.
    pub(super) damping: Option<Vec<f64>>,
}

impl Tool {
    /// The response of the tool's body to a cycle.
    ///
    /// # Errors
    /// Those of the transient solver and of the Fourier transform.
    pub(super) fn new(
        design: &Design,
        (body, bem): (GraphBody, Option<ModalBem>),
        record: &CycleRecord,
    ) -> Result<Self, Error> {
        let damping = match &bem {
            Some(bem) if design.acoustics.radiation_damping => Some(damping_of(bem, &body.omega)),
            _ => None,
        };
        let motion = inputs::response::tool(design)?.response(&body, damping.as_deref(), record)?;
        let points = sensors::shapes(design, Carrier::Tool, &body)?;
        let all = [(spectrum_range(design, &body), points)].into_iter();
        let (mut spectra, mut sensors) = modal_spectra(&motion.response, all)?;
        Ok(Self {
            spectra: spectra.remove(0),
            sensors: sensors.remove(0),
            body,
            response: motion.response,
            checks: motion.checks,
            stiffness: motion.stiffness,
            bem,
            damping,
        })
    }

    /// It with its response.
    pub fn driven(&self) -> Driven<'_> {
        Driven {
            body: &self.body,
            response: &self.response,
            index: 0,
            spectra: &self.spectra,
        }
    }
}

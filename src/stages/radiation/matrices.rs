//! Radiation matrices in standard air, which are kept: they depend on the wavelength alone.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::radiation::Rayleigh;
use nailnoise_acoustics::sound::FlushSound;
use serde::Serialize;

use super::CODE;
use super::boundary_elements::Places;
use super::flush::{sampled, sampling_to, top_of};
use super::surface_modes::SurfaceModes;
use super::tool::{CapSurface, ToolRadiation};
use super::workpiece::WorkpieceBoundaryElements;
use crate::error::Error;
use crate::stages::bodies::Body;
use crate::stages::{Code, Input, Postcard, Progress, Stage, Stored};

/// Boundary elements of workpiece and worktable as one surface, or of a workpiece alone.
#[derive(Serialize)]
pub struct WorkpieceMatrix {
    /// Surroundings and resolution.
    pub elements: WorkpieceBoundaryElements,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for WorkpieceMatrix {
    type Output = ModalBem;
    type Codec = Postcard;
    const NAME: &'static str = "radiation of workpiece and worktable";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        self.modes.inputs()
    }

    fn compute(&self, progress: &Progress) -> Result<ModalBem, Error> {
        self.elements.compute(&self.modes.get()?.surfaces(), progress)
    }
}

/// Boundary elements of the tool's housing.
#[derive(Serialize)]
pub struct ToolMatrix {
    /// Surroundings and resolution.
    pub elements: ToolRadiation,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for ToolMatrix {
    type Output = ModalBem;
    type Codec = Postcard;
    const NAME: &'static str = "radiation of the tool";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        self.modes.inputs()
    }

    fn compute(&self, progress: &Progress) -> Result<ModalBem, Error> {
        self.elements.compute(&self.modes.get()?.surfaces()[0], progress)
    }
}

/// Boundary elements of the tool's housing in the motion of each mode, and behind them with its cap alone in that motion.
#[derive(Serialize)]
pub struct ToolCapMatrix {
    /// Surroundings and resolution.
    pub elements: ToolRadiation,
    /// The cap.
    pub cap: CapSurface,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for ToolCapMatrix {
    type Output = ModalBem;
    type Codec = Postcard;
    const NAME: &'static str = "radiation of the tool's cap";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        self.modes.inputs()
    }

    fn compute(&self, progress: &Progress) -> Result<ModalBem, Error> {
        let modes = self.modes.get()?;
        self.elements
            .compute_with_cap(&modes.surfaces()[0], &self.cap, progress)
    }
}

/// Rayleigh's integral over the workpiece's top in a rigid plane, without sand.
#[derive(Serialize)]
pub struct FlushMatrix {
    /// The microphones.
    pub places: Places,
    /// Highest frequency of the block's motion in the analysed range \[Hz\].
    pub top_hz: f64,
    /// The air in which it is computed, see [`Self::computed_air`].
    pub air: Air,
    /// The workpiece.
    pub body: Stored<Body>,
}

impl FlushMatrix {
    /// The air in which the top by itself is computed: standard air, unless the wavelengths of `air` are far from it.
    pub fn computed_air(air: &Air) -> Air {
        let standard = Air::default();
        let apart = (air.sound_speed / standard.sound_speed).ln().abs() > FlushSound::WIDEST.ln();
        if apart { *air } else { standard }
    }
}

impl Stage for FlushMatrix {
    type Output = FlushSound;
    type Codec = Postcard;
    const NAME: &'static str = "radiation of the workpiece in a plane";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        vec![&self.body]
    }

    fn compute(&self, progress: &Progress) -> Result<FlushSound, Error> {
        let surface = top_of(&self.body.get()?.moving_surface())?;
        let sampling = sampling_to(self.top_hz * FlushSound::WIDEST);
        sampled(&Rayleigh::new(&surface, &self.air)?, &sampling, &self.places, progress)
    }
}

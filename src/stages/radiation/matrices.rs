//! Results of boundary elements and Rayleigh's integral in standard air. They are stored, because they depend only on
//! the wavelength.
//!
//! ```text
//! WorkpieceSolution, ToolSolution, ToolCapSolution     boundary elements for the modes of bodies
//!   -> RadiationMatrix                                 powers
//!   -> PressureOnSurface                               pressures on the surface
//!      -> PressureAtMicrophones                        pressures at the microphones, their surface integral
//! both -> MatrixWithMicrophones                        powers and pressures at the microphones
//! ```
//!
//! Other microphones do not require a new boundary-element solution.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::boundary_elements::{ModalBem, ModalPressures, SurfacePressures};
use nailnoise_acoustics::radiation::flush_with_sand::{FlushSound, Rayleigh};
use nalgebra::DMatrix;
use serde::Serialize;

use super::CODE;
use super::boundary_elements::{Places, Solution};
use super::flush_with_sand::{sampled, sampling_to, top_of};
use super::reference::RadiatingShape;
use super::surface_modes::SurfaceModes;
use super::tool::ToolRadiation;
use super::tool_parts::CapSurface;
use super::workpiece::WorkpieceBoundaryElements;
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::{Body, MovingSurface};
use crate::stages::{Code, OnDemand, Postcard, Progress, Stage, Stored, Uncached, all};

/// Boundary elements of workpiece and worktable as one surface, or of only the workpiece.
#[derive(Serialize)]
pub struct WorkpieceSolution {
    /// Surroundings and resolution.
    pub elements: WorkpieceBoundaryElements,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for WorkpieceSolution {
    type Output = Solution;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation of workpiece and worktable";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<Solution, Error> {
        self.elements.compute(&self.modes.get()?.surfaces(), progress)
    }
}

/// Boundary elements of the tool's housing.
#[derive(Serialize)]
pub struct ToolSolution {
    /// Surroundings and resolution.
    pub elements: ToolRadiation,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for ToolSolution {
    type Output = Solution;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation of the tool";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<Solution, Error> {
        self.elements.compute(&self.modes.get()?.surfaces(), progress)
    }
}

/// Boundary elements of the tool's housing for each mode, followed by those with only its cap moving in that mode.
#[derive(Serialize)]
pub struct ToolCapSolution {
    /// Surroundings and resolution.
    pub elements: ToolRadiation,
    /// The cap.
    pub cap: CapSurface,
    /// The modes.
    pub modes: SurfaceModes,
}

impl Stage for ToolCapSolution {
    type Output = Solution;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation of the tool's cap";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<Solution, Error> {
        let modes = self.modes.get()?;
        self.elements.compute_with_cap(&modes.surfaces(), &self.cap, progress)
    }
}

/// The radiation matrix of a surface.
#[derive(Serialize)]
pub struct RadiationMatrix {
    /// Results of boundary elements for the surface.
    pub solution: OnDemand<Stored<Solution>>,
    /// The pressures of the same solution.
    pub surface: OnDemand<Stored<SurfacePressures>>,
}

impl Stage for RadiationMatrix {
    type Output = ModalBem;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "radiation matrix";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ModalBem, Error> {
        let matrix = self.solution.get()?.matrix.clone();
        // Also stored, so that the surface need not be solved again for the first microphones.
        self.surface.get()?;
        Ok(matrix)
    }
}

/// The pressures on a surface for each mode.
#[derive(Serialize)]
pub struct PressureOnSurface {
    /// Results of boundary elements for the surface.
    pub solution: OnDemand<Stored<Solution>>,
}

impl Stage for PressureOnSurface {
    type Output = SurfacePressures;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "pressure on the surface";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<SurfacePressures, Error> {
        Ok(self.solution.get()?.surface.clone())
    }
}

/// The pressures at the microphones for each mode.
#[derive(Serialize)]
pub struct PressureAtMicrophones {
    /// The surface.
    pub shape: RadiatingShape,
    /// Bodies with that surface.
    pub bodies: Vec<Stored<Body>>,
    /// The pressures on it.
    pub surface: Stored<SurfacePressures>,
    /// The microphones.
    pub places: Places,
}

impl Stage for PressureAtMicrophones {
    type Output = ModalPressures;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "pressure at the microphones";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ModalPressures, Error> {
        let bodies = all(&self.bodies)?;
        let still: Vec<DMatrix<f32>> = bodies.iter().map(|body| DMatrix::zeros(body.skin.nrows(), 0)).collect();
        let surfaces = bodies.iter().zip(&still).map(|(body, modes)| MovingSurface {
            modes,
            ..body.moving_surface()
        });
        let levels = self.shape.mesh_hierarchy(&surfaces.collect::<Vec<_>>())?;
        Ok(self.surface.get()?.at(&self.places.receivers(), &levels)?)
    }
}

/// A radiation matrix with the pressures at the microphones.
#[derive(Serialize)]
pub struct MatrixWithMicrophones {
    /// The matrix.
    pub matrix: Stored<ModalBem>,
    /// The pressures at the microphones.
    pub pressures: Stored<ModalPressures>,
}

impl Stage for MatrixWithMicrophones {
    type Output = ModalBem;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation at the microphones";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ModalBem, Error> {
        let with = self.matrix.get()?.with_pressures(self.pressures.get()?);
        with.ok_or(BodyError::OtherModes { body: "bodies" }.into())
    }
}

/// Rayleigh's integral over the workpiece's top in a rigid plane, without sand.
#[derive(Serialize)]
pub struct FlushMatrix {
    /// The microphones.
    pub places: Places,
    /// Highest frequency of the block's motion in the analysed range \[Hz\].
    pub top_hz: f64,
    /// The air used for the computation, see [`Self::computed_air`].
    pub air: Air,
    /// The workpiece.
    pub body: Stored<Body>,
}

impl FlushMatrix {
    /// The air for computing the top without its surroundings: standard air, unless the wavelengths in `air` are very
    /// different.
    pub fn computed_air(air: &Air) -> Air {
        let standard = Air::default();
        let apart = (air.sound_speed / standard.sound_speed).ln().abs() > FlushSound::WIDEST.ln();
        if apart { *air } else { standard }
    }
}

impl Stage for FlushMatrix {
    type Output = FlushSound;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "radiation of the workpiece in a plane";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<FlushSound, Error> {
        let surface = top_of(&self.body.get()?.moving_surface())?;
        let sampling = sampling_to(self.top_hz * FlushSound::WIDEST);
        sampled(&Rayleigh::new(&surface, &self.air)?, &sampling, &self.places, progress)
    }
}

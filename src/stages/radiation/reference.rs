//! Radiation converted from reference structures to other bodies with the same outer surface.
//!
//! The radiation matrix is solved for the modes of reference bodies, which have the shape of the design's bodies and
//! fixed materials. The velocities of the design's own modes are fitted by theirs on the finest mesh
//! ([`ReferenceProjection`]), and the matrix follows by products ([`ProjectedMatrix`]), the pressure at the microphones
//! likewise ([`ProjectedPressures`]). Thus a body with another material, loss factor, nail or nail position needs no
//! boundary elements, as long as the fit represents its motion. Otherwise the modes of further reference bodies are
//! added. If these do not represent it either, the matrix is solved for the body's modes.

use std::f64::consts::TAU;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::boundary_elements::{MeshRange, ModalBem, ModalPressures, SurfaceFit};
use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

use super::CODE;
use super::surface_modes::SurfaceModes;
use super::tool::ToolRadiation;
use super::tool_parts::CapSurface;
use super::workpiece::WorkpieceBoundaryElements;
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::{Body, MovingSurface};
use crate::stages::{Code, OnDemand, Postcard, Progress, Stage, Stored, Uncached, all};

/// Maximum fraction of a surface's kinetic energy under any load that the known modes of workpiece and table may miss.
/// Above it, others are added, or the matrix is solved for the body's own modes.
const LIMIT: f64 = 1e-3;

/// The same for a tool with one standard structure. With walls for which one structure missed 1.4e-4 and 3.6e-4, levels
/// of the tool differed by up to 0.025 and 0.28 dB (at 8 kHz, above boundary elements, where the fit determines the
/// radiation damping). With two structures, which missed 2.3e-5 and 1.7e-5, they differed by 0.004 and 0.008 dB. For
/// alloys and masses for which one structure missed at most 1.2e-5, they differed by 0.003 dB.
const LIMIT_OF_FIRST_TOOL: f64 = 5e-5;

/// The same for a tool with two standard structures. For walls for which they missed 3.6e-4, 4.2e-4 and 5.6e-4, levels
/// differed by up to 0.006, 0.016 and 0.034 dB.
const LIMIT_OF_BOTH_TOOLS: f64 = 5e-4;

/// Loss factor for comparing responses to loads; near resonances, the modes have the same weight as in wood.
const LOSS_FACTOR: f64 = 0.02;

/// Number of frequencies per octave at which they are compared.
const PER_OCTAVE: f64 = 6.0;
const LOWEST_HZ: f64 = 50.0;

/// Quality with which modes of reference bodies represent the motion of the design's bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Projection {
    /// The fit; `None` if the surfaces differ.
    pub fit: Option<SurfaceFit>,
    /// Frequency \[Hz\] and fraction of the energy of the surface's motion that the known modes miss \[-\], RMS over
    /// the loads.
    pub lacking: Vec<[f64; 2]>,
}

impl Projection {
    /// Largest fraction of the energy that the known modes miss \[-\].
    pub fn worst(&self) -> f64 {
        self.lacking.iter().map(|[_, share]| *share).fold(0.0, f64::max)
    }

    /// Whether the modes of reference bodies of workpiece and table represent the motion well enough.
    pub fn holds(&self) -> bool {
        self.within(LIMIT)
    }

    fn within(&self, limit: f64) -> bool {
        self.fit.is_some() && self.worst() <= limit
    }
}

/// The surface that the boundary elements cover, with its surroundings and resolution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum RadiatingShape {
    /// The workpiece, and the worktable if any.
    Workpiece(WorkpieceBoundaryElements),
    /// The tool's housing.
    Tool(ToolRadiation),
    /// The tool's housing for each mode, followed by only its cap moving in that mode.
    Cap(ToolRadiation, CapSurface),
}

impl RadiatingShape {
    /// The finest mesh with the velocities of all modes, in standard air.
    fn finest(&self, surfaces: &[MovingSurface<'_>]) -> Result<Option<MeshRange>, Error> {
        let air = Air::default();
        match self {
            Self::Workpiece(elements) => elements.finest(surfaces, &air),
            Self::Tool(elements) => elements.finest(surfaces, None, &air),
            Self::Cap(elements, cap) => elements.finest(surfaces, Some(cap), &air),
        }
    }

    /// The meshes to be solved, with the velocities of all modes, in standard air.
    pub(super) fn mesh_hierarchy(&self, surfaces: &[MovingSurface<'_>]) -> Result<Vec<MeshRange>, Error> {
        let air = Air::default();
        match self {
            Self::Workpiece(elements) => elements.mesh_hierarchy(surfaces, &air),
            Self::Tool(elements) => elements.mesh_hierarchy(surfaces, None, &air),
            Self::Cap(elements, cap) => elements.mesh_hierarchy(surfaces, Some(cap), &air),
        }
    }

    /// Maximum fraction of the energy that the modes of this number of reference structures may miss.
    pub(crate) fn limit(&self, structures: usize) -> f64 {
        match self {
            Self::Workpiece(_) => LIMIT,
            Self::Tool(_) | Self::Cap(..) if structures < 2 => LIMIT_OF_FIRST_TOOL,
            Self::Tool(_) | Self::Cap(..) => LIMIT_OF_BOTH_TOOLS,
        }
    }

    fn top_hz(&self) -> f64 {
        match self {
            Self::Workpiece(elements) => elements.resolution.highest_hz(),
            Self::Tool(elements) | Self::Cap(elements, _) => elements.resolution.highest_hz(),
        }
    }
}

/// Fits the modes of the design's bodies by those of reference bodies of the same shape.
#[derive(Serialize)]
pub struct ReferenceProjection {
    /// The surface.
    pub shape: RadiatingShape,
    /// The modes of reference bodies.
    pub standard: SurfaceModes,
    /// The design's bodies.
    pub bodies: Vec<Stored<Body>>,
}

impl Stage for ReferenceProjection {
    type Output = Projection;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "fit of surface velocities";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Projection, Error> {
        let (standard, bodies) = (self.standard.get()?, all(&self.bodies)?);
        let own: Vec<_> = bodies.iter().map(|body| body.moving_surface()).collect();
        let (known, own) = rayon::join(|| self.shape.finest(&standard.surfaces()), || self.shape.finest(&own));
        let both = known?.zip(own?);
        let fit = both.and_then(|(known, own)| SurfaceFit::new(&known, &own));
        let bodies: Vec<&Body> = bodies.iter().map(|body| &**body).collect();
        let lacking = fit.as_ref().map(|fit| lacking(fit, &bodies, self.shape.top_hz()));
        Ok(Projection {
            lacking: lacking.unwrap_or_default(),
            fit,
        })
    }
}

/// The fraction of the energy of the surface's motion that a fit misses, for each frequency. Each body moves
/// independently under a force of one newton at each of its loads and supports; the energies under all are summed
/// before they are divided. The result is that of the worst body.
fn lacking(fit: &SurfaceFit, bodies: &[&Body], top_hz: f64) -> Vec<[f64; 2]> {
    let modes: usize = bodies.iter().map(|body| body.omega.len()).sum();
    let places = (0..fit.modes() / modes.max(1)).flat_map(|part| {
        let first = bodies.iter().scan(part * modes, |next, body| {
            let first = *next;
            *next += body.omega.len();
            Some((first, *body))
        });
        first.collect::<Vec<_>>()
    });
    let places: Vec<(usize, &Body)> = places.collect();
    let count = (PER_OCTAVE * (top_hz / LOWEST_HZ).log2()).ceil().max(1.0) as i32;
    let at = |number: i32| {
        let hz = LOWEST_HZ * 2f64.powf(f64::from(number) / PER_OCTAVE);
        let share = |&(first, body): &(usize, &Body)| {
            let loads = [&body.loads, &body.contacts];
            let mut amplitudes = DMatrix::zeros(body.omega.len(), loads.iter().map(|loads| loads.ncols()).sum());
            let columns = loads.into_iter().flat_map(|loads| loads.column_iter());
            for (mut to, load) in amplitudes.column_iter_mut().zip(columns) {
                for ((to, force), omega) in to.iter_mut().zip(load.iter()).zip(&body.omega) {
                    let (square, driven) = (omega * omega, (TAU * hz).powi(2));
                    *to = Complex::from(*force) / Complex::new(square - driven, LOSS_FACTOR * square);
                }
            }
            let [whole, rest] = fit.squares(first, &amplitudes);
            if whole > 0.0 { rest / whole } else { 0.0 }
        };
        [hz, places.iter().map(share).fold(0.0, f64::max)]
    };
    (0..=count).map(at).collect()
}

/// Known results of reference bodies in the shape of a design's.
#[derive(Serialize)]
#[serde(bound = "T: Send + Sync + 'static")]
pub struct ReferenceResult<T> {
    /// Quality with which their modes represent those of the design's bodies.
    pub fit: Stored<Projection>,
    /// The known results of their modes; read only if the fit is good enough.
    pub known: Stored<T>,
    /// Description of the bodies.
    pub name: &'static str,
    /// Maximum fraction of the energy that their modes may miss.
    pub limit: f64,
}

/// The radiation matrix of the design's bodies. It is carried over from the first reference bodies that represent their
/// motion; if none do, it is solved for the design's modes.
#[derive(Serialize)]
pub struct ProjectedMatrix {
    /// Reference bodies, in the order in which they are tried.
    pub references: OnDemand<Vec<ReferenceResult<ModalBem>>>,
    /// The matrix of the design's modes; read only if no fit is good enough.
    pub own: OnDemand<Stored<ModalBem>>,
}

impl Stage for ProjectedMatrix {
    type Output = ModalBem;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation from reference structures";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<ModalBem, Error> {
        for ReferenceResult {
            fit,
            known,
            name,
            limit,
        } in self.references.iter()
        {
            let fitted = fit.get()?;
            let Some(combinations) = &fitted.fit else {
                progress.note(&format!("radiation: the surface differs from that of {name}"));
                continue;
            };
            let lack = format!("{:.1e} of the energy of the surface's motion", fitted.worst());
            if !fitted.within(*limit) {
                progress.note(&format!(
                    "radiation: the modes of {name} miss up to {lack}, more than {limit:.0e}"
                ));
                continue;
            }
            progress.note(&format!(
                "radiation: taken from {name}, whose modes miss at most {lack}"
            ));
            return known.get()?.of_modes(combinations).ok_or(
                BodyError::OtherModes {
                    body: "reference bodies",
                }
                .into(),
            );
        }
        progress.note("radiation: boundary elements solved for the design's own modes");
        Ok(ModalBem::clone(&*self.own.get()?))
    }
}

/// The pressures at the microphones in the modes whose radiation [`ProjectedMatrix`] uses.
#[derive(Serialize)]
pub struct ProjectedPressures {
    /// As in [`ProjectedMatrix`].
    pub references: OnDemand<Vec<ReferenceResult<ModalPressures>>>,
    /// The pressures of the design's modes; read only if no fit is good enough.
    pub own: OnDemand<Stored<ModalPressures>>,
}

impl Stage for ProjectedPressures {
    type Output = ModalPressures;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "pressure from reference structures";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ModalPressures, Error> {
        for ReferenceResult { fit, known, limit, .. } in self.references.iter() {
            if fit.get()?.within(*limit) {
                return Ok(ModalPressures::clone(&*known.get()?));
            }
        }
        Ok(ModalPressures::clone(&*self.own.get()?))
    }
}

//! Faults of radiating surfaces.

use miette::Diagnostic;
use thiserror::Error;

/// Why the radiation of a surface cannot be computed.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A cap that cannot be separated from the rest of the body.
    #[error("{} of {} panels of the tool's outline are its cap", panels[0], panels[1])]
    NoCapSurface {
        /// Name of the surface in the file of a body; none for the parametric one.
        surface: Option<&'static str>,
        /// Number of panels on the cap and on the complete outline.
        panels: [usize; 2],
    },
    /// A surface within the tool that is open to the outside.
    #[error("the tool's surface `{surface}`, the wall of an enclosed volume of air, lies in the open air")]
    #[diagnostic(help("close the gap in the wall around that volume"))]
    OpenCavity {
        /// Name of the surface.
        surface: String,
    },
    /// The sides of a mesh of block or table differ from those that radiate.
    #[error(
        "block and table radiate as boxes of the design's dimensions; the sides of `workpiece.mesh` or \
         `support.worktable.mesh` are others"
    )]
    #[diagnostic(help(
        "give the mesh's dimensions (workpiece.length, width, thickness; support.worktable.length, width, height, \
         top_thickness, leg_width), or set acoustics.method = \"erp\"; on a floor, clamped or on springs a block \
         radiates from the faces of its own mesh"
    ))]
    NotBoxes {
        /// Place of the difference.
        #[source]
        cause: nailnoise_acoustics::AcousticsError,
    },
    /// A microphone, or the operator's ear, is so close to a body that its pressure cannot be computed.
    #[error("a microphone or the operator's ear is too close to a body")]
    #[diagnostic(help(
        "move the ear (`acoustics.ear_along`, `acoustics.ear_across`, `acoustics.ear_height`); the other microphones \
         follow the \
         nail's place and the tool's height"
    ))]
    MicrophoneNearSurface {
        /// The place and its distance.
        #[source]
        cause: nailnoise_acoustics::ReceiverError,
    },
}

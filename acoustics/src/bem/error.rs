use crate::checks::InputError;
use thiserror::Error;

/// Why the boundary element method cannot be applied to a surface or a frequency.
#[derive(Debug, Error)]
pub enum BemError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A surface whose exterior problem is to be solved has a hole.
    #[error(
        "the surface is open: {edges} edges belong to one panel only, one of them near {at:?} m; merge coincident \
         nodes \
         or close the hole (a body may be open only where it stands on the floor)"
    )]
    OpenSurface {
        /// Number of open edges.
        edges: usize,
        /// Middle of one of them \[m\].
        at: [f64; 3],
    },
    /// More than two panels meet at an edge, or a panel meets it twice.
    #[error(
        "{panels} panels meet at the edge near {at:?} m; a closed surface has two at every edge, remove the others"
    )]
    TangledSurface {
        /// Number of panels at the edge.
        panels: usize,
        /// Middle of the edge \[m\].
        at: [f64; 3],
    },
    /// The floor cuts through the body or lies above it.
    #[error(
        "the floor z = {floor} m lies above the body's lowest point z = {lowest} m (its highest is {highest} m); \
         lower the \
         floor or raise the body"
    )]
    FloorThroughBody {
        /// Height of the floor \[m\].
        floor: f64,
        /// Lowest point of the body \[m\].
        lowest: f64,
        /// Highest point of the body \[m\].
        highest: f64,
    },
    /// A mirror plane cuts the part of the surface that should lie above it.
    #[error(
        "the mirror plane {axis} = {plane} m lies above the lowest {axis} = {lowest} m of the part given; give the \
         part \
         above the plane alone, or the whole surface without the mirror"
    )]
    MirrorThroughPart {
        /// Axis across the plane.
        axis: &'static str,
        /// Position of the plane \[m\].
        plane: f64,
        /// Lowest coordinate along the axis \[m\].
        lowest: f64,
    },
    /// A panel is not covered by the faces of the volume mesh that moves it.
    #[error(
        "the faces of the volume mesh cover {share:.6} of panel {panel} near {at:?} m; body and boundary mesh must \
         have \
         the same flat sides"
    )]
    Uncovered {
        /// Index of the panel.
        panel: usize,
        /// Its centre \[m\].
        at: [f64; 3],
        /// Covered fraction of its area.
        share: f64,
    },
    /// A surface that should be flat is not.
    #[error(
        "panel {panel} lies up to {off:.1e} m out of the plane of the first; a thin plate is given by its flat midplane"
    )]
    NotFlat {
        /// Index of the panel.
        panel: usize,
        /// Largest distance of its nodes from the plane \[m\].
        off: f64,
    },
    /// A panel has zero area.
    #[error("panel {panel} has an area of {area:.1e} m2; remove it or repair the mesh")]
    DegeneratePanel {
        /// Index of the panel.
        panel: usize,
        /// Its area \[m²\].
        area: f64,
    },
    /// The mesh does not resolve the wavelength.
    #[error(
        "the panels' longest edge, {edge} m, is 1/{per_wavelength:.1} of the wavelength at {hz:.0} Hz; 1/{needed} is \
         needed: stay below {highest:.0} Hz or refine the mesh"
    )]
    TooCoarse {
        /// Requested frequency \[Hz\].
        hz: f64,
        /// Longest edge \[m\].
        edge: f64,
        /// Panels per wavelength.
        per_wavelength: f64,
        /// Required panels per wavelength.
        needed: f64,
        /// Highest frequency the mesh resolves \[Hz\].
        highest: f64,
    },
    /// The compressed equations did not converge.
    #[error(
        "after {steps} steps the residual of the compressed boundary-element equations is {residual:.1e} of the \
         right-hand \
         side, {tolerance:.0e} is needed; solve them with the dense matrix"
    )]
    NotConverged {
        /// Largest residual of a pattern relative to its right-hand side.
        residual: f64,
        /// Required residual.
        tolerance: f64,
        /// Number of steps taken.
        steps: usize,
    },
}

use crate::checks::InputError;
use thiserror::Error;

/// Why a radiation operator cannot be built.
#[derive(Debug, Error)]
pub enum RadiationError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The Rayleigh integral requires a single plane surface that faces up.
    #[error(
        "surface point {point} lies {offset} m off the plane z = {plane} m or its normal is not +z (n_z = {normal}); \
         the Rayleigh integral holds for a flat face in a rigid plane, use another operator for this surface"
    )]
    NotPlanar {
        /// Index of the quadrature point.
        point: usize,
        /// Distance from the plane \[m\].
        offset: f64,
        /// Height of the plane \[m\].
        plane: f64,
        /// Vertical component of the point's normal.
        normal: f64,
    },
    /// A patch index exceeds the list of patch names.
    #[error("surface point {point} belongs to patch {patch}, but only {patches} patches are named")]
    Patch {
        /// Index of the quadrature point.
        point: usize,
        /// Its patch index.
        patch: usize,
        /// Number of named patches.
        patches: usize,
    },
    /// The block's footprint does not lie inside the sand box.
    #[error("the footprint {footprint:?} m (x, y) does not lie inside the sand box {sand:?} m; enlarge the box")]
    SandBox {
        /// Half-open intervals of the block's top: x, then y \[m\].
        footprint: [[f64; 2]; 2],
        /// Intervals of the sand surface: x, then y \[m\].
        sand: [[f64; 2]; 2],
    },
}

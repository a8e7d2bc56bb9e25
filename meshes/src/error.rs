//! What can be wrong with a mesh or a request to it.

use std::path::PathBuf;

/// An error of this crate; every variant carries the numbers and names the remedy.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// A dimension is not a positive finite number.
    #[error("{what} is {value} m; give a positive length")]
    Dimension {
        /// Which dimension.
        what: &'static str,
        /// The value found \[m\].
        value: f64,
    },
    /// A direction was to be divided into no elements.
    #[error("{what} would have no element; ask for at least one")]
    NoElements {
        /// Which direction.
        what: &'static str,
    },
    /// Two dimensions exclude each other.
    #[error("{what}: {inner} m does not fit into {outer} m; make it smaller")]
    DoesNotFit {
        /// Which dimensions.
        what: &'static str,
        /// The part's size \[m\].
        inner: f64,
        /// The room it has \[m\].
        outer: f64,
    },
    /// Grid lines do not increase.
    #[error("grid line {index} along {axis} at {value} m does not lie above the one before it; sort the lines")]
    GridLines {
        /// `x`, `y` or `z`.
        axis: char,
        /// Index of the offending line.
        index: usize,
        /// Its coordinate \[m\].
        value: f64,
    },
    /// No face group has this name.
    #[error("no face group \"{name}\"; the mesh has: {known}")]
    UnknownGroup {
        /// The name asked for.
        name: String,
        /// The names there are, comma separated.
        known: String,
    },
    /// No element or face holds the point.
    #[error("point ({x}, {y}, {z}) m lies outside {place}, {distance} m from the nearest part of it; move it inside")]
    Outside {
        /// Coordinate \[m\].
        x: f64,
        /// Coordinate \[m\].
        y: f64,
        /// Coordinate \[m\].
        z: f64,
        /// Where it was looked for.
        place: String,
        /// Distance to what was searched \[m\].
        distance: f64,
    },
    /// A field to be written does not match the mesh.
    #[error("field \"{name}\" has {found} values, the mesh needs {expected}; give one value a component of each item")]
    FieldLength {
        /// Field name.
        name: String,
        /// Values given.
        found: usize,
        /// Values needed.
        expected: usize,
    },
    /// Writing a file failed.
    #[error("cannot write {path}: {source}; check that the folder exists and has room")]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The VTK library refused the data.
    #[error("cannot encode {path} as VTK XML: {reason}")]
    Encode {
        /// The file that was to be written.
        path: PathBuf,
        /// The library's reason.
        reason: String,
    },
    /// A quadrature rule without points was asked for.
    #[error("a Gauss rule with {points} points is not available; use at least 1")]
    GaussPoints {
        /// Points asked for.
        points: usize,
    },
}

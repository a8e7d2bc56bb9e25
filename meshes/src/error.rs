//! Errors in a mesh or in a request to it.

use std::path::PathBuf;

use crate::MshError;

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
    /// A direction would be divided into no elements.
    #[error("{what} would have no element; ask for at least one")]
    NoElements {
        /// Which direction.
        what: &'static str,
    },
    /// Two dimensions are incompatible.
    #[error("{what}: {inner} m does not fit into {outer} m; make it smaller")]
    DoesNotFit {
        /// Which dimensions.
        what: &'static str,
        /// Size of the part \[m\].
        inner: f64,
        /// Space available for it \[m\].
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
        /// The requested name.
        name: String,
        /// The available names, comma separated.
        known: String,
    },
    /// No element or face contains the point.
    #[error("point ({x}, {y}, {z}) m lies outside {place}, {distance} m from the nearest part of it; move it inside")]
    Outside {
        /// Coordinate \[m\].
        x: f64,
        /// Coordinate \[m\].
        y: f64,
        /// Coordinate \[m\].
        z: f64,
        /// The searched elements or faces.
        place: String,
        /// Distance to the searched elements or faces \[m\].
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
    /// A VTK file could not be composed.
    #[error("vtkio cannot compose the file: {0}")]
    Vtk(#[from] vtkio::xml::Error),
    /// An HDF5 file could not be composed.
    #[error("hdf5-pure cannot compose the file: {0}")]
    Hdf5(#[from] hdf5_pure::Error),
    /// Writing a file failed.
    #[error("cannot write {path}: {source}; check that the folder exists and has room")]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Reading a file failed.
    #[error("cannot read {}: {source}; check its name and that it may be read", path.display())]
    Read {
        /// The file that was to be read.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A `.msh` file is damaged or unsuitable.
    #[error("{}: {problem}", path.display())]
    Msh {
        /// The file.
        path: PathBuf,
        /// The fault.
        problem: MshError,
    },
    /// Elements of a mesh are inverted or degenerate.
    #[error(
        "element {element} has the Jacobian determinant {determinant:.3e} m3 at its worst node, as the worst of \
         {inverted} \
         inverted or flat elements of {of}; repair the mesh (gmsh: Mesh.HighOrderOptimize = 2, or \
         Mesh.SecondOrderLinear = 1), or turn the elements round if all are inverted"
    )]
    Inverted {
        /// Number of the element: that of its file if it has one, else its index.
        element: u64,
        /// Its Jacobian determinant \[m3\].
        determinant: f64,
        /// Number of inverted or degenerate elements.
        inverted: usize,
        /// Total number of elements.
        of: usize,
    },
    /// More than two elements share a face.
    #[error(
        "{edges} edges of the skin are open or wrongly oriented: elements overlap, so that more than two share a \
         face; remove the \
         elements that are there twice (gmsh: Coherence Mesh)"
    )]
    OpenSkin {
        /// Number of such edges.
        edges: usize,
    },
    /// gmsh cannot be found.
    #[error(
        "new geometry needs gmsh, and {program} cannot be started ({reason}); install it with \
         `apt-get install --no-install-recommends gmsh` (Debian, Ubuntu), `brew install gmsh` or `pip install gmsh`, \
         or name the program in NAILNOISE_GMSH"
    )]
    NoGmsh {
        /// The program.
        program: String,
        /// Error of the operating system.
        reason: String,
    },
    /// gmsh could not mesh a geometry.
    #[error("gmsh could not mesh {what}: {reason}; repair the geometry or change the element size")]
    Gmsh {
        /// The geometry.
        what: String,
        /// The message of gmsh.
        reason: String,
    },
    /// gmsh exceeded its time limit.
    #[error(
        "gmsh could not mesh {what}: it had not ended after {seconds} s of processor time, several times what such a \
         body takes: its \
         dimensions do not go together, or its elements are too small for it; repair the geometry or change the \
         element size"
    )]
    OutOfTime {
        /// The geometry.
        what: String,
        /// Its limit of processor time \[s\].
        seconds: u64,
    },
    /// A geometry consists of faces without a solid.
    #[error(
        "{what} contains {faces} faces and no solid, also after sewing faces with common edges; export a solid body \
         (STEP: \"solid\", \
         not \"surfaces\" or \"shells\")"
    )]
    Sheets {
        /// The geometry.
        what: String,
        /// Number of faces.
        faces: usize,
    },
    /// The requested solid does not exist.
    #[error("{what} has no solid {asked}; there are {solids}")]
    NoSolid {
        /// The geometry.
        what: String,
        /// The requested number, from 1.
        asked: usize,
        /// Description of the available solids.
        solids: String,
    },
    /// A mesh would need more memory than allowed.
    #[error(
        "{what} with element sides of at most {} mm would have about {elements:.1e} elements, for which gmsh needs \
         {gigabytes:.1} GB; \
         {allowed:.1} GB are allowed (--memory); allow longer elements, or check the size of the geometry", 1e3 * size
    )]
    TooFine {
        /// The geometry.
        what: String,
        /// Longest element side requested \[m\].
        size: f64,
        /// Estimated number of elements.
        elements: f64,
        /// Memory required \[GB\].
        gigabytes: f64,
        /// Memory allowed \[GB\].
        allowed: f64,
    },
    /// A solid geometry is far too large or too small for the object that it represents.
    #[error("{what} is {extent:.4e} m long, expected are {:.4e} to {:.4e} m; give the unit of its \
        lengths", expected[0], expected[1])]
    Extent {
        /// The geometry.
        what: String,
        /// Its longest side along an axis \[m\].
        extent: f64,
        /// Its allowed range \[m\].
        expected: [f64; 2],
    },
    /// gmsh exceeds the requested element size.
    #[error(
        "gmsh leaves an element side of {longest:.4} m in {what}, where {size:.4} m is asked for; divide its faces \
         (gmsh: \
         Mesh.OptimizeNetgen = 1), or allow longer elements"
    )]
    TooLong {
        /// The geometry.
        what: String,
        /// The longest side in the finest mesh \[m\].
        longest: f64,
        /// The longest side allowed \[m\].
        size: f64,
    },
    /// gmsh cannot open this type of geometry file.
    #[error("{}: known are .msh, .msh.gz, .step, .stp, .brep, .igs and .iges", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// The mesh cannot be written in this file format.
    #[error("{}: meshes are written as .vtu, .msh or .msh.gz", path.display())]
    UnknownOutput {
        /// The file.
        path: PathBuf,
    },
    /// A quadrature rule was requested with an unsupported number of points.
    #[error("a Gauss rule with {points} points is not available; use at least 1")]
    GaussPoints {
        /// Number of points requested.
        points: usize,
    },
}

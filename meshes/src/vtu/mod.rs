//! VTK XML files: `.vtu` grids with fields, and `.pvd` lists that combine them to a series.
//!
//! The crate vtkio writes meshes, surfaces and polygons ([`Grid`]), compressed by zlib. Film frames share one grid; see
//! [`Frames`]. Meshes are written in double precision, so that they can be read back unchanged; surfaces and polygons,
//! which are only viewed, in single precision.

mod frames;
mod grid;

pub use frames::{Array, Frames};
pub use grid::Grid;

use crate::MeshError;

/// A field to be written, with `components` values per item.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Name shown by the reader; include the unit, as in `velocity [m/s]`.
    pub name: &'a str,
    /// 1 for a scalar, 3 for a vector.
    pub components: usize,
    /// The values: `components` for each node or cell.
    pub values: &'a [f64],
}

/// A `.pvd` series: pairs of time (or frequency) and `.vtu` file, relative to the folder of the series.
pub fn series(files: &[(f64, String)]) -> String {
    let entry = |(time, file): &(f64, String)| {
        let file = escaped(file);
        format!("    <DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{file}\"/>\n")
    };
    let entries: String = files.iter().map(entry).collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  \
         <Collection>\n{entries}  </Collection>\n</VTKFile>\n"
    )
}

/// Escapes a name for use as an XML attribute.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

pub(crate) fn check(name: &str, found: usize, expected: usize) -> Result<(), MeshError> {
    if found == expected {
        return Ok(());
    }
    let name = name.to_owned();
    Err(MeshError::FieldLength { name, found, expected })
}

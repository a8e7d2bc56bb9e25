//! VTK XML files: `.vtu` grids with fields and the `.pvd` list that makes a series of them.
//!
//! Arrays stand in their elements, little-endian bytes in zlib streams in base64, which VTK, ParaView, pyvista, meshio and
//! vtkio read (appended raw data would be a quarter shorter; vtkio does not read them): meshes in double precision, to be
//! read back as they are; surfaces and polygons, which are pictures, in single. The files of a series repeat their surface,
//! and a velocity is noise to a compressor. So a [`Grid`] is compressed once for all files that show it, and an [`Array`]
//! is laid into streams that hold its bytes as they are, at the price of a copy and a checksum.

mod array;
mod grid;

use std::fmt::Write;

pub use array::Array;
pub use grid::Grid;

/// A field to be written: values item by item, `components` of each.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Name shown by the reader; give the unit in it, as in `velocity [m/s]`.
    pub name: &'a str,
    /// 1 for a scalar, 3 for a vector.
    pub components: usize,
    /// The values, components x nodes (or cells) of them.
    pub values: &'a [f64],
}

/// A `.pvd` series: pairs of time (or frequency) and the `.vtu` file, relative to the series' folder.
pub fn series(files: &[(f64, String)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    for (time, file) in files {
        let file = escaped(file);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            r#"    <DataSet timestep="{time}" group="" part="0" file="{file}"/>"#
        );
    }
    text.push_str("  </Collection>\n</VTKFile>\n");
    text
}

/// A name as an attribute has it.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

//! VTK XML files: `.vtu` grids with fields and the `.pvd` list that makes a series of them.
//!
//! Data are written inline as base64 in little-endian binary, which VTK, ParaView and meshio read.

use std::io::Write;
use std::path::Path;

use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

use crate::{Mesh, MeshError, Surface, write_atomic};

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

/// Writes a volume mesh with point and cell fields; the part of each element is added as the cell field `part`.
///
/// # Errors
/// [`MeshError::FieldLength`], [`MeshError::Encode`] or [`MeshError::Write`].
pub fn write_mesh(path: &Path, mesh: &Mesh, points: &[Field<'_>], cells: &[Field<'_>]) -> Result<(), MeshError> {
    let types = mesh.kinds.iter().map(|k| k.vtk_type()).collect();
    let part: Vec<f64> = mesh.parts.iter().map(|&p| p as f64).collect();
    let mut cells = cells.to_vec();
    cells.push(Field {
        name: "part",
        components: 1,
        values: &part,
    });
    let xyz = mesh.nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    write(path, xyz, &mesh.connectivity, &mesh.offsets[1..], types, points, &cells)
}

/// Writes a surface with point and cell fields; the patch of each face is added as the cell field `patch`.
///
/// # Errors
/// [`MeshError::FieldLength`], [`MeshError::Encode`] or [`MeshError::Write`].
pub fn write_surface(
    path: &Path,
    surface: &Surface,
    points: &[Field<'_>],
    cells: &[Field<'_>],
) -> Result<(), MeshError> {
    let types = surface.faces.iter().map(|f| f.kind.vtk_type()).collect();
    let (mut connectivity, mut offsets) = (Vec::new(), Vec::new());
    for face in &surface.faces {
        connectivity.extend_from_slice(&face.nodes);
        offsets.push(connectivity.len());
    }
    let patch: Vec<f64> = surface.faces.iter().map(|f| f.patch as f64).collect();
    let mut cells = cells.to_vec();
    cells.push(Field {
        name: "patch",
        components: 1,
        values: &patch,
    });
    let xyz = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    write(path, xyz, &connectivity, &offsets, types, points, &cells)
}

/// Writes a `.pvd` series: pairs of time (or frequency) and the `.vtu` file, relative to the series' folder.
///
/// # Errors
/// [`MeshError::Write`].
pub fn write_series(path: &Path, files: &[(f64, String)]) -> Result<(), MeshError> {
    let mut text = Vec::new();
    let source = |source| MeshError::Write {
        path: path.to_owned(),
        source,
    };
    let mut lines = || -> std::io::Result<()> {
        writeln!(text, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            text,
            r#"<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">"#
        )?;
        writeln!(text, "  <Collection>")?;
        for (time, file) in files {
            let file = file.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
            writeln!(
                text,
                r#"    <DataSet timestep="{time}" group="" part="0" file="{file}"/>"#
            )?;
        }
        writeln!(text, "  </Collection>")?;
        writeln!(text, "</VTKFile>")
    };
    lines().map_err(source)?;
    write_atomic(path, &text).map_err(source)
}

fn write(
    path: &Path,
    xyz: Vec<f64>,
    connectivity: &[usize],
    offsets: &[usize],
    types: Vec<u8>,
    points: &[Field<'_>],
    cells: &[Field<'_>],
) -> Result<(), MeshError> {
    let encode = |reason: String| MeshError::Encode {
        path: path.to_owned(),
        reason,
    };
    let types = types
        .into_iter()
        .map(|code| match code {
            5 => Ok(CellType::Triangle),
            9 => Ok(CellType::Quad),
            10 => Ok(CellType::Tetra),
            12 => Ok(CellType::Hexahedron),
            22 => Ok(CellType::QuadraticTriangle),
            23 => Ok(CellType::QuadraticQuad),
            24 => Ok(CellType::QuadraticTetra),
            25 => Ok(CellType::QuadraticHexahedron),
            26 => Ok(CellType::QuadraticWedge),
            28 => Ok(CellType::BiquadraticQuad),
            29 => Ok(CellType::TriquadraticHexahedron),
            other => Err(encode(format!("cell type {other} has no VTK counterpart here"))),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let data = Attributes {
        point: attributes(points, xyz.len() / 3)?,
        cell: attributes(cells, types.len())?,
    };
    let vertices = VertexNumbers::XML {
        connectivity: connectivity.iter().map(|&i| i as u64).collect(),
        offsets: offsets.iter().map(|&i| i as u64).collect(),
    };
    let cells = Cells {
        cell_verts: vertices,
        types,
    };
    let piece = UnstructuredGridPiece {
        points: IOBuffer::F64(xyz),
        cells,
        data,
    };
    let vtk = Vtk {
        version: Version::XML { major: 1, minor: 0 },
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        data: DataSet::inline(piece),
        file_path: None,
    };
    let mut bytes = Vec::new();
    vtk.write_xml(&mut bytes).map_err(|e| encode(e.to_string()))?;
    write_atomic(path, &bytes).map_err(|source| MeshError::Write {
        path: path.to_owned(),
        source,
    })
}

fn attributes(fields: &[Field<'_>], items: usize) -> Result<Vec<Attribute>, MeshError> {
    fields
        .iter()
        .map(|f| {
            let expected = items * f.components;
            if f.values.len() != expected {
                let (name, found) = (f.name.to_owned(), f.values.len());
                return Err(MeshError::FieldLength { name, found, expected });
            }
            let attribute = match f.components {
                3 => Attribute::vectors(f.name),
                n => Attribute::scalars(f.name, n as u32),
            };
            Ok(attribute.with_data(f.values.to_vec()))
        })
        .collect()
}

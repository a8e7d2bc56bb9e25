//! VTK XML files: `.vtu` grids with fields and the `.pvd` list that makes a series of them.
//!
//! Data are written inline as base64 in little-endian binary, which VTK, ParaView and meshio read: meshes in double
//! precision, to be read back as they are; surfaces, which are pictures, in single.

use std::io::Write;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

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
/// [`MeshError::FieldLength`] or [`MeshError::Write`].
pub fn write_mesh(path: &Path, mesh: &Mesh, points: &[Field<'_>], cells: &[Field<'_>]) -> Result<(), MeshError> {
    let types: Vec<u8> = mesh.kinds.iter().map(|k| k.vtk_type()).collect();
    let part: Vec<f64> = mesh.parts.iter().map(|&p| p as f64).collect();
    let mut cells = cells.to_vec();
    cells.push(Field {
        name: "part",
        components: 1,
        values: &part,
    });
    let xyz: Vec<f64> = mesh.nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let grid = Grid {
        xyz: &xyz,
        connectivity: &mesh.connectivity,
        offsets: &mesh.offsets[1..],
        types: &types,
        single: false,
    };
    grid.write(path, points, &cells)
}

/// Writes a surface with point and cell fields; the patch of each face is added as the cell field `patch`.
///
/// # Errors
/// [`MeshError::FieldLength`] or [`MeshError::Write`].
pub fn write_surface(
    path: &Path,
    surface: &Surface,
    points: &[Field<'_>],
    cells: &[Field<'_>],
) -> Result<(), MeshError> {
    let types: Vec<u8> = surface.faces.iter().map(|f| f.kind.vtk_type()).collect();
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
    let xyz: Vec<f64> = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let grid = Grid {
        xyz: &xyz,
        connectivity: &connectivity,
        offsets: &offsets,
        types: &types,
        single: true,
    };
    grid.write(path, points, &cells)
}

/// Writes polygons, given by the numbers of their corners in order, with point and cell fields; a picture, in single
/// precision.
///
/// # Errors
/// [`MeshError::FieldLength`] or [`MeshError::Write`].
pub fn write_polygons(
    path: &Path,
    (corners, polygons): (&[[f64; 3]], &[Vec<usize>]),
    points: &[Field<'_>],
    cells: &[Field<'_>],
) -> Result<(), MeshError> {
    let types: Vec<u8> = polygons
        .iter()
        .map(|polygon| match polygon.len() {
            3 => 5,
            4 => 9,
            _ => 7,
        })
        .collect();
    let end = |sum: &mut usize, polygon: &Vec<usize>| {
        *sum += polygon.len();
        Some(*sum)
    };
    let offsets: Vec<usize> = polygons.iter().scan(0, end).collect();
    let grid = Grid {
        xyz: corners.as_flattened(),
        connectivity: &polygons.concat(),
        offsets: &offsets,
        types: &types,
        single: true,
    };
    grid.write(path, points, cells)
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

/// An unstructured grid as the file has it.
struct Grid<'a> {
    xyz: &'a [f64],
    connectivity: &'a [usize],
    offsets: &'a [usize],
    types: &'a [u8],
    /// Whether numbers are written in single precision.
    single: bool,
}

impl Grid<'_> {
    fn write(&self, path: &Path, points: &[Field<'_>], cells: &[Field<'_>]) -> Result<(), MeshError> {
        let (nodes, elements) = (self.xyz.len() / 3, self.types.len());
        check(points, nodes)?;
        check(cells, elements)?;
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{elements}\">\n"
        );
        for (section, fields) in [("PointData", points), ("CellData", cells)] {
            text.push_str(&format!("<{section}>\n"));
            for field in fields {
                self.numbers(&mut text, field.name, field.components, field.values);
            }
            text.push_str(&format!("</{section}>\n"));
        }
        text.push_str("<Points>\n");
        self.numbers(&mut text, "points", 3, self.xyz);
        text.push_str("</Points>\n<Cells>\n");
        for (name, indices) in [("connectivity", self.connectivity), ("offsets", self.offsets)] {
            if indices.iter().all(|&i| i32::try_from(i).is_ok()) {
                array(
                    &mut text,
                    "Int32",
                    name,
                    1,
                    indices.iter().map(|&i| (i as i32).to_le_bytes()),
                );
            } else {
                array(
                    &mut text,
                    "Int64",
                    name,
                    1,
                    indices.iter().map(|&i| (i as i64).to_le_bytes()),
                );
            }
        }
        array(&mut text, "UInt8", "types", 1, self.types.iter().map(|&kind| [kind]));
        text.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        write_atomic(path, text.as_bytes()).map_err(|source| MeshError::Write {
            path: path.to_owned(),
            source,
        })
    }

    fn numbers(&self, text: &mut String, name: &str, components: usize, values: &[f64]) {
        if self.single {
            let values = values.iter().map(|&x| (x as f32).to_le_bytes());
            array(text, "Float32", name, components, values);
        } else {
            array(
                text,
                "Float64",
                name,
                components,
                values.iter().map(|x| x.to_le_bytes()),
            );
        }
    }
}

/// One array: the number of its bytes and they themselves, as one stretch of base64.
fn array<const N: usize>(
    text: &mut String,
    kind: &str,
    name: &str,
    components: usize,
    values: impl ExactSizeIterator<Item = [u8; N]>,
) {
    let length = N * values.len();
    let mut bytes = Vec::with_capacity(8 + length);
    bytes.extend_from_slice(&(length as u64).to_le_bytes());
    values.for_each(|value| bytes.extend_from_slice(&value));
    let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    text.push_str(&format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    ));
    STANDARD.encode_string(&bytes, text);
    text.push_str("</DataArray>\n");
}

fn check(fields: &[Field<'_>], items: usize) -> Result<(), MeshError> {
    for field in fields {
        let (found, expected) = (field.values.len(), items * field.components);
        if found != expected {
            let name = field.name.to_owned();
            return Err(MeshError::FieldLength { name, found, expected });
        }
    }
    Ok(())
}

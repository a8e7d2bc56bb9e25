//! VTK XML files: `.vtu` grids with fields and the `.pvd` list that makes a series of them.
//!
//! Data are written inline as base64 in little-endian binary, which VTK, ParaView and meshio read: meshes in double
//! precision, to be read back as they are; surfaces, which are pictures, in single.

use std::fmt::Write;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

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
    let skin = Skin::of(surface);
    let cells = [cells, &[skin.patch()]].concat();
    skin.grid().write(path, points, &cells)
}

/// All of a surface's files that does not change from one to the next of a series: everything but point fields. It is
/// encoded once for all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Still {
    points: usize,
    before: String,
    after: String,
}

impl Still {
    /// Of a surface.
    pub fn of(surface: &Surface) -> Self {
        let skin = Skin::of(surface);
        let grid = skin.grid();
        Self {
            points: surface.points.len(),
            before: grid.before(),
            after: grid.after(&[skin.patch()]),
        }
    }

    /// Appends the file that [`write_surface`] writes with these point fields.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`]
    pub fn file(&self, fields: &[Single<'_>], text: &mut Vec<u8>) -> Result<(), MeshError> {
        text.extend_from_slice(self.before.as_bytes());
        for field in fields {
            let (found, expected) = (field.block.len(), HEADER + 4 * field.components * self.points);
            if found != expected {
                return Err(MeshError::FieldLength {
                    name: field.name.to_owned(),
                    found: found.saturating_sub(HEADER) / 4,
                    expected: field.components * self.points,
                });
            }
            encoded(text, ("Float32", field.name, field.components), field.block);
        }
        text.extend_from_slice(self.after.as_bytes());
        Ok(())
    }
}

/// A field in single precision as files have it.
#[derive(Clone, Copy, Debug)]
pub struct Single<'a> {
    /// Name shown by the reader; give the unit in it.
    pub name: &'a str,
    /// 1 for a scalar, 3 for a vector.
    pub components: usize,
    /// Its [`block`].
    pub block: &'a [u8],
}

/// Values as a file has them before they become text: the number of their bytes, then they, little-endian.
pub fn block(values: impl ExactSizeIterator<Item = f32>) -> Vec<u8> {
    bytes_of(values.map(f32::to_le_bytes))
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

/// Writes a `.pvd` [`series`].
///
/// # Errors
/// [`MeshError::Write`].
pub fn write_series(path: &Path, files: &[(f64, String)]) -> Result<(), MeshError> {
    write(path, series(files).as_bytes())
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

fn write(path: &Path, text: &[u8]) -> Result<(), MeshError> {
    write_atomic(path, text).map_err(|source| MeshError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A surface as the arrays of a grid.
struct Skin {
    xyz: Vec<f64>,
    connectivity: Vec<usize>,
    offsets: Vec<usize>,
    types: Vec<u8>,
    patch: Vec<f64>,
}

impl Skin {
    fn of(surface: &Surface) -> Self {
        let (mut connectivity, mut offsets) = (Vec::new(), Vec::new());
        for face in &surface.faces {
            connectivity.extend_from_slice(&face.nodes);
            offsets.push(connectivity.len());
        }
        Self {
            xyz: surface.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
            connectivity,
            offsets,
            types: surface.faces.iter().map(|f| f.kind.vtk_type()).collect(),
            patch: surface.faces.iter().map(|f| f.patch as f64).collect(),
        }
    }

    fn grid(&self) -> Grid<'_> {
        Grid {
            xyz: &self.xyz,
            connectivity: &self.connectivity,
            offsets: &self.offsets,
            types: &self.types,
            single: true,
        }
    }

    fn patch(&self) -> Field<'_> {
        Field {
            name: "patch",
            components: 1,
            values: &self.patch,
        }
    }
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
        check(points, self.xyz.len() / 3)?;
        check(cells, self.types.len())?;
        let mut text = self.before().into_bytes();
        points.iter().for_each(|field| self.numbers(&mut text, field));
        text.extend_from_slice(self.after(cells).as_bytes());
        write(path, &text)
    }

    /// The text before the first point field.
    fn before(&self) -> String {
        let (nodes, elements) = (self.xyz.len() / 3, self.types.len());
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{elements}\">\n\
             <PointData>\n"
        )
    }

    /// The text after the last point field: cell fields, points, cells.
    fn after(&self, cells: &[Field<'_>]) -> String {
        let mut text = b"</PointData>\n<CellData>\n".to_vec();
        cells.iter().for_each(|field| self.numbers(&mut text, field));
        text.extend_from_slice(b"</CellData>\n<Points>\n");
        let points = Field {
            name: "points",
            components: 3,
            values: self.xyz,
        };
        self.numbers(&mut text, &points);
        text.extend_from_slice(b"</Points>\n<Cells>\n");
        for (name, indices) in [("connectivity", self.connectivity), ("offsets", self.offsets)] {
            if indices.iter().all(|&i| i32::try_from(i).is_ok()) {
                let block = bytes_of(indices.iter().map(|&i| (i as i32).to_le_bytes()));
                encoded(&mut text, ("Int32", name, 1), &block);
            } else {
                let block = bytes_of(indices.iter().map(|&i| (i as i64).to_le_bytes()));
                encoded(&mut text, ("Int64", name, 1), &block);
            }
        }
        let types = bytes_of(self.types.iter().map(|&kind| [kind]));
        encoded(&mut text, ("UInt8", "types", 1), &types);
        text.extend_from_slice(b"</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        // All of it is ASCII but names of fields, which are text already.
        String::from_utf8_lossy(&text).into_owned()
    }

    fn numbers(&self, text: &mut Vec<u8>, field: &Field<'_>) {
        let Field {
            name,
            components,
            values,
        } = *field;
        if self.single {
            encoded(
                text,
                ("Float32", name, components),
                &block(values.iter().map(|&x| x as f32)),
            );
        } else {
            let block = bytes_of(values.iter().map(|x| x.to_le_bytes()));
            encoded(text, ("Float64", name, components), &block);
        }
    }
}

/// Bytes of the number before an array.
const HEADER: usize = 8;

/// The number of an array's bytes, and they themselves.
fn bytes_of<const N: usize>(values: impl ExactSizeIterator<Item = [u8; N]>) -> Vec<u8> {
    let length = N * values.len();
    let mut bytes = Vec::with_capacity(HEADER + length);
    bytes.extend_from_slice(&(length as u64).to_le_bytes());
    values.for_each(|value| bytes.extend_from_slice(&value));
    bytes
}

/// One array of a type, name and number of components: its bytes as one stretch of base64.
fn encoded(text: &mut Vec<u8>, (kind, name, components): (&str, &str, usize), bytes: &[u8]) {
    let name = escaped(name);
    let opening =
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">");
    text.extend_from_slice(opening.as_bytes());
    let start = text.len();
    text.resize(start + 4 * bytes.len().div_ceil(3), 0);
    // The slice has room for all.
    let length = STANDARD.encode_slice(bytes, &mut text[start..]).unwrap_or_default();
    text.truncate(start + length);
    text.extend_from_slice(b"</DataArray>\n");
}

/// A name as an attribute has it.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
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

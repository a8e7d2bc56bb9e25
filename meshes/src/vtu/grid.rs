//! Unstructured grids: what the files of a series show of a mesh, a surface or polygons, but for the fields on it.

use serde::{Deserialize, Serialize};

use super::Field;
use super::array::{Array, deflated, element};
use crate::{Mesh, MeshError, Surface};

/// What stands between the fields on points and those on cells.
const BETWEEN: &str = "</PointData>\n<CellData>\n";

/// A grid as files have it: the text around the elements of fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    points: usize,
    cells: usize,
    /// Whether fields are written in double precision.
    double: bool,
    before: String,
    #[serde(with = "serde_bytes")]
    after: Vec<u8>,
}

impl Grid {
    /// Of a volume mesh, in double precision; the part of each element is its cell field `part`.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let xyz: Vec<[f64; 3]> = mesh.nodes.iter().map(|p| [p.x, p.y, p.z]).collect();
        let part: Vec<f64> = mesh.parts.iter().map(|&part| part as f64).collect();
        let types: Vec<u8> = mesh.kinds.iter().map(|kind| kind.vtk_type()).collect();
        let mut own = Own::default();
        own.add("Float64", ("part", 1), &part, f64::to_le_bytes);
        own.points();
        own.add("Float64", ("points", 3), xyz.as_flattened(), f64::to_le_bytes);
        own.cells(&mesh.connectivity, &mesh.offsets[1..], &types);
        own.grid(mesh.nodes.len(), types.len(), true)
    }

    /// Of a surface, in single precision; the patch of each face is its cell field `patch`.
    pub fn of_surface(surface: &Surface) -> Self {
        let faces = || surface.faces.iter();
        let xyz: Vec<[f32; 3]> = surface
            .points
            .iter()
            .map(|p| [p.x, p.y, p.z].map(|x| x as f32))
            .collect();
        let patch: Vec<f32> = faces().map(|face| face.patch as f32).collect();
        let connectivity: Vec<usize> = faces().flat_map(|face| face.nodes.iter().copied()).collect();
        let offsets = ends(faces().map(|face| face.nodes.len()));
        let types: Vec<u8> = faces().map(|face| face.kind.vtk_type()).collect();
        let mut own = Own::default();
        own.add("Float32", ("patch", 1), &patch, f32::to_le_bytes);
        own.points();
        own.add("Float32", ("points", 3), xyz.as_flattened(), f32::to_le_bytes);
        own.cells(&connectivity, &offsets, &types);
        own.grid(surface.points.len(), types.len(), false)
    }

    /// Of polygons, given by the numbers of their corners in order, in single precision.
    pub fn of_polygons(corners: &[[f64; 3]], polygons: &[Vec<usize>]) -> Self {
        let xyz: Vec<[f32; 3]> = corners.iter().map(|corner| corner.map(|x| x as f32)).collect();
        let offsets = ends(polygons.iter().map(Vec::len));
        let vtk_type = |polygon: &Vec<usize>| match polygon.len() {
            3 => 5,
            4 => 9,
            _ => 7,
        };
        let types: Vec<u8> = polygons.iter().map(vtk_type).collect();
        let mut own = Own::default();
        own.points();
        own.add("Float32", ("points", 3), xyz.as_flattened(), f32::to_le_bytes);
        own.cells(&polygons.concat(), &offsets, &types);
        own.grid(corners.len(), types.len(), false)
    }

    /// The file that shows the grid with fields on its points and its cells.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`].
    pub fn to_bytes(&self, points: &[Field<'_>], cells: &[Field<'_>]) -> Result<Vec<u8>, MeshError> {
        let [points, cells] = [points, cells]
            .map(|fields| -> Vec<Array> { fields.iter().map(|field| Array::of(field, self.double)).collect() });
        let mut bytes = Vec::new();
        self.render(&points, &cells, &mut bytes)?;
        Ok(bytes)
    }

    /// Appends the file that shows the grid with arrays on its points and its cells.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`]
    pub fn render(&self, points: &[Array], cells: &[Array], bytes: &mut Vec<u8>) -> Result<(), MeshError> {
        check(points, self.points)?;
        check(cells, self.cells)?;
        let of_fields: usize = points.iter().chain(cells).map(Array::length).sum();
        bytes.reserve(self.before.len() + BETWEEN.len() + self.after.len() + of_fields);
        bytes.extend_from_slice(self.before.as_bytes());
        points.iter().for_each(|array| array.element(bytes));
        bytes.extend_from_slice(BETWEEN.as_bytes());
        cells.iter().for_each(|array| array.element(bytes));
        bytes.extend_from_slice(&self.after);
        Ok(())
    }
}

fn check(fields: &[Array], items: usize) -> Result<(), MeshError> {
    for field in fields {
        let [components, found] = field.shape();
        let expected = items * components;
        if found != expected {
            let name = field.name().to_owned();
            return Err(MeshError::FieldLength { name, found, expected });
        }
    }
    Ok(())
}

/// Where each cell ends in the connectivity.
fn ends(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let end = |sum: &mut usize, length: usize| {
        *sum += length;
        Some(*sum)
    };
    lengths.scan(0, end).collect()
}

/// The text of a grid's own arrays, in the order of their elements: cell fields, points, cells.
#[derive(Default)]
struct Own(Vec<u8>);

impl Own {
    fn add<T: Copy, const N: usize>(
        &mut self,
        kind: &str,
        (name, components): (&str, usize),
        values: &[T],
        le: impl Fn(T) -> [u8; N],
    ) {
        element(&mut self.0, kind, (name, components), &deflated(values, le));
    }

    /// Here the cell fields end.
    fn points(&mut self) {
        self.0.extend_from_slice(b"</CellData>\n<Points>\n");
    }

    /// Here the points end.
    fn cells(&mut self, connectivity: &[usize], offsets: &[usize], types: &[u8]) {
        self.0.extend_from_slice(b"</Points>\n<Cells>\n");
        for (name, indices) in [("connectivity", connectivity), ("offsets", offsets)] {
            if indices.iter().all(|&i| i32::try_from(i).is_ok()) {
                self.add("Int32", (name, 1), indices, |i| (i as i32).to_le_bytes());
            } else {
                self.add("Int64", (name, 1), indices, |i| (i as i64).to_le_bytes());
            }
        }
        self.add("UInt8", ("types", 1), types, |kind| [kind]);
        self.0
            .extend_from_slice(b"</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    }

    fn grid(self, points: usize, cells: usize, double: bool) -> Grid {
        let before = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n<PointData>\n"
        );
        Grid {
            points,
            cells,
            double,
            before,
            after: self.0,
        }
    }
}

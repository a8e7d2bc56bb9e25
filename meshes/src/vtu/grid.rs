//! Unstructured grids: meshes, surfaces and polygons with fields on them.

use vtkio::Vtk;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, IOBuffer, UnstructuredGridPiece, Version,
    VertexNumbers,
};
use vtkio::xml::Compressor;

use super::Field;
use crate::{Mesh, MeshError, Surface};

/// A fast level of zlib; the best one takes ten times as long and reduces the size of a surface by 1 %. With zlib-rs,
/// level 1 makes a surface half as large again, because zlib-rs codes it with fixed tables. The features of another
/// crate may select zlib-rs for flate2.
const LEVEL: u32 = 2;

/// A grid to be written with fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid(UnstructuredGridPiece);

impl Grid {
    /// The grid of a volume mesh in double precision; cell field `part` contains the part of each element.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let xyz: Vec<f64> = mesh.nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let cells = mesh.elements().map(|element| (element.nodes, element.kind.vtk_type()));
        let part = mesh.parts.iter().map(|&part| part as f64).collect();
        Self::new(xyz.into(), cells, Some(("part", part)))
    }

    /// The grid of a surface in single precision; cell field `patch` contains the patch of each face.
    pub fn of_surface(surface: &Surface) -> Self {
        let xyz = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]);
        let faces = || surface.faces.iter();
        let cells = faces().map(|face| (&*face.nodes, face.kind.vtk_type()));
        let patch = faces().map(|face| face.patch as f64).collect();
        Self::new(single(xyz), cells, Some(("patch", patch)))
    }

    /// The grid of polygons in single precision; each polygon lists its corner indices in order.
    pub fn of_polygons(corners: &[[f64; 3]], polygons: &[Vec<usize>]) -> Self {
        let cells = polygons.iter().map(|polygon| {
            let vtk_type = match polygon.len() {
                3 => CellType::Triangle,
                4 => CellType::Quad,
                _ => CellType::Polygon,
            };
            (&**polygon, vtk_type)
        });
        Self::new(single(corners.iter().flatten().copied()), cells, None)
    }

    fn new<'a>(
        points: IOBuffer,
        cells: impl Iterator<Item = (&'a [usize], CellType)>,
        own: Option<(&str, Vec<f64>)>,
    ) -> Self {
        let (mut connectivity, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
        for (nodes, vtk_type) in cells {
            connectivity.extend(nodes.iter().map(|&node| node as u64));
            offsets.push(connectivity.len() as u64);
            types.push(vtk_type);
        }
        let cell_verts = VertexNumbers::XML { connectivity, offsets };
        let mut grid = Self(UnstructuredGridPiece {
            points,
            cells: Cells { cell_verts, types },
            data: Attributes::new(),
        });
        let own = own.map(|(name, values)| grid.attribute(name, 1, &values));
        grid.0.data.cell.extend(own);
        grid
    }

    /// The file of the grid with point and cell fields, compressed by zlib.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`].
    pub fn to_bytes(&self, points: &[Field<'_>], cells: &[Field<'_>]) -> Result<Vec<u8>, MeshError> {
        let mut piece = self.0.clone();
        piece.data.point = self.attributes(points, self.points())?;
        piece
            .data
            .cell
            .splice(0..0, self.attributes(cells, piece.cells.num_cells())?);
        let file = Vtk {
            version: Version::new_xml(1, 0),
            title: String::new(),
            byte_order: ByteOrder::LittleEndian,
            data: DataSet::inline(piece),
            file_path: None,
        };
        let mut bytes = Vec::new();
        file.try_into_xml_format(Compressor::ZLib, LEVEL)?.write(&mut bytes)?;
        Ok(bytes)
    }

    /// Number of points.
    pub(super) fn points(&self) -> usize {
        self.0.num_points()
    }

    fn attributes(&self, fields: &[Field<'_>], items: usize) -> Result<Vec<Attribute>, MeshError> {
        let attribute = |field: &Field<'_>| {
            super::check(field.name, field.values.len(), items * field.components)?;
            Ok(self.attribute(field.name, field.components, field.values))
        };
        fields.iter().map(attribute).collect()
    }

    /// Converts a field to the precision of the points.
    fn attribute(&self, name: &str, components: usize, values: &[f64]) -> Attribute {
        let data = match self.0.points {
            IOBuffer::F64(_) => values.to_vec().into(),
            _ => single(values.iter().copied()),
        };
        Attribute::DataArray(DataArray::new(name, components as u32).with_buf(data))
    }
}

fn single(values: impl Iterator<Item = f64>) -> IOBuffer {
    values.map(|x| x as f32).collect::<Vec<f32>>().into()
}

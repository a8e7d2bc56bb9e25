//! VTKHDF files: a film of a surface in one file (VTK file formats, VTKHDF, version 2.2).
//!
//! The crate hdf5-pure writes HDF5. The file contains the surface once; the frames refer to it by offsets.
//!
//! ```text
//! /VTKHDF                  Version, Type = "UnstructuredGrid"
//!   Points, Connectivity, Offsets, Types, NumberOfPoints, NumberOfCells, NumberOfConnectivityIds
//!   CellData/patch         patch of each face
//!   PointData/FIELD        frames x points rows of components
//!   Steps                  NSteps, NumberOfParts; Values: the time of each frame
//!     PointDataOffsets/FIELD    frame x points; all other offsets are 0
//! ```

use hdf5_pure::{AttrValue, FileBuilder, GroupBuilder, make_f32_type};
use serde::{Deserialize, Serialize};

use crate::vtu::Array;
use crate::{MeshError, Surface};

/// Version of the layout.
const VERSION: [i64; 2] = [2, 2];

/// Bytes of a single-precision number.
const SINGLE: usize = size_of::<f32>();

/// The surface of a film: its points and faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilmSurface {
    /// Three coordinates of each point \[m\].
    points: Vec<f32>,
    /// Points of all faces, one face after another.
    connectivity: Vec<u32>,
    /// Number of points of the faces before each face; the last is that of all faces.
    offsets: Vec<u32>,
    /// VTK's cell type of each face.
    #[serde(with = "serde_bytes")]
    types: Vec<u8>,
    /// Patch of each face.
    patches: Vec<u32>,
}

/// One frame of a film.
#[derive(Clone, Copy, Debug)]
pub struct FilmFrame<'a> {
    /// Its time \[s\].
    pub time: f64,
    /// Its fields. All frames have fields of the same names, in the same order.
    pub fields: &'a [Array],
}

impl FilmSurface {
    /// The surface of a film.
    pub fn of(surface: &Surface) -> Self {
        let (mut connectivity, mut offsets) = (Vec::new(), vec![0]);
        for face in &surface.faces {
            connectivity.extend(face.nodes.iter().map(|&node| node as u32));
            offsets.push(connectivity.len() as u32);
        }
        let coordinates = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]);
        Self {
            points: coordinates.map(|x| x as f32).collect(),
            connectivity,
            offsets,
            types: surface.faces.iter().map(|face| face.kind.vtk_type() as u8).collect(),
            patches: surface.faces.iter().map(|face| face.patch as u32).collect(),
        }
    }

    /// The file of a film. A slash separates groups in HDF5, so that `m/s` in the name of a field becomes `m per s`.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`]; [`MeshError::Hdf5`] if hdf5-pure cannot compose the file.
    pub fn film(&self, frames: &[FilmFrame<'_>]) -> Result<Vec<u8>, MeshError> {
        let points = self.points.len() / 3;
        let mut file = FileBuilder::new();
        let mut root = file.create_group("VTKHDF");
        root.set_attr("Version", AttrValue::I64Array(VERSION.to_vec()));
        root.set_attr("Type", AttrValue::AsciiString("UnstructuredGrid".to_owned()));
        self.write(&mut root);
        let mut steps = root.create_group("Steps");
        let zeros = vec![0_i64; frames.len()];
        let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
        steps.set_attr("NSteps", AttrValue::I64(frames.len() as i64));
        steps.create_dataset("Values").with_f64_data(&times);
        steps
            .create_dataset("NumberOfParts")
            .with_i64_data(&vec![1; frames.len()]);
        for name in ["PartOffsets", "PointOffsets"] {
            steps.create_dataset(name).with_i64_data(&zeros);
        }
        for name in ["CellOffsets", "ConnectivityIdOffsets"] {
            let offsets = steps.create_dataset(name);
            offsets.with_i64_data(&zeros).with_shape(&[frames.len() as u64, 1]);
        }
        let mut of_cells = steps.create_group("CellDataOffsets");
        of_cells.create_dataset("patch").with_i64_data(&zeros);
        steps.add_group(of_cells.finish());
        let mut of_points = steps.create_group("PointDataOffsets");
        let mut fields = root.create_group("PointData");
        let offsets: Vec<i64> = (0..frames.len()).map(|frame| (frame * points) as i64).collect();
        for place in 0..frames.first().map_or(0, |frame| frame.fields.len()) {
            let name = write_field(&mut fields, points, place, frames)?;
            of_points.create_dataset(&name).with_i64_data(&offsets);
        }
        steps.add_group(of_points.finish());
        root.add_group(fields.finish());
        root.add_group(steps.finish());
        file.add_group(root.finish());
        Ok(file.finish()?)
    }

    /// Adds points and faces.
    fn write(&self, root: &mut GroupBuilder) {
        let wide = |values: &[u32]| values.iter().map(|&value| i64::from(value)).collect::<Vec<_>>();
        let points = self.points.len() / 3;
        for (name, number) in [
            ("NumberOfPoints", points),
            ("NumberOfCells", self.types.len()),
            ("NumberOfConnectivityIds", self.connectivity.len()),
        ] {
            root.create_dataset(name).with_i64_data(&[number as i64]);
        }
        let coordinates = root.create_dataset("Points").with_f32_data(&self.points);
        coordinates.with_shape(&[points as u64, 3]);
        let connectivity = wide(&self.connectivity);
        root.create_dataset("Connectivity").with_i64_data(&connectivity);
        root.create_dataset("Offsets").with_i64_data(&wide(&self.offsets));
        root.create_dataset("Types").with_u8_data(&self.types);
        let mut cells = root.create_group("CellData");
        cells.create_dataset("patch").with_i64_data(&wide(&self.patches));
        root.add_group(cells.finish());
    }
}

/// Adds the field at a place of the frames' fields; returns its name in the file.
fn write_field(
    fields: &mut GroupBuilder,
    points: usize,
    place: usize,
    frames: &[FilmFrame<'_>],
) -> Result<String, MeshError> {
    let mut bytes = Vec::new();
    let (mut name, mut components) = (String::new(), 1);
    for field in frames.iter().filter_map(|frame| frame.fields.get(place)) {
        field.check(points)?;
        bytes.extend_from_slice(field.bytes());
        (name, components) = (field.name().replace('/', " per "), field.components());
    }
    let (rows, values) = (frames.len() * points, bytes.len() / SINGLE);
    crate::vtu::check(&name, values, rows * components)?;
    let dataset = fields.create_dataset(&name);
    dataset.with_raw_data(make_f32_type(), bytes, values as u64);
    let shape = [rows as u64, components as u64];
    // VTK reads scalars as a list.
    dataset.with_shape(if components == 1 { &shape[..1] } else { &shape });
    Ok(name)
}

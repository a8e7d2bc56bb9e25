//! Files are read back by vtkio and equal the written data: meshes to the last bit, surfaces to single precision.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_meshes::vtu::{Array, Field, Frames, Grid, series};
use nailnoise_meshes::{Block, Mesh, MeshError, Surface, block};
use vtkio::Vtk;
use vtkio::model::{Attribute, CellType, UnstructuredGridPiece, VertexNumbers};

fn read(bytes: &[u8]) -> UnstructuredGridPiece {
    let file = Vtk::parse_xml(bytes).unwrap();
    UnstructuredGridPiece::try_from(file.data).unwrap()
}

fn single(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&x| x as f32).collect()
}

fn rounded(values: &[f64]) -> Vec<f64> {
    values.iter().map(|&x| f64::from(x as f32)).collect()
}

fn brick(divisions: [usize; 3]) -> Mesh {
    block(&Block {
        size: [0.4, 0.3, 0.1],
        divisions,
        origin: [0.0; 3],
    })
    .unwrap()
}

fn field<'a>(name: &'a str, components: usize, values: &'a [f64]) -> Field<'a> {
    Field {
        name,
        components,
        values,
    }
}

fn values(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let found = attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.clone().cast_into::<f64>(),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no field {name}"))
}

/// Nodes of each cell.
fn cells(piece: &UnstructuredGridPiece) -> Vec<Vec<usize>> {
    let VertexNumbers::XML { connectivity, offsets } = &piece.cells.cell_verts else {
        panic!("not XML")
    };
    let mut starts = vec![0];
    starts.extend(offsets);
    let nodes = |ends: &[u64]| connectivity[ends[0] as usize..ends[1] as usize].iter();
    starts
        .windows(2)
        .map(|ends| nodes(ends).map(|&node| node as usize).collect())
        .collect()
}

#[test]
fn a_mesh_is_read_back_to_the_last_bit() {
    let mesh = brick([3, 2, 1]);
    let piece = read(&Grid::of_mesh(&mesh).to_bytes(&[], &[]).unwrap());
    let nodes: Vec<f64> = mesh.nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(piece.points.clone().into_vec::<f64>().unwrap(), nodes);
    assert!(piece.cells.types.iter().all(|&t| t == CellType::QuadraticHexahedron));
    let connectivity: Vec<Vec<usize>> = mesh.elements().map(|element| element.nodes.to_vec()).collect();
    assert_eq!(cells(&piece), connectivity);
    assert_eq!(values(&piece.data.cell, "part"), vec![0.0; 6]);
}

#[test]
fn fields_on_a_mesh_are_read_back_to_the_last_bit() {
    let mesh = brick([3, 2, 1]);
    let u: Vec<f64> = (0..3 * mesh.nodes.len()).map(|i| (i as f64).sin()).collect();
    let v: Vec<f64> = u.iter().map(|x| x * 1e-12).collect();
    let p: Vec<f64> = (0..mesh.nodes.len()).map(|i| i as f64).collect();
    let e: Vec<f64> = (0..mesh.element_count()).map(|i| (i as f64).sqrt()).collect();
    let points = [
        field("displacement [m]", 3, &u),
        field("velocity [m/s]", 3, &v),
        field("pressure [Pa]", 1, &p),
    ];
    let energy = field("energy [J]", 1, &e);
    let piece = read(&Grid::of_mesh(&mesh).to_bytes(&points, &[energy]).unwrap());
    for field in points {
        assert_eq!(values(&piece.data.point, field.name), field.values);
    }
    assert_eq!(values(&piece.data.cell, "energy [J]"), e);
}

#[test]
fn a_surface_is_read_back_in_single_precision() {
    let surface = Surface::of(&brick([3, 2, 1]));
    let heat: Vec<f64> = surface.points.iter().map(|point| 1.0 + point.x / 3.0).collect();
    let name = "heat & <more> [K]";
    let bytes = Grid::of_surface(&surface).to_bytes(&[field(name, 1, &heat)], &[]);
    let piece = read(&bytes.unwrap());
    let xyz: Vec<f64> = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(piece.points.clone().into_vec::<f32>().unwrap(), single(&xyz));
    assert_eq!(values(&piece.data.point, name), rounded(&heat));
    assert!(piece.cells.types.iter().all(|&t| t == CellType::QuadraticQuad));
    assert_eq!(values(&piece.data.cell, "patch").len(), surface.faces.len());
}

#[test]
fn polygons_of_many_blocks_are_read_back() {
    // A block has 8192 numbers in single precision, three of them a point: none, less than one, some, some and a bit.
    for corners in [0, 2731, 8192, 8193] {
        let xyz = |i: usize| [i as f64, (i as f64).sin(), 1.0 / (i as f64 + 1.0)];
        let points: Vec<[f64; 3]> = (0..corners).map(xyz).collect();
        let polygon = |i: usize| (i.saturating_sub(3 + i % 3)..=i).collect();
        let polygons: Vec<Vec<usize>> = (2..corners).map(polygon).collect();
        let noise: Vec<f64> = points.iter().map(|[_, y, z]| (1e4 * y).sin() * z).collect();
        let sides: Vec<f64> = polygons.iter().map(|polygon| polygon.len() as f64).collect();
        let grid = Grid::of_polygons(&points, &polygons);
        let bytes = grid.to_bytes(&[field("noise", 1, &noise)], &[field("sides", 1, &sides)]);
        let piece = read(&bytes.unwrap());
        assert_eq!(cells(&piece), polygons);
        assert_eq!(piece.points.into_vec::<f32>().unwrap(), single(points.as_flattened()));
        assert_eq!(values(&piece.data.point, "noise"), rounded(&noise));
        assert_eq!(values(&piece.data.cell, "sides"), sides);
    }
}

#[test]
fn a_frame_is_read_back_as_the_file_of_its_grid() {
    // The points of the last grid are a whole number of blocks.
    let surface = Surface::of(&brick([3, 2, 2]));
    let flat: Vec<[f64; 3]> = (0..8192).map(|i| [i as f64, 0.0, 1.0]).collect();
    for grid in [Grid::of_surface(&surface), Grid::of_polygons(&flat, &[vec![0, 1, 2]])] {
        let frames = Frames::of(&grid).unwrap();
        let points = read(&grid.to_bytes(&[], &[]).unwrap()).num_points();
        let level: Vec<f64> = (0..points).map(|i| (i as f64).sqrt()).collect();
        let velocity: Vec<f64> = (0..3 * points).map(|i| (i as f64).sin()).collect();
        let named = [("level [dB]", 1, &level), ("velocity & more [m/s]", 3, &velocity)];
        let arrays = named.map(|(name, components, values)| Array::new(name, components, &single(values)));
        let fields = named.map(|(name, components, values)| field(name, components, values));
        for own in [0..0, 0..1, 1..2, 0..2] {
            let expected = read(&grid.to_bytes(&fields[own.clone()], &[]).unwrap());
            let mut bytes = Vec::new();
            frames.render(&arrays[own], &mut bytes).unwrap();
            assert_eq!(read(&bytes), expected);
        }
    }
}

#[test]
fn the_arrays_of_a_frame_may_have_any_length() {
    for points in [1, 4095, 8191, 8192, 8193, 3 * 8192, 3 * 8192 + 1] {
        let corners: Vec<[f64; 3]> = (0..points).map(|i| [i as f64, 0.0, 1.0]).collect();
        let frames = Frames::of(&Grid::of_polygons(&corners, &[vec![0]])).unwrap();
        let noise: Vec<f64> = (0..points).map(|i| (1e4 * i as f64).sin()).collect();
        let mut bytes = Vec::new();
        frames
            .render(&[Array::new("noise", 1, &single(&noise))], &mut bytes)
            .unwrap();
        assert_eq!(values(&read(&bytes).data.point, "noise"), rounded(&noise));
    }
}

#[test]
fn a_velocity_costs_its_bytes_and_a_surface_less() {
    let surface = Surface::of(&brick([40, 30, 10]));
    let frames = Frames::of(&Grid::of_surface(&surface)).unwrap();
    let size = |arrays: &[Array]| {
        let mut bytes = Vec::new();
        frames.render(arrays, &mut bytes).unwrap();
        bytes.len()
    };
    let velocity: Vec<f32> = (0..3 * surface.points.len()).map(|i| (i as f32).sin()).collect();
    let (bare, shown) = (size(&[]), size(&[Array::new("velocity [m/s]", 3, &velocity)]));
    let ratio = (shown - bare) as f64 / (4 * velocity.len()) as f64;
    // In base64 three bytes are four.
    assert!((1.0..1.01).contains(&(0.75 * ratio)), "{ratio}");
    let corners: usize = surface.faces.iter().map(|face| face.nodes.len()).sum();
    assert!(3 * bare < 2 * (12 * surface.points.len() + 4 * corners), "{bare}");
}

#[test]
fn a_series_lists_its_files() {
    let text = series(&[(1483.0, "mode & 7.vtu".to_owned()), (2261.5, "mode8.vtu".to_owned())]);
    assert!(text.contains(r#"timestep="1483""#) && text.contains("mode &amp; 7.vtu") && text.contains("mode8.vtu"));
}

#[test]
fn a_field_of_the_wrong_length_is_refused() {
    let mesh = brick([1; 3]);
    let refused = Grid::of_mesh(&mesh).to_bytes(&[field("u", 3, &[0.0; 3])], &[]);
    assert!(matches!(
        refused,
        Err(MeshError::FieldLength {
            found: 3,
            expected: 60,
            ..
        })
    ));
    let frames = Frames::of(&Grid::of_mesh(&mesh)).unwrap();
    let refused = frames.render(&[Array::new("short", 3, &[0.0; 59])], &mut Vec::new());
    assert!(matches!(
        refused,
        Err(MeshError::FieldLength {
            found: 59,
            expected: 60,
            ..
        })
    ));
}

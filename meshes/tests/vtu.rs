//! Files are read back by another library and hold what was written: meshes to the last bit, surfaces to single precision.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_meshes::vtu::{Array, Field, Grid, series};
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

fn brick(divisions: [usize; 3]) -> Mesh {
    block(&Block {
        size: [0.4, 0.3, 0.1],
        divisions,
        origin: [0.0; 3],
    })
    .unwrap()
}

fn values(attributes: &[Attribute], name: &str) -> Vec<f64> {
    attributes
        .iter()
        .find_map(|a| match a {
            Attribute::DataArray(d) if d.name == name => d.data.clone().cast_into::<f64>(),
            _ => None,
        })
        .unwrap()
}

#[test]
fn a_mesh_and_its_surface_survive_the_round_trip() {
    let mesh = brick([3, 2, 1]);
    let u: Vec<f64> = (0..3 * mesh.nodes.len()).map(|i| (i as f64).sin()).collect();
    let v: Vec<f64> = u.iter().map(|x| x * 1e-12).collect();
    let p: Vec<f64> = (0..mesh.nodes.len()).map(|i| i as f64).collect();
    let e: Vec<f64> = (0..mesh.element_count()).map(|i| (i as f64).sqrt()).collect();
    let points = [
        Field {
            name: "displacement [m]",
            components: 3,
            values: &u,
        },
        Field {
            name: "velocity [m/s]",
            components: 3,
            values: &v,
        },
        Field {
            name: "pressure [Pa]",
            components: 1,
            values: &p,
        },
    ];
    let energy = Field {
        name: "energy [J]",
        components: 1,
        values: &e,
    };
    let piece = read(&Grid::of_mesh(&mesh).to_bytes(&points, &[energy]).unwrap());
    let nodes: Vec<f64> = mesh.nodes.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(piece.points.clone().into_vec::<f64>().unwrap(), nodes);
    assert!(piece.cells.types.iter().all(|&t| t == CellType::QuadraticHexahedron));
    let VertexNumbers::XML { connectivity, offsets } = &piece.cells.cell_verts else {
        panic!("not XML")
    };
    assert!(
        connectivity
            .iter()
            .zip(&mesh.connectivity)
            .all(|(&a, &b)| a as usize == b)
    );
    assert_eq!(offsets.last().copied().unwrap() as usize, mesh.connectivity.len());
    assert_eq!(values(&piece.data.point, "displacement [m]"), u);
    assert_eq!(values(&piece.data.point, "velocity [m/s]"), v);
    assert_eq!(values(&piece.data.point, "pressure [Pa]"), p);
    assert_eq!(values(&piece.data.cell, "energy [J]"), e);
    assert_eq!(values(&piece.data.cell, "part"), vec![0.0; 6]);

    let surface = Surface::of(&mesh);
    let heat: Vec<f64> = surface.points.iter().map(|point| 1.0 + point.x / 3.0).collect();
    let field = Field {
        name: "heat & <more> [K]",
        components: 1,
        values: &heat,
    };
    let piece = read(&Grid::of_surface(&surface).to_bytes(&[field], &[]).unwrap());
    let found = piece.points.clone().cast_into::<f64>().unwrap();
    let wanted = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]);
    assert!(
        found
            .iter()
            .zip(wanted)
            .all(|(found, wanted)| *found == f64::from(wanted as f32))
    );
    let rounded: Vec<f64> = heat.iter().map(|&x| f64::from(x as f32)).collect();
    assert_eq!(values(&piece.data.point, "heat & <more> [K]"), rounded);
    assert!(piece.cells.types.iter().all(|&t| t == CellType::QuadraticQuad));
    assert_eq!(values(&piece.data.cell, "patch").len(), surface.faces.len());
}

#[test]
fn a_file_of_a_series_is_that_of_its_surface_to_the_byte() {
    let surface = Surface::of(&brick([3, 2, 2]));
    let grid = Grid::of_surface(&surface);
    let level: Vec<f64> = surface.points.iter().map(|point| (7.0 * point.x).exp()).collect();
    let velocity: Vec<f64> = surface.points.iter().flat_map(|p| [p.y / 3.0, -p.x, p.z]).collect();
    let named = [("level [dB]", 1, &level), ("velocity & more [m/s]", 3, &velocity)];
    let arrays = named.map(|(name, components, values)| Array::new(name, components, &single(values)));
    let fields = named.map(|(name, components, values)| Field {
        name,
        components,
        values,
    });
    for own in [0..0, 0..1, 1..2, 0..2] {
        let expected = grid.to_bytes(&fields[own.clone()], &[]).unwrap();
        let mut bytes = Vec::new();
        grid.render(&arrays[own], &[], &mut bytes).unwrap();
        assert_eq!(bytes, expected);
    }
    let short = Array::new("short", 3, &single(&velocity[1..]));
    let refused = grid.render(&[short], &[], &mut Vec::new());
    assert!(matches!(refused, Err(MeshError::FieldLength { found, expected, .. }) if found + 1 == expected));
}

#[test]
fn arrays_of_many_blocks_come_back_to_the_last_bit() {
    // A block holds 4096 numbers in double precision, 8192 in single: less than one, one, one and a bit, some and a bit.
    for nodes in [4095, 4096, 4097, 3 * 8192, 3 * 8192 + 1] {
        let corners: Vec<[f64; 3]> = (0..nodes)
            .map(|i| [i as f64, (i as f64).sin(), 1.0 / (i as f64 + 1.0)])
            .collect();
        let polygons: Vec<Vec<usize>> = (2_usize..nodes)
            .map(|i| (i.saturating_sub(3 + i % 3)..=i).collect())
            .collect();
        let noise: Vec<f64> = corners.iter().map(|[_, y, z]| (1e4 * y).sin() * z).collect();
        let of_polygons: Vec<f64> = polygons.iter().map(|polygon| polygon.len() as f64).collect();
        let [point, cell] = [("noise", &noise), ("corners", &of_polygons)].map(|(name, values)| Field {
            name,
            components: 1,
            values,
        });
        let grid = Grid::of_polygons(&corners, &polygons);
        let piece = read(&grid.to_bytes(&[point], &[cell]).unwrap());
        let found = piece.points.into_vec::<f32>().unwrap();
        assert_eq!(found, single(corners.as_flattened()));
        let VertexNumbers::XML { connectivity, offsets } = &piece.cells.cell_verts else {
            panic!("not XML")
        };
        let mut starts = vec![0];
        starts.extend_from_slice(offsets);
        for (polygon, ends) in polygons.iter().zip(starts.windows(2)) {
            let own = &connectivity[ends[0] as usize..ends[1] as usize];
            assert!(own.iter().zip(polygon).all(|(&a, &b)| a as usize == b) && own.len() == polygon.len());
        }
        assert_eq!(
            values(&piece.data.point, "noise"),
            single(&noise).iter().map(|&x| f64::from(x)).collect::<Vec<_>>()
        );
        assert_eq!(values(&piece.data.cell, "corners"), of_polygons);
    }
}

#[test]
fn a_velocity_costs_its_bytes_and_a_surface_less() {
    let surface = Surface::of(&brick([40, 30, 10]));
    let grid = Grid::of_surface(&surface);
    let size = |arrays: &[Array]| {
        let mut bytes = Vec::new();
        grid.render(arrays, &[], &mut bytes).unwrap();
        bytes.len()
    };
    let velocity: Vec<f32> = (0..3 * surface.points.len()).map(|i| (i as f32).sin()).collect();
    let (bare, shown) = (size(&[]), size(&[Array::new("velocity [m/s]", 3, &velocity)]));
    let around = (shown - bare) as f64 / (4 * velocity.len()) as f64;
    // In base64 three bytes are four.
    assert!((1.0..1.01).contains(&(0.75 * around)), "{around}");
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
    let grid = Grid::of_mesh(&brick([1; 3]));
    let short = Field {
        name: "u",
        components: 3,
        values: &[0.0; 3],
    };
    assert!(matches!(
        grid.to_bytes(&[short], &[]),
        Err(MeshError::FieldLength { .. })
    ));
}

//! Files are read back by another library and hold what was written: meshes to the last bit, surfaces to single precision.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_meshes::vtu::{Array, Field, Grid, write_series};
use nailnoise_meshes::{Block, Mesh, MeshError, Surface, block, write_atomic};
use vtkio::Vtk;
use vtkio::model::{Attribute, CellType, UnstructuredGridPiece, VertexNumbers};

fn folder(name: &str) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("nailnoise-meshes-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn read(path: &std::path::Path) -> UnstructuredGridPiece {
    let file = Vtk::import(path).unwrap();
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
    let folder = folder("round-trip");
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
    let path = folder.join("block.vtu");
    let energy = Field {
        name: "energy [J]",
        components: 1,
        values: &e,
    };
    Grid::of_mesh(&mesh).write(&path, &points, &[energy]).unwrap();
    let piece = read(&path);
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
    let path = folder.join("skin.vtu");
    let heat: Vec<f64> = surface.points.iter().map(|point| 1.0 + point.x / 3.0).collect();
    let field = Field {
        name: "heat & <more> [K]",
        components: 1,
        values: &heat,
    };
    Grid::of_surface(&surface).write(&path, &[field], &[]).unwrap();
    let piece = read(&path);
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

    // Nothing but the finished files is left behind.
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["block.vtu", "skin.vtu"]);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_file_of_a_series_is_that_of_its_surface_to_the_byte() {
    let folder = folder("series-of-a-surface");
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
        let path = folder.join("skin.vtu");
        grid.write(&path, &fields[own.clone()], &[]).unwrap();
        let mut bytes = Vec::new();
        grid.render(&arrays[own], &[], &mut bytes).unwrap();
        assert_eq!(bytes, std::fs::read(path).unwrap());
    }
    let short = Array::new("short", 3, &single(&velocity[1..]));
    let refused = grid.render(&[short], &[], &mut Vec::new());
    assert!(matches!(refused, Err(MeshError::FieldLength { found, expected, .. }) if found + 1 == expected));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn arrays_of_many_blocks_come_back_to_the_last_bit() {
    let folder = folder("blocks");
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
        let path = folder.join("polygons.vtu");
        Grid::of_polygons(&corners, &polygons)
            .write(&path, &[point], &[cell])
            .unwrap();
        let piece = read(&path);
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
    std::fs::remove_dir_all(folder).unwrap();
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
    let folder = folder("series");
    let path = folder.join("modes.pvd");
    write_series(
        &path,
        &[(1483.0, "mode & 7.vtu".to_owned()), (2261.5, "mode8.vtu".to_owned())],
    )
    .unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(r#"timestep="1483""#) && text.contains("mode &amp; 7.vtu") && text.contains("mode8.vtu"));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn wrong_fields_and_folders_are_refused() {
    let grid = Grid::of_mesh(&brick([1; 3]));
    let short = [Field {
        name: "u",
        components: 3,
        values: &[0.0; 3],
    }];
    let path = std::path::Path::new("nowhere/at/all/block.vtu");
    assert!(matches!(
        grid.write(path, &short, &[]),
        Err(MeshError::FieldLength { .. })
    ));
    assert!(matches!(grid.write(path, &[], &[]), Err(MeshError::Write { .. })));
    assert!(write_atomic(std::path::Path::new("/"), b"").is_err());
}

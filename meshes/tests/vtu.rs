//! Files are read back by another library and hold what was written: meshes to the last bit, surfaces to single precision.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_meshes::vtu::{Field, Single, Still, block as bytes_of, write_mesh, write_series, write_surface};
use nailnoise_meshes::{Block, MeshError, Surface, block, write_atomic};
use vtkio::Vtk;
use vtkio::model::{Attribute, CellType, UnstructuredGridPiece, VertexNumbers};

fn folder(name: &str) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("nailnoise-meshes-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn read(path: &std::path::Path) -> UnstructuredGridPiece {
    UnstructuredGridPiece::try_from(Vtk::import(path).unwrap().data).unwrap()
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
    let mesh = block(&Block {
        size: [0.4, 0.3, 0.1],
        divisions: [3, 2, 1],
        origin: [0.0; 3],
    })
    .unwrap();
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
    write_mesh(
        &path,
        &mesh,
        &points,
        &[Field {
            name: "energy [J]",
            components: 1,
            values: &e,
        }],
    )
    .unwrap();
    let piece = read(&path);
    assert_eq!(
        piece.points.clone().into_vec::<f64>().unwrap().len(),
        3 * mesh.nodes.len()
    );
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
    write_surface(&path, &surface, &[field], &[]).unwrap();
    let piece = read(&path);
    let found = piece.points.clone().cast_into::<f64>().unwrap();
    let wanted = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]);
    assert!(
        found
            .iter()
            .zip(wanted)
            .all(|(found, wanted)| *found == f64::from(wanted as f32))
    );
    let single: Vec<f64> = heat.iter().map(|&x| f64::from(x as f32)).collect();
    assert_eq!(values(&piece.data.point, "heat & <more> [K]"), single);
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
    let folder = folder("still");
    let mesh = block(&Block {
        size: [0.3, 0.2, 0.1],
        divisions: [3, 2, 2],
        origin: [0.0; 3],
    })
    .unwrap();
    let surface = Surface::of(&mesh);
    let still = Still::of(&surface);
    let level: Vec<f64> = surface.points.iter().map(|point| (7.0 * point.x).exp()).collect();
    let velocity: Vec<f64> = surface.points.iter().flat_map(|p| [p.y / 3.0, -p.x, p.z]).collect();
    let named = [("level [dB]", 1, &level), ("velocity & more [m/s]", 3, &velocity)];
    let blocks = named.map(|(.., values)| bytes_of(values.iter().map(|&x| x as f32)));
    let fields = [0, 1].map(|own| Field {
        name: named[own].0,
        components: named[own].1,
        values: named[own].2,
    });
    let singles = [0, 1].map(|own| Single {
        name: named[own].0,
        components: named[own].1,
        block: &blocks[own],
    });
    for own in [0..0, 0..1, 1..2, 0..2] {
        let path = folder.join("skin.vtu");
        write_surface(&path, &surface, &fields[own.clone()], &[]).unwrap();
        let mut text = Vec::new();
        still.file(&singles[own], &mut text).unwrap();
        assert_eq!(text, std::fs::read(path).unwrap());
    }
    let short = Single {
        block: &blocks[1][..blocks[1].len() - 4],
        ..singles[1]
    };
    let refused = still.file(&[short], &mut Vec::new());
    assert!(matches!(refused, Err(MeshError::FieldLength { found, expected, .. }) if found + 1 == expected));
    std::fs::remove_dir_all(folder).unwrap();
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
    let mesh = block(&Block {
        size: [1.0; 3],
        divisions: [1; 3],
        origin: [0.0; 3],
    })
    .unwrap();
    let short = [Field {
        name: "u",
        components: 3,
        values: &[0.0; 3],
    }];
    let path = std::path::Path::new("nowhere/at/all/block.vtu");
    assert!(matches!(
        write_mesh(path, &mesh, &short, &[]),
        Err(MeshError::FieldLength { .. })
    ));
    assert!(matches!(
        write_mesh(path, &mesh, &[], &[]),
        Err(MeshError::Write { .. })
    ));
    assert!(write_atomic(std::path::Path::new("/"), b"").is_err());
}

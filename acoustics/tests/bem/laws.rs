//! Laws of the radiation matrix, and surfaces that are refused or repaired.

use crate::boundary_meshes::{cuboid, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{BemError, Boundary, BoundaryMesh, Exterior, Repairs};
use nalgebra::{DMatrix, SymmetricEigen};

fn block(edge: f64) -> BoundaryMesh {
    cuboid([0.0, 0.0, 0.1], [0.4, 0.15, 0.2], edge, true)
}

/// Six rigid motions and two bending ones, as displacements of the points.
fn motions(mesh: &BoundaryMesh) -> DMatrix<f64> {
    DMatrix::from_fn(3 * mesh.points.len(), 8, |row, mode| {
        let (x, c) = (mesh.points[row / 3], row % 3);
        let turn = |axis: usize| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            if c == u {
                -x[v]
            } else if c == v {
                x[u]
            } else {
                0.0
            }
        };
        match mode {
            0..=2 => f64::from(u8::from(mode == c)),
            3..=5 => turn(mode - 3),
            _ if c == 2 => (f64::from(mode as u8 - 4) * std::f64::consts::PI * x.x / 0.4).cos(),
            _ => 0.0,
        }
    })
}

#[test]
fn reciprocal_symmetric_and_positive() {
    for floor in [None, Some(0.0), Some(0.1)] {
        let boundary = Boundary::new(block(0.03), floor).unwrap();
        let v = boundary.project_displacements(&motions(boundary.mesh())).unwrap();
        let problem = Exterior::new(boundary, &Air::default());
        for hz in [200.0, 800.0, 1800.0] {
            let two = problem.resistance(hz, &v).unwrap();
            let r = &two.far_field;
            assert_eq!(*r, r.transpose());
            let least = SymmetricEigen::new(r.clone()).eigenvalues.min();
            println!(
                "{floor:?} {hz}: asymmetry {:.1e}, {:.3} dB, least {:.1e}",
                two.asymmetry,
                two.difference_db,
                least / r.amax()
            );
            assert!(least > -1e-12 * r.amax(), "{least:e}");
            assert!(two.asymmetry < 2e-3 && two.difference_db < 0.1);
            let surface = two.patches.iter().fold(DMatrix::zeros(8, 8), |sum, p| sum + p);
            let scaled = |i: usize, j: usize| (surface[(i, j)] - r[(i, j)]) / (r[(i, i)] * r[(j, j)]).sqrt();
            // The loudest motion to 0.1 dB.
            let loudest = r.diagonal().imax();
            assert!(scaled(loudest, loudest).abs() < 0.02);
            let split = two.split();
            assert_eq!(split.len(), 7);
            let sum: DMatrix<f64> = split.into_iter().fold(DMatrix::zeros(8, 8), |s, p| s + p.real);
            assert!((sum - r).amax() < 1e-12 * r.amax());
        }
    }
}

#[test]
fn flipped_normals_are_corrected_and_counted() {
    let mut mesh = sphere(1.0, 2, true);
    let straight = Boundary::new(mesh.clone(), None).unwrap();
    assert_eq!(
        straight.repairs(),
        Repairs {
            flipped: 0,
            on_floor: 0,
            panels: 80
        }
    );
    // Turning by hand: corners and mid-sides in the other direction.
    for panel in mesh.panels.iter_mut().step_by(3) {
        let n = panel.nodes().to_vec();
        let turned = [n[0], n[2], n[1], n[5], n[4], n[3]];
        *panel = nailnoise_acoustics::bem::Panel::new(panel.kind(), &turned, panel.patch).unwrap();
    }
    let repaired = Boundary::new(mesh, None).unwrap();
    assert_eq!(repaired.repairs().flipped, 27);
    let out = (0..80).all(|p| {
        let point = repaired.mesh().point_at(p, [0.3, 0.3]);
        point.area_vector().dot(&point.position.coords) > 0.0
    });
    assert!(out);
}

#[test]
fn open_or_degenerate_surfaces_are_refused_with_numbers() {
    let mut open = block(0.05);
    open.panels.pop();
    let error = Boundary::new(open, None).unwrap_err();
    assert!(matches!(error, BemError::OpenSurface { edges: 4, .. }), "{error}");
    let error = Boundary::new(block(0.05), Some(0.15)).unwrap_err();
    assert!(
        matches!(error, BemError::FloorThroughBody { lowest: 0.1, .. }),
        "{error}"
    );
    let mut double = block(0.05);
    double.panels.push(double.panels[0]);
    assert!(matches!(
        Boundary::new(double, None),
        Err(BemError::TangledSurface { panels: 3, .. })
    ));
    let standing = Boundary::new(block(0.05), Some(0.1)).unwrap();
    assert_eq!(standing.repairs().on_floor, 8 * 3);
    let problem = Exterior::new(standing, &Air::default());
    let v = DMatrix::zeros(problem.boundary().velocity_values(), 1);
    let error = problem.solve(3000.0, &v).unwrap_err();
    println!("{error}");
    assert!(matches!(error, BemError::TooCoarse { needed: 6.0, .. }), "{error}");
}

#[test]
fn the_surface_of_a_volume_mesh_carries_its_modes() {
    let mesh = nailnoise_meshes::block(&nailnoise_meshes::Block {
        size: [0.4, 0.15, 0.1],
        divisions: [8, 3, 2],
        origin: [0.0, 0.0, 0.1],
    })
    .unwrap();
    let skin = nailnoise_meshes::Surface::of(&mesh);
    let boundary = Boundary::new(BoundaryMesh::of_skin(&skin), Some(0.0)).unwrap();
    let heave = DMatrix::from_fn(3 * skin.points.len(), 1, |row, _| f64::from(u8::from(row % 3 == 2)));
    let v = boundary.project_displacements(&heave).unwrap();
    let problem = Exterior::new(boundary, &Air::default());
    let reference = Boundary::new(block(0.05), Some(0.0)).unwrap();
    let w = reference.project_displacements(&motions(reference.mesh())).unwrap();
    let flat = Exterior::new(reference, &Air::default());
    let found = problem.resistance(500.0, &v).unwrap().far_field[(0, 0)];
    let exact = flat.resistance(500.0, &w).unwrap().far_field[(2, 2)];
    // Quadrilaterals are halved along the diagonal from their first node, which differs.
    assert!((found / exact - 1.0).abs() < 2e-4, "{found} {exact}");
    assert!(problem.boundary().project_displacements(&DMatrix::zeros(3, 1)).is_err());
}

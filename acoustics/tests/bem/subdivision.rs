//! Finer panels of a surface: their agreement with it, and their radiation.

use crate::boundary_meshes::{cuboid, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel, Subdivision};
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// V = 1/3 closed integral of x . n dS.
fn volume(mesh: &BoundaryMesh) -> f64 {
    let of_panel = |p: usize| {
        let points = mesh.panels[p].kind().rule(4).unwrap().into_iter();
        let moment = |(xi, w): ([f64; 2], f64)| {
            let point = mesh.point_at(p, xi);
            w * point.position.coords.dot(&point.area_vector()) / 3.0
        };
        points.map(moment).sum::<f64>()
    };
    (0..mesh.panels.len()).map(of_panel).sum()
}

/// Smallest angle of all flat triangles of the corners.
fn smallest_angle(mesh: &BoundaryMesh) -> f64 {
    let of_panel = |panel: &Panel| {
        let x = |k: usize| mesh.points[panel.corners()[k % 3]];
        let angles = (0..3).map(|k| (x(k + 1) - x(k)).angle(&(x(k + 2) - x(k))));
        angles.fold(f64::INFINITY, f64::min)
    };
    mesh.panels.iter().map(of_panel).fold(f64::INFINITY, f64::min)
}

/// The mesh with edges of at most a share of its longest.
fn finer(mesh: &BoundaryMesh, share: f64) -> Subdivision {
    mesh.subdivided(share * mesh.longest_edge()).unwrap()
}

#[test]
fn subdivided_panels_cover_the_same_surface() {
    for mesh in [sphere(1.0, 3, true), cuboid([0.0; 3], [0.4, 0.3, 0.2], 0.1, false)] {
        for share in [0.9, 0.6, 0.3] {
            let fine = finer(&mesh, share);
            assert!(fine.mesh.panels.len() > mesh.panels.len());
            assert!(fine.mesh.longest_edge() <= share * mesh.longest_edge() * (1.0 + 1e-9));
            assert!((volume(&fine.mesh) / volume(&mesh) - 1.0).abs() < 1e-12);
            let mut areas = vec![0.0; mesh.panels.len()];
            for (panel, &parent) in fine.parents.iter().enumerate() {
                areas[parent] += fine.mesh.panel_area(panel);
                assert_eq!(fine.mesh.panels[panel].patch, mesh.panels[parent].patch);
            }
            for (panel, area) in areas.into_iter().enumerate() {
                // The rule for areas is not exact on curved panels.
                assert!((area / mesh.panel_area(panel) - 1.0).abs() < 1e-6, "{area}");
            }
        }
    }
}

#[test]
fn subdivided_panels_end_at_each_other() {
    for quads in [false, true] {
        let mesh = cuboid([0.0; 3], [0.4, 0.3, 0.2], 0.1, quads);
        // A closed surface is required.
        let fine = Boundary::new(finer(&mesh, 0.45).mesh, None).unwrap();
        let edges: usize = fine.mesh().panels.iter().map(|p| p.corners().len()).sum();
        assert_eq!(fine.nodes() + fine.mesh().panels.len(), edges / 2 + 2);
        assert_eq!(fine.repairs().flipped, 0);
    }
}

/// Rivara's bound.
#[test]
fn angles_of_subdivided_panels_are_at_least_half_the_smallest() {
    let mesh = sphere(1.0, 3, false);
    for share in [0.9, 0.6, 0.4, 0.2, 0.1] {
        let ratio = smallest_angle(&finer(&mesh, share).mesh) / smallest_angle(&mesh);
        println!("{share}: {ratio}");
        assert!(ratio >= 0.5, "{share}: {ratio}");
    }
}

#[test]
fn panels_that_are_small_enough_stay() {
    for quads in [false, true] {
        let mesh = cuboid([0.0; 3], [0.4, 0.3, 0.2], 0.1, quads);
        let same = finer(&mesh, 1.0);
        assert!(same.mesh.panels == mesh.panels && same.mesh.points == mesh.points);
    }
}

/// Motion is interpolated with the shape functions of the given panels: a square of the coordinates is exact on flat
/// ones with nodes on their sides.
#[test]
fn motion_is_interpolated_on_the_given_panels() {
    let mut mesh = sphere(1.0, 2, true);
    // Flat panels: nodes half way between the corners.
    for panel in &mesh.panels {
        let (c, nodes) = (panel.corners(), panel.nodes());
        for k in 0..3 {
            mesh.points[nodes[3 + k]] = nalgebra::center(&mesh.points[c[k]], &mesh.points[c[(k + 1) % 3]]);
        }
    }
    let field = |points: &[nalgebra::Point3<f64>]| {
        DMatrix::from_fn(3 * points.len(), 2, |row, mode| {
            let x = points[row / 3];
            [x[row % 3], x.x * x[row % 3] - x.y * x.z][mode]
        })
    };
    let fine = finer(&mesh, 0.3);
    let found = fine.fields(&field(&mesh.points)).unwrap();
    assert!((found - field(&fine.mesh.points)).amax() < 1e-12);
    assert!(fine.fields(&DMatrix::zeros(3, 1)).is_err());
}

/// Powers of a pulsating and of an oscillating sphere of radius 1 m over rho c times its area, at ka.
fn powers(mesh: BoundaryMesh, ka: f64) -> [f64; 2] {
    let (boundary, air) = (Boundary::new(mesh, None).unwrap(), Air::default());
    let velocities = boundary.project(2, |_, _, point, v| {
        (v[0], v[1]) = (1.0, point.area_vector().normalize().z);
    });
    let problem = Exterior::new(boundary, &air).with_panels_per_wavelength(1.0).unwrap();
    let hz = ka * air.sound_speed / (2.0 * PI);
    let found = problem.resistance(hz, &velocities).unwrap().far_field;
    [0, 1].map(|m| found[(m, m)] / (4.0 * PI * air.impedance()))
}

/// x²/(1 + x²), and of the mean square 1/3 of the normal velocity x⁴/(4 + x⁴) (Pierce, *Acoustics*, 1989, section 4-2).
#[test]
fn a_subdivided_sphere_radiates_by_the_closed_form() {
    let given = sphere(1.0, 4, true);
    let fine = finer(&given, 0.51);
    println!("{} of {} panels", fine.mesh.panels.len(), given.panels.len());
    for ka in [1.0f64, 4.0, 7.0] {
        let exact = [ka.powi(2) / (1.0 + ka.powi(2)), ka.powi(4) / (4.0 + ka.powi(4)) / 3.0];
        let in_db = |found: [f64; 2]| [0, 1].map(|m| 10.0 * (found[m] / exact[m]).log10());
        let (coarse, fine) = (in_db(powers(given.clone(), ka)), in_db(powers(fine.mesh.clone(), ka)));
        println!("ka {ka}: {coarse:.4?} -> {fine:.4?} dB");
        for m in [0, 1] {
            assert!(fine[m].abs() < 0.002, "ka {ka}: {fine:?}");
        }
    }
}

/// A box whose top moves in a wave, from large panels and from panels that were small from the beginning.
#[test]
fn a_subdivided_box_radiates_as_one_of_small_panels() {
    let air = Air::default();
    let power = |mesh: BoundaryMesh, hz: f64| {
        let boundary = Boundary::new(mesh, Some(-0.05)).unwrap();
        let velocities = boundary.project(1, |_, _, point, v| {
            let (x, n) = (point.position, point.area_vector().normalize());
            v[0] = n.z.max(0.0) * (2.0 * PI * x.x / 0.2).cos();
        });
        let problem = Exterior::new(boundary, &air).with_panels_per_wavelength(4.0).unwrap();
        problem.resistance(hz, &velocities).unwrap().far_field[(0, 0)]
    };
    let of = |edge: f64, quads: bool| cuboid([0.0; 3], [0.4, 0.3, 0.2], edge, quads);
    for quads in [false, true] {
        let fine = of(0.1, quads).subdivided(0.036).unwrap().mesh;
        for hz in [300.0, 1500.0] {
            let apart = 10.0 * (power(fine.clone(), hz) / power(of(0.025, false), hz)).log10();
            println!("quads {quads}, {hz} Hz: {apart:.4} dB, {} panels", fine.panels.len());
            assert!(apart.abs() < 0.05, "{hz} Hz: {apart} dB");
        }
    }
}

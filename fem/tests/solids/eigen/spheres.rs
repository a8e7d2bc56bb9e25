//! Curved elements against exact solutions of elastic spheres.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::{FRAC_PI_4, TAU};

use crate::kinds::{merged, structured};
use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{ElementKind, Mesh};
use nalgebra::{Point3, Vector3};

/// The direction of a point of one side of a cube, a and b in \[-1, 1\].
fn direction(a: f64, b: f64) -> Vector3<f64> {
    Vector3::new((a * FRAC_PI_4).tan(), (b * FRAC_PI_4).tan(), 1.0)
}

/// Rotations that carry the side +z to the sides +z, +x, +y.
fn cycle(p: Vector3<f64>, times: usize) -> Vector3<f64> {
    (0..times).fold(p, |p, _| Vector3::new(p.z, p.x, p.y))
}

/// A solid ball of radius 1: a cube of half edge 0.4 in the middle and six blocks around it.
fn ball(kind: ElementKind, across: usize, outwards: usize) -> Mesh {
    const HALF: f64 = 0.4;
    let warp = |x: f64| HALF * ((2.0 * x - 1.0) * FRAC_PI_4).tan();
    let mut blocks = vec![structured(kind, [across; 3], |x| Point3::from(x.map(warp)))];
    for times in 0..3 {
        for turn in [1.0, -1.0] {
            blocks.push(structured(kind, [across, across, outwards], |[a, b, r]| {
                let d = direction(2.0 * a - 1.0, 2.0 * b - 1.0);
                let p = d * HALF * (1.0 - r) + d.normalize() * r;
                // Half a turn about x takes +z to -z without a mirror image.
                Point3::from(cycle(Vector3::new(p.x, turn * p.y, turn * p.z), times))
            }));
        }
    }
    merged(&blocks)
}

/// Roots for omega R / c_s of torsional and omega R / c_l of radial vibration (nu = 0.3) of a free sphere.
#[test]
fn an_elastic_sphere_has_its_torsional_and_radial_modes() {
    let (e, nu, rho): (f64, f64, f64) = (2e11, 0.3, 8000.0);
    let shear = (e / (2.0 * (1.0 + nu)) / rho).sqrt();
    let long = (e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / rho).sqrt();
    let torsional = 2.501_132_620_409_397 * shear / TAU;
    let radial = 2.670_214_733_237_052_5 * long / TAU;
    for (kind, across, outwards) in [
        (ElementKind::Hex20, 3, 2),
        (ElementKind::Hex27, 2, 2),
        (ElementKind::Tet10, 3, 2),
    ] {
        let mesh = ball(kind, across, outwards);
        let system = assemble(&mesh, &[Material::isotropic(e, nu, rho).unwrap()], &Constraints::free()).unwrap();
        let basis = modes(&system, &ModalSettings::below(1.05 * radial), &|_, _| ()).unwrap();
        assert_eq!(basis.sturm.count, basis.hz.len());
        assert_eq!(basis.rigid.iter().filter(|r| **r).count(), 6);
        // Torsion with l = 2 is the lowest mode of a sphere and has 2 l + 1 = 5 of its kind.
        let error = basis.hz[6..11]
            .iter()
            .map(|f| (f / torsional - 1.0).abs())
            .fold(0.0, f64::max);
        println!("{kind:?}: {} dofs, torsion {error:.1e}", basis.dofs);
        assert!(error < 0.01, "{kind:?}: {:?} against {torsional}", &basis.hz[..12]);
        // The breathing mode is the one whose displacement is all along the radius.
        let breathing = (6..basis.hz.len())
            .max_by(|&a, &b| outward(&basis.shapes, &mesh, a).total_cmp(&outward(&basis.shapes, &mesh, b)));
        let found = basis.hz[breathing.unwrap()];
        println!("{kind:?}: radial {:.1e}", found / radial - 1.0);
        assert!(
            (found / radial - 1.0).abs() < 0.01,
            "{kind:?}: {found} against {radial}"
        );
    }
}

/// |mean of u . r| over the root mean square of u.
fn outward(shapes: &nalgebra::DMatrix<f64>, mesh: &Mesh, mode: usize) -> f64 {
    let (mut along, mut square) = (0.0, 0.0);
    for (node, p) in mesh.nodes.iter().enumerate() {
        let u = Vector3::new(
            shapes[(3 * node, mode)],
            shapes[(3 * node + 1, mode)],
            shapes[(3 * node + 2, mode)],
        );
        along += u.dot(&p.coords);
        square += u.norm_squared();
    }
    along.abs() / square.sqrt()
}

/// NAFEMS FV42: thick hollow sphere, 1.8 m to 6 m, uniform radial vibration; here an eighth with its planes of symmetry
/// fixed, against the roots of the exact radial equation.
#[test]
fn a_thick_hollow_sphere_meets_nafems_fv42() {
    let exact = [369.943_416_9, 838.033_458_0, 1_451.191_527_7];
    let blocks: Vec<Mesh> = (0..3)
        .map(|times| {
            structured(ElementKind::Hex20, [2, 2, 8], |[a, b, r]| {
                Point3::from(cycle(direction(a, b).normalize() * (1.8 + 4.2 * r), times))
            })
        })
        .collect();
    let mesh = merged(&blocks);
    let mut constraints = Constraints::free();
    for (node, p) in mesh.nodes.iter().enumerate() {
        (0..3)
            .filter(|&k| p[k].abs() < 1e-9)
            .for_each(|axis| constraints.hold(node, axis));
    }
    let material = Material::isotropic(2e11, 0.3, 8000.0).unwrap();
    let system = assemble(&mesh, &[material], &constraints).unwrap();
    let basis = modes(&system, &ModalSettings::below(1500.0), &|_, _| ()).unwrap();
    assert_eq!(basis.sturm.count, basis.hz.len());
    let radial: Vec<f64> = (0..basis.hz.len())
        .filter(|&mode| {
            // Radial modes move every point along its radius.
            let (mut along, mut square) = (0.0, 0.0);
            for (node, p) in mesh.nodes.iter().enumerate() {
                let u = Vector3::from_fn(|k, _| basis.shapes[(3 * node + k, mode)]);
                along += u.dot(&p.coords.normalize()).powi(2);
                square += u.norm_squared();
            }
            along > 0.99 * square
        })
        .map(|mode| basis.hz[mode])
        .collect();
    println!("{radial:?}");
    assert_eq!(radial.len(), exact.len(), "{radial:?} of {:?}", basis.hz);
    for (found, exact) in radial.iter().zip(exact) {
        assert!((found / exact - 1.0).abs() < 0.003, "{radial:?}");
    }
}

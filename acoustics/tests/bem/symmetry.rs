//! A body with two planes of symmetry, whole and in quarters.

use crate::boundary_meshes::cuboid;
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Parity, Patterns};
use nalgebra::{DMatrix, Point3, Vector3};

const HIGH: [f64; 3] = [0.2, 0.15, 0.3];

/// Smooth normal velocities without any symmetry.
fn velocity(at: Point3<f64>, normal: Vector3<f64>, values: &mut [f64]) {
    let [x, y, z] = [at.x / HIGH[0], at.y / HIGH[1], at.z / HIGH[2]];
    let field = [
        Vector3::new(0.3, -0.2, 1.0),
        Vector3::new(x + 0.4, 0.7 * y * z, 0.5 - x * y),
        Vector3::new(y * z, 1.0 - x, 0.3 * x + 0.2 * y),
    ];
    values.iter_mut().zip(field).for_each(|(v, f)| *v = f.dot(&normal));
}

/// The velocities of one parity on the quarter: the mean over the quarters with their signs.
fn part(quarter: &Boundary, parity: Parity) -> Patterns {
    let velocities = quarter.project(3, |_, _, point, values| {
        values.fill(0.0);
        let normal = point.area_vector().normalize();
        for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            let mut v = [0.0; 3];
            let p = point.position;
            velocity(
                Point3::new(sx * p.x, sy * p.y, p.z),
                Vector3::new(sx * normal.x, sy * normal.y, normal.z),
                &mut v,
            );
            let sign = if parity.odd_x { sx } else { 1.0 } * if parity.odd_y { sy } else { 1.0 };
            values.iter_mut().zip(v).for_each(|(to, v)| *to += 0.25 * sign * v);
        }
    });
    Patterns { parity, velocities }
}

fn cut(mesh: BoundaryMesh, mirrors: [bool; 2], floor: Option<f64>) -> Exterior {
    let planes = mirrors.map(|m| m.then_some(0.0));
    Exterior::new(Boundary::symmetric(mesh, planes, floor).unwrap(), &Air::default())
}

#[test]
fn quarters_with_symmetry_radiate_the_power_of_the_whole() {
    // Above the floor, standing on it, and in free space; below and above the first inner resonance.
    for (low, floor) in [(0.05, Some(0.0)), (0.0, Some(0.0)), (0.05, None)] {
        let whole = cuboid([-HIGH[0], -HIGH[1], low], HIGH, 0.05, true);
        let quarter = cuboid([0.0, 0.0, low], HIGH, 0.05, true);
        let whole = cut(whole, [false; 2], floor);
        let quarter = cut(quarter, [true; 2], floor);
        assert_eq!(
            4 * quarter.boundary().mesh().panels.len(),
            whole.boundary().mesh().panels.len()
        );
        assert!((quarter.lowest_resonance() / whole.lowest_resonance() - 1.0).abs() < 1e-12);
        let v = whole.boundary().project(3, |_, _, point, values| {
            velocity(point.position, point.area_vector().normalize(), values);
        });
        let parts: Vec<Patterns> = Parity::all([true; 2])
            .into_iter()
            .map(|parity| part(quarter.boundary(), parity))
            .collect();
        for hz in [150.0, 900.0] {
            let exact = whole.resistance(hz, &v).unwrap();
            let found = quarter.resistance_parities(hz, &parts).unwrap();
            let sum = |f: fn(&nailnoise_acoustics::radiation::boundary_elements::TwoEvaluations) -> DMatrix<f64>| {
                found.iter().map(f).fold(DMatrix::zeros(3, 3), |sum, r| sum + r)
            };
            let far = sum(|two| two.far_field.clone());
            let surface = sum(|two| two.patches.iter().fold(DMatrix::zeros(3, 3), |sum, r| sum + r));
            let whole_surface = exact.patches.iter().fold(DMatrix::zeros(3, 3), |sum, r| sum + r);
            let scale = exact.far_field.amax();
            let (far, surface) = (
                (&far - &exact.far_field).amax() / scale,
                (&surface - &whole_surface).amax() / scale,
            );
            println!("from {low}, floor {floor:?}, {hz} Hz: {far:.1e}, {surface:.1e}");
            // Touching quadrilaterals are halved along another diagonal in the images.
            assert!(far < 5e-4 && surface < 5e-4);
        }
    }
}

#[test]
fn stored_integrals_of_close_pairs_equal_computed_ones() {
    let v = |boundary: &Boundary| {
        boundary.project(3, |_, _, point, values| {
            velocity(point.position, point.area_vector().normalize(), values);
        })
    };
    // A slab of two thin layers: across it panels are closer than they are wide.
    let slab = |triangles: bool| cuboid([-0.2, -0.15, 0.0], [0.2, 0.15, 0.02], 0.05, !triangles);
    for triangles in [false, true] {
        let direct = cut(slab(triangles), [false; 2], Some(0.0));
        let top = direct.estimate().highest_hz;
        let kept = cut(slab(triangles), [false; 2], Some(0.0)).with_near_field_cache(top);
        for hz in [50.0, 0.4 * top, top] {
            let [a, b] = [&direct, &kept].map(|p| p.solve(hz, &v(p.boundary())).unwrap().pressure);
            let largest = a.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let off = (&a - b).iter().map(|z| z.norm()).fold(0.0, f64::max) / largest;
            println!("triangles {triangles}, {hz:.0} Hz: {off:.1e}");
            assert!(off < 3e-5, "{hz} Hz: {off:e}");
        }
    }
}

#[test]
fn a_part_below_its_mirror_is_refused() {
    let mesh = cuboid([-0.1, 0.0, 0.0], [0.2, 0.1, 0.1], 0.05, true);
    let error = Boundary::symmetric(mesh, [Some(0.0), None], None)
        .unwrap_err()
        .to_string();
    assert!(error.contains("x = 0 m lies above the lowest x = -0.1 m"), "{error}");
}

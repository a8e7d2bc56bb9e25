//! Porous covers: spheres against closed forms, limits, and laws of partly covered bodies.

use crate::boundary_meshes::{octants, sphere};
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Patterns, SurfaceCover};
use nailnoise_acoustics::radiation::boundary_elements::{MeshRange, ModalBem};
use nailnoise_acoustics::radiation::{ModalRadiation, Sampling};
use nailnoise_acoustics::{Air, Frame, PorousLayer};
use nalgebra::{Complex, DMatrix, Point3};
use std::f64::consts::{PI, TAU};

/// Radius of the spheres \[m\].
const RADIUS: f64 = 0.1;
const FRAMES: [Frame; 2] = [Frame::Moving, Frame::Resting];

fn foam(frame: Frame) -> PorousLayer {
    PorousLayer::new(0.02, 1e4, frame).unwrap()
}

fn hz(ka: f64) -> f64 {
    ka * Air::default().sound_speed / (TAU * RADIUS)
}

/// Specific impedances of the pulsating and the oscillating sphere for e^{+j omega t}.
fn impedances(x: f64) -> [Complex<f64>; 2] {
    let j = Complex::<f64>::i();
    [
        j * x / (1.0 + j * x),
        j * x * (1.0 + j * x) / (2.0 - x * x + 2.0 * j * x),
    ]
}

/// Velocity of the outer face relative to that of the wall: v = T v_s - Y rho c z v.
fn exact_velocities(ka: f64, layer: &PorousLayer) -> [Complex<f64>; 2] {
    let air = Air::default();
    let of = layer.transfer(hz(ka), &air);
    impedances(ka).map(|z| of.velocity / (1.0 + of.admittance * air.impedance() * z))
}

/// Resistances of both motions of the covered sphere, in units of rho c times the sphere's square \[m2\].
fn exact(ka: f64, layer: &PorousLayer) -> [f64; 2] {
    let (z, v) = (impedances(ka), exact_velocities(ka, layer));
    let areas = [4.0 * PI * RADIUS.powi(2), 4.0 * PI * RADIUS.powi(2) / 3.0];
    [0, 1].map(|n| Air::default().impedance() * areas[n] * z[n].re * v[n].norm_sqr())
}

/// A surface with a pulsating and a vertically oscillating motion, covered where `share` says so.
fn problem(
    mesh: BoundaryMesh,
    floor: Option<f64>,
    layer: PorousLayer,
    share: impl Fn(Point3<f64>) -> f64 + Sync,
) -> (Exterior, DMatrix<f64>) {
    let boundary = Boundary::new(mesh, floor).unwrap();
    let v = boundary.project(2, |_, _, point, v| {
        v[0] = 1.0;
        v[1] = point.area_vector().normalize().z;
    });
    let panels = &boundary.mesh().panels;
    let centre = |panel: &nailnoise_acoustics::bem::Panel| {
        let corners = panel.corners();
        let sum = corners.iter().map(|&n| boundary.mesh().points[n].coords);
        Point3::from(sum.sum::<nalgebra::Vector3<f64>>() / corners.len() as f64)
    };
    let shares = panels
        .iter()
        .flat_map(|p| vec![share(centre(p)); p.corners().len()])
        .collect();
    let problem = Exterior::new(boundary, &Air::default());
    let problem = problem.with_cover(SurfaceCover { layer, shares }).unwrap();
    (problem.with_panels_per_wavelength(1.0).unwrap(), v)
}

fn whole(_: Point3<f64>) -> f64 {
    1.0
}

fn upper(at: Point3<f64>) -> f64 {
    f64::from(u8::from(at.z > 0.0))
}

fn decibels(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

#[test]
fn covered_sphere_has_its_closed_form_from_ka_0_1_to_10() {
    for frame in FRAMES {
        let layer = foam(frame);
        let (problem, v) = problem(sphere(RADIUS, 8, true), None, layer, whole);
        // pi and 4.4934 are resonances of the inside.
        for ka in [0.1, 0.3, 1.0, 2.0, PI, 4.493_409_457_909_064, 6.0, 10.0] {
            let two = problem.resistance(hz(ka), &v).unwrap();
            let exact = exact(ka, &layer);
            let bare = impedances(ka).map(|z| z.re);
            for n in 0..2 {
                let [far, surface] = [&two.far_field, &two.patches[0]].map(|r| decibels(r[(n, n)] / exact[n]));
                let area = Air::default().impedance() * 4.0 * PI * RADIUS.powi(2) / [1.0, 3.0][n];
                let loss = decibels(area * bare[n] / exact[n]);
                println!("{frame:?}, ka {ka:6.3}, order {n}: loss {loss:6.2} dB; off {far:8.5} {surface:8.5} dB");
                assert!(
                    far.abs() < 0.05 && surface.abs() < 0.05,
                    "{frame:?}, ka {ka}, order {n}"
                );
            }
        }
    }
}

#[test]
fn sound_of_a_covered_sphere_is_that_of_its_outer_face() {
    let layer = foam(Frame::Moving);
    let (problem, v) = problem(sphere(RADIUS, 6, true), None, layer, whole);
    let (ka, distance) = (2.0, 0.5);
    let solution = problem.solve(hz(ka), &v).unwrap();
    let place = Point3::new(0.0, distance * 0.6, distance * 0.8);
    let [direct, by_floor] = problem.pressure_at(&[place], &v, &solution).unwrap();
    let on_face = impedances(ka)[0] * Air::default().impedance() * exact_velocities(ka, &layer)[0];
    let exact = on_face * (RADIUS / distance) * Complex::from_polar(1.0, -ka * (distance / RADIUS - 1.0));
    assert!(
        (direct[(0, 0)] / exact - 1.0).norm() < 2e-3,
        "{} {exact}",
        direct[(0, 0)]
    );
    assert_eq!(by_floor[(0, 0)], Complex::default());
}

#[test]
fn a_layer_without_thickness_is_a_bare_wall() {
    let layer = PorousLayer::new(0.0, 1e4, Frame::Moving).unwrap();
    let (covered, v) = problem(sphere(RADIUS, 4, true), None, layer, upper);
    let boundary = Boundary::new(sphere(RADIUS, 4, true), None).unwrap();
    let bare = Exterior::new(boundary, &Air::default());
    let bare = bare.with_panels_per_wavelength(1.0).unwrap();
    for ka in [0.3, 3.0] {
        let [covered, bare] = [&covered, &bare].map(|p| p.resistance(hz(ka), &v).unwrap());
        let off = (&covered.far_field - &bare.far_field).amax() / bare.far_field.amax();
        assert!(off < 1e-5, "ka {ka}: {off:e}");
        let (skew, _) = covered.imaginary.unwrap();
        assert!(skew.amax() < 1e-5 * bare.far_field.amax());
    }
}

#[test]
fn a_layer_without_flow_resistance_leaves_a_plane_wave_as_it_is() {
    let air = Air::default();
    for frame in FRAMES {
        for (thickness, hz) in [(1e-3, 5e3), (0.02, 1e3), (0.02, 4e3), (0.05, 8e3)] {
            let power = PorousLayer::new(thickness, 1e-6, frame)
                .unwrap()
                .plane_wave_power(hz, &air);
            assert!(
                decibels(power).abs() < 0.01,
                "{frame:?}, {thickness} m, {hz} Hz: {power}"
            );
        }
    }
}

#[test]
fn a_thin_layer_moves_with_its_wall() {
    let air = Air::default();
    for frame in FRAMES {
        let of = |hz| foam(frame).transfer(hz, &air);
        // T - 1 and Y fall at least in proportion to frequency.
        let [low, high] = [of(10.0), of(100.0)];
        assert!((low.velocity - 1.0).norm() < 0.02, "{frame:?}: {low:?}");
        assert!((low.velocity - 1.0).norm() < 0.3 * (high.velocity - 1.0).norm());
        assert!(low.admittance.norm() < 0.2 * high.admittance.norm());
    }
}

#[test]
fn a_layer_absorbs_and_gives_no_power() {
    let air = Air::default();
    for (thickness, resistivity) in [(5e-3, 3e3), (0.02, 1e4), (0.1, 5e4)] {
        let layer = PorousLayer::new(thickness, resistivity, Frame::Moving).unwrap();
        for hz in [50.0, 500.0, 3e3] {
            assert!(
                layer.transfer(hz, &air).admittance.re > 0.0,
                "{thickness} {resistivity} {hz}"
            );
        }
    }
}

#[test]
fn other_air_at_the_same_wavelength_has_the_same_layer() {
    let air = Air {
        density: 1.0,
        sound_speed: 360.0,
        ..Air::default()
    };
    for frame in FRAMES {
        let own = foam(frame).transfer(1000.0, &air);
        let standard = Air::default();
        let hz = 1000.0 * standard.sound_speed / air.sound_speed;
        let converted = foam(frame).in_standard_air(&air).transfer(hz, &standard);
        assert!((own.velocity - converted.velocity).norm() < 1e-12);
        let [own, converted] = [
            own.admittance * air.impedance(),
            converted.admittance * standard.impedance(),
        ];
        assert!((own - converted).norm() < 1e-12);
    }
}

#[test]
fn both_evaluations_of_a_partly_covered_sphere_agree_for_complex_motions() {
    let (problem, v) = problem(sphere(RADIUS, 8, true), None, foam(Frame::Resting), upper);
    for ka in [0.5, 2.0, 5.0] {
        let two = problem.resistance(hz(ka), &v).unwrap();
        let parts = two.split();
        assert_eq!(parts.len(), 2);
        for phase in [0.0, 0.5 * PI, 0.8 * PI, 1.5 * PI] {
            let motion = [Complex::from(1.0), Complex::from_polar(1.7, phase)];
            let [surface, rest] = [0, 1].map(|i: usize| parts[i].form(&motion));
            let off = decibels((surface + rest) / surface);
            println!("ka {ka}, phase {phase:.2}: {off:.4} dB");
            assert!(off.abs() < 0.05, "ka {ka}, phase {phase}: {off}");
        }
        let (skew, _) = two.imaginary.as_ref().unwrap();
        assert!(skew[(0, 1)].abs() > 1e-3 * two.far_field.amax(), "{skew}");
        assert_eq!(skew[(0, 1)], -skew[(1, 0)]);
        assert!(two.asymmetry < 2e-3, "{}", two.asymmetry);
    }
}

#[test]
fn covered_hemisphere_on_the_floor_is_half_a_sphere() {
    let layer = foam(Frame::Moving);
    let mut half = octants(&[[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]], 6, false);
    half.points.iter_mut().for_each(|p| p.coords *= RADIUS);
    let (problem, v) = problem(half, Some(0.0), layer, whole);
    for ka in [0.2, 1.0, PI] {
        let two = problem.resistance(hz(ka), &v).unwrap();
        let off = decibels(2.0 * two.far_field[(0, 0)] / exact(ka, &layer)[0]);
        assert!(off.abs() < 0.05, "ka {ka}: {off}");
    }
}

#[test]
fn the_sampled_matrix_of_a_covered_sphere_is_that_of_single_frequencies_and_of_plane_waves_above() {
    let layer = foam(Frame::Moving);
    let (problem, velocities) = problem(sphere(RADIUS, 6, true), None, layer, whole);
    let level = MeshRange {
        problem: problem.with_panels_per_wavelength(4.0).unwrap(),
        top_hz: hz(3.0),
        patterns: vec![Patterns {
            parity: Default::default(),
            velocities,
        }],
    };
    let sampling = Sampling {
        range_hz: [40.0, hz(3.0)],
        tolerance: 0.005,
        floor: 1e-2,
        most_samples: 200,
    };
    let radiation = ModalBem::new(vec![level], &sampling, &|| ()).unwrap();
    for ka in [0.2, 0.7, 1.5, 2.7] {
        let found = radiation.resistance(hz(ka)).real;
        for n in 0..2 {
            let off = decibels(found[(n, n)] / exact(ka, &layer)[n]);
            println!("ka {ka}, order {n}: {off:.4} dB");
            assert!(off.abs() < 0.1, "ka {ka}, order {n}: {off}");
        }
    }
    // Far above, every point radiates as in a plane wave.
    let high = 9e3;
    let air = Air::default();
    let expected = layer.plane_wave_power(high, &air) * air.impedance() * 4.0 * PI * RADIUS.powi(2);
    let off = decibels(radiation.resistance(high).real[(0, 0)] / expected);
    assert!(off.abs() < 0.3, "{off}");
}

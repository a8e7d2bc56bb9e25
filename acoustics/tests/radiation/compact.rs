//! A compact body: the oscillating sphere is exact.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::{CompactErp, Erp, ModalRadiation, RadiatingSurface};
use nalgebra::{Complex, DMatrix, Point3, Vector3};

/// A sphere that oscillates along z.
fn sphere(radius: f64) -> RadiatingSurface {
    let (n, m) = (400, 8);
    let (mut points, mut normals, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        // Rings of equal area (Archimedes).
        let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
        for k in 0..m {
            let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(m)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let normal = Vector3::new(r * cos, r * sin, z);
            points.push(Point3::from(radius * normal));
            normals.push(normal);
            weights.push(4.0 * PI * radius * radius / f64::from(n * m));
        }
    }
    let modes = DMatrix::from_fn(points.len(), 1, |i, _| normals[i].z);
    let patch = vec![0; points.len()];
    RadiatingSurface::new(points, normals, weights, patch, vec!["all".to_owned()], modes).unwrap()
}

#[test]
fn a_rigid_sphere_has_its_exact_resistance_and_all_forms_of_it_agree() {
    let (air, radius) = (Air::default(), 0.07);
    let volume = 4.0 / 3.0 * PI * radius * radius * radius;
    let erp = Erp::new(&sphere(radius), &air);
    let compact = CompactErp::new(erp.clone(), volume, &air).unwrap();
    for hz in [50.0, 400.0, 1500.0, 10_000.0] {
        let ka = 2.0 * PI * hz * radius / air.sound_speed;
        let exact = air.impedance() * 4.0 * PI * radius * radius / 3.0 * ka.powi(4) / (4.0 + ka.powi(4));
        let found = compact.resistance(hz).real[(0, 0)];
        assert!((found / exact - 1.0).abs() < 1e-4, "{hz} Hz: {found} {exact}");
        let a = DMatrix::from_element(1, 1, Complex::new(0.3, -0.4));
        let form = compact.energy_forms(&[hz], &a)[(0, 0)];
        let signal = compact.root_signals(&[hz], &a)[(0, 0)].norm_sqr();
        let expected = 0.25 * found / (2.0 * PI * hz).powi(2);
        assert!((form / expected - 1.0).abs() < 1e-6 && (signal / expected - 1.0).abs() < 1e-12);
        assert!(found < erp.resistance(hz).real[(0, 0)]);
    }
    assert!(compact.efficiency(1e5) > 0.999);
    assert!(CompactErp::new(erp, 0.0, &air).is_err());
}

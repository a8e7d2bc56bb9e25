//! From a mesh's skin to a radiating surface.

use crate::radiating_surfaces::{flat, rectangle};
use nailnoise_acoustics::radiation::flush_with_sand::Rayleigh;
use nailnoise_acoustics::radiation::{Erp, ModalRadiation, RadiatingSurface, RadiationError};
use nailnoise_acoustics::{AcousticsError, Air, InputError};
use nailnoise_meshes::{Block, Mesh, QuadraturePoint, Surface, block};
use nalgebra::DMatrix;

fn mesh() -> Mesh {
    block(&Block {
        size: [0.4, 0.15, 0.1],
        divisions: [6, 3, 2],
        origin: [-0.2, -0.075, -0.1],
    })
    .unwrap()
}

/// Heave along z and rocking about y, as displacements of every point of the skin.
fn rigid_modes(skin: &Surface) -> DMatrix<f32> {
    DMatrix::from_fn(3 * skin.points.len(), 2, |row, mode| {
        let (x, axis) = (skin.points[row / 3], row % 3);
        let value = match (mode, axis) {
            (0, 2) => 1.0,
            (1, 0) => x.z,
            (1, 2) => -x.x,
            _ => 0.0,
        };
        value as f32
    })
}

/// The surface of some patches of a skin in rigid motion.
fn radiating(skin: &Surface, patches: &[&str]) -> RadiatingSurface {
    let shown = |point: &QuadraturePoint| {
        let patch = &skin.patches[skin.faces[point.face].patch];
        patches.is_empty() || patches.contains(&patch.as_str())
    };
    RadiatingSurface::of_faces(skin, rigid_modes(skin).as_view(), shown).unwrap()
}

#[test]
fn a_rigid_block_radiates_as_the_rectangle_of_its_top() {
    let mesh = mesh();
    let (skin, air) = (Surface::of(&mesh), Air::default());
    let exact = flat(
        rectangle([-0.2, 0.2], [-0.075, 0.075], 20, 12),
        &[&|_, _| 1.0, &|x, _| -x],
    );
    let top = radiating(&skin, &["top"]);
    assert!((top.area() - 0.06).abs() < 1e-14);
    for hz in [100.0, 1500.0] {
        let found = &Rayleigh::new(&top, &air).unwrap().resistance(hz)[0].real;
        let exact = &Rayleigh::new(&exact, &air).unwrap().resistance(hz)[0].real;
        let error = (found - exact).amax() / exact.amax();
        assert!(error < 1e-5, "{hz} Hz: {error:e}");
    }
}

#[test]
fn every_face_takes_its_own_normal() {
    let mesh = mesh();
    let skin = Surface::of(&mesh);
    let whole = radiating(&skin, &[]);
    let air = Air::default();
    let erp = Erp::new(&whole, &air).resistance(1000.0).real;
    // Heave moves top and bottom only: rho c 2 A.
    assert!((erp[(0, 0)] / (air.impedance() * 2.0 * 0.06) - 1.0).abs() < 1e-12);
    assert!((whole.area() - 2.0 * (0.4 * 0.15 + 0.4 * 0.1 + 0.15 * 0.1)).abs() < 1e-13);
    // A rigid motion encloses no volume flow.
    for mode in 0..2 {
        let flow: f64 = whole
            .normal_modes()
            .column(mode)
            .iter()
            .zip(whole.weights())
            .map(|(v, w)| v * w)
            .sum();
        assert!(flow.abs() < 1e-9, "{flow:e}");
    }
}

#[test]
fn impossible_requests_are_refused_by_name() {
    let mesh = mesh();
    let skin = Surface::of(&mesh);
    let short = rigid_modes(&skin).rows(0, 30).into_owned();
    assert!(matches!(
        RadiatingSurface::of_faces(&skin, short.as_view(), |_| true),
        Err(AcousticsError::Input(InputError::Length { found: 30, .. }))
    ));
    assert!(matches!(
        Rayleigh::new(&radiating(&skin, &["x_min"]), &Air::default()),
        Err(RadiationError::NotPlanar { .. })
    ));
}

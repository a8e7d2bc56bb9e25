//! Boundary elements in the mean over frequency, far above the meshes of single frequencies.

use crate::boundary_meshes::cuboid;
use nailnoise_acoustics::bem::{BemError, Boundary, Exterior, Parity, Patterns};
use nailnoise_acoustics::radiation::boundary_elements::{MeanBands, MeanRanges, MeshRange, ModalBem};
use nailnoise_acoustics::radiation::{ModalRadiation, Sampling};
use nailnoise_acoustics::{AcousticsError, Air};
use nalgebra::DMatrix;

/// A cube in free space that shakes and pulsates, on panels of at most `edge` \[m\].
fn shaken_cube(edge: f64, top_hz: f64) -> MeshRange {
    let boundary = Boundary::new(cuboid([0.0; 3], [0.3; 3], edge, true), None).unwrap();
    let velocities = boundary.project(2, |_, _, point, v| {
        (v[0], v[1]) = (point.area_vector().normalize().z, 1.0)
    });
    let patterns = vec![Patterns {
        parity: Parity::default(),
        velocities,
    }];
    MeshRange {
        problem: Exterior::new(boundary, &Air::default()),
        top_hz,
        patterns,
    }
}

/// Averages over two octaves above single frequencies, with the finer meshes that these need.
#[test]
fn averages_on_finer_meshes_are_means_of_single_solutions() {
    let top_hz = 300.0;
    let (to_hz, edge) = (Some(1200.0), |hz: f64| Air::default().sound_speed / (6.0 * hz));
    let bands = MeanBands::new(top_hz, to_hz);
    let mesh = |(top, _): (f64, usize)| shaken_cube(edge(top), top);
    let finer = || bands.finer_meshes().into_iter().map(mesh).collect::<Vec<_>>();
    assert_eq!(finer().len(), 3);
    let sampling = Sampling {
        range_hz: [150.0, top_hz],
        ..Sampling::default()
    };
    let solve = |finer: Vec<MeshRange>| {
        let levels = vec![shaken_cube(edge(top_hz), top_hz)];
        let means = MeanRanges { to_hz, finer };
        ModalBem::solve(levels, means, &sampling, &|| ()).map(|(bem, _)| bem)
    };
    let bem = solve(finer()).unwrap();
    let limit_from = bem.transition_hz()[0];
    assert!(
        (limit_from / bands.all()[11].centre_hz - 1.0).abs() < 1e-9,
        "{limit_from}"
    );
    assert!((bem.compared_hz()[1] / 1200.0 - 1.0).abs() < 1e-9);
    for (band, mesh) in [(4, 0), (11, 2)] {
        let (band, mesh) = (&bands.all()[band], &finer()[mesh]);
        let at = |hz: &f64| {
            mesh.problem
                .resistance(*hz, &mesh.patterns[0].velocities)
                .unwrap()
                .far_field
        };
        let mean = band
            .samples_hz
            .iter()
            .map(at)
            .fold(DMatrix::zeros(2, 2), |sum, r| sum + r)
            / 3.0;
        let found = bem.resistance(band.centre_hz).real;
        assert!((found - &mean).amax() < 1e-5 * mean.amax(), "{:.0} Hz", band.centre_hz);
    }
    for missing in [0, 1] {
        let meshes = finer().drain(..missing).collect();
        assert!(matches!(
            solve(meshes),
            Err(AcousticsError::Bem(BemError::TooCoarse { .. } | BemError::Input(_)))
        ));
    }
}

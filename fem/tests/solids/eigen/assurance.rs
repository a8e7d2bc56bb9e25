//! The modal assurance criterion does not depend on the axes of the measurement.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_fem::{Correlation, Pairing, correlate};
use nailnoise_meshes::uff::{MeasuredMode, Measurement};
use nailnoise_meshes::{Block, Surface, block};
use nalgebra::{Complex, DMatrix, Matrix3, Rotation3, Vector3};

const REACH: Pairing = Pairing::Position { reach: 1e-3 };

/// Three shapes of a block that have nothing in common.
fn shapes() -> (Surface, DMatrix<f64>) {
    let mesh = block(&Block {
        size: [0.4, 0.15, 0.1],
        divisions: [3, 2, 1],
        origin: [0.0; 3],
    })
    .unwrap();
    let value = |dof: usize, mode: usize| (dof as f64 * 0.37 + (mode * mode) as f64 * (1.0 + dof as f64)).sin();
    (Surface::of(&mesh), DMatrix::from_fn(3 * mesh.nodes.len(), 3, value))
}

/// Shapes as measured along the axes of each point, `seen` of them.
fn measured(
    surface: &Surface,
    shapes: &DMatrix<f64>,
    axes: impl Fn(u64) -> Matrix3<f64>,
    seen: [bool; 3],
) -> Measurement {
    let label = |node: usize| node as u64 + 1;
    let mode = |mode: usize| MeasuredMode {
        hz: 100.0 * (mode + 1) as f64,
        shape: surface
            .volume_nodes
            .iter()
            .map(|&node| {
                let u = axes(label(node)) * Vector3::from_fn(|k, _| shapes[(3 * node + k, mode)]);
                let of = |k: usize| Complex::new(if seen[k] { u[k] } else { 0.0 }, 0.0);
                (label(node), [of(0), of(1), of(2)])
            })
            .collect(),
    };
    let places = surface.volume_nodes.iter().zip(&surface.points);
    Measurement {
        nodes: places.map(|(&node, &point)| (label(node), point)).collect(),
        axes: surface
            .volume_nodes
            .iter()
            .map(|&node| (label(node), axes(label(node))))
            .collect(),
        modes: (0..3).map(mode).collect(),
    }
}

/// Axes that differ from point to point.
fn turned(label: u64) -> Matrix3<f64> {
    Rotation3::from_euler_angles(label as f64, 0.3 * label as f64, 2.0).into_inner()
}

fn with(shapes: &DMatrix<f64>, surface: &Surface, measurement: &Measurement, pairing: Pairing) -> Correlation {
    correlate((&[100.0, 200.0, 300.0], shapes), surface, measurement, pairing).unwrap()
}

#[test]
fn a_mode_matches_itself_in_any_axes_and_with_any_sensors() {
    let (surface, shapes) = shapes();
    for seen in [[true; 3], [true, false, false], [false, true, true]] {
        let found = with(&shapes, &surface, &measured(&surface, &shapes, turned, seen), REACH);
        assert_eq!(
            (found.matched, found.unmatched, found.by_position),
            (surface.points.len(), 0, true)
        );
        for (mode, row) in found.mac.iter().enumerate() {
            assert!((row[mode] - 1.0).abs() < 1e-12, "{seen:?}: {row:?}");
            assert_eq!(found.pairs[mode].mode, mode + 1);
        }
    }
    // Without its axes the same file is of other modes.
    let mut without = measured(&surface, &shapes, turned, [true; 3]);
    without.axes.clear();
    let found = with(&shapes, &surface, &without, REACH);
    assert!(
        found.mac.iter().enumerate().all(|(mode, row)| row[mode] < 0.9),
        "{:?}",
        found.mac
    );
}

#[test]
fn no_distance_is_stated_without_coordinates() {
    let (surface, shapes) = shapes();
    let mut file = measured(&surface, &shapes, |_| Matrix3::identity(), [true; 3]);
    let found = with(&shapes, &surface, &file, Pairing::Number);
    assert!(!found.by_position && found.farthest.unwrap() < 1e-15);
    file.nodes.values_mut().for_each(|p| p.x += 0.02);
    let found = with(&shapes, &surface, &file, Pairing::Number);
    assert!((found.farthest.unwrap() - 0.02).abs() < 1e-12);
    assert!(correlate((&[100.0], &shapes), &surface, &file, REACH).is_none());
    file.nodes.clear();
    let found = with(&shapes, &surface, &file, Pairing::Number);
    assert_eq!(found.farthest, None);
    assert!((found.mac[0][0] - 1.0).abs() < 1e-12);
    assert!(correlate((&[100.0], &shapes), &surface, &file, REACH).is_none());
}

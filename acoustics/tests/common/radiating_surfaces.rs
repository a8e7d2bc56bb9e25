//! Surfaces with analytic quadrature.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use nailnoise_acoustics::radiation::RadiatingSurface;
use nalgebra::{DMatrix, Point3, Vector3};
use std::f64::consts::PI;

/// Gauss-Legendre nodes and weights on [low, high].
pub fn gauss(n: usize, low: f64, high: f64) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..20 {
            let (mut before, mut p) = (1.0, x);
            for k in 2..=n {
                (before, p) = (p, ((2 * k - 1) as f64 * x * p - (k - 1) as f64 * before) / k as f64);
            }
            slope = n as f64 * (before - x * p) / (1.0 - x * x);
            x -= p / slope;
        }
        let half = 0.5 * (high - low);
        (low + half * (1.0 - x), half * 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// A surface in the plane z = 0 facing up, from points with weights and modes given as functions.
pub fn flat(points: Vec<([f64; 2], f64)>, modes: &[&dyn Fn(f64, f64) -> f64]) -> RadiatingSurface {
    let n = points.len();
    let values = DMatrix::from_fn(n, modes.len(), |i, j| modes[j](points[i].0[0], points[i].0[1]));
    RadiatingSurface::new(
        points.iter().map(|(p, _)| Point3::new(p[0], p[1], 0.0)).collect(),
        vec![Vector3::z(); n],
        points.iter().map(|(_, w)| *w).collect(),
        vec![0; n],
        vec!["top".to_owned()],
        values,
    )
    .unwrap()
}

/// Gauss points of a rectangle.
pub fn rectangle(x: [f64; 2], y: [f64; 2], nx: usize, ny: usize) -> Vec<([f64; 2], f64)> {
    let (xs, ys) = (gauss(nx, x[0], x[1]), gauss(ny, y[0], y[1]));
    xs.iter()
        .flat_map(|&(x, wx)| ys.iter().map(move |&(y, wy)| ([x, y], wx * wy)))
        .collect()
}

/// Points of a disk: Gauss in the radius, equal steps around.
pub fn disk(radius: f64, rings: usize, around: usize) -> Vec<([f64; 2], f64)> {
    let ring = |(r, w): (f64, f64)| {
        (0..around).map(move |i| {
            let (sine, cosine) = (2.0 * PI * (i as f64 + 0.5) / around as f64).sin_cos();
            ([r * cosine, r * sine], w * r * 2.0 * PI / around as f64)
        })
    };
    gauss(rings, 0.0, radius).into_iter().flat_map(ring).collect()
}

/// The published references copied into the tests.
pub fn references() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/references.json")).unwrap()
}

//! Quadrature points on faces, and the kernel between them.

use crate::air::Air;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use faer::Mat;
use nalgebra::{DMatrix, Vector3};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// Number of frequencies over which a kernel is averaged.
const AVERAGED: usize = 16;

/// Step of a kernel's table over distance, in units of 1/k at the highest frequency.
const STEP: f64 = 0.05;

/// Adding 1.5 x 2^52 rounds to the nearest integer, which is then in the lowest bits.
const NEAREST: f64 = 6_755_399_441_055_744.0;

/// Quadrature points of a set of panels.
pub(super) struct Points {
    pub(super) at: Vec<Vector3<f64>>,
    pub(super) weights: Vec<f64>,
    pub(super) patch: Vec<usize>,
    /// Index of the first velocity value of the point's panel, and the corner functions there.
    shapes: Vec<(usize, Vec<f64>)>,
}

impl Points {
    /// Quadrature points of `panels`; `order` returns the number of points per side, given the length of the longest
    /// side \[m\].
    pub(super) fn new(boundary: &Boundary, panels: &[usize], order: impl Fn(f64) -> usize) -> Self {
        let mesh = boundary.mesh();
        let corners: Vec<usize> = mesh.panels.iter().map(|p| p.corners().len()).collect();
        let mut first = vec![0; corners.len()];
        for p in 1..corners.len() {
            first[p] = first[p - 1] + corners[p - 1];
        }
        let mut points = Self {
            at: Vec::new(),
            weights: Vec::new(),
            patch: Vec::new(),
            shapes: Vec::new(),
        };
        for &p in panels {
            let kind = mesh.panels[p].kind();
            let at = |k: usize| mesh.points[mesh.panels[p].corners()[k % corners[p]]];
            let longest = (0..corners[p]).map(|k| (at(k + 1) - at(k)).norm()).fold(0.0, f64::max);
            let rule = match (corners[p], order(longest)) {
                (3, order) => rules::triangle(if order > 3 { 12 } else { 7 }),
                (_, order) => rules::square(order),
            };
            for (xi, w) in rule {
                let point = mesh.point_at(p, xi);
                points.at.push(point.position.coords);
                points.weights.push(w * point.area_vector().norm());
                points.patch.push(mesh.panels[p].patch);
                points
                    .shapes
                    .push((first[p], kind.linear().at(xi).n[..corners[p]].to_vec()));
            }
        }
        points
    }

    /// Their patches, without duplicates.
    pub(super) fn patches(&self) -> Vec<usize> {
        let mut patches = self.patch.clone();
        patches.sort_unstable();
        patches.dedup();
        patches
    }

    pub(super) fn velocity(&self, point: usize, velocities: &DMatrix<f64>, mode: usize) -> f64 {
        let (first, shape) = &self.shapes[point];
        shape
            .iter()
            .enumerate()
            .map(|(c, n)| n * velocities[(first + c, mode)])
            .sum()
    }

    /// Modes that move any of the points, and weight times velocity, points x those modes.
    pub(super) fn flows(&self, velocities: &DMatrix<f64>) -> (Vec<usize>, Mat<f32>) {
        let moves = |mode: &usize| {
            let values = velocities.column(*mode);
            let moved = |(first, shape): &(usize, Vec<f64>)| (0..shape.len()).any(|c| values[first + c] != 0.0);
            self.shapes.iter().any(moved)
        };
        let moving: Vec<usize> = (0..velocities.ncols()).filter(moves).collect();
        let flow = |i: usize, j: usize| (self.weights[i] * self.velocity(i, velocities, moving[j])) as f32;
        let flows = Mat::from_fn(self.at.len(), moving.len(), flow);
        (moving, flows)
    }
}

/// The mean of k² sin(kr)/(kr) over a range of frequencies, uniform in their logarithm, tabulated over distance.
pub(super) struct Kernel {
    /// The largest wavenumber \[1/m\].
    pub(super) highest: f64,
    step: f64,
    values: Vec<f64>,
}

impl Kernel {
    pub(super) fn new([low, high]: [f64; 2], air: &Air, farthest: f64) -> Self {
        let wavenumber = |hz: f64| 2.0 * PI * hz / air.sound_speed;
        let rule = nailnoise_meshes::gauss_legendre(AVERAGED);
        let numbers: Vec<(f64, f64)> = rule
            .into_iter()
            .map(|(x, w)| (wavenumber(low * (high / low).powf(0.5 * (1.0 + x))), 0.5 * w))
            .collect();
        let step = STEP / wavenumber(high);
        let value = |i: usize| {
            let r = i as f64 * step;
            let one = |&(k, w): &(f64, f64)| w * k * k * if i == 0 { 1.0 } else { (k * r).sin() / (k * r) };
            numbers.iter().map(one).sum()
        };
        let values = (0..(farthest / step).ceil() as usize + 2).map(value).collect();
        Self {
            highest: wavenumber(high),
            step,
            values,
        }
    }

    /// Sets `sums` to the kernel between some places and each of the points with coordinates `points`, summed over the
    /// places.
    pub(super) fn between(&self, places: &[Vector3<f64>], points: [&[f64]; 3], sums: &mut [f64]) {
        sums.fill(0.0);
        let mut steps = vec![0.0; sums.len()];
        for place in places {
            Arch::new().dispatch(FromPlace {
                kernel: self,
                place,
                points,
                steps: &mut steps,
                sums,
            });
        }
    }
}

/// Adds the kernel between one place and each point to `sums`; `steps` is workspace for the distances in units of the
/// table step.
struct FromPlace<'a> {
    kernel: &'a Kernel,
    place: &'a Vector3<f64>,
    points: [&'a [f64]; 3],
    steps: &'a mut [f64],
    sums: &'a mut [f64],
}

impl WithSimd for FromPlace<'_> {
    type Output = ();

    /// Loops over slices are vectorised at the full vector width.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let ([x, y, z], from) = (self.points, self.place);
        let inverse = 1.0 / self.kernel.step;
        for (((to, x), y), z) in self.steps.iter_mut().zip(x).zip(y).zip(z) {
            let (x, y, z) = (x - from.x, y - from.y, z - from.z);
            *to = (x * x + y * y + z * z).sqrt() * inverse;
        }
        let values = self.kernel.values.as_slice();
        let last = values.len() - 2;
        for (sum, &place) in self.sums.iter_mut().zip(&*self.steps) {
            let below = place - 0.5 + NEAREST;
            let i = (below.to_bits() as u32 as usize).min(last);
            let t = place - (below - NEAREST);
            *sum += values[i] + t * (values[i + 1] - values[i]);
        }
    }
}

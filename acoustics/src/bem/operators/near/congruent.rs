//! Finds congruent pairs of panels, which have the same matrices.

use super::choice::ClosePair;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::MOST_NODES;
use crate::bem::mesh::symmetry::Image;
use nailnoise_meshes::FaceKind;
use nalgebra::Vector3;

/// Distance below which points count as coincident, relative to the largest extent of the body. Pairs that differ by
/// less have matrices that agree to about the same accuracy relative to the panel size; rounding errors are far
/// smaller.
const SAME: f64 = 1e-10;

/// Shape of a pair: kinds, common corners, whether the second panel is an odd image, and the positions of all nodes in
/// a frame attached to the first panel.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct Congruence {
    kinds: [FaceKind; 2],
    common: u16,
    odd: bool,
    positions: Vec<[i64; 3]>,
}

impl Congruence {
    /// `size` is the body's largest extent \[m\].
    pub(super) fn of(boundary: &Boundary, couple: &ClosePair, size: f64) -> Self {
        let panels = couple.panels.map(|p| &boundary.mesh().panels[p]);
        let images = [boundary.images()[0], couple.image];
        let [x, y] = [0, 1].map(|side| positions(boundary, couple.panels[side], images[side]));
        let origin = Vector3::from(x[0]);
        let from = |p: &[f64; 3]| Vector3::from(*p) - origin;
        let along = from(&x[1]).normalize();
        let normal = along.cross(&from(&x[panels[0].corners().len() - 1])).normalize();
        let across = normal.cross(&along);
        let cell = |p: &[f64; 3]| {
            let d = from(p);
            [along, across, normal].map(|axis| (d.dot(&axis) / (SAME * size)).round() as i64)
        };
        let nodes = [0, 1].map(|side| panels[side].nodes().len());
        Self {
            kinds: panels.map(|p| p.kind()),
            common: couple.common(boundary),
            odd: couple.image.handedness() < 0.0,
            positions: x[..nodes[0]].iter().chain(&y[..nodes[1]]).map(cell).collect(),
        }
    }
}

/// Node positions of a panel's image.
pub(super) fn positions(boundary: &Boundary, p: usize, image: Image) -> [[f64; 3]; MOST_NODES] {
    let mesh = boundary.mesh();
    let mut all = [[0.0; 3]; MOST_NODES];
    for (slot, &n) in all.iter_mut().zip(mesh.panels[p].nodes()) {
        let x = mesh.points[n];
        *slot = [0, 1, 2].map(|axis| boundary.mirrored(image, axis, x[axis]));
    }
    all
}

//! Porous covers on a surface: the condition v_n = T v_s - Y p on covered panels.
//!
//! On bare panels the normal velocity v_n of the air is that of the wall, v_s. On covered ones the outer face of the
//! layer yields to the pressure, with T and Y of [`PorousLayer::transfer`]. The outer face is assumed to be at the
//! position of the wall. Let A p = j omega rho B v_n be the equation of Burton & Miller, see
//! [`Exterior`](super::problem::Exterior), and s = 1 on covered panels, 0 on the others.
//!
//! ```text
//! (A + j omega rho Y B s) p = j omega rho B (1 + (T - 1) s) v_s
//! ```
//!
//! B s is the product of B with s times the shape function of each pressure unknown. These products are computed as
//! additional velocity patterns.

use crate::air::Air;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::operators::blocks::Block;
use crate::bem::operators::equations::Sums;
use crate::porous::{LayerTransfer, PorousLayer};
use faer::Mat;
use nailnoise_meshes::FaceKind;
use nalgebra::{Complex, DMatrix};

/// A porous layer on part of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceCover {
    /// The layer.
    pub layer: PorousLayer,
    /// Covered share of the surface at each corner of every panel, from 0 to 1; see [`Boundary::project`].
    pub shares: Vec<f64>,
}

/// Additional patterns for the equations of a covered surface: s times the shape function of each pressure unknown on a
/// covered panel.
#[derive(Debug)]
pub(crate) struct CoverPatterns {
    /// Shares by velocity value.
    shares: Vec<f64>,
    /// The unknown of each pattern.
    unknowns: Vec<usize>,
    /// For each corner of a covered panel its velocity value, unknown and pattern.
    corners: Vec<Corner>,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    value: usize,
    pattern: usize,
}

impl CoverPatterns {
    pub(crate) fn new(boundary: &Boundary, cover: &SurfaceCover) -> Self {
        let mut pattern_of = vec![None; boundary.nodes()];
        let (mut unknowns, mut corners, mut value) = (Vec::new(), Vec::new(), 0);
        for panel in &boundary.mesh().panels {
            for unknown in boundary.unknowns_of(panel) {
                if cover.shares[value] > 0.0 {
                    let pattern = *pattern_of[unknown].get_or_insert_with(|| {
                        unknowns.push(unknown);
                        unknowns.len() - 1
                    });
                    corners.push(Corner { value, pattern });
                }
                value += 1;
            }
        }
        Self {
            shares: cover.shares.clone(),
            unknowns,
            corners,
        }
    }

    /// The columns of the equations for this many motions: those of the motions, of s times the motions, and of s times
    /// the shape functions.
    pub(crate) fn columns(&self, motions: usize) -> usize {
        2 * motions + self.unknowns.len()
    }

    /// s v for the corner values of motions.
    pub(crate) fn on_covered(&self, velocities: &DMatrix<f64>) -> DMatrix<f64> {
        let mut covered = velocities.clone();
        for (mut row, share) in covered.row_iter_mut().zip(&self.shares) {
            row *= *share;
        }
        covered
    }

    /// s times the shape functions at the points of a block, patterns x points, see [`Block::patterns`].
    pub(crate) fn on_block(&self, block: &Block) -> Mat<f32> {
        let kind = if block.corners == 3 {
            FaceKind::Tri3
        } else {
            FaceKind::Quad4
        };
        let shapes: Vec<_> = rules::far(block.corners).iter().map(|&(xi, _)| kind.at(xi)).collect();
        let mut patterns = Mat::zeros(self.unknowns.len(), block.corners * block.width);
        for (f, &first) in block.first_value.iter().enumerate() {
            for corner in self.corners_of(first, block.corners) {
                let share = self.shares[corner.value];
                for (point, shape) in shapes.iter().enumerate() {
                    patterns[(corner.pattern, point * block.width + f)] +=
                        (share * shape.n[corner.value - first]) as f32;
                }
            }
        }
        patterns
    }

    /// The covered corners of a panel whose velocity values begin at `first`.
    fn corners_of(&self, first: usize, count: usize) -> &[Corner] {
        let start = self.corners.partition_point(|c| c.value < first);
        let end = self.corners.partition_point(|c| c.value < first + count);
        &self.corners[start..end]
    }

    /// Adds `factor` int phi_i s phi_j dS to the columns of the shape functions.
    pub(crate) fn add_moments(
        &self,
        (boundary, masses): (&Boundary, &[[[f64; 4]; 4]]),
        (motions, factor): (usize, f64),
        to: &mut Mat<f64>,
    ) {
        let mut first = 0;
        for (panel, mass) in boundary.mesh().panels.iter().zip(masses) {
            let unknowns: Vec<usize> = boundary.unknowns_of(panel).collect();
            for corner in self.corners_of(first, unknowns.len()) {
                let column = to.col_as_slice_mut(2 * motions + corner.pattern);
                let share = factor * self.shares[corner.value];
                for (&unknown, mass) in unknowns.iter().zip(&mass[corner.value - first]) {
                    column[unknown] += share * mass;
                }
            }
            first += unknowns.len();
        }
    }

    /// The equations of the covered surface from those of the bare one with [`Self::columns`], where `factor` is
    /// j omega rho.
    pub(crate) fn folded(&self, sums: Sums, motions: usize, of: &LayerTransfer, factor: Complex<f64>) -> Sums {
        let Sums {
            mut matrix,
            transposed,
            right: [re, im],
        } = sums;
        let admittance = factor * of.admittance;
        for (pattern, &unknown) in self.unknowns.iter().enumerate() {
            let column = 2 * motions + pattern;
            let parts = re.col_as_slice(column).iter().zip(im.col_as_slice(column));
            for (to, (&re, &im)) in matrix.col_as_slice_mut(unknown).iter_mut().zip(parts) {
                let added = admittance * Complex::new(re, im);
                *to += Complex::new(added.re as f32, added.im as f32);
            }
        }
        let excess = of.velocity - 1.0;
        let mut right = [0, 1].map(|_| Mat::zeros(re.nrows(), motions));
        for m in 0..motions {
            for i in 0..re.nrows() {
                let covered = excess * Complex::new(re[(i, motions + m)], im[(i, motions + m)]);
                right[0][(i, m)] = re[(i, m)] + covered.re;
                right[1][(i, m)] = im[(i, m)] + covered.im;
            }
        }
        Sums {
            matrix,
            transposed,
            right,
        }
    }
}

impl SurfaceCover {
    /// Real velocities of the wall with which a bare surface would radiate the power of the covered one in plane waves.
    pub(crate) fn equivalent(&self, velocities: &DMatrix<f64>, hz: f64, air: &Air) -> DMatrix<f64> {
        let power = self.layer.plane_wave_power(hz, air);
        let mut scaled = velocities.clone();
        for (mut row, share) in scaled.row_iter_mut().zip(&self.shares) {
            row *= (1.0 + share * (power - 1.0)).sqrt();
        }
        scaled
    }

    /// Replaces the velocities of the wall at all corners by those of the outer face, for one motion at one frequency,
    /// given the pressures of all unknowns and the unknown at each corner.
    pub(crate) fn to_outer_face(
        &self,
        of: &LayerTransfer,
        (pressures, unknowns): (&[Complex<f64>], &[usize]),
        velocities: &mut [Complex<f64>],
    ) {
        for ((v, &unknown), share) in velocities.iter_mut().zip(unknowns).zip(&self.shares) {
            *v += *share * ((of.velocity - 1.0) * *v - of.admittance * pressures[unknown]);
        }
    }
}

/// First half of the columns plus j times the second half.
pub(crate) fn joined(halves: &Mat<Complex<f64>>) -> Mat<Complex<f64>> {
    let motions = halves.ncols() / 2;
    Mat::from_fn(halves.nrows(), motions, |i, m| {
        halves[(i, m)] + Complex::<f64>::i() * halves[(i, motions + m)]
    })
}

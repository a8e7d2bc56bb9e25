//! Porous covers on a surface: the condition v_n = T v_s - Y p on covered panels.
//!
//! On bare panels the normal velocity v_n of the air is that of the wall, v_s. On covered ones the outer face of the
//! layer yields to the pressure, with T and Y of [`PorousLayer::transfer`]. The outer face is taken at the place of the
//! wall. With A p = j omega rho B v_n the equation of Burton & Miller (see [`Exterior`]) and s = 1 on covered panels, 0
//! on the others:
//!
//! ```text
//! (A + j omega rho Y B s) p = j omega rho B (1 + (T - 1) s) v_s
//! ```
//!
//! B s is the product of B with s times each pressure unknown's shape function, computed as further velocity patterns.

use super::cost::FrequencyCost;
use super::far_field::Radiated;
use super::neumann::NeumannData;
use super::problem::{Exterior, SurfacePressure};
use crate::air::Air;
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::operators::blocks::Block;
use crate::bem::operators::equations::Sums;
use crate::checks::{InputError, same_length};
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

impl Exterior {
    /// Adds the cost of the columns of a cover, of which there are at most as many as unknowns, to that of the motions.
    pub(crate) fn with_cost_of_cover(&self, cost: FrequencyCost) -> FrequencyCost {
        let Some(cover) = self.cover() else { return cost };
        let covered = cover.shares.iter().filter(|share| **share > 0.0).count() as f64;
        let (nodes, copies) = (self.boundary().nodes() as f64, self.boundary().copies() as f64);
        let columns = nodes * covered / cover.shares.len().max(1) as f64;
        FrequencyCost {
            bytes: cost.bytes + copies * 32.0 * nodes * columns,
            seconds: cost.seconds + cost.seconds_per_pattern * columns,
            ..cost
        }
    }

    /// Puts a porous layer on part of the surface. Velocities are those of the wall below it. The equations are solved
    /// with a dense matrix.
    ///
    /// # Errors
    /// If the shares are not one for each velocity value, or outside 0 to 1.
    pub fn with_cover(mut self, cover: SurfaceCover) -> Result<Self, BemError> {
        let values = self.boundary().velocity_values();
        same_length("covered shares of the corners", cover.shares.len(), values)?;
        if let Some(&value) = cover.shares.iter().find(|s| !(0.0..=1.0).contains(*s)) {
            return Err(InputError::OutsideRange {
                what: "covered share of a corner",
                value,
                low: 0.0,
                high: 1.0,
            }
            .into());
        }
        self.set_cover(cover);
        Ok(self)
    }

    /// Normal velocity of the air at the corners of all panels, real and imaginary parts, for the velocities of the
    /// wall and the pressure that they cause; `None` on a bare surface, where both velocities are equal.
    pub(crate) fn air_velocities(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Option<[DMatrix<f64>; 2]> {
        let cover = self.cover()?;
        let of = cover.layer.transfer(solution.hz, self.air());
        let unknowns = self.unknowns_of_values();
        let mut air = velocities.map(Complex::from);
        for (v, p) in air
            .as_mut_slice()
            .chunks_exact_mut(unknowns.len().max(1))
            .zip(solution.pressure.column_iter())
        {
            cover.to_outer_face(&of, (p.as_slice(), &unknowns), v);
        }
        Some([air.map(|v| v.re), air.map(|v| v.im)])
    }

    /// The pressure unknown at each velocity value.
    pub(crate) fn unknowns_of_values(&self) -> Vec<usize> {
        let panels = self.boundary().mesh().panels.iter();
        panels.flat_map(|panel| self.boundary().unknowns_of(panel)).collect()
    }

    /// int v_i* p_j dS of every patch for the velocities v of the air, given those of the wall.
    pub(crate) fn powers(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        let Some(air) = self.air_velocities(velocities, solution) else {
            return self.impedance(velocities, solution);
        };
        let [real, imaginary] = air.each_ref().map(|part| self.impedance(part, solution));
        let pairs = real?.into_iter().zip(imaginary?);
        Ok(pairs.map(|(re, im)| re - im * Complex::<f64>::i()).collect())
    }

    /// int (1 + (T - 1) s) v_i p_j dS over the surface, which is symmetric by reciprocity.
    pub(crate) fn reciprocal_impedance(
        &self,
        data: &NeumannData,
        solution: &SurfacePressure,
    ) -> Result<DMatrix<Complex<f64>>, BemError> {
        let zeros = DMatrix::zeros(data.count(), data.count());
        let bare = self.impedances(data.by_patch(), solution)?;
        let mut sum = bare.iter().fold(zeros, |sum, z| sum + z);
        if let (Some(cover), Some(patterns)) = (self.cover(), data.cover()) {
            let excess = cover.layer.transfer(solution.hz, self.air()).velocity - 1.0;
            for z in self.impedance(&patterns.on_covered(data.velocities()), solution)? {
                sum += z * excess;
            }
        }
        Ok(sum)
    }

    /// Radiating fields with real velocities whose first half plus j times their second half is that of a covered
    /// surface; `None` on a bare surface.
    pub(crate) fn with_real_velocities(&self, all: &[Radiated<'_>]) -> Option<Vec<(DMatrix<f64>, SurfacePressure)>> {
        let of = |(velocities, solution): &Radiated<'_>| {
            let [real, imaginary] = self.air_velocities(velocities, solution)?;
            let motions = real.ncols();
            let mut both = real.resize_horizontally(2 * motions, 0.0);
            both.columns_mut(motions, motions).copy_from(&imaginary);
            let pressure = solution.pressure.clone();
            let pressure = pressure.resize_horizontally(2 * motions, Complex::default());
            Some((both, SurfacePressure { pressure, ..**solution }))
        };
        all.iter().map(of).collect()
    }
}

/// First half of the columns plus j times the second half.
pub(crate) fn joined(halves: &Mat<Complex<f64>>) -> Mat<Complex<f64>> {
    let motions = halves.ncols() / 2;
    Mat::from_fn(halves.nrows(), motions, |i, m| {
        halves[(i, m)] + Complex::<f64>::i() * halves[(i, motions + m)]
    })
}

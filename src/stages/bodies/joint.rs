//! Joint of a workpiece with two pieces: a board on the block, and the nail that fastens it.
//!
//! The pieces touch in contact cells that transmit only compression. The driven nail connects them along its axis, by
//! its head and the friction along its shank, and across its axis, as a dowel. Its springs act from the start of the
//! shot. Assumption: until the nail has passed the joint, tool and weight press the pieces together, so that the
//! springs carry little. Friction between the pieces is neglected.

use nailnoise_fem::LoadVector;
use nailnoise_fem::vibration::{Support, SupportLaw};
use nailnoise_meshes::{JOINT, Mesh, MeshError, gauss_legendre};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::contact_cells::ContactCells;
use super::nail_stations::NailPlace;

/// Number of points for the mean along a part of the shank.
const POINTS: usize = 3;

/// Number of springs of the nail: one along its axis, two across.
const NAIL_SPRINGS: usize = 3;

/// Places where the two pieces of a workpiece act on each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Joint {
    /// Its height above the underside of the block \[m\].
    pub height: f64,
    /// Cells where the pieces touch.
    pub cells: ContactCells,
    /// The nail.
    pub nail: NailPlace,
    /// Length of the shank on each side of the joint over which the dowel acts \[m\].
    pub dowel: f64,
}

/// A spring with its dashpot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSpring {
    /// Stiffness \[N/m\], or per area \[N/m3\].
    pub stiffness: f64,
    /// Damping \[N s/m\], or per area \[N s/m3\].
    pub damping: f64,
}

impl Joint {
    /// Number of its supports.
    pub fn supports_count(&self) -> usize {
        self.cells.grid().points.len() + NAIL_SPRINGS
    }

    /// Supports in the order of the load vectors: contact per area in each cell, then the nail along and across its
    /// axis.
    pub fn supports(&self, contact: JointSpring, axial: JointSpring, shear: JointSpring) -> Vec<Support> {
        let support = |spring: JointSpring, area: f64, law| Support {
            stiffness: spring.stiffness * area,
            damping: spring.damping * area,
            gap: 0.0,
            law,
        };
        let grid = self.cells.grid();
        let cells = grid
            .areas
            .iter()
            .map(|&area| support(contact, area, SupportLaw::Unilateral));
        let nail = [axial, shear, shear].map(|spring| support(spring, 1.0, SupportLaw::Bonded));
        cells.chain(nail).collect()
    }

    /// Load vectors: approach of the pieces in each cell, then the displacement of the block minus that of the board at
    /// the nail, upwards, along x and along y.
    pub(super) fn load_vectors(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, MeshError> {
        let up = Vector3::z();
        let lower = self.cells.load_vectors(mesh, JOINT[0], self.height, up)?;
        let upper = self.cells.load_vectors(mesh, JOINT[1], self.height, -up)?;
        let mut vectors: Vec<LoadVector> = lower.iter().zip(&upper).map(|(a, b)| a.plus(b)).collect();
        let NailPlace { entry: top, length, .. } = self.nail;
        let tip = top - length;
        vectors.push(self.slip(mesh, [tip, top], up)?);
        let near = [tip.max(self.height - self.dowel), top.min(self.height + self.dowel)];
        for across in [Vector3::x(), Vector3::y()] {
            vectors.push(self.slip(mesh, near, across)?);
        }
        Ok(vectors)
    }

    /// Mean displacement of the block along the shank from the lower end to the joint, minus that of the board from the
    /// joint to the upper end.
    fn slip(&self, mesh: &Mesh, [low, high]: [f64; 2], direction: Vector3<f64>) -> Result<LoadVector, MeshError> {
        let [x, y] = self.nail.at;
        let pieces = [([low, self.height], 1.0), ([self.height, high], -1.0)];
        let mut sum = LoadVector::zero();
        for ([from, to], sign) in pieces {
            for &(xi, weight) in &gauss_legendre(POINTS) {
                let z = 0.5 * ((from + to) + xi * (to - from));
                let point = LoadVector::point(mesh, Point3::new(x, y, z), direction * (0.5 * sign * weight), 0.0)?;
                sum = sum.plus(&point);
            }
        }
        Ok(sum)
    }
}

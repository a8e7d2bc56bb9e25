//! The faces of workpiece and support that do not radiate.

use nailnoise_meshes::JOINT;
use nalgebra::Point3;
use serde::Serialize;

use crate::stages::bodies::BodyKind;

/// Names of the bodies of the structure.
pub(super) const WORKPIECE: &str = BodyKind::Workpiece.name();
pub(super) const WORKTABLE: &str = BodyKind::Worktable.name();

/// The faces of a workpiece that radiate into the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum OpenFaces {
    /// All: the underside is clear of the floor; even a narrow gap radiates.
    All,
    /// All except the underside, which lies on its support.
    AboveUnderside,
    /// Only the top, flush with a plane around it.
    FlushTop,
}

/// The faces of workpiece and support that do not radiate, because they touch each other, the floor or the surrounding
/// material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CoveredFaces {
    /// The faces of the workpiece that radiate.
    pub workpiece: OpenFaces,
    /// Half-lengths of the sides of the workpiece's underside, which covers part of the top of a table \[m\].
    pub half_sides: [f64; 2],
}

impl CoveredFaces {
    /// Whether a body's patch does not radiate at a point.
    pub fn covers(&self, body: &str, patch: &str, at: &Point3<f64>) -> bool {
        // Faces tied to others, and those where two pieces touch.
        if patch.ends_with("_slave") || JOINT.contains(&patch) {
            return true;
        }
        let [x, y] = self.half_sides;
        match (body, patch) {
            (_, "floor") => true,
            (WORKPIECE, "top") => false,
            (WORKPIECE, "bottom") => self.workpiece != OpenFaces::All,
            (WORKPIECE, _) => self.workpiece == OpenFaces::FlushTop,
            (WORKTABLE, "bottom") => true,
            (WORKTABLE, "top") => at.x.abs() < x && at.y.abs() < y,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether each patch of the workpiece is covered, for a workpiece with these open faces.
    fn covered(workpiece: OpenFaces) -> [bool; 3] {
        let faces = CoveredFaces {
            workpiece,
            half_sides: [0.2, 0.1],
        };
        ["top", "x_min", "bottom"].map(|patch| faces.covers("workpiece", patch, &Point3::origin()))
    }

    #[test]
    fn a_support_covers_the_underside_and_sand_all_but_the_top() {
        assert_eq!(covered(OpenFaces::All), [false, false, false]);
        assert_eq!(covered(OpenFaces::AboveUnderside), [false, false, true]);
        assert_eq!(covered(OpenFaces::FlushTop), [false, true, true]);
    }

    #[test]
    fn the_workpiece_covers_the_table_under_it_alone() {
        let faces = CoveredFaces {
            workpiece: OpenFaces::AboveUnderside,
            half_sides: [0.2, 0.1],
        };
        let on_table = |x: f64, y: f64| faces.covers("worktable", "top", &Point3::new(x, y, 0.0));
        assert!(on_table(0.19, 0.09) && !on_table(0.21, 0.0) && !on_table(0.0, 0.11));
    }
}

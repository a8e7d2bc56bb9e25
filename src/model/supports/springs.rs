//! The user's springs, `springs.NAME`, as the only support of a workpiece that stands or hangs above a floor.

use nailnoise_dynamics as dynamics;

use super::floor;
use super::support::{FARTHEST_FLOOR, Support, carried};
use crate::design::{Conflict, Sprung, Values};
use crate::drawing::{Annotation, Side, View};
use crate::error::Error;
use crate::stages::radiation::OpenFaces;

/// A workpiece on springs.
pub(super) struct OnSprings<'a>(pub(super) &'a Values);

impl Support for OnSprings<'_> {
    fn check(&self) -> Result<(), Conflict> {
        carried(self.0, Sprung::Workpiece, "support.kind")
    }

    /// The sum of the springs.
    fn lumped(&self) -> Result<dynamics::Support, Error> {
        let [stiffness, damping] = self.0.sprung(Sprung::Workpiece);
        Ok(dynamics::Support {
            stiffness,
            damping: dynamics::SupportDamping::Coefficient(damping),
        })
    }

    fn reflecting_plane(&self) -> f64 {
        -self.0.support.clearance
    }

    fn floor(&self) -> Option<f64> {
        let clearance = self.0.support.clearance;
        (clearance <= FARTHEST_FLOOR).then_some(-clearance)
    }

    fn sound_centre(&self) -> f64 {
        0.5 * self.0.workpiece.thickness
    }

    fn open_faces(&self) -> OpenFaces {
        if self.0.support.clearance > 0.0 {
            OpenFaces::All
        } else {
            OpenFaces::AboveUnderside
        }
    }

    fn name(&self) -> String {
        "springs".to_owned()
    }

    fn in_words(&self) -> String {
        if self.open_faces() == OpenFaces::AboveUnderside {
            return "workpiece alone on its springs and the floor, its underside silent".to_owned();
        }
        format!(
            "workpiece alone on its springs, its underside {:.3} m above the floor{}",
            self.0.support.clearance,
            if self.floor().is_some() {
                ""
            } else {
                ", which is left out of its power"
            }
        )
    }

    fn draw(&self, view: &mut View) {
        let (half, plane) = (0.5 * self.0.workpiece.length, self.reflecting_plane());
        floor::draw(view, floor::beyond(half), plane);
        view.annotations.push(Annotation::upright(
            "support.clearance",
            Side::Left,
            [plane, 0.0],
            -half - 0.03,
            [-half; 2],
        ));
    }
}

//! A rigid floor to which the workpiece's underside is fixed.

use nailnoise_dynamics as dynamics;

use super::floor;
use super::support::Support;
use crate::design::Values;
use crate::drawing::View;
use crate::error::Error;

/// A workpiece whose underside is fixed.
pub(super) struct Clamped<'a>(pub(super) &'a Values);

impl Support for Clamped<'_> {
    /// A block clamped at its base is the spring k_ws = E A/L itself.
    fn lumped(&self) -> Result<dynamics::Support, Error> {
        let table = &self.0.support.worktable;
        Ok(dynamics::Support {
            stiffness: table.stiffness,
            damping: dynamics::SupportDamping::Ratio(table.damping_ratio),
        })
    }

    fn fixed(&self) -> Option<&'static str> {
        Some("bottom")
    }

    fn reflecting_plane(&self) -> f64 {
        0.0
    }

    fn name(&self) -> String {
        "clamped".to_owned()
    }

    fn in_words(&self) -> String {
        "workpiece alone, its underside held on a rigid floor".to_owned()
    }

    fn draw(&self, view: &mut View) {
        floor::draw(view, floor::beyond(0.5 * self.0.workpiece.length), 0.0);
    }
}

//! A rigid floor on which the workpiece lies.

use nailnoise_dynamics as dynamics;

use super::support::{Contact, Support};
use crate::design::Values;
use crate::drawing::{Material, Part, View, rectangle};
use crate::error::Error;

/// Distance by which a drawn floor extends beyond the object on it \[m\].
const BEYOND: f64 = 0.08;

/// A workpiece on a rigid floor.
pub(super) struct OnFloor<'a>(pub(super) &'a Values);

impl Support for OnFloor<'_> {
    /// The contact as one spring and dashpot.
    fn lumped(&self) -> Result<dynamics::Support, Error> {
        let (block, contact) = (&self.0.workpiece, Contact::of_underside(self.0));
        let area = block.length * block.width;
        Ok(dynamics::Support {
            stiffness: contact.stiffness * area,
            damping: dynamics::SupportDamping::Coefficient(contact.damping * area),
        })
    }

    fn contacts(&self) -> Result<Vec<Contact>, Error> {
        Ok(vec![Contact::of_underside(self.0)])
    }

    fn reflecting_plane(&self) -> f64 {
        0.0
    }

    fn name(&self) -> String {
        "floor".to_owned()
    }

    fn in_words(&self) -> String {
        "workpiece alone on a rigid floor, its underside silent".to_owned()
    }

    fn draw(&self, view: &mut View) {
        draw(view, beyond(0.5 * self.0.workpiece.length), 0.0);
    }
}

/// Ends of a drawn floor under an object of this half-length \[m\].
pub(super) fn beyond(half: f64) -> [f64; 2] {
    [-half - BEYOND, half + BEYOND]
}

/// Draws a floor between two ends at a height \[m\].
pub(super) fn draw(view: &mut View, [from, to]: [f64; 2], height: f64) {
    view.parts.push(Part::new(
        "floor",
        Material::Floor,
        vec![rectangle([from, to], [height - 0.025, height])],
    ));
}

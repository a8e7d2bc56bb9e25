//! Supports of the workpiece, one file each.
//!
//! A [`Support`] provides all that depends on the support: its spring in the nailing cycle, its finite-element bodies
//! and contacts, the faces that it covers, the reflecting plane, the sensors that it can carry, its description and its
//! drawing. Nothing else in the program distinguishes the kinds of support. A new one needs a file here, a line in
//! [`of`], and its keys in the design.

mod clamped;
mod floor;
mod sandbox;
mod springs;
pub(crate) mod support;
mod worktable;

use crate::design::{SupportKind, Values};

pub(crate) use support::{Contact, FlushSand, Support, Table, underside};

/// The support of a design's workpiece.
pub(crate) fn of(values: &Values) -> Box<dyn Support + '_> {
    match values.support.kind {
        SupportKind::Worktable => Box::new(worktable::OnWorktable(values)),
        SupportKind::Sandbox => Box::new(sandbox::InSandbox(values)),
        SupportKind::Floor => Box::new(floor::OnFloor(values)),
        SupportKind::Clamped => Box::new(clamped::Clamped(values)),
        SupportKind::Springs => Box::new(springs::OnSprings(values)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nailnoise_dynamics as dynamics;

    use super::*;
    use crate::design::{Carrier, Conflict, Design, Sprung, TableFoot};
    use crate::stages::bodies::BodyKind;
    use crate::stages::radiation::OpenFaces;

    /// The base design on every kind of support.
    fn designs() -> impl Iterator<Item = Design> {
        SupportKind::ALL.iter().map(|kind| {
            let mut design = Design::shipped("n80cb.toml").unwrap();
            design.support.kind = *kind;
            design
        })
    }

    #[test]
    fn a_support_states_the_same_in_all_its_answers() {
        for design in designs() {
            let (support, name) = (of(&design), design.support.kind.as_str());
            let (faces, carriers) = (support.open_faces(), support.carriers());
            let flush = support.flush_sand().unwrap().is_some();
            assert_eq!(flush, faces == OpenFaces::FlushTop, "{name}");
            let moving = support.moving_sand().unwrap().is_some();
            assert_eq!(moving, carriers.contains(&Carrier::Sand), "{name}");
            let table = support.table().unwrap().is_some();
            assert_eq!(table, support.bodies().contains(&BodyKind::Worktable), "{name}");
            assert_eq!(table, carriers.contains(&Carrier::Worktable), "{name}");
            assert_eq!(table, !support.boxes().is_empty(), "{name}");
            assert_eq!(table, support.radiating_area() > 0.0, "{name}");
        }
    }

    /// The foundation stiffness of a base is its foundation modulus times its area.
    #[test]
    fn a_rigid_workpiece_on_its_contact_cells_is_the_lumped_spring() {
        let mut compared = 0;
        for design in designs() {
            let (support, name) = (of(&design), design.support.kind.as_str());
            // The lumped spring of a table is that of the table, not of the contact on it.
            if support.table().unwrap().is_some() {
                continue;
            }
            let lumped = support.lumped().unwrap();
            for contact in support.contacts().unwrap() {
                let springs = contact.springs();
                let stiffness: f64 = springs.iter().map(|spring| spring.stiffness).sum();
                assert!((stiffness / lumped.stiffness - 1.0).abs() < 1e-12, "{name}");
                let damping: f64 = springs.iter().map(|spring| spring.damping).sum();
                let dynamics::SupportDamping::Coefficient(coefficient) = lumped.damping else {
                    panic!("{name} has no dashpot");
                };
                assert!((damping / coefficient - 1.0).abs() < 1e-12, "{name}");
                compared += 1;
            }
        }
        assert_eq!(compared, 2);
    }

    #[test]
    fn a_body_on_springs_without_stiffness_is_refused() {
        for (kind, body) in [
            (SupportKind::Springs, Sprung::Workpiece),
            (SupportKind::Worktable, Sprung::Worktable),
        ] {
            let mut design = Design::shipped("n80cb.toml").unwrap();
            design.springs.clear();
            design.support.kind = kind;
            design.support.worktable.foot = TableFoot::Springs;
            let conflict = of(&design).check().unwrap_err();
            assert!(matches!(conflict, Conflict::NotCarried { body: found, .. } if found == body));
        }
    }
}

//! Inputs of the notes: the support in words.

use super::radiation::workpiece_floor;
use crate::design::{Design, SupportKind};

/// What supports the workpiece.
pub(crate) fn support(design: &Design) -> String {
    let support = &design.support;
    match support.kind {
        SupportKind::Worktable => format!("workpiece on worktable {}", support.worktable.preset.as_str()),
        SupportKind::Sandbox => "workpiece in sand".to_owned(),
        SupportKind::Floor => "workpiece alone on a rigid floor, its underside silent".to_owned(),
        SupportKind::Clamped => "workpiece alone, its underside held on a rigid floor".to_owned(),
        SupportKind::Springs if support.clearance > 0.0 => format!(
            "workpiece alone on its springs, its underside {:.3} m above the floor{}",
            support.clearance,
            if workpiece_floor(design).is_some() {
                ""
            } else {
                ", which is left out of its power"
            }
        ),
        SupportKind::Springs => "workpiece alone on its springs and the floor, its underside silent".to_owned(),
    }
}

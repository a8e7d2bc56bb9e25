//! Inputs of the notes: support and values outside their ranges, in words.

use super::radiation::workpiece_floor;
use crate::design::{Design, SupportKind, Warning};

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

/// Values outside the ranges that the design gives.
pub(crate) fn outside_ranges(design: &Design) -> Vec<String> {
    let warnings = design.warnings().iter();
    let outside = warnings.filter(|warning| matches!(warning, Warning::OutsideRange { .. }));
    outside.map(ToString::to_string).collect()
}

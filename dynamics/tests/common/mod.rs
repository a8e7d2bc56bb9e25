//! Parameters of the base design, read from its file.

#[path = "../../../tests/common/base_design.rs"]
mod base_design;

use nailnoise_dynamics::{Parameters, Support, SupportDamping};
use nailnoise_quantities::dimension::{NUMBER, STIFFNESS};
use nailnoise_quantities::{fraction, nonnegative, positive};

use base_design::group;
pub(crate) use base_design::number;

/// The cycle's parameters of `designs/n80cb.toml`.
pub(crate) fn n80cb() -> Parameters {
    Parameters {
        supply: group("supply"),
        piston: group("piston"),
        head_valve: group("head_valve"),
        chambers: group("chambers"),
        exhaust: group("exhaust"),
        muffler_area: None,
        trigger: group("trigger"),
        nail: group("nail"),
        wood: group("wood"),
        friction_share: number("wood.friction_share", fraction()),
        penetration_table: None,
        penetration_fit: None,
        workpiece: group("workpiece"),
        contacts: group("contacts"),
        tool: group("tool"),
        hand: group("hand"),
        support: Support {
            stiffness: number("support.worktable.stiffness", positive(STIFFNESS)),
            damping: SupportDamping::Ratio(number("support.worktable.damping_ratio", nonnegative(NUMBER))),
        },
        ambient: group("ambient"),
        model: group("model"),
    }
}

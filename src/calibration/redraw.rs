//! Classes of inputs that a calibrated design draws anew, because later shots use another board, other nails or another
//! support than those that were measured.

/// Largest rank correlation of a redrawn input with one that is kept, beyond which redrawing widens predictions.
const INDEPENDENT: f64 = 0.3;

/// Keys of the group `wood` that belong to the penetration law, not to a board.
const OF_LAW: [&str; 7] = [
    "wood.speed_term",
    "wood.slenderness_term",
    "wood.resistance_scale",
    "wood.head_stiffness_scale",
    "wood.unloading_stiffness",
    "wood.friction_share",
    "wood.penetration_force",
];

/// Keys of the group `nail` that belong to the tool or to the shot.
const OF_TOOL: [&str; 4] = [
    "nail.feed_height",
    "nail.magazine_friction",
    "nail.offset_along",
    "nail.offset_across",
];

/// A class of inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Redrawn {
    /// The board: its wood and its dimensions, without the penetration law
    Board,
    /// The nails
    Nails,
    /// The support
    Support,
}

impl Redrawn {
    /// All classes, by name.
    pub const ALL: [(&'static str, Self); 3] = [
        ("board", Self::Board),
        ("nails", Self::Nails),
        ("support", Self::Support),
    ];

    /// Whether a key is in the class.
    pub(super) fn contains(self, key: &str) -> bool {
        match self {
            Self::Board => (key.starts_with("wood.") && !OF_LAW.contains(&key)) || key.starts_with("workpiece."),
            Self::Nails => key.starts_with("nail.") && !OF_TOOL.contains(&key),
            Self::Support => key.starts_with("support."),
        }
    }
}

/// Whether a key is in one of some classes.
pub(super) fn is_redrawn(classes: &[Redrawn], key: &str) -> bool {
    classes.iter().any(|class| class.contains(key))
}

/// A note on redrawn inputs that the measurements determined only together with others, if there are any. `pairs` are
/// inputs with their rank correlation.
pub(super) fn note<'p>(classes: &[Redrawn], pairs: impl Iterator<Item = (&'p [String; 2], f64)>) -> Option<String> {
    let split = pairs.filter(|(_, correlation)| correlation.abs() > INDEPENDENT);
    let split = split.filter_map(|([a, b], _)| match [a, b].map(|key| is_redrawn(classes, key)) {
        [true, false] => Some(format!("{a} with {b}")),
        [false, true] => Some(format!("{b} with {a}")),
        _ => None,
    });
    let split: Vec<String> = split.collect();
    (!split.is_empty()).then(|| {
        format!(
            "the measurements determine some redrawn inputs only together with others ({}): predictions for another \
             board, nail or support are too wide unless these inputs are measured and given under [direct]",
            split.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_penetration_law_is_not_part_of_a_board_and_the_feed_not_of_the_nails() {
        for (key, class) in [
            ("wood.density", Some(Redrawn::Board)),
            ("workpiece.thickness", Some(Redrawn::Board)),
            ("wood.resistance_scale", None),
            ("nail.diameter", Some(Redrawn::Nails)),
            ("nail.feed_height", None),
            ("support.worktable.loss_factor", Some(Redrawn::Support)),
            ("piston.mass", None),
            ("method.exhaust", None),
        ] {
            let found = Redrawn::ALL.into_iter().find(|(_, class)| class.contains(key));
            assert_eq!(found.map(|(_, class)| class), class, "{key}");
        }
    }

    #[test]
    fn inputs_that_are_determined_only_together_are_named() {
        let pair = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        let inputs = [
            pair("wood.resistance_scale", "wood.hardness_modulus"),
            pair("wood.density", "piston.mass"),
            pair("wood.density", "wood.hardness_modulus"),
        ];
        let of = |class| note(&[class], inputs.iter().zip([-0.6, 0.2, 0.9]));
        let text = of(Redrawn::Board).unwrap_or_default();
        assert!(
            text.contains("(wood.hardness_modulus with wood.resistance_scale)"),
            "{text}"
        );
        assert_eq!(of(Redrawn::Support), None);
    }
}

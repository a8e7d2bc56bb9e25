//! Keys of earlier versions and their successors; this table is used both to read and to rewrite files.

use std::borrow::Cow;
use std::ops::Range;

use nailnoise_quantities::dotted;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A renamed key; the group is the same.
struct Rename {
    old: &'static str,
    new: &'static str,
}

/// A key of an earlier version without a successor of the same meaning.
struct Replaced {
    old: &'static str,
    /// What to write instead.
    successors: &'static str,
}

macro_rules! renames {
    ($($old:literal => $new:literal,)+) => {
        &[$(Rename { old: $old, new: $new }),+]
    };
}

const RENAMED: &[Rename] = renames! {
    "exhaust.muffler.octaves.hz_63" => "exhaust.muffler.octaves.63",
    "exhaust.muffler.octaves.hz_125" => "exhaust.muffler.octaves.125",
    "exhaust.muffler.octaves.hz_250" => "exhaust.muffler.octaves.250",
    "exhaust.muffler.octaves.hz_500" => "exhaust.muffler.octaves.500",
    "exhaust.muffler.octaves.hz_1000" => "exhaust.muffler.octaves.1000",
    "exhaust.muffler.octaves.hz_2000" => "exhaust.muffler.octaves.2000",
    "exhaust.muffler.octaves.hz_4000" => "exhaust.muffler.octaves.4000",
    "exhaust.muffler.octaves.hz_8000" => "exhaust.muffler.octaves.8000",
    "exhaust.muffler.octaves.hz_16000" => "exhaust.muffler.octaves.16000",
    "support.sand.moving_surface_top" => "support.sand.moving_surface_max_frequency",
    "acoustics.bem_top" => "acoustics.bem_max_frequency",
    "acoustics.bem_mean_top" => "acoustics.bem_mean_max_frequency",
    "analysis.workpiece_top" => "analysis.workpiece_max_frequency",
    "analysis.worktable_top" => "analysis.worktable_max_frequency",
    "analysis.body_top" => "analysis.body_max_frequency",
    "analysis.exhaust_top" => "analysis.exhaust_max_frequency",
};

const REPLACED: &[Replaced] = &[
    Replaced {
        old: "acoustics.radiation_damping",
        successors: "`acoustics.fluid_loading`, \"damping\" where it was true and \"none\" where it was false; \
            \"full\" adds the mass of air that moves along",
    },
    Replaced {
        old: "nail.head_gap",
        successors: "`nail.feed_height`, the height of the waiting nail's head above the nose's face, and \
            `piston.rod_protrusion`, the length of the rod beyond it on the bumper; the travel to the head is stroke - \
            protrusion - feed height",
    },
    Replaced {
        old: "nail.tip_gap",
        successors: "`piston.rod_protrusion`, the length of the rod beyond the nose's face with the piston on the \
            bumper; the travel until the tip reaches the wood is stroke - protrusion - `nail.length`",
    },
    Replaced {
        old: "support.worktable.steel",
        successors: "the keys of `support.worktable` with `preset` \"B\" or \"C\": `top_thickness` for \
            `top_thickness_b` and `top_thickness_c`, `leg_width` for `tube_width`, `leg_wall` for `tube_wall`, \
            `loss_factor`, and `metal` for `material`",
    },
];

/// All renamed keys: the earlier and the current name.
pub(crate) fn renames() -> impl Iterator<Item = (&'static str, &'static str)> {
    RENAMED.iter().map(|rename| (rename.old, rename.new))
}

/// The current name of a key, if it is one of an earlier version.
pub(crate) fn successor(key: &str) -> Option<&'static str> {
    RENAMED.iter().find(|rename| rename.old == key).map(|rename| rename.new)
}

/// The current name of any key.
pub(crate) fn current(key: &str) -> &str {
    successor(key).unwrap_or(key)
}

/// What to write in place of a key or group of an earlier version that has no single successor.
pub(crate) fn successors(key: &str) -> Option<&'static str> {
    let replaced = REPLACED.iter().find(|replaced| replaced.old == key);
    replaced.map(|replaced| replaced.successors)
}

/// A key of an earlier version in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OldKey {
    /// Its full name.
    pub(crate) key: String,
    /// Byte range of its name in the text, including quotes.
    pub(crate) span: Range<usize>,
    /// Its current name; `None` if it has to be replaced by hand.
    pub(crate) new: Option<&'static str>,
}

impl OldKey {
    /// The text of its current name, to replace the old text; `None` if it has to be replaced by hand.
    pub(crate) fn replacement(&self, old: &str) -> Option<String> {
        let new = self.new?;
        let plain = old.trim_matches(['"', '\'']);
        let name = match plain.contains('.') {
            true => new,
            false => new.rsplit('.').next().unwrap_or(new),
        };
        Some(if plain == old {
            name.to_owned()
        } else {
            format!("\"{name}\"")
        })
    }
}

type Key<'i> = Spanned<Cow<'i, str>>;

/// The keys of earlier versions in the `table` of a file, including those named in `[study]`, in file order.
pub(crate) fn old_keys(table: &DeTable<'_>) -> Vec<OldKey> {
    let mut found = Vec::new();
    collect(table, "", &mut found);
    found.sort_by_key(|old| old.span.start);
    found
}

fn collect(table: &DeTable<'_>, path: &str, found: &mut Vec<OldKey>) {
    for (key, value) in table {
        let full = dotted(path, key.get_ref());
        match (full.as_str(), value.get_ref()) {
            ("study.alternatives", DeValue::Table(alternatives)) => in_alternatives(alternatives, found),
            ("study.correlation", DeValue::Array(correlations)) => in_correlations(correlations, found),
            _ => {
                note(&full, key.span(), found);
                if let DeValue::Table(inner) = value.get_ref() {
                    collect(inner, &full, found);
                }
            }
        }
    }
}

fn in_alternatives(alternatives: &DeTable<'_>, found: &mut Vec<OldKey>) {
    for (name, options) in alternatives {
        let name: &Key<'_> = name;
        note(name.get_ref(), name.span(), found);
        let options = options.get_ref().as_array().into_iter().flatten();
        for option in options.filter_map(|option| option.get_ref().as_table()) {
            collect(option, name.get_ref(), found);
        }
    }
}

fn in_correlations(correlations: &[Spanned<DeValue<'_>>], found: &mut Vec<OldKey>) {
    let tables = correlations.iter().filter_map(|one| one.get_ref().as_table());
    let keys = tables.filter_map(|table| table.get("keys")?.get_ref().as_array());
    for key in keys.flatten() {
        if let Some(name) = key.get_ref().as_str() {
            note(name, key.span(), found);
        }
    }
}

fn note(key: &str, span: Range<usize>, found: &mut Vec<OldKey>) {
    let new = successor(key);
    if new.is_some() || successors(key).is_some() {
        found.push(OldKey {
            key: key.to_owned(),
            span,
            new,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_quantities::Group as _;

    #[test]
    fn every_successor_is_a_key_and_no_old_name_is_one() {
        let mut keys = Vec::new();
        crate::design::Values::SPEC.each_key("", &mut |key, _| keys.push(key.to_owned()));
        let is_key = |name: &str| keys.iter().any(|key| key == name);
        for Rename { old, new } in RENAMED {
            assert!(is_key(new) && !is_key(old), "{old} => {new}");
            // A rename in place: the group is the same.
            assert_eq!(
                old.rsplit_once('.').map(|own| own.0),
                new.rsplit_once('.').map(|own| own.0)
            );
        }
        for Replaced { old, .. } in REPLACED {
            assert!(!is_key(old), "{old}");
        }
    }
}

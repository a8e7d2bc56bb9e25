//! The known name that is most like an unknown one.

use nailnoise_quantities::{GroupSpec, dotted};

/// Edits that still count as a slip of the finger, for a name of this length.
fn tolerance(name: &str) -> usize {
    (name.chars().count() / 4).clamp(1, 3)
}

/// The word most like `name`, if any is near.
pub(crate) fn word<'a>(words: impl Iterator<Item = &'a str>, name: &str) -> Option<&'a str> {
    let name = name.to_lowercase();
    words
        .map(|word| (strsim::damerau_levenshtein(word, &name), word))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, _)| *edits <= tolerance(&name))
        .map(|(_, word)| word)
}

/// The key most like `full`: the same name in another group, or a slip within the full name or only within its last
/// part.
pub(crate) fn key(root: &'static GroupSpec, full: &str) -> Option<String> {
    let mut keys = Vec::new();
    root.each_key("", &mut |name, _| keys.push(name.to_owned()));
    nearest(&keys, full)
}

/// The group most like `full`.
pub(crate) fn group(root: &'static GroupSpec, full: &str) -> Option<String> {
    let mut groups = Vec::new();
    collect(root, "", &mut groups);
    nearest(&groups, full)
}

fn collect(group: &'static GroupSpec, path: &str, names: &mut Vec<String>) {
    for (name, inner) in group.groups {
        let name = dotted(path, name);
        collect(inner, &name, names);
        names.push(name);
    }
}

fn nearest(names: &[String], full: &str) -> Option<String> {
    let last = |name: &str| name.rsplit('.').next().unwrap_or(name).to_owned();
    let own = last(full);
    if let Some(near) = word(names.iter().map(String::as_str), full) {
        return Some(near.to_owned());
    }
    if let Some(same) = names.iter().find(|name| last(name) == own) {
        return Some(same.clone());
    }
    // A slip only in the last part counts only within the same group, where it cannot mean anything else.
    let group = full.strip_suffix(&own).unwrap_or("");
    let beside = names
        .iter()
        .filter(|name| name.strip_suffix(last(name).as_str()) == Some(group));
    let lasts: Vec<String> = beside.map(|name| last(name)).collect();
    let near = word(lasts.iter().map(String::as_str), &own)?;
    Some(format!("{group}{near}"))
}

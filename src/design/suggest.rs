//! Finds the known name that is most similar to an unknown one.

use nailnoise_documents::nearest as nearest_word;
use nailnoise_quantities::{GroupSpec, dotted};

/// The key most similar to `full`: the same name in another group, or a typing error in the full name or only in its
/// last part.
pub(crate) fn key(root: &'static GroupSpec, full: &str) -> Option<String> {
    let mut keys = Vec::new();
    root.each_key("", &mut |name, _| keys.push(name.to_owned()));
    nearest(&keys, full)
}

/// The group most similar to `full`.
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
    if let Some(near) = nearest_word(names.iter().map(String::as_str), full) {
        return Some(near.to_owned());
    }
    if let Some(same) = names.iter().find(|name| last(name) == own) {
        return Some(same.clone());
    }
    // A typing error in the last part counts only within the same group, because it is unambiguous there.
    let group = full.strip_suffix(&own).unwrap_or("");
    let beside = names
        .iter()
        .filter(|name| name.strip_suffix(last(name).as_str()) == Some(group));
    let lasts: Vec<String> = beside.map(|name| last(name)).collect();
    let near = nearest_word(lasts.iter().map(String::as_str), &own)?;
    Some(format!("{group}{near}"))
}

//! The files that a design depends on, for code that waits for changes.

use std::path::{Path, PathBuf};

use nailnoise_quantities::{Group, Kind};
use toml::de::{DeTable, DeValue};

use super::Values;
use super::assignment::Assignment;
use super::source::File;

/// The files that a design reads: its own, its bases, and those named by its keys and by the assignments. Files that do
/// not exist are included. If a file is not a design, its bases and files are unknown.
pub fn dependencies(path: &Path, assignments: &[Assignment]) -> Vec<PathBuf> {
    let mut keys = Vec::new();
    Values::SPEC.each_key("", &mut |key, spec| {
        if matches!(spec.kind, Kind::File) {
            keys.push(key.to_owned());
        }
    });
    let mut found = vec![path.to_owned()];
    let add = |file: &File, found: &mut Vec<PathBuf>| {
        let Ok(table) = file.table() else { return };
        let named = keys.iter().filter_map(|key| text(&table, key));
        let paths = named.filter(|name| !name.is_empty()).map(|name| file.beside(name));
        found.extend(paths);
    };
    for assignment in assignments {
        add(&assignment.file(), &mut found);
    }
    let mut next = Some(path.to_owned());
    let mut read = Vec::new();
    while let Some(path) = next.take().filter(|path| !read.contains(path)) {
        read.push(path.clone());
        let Ok(file) = File::read(&path, None) else { break };
        add(&file, &mut found);
        next = file.base_file();
        found.extend(next.clone());
    }
    found.sort();
    found.dedup();
    found
}

/// The text of a key of a table, given directly or as the value of a table with provenance.
fn text<'t>(table: &'t DeTable<'_>, key: &str) -> Option<&'t str> {
    let (groups, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = table;
    for group in groups.split('.').filter(|group| !group.is_empty()) {
        table = table.get(group)?.get_ref().as_table()?;
    }
    match table.get(name)?.get_ref() {
        DeValue::Table(inner) => inner.get("value")?.get_ref().as_str(),
        value => value.as_str(),
    }
}

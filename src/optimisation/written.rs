//! Writes designs that were found as files based on the design from which the search started.

use std::path::{Component, Path, PathBuf};

use super::search::Optimisation;
use super::trial::Trial;
use crate::design::{Assignment, Design, Value};
use crate::error::Error;

/// The text of such a design as a file in `folder`: its base by a relative path, values set on the command line, and
/// values found by the search.
///
/// # Errors
/// If values cannot be assigned.
pub fn design_over(
    found: &Optimisation,
    trial: &Trial,
    (path, changes): (&Path, &[Assignment]),
    folder: &Path,
) -> Result<String, Error> {
    let own = found.variables.iter().zip(&trial.values);
    let own = own
        .map(|(variable, value)| variable.assign(value))
        .collect::<Result<Vec<_>, _>>()?;
    let design = Design::load_with(path, &[changes, &own].concat())?;
    let base = relative(folder, path);
    let mut text = format!("base = {}\n\n", toml::Value::String(base));
    let all: Vec<&Assignment> = changes.iter().chain(&own).collect();
    for (place, assignment) in all.iter().enumerate() {
        // The last assignment of a key takes precedence.
        if all[place + 1..].iter().any(|later| later.key() == assignment.key()) {
            continue;
        }
        let entries = design.entries();
        let entry = entries.iter().find(|entry| entry.key == assignment.key());
        match entry.map(|entry| &entry.value) {
            // A file name on the command line is relative to the working folder; in a design, it is relative to the
            // folder of the design.
            Some(Value::File(file)) if !file.is_empty() => {
                let file = toml::Value::String(relative(folder, Path::new(file)));
                text.push_str(&format!("{} = {file}\n", assignment.key()));
            }
            _ => text.push_str(&format!("{}\n", assignment.file_line())),
        }
    }
    Ok(text)
}

/// The path of a file relative to a folder, with slashes; the absolute path if no relative path exists.
fn relative(folder: &Path, file: &Path) -> String {
    let absolute = |path: &Path| {
        path.canonicalize()
            .or_else(|_| std::path::absolute(path))
            .unwrap_or_else(|_| path.into())
    };
    let (from, to) = (absolute(folder), absolute(file));
    let [from_parts, to_parts]: [Vec<Component<'_>>; 2] = [&from, &to].map(|path| path.components().collect());
    let common = from_parts.iter().zip(&to_parts).take_while(|(a, b)| a == b).count();
    // There is no relative path to another drive.
    if common == 0 {
        return to.display().to_string();
    }
    let up = from_parts[common..].iter().map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(to_parts[common..].iter().copied()).collect();
    let names: Vec<String> = path.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    names.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_relative_path_of_a_file_starts_at_the_folder() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let from = |folder: &str| relative(&root.join(folder), &root.join("designs/n80cb.toml"));
        assert_eq!(from("designs"), "n80cb.toml");
        assert_eq!(from("out/n80cb/optimised"), "../../../designs/n80cb.toml");
    }
}

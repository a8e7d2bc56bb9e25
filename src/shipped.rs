//! Designs and measurements that come with the program. They are compiled into it, so that it needs no other files
//! wherever it is installed.

/// Files of the folder `designs`, by their paths, with their content.
macro_rules! files {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../designs/", $path)))),*]
    };
}

/// Every design, by its path in the folder `designs`.
pub const DESIGNS: &[(&str, &str)] = files![
    "n80cb.toml",
    "n80cb-sandbox.toml",
    "n80cb-board.toml",
    "n80cb-feet.toml",
    "n80cb-free.toml",
    "n80cb-as-tested.toml",
    "n80cb-as-tested-sandbox.toml",
    "n80cb-as-tested-sandbox-floor.toml",
    "n80cb-as-filmed.toml",
    "site/held-board.toml",
    "site/joists.toml",
    "site/sawhorses.toml",
    "site/studs.toml",
    "quieter/as-it-is.toml",
    "quieter/on-worktable.toml",
    "quieter/muffler.toml",
    "quieter/muffler-on-worktable.toml",
    "quieter/small-holes.toml",
    "quieter/foam.toml",
    "quieter/expansion-chamber.toml",
    "tools/stapler.toml",
    "tools/gas-spring-nailer.toml",
    "tools/blow-gun.toml",
    "tools/n80cb-as-published.toml",
    "tools/impact-rig.toml",
];

/// Designs of [`DESIGNS`] without a study among [`STUDIES`]: those that have their own assembly.
pub const WITHOUT_STUDY: &[&str] = &[
    "quieter/expansion-chamber.toml",
    "tools/stapler.toml",
    "tools/gas-spring-nailer.toml",
    "tools/blow-gun.toml",
    "tools/n80cb-as-published.toml",
    "tools/impact-rig.toml",
];

/// Published measurements, for `compare --measured`.
pub const MEASURED: &[(&str, &str)] = files!["measured/n80cb.json"];

/// Studies of designs, for the intervals of `nailnoise run`: every file of the folder `designs/studies`, which
/// `nailnoise provide` renews. The list is made when the program is built.
pub const STUDIES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/studies.rs"));

/// The design with this name, with or without folder and extension: `n80cb`, `muffler.toml`, `quieter/muffler`.
pub fn design(name: &str) -> Option<(&'static str, &'static str)> {
    find(DESIGNS, name)
}

/// The measurements with this name, which may be written like that of a [`design`].
pub fn measured(name: &str) -> Option<(&'static str, &'static str)> {
    find(MEASURED, name)
}

/// Paths of the designs that have a study.
pub fn studied() -> impl Iterator<Item = &'static str> {
    let paths = DESIGNS.iter().map(|(path, _)| *path);
    paths.filter(|path| !WITHOUT_STUDY.contains(path))
}

/// Names of all designs, as users write them.
pub fn names() -> impl Iterator<Item = &'static str> {
    DESIGNS.iter().map(|(path, _)| stem(path))
}

fn find(files: &[(&'static str, &'static str)], name: &str) -> Option<(&'static str, &'static str)> {
    let has_name = |path: &str| {
        let file = file_name(path);
        [path, stem(path), file, stem(file)].contains(&name)
    };
    files.iter().find(|(path, _)| has_name(path)).copied()
}

/// The last part of a path.
pub fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// A path without its extension.
fn stem(path: &str) -> &str {
    path.rsplit_once('.').map_or(path, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Files under a folder, by their paths in it.
    fn files(folder: &Path, within: &str) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder of the repository");
        let each = entries.flatten().flat_map(|entry| {
            let name = format!("{within}{}", entry.file_name().to_string_lossy());
            match entry.path().is_dir() {
                true => files(&entry.path(), &format!("{name}/")),
                false => vec![name],
            }
        });
        each.collect()
    }

    #[test]
    fn every_file_of_the_folder_is_in_the_program() {
        let mut found = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("designs"), "");
        let mut own: Vec<&str> = DESIGNS
            .iter()
            .chain(MEASURED)
            .chain(STUDIES)
            .map(|(path, _)| *path)
            .collect();
        found.sort();
        own.sort_unstable();
        assert_eq!(own, found);
    }

    #[test]
    fn every_design_has_a_study_or_is_listed_without_one() {
        for (path, _) in DESIGNS {
            let study = format!("studies/{}.json", stem(path).replace('/', "-"));
            let has_study = STUDIES.iter().any(|(own, _)| *own == study);
            assert_ne!(has_study, WITHOUT_STUDY.contains(path), "{path}");
        }
    }

    #[test]
    fn a_design_has_its_path_and_its_name() {
        for name in ["quieter/muffler.toml", "quieter/muffler", "muffler.toml", "muffler"] {
            assert_eq!(
                design(name).map(|(path, _)| path),
                Some("quieter/muffler.toml"),
                "{name}"
            );
        }
        assert_eq!(design("uffler"), None);
        assert!(measured("n80cb").is_some());
    }
}

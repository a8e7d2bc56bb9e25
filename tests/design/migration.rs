//! Keys of earlier versions: they are read with a warning that names the successor, and a migration renames them.

use std::fs;
use std::path::{Path, PathBuf};

use nailnoise::Design;
use nailnoise::design::{DesignError, Migration, Problem, Value, Warning};

const OLD: &str = r#"# A tool of last year.
base = "n80cb.toml"   # the shipped one

[analysis]
exhaust_top = "12 kHz"       # above the levels
workpiece_top.value = "8 kHz"
[exhaust.muffler]
kind = "insertion_loss"
octaves.hz_1000 = { value = 5, range = "3 .. 7" }
[study.alternatives]
"support.sand.moving_surface_top" = { "1 kHz" = 1, "2 kHz" = 1 }
"exhaust.muffler.octaves" = [{ hz_2000 = 5 }, { hz_2000 = 8, weight = 2 }]
"#;

const NEW: &str = r#"# A tool of last year.
base = "n80cb.toml"   # the shipped one

[analysis]
exhaust_max_frequency = "12 kHz"       # above the levels
workpiece_max_frequency.value = "8 kHz"
[exhaust.muffler]
kind = "insertion_loss"
octaves.1000 = { value = 5, range = "3 .. 7" }
[study.alternatives]
"support.sand.moving_surface_max_frequency" = { "1 kHz" = 1, "2 kHz" = 1 }
"exhaust.muffler.octaves" = [{ 2000 = 5 }, { 2000 = 8, weight = 2 }]
"#;

fn read(text: &str) -> Result<Design, DesignError> {
    Design::parse(text, concat!(env!("CARGO_MANIFEST_DIR"), "/designs/over.toml"))
}

fn written(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("nailnoise-{name}-{}.toml", std::process::id()));
    fs::write(&path, text).unwrap();
    path
}

fn migrated(path: &Path) -> Migration {
    let migration = Migration::of(path).unwrap();
    fs::remove_file(path).unwrap();
    migration
}

#[test]
fn old_keys_are_read_as_their_successors_with_a_warning_each() {
    let (old, new) = (read(OLD).unwrap(), read(NEW).unwrap());
    assert_eq!(old.digest(), new.digest());
    assert_eq!(old.study(), new.study());
    let renamed = |design: &Design| -> Vec<(String, &'static str, usize)> {
        let warnings = design.warnings().iter();
        warnings
            .filter_map(|warning| match warning {
                Warning::Renamed { key, successor, at } => Some((key.clone(), *successor, at.line())),
                _ => None,
            })
            .collect()
    };
    assert!(renamed(&new).is_empty());
    let found = renamed(&old);
    assert_eq!(found.len(), 6, "{found:?}");
    let first = ("analysis.exhaust_top".to_owned(), "analysis.exhaust_max_frequency", 5);
    assert_eq!(found[0], first);
}

#[test]
fn a_program_may_set_an_old_key() {
    let mut design = read(NEW).unwrap();
    design.set(&[("analysis.body_top", Value::Number(5e3))]).unwrap();
    assert_eq!(design.analysis.body_max_frequency, 5e3);
}

#[test]
fn a_migration_renames_the_keys_and_leaves_all_else_as_it_is() {
    let migration = migrated(&written("migrates", OLD));
    assert_eq!(migration.text, NEW);
    assert_eq!(migration.renamed.len(), 6);
    assert_eq!(
        (migration.renamed[0].line, migration.renamed[0].new),
        (5, "analysis.exhaust_max_frequency")
    );
    let again = migrated(&written("migrated", NEW));
    assert!(again.text == NEW && again.renamed.is_empty() && again.by_hand.is_empty());
}

#[test]
fn a_key_without_a_successor_of_the_same_meaning_is_left_and_named() {
    let text = "base = \"n80cb.toml\"\n[support.worktable.steel]\ntube_wall = \"3 mm\"\n";
    let migration = migrated(&written("by-hand", text));
    assert_eq!(migration.text, text);
    let [own] = &migration.by_hand[..] else {
        panic!("{:?}", migration.by_hand)
    };
    assert!(own.line == 2 && own.old == "support.worktable.steel" && own.successors.contains("leg_wall"));
    let error = read(text).unwrap_err();
    assert!(matches!(error.problem, Problem::Replaced { .. }), "{error:?}");
    assert!(error.remedy().contains("leg_wall"), "{}", error.remedy());
}

#[test]
fn octaves_are_a_list_with_one_range_or_one_per_band() {
    let list = |value: &str| read(&format!("base = \"n80cb.toml\"\nexhaust.muffler.octaves = {value}\n"));
    let losses = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let plain = list("[0, 1, 2, 3, 4, 5, 6, 7, 8]").unwrap();
    assert_eq!(plain.exhaust.muffler.octaves[..], losses);
    let ranged =
        list("{ value = [0, 1, 2, 3, 4, 5, 6, 7, 8], range = \"+-2\", provenance = \"estimated: own\" }").unwrap();
    let entries = ranged.entries();
    let entry = |key: &str| entries.iter().find(|entry| entry.key == key).unwrap();
    assert_eq!(entry("exhaust.muffler.octaves.16000").range, Some([6.0, 10.0]));
    assert_eq!(entry("exhaust.muffler.octaves.63").source, "own");
    for wrong in ["[0, 1]", "{ value = [0, 0, 0, 0, 0, 0, 0, 0, 0], range = [0, 1] }"] {
        let error = list(wrong).unwrap_err();
        assert!(
            matches!(&error.problem, Problem::WrongKind { key, .. } if key == "exhaust.muffler.octaves"),
            "{error:?}"
        );
    }
}

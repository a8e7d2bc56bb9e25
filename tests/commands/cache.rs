//! `nailnoise cache`, and what runs do with a cache in disorder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::common::{SMALL, command, folder, json, messages};

fn nailnoise(cache: &Path, arguments: &[&str]) -> Output {
    command(arguments).env("NAILNOISE_CACHE", cache).output().unwrap()
}

/// Modes of the small block, the quickest of what is cached.
fn modes(cache: &Path) -> Output {
    let out = cache.with_file_name("out");
    let arguments = [
        "modes",
        SMALL,
        "--body",
        "workpiece",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = nailnoise(cache, &arguments);
    json(&output);
    output
}

/// A cache that holds entries.
fn filled(name: &str) -> (PathBuf, Vec<PathBuf>) {
    let cache = folder(name).join("cache");
    modes(&cache);
    let mut entries: Vec<PathBuf> = fs::read_dir(&cache)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    assert!(entries.len() >= 2);
    (cache, entries)
}

/// Puts a folder that is not empty, a link to nothing, and a pipe in the places of entries.
fn disorder(entries: &[PathBuf], kind: &str) {
    for entry in entries {
        fs::remove_file(entry).unwrap();
        match kind {
            "a folder" => {
                fs::create_dir(entry).unwrap();
                fs::write(entry.join("file"), "").unwrap();
            }
            #[cfg(unix)]
            "a link to nothing" => std::os::unix::fs::symlink("nowhere", entry).unwrap(),
            _ => {
                let made = std::process::Command::new("mkfifo").arg(entry).status().unwrap();
                assert!(made.success());
            }
        }
    }
}

#[cfg(unix)]
const KINDS: [&str; 3] = ["a folder", "a link to nothing", "a pipe"];
#[cfg(not(unix))]
const KINDS: [&str; 1] = ["a folder"];

#[test]
fn verify_removes_what_has_the_name_of_an_entry() {
    for kind in KINDS {
        let (cache, entries) = filled("cache-verify");
        let mine = cache.join("notes.txt");
        fs::write(&mine, "mine").unwrap();
        disorder(&entries[..1], kind);
        let output = nailnoise(&cache, &["cache", "verify", "--json"]);
        let told = messages(&output);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains(&format!("is {kind}")), "{kind}: {told}");
        let counts: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (&counts["sound"], &counts["removed"]),
            (&(entries.len() - 1).into(), &1.into())
        );
        assert!(entries[0].symlink_metadata().is_err() && mine.exists());
        assert_eq!(nailnoise(&cache, &["cache", "verify"]).status.code(), Some(0));
    }
}

#[test]
fn clear_removes_what_has_the_name_of_an_entry() {
    for kind in KINDS {
        let (cache, entries) = filled("cache-clear");
        disorder(&entries[..1], kind);
        let output = nailnoise(&cache, &["cache", "clear"]);
        assert_eq!(output.status.code(), Some(0));
        assert!(
            messages(&output).contains(&format!("is {kind}")),
            "{}",
            messages(&output)
        );
        assert_eq!(fs::read_dir(&cache).unwrap().count(), 0);
    }
}

#[test]
fn disorder_in_the_cache_neither_stops_nor_changes_a_run() {
    for kind in KINDS {
        let (cache, entries) = filled("cache-disorder");
        let expected = modes(&cache).stdout;
        disorder(&entries, kind);
        assert_eq!(modes(&cache).stdout, expected, "{kind}");
        // Once more with what the last run could keep.
        assert_eq!(modes(&cache).stdout, expected, "{kind}");
    }
}

#[test]
fn a_folder_in_place_of_an_entry_is_reported_with_its_remedy() {
    let (cache, entries) = filled("cache-folder");
    disorder(&entries, "a folder");
    let told = messages(&modes(&cache));
    assert!(
        told.contains("is a folder") && told.contains("`nailnoise cache verify`"),
        "{told}"
    );
}

/// The kernel's own folder takes no files, like a file system that is mounted for reading.
#[test]
#[cfg(target_os = "linux")]
fn a_cache_that_cannot_be_written_is_one_note() {
    let out = folder("cache-unwritable");
    let arguments = ["modes", SMALL, "--body", "workpiece", "--out", out.to_str().unwrap()];
    let output = nailnoise(Path::new("/proc/nailnoise"), &arguments);
    let told = messages(&output);
    assert!(output.status.success(), "{told}");
    assert_eq!(told.matches("cannot be kept").count(), 1, "{told}");
}

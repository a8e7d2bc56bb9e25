//! `nailnoise cache`, and the behaviour of runs with a cache in disorder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::common::{SMALL, command, folder, json, messages};

fn nailnoise(cache: &Path, arguments: &[&str]) -> Output {
    command(arguments).env("NAILNOISE_CACHE", cache).output().unwrap()
}

/// Modes of the small block, the quickest of the cached results.
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

/// A cache with entries.
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

/// Names that end like those of entries, and the name of an entry itself: the content decides.
#[test]
fn clear_and_verify_leave_files_of_others() {
    let (cache, entries) = filled("cache-others");
    let foreign = cache.join(format!("own-{}.entry", "0".repeat(64)));
    let mine = ["notes.entry", "a-1.entry", ".entry"].map(|name| cache.join(name));
    for path in mine.iter().chain([&foreign]) {
        fs::write(path, "mine").unwrap();
    }
    let verified = nailnoise(&cache, &["cache", "verify", "--json"]);
    let counts: serde_json::Value = serde_json::from_slice(&verified.stdout).unwrap();
    assert_eq!(
        (&counts["sound"], &counts["removed"]),
        (&entries.len().into(), &0.into())
    );
    let cleared = nailnoise(&cache, &["cache", "clear"]);
    for output in [&verified, &cleared] {
        assert!(
            messages(output).contains("nailnoise did not write it"),
            "{}",
            messages(output)
        );
    }
    for path in mine.iter().chain([&foreign]) {
        assert_eq!(fs::read_to_string(path).unwrap(), "mine");
    }
    assert_eq!(fs::read_dir(&cache).unwrap().count(), 4, "all entries are gone");
}

/// The command with this cache, or with none by an environment without folders, must end: nothing else is waited for.
#[cfg(unix)]
fn modes_with(name: &str, change: impl FnOnce(&mut std::process::Command)) -> Output {
    let out = folder(name);
    let mut command = command(&[
        "modes",
        SMALL,
        "--body",
        "workpiece",
        "--quiet",
        "--out",
        out.to_str().unwrap(),
    ]);
    change(&mut command);
    command.output().unwrap()
}

#[test]
#[cfg(unix)]
fn a_cache_that_is_no_folder_is_a_warning_and_a_store_that_is_none_an_error() {
    use std::os::unix::fs::symlink;
    let place = folder("cache-no-folder");
    let [file, dangling, endless, pipe] = ["file", "dangling", "endless", "pipe"].map(|name| place.join(name));
    fs::write(&file, "mine").unwrap();
    symlink("/nope/nothing", &dangling).unwrap();
    symlink(&endless, &endless).unwrap();
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let device = PathBuf::from("/dev/null");
    let cases = [
        (&device, "is a pipe or a device"),
        (&file, "is a file"),
        (&dangling, "is a link to nothing"),
        (&endless, "cannot be used"),
        (&pipe, "is a pipe or a device"),
        (&file.join("below"), "cannot be used"),
    ];
    for (cache, words) in cases {
        let output = modes_with("cache-no-folder-out", |command| {
            command.env("NAILNOISE_CACHE", cache);
        });
        let printed = messages(&output);
        // Wrapped lines of a message have a bar in front.
        let words_of = printed.split_whitespace().filter(|word| *word != "|");
        let told = words_of.collect::<Vec<_>>().join(" ");
        assert!(output.status.success(), "{}: {told}", cache.display());
        assert_eq!(told.matches("not cached").count(), 1, "{told}");
        assert!(told.contains(words), "{told}");
        let listed = nailnoise(cache, &["cache"]);
        assert_eq!(listed.status.code(), Some(2), "{}", messages(&listed));
        let store = cache.to_str().unwrap();
        for arguments in [
            &["study", SMALL, "-n", "4", "--store", store][..],
            &["sweep", SMALL, "--vary", "exhaust.holes=3,5", "--store", store],
        ] {
            let output = command(arguments).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{}", messages(&output));
        }
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[test]
#[cfg(unix)]
fn without_a_home_a_run_goes_on_without_a_cache_and_says_so_once() {
    let output = modes_with("cache-no-home", |command| {
        for name in ["HOME", "XDG_CACHE_HOME", "NAILNOISE_CACHE"] {
            command.env_remove(name);
        }
    });
    let told = messages(&output);
    assert!(output.status.success(), "{told}");
    assert_eq!(told.matches("not cached").count(), 1, "{told}");
}

/// An object that is not a file under the name of a claim has no owner, and a file without renewal is taken over:
/// neither stops a run.
#[test]
#[cfg(unix)]
fn a_claim_that_is_no_claim_is_not_waited_for() {
    for kind in KINDS {
        let (cache, entries) = filled("cache-claims");
        let expected = modes(&cache).stdout;
        let claims: Vec<PathBuf> = entries
            .iter()
            .map(|entry| cache.join(format!(".{}.claim.tmp", entry.file_name().unwrap().to_str().unwrap())))
            .collect();
        claims.iter().for_each(|claim| fs::write(claim, "").unwrap());
        disorder(&claims, kind);
        entries.iter().for_each(|entry| fs::remove_file(entry).unwrap());
        let output = modes(&cache);
        assert_eq!(output.stdout, expected, "{kind}");
        assert_eq!(
            messages(&output).matches("not the claim of a process").count(),
            1,
            "{}",
            messages(&output)
        );
    }
}

#[test]
fn disorder_in_the_cache_neither_stops_nor_changes_a_run() {
    for kind in KINDS {
        let (cache, entries) = filled("cache-disorder");
        let expected = modes(&cache).stdout;
        disorder(&entries, kind);
        assert_eq!(modes(&cache).stdout, expected, "{kind}");
        // Once more with the results that the last run could store.
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

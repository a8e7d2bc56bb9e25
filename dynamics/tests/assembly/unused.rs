//! Blocks and keys that nothing names.

use std::path::{Path, PathBuf};

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, BUILT_IN};

/// Path, file and line of each unused block of some files.
fn unused(files: &[(&str, &str)]) -> Vec<(String, String, usize)> {
    let documents: Vec<Document> = files
        .iter()
        .map(|(name, text)| Document::new(Path::new(name), text))
        .collect();
    let text = AssemblyText::open_files(&documents).unwrap_or_else(|error| panic!("{error}"));
    let found = text.unused().into_iter();
    found
        .map(|own| (own.path, own.at.file().to_owned(), own.at.line()))
        .collect()
}

fn at(path: &str, file: &str, line: usize) -> (String, String, usize) {
    (path.to_owned(), file.to_owned(), line)
}

#[test]
fn blocks_and_keys_that_nothing_names_are_found() {
    let own = r#"[keys.own]
used = { domain = "1 .. 10 mm" }
idle = { domain = "1 .. 10 mm", text = "own.idle is named here only" }
[own]
used = "2 mm"
idle = "3 mm"
[cycle]
assembly = "blow_gun"
[cycle.let]
taken = "=disc(own.used)"
spare = "=2*taken"
[cycle.trigger]
pressed = { starts = true }
followed = { starts = true }
[cycle.reservoir]
tank = { pressure = "8 bar", temperature = "20 degC" }
[cycle.passage.nozzle]
open = { when = "followed" }
[cycle.sensor]
pressure = { is = "gun.pressure", unit = "Pa" }
"#;
    let expected = [
        at("cycle.reservoir.tank", "own.toml", 16),
        at("cycle.trigger.pressed", "own.toml", 13),
        at("cycle.let.spare", "own.toml", 11),
        at("keys.own.idle", "own.toml", 3),
    ];
    assert_eq!(unused(&[("own.toml", own)]), expected);
}

/// A user who removes the passage from the hose is not told that the base's hose is idle.
#[test]
fn a_block_whose_user_a_nearer_file_removes_is_not_reported() {
    let own = "[cycle]\nassembly = \"n80cb\"\n[cycle.passage]\nrefill = false\n";
    assert_eq!(unused(&[("own.toml", own)]), []);
    let base = "[cycle]\nassembly = \"blow_gun\"\n[cycle.trigger]\nlever = { starts = true }\n\
                [cycle.passage.nozzle]\nopen = { when = \"lever\" }\n";
    let own = "[cycle.passage]\nnozzle = { replace = true, between = [\"gun\", \"atmosphere\"], area = \"3 mm2\" }\n";
    assert_eq!(unused(&[("base.toml", base), ("own.toml", own)]), []);
}

#[test]
fn the_remedy_says_how_a_block_is_named() {
    let own = "[cycle]\nassembly = \"blow_gun\"\n[cycle.trigger]\nlever = { starts = true }\n";
    let text = AssemblyText::open(&Document::new(Path::new("own.toml"), own)).unwrap();
    let [lever] = &text.unused()[..] else {
        panic!("one is unused")
    };
    assert_eq!(
        lever.to_string(),
        "`cycle.trigger.lever` has no effect: nothing names it"
    );
    assert!(lever.help().contains("open = { when = \"lever\" }"), "{}", lever.help());
}

#[test]
fn every_block_of_the_shipped_assemblies_and_designs_is_used() {
    for (name, _) in BUILT_IN {
        let text = AssemblyText::built_in(name).unwrap().unwrap();
        assert_eq!(text.unused(), [], "{name}");
    }
    let mut folders = vec![PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs")];
    let mut read = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "toml") {
                let document = Document::from_bytes(&path, std::fs::read(&path).unwrap()).unwrap();
                let text = AssemblyText::open_design(&[document]).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(text.unused(), [], "{}", path.display());
                read += 1;
            }
        }
    }
    assert!(read > 20, "{read} designs");
}

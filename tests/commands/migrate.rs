//! `nailnoise migrate` lists the old keys of a file and renames them; a second run finds none.

use std::fs;

use crate::common::{command, folder, json, messages};

#[test]
fn a_file_is_rewritten_once_and_then_has_no_old_key() {
    let path = folder("migrate").join("old.toml");
    fs::write(
        &path,
        "base = \"n80cb.toml\"\n[analysis] # limits\nbody_top = \"2 kHz\"\n",
    )
    .unwrap();
    let run = |extra: &[&str]| {
        let mut command = command(&["migrate", path.to_str().unwrap(), "--json"]);
        command.args(extra).output().unwrap()
    };
    let listed = run(&[]);
    assert_eq!(listed.status.code(), Some(1), "{}", messages(&listed));
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    assert_eq!(listed["renamed"][0]["new"], "analysis.body_max_frequency");
    assert_eq!(
        (&listed["renamed"][0]["line"], &listed["written"]),
        (&3.into(), &false.into())
    );
    let written = run(&["--write"]);
    assert_eq!(written.status.code(), Some(0), "{}", messages(&written));
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        "base = \"n80cb.toml\"\n[analysis] # limits\nbody_max_frequency = \"2 kHz\"\n"
    );
    let again = run(&["--write"]);
    assert_eq!(again.status.code(), Some(0));
    assert_eq!(json(&again)["written"], false);
}

//! Common parts of the tests of all binaries: shipped and small designs, separate folders, and the command.
#![allow(dead_code)] // each binary uses its part

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use nailnoise::chain::{BodyStages, Chain, Options};
use nailnoise::graph::Graph;
use nailnoise::run::Run;
use nailnoise::stages::Silent;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::store::{LIMIT, Store};
use nailnoise::{Design, Error};
use serde_json::Value;

/// The root of the repository.
pub(crate) const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The small design, whose full chain takes seconds.
pub(crate) const SMALL: &str = "tests/data/small.toml";

/// A design file of the repository, by its path from the root.
pub(crate) fn design(path: &str) -> Design {
    Design::load(Path::new(ROOT).join(path)).unwrap()
}

/// The small design with other keys.
pub(crate) fn small(text: &str) -> Design {
    let beside = Path::new(ROOT).join("tests/data/over.toml");
    Design::parse(&format!("base = \"small.toml\"\n{text}\n"), beside).unwrap()
}

/// A folder for the files of one test, emptied.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A design file in a folder that changes the small design.
pub(crate) fn over(folder: &Path, name: &str, text: &str) -> String {
    let file = folder.join(format!("{name}.toml"));
    let base = Path::new(ROOT).join(SMALL);
    fs::write(&file, format!("base = {base:?}\n{text}\n")).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Folder of the common store of all tests.
pub(crate) fn shared_folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("modes")
}

/// The store that all tests share, so that the same modes are computed once.
pub(crate) fn store() -> Store {
    Store::at(shared_folder(), LIMIT)
}

/// A graph with a store.
pub(crate) fn graph(store: Store) -> Graph {
    Graph::new(Arc::new(store), Arc::new(Silent))
}

/// Runs a design with a store; its chain contains the motions.
pub(crate) fn try_run(design: &Design, store: Store) -> Result<(Run, Chain), Error> {
    let chain = Chain::new(&graph(store), design, Options::default())?;
    Ok((chain.run(design)?, chain))
}

/// A run that succeeds, with its chain.
pub(crate) fn run_with_chain(design: &Design, store: Store) -> (Run, Chain) {
    try_run(design, store).unwrap()
}

/// A run that succeeds, with the store that all tests share.
pub(crate) fn run(design: &Design) -> Run {
    run_with_chain(design, store()).0
}

/// The stages of a body of a design.
pub(crate) fn body(design: &Design, kind: BodyKind, driven: bool, store: Store) -> BodyStages {
    BodyStages::add(&graph(store), design, kind, driven).unwrap()
}

/// The command at the root of the repository, with the store that all tests share.
pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nailnoise"));
    command
        .args(arguments)
        .current_dir(ROOT)
        .env("NO_COLOR", "1")
        .env("NAILNOISE_CACHE", shared_folder());
    command
}

/// Runs [`command`].
pub(crate) fn nailnoise(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

/// Output of a command on standard error.
pub(crate) fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The JSON value that a successful command printed.
pub(crate) fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", messages(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

//! Digests the code of every crate and stage, so that a cached result is only used by the code that produced it.
//!
//! Comments, documentation, layout and unit tests are ignored, because they do not change results. Included files are
//! digested completely. The digest of a crate includes those of the workspace crates it depends on, and the lock file,
//! which pins all other dependencies.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use sha2::{Digest as _, Sha256};

/// Crates of the workspace in dependency order.
const CRATES: [&str; 10] = [
    "quantities",
    "documents",
    "calibration",
    "penetration",
    "dynamics",
    "meshes",
    "fem",
    "acoustics",
    "measurement",
    "pipeline",
];

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let lock = fs::read(root.join("Cargo.lock")).unwrap_or_default();
    println!("cargo:rerun-if-changed=Cargo.lock");
    let mut crates: BTreeMap<&str, String> = BTreeMap::new();
    for name in CRATES {
        let manifest = fs::read_to_string(root.join(name).join("Cargo.toml")).unwrap_or_default();
        let mut digest = Sha256::new();
        digest.update(&lock);
        for (other, known) in &crates {
            if manifest.contains(&format!("nailnoise-{other}")) {
                digest.update(known);
            }
        }
        // A published package does not contain the other crates; the lock file then fixes their versions.
        digest_code(&root, &root.join(name).join("src"), &mut digest)?;
        crates.insert(name, emit(name, digest));
    }
    let mut all = Sha256::new();
    crates.values().for_each(|known| all.update(known));
    digest_code(&root, &root.join("src"), &mut all)?;
    let all: String = all.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=NAILNOISE_SOURCES={all}");
    for entry in fs::read_dir(root.join("src/stages"))? {
        let path = entry?.path();
        let stage = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut digest = Sha256::new();
        digest_code(&root, &path, &mut digest)?;
        emit(&format!("stages_{stage}"), digest);
    }
    // The stages of a source are in its file, or in `sound.rs` in its folder; the rest only describes it.
    for entry in fs::read_dir(root.join("src/model/sources"))? {
        let path = entry?.path();
        let source = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let stages = if path.is_dir() { path.join("sound.rs") } else { path };
        let mut digest = Sha256::new();
        digest_code(&root, &stages, &mut digest)?;
        emit(&format!("model_sources_{source}"), digest);
    }
    println!("cargo:rerun-if-changed=src/model/sources");
    for exports in ["output", "report"] {
        let mut digest = Sha256::new();
        digest_code(&root, &root.join("src").join(exports), &mut digest)?;
        // Sound files are written by the module that reads them.
        digest_code(&root, &root.join("measurement/src/recordings/wav.rs"), &mut digest)?;
        emit(exports, digest);
    }
    println!("cargo:rerun-if-changed=src/stages");
    studies(&root)?;
    describe(&root);
    Ok(())
}

/// Lists the studies that come with the program: all files in their folder.
fn studies(root: &Path) -> Result<(), Box<dyn Error>> {
    let folder = root.join("designs/studies");
    println!("cargo:rerun-if-changed=designs/studies");
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".json") {
            names.push(name);
        }
    }
    names.sort();
    let file = |name: &String| {
        let path = folder.join(name);
        format!("    ({:?}, include_str!({path:?})),\n", format!("studies/{name}"))
    };
    let list: String = names.iter().map(file).collect();
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("studies.rs"), format!("&[\n{list}]\n"))?;
    Ok(())
}

/// Build information for `--version`. It is not part of any key, because the digests above cover only the sources.
fn describe(root: &Path) {
    let set = |name: &str| std::env::var(name).unwrap_or_default();
    let features = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
    let features =
        features.filter_map(|name| Some(name.strip_prefix("CARGO_FEATURE_")?.to_lowercase().replace('_', "-")));
    let features: Vec<String> = features.collect();
    let features = if features.is_empty() {
        "none".to_owned()
    } else {
        features.join(", ")
    };
    println!(
        "cargo:rustc-env=NAILNOISE_COMMIT={}",
        commit(root).unwrap_or_else(|| "not known".to_owned())
    );
    println!(
        "cargo:rustc-env=NAILNOISE_PROFILE={}, opt-level {}",
        set("PROFILE"),
        set("OPT_LEVEL")
    );
    println!("cargo:rustc-env=NAILNOISE_TARGET={}", set("TARGET"));
    println!("cargo:rustc-env=NAILNOISE_FEATURES={features}");
}

/// The commit of the sources, if they are in a repository or in a package made from one. The script runs when a source
/// changes but not when a commit is made, so it may report the previous commit with changes.
fn commit(root: &Path) -> Option<String> {
    if let Ok(package) = fs::read_to_string(root.join(".cargo_vcs_info.json")) {
        let hash = package.split("\"sha1\"").nth(1)?.split('"').nth(1)?;
        return Some(hash.to_owned());
    }
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout)
            .ok()
            .filter(|_| output.status.success())?;
        Some(text.trim().to_owned())
    };
    // If the repository merely contains a copy of the sources, its commit does not describe them.
    let top = PathBuf::from(git(&["rev-parse", "--show-toplevel"])?);
    if top.canonicalize().ok()? != root.canonicalize().ok()? {
        return None;
    }
    let hash = git(&["rev-parse", "HEAD"])?;
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changed.is_empty() {
        hash
    } else {
        format!("{hash} and changes")
    })
}

/// Passes a digest on to the compiler as `NAILNOISE_CODE_unit`.
fn emit(unit: &str, digest: Sha256) -> String {
    let digest: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=NAILNOISE_CODE_{unit}={digest}");
    digest
}

/// Adds the code of a file, or of all files under a folder in the order of their paths.
fn digest_code(root: &Path, path: &Path, digest: &mut Sha256) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed={}", path.display());
    if path.is_dir() {
        let mut entries: Vec<PathBuf> = fs::read_dir(path)?
            .map(|e| e.map(|e| e.path()))
            .collect::<Result<_, _>>()?;
        entries.sort();
        return entries.iter().try_for_each(|entry| digest_code(root, entry, digest));
    }
    if path.extension().is_some_and(|extension| extension == "rs") {
        digest.update(path.strip_prefix(root)?.to_string_lossy().as_bytes());
        let text = fs::read_to_string(path)?;
        // A file that is not Rust fails in the compiler, with a better message.
        let Ok(tokens) = TokenStream::from_str(&text) else {
            digest.update(text);
            return Ok(());
        };
        let code = significant(tokens);
        digest.update(code.to_string());
        for name in included_files(code) {
            let file = path.with_file_name(&name);
            println!("cargo:rerun-if-changed={}", file.display());
            digest.update(&name);
            digest.update(fs::read(file)?);
        }
    }
    Ok(())
}

/// Files that code includes by `include_str!("...")` or `include_bytes!("...")`: geometries, meshes, styles and
/// scripts.
fn included_files(tokens: TokenStream) -> Vec<String> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut names = Vec::new();
    for (at, tree) in tokens.iter().enumerate() {
        let TokenTree::Group(group) = tree else { continue };
        let macros = ["include_str", "include_bytes"];
        let includes = at >= 2 && macros.iter().any(|name| tokens[at - 2].to_string() == *name);
        match group.stream().into_iter().next() {
            Some(TokenTree::Literal(name)) if includes => names.push(name.to_string().trim_matches('"').to_owned()),
            _ => names.extend(included_files(group.stream())),
        }
    }
    names
}

/// Tokens excluding documentation and test-only code.
fn significant(tokens: TokenStream) -> TokenStream {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        match attribute(&tokens[at..]) {
            Some((length, text)) if text.starts_with("doc") => at += length,
            Some((length, text)) if text.starts_with("cfg (test)") || text.starts_with("cfg(test)") => {
                at += length;
                // An item ends with its block or semicolon.
                let end = |tree: &TokenTree| match tree {
                    TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
                    TokenTree::Punct(mark) => mark.as_char() == ';',
                    _ => false,
                };
                at += tokens[at..]
                    .iter()
                    .position(end)
                    .map_or(tokens.len() - at, |end| end + 1);
            }
            _ => {
                kept.push(match &tokens[at] {
                    TokenTree::Group(group) => {
                        TokenTree::Group(proc_macro2::Group::new(group.delimiter(), significant(group.stream())))
                    }
                    other => other.clone(),
                });
                at += 1;
            }
        }
    }
    kept.into_iter().collect()
}

/// The attribute at the start of these tokens, `#[...]` or `#![...]`: the number of tokens it occupies, and its text.
fn attribute(tokens: &[TokenTree]) -> Option<(usize, String)> {
    let is =
        |tree: Option<&TokenTree>, wanted: char| matches!(tree, Some(TokenTree::Punct(p)) if p.as_char() == wanted);
    if !is(tokens.first(), '#') {
        return None;
    }
    let at = if is(tokens.get(1), '!') { 2 } else { 1 };
    match tokens.get(at)? {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket => {
            Some((at + 1, group.stream().to_string()))
        }
        _ => None,
    }
}

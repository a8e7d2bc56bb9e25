//! Names the sources this program is built from, so that the cache never hands out what other code computed.

use std::path::{Path, PathBuf};
use std::{fs, io};

use sha2::{Digest as _, Sha256};

fn main() -> io::Result<()> {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut files = vec![root.join("Cargo.lock")];
    for folder in ["src", "dynamics/src", "meshes/src", "fem/src", "acoustics/src"] {
        let folder = root.join(folder);
        println!("cargo:rerun-if-changed={}", folder.display());
        // A published package has no other crates beside it; its version and theirs are in the lock file.
        if folder.is_dir() {
            collect(&folder, &mut files)?;
        }
    }
    files.sort();
    let mut digest = Sha256::new();
    for file in files.iter().filter(|file| file.is_file()) {
        digest.update(file.strip_prefix(&root).unwrap_or(file).to_string_lossy().as_bytes());
        digest.update(fs::read(file)?);
    }
    let digest: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rerun-if-changed=Cargo.lock");
    println!("cargo:rustc-env=NAILNOISE_SOURCES={digest}");
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

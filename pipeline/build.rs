//! Digests the code that determines the byte layout of values, so that only programs with the same layout read each
//! other's cache entries.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use sha2::{Digest as _, Sha256};

/// The code that serialises values.
const LAYOUT: [&str; 2] = ["src/codec.rs", "src/store/checksum.rs"];

/// The lock file pins the serialisation formats of dependencies; a published package is built without the workspace's.
const LOCK: &str = "../Cargo.lock";

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut digest = Sha256::new();
    digest.update(fs::read(root.join(LOCK)).unwrap_or_default());
    for file in LAYOUT {
        digest.update(fs::read(root.join(file))?);
        println!("cargo:rerun-if-changed={file}");
    }
    println!("cargo:rerun-if-changed={LOCK}");
    let digest: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=NAILNOISE_LAYOUT={digest}");
    Ok(())
}

//! Digests what lays values out in bytes, so that an entry of the cache is only read by a program that lays its values
//! out alike.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use sha2::{Digest as _, Sha256};

/// The code that writes and reads values.
const LAYOUT: [&str; 2] = ["src/codec.rs", "src/store/checksum.rs"];

/// The lock file fixes the formats of dependencies; a published package is built without that of the workspace.
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

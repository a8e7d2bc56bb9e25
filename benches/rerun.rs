//! How long a first run takes and how long later ones, as a user waits for them: `cargo bench -p nailnoise --bench rerun`.
//!
//! Each design runs in an empty cache, then unchanged, then with one thing changed. The figures are wall times of the whole
//! command, files included.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// What is changed, and the key that does it.
const CHANGES: [(&str, &str); 4] = [
    ("exhaust's pitch", "exhaust.pitch = \"25 mm\""),
    ("exhaust's holes", "exhaust.holes = 6"),
    ("ambient temperature", "ambient.temperature = \"25 degC\""),
    ("supply pressure", "supply.pressure = \"90 psig\""),
];

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let work = root.join("target/rerun");
    for name in ["n80cb", "n80cb-sandbox"] {
        let cache = work.join(format!("{name}-cache"));
        if cache.exists() {
            std::fs::remove_dir_all(&cache)?;
        }
        std::fs::create_dir_all(&work)?;
        let design = root.join("designs").join(name).with_extension("toml");
        println!("{name}");
        for what in ["first", "unchanged"] {
            println!("  {what:<22}{:7.2} s", seconds(&design, &cache, &work)?);
        }
        for (what, key) in CHANGES {
            let changed: PathBuf = work.join(format!("{name}-changed.toml"));
            std::fs::write(&changed, format!("base = {design:?}\n{key}\n"))?;
            println!("  {what:<22}{:7.2} s", seconds(&changed, &cache, &work)?);
        }
    }
    Ok(())
}

/// Wall time of a run.
fn seconds(design: &Path, cache: &Path, work: &Path) -> Result<f64, Box<dyn Error>> {
    let since = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
        .args(["run", "--quiet", "--out"])
        .arg(work.join("out"))
        .arg(design)
        .env("NAILNOISE_CACHE", cache)
        .stdout(Stdio::null())
        .status()?;
    if !status.success() {
        return Err(format!("{}: {status}", design.display()).into());
    }
    Ok(since.elapsed().as_secs_f64())
}

//! Durations of a first run and of later ones, as a user experiences them, and the size of the files: `cargo bench -p
//! nailnoise --bench rerun`.
//!
//! Each design runs with an empty cache, then unchanged, then with one change. The figures are wall times of the
//! complete command, including files. If the system reports it, the processor time of all threads is added, which
//! depends less on other load.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The change, and the assignment that makes it.
const CHANGES: [(&str, &str); 17] = [
    ("exhaust's pitch", "exhaust.pitch = \"25 mm\""),
    ("exhaust's muffler", MUFFLER),
    ("background noise", "acoustics.background_level = 70"),
    ("exhaust's holes", "exhaust.holes = 6"),
    ("ambient temperature", "ambient.temperature = \"25 degC\""),
    ("supply pressure", "supply.pressure = \"90 psig\""),
    // New modes on the same surfaces, without boundary elements; see docs/performance.md.
    ("wood's stiffness", "wood.elastic.e_l = \"12.3 GPa\""),
    ("wood's density", "wood.density = \"440 kg/m3\""),
    ("wood's loss factor", "wood.loss_factor = 0.03"),
    ("nail's length", "nail.length = \"76 mm\""),
    // The same surfaces, with receivers at other places.
    ("ear", "acoustics.ear_across = \"0.53 m\""),
    ("nail's place", "nail.offset_along = \"30 mm\""),
    // Boundary elements of the table only.
    ("table's height", "support.worktable.height = \"700 mm\""),
    (
        "table's thickness",
        "support.worktable.top_thickness = \"45 mm\"\nsensors.table_centre.z = \"-45 mm\"",
    ),
    // New modes of the tool on the same mesh.
    ("tool's mass", "tool.mass = \"4.0 kg\""),
    // New meshes of the tool; the first one also needs its second reference structure, once.
    ("tool's first wall", "body.magazine_wall = \"3.4 mm\""),
    ("tool's next wall", "body.cap_wall = \"3.5 mm\""),
];

/// A muffler with measured insertion loss; its outlet area affects the flow and therefore the shot.
const MUFFLER: &str = "exhaust.muffler.kind = \"insertion_loss\"\nexhaust.muffler.octaves.4000 = 10";

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
            println!("  {what:<22}{}", spent(&design, &cache, &work)?);
        }
        let out = work.join("out");
        let report = std::fs::metadata(out.join("report.html"))?.len();
        println!(
            "  {:<22}{:7.2} MB, of it the report {:.2} MB",
            "files",
            1e-6 * size(&out)? as f64,
            1e-6 * report as f64
        );
        for (what, key) in CHANGES {
            let changed: PathBuf = work.join(format!("{name}-changed.toml"));
            std::fs::write(&changed, format!("base = {design:?}\nstudy.screening = 0\n{key}\n"))?;
            println!("  {what:<22}{}", spent(&changed, &cache, &work)?);
        }
    }
    Ok(())
}

/// Total size of the files in a folder \[bytes\].
fn size(folder: &Path) -> std::io::Result<u64> {
    let of = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry?;
        let data = entry.metadata()?;
        if data.is_dir() {
            size(&entry.path())
        } else {
            Ok(data.len())
        }
    };
    std::fs::read_dir(folder)?.map(of).sum()
}

/// Wall and processor time of a run.
fn spent(design: &Path, cache: &Path, work: &Path) -> Result<String, Box<dyn Error>> {
    let (since, before) = (Instant::now(), processor());
    let status = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
        .args(["run", "--quiet", "--out"])
        .arg(work.join("out"))
        .arg(design)
        .env("NAILNOISE_CACHE", cache)
        .stdout(Stdio::null())
        .status()?;
    // A failed check, for example of a short nail that is driven too deep, does not shorten the run.
    if !status.success() && status.code() != Some(3) {
        return Err(format!("{}: {status}", design.display()).into());
    }
    let wall = since.elapsed().as_secs_f64();
    let processor = before.zip(processor()).map(|(before, after)| after - before);
    Ok(match processor {
        Some(processor) => format!("{wall:7.2} s, {processor:7.2} CPU s"),
        None => format!("{wall:7.2} s"),
    })
}

/// User and system time of the child processes so far \[s\], from Linux's /proc (proc(5): fields 16 and 17, in
/// hundredths of a second).
fn processor() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name, in parentheses, may contain spaces; field 3 follows it.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field - 3)?.parse::<f64>().ok();
    Some((ticks(16)? + ticks(17)?) / 100.0)
}

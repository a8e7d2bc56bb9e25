//! Each fuzz target reads arbitrary bytes as the program reads a file. It goes as far as a command goes before the
//! computation begins. Nothing may panic, hang or need much memory; errors are as good as values.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise::artifacts::RunArtifacts;
use nailnoise::design::Design;
use nailnoise::measurement::Manifest;
use nailnoise::measurement::recordings::{Selector, decode};
use nailnoise::stages::bodies::{Body, BodySensors, WholeModes};
use nailnoise::stages::response::ResponseChecks;
use nailnoise::stages::{Codec, Postcard, WithMatrix};
use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, KeyValue};
use nailnoise_meshes::{Surface, msh, uff};

/// A target by its name.
pub type Target = (&'static str, fn(&[u8]));

/// All targets; each has a corpus of its name.
pub const TARGETS: [Target; 9] = [
    ("assembly", assembly),
    ("design", design),
    ("msh22", mesh),
    ("msh41", mesh),
    ("uff", universal_file),
    ("penetration_table", penetration_table),
    ("cache_entry", cache_entry),
    ("manifest", manifest),
    ("recording", recording),
];

/// An assembly, evaluated without the keys of a design.
pub fn assembly(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let keys: BTreeMap<String, KeyValue> = BTreeMap::new();
    if let Ok(text) = AssemblyText::open(&Document::new(Path::new("fuzzed.toml"), text)) {
        let _ = text.resolve(&keys);
    }
}

/// A design over the shipped ones, and the estimate of its cost.
pub fn design(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    // This file is compiled into the targets, and into the tests of the program.
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = if own.ends_with("fuzz") {
        own.join("..")
    } else {
        own.to_owned()
    };
    if let Ok(design) = Design::parse(text, root.join("designs/fuzzed.toml")) {
        let _ = nailnoise::cost::of_run(&design);
        let _ = design.digest();
        let _ = design.entries();
    }
}

/// A mesh of either version, checked as one that a user gives.
pub fn mesh(bytes: &[u8]) {
    if let Ok(imported) = msh::parse(bytes, 1e-3, Path::new("fuzzed.msh")) {
        let mesh = &imported.mesh;
        if mesh.validate(|element| element as u64).is_ok() {
            let _ = mesh.quality();
            let _ = mesh.part_volumes();
            let _ = Surface::of(mesh);
        }
    }
}

/// Measured modes.
pub fn universal_file(bytes: &[u8]) {
    let _ = uff::parse(bytes, Path::new("fuzzed.uff"));
}

/// A penetration law by points.
pub fn penetration_table(bytes: &[u8]) {
    let _ = nailnoise::penetration::force_table(bytes, Path::new("fuzzed.csv"));
}

/// The manifest of a test, without its recordings.
pub fn manifest(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Manifest::parse(text, Path::new("fuzzed.toml"));
}

/// A recording of any format, by its channels and by a column.
pub fn recording(bytes: &[u8]) {
    let [first, second, column] = [
        Selector::Channel(1),
        Selector::Channel(2),
        Selector::Column("N".to_owned()),
    ];
    for channels in [vec![&first], vec![&second, &first], vec![&column]] {
        let _ = decode(bytes, Path::new("fuzzed.wav"), &channels);
    }
}

/// Content of a cache entry after its header: a value in the postcard format, or one with a matrix.
pub fn cache_entry(bytes: &[u8]) {
    fn read<T, C: Codec<T>>(mut bytes: &[u8]) {
        let length = bytes.len();
        let _ = C::read(&mut bytes, length);
    }
    read::<Body, WithMatrix>(bytes);
    read::<WholeModes, WithMatrix>(bytes);
    read::<RunArtifacts, Postcard>(bytes);
    read::<BodySensors, Postcard>(bytes);
    read::<ResponseChecks, Postcard>(bytes);
    read::<Vec<Vec<f64>>, Postcard>(bytes);
}

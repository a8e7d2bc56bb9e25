//! Sound of each design of a comparison: all sources at the front microphone, with a common scale.

use std::path::PathBuf;

use serde_json::Value;

use crate::measurement::recordings::wav::{Coding, encode};
use crate::report::Recording;

/// The sound file within the folder of a result.
const SOUND: &str = "microphones/total-1.wav";

/// A sound in pascals.
struct Sound {
    name: String,
    rate: u32,
    /// Pressure of a full-scale sample \[Pa\].
    full_scale: f64,
    pressure: Vec<f64>,
}

/// The sounds of designs, by name and folder. A result without sounds is omitted; the page is complete without them.
pub(super) fn recordings(results: &[(String, PathBuf)]) -> Vec<Recording> {
    let sounds: Vec<Sound> = results.iter().filter_map(|(name, folder)| read(name, folder)).collect();
    // A single sound cannot be compared.
    if sounds.len() < 2 {
        return Vec::new();
    }
    let full_scale = sounds.iter().map(|sound| sound.full_scale).fold(0.0, f64::max);
    let recording = |sound: Sound| {
        let wav = encode(&[&sound.pressure], sound.rate, full_scale, Coding::Integer24).ok()?;
        Some(Recording { name: sound.name, wav })
    };
    sounds.into_iter().filter_map(recording).collect()
}

fn read(name: &str, folder: &std::path::Path) -> Option<Sound> {
    let text = std::fs::read_to_string(folder.join("result.json")).ok()?;
    let result: Value = serde_json::from_str(&text).ok()?;
    let full_scale = result["microphones"]["full_scale_pa"]
        .as_f64()
        .filter(|own| *own > 0.0)?;
    let mut reader = hound::WavReader::open(folder.join(SOUND)).ok()?;
    let spec = reader.spec();
    if spec.channels != 1 || spec.sample_format != hound::SampleFormat::Int {
        return None;
    }
    let full = f64::from(1_u32 << (spec.bits_per_sample - 1)) - 1.0;
    let samples = reader.samples::<i32>().collect::<Result<Vec<_>, _>>().ok()?;
    Some(Sound {
        name: name.to_owned(),
        rate: spec.sample_rate,
        full_scale,
        pressure: samples
            .into_iter()
            .map(|sample| full_scale * f64::from(sample) / full)
            .collect(),
    })
}

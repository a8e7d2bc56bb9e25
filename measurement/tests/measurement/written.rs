//! Tests as their recorders would leave them: a folder with a manifest and recordings.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use nailnoise_measurement::recordings::wav::{Coding, encode};
use nailnoise_measurement::{Manifest, MeasurementError};
use nailnoise_meshes::uff::{History, Ordinate};

/// Sampling rate of the recordings \[Hz\].
pub(crate) const RATE: u32 = 48_000;

/// Samples of a recording: 0.25 s.
pub(crate) const SAMPLES: usize = 12_000;

/// Position of the fifth microphone around the centre of [`HEAD`].
pub(crate) const CORNER: &str = "position = [1, 1, 1.938]";

/// The keys of a test before its channels.
pub(crate) const HEAD: &str =
    "setup = \"worktable\"\ncentre = [0, 0, 0.938]\nplane = \"floor\"\ntemperature = \"21 degC\"\n";

/// One configuration of one shot.
pub(crate) const ONE: &str = "[configurations]\nW-1 = { repeats = 1, trigger = \"12.5 ms\" }\n";

/// A folder for one test, deleted at its end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("measurement-{name}"));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Writes and reads a manifest.
    pub(crate) fn load(&self, text: &str) -> Result<Manifest, MeasurementError> {
        self.write("test.toml", text);
        Manifest::load(&self.path("test.toml"))
    }

    /// A manifest of one microphone with these keys, and its first shot; the recording is `W-1-1` with this extension.
    pub(crate) fn microphone(
        &self,
        extension: &str,
        keys: &str,
    ) -> Result<(Manifest, nailnoise_measurement::Shot), MeasurementError> {
        let manifest = self.load(&format!(
            "{HEAD}[channels]\nmic5 = {{ file = \"{{c}}-{{k}}.{extension}\", {keys}, {CORNER} }}\n{ONE}"
        ))?;
        let shot = manifest.shot(0, 0)?;
        Ok((manifest, shot))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A sine of 500 Hz with this amplitude.
pub(crate) fn sine(amplitude: f64) -> Vec<f64> {
    tone(amplitude, 500.0, SAMPLES)
}

/// A sine.
pub(crate) fn tone(amplitude: f64, hz: f64, samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|i| amplitude * (TAU * hz * i as f64 / f64::from(RATE)).sin())
        .collect()
}

/// A WAV file of 24 bits, full scale 1.
pub(crate) fn wav(signals: &[&[f64]]) -> Vec<u8> {
    encode(signals, RATE, 1.0, Coding::Integer24).unwrap()
}

/// A universal file of accelerations in m/s2.
pub(crate) fn uff(signals: &[&[f64]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (index, values) in signals.iter().enumerate() {
        let history = History {
            title: "N",
            origin: "test",
            sensor: "N",
            node: index + 1,
            ordinate: Ordinate::Acceleration,
            interval: 1.0 / f64::from(RATE),
            values,
        };
        history.write(&mut bytes);
    }
    bytes
}

/// A binary universal file of one acceleration: single or double precision, least significant byte first or last.
pub(crate) fn binary_uff(values: &[f64], double: bool, little: bool) -> Vec<u8> {
    let text = String::from_utf8(uff(&[values])).unwrap();
    let mut lines: Vec<String> = text.lines().take(13).map(str::to_owned).collect();
    let width = if double { 8 } else { 4 };
    let order = if little { 1 } else { 2 };
    lines[1] = format!(
        "    58b{order:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}",
        2,
        11,
        values.len() * width,
        0,
        0,
        0,
        0
    );
    lines[8] = lines[8].replacen('4', if double { "4" } else { "2" }, 1);
    let mut bytes = (lines.join("\n") + "\n").into_bytes();
    for &value in values {
        match (double, little) {
            (true, true) => bytes.extend(value.to_le_bytes()),
            (true, false) => bytes.extend(value.to_be_bytes()),
            (false, true) => bytes.extend((value as f32).to_le_bytes()),
            (false, false) => bytes.extend((value as f32).to_be_bytes()),
        }
    }
    bytes.extend(b"\n    -1\n");
    bytes
}

/// A CSV file of times and columns.
pub(crate) fn csv(headings: &str, columns: &[&[f64]]) -> String {
    let mut text = format!("{headings}\n");
    for index in 0..columns[0].len() {
        text += &format!("{:.9}", index as f64 / f64::from(RATE));
        for column in columns {
            text += &format!(",{}", column[index]);
        }
        text.push('\n');
    }
    text
}

/// Message and remedy of an error, and that it has both.
pub(crate) fn said(error: &MeasurementError) -> String {
    let remedy = error.help().unwrap().to_string();
    assert!(!remedy.is_empty(), "{error} has no remedy");
    format!("{error}\n{remedy}")
}

/// Asserts that an error names all of these.
pub(crate) fn names(error: &MeasurementError, words: &[&str]) {
    let text = said(error);
    for word in words {
        assert!(text.contains(word), "\"{word}\" is not in: {text}");
    }
}

//! One value per octave band, as a list in the design file.

use std::ops::Deref;

use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{Assign, Found, Group, GroupSpec, KeySpec, Kind, Value, any, dotted, read_key};
use serde::{Deserialize, Serialize};

/// Insertion loss \[dB\].
const LOSS: Kind = any(NUMBER).within(-100.0, 100.0);

macro_rules! octaves {
    ($($name:literal: $doc:literal),+ $(,)?) => {
        &[$(KeySpec { name: $name, symbol: "D_i", doc: &[$doc], kind: LOSS }),+]
    };
}

/// The octave bands, each a key that a study, a sweep or an assignment can address: `exhaust.muffler.octaves.1000`.
const KEYS: &[KeySpec] = octaves! {
    "63": "63 Hz octave.",
    "125": "125 Hz octave.",
    "250": "250 Hz octave.",
    "500": "500 Hz octave.",
    "1000": "1 kHz octave.",
    "2000": "2 kHz octave.",
    "4000": "4 kHz octave.",
    "8000": "8 kHz octave.",
    "16000": "16 kHz octave.",
};

/// Measured insertion loss \[dB\] in the octave bands from 63 Hz to 16 kHz.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Octaves([f64; KEYS.len()]);

impl Deref for Octaves {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl Group for Octaves {
    const SPEC: GroupSpec = GroupSpec {
        doc: &[
            "Measured insertion loss \\[dB\\] by octave bands, the muffler's own flow noise included (ISO 11820, ISO ",
            "7235). A list gives all bands: `octaves = [0, 0, 0, 0, 5, 10, 15, 15, 15]`, or with range and provenance ",
            "`octaves = { value = [...], range = \"+-3\", provenance = \"...\" }`. A single band is a key of this \
             group.",
        ],
        keys: &[KEYS],
        groups: &[],
        lists: &[],
        is_list: true,
    };

    fn build(path: &str, found: &Found) -> Result<Self, String> {
        let mut octaves = Self([0.0; KEYS.len()]);
        for (loss, key) in octaves.0.iter_mut().zip(KEYS) {
            *loss = read_key(path, key.name, found)?;
        }
        Ok(octaves)
    }

    fn visit(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec, Value)) {
        for (loss, key) in self.0.iter().zip(KEYS) {
            f(&dotted(path, key.name), key, Value::Number(*loss));
        }
    }

    fn key_mut(&mut self, name: &str) -> Option<(&'static KeySpec, &mut dyn Assign)> {
        let place = KEYS.iter().position(|key| key.name == name)?;
        Some((&KEYS[place], &mut self.0[place]))
    }
}

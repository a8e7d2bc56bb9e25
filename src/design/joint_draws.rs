//! Joint draws of a design's keys, such as those of a calibration, which replace the ranges of these keys in a study.
//!
//! ```toml
//! [study]
//! draws = "calibrated.draws" # beside the file of the design
//! ```
//!
//! The file is JSON. A row gives a value to each of its keys, in SI units; rows are in random order. Draws that are
//! conditioned on levels also give `method.SOURCE`, the place of the method's error between its bounds, 0 .. 1.

use std::path::Path;

use nailnoise_documents::read_regular;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::wording::hexadecimal;

/// Name and version of the layout.
const SCHEMA: &str = "nailnoise-draws/1";

/// Maximum size of a file \[byte\].
const LARGEST: u64 = 256 << 20;

/// Joint draws of keys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointDraws {
    schema: String,
    /// The file of measurements on which they are conditioned.
    pub measured: String,
    /// Digests of the code of the cycle, and of the levels, with which they were conditioned.
    pub code: String,
    /// Names of the keys.
    pub names: Vec<String>,
    /// A value for each key in each draw.
    pub rows: Vec<Vec<f64>>,
    /// SHA-256 of the file in hexadecimal digits.
    #[serde(skip)]
    pub digest: String,
}

impl JointDraws {
    /// Draws to be written.
    pub fn new(measured: String, code: String, names: Vec<String>, rows: Vec<Vec<f64>>) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            measured,
            code,
            names,
            rows,
            digest: String::new(),
        }
    }

    /// The draws without some keys, which are then drawn from their ranges.
    pub(crate) fn without(&self, is_left_out: impl Fn(&str) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.names.len())
            .filter(|&key| !is_left_out(&self.names[key]))
            .collect();
        Self {
            names: kept.iter().map(|&key| self.names[key].clone()).collect(),
            rows: self
                .rows
                .iter()
                .map(|row| kept.iter().map(|&key| row[key]).collect())
                .collect(),
            ..self.clone()
        }
    }

    /// Number of the row for a candidate of a study; the first row depends on the seed.
    pub(crate) fn row_of(&self, candidate: u64, seed: u64) -> usize {
        let count = self.rows.len() as u64;
        ((candidate % count + seed % count) % count) as usize
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The reason why it cannot be read, as text.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let bytes = read_regular(path, LARGEST).map_err(|error| error.to_string())?;
        let mut own: Self = serde_json::from_slice(&bytes).map_err(|error| error.to_string())?;
        let is_whole = own.rows.iter().all(|row| row.len() == own.names.len());
        if own.schema != SCHEMA || own.rows.is_empty() || !is_whole {
            return Err(format!("it does not follow the layout {SCHEMA}"));
        }
        own.digest = hexadecimal(&Sha256::digest(&bytes));
        Ok(own)
    }
}

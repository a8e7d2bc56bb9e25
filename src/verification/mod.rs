//! Benchmarks from other sources, closed forms, standards and public measurements, next to computed values.
//!
//! `nailnoise verify` computes them on the user's machine and the tests compute them in CI. Each row names its source.
//! Disagreements are stated with their values in `docs/limits.md` and marked in the row; no parameter was fitted to
//! agree.

mod cycle;
mod garteur;
mod jets;
mod loudness;
mod panels;
mod plates;
mod radiation;
mod row;
mod signals;
mod spruce;
mod structures;
mod table;
mod valves;

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;

pub use row::{Case, Row, Verdict};
pub use table::{Shown, markdown, summary};

/// The rows of one field of physics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Section {
    /// Its name.
    pub field: &'static str,
    /// Its rows; those of one case are together.
    pub rows: Vec<Row>,
}

/// A field of physics and the functions that compute its rows.
struct Field {
    name: &'static str,
    parts: &'static [fn() -> Result<Vec<Row>, Error>],
}

const FIELDS: [Field; 4] = [
    Field {
        name: "cycle",
        parts: &[cycle::rows],
    },
    Field {
        name: "vibration",
        parts: &[
            plates::free,
            plates::cantilever,
            plates::supported,
            plates::thick,
            structures::membrane,
            structures::cylinder,
            structures::double_cell_box,
            structures::composite,
            garteur::rows,
            spruce::rows,
        ],
    },
    Field {
        name: "sound",
        parts: &[radiation::spheres, radiation::flat, jets::rows, valves::rows],
    },
    Field {
        name: "levels",
        parts: &[signals::rows, loudness::rows],
    },
];

/// Computes all benchmarks in parallel.
///
/// # Errors
/// If a case fails numerically.
pub fn verify() -> Result<Vec<Section>, Error> {
    let section = |field: &Field| {
        let parts = field.parts.par_iter().map(|rows| rows());
        let rows: Vec<Vec<Row>> = parts.collect::<Result<_, Error>>()?;
        Ok(Section {
            field: field.name,
            rows: rows.concat(),
        })
    };
    FIELDS.par_iter().map(section).collect()
}

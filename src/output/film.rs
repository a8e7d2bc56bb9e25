//! The fields of a shot in the form of the inputs of their files: surfaces once, and the values of each file.
//!
//! More than half of the files' bytes are the surface they share, which a reader wants in each of them. The record that
//! is stored from run to run has it once, compressed, and every file is restored from it to the byte.

use std::path::{Path, PathBuf};

use nailnoise_meshes::vtu::{Array, Frames};
use serde::{Deserialize, Serialize};

use super::file::FIELDS;
use crate::error::Error;

/// Files that are rendered when they are written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Fields {
    grids: Vec<Frames>,
    files: Vec<(PathBuf, Content)>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Content {
    Text(Vec<u8>),
    /// A surface, by its place among the grids, with point fields.
    Frame {
        grid: usize,
        fields: Vec<Array>,
    },
}

impl Fields {
    /// How many files there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Path of a file in the folder of a run.
    pub fn path(&self, file: usize) -> &Path {
        &self.files[file].0
    }

    /// Renders a file into memory whose former content is lost.
    ///
    /// # Errors
    /// [`Error::Mesh`] where a field has not as many values as its surface has points.
    pub fn render(&self, file: usize, bytes: &mut Vec<u8>) -> Result<(), Error> {
        bytes.clear();
        match &self.files[file].1 {
            Content::Text(text) => bytes.extend_from_slice(text),
            Content::Frame { grid, fields } => self.grids[*grid].render(fields, bytes)?,
        }
        Ok(())
    }

    /// Adds a surface that later frames show.
    pub(super) fn show(&mut self, grid: Frames) {
        self.grids.push(grid);
    }

    /// Adds a text.
    pub(super) fn text(&mut self, path: impl Into<PathBuf>, text: impl Into<Vec<u8>>) {
        self.files.push((path.into(), Content::Text(text.into())));
    }

    /// Adds a file of the surface shown last, by its path in the folder of the fields.
    pub(super) fn frame(&mut self, path: &str, fields: Vec<Array>) {
        let grid = self.grids.len() - 1;
        self.files
            .push((Path::new(FIELDS).join(path), Content::Frame { grid, fields }));
    }

    /// Adds frames of one field over time or frequency, `NAME/*.vtu`, and the list of them, `NAME.pvd`.
    pub(super) fn series(&mut self, name: &str, frames: Vec<(f64, String, Array)>) {
        let mut listed = Vec::with_capacity(frames.len());
        for (at, file, values) in frames {
            let path = format!("{name}/{file}.vtu");
            self.frame(&path, vec![values]);
            listed.push((at, path));
        }
        let list = Path::new(FIELDS).join(format!("{name}.pvd"));
        self.text(list, nailnoise_meshes::vtu::series(&listed));
    }
}

//! The fields of a shot as data from which their files are rendered: each surface once, and the values of each file.
//!
//! More than half of the bytes in the files describe the surface that they share, which readers want in each of them.
//! The stored record contains it once, compressed, and every file is restored from it exactly.

use std::path::{Path, PathBuf};

use nailnoise_meshes::Surface;
use nailnoise_meshes::vtkhdf::{FilmFrame, FilmSurface};
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
    /// A surface, given by its index among the grids, with point fields.
    Frame {
        grid: usize,
        fields: Vec<Array>,
    },
    /// All frames of a film, each a time \[s\] and the index of its file, in one VTKHDF file.
    Film {
        surface: FilmSurface,
        frames: Vec<(f64, usize)>,
    },
}

impl Fields {
    /// Number of files.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether there are no files.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Path of a file in the folder of a run.
    pub fn path(&self, file: usize) -> &Path {
        &self.files[file].0
    }

    /// Renders a file into memory, whose previous content is lost.
    ///
    /// # Errors
    /// [`Error::Mesh`] if the number of values in a field differs from the number of points of its surface.
    pub fn render(&self, file: usize, bytes: &mut Vec<u8>) -> Result<(), Error> {
        bytes.clear();
        match &self.files[file].1 {
            Content::Text(text) => bytes.extend_from_slice(text),
            Content::Frame { grid, fields } => self.grids[*grid].render(fields, bytes)?,
            Content::Film { surface, frames } => {
                let frames = frames.iter().filter_map(|&(time, file)| match &self.files[file].1 {
                    Content::Frame { fields, .. } => Some(FilmFrame { time, fields }),
                    _ => None,
                });
                *bytes = surface.film(&frames.collect::<Vec<_>>())?;
            }
        }
        Ok(())
    }

    /// Adds a surface for the frames that follow.
    pub(super) fn show(&mut self, grid: Frames) {
        self.grids.push(grid);
    }

    /// Adds a text file.
    pub(super) fn text(&mut self, path: impl Into<PathBuf>, text: impl Into<Vec<u8>>) {
        self.files.push((path.into(), Content::Text(text.into())));
    }

    /// Adds a file with the surface added last; `path` is relative to the folder of the fields.
    pub(super) fn frame(&mut self, path: &str, fields: Vec<Array>) {
        let grid = self.grids.len() - 1;
        self.files
            .push((Path::new(FIELDS).join(path), Content::Frame { grid, fields }));
    }

    /// Adds frames of fields over time or frequency, `NAME/*.vtu`, and `NAME.pvd`, which lists them.
    pub(super) fn series(&mut self, name: &str, frames: Vec<(f64, String, Vec<Array>)>) {
        let mut listed = Vec::with_capacity(frames.len());
        for (at, file, values) in frames {
            let path = format!("{name}/{file}.vtu");
            self.frame(&path, values);
            listed.push((at, path));
        }
        let list = Path::new(FIELDS).join(format!("{name}.pvd"));
        self.text(list, nailnoise_meshes::vtu::series(&listed));
    }

    /// Adds the same as [`series`](Self::series), and all frames in one file, `NAME.vtkhdf`.
    pub(super) fn film(&mut self, name: &str, surface: &Surface, frames: Vec<(f64, String, Vec<Array>)>) {
        let first = self.files.len();
        let frames_of = |(frame, (time, ..)): (usize, &(f64, String, Vec<Array>))| (*time, first + frame);
        let content = Content::Film {
            surface: FilmSurface::of(surface),
            frames: frames.iter().enumerate().map(frames_of).collect(),
        };
        self.series(name, frames);
        let path = Path::new(FIELDS).join(format!("{name}.vtkhdf"));
        self.files.push((path, content));
    }
}

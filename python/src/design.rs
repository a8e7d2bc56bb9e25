//! Designs, and the store for results of their stages.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nailnoise::Error;
use nailnoise::design::{Assignment, Design, dependencies};
use nailnoise::store::{LIMIT, Store};
use pyo3::prelude::*;

use crate::error::{NoCacheError, json_of, raised, value_error};

/// A design file with the values set over it.
#[pyclass(frozen, name = "Design", module = "nailnoise._native")]
pub(crate) struct NativeDesign {
    pub(crate) design: Arc<Design>,
    pub(crate) assignments: Vec<String>,
}

/// Assignments `key=value`.
pub(crate) fn parsed(assignments: &[String]) -> PyResult<Vec<Assignment>> {
    assignments
        .iter()
        .map(|text| text.parse().map_err(value_error))
        .collect()
}

#[pymethods]
impl NativeDesign {
    /// Reads a design file with assignments `key=value` over it.
    #[staticmethod]
    fn load(path: PathBuf, assignments: Vec<String>) -> PyResult<Self> {
        let design = Design::load_with(&path, &parsed(&assignments)?).map_err(|error| raised(error.into()))?;
        Ok(Self {
            design: Arc::new(design),
            assignments,
        })
    }

    /// The same file with more assignments.
    fn with_assignments(&self, more: Vec<String>) -> PyResult<Self> {
        Self::load(self.design.path().to_owned(), [&self.assignments[..], &more].concat())
    }

    #[getter]
    fn name(&self) -> &str {
        self.design.name()
    }

    #[getter]
    fn digest(&self) -> String {
        self.design.digest()
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.design.path().to_owned()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.design.warnings().iter().map(ToString::to_string).collect()
    }

    /// The files that it is made of: its own, its bases, and those that its keys name.
    fn files(&self) -> PyResult<Vec<PathBuf>> {
        Ok(dependencies(self.design.path(), &parsed(&self.assignments)?))
    }

    /// All values with units, ranges and sources, as JSON.
    fn entries(&self) -> PyResult<String> {
        json_of(&self.design.entries())
    }

    /// The derived quantities that a study draws, as JSON.
    fn drawn_derived(&self) -> PyResult<String> {
        let entries: Vec<_> = self.design.drawn_derived().map(|(entry, _)| entry).collect();
        json_of(&entries)
    }
}

/// The store for results: the folder given, the user's cache, or none.
pub(crate) fn store(cache: Option<PathBuf>, keep: bool) -> Result<Store, Error> {
    Ok(match cache {
        _ if !keep => Store::none(),
        Some(folder) => Store::in_folder(&folder, LIMIT)?,
        None => Store::of_user()?,
    })
}

/// A folder that tasks fill, without a size limit.
pub(crate) fn unbounded(folder: &Path) -> Result<Store, Error> {
    Ok(Store::shared(folder)?)
}

/// The folder of the user's cache.
#[pyfunction]
pub(crate) fn cache_folder() -> PyResult<PathBuf> {
    let store = Store::of_user().map_err(|error| match error.is_dispensable() {
        true => NoCacheError::new_err(error.to_string()),
        false => raised(error.into()),
    })?;
    let folder = store.folder().map(ToOwned::to_owned);
    folder.ok_or_else(|| value_error("there is no folder for the cache"))
}

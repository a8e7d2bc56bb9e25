//! Penetration laws, woods and nails by the names and files that a user gives.

use std::io;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use nailnoise_dynamics::prf::{CurveError, ForceTable, NAILS, NailSize, PenetrationLaw, TableError, WOODS, WoodKind};
use nailnoise_meshes::read_regular;
use thiserror::Error;

/// Why laws cannot be compared.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PenetrationError {
    /// A law, wood or nail that is not among the published ones.
    #[error("there is no {what} \"{name}\" among the published ones")]
    #[diagnostic(help("{}choose from: {known}", nearest.map_or_else(String::new, |near| format!("is it \"{near}\"? "))))]
    Unknown {
        /// `law`, `wood` or `nail`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The name most like it, if one is near.
        nearest: Option<&'static str>,
        /// All names.
        known: String,
    },
    /// A table that cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    #[diagnostic(help("name a CSV file of depths in m and forces in N"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// A file that holds no law.
    #[error("{} holds no penetration law", path.display())]
    #[diagnostic(help("a line holds a depth in m and a force in N with a comma between; depths increase from 0"))]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: TableError,
    },
    /// A law that cannot be evaluated.
    #[error(transparent)]
    #[diagnostic(help("{}", _0.remedy()))]
    Curve(#[from] CurveError),
}

/// The largest table that is read \[byte\].
const LARGEST_TABLE: u64 = 16 << 20;

fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read_regular(path, LARGEST_TABLE)?;
    String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

/// Reads a law from a CSV file of depths \[m\] and forces \[N\].
///
/// # Errors
/// [`PenetrationError::Unreadable`] or [`PenetrationError::Table`] with the file.
pub fn table(path: &Path) -> Result<ForceTable, PenetrationError> {
    let text = read_text(path).map_err(|cause| PenetrationError::Unreadable {
        path: path.to_owned(),
        cause: cause.to_string(),
    })?;
    ForceTable::from_csv(&text).map_err(|source| PenetrationError::Table {
        path: path.to_owned(),
        source,
    })
}

/// The published law of this name; case, hyphens and spaces do not matter.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn law(name: &str) -> Result<PenetrationLaw, PenetrationError> {
    find("law", name, PenetrationLaw::ALL, |law| law.as_str()).copied()
}

/// The wood of this name among those of the published tests.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn wood(name: &str) -> Result<&'static WoodKind, PenetrationError> {
    find("wood", name, &WOODS, |wood| wood.name)
}

/// The nail of this penny size among those of the published tests.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all sizes.
pub fn nail(name: &str) -> Result<&'static NailSize, PenetrationError> {
    find("nail", name, &NAILS, |nail| nail.name)
}

fn find<T>(
    what: &'static str,
    name: &str,
    all: &'static [T],
    own: fn(&T) -> &'static str,
) -> Result<&'static T, PenetrationError> {
    let plain = |text: &str| text.trim().to_lowercase().replace(['-', '_', ' '], "");
    all.iter().find(|item| plain(own(item)) == plain(name)).ok_or_else(|| {
        let distance = |item: &T| strsim::damerau_levenshtein(&plain(own(item)), &plain(name));
        let nearest = all
            .iter()
            .min_by_key(|item| distance(item))
            .filter(|item| distance(item) <= 2 + name.len() / 4);
        let known = all.iter().map(own).collect::<Vec<_>>().join(", ");
        PenetrationError::Unknown {
            what,
            name: name.to_owned(),
            nearest: nearest.map(own),
            known,
        }
    })
}

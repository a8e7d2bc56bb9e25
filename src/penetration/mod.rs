//! Penetration laws, woods, nails and measured drives by the names and files that a user gives.

pub mod drives;
pub mod fitting;
pub mod machine;
pub mod recordings;

use std::io;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use nailnoise_documents::read_regular;
use nailnoise_dynamics::machine::{MachineError, PlanError};
use nailnoise_penetration::fit::{FitError, FittedLaw, FormError};
use nailnoise_penetration::{CurveError, ForceTable, NAILS, NailSize, PenetrationLaw, TableError, WOODS, WoodKind};
use nailnoise_quantities::dimension;
use thiserror::Error;

use nailnoise_documents::tables::{ColumnOf, Table, TableFault};

/// Reasons why laws cannot be compared.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PenetrationError {
    /// A law, wood or nail that is not among the published ones.
    #[error("there is no {what} \"{name}\" among the published ones")]
    #[diagnostic(help("{}choose from: {known}", nearest.map_or_else(String::new, |near|
        format!("is it \"{near}\"? "))))]
    Unknown {
        /// `law`, `wood` or `nail`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The most similar name, if one is close.
        nearest: Option<&'static str>,
        /// All names.
        known: String,
    },
    /// A table that cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    #[diagnostic(help("{help}"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Message of the operating system.
        cause: String,
        /// The remedy.
        help: String,
    },
    /// Measured drives that cannot be used.
    #[error("{}, line {line}: {problem}", path.display())]
    #[diagnostic(help("{help}"))]
    Data {
        /// The file.
        path: PathBuf,
        /// The line, starting at 1.
        line: usize,
        /// The fault.
        problem: String,
        /// The remedy.
        help: String,
    },
    /// A recording in a universal file that cannot be read.
    #[error("{cause}")]
    #[diagnostic(help(
        "write displacement and force as datasets 58 of real values, or give a CSV file: time_s,depth_m,force_n"
    ))]
    Universal {
        /// The cause, with file and line.
        cause: String,
    },
    /// A text that is not a form of a law.
    #[error(transparent)]
    #[diagnostic(help("{}", _0.remedy()))]
    Form(#[from] FormError),
    /// Drives that do not determine a law.
    #[error("{}{}: {source}", path.display(), line.map_or_else(String::new, |line| format!(", line {line}")))]
    #[diagnostic(help("{}", source.remedy()))]
    Fit {
        /// The file of the drives.
        path: PathBuf,
        /// The line of the drive that caused the error, if any.
        line: Option<usize>,
        /// The cause.
        source: FitError,
    },
    /// A file that does not contain a fitted law.
    #[error("{}{} contains no fitted law: {problem}", path.display(),
        line.map_or_else(String::new, |line| format!(", line {line},")))]
    #[diagnostic(help("make it with `nailnoise penetration fit`"))]
    Law {
        /// The file.
        path: PathBuf,
        /// The line, if it is known.
        line: Option<usize>,
        /// The fault.
        problem: String,
    },
    /// A condition outside the range of the data of a law.
    #[error("{}: {variable} is {value:.6}, beyond the range of the fit, {:.6} to \
        {:.6}", path.display(), range[0], range[1])]
    #[diagnostic(help(
        "drive nails under conditions that include this one, or fit again with `nailnoise penetration fit \
         --extrapolate` to \
         allow it"
    ))]
    Beyond {
        /// The file of the law.
        path: PathBuf,
        /// The variable.
        variable: &'static str,
        /// Its value.
        value: f64,
        /// The range of the data.
        range: [f64; 2],
    },
    /// A file that does not contain a law.
    #[error("{} contains no penetration law", path.display())]
    #[diagnostic(help("a line has a depth in m and a force in N; depths increase from 0"))]
    Table {
        /// The file.
        path: PathBuf,
        /// The fault.
        source: TableError,
    },
    /// Values for which no test plan exists.
    #[error(transparent)]
    #[diagnostic(help("give masses in kg and the energy of the middle level in J; lighter projectiles fly faster"))]
    Plan(#[from] PlanError),
    /// A shot of the test machine that cannot be computed.
    #[error(transparent)]
    #[diagnostic(help("{}", _0.remedy()))]
    Machine(#[from] MachineError),
    /// A law that cannot be evaluated.
    #[error(transparent)]
    #[diagnostic(help("{}", _0.remedy()))]
    Curve(#[from] CurveError),
}

/// Columns of recordings of drives and of laws.
const TIME: ColumnOf = ColumnOf {
    name: "time",
    dimension: dimension::TIME,
};
const DEPTH: ColumnOf = ColumnOf {
    name: "depth",
    dimension: dimension::LENGTH,
};
const FORCE: ColumnOf = ColumnOf {
    name: "force",
    dimension: dimension::FORCE,
};

/// Maximum size of a table \[byte\].
const LARGEST_TABLE: u64 = 16 << 20;

pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read_regular(path, LARGEST_TABLE)?;
    String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

fn unreadable(path: &Path, cause: &io::Error, help: &str) -> PenetrationError {
    PenetrationError::Unreadable {
        path: path.to_owned(),
        cause: cause.to_string(),
        help: help.to_owned(),
    }
}

impl PenetrationError {
    /// The error of a table that cannot be read. `help` applies to faults in lines; `otherwise` is the line for other
    /// faults.
    pub(crate) fn of_table(path: &Path, fault: TableFault, otherwise: usize, help: &str) -> Self {
        let (line, problem, help) = match fault {
            TableFault::Line { line, problem, .. } => (line, problem, help.to_owned()),
            TableFault::Foreign(foreign) => (otherwise, format!("it is {}", foreign.name), foreign.remedy.to_owned()),
            fault => (otherwise, fault.to_string(), help.to_owned()),
        };
        Self::Data {
            path: path.to_owned(),
            line,
            problem,
            help,
        }
    }
}

pub(crate) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    read_regular(path, LARGEST_TABLE)
}

/// Reads a fitted law, as written by `nailnoise penetration fit`.
///
/// # Errors
/// [`PenetrationError::Unreadable`] or [`PenetrationError::Law`] with the file and, if known, the line.
pub fn fitted(path: &Path) -> Result<FittedLaw, PenetrationError> {
    let text =
        read_text(path).map_err(|cause| unreadable(path, &cause, "name a file made by `nailnoise penetration fit`"))?;
    toml::from_str(&text).map_err(|error: toml::de::Error| PenetrationError::Law {
        path: path.to_owned(),
        line: error
            .span()
            .map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count()),
        problem: error.message().to_owned(),
    })
}

/// Content of `fit.toml`, as [`fitted`] reads it.
///
/// # Errors
/// [`PenetrationError::Law`] for a law that cannot be written.
pub fn file_of(law: &FittedLaw) -> Result<String, PenetrationError> {
    let text = toml::to_string(law).map_err(|error| PenetrationError::Law {
        path: PathBuf::from("fit.toml"),
        line: None,
        problem: error.to_string(),
    })?;
    Ok(format!(
        "# Penetration law fitted by nailnoise penetration fit: F_r = H_M NL max(0, s)^2, s = sum of coefficient x \
         term.\n\
         # In a design: wood.penetration_law = \"fitted\" and wood.penetration_fit = \"fit.toml\".\n\
         # Covariance and standard errors allow for deviations common to a drive; sigma_* are of s.\n\n{text}"
    ))
}

/// Reads a law from a CSV file of depths \[m\] and forces \[N\].
///
/// # Errors
/// [`PenetrationError::Unreadable`] or [`PenetrationError::Table`] with the file.
pub fn table(path: &Path) -> Result<ForceTable, PenetrationError> {
    let help = "name a table of depths and forces";
    let bytes = read_bytes(path).map_err(|cause| unreadable(path, &cause, help))?;
    force_table(&bytes, path)
}

/// Reads a law from the bytes of a table; `path` is for messages. Columns are in m and N unless their headings have
/// other units, such as `depth [mm]`; without headings, the first two columns are depth and force.
///
/// # Errors
/// [`PenetrationError::Data`] with the line, or [`PenetrationError::Table`].
pub fn force_table(bytes: &[u8], path: &Path) -> Result<ForceTable, PenetrationError> {
    let help = "give two numbers a line, depth in m and force in N";
    let wrong = |fault: TableFault| PenetrationError::of_table(path, fault, 1, help);
    let table = Table::without_headings(bytes).map_err(wrong)?;
    let named = |of| table.headings.iter().position(|heading| heading.is_of(of));
    let places = match (named(DEPTH), named(FORCE)) {
        (Some(depth), Some(force)) => [depth, force],
        // Headings of the user's own without units, or no headings.
        _ => [0, 1],
    };
    let mut columns = table.columns(&places).map_err(wrong)?.values.into_iter();
    let mut column = |place: usize, of: ColumnOf| -> Result<Vec<f64>, PenetrationError> {
        let heading = &table.headings[places[place]];
        let factor = heading.factor(of).map_err(|problem| {
            let problem = format!("the unit of \"{}\": {problem}", heading.text);
            wrong(TableFault::Line {
                line: table.line,
                column: None,
                problem,
            })
        })?;
        let values = columns.next().unwrap_or_default().into_iter();
        Ok(values.map(|value| factor * value).collect())
    };
    let (depths, forces) = (column(0, DEPTH)?, column(1, FORCE)?);
    ForceTable::new(depths, forces).map_err(|source| PenetrationError::Table {
        path: path.to_owned(),
        source,
    })
}

/// The published law with this name; case, hyphens and spaces do not matter.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn law(name: &str) -> Result<PenetrationLaw, PenetrationError> {
    find("law", name, PenetrationLaw::ALL, |law| law.as_str()).copied()
}

/// The wood with this name from the published tests.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn wood(name: &str) -> Result<&'static WoodKind, PenetrationError> {
    find("wood", name, &WOODS, |wood| wood.name)
}

/// The nail with this penny size from the published tests.
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

//! Design files as text, and the chain of files from which one inherits.

use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use nailnoise_documents::{Document, Place, found, read_regular};
use toml::de::{DeTable, DeValue};

use super::error::{DesignError, Problem, Warning};
use crate::shipped;

/// Name of the command line as a place of errors and entries.
pub(super) const COMMAND_LINE: &str = "command line";

/// Maximum size of a design file \[byte\].
const LARGEST: u64 = 4 << 20;

/// The text of one design file.
#[derive(Debug)]
pub(crate) struct File {
    document: Document,
    /// Whether it comes with the program instead of being read from a file.
    is_shipped: bool,
}

impl File {
    pub(crate) fn new(path: &Path, text: &str) -> Self {
        Self {
            document: Document::new(path, text),
            is_shipped: false,
        }
    }

    /// The design with this file name that comes with the program.
    pub(crate) fn shipped(name: &str) -> Option<Self> {
        let (path, text) = shipped::design(name).filter(|_| name.ends_with(".toml"))?;
        let path = PathBuf::from(format!("{path} of nailnoise {}", env!("CARGO_PKG_VERSION")));
        Some(Self {
            document: Document::new(&path, text),
            is_shipped: true,
        })
    }

    pub(crate) fn read(path: &Path, at: Option<&Place>) -> Result<Self, DesignError> {
        let bytes = read_regular(path, LARGEST).map_err(|source| DesignError::unreadable(path, source, at))?;
        let document = Document::from_bytes(path, bytes).map_err(|error| DesignError::not_toml(path, error))?;
        Ok(Self {
            document,
            is_shipped: false,
        })
    }

    pub(crate) fn text(&self) -> &str {
        self.document.text()
    }

    fn path(&self) -> &Path {
        self.document.path()
    }

    pub(super) fn document(&self) -> &Document {
        &self.document
    }

    pub(crate) fn place(&self, span: Range<usize>) -> Box<Place> {
        self.document.place(span)
    }

    pub(crate) fn table(&self) -> Result<DeTable<'_>, DesignError> {
        self.document
            .table()
            .map_err(|error| DesignError::not_toml(self.path(), error))
    }

    /// Whether it is a value given on the command line.
    pub(crate) fn is_command_line(&self) -> bool {
        self.path() == Path::new(COMMAND_LINE)
    }

    /// A path relative to the folder of this file.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.document.sibling(name)
    }

    /// The value of `base`.
    fn base(&self) -> Result<Option<(String, Box<Place>)>, DesignError> {
        let table = self.table()?;
        let Some((key, value)) = table.get_key_value("base") else {
            return Ok(None);
        };
        let place = self.place(key.span().start..value.span().end);
        let DeValue::String(name) = value.get_ref() else {
            return Err(Problem::WrongKind {
                key: "base".to_owned(),
                found: found(value.get_ref()),
                expected: "as the name of a design file, in quotes".to_owned(),
            }
            .at(place));
        };
        Ok(Some((name.as_ref().to_owned(), place)))
    }

    /// The path of a base, relative to the folder of this file.
    fn base_path(&self, name: &str) -> PathBuf {
        let folder = self.path().parent().unwrap_or(Path::new(""));
        tidy(&folder.join(name))
    }

    /// The file of the base, if there is a base.
    pub(crate) fn base_file(&self) -> Option<PathBuf> {
        let (name, _) = self.base().ok()??;
        Some(self.base_path(&name))
    }

    /// Reads the base with this name. If no such file exists, or for bases of shipped designs, it is the design with
    /// this name that comes with the program.
    fn read_base(&self, name: &str, at: &Place) -> Result<Self, DesignError> {
        if self.is_shipped
            && let Some(base) = Self::shipped(shipped::file_name(name))
        {
            return Ok(base);
        }
        let path = self.base_path(name);
        let absent = || fs::symlink_metadata(&path).is_err_and(|error| error.kind() == ErrorKind::NotFound);
        match Self::shipped(name) {
            Some(base) if absent() => Ok(base),
            _ => Self::read(&path, Some(at)),
        }
    }

    /// This file and those it inherits from, nearest first.
    pub(crate) fn chain(self) -> Result<Vec<Self>, DesignError> {
        let mut chain = vec![self];
        let mut seen: Vec<PathBuf> = chain.iter().map(|file| identity(file.path())).collect();
        while let Some((name, at)) = chain[chain.len() - 1].base()? {
            let base = &chain[chain.len() - 1];
            // Checked before the file is read, because a loop is the more direct cause.
            let own = identity(&base.base_path(&name));
            if !base.is_shipped
                && let Some(first) = seen.iter().position(|other| *other == own)
            {
                let path = base.base_path(&name);
                let names = chain[first..].iter().map(File::path).chain([path.as_path()]);
                let chain = names.map(|path| path.display().to_string()).collect();
                return Err(Problem::InheritanceLoop { chain }.at(at));
            }
            seen.push(own);
            let base = base.read_base(&name, &at)?;
            chain.push(base);
        }
        Ok(chain)
    }

    /// Warning that a base was not found and the one that comes with the program is used.
    pub(crate) fn shipped_base(chain: &[Self]) -> Option<Warning> {
        let pair = chain
            .windows(2)
            .find(|pair| !pair[0].is_shipped && pair[1].is_shipped)?;
        let (name, at) = pair[0].base().ok()??;
        Some(Warning::ShippedBase { name, at })
    }
}

/// The path without `a/..`, if it refers to the same folder; `..` after a symbolic link may not.
fn tidy(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for part in path.components() {
        match (part, tidy.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => {
                tidy.pop();
            }
            (Component::CurDir, _) => {}
            _ => tidy.push(part),
        }
    }
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        fs::canonicalize(parent.unwrap_or(Path::new("."))).ok()
    };
    match (folder(&tidy), folder(path)) {
        (Some(own), Some(other)) if own == other => tidy,
        _ => path.to_owned(),
    }
}

/// A unique name for a file, however its path is written.
fn identity(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

//! Places in documents.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use miette::{LabeledSpan, NamedSource, SourceCode};

/// A location in a document, for error messages.
#[derive(Debug, Clone)]
pub struct Place {
    pub(crate) source: NamedSource<Arc<str>>,
    pub(crate) span: Range<usize>,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// Places are equal if their files and byte ranges are.
impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        self.file() == other.file() && self.span == other.span
    }
}

impl Place {
    /// The file as given.
    pub fn file(&self) -> &str {
        self.source.name()
    }

    /// Line, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        self.column
    }

    /// Its byte range in the text.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The text of the document, for a message that shows the place.
    pub fn source_code(&self) -> &dyn SourceCode {
        &self.source
    }

    /// The place with a label, for a message that shows it.
    pub fn label(&self, label: &str) -> LabeledSpan {
        LabeledSpan::new_with_span(Some(label.to_owned()), self.span())
    }
}

/// `file:line:column`.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file(), self.line, self.column)
    }
}

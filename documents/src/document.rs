//! TOML documents: the text of a file and its path.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use memchr::memchr_iter;
use miette::NamedSource;
use toml::Spanned;
use toml::de::DeTable;

use super::place::Place;

/// The text of a TOML file.
#[derive(Debug, Clone)]
pub struct Document {
    path: PathBuf,
    text: Arc<str>,
}

/// Why a file cannot be read as a TOML document.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DocumentError {
    /// The file is not UTF-8.
    #[error("line {line} holds bytes that are not UTF-8")]
    NotText {
        /// Line of the first invalid byte, from 1.
        line: usize,
    },
    /// The text is not valid TOML.
    #[error("this is not TOML: {message}")]
    Syntax {
        /// Message of the parser.
        message: String,
        /// Location of the error.
        at: Box<Place>,
    },
}

impl Document {
    /// Creates a document from text. `path` appears in messages, and file names in the text are relative to its folder.
    pub fn new(path: &Path, text: &str) -> Self {
        // A byte order mark must not become part of the first key.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self {
            path: path.to_owned(),
            text: text.into(),
        }
    }

    /// Decodes the content of a file.
    ///
    /// # Errors
    /// [`DocumentError::NotText`].
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, DocumentError> {
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self::new(path, &text)),
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
                Err(DocumentError::NotText { line })
            }
        }
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text, without a byte order mark.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Path of a file that is named relative to the folder of this one.
    pub fn sibling(&self, name: &str) -> PathBuf {
        self.path.with_file_name("").join(name)
    }

    /// The place of a span of bytes, trimmed to character boundaries.
    pub fn place(&self, span: Range<usize>) -> Box<Place> {
        let start = (0..=span.start.min(self.text.len()))
            .rev()
            .find(|at| self.text.is_char_boundary(*at))
            .unwrap_or(0);
        let end = span.end.clamp(start, self.text.len());
        let before = &self.text[..start];
        let line = memchr_iter(b'\n', before.as_bytes()).count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        let source = NamedSource::new(self.path.to_string_lossy(), Arc::clone(&self.text)).with_language("TOML");
        Box::new(Place {
            source,
            span: start..end,
            line,
            column,
        })
    }

    /// Parses the text into its keys with their spans.
    ///
    /// # Errors
    /// [`DocumentError::Syntax`].
    pub fn table(&self) -> Result<DeTable<'_>, DocumentError> {
        let table = DeTable::parse(&self.text).map(Spanned::into_inner);
        table.map_err(|error| DocumentError::Syntax {
            message: error.message().to_owned(),
            at: self.place(error.span().unwrap_or(0..0)),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_place_is_a_line_and_a_column_in_characters() {
        let document = Document::new(Path::new("a.toml"), "\u{feff}a = 1\n\"é\" = 2\n");
        let text = "a = 1\n\"é\" = 2\n";
        let place = document.place(text.find('2').unwrap()..text.len());
        assert_eq!(
            (place.file(), place.line(), place.column(), place.to_string().as_str()),
            ("a.toml", 2, 7, "a.toml:2:7")
        );
        let within = text.find('é').unwrap() + 1;
        assert_eq!(
            document.place(within..within + 1).column(),
            2,
            "a span that begins within a character"
        );
    }

    #[test]
    fn bytes_that_are_not_text_and_text_that_is_not_toml_name_their_line() {
        let path = Path::new("a.toml");
        let not_text = Document::from_bytes(path, b"a = 1\nb = \xff".to_vec()).unwrap_err();
        assert_eq!(not_text, DocumentError::NotText { line: 2 });
        let document = Document::from_bytes(path, b"a = 1\nb = = 2\n".to_vec()).unwrap();
        match document.table().unwrap_err() {
            DocumentError::Syntax { at, .. } => assert_eq!(at.line(), 2),
            other => panic!("{other}"),
        }
    }
}

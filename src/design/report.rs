//! `[report]` of a design file: texts in the head of the report, apart from the design.
//!
//! ```toml
//! [report]
//! title = "Framing nailer, second prototype"
//! client = "Example Tools Ltd"
//! author = "A. Engineer"
//! revision = "B"
//! note = "Exhaust with twelve holes"
//! ```
//!
//! It changes neither a value of the design nor its digest, because no stage reads it.

use serde::Serialize;
use toml::de::{DeTable, DeValue};

use super::error::{DesignError, Problem};
use super::source::File;
use nailnoise_documents::{found, nearest};

/// Maximum number of characters of a text: it appears in the head of a page.
const LONGEST: usize = 2000;

/// Texts in the head of the report; empty texts are left out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct ReportSettings {
    /// Heading in place of the name of the design.
    pub title: String,
    /// The client.
    pub client: String,
    /// The responsible author.
    pub author: String,
    /// Revision of the design or of the report.
    pub revision: String,
    /// A remark below the head.
    pub note: String,
}

/// The keys with their descriptions.
pub(super) const KEYS: [(&str, &str); 5] = [
    ("title", "Heading of the report in place of the name of the design."),
    ("client", "For whom the report is."),
    ("author", "Who is responsible for the report."),
    ("revision", "Revision of the design or of the report."),
    ("note", "A remark below the head of the report."),
];

impl ReportSettings {
    fn text(&mut self, key: &str) -> Option<&mut String> {
        Some(match key {
            "title" => &mut self.title,
            "client" => &mut self.client,
            "author" => &mut self.author,
            "revision" => &mut self.revision,
            "note" => &mut self.note,
            _ => return None,
        })
    }

    /// Reads the texts in `[report]` of a file, which replace those of its bases.
    pub(super) fn read(&mut self, file: &File, table: &DeTable<'_>) -> Result<(), DesignError> {
        let Some(value) = table.get("report") else {
            return Ok(());
        };
        let wrong = |key: &str, value: &toml::Spanned<DeValue<'_>>, expected: String| {
            Problem::WrongKind {
                key: key.to_owned(),
                found: found(value.get_ref()),
                expected,
            }
            .at(file.place(value.span()))
        };
        let DeValue::Table(own) = value.get_ref() else {
            return Err(wrong("report", value, "as a group of keys: [report]".to_owned()));
        };
        for (name, value) in own {
            let key = name.get_ref().as_ref();
            let full = format!("report.{key}");
            let Some(text) = self.text(key) else {
                let known = KEYS.map(|(key, _)| key.to_owned()).to_vec();
                return Err(Problem::UnknownKey {
                    nearest: nearest(known.iter().map(String::as_str), key).map(|near| format!("report.{near}")),
                    key: full,
                    known,
                }
                .at(file.place(name.span())));
            };
            match value.get_ref() {
                DeValue::String(given) if given.chars().count() <= LONGEST => *text = given.to_string(),
                DeValue::String(_) => {
                    return Err(wrong(
                        &full,
                        value,
                        format!("as a text of {LONGEST} characters at most"),
                    ));
                }
                _ => return Err(wrong(&full, value, "as text in quotes".to_owned())),
            }
        }
        Ok(())
    }
}

//! Datasets of a universal file: their lines, and the numbers in them.

use std::path::{Path, PathBuf};

/// Errors in a universal file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UffError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check its name and that it may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A line does not match its dataset's format.
    #[error("{}, line {line}, dataset {dataset}: expected {expected}, found \"{found}\"", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The dataset.
        dataset: u64,
        /// Expected content.
        expected: &'static str,
        /// The text found.
        found: String,
    },
    /// The end of a dataset is missing.
    #[error("{}: dataset {dataset} of line {line} has no end (-1); the file is cut off", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Line at which it begins, from 1.
        line: usize,
        /// Its number.
        dataset: u64,
    },
    /// A dataset has an unsupported form.
    #[error("{}, line {line}: dataset {dataset} is {found}; write it as {expected}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Line at which it begins, from 1.
        line: usize,
        /// Its number.
        dataset: u64,
        /// Form found.
        found: &'static str,
        /// Supported forms.
        expected: &'static str,
    },
    /// A binary dataset contains a number that is not finite.
    #[error("{}, line {line}, dataset {dataset}: sample {sample} is {value}, which is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Line at which it begins, from 1.
        line: usize,
        /// Its number.
        dataset: u64,
        /// Index of the sample, from 1.
        sample: usize,
        /// Its value.
        value: f64,
    },
    /// A node refers to a coordinate system that the file does not define.
    #[error(
        "{}, line {line}, dataset {dataset}: the node names coordinate system {system}, which the file does not give \
         (known: \
         {known}); export the coordinate systems as well (dataset 18 or 2420), or the nodes in global axes (system \
         0)", path.display()
    )]
    NoSystem {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The dataset.
        dataset: u64,
        /// The label of the system.
        system: u64,
        /// The labels defined, comma separated, or `none`.
        known: String,
    },
    /// A coordinate system is not connected to the global one by its reference systems.
    #[error(
        "{}: coordinate system {system} has a reference system that leads back to itself or is not Cartesian; give it \
         in terms of a \
         Cartesian one", path.display()
    )]
    Reference {
        /// The file.
        path: PathBuf,
        /// The label of the system.
        system: u64,
    },
    /// The file contains no modes.
    #[error(
        "{} has no mode shapes: no dataset 55 with normal modes (2) or complex ones (3, \
         7){}", path.display(), others(*analyses)
    )]
    NoModes {
        /// The file.
        path: PathBuf,
        /// Number of datasets 2414.
        analyses: usize,
    },
}

/// Mentions datasets that are not read but may contain modes from a simulation.
fn others(analyses: usize) -> String {
    match analyses {
        0 => String::new(),
        _ => format!(
            "; it has {analyses} of dataset 2414 (analysis data), which is not read: export the mode shapes as \
             dataset 55"
        ),
    }
}

/// Lines of one dataset.
pub(super) struct Block<'a> {
    pub(super) path: &'a Path,
    pub(super) dataset: u64,
    /// Number of its first line in the file, from 1.
    pub(super) first: usize,
    pub(super) lines: &'a [&'a str],
}

/// A dataset of a file; its text is decoded only when it is read.
pub(super) struct Dataset<'a> {
    pub(super) number: u64,
    /// Number of its first line in the file, from 1.
    first: usize,
    text: &'a [u8],
    /// The bytes that follow the lines of a binary dataset.
    pub(super) binary: Option<Binary<'a>>,
    /// Why it cannot be read; other datasets of the file may still be readable.
    damage: Option<Damage>,
}

/// Why a dataset cannot be read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Damage {
    /// Its end is missing.
    CutOff,
    /// A binary dataset whose header does not give its length.
    Length,
}

/// Data of a binary dataset.
#[derive(Clone, Copy)]
pub(super) struct Binary<'a> {
    /// 1 least significant byte first, 2 most significant byte first.
    pub(super) order: u64,
    /// 1 DEC VMS, 2 IEEE 754, 3 IBM 5/370.
    pub(super) format: u64,
    pub(super) bytes: &'a [u8],
}

impl Dataset<'_> {
    /// Whether the file ends within it, so that later datasets may be missing.
    pub(super) fn is_cut_off(&self) -> bool {
        self.damage == Some(Damage::CutOff)
    }

    /// Calls `read` with the lines, decoded from UTF-8 or Windows-1252.
    pub(super) fn read<T>(
        &self,
        path: &Path,
        read: impl FnOnce(&Block<'_>) -> Result<T, UffError>,
    ) -> Result<T, UffError> {
        let (path_of, line) = (|| path.to_owned(), self.first - 2);
        match self.damage {
            Some(Damage::CutOff) => {
                return Err(UffError::Truncated {
                    path: path_of(),
                    line,
                    dataset: self.number,
                });
            }
            Some(Damage::Length) => {
                return Err(UffError::Form {
                    path: path_of(),
                    line,
                    dataset: self.number,
                    found: "binary, and its header does not say how many lines and bytes it has",
                    expected: "58b with byte order, format, lines and bytes, or as text",
                });
            }
            None => {}
        }
        let text = nailnoise_documents::text::characters(self.text);
        let lines: Vec<&str> = text.lines().collect();
        read(&Block {
            path,
            dataset: self.number,
            first: self.first,
            lines: &lines,
        })
    }
}

/// Reads the lines of a file one by one.
struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the current line, from 1.
    line: usize,
}

impl<'a> Walk<'a> {
    /// The next line, including its line end; none at the end of the file.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let length = rest
            .iter()
            .position(|byte| *byte == b'\n')
            .map_or(rest.len(), |end| end + 1);
        self.at += length;
        self.line += 1;
        Some(&rest[..length])
    }

    /// The next `count` bytes.
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes[self.at..].get(..count)?;
        self.at += count;
        self.line += taken.iter().filter(|byte| **byte == b'\n').count();
        Some(taken)
    }
}

fn is_end(line: &[u8]) -> bool {
    line.trim_ascii() == b"-1"
}

/// The datasets of a file, in order. An error in a dataset is reported when it is read, not here.
pub(super) fn datasets(bytes: &[u8]) -> Vec<Dataset<'_>> {
    let mut walk = Walk { bytes, at: 0, line: 1 };
    let mut datasets = Vec::new();
    // Some programs write a byte order mark.
    walk.at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    while let Some(line) = walk.next() {
        if !is_end(line) {
            continue;
        }
        let Some(header) = walk.next() else { break };
        let header = String::from_utf8_lossy(header);
        let mut words = header.split_whitespace();
        let word = words.next().unwrap_or("");
        let number = word.trim_end_matches('b').parse().unwrap_or(0);
        let (first, start) = (walk.line, walk.at);
        let mut fields: Vec<Option<u64>> = words.map(|word| word.parse().ok()).collect();
        let is_binary = word.ends_with('b') || (number == 58 && fields.len() > 1);
        fields.resize(4, None);
        let dataset = |text, binary, damage| Dataset {
            number,
            first,
            text,
            binary,
            damage,
        };
        if let ([Some(order), Some(format), Some(lines), Some(length)], true) = (&fields[..4], is_binary) {
            let whole = (0..*lines).all(|_| walk.next().is_some());
            let text = &bytes[start..walk.at];
            let content = usize::try_from(*length).ok().filter(|_| whole);
            let content = content.and_then(|length| walk.take(length));
            // Some programs end the line after the bytes, others do not.
            let end = std::iter::from_fn(|| walk.next()).find(|line| !line.trim_ascii().is_empty());
            match content.filter(|_| end.is_some_and(is_end)) {
                Some(content) => {
                    let binary = Binary {
                        order: *order,
                        format: *format,
                        bytes: content,
                    };
                    datasets.push(dataset(text, Some(binary), None));
                }
                None => {
                    datasets.push(dataset(text, None, Some(Damage::CutOff)));
                    break;
                }
            }
            continue;
        }
        let (mut at, mut ended) = (walk.at, false);
        while let Some(line) = walk.next() {
            ended = is_end(line);
            if ended {
                break;
            }
            at = walk.at;
        }
        let damage = match (ended, is_binary) {
            (false, _) => Some(Damage::CutOff),
            (true, true) => Some(Damage::Length),
            (true, false) => None,
        };
        datasets.push(dataset(&bytes[start..at], None, damage));
    }
    datasets
}

impl Block<'_> {
    /// An error concerning a complete line.
    pub(super) fn error(&self, line: usize, expected: &'static str) -> UffError {
        self.unexpected(line, expected, self.lines.get(line).unwrap_or(&""))
    }

    /// An error concerning part of a line.
    pub(super) fn unexpected(&self, line: usize, expected: &'static str, found: &str) -> UffError {
        UffError::Line {
            path: self.path.to_owned(),
            line: self.first + line,
            dataset: self.dataset,
            expected,
            found: found.trim().chars().take(60).collect(),
        }
    }

    /// Parses the numbers of a line, with `D` also accepted in exponents; fields of width 13 without separators are
    /// split.
    pub(super) fn numbers(&self, line: usize, expected: &'static str) -> Result<Vec<f64>, UffError> {
        let text = self.lines.get(line).ok_or_else(|| self.error(line, expected))?;
        let number = |word: &str| {
            word.trim()
                .replace(['D', 'd'], "E")
                .parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
        };
        let words: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        words
            .or_else(|| {
                let fields: Vec<char> = text.trim_end().chars().collect();
                fields
                    .chunks(13)
                    .map(|field| number(&field.iter().collect::<String>()))
                    .collect()
            })
            .ok_or_else(|| self.error(line, expected))
    }
}

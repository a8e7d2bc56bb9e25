//! Datasets of a universal file: their lines, and the numbers on them.

use std::path::{Path, PathBuf};

/// What is wrong with a universal file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UffError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check its name and that it may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A line is not what its dataset needs.
    #[error("{}, line {line}, dataset {dataset}: expected {expected}, found \"{found}\"", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The dataset.
        dataset: u64,
        /// What is expected.
        expected: &'static str,
        /// The text found.
        found: String,
    },
    /// A dataset has no end.
    #[error("{}: dataset {dataset} of line {line} has no end (-1); the file is cut off", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Where it begins, from 1.
        line: usize,
        /// Its number.
        dataset: u64,
    },
    /// A dataset in a form that is not read.
    #[error("{}, line {line}: dataset {dataset} is {found}; write it as {expected}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Where it begins, from 1.
        line: usize,
        /// Its number.
        dataset: u64,
        /// What it is.
        found: &'static str,
        /// What is read.
        expected: &'static str,
    },
    /// There is no mode in it.
    #[error("{} has no mode shapes: no dataset 55 with normal modes (2) or complex ones (3, 7)", path.display())]
    NoModes {
        /// The file.
        path: PathBuf,
    },
}

/// Lines of one dataset.
pub(super) struct Block<'a> {
    pub(super) path: &'a Path,
    pub(super) dataset: u64,
    /// Its header has more words than its number: a binary dataset.
    pub(super) binary: bool,
    /// Number of its first line in the file, from 1.
    pub(super) first: usize,
    pub(super) lines: &'a [&'a str],
}

/// The datasets of a file, in their order.
pub(super) fn blocks<'a>(lines: &'a [&'a str], path: &'a Path) -> Result<Vec<Block<'a>>, UffError> {
    let is_end = |line: &str| line.trim() == "-1";
    let mut blocks = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        if !is_end(lines[at]) {
            at += 1;
            continue;
        }
        let Some(header) = lines.get(at + 1) else { break };
        let mut words = header.split_whitespace();
        let dataset = words
            .next()
            .and_then(|word| word.trim_end_matches('b').parse().ok())
            .unwrap_or(0);
        let binary = header.contains('b') || words.next().is_some();
        let Some(length) = lines[at + 2..].iter().position(|line| is_end(line)) else {
            return Err(UffError::Truncated {
                path: path.to_owned(),
                line: at + 1,
                dataset,
            });
        };
        blocks.push(Block {
            path,
            dataset,
            binary,
            first: at + 3,
            lines: &lines[at + 2..at + 2 + length],
        });
        at += length + 3;
    }
    Ok(blocks)
}

impl Block<'_> {
    pub(super) fn error(&self, line: usize, expected: &'static str) -> UffError {
        UffError::Line {
            path: self.path.to_owned(),
            line: self.first + line,
            dataset: self.dataset,
            expected,
            found: self
                .lines
                .get(line)
                .map_or_else(String::new, |text| text.trim().chars().take(60).collect()),
        }
    }

    /// Numbers of one line, with `D` as an exponent; fields of 13 that have run together are taken apart.
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

//! Reads words and bytes of a `.msh` file, and tracks the current section for messages.

use super::MshError;

/// Length limit of a section name; gmsh's own have at most 20 bytes.
const LONGEST_NAME: usize = 80;

/// How numbers are encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Decimal text.
    Text,
    /// Binary in the byte order of the file.
    Binary {
        /// Whether the byte order is big-endian, the opposite of the reader's.
        swapped: bool,
        /// Size of a `size_t` \[bytes\].
        size: usize,
    },
}

/// A position in the file.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    section: String,
    pub(super) encoding: Encoding,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            section: "MeshFormat".to_owned(),
            encoding: Encoding::Text,
        }
    }

    /// Skips white space and reads the name of the section that starts here, without its `$`; none at the end of the
    /// file.
    pub(super) fn open(&mut self) -> Result<Option<String>, MshError> {
        self.skip_space();
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        // A replacement character may be longer than the byte it replaces, so the length of the text is not that of the
        // word.
        let name = std::str::from_utf8(&rest[..length])
            .ok()
            .and_then(|word| word.strip_prefix('$'));
        let Some(name) = name.filter(|name| name.len() < LONGEST_NAME) else {
            return Err(MshError::SectionEnd {
                section: self.section.clone(),
                byte: self.at,
            });
        };
        self.section = name.to_owned();
        self.at += length;
        self.end_of_line();
        Ok(Some(name.to_owned()))
    }

    /// The word that ends the section; version 1 uses capitals.
    fn end(&self) -> String {
        let of_version_1 = matches!(self.section.as_str(), "NOD" | "ELM");
        format!("{}{}", if of_version_1 { "$END" } else { "$End" }, self.section)
    }

    /// Reads the end of the section.
    pub(super) fn close(&mut self) -> Result<(), MshError> {
        self.skip_space();
        let end = self.end();
        if self.bytes[self.at..].starts_with(end.as_bytes()) {
            self.at += end.len();
            return Ok(());
        }
        Err(if self.at == self.bytes.len() {
            self.truncated()
        } else {
            MshError::SectionEnd {
                section: self.section.clone(),
                byte: self.at,
            }
        })
    }

    /// Skips the rest of the section.
    pub(super) fn skip_section(&mut self) -> Result<(), MshError> {
        let end = self.end().into_bytes();
        let found = self.bytes[self.at..]
            .windows(end.len().max(1))
            .position(|window| window == end.as_slice());
        let Some(offset) = found else {
            return Err(self.truncated());
        };
        self.at += offset + end.len();
        Ok(())
    }

    /// The next word.
    pub(super) fn word(&mut self) -> Result<&'a str, MshError> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.truncated());
        }
        let word = &rest[..length];
        match std::str::from_utf8(word) {
            Ok(word) => {
                self.at += length;
                Ok(word)
            }
            Err(_) => Err(self.number(&String::from_utf8_lossy(word), "text")),
        }
    }

    /// The next integer written as text, whatever the encoding.
    pub(super) fn text_integer(&mut self) -> Result<i64, MshError> {
        let word = self.word()?;
        word.parse().map_err(|_| self.number(word, "a whole number"))
    }

    /// Reads the rest of a name in double quotes; embedded quotes are retained.
    pub(super) fn quoted(&mut self) -> Result<String, MshError> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let line = &rest[..rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())];
        let text = String::from_utf8_lossy(line).trim().to_owned();
        let name = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        let Some(name) = name.filter(|_| text.len() >= 2) else {
            return Err(self.number(&text, "a name in double quotes"));
        };
        self.at += line.len();
        Ok(name.to_owned())
    }

    /// Reads an `int`.
    pub(super) fn int(&mut self) -> Result<i64, MshError> {
        match self.encoding {
            Encoding::Text => self.text_integer(),
            Encoding::Binary { swapped, .. } => {
                let bytes = self.take::<4>(swapped)?;
                Ok(i64::from(i32::from_le_bytes(bytes)))
            }
        }
    }

    /// Reads a `size_t`.
    pub(super) fn size(&mut self) -> Result<u64, MshError> {
        match self.encoding {
            Encoding::Text => {
                let word = self.word()?;
                word.parse()
                    .map_err(|_| self.number(word, "a whole number that is not negative"))
            }
            Encoding::Binary { swapped, size: 4 } => Ok(u64::from(u32::from_le_bytes(self.take(swapped)?))),
            Encoding::Binary { swapped, .. } => Ok(u64::from_le_bytes(self.take(swapped)?)),
        }
    }

    /// Reads a `double`.
    pub(super) fn double(&mut self) -> Result<f64, MshError> {
        match self.encoding {
            Encoding::Text => {
                let word = self.word()?;
                word.parse().map_err(|_| self.number(word, "a number"))
            }
            Encoding::Binary { swapped, .. } => Ok(f64::from_le_bytes(self.take(swapped)?)),
        }
    }

    /// Converts `count` to a number of items of at least `bytes` bytes each. Rejects it if the rest of the file is too
    /// short, so that a damaged count does not allocate memory.
    pub(super) fn count(&self, what: &'static str, count: u64, bytes: usize) -> Result<usize, MshError> {
        let left = self.bytes.len() - self.at;
        usize::try_from(count)
            .ok()
            .filter(|&items| items <= left / bytes.max(1))
            .ok_or_else(|| MshError::Count {
                section: self.section.clone(),
                what,
                count,
                bytes: left,
            })
    }

    /// Minimum size of a number: `binary` bytes, or a digit and a space.
    pub(super) fn least(&self, binary: usize) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { .. } => binary,
        }
    }

    /// Size of a `size_t`, or the minimum size of a number in text \[bytes\].
    pub(super) fn size_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { size, .. } => size,
        }
    }

    /// The rest of this line, without its line end.
    pub(super) fn line(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        String::from_utf8_lossy(&rest[..length]).trim().to_owned()
    }

    /// Reads four bytes as stored.
    pub(super) fn raw_four(&mut self) -> Result<[u8; 4], MshError> {
        self.take::<4>(false)
    }

    /// Moves past the end of this line.
    pub(super) fn end_of_line(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            self.at += 1;
            if byte == b'\n' {
                break;
            }
        }
    }

    /// The error that the file ends here.
    pub(super) fn truncated(&self) -> MshError {
        MshError::Truncated {
            section: self.section.clone(),
            byte: self.bytes.len(),
        }
    }

    fn number(&self, found: &str, expected: &'static str) -> MshError {
        const SHOWN: usize = 40;
        let mut shown: String = found.chars().take(SHOWN).collect();
        if found.chars().count() > SHOWN {
            shown.push_str("...");
        }
        MshError::Number {
            line: 1 + self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count(),
            section: self.section.clone(),
            found: shown,
            expected,
        }
    }

    fn take<const N: usize>(&mut self, swapped: bool) -> Result<[u8; N], MshError> {
        let Some(slice) = self.bytes.get(self.at..self.at + N) else {
            return Err(self.truncated());
        };
        let mut bytes = [0; N];
        bytes.copy_from_slice(slice);
        if swapped {
            bytes.reverse();
        }
        self.at += N;
        Ok(bytes)
    }

    fn skip_space(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }
}

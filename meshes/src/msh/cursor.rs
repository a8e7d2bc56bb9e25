//! Words and bytes of a `.msh` file, with the section they are in for messages.

use super::MshError;

/// Bytes of the longest section name; gmsh's own have at most 20.
const LONGEST_NAME: usize = 80;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Decimal text.
    Text,
    /// Binary of the file's own byte order.
    Binary {
        /// Whether the bytes of a number are in the order opposite to this reader's, which is little-endian.
        swapped: bool,
        /// Bytes of a `size_t`.
        size: usize,
    },
}

/// A place in the file.
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

    /// Skips white space and gives the section that begins here, without its `$`; none at the end of the file.
    pub(super) fn open(&mut self) -> Result<Option<String>, MshError> {
        self.skip_space();
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        // A replaced character may be longer than its byte, so the text does not give the length of the word.
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

    /// The word that ends the section; sections of version 1 are in capitals.
    fn end(&self) -> String {
        let of_version_1 = matches!(self.section.as_str(), "NOD" | "ELM");
        format!("{}{}", if of_version_1 { "$END" } else { "$End" }, self.section)
    }

    /// Expects the end of the section.
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

    /// Leaves out the rest of the section.
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

    /// The next word of text.
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

    /// The next whole number of text, whatever the encoding.
    pub(super) fn text_integer(&mut self) -> Result<i64, MshError> {
        let word = self.word()?;
        word.parse().map_err(|_| self.number(word, "a whole number"))
    }

    /// The rest of a name in double quotes; quotes within it are retained.
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

    /// An `int`.
    pub(super) fn int(&mut self) -> Result<i64, MshError> {
        match self.encoding {
            Encoding::Text => self.text_integer(),
            Encoding::Binary { swapped, .. } => {
                let bytes = self.take::<4>(swapped)?;
                Ok(i64::from(i32::from_le_bytes(bytes)))
            }
        }
    }

    /// A `size_t`.
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

    /// A `double`.
    pub(super) fn double(&mut self) -> Result<f64, MshError> {
        match self.encoding {
            Encoding::Text => {
                let word = self.word()?;
                word.parse().map_err(|_| self.number(word, "a number"))
            }
            Encoding::Binary { swapped, .. } => Ok(f64::from_le_bytes(self.take(swapped)?)),
        }
    }

    /// `count` as a number of items that each take at least `bytes` bytes; refused if the file is too short for them,
    /// so that nothing is allocated for a damaged count.
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

    /// Fewest bytes that a number takes: `binary` of them, or a digit and a space.
    pub(super) fn least(&self, binary: usize) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { .. } => binary,
        }
    }

    /// Bytes of a `size_t`, or the fewest that a number of text takes.
    pub(super) fn size_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { size, .. } => size,
        }
    }

    /// The rest of this line, without its end.
    pub(super) fn line(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        String::from_utf8_lossy(&rest[..length]).trim().to_owned()
    }

    /// Four bytes as stored.
    pub(super) fn raw_four(&mut self) -> Result<[u8; 4], MshError> {
        self.take::<4>(false)
    }

    /// Goes behind the end of this line.
    pub(super) fn end_of_line(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            self.at += 1;
            if byte == b'\n' {
                break;
            }
        }
    }

    /// The file ends here.
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

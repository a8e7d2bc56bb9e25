//! The chunks of RIFF files, and of RF64 and BW64 files, whose length may exceed 4 GiB (EBU Tech 3306, ITU-R BS.2088).
//!
//! This reader is needed because hound rejects files that recorders write: chunks of odd length, `fmt ` chunks of 18
//! and 40 bytes whose contents differ from hound's own, and RF64. It also reads 24 bits in 32-bit containers from the
//! wrong end. The licence of symphonia, MPL-2.0, is not allowed by `deny.toml`. This reader is as lenient as
//! libsndfile: it accepts chunks in any order and a missing pad byte, and ignores the file length in the header.

use std::io::{self, Read, Seek, SeekFrom};

/// Chunk lengths that mean "see ds64" or "unknown, to the end of the file".
const UNKNOWN: u32 = u32::MAX;

/// Largest number of chunks in a file; recorders write about ten.
const MOST: usize = 1 << 16;

/// Largest number of bytes read from a `ds64` chunk.
const DS64: usize = 1 << 16;

/// Names of chunks that may follow one of odd length without a pad byte.
const KNOWN: [&[u8]; 12] = [
    b"fmt ", b"data", b"fact", b"LIST", b"bext", b"iXML", b"JUNK", b"PEAK", b"cue ", b"id3 ", b"axml", b"chna",
];

/// A chunk of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    /// Four characters.
    pub(super) name: [u8; 4],
    /// Offset of its content \[byte\].
    pub(super) begin: u64,
    /// Length of its content that is present in the file \[byte\].
    pub(super) found: u64,
    /// Length according to its header \[byte\]; none if the header leaves it open.
    pub(super) length: Option<u64>,
}

/// Whether a file with these first bytes consists of RIFF chunks.
pub(super) fn is_riff(bytes: &[u8]) -> bool {
    [&b"RIFF"[..], b"RF64", b"BW64"]
        .iter()
        .any(|mark| bytes.starts_with(mark))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

fn is_name(name: &[u8]) -> bool {
    name.len() == 4 && name.iter().all(|byte| (b' '..=b'~').contains(byte))
}

/// Chunk lengths in a `ds64` chunk: that of `data`, and those of others by name.
fn long_length(ds64: &[u8], name: [u8; 4]) -> Option<u64> {
    if name == *b"data" {
        return long(ds64, 8);
    }
    let entries = word(ds64, 24).map_or(0, |count| count as usize);
    let table = ds64.get(28..).unwrap_or(&[]);
    table
        .chunks_exact(12)
        .take(entries)
        .find(|entry| entry[..4] == name)
        .and_then(|entry| long(entry, 4))
}

/// A file of chunks; only the requested parts are read.
#[derive(Debug)]
pub(super) struct Riff<R> {
    reader: R,
    /// Length of the file \[byte\].
    length: u64,
}

impl<R: Read + Seek> Riff<R> {
    /// Wraps a file of `length` bytes.
    pub(super) fn new(reader: R, length: u64) -> Self {
        Self { reader, length }
    }

    /// Up to `most` bytes from an offset; fewer at the end of the file.
    fn bytes(&mut self, at: u64, most: usize) -> io::Result<Vec<u8>> {
        let left = usize::try_from(self.length.saturating_sub(at)).unwrap_or(usize::MAX);
        let mut bytes = vec![0; left.min(most)];
        self.reader.seek(SeekFrom::Start(at))?;
        self.reader.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// The form of the file: `WAVE`, `AVI `.
    pub(super) fn form(&mut self) -> io::Result<Option<[u8; 4]>> {
        Ok(self.bytes(8, 4)?.try_into().ok())
    }

    /// The first bytes of a chunk's content.
    pub(super) fn prefix(&mut self, chunk: &Chunk, most: usize) -> io::Result<Vec<u8>> {
        let found = usize::try_from(chunk.found).unwrap_or(usize::MAX);
        self.bytes(chunk.begin, found.min(most))
    }

    /// A reader that starts at the content of a chunk.
    pub(super) fn content(&mut self, chunk: &Chunk) -> io::Result<impl Read> {
        self.reader.seek(SeekFrom::Start(chunk.begin))?;
        Ok(self.reader.by_ref().take(chunk.found))
    }

    /// The chunks of the file, in order.
    ///
    /// # Errors
    /// Errors of the reader, or if there are more chunks than a recorder writes.
    pub(super) fn chunks(&mut self) -> io::Result<Vec<Chunk>> {
        let mut found: Vec<Chunk> = Vec::new();
        let mut ds64: Option<Vec<u8>> = None;
        let mut at = 12;
        loop {
            let header = self.bytes(at, 8)?;
            let (Some(&[a, b, c, d]), Some(stated)) = (header.get(..4), word(&header, 4)) else {
                break;
            };
            let name = [a, b, c, d];
            if !is_name(&name) {
                break;
            }
            if found.len() == MOST {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    format!("it has more than {MOST} chunks; a recording has about ten"),
                ));
            }
            let begin = at + 8;
            let length = match stated {
                // A program that writes to a pipe cannot know the length.
                UNKNOWN => ds64
                    .as_deref()
                    .and_then(|ds64| long_length(ds64, name))
                    .filter(|length| *length > 0),
                0 if name == *b"data" && !self.is_chunk_or_end(begin)? => None,
                stated => Some(u64::from(stated)),
            };
            let rest = self.length - begin;
            let chunk = Chunk {
                name,
                begin,
                found: length.map_or(rest, |length| length.min(rest)),
                length,
            };
            if name == *b"ds64" && ds64.is_none() {
                ds64 = Some(self.prefix(&chunk, DS64)?);
            }
            found.push(chunk);
            at = begin + chunk.found;
            if chunk.found % 2 == 1 && !self.lacks_pad(at)? {
                at += 1;
            }
        }
        Ok(found)
    }

    /// Whether the offset is the end of the file or the header of a complete chunk.
    fn is_chunk_or_end(&mut self, at: u64) -> io::Result<bool> {
        let header = self.bytes(at, 8)?;
        let Some(name) = header.get(..4) else {
            return Ok(true);
        };
        let whole = word(&header, 4).is_some_and(|length| u64::from(length) <= self.length - at - 8);
        Ok(is_name(name) && whole)
    }

    /// Whether a chunk of odd length that ends here has no pad byte, as written by some recorders.
    fn lacks_pad(&mut self, at: u64) -> io::Result<bool> {
        let bytes = self.bytes(at, 5)?;
        let (without, with) = (bytes.get(..4), bytes.get(1..5));
        let is_known = |name: Option<&[u8]>| name.is_some_and(|name| KNOWN.contains(&name));
        Ok(is_known(without) && !is_known(with)
            || bytes.first() != Some(&0) && !with.is_some_and(is_name) && without.is_some_and(is_name))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn chunk(name: &[u8], content: &[u8], pad: bool) -> Vec<u8> {
        let mut bytes = [name, &(content.len() as u32).to_le_bytes(), content].concat();
        if pad && content.len() % 2 == 1 {
            bytes.push(0);
        }
        bytes
    }

    fn riff(bytes: &[u8]) -> Riff<Cursor<&[u8]>> {
        Riff::new(Cursor::new(bytes), bytes.len() as u64)
    }

    fn chunks(bytes: &[u8]) -> Vec<Chunk> {
        riff(bytes).chunks().unwrap_or_default()
    }

    fn content(bytes: &[u8], chunk: &Chunk) -> Vec<u8> {
        riff(bytes).prefix(chunk, usize::MAX).unwrap_or_default()
    }

    fn names(bytes: &[u8]) -> Vec<String> {
        let name = |chunk: &Chunk| String::from_utf8_lossy(&chunk.name).into_owned();
        chunks(bytes).iter().map(name).collect()
    }

    #[test]
    fn chunks_of_odd_length_are_followed_with_and_without_a_pad_byte() {
        for pad in [true, false] {
            let parts = [
                b"RIFF\0\0\0\0WAVE".to_vec(),
                chunk(b"iXML", b"<a/>!", pad),
                chunk(b"bext", b"x", pad),
                chunk(b"fmt ", &[0; 16], pad),
                chunk(b"data", &[1, 2, 3], pad),
                chunk(b"LIST", b"INFO", pad),
            ];
            assert_eq!(
                names(&parts.concat()),
                ["iXML", "bext", "fmt ", "data", "LIST"],
                "{pad}"
            );
        }
    }

    #[test]
    fn lengths_beyond_32_bits_are_those_of_the_ds64_chunk() {
        let mut ds64 = [100_u64, 6, 3]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect::<Vec<u8>>();
        ds64.extend(1_u32.to_le_bytes());
        ds64.extend(b"bext");
        ds64.extend(4_u64.to_le_bytes());
        let open = |name: &[u8], content: &[u8]| [name, &[0xff; 4], content].concat();
        let bytes = [
            b"RF64\xff\xff\xff\xffWAVE".to_vec(),
            chunk(b"ds64", &ds64, true),
            open(b"bext", b"abcd"),
            open(b"data", b"123456"),
            chunk(b"LIST", b"INFO", true),
        ]
        .concat();
        let found = chunks(&bytes);
        assert_eq!(names(&bytes), ["ds64", "bext", "data", "LIST"]);
        assert_eq!(content(&bytes, &found[1]), b"abcd");
        assert_eq!(content(&bytes, &found[2]), b"123456");
    }

    #[test]
    fn an_open_length_reaches_to_the_end_of_the_file() {
        for length in [[0xff; 4], [0; 4]] {
            let bytes = [&b"RIFF\xff\xff\xff\xffWAVEdata"[..], &length, &[7; 10]].concat();
            let found = chunks(&bytes);
            assert_eq!((found[0].length, found[0].found), (None, 10));
        }
        // An empty chunk followed by another one is really empty.
        let bytes = [
            b"RIFF\0\0\0\0WAVE".to_vec(),
            chunk(b"data", b"", true),
            chunk(b"LIST", b"INFO", true),
        ]
        .concat();
        assert_eq!(chunks(&bytes)[0].found, 0);
    }

    #[test]
    fn no_bytes_are_beyond_the_end() {
        for end in 0..60 {
            let bytes = [
                b"RIFF\0\0\0\0WAVE".to_vec(),
                chunk(b"fmt ", &[0; 16], true),
                chunk(b"data", &[9; 30], true),
            ]
            .concat();
            let _ = chunks(&bytes[..end.min(bytes.len())]);
        }
    }

    #[test]
    fn a_file_with_too_many_chunks_is_refused() {
        let bytes = [b"RIFF\0\0\0\0WAVE".to_vec(), chunk(b"JUNK", b"", true).repeat(MOST + 1)].concat();
        let refusal = riff(&bytes).chunks().map_err(|error| error.to_string());
        assert!(
            refusal.as_ref().is_err_and(|said| said.contains("65536 chunks")),
            "{refusal:?}"
        );
    }
}

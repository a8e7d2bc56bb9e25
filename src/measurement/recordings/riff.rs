//! The chunks of RIFF files, and of RF64 and BW64 files, whose lengths may exceed 4 GiB (EBU Tech 3306, ITU-R BS.2088).
//!
//! Written here, because hound refuses what recorders write: chunks of odd length, `fmt ` chunks of 18 and 40 bytes
//! with other contents than its own, RF64; and it reads 24 bits in containers of 32 from the wrong end. The licence of
//! symphonia, MPL-2.0, is not among those of `deny.toml`. This reader is lenient where libsndfile is: it follows the
//! chunks in any order, accepts a missing pad byte, and ignores the length of the file in its header.

/// Lengths of chunks that stand for "see ds64" or "unknown, to the end of the file".
const UNKNOWN: u32 = u32::MAX;

/// Names of chunks that may follow one of odd length without a pad byte.
const KNOWN: [&[u8]; 12] = [
    b"fmt ", b"data", b"fact", b"LIST", b"bext", b"iXML", b"JUNK", b"PEAK", b"cue ", b"id3 ", b"axml", b"chna",
];

/// A chunk of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk<'a> {
    /// Four characters.
    pub(super) name: [u8; 4],
    /// Its content, as far as the file has it.
    pub(super) content: &'a [u8],
    /// Length by its header \[byte\]; none where the header leaves it open.
    pub(super) length: Option<u64>,
}

/// Whether a file is a tree of chunks, in the byte order of RIFF.
pub(super) fn is_riff(bytes: &[u8]) -> bool {
    [&b"RIFF"[..], b"RF64", b"BW64"]
        .iter()
        .any(|mark| bytes.starts_with(mark))
}

/// The form of a file: `WAVE`, `AVI `.
pub(super) fn form(bytes: &[u8]) -> Option<[u8; 4]> {
    bytes.get(8..12)?.try_into().ok()
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

/// Lengths of chunks in a `ds64` chunk: that of `data`, and those of others by their names.
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

/// The chunks of a file, in their order.
pub(super) fn chunks(bytes: &[u8]) -> Vec<Chunk<'_>> {
    let mut found: Vec<Chunk<'_>> = Vec::new();
    let mut at = 12;
    while let (Some(name), Some(stated)) = (bytes.get(at..at + 4), word(bytes, at + 4)) {
        if !is_name(name) {
            break;
        }
        let name: [u8; 4] = [name[0], name[1], name[2], name[3]];
        let begin = at + 8;
        let ds64 = found
            .iter()
            .find(|chunk| chunk.name == *b"ds64")
            .map(|chunk| chunk.content);
        let length = match stated {
            // A program that writes to a pipe cannot know the length.
            UNKNOWN => ds64
                .and_then(|ds64| long_length(ds64, name))
                .filter(|length| *length > 0),
            0 if name == *b"data" && !is_chunk_or_end(bytes, begin) => None,
            stated => Some(u64::from(stated)),
        };
        let rest = bytes.len() - begin;
        let own = length.map_or(rest, |length| {
            usize::try_from(length).map_or(rest, |length| length.min(rest))
        });
        found.push(Chunk {
            name,
            content: &bytes[begin..begin + own],
            length,
        });
        at = begin + own;
        if own % 2 == 1 && !lacks_pad(bytes, at) {
            at += 1;
        }
    }
    found
}

/// Whether the bytes are the end of the file or the header of a chunk that is whole.
fn is_chunk_or_end(bytes: &[u8], at: usize) -> bool {
    let Some(name) = bytes.get(at..at + 4) else {
        return true;
    };
    let whole = word(bytes, at + 4).is_some_and(|length| length as usize <= bytes.len() - at - 8);
    is_name(name) && whole
}

/// Whether a chunk of odd length that ends here has no pad byte behind it, as some recorders write it.
fn lacks_pad(bytes: &[u8], at: usize) -> bool {
    let name = |at: usize| bytes.get(at..at + 4);
    let is_known = |at: usize| name(at).is_some_and(|name| KNOWN.contains(&name));
    is_known(at) && !is_known(at + 1)
        || bytes.get(at) != Some(&0) && !name(at + 1).is_some_and(is_name) && name(at).is_some_and(is_name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(name: &[u8], content: &[u8], pad: bool) -> Vec<u8> {
        let mut bytes = [name, &(content.len() as u32).to_le_bytes(), content].concat();
        if pad && content.len() % 2 == 1 {
            bytes.push(0);
        }
        bytes
    }

    fn names(bytes: &[u8]) -> Vec<String> {
        let name = |chunk: &Chunk<'_>| String::from_utf8_lossy(&chunk.name).into_owned();
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
        assert_eq!((found[1].content, found[2].content), (&b"abcd"[..], &b"123456"[..]));
    }

    #[test]
    fn an_open_length_reaches_to_the_end_of_the_file() {
        for length in [[0xff; 4], [0; 4]] {
            let bytes = [&b"RIFF\xff\xff\xff\xffWAVEdata"[..], &length, &[7; 10]].concat();
            let found = chunks(&bytes);
            assert_eq!((found[0].length, found[0].content.len()), (None, 10));
        }
        // An empty chunk with another one behind it is empty.
        let bytes = [
            b"RIFF\0\0\0\0WAVE".to_vec(),
            chunk(b"data", b"", true),
            chunk(b"LIST", b"INFO", true),
        ]
        .concat();
        assert_eq!(chunks(&bytes)[0].content.len(), 0);
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
}

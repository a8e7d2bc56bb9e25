//! Arrays of numbers as files have them.
//!
//! With `compressor="vtkZLibDataCompressor"` and 64-bit headers an array of n bytes in blocks of B is
//!
//! ```text
//! [number of blocks] [B] [bytes of the last block] [bytes of each stream ...] stream stream ...
//! ```
//!
//! each stream a block in zlib's format (RFC 1950; VTK file formats, XML). A last block that is full may be said to have no
//! bytes, too; not every reader takes that. In an element the numbers before the streams are one stretch of base64, the
//! streams another.

use std::io::Read as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::bufread::ZlibEncoder;
use serde::{Deserialize, Serialize};

use super::{Field, escaped};

/// Bytes of a block: VTK's own choice, a whole number of all numbers, and no more than a stored block of DEFLATE holds.
const BLOCK: usize = 1 << 15;

/// What stands before the bytes of a stored block: zlib's header (DEFLATE in a window of 32 KiB, fastest) and the mark of a
/// last block that is stored (RFC 1951, 3.2.4).
const STORED: [u8; 3] = [0x78, 0x01, 0x01];

/// Bytes of a stream beside those of its stored block: the beginning, twice the length, the checksum.
const AROUND: usize = STORED.len() + 2 * size_of::<u16>() + size_of::<u32>();

/// Bytes of a number before the streams.
const NUMBER: usize = size_of::<u64>();

/// Numbers before the sizes of the streams.
const BEGINNING: usize = 3;

/// A field as files have it: made once, copied into the file that shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Array {
    name: String,
    double: bool,
    components: usize,
    values: usize,
    #[serde(with = "serde_bytes")]
    bytes: Vec<u8>,
}

impl Array {
    /// Of values in single precision, item by item, `components` of each. The reader shows the name; give the unit in it.
    pub fn new(name: impl Into<String>, components: usize, values: &[f32]) -> Self {
        Self {
            name: name.into(),
            double: false,
            components,
            values: values.len(),
            bytes: stored(values, f32::to_le_bytes),
        }
    }

    /// Of a field in double or single precision.
    pub(super) fn of(field: &Field<'_>, double: bool) -> Self {
        let Field {
            name,
            components,
            values,
        } = *field;
        if double {
            Self {
                name: name.to_owned(),
                double,
                components,
                values: values.len(),
                bytes: stored(values, f64::to_le_bytes),
            }
        } else {
            let values: Vec<f32> = values.iter().map(|&x| x as f32).collect();
            Self::new(name, components, &values)
        }
    }

    /// Name of the field.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Components of an item, and values of all items.
    pub(super) fn shape(&self) -> [usize; 2] {
        [self.components, self.values]
    }

    /// Appends its element.
    pub(super) fn element(&self, text: &mut Vec<u8>) {
        let kind = if self.double { "Float64" } else { "Float32" };
        element(text, kind, (&self.name, self.components), &self.bytes);
    }

    /// About the length of its element.
    pub(super) fn length(&self) -> usize {
        self.bytes.len() / 3 * 4 + 256
    }
}

/// Appends the element of an array of so many components to the text of a file.
pub(super) fn element(text: &mut Vec<u8>, kind: &str, (name, components): (&str, usize), bytes: &[u8]) {
    let name = escaped(name);
    let opening =
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">");
    text.extend_from_slice(opening.as_bytes());
    let blocks = bytes.first_chunk().map_or(0, |blocks| u64::from_le_bytes(*blocks));
    let (numbers, streams) = bytes.split_at(NUMBER * (BEGINNING + blocks as usize));
    for part in [numbers, streams] {
        let start = text.len();
        text.resize(start + 4 * part.len().div_ceil(3), 0);
        // The slice has room for all.
        let length = STANDARD.encode_slice(part, &mut text[start..]).unwrap_or_default();
        text.truncate(start + length);
    }
    text.extend_from_slice(b"</DataArray>\n");
}

/// An array that is compressed. The fastest level leaves a surface 1 % larger than the best one, which takes ten times as
/// long.
pub(super) fn deflated<T: Copy, const N: usize>(values: &[T], le: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    let (mut block, mut streams) = (Vec::with_capacity(BLOCK), Vec::new());
    let sizes = values.chunks(BLOCK / N).map(|part| {
        block.clear();
        append(&mut block, part, &le);
        let start = streams.len();
        // Memory that is read into memory cannot fail.
        let _ = ZlibEncoder::new(block.as_slice(), Compression::fast()).read_to_end(&mut streams);
        streams.len() - start
    });
    let mut bytes = header(N * values.len(), sizes);
    bytes.append(&mut streams);
    bytes
}

/// An array whose streams hold its bytes as they are.
fn stored<T: Copy, const N: usize>(values: &[T], le: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    let parts = values.chunks(BLOCK / N);
    let mut bytes = header(N * values.len(), parts.clone().map(|part| AROUND + N * part.len()));
    bytes.reserve_exact(N * values.len() + AROUND * parts.len());
    for part in parts {
        let length = (N * part.len()) as u16;
        bytes.extend_from_slice(&STORED);
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(&(!length).to_le_bytes());
        let start = bytes.len();
        append(&mut bytes, part, &le);
        let checksum = simd_adler32::adler32(&&bytes[start..]);
        bytes.extend_from_slice(&checksum.to_be_bytes());
    }
    bytes
}

/// What stands before the streams, whose sizes are given.
fn header(length: usize, streams: impl Iterator<Item = usize>) -> Vec<u8> {
    let blocks = length.div_ceil(BLOCK);
    let beginning: [usize; BEGINNING] = [blocks, BLOCK, length - BLOCK * blocks.saturating_sub(1)];
    let numbers = beginning.into_iter().chain(streams);
    numbers.flat_map(|number| (number as u64).to_le_bytes()).collect()
}

/// Appends the bytes of numbers.
fn append<T: Copy, const N: usize>(bytes: &mut Vec<u8>, values: &[T], le: impl Fn(T) -> [u8; N]) {
    let start = bytes.len();
    bytes.resize(start + N * values.len(), 0);
    let (places, _) = bytes[start..].as_chunks_mut::<N>();
    places
        .iter_mut()
        .zip(values)
        .for_each(|(place, &value)| *place = le(value));
}

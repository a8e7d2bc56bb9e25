//! Arrays of numbers as appended data have them.
//!
//! With `compressor="vtkZLibDataCompressor"` and 64-bit headers an array of n bytes in blocks of B is
//!
//! ```text
//! [number of blocks] [B] [bytes of the last block] [bytes of each stream ...] stream stream ...
//! ```
//!
//! each stream a block in zlib's format (RFC 1950; VTK file formats, XML, appended data). A last block that is full may be
//! said to have no bytes, too; not every reader takes that.

use std::io::Read as _;

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

    /// Its appended data.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Its element in the text of a file, with the place of its bytes among the appended data.
    pub(super) fn element(&self, offset: usize) -> String {
        let kind = if self.double { "Float64" } else { "Float32" };
        element(kind, &self.name, self.components, offset)
    }
}

/// The element of an array in the text of a file.
pub(super) fn element(kind: &str, name: &str, components: usize, offset: usize) -> String {
    let name = escaped(name);
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
         offset=\"{offset}\"/>\n"
    )
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
    let beginning = [blocks, BLOCK, length - BLOCK * blocks.saturating_sub(1)];
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

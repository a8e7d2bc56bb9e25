//! Film frames: files that share one grid but have different fields.
//!
//! vtkio writes the grid once for all frames; the fields are inserted into its file here, because vtkio compresses
//! every file anew, number by number. For sixty frames of the velocity at 45 602 points, this takes 0.13 s of processor
//! time (0.1 s of it for the grid) and 73 MB. The writer of vtkio takes 8 s and 69 MB compressed, or 0.7 s and 176 MB
//! uncompressed.
//!
//! With `compressor="vtkZLibDataCompressor"` and 64-bit headers, an array of n bytes in blocks of B bytes is stored as
//!
//! ```text
//! [number of blocks] [B] [bytes of the last block] [bytes of each stream ...] stream stream ...
//! ```
//!
//! where each stream is a block in zlib's format (RFC 1950; VTK file formats, XML), and the numbers and the streams are
//! two separate sequences of base64. Velocities do not compress, so their blocks are stored uncompressed. flate2 takes
//! 0.6 s to store 48 MB in this form; a copy and a checksum take 0.03 s.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::{Grid, check, escaped};
use crate::MeshError;

/// Block size in bytes: VTK's default, which is a multiple of the size of a number and fits in a stored block of
/// DEFLATE.
const BLOCK: usize = 1 << 15;

/// Bytes that precede a stored block: zlib's header (DEFLATE with a window of 32 KiB, fastest) and the marker of a
/// final, stored block (RFC 1951, 3.2.4).
const STORED: [u8; 3] = [0x78, 0x01, 0x01];

/// Bytes of a stream other than the data of its stored block: the marker, the length twice, and the checksum.
const OVERHEAD: usize = STORED.len() + 2 * size_of::<u16>() + size_of::<u32>();

/// A single-precision field, with its values as little-endian bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Array {
    name: String,
    components: usize,
    #[serde(with = "serde_bytes")]
    bytes: Vec<u8>,
}

impl Array {
    /// Creates a field from values with `components` per item. The reader shows the name; include the unit in it.
    pub fn new(name: impl Into<String>, components: usize, values: &[f32]) -> Self {
        let mut bytes = vec![0; size_of_val(values)];
        let (places, _) = bytes.as_chunks_mut();
        places
            .iter_mut()
            .zip(values)
            .for_each(|(place, x)| *place = x.to_le_bytes());
        Self {
            name: name.into(),
            components,
            bytes,
        }
    }

    /// Its name, with its unit.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Values per item.
    pub(crate) fn components(&self) -> usize {
        self.components
    }

    /// Its values as little-endian bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns an error unless the number of values matches these items.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`].
    pub(crate) fn check(&self, items: usize) -> Result<(), MeshError> {
        let values = self.bytes.len() / size_of::<f32>();
        check(&self.name, values, items * self.components)
    }

    /// Appends its XML element to a file.
    fn render(&self, text: &mut Vec<u8>) {
        let (name, components) = (escaped(&self.name), self.components);
        let opening = format!(
            "<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
        );
        text.extend_from_slice(opening.as_bytes());
        stored(&self.bytes).iter().for_each(|part| append(text, part));
        text.extend_from_slice(b"</DataArray>");
    }
}

/// The grid shared by the frames of a film: the parts of the file before and after the point fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    points: usize,
    before: String,
    after: String,
}

impl Frames {
    /// Prepares the frames of a grid.
    ///
    /// # Errors
    /// [`MeshError::Vtk`] if vtkio cannot write the grid.
    pub fn of(grid: &Grid) -> Result<Self, MeshError> {
        let mut text = String::from_utf8_lossy(&grid.to_bytes(&[], &[])?).into_owned();
        // Point fields come first in a piece.
        let piece = text.find("<Piece").unwrap_or_default();
        let end = text[piece..].find('>').map_or(0, |length| piece + length + 1);
        let after = text.split_off(end);
        Ok(Self {
            points: grid.points(),
            before: text,
            after,
        })
    }

    /// Appends a file that shows the grid with the given point fields.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`].
    pub fn render(&self, fields: &[Array], bytes: &mut Vec<u8>) -> Result<(), MeshError> {
        fields.iter().try_for_each(|field| field.check(self.points))?;
        let of_fields: usize = fields.iter().map(|field| field.bytes.len() * 7 / 5 + 512).sum();
        bytes.reserve(self.before.len() + self.after.len() + of_fields);
        bytes.extend_from_slice(self.before.as_bytes());
        bytes.extend_from_slice(b"<PointData>");
        fields.iter().for_each(|field| field.render(bytes));
        bytes.extend_from_slice(b"</PointData>");
        bytes.extend_from_slice(self.after.as_bytes());
        Ok(())
    }
}

/// Appends bytes in base64.
fn append(text: &mut Vec<u8>, bytes: &[u8]) {
    let start = text.len();
    text.resize(start + 4 * bytes.len().div_ceil(3), 0);
    // The slice is large enough.
    let length = STANDARD.encode_slice(bytes, &mut text[start..]).unwrap_or_default();
    text.truncate(start + length);
}

/// The header numbers, and the streams with the bytes stored uncompressed.
fn stored(bytes: &[u8]) -> [Vec<u8>; 2] {
    let blocks = bytes.chunks(BLOCK);
    let last = blocks.clone().last().map_or(0, <[u8]>::len);
    let numbers = [blocks.len(), BLOCK, last].into_iter();
    let numbers = numbers.chain(blocks.clone().map(|block| OVERHEAD + block.len()));
    let numbers = numbers.flat_map(|number| (number as u64).to_le_bytes()).collect();
    let mut streams = Vec::with_capacity(bytes.len() + OVERHEAD * blocks.len());
    for block in blocks {
        let length = block.len() as u16;
        streams.extend_from_slice(&STORED);
        streams.extend_from_slice(&length.to_le_bytes());
        streams.extend_from_slice(&(!length).to_le_bytes());
        streams.extend_from_slice(block);
        streams.extend_from_slice(&simd_adler32::adler32(&block).to_be_bytes());
    }
    [numbers, streams]
}

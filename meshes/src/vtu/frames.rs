//! Films: files that share one grid, with other fields in each.
//!
//! vtkio writes the grid, once for all frames; the fields are put into its file here, because vtkio compresses every
//! file anew, number by number. Processor time and size of sixty frames of the velocity on 45 602 points: 0.13 s and 73
//! MB here (0.1 s of it is the grid). With vtkio they are 8 s and 69 MB compressed, 0.7 s and 176 MB uncompressed.
//!
//! With `compressor="vtkZLibDataCompressor"` and 64-bit headers an array of n bytes in blocks of B is
//!
//! ```text
//! [number of blocks] [B] [bytes of the last block] [bytes of each stream ...] stream stream ...
//! ```
//!
//! each stream a block in zlib's format (RFC 1950; VTK file formats, XML), the numbers and the streams two stretches of
//! base64. A velocity does not compress: its blocks are stored as they are. flate2 takes 0.6 s to store 48 MB in this
//! form, a copy and a checksum 0.03 s.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::{Grid, check, escaped};
use crate::MeshError;

/// Bytes of a block: VTK's own choice, a multiple of the size of a number, and no more than a stored block of DEFLATE
/// can contain.
const BLOCK: usize = 1 << 15;

/// What precedes the bytes of a stored block: zlib's header (DEFLATE in a window of 32 KiB, fastest) and the mark of a
/// last block that is stored (RFC 1951, 3.2.4).
const STORED: [u8; 3] = [0x78, 0x01, 0x01];

/// Bytes of a stream besides those of its stored block: the mark, the length twice, the checksum.
const OVERHEAD: usize = STORED.len() + 2 * size_of::<u16>() + size_of::<u32>();

/// A field in single precision, with its values as bytes, little-endian.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Array {
    name: String,
    components: usize,
    #[serde(with = "serde_bytes")]
    bytes: Vec<u8>,
}

impl Array {
    /// Of values item by item, `components` of each. The reader shows the name; give the unit in it.
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

    /// Appends its element to the text of a file.
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

/// The grid that the frames of a film share: the text of a file before and after the fields on its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    points: usize,
    before: String,
    after: String,
}

impl Frames {
    /// Of a grid.
    ///
    /// # Errors
    /// [`MeshError::Vtk`] where vtkio cannot write the grid.
    pub fn of(grid: &Grid) -> Result<Self, MeshError> {
        let mut text = String::from_utf8_lossy(&grid.to_bytes(&[], &[])?).into_owned();
        // The fields on points come first in a piece.
        let piece = text.find("<Piece").unwrap_or_default();
        let end = text[piece..].find('>').map_or(0, |length| piece + length + 1);
        let after = text.split_off(end);
        Ok(Self {
            points: grid.points(),
            before: text,
            after,
        })
    }

    /// Appends the file that shows the grid with fields on its points.
    ///
    /// # Errors
    /// [`MeshError::FieldLength`].
    pub fn render(&self, fields: &[Array], bytes: &mut Vec<u8>) -> Result<(), MeshError> {
        for field in fields {
            let values = field.bytes.len() / size_of::<f32>();
            check(&field.name, values, self.points * field.components)?;
        }
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
    // The slice has room for all.
    let length = STANDARD.encode_slice(bytes, &mut text[start..]).unwrap_or_default();
    text.truncate(start + length);
}

/// The numbers before the streams, and the streams, which store the bytes as they are.
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

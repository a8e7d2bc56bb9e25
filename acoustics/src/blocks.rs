//! Serialises large arrays as single blocks of little-endian bytes, for `#[serde(with = "crate::blocks")]`.
//!
//! Encoding every number separately would take several times as long as copying a radiation matrix.

use nalgebra::{Complex, DMatrix};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

/// A matrix in its stored form, column by column.
#[derive(Serialize, Deserialize)]
pub(crate) struct Block<'a> {
    rows: usize,
    columns: usize,
    #[serde(borrow, with = "serde_bytes")]
    bytes: Cow<'a, [u8]>,
}

/// A value stored as one block or as a list of blocks.
pub(crate) trait Blocks: Sized {
    /// The stored form.
    type Stored<'a>: Serialize + Deserialize<'a>;

    fn stored(&self) -> Self::Stored<'static>;

    /// Restores the value; none if the bytes do not match the given size.
    fn restored(stored: Self::Stored<'_>) -> Option<Self>;
}

pub(crate) fn serialize<T: Blocks, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    value.stored().serialize(serializer)
}

pub(crate) fn deserialize<'de, T: Blocks, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let stored = T::Stored::deserialize(deserializer)?;
    T::restored(stored).ok_or_else(|| D::Error::custom("a matrix has another size than its header says"))
}

fn block<const N: usize, T>(
    rows: usize,
    columns: usize,
    values: &[T],
    to_bytes: impl Fn(&T) -> [u8; N],
) -> Block<'static> {
    let mut bytes = vec![0; N * values.len()];
    for (to, value) in bytes.as_chunks_mut::<N>().0.iter_mut().zip(values) {
        *to = to_bytes(value);
    }
    let bytes = Cow::Owned(bytes);
    Block { rows, columns, bytes }
}

fn values<const N: usize, T>(block: &Block<'_>, from_bytes: impl Fn([u8; N]) -> T) -> Option<Vec<T>> {
    let (chunks, rest) = block.bytes.as_chunks::<N>();
    let whole = rest.is_empty() && block.rows.checked_mul(block.columns) == Some(chunks.len());
    whole.then(|| chunks.iter().map(|bytes| from_bytes(*bytes)).collect())
}

impl Blocks for Vec<f32> {
    type Stored<'a> = Block<'a>;

    fn stored(&self) -> Block<'static> {
        block(self.len(), 1, self, |v| v.to_le_bytes())
    }

    fn restored(stored: Block<'_>) -> Option<Self> {
        values(&stored, f32::from_le_bytes)
    }
}

impl Blocks for Vec<i16> {
    type Stored<'a> = Block<'a>;

    fn stored(&self) -> Block<'static> {
        block(self.len(), 1, self, |v| v.to_le_bytes())
    }

    fn restored(stored: Block<'_>) -> Option<Self> {
        values(&stored, i16::from_le_bytes)
    }
}

impl Blocks for DMatrix<f64> {
    type Stored<'a> = Block<'a>;

    fn stored(&self) -> Block<'static> {
        block(self.nrows(), self.ncols(), self.as_slice(), |v| v.to_le_bytes())
    }

    fn restored(stored: Block<'_>) -> Option<Self> {
        let values = values(&stored, f64::from_le_bytes)?;
        Some(Self::from_vec(stored.rows, stored.columns, values))
    }
}

impl Blocks for DMatrix<Complex<f64>> {
    type Stored<'a> = Block<'a>;

    fn stored(&self) -> Block<'static> {
        let to_bytes = |z: &Complex<f64>| {
            let mut bytes = [0; 16];
            bytes[..8].copy_from_slice(&z.re.to_le_bytes());
            bytes[8..].copy_from_slice(&z.im.to_le_bytes());
            bytes
        };
        block(self.nrows(), self.ncols(), self.as_slice(), to_bytes)
    }

    fn restored(stored: Block<'_>) -> Option<Self> {
        let part = |bytes: &[u8]| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
        let values = values(&stored, |bytes: [u8; 16]| {
            Complex::new(part(&bytes[..8]), part(&bytes[8..]))
        })?;
        Some(Self::from_vec(stored.rows, stored.columns, values))
    }
}

impl<T: Blocks> Blocks for Vec<T> {
    type Stored<'a> = Vec<T::Stored<'a>>;

    fn stored(&self) -> Vec<T::Stored<'static>> {
        self.iter().map(T::stored).collect()
    }

    fn restored(stored: Vec<T::Stored<'_>>) -> Option<Self> {
        stored.into_iter().map(T::restored).collect()
    }
}

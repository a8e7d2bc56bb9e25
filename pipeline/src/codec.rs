//! Serialisation of stage outputs for the store.

use std::io::{self, Read, Write};

use nalgebra::{DMatrix, Scalar};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// The serialised form of a type.
pub trait Codec<T> {
    /// Whether outputs are stored at all.
    const KEPT: bool = true;

    /// Writes a value.
    ///
    /// # Errors
    /// Errors of the writer.
    fn write(value: &T, to: &mut dyn Write) -> io::Result<()>;

    /// Reads a value from `length` bytes.
    ///
    /// # Errors
    /// [`Undecodable`] if the bytes do not encode a value of the type.
    fn read(from: &mut dyn Read, length: usize) -> Result<T, Undecodable>;
}

/// Why bytes could not be decoded.
#[derive(Debug, Error)]
#[error("holds something else ({0})")]
pub struct Undecodable(pub String);

impl Undecodable {
    /// Wraps the reason given by a decoder.
    pub fn new(reason: impl ToString) -> Self {
        Self(reason.to_string())
    }
}

/// The postcard format, for any serde type.
pub struct Postcard;

impl<T: Serialize + DeserializeOwned> Codec<T> for Postcard {
    fn write(value: &T, to: &mut dyn Write) -> io::Result<()> {
        let mut to = io::BufWriter::with_capacity(1 << 16, to);
        postcard::to_io(value, &mut to).map_err(io::Error::other)?;
        to.flush()
    }

    fn read(from: &mut dyn Read, length: usize) -> Result<T, Undecodable> {
        let mut bytes = Vec::with_capacity(length);
        from.read_to_end(&mut bytes).map_err(Undecodable::new)?;
        postcard::from_bytes(&bytes).map_err(Undecodable::new)
    }
}

/// A value that consists mostly of one matrix, which its serde form omits.
pub trait HasMatrix {
    /// Type of the matrix entries.
    type Entry: Entry;

    /// The matrix.
    fn matrix(&self) -> &DMatrix<Self::Entry>;

    /// Inserts the matrix into a value that was read without it.
    fn set_matrix(&mut self, matrix: DMatrix<Self::Entry>);
}

/// Numbers with a fixed-size little-endian encoding.
pub trait Entry: Scalar + Copy {
    /// Size of a number \[bytes\].
    const BYTES: usize;

    /// Appends the encoding of numbers to `bytes`.
    fn encode(entries: &[Self], bytes: &mut Vec<u8>);

    /// Appends the numbers decoded from `bytes`.
    fn decode(bytes: &[u8], entries: &mut Vec<Self>);
}

macro_rules! entry {
    ($($number:ty),+) => {$(
        impl Entry for $number {
            const BYTES: usize = size_of::<Self>();

            fn encode(entries: &[Self], bytes: &mut Vec<u8>) {
                bytes.extend(entries.iter().flat_map(|entry| entry.to_le_bytes()));
            }

            fn decode(bytes: &[u8], entries: &mut Vec<Self>) {
                let (numbers, _) = bytes.as_chunks::<{ size_of::<Self>() }>();
                entries.extend(numbers.iter().map(|number| Self::from_le_bytes(*number)));
            }
        }
    )+};
}

entry!(f32, f64);

/// Number of entries encoded or decoded at once.
const PART: usize = 1 << 13;

/// A value with a large matrix, which is read directly into its final memory:
///
/// ```text
/// 8 bytes  length of the head
/// head     the value without its matrix, then the numbers of rows and columns, in the postcard format
/// rest     the entries, column by column, little-endian
/// ```
pub struct WithMatrix;

impl<T: HasMatrix + Serialize + DeserializeOwned> Codec<T> for WithMatrix {
    fn write(value: &T, to: &mut dyn Write) -> io::Result<()> {
        let matrix = value.matrix();
        let head = postcard::to_stdvec(&(value, matrix.shape())).map_err(io::Error::other)?;
        to.write_all(&(head.len() as u64).to_le_bytes())?;
        to.write_all(&head)?;
        let mut bytes = Vec::with_capacity(T::Entry::BYTES * PART);
        for part in matrix.as_slice().chunks(PART) {
            bytes.clear();
            T::Entry::encode(part, &mut bytes);
            to.write_all(&bytes)?;
        }
        Ok(())
    }

    fn read(from: &mut dyn Read, length: usize) -> Result<T, Undecodable> {
        let size = T::Entry::BYTES;
        let mut of_head = [0; 8];
        from.read_exact(&mut of_head).map_err(Undecodable::new)?;
        let rest = |of_head: usize| Some((of_head, length.checked_sub(8)?.checked_sub(of_head)?));
        let lengths = usize::try_from(u64::from_le_bytes(of_head)).ok().and_then(rest);
        let (of_head, of_entries) = lengths.ok_or_else(|| Undecodable::new("the head is too long"))?;
        let mut head = vec![0; of_head];
        from.read_exact(&mut head).map_err(Undecodable::new)?;
        let (mut value, (rows, columns)): (T, (usize, usize)) =
            postcard::from_bytes(&head).map_err(Undecodable::new)?;
        let count = rows.saturating_mul(columns);
        if count.checked_mul(size) != Some(of_entries) {
            return Err(Undecodable::new("the matrix has another size"));
        }
        let mut entries = Vec::with_capacity(count);
        let mut part = vec![0; size * PART.min(count)];
        while entries.len() < count {
            part.truncate(size * (count - entries.len()));
            from.read_exact(&mut part).map_err(Undecodable::new)?;
            T::Entry::decode(&part, &mut entries);
        }
        value.set_matrix(DMatrix::from_vec(rows, columns, entries));
        Ok(value)
    }
}

/// Serde support for a small matrix or vector as a field.
pub mod matrix {
    use nalgebra::{DMatrix, DVector};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// A dense matrix or vector, stored by columns.
    pub trait Dense: Sized {
        /// Rows, columns and entries.
        fn parts(&self) -> (usize, usize, &[f64]);
        /// Builds a value from its parts; the number of entries matches the dimensions.
        fn of_parts(rows: usize, columns: usize, entries: Vec<f64>) -> Self;
    }

    impl Dense for DMatrix<f64> {
        fn parts(&self) -> (usize, usize, &[f64]) {
            (self.nrows(), self.ncols(), self.as_slice())
        }

        fn of_parts(rows: usize, columns: usize, entries: Vec<f64>) -> Self {
            Self::from_vec(rows, columns, entries)
        }
    }

    impl Dense for DVector<f64> {
        fn parts(&self) -> (usize, usize, &[f64]) {
            (self.nrows(), 1, self.as_slice())
        }

        fn of_parts(_: usize, _: usize, entries: Vec<f64>) -> Self {
            Self::from_vec(entries)
        }
    }

    /// Writes rows, columns and entries.
    pub fn serialize<M: Dense, S: Serializer>(matrix: &M, serializer: S) -> Result<S::Ok, S::Error> {
        matrix.parts().serialize(serializer)
    }

    /// Reads rows, columns and entries.
    pub fn deserialize<'de, M: Dense, D: Deserializer<'de>>(deserializer: D) -> Result<M, D::Error> {
        let (rows, columns, entries) = <(usize, usize, Vec<f64>)>::deserialize(deserializer)?;
        if rows.checked_mul(columns) != Some(entries.len()) {
            return Err(D::Error::custom("the matrix has another size"));
        }
        Ok(M::of_parts(rows, columns, entries))
    }
}

/// Stores nothing: the output is cheaper to compute than to read, or it is an intermediate of stored outputs.
pub struct Uncached;

impl<T> Codec<T> for Uncached {
    const KEPT: bool = false;

    fn write(_: &T, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }

    fn read(_: &mut dyn Read, _: usize) -> Result<T, Undecodable> {
        Err(Undecodable::new("this output is never kept"))
    }
}

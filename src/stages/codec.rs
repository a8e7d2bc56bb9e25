//! How outputs of stages are written to the store and read back.

use std::io::{self, Read, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// The kept form of a type.
pub trait Codec<T> {
    /// Whether anything is kept at all.
    const KEPT: bool = true;

    /// Writes a value.
    ///
    /// # Errors
    /// Those of the writer.
    fn write(value: &T, to: &mut dyn Write) -> io::Result<()>;

    /// Reads a value from its `length` bytes.
    ///
    /// # Errors
    /// [`Undecodable`] when the bytes are no such value.
    fn read(from: &mut dyn Read, length: usize) -> Result<T, Undecodable>;
}

/// Why bytes could not be read as a value.
#[derive(Debug, Error)]
#[error("holds something else ({0})")]
pub struct Undecodable(pub String);

impl Undecodable {
    /// With the reason that a decoder gives.
    pub fn new(reason: impl ToString) -> Self {
        Self(reason.to_string())
    }
}

/// The postcard format: for whatever serde can write.
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

/// Nothing is kept: the output costs less to compute than to read, or is an intermediate of outputs that are kept.
pub struct NotKept;

impl<T> Codec<T> for NotKept {
    const KEPT: bool = false;

    fn write(_: &T, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }

    fn read(_: &mut dyn Read, _: usize) -> Result<T, Undecodable> {
        Err(Undecodable::new("this output is never kept"))
    }
}

//! Radiation operators as bytes, for a cache.

use crate::error::AcousticsError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::Read;

/// A value as bytes in the postcard format, in which large matrices are single blocks.
pub trait Archive: Serialize + DeserializeOwned {
    /// All of it as bytes.
    ///
    /// # Errors
    /// None for the types of this crate.
    fn to_bytes(&self) -> Vec<u8> {
        postcard::to_stdvec(self).unwrap_or_default()
    }

    /// What [`Archive::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`AcousticsError::Damaged`] for any other bytes.
    fn from_bytes(bytes: &[u8]) -> Result<Self, AcousticsError> {
        match postcard::take_from_bytes(bytes) {
            Ok((value, [])) => Ok(value),
            _ => Err(AcousticsError::Damaged { length: bytes.len() }),
        }
    }

    /// The same from a reader that holds `length` bytes.
    ///
    /// # Errors
    /// [`AcousticsError::Damaged`] for any other bytes, or where they end or fail before that.
    fn from_reader(from: &mut dyn Read, length: usize) -> Result<Self, AcousticsError> {
        let mut bytes = Vec::with_capacity(length);
        let read = from.take(length as u64).read_to_end(&mut bytes);
        read.map_err(|_| AcousticsError::Damaged { length })?;
        Self::from_bytes(&bytes)
    }
}

impl<T: Serialize + DeserializeOwned> Archive for T {}

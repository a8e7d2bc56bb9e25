//! The digest of everything that a stage depends on.

use std::io::{self, BufWriter, Write};

use serde::Serialize;
use sha2::{Digest as _, Sha256};

/// Buffer size for digesting inputs; the record of a cycle has twenty million bytes.
const BUFFER: usize = 1 << 16;

/// A writer that digests all bytes.
struct Digesting<'a>(&'a mut Sha256);

impl Write for Digesting<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Digest of everything that a value depends on.
pub type Digest = [u8; 32];

/// Formats bytes in hexadecimal.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Collects the inputs of a stage.
#[derive(Debug, Clone)]
pub struct Key(Sha256);

impl Key {
    /// Creates a key that depends on nothing.
    pub fn empty() -> Self {
        Self(Sha256::new())
    }

    /// Adds a value to the key.
    ///
    /// Numbers are digested by their bits, sequences and texts with their length, so that no two lists of inputs yield
    /// the same bytes.
    #[must_use]
    pub fn with<T: Serialize + ?Sized>(mut self, value: &T) -> Self {
        let mut buffer = BufWriter::with_capacity(BUFFER, Digesting(&mut self.0));
        // Only a type without a fixed form (a sequence of unknown length) cannot be written. That would be a
        // programming error, which every test of the stage detects.
        if let Err(error) = postcard::to_io(value, &mut buffer) {
            unreachable!("inputs of a stage have a fixed form: {error}");
        }
        drop(buffer); // flushes it into the digest
        self
    }

    /// The digest of all values added.
    pub fn digest(self) -> Digest {
        self.0.finalize().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_do_not_run_into_each_other() {
        let keys = [
            Key::empty(),
            Key::empty().with("ab").with("c"),
            Key::empty().with("a").with("bc"),
            Key::empty().with("abc"),
            Key::empty().with(&[1.0, 2.0][..]).with(&[3.0][..]),
            Key::empty().with(&[1.0][..]).with(&[2.0, 3.0][..]),
            Key::empty().with(&0.0),
            Key::empty().with(&-0.0),
        ];
        let digests: std::collections::BTreeSet<_> = keys.into_iter().map(Key::digest).collect();
        assert_eq!(digests.len(), 8);
    }
}

//! The digest of everything a stage depends on.

use serde::Serialize;
use sha2::{Digest as _, Sha256};

/// Digest of this program's sources: other code may compute something else from the same inputs.
const SOURCES: &str = env!("NAILNOISE_SOURCES");

/// Collects the inputs of a stage.
#[derive(Debug, Clone)]
pub struct Key(Sha256);

impl Default for Key {
    fn default() -> Self {
        Self::new()
    }
}

impl Key {
    /// Depends on this program alone.
    pub fn new() -> Self {
        Self::of_sources(SOURCES)
    }

    fn of_sources(sources: &str) -> Self {
        Self(Sha256::new()).with(sources)
    }

    /// Depends on this value as well.
    ///
    /// Numbers count by their bits, sequences and texts with their length, so that no two lists of inputs share their
    /// bytes.
    #[must_use]
    pub fn with<T: Serialize + ?Sized>(mut self, value: &T) -> Self {
        // Only a type without a fixed form (a sequence of unknown length) cannot be written: a mistake in this program
        // that every test of its stage meets.
        match postcard::to_stdvec(value) {
            Ok(bytes) => self.0.update(bytes),
            Err(error) => unreachable!("inputs of a stage have a fixed form: {error}"),
        }
        self
    }

    pub(crate) fn digest(self) -> [u8; 32] {
        self.0.finalize().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_do_not_run_into_each_other() {
        let keys = [
            Key::new(),
            Key::new().with("ab").with("c"),
            Key::new().with("a").with("bc"),
            Key::new().with("abc"),
            Key::new().with(&[1.0, 2.0][..]).with(&[3.0][..]),
            Key::new().with(&[1.0][..]).with(&[2.0, 3.0][..]),
            Key::new().with(&0.0),
            Key::new().with(&-0.0),
            Key::of_sources("other"),
        ];
        let digests: std::collections::BTreeSet<_> = keys.into_iter().map(Key::digest).collect();
        assert_eq!(digests.len(), 9);
    }
}

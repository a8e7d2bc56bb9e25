//! Stage outputs as inputs of other stages.

use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::inputs::{self, Input};
use crate::store::Digest;

/// The output of a stage, made when first read and shared by all readers.
///
/// It is serialised as the key of its stage. A result that uses it thus depends on the inputs of that stage and not on
/// its bytes, whose last digits may differ between machines.
pub struct Stored<T, E> {
    key: Digest,
    source: Arc<dyn Source<T, E>>,
}

/// Origin of a [`Stored`] value.
pub trait Source<T, E>: Send + Sync {
    /// Looks up or computes the value.
    ///
    /// # Errors
    /// The error of the stage that makes it.
    fn get(&self) -> Result<Arc<T>, E>;
}

impl<T, E> Stored<T, E> {
    /// The output of the stage with this key.
    pub fn new(key: Digest, source: Arc<dyn Source<T, E>>) -> Self {
        Self { key, source }
    }

    /// Returns the value. Must not be called within a parallel loop: making the value may need the threads of the loop.
    ///
    /// # Errors
    /// The error of the stage that makes it.
    pub fn get(&self) -> Result<Arc<T>, E> {
        self.source.get()
    }

    /// Digest of everything the value depends on.
    pub fn key(&self) -> &Digest {
        &self.key
    }
}

impl<T: Send + Sync + 'static, E: 'static> Stored<T, E> {
    /// Wraps an available value under a key chosen by the caller, for tests and for callers that run a single stage.
    pub fn ready(key: Digest, value: T) -> Self {
        struct Ready<T>(Arc<T>);
        impl<T: Send + Sync, E> Source<T, E> for Ready<T> {
            fn get(&self) -> Result<Arc<T>, E> {
                Ok(Arc::clone(&self.0))
            }
        }
        Self::new(key, Arc::new(Ready(Arc::new(value))))
    }
}

impl<T, E> Clone for Stored<T, E> {
    fn clone(&self) -> Self {
        Self::new(self.key, Arc::clone(&self.source))
    }
}

impl<T: Send + Sync + 'static, E: 'static> Serialize for Stored<T, E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        inputs::register(&self.key, || -> Arc<dyn Input<E>> { Arc::new(self.clone()) });
        serializer.serialize_bytes(&self.key)
    }
}

/// Returns the values of several inputs.
///
/// # Errors
/// The errors of the stages that make them.
pub fn all<T, E>(inputs: &[Stored<T, E>]) -> Result<Vec<Arc<T>>, E> {
    inputs.iter().map(Stored::get).collect()
}

impl<T: Send + Sync, E> Input<E> for Stored<T, E> {
    fn prepare(&self) -> Result<(), E> {
        self.get().map(drop)
    }
}

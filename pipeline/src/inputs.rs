//! Finds the inputs of a stage while its fields are serialised for its key.
//!
//! A separate list of inputs would have to be maintained along with the fields. Serialisation already visits every
//! field, including options, lists and nested values, and every [`Stored`](crate::Stored) it visits is an input.

use std::any::Any;
use std::cell::RefCell;
use std::ops::Deref;
use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::store::Digest;

/// An input of a stage, of any type.
pub trait Input<E>: Send + Sync {
    /// Makes the value if it has not been made yet.
    ///
    /// # Errors
    /// The error of the stage that makes it.
    fn prepare(&self) -> Result<(), E>;
}

thread_local! {
    /// Inputs found so far in the stage that this thread is serialising.
    static FOUND: RefCell<Option<Vec<Found>>> = const { RefCell::new(None) };
}

/// An input, whatever its error type.
struct Found {
    /// Key of the stage that makes it.
    key: Digest,
    /// An `Arc<dyn Input<E>>`.
    input: Box<dyn Any>,
}

/// Runs work that serialises values; also returns the inputs within them, each once.
pub(crate) fn collect<T, E: 'static>(work: impl FnOnce() -> T) -> (T, Vec<Arc<dyn Input<E>>>) {
    let outer = FOUND.replace(Some(Vec::new()));
    let value = work();
    let found = FOUND.replace(outer).unwrap_or_default();
    let inputs = found
        .into_iter()
        .filter_map(|found| found.input.downcast::<Arc<dyn Input<E>>>().ok())
        .map(|input| *input);
    (value, inputs.collect())
}

/// Counts the output of the stage `key` as an input of the stage that is being serialised, if one is.
pub(crate) fn register<E: 'static>(key: &Digest, input: impl FnOnce() -> Arc<dyn Input<E>>) {
    FOUND.with_borrow_mut(|found| {
        let Some(found) = found else { return };
        if found.iter().all(|known| known.key != *key) {
            found.push(Found {
                key: *key,
                input: Box::new(input()),
            });
        }
    });
}

/// Inputs that a stage reads only in some cases, or one after the other to save memory. They are part of its key but
/// are not made in advance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OnDemand<T>(pub T);

impl<T> Deref for OnDemand<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Serialize> Serialize for OnDemand<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let outer = FOUND.take();
        let serialized = self.0.serialize(serializer);
        FOUND.set(outer);
        serialized
    }
}

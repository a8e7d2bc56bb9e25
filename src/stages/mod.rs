//! The stages of the chain from inputs to sound power, and functions that several of them share; `chain` shows their
//! order.
//!
//! A [`Stage`] is a value that contains all its inputs and nothing else. Its key is the digest of its name, of the code
//! it calls and of its serialised fields, so that a stored result can be neither stale nor confused with another. A
//! large input is a [`Stored`]: it counts by the key of the stage that makes it, and is made when it is first read.
//!
//! Stages depend neither on the design file nor on the store. `design::inputs` makes their fields from a design,
//! `chain` assembles them, and `graph` looks them up, computes, stores and times them.

pub mod apart;
pub mod bodies;
pub mod changes;
mod codec;
pub mod convention;
pub mod cycle;
pub mod headline;
pub mod intervals;
pub mod levels;
pub mod microphones;
pub mod notes;
pub mod outcomes;
mod progress;
pub mod radiation;
pub mod ranking;
pub mod requirements;
pub mod response;
pub mod sensors;
pub mod sound;
pub mod sound_fields;
pub mod sources;
pub mod spectra;
pub mod starts;
pub mod tool_response;
pub mod transducers;
pub mod truncation;

use std::sync::Arc;

use serde::{Serialize, Serializer};

pub use codec::{Codec, Entry, HasMatrix, Postcard, Uncached, Undecodable, WithMatrix, matrix};
pub use progress::{Observer, Progress, Silent, Task, WithoutStages};

use crate::error::Error;

/// A step of the chain: its inputs and its output.
pub trait Stage: Serialize + Send + Sync + 'static {
    /// Its output.
    type Output: Send + Sync + 'static;
    /// How the output is stored between runs: [`Postcard`], [`Uncached`], or a dedicated form.
    type Codec: Codec<Self::Output>;
    /// Its name in the store, in progress and in the timing of a run.
    const NAME: &'static str;
    /// Digests of the code that it calls, made by the macro `code!`.
    const CODE: Code;

    /// The inputs that it reads in every case; they are made side by side before [`compute`](Self::compute) is called.
    fn inputs(&self) -> Vec<&dyn Input> {
        Vec::new()
    }

    /// Makes the output.
    ///
    /// # Errors
    /// [`Error`] of the computation, or of an input.
    fn compute(&self, progress: &Progress) -> Result<Self::Output, Error>;
}

/// Name and digest of each unit of code that a stage calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Code(pub &'static [(&'static str, &'static str)]);

/// The [`Code`] of a stage: the crates whose functions it calls, as `dynamics`, and the modules of `stages`, as
/// `stages_bodies`, that make its output. The digests are made at build time (`build.rs`).
macro_rules! code {
    ($($unit:ident),* $(,)?) => {
        $crate::stages::Code(&[$((stringify!($unit), env!(concat!("NAILNOISE_CODE_", stringify!($unit))))),*])
    };
}
pub(crate) use code;

/// Digest of all that a stage's output depends on.
pub type Digest = [u8; 32];

/// The output of a stage, made when it is first read and shared by all who read it.
///
/// It is serialised as the key of its stage: a result that uses it depends on the inputs of that stage, not on its
/// bytes, whose last digits may differ between machines.
pub struct Stored<T> {
    key: Digest,
    source: Arc<dyn Source<T>>,
}

/// Origin of a [`Stored`] value.
pub trait Source<T>: Send + Sync {
    /// The value, looked up or computed.
    ///
    /// # Errors
    /// [`Error`] of the stage that makes it.
    fn get(&self) -> Result<Arc<T>, Error>;
}

impl<T> Stored<T> {
    /// The output of the stage with this key.
    pub fn new(key: Digest, source: Arc<dyn Source<T>>) -> Self {
        Self { key, source }
    }

    /// The value. Must not be called within a parallel loop: the threads of the loop may be the ones that make it.
    ///
    /// # Errors
    /// [`Error`] of the stage that makes it.
    pub fn get(&self) -> Result<Arc<T>, Error> {
        self.source.get()
    }

    /// Digest of all that the value depends on.
    pub fn key(&self) -> &Digest {
        &self.key
    }
}

impl<T: Send + Sync + 'static> Stored<T> {
    /// A value at hand, under a key of the caller's choice: for tests, and for callers that run a single stage.
    pub fn ready(key: Digest, value: T) -> Self {
        struct Ready<T>(Arc<T>);
        impl<T: Send + Sync> Source<T> for Ready<T> {
            fn get(&self) -> Result<Arc<T>, Error> {
                Ok(Arc::clone(&self.0))
            }
        }
        Self::new(key, Arc::new(Ready(Arc::new(value))))
    }
}

impl<T> Clone for Stored<T> {
    fn clone(&self) -> Self {
        Self::new(self.key, Arc::clone(&self.source))
    }
}

impl<T> Serialize for Stored<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.key)
    }
}

/// The values of several inputs.
///
/// # Errors
/// [`Error`] of the stages that make them.
pub(crate) fn all<T>(inputs: &[Stored<T>]) -> Result<Vec<Arc<T>>, Error> {
    inputs.iter().map(Stored::get).collect()
}

/// An input of a stage, of any type.
pub trait Input: Send + Sync {
    /// Makes the value, if it is not made yet.
    ///
    /// # Errors
    /// [`Error`] of the stage that makes it.
    fn prepare(&self) -> Result<(), Error>;
}

impl<T: Send + Sync> Input for Stored<T> {
    fn prepare(&self) -> Result<(), Error> {
        self.get().map(drop)
    }
}

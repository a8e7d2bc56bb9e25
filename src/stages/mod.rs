//! The stages of the chain from inputs to sound power, and functions shared by several of them; `chain` shows their
//! order.
//!
//! A [`Stage`] is a value that contains exactly its inputs. Its key is the digest of its name, the code it calls and
//! its serialised fields, so that a stored result can be neither stale nor confused with another. A large input is a
//! [`Stored`]: its key is that of the stage that makes it, and it is computed when it is first read.
//!
//! Stages depend neither on the design file nor on the store. `design::inputs` makes their fields from a design,
//! `chain` assembles them, and `graph` finds them in the store or computes, stores and times them.

pub mod apart;
pub mod bodies;
pub mod changes;
pub mod convention;
pub mod cycle;
pub mod headline;
pub mod intervals;
pub mod levels;
pub mod microphones;
pub mod modal_efficiency;
pub mod motion_bands;
pub mod notes;
pub mod outcomes;
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

pub use nailnoise_pipeline::store::Digest;
pub use nailnoise_pipeline::{
    Code, Codec, Entry, HasMatrix, Input, Observer, OnDemand, Postcard, Progress, Silent, Stage, Task, Uncached,
    Undecodable, WithMatrix, WithoutStages, all, matrix,
};

use crate::error::Error;

/// The output of a stage of this program, as an input of another.
pub type Stored<T> = nailnoise_pipeline::Stored<T, Error>;

/// The [`Code`] of a stage: the crates whose functions it calls, such as `dynamics`, and the modules of `stages` that
/// make its output, such as `stages_bodies`. The digests are made at build time (`build.rs`).
macro_rules! code {
    ($($unit:ident),* $(,)?) => {
        $crate::stages::Code(&[$((stringify!($unit), env!(concat!("NAILNOISE_CODE_", stringify!($unit))))),*])
    };
}
pub(crate) use code;

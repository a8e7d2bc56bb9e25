#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod codec;
mod error;
mod graph;
mod inputs;
mod progress;
mod stage;
pub mod store;
mod stored;
mod threads;
mod timing;

pub use codec::{Codec, Entry, HasMatrix, Postcard, Uncached, Undecodable, WithMatrix, matrix};
pub use error::{PipelineError, StageError, first_cause};
pub use graph::{Graph, key};
pub use inputs::{Input, OnDemand};
pub use progress::{Observer, Progress, Silent, Task, WithoutStages};
pub use stage::{Code, Stage};
pub use store::Digest;
pub use stored::{Source, Stored, all};
pub use threads::{Begun, beside};
pub use timing::Timing;

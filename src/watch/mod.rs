//! A design that runs again when it is saved, with its report on a page that follows: the parts of `nailnoise watch`.
//!
//! [`Watched`] lists the files of the design and waits for their changes, [`Board`] has the content of the page, and
//! [`Server`] serves it to browsers on this machine. [`Slider`]s of the page change values over those of the
//! file. The code that runs the design is a layer above, in the command.

mod board;
mod files;
mod page;
mod request;
mod server;
mod shot;
mod slider;

pub use board::Board;
pub use files::Watched;
pub use server::Server;
pub use shot::{Differences, FinishedRun, Sound};
pub use slider::Slider;

//! Runs a design again when it is saved and shows its report on a page that updates: the parts of `nailnoise watch`.
//!
//! [`Watched`] lists the files of the design and waits for their changes, [`Board`] has the content of the page, and
//! [`Server`] serves it to browsers on this machine. The code that runs the design is one layer above, in the command.

mod board;
mod files;
mod page;
mod request;
mod server;
mod shot;

pub use board::Board;
pub use files::Watched;
pub use server::Server;
pub use shot::{Differences, FinishedRun};

//! A design that runs again when it is saved, with its report on a page that follows: what `nailnoise watch` is made of.
//!
//! [`Watched`] knows the files of the design and waits for their changes, [`Board`] holds what the page shows, and [`Server`]
//! serves it to browsers on this machine. What runs the design stands above, in the command.

mod board;
mod files;
mod page;
mod request;
mod server;
mod shot;

pub use board::Board;
pub use files::Watched;
pub use server::Server;
pub use shot::{Differences, Shot};

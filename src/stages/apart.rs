//! A source separated from the part that the convention of selective wrapping assigns to another source.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// A source, and the part of it that is assigned to another source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Apart<T> {
    /// The source without that part.
    pub own: T,
    /// The part.
    pub moved: Option<Moved<T>>,
}

/// A part that is assigned to another source than the one that makes it; its energies may have either sign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Moved<T> {
    /// Name of the source to which it is assigned.
    pub to: Cow<'static, str>,
    /// Error of its energy.
    pub error: PartError,
    /// The part.
    pub part: T,
}

/// Error of the energy of a part that is assigned to another source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PartError {
    /// Error of the part itself.
    OfPart,
    /// Error of the source with the part: it may be entirely in the part, or entirely in the rest.
    OfWhole,
}

impl<T> Apart<T> {
    /// A source without a part that is assigned to another one.
    pub fn whole(own: T) -> Self {
        Self { own, moved: None }
    }

    /// The source, then its part.
    pub fn parts(&self) -> Vec<&T> {
        let moved = self.moved.iter().map(|moved| &moved.part);
        std::iter::once(&self.own).chain(moved).collect()
    }

    /// Applies a function to the source, then to its part.
    pub fn map<'a, U>(&'a self, mut of: impl FnMut(&'a T) -> U) -> Apart<U> {
        Apart {
            own: of(&self.own),
            moved: self.moved.as_ref().map(|moved| Moved {
                to: moved.to.clone(),
                error: moved.error,
                part: of(&moved.part),
            }),
        }
    }
}

//! The sources of sound, one module each. All other code iterates over `ALL`.
//!
//! A source is one file here, or a folder whose other files make its stages, and one line in `ALL`. Its name is also
//! one of [`crate::design::SOURCES`], so that a design can set the error of its method.

pub mod exhaust;
mod housing;
mod source;
mod workpiece;

use crate::stages::bodies::BodyKind;
pub(crate) use source::{Compared, ImpedanceComparison, Source, SourceStages};

/// All sources, in the order of every table.
pub(crate) static ALL: [&dyn Source; 3] = [&workpiece::Workpiece, &exhaust::ExhaustAir, &housing::Housing];

/// A source by its name.
pub(crate) fn by_name(name: &str) -> Option<&'static dyn Source> {
    ALL.into_iter().find(|source| source.name() == name)
}

/// The source that radiates the vibration of a body.
pub(crate) fn of_body(body: BodyKind) -> Option<&'static dyn Source> {
    ALL.into_iter().find(|source| source.bodies().contains(&body))
}

/// Names of all sources, in the order of every table.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.into_iter().map(Source::name)
}

//! Values, ranges and texts of one key, collected from a chain of files before they are resolved.

use nailnoise_quantities::KeySpec;

use super::distribution::Distribution;
use super::provenance::Provenance;
use super::range::GivenRange;
use super::settings::Given;
use nailnoise_documents::Place;

/// Values, ranges and texts of one key from the files, the nearest file last.
#[derive(Debug, Clone)]
pub(crate) struct Merged {
    pub(super) spec: &'static KeySpec,
    pub(super) value: Option<(Given, String, Box<Place>)>,
    pub(super) range: Option<(GivenRange, Box<Place>)>,
    /// The value in the file that states the range, if a file nearer to the design gives another value.
    pub(super) value_of_range: Option<Given>,
    pub(super) distribution: Option<(Distribution, Box<Place>)>,
    pub(super) provenance: Provenance,
    pub(super) source: String,
    pub(super) note: String,
    /// Number of files between this one and the design itself.
    pub(super) depth: usize,
}

impl Merged {
    /// The value given so far.
    pub(crate) fn given(&self) -> Option<Given> {
        self.value.as_ref().map(|(given, ..)| given.clone())
    }

    /// Discards the statements about its range.
    pub(crate) fn forget_range(&mut self) {
        (self.range, self.value_of_range, self.distribution) = (None, None, None);
    }
}

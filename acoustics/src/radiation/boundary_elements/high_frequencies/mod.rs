//! Frequencies above those solved individually: averaged boundary elements, and the high-frequency limit.

pub(crate) mod composite;
pub(crate) mod faces;
pub(crate) mod frequencies;
pub(crate) mod mean_bands;

pub use mean_bands::{MeanBand, MeanBands};

//! What places around a device hear: pressures, their course in time, and levels by the standard's procedure.
//!
//! A source that knows phases gives the complex pressure at every place (boundary elements with
//! [`crate::bem::Receivers`], a flush surface by [`SoundAbovePlane`], which is part of
//! all its sound, [`FlushSound`], a shaken sphere by [`shaken_sphere_pressure`]). One
//! that knows energies alone is [spread evenly](spread_evenly). Spectra become signals by [`OverTime`].

mod array;
mod bands;
mod directions;
mod fields;
mod flush;
mod plane;
mod sphere;
mod spread;
mod time;

pub use array::{Iso3744Box, background_correction, environmental_correction};
pub use bands::{Around, BandSound, above_plane};
pub(crate) use bands::{bins_of, groups, of_bins, squares};
pub use directions::Directions;
pub(crate) use fields::{Field, Fields};
pub use flush::FlushSound;
pub use plane::SoundAbovePlane;
pub use sphere::{rigid_body_far_field, shaken_sphere_pressure};
pub use spread::{Spread, spread_evenly};
pub use time::OverTime;

use nalgebra::Point3;

/// The image of a place in the horizontal plane at the height `plane`.
fn image(place: Point3<f64>, plane: f64) -> Point3<f64> {
    Point3::new(place.x, place.y, 2.0 * plane - place.z)
}

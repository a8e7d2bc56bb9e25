//! Sound at points around a device: pressures, time signals, and levels by the procedure of the standard.
//!
//! A source with known phases gives the complex pressure at every point: boundary elements with
//! [`Receivers`](super::boundary_elements::Receivers), a flush surface by
//! [`SoundAbovePlane`](super::flush_with_sand::SoundAbovePlane), an oscillating sphere by
//! [`oscillating_sphere_pressure`]. If only the energy of a source is known, the source is treated as
//! [omnidirectional](omnidirectional_transfer). [`ChirpTransform`](crate::signals::ChirpTransform) converts spectra to
//! signals.

mod array;
mod bands;
mod directions;
mod fields;
mod omnidirectional;
mod sphere;

pub use array::{Iso3744Box, background_correction, environmental_correction};
pub use bands::{BandSound, FieldPoints};
pub(crate) use bands::{bins_of, groups, of_bins, squares};
pub use directions::Directions;
pub(crate) use fields::{Field, Fields};
pub use omnidirectional::{OmnidirectionalTransfer, omnidirectional_transfer};
pub use sphere::{oscillating_sphere_pressure, rigid_body_far_field};

use nalgebra::Point3;

/// The mirror image of a point in the horizontal plane at height `plane`.
fn image(place: Point3<f64>, plane: f64) -> Point3<f64> {
    Point3::new(place.x, place.y, 2.0 * plane - place.z)
}

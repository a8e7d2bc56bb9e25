//! Argument checks shared by several modules, and the errors that they return.

use thiserror::Error;

/// An argument with an invalid value or length.
#[derive(Debug, Error)]
pub enum InputError {
    /// Two corresponding arrays differ in length.
    #[error("{what}: {found} values where {expected} are needed; give both on the same points or samples")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Expected length.
        expected: usize,
    },
    /// A quantity that must be finite and positive is not.
    #[error("{what} is {value}; it must be a finite number above zero")]
    NotPositive {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A value of a history or spectrum is not finite.
    #[error("{what}[{index}] is {value}; every value must be finite")]
    NotFinite {
        /// The array.
        what: &'static str,
        /// Index of the first such value.
        index: usize,
        /// The value.
        value: f64,
    },
    /// A quantity is outside the validity range of the model.
    #[error("{what} is {value}, outside {low} to {high}")]
    OutsideRange {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
    },
}

/// Why the sound pressure at a point cannot be computed.
#[derive(Debug, Error)]
pub enum ReceiverError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// An outlet or receiver is below the floor.
    #[error("a point at z = {z} m lies below the floor at {floor} m; outlet and receiver must stand on or above it")]
    BelowFloor {
        /// Height of the point \[m\].
        z: f64,
        /// Height of the floor \[m\].
        floor: f64,
    },
    /// A receiver is too close to a radiating surface.
    #[error(
        "the point {point:.3?} m lies {distance:.3} m from the radiating surface; at least {needed:.3} m, the longest \
         edge of a \
         panel, are needed: move it away or refine the mesh"
    )]
    NearSurface {
        /// The point \[m\].
        point: [f64; 3],
        /// Its distance from the nearest panel \[m\].
        distance: f64,
        /// Required distance \[m\].
        needed: f64,
    },
}

/// Returns `value`, or [`InputError::NotPositive`] unless it is finite and greater than zero.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, InputError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(InputError::NotPositive { what, value })
    }
}

/// Returns [`InputError::NotFinite`] for the first value that is not finite.
pub(crate) fn finite(what: &'static str, values: &[f64]) -> Result<(), InputError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(InputError::NotFinite {
            what,
            index,
            value: values[index],
        }),
    }
}

/// Returns [`InputError::Length`] unless the two lengths agree.
pub(crate) fn same_length(what: &'static str, found: usize, expected: usize) -> Result<(), InputError> {
    if found == expected {
        Ok(())
    } else {
        Err(InputError::Length { what, found, expected })
    }
}

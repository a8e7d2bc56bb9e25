//! Stations along the nail's axis at which its force acts on the wood.

/// Number of stations from the surface to the depth of a fully driven tip; 7.5 mm apart for a 12d nail, finer than the
/// elements.
pub(crate) const STATIONS: usize = 12;

/// Depths of the stations below the surface \[m\].
pub(crate) fn depths(nail_length: f64) -> [f64; STATIONS] {
    std::array::from_fn(|k| nail_length * k as f64 / (STATIONS - 1) as f64)
}

//! Element size required by the shortest waves in a mesh.

use crate::MeshError;

/// Element size \[m\] at which the slowest wave has `elements` elements per wavelength at the top frequency: h = c / (f
/// n).
///
/// `slowest_speed` is usually sqrt(G_min / rho) \[m/s\]. With three quadratic elements per wavelength, frequencies have
/// an error below half a percent.
///
/// # Errors
/// [`MeshError::Dimension`] unless every argument is positive and finite.
pub fn element_size(top_frequency: f64, slowest_speed: f64, elements: f64) -> Result<f64, MeshError> {
    let h = slowest_speed / (top_frequency * elements);
    if h.is_finite() && h > 0.0 && elements > 0.0 && top_frequency > 0.0 {
        Ok(h)
    } else {
        Err(MeshError::Dimension {
            what: "the element size c / (f n)",
            value: h,
        })
    }
}

/// Positions that divide \[from, to\] into equal elements no longer than `size`. The first position is omitted so that
/// intervals can be joined.
///
/// # Errors
/// [`MeshError::Dimension`] unless `size` and the interval are positive and finite.
pub fn subdivide(from: f64, to: f64, size: f64) -> Result<Vec<f64>, MeshError> {
    for (what, value) in [("the element size", size), ("a stretch to divide", to - from)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(MeshError::Dimension { what, value });
        }
    }
    // An interval that is a multiple of the size up to rounding must not get an extra element.
    let n = ((to - from) / size * (1.0 - 1e-12)).ceil().max(1.0) as usize;
    Ok((1..=n)
        .map(|i| {
            if i == n {
                to
            } else {
                from + (to - from) * i as f64 / n as f64
            }
        })
        .collect())
}

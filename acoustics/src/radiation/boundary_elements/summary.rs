use serde::{Deserialize, Serialize};

/// Summary of the sampling of a radiation matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of frequencies solved on the mesh of their range.
    pub samples: usize,
    /// Largest interpolation error over frequency: root mean square over the entries R_ij relative to sqrt(R_ii R_jj).
    pub interpolation: f64,
    /// Largest difference between the powers from surface and far field, for modes within 30 dB of the loudest \[dB\].
    pub difference_db: f64,
    /// Largest asymmetry of R, relative to its largest entry.
    pub asymmetry: f64,
    /// Bound on the level error due to panels at the rims of thin gaps, see [`Gap`](crate::bem::Gap) \[dB\]; zero
    /// without gaps.
    pub gap_error_db: f64,
}

//! Penetration resistance given by points.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest depth \[m\] and largest force \[N\] of a table: longer than any nail, and enough to crush its shank.
const DEEPEST: f64 = 10.0;
const LARGEST: f64 = 1e7;

/// Force over depth, given by points with monotone cubic interpolation.
///
/// The slopes at the points are those of Fritsch and Butland (1984). The curve has a continuous first derivative,
/// passes through every point, and rises or falls only where the points do. It is valid from the surface to the last
/// depth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Points", into = "Points")]
pub struct ForceTable {
    depths: Vec<f64>,
    forces: Vec<f64>,
    slopes: Vec<f64>,
}

/// The points as stored.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Points {
    depths: Vec<f64>,
    forces: Vec<f64>,
}

impl TryFrom<Points> for ForceTable {
    type Error = TableError;

    fn try_from(points: Points) -> Result<Self, TableError> {
        Self::new(points.depths, points.forces)
    }
}

impl From<ForceTable> for Points {
    fn from(table: ForceTable) -> Self {
        Self {
            depths: table.depths,
            forces: table.forces,
        }
    }
}

/// Why points do not define a penetration law.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The lists differ in length.
    #[error("there are {depths} depths and {forces} forces; give one force a depth")]
    Lengths {
        /// Number of depths.
        depths: usize,
        /// Number of forces.
        forces: usize,
    },
    /// Fewer than two points.
    #[error("a penetration law needs two points at least, this table has {count}")]
    TooFew {
        /// Points found.
        count: usize,
    },
    /// A depth or force is implausible.
    #[error(
        "point {point} is {depth:?} m, {force:?} N; depths of at most {DEEPEST} m and forces from 0 to {LARGEST:e} N \
         are expected; \
         correct the point, or the units of the columns"
    )]
    Value {
        /// Index of the point, from 1.
        point: usize,
        /// Its depth \[m\].
        depth: f64,
        /// Its force \[N\].
        force: f64,
    },
    /// The first point is not at the surface.
    #[error("the first depth is {depth} m; begin the table at the surface, with a depth of 0")]
    Start {
        /// First depth \[m\].
        depth: f64,
    },
    /// The depths do not increase.
    #[error("depth {depth} m of point {point} follows {before} m; sort the points by depth, each depth once")]
    Order {
        /// Index of the point, from 1.
        point: usize,
        /// Its depth \[m\].
        depth: f64,
        /// The preceding depth \[m\].
        before: f64,
    },
}

impl ForceTable {
    /// Creates a table from depths \[m\], increasing from 0, and forces \[N\].
    ///
    /// # Errors
    /// [`TableError`] for the first invalid point.
    pub fn new(depths: Vec<f64>, forces: Vec<f64>) -> Result<Self, TableError> {
        if depths.len() != forces.len() {
            return Err(TableError::Lengths {
                depths: depths.len(),
                forces: forces.len(),
            });
        }
        if depths.len() < 2 {
            return Err(TableError::TooFew { count: depths.len() });
        }
        for (i, (&depth, &force)) in depths.iter().zip(&forces).enumerate() {
            let point = i + 1;
            if !(depth.abs() <= DEEPEST && (0.0..=LARGEST).contains(&force)) {
                return Err(TableError::Value { point, depth, force });
            }
            if i == 0 && depth != 0.0 {
                return Err(TableError::Start { depth });
            }
            if i > 0 && depth <= depths[i - 1] {
                let before = depths[i - 1];
                return Err(TableError::Order { point, depth, before });
            }
        }
        let slopes = slopes(&depths, &forces);
        Ok(Self { depths, forces, slopes })
    }

    /// Depth of the last point \[m\].
    pub fn last_depth(&self) -> f64 {
        self.depths[self.depths.len() - 1]
    }

    /// Force at `depth` \[N\]; zero at or above the surface, linearly extrapolated beyond the last point.
    pub fn force(&self, depth: f64) -> f64 {
        if depth <= 0.0 { 0.0 } else { self.evaluate(depth).0 }
    }

    /// Force and its derivative, linearly extrapolated beyond both ends.
    #[inline]
    pub(crate) fn evaluate(&self, depth: f64) -> (f64, f64) {
        let last = self.depths.len() - 1;
        let right = self.depths.partition_point(|x| *x <= depth);
        if right == 0 || right > last {
            let end = if right == 0 { 0 } else { last };
            let slope = self.slopes[end];
            return (self.forces[end] + slope * (depth - self.depths[end]), slope);
        }
        // Cubic Hermite polynomial in s = (x - x_k)/h.
        let k = right - 1;
        let h = self.depths[right] - self.depths[k];
        let s = (depth - self.depths[k]) / h;
        let (f, rise) = (self.forces[k], self.forces[right] - self.forces[k]);
        let (a, b) = (self.slopes[k] * h, self.slopes[right] * h);
        let (c2, c3) = (3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise);
        (f + s * (a + s * (c2 + s * c3)), (a + s * (2.0 * c2 + 3.0 * s * c3)) / h)
    }
}

/// Slopes that make the cubics monotone: zero at a local extremum, else a weighted harmonic mean of the adjacent chords
/// (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984). At the ends, the limited slope of a parabola through
/// three points.
fn slopes(x: &[f64], f: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let chord: Vec<f64> = f.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    if n == 2 {
        return vec![chord[0]; 2];
    }
    let end = |h0: f64, h1: f64, d0: f64, d1: f64| {
        let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if slope * d0 <= 0.0 {
            0.0
        } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
            3.0 * d0
        } else {
            slope
        }
    };
    let mut slopes = vec![0.0; n];
    slopes[0] = end(h[0], h[1], chord[0], chord[1]);
    slopes[n - 1] = end(h[n - 2], h[n - 3], chord[n - 2], chord[n - 3]);
    for k in 1..n - 1 {
        let (left, right) = (chord[k - 1], chord[k]);
        if left * right > 0.0 {
            let (w1, w2) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
            slopes[k] = (w1 + w2) / (w1 / left + w2 / right);
        }
    }
    slopes
}

//! Point sources in a plane, and reduced sets of equivalent sources for long waves.

use super::spherical_waves::highest_order;
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// Points of a plane and their source strengths for each mode.
#[derive(Debug, Clone)]
pub(super) struct Sources {
    /// x and y \[m\].
    pub(super) points: Vec<[f64; 2]>,
    /// Indices of the points of each patch.
    pub(super) rows: Vec<Vec<usize>>,
    /// Displacement of each mode at the points times their area, points x modes.
    pub(super) strengths: DMatrix<f64>,
}

impl Sources {
    /// Equivalent sources on a [`Grid`] for waves up to a wavenumber k, or a copy of these sources if the grid would
    /// have more than half as many points.
    pub(super) fn fewer(&self, k: f64) -> Self {
        let grid = Grid::new(extent(&self.points), k);
        let cells = grid.len();
        if 2 * cells * self.rows.len() > self.points.len() {
            return self.clone();
        }
        let mut strengths = DMatrix::zeros(cells * self.rows.len(), self.strengths.ncols());
        for (patch, rows) in self.rows.iter().enumerate() {
            let mut carried = DMatrix::zeros(cells, rows.len());
            for (&row, mut column) in rows.iter().zip(carried.column_iter_mut()) {
                grid.shares(self.points[row], column.as_mut_slice());
            }
            let of_patch = carried * self.strengths.select_rows(rows);
            strengths.rows_mut(patch * cells, cells).copy_from(&of_patch);
        }
        Self {
            points: grid.points().repeat(self.rows.len()),
            rows: (0..self.rows.len())
                .map(|patch| (patch * cells..(patch + 1) * cells).collect())
                .collect(),
            strengths,
        }
    }
}

/// Bounding rectangle of points, intervals of x and y.
pub(super) fn extent(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let along = points.iter().map(|p| p[axis]);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    })
}

/// Chebyshev points of a rectangle. A wave is a smooth function on the rectangle, and its values w at these points x_c
/// determine it to ten digits. Any set of sources is therefore equivalent to sources at these points:
///
/// ```text
/// w(x_a) = sum_c L_c(x_a) w(x_c)        =>      sum_a s_a w(x_a) = sum_c s'_c w(x_c),   s'_c = sum_a L_c(x_a) s_a
/// ```
#[derive(Debug)]
pub(super) struct Grid {
    axes: [Vec<f64>; 2],
}

impl Grid {
    /// Creates the grid for waves up to a wavenumber k.
    pub(super) fn new(extent: [[f64; 2]; 2], k: f64) -> Self {
        Self {
            axes: extent.map(|ends| chebyshev(ends, k)),
        }
    }

    /// Number of its points.
    pub(super) fn len(&self) -> usize {
        self.axes[0].len() * self.axes[1].len()
    }

    /// Its points, x and y.
    pub(super) fn points(&self) -> Vec<[f64; 2]> {
        let [xs, ys] = &self.axes;
        xs.iter().flat_map(|&x| ys.iter().map(move |&y| [x, y])).collect()
    }

    /// L_c at a point of the rectangle, for each grid point.
    pub(super) fn shares(&self, point: [f64; 2], to: &mut [f64]) {
        let [x, y] = [0, 1].map(|axis| lagrange(&self.axes[axis], point[axis]));
        let products = x.iter().flat_map(|x| y.iter().map(move |y| x * y));
        to.iter_mut().zip(products).for_each(|(to, value)| *to = value);
    }
}

/// Chebyshev points of the first kind on an interval, enough for waves of wavenumber k along it: the Chebyshev
/// coefficients of such waves are Bessel functions of k times half its length.
fn chebyshev([low, high]: [f64; 2], k: f64) -> Vec<f64> {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    if half == 0.0 {
        return vec![middle];
    }
    let count = highest_order(k * half) + 2;
    (0..count)
        .map(|i| middle - half * (PI * (i as f64 + 0.5) / count as f64).cos())
        .collect()
}

/// Lagrange polynomials on Chebyshev points, evaluated at x with barycentric weights.
fn lagrange(nodes: &[f64], x: f64) -> Vec<f64> {
    if let Some(hit) = nodes.iter().position(|node| *node == x) {
        return (0..nodes.len()).map(|i| f64::from(u8::from(i == hit))).collect();
    }
    let term = |(i, node): (usize, &f64)| {
        let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * (PI * (i as f64 + 0.5) / nodes.len() as f64).sin() / (x - node)
    };
    let terms: Vec<f64> = nodes.iter().enumerate().map(term).collect();
    let sum: f64 = terms.iter().sum();
    terms.into_iter().map(|t| t / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plane and spherical waves of a block with lively modes, in two patches.
    #[test]
    fn fewer_sources_send_out_the_same_waves() {
        let points: Vec<[f64; 2]> = (0..3600)
            .map(|i| {
                [
                    -0.2 + 0.4 * (f64::from(i % 90) + 0.5) / 90.0,
                    0.1 + 0.15 * (f64::from(i / 90) + 0.5) / 40.0,
                ]
            })
            .collect();
        let modes = DMatrix::from_fn(points.len(), 3, |i, j| {
            (9.0 * j as f64 * points[i][0] + 1.0).cos() * (14.0 * j as f64 * points[i][1]).cos() / 3600.0
        });
        let (left, right) = (0..points.len()).partition(|&i| points[i][0] < 0.03);
        let sources = Sources {
            points,
            rows: vec![left, right],
            strengths: modes,
        };
        let sent = |of: &Sources, patch: usize, wave: &dyn Fn([f64; 2]) -> f64| {
            let mut sum = nalgebra::RowDVector::zeros(3);
            for &row in &of.rows[patch] {
                sum += of.strengths.row(row) * wave(of.points[row]);
            }
            sum
        };
        for k in [0.5, 20.0] {
            let fewer = sources.fewer(k);
            assert!(fewer.points.len() < 700);
            for patch in [0, 1] {
                let plane = |[x, y]: [f64; 2]| (k * (0.6 * x - 0.8 * y) + 0.3).cos();
                let spherical =
                    |[x, y]: [f64; 2]| (k * (x - 0.3).hypot(y).hypot(0.4)).sin() / (x - 0.3).hypot(y).hypot(0.4);
                for wave in [&plane as &dyn Fn([f64; 2]) -> f64, &spherical] {
                    let (few, all) = (sent(&fewer, patch, wave), sent(&sources, patch, wave));
                    assert!((&few - &all).amax() < 1e-9, "{k}: {few} {all}");
                    assert!(all.amax() > 1e-2);
                }
            }
        }
        // Short waves need all points.
        assert_eq!(sources.fewer(400.0).points, sources.points);
    }
}

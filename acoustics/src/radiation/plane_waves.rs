//! The Rayleigh kernel as a sum of plane waves.
//!
//! ```text
//! sin(k r) / (k r) = (1/2 pi) int_hemisphere cos(k s . r) dOmega(s)        r in the plane
//! ```
//!
//! so that R = Y^T Y with Y the modes' far field in the directions s: positive semidefinite by construction, and at a
//! cost of directions x points x modes, where the directions needed grow with (k D)^2, D the surface's diameter. The
//! identity is exact; the quadrature over directions is spectrally accurate once it resolves spherical harmonics a
//! little beyond order k D.

use super::quadrature::gauss_legendre;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

/// Points of a plane, with the distinct values of each coordinate: on structured meshes a phase factor is then one
/// product of two tabulated ones.
#[derive(Debug, Clone)]
pub(crate) struct PlanarPoints {
    x: Vec<f64>,
    y: Vec<f64>,
    index: Vec<(usize, usize)>,
    pub(crate) diameter: f64,
}

impl PlanarPoints {
    pub(crate) fn new(points: &[[f64; 2]]) -> Self {
        let axis = |i: usize| {
            let mut values: Vec<f64> = points.iter().map(|p| p[i]).collect();
            values.sort_by(f64::total_cmp);
            let extent = values.last().zip(values.first()).map_or(0.0, |(b, a)| b - a);
            values.dedup_by(|b, a| *b - *a <= 1e-12 * extent);
            (values, extent)
        };
        let ((x, width), (y, depth)) = (axis(0), axis(1));
        let place = |values: &[f64], v: f64| values.partition_point(|&u| u <= v).saturating_sub(1);
        let index = points.iter().map(|p| (place(&x, p[0]), place(&y, p[1]))).collect();
        Self {
            x,
            y,
            index,
            diameter: width.hypot(depth),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.index.len()
    }

    /// Coordinates in the plane.
    pub(crate) fn at(&self, point: usize) -> [f64; 2] {
        let (x, y) = self.index[point];
        [self.x[x], self.y[y]]
    }
}

/// A point that follows another, its leader.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Follower {
    /// Number of the leader.
    pub(crate) leader: usize,
    /// Its velocity over the leader's, times the area it stands for \[m²\].
    pub(crate) amplitude: Complex<f64>,
}

/// Directions with their weights; they sum to one.
#[derive(Debug, Clone)]
pub(crate) struct Directions {
    x: Vec<f64>,
    y: Vec<f64>,
    root_weight: Vec<f64>,
}

impl Directions {
    /// Directions that integrate the waves of a surface of diameter `diameter` at the wavenumber `k`.
    ///
    /// j_l(k r) falls below 1e-13 beyond l = k r + 10 (k r)^{1/3} + 12, which sets the degree of both rules. Waves of
    /// direction s and of its mirror image about the normal are conjugate, so half the azimuths suffice.
    pub(crate) fn new(k: f64, diameter: f64) -> Self {
        let degree = |kr: f64| kr + 10.0 * kr.cbrt() + 12.0;
        let half = (degree(k * diameter) / 4.0).ceil() as usize + 1;
        let mut directions = Self {
            x: Vec::new(),
            y: Vec::new(),
            root_weight: Vec::new(),
        };
        for (u, w) in gauss_legendre(2 * half).into_iter().filter(|(u, _)| *u > 0.0) {
            let sine = (1.0 - u * u).sqrt();
            let azimuths = (degree(k * diameter * sine) / 2.0).ceil() as usize + 1;
            for i in 0..azimuths {
                let psi = PI * i as f64 / azimuths as f64;
                directions.x.push(sine * psi.cos());
                directions.y.push(sine * psi.sin());
                directions.root_weight.push((w / azimuths as f64).sqrt());
            }
        }
        directions
    }

    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }

    /// Adds the far field of `sources` (points x columns, already times area) to `field` (2 directions x columns):
    /// cosine parts above, sine parts below.
    pub(crate) fn add_field(
        &self,
        k: f64,
        points: &PlanarPoints,
        rows: &[usize],
        sources: &DMatrix<f64>,
        field: &mut DMatrix<f64>,
    ) {
        const CHUNK: usize = 384;
        let n = self.len();
        let waves_of = self.waves(k, points);
        for start in (0..rows.len()).step_by(CHUNK) {
            let chunk = &rows[start..(start + CHUNK).min(rows.len())];
            let mut waves = DMatrix::zeros(2 * n, chunk.len());
            for (&row, mut column) in chunk.iter().zip(waves.column_iter_mut()) {
                waves_of.of(row, column.as_mut_slice());
            }
            field.gemm(1.0, &waves, &sources.select_rows(chunk), 1.0);
        }
    }

    /// The far field of points that follow others, per unit of motion of each of those: real and imaginary part, both
    /// 2 directions x leaders.
    pub(crate) fn field_of_followers(
        &self,
        k: f64,
        points: &PlanarPoints,
        followers: &[Follower],
        leaders: usize,
    ) -> [DMatrix<f64>; 2] {
        let n = 2 * self.len();
        let waves_of = self.waves(k, points);
        let mut fields = [DMatrix::zeros(n, leaders), DMatrix::zeros(n, leaders)];
        let mut wave = vec![0.0; n];
        for (point, follower) in followers.iter().enumerate() {
            waves_of.of(point, &mut wave);
            let amplitude = follower.amplitude;
            for (field, amplitude) in fields.iter_mut().zip([amplitude.re, amplitude.im]) {
                let to = &mut field.as_mut_slice()[follower.leader * n..][..n];
                to.iter_mut().zip(&wave).for_each(|(to, w)| *to += amplitude * w);
            }
        }
        fields
    }

    /// Waves from points into all directions.
    fn waves<'a>(&self, k: f64, points: &'a PlanarPoints) -> Waves<'a> {
        let n = self.len();
        let table = |values: &[f64], along: &[f64], amplitude: Option<&[f64]>| {
            let mut cosine = DMatrix::zeros(n, values.len());
            let mut sine = DMatrix::zeros(n, values.len());
            for (j, value) in values.iter().enumerate() {
                for i in 0..n {
                    let (s, c) = (k * along[i] * value).sin_cos();
                    let a = amplitude.map_or(1.0, |a| a[i]);
                    (cosine[(i, j)], sine[(i, j)]) = (a * c, a * s);
                }
            }
            (cosine, sine)
        };
        Waves {
            points,
            along_x: table(&points.x, &self.x, Some(&self.root_weight)),
            along_y: table(&points.y, &self.y, None),
        }
    }
}

/// Phase factors along both coordinates, directions x values, cosines and sines.
struct Waves<'a> {
    points: &'a PlanarPoints,
    along_x: (DMatrix<f64>, DMatrix<f64>),
    along_y: (DMatrix<f64>, DMatrix<f64>),
}

impl Waves<'_> {
    /// That of one point: cosine parts of all directions, then sine parts.
    fn of(&self, point: usize, wave: &mut [f64]) {
        let n = self.along_x.0.nrows();
        let (ix, iy) = self.points.index[point];
        let (cosine, sine) = wave.split_at_mut(n);
        let (xc, xs) = (
            &self.along_x.0.as_slice()[ix * n..][..n],
            &self.along_x.1.as_slice()[ix * n..][..n],
        );
        let (yc, ys) = (
            &self.along_y.0.as_slice()[iy * n..][..n],
            &self.along_y.1.as_slice()[iy * n..][..n],
        );
        for i in 0..n {
            cosine[i] = xc[i] * yc[i] - xs[i] * ys[i];
            sine[i] = xs[i] * yc[i] + xc[i] * ys[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_waves_sum_to_the_kernel() {
        let points = [[0.0, 0.0], [0.4, 0.1], [-0.03, 0.15], [0.2, -0.2]];
        for k in [0.1, 1.0, 7.0, 60.0, 180.0] {
            let planar = PlanarPoints::new(&points);
            let directions = Directions::new(k, planar.diameter);
            let mut field = DMatrix::zeros(2 * directions.len(), points.len());
            directions.add_field(k, &planar, &[0, 1, 2, 3], &DMatrix::identity(4, 4), &mut field);
            let kernel = field.tr_mul(&field);
            for i in 0..4 {
                for j in 0..4 {
                    let kr = k * (points[i][0] - points[j][0]).hypot(points[i][1] - points[j][1]);
                    let sinc = if kr == 0.0 { 1.0 } else { kr.sin() / kr };
                    let error = kernel[(i, j)] - sinc;
                    assert!(error.abs() < 1e-12, "k = {k}, pair {i} {j}: error {error:.2e}");
                }
            }
        }
    }
}

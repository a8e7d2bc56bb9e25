//! The Rayleigh kernel as a sum of standing spherical waves.
//!
//! ```text
//! sin(k r) / (k r) = sum_lm w_lm(x) w_lm(y)        r = |x - y|, x and y in the plane
//! w_lm(x) = j_l(k |x|) sqrt((2 l + 1) c_{(l-m)/2} c_{(l+m)/2}) {1, sqrt(2) cos(m psi), sqrt(2) sin(m psi)}
//! c_n = (2 n)! / (2^n n!)^2        m = l, l - 2, ... >= 0
//! ```
//!
//! by the addition theorems of the spherical Bessel functions (Abramowitz and Stegun 10.1.45) and of Legendre
//! polynomials; in the plane only harmonics with even l + m are nonzero. Hence R = Y^T Y, where Y contains the
//! amplitudes of all spherical waves for each mode: positive semidefinite by construction. The cost is waves x points x
//! modes; the number of waves grows with (k a)^2, where a is the radius of the surface.

use nalgebra::{Complex, DMatrix};

/// Orders are omitted once all waves are smaller than this; the error of the kernel is its square.
const SMALLEST: f64 = 1e-10;

/// Number of columns of a product multiplied at once.
const CHUNK: usize = 384;

/// A point whose motion is proportional to that of another point, its leader.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Follower {
    /// Index of the leader.
    pub(crate) leader: usize,
    /// Velocity relative to the leader, times the area of the point \[m²\].
    pub(crate) amplitude: Complex<f64>,
}

/// Spherical waves about a point of the plane, in ascending order.
#[derive(Debug, Clone)]
pub(crate) struct SphericalWaves {
    k: f64,
    middle: [f64; 2],
    /// Highest order l.
    order: usize,
    /// Normalisation factor of every wave.
    factors: Vec<f64>,
}

impl SphericalWaves {
    /// Waves of wavenumber `k` for points within `radius` of `middle`.
    pub(crate) fn new(k: f64, middle: [f64; 2], radius: f64) -> Self {
        let order = highest_order(k * radius);
        // c_n, which contain all factorials.
        let mut c = vec![1.0];
        for n in 1..=order {
            c.push(c[n - 1] * (n as f64 - 0.5) / n as f64);
        }
        let mut factors = Vec::with_capacity((order + 1) * (order + 2) / 2);
        for l in 0..=order {
            for m in (l % 2..=l).step_by(2) {
                let square = (2 * l + 1) as f64 * c[(l - m) / 2] * c[(l + m) / 2];
                match m {
                    0 => factors.push(square.sqrt()),
                    _ => factors.extend([(2.0 * square).sqrt(); 2]),
                }
            }
        }
        Self {
            k,
            middle,
            order,
            factors,
        }
    }

    /// Number of waves.
    pub(crate) fn len(&self) -> usize {
        self.factors.len()
    }

    /// Wave amplitudes of the `rows` of `sources` (points x columns, multiplied by area): waves x columns.
    pub(crate) fn field(&self, points: &[[f64; 2]], rows: &[usize], sources: &DMatrix<f64>) -> DMatrix<f64> {
        let mut field = DMatrix::zeros(self.len(), sources.ncols());
        let mut scratch = self.scratch();
        for rows in rows.chunks(CHUNK) {
            let mut waves = DMatrix::zeros(self.len(), rows.len());
            for (&row, mut column) in rows.iter().zip(waves.column_iter_mut()) {
                self.at(points[row], &mut scratch, column.as_mut_slice());
            }
            field.gemm(1.0, &waves, &sources.select_rows(rows), 1.0);
        }
        field
    }

    /// Wave amplitudes of followers per unit motion of their leaders: real and imaginary part, both waves x leaders.
    pub(crate) fn field_of_followers(
        &self,
        points: &[[f64; 2]],
        followers: &[Follower],
        leaders: usize,
    ) -> [DMatrix<f64>; 2] {
        let n = self.len();
        let mut fields = [DMatrix::zeros(n, leaders), DMatrix::zeros(n, leaders)];
        let (mut scratch, mut wave) = (self.scratch(), vec![0.0; n]);
        for (point, follower) in points.iter().zip(followers) {
            self.at(*point, &mut scratch, &mut wave);
            let amplitude = follower.amplitude;
            for (field, amplitude) in fields.iter_mut().zip([amplitude.re, amplitude.im]) {
                let to = &mut field.as_mut_slice()[follower.leader * n..][..n];
                to.iter_mut().zip(&wave).for_each(|(to, w)| *to += amplitude * w);
            }
        }
        fields
    }

    fn scratch(&self) -> Scratch {
        Scratch {
            radial: vec![0.0; self.order + 1],
            around: vec![Complex::default(); self.order + 1],
        }
    }

    /// All waves at a point.
    fn at(&self, [x, y]: [f64; 2], Scratch { radial, around }: &mut Scratch, waves: &mut [f64]) {
        let (x, y) = (x - self.middle[0], y - self.middle[1]);
        let r = x.hypot(y);
        spherical_bessel(self.k * r, radial);
        let turn = if r > 0.0 {
            Complex::new(x, y) / r
        } else {
            Complex::from(1.0)
        };
        let mut angle = Complex::from(1.0);
        for to in around.iter_mut() {
            *to = angle;
            angle *= turn;
        }
        let mut waves = waves.iter_mut().zip(&self.factors);
        let mut put = |value: f64| waves.next().into_iter().for_each(|(to, factor)| *to = factor * value);
        for (l, j) in radial.iter().enumerate() {
            for (m, angle) in around.iter().enumerate().take(l + 1).skip(l % 2).step_by(2) {
                put(j * angle.re);
                if m > 0 {
                    put(j * angle.im);
                }
            }
        }
    }
}

/// Workspace for j_l and e^{j m psi} at one point.
struct Scratch {
    radial: Vec<f64>,
    around: Vec<Complex<f64>>,
}

/// Highest order l with sqrt(2 l + 1) j_l(x) above [`SMALLEST`].
pub(super) fn highest_order(x: f64) -> usize {
    // j_l decays within about x^{1/3} orders beyond l = x.
    let mut values = vec![0.0; (x + 8.0 * x.cbrt() + 16.0).ceil() as usize];
    spherical_bessel(x, &mut values);
    let counts = |(l, j): (usize, &f64)| ((2 * l + 1) as f64).sqrt() * j > SMALLEST;
    values.iter().enumerate().rposition(counts).unwrap_or(0)
}

/// j_0(x), j_1(x), ... for x >= 0, where the last one must lie beyond l = x: by downward recurrence (J. C. P. Miller,
/// in Abramowitz and Stegun 10.5), scaled to sum (2 l + 1) j_l^2 = 1.
fn spherical_bessel(x: f64, values: &mut [f64]) {
    /// Number of orders beyond the last one required at which the recurrence starts.
    const BEYOND: usize = 16;
    /// Values are rescaled before they overflow.
    const LARGEST: f64 = 1e100;
    /// Below this argument, j_1 is smaller than any rounding error.
    const LEAST: f64 = 1e-30;
    values.fill(0.0);
    if x < LEAST {
        values.iter_mut().take(1).for_each(|j| *j = 1.0);
        return;
    }
    // Positive for l > x, like j_l.
    let (mut above, mut j, mut sum) = (0.0, 1.0, 0.0);
    for l in (0..values.len() + BEYOND).rev() {
        if let Some(to) = values.get_mut(l) {
            *to = j;
        }
        sum += (2 * l + 1) as f64 * j * j;
        (above, j) = (j, (2 * l + 1) as f64 / x * j - above);
        if j.abs() > LARGEST {
            (above, j, sum) = (above / LARGEST, j / LARGEST, sum / LARGEST / LARGEST);
            values.iter_mut().skip(l).for_each(|v| *v /= LARGEST);
        }
    }
    let scale = 1.0 / sum.sqrt();
    values.iter_mut().for_each(|v| *v *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spherical_waves_sum_to_the_kernel() {
        let points = [[0.0, 0.0], [0.4, 0.1], [-0.03, 0.15], [0.2, -0.2]];
        for (k, middle) in [
            (0.1, [0.1, 0.0]),
            (1.0, [0.0, 0.0]),
            (7.0, [0.2, 0.1]),
            (60.0, [0.1, 0.0]),
            (180.0, [0.2, 0.0]),
        ] {
            let waves = SphericalWaves::new(k, middle, 0.5);
            let field = waves.field(&points, &[0, 1, 2, 3], &DMatrix::identity(4, 4));
            let kernel = field.tr_mul(&field);
            for i in 0..4 {
                for j in 0..4 {
                    let kr = k * (points[i][0] - points[j][0]).hypot(points[i][1] - points[j][1]);
                    let sinc = if kr == 0.0 { 1.0 } else { kr.sin() / kr };
                    let error = kernel[(i, j)] - sinc;
                    assert!(error.abs() < 1e-13, "k = {k}, pair {i} {j}: error {error:.2e}");
                }
            }
        }
    }

    #[test]
    fn bessel_functions_are_those_known_in_closed_form() {
        for x in [1e-40, 1e-9, 1e-3, 0.7, 3.1, 20.3, 99.0f64] {
            let mut values = vec![0.0; 150];
            spherical_bessel(x, &mut values);
            let j0 = if x < 1e-20 { 1.0 } else { x.sin() / x };
            assert!((values[0] - j0).abs() < 1e-14, "{x}: {} {j0}", values[0]);
            // x/3 - x^3/30, where sine and cosine would cancel.
            let j1 = if x < 1e-2 {
                x / 3.0 - x.powi(3) / 30.0
            } else {
                (x.sin() / x - x.cos()) / x
            };
            assert!((values[1] - j1).abs() < 1e-14, "{x}: {} {j1}", values[1]);
            assert!(values.iter().all(|j| j.is_finite()));
        }
    }
}

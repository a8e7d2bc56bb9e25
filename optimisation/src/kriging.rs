//! Ordinary Kriging: a Gaussian process with a constant mean, fitted to observations.
//!
//! The model is y(x) = beta + Z(x) with cov(Z(x), Z(x')) = sigma^2 k(r) and r^2 = sum_i (x_i - x'_i)^2 / l_i^2. The
//! correlation is the Matern function of order 5/2, k(r) = (1 + sqrt(5) r + 5 r^2/3) exp(-sqrt(5) r) (Rasmussen and
//! Williams, "Gaussian Processes for Machine Learning", 2006, eq. 4.17). With R_ij = k(r_ij) + g delta_ij, the
//! likelihood has its maximum at beta = 1'R^-1 y / 1'R^-1 1 and sigma^2 = (y - beta)'R^-1 (y - beta)/n. (Jones,
//! Schonlau and Welch, "Efficient global optimization of expensive black-box functions", Journal of Global Optimization
//! 13, 455 (1998), eqs. 5 and 6.) The lengths l_i and the roughness g maximise the remaining terms, -n/2 ln sigma^2 -
//! 1/2 ln det R, and a prior on the lengths.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Smallest and largest length, relative to the range \[-\].
const LENGTHS: [f64; 2] = [0.03, 30.0];

/// Smallest and largest roughness, the fraction of the variance that adjacent points do not share \[-\].
const ROUGHNESS: [f64; 2] = [1e-8, 0.1];

/// Prior median of a length in one dimension, and standard deviation of its logarithm. The lengths are long, because a
/// quantity has no effect without evidence. In d dimensions, the median is multiplied by sqrt(d) (Hvarfner, Hellsten
/// and Nardi, "Vanilla Bayesian optimization performs great in high dimensions", 2024).
const PRIOR: (f64, f64) = (0.7, 1.2);

/// Maximum number of moves in the search for the lengths.
const MOVES: usize = 40;

/// A fitted model.
#[derive(Debug, Clone)]
pub(crate) struct Kriging {
    /// Coordinates divided by their lengths.
    points: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    roughness: f64,
    factor: Cholesky<f64, Dyn>,
    mean: f64,
    variance: f64,
    /// R^-1 (y - beta).
    weights: DVector<f64>,
    /// R^-1 1.
    ones: DVector<f64>,
    values: Vec<f64>,
}

/// Mean and standard deviations of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prediction {
    pub(crate) mean: f64,
    /// Of an observation.
    pub(crate) deviation: f64,
    /// Of the smooth part, without the roughness; it decreases with each observation near the point.
    pub(crate) smooth: f64,
}

/// Logarithms of lengths and roughness.
#[derive(Debug, Clone)]
struct Parameters {
    lengths: Vec<f64>,
    roughness: f64,
}

/// Observations to which a model is fitted.
struct Data<'a> {
    /// Coordinates of each point.
    points: &'a [Vec<f64>],
    /// The dimension of each coordinate.
    owners: &'a [usize],
    values: &'a [f64],
}

impl Kriging {
    /// The model of values at points, in coordinates that belong to the dimensions `owners`; `None` for fewer than two
    /// points, or if no factorisation succeeds.
    pub(crate) fn fit(points: &[Vec<f64>], owners: &[usize], values: &[f64]) -> Option<Self> {
        if points.len() < 2 {
            return None;
        }
        let data = Data { points, owners, values };
        let dimensions = owners.last().map_or(0, |last| last + 1);
        let start = |length: f64, roughness: f64| Parameters {
            lengths: vec![length.ln(); dimensions],
            roughness: roughness.ln(),
        };
        let starts = [0.15, 0.4, 1.0, 3.0]
            .into_iter()
            .flat_map(|length| [1e-6, 1e-3].map(|roughness| start(length, roughness)));
        let rated = starts.map(|own| (data.likelihood(&own), own));
        let (mut best, mut own) = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
        // A compass search: every parameter is moved up and down, and the steps are halved if nothing improves.
        let mut step = 1.0;
        for _ in 0..MOVES {
            let moves = (0..=dimensions).flat_map(|place| [step, -step].map(|by| own.moved(place, by)));
            let rated = moves.map(|own| (data.likelihood(&own), own));
            match rated.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((rating, moved)) if rating > best + 1e-6 => (best, own) = (rating, moved),
                _ if step < 0.1 => break,
                _ => step *= 0.5,
            }
        }
        data.model(&own)
    }

    /// The prediction at a point.
    pub(crate) fn predict(&self, coordinates: &[f64]) -> Prediction {
        let point: Vec<f64> = coordinates.iter().zip(&self.lengths).map(|(x, l)| x / l).collect();
        let r = DVector::from_iterator(
            self.points.len(),
            self.points.iter().map(|own| matern(distance(own, &point))),
        );
        let mean = self.mean + r.dot(&self.weights);
        let mut solved = r.clone();
        self.factor.l_dirty().solve_lower_triangular_mut(&mut solved);
        // The second part is the uncertainty of the mean (Jones et al., eq. 9).
        let of_mean = (1.0 - r.dot(&self.ones)).powi(2) / self.ones.sum();
        let share = 1.0 - solved.norm_squared() + of_mean;
        let deviation = |share: f64| (self.variance * share.max(0.0)).sqrt();
        Prediction {
            mean,
            deviation: deviation(share + self.roughness),
            smooth: deviation(share),
        }
    }

    /// The model with one further observation and the same lengths.
    pub(crate) fn with(&self, coordinates: &[f64], value: f64) -> Option<Self> {
        let mut points = self.points.clone();
        points.push(coordinates.iter().zip(&self.lengths).map(|(x, l)| x / l).collect());
        let mut values = self.values.clone();
        values.push(value);
        Self::of(points, &values, self.lengths.clone(), self.roughness)
    }

    /// The model with these coordinate lengths.
    fn of(points: Vec<Vec<f64>>, values: &[f64], lengths: Vec<f64>, roughness: f64) -> Option<Self> {
        let n = points.len();
        let correlation = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => 1.0 + roughness,
            std::cmp::Ordering::Greater => matern(distance(&points[i], &points[j])),
            // The factorisation reads the lower triangle.
            std::cmp::Ordering::Less => 0.0,
        });
        let factor = Cholesky::new(correlation)?;
        let ones = factor.solve(&DVector::from_element(n, 1.0));
        let y = DVector::from_column_slice(values);
        let mean = ones.dot(&y) / ones.sum();
        let rest = y.add_scalar(-mean);
        let weights = factor.solve(&rest);
        // Values that are all equal have no variance; a floor keeps the likelihood finite.
        let variance = (rest.dot(&weights) / n as f64).max(1e-12);
        Some(Self {
            points,
            lengths,
            roughness,
            factor,
            mean,
            variance,
            weights,
            ones,
            values: values.to_vec(),
        })
    }
}

impl Parameters {
    /// One parameter moved; the last is the roughness, which moves three times as far.
    fn moved(&self, place: usize, by: f64) -> Self {
        let mut moved = self.clone();
        let within = |value: f64, [low, high]: [f64; 2]| value.clamp(low.ln(), high.ln());
        match moved.lengths.get_mut(place) {
            Some(length) => *length = within(*length + by, LENGTHS),
            None => moved.roughness = within(moved.roughness + 3.0 * by, ROUGHNESS),
        }
        moved
    }
}

impl Data<'_> {
    fn model(&self, own: &Parameters) -> Option<Kriging> {
        let lengths: Vec<f64> = self.owners.iter().map(|&owner| own.lengths[owner].exp()).collect();
        let scaled = |point: &Vec<f64>| point.iter().zip(&lengths).map(|(x, l)| x / l).collect();
        let points = self.points.iter().map(scaled).collect();
        Kriging::of(points, self.values, lengths, own.roughness.exp())
    }

    /// Logarithm of the product of likelihood and prior, apart from a constant.
    fn likelihood(&self, own: &Parameters) -> f64 {
        let Some(model) = self.model(own) else {
            return f64::NEG_INFINITY;
        };
        let n = self.values.len() as f64;
        let half_determinant: f64 = model.factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
        let (median, spread) = PRIOR;
        let center = (median * (own.lengths.len() as f64).sqrt()).ln();
        let prior: f64 = own.lengths.iter().map(|l| ((l - center) / spread).powi(2)).sum();
        -0.5 * n * model.variance.ln() - half_determinant - 0.5 * prior
    }
}

/// The Matern function of order 5/2.
fn matern(r: f64) -> f64 {
    let s = 5.0_f64.sqrt() * r;
    (1.0 + s + s * s / 3.0) * (-s).exp()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: u32) -> Vec<Vec<f64>> {
        let number = |place, dimension| f64::from(sobol_burley::sample(place, dimension, 3));
        (0..count)
            .map(|place| vec![number(place, 0), number(place, 1)])
            .collect()
    }

    fn value(point: &[f64]) -> f64 {
        (4.0 * point[0]).sin() + 0.5 * point[1]
    }

    fn fitted(count: u32) -> Kriging {
        let points = points(count);
        let values: Vec<f64> = points.iter().map(|point| value(point)).collect();
        Kriging::fit(&points, &[0, 1], &values).unwrap_or_else(|| panic!("no model"))
    }

    #[test]
    fn a_smooth_function_is_interpolated_and_predicted() {
        let model = fitted(25);
        for point in points(25) {
            assert!((model.predict(&point).mean - value(&point)).abs() < 1e-3);
        }
        let error = points(60)[25..]
            .iter()
            .map(|point| (model.predict(point).mean - value(point)).abs())
            .fold(0.0, f64::max);
        assert!(error < 0.1, "{error}");
    }

    #[test]
    fn the_deviation_covers_the_error_and_grows_away_from_observations() {
        let model = fitted(12);
        let z: Vec<f64> = points(200)[12..]
            .iter()
            .map(|point| {
                let own = model.predict(point);
                (own.mean - value(point)) / own.deviation
            })
            .collect();
        let within = z.iter().filter(|z| z.abs() < 3.0).count();
        assert!(within as f64 > 0.85 * z.len() as f64, "{within} of {}", z.len());
        let near = points(12)[0].iter().map(|x| x + 1e-3).collect::<Vec<_>>();
        assert!(model.predict(&near).deviation < 0.2 * model.predict(&[3.0, 3.0]).deviation);
    }

    #[test]
    fn a_coordinate_without_effect_has_the_longer_length() {
        let points = points(30);
        let values: Vec<f64> = points.iter().map(|point| (5.0 * point[0]).cos()).collect();
        let model = Kriging::fit(&points, &[0, 1], &values).unwrap_or_else(|| panic!("no model"));
        assert!(model.lengths[1] > 3.0 * model.lengths[0], "{:?}", model.lengths);
    }

    #[test]
    fn a_further_observation_draws_the_mean_and_leaves_little_uncertainty() {
        let (model, point) = (fitted(12), [0.95, 0.05]);
        let before = model.predict(&point);
        let value = before.mean + before.deviation;
        let after = model
            .with(&point, value)
            .unwrap_or_else(|| panic!("no model"))
            .predict(&point);
        assert!(
            (after.mean - value).abs() < 0.2 * before.deviation,
            "{before:?} {after:?}"
        );
        assert!(after.deviation < 0.3 * before.deviation, "{before:?} {after:?}");
    }
}

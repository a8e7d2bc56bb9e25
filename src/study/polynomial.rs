//! Sparse polynomials of points in the unit cube.
//!
//! A figure is expanded in products of Legendre polynomials, which are orthonormal for independent uniform coordinates
//! (Xiu and Karniadakis, SIAM J. Sci. Comput. 24, 619 (2002)). Terms are added one by one: the next is the one that
//! correlates most with the residual of the figure (orthogonal matching pursuit; for polynomials Blatman and Sudret, J.
//! Comput. Phys. 230, 2345 (2011)). Their number is the one that best predicts points that were not used for choosing
//! them; Q2 is the predicted fraction of the variance at these points. Sobol' indices are sums of squared coefficients
//! (Sudret, Reliab. Eng. Syst. Saf. 93, 964 (2008)).

use nailnoise_acoustics::random::uniform;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Maximum number of candidate terms of a polynomial, and maximum degree.
const MOST_CANDIDATES: usize = 12_000;
const HIGHEST_DEGREE: usize = 10;

/// Maximum number of terms of a polynomial; with few points, a quarter of the number of points.
const MOST_TERMS: usize = 40;

/// Number of parts into which points are divided; each is predicted from the others.
const FOLDS: u64 = 5;

const SEED: u64 = 0x50F7_0A7E;

/// The fold of a point, or of points that are predicted together, from their number.
pub(super) fn fold_of(number: usize) -> u64 {
    (uniform(SEED, number as u64, 0) * FOLDS as f64) as u64
}

/// A product of polynomials: inputs with their degrees.
type Term = Vec<(usize, usize)>;

/// Candidate terms of a polynomial, with their values at all points.
pub(super) struct Candidates {
    terms: Vec<Term>,
    /// Highest total degree.
    pub(super) degree: usize,
    /// Values; those of a term at all points are contiguous, the constant first.
    columns: Vec<Vec<f64>>,
}

/// Terms of a polynomial other than the constant, in the order of their choice, with their coefficients.
pub(super) struct Polynomial {
    pub(super) terms: Vec<usize>,
    coefficients: Vec<f64>,
    /// Fraction of the variance that is predicted at points left out \[-\].
    pub(super) q2: f64,
}

impl Candidates {
    /// All terms up to the highest degree that a limited number of terms allows, for points in the unit cube.
    pub(super) fn new(points: &[Vec<f64>], inputs: usize) -> Self {
        let degree = (1..=HIGHEST_DEGREE)
            .take_while(|&degree| degree == 1 || number_of_terms(inputs, degree) <= MOST_CANDIDATES)
            .last()
            .unwrap_or(1);
        let mut terms: Vec<Term> = vec![Vec::new()];
        let mut last = 0..1;
        for _ in 0..degree {
            // One degree more, in the last input of a term or in a later one, so that each product appears once.
            let mut next = Vec::new();
            for term in &terms[last.clone()] {
                let (begin, rest) = term.split_at(term.len().saturating_sub(1));
                let from = rest.first().map_or(0, |&(input, _)| input);
                for input in from..inputs {
                    let mut raised = begin.to_vec();
                    match rest.first() {
                        Some(&(own, power)) if own == input => raised.push((own, power + 1)),
                        other => {
                            raised.extend(other);
                            raised.push((input, 1));
                        }
                    }
                    next.push(raised);
                }
            }
            last = terms.len()..terms.len() + next.len();
            terms.extend(next);
        }
        let legendre: Vec<Vec<Vec<f64>>> = points
            .iter()
            .map(|point| point.iter().map(|&u| legendre(u, degree)).collect())
            .collect();
        let column = |term: &Term| {
            let value = |values: &Vec<Vec<f64>>| term.iter().map(|&(input, power)| values[input][power]).product();
            legendre.iter().map(value).collect()
        };
        Self {
            columns: terms.par_iter().map(column).collect(),
            terms,
            degree,
        }
    }

    /// The polynomial for levels at the points; each point belongs to a fold.
    pub(super) fn fitted(&self, levels: &[f64], folds: &[u64]) -> Polynomial {
        let most = (levels.len() / 4).min(MOST_TERMS).min(self.terms.len() - 1);
        // Sum of squared errors at the points of a fold for every number of terms, predicted from the other folds.
        let of_fold = |fold: u64| {
            let known: Vec<bool> = folds.iter().map(|&own| own != fold).collect();
            let mut errors = Vec::with_capacity(most + 1);
            self.pursue(levels, &known, most, |prediction| {
                let left = levels.iter().zip(prediction).zip(&known).filter(|(_, known)| !**known);
                errors.push(
                    left.map(|((level, predicted), _)| (level - predicted).powi(2))
                        .sum::<f64>(),
                );
            });
            errors
        };
        let errors: Vec<Vec<f64>> = (0..FOLDS).into_par_iter().map(of_fold).collect();
        // A fold whose levels are matched exactly ends early.
        let at = |errors: &Vec<f64>, terms: usize| errors.get(terms).or(errors.last()).copied().unwrap_or(0.0);
        let sum = |terms: usize| errors.iter().map(|errors| at(errors, terms)).sum::<f64>();
        let best = (0..=most).fold(0, |best, terms| if sum(terms) < sum(best) { terms } else { best });
        let all = vec![true; levels.len()];
        let (terms, coefficients) = self.pursue(levels, &all, best, |_| {});
        let q2 = if sum(0) > 0.0 { 1.0 - sum(best) / sum(0) } else { 0.0 };
        Polynomial {
            terms,
            coefficients,
            q2,
        }
    }

    /// Chooses up to `most` terms using the points that are `known`; `each` receives the prediction at all points after
    /// the constant and after every term. Returns the terms other than the constant, and their coefficients.
    fn pursue(
        &self,
        levels: &[f64],
        known: &[bool],
        most: usize,
        mut each: impl FnMut(&[f64]),
    ) -> (Vec<usize>, Vec<f64>) {
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            let both = a.iter().zip(b).zip(known).filter(|(_, known)| **known);
            both.map(|((a, b), _)| a * b).sum()
        };
        let norms: Vec<f64> = self.columns.iter().map(|column| dot(column, column).sqrt()).collect();
        let mut rest: Vec<f64> = levels.to_vec();
        let mut prediction = vec![0.0; levels.len()];
        // Orthonormal columns over the known points, and their coefficients in terms of the terms' columns.
        let (mut basis, mut of_terms) = (Vec::<Vec<f64>>::new(), Vec::<Vec<f64>>::new());
        let (mut chosen, mut amplitudes) = (Vec::<usize>::new(), Vec::new());
        for step in 0..=most {
            // The constant is the first term.
            let place = match step {
                0 => 0,
                _ => {
                    // Points that are not known are ignored.
                    let masked: Vec<f64> = rest
                        .iter()
                        .zip(known)
                        .map(|(r, known)| if *known { *r } else { 0.0 })
                        .collect();
                    let correlation = |place: usize| -> f64 {
                        let product: f64 = self.columns[place].iter().zip(&masked).map(|(a, b)| a * b).sum();
                        if norms[place] > 0.0 {
                            product.abs() / norms[place]
                        } else {
                            0.0
                        }
                    };
                    let others = (1..self.columns.len()).filter(|place| !chosen.contains(place));
                    let best = others.map(|place| (place, correlation(place)));
                    let Some((place, correlation)) = best.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                        break;
                    };
                    if correlation <= 1e-12 * dot(levels, levels).sqrt() {
                        break;
                    }
                    place
                }
            };
            let mut column = self.columns[place].clone();
            let mut of_term = vec![0.0; chosen.len()];
            of_term.push(1.0);
            // Orthogonalising twice is enough.
            for _ in 0..2 {
                for (own, combination) in basis.iter().zip(&of_terms) {
                    let part = dot(own, &column);
                    column.iter_mut().zip(own).for_each(|(c, b)| *c -= part * b);
                    of_term.iter_mut().zip(combination).for_each(|(c, b)| *c -= part * b);
                }
            }
            let norm = dot(&column, &column).sqrt();
            if norm <= 1e-9 * norms[place] {
                break;
            }
            column.iter_mut().chain(&mut of_term).for_each(|c| *c /= norm);
            let amplitude = dot(&column, &rest);
            rest.iter_mut().zip(&column).for_each(|(r, c)| *r -= amplitude * c);
            prediction
                .iter_mut()
                .zip(&column)
                .for_each(|(p, c)| *p += amplitude * c);
            chosen.push(place);
            amplitudes.push(amplitude);
            basis.push(column);
            of_terms.push(of_term);
            each(&prediction);
        }
        let mut coefficients = vec![0.0; chosen.len()];
        for (amplitude, combination) in amplitudes.iter().zip(&of_terms) {
            coefficients
                .iter_mut()
                .zip(combination)
                .for_each(|(c, own)| *c += amplitude * own);
        }
        // Without known points, not even the constant is determined.
        (
            chosen.into_iter().skip(1).collect(),
            coefficients.into_iter().skip(1).collect(),
        )
    }

    /// The same terms with the coefficients that best fit levels at points that may count several times. `None` if
    /// these points do not determine them.
    pub(super) fn refitted(&self, polynomial: &Polynomial, levels: &[f64], counts: &[u32]) -> Option<Polynomial> {
        let places = || std::iter::once(0).chain(polynomial.terms.iter().copied());
        let weighted: Vec<Vec<f64>> = places()
            .map(|place| {
                self.columns[place]
                    .iter()
                    .zip(counts)
                    .map(|(v, &n)| v * f64::from(n))
                    .collect()
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let columns: Vec<&[f64]> = places().map(|place| &self.columns[place][..]).collect();
        let size = columns.len();
        let normal = DMatrix::from_fn(
            size,
            size,
            |i, j| if i >= j { dot(&weighted[i], columns[j]) } else { 0.0 },
        );
        let right = DVector::from_iterator(size, weighted.iter().map(|column| dot(column, levels)));
        // The factorisation reads only the lower triangle.
        let factor = normal.cholesky()?;
        let diagonal = factor.l_dirty().diagonal();
        if diagonal.min() < 1e-6 * diagonal.max() {
            return None;
        }
        let coefficients: Vec<f64> = factor.solve(&right).iter().skip(1).copied().collect();
        Some(Polynomial {
            terms: polynomial.terms.clone(),
            coefficients,
            q2: polynomial.q2,
        })
    }

    /// First-order and total index of every input that is in a term.
    pub(super) fn indices(&self, polynomial: &Polynomial) -> Vec<(usize, [f64; 2])> {
        let mut indices = std::collections::BTreeMap::<usize, [f64; 2]>::new();
        let variance: f64 = polynomial.coefficients.iter().map(|c| c * c).sum();
        for (&place, coefficient) in polynomial.terms.iter().zip(&polynomial.coefficients) {
            let part = coefficient * coefficient / variance;
            for &(input, _) in &self.terms[place] {
                let own = indices.entry(input).or_default();
                own[1] += part;
                if self.terms[place].len() == 1 {
                    own[0] += part;
                }
            }
        }
        indices.into_iter().collect()
    }
}

/// Number of terms of up to a total degree, without the constant: C(inputs + degree, degree) - 1.
fn number_of_terms(inputs: usize, degree: usize) -> usize {
    (1..=degree).fold(1, |count: usize, k| count.saturating_mul(inputs + k) / k) - 1
}

/// Legendre polynomials of degrees 0 to `degree`, orthonormal on the unit interval.
fn legendre(u: f64, degree: usize) -> Vec<f64> {
    let x = 2.0 * u - 1.0;
    let mut values = vec![1.0, x];
    for n in 2..=degree {
        let n = n as f64;
        let [last, before] = [values[values.len() - 1], values[values.len() - 2]];
        values.push(((2.0 * n - 1.0) * x * last - (n - 1.0) * before) / n);
    }
    for (n, value) in values.iter_mut().enumerate() {
        *value *= (2.0 * n as f64 + 1.0).sqrt();
    }
    values
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::PI;

    use super::*;

    fn points(n: u32, inputs: u32) -> Vec<Vec<f64>> {
        let number = |index, input| f64::from(sobol_burley::sample(index, input, 7)) + 1e-8;
        (0..n)
            .map(|index| (0..inputs).map(|input| number(index, input)).collect())
            .collect()
    }

    fn folds(n: usize) -> Vec<u64> {
        (0..n).map(fold_of).collect()
    }

    /// Q2 and indices of a function of points.
    fn found(points: &[Vec<f64>], function: impl Fn(&[f64]) -> f64) -> (f64, Vec<(usize, [f64; 2])>) {
        let candidates = Candidates::new(points, points[0].len());
        let levels: Vec<f64> = points.iter().map(|point| function(point)).collect();
        let polynomial = candidates.fitted(&levels, &folds(points.len()));
        (polynomial.q2, candidates.indices(&polynomial))
    }

    #[test]
    fn polynomials_are_orthonormal() {
        let n = 20_000;
        let values: Vec<Vec<f64>> = (0..n)
            .map(|k| legendre((f64::from(k) + 0.5) / f64::from(n), 6))
            .collect();
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            let mean = values.iter().map(|v| v[i] * v[j]).sum::<f64>() / f64::from(n);
            assert!((mean - f64::from(u8::from(i == j))).abs() < 1e-5, "{i} {j}: {mean}");
        }
    }

    #[test]
    fn every_product_up_to_the_degree_comes_once() {
        let mut terms = Candidates::new(&[vec![0.3, 0.6, 0.1]], 3).terms;
        assert_eq!(terms.len(), number_of_terms(3, HIGHEST_DEGREE) + 1);
        terms.sort();
        terms.dedup();
        assert_eq!(terms.len(), 286);
        assert_eq!(number_of_terms(140, 2), 10_010);
    }

    /// Ishigami and Homma 1990, a = 7, b = 0.1: the closed form.
    #[test]
    fn indices_of_the_ishigami_function_are_the_analytic_ones() {
        let (q2, indices) = found(&points(512, 3), |u| {
            let [x, y, z] = [u[0], u[1], u[2]].map(|u| PI * (2.0 * u - 1.0));
            x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
        });
        assert!(q2 > 0.99, "{q2}");
        let expected = [[0.313_905, 0.557_589], [0.442_411, 0.442_411], [0.0, 0.243_684]];
        for ((input, found), expected) in indices.iter().zip(expected) {
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 0.01,
                    "input {input}: {found}, expected {expected}"
                );
            }
        }
    }

    /// N(100, 3) + N(97, 4) in energy, by quadrature.
    #[test]
    fn indices_of_an_energy_sum_are_those_by_quadrature() {
        let z = |u: f64| super::super::normal::quantile(u);
        let level = |u: &[f64]| crate::decibels::energy_sum([100.0 + 3.0 * z(u[0]), 97.0 + 4.0 * z(u[1])]);
        let (q2, indices) = found(&points(1000, 2), level);
        assert!(q2 > 0.97, "{q2}");
        for ((_, found), expected) in indices.iter().zip([[0.580_996, 0.623_793], [0.376_207, 0.419_004]]) {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.02, "{found}, expected {expected}");
            }
        }
    }

    /// Draws that were used for choosing the terms would seem to be predicted.
    #[test]
    fn noise_is_not_predicted() {
        let points = points(200, 60);
        let mut number = 0;
        let levels: Vec<f64> = points
            .iter()
            .map(|_| {
                number += 1;
                uniform(3, number, 1)
            })
            .collect();
        let candidates = Candidates::new(&points, 60);
        let polynomial = candidates.fitted(&levels, &folds(200));
        assert!(polynomial.q2 < 0.1, "{}", polynomial.q2);
    }

    #[test]
    fn points_of_one_fold_are_not_predicted() {
        let points = points(64, 3);
        let levels: Vec<f64> = points.iter().map(|point| point[0]).collect();
        let polynomial = Candidates::new(&points, 3).fitted(&levels, &[2; 64]);
        assert_eq!(polynomial.q2, 0.0);
    }

    #[test]
    fn terms_refitted_to_the_same_points_keep_their_coefficients() {
        let points = points(200, 4);
        let level = |u: &Vec<f64>| (3.0 * u[0]).exp() + u[1] * u[2] + 0.2 * u[3];
        let levels: Vec<f64> = points.iter().map(level).collect();
        let candidates = Candidates::new(&points, 4);
        let polynomial = candidates.fitted(&levels, &folds(200));
        let again = candidates.refitted(&polynomial, &levels, &[2; 200]).unwrap();
        for (found, expected) in again.coefficients.iter().zip(&polynomial.coefficients) {
            assert!((found - expected).abs() < 1e-8, "{found}, expected {expected}");
        }
        let mut few = vec![0; 200];
        few[..polynomial.terms.len()].fill(1);
        assert!(candidates.refitted(&polynomial, &levels, &few).is_none());
    }

    #[test]
    fn one_of_many_inputs_is_found() {
        let (q2, indices) = found(&points(200, 60), |u| 3.0 * u[17] + 0.5 * u[4] * u[17]);
        assert!(q2 > 0.99, "{q2}");
        let largest = indices.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1])).unwrap();
        assert!(largest.0 == 17 && largest.1[1] > 0.95, "{indices:?}");
    }
}

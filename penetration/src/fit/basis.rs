//! Polynomials in x in a well-conditioned basis.
//!
//! Powers of x on 0..1 are nearly linearly dependent: for the form of Eq. 2.2, the scaled columns have a condition
//! number of 8e4, compared with 15 for shifted Legendre polynomials. The regression uses the latter and converts its
//! coefficients afterwards.

use nalgebra::DMatrix;

use super::form::{Term, Values, Variable, raise};

/// One column: x^shift P*_n(x) times the other factors of a term; if `anchored`, the constant of P*_n is subtracted.
#[derive(Debug, Clone)]
struct Column {
    /// The factors other than x.
    cofactor: Term,
    /// Power of x before the polynomial.
    shift: f64,
    /// Degree of the polynomial.
    degree: usize,
    /// Whether the polynomial vanishes at x = 0. If so, the powers start at x^1 and the span excludes constants.
    anchored: bool,
}

/// The columns of a regression, and their conversion to the terms.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    columns: Vec<Column>,
    /// Coefficients of the terms = conversion x coefficients of the columns.
    conversion: DMatrix<f64>,
}

impl Basis {
    /// Creates one column per term, in order. Consecutive integer powers of x with the same other factors share a
    /// family of polynomials.
    pub(super) fn new(terms: &[Term]) -> Self {
        let mut columns = Vec::with_capacity(terms.len());
        let mut conversion = DMatrix::zeros(terms.len(), terms.len());
        for (index, term) in terms.iter().enumerate() {
            let power = term.power(Variable::X);
            let cofactor = term.with_depth_power(0.0);
            let place = |power: f64| terms.iter().position(|t| *t == cofactor.with_depth_power(power));
            let mut start = power;
            while power == power.trunc() && start >= 1.0 && place(start - 1.0).is_some() {
                start -= 1.0;
            }
            // Powers from x^1 upwards: polynomials that vanish at 0.
            let anchored = start == 1.0;
            let shift = if anchored { 0.0 } else { start };
            let degree = (power - shift) as usize;
            for (k, coefficient) in legendre_coefficients(degree).into_iter().enumerate() {
                if let Some(row) = place(shift + k as f64).filter(|_| !(anchored && k == 0)) {
                    conversion[(row, index)] = coefficient;
                }
            }
            columns.push(Column {
                cofactor,
                shift,
                degree,
                anchored,
            });
        }
        Self { columns, conversion }
    }

    /// Values of all columns at a point.
    pub(super) fn row(&self, values: &Values) -> impl Iterator<Item = f64> + '_ {
        let values = *values;
        let x = values[Variable::X as usize];
        // The last cofactor is cached, because all polynomials of a family share it.
        let mut last: Option<(&Term, f64)> = None;
        self.columns.iter().map(move |column| {
            let cofactor = match last {
                Some((term, value)) if *term == column.cofactor => value,
                _ => column.cofactor.value(&values),
            };
            last = Some((&column.cofactor, cofactor));
            let mut polynomial = legendre(column.degree, x);
            if column.anchored {
                polynomial -= if column.degree.is_multiple_of(2) { 1.0 } else { -1.0 };
            }
            let shift = if column.shift == 0.0 {
                1.0
            } else {
                raise(x, column.shift)
            };
            cofactor * shift * polynomial
        })
    }

    /// The matrix that converts coefficients of the columns to those of the terms.
    pub(super) fn conversion(&self) -> &DMatrix<f64> {
        &self.conversion
    }
}

/// P*_n(x) = P_n(2x - 1), by Bonnet's recurrence.
fn legendre(degree: usize, x: f64) -> f64 {
    let z = 2.0 * x - 1.0;
    let (mut before, mut now) = (0.0, 1.0);
    for n in 0..degree {
        let n = n as f64;
        (before, now) = (now, ((2.0 * n + 1.0) * z * now - n * before) / (n + 1.0));
    }
    now
}

/// Coefficients of P*_n in powers of x: (-1)^(n+k) C(n,k) C(n+k,k).
fn legendre_coefficients(degree: usize) -> Vec<f64> {
    let mut coefficient = if degree.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut all = vec![coefficient];
    for k in 0..degree {
        // C(n,k+1) C(n+k+1,k+1) in terms of C(n,k) C(n+k,k).
        coefficient *= -((degree - k) as f64) * ((degree + k + 1) as f64) / ((k + 1) as f64).powi(2);
        all.push(coefficient);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_are_those_of_the_recurrence() {
        for degree in 0..8 {
            for x in [0.0, 0.3, 1.0] {
                let sum = legendre_coefficients(degree)
                    .iter()
                    .rev()
                    .fold(0.0, |sum, c| sum * x + c);
                assert!((sum - legendre(degree, x)).abs() < 1e-11, "{degree} {x}");
            }
        }
    }
}

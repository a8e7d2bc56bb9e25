use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix};

/// Modal radiation resistance R(f) at one frequency: Hermitian, positive semidefinite, modes x modes.
///
/// With mass-normalised modal coordinates its unit is 1/s. It is real symmetric unless surface points move with
/// different phases, like the sand around a block; then `imaginary` contains the antisymmetric part.
#[derive(Debug, Clone, PartialEq)]
pub struct Resistance {
    /// Symmetric real part.
    pub real: DMatrix<f64>,
    /// Antisymmetric imaginary part; `None` if zero.
    pub imaginary: Option<DMatrix<f64>>,
}

impl Resistance {
    /// The quadratic form v^H R v.
    pub fn form(&self, v: &[Complex<f64>]) -> f64 {
        let n = v.len();
        let mut total = 0.0;
        for j in 0..n {
            for i in 0..n {
                let pair = v[i].conj() * v[j];
                total += self.real[(i, j)] * pair.re;
                if let Some(imaginary) = &self.imaginary {
                    total -= imaginary[(i, j)] * pair.im;
                }
            }
        }
        total
    }

    /// R times a real factor.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.real *= factor;
        if let Some(imaginary) = &mut self.imaginary {
            *imaginary *= factor;
        }
        self
    }

    /// Adds `factor` times another resistance.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        add_scaled(&mut self.real, factor, &other.real);
        if let Some(theirs) = &other.imaginary {
            let (rows, columns) = theirs.shape();
            add_scaled(
                self.imaginary.get_or_insert_with(|| DMatrix::zeros(rows, columns)),
                factor,
                theirs,
            );
        }
    }

    /// v^T Re(R) v for a sparse real motion v, given by its nonzero entries.
    pub(crate) fn sparse_form(&self, v: &[(usize, f64)]) -> f64 {
        let row = |&(i, a): &(usize, f64)| a * v.iter().map(|&(j, b)| self.real[(i, j)] * b).sum::<f64>();
        v.iter().map(row).sum()
    }

    /// R times each column of a motion.
    pub(crate) fn product(&self, motion: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut product = real_product(&self.real, motion);
        if let Some(imaginary) = &self.imaginary {
            product += real_product(imaginary, motion) * Complex::<f64>::i();
        }
        product
    }

    /// The zero resistance of this many modes.
    pub fn zeros(modes: usize) -> Self {
        Self {
            real: DMatrix::zeros(modes, modes),
            imaginary: None,
        }
    }
}

fn add_scaled(to: &mut DMatrix<f64>, factor: f64, from: &DMatrix<f64>) {
    to.iter_mut().zip(from.iter()).for_each(|(a, b)| *a += factor * b);
}

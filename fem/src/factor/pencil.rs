//! The matrix pencil of the eigenproblem.

use nalgebra_sparse::CscMatrix;

/// The matrices of K phi = lambda M phi.
#[derive(Clone, Copy)]
pub(crate) struct Pencil<'a> {
    pub(crate) stiffness: &'a CscMatrix<f64>,
    pub(crate) mass: &'a CscMatrix<f64>,
}

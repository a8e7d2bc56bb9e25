//! Modes of vibration: settings and results.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Settings of a modal solution.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalSettings {
    /// All modes below this frequency are returned \[Hz\]. It may be moved up slightly into a gap between modes.
    pub top_hz: f64,
    /// Load patterns, 3 x nodes rows with one column per load, for which static-correction shapes are returned; there
    /// may be none.
    pub loads: Option<DMatrix<f64>>,
    /// Largest residual accepted for any mode.
    pub residual_limit: f64,
    /// Largest size of a Lanczos block; one pass finds multiplicities up to this size.
    pub block: usize,
    /// Whether mirror planes of the body are used to divide the problem.
    pub mirrors: bool,
    /// Largest number of Lanczos vectors before the iteration restarts with the best of them.
    pub max_vectors: usize,
}

impl ModalSettings {
    /// All modes below `top_hz` \[Hz\] without static corrections, with blocks of 16 and residuals below 1e-8.
    pub fn below(top_hz: f64) -> Self {
        Self {
            top_hz,
            loads: None,
            residual_limit: 1e-8,
            block: 16,
            mirrors: true,
            max_vectors: 3000,
        }
    }

    /// Adds static corrections for these load patterns (3 x nodes rows).
    #[must_use]
    pub fn with_loads(self, loads: DMatrix<f64>) -> Self {
        Self {
            loads: Some(loads),
            ..self
        }
    }
}

/// The modes of a body below a frequency, proven complete; `S` is `()` if the shapes are stored separately.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalBasis<S = DMatrix<f64>> {
    /// Free degrees of freedom of the model.
    pub dofs: usize,
    /// Natural frequencies, ascending; 0 for rigid modes \[Hz\].
    pub hz: Vec<f64>,
    /// Shapes of the modes, then of the static corrections: 3 x nodes rows, one column per shape, phi^T M phi = 1
    /// \[kg^-1/2\].
    pub shapes: S,
    /// |K phi - lambda M phi| / |lambda M phi| of each mode. A rigid mode has lambda = 0, so its residual
    /// is |K phi| / |lambda_1 M phi| with lambda_1 of the first elastic mode, or of the edge if there is none. On a
    /// soft support the terms of K phi cancel, so the residual consists of rounding; if 1e-6 diag(K) phi exceeds lambda
    /// M phi, it replaces the denominator.
    pub residuals: Vec<f64>,
    /// Whether each mode is a rigid-body mode.
    pub rigid: Vec<bool>,
    /// Largest entry of |Phi^T M Phi - I|.
    pub orthonormality: f64,
    /// The proof that no mode is missing.
    pub sturm: Sturm,
    /// Rayleigh frequencies of the static corrections for the load patterns, ascending \[Hz\].
    ///
    /// Corrections are residual vectors: the contribution of the omitted modes to the static response to the loads.
    /// They are mass-normalised and orthogonal to the modes and to each other with respect to M and K. They are
    /// therefore used as further modes with these frequencies, which lie above those of the modes.
    pub corrections: Vec<f64>,
    /// The cost of the solution.
    pub work: ModalWork,
}

/// The number of eigenvalues below an edge, from Sylvester's law of inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sturm {
    /// The edge \[Hz\].
    pub upper_hz: f64,
    /// Negative pivots of K - (2 pi upper_hz)^2 M.
    pub count: usize,
}

/// Work counters of a modal solution; they are independent of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModalWork {
    /// Number of independent problems into which mirror planes divide the body; 1 without symmetry.
    pub sectors: usize,
    /// Stored values of the factor L, summed over all sectors.
    pub factor_values: usize,
    /// Number of factorisations of the shifted matrix and for Sturm counts.
    pub factorisations: usize,
    /// Number of Lanczos block steps.
    pub block_steps: usize,
    /// Number of right-hand sides solved, including every vector of a block.
    pub solves: usize,
    /// Number of restarts of the iteration.
    pub restarts: usize,
}

impl ModalWork {
    /// Adds the work of part of the solution.
    pub(crate) fn add(&mut self, part: &Self) {
        self.factorisations += part.factorisations;
        self.block_steps += part.block_steps;
        self.solves += part.solves;
        self.restarts += part.restarts;
    }
}

impl<S> ModalBasis<S> {
    /// Replaces the shapes; returns the basis with the new shapes, and the old shapes.
    pub fn swap_shapes<T>(self, shapes: T) -> (ModalBasis<T>, S) {
        let basis = ModalBasis {
            dofs: self.dofs,
            hz: self.hz,
            shapes,
            residuals: self.residuals,
            rigid: self.rigid,
            orthonormality: self.orthonormality,
            sturm: self.sturm,
            corrections: self.corrections,
            work: self.work,
        };
        (basis, self.shapes)
    }

    /// Frequencies of modes and corrections, in the order of the columns of [`Self::shapes`] \[Hz\].
    pub fn all_hz(&self) -> Vec<f64> {
        self.hz.iter().chain(&self.corrections).copied().collect()
    }
}

//! Modes of vibration: the request and the result.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// What to solve for.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalSettings {
    /// All modes below this frequency are returned \[Hz\]. The edge may be moved up slightly into a gap between modes.
    pub top_hz: f64,
    /// Load patterns, 3 x nodes rows, one column each, for which static-correction shapes are returned; may have no
    /// columns.
    pub loads: Option<DMatrix<f64>>,
    /// Largest residual accepted for any mode.
    pub residual_limit: f64,
    /// Most vectors of a Lanczos block; multiplicities up to the block are found in one pass.
    pub block: usize,
    /// Whether mirror planes of the body are used to divide the problem.
    pub mirrors: bool,
    /// The largest number of Lanczos vectors before the iteration restarts on the best of them.
    pub max_vectors: usize,
}

impl ModalSettings {
    /// All modes below `top_hz` \[Hz\], without static corrections: blocks of 16, residuals below 1e-8.
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

    /// The same with static corrections for these load patterns (3 x nodes rows).
    #[must_use]
    pub fn with_loads(self, loads: DMatrix<f64>) -> Self {
        Self {
            loads: Some(loads),
            ..self
        }
    }
}

/// The modes of a body below a frequency, proven complete; `S` is `()` where the shapes are stored separately.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalBasis<S = DMatrix<f64>> {
    /// Free degrees of freedom of the model.
    pub dofs: usize,
    /// Natural frequencies, ascending; 0 for rigid modes \[Hz\].
    pub hz: Vec<f64>,
    /// Shapes of the modes, then of the static corrections: 3 x nodes rows, one column a shape, phi^T M phi = 1
    /// \[kg^-1/2\].
    pub shapes: S,
    /// |K phi - lambda M phi| / |lambda M phi| of each mode. A rigid mode has no lambda to divide by, so its residual
    /// is |K phi| / |lambda_1 M phi| with the first elastic mode's lambda_1, or that of the edge when there is none. On
    /// a soft support the terms of K phi cancel, and only rounding is left of a residual: where 1e-6 diag(K) phi is
    /// larger than lambda M phi, it takes that one's place.
    pub residuals: Vec<f64>,
    /// Whether a mode moves the body without straining it.
    pub rigid: Vec<bool>,
    /// Largest entry of |Phi^T M Phi - I|.
    pub orthonormality: f64,
    /// The proof that none is missing.
    pub sturm: Sturm,
    /// Rayleigh frequencies of the static corrections for the load patterns asked for, ascending \[Hz\].
    ///
    /// Corrections are residual vectors: the contribution of the omitted modes to the static response to the loads.
    /// They are orthogonal to the modes and to each other with respect to M and K, mass-normalised, and so are taken as
    /// further modes with these frequencies, which lie above those of the modes.
    pub corrections: Vec<f64>,
    /// The cost of the solution.
    pub work: ModalWork,
}

/// The number of eigenvalues below an edge, by Sylvester's law of inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sturm {
    /// The edge \[Hz\].
    pub upper_hz: f64,
    /// Negative pivots of K - (2 pi upper_hz)^2 M.
    pub count: usize,
}

/// Work counters of a modal solution; they do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModalWork {
    /// Independent problems that mirror planes divide the body into; 1 without symmetry.
    pub sectors: usize,
    /// Stored values of the factor L, of all sectors together.
    pub factor_values: usize,
    /// Factorisations, of the shifted matrix and for the Sturm counts.
    pub factorisations: usize,
    /// Lanczos block steps.
    pub block_steps: usize,
    /// Right-hand sides solved for, those of a block step counting one each.
    pub solves: usize,
    /// Restarts of the iteration.
    pub restarts: usize,
}

impl ModalWork {
    /// Adds the cost of a part of the solution.
    pub(crate) fn add(&mut self, part: &Self) {
        self.factorisations += part.factorisations;
        self.block_steps += part.block_steps;
        self.solves += part.solves;
        self.restarts += part.restarts;
    }
}

impl<S> ModalBasis<S> {
    /// Replaces the shapes; returns the basis with the new shapes, and the old ones.
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

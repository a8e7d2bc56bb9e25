//! Modes of vibration: what is asked for and what comes back.

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
    /// Vectors a Lanczos block holds at most; multiplicities up to the block are found in one pass.
    pub block: usize,
    /// Whether mirror planes of the body are used to divide the problem.
    pub mirrors: bool,
    /// The largest number of Lanczos vectors kept before the iteration restarts on the best of them.
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

/// The modes of a body below a frequency, proven complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalBasis {
    /// Free degrees of freedom of the model.
    pub dofs: usize,
    /// Natural frequencies, ascending; 0 for rigid modes \[Hz\].
    pub hz: Vec<f64>,
    /// Shapes of the modes, then of the static corrections: 3 x nodes rows, one column a shape, phi^T M phi = 1
    /// \[kg^-1/2\].
    #[serde(with = "matrix")]
    pub shapes: DMatrix<f64>,
    /// |K phi - lambda M phi| / |lambda M phi| of each mode; a rigid mode has no lambda to divide by, so its residual is
    /// |K phi| / |lambda_1 M phi| with the first elastic mode's lambda_1, or that of the edge when there is none. On a
    /// soft support the terms of K phi cancel, and rounding is all that is left of a residual: where 1e-6 diag(K) phi is
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
    /// Corrections are residual vectors: what the modes left out contribute to the static response to the loads. They are
    /// orthogonal to the modes and to each other with respect to M and K, mass-normalised, and so are taken as further
    /// modes with these frequencies, which lie above those of the modes.
    pub corrections: Vec<f64>,
    /// What the solution cost.
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
    /// Adds what a part of the solution cost.
    pub(crate) fn add(&mut self, part: &Self) {
        self.factorisations += part.factorisations;
        self.block_steps += part.block_steps;
        self.solves += part.solves;
        self.restarts += part.restarts;
    }
}

impl ModalBasis {
    /// Frequencies of modes and corrections, in the order of the columns of [`Self::shapes`] \[Hz\].
    pub fn all_hz(&self) -> Vec<f64> {
        self.hz.iter().chain(&self.corrections).copied().collect()
    }
}

/// A matrix as its numbers of rows and columns and its entries column by column, as one piece of bytes.
mod matrix {
    use std::fmt;

    use nalgebra::DMatrix;
    use serde::de::{Error as _, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(matrix: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        (matrix.nrows(), matrix.ncols(), Entries(matrix.as_slice().to_vec())).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<DMatrix<f64>, D::Error> {
        let (rows, columns, Entries(entries)) = <(usize, usize, Entries)>::deserialize(deserializer)?;
        if rows.checked_mul(columns) != Some(entries.len()) {
            return Err(D::Error::custom("the entries do not fill the matrix"));
        }
        Ok(DMatrix::from_vec(rows, columns, entries))
    }

    struct Entries(Vec<f64>);

    impl Serialize for Entries {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let bytes: Vec<u8> = self.0.iter().flat_map(|entry| entry.to_le_bytes()).collect();
            serializer.serialize_bytes(&bytes)
        }
    }

    impl<'de> Deserialize<'de> for Entries {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct Bytes;
            impl Visitor<'_> for Bytes {
                type Value = Entries;

                fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.write_str("the bytes of double precision numbers")
                }

                fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Entries, E> {
                    let (entries, rest) = bytes.as_chunks::<8>();
                    if !rest.is_empty() {
                        return Err(E::invalid_length(bytes.len(), &self));
                    }
                    Ok(Entries(
                        entries.iter().map(|entry| f64::from_le_bytes(*entry)).collect(),
                    ))
                }
            }
            deserializer.deserialize_bytes(Bytes)
        }
    }
}

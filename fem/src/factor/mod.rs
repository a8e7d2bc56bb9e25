//! Supernodal factors of K - sigma M.

mod numeric;
pub(crate) mod order;
pub(crate) mod pencil;
pub(crate) mod rows;
pub(crate) mod sparse;
pub(crate) mod subtrees;
mod supernodal_solve;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::prelude::Solve;
use faer::sparse::linalg::cholesky::simplicial::prefactorize_symbolic_cholesky;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_symbolic_cholesky, factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, SymbolicSparseColMatRef, Triplet};
use faer::{MatMut, MatRef, Scale};
use nalgebra_sparse::CscMatrix;
use nalgebra_sparse::pattern::SparsityPattern;

use crate::FemError;
use crate::random::Random;
use numeric::{Descendants, Numeric};
use sparse::product_of_vector;
use subtrees::{PartRows, Subtrees};
use supernodal_solve::Panels;

/// Largest residual of a probe; that of a sound factor is many orders of magnitude smaller.
const PROBE_LIMIT: f64 = 1e-7;

/// The sparsity pattern of the factor, shared by all shifts.
#[derive(Debug)]
pub(crate) struct Symbolic {
    supernodal: SymbolicSupernodalCholesky<usize>,
    descendants: Descendants,
    subtrees: Subtrees,
}

impl Symbolic {
    /// Analyses the pattern of a symmetric matrix, given by its lower triangle in elimination order.
    pub(crate) fn new(a: &CscMatrix<f64>) -> Result<Self, FemError> {
        Self::of_pattern(a.pattern())
    }

    /// Same as `new`, given the pattern of the lower triangle by columns.
    pub(crate) fn of_pattern(lower: &SparsityPattern) -> Result<Self, FemError> {
        let n = lower.major_dim();
        let large = FemError::TooLarge { dofs: n };
        let upper = lower.transpose();
        let upper = SymbolicSparseColMatRef::new_checked(n, n, upper.major_offsets(), None, upper.minor_indices());
        let mut etree = vec![0isize; n];
        let mut counts = vec![0usize; n];
        let request = factorize_supernodal_symbolic_cholesky_scratch::<usize>(n).or(StackReq::new::<usize>(n));
        let mut memory = buffer(request, n)?;
        let stack = MemStack::new(&mut memory);
        let etree = prefactorize_symbolic_cholesky::<usize>(&mut etree, &mut counts, upper, stack);
        let supernodal = factorize_supernodal_symbolic_cholesky(upper, etree, &counts, stack, Default::default())
            .map_err(|_| large)?;
        Ok(Self {
            subtrees: Subtrees::new(&supernodal),
            descendants: Descendants::new(&supernodal),
            supernodal,
        })
    }

    /// How work in this elimination order is divided among threads.
    pub(crate) fn subtrees(&self) -> &Subtrees {
        &self.subtrees
    }

    /// Number of stored values of the factor.
    pub(crate) fn values(&self) -> usize {
        self.supernodal.len_val()
    }

    /// A factor of A for solves: L D L^T, or L U with pivoting if a pivot or the probe of L D L^T fails.
    pub(crate) fn best(&self, a: &CscMatrix<f64>, shift: f64, values: Vec<f64>) -> Result<Factor<'_>, FemError> {
        self.symmetric(a, shift, values).or_else(|_| self.pivoted(a, shift))
    }

    /// P A Q = L U, with a separate fill-reducing order.
    fn pivoted(&self, a: &CscMatrix<f64>, shift: f64) -> Result<Factor<'_>, FemError> {
        let n = a.nrows();
        let mut triplets = Vec::with_capacity(2 * a.nnz());
        for (i, j, &value) in a.triplet_iter() {
            triplets.push(Triplet::new(i, j, value));
            if i != j {
                triplets.push(Triplet::new(j, i, value));
            }
        }
        let pivot = |_| FemError::Pivot { shift, pivot: n };
        let full = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets)
            .map_err(|_| FemError::TooLarge { dofs: n })?;
        let factor = Factor {
            symbolic: self,
            kind: Kind::Pivoted(Box::new(full.sp_lu().map_err(pivot)?)),
        };
        factor.probe(a, shift)?;
        Ok(factor)
    }

    /// L D L^T = A. No pivoting is used; the probe checks the stability. `values` is the storage of an earlier factor,
    /// or empty.
    pub(crate) fn symmetric(&self, a: &CscMatrix<f64>, shift: f64, values: Vec<f64>) -> Result<Factor<'_>, FemError> {
        let mut values = self.storage(values);
        let numeric = Numeric {
            symbolic: &self.supernodal,
            descendants: &self.descendants,
            a,
        };
        let factorised = numeric.factorise(&self.subtrees, &mut values);
        factorised.map_err(|pivot| FemError::Pivot { shift, pivot })?;
        let diagonal = supernodal_solve::pack(&self.supernodal, &mut values);
        let factor = Factor {
            symbolic: self,
            kind: Kind::Symmetric { values, diagonal },
        };
        factor.probe(a, shift)?;
        Ok(factor)
    }

    /// Storage for the values; zeroed pages from the system are not touched before the factor is written.
    fn storage(&self, values: Vec<f64>) -> Vec<f64> {
        if values.len() == self.values() {
            return values;
        }
        vec![0.0; self.values()]
    }
}

/// A factor of a matrix.
pub(crate) struct Factor<'a> {
    symbolic: &'a Symbolic,
    kind: Kind,
}

enum Kind {
    /// L D L^T, stored as described in [`panels`].
    Symmetric {
        values: Vec<f64>,
        diagonal: Vec<f64>,
    },
    Pivoted(Box<Lu<usize, f64>>),
}

impl Factor<'_> {
    /// Overwrites x with A^-1 x.
    pub(crate) fn solve(&self, x: MatMut<'_, f64>) {
        match &self.kind {
            Kind::Symmetric { values, diagonal } => {
                self.panels(values, diagonal).solve(x, &mut PartRows::default());
            }
            Kind::Pivoted(lu) => lu.solve_in_place(x),
        }
    }

    /// Y = scale A^-1 X; `room` is reused by the next solve.
    pub(crate) fn solve_scaled(&self, scale: f64, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, room: &mut PartRows) {
        match &self.kind {
            Kind::Symmetric { values, diagonal } => {
                self.panels(values, diagonal).solve_scaled(scale, x, y, room);
            }
            Kind::Pivoted(lu) => {
                y.copy_from(x);
                lu.solve_in_place(y.as_mut());
                y *= Scale(scale);
            }
        }
    }

    fn panels<'f>(&'f self, values: &'f [f64], diagonal: &'f [f64]) -> Panels<'f> {
        Panels {
            symbolic: &self.symbolic.supernodal,
            subtrees: &self.symbolic.subtrees,
            values,
            diagonal,
        }
    }

    /// The sparsity pattern.
    pub(crate) fn symbolic(&self) -> &Symbolic {
        self.symbolic
    }

    /// The number of negative eigenvalues of A, which equals the number of negative pivots (Sylvester's law of
    /// inertia); none if pivoting has broken the symmetry.
    pub(crate) fn negative_eigenvalues(&self) -> Option<usize> {
        match &self.kind {
            Kind::Symmetric { diagonal, .. } => Some(diagonal.iter().filter(|&&d| d < 0.0).count()),
            Kind::Pivoted(_) => None,
        }
    }

    /// Returns the storage for use by another factor.
    pub(crate) fn into_storage(self) -> Vec<f64> {
        match self.kind {
            Kind::Symmetric { values, .. } => values,
            Kind::Pivoted(_) => Vec::new(),
        }
    }

    /// Solves A x = b for b = A z with a random z, and rejects the factor if |A x - b| / |b| is large.
    fn probe(&self, a: &CscMatrix<f64>, shift: f64) -> Result<(), FemError> {
        let mut random = Random::new(1);
        let n = a.nrows();
        let z: Vec<f64> = (0..n).map(|_| random.next()).collect();
        let b = product_of_vector(a, &z);
        let mut x = b.clone();
        self.solve(MatMut::from_column_major_slice_mut(&mut x, n, 1));
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let mut apart = product_of_vector(a, &x).into_iter().zip(&b).map(|(x, b)| x - b);
        let residual = norm(&mut apart) / norm(&mut b.iter().copied());
        if residual.is_nan() || residual > PROBE_LIMIT {
            return Err(FemError::Probe {
                shift,
                residual,
                limit: PROBE_LIMIT,
            });
        }
        Ok(())
    }
}

fn buffer(request: StackReq, dofs: usize) -> Result<MemBuffer, FemError> {
    MemBuffer::try_new(request).map_err(|_| FemError::TooLarge { dofs })
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use nalgebra::DMatrix;

    use super::*;
    use crate::factor::sparse::product;

    fn lower(rows: &[&[f64]]) -> CscMatrix<f64> {
        let dense = DMatrix::from_fn(rows.len(), rows.len(), |i, j| if i >= j { rows[i][j] } else { 0.0 });
        // Zeros of the pattern are stored, so that all matrices share the pattern.
        let n = rows.len();
        let offsets = (0..=n).map(|j| j * n - j * j.saturating_sub(1) / 2).collect();
        let indices = (0..n).flat_map(|j| j..n).collect();
        let values = (0..n)
            .flat_map(|j| (j..n).map(move |i| (i, j)))
            .map(|at| dense[at])
            .collect();
        CscMatrix::try_from_csc_data(n, n, offsets, indices, values).unwrap()
    }

    fn solves(factor: &Factor<'_>, a: &CscMatrix<f64>) {
        let x = Mat::from_fn(a.nrows(), 19, |i, j| ((3 * i + 5 * j) as f64).sin());
        let mut b = product(a, x.as_ref());
        factor.solve(b.as_mut());
        assert!((b - x).norm_max() < 1e-12);
    }

    #[test]
    fn each_matrix_gets_the_factor_it_admits() {
        let definite = lower(&[&[4.0, 0.0, 0.0], &[1.0, 3.0, 0.0], &[0.5, -1.0, 5.0]]);
        let symbolic = Symbolic::new(&definite).unwrap();
        let factor = symbolic.best(&definite, 0.0, Vec::new()).unwrap();
        assert_eq!(factor.negative_eigenvalues(), Some(0));
        solves(&factor, &definite);
        let indefinite = lower(&[&[4.0, 0.0, 0.0], &[1.0, -3.0, 0.0], &[0.5, -1.0, 5.0]]);
        let factor = symbolic.best(&indefinite, 0.0, Vec::new()).unwrap();
        assert_eq!(factor.negative_eigenvalues(), Some(1));
        solves(&factor, &indefinite);
        // Its first pivot is zero, so the factor does not exist without pivoting.
        let saddle = lower(&[&[0.0, 0.0, 0.0], &[1.0, 0.0, 0.0], &[2.0, -1.0, 0.0]]);
        assert!(symbolic.symmetric(&saddle, 0.0, Vec::new()).is_err());
        let factor = symbolic.best(&saddle, 0.0, Vec::new()).unwrap();
        assert_eq!(factor.negative_eigenvalues(), None);
        solves(&factor, &saddle);
        let singular = lower(&[&[0.0, 0.0, 0.0], &[0.0, 0.0, 0.0], &[0.0, 0.0, 0.0]]);
        assert!(symbolic.best(&singular, 0.0, Vec::new()).is_err());
    }

    #[test]
    fn supernodes_of_several_blocks_and_panels_of_every_height_solve() {
        // A full matrix is a single supernode.
        for n in [5, 64, 65, 131, 134] {
            let entry = |i: usize, j: usize| ((3 * i + 7 * j) as f64).cos() + if i == j { 3.0 * n as f64 } else { 0.0 };
            let offsets = (0..=n).map(|j: usize| j * n - j * j.saturating_sub(1) / 2).collect();
            let indices = (0..n).flat_map(|j| j..n).collect();
            let values = (0..n).flat_map(|j| (j..n).map(move |i| entry(i, j))).collect();
            let full = CscMatrix::try_from_csc_data(n, n, offsets, indices, values).unwrap();
            let symbolic = Symbolic::new(&full).unwrap();
            solves(&symbolic.symmetric(&full, 0.0, Vec::new()).unwrap(), &full);
        }
    }

    #[test]
    fn rows_below_several_supernodes_take_panels_of_every_height() {
        for shared in 1..9 {
            let (part, n) = (70, 2 * 70 + shared);
            let couples = |i: usize, j: usize| i >= 2 * part || i / part == j / part;
            let column = |j: usize| (j..n).filter(move |&i| couples(i, j));
            let mut offsets = vec![0];
            (0..n).for_each(|j| offsets.push(offsets[j] + column(j).count()));
            let indices: Vec<usize> = (0..n).flat_map(column).collect();
            let value = |(i, j): (usize, usize)| ((i + 5 * j) as f64).sin() + if i == j { 3.0 * n as f64 } else { 0.0 };
            let values = (0..n).flat_map(|j| column(j).map(move |i| (i, j))).map(value).collect();
            let arrow = CscMatrix::try_from_csc_data(n, n, offsets, indices, values).unwrap();
            let symbolic = Symbolic::new(&arrow).unwrap();
            solves(&symbolic.symmetric(&arrow, 0.0, Vec::new()).unwrap(), &arrow);
        }
    }
}

//! Supernodal factors of K - sigma M.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::cholesky::simplicial::prefactorize_symbolic_cholesky;
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLdltRef, SupernodalLltRef, SymbolicSupernodalCholesky, factorize_supernodal_numeric_ldlt,
    factorize_supernodal_numeric_ldlt_scratch, factorize_supernodal_numeric_llt,
    factorize_supernodal_numeric_llt_scratch, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par};
use nalgebra_sparse::CscMatrix;

use crate::FemError;
use crate::random::Random;
use crate::sparse::product;

/// Sequential inside, so that no bit depends on the number of threads.
const PAR: Par = Par::Seq;

/// Largest residual of a probe; a sound factor stays many orders below.
const PROBE_LIMIT: f64 = 1e-7;

/// The pattern of the factor, shared by all shifts.
pub(crate) struct Symbolic {
    supernodal: SymbolicSupernodalCholesky<usize>,
}

impl Symbolic {
    /// Analyses the pattern of a symmetric matrix given by its lower triangle, already in the order of elimination.
    pub(crate) fn new(a: &CscMatrix<f64>) -> Result<Self, FemError> {
        let n = a.nrows();
        let large = FemError::TooLarge { dofs: n };
        let upper = a.pattern().transpose();
        let upper = SymbolicSparseColMatRef::new_checked(n, n, upper.major_offsets(), None, upper.minor_indices());
        let mut etree = vec![0isize; n];
        let mut counts = vec![0usize; n];
        let request = factorize_supernodal_symbolic_cholesky_scratch::<usize>(n).or(StackReq::new::<usize>(n));
        let mut memory = buffer(request, n)?;
        let stack = MemStack::new(&mut memory);
        let etree = prefactorize_symbolic_cholesky::<usize>(&mut etree, &mut counts, upper, stack);
        let supernodal = factorize_supernodal_symbolic_cholesky(upper, etree, &counts, stack, Default::default())
            .map_err(|_| large)?;
        Ok(Self { supernodal })
    }

    /// Number of stored values of the factor.
    pub(crate) fn values(&self) -> usize {
        self.supernodal.len_val()
    }

    /// L L^T = A for a positive definite A; `values` is the storage of an earlier factor, or empty.
    pub(crate) fn cholesky(&self, a: &CscMatrix<f64>, shift: f64, values: Vec<f64>) -> Result<Factor<'_>, FemError> {
        let request = factorize_supernodal_numeric_llt_scratch::<usize, f64>(&self.supernodal, PAR, Default::default());
        let mut memory = buffer(request, a.nrows())?;
        let mut factor = Factor {
            symbolic: self,
            values,
            kind: Kind::Cholesky,
        };
        factor.values.resize(self.values(), 0.0);
        factorize_supernodal_numeric_llt(
            &mut factor.values,
            view(a),
            Default::default(),
            &self.supernodal,
            PAR,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|LltError::NonPositivePivot { index }| FemError::Pivot { shift, pivot: index })?;
        factor.probe(a, shift)?;
        Ok(factor)
    }

    /// L D L^T = A for an indefinite A. There is no pivoting, so the probe stands guard over its stability.
    pub(crate) fn indefinite(&self, a: &CscMatrix<f64>, shift: f64, values: Vec<f64>) -> Result<Factor<'_>, FemError> {
        let request =
            factorize_supernodal_numeric_ldlt_scratch::<usize, f64>(&self.supernodal, PAR, Default::default());
        let mut memory = buffer(request, a.nrows())?;
        let mut factor = Factor {
            symbolic: self,
            values,
            kind: Kind::Indefinite,
        };
        factor.values.resize(self.values(), 0.0);
        factorize_supernodal_numeric_ldlt(
            &mut factor.values,
            view(a),
            Default::default(),
            &self.supernodal,
            PAR,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|LdltError::ZeroPivot { index }| FemError::Pivot { shift, pivot: index })?;
        factor.probe(a, shift)?;
        Ok(factor)
    }
}

/// L L^T or L D L^T of a matrix.
pub(crate) struct Factor<'a> {
    symbolic: &'a Symbolic,
    values: Vec<f64>,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    Cholesky,
    Indefinite,
}

impl Factor<'_> {
    /// Overwrites x by A^-1 x.
    pub(crate) fn solve(&self, x: MatMut<'_, f64>) -> Result<(), FemError> {
        let supernodal = &self.symbolic.supernodal;
        let mut memory = buffer(
            supernodal.solve_in_place_scratch::<f64>(x.ncols(), PAR),
            supernodal.nrows(),
        )?;
        let stack = MemStack::new(&mut memory);
        match self.kind {
            Kind::Cholesky => SupernodalLltRef::<'_, usize, f64>::new(supernodal, &self.values)
                .solve_in_place_with_conj(Conj::No, x, PAR, stack),
            Kind::Indefinite => SupernodalLdltRef::<'_, usize, f64>::new(supernodal, &self.values)
                .solve_in_place_with_conj(Conj::No, x, PAR, stack),
        }
        Ok(())
    }

    /// The number of negative eigenvalues of A, by Sylvester's law of inertia that of the negative pivots.
    pub(crate) fn negative_eigenvalues(&self) -> usize {
        let supernodal = &self.symbolic.supernodal;
        let factor = SupernodalLdltRef::<'_, usize, f64>::new(supernodal, &self.values);
        match self.kind {
            Kind::Cholesky => 0,
            Kind::Indefinite => (0..supernodal.n_supernodes())
                .map(|s| {
                    factor
                        .supernode(s)
                        .val()
                        .diagonal()
                        .column_vector()
                        .iter()
                        .filter(|&&d| d < 0.0)
                        .count()
                })
                .sum(),
        }
    }

    /// The storage, for another factor.
    pub(crate) fn into_storage(self) -> Vec<f64> {
        self.values
    }

    /// Solves for b = A z with a random z and refuses the factor when |A x - b| / |b| is large.
    fn probe(&self, a: &CscMatrix<f64>, shift: f64) -> Result<(), FemError> {
        let mut random = Random::new(1);
        let z = Mat::from_fn(a.nrows(), 1, |_, _| random.next());
        let b = product(a, z.as_ref());
        let mut x = b.clone();
        self.solve(x.as_mut())?;
        let residual = (product(a, x.as_ref()) - &b).norm_l2() / b.norm_l2();
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

fn view(a: &CscMatrix<f64>) -> SparseColMatRef<'_, usize, f64> {
    let n = a.nrows();
    SparseColMatRef::new(
        SymbolicSparseColMatRef::new_checked(n, n, a.col_offsets(), None, a.row_indices()),
        a.values(),
    )
}

fn buffer(request: StackReq, dofs: usize) -> Result<MemBuffer, FemError> {
    MemBuffer::try_new(request).map_err(|_| FemError::TooLarge { dofs })
}

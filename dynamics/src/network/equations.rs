//! The network as a system of equations for diffsol.

use std::cell::{Cell, RefCell};

use diffsol::matrix::dense_nalgebra_serial::NalgebraMat;
use diffsol::{
    ConstantOp, Matrix as _, NalgebraContext, NalgebraVec, NonLinearOp, NonLinearOpJacobian, OdeEquations,
    OdeEquationsRef, OdeSolverProblem, Op, ParameterisedOp, UnitCallable,
};

use super::jacobian::Jacobian;
use super::mode::Mode;
use super::past_flows::PastFlows;
use super::plan::Plan;
use super::rates::Workspace;

type Matrix = NalgebraMat<f64>;
type Vector = NalgebraVec<f64>;

/// Number of power iterations before the growth is averaged, and number of those in the average. A pair of complex
/// eigenvalues makes the growth oscillate.
const SETTLING: usize = 8;
const AVERAGED: usize = 6;

/// The equations with their tolerances.
pub(crate) type Problem<'p> = OdeSolverProblem<Equations<'p>>;

/// Counts of evaluations.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Calls {
    pub(crate) rates: usize,
    pub(crate) jacobians: usize,
}

/// dy/dt = f(t, y) in a fixed mode.
pub(crate) struct Equations<'p> {
    plan: &'p Plan,
    inside: RefCell<Inside>,
    calls: Cell<Calls>,
    context: NalgebraContext,
}

/// The data that an evaluation changes.
struct Inside {
    mode: Mode,
    workspace: Workspace,
    jacobian: Jacobian,
}

impl<'p> Equations<'p> {
    /// The equations in a mode; the past flows are those of the run.
    pub(crate) fn new(plan: &'p Plan, mode: Mode, past: PastFlows) -> Self {
        let mut workspace = Workspace::new(plan);
        workspace.past = past;
        Self {
            plan,
            inside: RefCell::new(Inside {
                mode,
                workspace,
                jacobian: Jacobian::new(plan),
            }),
            calls: Cell::default(),
            context: NalgebraContext::default(),
        }
    }

    pub(crate) fn set_mode(&self, mode: &Mode) {
        self.inside.borrow_mut().mode.clone_from(mode);
    }

    pub(crate) fn calls(&self) -> Calls {
        self.calls.get()
    }

    fn count(&self, change: impl FnOnce(&mut Calls)) {
        let mut calls = self.calls.get();
        change(&mut calls);
        self.calls.set(calls);
    }

    /// Evaluates the Jacobian at a state.
    pub(crate) fn linearise(&self, t: f64, y: &[f64]) {
        self.count(|calls| calls.jacobians += 1);
        let Inside {
            mode,
            workspace,
            jacobian,
        } = &mut *self.inside.borrow_mut();
        self.plan.jacobian(t, y, mode, workspace, jacobian);
    }

    /// y' and y'' at a state, without the explicit dependence on time in y''; evaluates the Jacobian.
    pub(crate) fn derivatives(&self, t: f64, y: &[f64]) -> [Vec<f64>; 2] {
        let first = self.rates(t, y);
        self.linearise(t, y);
        let mut second = vec![0.0; y.len()];
        let inside = self.inside.borrow();
        for (column, rate) in inside.jacobian.values().chunks_exact(y.len()).zip(&first) {
            for (second, value) in second.iter_mut().zip(column) {
                *second += value * rate;
            }
        }
        [first, second]
    }

    /// Estimate of the spectral radius of the states' part of the Jacobian that was evaluated last, by power iteration
    /// in units of `scale` \[1/s\].
    pub(crate) fn spectral_radius(&self, scale: &[f64]) -> f64 {
        let jacobian = &self.inside.borrow().jacobian;
        let states = self.plan.states();
        let scale = &scale[..states];
        let (mut x, mut product) = (vec![1.0; states], vec![0.0; states]);
        let mut growth = 0.0;
        for iteration in 0..SETTLING + AVERAGED {
            product.fill(0.0);
            let columns = jacobian.values().chunks_exact(self.plan.size()).zip(&x).zip(scale);
            for ((column, x), size) in columns {
                let value = x * size;
                for (product, entry) in product.iter_mut().zip(column) {
                    *product += entry * value;
                }
            }
            for (product, size) in product.iter_mut().zip(scale) {
                *product /= size;
            }
            let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let norm = length(&product);
            if norm == 0.0 {
                return 0.0;
            }
            if iteration >= SETTLING {
                growth += (norm / length(&x)).ln();
            }
            for (x, product) in x.iter_mut().zip(&product) {
                *x = product / norm;
            }
        }
        (growth / AVERAGED as f64).exp()
    }

    /// y' at a state.
    pub(crate) fn rates(&self, t: f64, y: &[f64]) -> Vec<f64> {
        let mut rate = vec![0.0; y.len()];
        let Inside { mode, workspace, .. } = &mut *self.inside.borrow_mut();
        self.plan.rates(t, y, mode, workspace, &mut rate);
        rate
    }

    fn size(&self) -> usize {
        self.plan.size()
    }
}

impl Op for Equations<'_> {
    type T = f64;
    type V = Vector;
    type M = Matrix;
    type C = NalgebraContext;

    fn context(&self) -> &NalgebraContext {
        &self.context
    }
    fn nstates(&self) -> usize {
        self.size()
    }
    fn nout(&self) -> usize {
        self.size()
    }
    fn nparams(&self) -> usize {
        0
    }
}

/// The right-hand side.
pub(crate) struct Rates<'a, 'p>(&'a Equations<'p>);

/// The initial state; unused, because every segment starts from its own state.
pub(crate) struct Initial<'a, 'p>(&'a Equations<'p>);

macro_rules! same_shape {
    ($name:ident) => {
        impl Op for $name<'_, '_> {
            type T = f64;
            type V = Vector;
            type M = Matrix;
            type C = NalgebraContext;

            fn context(&self) -> &NalgebraContext {
                &self.0.context
            }
            fn nstates(&self) -> usize {
                self.0.size()
            }
            fn nout(&self) -> usize {
                self.0.size()
            }
            fn nparams(&self) -> usize {
                0
            }
        }
    };
}
same_shape!(Rates);
same_shape!(Initial);

impl ConstantOp for Initial<'_, '_> {
    fn call_inplace(&self, _t: f64, y: &mut Vector) {
        y.batch_as_mut_slice(0).fill(0.0);
    }
}

impl NonLinearOp for Rates<'_, '_> {
    fn call_inplace(&self, x: &Vector, t: f64, y: &mut Vector) {
        self.0.count(|calls| calls.rates += 1);
        let Inside { mode, workspace, .. } = &mut *self.0.inside.borrow_mut();
        let rate = y.batch_as_mut_slice(0);
        self.0.plan.rates(t, x.batch_as_slice(0), mode, workspace, rate);
    }
}

impl NonLinearOpJacobian for Rates<'_, '_> {
    fn jac_mul_inplace(&self, x: &Vector, t: f64, v: &Vector, y: &mut Vector) {
        let Inside {
            mode,
            workspace,
            jacobian,
        } = &mut *self.0.inside.borrow_mut();
        self.0.plan.jacobian(t, x.batch_as_slice(0), mode, workspace, jacobian);
        let product = y.batch_as_mut_slice(0);
        product.fill(0.0);
        for (column, factor) in jacobian.values().chunks_exact(product.len()).zip(v.batch_as_slice(0)) {
            for (product, value) in product.iter_mut().zip(column) {
                *product += value * factor;
            }
        }
    }

    fn jacobian_inplace(&self, x: &Vector, t: f64, matrix: &mut Matrix) {
        self.0.count(|calls| calls.jacobians += 1);
        let Inside {
            mode,
            workspace,
            jacobian,
        } = &mut *self.0.inside.borrow_mut();
        self.0.plan.jacobian(t, x.batch_as_slice(0), mode, workspace, jacobian);
        // The columns of the ledger stay zero.
        let values = jacobian.values();
        matrix.inner_mut().as_mut_slice()[..values.len()].copy_from_slice(values);
    }
}

impl<'a, 'p> OdeEquationsRef<'a> for Equations<'p> {
    type Rhs = Rates<'a, 'p>;
    type Mass = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Root = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Init = Initial<'a, 'p>;
    type Out = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Reset = ParameterisedOp<'a, UnitCallable<Matrix>>;
}

impl<'p> OdeEquations for Equations<'p> {
    fn rhs(&self) -> Rates<'_, 'p> {
        Rates(self)
    }

    fn mass(&self) -> Option<ParameterisedOp<'_, UnitCallable<Matrix>>> {
        None
    }

    fn init(&self) -> Initial<'_, 'p> {
        Initial(self)
    }

    fn set_params(&mut self, _p: &Vector) {}

    fn get_params(&self, _p: &mut Vector) {}
}

//! The model as a system of equations for diffsol.

use std::cell::{Cell, RefCell};

use diffsol::matrix::dense_nalgebra_serial::NalgebraMat;
use diffsol::{
    ConstantOp, DenseMatrix, NalgebraContext, NalgebraVec, NonLinearOp, NonLinearOpJacobian, OdeEquations,
    OdeEquationsRef, Op, ParameterisedOp, UnitCallable,
};

use super::history::{History, Past};
use super::mode::Mode;
use super::state::{SIZE, STATES, State};
use super::system::System;
use crate::Form;
use nailnoise_penetration::Dual;

type Matrix = NalgebraMat<f64>;
type Vector = NalgebraVec<f64>;

/// Numbers of evaluations.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Calls {
    pub(crate) rates: usize,
    pub(crate) jacobians: usize,
}

/// dy/dt = f(y) in a fixed mode.
pub(crate) struct Equations<'s> {
    system: &'s System,
    mode: Cell<Mode>,
    calls: Cell<Calls>,
    history: RefCell<History>,
    context: NalgebraContext,
}

impl<'s> Equations<'s> {
    pub(crate) fn new(system: &'s System, mode: Mode) -> Self {
        Self {
            system,
            mode: Cell::new(mode),
            calls: Cell::default(),
            history: RefCell::default(),
            context: NalgebraContext::default(),
        }
    }

    pub(crate) fn set_mode(&self, mode: Mode) {
        self.mode.set(mode);
    }

    pub(crate) fn calls(&self) -> Calls {
        self.calls.get()
    }

    /// Channel flow one delay earlier, in the form that delays it.
    pub(crate) fn past(&self, t: f64) -> Past {
        match self.system.p.model.delay {
            Form::Corrected => Past::none(),
            Form::Published => self.history.borrow().at(t - self.system.geometry.channel_delay),
        }
    }

    /// Stores the channel flow at an accepted state, in the form that delays it.
    pub(crate) fn remember(&self, t: f64, y: &State) {
        if self.system.p.model.delay == Form::Published {
            let mode = self.mode.get();
            let rate: State = self.system.rates(y, &mode, &self.past(t));
            self.history.borrow_mut().push(self.system, mode.released, t, y, &rate);
        }
    }

    /// y' and y'' at a state.
    pub(crate) fn derivatives(&self, t: f64, y: &State) -> (State, State) {
        let (mode, past) = (self.mode.get(), self.past(t));
        let first: State = self.system.rates(y, &mode, &past);
        let along: [Dual<1>; SIZE] = std::array::from_fn(|i| Dual {
            value: y[i],
            slope: [first[i]],
        });
        let second = self.system.rates(&along, &mode, &past);
        (first, second.map(|d| d.slope[0]))
    }

    fn jacobian(&self, t: f64, y: &[f64]) -> [Dual<STATES>; SIZE] {
        let mut calls = self.calls.get();
        calls.jacobians += 1;
        self.calls.set(calls);
        let seeded: [Dual<STATES>; SIZE] = std::array::from_fn(|i| {
            let mut slope = [0.0; STATES];
            if i < STATES {
                slope[i] = 1.0;
            }
            Dual { value: y[i], slope }
        });
        self.system.rates(&seeded, &self.mode.get(), &self.past(t))
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
        SIZE
    }
    fn nout(&self) -> usize {
        SIZE
    }
    fn nparams(&self) -> usize {
        0
    }
}

/// The right-hand side.
pub(crate) struct Rates<'a, 's>(&'a Equations<'s>);

/// The initial state; unused, because every segment starts from its own state.
pub(crate) struct Start<'a, 's>(&'a Equations<'s>);

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
                SIZE
            }
            fn nout(&self) -> usize {
                SIZE
            }
            fn nparams(&self) -> usize {
                0
            }
        }
    };
}
same_shape!(Rates);
same_shape!(Start);

impl ConstantOp for Start<'_, '_> {
    fn call_inplace(&self, _t: f64, y: &mut Vector) {
        y.batch_as_mut_slice(0).fill(0.0);
    }
}

impl NonLinearOp for Rates<'_, '_> {
    fn call_inplace(&self, x: &Vector, t: f64, y: &mut Vector) {
        let mut calls = self.0.calls.get();
        calls.rates += 1;
        self.0.calls.set(calls);
        let rates: State = self
            .0
            .system
            .rates(x.batch_as_slice(0), &self.0.mode.get(), &self.0.past(t));
        y.batch_as_mut_slice(0).copy_from_slice(&rates);
    }
}

impl NonLinearOpJacobian for Rates<'_, '_> {
    fn jac_mul_inplace(&self, x: &Vector, t: f64, v: &Vector, y: &mut Vector) {
        let (x, v) = (x.batch_as_slice(0), v.batch_as_slice(0));
        let along: [Dual<1>; SIZE] = std::array::from_fn(|i| Dual {
            value: x[i],
            slope: [v[i]],
        });
        let rates = self.0.system.rates(&along, &self.0.mode.get(), &self.0.past(t));
        for (y, rate) in y.batch_as_mut_slice(0).iter_mut().zip(&rates) {
            *y = rate.slope[0];
        }
    }

    fn jacobian_inplace(&self, x: &Vector, t: f64, matrix: &mut Matrix) {
        let rows = self.0.jacobian(t, x.batch_as_slice(0));
        for (i, row) in rows.iter().enumerate() {
            for (j, slope) in row.slope.iter().enumerate() {
                matrix.set_index(i, j, *slope);
            }
        }
    }
}

impl<'a, 's> OdeEquationsRef<'a> for Equations<'s> {
    type Rhs = Rates<'a, 's>;
    type Mass = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Root = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Init = Start<'a, 's>;
    type Out = ParameterisedOp<'a, UnitCallable<Matrix>>;
    type Reset = ParameterisedOp<'a, UnitCallable<Matrix>>;
}

impl<'s> OdeEquations for Equations<'s> {
    fn rhs(&self) -> Rates<'_, 's> {
        Rates(self)
    }

    fn mass(&self) -> Option<ParameterisedOp<'_, UnitCallable<Matrix>>> {
        None
    }

    fn init(&self) -> Start<'_, 's> {
        Start(self)
    }

    fn set_params(&mut self, _p: &Vector) {}

    fn get_params(&self, _p: &mut Vector) {}
}

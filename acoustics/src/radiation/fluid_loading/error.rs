use crate::checks::InputError;
use thiserror::Error;

/// Why fluid loading of modes cannot be computed.
#[derive(Debug, Error)]
pub enum FluidLoadingError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The total mass of structure and fluid is not positive definite.
    #[error(
        "the mass of modes and fluid is not positive definite at {hz:.1} Hz; X / omega must be positive: refine the \
         boundary \
         elements, or leave out modes that move the surface alike"
    )]
    Mass {
        /// Frequency \[Hz\].
        hz: f64,
    },
    /// The equations of motion have no solution at a frequency.
    #[error(
        "the modal equations are singular at {hz:.3} Hz; an undamped mode is driven at its resonance, or a support \
         has no damping"
    )]
    Singular {
        /// Frequency \[Hz\].
        hz: f64,
    },
    /// The iteration for the motion with the full impedance does not converge.
    #[error(
        "the motion with the complete impedance does not converge at {hz:.1} Hz, residual {residual:.1e}: refine the \
         boundary \
         elements, or let radiation act as damping alone"
    )]
    Iteration {
        /// Frequency \[Hz\].
        hz: f64,
        /// Residual relative to the right-hand side \[-\].
        residual: f64,
    },
    /// The method does not provide the added mass of the fluid.
    #[error(
        "{method} gives radiation resistance alone, no mass of air that moves along; let radiation act as damping, or \
         compute \
         it by boundary elements"
    )]
    NoReactance {
        /// The method.
        method: &'static str,
    },
}

//! Complex frequencies of free vibration in the fluid.

use super::error::FluidLoadingError;
use super::modes::{DryModes, hz};
use nalgebra::{Complex, DMatrix, DVector};

/// Number of iterations of either kind after which a resonance is abandoned.
const MOST: usize = 60;

/// Relative change of a frequency below which an iteration ends \[-\].
const TOLERANCE: f64 = 1e-10;

/// Free vibration in the fluid, e^{j omega t} with omega = omega_r + j omega_i.
#[derive(Debug, Clone, PartialEq)]
pub struct Resonance {
    /// Complex angular frequency \[rad/s\]; its imaginary part is positive for decaying motion.
    pub omega: Complex<f64>,
    /// Amplitudes of the dry modes, normalised to unit length.
    pub shape: DVector<Complex<f64>>,
}

impl Resonance {
    /// Frequency \[Hz\], the real part.
    pub fn hz(&self) -> f64 {
        hz(self.omega.re)
    }

    /// Damping ratio omega_i / |omega| \[-\].
    pub fn zeta(&self) -> f64 {
        self.omega.im / self.omega.norm()
    }
}

/// Resonances of modes in a fluid below `highest` \[rad/s\], one for each mode, sorted by their frequency with only the
/// fluid's mass. `None` if a mode is rigid, lies above `highest`, or is overdamped.
///
/// `impedance` gives Z at complex angular frequencies near the real axis up to `highest` (closed forms, or an
/// [`ImpedanceTable`](super::ImpedanceTable)). Each of the sorted undamped frequencies, which satisfy
///
/// ```text
/// det[Omega² - lambda (I + X(w)/w)] = 0,    w = sqrt(lambda_i)
/// ```
///
/// is found by fixed-point iteration of w. Newton's method on q^T T(omega) q, where T is the complete equation and q
/// comes from inverse iteration, then yields the damped frequency (T is symmetric, hence third-order convergence).
///
/// # Errors
/// If lengths are inconsistent; [`FluidLoadingError::Mass`].
pub fn resonances(
    modes: &DryModes,
    highest: f64,
    impedance: impl Fn(Complex<f64>) -> DMatrix<Complex<f64>>,
) -> Result<Vec<Option<Resonance>>, FluidLoadingError> {
    (0..modes.count())
        .map(|index| {
            let Some((omega, shape)) = undamped(modes, &impedance, (index, highest))? else {
                return Ok(None);
            };
            damped(modes, &impedance, omega, shape)
        })
        .collect()
}

/// The undamped resonance with the given index in ascending order.
fn undamped(
    modes: &DryModes,
    impedance: &impl Fn(Complex<f64>) -> DMatrix<Complex<f64>>,
    (index, highest): (usize, f64),
) -> Result<Option<(f64, DVector<f64>)>, FluidLoadingError> {
    let mut rising = modes.omega().to_vec();
    rising.sort_by(f64::total_cmp);
    let mut omega = rising[index].min(highest);
    if omega == 0.0 {
        return Ok(None);
    }
    let mut shape = DVector::zeros(modes.count());
    for _ in 0..MOST {
        let mass = impedance(Complex::from(omega)).map(|z| z.im / omega);
        let (all, shapes) = modes.with_mass(&mass, hz(omega))?;
        if all[index] == 0.0 || (omega == highest && all[index] > highest) {
            return Ok(None);
        }
        let next = all[index].min(highest);
        let change = next - omega;
        shape.copy_from(&shapes.column(index));
        omega = next;
        if change.abs() <= 1e-8 * omega {
            break;
        }
    }
    Ok(Some((omega, shape)))
}

/// Newton's method from the undamped resonance; none if it does not converge to an oscillation.
fn damped(
    modes: &DryModes,
    impedance: &impl Fn(Complex<f64>) -> DMatrix<Complex<f64>>,
    from: f64,
    shape: DVector<f64>,
) -> Result<Option<Resonance>, FluidLoadingError> {
    let mut omega = Complex::from(from);
    let mut q = shape.map(Complex::from).normalize();
    for _ in 0..MOST {
        let step = Complex::from(1e-5 * omega.norm());
        let at = |omega| modes.dynamic_stiffness(omega, &impedance(omega));
        let stiffness = at(omega)?;
        let slope = (at(omega + step)? - at(omega - step)?) / (step * 2.0);
        let moved = &slope * &q;
        let Some(next) = stiffness.clone().lu().solve(&moved) else {
            return Ok(Some(Resonance { omega, shape: q }));
        };
        q = next.normalize();
        let dot = |x: &DVector<Complex<f64>>| q.iter().zip(x.iter()).map(|(a, b)| a * b).sum::<Complex<f64>>();
        let change = dot(&(&stiffness * &q)) / dot(&(&slope * &q));
        omega -= change;
        if !omega.is_finite() || omega.re <= 0.0 || omega.norm() > 10.0 * from {
            return Ok(None);
        }
        if change.norm() <= TOLERANCE * omega.norm() {
            return Ok(Some(Resonance { omega, shape: q }));
        }
    }
    Ok(None)
}

//! Corrects a linear motion from the frozen to the full radiation impedance.

use super::damped_transform::DampedTransform;
use super::error::FluidLoadingError;
use super::gmres;
use super::impedance::Impedance;
use crate::checks::{InputError, same_length};
use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix, DVector, Dyn, LU};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Width in octaves, below the highest frequency of the impedance, of the transition to the frozen impedance.
const ROLL_OFF: f64 = 1.0 / 3.0;

/// Tolerance on the residual of the equations at each frequency, relative to the right-hand side.
const TOLERANCE: f64 = 1e-9;

/// Number of lines solved together, which limits the size of their Krylov subspaces.
const LINES: usize = 64;

/// A structure on linear supports, in the coordinates u of its motion with frozen impedance.
///
/// ```text
/// u'' + diag(2 zeta w) u' + diag(w²) u + P (k P^T u + c P^T u') = f
/// ```
///
/// Modes in vacuum are obtained as q = S u.
#[derive(Debug, Clone)]
pub struct FrozenModes {
    /// Angular frequencies w \[rad/s\].
    pub omega: Vec<f64>,
    /// 2 zeta w of structure and frozen radiation \[1/s\].
    pub damping: Vec<f64>,
    /// Additional damping from the time integration \[1/s\]: zero except for modes that its step cannot resolve.
    pub numerical_damping: Vec<f64>,
    /// S, modes in vacuum x coordinates.
    pub coordinates: DMatrix<f64>,
    /// Damping of the structure in its modes in vacuum, 2 zeta Omega \[1/s\].
    pub structure: Vec<f64>,
    /// Added mass M of the modes in vacuum that the coordinates contain \[-\].
    pub mass: DMatrix<f64>,
    /// P, coordinates x supports \[1/sqrt(kg)\].
    pub supports: DMatrix<f64>,
    /// k \[N/m\].
    pub stiffness: Vec<f64>,
    /// c \[N s/m\].
    pub dashpots: Vec<f64>,
}

/// The difference between the motion with the full impedance and that with the frozen one.
pub struct ImpedanceCorrection {
    /// The transform of its lines.
    pub transform: DampedTransform,
    /// Lines of the added motion d, coordinates x lines.
    pub motion: DMatrix<Complex<f64>>,
    /// Lines of the force D (u + d) that the full impedance exerts on the coordinates beyond the frozen one,
    /// coordinates x lines.
    pub reaction: DMatrix<Complex<f64>>,
    /// Largest number of products with the impedance at any frequency.
    pub products: usize,
    /// Largest residual of the equations of motion over all lines, relative to the largest force D u \[-\].
    pub residual: f64,
}

/// Computes the difference that the full impedance makes to a motion u(t) with the frozen one.
///
/// At s = sigma + j omega, A is the dynamic stiffness of [`FrozenModes`].
///
/// ```text
/// [A(s) + D(s)] d = -D(s) u        D = W [S^T (s Z - s² M) S + s (S^T C S - diag(2 zeta w))]
/// ```
///
/// This is exact for linear motion. The sum u + d satisfies the equation with the full matrix Z at every frequency, R
/// and X, instead of the frozen one. Forces and initial conditions need not be known. Z/s is smooth and finite down to
/// zero, and is evaluated on the real axis:
///
/// ```text
/// Z(s)/s ~ (1-j)/2 G(omega + sigma) + (1+j)/2 G(omega - sigma)        G(omega) = Z(j omega)/(j omega)
/// ```
///
/// The error is sigma² G'', a fraction of about (sigma a/c)² for a body of size a. W decreases from 1 to 0 over the
/// uppermost third of an octave for which Z is known; above, the frozen impedance is used. `motion` contains the
/// records of a range of coordinates, samples x coordinates, at intervals of `step` \[s\].
///
/// # Errors
/// If lengths are inconsistent; errors of `motion`; [`FluidLoadingError::Iteration`].
pub fn impedance_correction<E: From<FluidLoadingError>>(
    modes: &FrozenModes,
    impedance: &dyn Impedance,
    (samples, step): (usize, f64),
    mut motion: impl FnMut(std::ops::Range<usize>) -> Result<DMatrix<f64>, E>,
) -> Result<ImpedanceCorrection, E> {
    let operator = Operator::new(modes, impedance, (samples, step))?;
    let transform = operator.transform.clone();
    let (n, bins) = (modes.omega.len(), transform.bins());
    let mut u = DMatrix::zeros(n, bins);
    for first in (0..n).step_by(LINES) {
        let range = first..n.min(first + LINES);
        let records = motion(range.clone())?;
        same_length("samples of the motion", records.nrows(), samples).map_err(FluidLoadingError::from)?;
        u.rows_mut(first, range.len()).copy_from(&transform.lines(&records));
    }
    let first: Vec<usize> = (0..bins).step_by(LINES).collect();
    let parts: Vec<Result<Part, FluidLoadingError>> = first
        .par_iter()
        .map(|&first| operator.solve(first, &u.columns(first, LINES.min(bins - first)).into_owned()))
        .collect();
    let mut all = ImpedanceCorrection {
        transform,
        motion: DMatrix::zeros(n, bins),
        reaction: DMatrix::zeros(n, bins),
        products: 0,
        residual: 0.0,
    };
    let mut largest: f64 = f64::MIN_POSITIVE;
    for (part, first) in parts.into_iter().zip(first) {
        let part = part?;
        all.motion
            .columns_mut(first, part.motion.ncols())
            .copy_from(&part.motion);
        all.reaction
            .columns_mut(first, part.motion.ncols())
            .copy_from(&part.reaction);
        all.products = all.products.max(part.products);
        all.residual = all.residual.max(part.residual);
        largest = largest.max(part.largest);
    }
    all.residual /= largest;
    Ok(all)
}

/// Some lines of a correction.
struct Part {
    motion: DMatrix<Complex<f64>>,
    reaction: DMatrix<Complex<f64>>,
    products: usize,
    /// Largest residual and largest right-hand side of a line.
    residual: f64,
    largest: f64,
}

/// A and D at all lines.
struct Operator<'a> {
    modes: &'a FrozenModes,
    impedance: &'a dyn Impedance,
    transform: DampedTransform,
    /// S^T M S, and S^T C S - diag(2 zeta w).
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    transposed: DMatrix<f64>,
    /// Supports in contact.
    acting: Vec<usize>,
    /// The columns of P for those.
    supports: DMatrix<f64>,
    roll_off: [f64; 2],
}

impl<'a> Operator<'a> {
    fn new(
        modes: &'a FrozenModes,
        impedance: &'a dyn Impedance,
        (samples, step): (usize, f64),
    ) -> Result<Self, FluidLoadingError> {
        modes.check(impedance)?;
        let top = impedance.top_hz().min(0.5 / step);
        let s = &modes.coordinates;
        let transposed = s.transpose();
        let structure = DMatrix::from_fn(s.nrows(), s.ncols(), |i, j| modes.structure[i] * s[(i, j)]);
        let mut damping = &transposed * structure;
        for (j, frozen) in modes.damping.iter().enumerate() {
            damping[(j, j)] -= frozen;
        }
        let acting = (0..modes.stiffness.len()).filter(|&i| modes.stiffness[i] > 0.0 || modes.dashpots[i] > 0.0);
        let acting: Vec<usize> = acting.collect();
        Ok(Self {
            modes,
            impedance,
            transform: DampedTransform::new(samples, step, top)?,
            mass: &transposed * (&modes.mass * s),
            damping,
            transposed,
            supports: modes.supports.select_columns(&acting),
            acting,
            roll_off: [top * 2f64.powf(-ROLL_OFF), top],
        })
    }

    /// Solves the lines from `first` on for their motions u.
    fn solve(&self, first: usize, u: &DMatrix<Complex<f64>>) -> Result<Part, FluidLoadingError> {
        let lines: Vec<usize> = (first..first + u.ncols()).collect();
        let mut stiffnesses = Vec::with_capacity(lines.len());
        for &line in &lines {
            stiffnesses.push(self.stiffness(line)?);
        }
        let sides = -self.reaction(&lines, u);
        // With y = A d:  [1 + D A^-1] y = -D u.
        let by_stiffness = |columns: &[usize], y: &DMatrix<Complex<f64>>| {
            let mut d = y.clone();
            for (mut d, &column) in d.column_iter_mut().zip(columns) {
                let solved = stiffnesses[column].solve(&d.clone_owned(), &self.supports);
                d.copy_from(&solved);
            }
            d
        };
        let solved = gmres::solve(&sides, TOLERANCE, |columns, y| {
            let of: Vec<usize> = columns.iter().map(|&column| lines[column]).collect();
            y + self.reaction(&of, &by_stiffness(columns, y))
        });
        if let Some((column, residual)) = solved.failed {
            return Err(FluidLoadingError::Iteration {
                hz: self.transform.hz(lines[column]),
                residual,
            });
        }
        let all: Vec<usize> = (0..lines.len()).collect();
        let motion = by_stiffness(&all, &solved.solutions);
        let reaction = self.reaction(&lines, &(u + &motion));
        let mut residual: f64 = 0.0;
        for (column, stiffness) in stiffnesses.iter().enumerate() {
            let d = motion.column(column).into_owned();
            let left = stiffness.product(&d, &self.supports) + reaction.column(column);
            residual = residual.max(left.norm());
        }
        Ok(Part {
            motion,
            reaction,
            products: solved.products,
            residual,
            largest: sides.column_iter().map(|side| side.norm()).fold(0.0, f64::max),
        })
    }

    /// D v for lines, one column each.
    fn reaction(&self, lines: &[usize], v: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let s: Vec<Complex<f64>> = lines.iter().map(|&line| self.transform.s(line)).collect();
        let times = |x: &DMatrix<Complex<f64>>, factor: &dyn Fn(usize) -> Complex<f64>| {
            let mut scaled = x.clone();
            for (k, mut column) in scaled.column_iter_mut().enumerate() {
                column *= factor(k);
            }
            scaled
        };
        let acceleration = real_product(&self.modes.coordinates, &times(v, &|k| s[k] * s[k]));
        let force = self.by_impedance(lines, &acceleration);
        let mut reaction = real_product(&self.transposed, &force);
        reaction -= real_product(&self.mass, &times(v, &|k| s[k] * s[k]));
        reaction += real_product(&self.damping, &times(v, &|k| s[k]));
        times(&reaction, &|k| Complex::from(self.weight(self.transform.hz(lines[k]))))
    }

    /// Z(s)/s a for accelerations of the modes in vacuum.
    fn by_impedance(&self, lines: &[usize], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut sum = DMatrix::zeros(accelerations.nrows(), lines.len());
        for (shift, weight) in [(1.0, Complex::new(0.5, -0.5)), (-1.0, Complex::new(0.5, 0.5))] {
            let omega = |&line: &usize| self.transform.s(line).im + shift * self.transform.sigma();
            let omega: Vec<f64> = lines.iter().map(omega).collect();
            let hz: Vec<f64> = omega.iter().map(|omega| omega.abs() / TAU).collect();
            // G(-omega) a is the conjugate of G(omega) a*.
            let turned = |mut x: DMatrix<Complex<f64>>| {
                for (mut column, _) in x.column_iter_mut().zip(&omega).filter(|(_, omega)| **omega < 0.0) {
                    column.iter_mut().for_each(|x| *x = x.conj());
                }
                x
            };
            let mut velocities = turned(accelerations.clone());
            for (mut column, omega) in velocities.column_iter_mut().zip(&omega) {
                column /= Complex::new(0.0, omega.abs());
            }
            sum += turned(self.impedance.product(&hz, &velocities)) * weight;
        }
        sum
    }

    /// W at a frequency.
    fn weight(&self, hz: f64) -> f64 {
        let [from, to] = self.roll_off;
        let beyond = ((hz - from) / (to - from)).clamp(0.0, 1.0);
        (0.5 * PI * beyond).cos().powi(2)
    }

    /// A for one line, prepared for solving.
    fn stiffness(&self, line: usize) -> Result<Stiffness, FluidLoadingError> {
        let s = self.transform.s(line);
        let modes = self.modes;
        let diagonal: Vec<Complex<f64>> = (0..modes.omega.len())
            .map(|j| s * s + s * (modes.damping[j] + modes.numerical_damping[j]) + modes.omega[j] * modes.omega[j])
            .collect();
        let springs: Vec<Complex<f64>> = self
            .acting
            .iter()
            .map(|&i| modes.stiffness[i] + s * modes.dashpots[i])
            .collect();
        // I + K P^T A0^-1 P.
        let m = springs.len();
        let part = |of: &dyn Fn(Complex<f64>) -> f64| {
            let scaled = DMatrix::from_fn(self.supports.nrows(), m, |i, k| {
                of(diagonal[i].inv()) * self.supports[(i, k)]
            });
            self.supports.transpose() * scaled
        };
        let (re, im) = (part(&|x| x.re), part(&|x| x.im));
        let capacitance = DMatrix::from_fn(m, m, |i, k| {
            let own = if i == k { 1.0 } else { 0.0 };
            own + springs[i] * Complex::new(re[(i, k)], im[(i, k)])
        });
        let capacitance = capacitance.lu();
        if m > 0 && !capacitance.is_invertible() {
            return Err(FluidLoadingError::Singular {
                hz: self.transform.hz(line),
            });
        }
        Ok(Stiffness {
            diagonal,
            springs,
            capacitance,
        })
    }
}

impl FrozenModes {
    fn check(&self, impedance: &dyn Impedance) -> Result<(), InputError> {
        let (own, dry) = (self.omega.len(), impedance.modes());
        same_length("damping of the coordinates", self.damping.len(), own)?;
        same_length(
            "numerical damping of the coordinates",
            self.numerical_damping.len(),
            own,
        )?;
        same_length("columns of the coordinates", self.coordinates.ncols(), own)?;
        same_length("rows of the coordinates", self.coordinates.nrows(), dry)?;
        same_length("damping of the modes", self.structure.len(), dry)?;
        same_length("rows of the added mass", self.mass.nrows(), dry)?;
        same_length("columns of the added mass", self.mass.ncols(), dry)?;
        same_length("rows of the supports", self.supports.nrows(), own)?;
        same_length(
            "stiffnesses of the supports",
            self.stiffness.len(),
            self.supports.ncols(),
        )?;
        same_length("dashpots of the supports", self.dashpots.len(), self.supports.ncols())
    }
}

/// A = A0 + P K P^T with A0 diagonal, inverted by the Woodbury formula.
struct Stiffness {
    /// A0.
    diagonal: Vec<Complex<f64>>,
    /// K.
    springs: Vec<Complex<f64>>,
    /// I + K P^T A0^-1 P.
    capacitance: LU<Complex<f64>, Dyn, Dyn>,
}

impl Stiffness {
    /// A^-1 b.
    fn solve(&self, b: &DVector<Complex<f64>>, supports: &DMatrix<f64>) -> DVector<Complex<f64>> {
        let free = DVector::from_fn(b.len(), |i, _| b[i] / self.diagonal[i]);
        if self.springs.is_empty() {
            return free;
        }
        let mut forces = self.forces(&free, supports);
        self.capacitance.solve_mut(&mut forces);
        let held = along(supports, &forces);
        DVector::from_fn(b.len(), |i, _| free[i] - held[i] / self.diagonal[i])
    }

    /// A d.
    fn product(&self, d: &DVector<Complex<f64>>, supports: &DMatrix<f64>) -> DVector<Complex<f64>> {
        let held = along(supports, &self.forces(d, supports));
        DVector::from_fn(d.len(), |i, _| self.diagonal[i] * d[i] + held[i])
    }

    /// K P^T d.
    fn forces(&self, d: &DVector<Complex<f64>>, supports: &DMatrix<f64>) -> DVector<Complex<f64>> {
        let [re, im] = [d.map(|d| d.re), d.map(|d| d.im)].map(|part| supports.tr_mul(&part));
        DVector::from_fn(self.springs.len(), |i, _| self.springs[i] * Complex::new(re[i], im[i]))
    }
}

/// P f.
fn along(supports: &DMatrix<f64>, forces: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let [re, im] = [forces.map(|f| f.re), forces.map(|f| f.im)].map(|part| supports * part);
    re.zip_map(&im, Complex::new)
}

#[cfg(test)]
mod tests;

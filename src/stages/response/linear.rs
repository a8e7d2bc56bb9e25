//! Linear motion with the complete radiation impedance of the air.
//!
//! A time-domain response uses the impedance frozen at each mode's resonance, because its contact may open. If nothing
//! opens, the effect of R and X at every frequency is computed in the frequency domain
//! ([`impedance_correction`](nailnoise_acoustics::radiation::fluid_loading::impedance_correction)) and added.

use std::ops::Range;
use std::sync::Arc;

use nailnoise_acoustics::AcousticsError;
use nailnoise_acoustics::radiation::fluid_loading::{
    FluidLoadingError, FrozenModes, ImpedanceCorrection, WetModes, impedance_correction,
};
use nailnoise_acoustics::radiation::radiator::{FluidLoads, Radiator};
use nailnoise_fem::vibration::{AddedMotion, ModalResponse, Motion, Support};
use nalgebra::DMatrix;
use serde::Serialize;

use super::{CODE, Vibration};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::Body;
use crate::stages::{Code, Progress, Stage, Stored, Uncached, all};

/// Number of modes whose records are in memory together.
const BLOCK: usize = 32;

/// Largest residual of the equations of motion in the frequency lines of the correction, relative to the largest force.
const RESIDUAL_LIMIT: f64 = 1e-6;

/// Largest energy imbalance over time, relative to the energy exchanged between structure and air beyond the frozen
/// impedance: a hundredth of a change of some tenths of a decibel.
const ENERGY_LIMIT: f64 = 0.01;

/// A linear response with the complete impedance instead of the frozen one.
#[derive(Serialize)]
#[serde(bound = "R: Send + Sync + 'static")]
pub struct LinearResponse<R> {
    /// The response with the impedance frozen.
    pub frozen: Stored<Vibration>,
    /// The radiator.
    pub radiator: Stored<R>,
    /// The bodies.
    pub bodies: Vec<Stored<Body>>,
    /// Loss factor of the modes of each \[-\].
    pub loss_factors: Vec<f64>,
    /// Fluid loads of the air on the modes of each.
    pub fluid: Stored<Vec<FluidLoads>>,
    /// Springs and dashpots, which never open.
    pub supports: Vec<Support>,
    /// Whether a guide restricts the rigid-body motion to translation along its axis.
    pub guided: bool,
}

impl<R: Radiator + 'static> Stage for LinearResponse<R> {
    type Output = Vibration;
    type Error = Error;
    /// An intermediate result of stored outputs.
    type Codec = Uncached;
    const NAME: &'static str = "response with the complete impedance of the air";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Vibration, Error> {
        let (vibration, radiator) = (self.frozen.get()?, self.radiator.get()?);
        let (bodies, fluid) = (all(&self.bodies)?, self.fluid.get()?);
        let response = &vibration.response;
        let wet: Option<Vec<&WetModes>> = fluid.iter().map(|loads| loads.wet.as_ref()).collect();
        let (Some(impedance), Some(wet)) = (radiator.impedance(), wet) else {
            let method = "this method of radiation";
            return Err(AcousticsError::from(FluidLoadingError::NoReactance { method }).into());
        };
        let modes = self.modes(response, &bodies, &wet)?;
        let places = places(response);
        let motion = |range: Range<usize>| motion_of(response, &places, range);
        let correction = impedance_correction(&modes, impedance, (response.samples(), response.step), motion)?;
        let [added, reaction] = [&correction.motion, &correction.reaction].map(|lines| {
            let of_body = |range: &Range<usize>| lines.rows(range.start, range.len()).into_owned();
            let (length, sigma) = (correction.transform.length(), correction.transform.sigma());
            AddedMotion::new(places.iter().map(of_body).collect(), response.step, length, sigma)
        });
        let name = if self.guided { "tool" } else { "response" };
        let mut checks = vibration.checks.clone();
        checks.push(residual(&correction).of(name));
        let balance = self.balance(response, &added, &reaction)?;
        checks.push(
            Check::at_most(
                "energy beyond the frozen impedance, balance over time",
                balance,
                ENERGY_LIMIT,
            )
            .of(name),
        );
        Ok(Vibration {
            response: Arc::new(response.with_added(added)?),
            coordinates: vibration.coordinates.clone(),
            checks,
        })
    }
}

fn residual(correction: &ImpedanceCorrection) -> Check {
    Check::at_most(
        "equations of motion with the complete impedance, residual",
        correction.residual,
        RESIDUAL_LIMIT,
    )
}

/// Range of each body's coordinates among all coordinates.
fn places(response: &ModalResponse) -> Vec<Range<usize>> {
    let mut first = 0;
    let place = |modes: usize| {
        first += modes;
        first - modes..first
    };
    response.bodies().iter().map(|body| body.modes()).map(place).collect()
}

/// Displacements of a range of the coordinates of all bodies, samples x coordinates.
fn motion_of(response: &ModalResponse, places: &[Range<usize>], range: Range<usize>) -> Result<DMatrix<f64>, Error> {
    let mut records = DMatrix::zeros(response.samples(), range.len());
    for (body, place) in places.iter().enumerate() {
        let (from, to) = (range.start.max(place.start), range.end.min(place.end));
        if from < to {
            let own = response.modal(body, from - place.start..to - place.start, Motion::Displacement)?;
            records.columns_mut(from - range.start, to - from).copy_from(&own);
        }
    }
    Ok(records)
}

impl<R: Radiator + 'static> LinearResponse<R> {
    /// The modes of all bodies, with their motion.
    fn modes(&self, response: &ModalResponse, bodies: &[Arc<Body>], wet: &[&WetModes]) -> Result<FrozenModes, Error> {
        let own: usize = response.bodies().iter().map(|body| body.modes()).sum();
        let dry: usize = bodies.iter().map(|body| body.omega.len()).sum();
        let mut modes = FrozenModes {
            omega: Vec::new(),
            damping: Vec::new(),
            numerical_damping: Vec::new(),
            coordinates: DMatrix::zeros(dry, own),
            structure: Vec::new(),
            mass: DMatrix::zeros(dry, dry),
            supports: DMatrix::zeros(own, self.supports.len()),
            stiffness: self.supports.iter().map(|support| support.stiffness).collect(),
            dashpots: self.supports.iter().map(|support| support.damping).collect(),
        };
        for (index, (body, wet)) in bodies.iter().zip(wet).enumerate() {
            let moving = &response.bodies()[index];
            let (row, column, n) = (modes.structure.len(), modes.omega.len(), body.omega.len());
            let shapes = if self.guided {
                guide(body) * &wet.shapes
            } else {
                wet.shapes.clone()
            };
            modes
                .coordinates
                .view_mut((row, column), shapes.shape())
                .copy_from(&shapes);
            modes.mass.view_mut((row, row), (n, n)).copy_from(&wet.mass);
            let supports = &moving.supports;
            modes
                .supports
                .view_mut((column, 0), supports.shape())
                .copy_from(supports);
            modes
                .structure
                .extend(body.omega.iter().map(|omega| self.loss_factors[index] * omega));
            let used = response.damping_ratios(index)?;
            for ((omega, zeta), used) in moving.omega.iter().zip(&moving.zeta).zip(used) {
                modes.omega.push(*omega);
                modes.damping.push(2.0 * zeta * omega);
                modes.numerical_damping.push(2.0 * (used - zeta) * omega);
            }
        }
        Ok(modes)
    }

    /// Energy missing from the balance over time, relative to the energy exchanged with the air beyond the frozen
    /// impedance.
    ///
    /// Let u and f_0 be the motion and the support forces of the frozen response, which has a separate balance. Let d
    /// be the added motion, x = P^T d, f_x = k x + c x', and r the force of the air beyond the frozen one. The
    /// difference of the two balances is
    ///
    /// ```text
    /// int F . d'  =  change of energy in modes and air + int 2 zeta w (2 u' d' + d'²)
    ///                + int [f_0 x' + f_x (P^T u' + x')] + int r (u' + d')
    /// ```
    fn balance(&self, response: &ModalResponse, added: &AddedMotion, air: &AddedMotion) -> Result<f64, Error> {
        let samples = response.samples();
        let last = samples - 1;
        let integral = |of: &dyn Fn(usize) -> f64| {
            let inner: f64 = (1..last).map(of).sum();
            response.step * (inner + 0.5 * (of(0) + of(last)))
        };
        let (mut open, mut exchanged) = (0.0, 0.0);
        let holders = self.supports.len();
        let [mut before, mut x, mut rate] = [0, 1, 2].map(|_| DMatrix::<f64>::zeros(samples, holders));
        for (index, body) in response.bodies().iter().enumerate() {
            let used = response.damping_ratios(index)?;
            for first in (0..body.modes()).step_by(BLOCK) {
                let range = first..body.modes().min(first + BLOCK);
                let [v, q] =
                    [Motion::Velocity, Motion::Displacement].map(|motion| response.modal(index, range.clone(), motion));
                let (v, q) = (v?, q?);
                let d = added.records(index, range.clone(), samples, Motion::Displacement);
                let d_rate = added.records(index, range.clone(), samples, Motion::Velocity);
                let r = air.records(index, range.clone(), samples, Motion::Displacement);
                for (k, mode) in range.enumerate() {
                    let (omega, damping) = (body.omega[mode], 2.0 * used[mode] * body.omega[mode]);
                    let energy = |n: usize| {
                        let kinetic = d_rate[(n, k)] * (2.0 * v[(n, k)] + d_rate[(n, k)]);
                        0.5 * (kinetic + omega * omega * d[(n, k)] * (2.0 * q[(n, k)] + d[(n, k)]))
                    };
                    let power = |n: usize| r[(n, k)] * (v[(n, k)] + d_rate[(n, k)]);
                    open += energy(last) - energy(0) + integral(&power);
                    open += integral(&|n| damping * d_rate[(n, k)] * (2.0 * v[(n, k)] + d_rate[(n, k)]));
                    exchanged += integral(&|n| power(n).abs());
                }
            }
            let of_loads = added.of_points(index, &body.loads, samples, Motion::Velocity);
            for load in (0..body.loads.ncols()).filter(|&load| body.loads.column(load).iter().any(|p| *p != 0.0)) {
                open -= integral(&|n| response.loads[(load, n)] * of_loads[(n, load)]);
            }
            if holders > 0 {
                before += response.points(index, &body.supports, Motion::Velocity)?;
                x += added.of_points(index, &body.supports, samples, Motion::Displacement);
                rate += added.of_points(index, &body.supports, samples, Motion::Velocity);
            }
        }
        for (i, support) in self.supports.iter().enumerate() {
            open += integral(&|n| {
                let force = support.stiffness * x[(n, i)] + support.damping * rate[(n, i)];
                response.contact_forces[(i, n)] * rate[(n, i)] + force * (before[(n, i)] + rate[(n, i)])
            });
        }
        Ok(if exchanged == 0.0 { 0.0 } else { open.abs() / exchanged })
    }
}

/// Removes all rigid-body motions except translation along the axis, as the guide of the body does.
fn guide(body: &Body) -> DMatrix<f64> {
    let n = body.omega.len();
    let rigid = |j: usize| body.omega[j] == 0.0;
    let descent: f64 = (0..n).filter(|&j| rigid(j)).map(|j| body.lift[j] * body.lift[j]).sum();
    DMatrix::from_fn(n, n, |i, j| match (rigid(i), rigid(j)) {
        (true, true) => body.lift[i] * body.lift[j] / descent,
        (false, false) if i == j => 1.0,
        _ => 0.0,
    })
}

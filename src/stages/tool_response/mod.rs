//! Response of the tool's elastic housing to the forces of the cycle.
//!
//! In the cycle, hand and guide restrict the tool to motion along its axis, and the same applies to the rigid-body
//! motion here. The reactions that prevent rotation are assumed to be distributed like the inertia of the body, so that
//! they cause no bending. The elastic modes are those of the free body.
//!
//! Forces come from the cycle with their lumped contact stiffnesses, which represent the compliance of cap and
//! cylinder. The body deforms under these forces. This deformation does not change the forces, and no contact spring is
//! added between cycle and body, so that the compliance is counted once. The notes of a run state both the body's own
//! stiffness and the lumped one.

mod forces;

use std::borrow::Cow;
use std::sync::Arc;

use nailnoise_acoustics::radiation::radiator::FluidLoads;
use nailnoise_fem::vibration::{Loads, ModalBody, ModalResponse, ModalState, Motion, Settings, Start, respond};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::response::{Vibration, in_air};
use super::{Code, Postcard, Progress, Stage, Stored, Uncached, code};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::Body;
use crate::stages::bodies::tool_loads::{AXIAL, HANDLE, LOADS, MASS_LIMIT, axial_index};
use crate::stages::cycle::ShotRecord;

/// Code that the stages of this module call.
const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    stages_bodies,
    stages_response,
    stages_tool_response,
    stages_cycle
);

/// Inputs of the response of the tool, without its body and the cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToolShot {
    /// Acceleration of gravity \[m/s2\].
    pub gravity: f64,
    /// Mass of the tool in the cycle \[kg\].
    pub mass: f64,
    /// Contacts of the cycle with the housing whose stiffness the body's is compared with.
    pub contacts: Vec<HousingContact>,
    /// Step \[s\].
    pub step: f64,
    /// Simulated time \[s\].
    pub duration: f64,
}

/// A lumped contact of the cycle with the housing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HousingContact {
    /// Surface of the housing.
    pub surface: String,
    /// Where, in words.
    pub place: String,
    /// Its stiffness \[N/m\].
    pub stiffness: f64,
}

/// Response of the tool's elastic body to a cycle.
#[derive(Serialize)]
pub struct ToolResponse {
    /// Forces and duration.
    pub shot: ToolShot,
    /// The body.
    pub body: Stored<Body>,
    /// Its loss factor \[-\].
    pub loss_factor: f64,
    /// Fluid loads of the air on its modes, if the air acts on them.
    pub fluid: Option<Stored<Vec<FluidLoads>>>,
    /// The cycle.
    pub cycle: Stored<ShotRecord>,
}

impl Stage for ToolResponse {
    type Output = Vibration;
    type Error = Error;
    /// An intermediate result of stored outputs.
    type Codec = Uncached;
    const NAME: &'static str = "response of the tool";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Vibration, Error> {
        let (body, record) = (self.body.get()?, self.cycle.get()?);
        let fluid = self.fluid.as_ref().map(Stored::get).transpose()?;
        let fluid = fluid.as_deref().and_then(|loads| loads.first());
        self.shot.response(&body, self.loss_factor, fluid, &record)
    }
}

/// Checks of the tool's body and of its response, and the body's stiffness.
#[derive(Serialize)]
pub struct ToolReport {
    /// Forces and duration.
    pub shot: ToolShot,
    /// The body.
    pub body: Stored<Body>,
    /// Its response.
    pub vibration: Stored<Vibration>,
}

/// Output of [`ToolReport`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToolChecks {
    /// Checks of modes and response.
    pub checks: Vec<Check>,
    /// Stiffness of the body at the cycle's contacts, and theirs.
    pub stiffness: Vec<Stiffness>,
}

impl Stage for ToolReport {
    type Output = ToolChecks;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "checks of the tool";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ToolChecks, Error> {
        let body = self.body.get()?;
        let mut checks = body.checks();
        checks.extend(self.vibration.get()?.checks.iter().cloned());
        Ok(ToolChecks {
            checks,
            stiffness: self.shot.stiffness(&body),
        })
    }
}

/// Stiffness of the tool's body at a contact of the cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// Place of the contact.
    pub place: Cow<'static, str>,
    /// Ratio of static force to mean displacement there, of the free body relative to its rigid-body motion \[N/m\].
    pub body: f64,
    /// Stiffness of the contact in the cycle \[N/m\].
    pub contact: f64,
}

/// Largest difference between the sum of all forces and that in the cycle's equation of motion, relative to its
/// maximum.
const FORCE_LIMIT: f64 = 1e-9;

/// Largest axial force due to pressure on closed walls, relative to the largest sum of all forces; it results from the
/// approximation of cylinders by the mesh.
const STRAY_LIMIT: f64 = 1e-4;

/// Largest difference between the velocities of body and cycle, relative to the maximum; it results from forces of
/// piston, nose and hand that jump between two samples.
const VELOCITY_LIMIT: f64 = 5e-3;

impl ToolShot {
    /// The response of the tool's body to a cycle, in air if its fluid loads are given.
    ///
    /// # Errors
    /// The errors of the transient solver, and [`MeshError`](nailnoise_meshes::MeshError) for a body without a bore.
    fn response(
        &self,
        body: &Body,
        loss_factor: f64,
        fluid: Option<&FluidLoads>,
        record: &ShotRecord,
    ) -> Result<Vibration, Error> {
        let guided = Guided::new(body, self.gravity);
        let loads = loads(&guided, forces::histories(&body.mesh, record)?, record);
        let modal = ModalBody {
            name: body.name.to_owned(),
            omega: body.omega.clone(),
            zeta: vec![0.5 * loss_factor; body.omega.len()],
            loads: guided.loads.clone(),
            supports: DMatrix::zeros(body.omega.len(), 0),
        };
        let (modal, coordinates) = match fluid {
            Some(loads) => in_air(modal, loads),
            None => (modal, None),
        };
        let settings = Settings {
            step: self.step,
            duration: self.duration,
            decay: f64::INFINITY, // its flight does not decay
            start: Start::State(vec![rest(&modal, &loads)]),
            require_contact: false,
            ..Settings::default()
        };
        let response = respond(&[modal], &[], &loads, &settings)?;
        Ok(Vibration {
            checks: guided.checks(self.mass, record, &loads, (&response, coordinates.as_ref()))?,
            response: Arc::new(response),
            coordinates: vec![coordinates],
        })
    }

    /// Stiffness of the body at the cycle's contacts.
    fn stiffness(&self, body: &Body) -> Vec<Stiffness> {
        let guided = Guided::new(body, self.gravity);
        let stiffness = |contact: &HousingContact| {
            Some(Stiffness {
                place: contact.place.clone().into(),
                body: 1.0 / compliance(body, &guided.loads, axial_index(&contact.surface)?),
                contact: contact.stiffness,
            })
        };
        self.contacts.iter().filter_map(stiffness).collect()
    }
}

/// The body, guided along its axis.
struct Guided {
    /// Participation of all loads and of weight: modes x (loads + 1), downwards.
    loads: DMatrix<f64>,
    /// Modal coordinates of a unit downward displacement, zero for elastic modes \[kg^1/2\].
    descent: DVector<f64>,
    /// Its mass \[kg\].
    mass: f64,
    /// Axial force due to each pressure on walls before it is removed \[m2\].
    stray: Vec<f64>,
}

impl Guided {
    /// Keeps only axial translation of all rigid-body motions; a resultant force R accelerates the body by R/M, and
    /// pressures on closed walls have no resultant.
    fn new(body: &Body, gravity: f64) -> Self {
        let rigid: Vec<usize> = (0..body.omega.len()).filter(|&j| body.omega[j] == 0.0).collect();
        let mut descent = DVector::zeros(body.omega.len());
        rigid.iter().for_each(|&j| descent[j] = -body.lift[j]);
        let mass = descent.norm_squared();
        let mut loads = DMatrix::zeros(body.omega.len(), LOADS + 1);
        loads.columns_mut(0, LOADS).copy_from(&body.loads);
        loads.set_column(LOADS, &body.weight(gravity));
        let mut stray = Vec::new();
        for (load, mut column) in loads.column_iter_mut().enumerate() {
            let mut resultant = descent.dot(&column);
            if (AXIAL..LOADS).contains(&load) {
                stray.push(resultant);
                resultant = 0.0;
            }
            rigid.iter().for_each(|&j| column[j] = descent[j] * resultant / mass);
        }
        Self {
            loads,
            descent,
            mass,
            stray,
        }
    }

    /// Axial force of each load per unit.
    fn resultants(&self) -> DVector<f64> {
        self.loads.tr_mul(&self.descent)
    }

    fn checks(
        &self,
        mass: f64,
        record: &ShotRecord,
        loads: &Loads,
        (response, coordinates): (&ModalResponse, Option<&DMatrix<f64>>),
    ) -> Result<Vec<Check>, Error> {
        let still = crate::stages::cycle::Body::default();
        let tool = record.tool.as_ref().unwrap_or(&still);
        let largest = |values: &[f64]| values.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()));
        let force = mass * largest(&tool.acceleration);
        let sums = loads.history.tr_mul(&self.resultants());
        let mut corrections = vec![0.0; record.len()];
        for own in &record.impulse_corrections {
            corrections
                .iter_mut()
                .zip(&own.force)
                .for_each(|(sum, force)| *sum += force);
        }
        let gap = |((sum, beside), a): ((&f64, &f64), &f64)| (sum - beside - mass * a).abs();
        let sums = sums.iter().zip(&corrections).zip(&tool.acceleration);
        let off = sums.map(gap).fold(0.0, f64::max);
        let stray = |sample: usize| {
            let pressures = loads.history.column(sample);
            let left = |(k, area): (usize, &f64)| pressures[AXIAL + k] * area;
            self.stray.iter().enumerate().map(left).sum::<f64>().abs()
        };
        let stray = (0..record.len()).map(stray).fold(0.0, f64::max);
        let fall = DMatrix::from_column_slice(self.descent.len(), 1, self.descent.as_slice()) / self.mass;
        let fall = coordinates.map_or_else(|| fall.clone(), |coordinates| coordinates.tr_mul(&fall));
        let velocity = response.points(0, &fall, Motion::Velocity)?;
        // An impulse between two samples is spread over both, so that the velocity is smoothed over four.
        let smooth = |v: &[f64]| 0.25 * (v[0] + 2.0 * v[1] + v[2]);
        let drift = |(n, v): (usize, &[f64])| {
            let sample = ((n + 1) as f64 * record.sample_interval / response.step).round() as usize;
            velocity.get(sample).map_or(0.0, |found| (found - smooth(v)).abs())
        };
        let drift = tool.velocity.windows(3).enumerate().map(drift).fold(0.0, f64::max);
        let mut checks = vec![
            Check::at_most(
                "tool: relative difference between its mass and that in the cycle",
                (self.mass / mass - 1.0).abs(),
                MASS_LIMIT,
            ),
            Check::at_most(
                "tool: difference between its net force and that in the cycle, relative to the largest force",
                off / force,
                FORCE_LIMIT,
            ),
            Check::at_most(
                "tool: net gas force on closed walls, relative to the largest force",
                stray / force,
                STRAY_LIMIT,
            ),
            Check::at_most(
                "tool: difference between its velocity and that in the cycle, relative to the largest velocity",
                drift / largest(&tool.velocity),
                VELOCITY_LIMIT,
            ),
        ];
        checks.extend(super::response::checks("tool", response));
        Ok(checks)
    }
}

/// At rest, deformed statically by the initial loads.
fn rest(body: &ModalBody, loads: &Loads) -> ModalState {
    let force = &body.loads * loads.history.column(0);
    let mut state = ModalState::rest(body.modes());
    for (j, omega) in body.omega.iter().enumerate().filter(|(_, omega)| **omega > 0.0) {
        state.displacement[j] = force[j] / (omega * omega);
    }
    state
}

/// The loads of a shot. After the record, internal forces keep their values, and the hand balances the others: the tool
/// keeps floating; its landing is not part of the shot.
fn loads(guided: &Guided, histories: DMatrix<f64>, record: &ShotRecord) -> Loads {
    let mut history = DMatrix::from_element(LOADS + 1, record.len(), 1.0);
    history.rows_mut(0, LOADS).copy_from(&histories);
    let mut last = history.column(record.len() - 1).into_owned();
    last[HANDLE] -= guided.resultants().dot(&last);
    Loads {
        interval: record.sample_interval,
        history,
        final_values: last.as_slice().to_vec(),
    }
}

/// Mean displacement where a unit load acts, of the free body relative to its rigid-body motion \[m/N\]: the sum of
/// p_j^2/omega_j^2 over elastic modes, including static corrections.
fn compliance(body: &Body, loads: &DMatrix<f64>, load: usize) -> f64 {
    let term = |(p, omega): (&f64, &f64)| if *omega > 0.0 { (p / omega).powi(2) } else { 0.0 };
    loads.column(load).iter().zip(&body.omega).map(term).sum()
}

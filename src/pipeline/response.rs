//! The blow in wood and support: the cycle's forces drive the bodies, the block may lift off what it stands on.
//!
//! One way, the cycle has its own lumped workpiece, and its forces on the wood are applied to the block; both ways,
//! they run together (see [`super::coupling`]).

use nailnoise_dynamics::{CycleRecord, Parameters};
use nailnoise_fem::supports::{RectangularBase, Sand, contact_dashpot};
use nailnoise_fem::transient::{Loads, ModalBody, ModalResponse, Settings, Support, SupportLaw, respond};
use nalgebra::{DMatrix, DVector};

use super::Body;
use super::bodies::{Structure, WORKPIECE_LOADS, weight};
use super::coupling::{Coupled, couple};
use super::cycle_settings;
use super::starts::open_gaps;
use crate::design::inputs::bodies as inputs;
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::nail_load;

/// Forces of the shot on the workpiece, and gravity as the last load.
const LOADS: usize = WORKPIECE_LOADS + 1;

/// Computes cycle and response together, each acting on the other; damping by radiation as in [`response`].
///
/// # Errors
/// Those of the cycle, of the transient solver, and that they do not agree.
pub(super) fn coupled(
    design: &Design,
    structure: &Structure,
    radiation_damping: Option<&[Vec<f64>]>,
    parameters: &Parameters,
    start: u32,
) -> Result<Coupled, Error> {
    let bodies = modal_bodies(design, structure, radiation_damping)?;
    couple(
        parameters,
        design.wood.friction_share,
        &cycle_settings(design),
        &bodies,
        &supports(design, structure, start)?,
        &settings(design),
    )
}

/// Computes the response of workpiece and support to the forces of a cycle. `radiation_damping` is added to the damping
/// ratios, mode by mode and body by body.
///
/// # Errors
/// Those of the penetration law and of the transient solver.
pub(super) fn response(
    design: &Design,
    structure: &Structure,
    radiation_damping: Option<&[Vec<f64>]>,
    parameters: &Parameters,
    record: &CycleRecord,
    (force_scale, start): (f64, u32),
) -> Result<ModalResponse, Error> {
    let bodies = modal_bodies(design, structure, radiation_damping)?;
    let loads = loads(design, parameters, record, force_scale)?;
    Ok(respond(
        &bodies,
        &supports(design, structure, start)?,
        &loads,
        &settings(design),
    )?)
}

fn settings(design: &Design) -> Settings {
    Settings {
        step: design.analysis.time_step,
        duration: design.analysis.duration,
        ..Settings::default()
    }
}

/// All bodies, with the damping ratios that radiation adds.
fn modal_bodies(
    design: &Design,
    structure: &Structure,
    radiation_damping: Option<&[Vec<f64>]>,
) -> Result<Vec<ModalBody>, Error> {
    let of_body = |body: &Body| Ok::<_, Error>(modal_body(body, &weight(design, &structure.grid, body)?));
    let mut bodies: Vec<ModalBody> = structure.bodies().map(of_body).collect::<Result<_, _>>()?;
    for (body, added) in bodies.iter_mut().zip(radiation_damping.unwrap_or_default()) {
        body.zeta.iter_mut().zip(added).for_each(|(zeta, added)| *zeta += added);
    }
    Ok(bodies)
}

/// A body as the transient solver takes it. Loads of the shot act on the workpiece alone, gravity on every body.
fn modal_body(body: &Body, weight: &DVector<f64>) -> ModalBody {
    let modes = body.omega.len();
    let mut loads = DMatrix::zeros(modes, LOADS);
    loads.columns_mut(0, body.loads.ncols()).copy_from(&body.loads);
    loads.set_column(LOADS - 1, weight);
    ModalBody {
        name: body.name.to_owned(),
        omega: body.omega.clone(),
        zeta: vec![0.5 * body.loss_factor; modes],
        loads,
        supports: body.contacts.clone(),
    }
}

/// Springs and dashpots of the contact cells between the block and what it stands on, of the sand at its sides, and those
/// of the user to the ground.
fn supports(design: &Design, structure: &Structure, start: u32) -> Result<Vec<Support>, Error> {
    let mut supports = cells(design, structure)?;
    supports.extend(inputs::side_supports(design)?);
    supports.extend(inputs::spring_supports(design));
    open_gaps(&mut supports, start);
    Ok(supports)
}

/// The contact cells.
fn cells(design: &Design, structure: &Structure) -> Result<Vec<Support>, Error> {
    let (stiffness, dashpot, bonded) = match design.support.kind {
        SupportKind::Clamped | SupportKind::Springs => return Ok(Vec::new()),
        SupportKind::Worktable | SupportKind::Floor => {
            let c = &design.support.contact;
            let dashpot = contact_dashpot(c.stiffness_per_area, c.loss_ratio, c.loss_frequency);
            (c.stiffness_per_area, dashpot, c.bonded)
        }
        SupportKind::Sandbox => {
            let s = &design.support.sand;
            let sand = Sand::new(s.shear_modulus, s.density, s.poisson_ratio)?;
            let base = RectangularBase::new(design.workpiece.length, design.workpiece.width)?;
            (base.normal_bedding(&sand), sand.normal_dashpot(), s.bonded)
        }
    };
    let law = if bonded {
        SupportLaw::Bonded
    } else {
        SupportLaw::Unilateral
    };
    let cell = |&area: &f64| Support {
        stiffness: stiffness * area,
        damping: dashpot * area,
        gap: 0.0,
        law,
    };
    Ok(structure.grid.areas.iter().map(cell).collect())
}

/// Loads of the shot: the nail's stations, the nose with the guard spring, gravity.
///
/// After the record the tool is off the wood and the nail at rest: the forces of the shot go to zero, gravity stays.
fn loads(design: &Design, parameters: &Parameters, record: &CycleRecord, force_scale: f64) -> Result<Loads, Error> {
    let nail = nail_load::forces(parameters, design.wood.friction_share, record);
    let mut history = DMatrix::zeros(LOADS, record.len());
    history.rows_mut(0, nail_load::STATIONS).copy_from(&nail);
    for sample in 0..record.len() {
        history[(nail_load::STATIONS, sample)] = record.forces.nose[sample] + record.forces.guard[sample];
    }
    history *= force_scale;
    history.row_mut(LOADS - 1).fill(1.0);
    let mut final_values = DVector::zeros(LOADS);
    final_values[LOADS - 1] = 1.0;
    Ok(Loads {
        interval: record.sample_interval,
        history,
        final_values: final_values.as_slice().to_vec(),
    })
}

/// Checks of the response.
pub(super) fn checks(response: &ModalResponse) -> Vec<Check> {
    let check = |c: &nailnoise_fem::transient::Check| Check {
        name: format!("response: {}", c.name),
        value: c.value,
        limit: c.limit,
        ok: c.ok,
    };
    response.checks.iter().map(check).collect()
}

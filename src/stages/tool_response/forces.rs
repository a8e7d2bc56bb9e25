//! Forces and pressures on the tool's body at every sample of the cycle.
//!
//! Gas pressures p are gauge pressures. A uniform pressure exerts no net force on the cycle's rod, piston and head
//! valve, because A_1 = A_2 + A_r and A_h1 = A_h2 + A_h3, so that the ambient pressure cancels. Along the axis,
//! downwards,
//!
//! ```text
//! roof within the valve   - p_1 A_i + F_st                                    A_i = pi/4 D_i^2
//! roof above the valve    - p_h A_h1 + F_hc - F_s + F_fh + thrust
//! cylinder's rim          p_1 (A_i + A_h3 - A_1) + p_ext A_h2 + F_seat
//! floor of the cylinder   p_2 A_2 + F_b
//! cylinder's bore         F_fp, evenly
//! nose                    - F_n - F_e + F_mag
//! handle                  F_hm, evenly
//! ```
//!
//! and weight: their sum is the force on the tool in the cycle's equation of motion. Gas also presses on walls without
//! moving the tool: p_1 and p_2 on the bore on both sides of the piston, p_ext inside the handle and around the
//! cylinder above the check-ring holes, p_r around it below them, and the plenum's pressure in the cap.
//!
//! The head valve leaves a stiff cap or seat in less than a sampling interval. The impulse of the contact is therefore
//! computed from the valve's velocity, and the mean force around each sample replaces the sample
//! ([`impulse_correction`]).

use nailnoise_dynamics::{CycleRecord, Form, Geometry, Parameters, Volume};
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::DMatrix;

use crate::stages::bodies::tool_loads::{AXIAL, Axial, Bore, LOADS, PLENUM, RETURN, RINGS, SUPPLY};

/// Forces \[N\] and pressures \[Pa\] of all loads: loads x samples.
///
/// # Errors
/// [`MeshError::UnknownGroup`] for a mesh without a bore.
pub(super) fn histories(parameters: &Parameters, mesh: &Mesh, record: &CycleRecord) -> Result<DMatrix<f64>, MeshError> {
    let (p, g) = (parameters, Geometry::new(parameters));
    let bore = Bore::of(mesh)?;
    let within = 0.25 * std::f64::consts::PI * p.head_valve.inner_diameter.powi(2);
    // As published, nothing acts on the valve's underside: the ambient pressure on it is not balanced.
    let underside = match p.model.valve_underside {
        Form::Corrected => g.valve_cylinder_area,
        Form::Published => 0.0,
    };
    let ambient = p.ambient.pressure;
    let unbalanced = ambient * (g.valve_control_area - g.valve_supply_area - underside);
    let f = &record.forces;
    let impulse_correction = impulse_correction(parameters, record);
    let mut histories = DMatrix::zeros(LOADS, record.len());
    for (n, mut column) in histories.column_iter_mut().enumerate() {
        let over = |volume: &Volume| volume.pressure[n] - ambient;
        let (above, below) = (over(&record.above_piston), over(&record.below_piston));
        let (control, supply) = (over(&record.above_valve), over(&record.supply));
        let mut axial = |place: Axial, force: f64| column[place as usize] += force;
        axial(Axial::Roof, f.stopper[n] - above * within);
        axial(
            Axial::Cap,
            f.cap[n] - f.spring[n] + f.valve_friction[n] + f.thrust[n] - control * g.valve_control_area - unbalanced,
        );
        axial(
            Axial::Rim,
            f.seat[n] + above * (within + underside - g.piston_area) + supply * g.valve_supply_area,
        );
        axial(nearest_stop(parameters, record, n), impulse_correction[n]);
        axial(Axial::Floor, f.bumper[n] + below * g.ring_area);
        axial(Axial::Bore, f.piston_friction[n]);
        axial(Axial::Nose, f.magazine[n] - f.nose[n] - f.guard[n]);
        axial(Axial::Handle, f.hand[n]);
        for ring in 0..RINGS {
            let share = bore.above(ring, record.motion.piston_travel[n]);
            column[AXIAL + ring] = share * above + (1.0 - share) * below;
        }
        column[SUPPLY] = supply;
        column[RETURN] = over(&record.return_volume);
        column[PLENUM] = record.exhaust.plenum_pressure[n] - ambient;
    }
    Ok(histories)
}

/// The stop that is closer to the head valve at a sample.
fn nearest_stop(parameters: &Parameters, record: &CycleRecord, sample: usize) -> Axial {
    if record.motion.valve_lift[sample] > 0.5 * parameters.head_valve.lift {
        Axial::Cap
    } else {
        Axial::Rim
    }
}

/// Mean force of the head valve on its stops around each sample, minus the sampled force, positive downwards \[N\].
///
/// Between two samples at an interval h, the valve's momentum changes by M_h (v' - v). The mean of the smooth forces,
/// gas, spring, friction and weight (M_h a + cap + seat), accounts for part of the change; the rest is the impulse of
/// cap and seat. Half of it is assigned to each of the two samples.
pub(super) fn impulse_correction(parameters: &Parameters, record: &CycleRecord) -> Vec<f64> {
    let (valve, interval, mass) = (&record.head_valve, record.sample_interval, parameters.head_valve.mass);
    let sampled = |n: usize| record.forces.cap[n] + record.forces.seat[n];
    let smooth = |n: usize| mass * valve.acceleration[n] + sampled(n);
    let mut forces: Vec<f64> = (0..record.len()).map(|n| -sampled(n)).collect();
    for n in 1..record.len() {
        let gained = mass * (valve.velocity[n] - valve.velocity[n - 1]) / interval;
        let force = 0.5 * (smooth(n - 1) + smooth(n)) - gained;
        forces[n - 1] += 0.5 * force;
        forces[n] += 0.5 * force;
    }
    // Half an interval is missing at each end, where the valve is at rest.
    for end in [0, record.len() - 1] {
        forces[end] += 0.5 * sampled(end);
    }
    forces
}

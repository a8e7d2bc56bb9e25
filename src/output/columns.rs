//! Every history of a cycle by name and unit, for files that list them.

use nailnoise_dynamics::CycleRecord;

/// One history.
#[derive(Debug, Clone, Copy)]
pub struct Column<'a> {
    /// Name, words joined by underscores.
    pub name: &'static str,
    /// SI unit, as written in a header.
    pub unit: &'static str,
    /// Samples on the record's time grid.
    pub values: &'a [f64],
}

/// All histories of a record, in the order a reader would look for them: motion, gas, forces, flow.
pub fn columns(record: &CycleRecord) -> Vec<Column<'_>> {
    let column = |name, unit, values| Column { name, unit, values };
    let r = record;
    let f = &r.forces;
    vec![
        column("piston_position", "m", &r.piston.position),
        column("piston_velocity", "m/s", &r.piston.velocity),
        column("piston_acceleration", "m/s2", &r.piston.acceleration),
        column("head_valve_position", "m", &r.head_valve.position),
        column("head_valve_velocity", "m/s", &r.head_valve.velocity),
        column("head_valve_acceleration", "m/s2", &r.head_valve.acceleration),
        column("tool_position", "m", &r.tool.position),
        column("tool_velocity", "m/s", &r.tool.velocity),
        column("tool_acceleration", "m/s2", &r.tool.acceleration),
        column("workpiece_position", "m", &r.workpiece.position),
        column("workpiece_velocity", "m/s", &r.workpiece.velocity),
        column("workpiece_acceleration", "m/s2", &r.workpiece.acceleration),
        column("piston_travel", "m", &r.motion.piston_travel),
        column("valve_lift", "m", &r.motion.valve_lift),
        column("tip_depth", "m", &r.motion.tip_depth),
        column("nail_depth", "m", &r.motion.nail_depth),
        column("moving_mass", "kg", &r.motion.moving_mass),
        column("above_piston_pressure", "Pa", &r.above_piston.pressure),
        column("above_piston_temperature", "K", &r.above_piston.temperature),
        column("above_piston_mass", "kg", &r.above_piston.mass),
        column("below_piston_pressure", "Pa", &r.below_piston.pressure),
        column("below_piston_temperature", "K", &r.below_piston.temperature),
        column("below_piston_mass", "kg", &r.below_piston.mass),
        column("return_volume_pressure", "Pa", &r.return_volume.pressure),
        column("return_volume_temperature", "K", &r.return_volume.temperature),
        column("return_volume_mass", "kg", &r.return_volume.mass),
        column("above_valve_pressure", "Pa", &r.above_valve.pressure),
        column("above_valve_temperature", "K", &r.above_valve.temperature),
        column("above_valve_mass", "kg", &r.above_valve.mass),
        column("supply_pressure", "Pa", &r.supply.pressure),
        column("supply_temperature", "K", &r.supply.temperature),
        column("supply_mass", "kg", &r.supply.mass),
        column("piston_gas_force", "N", &f.piston_gas),
        column("valve_gas_force", "N", &f.valve_gas),
        column("bumper_force", "N", &f.bumper),
        column("stopper_force", "N", &f.stopper),
        column("cap_force", "N", &f.cap),
        column("seat_force", "N", &f.seat),
        column("spring_force", "N", &f.spring),
        column("piston_friction_force", "N", &f.piston_friction),
        column("valve_friction_force", "N", &f.valve_friction),
        column("penetration_force", "N", &f.penetration),
        column("nose_force", "N", &f.nose),
        column("guard_force", "N", &f.guard),
        column("support_force", "N", &f.support),
        column("hand_force", "N", &f.hand),
        column("exhaust_mass_flow", "kg/s", &r.exhaust.mass_flow),
        column("exhaust_plenum_pressure", "Pa", &r.exhaust.plenum_pressure),
        column("exhaust_back_pressure", "Pa", &r.exhaust.back_pressure),
        column("exhaust_stagnation_temperature", "K", &r.exhaust.stagnation_temperature),
        column("intake_mass_flow", "kg/s", &r.exhaust.intake_mass_flow),
        column("vent_mass_flow", "kg/s", &r.vent.mass_flow),
        column("vent_pressure", "Pa", &r.vent.pressure),
        column("vent_temperature", "K", &r.vent.temperature),
    ]
}

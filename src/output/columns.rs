//! Every history of a cycle with its name and unit, for files that list them.

use crate::stages::cycle::{EngineRecord, ShotRecord};
use nailnoise_dynamics::{Body, CycleRecord, ExhaustFlow, Forces, Motion, VentFlow, Volume};

/// One history.
#[derive(Debug, Clone)]
pub struct Column<'a> {
    /// Name: words joined by underscores.
    pub name: String,
    /// SI unit, as written in a header.
    pub unit: &'a str,
    /// Samples on the record's time grid.
    pub values: &'a [f64],
}

/// The columns of a group of the record. The pattern lists all fields of the group, so that a history without a column
/// does not compile. `flags` are fields that are not quantities.
macro_rules! group {
    ($group:expr, $type:ident { $($field:ident: $name:expr, $unit:literal;)* } $(flags $($flag:ident),*)?) => {{
        let $type { $($field,)* $($($flag: _,)*)? } = $group;
        vec![$(Column { name: $name.to_owned(), unit: $unit, values: $field }),*]
    }};
}

fn body<'a>(name: &str, own: &'a Body) -> Vec<Column<'a>> {
    group!(own, Body {
        position: format!("{name}_position"), "m";
        velocity: format!("{name}_velocity"), "m/s";
        acceleration: format!("{name}_acceleration"), "m/s2";
    })
}

fn volume<'a>(name: &str, own: &'a Volume) -> Vec<Column<'a>> {
    group!(own, Volume {
        pressure: format!("{name}_pressure"), "Pa";
        temperature: format!("{name}_temperature"), "K";
        mass: format!("{name}_mass"), "kg";
    })
}

fn motion(own: &Motion) -> Vec<Column<'_>> {
    group!(own, Motion {
        piston_travel: "piston_travel", "m";
        valve_lift: "valve_lift", "m";
        tip_depth: "tip_depth", "m";
        nail_depth: "nail_depth", "m";
        moving_mass: "moving_mass", "kg";
    })
}

fn forces(own: &Forces) -> Vec<Column<'_>> {
    group!(own, Forces {
        piston_gas: "piston_gas_force", "N";
        valve_gas: "valve_gas_force", "N";
        bumper: "bumper_force", "N";
        stopper: "stopper_force", "N";
        cap: "cap_force", "N";
        seat: "seat_force", "N";
        spring: "spring_force", "N";
        piston_friction: "piston_friction_force", "N";
        valve_friction: "valve_friction_force", "N";
        penetration: "penetration_force", "N";
        nose: "nose_force", "N";
        guard: "guard_force", "N";
        support: "support_force", "N";
        hand: "hand_force", "N";
        magazine: "magazine_force", "N";
        thrust: "thrust_force", "N";
    })
}

fn exhaust(own: &ExhaustFlow) -> Vec<Column<'_>> {
    group!(own, ExhaustFlow {
        mass_flow: "exhaust_mass_flow", "kg/s";
        plenum_pressure: "exhaust_plenum_pressure", "Pa";
        back_pressure: "exhaust_back_pressure", "Pa";
        stagnation_temperature: "exhaust_stagnation_temperature", "K";
        intake_mass_flow: "intake_mass_flow", "kg/s";
    } flags choked, intake_choked)
}

fn vent(own: &VentFlow) -> Vec<Column<'_>> {
    group!(own, VentFlow {
        mass_flow: "vent_mass_flow", "kg/s";
        pressure: "vent_pressure", "Pa";
        temperature: "vent_temperature", "K";
    })
}

/// Columns added in later versions come last, because the order of the columns is an interface.
const ADDED: [&str; 2] = ["magazine_force", "thrust_force"];

/// All histories of a shot: those of [`columns`], or of the channels of an assembly.
pub fn columns_of(shot: &ShotRecord) -> Vec<Column<'_>> {
    match &shot.record {
        EngineRecord::Keys(record) => columns(record),
        EngineRecord::Assembly(record) => {
            let channels = record.channels.iter().filter(|channel| !channel.column.is_empty());
            let column = channels.map(|channel| Column {
                name: channel.column.clone(),
                unit: &channel.unit,
                values: &channel.values,
            });
            column.collect()
        }
    }
}

/// All histories of a record, in the order in which a reader would look for them: motion, gas, forces, flow.
pub fn columns(record: &CycleRecord) -> Vec<Column<'_>> {
    // A new group of histories does not compile until it has columns.
    let CycleRecord {
        piston,
        head_valve,
        tool,
        workpiece,
        motion: relative,
        above_piston,
        below_piston,
        return_volume,
        above_valve,
        supply,
        forces: between,
        exhaust: outflow,
        vent: vented,
        sample_interval: _,
        events: _,
        log: _,
        outcome: _,
        summary: _,
        energy: _,
        checks: _,
        work: _,
    } = record;
    let mut columns = [
        body("piston", piston),
        body("head_valve", head_valve),
        body("tool", tool),
        body("workpiece", workpiece),
        motion(relative),
        volume("above_piston", above_piston),
        volume("below_piston", below_piston),
        volume("return_volume", return_volume),
        volume("above_valve", above_valve),
        volume("supply", supply),
        forces(between),
        exhaust(outflow),
        vent(vented),
    ]
    .concat();
    columns.sort_by_key(|column| {
        ADDED
            .iter()
            .position(|name| *name == column.name)
            .map(|place| place + 1)
    });
    columns
}

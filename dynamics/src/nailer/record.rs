//! The record of the assembly in the fixed fields of a [`CycleRecord`].

use nailnoise_quantities::Check;

use super::log::log;
use super::summary::{events, outcome, summary};
use crate::network::{FlowHistory, Record};
use crate::{
    Body, ContactEnergy, CycleError, CycleRecord, EnergyFlow, ExhaustFlow, Forces, Form, Geometry, Motion, Parameters,
    Summary, VentFlow, Volume,
};

/// Histories of the assembly by name, each of which is moved out once; those of blocks that a design switches off are
/// zero.
struct Histories {
    record: Record,
    samples: usize,
}

impl Histories {
    fn take(&mut self, name: &str) -> Vec<f64> {
        self.record.take(name).unwrap_or_else(|| vec![0.0; self.samples])
    }

    fn body(&mut self, name: &str) -> Body {
        Body {
            position: self.take(&format!("{name}.position")),
            velocity: self.take(&format!("{name}.velocity")),
            acceleration: self.take(&format!("{name}.acceleration")),
        }
    }

    fn volume(&mut self, name: &str) -> Volume {
        Volume {
            pressure: self.take(&format!("{name}.pressure")),
            temperature: self.take(&format!("{name}.temperature")),
            mass: self.take(&format!("{name}.mass")),
        }
    }

    fn opening(&mut self, name: &str) -> Result<FlowHistory, CycleError> {
        let place = self.record.openings.iter().position(|opening| opening.name == name);
        let place = place.ok_or_else(|| CycleError::Assembly {
            cause: format!("no opening `{name}`"),
        })?;
        Ok(self.record.openings.swap_remove(place))
    }
}

/// The record in fixed fields.
///
/// # Errors
/// [`CycleError::Assembly`] if the assembly does not have the opening `exhaust`, or an outcome has another name.
pub(super) fn view(p: &Parameters, record: Record) -> Result<CycleRecord, CycleError> {
    let samples = record.channels.first().map_or(0, |channel| channel.values.len());
    let (log, energy) = (log(p, &record), energy(&record));
    let mut of = Histories { record, samples };
    let volumes = ["above_piston", "below_piston", "return_volume", "above_valve", "supply"];
    let [above_piston, below_piston, return_volume, above_valve, supply] = volumes.map(|name| of.volume(name));
    let motion = Motion {
        piston_travel: of.take("piston.travel"),
        valve_lift: of.take("valve_lift"),
        tip_depth: of.take("nail.tip"),
        nail_depth: of.take("nail.deepest"),
        moving_mass: of.take("piston.moving_mass"),
    };
    let forces = forces(p, &mut of, [&above_piston, &below_piston, &above_valve, &supply]);
    let critical = p.ambient.critical_ratio();
    let holes = of.opening("exhaust")?;
    let choked = |n: usize| {
        motion.valve_lift[n] > p.head_valve.intake_lap && above_piston.pressure[n] < critical * supply.pressure[n]
    };
    let exhaust = ExhaustFlow {
        mass_flow: holes.mass_flow,
        plenum_pressure: holes.pressure,
        back_pressure: holes.back_pressure,
        stagnation_temperature: holes.temperature,
        choked: holes.choked,
        intake_choked: (0..samples).map(choked).collect(),
        intake_mass_flow: of.take("intake.mass_flow"),
    };
    let vent = VentFlow {
        mass_flow: of.take("vent.mass_flow"),
        pressure: above_valve.pressure.clone(),
        temperature: above_valve.temperature.clone(),
    };
    let bodies = ["piston", "head_valve", "tool", "workpiece"];
    let [piston, head_valve, tool, workpiece] = bodies.map(|name| of.body(name));
    let record = of.record;
    let mut view = CycleRecord {
        sample_interval: record.interval.unwrap_or_default(),
        piston,
        head_valve,
        tool,
        workpiece,
        motion,
        above_piston,
        below_piston,
        return_volume,
        above_valve,
        supply,
        forces,
        exhaust,
        vent,
        events: events(&record),
        log,
        outcome: outcome(&record)?,
        summary: Summary::default(),
        energy,
        checks: checks(&record),
        work: record.work,
    };
    view.summary = summary(p, &record, &view);
    if p.model.nail == Form::Corrected {
        // In the published form, the nail ends with its first reversal.
        let (depth, limit) = (view.summary.head_depth.max(0.0), p.nail.overdrive_limit);
        view.checks
            .push(Check::at_most("head of the nail below the surface [m]", depth, limit));
    }
    Ok(view)
}

/// Limits of the balances of a nailer with some grams of air, which are tighter than those of any tool.
const LIMITS: [(&str, f64); 2] = [("mass balance [kg]", 1e-12), ("gas energy balance [J]", 1e-6)];

fn checks(record: &Record) -> Vec<Check> {
    let tightened = |check: &Check| {
        let limit = LIMITS.iter().find(|(name, _)| *name == check.name);
        limit.map_or_else(
            || check.clone(),
            |(name, limit)| Check::at_most(*name, check.value, *limit),
        )
    };
    record.checks.iter().map(tightened).collect()
}

fn forces(p: &Parameters, of: &mut Histories, [above, below, control, supply]: [&Volume; 4]) -> Forces {
    let g = Geometry::new(p);
    let underside = match p.model.valve_underside {
        Form::Corrected => g.valve_cylinder_area,
        Form::Published => 0.0,
    };
    let samples = of.samples;
    let history = |force: &dyn Fn(usize) -> f64| (0..samples).map(force).collect();
    let magazine = of.take("nail.guide_force");
    let mut force = |block: &str| of.take(&format!("{block}.force"));
    Forces {
        piston_gas: history(&|n| {
            above.pressure[n] * g.piston_area - below.pressure[n] * g.ring_area - p.ambient.pressure * g.rod_area
        }),
        valve_gas: history(&|n| {
            control.pressure[n] * g.valve_control_area
                - supply.pressure[n] * g.valve_supply_area
                - above.pressure[n] * underside
        }),
        bumper: force("bumper"),
        stopper: force("stopper"),
        cap: force("cap"),
        seat: force("seat"),
        spring: force("spring"),
        piston_friction: force("piston_friction"),
        valve_friction: force("valve_friction"),
        penetration: force("nail"),
        nose: force("nose"),
        guard: force("guard"),
        support: force("support"),
        hand: force("hand"),
        magazine,
        thrust: force("thrust"),
    }
}

fn energy(record: &Record) -> EnergyFlow {
    let of = |name: &str| record.integral(name).unwrap_or(0.0);
    let contact = |name: &str| of(&format!("dashpot.{name}")) + of(&format!("lost.{name}"));
    EnergyFlow {
        gas_start: of("gas.start"),
        gas_end: of("gas.end"),
        supply: of("enthalpy.refill"),
        exhaust: of("enthalpy.exhaust"),
        vent: of("enthalpy.vent"),
        leak: of("enthalpy.leak"),
        wall_heat: of("heat"),
        piston_work: of("work.piston"),
        valve_work: of("work.head_valve"),
        atmosphere: of("work.atmosphere"),
        hand: of("work.hand") + of("work.push"),
        gravity: of("gravity"),
        thrust: of("work.thrust"),
        piston_friction: of("friction.piston_friction"),
        valve_friction: of("friction.valve_friction"),
        magazine_friction: of("guide.nail"),
        penetration: of("penetration.nail"),
        nail_impact: of("lost.nail"),
        nail_left: of("left.nail"),
        contacts: ContactEnergy {
            bumper: contact("bumper"),
            stopper: contact("stopper"),
            cap: contact("cap"),
            seat: contact("seat"),
            nose: contact("nose"),
            support: contact("support"),
        },
        wood: of("coupling.workpiece"),
        hand_damping: of("dashpot.hand"),
        kinetic_start: of("kinetic.start"),
        kinetic_end: of("kinetic.end"),
        elastic_start: of("elastic.start"),
        elastic_end: of("elastic.end"),
    }
}

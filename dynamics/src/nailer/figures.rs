//! The shot in terms of the nailer, from the record of its assembly.

use nailnoise_quantities::Check;

use super::assembly::Nailer;
use super::log::log;
use super::summary::{events, is_event, outcome, summary};
use crate::network::Record;
use crate::{ContactEnergy, CycleError, CycleRecord, EnergyFlow, Form, NailerFigures, Parameters};

/// The record with the figures of the shot. Its events are those of the nailer; the others of the assembly are
/// conditions of outcome and log.
///
/// # Errors
/// [`CycleError::Assembly`] if an outcome has another name than those of the nailer.
pub(super) fn cycle_record(nailer: Nailer<'_>, record: Record) -> Result<CycleRecord, CycleError> {
    let mut record = nailer.arranged(record);
    let figures = figures(nailer.parameters, &record)?;
    record.events.retain(|event| is_event(&event.name));
    Ok(CycleRecord {
        assembly: nailer.assembly,
        record,
        figures,
    })
}

fn figures(p: &Parameters, record: &Record) -> Result<NailerFigures, CycleError> {
    let events = events(record);
    let summary = summary(p, record, &events);
    let mut checks = checks(record);
    if p.model.nail == Form::Corrected {
        // In the published form, the nail ends with its first reversal.
        let (depth, limit) = (summary.head_depth.max(0.0), p.nail.overdrive_limit);
        checks.push(Check::at_most("head of the nail below the surface [m]", depth, limit));
    }
    Ok(NailerFigures {
        outcome: outcome(record)?,
        events,
        summary,
        energy: energy(record),
        log: log(p, record),
        checks,
    })
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

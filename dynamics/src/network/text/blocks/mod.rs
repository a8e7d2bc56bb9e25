//! The families of blocks, one module per kind.

mod events;
mod gas;
mod list;
mod mechanics;
mod outputs;

pub(super) use gas::reaches_atmosphere;
pub(super) use list::is_atmosphere;
pub(super) use mechanics::unbalanced;

use nailnoise_quantities::dimension::{ACCELERATION, GAS_CONSTANT, NUMBER, TIME};
use nailnoise_quantities::{any, positive};

use super::fault::{AssemblyError, Fault};
use super::fields::Fields;
use super::layers::FAMILIES;
use super::resolver::Resolver;
use crate::network::assembly::{Assembly, Family, Finish, Ledger};

/// Fields of `[cycle]` that are not families of blocks.
const FIELDS: [&str; 9] = [
    "gas", "gravity", "linear", "end", "finish", "ledger", "let", "outcome", "pressure",
];

/// Relative pressure difference below which a flow is linear, unless the assembly gives another.
const LINEAR: f64 = 1e-3;

/// Reads all blocks.
pub(super) fn read(resolver: &Resolver<'_>) -> Result<Assembly, AssemblyError> {
    let cycle = &resolver.text.cycle;
    let known: Vec<&str> = FAMILIES.iter().chain(&FIELDS).copied().collect();
    let top = Fields::new(resolver, "cycle".to_owned(), cycle, "cycle", &known)?;
    let gas = top
        .table("gas", "gas", &["constant", "ratio"])?
        .ok_or_else(|| top.missing("gas", "{ constant = \"287.05 J/(kg K)\", ratio = 1.4 }"))?;
    let gravity = top.or("gravity", any(ACCELERATION), 0.0)?;
    let reservoirs = gas::reservoirs(resolver)?;
    let atmosphere = resolver
        .names
        .index("atmosphere", Family::Reservoir)
        .and_then(|index| reservoirs.get(index))
        .ok_or_else(|| top.own_error(Fault::NoAtmosphere))?;
    let parents = mechanics::parents(resolver)?;
    let bodies = mechanics::bodies(resolver, &parents, gravity)?;
    let volumes = gas::volumes(resolver, atmosphere.temperature)?;
    let passages = gas::passages(resolver, &parents)?;
    let sensors = events::sensors(resolver)?;
    let events = events::events(resolver, &sensors, &passages)?;
    Ok(Assembly {
        name: resolver.text.name.clone(),
        gas_constant: gas.required("constant", positive(GAS_CONSTANT), "\"287.05 J/(kg K)\"")?,
        heat_capacity_ratio: gas.required("ratio", positive(NUMBER).within(1.01, 1.7), "1.4")?,
        gravity,
        linear_ratio: top.or("linear", positive(NUMBER).within(1e-6, 0.1), LINEAR)?,
        end: top.required("end", positive(TIME).within(1e-6, 100.0), "\"100 ms\"")?,
        finish: finish(&top, resolver)?,
        ledger: top
            .word("ledger", &[("lean", Ledger::Lean), ("full", Ledger::Full)])?
            .unwrap_or(Ledger::Lean),
        unbalanced: unbalanced(resolver)?.iter().any(|unbalanced| *unbalanced),
        faces: gas::faces(resolver, &parents)?,
        contacts: mechanics::contacts(resolver, &parents, &bodies)?,
        springs: mechanics::springs(resolver, &parents)?,
        frictions: mechanics::frictions(resolver, &parents)?,
        forces: mechanics::forces(resolver)?,
        motors: mechanics::motors(resolver, &parents)?,
        holds: mechanics::holds(resolver, &parents, &bodies)?,
        fasteners: mechanics::fasteners(resolver)?,
        triggers: events::triggers(resolver, &passages)?,
        outcomes: events::outcomes(&top, &sensors)?,
        openings: outputs::openings(resolver, &passages)?,
        loads: outputs::loads(resolver, &sensors)?,
        pressures: outputs::pressures(resolver, &sensors)?,
        sensors: sensors.into_iter().map(|sensor| sensor.sensor).collect(),
        reservoirs,
        bodies,
        volumes,
        passages,
        events,
    })
}

fn finish(top: &Fields<'_, '_>, resolver: &Resolver<'_>) -> Result<Option<Finish>, AssemblyError> {
    let Some(finish) = top.table("finish", "finish", &["event", "tail", "never_past"])? else {
        return Ok(None);
    };
    let event = |key: &str| events::event_index(&finish, key, resolver);
    Ok(Some(Finish {
        event: event("event")?.ok_or_else(|| finish.missing("event", "\"t18\""))?,
        tail: finish.or("tail", nailnoise_quantities::nonnegative(TIME), 0.0)?,
        never_past: event("never_past")?,
    }))
}

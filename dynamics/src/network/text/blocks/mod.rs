//! The families of blocks, one module per kind.

mod blow;
mod columns;
mod events;
mod fastener;
mod gas;
mod list;
mod mechanics;
mod outputs;
mod tables;

pub(super) use gas::reaches_atmosphere;
pub(super) use list::is_atmosphere;
pub(super) use mechanics::unbalanced;

pub use tables::CYCLE;

use super::fault::{AssemblyError, Fault};
use super::fields::Fields;
use super::resolver::Resolver;
use crate::network::assembly::{Assembly, Family, Finish, Ledger};
use tables::LEDGERS;

/// Relative pressure difference below which a flow is linear, unless the assembly gives another.
const LINEAR: f64 = 1e-3;

/// Specific gas constant \[J/(kg K)\] and ratio of the heat capacities of dry air, which have no effect in an assembly
/// without volumes and passages.
const AIR: [f64; 2] = [287.05, 1.4];

/// Reads all blocks.
pub(super) fn read(resolver: &Resolver<'_>) -> Result<Assembly, AssemblyError> {
    let cycle = &resolver.text.cycle;
    let top = Fields::new(resolver, "cycle".to_owned(), cycle, &CYCLE)?;
    let gas = top.table("gas")?;
    let gravity = top.or("gravity", 0.0)?;
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
    let [gas_constant, heat_capacity_ratio] = match &gas {
        Some(gas) => [gas.required("constant")?, gas.required("ratio")?],
        None if volumes.is_empty() && passages.is_empty() => AIR,
        None => return Err(top.missing("gas")),
    };
    let fasteners = fastener::fasteners(resolver, &bodies)?;
    let sensors = events::sensors(resolver)?;
    let events = events::events(resolver, &sensors, &passages)?;
    Ok(Assembly {
        name: resolver.text.name.clone(),
        gas_constant,
        heat_capacity_ratio,
        polytropic: gas.as_ref().map(gas::polytropic).transpose()?.flatten(),
        gravity,
        linear_ratio: top.or("linear", LINEAR)?,
        end: top.required("end")?,
        finish: finish(&top, resolver)?,
        ledger: top.word("ledger", &LEDGERS)?.unwrap_or(Ledger::Lean),
        unbalanced: unbalanced(resolver)?.iter().any(|unbalanced| *unbalanced),
        faces: gas::faces(resolver, &parents)?,
        contacts: mechanics::contacts(resolver, &parents, &bodies)?,
        springs: mechanics::springs(resolver, &parents)?,
        frictions: mechanics::frictions(resolver, &parents)?,
        forces: mechanics::forces(resolver, &passages)?,
        motors: mechanics::motors(resolver, &parents)?,
        holds: mechanics::holds(resolver, &parents, &bodies)?,
        blows: blow::blows(resolver, &fasteners)?,
        fasteners,
        triggers: events::triggers(resolver, &passages)?,
        outcomes: events::outcomes(&top, &sensors, &passages)?,
        openings: outputs::openings(resolver, &passages)?,
        loads: outputs::loads(resolver, &sensors)?,
        pressures: outputs::pressures(resolver, &sensors)?,
        columns: columns::columns(resolver, &sensors)?,
        markers: columns::markers(&top)?,
        sensors: sensors.into_iter().map(|sensor| sensor.sensor).collect(),
        reservoirs,
        bodies,
        volumes,
        passages,
        events,
    })
}

fn finish(top: &Fields<'_, '_>, resolver: &Resolver<'_>) -> Result<Option<Finish>, AssemblyError> {
    let Some(finish) = top.table("finish")? else {
        return Ok(None);
    };
    let event = |key: &str| events::event_index(&finish, key, resolver);
    Ok(Some(Finish {
        event: event("event")?.ok_or_else(|| finish.missing("event"))?,
        tail: finish.or("tail", 0.0)?,
        never_past: event("never_past")?,
    }))
}

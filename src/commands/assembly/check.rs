//! `nailnoise check` of an assembly: its states, blocks, events, openings, balances and keys.

use std::path::Path;

use nailnoise_dynamics::network::Literal;
use nailnoise_dynamics::network::assembly::{
    Assembly, Base, BlockRef, Coefficient, Contact, Edge, Family, Opens, Passage, Push, Space, Start, Stop,
};
use nailnoise_quantities::Kind;
use nailnoise_quantities::dimension::NUMBER;
use serde::Serialize;

use crate::atomic_write;
use crate::commands::table::words;
use crate::commands::{Shown, Status, folder_of, print, print_json};
use crate::design::inputs::assembly::AssembledTool;
use crate::design::quantity_in_words;
use crate::drawing;
use crate::error::Error;
use crate::stages::cycle::event_in_words;

/// Layout of `check --json` of an assembly.
#[derive(Serialize)]
struct CheckResult<'a> {
    schema: &'static str,
    tool: &'a str,
    assembly: &'a str,
    /// Names of the states, in order.
    states: Vec<String>,
    tables: Vec<Table>,
}

/// A table of one family of blocks.
#[derive(Serialize)]
struct Table {
    name: &'static str,
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

pub(in crate::commands) fn execute(
    tool: &AssembledTool,
    path: &Path,
    json: bool,
    shown: Shown,
) -> Result<Status, Error> {
    let assembly = &tool.resolved.assembly;
    let tables = tables(tool);
    let states = states(assembly);
    if json {
        print_json(&CheckResult {
            schema: "nailnoise-network-check/1",
            tool: &tool.name,
            assembly: &assembly.name,
            states,
            tables,
        })?;
        return Ok(Status::SUCCESS);
    }
    let mut text = format!(
        "{}: assembly {}, {} states\n\n  states  {}\n",
        tool.name,
        assembly.name,
        states.len(),
        states.join(", ")
    );
    for table in tables.iter().filter(|table| !table.rows.is_empty()) {
        text.push_str(&format!("\n{}", words(&table.headings, &table.rows, shown.units)));
    }
    let sound = match tool.has_design {
        true => format!("`nailnoise run {}` ranks its sources", path.display()),
        false => "with a base design, `nailnoise run` ranks its sources".to_owned(),
    };
    text.push_str(&format!(
        "\n  `nailnoise cycle {}` computes its cycle; {sound}; --drawing draws the network\n",
        path.display()
    ));
    shown.print(&text)?;
    Ok(Status::SUCCESS)
}

/// Layout of `check --drawing --json` of an assembly.
#[derive(Serialize)]
struct DrawingResult<'a> {
    schema: &'static str,
    tool: &'a str,
    written: &'a Path,
}

/// Draws the network to a file, `out/NAME/network.svg` by default.
pub(in crate::commands) fn draw(
    tool: &AssembledTool,
    path: &Path,
    file: Option<&Path>,
    json: bool,
) -> Result<Status, Error> {
    let written = match file {
        Some(file) => file.to_owned(),
        None => folder_of(Path::new("out"), &tool.name, path)?.join("network.svg"),
    };
    let svg = drawing::network(&tool.name, &tool.resolved.assembly);
    atomic_write::write(&written, svg.as_bytes())?;
    if json {
        print_json(&DrawingResult {
            schema: "nailnoise-network-drawing/1",
            tool: &tool.name,
            written: &written,
        })?;
    } else {
        print(&format!("{}: network drawn to {}\n", tool.name, written.display()))?;
    }
    Ok(Status::SUCCESS)
}

/// Names of the states: position and velocity of each body, followed by energy and mass of the gas in each volume.
fn states(assembly: &Assembly) -> Vec<String> {
    let bodies = assembly.bodies.iter();
    let mut states: Vec<String> = bodies
        .flat_map(|body| [format!("{}.position", body.name), format!("{}.velocity", body.name)])
        .collect();
    states.extend(assembly.volumes.iter().map(|volume| format!("{}.energy", volume.name)));
    states.extend(assembly.volumes.iter().map(|volume| format!("{}.mass", volume.name)));
    states
}

fn tables(tool: &AssembledTool) -> Vec<Table> {
    let assembly = &tool.resolved.assembly;
    vec![
        bodies(assembly),
        volumes(assembly),
        passages(assembly),
        forces(assembly),
        triggers(assembly),
        events(tool),
        outcomes(tool),
        openings(assembly),
        balances(assembly),
        keys(&tool.resolved.literals),
    ]
}

fn base(assembly: &Assembly, base: Base) -> String {
    match base {
        Base::Ground => "ground".to_owned(),
        Base::Body(index) => assembly.bodies[index].name.clone(),
    }
}

fn space(assembly: &Assembly, space: Space) -> String {
    match space {
        Space::Volume(index) => assembly.volumes[index].name.clone(),
        Space::Reservoir(index) => assembly.reservoirs[index].name.clone(),
    }
}

fn block(assembly: &Assembly, block: BlockRef) -> String {
    match block.family {
        Family::Contact => assembly.contacts[block.index].name.clone(),
        Family::Spring => assembly.springs[block.index].name.clone(),
        _ => String::new(),
    }
}

fn mm(value: f64) -> String {
    format!("{:.3} mm", 1e3 * value)
}

fn bodies(assembly: &Assembly) -> Table {
    let row = |body: &nailnoise_dynamics::network::assembly::Body| {
        let start = match body.start {
            Start::RestOn(on) => format!("at rest on {}", block(assembly, on)),
            Start::At { travel, speed: 0.0 } => format!("at {}", mm(travel)),
            Start::At { travel, speed } => format!("at {} with {speed} m/s", mm(travel)),
        };
        vec![
            body.name.clone(),
            base(assembly, body.parent),
            format!("{:.4} kg", body.mass),
            start,
        ]
    };
    Table {
        name: "bodies",
        headings: vec!["body", "parent", "mass", "starts"],
        rows: assembly.bodies.iter().map(row).collect(),
    }
}

fn volumes(assembly: &Assembly) -> Table {
    let row = |index: usize| {
        let volume = &assembly.volumes[index];
        let faces = assembly.faces.iter().filter(|face| face.gas == Space::Volume(index));
        let faces: Vec<String> = faces
            .map(|face| format!("{} {:.1} mm2", assembly.bodies[face.body].name, 1e6 * face.area))
            .collect();
        let gas = if volume.isothermal { "isothermal" } else { "adiabatic" };
        vec![
            volume.name.clone(),
            format!("{:.2} cm3", 1e6 * volume.dead),
            format!("{:.1} kPa", 1e-3 * volume.pressure),
            volume
                .wall
                .map_or_else(|| gas.to_owned(), |wall| format!("wall {:.1} cm2", 1e4 * wall.area)),
            faces.join(", "),
        ]
    };
    Table {
        name: "volumes",
        headings: vec!["volume", "dead", "starts at", "heat", "faces"],
        rows: (0..assembly.volumes.len()).map(row).collect(),
    }
}

fn passages(assembly: &Assembly) -> Table {
    let row = |passage: &Passage| {
        let mut options = Vec::new();
        if passage.one_way {
            options.push("one way".to_owned());
        }
        if let Some(gate) = &passage.gate {
            let not = if gate.inverted { "not " } else { "" };
            options.push(format!("when {not}{}", assembly.triggers[gate.trigger].name));
        }
        vec![
            passage.name.clone(),
            space(assembly, passage.from),
            space(assembly, passage.to),
            passage
                .restrictions
                .iter()
                .map(|own| opens(assembly, &own.opens))
                .collect::<Vec<_>>()
                .join(", then "),
            passage
                .restrictions
                .iter()
                .map(|own| coefficient(&own.coefficient))
                .collect::<Vec<_>>()
                .join(", "),
            options.join(", "),
        ]
    };
    Table {
        name: "passages",
        headings: vec!["passage", "from", "to", "opens", "coefficient", ""],
        rows: assembly.passages.iter().map(row).collect(),
    }
}

fn opens(assembly: &Assembly, opens: &Opens) -> String {
    let mm2 = |area: f64| format!("{:.2} mm2", 1e6 * area);
    match *opens {
        Opens::Constant { area } => mm2(area),
        Opens::Ramp { area, time } => format!("{} in {:.2} ms", mm2(area), 1e3 * time),
        Opens::Seat {
            body,
            push,
            at,
            diameter,
            ..
        } => {
            let side = if push == Push::Down { "above" } else { "below" };
            format!(
                "seat {}, {} {side} {}",
                mm(diameter),
                assembly.bodies[body].name,
                mm(at)
            )
        }
        Opens::Holes {
            body, push, at, area, ..
        } => {
            let side = if push == Push::Down { "above" } else { "below" };
            format!("holes {}, {} {side} {}", mm2(area), assembly.bodies[body].name, mm(at))
        }
    }
}

fn coefficient(coefficient: &Coefficient) -> String {
    match coefficient {
        Coefficient::Constant(constant) => format!("{constant:.4}"),
        Coefficient::RatioPolynomial { from, to, .. } => format!("{from} .. {to}"),
    }
}

/// Everything that exerts a force, by pair of bodies.
fn forces(assembly: &Assembly) -> Table {
    let row = |kind: &str, name: &str, (on, against): (usize, Base), law: String| {
        let on = assembly.bodies[on].name.clone();
        vec![name.to_owned(), kind.to_owned(), on, base(assembly, against), law]
    };
    let contacts = assembly.contacts.iter();
    let contacts = contacts.map(|own| row("contact", &own.name, (own.on, own.against), stop(own)));
    let others = [
        pairs("spring", &assembly.springs, |own| (&own.name, own.on, own.against)),
        pairs("friction", &assembly.frictions, |own| (&own.name, own.on, own.against)),
        pairs("force", &assembly.forces, |own| (&own.name, own.on, own.against)),
        pairs("motor", &assembly.motors, |own| (&own.name, own.on, own.against)),
        pairs("latch", &assembly.holds, |own| (&own.name, own.on, own.against)),
        pairs("fastener", &assembly.fasteners, |own| (&own.name, own.driver, own.into)),
    ];
    let others = others.iter().flatten();
    let others = others.map(|(kind, name, on, against)| row(kind, name, (*on, *against), String::new()));
    Table {
        name: "forces",
        headings: vec!["force", "kind", "on", "against", "stop"],
        rows: contacts.chain(others).collect(),
    }
}

/// Kind, name and bodies of the blocks of a family.
fn pairs<'a, T>(
    kind: &'static str,
    blocks: &'a [T],
    of: impl Fn(&'a T) -> (&'a String, usize, Base),
) -> Vec<(&'static str, &'a str, usize, Base)> {
    let of = |own| {
        let (name, on, against) = of(own);
        (kind, name.as_str(), on, against)
    };
    blocks.iter().map(of).collect()
}

/// Side, position and stiffness of a stop.
fn stop(contact: &Contact) -> String {
    let side = if contact.stop == Stop::Below { "down" } else { "up" };
    let stiffness = if contact.exponent == 1.0 {
        format!("{:.4} N/mm", 1e-3 * contact.stiffness)
    } else {
        format!("{:.4e} N/m^{}", contact.stiffness, contact.exponent)
    };
    format!("{side} at {}, {stiffness}", mm(contact.at))
}

fn triggers(assembly: &Assembly) -> Table {
    let row = |trigger: &nailnoise_dynamics::network::assembly::Trigger| {
        let on = |on: bool| if on { "on" } else { "off" };
        let times = trigger
            .schedule
            .iter()
            .map(|(time, state)| format!("{} at {:.2} ms", on(*state), 1e3 * time));
        vec![
            trigger.name.clone(),
            on(trigger.starts).to_owned(),
            times.collect::<Vec<_>>().join(", "),
            format!("{} set, {} clear", trigger.set.len(), trigger.clear.len()),
        ]
    };
    Table {
        name: "triggers",
        headings: vec!["trigger", "starts", "schedule", "words"],
        rows: assembly.triggers.iter().map(row).collect(),
    }
}

fn events(tool: &AssembledTool) -> Table {
    let assembly = &tool.resolved.assembly;
    let row = |event: &nailnoise_dynamics::network::assembly::Event| {
        let field = match event.edge {
            Edge::At(_) => "at",
            Edge::Becomes(_) | Edge::Logged(_) => "becomes",
            Edge::Is(_) => "is",
        };
        let text = tool
            .text
            .text_of(&format!("cycle.event.{}.{field}", event.name))
            .unwrap_or_default();
        let after = event
            .after
            .map_or_else(String::new, |after| format!("after {}", assembly.events[after].name));
        let words = event_in_words(&event.name, &event.description);
        vec![words, format!("{field} {text}"), after]
    };
    Table {
        name: "events",
        headings: vec!["event", "happens", ""],
        rows: assembly.events.iter().map(row).collect(),
    }
}

fn outcomes(tool: &AssembledTool) -> Table {
    let rows = tool
        .resolved
        .assembly
        .outcomes
        .iter()
        .map(|outcome| vec![outcome.name.clone()]);
    Table {
        name: "outcomes",
        headings: vec!["outcome, the first that holds"],
        rows: rows.collect(),
    }
}

fn openings(assembly: &Assembly) -> Table {
    let row = |opening: &nailnoise_dynamics::network::assembly::Opening| {
        vec![
            opening.name.clone(),
            assembly.passages[opening.passage].name.clone(),
            format!("{}", opening.count),
            format!("{:.2} mm2", 1e6 * opening.area),
            opening.outlet.clone().unwrap_or_default(),
        ]
    };
    Table {
        name: "openings",
        headings: vec!["opening", "passage", "count", "area", "outlet"],
        rows: assembly.openings.iter().map(row).collect(),
    }
}

/// Areas of each body's faces, and whether its loads are given; both were checked when the file was read.
fn balances(assembly: &Assembly) -> Table {
    let row = |index: usize| {
        let area = |push: Push| -> f64 {
            let of = assembly
                .faces
                .iter()
                .filter(|face| face.body == index && face.push == push);
            // An empty sum would be -0.
            of.map(|face| 1e6 * face.area).sum::<f64>().abs()
        };
        let loads: Vec<&str> = assembly
            .loads
            .iter()
            .filter(|load| load.body == index)
            .map(|load| load.surface.as_str())
            .collect();
        let loads = if loads.is_empty() {
            "not given".to_owned()
        } else {
            format!("add up over {}", loads.join(", "))
        };
        vec![
            assembly.bodies[index].name.clone(),
            format!("{:.1} mm2", area(Push::Down)),
            format!("{:.1} mm2", area(Push::Up)),
            loads,
        ]
    };
    Table {
        name: "balances",
        headings: vec!["balance of", "faces down", "faces up", "loads"],
        rows: (0..assembly.bodies.len()).map(row).collect(),
    }
}

/// Keys that the files define, which `--set` can change.
fn keys(literals: &[Literal]) -> Table {
    let row = |literal: &Literal| {
        let dimension = match literal.kind {
            Kind::Quantity { dimension, .. } => dimension,
            _ => NUMBER,
        };
        let shown = |value: f64| quantity_in_words(value, dimension);
        let range = literal
            .range
            .map_or_else(String::new, |[low, high]| format!("{} .. {}", shown(low), shown(high)));
        vec![
            literal.path.clone(),
            shown(literal.si),
            range,
            literal.provenance.clone(),
        ]
    };
    Table {
        name: "keys",
        headings: vec!["key", "value", "range", "provenance"],
        rows: literals.iter().map(row).collect(),
    }
}

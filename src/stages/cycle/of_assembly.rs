//! The shot of a network of blocks.
//!
//! The housing is the body `tool`, the workpiece the body `workpiece`. Loads on the workpiece are those that the
//! assembly names `seat` and `nail`; by default, they are the contacts and fasteners between the workpiece and other
//! bodies.

use std::collections::BTreeMap;

use nailnoise_dynamics::network::assembly::{
    self, Base, Channel, Contact, Expression, Family, Opening, Passage, Quantity, Space,
};
use nailnoise_dynamics::network::{Assembly, LoadHistory, Record};
use nailnoise_dynamics::{CycleRecord, critical_ratio};
use nailnoise_penetration::RateLaw;

use super::shot::{Body, OnWorkpiece, ShotRecord, SummaryFigures, TOOL};

/// The body on which a tool works.
pub(crate) const WORKPIECE: &str = "workpiece";
/// Outcome of a shot to which no outcome of its assembly applies.
pub(crate) const UNNAMED: &str = "unnamed";

impl ShotRecord {
    /// The shot of an assembly.
    pub fn of_assembly(assembly: &Assembly, record: Record) -> Self {
        let of = Histories::new(assembly, &record);
        let atmosphere = assembly.reservoirs.iter().find(|own| own.name == "atmosphere");
        Self {
            sample_interval: record.interval.unwrap_or_default(),
            ambient_pressure: atmosphere.map_or(0.0, |own| own.pressure),
            outcome: record.outcome.clone().unwrap_or_else(|| UNNAMED.to_owned()),
            events: record.events.clone(),
            figures: SummaryFigures::Assembly(figures(assembly, &record)),
            tool: of.body(TOOL).map(|index| of.motion(index)),
            impulse_corrections: of.impulse_corrections(),
            workpiece: of.body(WORKPIECE).map(|index| of.on_workpiece(index)),
            checks: record.checks.clone(),
            record: Box::new(record),
            nailer: None,
        }
    }

    /// The shot of the tool described by keys, from a cycle with the loads on its surfaces.
    pub fn of_keys(cycle: CycleRecord) -> Self {
        Self {
            outcome: cycle.figures.outcome.name().to_owned(),
            figures: SummaryFigures::Keys(Box::new(cycle.figures.summary.clone())),
            checks: cycle.figures.checks.clone(),
            nailer: Some(Box::new(cycle.figures)),
            ..Self::of_assembly(&cycle.assembly, cycle.record)
        }
    }
}

/// Histories of an assembly's record.
struct Histories<'a> {
    assembly: &'a Assembly,
    record: &'a Record,
    samples: usize,
}

impl<'a> Histories<'a> {
    fn new(assembly: &'a Assembly, record: &'a Record) -> Self {
        Self {
            assembly,
            record,
            samples: record.len(),
        }
    }

    /// Index of a body.
    fn body(&self, name: &str) -> Option<usize> {
        self.assembly.bodies.iter().position(|body| body.name == name)
    }

    /// A quantity of a block; zero for one without a history.
    fn quantity(&self, block: &str, quantity: &str) -> Vec<f64> {
        let found = self.record.get(&format!("{block}.{quantity}"));
        found.map_or_else(|| vec![0.0; self.samples], <[f64]>::to_vec)
    }

    fn motion(&self, body: usize) -> Body {
        let name = &self.assembly.bodies[body].name;
        Body {
            position: self.quantity(name, "position"),
            velocity: self.quantity(name, "velocity"),
            acceleration: self.quantity(name, "acceleration"),
        }
    }

    fn on_workpiece(&self, body: usize) -> OnWorkpiece {
        let named = |surface: &str| {
            let mut loads = self.record.loads.iter();
            let load = loads.find(|own| own.body == WORKPIECE && own.surface == surface);
            load.map(|own| own.force.clone())
        };
        let seat = named("seat").unwrap_or_else(|| self.contacts_on(body));
        let fasteners: Vec<&str> = self.fasteners_in(body).collect();
        let nose = self.record.get("nose.force");
        OnWorkpiece {
            motion: self.motion(body),
            nose: nose.map_or_else(|| seat.clone(), <[f64]>::to_vec),
            fastener: named("nail").unwrap_or_else(|| self.signed_sum(fasteners.iter().map(|name| (*name, 1.0)))),
            deepest: match fasteners.first() {
                Some(name) => self.quantity(name, "deepest"),
                None => vec![0.0; self.samples],
            },
            fastener_speed: self.fastener_speed(body),
            seat,
        }
    }

    /// Speed of the first fastener that enters a body, relative to the body, if its resistance depends on speed. The
    /// fastener moves with its driver.
    fn fastener_speed(&self, body: usize) -> Option<Vec<f64>> {
        let mut fasteners = self.assembly.fasteners.iter();
        let fastener = fasteners.find(|own| own.into == Base::Body(body))?;
        let by_speed = matches!(&fastener.law, assembly::FastenerLaw::Wood(law) if law.wood.rate == RateLaw::Speed);
        by_speed.then(|| {
            let [driver, work] = [fastener.driver, body].map(|own| self.motion(own).velocity);
            let pairs = driver.iter().zip(&work);
            pairs.map(|(driver, work)| (driver - work).max(0.0)).collect()
        })
    }

    fn fasteners_in(&self, body: usize) -> impl Iterator<Item = &str> {
        let all = self.assembly.fasteners.iter();
        all.filter(move |own| own.into == Base::Body(body))
            .map(|own| own.name.as_str())
    }

    /// Force of other bodies on a body through contacts, springs and friction, positive downwards; supports on the
    /// ground are excluded.
    fn contacts_on(&self, body: usize) -> Vec<f64> {
        let (a, against) = (self.assembly, |base: Base| base == Base::Body(body));
        let apart = |base: Base| base != Base::Ground;
        // The force of contact and friction is on `against`, that of a spring on `on`.
        let contacts = a.contacts.iter().map(|own| (&own.name, own.on, own.against, 1.0));
        let frictions = a.frictions.iter().map(|own| (&own.name, own.on, own.against, 1.0));
        let springs = a.springs.iter().map(|own| (&own.name, own.on, own.against, -1.0));
        let all = contacts.chain(frictions).chain(springs);
        self.signed_sum(all.filter_map(|(name, on, other, sign)| {
            let sign = if against(other) {
                sign
            } else if on == body && apart(other) {
                -sign
            } else {
                return None;
            };
            Some((name.as_str(), sign))
        }))
    }

    /// Sum of forces of blocks with signs.
    fn signed_sum<'b>(&self, blocks: impl Iterator<Item = (&'b str, f64)>) -> Vec<f64> {
        let mut sum = vec![0.0; self.samples];
        for (block, sign) in blocks {
            let force = self.quantity(block, "force");
            sum.iter_mut().zip(force).for_each(|(sum, force)| *sum += sign * force);
        }
        sum
    }

    /// Corrections for bodies that strike stops of the housing, at the stop closer to each body. A body that drives a
    /// fastener is excluded, because the impact on its fastener also changes its velocity.
    fn impulse_corrections(&self) -> Vec<LoadHistory> {
        let (a, Some(tool)) = (self.assembly, self.body(TOOL)) else {
            return Vec::new();
        };
        let mut corrections = Vec::new();
        for (body, own) in a.bodies.iter().enumerate() {
            if a.fasteners.iter().any(|fastener| fastener.driver == body) {
                continue;
            }
            let stops: Vec<(usize, &Contact)> = a
                .contacts
                .iter()
                .enumerate()
                .filter(|(_, contact)| contact.on == body && contact.against == Base::Body(tool))
                .collect();
            let surfaces: Vec<&str> = stops.iter().filter_map(|(index, _)| surface_of(a, *index)).collect();
            if stops.is_empty() || surfaces.len() < stops.len() {
                continue;
            }
            let names = stops.iter().map(|(_, stop)| (stop.name.as_str(), 1.0));
            let correction = impulse_correction(
                own.mass,
                &self.motion(body),
                &self.signed_sum(names),
                self.record.interval.unwrap_or_default(),
            );
            let travel = self.quantity(&own.name, "travel");
            let nearest = |x: f64| {
                let gap = |stop: &Contact| (x - stop.at).abs();
                let pairs = stops.iter().enumerate();
                let least = pairs.min_by(|(_, (_, a)), (_, (_, b))| gap(a).total_cmp(&gap(b)));
                least.map_or(0, |(place, _)| place)
            };
            let nearest: Vec<usize> = travel.into_iter().map(nearest).collect();
            for (place, surface) in surfaces.iter().enumerate() {
                let here = nearest.iter().zip(&correction);
                corrections.push(LoadHistory {
                    body: TOOL.to_owned(),
                    surface: (*surface).to_owned(),
                    force: here
                        .map(|(at, force)| if *at == place { *force } else { 0.0 })
                        .collect(),
                });
            }
        }
        corrections
    }
}

/// Mean force of a body on its stiff stops around each sample, minus the `sampled` force, positive downwards \[N\].
///
/// The body may leave a stiff stop within less than a sampling interval. Between two samples at an interval h, its
/// momentum changes by M (v' - v). The mean of the smooth forces, gas, spring, friction and weight (M a + F), accounts
/// for part of the change; the rest is the impulse of the stops. Half of it is assigned to each of the two samples.
fn impulse_correction(mass: f64, body: &Body, sampled: &[f64], interval: f64) -> Vec<f64> {
    let smooth = |n: usize| mass * body.acceleration[n] + sampled[n];
    let mut forces: Vec<f64> = sampled.iter().map(|force| -force).collect();
    for n in 1..sampled.len() {
        let gained = mass * (body.velocity[n] - body.velocity[n - 1]) / interval;
        let force = 0.5 * (smooth(n - 1) + smooth(n)) - gained;
        forces[n - 1] += 0.5 * force;
        forces[n] += 0.5 * force;
    }
    // Half an interval is missing at each end, where the body is at rest.
    if let Some(last) = sampled.len().checked_sub(1) {
        for end in [0, last] {
            forces[end] += 0.5 * sampled[end];
        }
    }
    forces
}

/// The surface of the housing whose load contains the force of a contact.
fn surface_of(assembly: &Assembly, contact: usize) -> Option<&str> {
    let channel = Channel {
        block: assembly::BlockRef {
            family: Family::Contact,
            index: contact,
        },
        quantity: Quantity::Force,
    };
    let mut loads = assembly.loads.iter();
    let on_tool = |load: &&assembly::Load| assembly.bodies[load.body].name == TOOL;
    let load = loads.find(|load| on_tool(load) && contains(&load.force, channel))?;
    Some(&load.surface)
}

/// A contact that stops a body at a surface of the housing.
pub(crate) struct StopOnHousing<'a> {
    pub(crate) contact: &'a Contact,
    pub(crate) surface: &'a str,
}

/// Linear contacts of bodies that drive no fastener with named surfaces of the housing. Their blows are short, so that
/// the stiffness of the housing at the surface matters.
pub(crate) fn stops_on_housing(assembly: &Assembly) -> Vec<StopOnHousing<'_>> {
    let drives = |body: usize| assembly.fasteners.iter().any(|own| own.driver == body);
    let on_tool = |base: Base| matches!(base, Base::Body(index) if assembly.bodies[index].name == TOOL);
    let contacts = assembly.contacts.iter().enumerate();
    let stops = contacts.filter(|(_, own)| on_tool(own.against) && !drives(own.on) && own.exponent == 1.0);
    let on_surface = |(index, contact)| {
        let surface = surface_of(assembly, index)?;
        Some(StopOnHousing { contact, surface })
    };
    stops.filter_map(on_surface).collect()
}

/// Whether an expression contains a channel.
fn contains(expression: &Expression, channel: Channel) -> bool {
    match expression {
        Expression::Channel(own) => *own == channel,
        Expression::Constant(_) | Expression::Sensor(_) => false,
        Expression::Negative(inner) => contains(inner, channel),
        Expression::Binary(_, left, right) => contains(left, channel) || contains(right, channel),
        Expression::Function(_, parts) => parts.iter().any(|part| contains(part, channel)),
    }
}

/// SI unit of a figure of [`figures`], from its name.
pub(crate) fn figure_unit(figure: &str) -> &'static str {
    if figure.starts_with("speed_") {
        "m/s"
    } else if figure.ends_with("_force") {
        "N"
    } else if figure.ends_with("_depth") {
        "m"
    } else if figure.ends_with("_fraction") {
        ""
    } else {
        "kg"
    }
}

/// Figures of a shot, named after the blocks of its assembly.
fn figures(assembly: &Assembly, record: &Record) -> BTreeMap<String, f64> {
    let mut figures = BTreeMap::new();
    for peak in &record.peaks {
        figures.insert(format!("peak_{}_force", peak.block), peak.force);
    }
    for strike in &record.strikes {
        figures.insert(format!("speed_before_{}", strike.fastener), strike.before);
        figures.insert(format!("speed_after_{}", strike.fastener), strike.after);
    }
    for fastener in &assembly.fasteners {
        let deepest = record.get(&format!("{}.deepest", fastener.name));
        if let Some(depth) = deepest.and_then(|history| history.last()) {
            figures.insert(format!("{}_depth", fastener.name), *depth);
        }
    }
    for (opening, mass) in assembly.openings.iter().zip(discharged_masses(assembly, record)) {
        figures.extend(mass.map(|mass| (format!("{}_mass", opening.name), mass)));
    }
    for volume in assembly.volumes.iter().filter(|volume| volume.exhaust_path) {
        if let Some(fraction) = choked_fraction(assembly, record, &volume.name) {
            figures.insert(format!("{}_choked_fraction", volume.name), fraction);
        }
    }
    figures
}

/// Fraction of the gas that leaves a volume of the exhaust's path, to a reservoir or to the next volume of the path,
/// while the atmosphere is below the critical fraction of the volume's pressure. For the N80CB, this is the criterion
/// of the thesis, P_a/P_1. None if no gas leaves.
fn choked_fraction(assembly: &Assembly, record: &Record, volume: &str) -> Option<f64> {
    let pressure = record.get(&format!("{volume}.pressure"))?;
    let atmosphere = assembly.reservoirs.iter().find(|own| own.name == "atmosphere")?;
    let critical = critical_ratio(assembly.heat_capacity_ratio);
    let is_here = |space: Space| matches!(space, Space::Volume(index) if assembly.volumes[index].name == volume);
    let is_further = |space: Space| match space {
        Space::Reservoir(_) => true,
        Space::Volume(index) => assembly.volumes[index].exhaust_path,
    };
    let (mut choked, mut total) = (0.0, 0.0);
    for passage in &assembly.passages {
        let sign = if is_here(passage.from) && is_further(passage.to) {
            1.0
        } else if is_here(passage.to) && is_further(passage.from) {
            -1.0
        } else {
            continue;
        };
        let flows = record.get(&format!("{}.mass_flow", passage.name))?;
        for (flow, pressure) in flows.iter().map(|flow| (sign * flow).max(0.0)).zip(pressure) {
            total += flow;
            if atmosphere.pressure < critical * pressure {
                choked += flow;
            }
        }
    }
    (total > 0.0).then(|| choked / total)
}

/// Balances of the mass that leaves a tool for its surroundings, by name and sign: of passages from a volume to a
/// reservoir, and of openings that are written the other way. The mass that a supply hose fills in is not included.
pub(crate) fn outflows(assembly: &Assembly) -> Vec<(String, f64)> {
    let is_opening = |index| assembly.openings.iter().any(|opening| opening.passage == index);
    let passages = assembly.passages.iter().enumerate();
    let leaves = passages.filter(|(index, own)| match (own.from, own.to) {
        (Space::Volume(_), Space::Reservoir(_)) => true,
        (Space::Reservoir(_), Space::Volume(_)) => is_opening(*index),
        _ => false,
    });
    leaves.map(|(_, own)| outflow(own)).collect()
}

/// Name and sign of the balance of a passage to a reservoir, written in either direction.
fn outflow(passage: &Passage) -> (String, f64) {
    let sign = if matches!(passage.to, Space::Reservoir(_)) {
        1.0
    } else {
        -1.0
    };
    (format!("mass.{}", passage.name), sign)
}

/// Net mass that leaves through each opening \[kg\]; none if the record does not balance it.
pub(crate) fn discharged_masses(assembly: &Assembly, record: &Record) -> Vec<Option<f64>> {
    let mass = |opening: &Opening| {
        let (balance, sign) = outflow(assembly.passages.get(opening.passage)?);
        Some(sign * record.integral(&balance)?)
    };
    assembly.openings.iter().map(mass).collect()
}

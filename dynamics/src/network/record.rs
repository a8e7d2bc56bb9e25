//! Results of a run: named channels on a uniform grid, events, log, ledger and checks.

use std::collections::HashMap;

use nailnoise_quantities::Check;
use serde::Serialize;

use super::assembly::{Family, PressurePatch, Space};
use super::error::RunError;
use super::mode::Mode;
use super::plan::{Pair, Plan};
use super::probe::{Probe, Program};
use super::rates::Workspace;

/// History of a quantity on the grid of samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// `block.quantity`, or the name of a sensor.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Values at multiples of the sample interval.
    pub values: Vec<f64>,
}

/// Time of a named event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventTime {
    /// Name.
    pub name: String,
    /// Time \[s\]; none if it did not happen.
    pub time: Option<f64>,
}

/// A change of a block.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogEntry {
    /// Time \[s\].
    pub time: f64,
    /// Name of the block.
    pub block: String,
    /// Name of the restriction of a series; empty elsewhere.
    pub restriction: String,
    /// What happened.
    pub word: &'static str,
}

/// Flow through an opening to the atmosphere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlowHistory {
    /// Name of the opening.
    pub name: String,
    /// Mass flow out of the tool \[kg/s\].
    pub mass_flow: Vec<f64>,
    /// Pressure before the restriction \[Pa\].
    pub pressure: Vec<f64>,
    /// Pressure behind it \[Pa\].
    pub back_pressure: Vec<f64>,
    /// Temperature of the gas where the flow comes from \[K\].
    pub temperature: Vec<f64>,
    /// Whether the restriction is choked.
    pub choked: Vec<bool>,
}

/// Force on a named surface of a body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadHistory {
    /// Name of the body.
    pub body: String,
    /// Name of the surface.
    pub surface: String,
    /// Force, down \[N\].
    pub force: Vec<f64>,
}

/// Pressure on a wall that leaves no net force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressureHistory {
    /// Name of the body.
    pub body: String,
    /// Name of the surface.
    pub surface: String,
    /// Pressure, above the divide if there is one \[Pa\].
    pub pressure: Vec<f64>,
    /// Pressure below the divide \[Pa\]; empty without one.
    pub below: Vec<f64>,
    /// Position of the divide \[m\]; empty without one.
    pub divide: Vec<f64>,
}

/// An integral along the run, or an energy lost at events.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LedgerEntry {
    /// What it is: `mass.PASSAGE`, `enthalpy.PASSAGE`, `heat`, `work.BODY`, `dashpot.BLOCK`, `lost.BLOCK`, ...
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value at the end.
    pub value: f64,
}

/// Largest push of a contact or resistance of a fastener, over all steps and samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Peak {
    /// Name of the block.
    pub block: String,
    /// Force \[N\].
    pub force: f64,
}

/// A driver's blow on a fastener.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Strike {
    /// Name of the fastener.
    pub fastener: String,
    /// Time \[s\].
    pub time: f64,
    /// Velocity of the driver before it \[m/s\].
    pub before: f64,
    /// Velocity of the driver behind it \[m/s\].
    pub after: f64,
}

/// Work of the integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Effort {
    /// Accepted steps.
    pub steps: usize,
    /// Steps rejected for their error.
    pub rejected: usize,
    /// Failures of Newton's method.
    pub newton_failures: usize,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Right-hand sides.
    pub evaluations: usize,
    /// Jacobians.
    pub jacobians: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of the mode.
    pub events: usize,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// Interval of the samples \[s\]; none if nothing was sampled.
    pub interval: Option<f64>,
    /// End of the run \[s\].
    pub end: f64,
    /// Histories.
    pub channels: Vec<Channel>,
    /// Times of the named events, in the order of the assembly.
    pub events: Vec<EventTime>,
    /// Changes of blocks in order of time.
    pub log: Vec<LogEntry>,
    /// Name of the outcome, if one's test is satisfied.
    pub outcome: Option<String>,
    /// Flows through the openings that make noise.
    pub openings: Vec<FlowHistory>,
    /// Forces on surfaces.
    pub loads: Vec<LoadHistory>,
    /// Pressures on surfaces.
    pub pressures: Vec<PressureHistory>,
    /// Integrals.
    pub ledger: Vec<LedgerEntry>,
    /// Peaks of contact and fastener forces.
    pub peaks: Vec<Peak>,
    /// Blows on fasteners.
    pub strikes: Vec<Strike>,
    /// Conservation along the run.
    pub checks: Vec<Check>,
    /// Work of the integration.
    pub work: Effort,
    #[serde(skip)]
    index: HashMap<String, usize>,
}

impl Record {
    /// History of a quantity by its name, `piston.travel`.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.index.get(name).map(|i| &self.channels[*i].values[..])
    }

    /// Time of an event by its name; none if it did not happen or is not defined.
    pub fn event(&self, name: &str) -> Option<f64> {
        self.events
            .iter()
            .find(|event| event.name == name)
            .and_then(|event| event.time)
    }

    /// An integral by its name.
    pub fn integral(&self, name: &str) -> Option<f64> {
        self.ledger
            .iter()
            .find(|entry| entry.name == name)
            .map(|entry| entry.value)
    }

    /// Largest force of a contact or a fastener \[N\].
    pub fn peak(&self, block: &str) -> Option<f64> {
        self.peaks
            .iter()
            .find(|peak| peak.block == block)
            .map(|peak| peak.force)
    }

    /// Whether mass, energy and momentum are conserved.
    pub fn is_certified(&self) -> bool {
        self.checks.iter().all(|check| check.ok)
    }

    /// A record from its parts.
    pub(crate) fn new(parts: Parts, recorder: Recorder) -> Self {
        let Parts {
            end,
            events,
            log,
            outcome,
            ledger,
            peaks,
            strikes,
            checks,
            work,
        } = parts;
        Self {
            interval: recorder.interval,
            end,
            channels: recorder.columns.into_iter().map(|column| column.channel).collect(),
            events,
            log,
            outcome,
            openings: recorder.openings.into_iter().map(|opening| opening.history).collect(),
            loads: recorder.loads.into_iter().map(|load| load.history).collect(),
            pressures: recorder
                .pressures
                .into_iter()
                .map(|pressure| pressure.history)
                .collect(),
            ledger,
            peaks,
            strikes,
            checks,
            work,
            index: recorder.index,
        }
    }
}

/// What a record holds beside histories.
pub(crate) struct Parts {
    pub(crate) end: f64,
    pub(crate) events: Vec<EventTime>,
    pub(crate) log: Vec<LogEntry>,
    pub(crate) outcome: Option<String>,
    pub(crate) ledger: Vec<LedgerEntry>,
    pub(crate) peaks: Vec<Peak>,
    pub(crate) strikes: Vec<Strike>,
    pub(crate) checks: Vec<Check>,
    pub(crate) work: Effort,
}

#[derive(Debug)]
enum Source {
    Probe(Probe),
    Program(Program),
}

impl Source {
    #[inline]
    fn value(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        match self {
            Self::Probe(probe) => probe.value(plan, mode, w),
            Self::Program(program) => program.value(plan, mode, w),
        }
    }
}

#[derive(Debug)]
struct Column {
    channel: Channel,
    source: Source,
}

#[derive(Debug)]
struct OpeningColumns {
    history: FlowHistory,
    passage: usize,
    restriction: usize,
    /// +1 if the passage leads out, -1 if it leads in.
    outward: f64,
}

#[derive(Debug)]
struct LoadColumn {
    history: LoadHistory,
    program: Program,
}

#[derive(Debug)]
struct PressureColumns {
    history: PressureHistory,
    pressure: Probe,
    divided: Option<(Probe, Program)>,
}

/// Histories under construction.
#[derive(Debug)]
pub(crate) struct Recorder {
    interval: Option<f64>,
    columns: Vec<Column>,
    index: HashMap<String, usize>,
    openings: Vec<OpeningColumns>,
    loads: Vec<LoadColumn>,
    pressures: Vec<PressureColumns>,
    samples: usize,
}

impl Recorder {
    /// Columns for all blocks; none without an interval.
    pub(crate) fn new(plan: &Plan, interval: Option<f64>) -> Result<Self, RunError> {
        let mut recorder = Self {
            interval,
            columns: Vec::new(),
            index: HashMap::new(),
            openings: Vec::new(),
            loads: Vec::new(),
            pressures: Vec::new(),
            samples: 0,
        };
        if let Some(interval) = interval {
            recorder.describe(plan)?;
            recorder.describe_surfaces(plan)?;
            recorder.reserve((plan.assembly.end / interval) as usize + 2);
        }
        Ok(recorder)
    }

    fn add(&mut self, name: String, unit: &str, source: Source) {
        self.index.insert(name.clone(), self.columns.len());
        self.columns.push(Column {
            channel: Channel {
                name,
                unit: unit.to_owned(),
                values: Vec::new(),
            },
            source,
        });
    }

    fn describe(&mut self, plan: &Plan) -> Result<(), RunError> {
        let a = &plan.assembly;
        let mut probe = |name: &str, quantity: &str, unit: &str, probe: Probe| {
            self.add(format!("{name}.{quantity}"), unit, Source::Probe(probe));
        };
        for (i, body) in a.bodies.iter().enumerate() {
            let name = &body.name;
            let on_parent = Pair {
                on: i,
                against: plan.bodies[i].parent,
            };
            probe(name, "travel", "m", Probe::Travel(on_parent));
            probe(name, "speed", "m/s", Probe::Speed(on_parent));
            if on_parent.against != plan.ground() {
                probe(name, "position", "m", Probe::Position(i));
                probe(name, "velocity", "m/s", Probe::Velocity(i));
            }
            probe(name, "acceleration", "m/s2", Probe::Acceleration(i));
            if plan.bodies[i].fastener.is_some() {
                probe(name, "moving_mass", "kg", Probe::MovingMass(i));
            }
        }
        for (i, volume) in a.volumes.iter().enumerate() {
            probe(&volume.name, "pressure", "Pa", Probe::Pressure(i));
            probe(&volume.name, "temperature", "K", Probe::Temperature(i));
            probe(&volume.name, "mass", "kg", Probe::Mass(i));
        }
        for (i, passage) in a.passages.iter().enumerate() {
            probe(&passage.name, "mass_flow", "kg/s", Probe::MassFlow(i));
            if passage.restrictions.len() > 1 {
                probe(
                    &passage.name,
                    "plenum",
                    "Pa",
                    Probe::Before(i, passage.restrictions.len() - 1),
                );
            }
        }
        for (i, block) in a.contacts.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Contact(i));
        }
        for (i, block) in a.springs.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Spring(i));
        }
        for (i, block) in a.frictions.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Friction(i));
        }
        for (i, block) in a.forces.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Imposed(i));
        }
        for (i, block) in a.motors.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Motor(i));
        }
        for (i, block) in a.holds.iter().enumerate() {
            probe(&block.name, "force", "N", Probe::Hold(i));
        }
        for (i, block) in a.fasteners.iter().enumerate() {
            probe(&block.name, "tip", "m", Probe::Tip(i));
            probe(&block.name, "deepest", "m", Probe::Deepest(i));
            probe(&block.name, "force", "N", Probe::Resistance(i));
            if block.seated.guide_friction > 0.0 {
                probe(&block.name, "guide_force", "N", Probe::Guide(i));
            }
        }
        for sensor in &a.sensors {
            let program = Program::new(plan, &format!("sensor \"{}\"", sensor.name), &sensor.value)?;
            self.add(sensor.name.clone(), &sensor.unit, Source::Program(program));
        }
        for (i, body) in a.bodies.iter().enumerate() {
            if plan.bodies[i].parent == plan.ground() {
                for (alias, quantity) in [("position", "travel"), ("velocity", "speed")] {
                    if let Some(place) = self.index.get(&format!("{}.{quantity}", body.name)).copied() {
                        self.index.insert(format!("{}.{alias}", body.name), place);
                    }
                }
            }
        }
        Ok(())
    }

    fn describe_surfaces(&mut self, plan: &Plan) -> Result<(), RunError> {
        let a = &plan.assembly;
        for opening in &a.openings {
            self.openings.push(OpeningColumns {
                history: FlowHistory {
                    name: opening.name.clone(),
                    mass_flow: Vec::new(),
                    pressure: Vec::new(),
                    back_pressure: Vec::new(),
                    temperature: Vec::new(),
                    choked: Vec::new(),
                },
                passage: opening.passage,
                restriction: opening.restriction,
                outward: match a.passages.get(opening.passage).map(|passage| passage.to) {
                    Some(Space::Reservoir(_)) => 1.0,
                    _ => -1.0,
                },
            });
        }
        let name = |body: usize| a.bodies.get(body).map_or_else(String::new, |body| body.name.clone());
        for load in &a.loads {
            let owner = format!("load \"{}.{}\"", name(load.body), load.surface);
            self.loads.push(LoadColumn {
                history: LoadHistory {
                    body: name(load.body),
                    surface: load.surface.clone(),
                    force: Vec::new(),
                },
                program: Program::new(plan, &owner, &load.force)?,
            });
        }
        let gas = |space: Space| match space {
            Space::Volume(i) => Probe::Pressure(i),
            Space::Reservoir(i) => Probe::Pressure(plan.volumes.len() + i),
        };
        for surface in &a.pressures {
            let owner = format!("pressure \"{}.{}\"", name(surface.body), surface.surface);
            let (pressure, divided) = match &surface.patch {
                PressurePatch::Uniform(space) => (gas(*space), None),
                PressurePatch::Divided { above, below, at } => {
                    (gas(*above), Some((gas(*below), Program::new(plan, &owner, at)?)))
                }
                PressurePatch::Plenum(passage) => {
                    let last = plan
                        .passages
                        .get(*passage)
                        .map_or(0, |p| p.restrictions.len().saturating_sub(1));
                    (Probe::Before(*passage, last), None)
                }
            };
            self.pressures.push(PressureColumns {
                history: PressureHistory {
                    body: name(surface.body),
                    surface: surface.surface.clone(),
                    pressure: Vec::new(),
                    below: Vec::new(),
                    divide: Vec::new(),
                },
                pressure,
                divided,
            });
        }
        Ok(())
    }

    fn reserve(&mut self, n: usize) {
        // Columns of equal length would be at distances of whole pages, and one sample would fill one set of the cache;
        // an offset of a cache line for each column avoids it.
        for (i, column) in self.columns.iter_mut().enumerate() {
            column.channel.values.reserve_exact(n + 8 * i);
        }
    }

    /// Time of the next sample; infinite where nothing is sampled.
    pub(crate) fn next_time(&self) -> f64 {
        self.interval
            .map_or(f64::INFINITY, |interval| self.samples as f64 * interval)
    }

    /// Appends a sample of a state.
    pub(crate) fn push(&mut self, plan: &Plan, t: f64, y: &[f64], mode: &Mode, w: &mut Workspace) {
        plan.instant(y, w);
        plan.flows(t, mode, w, true);
        plan.forces(t, mode, w);
        self.samples += 1;
        for column in &mut self.columns {
            column.channel.values.push(column.source.value(plan, mode, w));
        }
        for opening in &mut self.openings {
            let history = &mut opening.history;
            let [before, behind] = plan.around(opening.passage, opening.restriction, w);
            let mass = opening.outward * w.flow[opening.passage].mass;
            let critical = plan.airs[plan.passages[opening.passage].air].critical;
            let open = plan.passages[opening.passage].is_open(mode);
            history.mass_flow.push(mass);
            history.pressure.push(before);
            history.back_pressure.push(behind);
            history
                .temperature
                .push(Probe::Upstream(opening.passage).value(plan, mode, w));
            history.choked.push(open && behind < critical * before);
        }
        for load in &mut self.loads {
            load.history.force.push(load.program.value(plan, mode, w));
        }
        for surface in &mut self.pressures {
            surface.history.pressure.push(surface.pressure.value(plan, mode, w));
            if let Some((below, at)) = &surface.divided {
                surface.history.below.push(below.value(plan, mode, w));
                surface.history.divide.push(at.value(plan, mode, w));
            }
        }
    }
}

/// Names of the blocks whose peaks are followed.
pub(crate) fn peaked(plan: &Plan) -> Vec<Peak> {
    let a = &plan.assembly;
    let contacts = a.contacts.iter().map(|contact| &contact.name);
    contacts
        .chain(a.fasteners.iter().map(|fastener| &fastener.name))
        .map(|block| Peak {
            block: block.clone(),
            force: 0.0,
        })
        .collect()
}

/// Whether a family's blocks have words in the log that name a restriction.
pub(crate) fn restriction_name(plan: &Plan, family: Family, index: usize, restriction: usize) -> String {
    if family != Family::Passage {
        return String::new();
    }
    let found = plan
        .assembly
        .passages
        .get(index)
        .and_then(|passage| passage.restrictions.get(restriction));
    found.map_or_else(String::new, |restriction| restriction.name.clone())
}

//! Histories on a uniform grid, under construction.

mod reads;

use reads::{BLOCK, Combination, Reads, Source};

use super::assembly::{ColumnValue, JetQuantity, PressurePatch, Space};
use super::error::RunError;
use super::mode::Mode;
use super::numerics::Numerics;
use super::plan::{Pair, Plan};
use super::probe::{Need, Probe, Program};
use super::rates::Workspace;

/// Passages whose flows are in a history or in a force; all if an expression may read any of them.
fn passages(plan: &Plan, sources: &[Source]) -> Vec<(usize, [f64; 2])> {
    let any = |source: &Source| matches!(source, Source::Program(program) if program.need >= Need::Flows);
    let all = sources.iter().any(any);
    let read = |passage: usize| {
        let of = |source: &Source| match source {
            Source::Probe(probe) | Source::Negative(probe) => probe.passage() == Some(passage),
            Source::Program(_) | Source::Combination => false,
        };
        sources.iter().any(of)
    };
    let needed = |passage: &usize| all || plan.passages[*passage].jet || read(*passage);
    let all = (0..plan.passages.len()).filter(needed);
    all.map(|passage| (passage, [f64::NAN; 2])).collect()
}

/// A named history and its position.
#[derive(Debug)]
pub(super) struct Named {
    pub(super) name: String,
    /// Name of its column; empty if another column has that name.
    pub(super) column: String,
    pub(super) unit: String,
    pub(super) place: usize,
}

/// Positions of an opening's histories.
#[derive(Debug)]
pub(super) struct OpeningPlaces {
    pub(super) name: String,
    pub(super) mass_flow: usize,
    pub(super) pressure: usize,
    pub(super) back_pressure: usize,
    pub(super) temperature: usize,
    pub(super) choked: usize,
}

/// Place of the history on a surface of a body.
#[derive(Debug)]
pub(super) struct SurfacePlace {
    pub(super) body: String,
    pub(super) surface: String,
    pub(super) place: usize,
    /// Pressure below the divide, and the divide.
    pub(super) divided: Option<[usize; 2]>,
}

/// Histories under construction.
#[derive(Debug)]
pub(crate) struct Recorder {
    pub(super) interval: Option<f64>,
    /// Names of the channels to record; none for all.
    wanted: Option<&'static [&'static str]>,
    sources: Vec<Source>,
    reads: Reads,
    /// Passages whose flows the histories need, with the pressures inside a series at the last two samples.
    passages: Vec<(usize, [f64; 2])>,
    pub(super) histories: Vec<Vec<f64>>,
    /// Histories that are sums of other columns of the block.
    combinations: Vec<Combination>,
    /// Samples not yet appended, by history; quantities that only combinations read follow the histories.
    block: Vec<f64>,
    rows: usize,
    samples: usize,
    pub(super) columns: Vec<Named>,
    pub(super) openings: Vec<OpeningPlaces>,
    pub(super) loads: Vec<SurfacePlace>,
    pub(super) pressures: Vec<SurfacePlace>,
}

impl Recorder {
    /// Histories for all blocks; none without an interval.
    pub(crate) fn new(plan: &Plan, numerics: &Numerics) -> Result<Self, RunError> {
        let interval = numerics.sample_interval;
        let mut recorder = Self {
            interval,
            wanted: numerics.channels,
            sources: Vec::new(),
            reads: Reads::default(),
            passages: Vec::new(),
            histories: Vec::new(),
            combinations: Vec::new(),
            block: Vec::new(),
            rows: 0,
            samples: 0,
            columns: Vec::new(),
            openings: Vec::new(),
            loads: Vec::new(),
            pressures: Vec::new(),
        };
        if let Some(interval) = interval {
            recorder.describe_gas_and_bodies(plan);
            recorder.describe_forces(plan);
            recorder.describe_sensors(plan)?;
            recorder.describe_columns(plan)?;
            recorder.describe_openings(plan);
            recorder.describe_surfaces(plan)?;
            let n = (plan.assembly.end / interval) as usize + 2;
            recorder.histories = recorder.sources.iter().map(|_| Vec::with_capacity(n)).collect();
            recorder.combine();
            recorder.reads = Reads::new(&recorder.sources);
            recorder.passages = passages(plan, &recorder.sources);
            recorder.block = vec![0.0; BLOCK * recorder.sources.len()];
        }
        Ok(recorder)
    }

    /// The position of a history; equal ones share it.
    fn place(&mut self, source: Source) -> usize {
        if let Some(place) = self.sources.iter().position(|other| *other == source) {
            return place;
        }
        self.sources.push(source);
        self.sources.len() - 1
    }

    /// Turns expressions of linear form into sums of columns, which are computed by vector instructions.
    fn combine(&mut self) {
        for place in 0..self.histories.len() {
            let Source::Program(program) = &self.sources[place] else {
                continue;
            };
            let Some((terms, offset)) = program.linear() else {
                continue;
            };
            let terms = terms.to_vec();
            let terms = terms
                .into_iter()
                .map(|(scale, probe)| (scale, self.place(Source::Probe(probe))));
            let terms = terms.collect();
            self.combinations.push(Combination { place, terms, offset });
            self.sources[place] = Source::Combination;
        }
    }

    fn add(&mut self, block: &str, quantity: &str, unit: &str, probe: Probe) {
        let is = |name: &&str| name.strip_prefix(block).and_then(|rest| rest.strip_prefix('.')) == Some(quantity);
        if self.wanted.is_some_and(|wanted| !wanted.iter().any(is)) {
            return;
        }
        let place = self.place(Source::Probe(probe));
        self.columns.push(Named {
            column: format!("{block}_{quantity}"),
            name: format!("{block}.{quantity}"),
            unit: unit.to_owned(),
            place,
        });
    }

    fn describe_gas_and_bodies(&mut self, plan: &Plan) {
        let a = &plan.assembly;
        for (i, body) in a.bodies.iter().enumerate() {
            let name = &body.name;
            let on_parent = Pair {
                on: i,
                against: plan.bodies[i].parent,
            };
            self.add(name, "travel", "m", Probe::Travel(on_parent));
            self.add(name, "speed", "m/s", Probe::Speed(on_parent));
            self.add(name, "position", "m", Probe::Position(i));
            self.add(name, "velocity", "m/s", Probe::Velocity(i));
            self.add(name, "acceleration", "m/s2", Probe::Acceleration(i));
            if plan.bodies[i].fastener.is_some() {
                self.add(name, "moving_mass", "kg", Probe::MovingMass(i));
            }
        }
        for (i, volume) in a.volumes.iter().enumerate() {
            self.add(&volume.name, "pressure", "Pa", Probe::Pressure(i));
            self.add(&volume.name, "temperature", "K", Probe::Temperature(i));
            self.add(&volume.name, "mass", "kg", Probe::Mass(i));
        }
        for (i, passage) in a.passages.iter().enumerate() {
            self.add(&passage.name, "mass_flow", "kg/s", Probe::MassFlow(i));
            if passage.restrictions.len() > 1 {
                self.add(
                    &passage.name,
                    "plenum",
                    "Pa",
                    Probe::Before(i, passage.restrictions.len() - 1),
                );
            }
        }
    }

    fn describe_forces(&mut self, plan: &Plan) {
        let a = &plan.assembly;
        for (i, block) in a.contacts.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Contact(i));
        }
        for (i, block) in a.springs.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Spring(i));
        }
        for (i, block) in a.frictions.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Friction(i));
        }
        for (i, block) in a.forces.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Imposed(i));
        }
        for (i, block) in a.motors.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Motor(i));
        }
        for (i, block) in a.holds.iter().enumerate() {
            self.add(&block.name, "force", "N", Probe::Hold(i));
        }
        for (i, block) in a.fasteners.iter().enumerate() {
            self.add(&block.name, "tip", "m", Probe::Tip(i));
            self.add(&block.name, "deepest", "m", Probe::Deepest(i));
            self.add(&block.name, "force", "N", Probe::Resistance(i));
            if block.seated.guide_friction > 0.0 {
                self.add(&block.name, "guide_force", "N", Probe::Guide(i));
            }
        }
    }

    fn describe_sensors(&mut self, plan: &Plan) -> Result<(), RunError> {
        let wanted = self.wanted;
        let is_wanted = |name: &str| wanted.is_none_or(|wanted| wanted.contains(&name));
        for sensor in plan.assembly.sensors.iter().filter(|sensor| is_wanted(&sensor.name)) {
            let program = Program::new(plan, &format!("sensor \"{}\"", sensor.name), &sensor.value)?;
            let place = self.place(Source::Program(program));
            self.columns.push(Named {
                column: sensor.name.clone(),
                name: sensor.name.clone(),
                unit: sensor.unit.clone(),
                place,
            });
        }
        Ok(())
    }

    /// Columns with names given by the assembly. These names take precedence over those of other channels.
    fn describe_columns(&mut self, plan: &Plan) -> Result<(), RunError> {
        for column in &plan.assembly.columns {
            let named = self.columns.iter().position(|own| own.name == column.channel);
            let at = match named {
                Some(at) => at,
                None if self
                    .wanted
                    .is_some_and(|wanted| !wanted.contains(&column.name.as_str())) =>
                {
                    continue;
                }
                None => {
                    let source = match &column.value {
                        ColumnValue::Expression(value) => {
                            Source::Program(Program::new(plan, &format!("column \"{}\"", column.name), value)?)
                        }
                        ColumnValue::Jet(opening, quantity) => {
                            let own = &plan.assembly.openings[*opening];
                            Source::Probe(match quantity {
                                JetQuantity::Pressure => Probe::Before(own.passage, own.restriction),
                                JetQuantity::BackPressure => Probe::Behind(own.passage, own.restriction),
                                JetQuantity::Temperature => Probe::Upstream(own.passage),
                            })
                        }
                    };
                    let place = self.place(source);
                    self.columns.push(Named {
                        column: String::new(),
                        name: column.name.clone(),
                        unit: column.unit.clone(),
                        place,
                    });
                    self.columns.len() - 1
                }
            };
            for own in self.columns.iter_mut().filter(|own| own.column == column.name) {
                own.column.clear();
            }
            self.columns[at].column.clone_from(&column.name);
        }
        Ok(())
    }

    fn describe_openings(&mut self, plan: &Plan) {
        for opening in &plan.assembly.openings {
            let (i, restriction) = (opening.passage, opening.restriction);
            let outward = matches!(plan.assembly.passages[i].to, Space::Reservoir(_));
            let mass_flow = Probe::MassFlow(i);
            let mut probe = |probe| self.place(Source::Probe(probe));
            let places = OpeningPlaces {
                name: opening.name.clone(),
                mass_flow: 0,
                pressure: probe(Probe::Before(i, restriction)),
                back_pressure: probe(Probe::Behind(i, restriction)),
                temperature: probe(Probe::Upstream(i)),
                choked: probe(Probe::ChokedAt(i, restriction)),
            };
            let source = if outward {
                Source::Probe(mass_flow)
            } else {
                Source::Negative(mass_flow)
            };
            let mass_flow = self.place(source);
            self.openings.push(OpeningPlaces { mass_flow, ..places });
        }
    }

    fn describe_surfaces(&mut self, plan: &Plan) -> Result<(), RunError> {
        let a = &plan.assembly;
        for load in &a.loads {
            let body = a.bodies[load.body].name.clone();
            let owner = format!("load \"{body}.{}\"", load.surface);
            let place = self.place(Source::Program(Program::new(plan, &owner, &load.force)?));
            self.loads.push(SurfacePlace {
                body,
                surface: load.surface.clone(),
                place,
                divided: None,
            });
        }
        let gas = |space: Space| match space {
            Space::Volume(i) => Source::Probe(Probe::Pressure(i)),
            Space::Reservoir(i) => Source::Probe(Probe::Pressure(plan.volumes.len() + i)),
        };
        for surface in &a.pressures {
            let body = a.bodies[surface.body].name.clone();
            let (place, divided) = match &surface.patch {
                PressurePatch::Uniform(space) => (self.place(gas(*space)), None),
                PressurePatch::Divided { above, below, at } => {
                    let owner = format!("pressure \"{body}.{}\"", surface.surface);
                    let below = self.place(gas(*below));
                    let at = self.place(Source::Program(Program::new(plan, &owner, at)?));
                    (self.place(gas(*above)), Some([below, at]))
                }
                PressurePatch::Plenum(passage) => {
                    let opening = a.openings.iter().find(|opening| opening.passage == *passage);
                    let last = plan.passages[*passage].restrictions.len() - 1;
                    let restriction = opening.map_or(last, |opening| opening.restriction);
                    (self.place(Source::Probe(Probe::Before(*passage, restriction))), None)
                }
            };
            self.pressures.push(SurfacePlace {
                body,
                surface: surface.surface.clone(),
                place,
                divided,
            });
        }
        Ok(())
    }

    /// Time of the next sample; infinite if nothing is sampled.
    pub(crate) fn next_time(&self) -> f64 {
        self.interval
            .map_or(f64::INFINITY, |interval| self.samples as f64 * interval)
    }

    /// Appends a sample of a state.
    pub(crate) fn push(&mut self, plan: &Plan, t: f64, y: &[f64], mode: &Mode, w: &mut Workspace) {
        plan.instant(y, mode, w);
        for (passage, [before, last]) in &mut self.passages {
            // The trend of the last two samples.
            plan.flow_through(*passage, t, mode, w, Some(2.0 * *last - *before));
            (*before, *last) = (*last, w.flow[*passage].between[0]);
        }
        plan.forces(t, mode, w);
        let row = self.rows;
        self.reads.copy(plan, mode, w, &mut self.block, row);
        for place in &self.reads.others {
            self.block[place * BLOCK + row] = self.sources[*place].value(plan, mode, w);
        }
        self.samples += 1;
        self.rows += 1;
        if self.rows == BLOCK {
            self.flush();
        }
    }

    /// Appends the collected rows to the histories.
    pub(super) fn flush(&mut self) {
        for combination in &self.combinations {
            combination.evaluate(&mut self.block);
        }
        for (column, history) in self.block.chunks_exact(BLOCK).zip(&mut self.histories) {
            history.extend_from_slice(&column[..self.rows]);
        }
        self.rows = 0;
    }
}

//! From a design to ranked sources: cycle, bodies, response, radiation, exhaust.
//!
//! Each stage is a function of the design and of what stands before it; none keeps state.

mod bodies;
mod changes;
mod coupling;
mod cycle;
mod exhaust;
mod geometry;
mod intervals;
mod microphones;
mod missing;
mod notes;
mod outside;
mod pattern;
mod preset;
mod radiation;
mod radiator;
mod ranking;
mod report;
mod response;
mod sensors;
mod settings;
mod shank;
mod sides;
mod sound;
mod springs;
mod starts;
mod tool;
mod tool_loads;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::Weighting;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::transient::ModalResponse;

pub use bodies::{Body, Structure, modes_of, table, tool_body, workpiece};
pub use coupling::{COUPLED_LOADS, Coupled, couple};
pub use cycle::{cycle, parameters};
pub use exhaust::exhaust_openings;
pub use geometry::{BodyKind, Geometry, Origin, import, needs_gmsh, tool_dimensions};
pub use intervals::SoundPower;
pub use microphones::Microphones;
pub(crate) use microphones::SAMPLE_RATE;
pub(crate) use outside::open_air;
pub use preset::{Preset, cycle_as_published};
pub use sensors::SensorRecord;
pub use settings::cycle_settings;
pub use tool::{Stiffness, Tool};

use radiator::Radiator;

use crate::cache::Cache;
use crate::design::{BodyModel, Coupling, Design, SupportKind};
use crate::error::Error;
use crate::result::{Check, DesignId, RunResult, SCHEMA, Timing};

/// Is told how far a run has got.
pub trait Observer {
    /// A stage begins.
    fn stage(&mut self, name: &str);
    /// Something the user should know beside the result.
    fn note(&mut self, text: &str);
    /// So many items of the stage are done, of so many in all.
    fn done(&mut self, _items: u64, _of: u64) {}
}

/// Listens to nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn stage(&mut self, _: &str) {}
    fn note(&mut self, _: &str) {}
}

/// A body with what the shot did to it.
#[derive(Clone, Copy)]
pub struct Driven<'a> {
    /// The body.
    pub body: &'a Body,
    /// The response that it is part of.
    pub response: &'a ModalResponse,
    /// Its place in that response.
    pub index: usize,
    /// Fourier transforms of its modal accelerations.
    pub spectra: &'a ModalSpectra,
}

/// A result with the histories and fields behind it.
pub struct Run {
    /// What the run tells.
    pub result: RunResult,
    /// The nailing cycle.
    pub record: CycleRecord,
    /// The bodies with their modes.
    pub structure: Structure,
    /// Their response to the shot.
    pub response: ModalResponse,
    /// Fourier transforms of the modal accelerations, one set a body.
    pub spectra: Vec<ModalSpectra>,
    /// The tool's body, unless it is rigid.
    pub tool: Option<Tool>,
    /// A-weighted sound power of every source over time, loudest source first.
    pub powers: Vec<SoundPower>,
    /// Screech frequency of the exhaust's jets at every sample of the cycle \[Hz\]; none while they are subsonic.
    pub screech: Vec<Option<f64>>,
    /// What the design's sensors record, by name.
    pub sensors: Vec<SensorRecord>,
    /// What microphones around the device hear of each source.
    pub microphones: Microphones,
}

impl Run {
    /// All elastic bodies: the workpiece, what it stands on, the tool.
    pub fn driven(&self) -> impl Iterator<Item = Driven<'_>> {
        let of_structure = |(index, (body, spectra))| Driven {
            body,
            response: &self.response,
            index,
            spectra,
        };
        self.structure
            .bodies()
            .zip(&self.spectra)
            .enumerate()
            .map(of_structure)
            .chain(self.tool.as_ref().map(Tool::driven))
    }
}

/// What a run may change about the physics without being another design; for studies and tests of laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Factor on the forces of the shot on the workpiece \[-\].
    pub workpiece_force_scale: f64,
}

impl Default for Options {
    /// The design as it is.
    fn default() -> Self {
        Self {
            workpiece_force_scale: 1.0,
        }
    }
}

/// Predicts and ranks the sound power of a design's sources.
///
/// Modes and radiation matrices that `cache` holds are not computed again; the result is the same.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub fn run(design: &Design, options: Options, cache: &Cache, observer: &mut dyn Observer) -> Result<Run, Error> {
    // Dense products inside a stage stay on one thread: a result must not depend on how many there are.
    let mut timing = Timing::default();
    let two_way = design.support.coupling == Coupling::TwoWay;
    let lumped = if two_way {
        None
    } else {
        observer.stage("nailing cycle");
        Some(timing.time("cycle", || cycle(design))?)
    };
    observer.stage("modes of the workpiece");
    let block = timing.time("workpiece modes", || workpiece(design, cache))?;
    let worktable = match design.support.kind {
        SupportKind::Worktable => {
            observer.stage("modes of the worktable");
            Some(timing.time("worktable modes", || table(design, cache))?)
        }
        SupportKind::Sandbox | SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs => None,
    };
    let tool = match design.body.model {
        BodyModel::Elastic => {
            observer.stage("modes of the tool");
            Some(timing.time("tool modes", || tool_body(design, cache))?)
        }
        BodyModel::Rigid => None,
    };
    let structure = Structure {
        workpiece: block,
        worktable,
        grid: bodies::contact_grid(design),
    };
    observer.stage("radiation matrices");
    let air = Air::at(design.ambient.temperature, design.ambient.pressure)?;
    let radiator = timing.time("radiation matrices", || {
        Radiator::new(design, &structure, &air, cache, observer)
    })?;
    cache.take_notes().iter().for_each(|note| observer.note(note));
    let damping = design
        .acoustics
        .radiation_damping
        .then(|| timing.time("radiation damping", || radiator.damping(&structure)));
    let added = damping.as_deref();
    let parameters = parameters(design)?;
    let (record, response, coupling) = match lumped {
        Some(record) => {
            observer.stage("response of workpiece and support");
            let force_scale = options.workpiece_force_scale;
            let response = timing.time("response", || {
                response::response(design, &structure, added, &parameters, &record, (force_scale, 0))
            })?;
            (record, response, None)
        }
        None => {
            observer.stage("nailing cycle with workpiece and support");
            let both = timing.time("cycle and response", || {
                response::coupled(design, &structure, added, &parameters, 0)
            })?;
            (both.record, both.response, Some((both.work, both.checks)))
        }
    };
    let tool = tool
        .map(|body| timing.time("tool response", || Tool::new(design, body, &parameters, &record)))
        .transpose()?;
    let shot = sensors::Shot {
        structure: &structure,
        response: &response,
        tool: tool.as_ref(),
        record: &record,
    };
    let sensors = timing.time("sensors", || sensors::sensors(design, shot))?;
    observer.stage("radiation");
    let spectra = timing.time("modal spectra", || {
        radiation::modal_spectra(design, &structure, &response)
    })?;
    let workpiece = timing.time("radiation", || {
        radiation::workpiece(design, &structure, &radiator, added, &spectra)
    })?;
    let body = timing.time("body", || match &tool {
        Some(tool) => tool.sound(design, &record, &air),
        None => radiation::rigid_tool(design, &record, &air),
    })?;
    observer.stage("exhaust");
    let exhaust = timing.time("exhaust", || exhaust::exhaust(design, &record, &air))?;

    let range = [design.analysis.range_low, design.analysis.range_high];
    let mut missing = missing::above_top(design, &structure, &workpiece.spectrum);
    missing.extend(
        tool.as_ref()
            .and_then(|tool| missing::above_tool_top(design, tool, &body.spectrum)),
    );
    let notes = notes::notes(
        design,
        &record,
        &response,
        &workpiece,
        &exhaust,
        &missing,
        tool.as_ref(),
    );
    notes.iter().for_each(|note| observer.note(note));
    let sounds = [&workpiece, &exhaust.sound, &body];
    let (mut ranking, total) = ranking::rank(&sounds, range);
    let tool_end = tool.as_ref().map_or(0.0, |tool| tool.response.duration());
    let end = response
        .duration()
        .max(tool_end)
        .max(record.sample_interval * record.len() as f64);
    observer.stage("microphones");
    let microphones = timing.time("microphones", || {
        let inputs = microphones::Inputs {
            structure: &structure,
            radiator: &radiator,
            spectra: &spectra,
            record: &record,
            workpiece: &workpiece,
            body: &body,
            exhaust: &exhaust,
            end,
        };
        microphones::microphones(design, &air, &inputs)
    })?;
    let (powers, interval_checks) = timing.time("intervals", || {
        intervals::intervals(&sounds, &mut ranking, &record.events, end, range)
    });
    let mut checks: Vec<Check> = record.checks.iter().map(Check::from).collect();
    structure.bodies().for_each(|body| checks.extend(body.checks()));
    checks.extend(response::checks(&response));
    checks.extend(coupling.iter().flat_map(|(_, checks)| checks.clone()));
    if let Some(tool) = &tool {
        checks.extend(tool.body.checks());
        checks.extend(tool.checks.iter().cloned());
    }
    checks.extend(missing.iter().map(missing::Missing::check));
    checks.extend(workpiece.radiation.as_ref().and_then(report::check));
    checks.extend(ranking::checks(&ranking, &total));
    checks.extend(interval_checks);
    checks.push(exhaust.check());
    let coupling = match coupling {
        Some((work, _)) => {
            observer.stage("the same one way, to compare");
            let (lumped, sources) = timing.time("one way", || {
                let record = cycle(design)?;
                let force = (options.workpiece_force_scale, 0);
                let response = response::response(design, &structure, added, &parameters, &record, force)?;
                let spectra = radiation::modal_spectra(design, &structure, &response)?;
                let workpiece = radiation::workpiece_energy(design, &radiator, &spectra)?;
                let body = match &tool {
                    Some(_) => {
                        let tool = Tool::new(design, tool_body(design, cache)?, &parameters, &record)?;
                        tool.sound(design, &record, &air)?
                    }
                    None => radiation::rigid_tool(design, &record, &air)?,
                };
                let exhaust = exhaust::exhaust(design, &record, &air)?;
                Ok::<_, Error>((record, [workpiece, exhaust.sound.spectrum, body.spectrum]))
            })?;
            Some(changes::changes(
                work,
                (&lumped, &sources),
                (&record, &ranking, &total),
                range,
            ))
        }
        None => None,
    };
    let starts = if design.analysis.starts > 1 {
        observer.stage("other starts");
        let first = workpiece.spectrum.level(range, Weighting::A);
        timing.time("other starts", || {
            starts::starts(design, &structure, &radiator, first, |start| {
                match design.support.coupling {
                    Coupling::OneWay => {
                        let force = (options.workpiece_force_scale, start);
                        response::response(design, &structure, added, &parameters, &record, force)
                    }
                    Coupling::TwoWay => Ok(response::coupled(design, &structure, added, &parameters, start)?.response),
                }
            })
        })?
    } else {
        None
    };
    if let Some(starts) = &starts {
        starts::widen(&mut ranking, starts);
    }
    let result = RunResult {
        schema: SCHEMA,
        design: DesignId {
            name: design.name().to_owned(),
            digest: design.digest(),
        },
        inputs: design.entries().into_iter().map(Into::into).collect(),
        ranking,
        total,
        outcome: record.outcome,
        cycle: record.summary.clone(),
        events: record.events,
        coupling,
        starts,
        sensors: sensors.iter().map(SensorRecord::level).collect(),
        microphones: microphones.report.clone(),
        checks,
        notes,
        timing,
    };
    Ok(Run {
        result,
        record,
        structure,
        response,
        spectra,
        tool,
        powers,
        screech: exhaust.screech,
        sensors,
        microphones,
    })
}

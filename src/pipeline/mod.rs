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
mod missing;
mod notes;
mod pattern;
mod preset;
mod radiation;
mod ranking;
mod response;
mod sensors;
mod settings;
mod shank;
mod sides;
mod sound;
mod starts;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::Weighting;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::transient::ModalResponse;

pub use bodies::{Body, Structure, modes_of, table, workpiece};
pub use coupling::{COUPLED_LOADS, Coupled, couple};
pub use cycle::{cycle, parameters};
pub use exhaust::exhaust_openings;
pub use geometry::{BodyKind, Geometry, Origin, import, needs_gmsh, tool_dimensions};
pub use intervals::SoundPower;
pub use preset::{Preset, cycle_as_published};
pub use sensors::SensorRecord;
pub use settings::cycle_settings;

use crate::cache::Cache;
use crate::design::{Coupling, Design, SupportKind};
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
    /// A-weighted sound power of every source over time, loudest source first.
    pub powers: Vec<SoundPower>,
    /// Screech frequency of the exhaust's jets at every sample of the cycle \[Hz\]; none while they are subsonic.
    pub screech: Vec<Option<f64>>,
    /// What the design's sensors record, by name.
    pub sensors: Vec<SensorRecord>,
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
/// Modes that `cache` holds are not computed again; the result is the same.
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
        SupportKind::Sandbox | SupportKind::Floor | SupportKind::Clamped => None,
    };
    cache.take_notes().iter().for_each(|note| observer.note(note));
    let structure = Structure {
        workpiece: block,
        worktable,
        grid: bodies::contact_grid(design),
    };
    let parameters = parameters(design)?;
    let (record, response, coupling) = match lumped {
        Some(record) => {
            observer.stage("response of workpiece and support");
            let force_scale = options.workpiece_force_scale;
            let response = timing.time("response", || {
                response::response(design, &structure, &parameters, &record, (force_scale, 0))
            })?;
            (record, response, None)
        }
        None => {
            observer.stage("nailing cycle with workpiece and support");
            let both = timing.time("cycle and response", || {
                response::coupled(design, &structure, &parameters, 0)
            })?;
            (both.record, both.response, Some((both.work, both.checks)))
        }
    };
    let sensors = timing.time("sensors", || sensors::sensors(design, &structure, &response, &record))?;
    observer.stage("radiation");
    let air = Air::at(design.ambient.temperature, design.ambient.pressure)?;
    let spectra = timing.time("modal spectra", || {
        radiation::modal_spectra(design, &structure, &response)
    })?;
    let workpiece = timing.time("radiation", || radiation::workpiece(design, &structure, &spectra, &air))?;
    let body = timing.time("body", || radiation::tool_body(design, &record, &air))?;
    observer.stage("exhaust");
    let exhaust = timing.time("exhaust", || exhaust::exhaust(design, &record, &air))?;

    let range = [design.analysis.range_low, design.analysis.range_high];
    let missing = missing::above_top(design, &structure, &workpiece.spectrum);
    let notes = notes::notes(design, &record, &response, &exhaust, &missing);
    notes.iter().for_each(|note| observer.note(note));
    let sounds = [&workpiece, &exhaust.sound, &body];
    let (mut ranking, total) = ranking::rank(&sounds, range);
    let end = response.duration().max(record.sample_interval * record.len() as f64);
    let (powers, interval_checks) = timing.time("intervals", || {
        intervals::intervals(&sounds, &mut ranking, &record.events, end, range)
    });
    let mut checks: Vec<Check> = record.checks.iter().map(Check::from).collect();
    structure.bodies().for_each(|body| checks.extend(body.checks()));
    checks.extend(response::checks(&response));
    checks.extend(coupling.iter().flat_map(|(_, checks)| checks.clone()));
    checks.extend(missing.iter().map(missing::Missing::check));
    checks.extend(ranking::checks(&ranking, &total));
    checks.extend(interval_checks);
    checks.push(exhaust.check());
    let coupling = match coupling {
        Some((work, _)) => {
            observer.stage("the same one way, to compare");
            let mut one_way = design.clone();
            one_way.support.coupling = Coupling::OneWay;
            one_way.analysis.starts = 1;
            let other = timing.time("one way", || run(&one_way, options, cache, &mut Silent))?;
            Some(changes::changes(
                work,
                (&other.record, &other.result),
                (&record, &ranking, &total),
            ))
        }
        None => None,
    };
    let starts = if design.analysis.starts > 1 {
        observer.stage("other starts");
        let first = workpiece.spectrum.level(range, Weighting::A);
        timing.time("other starts", || {
            starts::starts(design, &structure, &air, first, |start| match design.support.coupling {
                Coupling::OneWay => {
                    let force = (options.workpiece_force_scale, start);
                    response::response(design, &structure, &parameters, &record, force)
                }
                Coupling::TwoWay => Ok(response::coupled(design, &structure, &parameters, start)?.response),
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
        powers,
        screech: exhaust.screech,
        sensors,
    })
}

//! From a design to ranked sources: cycle, bodies, response, radiation, exhaust.
//!
//! Each stage is a function of the design and of what stands before it; none keeps state.

mod bodies;
mod cycle;
mod pictures;
mod preset;
mod radiation;
mod radiator;
mod report;
mod sensors;
mod told;
mod tool;
mod tool_sound;
mod vibration;

use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::transient::ModalResponse;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use crate::stages::response::{COUPLED_LOADS, Coupled, couple};
pub use crate::stages::sensors::SensorRecord;
pub use crate::stages::tool_response::Stiffness;
pub use bodies::{GraphBody, Structure, modes_of, tool_body, workpiece};
pub use cycle::cycle;
pub use pictures::{Picture, Pictures, Series, Shape, pictures};
pub use preset::{Preset, cycle_as_published};

pub use tool::Tool;
pub use vibration::Vibration;

use told::{Told, TwoWay, told};
use vibration::{Bench, Moved, moved};

use crate::design::inputs;
pub use crate::design::inputs::bodies::geometry;
pub use crate::design::inputs::cycle::{cycle_settings, parameters};
use crate::design::inputs::microphones;
use crate::design::{Coupling, Design, SupportKind};
use crate::error::Error;
use crate::result::{Check, DesignId, RunResult, SCHEMA, Timing};
use crate::stages::Progress;
pub use crate::stages::bodies::{Body, BodyKind};
use crate::stages::exhaust::{ExhaustSource, noise};
pub use crate::stages::microphones::Microphones;
pub(crate) use crate::stages::microphones::SAMPLE_RATE;
pub use crate::stages::ranking::SoundPower;
use crate::stages::truncation::Truncation;
use crate::stages::{changes, notes, ranking, sound};
use crate::store::Store;

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

/// A result with the histories behind it.
pub struct Run {
    /// What the run tells.
    pub result: RunResult,
    /// The nailing cycle.
    pub record: CycleRecord,
    /// A-weighted sound power of every source over time, loudest source first.
    pub powers: Vec<SoundPower>,
    /// Screech frequency of the exhaust's jets at every sample of the cycle \[Hz\]; none while they are subsonic.
    pub screech: Vec<Option<f64>>,
    /// What the design's sensors record, by name.
    pub sensors: Vec<SensorRecord>,
    /// What microphones around the device hear of each source.
    pub microphones: Microphones,
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
/// What `cache` holds of it is not computed again; the result is the same.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub fn run(design: &Design, options: Options, cache: &Store, progress: &Progress) -> Result<Run, Error> {
    let stage = ("sound of the bodies", |_: &Vibration, _: &CycleRecord| Ok(()));
    let (run, ()) = run_telling(design, options, cache, progress, stage, &|_| ())?;
    Ok(run)
}

/// A run with its bodies in motion, which only their modes and radiation matrices are taken from the cache for.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub fn run_in_full(
    design: &Design,
    options: Options,
    cache: &Store,
    progress: &Progress,
) -> Result<(Run, Vibration), Error> {
    let mut timing = Timing::default();
    let bench = Bench::new(design, options, cache)?;
    let lumped = match design.support.coupling {
        Coupling::OneWay => Some(driving(design, &mut timing, progress)?),
        Coupling::TwoWay => None,
    };
    let all = in_full(&bench, lumped, &mut timing, progress, |_, _| Ok(()))?;
    let of_bodies = (all.moved.record, all.told, all.two_way);
    let run = finish(&bench, of_bodies, all.exhaust, timing, progress)?;
    Ok((run, all.moved.vibration))
}

/// A shot with its bodies in motion, and what was made of them.
struct InFull<T> {
    moved: Moved,
    told: Told,
    two_way: Option<TwoWay>,
    exhaust: ExhaustSource,
    more: T,
}

/// Sets the bodies in motion; what they tell, what `tell` makes of them and how the exhaust sounds need nothing of each
/// other.
fn in_full<T: Send>(
    bench: &Bench<'_>,
    lumped: Option<CycleRecord>,
    timing: &mut Timing,
    progress: &Progress,
    tell: impl FnOnce(&Vibration, &CycleRecord) -> Result<T, Error> + Send,
) -> Result<InFull<T>, Error> {
    let (moved, body, exhaust) = moved(bench, lumped, timing, progress)?;
    let [mut of_telling, mut of_exhaust] = [Timing::default(), Timing::default()];
    let (told, (more, exhaust)) = rayon::join(
        || told(bench, &moved, body, timing, progress),
        || {
            rayon::join(
                || of_telling.time("telling", || tell(&moved.vibration, &moved.record)),
                || match exhaust {
                    Some(exhaust) => Ok(exhaust),
                    None => of_exhaust.time("exhaust", || bench.exhaust(&moved.record, moved.end())),
                },
            )
        },
    );
    timing.0.extend(of_telling.0.into_iter().chain(of_exhaust.0));
    let (told, two_way) = told?;
    Ok(InFull {
        moved,
        told,
        two_way,
        more: more?,
        exhaust: exhaust?,
    })
}

/// A run with what `tell` makes of its bodies in motion. Where a cycle drives them one way both are kept as `stage`, and
/// a design whose bodies move and radiate alike needs neither modes nor motion; where it needs them, `beside` sees the
/// cycle's record while the bodies move.
///
/// # Errors
/// [`Error`] of the stage that could not be computed, and those of `tell`.
pub(crate) fn run_telling<T: Serialize + DeserializeOwned + Send>(
    design: &Design,
    options: Options,
    cache: &Store,
    progress: &Progress,
    (stage, tell): (&str, impl FnOnce(&Vibration, &CycleRecord) -> Result<T, Error> + Send),
    beside: &(dyn Fn(&CycleRecord) + Sync),
) -> Result<(Run, T), Error> {
    let mut timing = Timing::default();
    let bench = Bench {
        beside,
        ..Bench::new(design, options, cache)?
    };
    if design.support.coupling == Coupling::TwoWay {
        let all = in_full(&bench, None, &mut timing, progress, tell)?;
        let of_bodies = (all.moved.record, all.told, all.two_way);
        return Ok((finish(&bench, of_bodies, all.exhaust, timing, progress)?, all.more));
    }
    let record = driving(design, &mut timing, progress)?;
    let key = told::key(design, options, &record);
    let mut found = None;
    let (told, more) = cache.get_or(stage, key, || {
        let all = in_full(&bench, Some(record.clone()), &mut timing, progress, tell)?;
        found = Some(all.exhaust);
        Ok::<_, Error>((all.told, all.more))
    })?;
    let exhaust = match found {
        Some(exhaust) => exhaust,
        None => {
            progress.stage("exhaust");
            timing.time("exhaust", || bench.exhaust(&record, told.end))?
        }
    };
    Ok((finish(&bench, (record, told, None), exhaust, timing, progress)?, more))
}

/// The cycle with its own lumped workpiece.
fn driving(design: &Design, timing: &mut Timing, progress: &Progress) -> Result<CycleRecord, Error> {
    progress.stage("nailing cycle");
    timing.time("cycle", || cycle(design))
}

/// The noise of a cycle's openings one by one, for what hears them at a place
/// ([`ExhaustNoise::at`](nailnoise_acoustics::exhaust::ExhaustNoise::at)): exhaust holes, a muffler's outlet where there is
/// one, trigger vent.
///
/// # Errors
/// Openings, plenum or muffler that cannot be, air that leaves against a higher pressure.
pub fn exhaust_openings(
    design: &Design,
    record: &CycleRecord,
) -> Result<Vec<nailnoise_acoustics::exhaust::ExhaustNoise>, Error> {
    Ok(noise(&inputs::exhaust::openings(design)?, record)?.1.openings)
}

/// From what bodies and exhaust tell to the result: ranking, intervals, checks and notes.
fn finish(
    bench: &Bench<'_>,
    (record, told, two_way): (CycleRecord, Told, Option<TwoWay>),
    exhaust: ExhaustSource,
    mut timing: Timing,
    progress: &Progress,
) -> Result<Run, Error> {
    let design = bench.design;
    let [workpiece, body] = &told.sources;
    let ExhaustSource {
        source: jets,
        details: exhaust,
        received,
    } = exhaust;
    let support = inputs::notes::support(design);
    let of_notes = notes::NoteInputs {
        support: &support,
        in_sand: design.support.kind == SupportKind::Sandbox,
        range_high: design.analysis.range_high,
        radiation: [workpiece.radiation.as_ref(), body.radiation.as_ref()],
        stiffness: told.stiffness.as_ref().map(|both| {
            both.each_ref().map(|own| notes::ContactStiffness {
                place: &own.place,
                body: own.body,
                contact: own.contact,
            })
        }),
        truncations: told.truncations.iter().map(Truncation::note).collect(),
        ending: &told.ending,
        idle_sensors: inputs::sensors::without_body(design),
        limited_sensors: inputs::sensors::limited(design),
        idle_springs: design.idle_springs(),
    };
    let notes = notes::notes(&of_notes, &record, &inputs::exhaust::openings(design)?, &exhaust);
    notes.iter().for_each(|note| progress.note(note));
    let range = [design.analysis.range_low, design.analysis.range_high];
    let sources = [workpiece, &jets, body];
    let (mut ranking, total) = ranking::rank(&sources, range);
    progress.stage("microphones");
    let microphones = timing.time("microphones", || {
        let [of_workpiece, of_body] = &told.heard;
        microphones::array(design)?.measurement(
            &microphones::room(design),
            [of_workpiece, &received, of_body],
            told.end,
        )
    })?;
    let powers = ranking::powers(&ranking, &sources, told.end);
    let interval_checks = ranking::interval_checks(&ranking, &sources, design.acoustics.bem_tolerance);
    let mut checks: Vec<Check> = record.checks.iter().map(Check::from).collect();
    let [of_response, of_tool] = told.checks.clone();
    checks.extend(of_response);
    checks.extend(two_way.iter().flat_map(|both| both.checks.clone()));
    checks.extend(of_tool);
    checks.extend(told.truncations.iter().map(Truncation::check));
    for source in [workpiece, body] {
        let report = source.radiation.as_ref();
        checks.extend(report.and_then(|report| report::check(&source.spectrum.source, report)));
    }
    checks.extend(ranking::checks(&ranking, &total));
    checks.extend(interval_checks);
    checks.push(exhaust.check());
    let coupling = two_way.map(|both| {
        let (lumped, sources) = &both.one_way;
        changes::changes(both.work, (lumped, sources), (&record, &ranking, &total), range)
    });
    if let Some(starts) = &told.starts {
        ranking::widen(&mut ranking, starts);
    }
    timing.end(bench.begin);
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
        starts: told.starts,
        sensors: told.sensors.iter().map(SensorRecord::level).collect(),
        microphones: microphones.report.clone(),
        checks,
        notes,
        timing,
    };
    Ok(Run {
        result,
        record,
        powers,
        screech: exhaust.screech,
        sensors: told.sensors,
        microphones,
    })
}

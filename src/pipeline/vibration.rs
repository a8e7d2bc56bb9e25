//! The bodies of a shot, set in motion by the cycle or together with it.

use std::time::Instant;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::{CouplingWork, CycleRecord};
use nailnoise_fem::transient::ModalResponse;

use super::bodies::GraphBody;
use super::radiator::{Radiator, tool_radiation};
use super::sensors;
use super::sound::Sound;
use super::{Body, BodyKind, Driven, Options, Structure, Tool, bodies, radiation};
use crate::design::inputs;
use crate::design::{BodyModel, Carrier, Design, SupportKind};
use crate::error::Error;
use crate::result::{Check, Timing};
use crate::stages::Progress;
use crate::stages::exhaust::{ExhaustSource, exhaust};
use crate::stages::response;
use crate::stages::sensors::{BodySensors, SensorMotion};
use crate::store::Store;

/// The bodies of a shot in motion.
pub struct Vibration {
    /// Workpiece and support with their modes.
    pub structure: Structure,
    /// Their response to the shot.
    pub response: ModalResponse,
    /// Fourier transforms of the modal accelerations, one set a body.
    pub spectra: Vec<ModalSpectra>,
    /// The tool's body, unless it is rigid.
    pub tool: Option<Tool>,
}

impl Vibration {
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

/// Everything that moves, and how it radiates.
pub(super) struct Moved {
    pub(super) record: CycleRecord,
    pub(super) vibration: Vibration,
    /// Acceleration at the sensors on workpiece and support.
    pub(super) sensors: Vec<SensorMotion>,
    /// How workpiece and support radiate.
    pub(super) radiator: Radiator,
    /// Damping ratios that radiation adds to their modes.
    pub(super) damping: Option<Vec<Vec<f64>>>,
    /// Work and checks of a coupling with the cycle.
    pub(super) coupling: Option<(CouplingWork, Vec<Check>)>,
}

impl Moved {
    /// When the last record ends \[s\].
    pub(super) fn end(&self) -> f64 {
        let Vibration { response, tool, .. } = &self.vibration;
        let of_tool = tool.as_ref().map(|tool| &tool.response);
        end(&self.record, std::iter::once(response).chain(of_tool))
    }
}

/// The same of a cycle and of responses.
fn end<'a>(record: &CycleRecord, responses: impl IntoIterator<Item = &'a ModalResponse>) -> f64 {
    let longest = responses.into_iter().map(ModalResponse::duration).fold(0.0, f64::max);
    longest.max(record.sample_interval * record.len() as f64)
}

/// What a stage of a run works with.
pub(super) struct Bench<'a> {
    pub(super) design: &'a Design,
    pub(super) options: Options,
    pub(super) air: Air,
    pub(super) cache: &'a Store,
    /// What can be done with the cycle's record alone, while the response keeps one core and no more.
    pub(super) beside: &'a (dyn Fn(&CycleRecord) + Sync),
    /// When the run began.
    pub(super) begin: Instant,
}

impl<'a> Bench<'a> {
    /// With the air of a design.
    ///
    /// # Errors
    /// Those of the air.
    pub(super) fn new(design: &'a Design, options: Options, cache: &'a Store) -> Result<Self, Error> {
        Ok(Self {
            design,
            options,
            air: Air::at(design.ambient.temperature, design.ambient.pressure)?,
            cache,
            beside: &|_| (),
            begin: Instant::now(),
        })
    }

    /// The exhaust of a shot whose records last until `end` \[s\].
    ///
    /// # Errors
    /// Those of the acoustics.
    pub(super) fn exhaust(&self, record: &CycleRecord, end: f64) -> Result<ExhaustSource, Error> {
        exhaust(
            &inputs::exhaust::openings(self.design)?,
            &inputs::exhaust::outlet(self.design),
            &inputs::microphones::array(self.design)?,
            record,
            end,
        )
    }
}

/// Sets the bodies in motion, by the cycle given or together with one both ways; the sound of the tool's body, and that of the
/// exhaust where there was time for it.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub(super) fn moved(
    bench: &Bench<'_>,
    lumped: Option<CycleRecord>,
    timing: &mut Timing,
    progress: &Progress,
) -> Result<(Moved, Sound, Option<ExhaustSource>), Error> {
    let (design, cache) = (bench.design, bench.cache);
    // Neither workpiece with support nor the tool's body knows of the other.
    let (of_structure, of_tool) = std::thread::scope(|scope| {
        let of_tool = scope.spawn(|| {
            let mut timing = Timing::default();
            let body = match design.body.model {
                BodyModel::Elastic => {
                    let body = || bodies::driven(design, BodyKind::Tool, cache, progress);
                    Some(timing.time("tool modes", body)?)
                }
                BodyModel::Rigid => None,
            };
            let side = match &lumped {
                Some(record) => {
                    let (tool, sound) = tool_in_motion(bench, body, record, &mut timing, progress)?;
                    // No response is longer than that of a housing, whose flight does not decay: the end is known.
                    let end = tool.as_ref().map(|tool| end(record, [&tool.response]));
                    let exhaust = end.map(|end| {
                        let exhaust = timing.time("exhaust", || bench.exhaust(record, end))?;
                        Ok::<_, Error>((end, exhaust))
                    });
                    (bench.beside)(record);
                    ToolSide::Moved(Box::new((tool, sound, exhaust.transpose()?)))
                }
                None => ToolSide::Still(Box::new(body)),
            };
            Ok::<_, Error>((side, timing))
        });
        let of_structure = structure_side(bench, lumped.as_ref(), timing, progress);
        let of_tool = of_tool.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        (of_structure, of_tool)
    });
    let StructureSide {
        structure,
        radiator,
        damping,
        response,
        spectra,
        sensors,
        coupled,
    } = of_structure?;
    let (of_tool, of_tool_timing) = of_tool?;
    timing.0.extend(of_tool_timing.0);
    let (record, coupling) = match (lumped, coupled) {
        (_, Some((record, work, checks))) => (record, Some((work, checks))),
        (Some(record), None) => (record, None),
        (None, None) => unreachable!("a cycle is given, or comes from a coupled run"),
    };
    let (tool, body, exhaust) = match of_tool {
        ToolSide::Moved(moved) => *moved,
        ToolSide::Still(body) => {
            let (tool, body) = tool_in_motion(bench, *body, &record, timing, progress)?;
            (tool, body, None)
        }
    };
    let moved = Moved {
        record,
        vibration: Vibration {
            structure,
            response,
            spectra,
            tool,
        },
        sensors,
        radiator,
        damping,
        coupling,
    };
    let exhaust = exhaust
        .filter(|(end, _)| *end == moved.end())
        .map(|(_, exhaust)| exhaust);
    Ok((moved, body, exhaust))
}

/// The tool's side of a run: at rest while its cycle is not known.
enum ToolSide {
    Still(Box<Option<GraphBody>>),
    Moved(Box<ToolInMotion>),
}

/// The elastic tool, its sound, and the exhaust with the end of the records that it was computed for \[s\].
type ToolInMotion = (Option<Tool>, Sound, Option<(f64, ExhaustSource)>);

/// What a cycle does to the tool's body, a rigid one without modes, and how it sounds.
fn tool_in_motion(
    bench: &Bench<'_>,
    body: Option<GraphBody>,
    record: &CycleRecord,
    timing: &mut Timing,
    progress: &Progress,
) -> Result<(Option<Tool>, Sound), Error> {
    let Bench {
        design, ref air, cache, ..
    } = *bench;
    let tool = match body {
        Some(body) => {
            let bem = timing.time("radiation matrices of the tool", || {
                tool_radiation(design, &body, air, cache, progress)
            })?;
            Some(timing.time("tool response", || Tool::new(design, (body, bem), record))?)
        }
        None => None,
    };
    let sound = timing.time("body", || match &tool {
        Some(tool) => tool.sound(design, record, air),
        None => radiation::rigid_tool_twice(design, record, air),
    })?;
    Ok((tool, sound))
}

/// The side of workpiece and support.
struct StructureSide {
    structure: Structure,
    radiator: Radiator,
    /// Damping ratios that radiation adds.
    damping: Option<Vec<Vec<f64>>>,
    response: ModalResponse,
    spectra: Vec<ModalSpectra>,
    /// Acceleration at the sensors on each body.
    sensors: Vec<SensorMotion>,
    /// The cycle of a two-way run, with work and checks of the coupling.
    coupled: Option<(CycleRecord, CouplingWork, Vec<Check>)>,
}

/// Workpiece and support, driven by a cycle or, without one, together with their own.
fn structure_side(
    bench: &Bench<'_>,
    lumped: Option<&CycleRecord>,
    timing: &mut Timing,
    progress: &Progress,
) -> Result<StructureSide, Error> {
    let Bench {
        design,
        options,
        ref air,
        cache,
        ..
    } = *bench;
    let structure = modes(design, cache, timing, progress)?;
    progress.stage("radiation matrices");
    let radiator = timing.time("radiation matrices", || {
        Radiator::new(design, &structure, air, cache, progress)
    })?;
    cache.take_notes().iter().for_each(|note| progress.note(note));
    let damping = design
        .acoustics
        .radiation_damping
        .then(|| timing.time("radiation damping", || radiator.damping(&structure)));
    let added = damping.as_deref();
    let shot = inputs::response::shot(design)?;
    let bodies = shot.modal_bodies(structure.bodies(), added);
    let (response, coupled) = match lumped {
        Some(record) => {
            progress.stage("response of workpiece and support");
            let force_scale = options.workpiece_force_scale;
            let response = timing.time("response", || shot.one_way(&bodies, record, force_scale))?;
            (response, None)
        }
        None => {
            progress.stage("nailing cycle with workpiece and support");
            let both = timing.time("cycle and response", || {
                shot.two_way(&bodies, &inputs::cycle::cycle_settings(design))
            })?;
            (both.response, Some((both.record, both.work, both.checks)))
        }
    };
    let (spectra, sensors) = timing.time("modal spectra", || spectra_and_sensors(bench, &structure, &response))?;
    Ok(StructureSide {
        structure,
        radiator,
        damping,
        response,
        spectra,
        sensors,
        coupled,
    })
}

/// Fourier transforms of every body's modal accelerations, and the accelerations at the sensors on it.
fn spectra_and_sensors(
    bench: &Bench<'_>,
    structure: &Structure,
    response: &ModalResponse,
) -> Result<(Vec<ModalSpectra>, Vec<SensorMotion>), Error> {
    let design = bench.design;
    let carriers = structure.in_graph().zip([Carrier::Workpiece, Carrier::Worktable]);
    let points = carriers.map(|(body, carrier)| {
        let shapes = sensors::shapes(design, carrier, body)?;
        Ok((spectrum_range(design, body), shapes))
    });
    let points: Vec<_> = points.collect::<Result<_, Error>>()?;
    response::modal_spectra(response, points.into_iter())
}

/// Range of the spectra of a body's motion \[Hz\].
pub(super) fn spectrum_range(design: &Design, body: &Body) -> [f64; 2] {
    [design.analysis.range_low, body.top_hz.min(design.analysis.range_high)]
}

/// Fourier transforms of every body's modal accelerations.
pub(super) fn modal_spectra(
    design: &Design,
    structure: &Structure,
    response: &ModalResponse,
) -> Result<Vec<ModalSpectra>, Error> {
    let bodies = structure
        .bodies()
        .map(|body| (spectrum_range(design, body), BodySensors::none(body.omega.len())));
    Ok(response::modal_spectra(response, bodies)?.0)
}

/// Workpiece and support with their modes.
fn modes(design: &Design, cache: &Store, timing: &mut Timing, progress: &Progress) -> Result<Structure, Error> {
    progress.stage("modes of the bodies");
    let body = |kind| bodies::driven(design, kind, cache, progress);
    let workpiece = timing.time("workpiece modes", || body(BodyKind::Workpiece))?;
    let worktable = match design.support.kind {
        SupportKind::Worktable => Some(timing.time("worktable modes", || body(BodyKind::Worktable))?),
        SupportKind::Sandbox | SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs => None,
    };
    Ok(Structure { workpiece, worktable })
}

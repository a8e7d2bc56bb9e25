//! The chain from a design to ranked sources: which stage reads which, from top to bottom.
//!
//! [`Chain::new`] adds the stages of a design to a graph without computing any. [`Chain::run`] (`run.rs`) makes the outputs
//! that a result needs, side by side, and ranks the sources.

mod bodies;
mod motion;
mod radiation;
mod shape;
mod sources;

use std::time::Instant;

use nailnoise_acoustics::exhaust::ExhaustNoise;
use nailnoise_acoustics::levels::SourceSpectrum;
use nailnoise_acoustics::radiator::Loading;
use nailnoise_dynamics::CycleRecord;

use crate::design::{Design, MufflerKind, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::Starts;
use crate::stages::cycle::{Cycle, Preset};
use crate::stages::exhaust::{Cycles, ExhaustSource, noise};
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::requirements::Usable;
use crate::stages::response::{CouplingReport, End, Reported, ResponseChecks, ResponseReport, Vibration};
use crate::stages::sensors::{SensorRecord, Sensors};
use crate::stages::sound_fields::{Fields, SoundFields, ToolField};
use crate::stages::sources::SurfaceSource;
use crate::stages::spectra::{BodyMotion, MovingBody};
use crate::stages::starts::OtherStarts;
use crate::stages::tool_response::{ToolChecks, ToolReport};
use crate::stages::transducers::{PressureRecord, Transducers};
use crate::stages::{Digest, Progress, Stage, Stored};
use bodies::Bodies;
pub use bodies::{BodyStages, CheckedBody, check_bodies, solved_bodies};
use motion::{Driven, Motions};
use radiation::Radiators;
pub use shape::SharedShapes;
use sources::Sources;

/// Changes of the physics for a run of the same design; for studies and tests of laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Factor on the forces of the shot on the workpiece, if a cycle drives it one way \[-\].
    pub workpiece_force_scale: f64,
    /// Seed of the jets' noise at the microphones; its levels do not depend on it.
    pub noise_seed: u32,
    /// Shapes that other designs share.
    pub shared: SharedShapes,
}

impl Default for Options {
    /// The design without changes.
    fn default() -> Self {
        Self {
            workpiece_force_scale: 1.0,
            noise_seed: 0,
            shared: SharedShapes::default(),
        }
    }
}

/// The stages of a design's shot.
pub struct Chain {
    pub(crate) graph: Graph,
    /// Requirements of a run on each body.
    pub(crate) usable: Vec<Stored<Usable>>,
    /// When the run began.
    pub(crate) begin: Instant,
    /// The nailing cycle.
    pub cycle: Stored<CycleRecord>,
    /// Workpiece, and worktable if there is one.
    pub structure: Vec<BodyStages>,
    /// The tool's body, unless it is rigid.
    pub tool: Option<BodyStages>,
    /// Response of workpiece and support.
    pub vibration: Stored<Vibration>,
    /// All elastic bodies in motion: the workpiece, its support, the tool.
    pub moving: Vec<MovingBody>,
    /// End of all records \[s\].
    pub end: Stored<f64>,
    /// The workpiece with its support as a source.
    pub workpiece: Stored<SurfaceSource>,
    /// The exhaust as a source.
    pub exhaust: Stored<ExhaustSource>,
    /// The tool's body as a source.
    pub body: Stored<SurfaceSource>,
    /// Only the levels of all sources.
    pub levels: Stored<Levels>,
    /// Keys of modes and of radiation in standard air, which shots on the same structures share.
    pub(crate) structures: Vec<Digest>,
    /// Signals of the sensors.
    pub sensors: Stored<Vec<SensorRecord>>,
    /// Signals of the pressure transducers.
    pub transducers: Stored<Vec<PressureRecord>>,
    /// Sound fields for inspection.
    pub fields: Stored<Fields>,
    /// Levels of other starts, for a workpiece that can lose contact.
    pub(crate) starts: Option<Stored<Option<Starts>>>,
    /// Checks of workpiece and support.
    pub(crate) response_report: Stored<ResponseChecks>,
    /// Checks of an elastic tool.
    pub(crate) tool_report: Option<Stored<ToolChecks>>,
    /// The same shot one way, for a two-way coupled one.
    pub(crate) one_way: Option<OneWay>,
    /// Linear motion with the frozen and with the complete impedance of the air, if its mass acts.
    pub(crate) loading: Option<ImpedanceComparison>,
    /// As in [`Options`].
    pub(crate) noise_seed: u32,
}

/// A two-way coupled shot and the one-way shot of the same design.
pub(crate) struct OneWay {
    pub(crate) report: Stored<Reported>,
    pub(crate) cycle: Stored<CycleRecord>,
    pub(crate) workpiece: Stored<SourceSpectrum>,
    pub(crate) exhaust: Stored<ExhaustSource>,
    pub(crate) body: Stored<(SourceSpectrum, Option<SourceSpectrum>)>,
}

/// Energies of linear motion with the impedance of the air frozen at each mode's resonance, and with the complete one.
pub(crate) struct ImpedanceComparison {
    /// Of the workpiece.
    pub(crate) workpiece: [Stored<SourceSpectrum>; 2],
    /// Whether the complete one acts on the workpiece of the run; otherwise its contact opens or acts back on the cycle, and
    /// both are of the same shot one way with the contact bonded.
    pub(crate) workpiece_is_linear: bool,
    /// Checks of the bonded motion, if it is not that of the run.
    pub(crate) report: Option<Stored<ResponseChecks>>,
    /// Of an elastic tool by boundary elements, which is linear in every case.
    pub(crate) body: Option<[Stored<(SourceSpectrum, Option<SourceSpectrum>)>; 2]>,
}

impl Chain {
    /// Adds the stages of a design to a graph.
    ///
    /// # Errors
    /// Values of the design that do not yield inputs.
    pub fn new(graph: &Graph, design: &Design, options: Options) -> Result<Self, Error> {
        let (begin, air) = (Instant::now(), inputs::air(design)?);
        let lumped = graph.add(cycle_stage(design)?);
        let bare = without_measured_muffler(design);
        let bodies = Bodies::add(graph, design)?;
        let radiators = Radiators::add(graph, design, &bodies, (air, options.shared))?;

        // Motion.
        let forced = (lumped.clone(), options.workpiece_force_scale);
        let motions = Motions::new(graph, design, (&bodies, &radiators), forced)?;
        let unmuffled = match &bare {
            Some(bare) => {
                let forced = (graph.add(cycle_stage(bare)?), options.workpiece_force_scale);
                Some(Motions::new(graph, bare, (&bodies, &radiators), forced)?)
            }
            None => None,
        };
        // The cycles of the exhaust of a shot, one way or two ways.
        let cycles = |shot: &Stored<CycleRecord>, two_way: bool| Cycles {
            shot: shot.clone(),
            unmuffled: unmuffled.as_ref().map(|bare| bare.driven(0, two_way).cycle),
        };
        let Driven {
            cycle,
            vibration: frozen,
            coupled,
        } = motions.driven(0, motions.two_way);
        let vibration = match motions.is_linear() {
            true => motions.with_complete_impedance(&frozen, &motions.shot),
            false => frozen.clone(),
        };
        let of_structure = motions.analysed(&vibration, true);
        let tool = motions.tool(&cycle);
        let of_tool = tool.as_ref().map(|(_, motion)| motion.clone());
        let all_motions: Vec<Stored<BodyMotion>> = of_structure.iter().chain(&of_tool).cloned().collect();
        let tool_vibration = tool.as_ref().map(|(vibration, _)| vibration);
        let end = graph.add(End {
            cycle: cycle.clone(),
            longest: tool_vibration.unwrap_or(&vibration).clone(),
        });

        // Sources.
        let seed = options.noise_seed;
        let sources = Sources::new(graph, design, (&bodies, &radiators, &motions), (air, seed))?;
        let workpiece_sound = sources.workpiece_sound(&of_structure);
        let body_sound = sources.body_sound(&cycle, of_tool.clone());
        let workpiece = sources.workpiece(&workpiece_sound, (&cycle, &end));
        let of_exhaust = cycles(&cycle, motions.two_way);
        let exhaust = sources.exhaust(&of_exhaust, &end);
        let body = sources.body(body_sound.clone(), &end);
        let sensors = Sensors {
            accelerometers: inputs::sensors::accelerometers(design)?,
            cycle: cycle.clone(),
            vibration: vibration.clone(),
            motions: all_motions,
        };
        let levels = graph.add(ShotLevels {
            workpiece: workpiece_sound,
            openings: sources.openings.clone(),
            body: body_sound,
            cycles: of_exhaust,
            end: end.clone(),
            range_hz: motions.range_hz,
            bodies: bodies.modal().cloned().collect(),
            responses: std::iter::once(&vibration).chain(tool_vibration).cloned().collect(),
            sensors: (!sensors.accelerometers.is_empty()).then(|| sensors.clone()),
        });

        // Beside them: signals, checks, the same shot in other ways, fields.
        let transducers = graph.add(Transducers {
            transducers: inputs::sensors::transducers(design),
            cycle: cycle.clone(),
        });
        let response_report = graph.add(ResponseReport {
            bodies: bodies.structure_bodies(),
            vibration: vibration.clone(),
        });
        let tool_report = bodies.tool.as_ref().zip(tool_vibration).map(|(stages, vibration)| {
            graph.add(ToolReport {
                shot: motions.tool_shot.clone(),
                body: stages.body.clone(),
                vibration: vibration.clone(),
            })
        });
        let starts = (motions.shot.can_lose_contact() && design.analysis.starts > 1).then(|| {
            let others = (1..design.analysis.starts).map(|start| motions.driven(start, motions.two_way).vibration);
            graph.add(OtherStarts {
                first: workpiece.clone(),
                others: others
                    .map(|vibration| sources.energy_without_sensors(&vibration))
                    .collect(),
                range_hz: motions.range_hz,
            })
        });
        let one_way = coupled.map(|both| OneWay {
            report: graph.add(CouplingReport(both)),
            workpiece: sources.energy_without_sensors(&motions.driven(0, false).vibration),
            exhaust: sources.exhaust(&cycles(&lumped, false), &end),
            body: sources.body_energy(&lumped, motions.tool(&lumped).map(|(_, motion)| motion)),
            cycle: lumped.clone(),
        });
        let loading = (radiators.acts == Loading::Full).then(|| {
            let bonded = (!motions.is_linear()).then(|| motions.bonded());
            ImpedanceComparison {
                report: bonded.as_ref().map(|[_, complete]| {
                    graph.add(ResponseReport {
                        bodies: Vec::new(),
                        vibration: complete.clone(),
                    })
                }),
                workpiece: match &bonded {
                    Some(both) => both
                        .each_ref()
                        .map(|vibration| sources.energy_without_sensors(vibration)),
                    None => [
                        sources.energy_without_sensors(&frozen),
                        sources.workpiece_energy(of_structure.clone()),
                    ],
                },
                workpiece_is_linear: bonded.is_none(),
                body: motions
                    .tool_with_frozen_impedance(&cycle)
                    .map(|frozen| [Some(frozen), of_tool.clone()].map(|motion| sources.body_energy(&cycle, motion))),
            }
        });

        let modal = bodies.modal().map(|body| *body.key());
        let structures = modal.chain(radiators.matrix_keys()).collect();
        let of_field = bodies.tool.as_ref().zip(of_tool.clone());
        let fields = graph.add(SoundFields {
            method: radiators.workpiece.field,
            bodies: bodies.structure_bodies(),
            motions: of_structure.clone(),
            tool: of_field.map(|(stages, motion)| ToolField {
                body: stages.body.clone(),
                motion,
                elements: radiators.tool.map(|tool| (tool.elements, tool.whole.radiator)),
                nose: inputs::radiation::nose(design).into(),
            }),
            air,
            cuts: inputs::microphones::cuts(design),
        });
        let moving = bodies.structure.iter().zip(of_structure).enumerate();
        let moving = moving.map(|(index, (stages, motion))| moving_body(stages, (&vibration, index), motion));
        let tool_moving = bodies.tool.as_ref().zip(tool);
        let tool_moving = tool_moving.map(|(stages, (vibration, motion))| moving_body(stages, (&vibration, 0), motion));
        Ok(Self {
            moving: moving.chain(tool_moving).collect(),
            graph: graph.clone(),
            begin,
            sensors: graph.add(sensors),
            structures,
            noise_seed: seed,
            usable: bodies.usable,
            structure: bodies.structure,
            tool: bodies.tool,
            cycle,
            vibration,
            end,
            workpiece,
            exhaust,
            body,
            levels,
            transducers,
            fields,
            starts,
            response_report,
            tool_report,
            one_way,
            loading,
        })
    }
}

fn moving_body(
    stages: &BodyStages,
    (vibration, index): (&Stored<Vibration>, usize),
    motion: Stored<BodyMotion>,
) -> MovingBody {
    MovingBody {
        body: stages.body.clone(),
        loss_factor: stages.loss_factor,
        vibration: vibration.clone(),
        index,
        motion,
    }
}

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] when the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.compute(&Progress::silent())
}

/// Computes the nailing cycle of a design in a published form.
///
/// # Errors
/// As [`cycle`].
pub fn cycle_as_published(design: &Design, preset: Preset) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.published(preset).compute(&Progress::silent())
}

/// The same design without the muffler after its exhaust holes, if the insertion loss of that was measured.
fn without_measured_muffler(design: &Design) -> Option<Design> {
    (design.exhaust.muffler.kind == MufflerKind::InsertionLoss).then(|| {
        let mut bare = design.clone();
        bare.exhaust.muffler.kind = MufflerKind::None;
        bare
    })
}

fn cycle_stage(design: &Design) -> Result<Cycle, Error> {
    Ok(Cycle {
        parameters: inputs::cycle::parameters(design)?,
        settings: inputs::cycle::cycle_settings(design),
    })
}

/// The noise of a cycle's openings one by one, which yields the sound at any place ([`ExhaustNoise::at`]): exhaust
/// holes, a muffler's outlet if present, trigger vent. For a muffler of measured insertion loss, the cycle without it
/// is computed too, one way.
///
/// # Errors
/// Openings, plenum or muffler that cannot be, air that leaves against a higher pressure.
pub fn exhaust_openings(design: &Design, record: &CycleRecord) -> Result<Vec<ExhaustNoise>, Error> {
    let unmuffled = without_measured_muffler(design).as_ref().map(cycle).transpose()?;
    let holes = unmuffled.as_ref().unwrap_or(record);
    Ok(noise(&inputs::exhaust::openings(design)?, holes, record)?.2.openings)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::stages::bodies::BodyKind;
    use crate::stages::sound_fields::FieldMethod;
    use radiation::workpiece_radiation;

    /// Beginnings of keys whose values reach no mesh, no mode and no load vector.
    const BEYOND_BODIES: [&str; 4] = ["acoustics.", "ambient.", "exhaust.", "supply."];

    /// Keys of the stages of all bodies.
    fn keys(design: &Design) -> Vec<Digest> {
        let graph = Graph::default();
        let of_body = |kind| *BodyStages::add(&graph, design, kind, true).unwrap().body.key();
        BodyKind::ALL.map(of_body).to_vec()
    }

    #[test]
    fn values_beyond_the_bodies_leave_their_keys_and_the_density_of_the_wood_changes_that_of_the_workpiece() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let mut other = base.clone();
        let mut changed = 0;
        for (key, kind, value) in base.keys() {
            if BEYOND_BODIES.iter().any(|beyond| key.starts_with(beyond)) {
                let value = crate::design::another(&value, kind).unwrap_or_else(|| panic!("{key} has one value"));
                other.set(&[(key.as_str(), value)]).unwrap();
                changed += 1;
            }
        }
        assert!(changed > 30, "{changed} keys changed");
        assert_eq!(keys(&base), keys(&other));
        let mut denser = base.clone();
        denser.wood.density *= 1.01;
        let [before, after] = [keys(&base), keys(&denser)];
        assert_ne!(before[0], after[0]);
        assert_eq!(before[1..], after[1..]);
    }

    /// Key of the tool's order of elimination.
    fn order(design: &Design) -> Digest {
        let geometry = inputs::bodies::geometry(design, BodyKind::Tool, false).unwrap();
        let graph = Graph::default();
        let mesh = graph.add(geometry.meshing());
        *graph.add(geometry.elimination(mesh)).key()
    }

    #[test]
    fn masses_and_materials_leave_the_order_of_elimination_and_dimensions_change_it() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let mut other = base.clone();
        other.tool.mass *= 1.1;
        other.body.lumped_nose *= 1.1;
        other.body.housing.density *= 1.01;
        assert_eq!(order(&base), order(&other));
        assert_ne!(keys(&base), keys(&other));
        other.piston.bore *= 1.01;
        assert_ne!(order(&base), order(&other));
    }

    /// Keys of the radiation matrices depend only on surfaces and modes.
    #[test]
    fn damping_contact_and_forces_leave_the_radiation_matrices() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        let matrix = |design: &Design| {
            let graph = Graph::default();
            let chain = Chain::new(&graph, design, Options::default()).unwrap();
            let bodies: Vec<_> = chain.structure.iter().map(|stages| stages.body.clone()).collect();
            match workpiece_radiation(
                &graph,
                design,
                &bodies,
                (inputs::air(design).unwrap(), SharedShapes::default()),
            )
            .unwrap()
            .field
            {
                FieldMethod::BoundaryElements(_, matrix) => *matrix.key(),
                FieldMethod::Rayleigh(..) | FieldMethod::Erp => panic!("boundary elements"),
            }
        };
        let mut other = base.clone();
        other.wood.loss_factor *= 2.0;
        other.support.contact.stiffness_per_area *= 2.0;
        other.supply.pressure *= 1.1;
        other.ambient.temperature += 5.0;
        assert_eq!(matrix(&base), matrix(&other));
        other.workpiece.length *= 1.01;
        assert_ne!(matrix(&base), matrix(&other));
    }
}

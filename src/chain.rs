//! The chain from a design to ranked sources: which stage reads which, from top to bottom.
//!
//! [`Chain::new`] adds the stages of a design to a graph without computing any. [`Chain::run`] (`run.rs`) makes the outputs
//! that a result needs, side by side, and ranks the sources.

mod shape;

use std::sync::Arc;
use std::time::Instant;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::exhaust::ExhaustNoise;
use nailnoise_acoustics::levels::SourceSpectrum;
use nailnoise_acoustics::radiator::{Loading, Radiator};
use nailnoise_dynamics::CycleRecord;

use crate::design::inputs;
use crate::design::inputs::bodies::BodyInputs;
use crate::design::{BodyModel, Carrier, Coupling, Design, SupportKind};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::Starts;
use crate::stages::bodies::{
    Body, BodyKind, BodySensors, Discretisation, Meshed, ModalModel, Model, Modes, SensorModes, WholeModes,
};
use crate::stages::cycle::{Cycle, Preset};
use crate::stages::exhaust::{Exhaust, ExhaustSource, noise};
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::radiation::{
    FluidLoadings, FlushMatrix, RadiatingShape, ToolRadiator, WorkpieceMethod, WorkpieceRadiation, WorkpieceRadiator,
};
use crate::stages::requirements::{Radiating, Requirements, Usable};
use crate::stages::response::{
    Coupled, CoupledCycle, CoupledResponse, CoupledVibration, CouplingReport, End, LinearResponse, Reported, Response,
    ResponseChecks, ResponseReport, Shot, Structure, Vibration,
};
use crate::stages::sensors::{SensorRecord, Sensors};
use crate::stages::sound_fields::{FieldMethod, Fields, SoundFields, ToolField};
use crate::stages::sources::{
    BodyEnergy, BodySound, BodySource, Housing, HousingAtMicrophones, SurfaceSource, WorkpieceEnergy,
    WorkpieceRadiated, WorkpieceSound, WorkpieceSource,
};
use crate::stages::spectra::{BodyAnalysis, BodyMotion, MovingBody};
use crate::stages::starts::OtherStarts;
use crate::stages::tool_response::{ToolChecks, ToolReport, ToolResponse};
use crate::stages::transducers::{PressureRecord, Transducers};
use crate::stages::{Digest, Progress, Stage, Stored};
pub use shape::SharedShapes;
use shape::{Standards, by_shape, standards};

/// What a run may change about the physics without being another design; for studies and tests of laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Factor on the forces of the shot on the workpiece, where a cycle drives it one way \[-\].
    pub workpiece_force_scale: f64,
    /// Seed of the jets' noise at the microphones; its levels do not depend on it.
    pub noise_seed: u32,
    /// Shapes that other designs share.
    pub shared: SharedShapes,
}

impl Default for Options {
    /// The design as it is.
    fn default() -> Self {
        Self {
            workpiece_force_scale: 1.0,
            noise_seed: 0,
            shared: SharedShapes::default(),
        }
    }
}

/// The stages of a body.
#[derive(Clone)]
pub struct BodyStages {
    /// Its mesh with materials.
    pub meshed: Stored<Meshed>,
    /// Its finite elements with load vectors.
    pub model: Stored<Model>,
    /// Its modes with their shapes on every node.
    pub modes: Stored<WholeModes>,
    /// The body in modal coordinates.
    pub body: Stored<Body>,
    /// Loss factor of all modes \[-\].
    pub loss_factor: f64,
    /// Frequency up to which its motion is part of the result \[Hz\].
    pub top_hz: f64,
}

impl BodyStages {
    /// Adds the stages of a body of a design, with the places of the shot's forces if it is `driven`.
    ///
    /// # Errors
    /// [`Error::NoSuchBody`] for the worktable of a design without one; those of materials and mesh file.
    pub fn add(graph: &Graph, design: &Design, kind: BodyKind, driven: bool) -> Result<Self, Error> {
        let BodyInputs {
            geometry,
            places,
            below_hz,
            residual_limit,
            loss_factor,
            top_hz,
        } = inputs::bodies::body(design, kind, driven)?;
        let mesh = graph.add(geometry.meshing());
        let order = graph.add(geometry.elimination(mesh.clone()));
        let meshed = graph.add(geometry.attachment(mesh));
        let model = graph.add(Discretisation {
            kind,
            meshed: meshed.clone(),
            places,
        });
        let modes = graph.add(Modes {
            kind,
            model: model.clone(),
            order,
            below_hz,
            residual_limit,
        });
        let body = graph.add(ModalModel {
            kind,
            model: model.clone(),
            modes: modes.clone(),
            top_hz,
            below_hz,
        });
        Ok(Self {
            meshed,
            model,
            modes,
            body,
            loss_factor,
            top_hz,
        })
    }

    /// Displacement of the body's modes at a design's sensors on it; none without sensors.
    fn sensors(&self, graph: &Graph, design: &Design, carrier: Carrier) -> Result<Option<Stored<BodySensors>>, Error> {
        let points = inputs::sensors::points(design, carrier)?;
        let stage = |points| SensorModes {
            points,
            body: self.body.clone(),
            modes: self.modes.clone(),
        };
        Ok((!points.is_empty()).then(|| graph.add(stage(points))))
    }
}

/// Bodies of a design that a run solves.
pub fn solved_bodies(design: &Design) -> Vec<BodyKind> {
    let on_table = design.support.kind == SupportKind::Worktable;
    let mut kinds = vec![BodyKind::Workpiece];
    kinds.extend(on_table.then_some(BodyKind::Worktable));
    kinds.extend((design.body.model == BodyModel::Elastic).then_some(BodyKind::Tool));
    kinds
}

/// Adds what a run requires of a body to a graph; `stages` are those of all its bodies.
fn requirements(
    graph: &Graph,
    design: &Design,
    kind: BodyKind,
    stages: &[(BodyKind, BodyStages)],
) -> Result<Option<Stored<Usable>>, Error> {
    let Some((_, own)) = stages.iter().find(|(other, _)| *other == kind) else {
        return Ok(None);
    };
    let (carrier, radiating) = match kind {
        BodyKind::Tool => {
            let cap = inputs::radiation::cap(design);
            let places = inputs::radiation::tool_places(design);
            let radiating = inputs::radiation::tool(design).map(|elements| Radiating::Tool(elements, cap, places));
            (Carrier::Tool, radiating)
        }
        BodyKind::Workpiece | BodyKind::Worktable => {
            let of = |wanted: BodyKind| stages.iter().find(|(kind, _)| *kind == wanted);
            let structure = [BodyKind::Workpiece, BodyKind::Worktable].into_iter().filter_map(of);
            let meshed = structure.map(|(_, stages)| stages.meshed.clone()).collect();
            let places = inputs::radiation::workpiece_places(design);
            let radiating = Radiating::Workpiece(inputs::radiation::workpiece(design)?, meshed, places);
            let carrier = match kind {
                BodyKind::Worktable => Carrier::Worktable,
                _ => Carrier::Workpiece,
            };
            (carrier, Some(radiating))
        }
    };
    Ok(Some(graph.add(Requirements {
        kind,
        meshed: own.meshed.clone(),
        model: own.model.clone(),
        sensors: inputs::sensors::points(design, carrier)?,
        mass: inputs::bodies::mass(design, kind),
        radiating,
    })))
}

/// A meshed body, and whether a run can use it.
pub struct CheckedBody {
    /// The mesh with materials.
    pub meshed: Arc<Meshed>,
    /// Why a run cannot use it; empty for a body that no run of the design solves.
    pub problems: Vec<Error>,
}

/// Meshes bodies of a design and checks them as a run does before it solves any.
pub fn check_bodies(design: &Design, kinds: &[BodyKind]) -> Vec<Result<CheckedBody, Error>> {
    let (graph, solved) = (Graph::default(), solved_bodies(design));
    let locate = |error| inputs::located(design, error);
    let others = solved.iter().filter(|kind| !kinds.contains(kind));
    let all = kinds.iter().chain(others);
    let added = all.map(|&kind| (kind, BodyStages::add(&graph, design, kind, solved.contains(&kind))));
    // Each mesh before any check: what reads a mesh that failed before no longer knows why.
    let meshed = added.map(|(kind, stages)| {
        let meshed = stages.and_then(|stages| Ok((stages.meshed.get()?, stages)));
        (kind, meshed.map_err(locate))
    });
    let mut meshed: Vec<_> = meshed.collect();
    let stages = meshed
        .iter()
        .filter_map(|(kind, meshed)| Some((*kind, meshed.as_ref().ok()?.1.clone())));
    let stages: Vec<_> = stages.filter(|(kind, _)| solved.contains(kind)).collect();
    let checked = meshed.drain(..kinds.len()).map(|(kind, meshed)| {
        let (meshed, _) = meshed?;
        let usable = requirements(&graph, design, kind, &stages)?;
        let problem = usable.and_then(|usable| usable.get().err());
        let problems = problem.map_or_else(Vec::new, |error| locate(error).parts());
        Ok(CheckedBody { meshed, problems })
    });
    checked.collect()
}

/// The stages of a design's shot.
pub struct Chain {
    pub(crate) graph: Graph,
    /// What a run requires of each body.
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
    /// All elastic bodies in motion: the workpiece, what it stands on, the tool.
    pub moving: Vec<MovingBody>,
    /// End of all records \[s\].
    pub end: Stored<f64>,
    /// The workpiece with its support as a source.
    pub workpiece: Stored<SurfaceSource>,
    /// The exhaust as a source.
    pub exhaust: Stored<ExhaustSource>,
    /// The tool's body as a source.
    pub body: Stored<SurfaceSource>,
    /// Levels of all sources alone.
    pub levels: Stored<Levels>,
    /// Keys of modes and of radiation in standard air: what shots on the same structures share.
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
    /// Linear motion with the frozen and with the complete impedance of the air, where its mass acts.
    pub(crate) loading: Option<ImpedanceComparison>,
    /// As in [`Options`].
    pub(crate) noise_seed: u32,
}

/// A two-way coupled shot beside the one-way shot of the same design.
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
    /// Checks of the bonded motion, where it is not that of the run.
    pub(crate) report: Option<Stored<ResponseChecks>>,
    /// Of an elastic tool by boundary elements, which is linear in every case.
    pub(crate) body: Option<[Stored<(SourceSpectrum, Option<SourceSpectrum>)>; 2]>,
}

/// What sets workpiece and support in motion, and the cycle that goes with it.
struct Driven {
    cycle: Stored<CycleRecord>,
    vibration: Stored<Vibration>,
    coupled: Option<Stored<Coupled>>,
}

impl Chain {
    /// Adds the stages of a design to a graph.
    ///
    /// # Errors
    /// Values of the design from which no inputs can be made.
    #[expect(clippy::too_many_lines, reason = "the chain reads from top to bottom")]
    pub fn new(graph: &Graph, design: &Design, options: Options) -> Result<Self, Error> {
        let (begin, air) = (Instant::now(), inputs::air(design)?);
        let two_way = design.support.coupling == Coupling::TwoWay;
        let lumped = graph.add(cycle_stage(design)?);

        // Bodies: the tool and what it stands on do not affect each other.
        let add = |kind| Ok((kind, BodyStages::add(graph, design, kind, true)?));
        let solved = solved_bodies(design)
            .into_iter()
            .map(add)
            .collect::<Result<Vec<(BodyKind, BodyStages)>, Error>>()?;
        let (tools, structure): (Vec<_>, Vec<_>) =
            solved.iter().cloned().partition(|(kind, _)| *kind == BodyKind::Tool);
        let structure: Vec<BodyStages> = structure.into_iter().map(|(_, stages)| stages).collect();
        let tool = tools.into_iter().next().map(|(_, stages)| stages);
        let bodies: Vec<Stored<Body>> = structure.iter().map(|stages| stages.body.clone()).collect();

        // What a run requires of them, known before any is solved.
        let usable = solved
            .iter()
            .map(|(kind, _)| requirements(graph, design, *kind, &solved));
        let usable = usable.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();

        // Radiation per unit of modal motion, and the damping that it adds to the modes.
        let RadiationStages {
            radiator,
            at_microphones,
            field: field_method,
            matrix_key: workpiece_matrix,
        } = workpiece_radiation(graph, design, &bodies, (air, options.shared))?;
        let acts = inputs::radiation::loading(design);
        let zeta = |bodies: &[&BodyStages]| {
            let zeta = bodies.iter().map(|stages| 0.5 * stages.loss_factor);
            (acts == Loading::Full).then(|| zeta.collect())
        };
        let loads = graph.add(FluidLoadings {
            radiator: radiator.clone(),
            bodies: bodies.clone(),
            with_mass: zeta(&structure.iter().collect::<Vec<_>>()),
        });
        let tool_elements = tool.as_ref().zip(inputs::radiation::tool(design));
        // The modes of a user's housing are its own: no other run has them, and what a standard housing lacks of them may be
        // worth a decibel.
        let standard_tool = match &tool_elements {
            Some(_) if design.body.mesh.is_empty() && options.shared.tool => {
                standards(graph, design, &[BodyKind::Tool])?
            }
            _ => Standards::new(),
        };
        let tool_places = inputs::radiation::tool_places(design);
        let of_tool = |shape: &RadiatingShape, stages: &BodyStages| {
            let body = std::slice::from_ref(&stages.body);
            let radiation = by_shape(graph, (shape, &tool_places), &standard_tool, body);
            let (at_microphones, matrix) = (radiation.at_microphones(graph), radiation.matrix);
            let key = *matrix.key();
            let [alone, at_microphones] =
                [matrix, at_microphones].map(|matrix| graph.add(ToolRadiator { matrix, air }));
            (key, alone, at_microphones)
        };
        let tool_radiation = tool_elements.map(|(stages, elements)| {
            let of_shape = of_tool(&RadiatingShape::Tool(elements.clone()), stages);
            (elements, of_shape)
        });
        let cap = tool
            .as_ref()
            .zip(tool_radiation.as_ref())
            .zip(inputs::radiation::cap(design));
        let cap_radiation =
            cap.map(|((stages, (elements, _)), cap)| of_tool(&RadiatingShape::Cap(elements.clone(), cap), stages));
        let tool_radiator = tool_radiation.as_ref().map(|(_, (_, radiator, _))| radiator.clone());
        let cap_radiator = cap_radiation.as_ref().map(|(_, radiator, _)| radiator.clone());
        let tool_loads = tool.as_ref().zip(tool_radiator.clone()).map(|(stages, radiator)| {
            graph.add(FluidLoadings {
                radiator,
                bodies: vec![stages.body.clone()],
                with_mass: zeta(&[stages]),
            })
        });

        let modal = structure.iter().chain(&tool).map(|stages| *stages.body.key());
        let tool_matrix_key = tool_radiation.as_ref().map(|(_, (key, ..))| *key);
        let cap_matrix_key = cap_radiation.as_ref().map(|(key, ..)| *key);
        let matrices = [workpiece_matrix, tool_matrix_key, cap_matrix_key];
        let structures = modal.chain(matrices.into_iter().flatten()).collect();

        // Motion: of workpiece and support for each start and coupling, of the tool for each cycle.
        let shot = inputs::response::shot(design)?;
        let driven_bodies = Structure {
            bodies: bodies.clone(),
            loss_factors: structure.iter().map(|stages| stages.loss_factor).collect(),
            fluid: acts.damps().then(|| loads.clone()),
        };
        let driven = |start: u32, two_way: bool| {
            let (shot, structure) = (shot.with_start(start), driven_bodies.clone());
            if two_way {
                let both = graph.add(CoupledResponse {
                    shot,
                    structure,
                    cycle: inputs::cycle::cycle_settings(design),
                });
                Driven {
                    cycle: graph.add(CoupledCycle(both.clone())),
                    vibration: graph.add(CoupledVibration(both.clone())),
                    coupled: Some(both),
                }
            } else {
                let response = Response {
                    shot,
                    structure,
                    cycle: lumped.clone(),
                    force_scale: options.workpiece_force_scale,
                };
                Driven {
                    cycle: lumped.clone(),
                    vibration: graph.add(response),
                    coupled: None,
                }
            }
        };
        let range_hz = [design.analysis.range_low, design.analysis.range_high];
        let within = |top_hz: f64| [range_hz[0], top_hz.min(range_hz[1])];
        let carriers = [Carrier::Workpiece, Carrier::Worktable];
        let on_structure = structure.iter().zip(carriers);
        let on_structure = on_structure.map(|(stages, carrier)| stages.sensors(graph, design, carrier));
        let on_structure = on_structure.collect::<Result<Vec<_>, _>>()?;
        let analysed = |vibration: &Stored<Vibration>, with_sensors: bool| -> Vec<Stored<BodyMotion>> {
            let bodies = structure.iter().zip(&on_structure).enumerate();
            let motion = bodies.map(|(index, (stages, sensors))| BodyAnalysis {
                vibration: vibration.clone(),
                index,
                range_hz: within(stages.top_hz),
                sensors: sensors.clone().filter(|_| with_sensors),
            });
            motion.map(|stage| graph.add(stage)).collect()
        };
        let tool_shot = inputs::response::tool(design)?;
        let on_tool = match &tool {
            Some(stages) => stages.sensors(graph, design, Carrier::Tool)?,
            None => None,
        };
        let tool_analysed = |stages: &BodyStages, vibration: &Stored<Vibration>| {
            graph.add(BodyAnalysis {
                vibration: vibration.clone(),
                index: 0,
                range_hz: within(stages.top_hz),
                sensors: on_tool.clone(),
            })
        };
        let frozen_tool_in = |stages: &BodyStages, cycle: &Stored<CycleRecord>| {
            graph.add(ToolResponse {
                shot: tool_shot.clone(),
                body: stages.body.clone(),
                loss_factor: stages.loss_factor,
                fluid: tool_loads.clone().filter(|_| acts.damps()),
                cycle: cycle.clone(),
            })
        };
        let tool_fluid = tool_radiator.clone().zip(tool_loads.clone());
        let tool_fluid = tool_fluid.filter(|_| acts == Loading::Full);
        let tool_in = |cycle: &Stored<CycleRecord>| {
            tool.as_ref().map(|stages| {
                let frozen = frozen_tool_in(stages, cycle);
                let vibration = match &tool_fluid {
                    None => frozen,
                    Some((radiator, fluid)) => graph.add(LinearResponse {
                        frozen,
                        radiator: radiator.clone(),
                        bodies: vec![stages.body.clone()],
                        loss_factors: vec![stages.loss_factor],
                        fluid: fluid.clone(),
                        supports: Vec::new(),
                        guided: true,
                    }),
                };
                let motion = tool_analysed(stages, &vibration);
                (vibration, motion)
            })
        };
        // A response whose contact cannot open, with the complete impedance of the air.
        let complete = |frozen: &Stored<Vibration>, shot: &Shot| {
            graph.add(LinearResponse {
                frozen: frozen.clone(),
                radiator: radiator.clone(),
                bodies: bodies.clone(),
                loss_factors: driven_bodies.loss_factors.clone(),
                fluid: loads.clone(),
                supports: shot.supports.clone(),
                guided: false,
            })
        };
        let workpiece_is_linear = acts == Loading::Full && !two_way && !shot.can_lose_contact();
        let Driven {
            cycle,
            vibration: frozen,
            coupled,
        } = driven(0, two_way);
        let vibration = match workpiece_is_linear {
            true => complete(&frozen, &shot),
            false => frozen.clone(),
        };
        let compared_motions = (acts == Loading::Full).then(|| {
            if workpiece_is_linear {
                return [frozen.clone(), vibration.clone()];
            }
            let bonded = shot.bonded();
            let frozen = graph.add(Response {
                shot: bonded.clone(),
                structure: driven_bodies.clone(),
                cycle: lumped.clone(),
                force_scale: options.workpiece_force_scale,
            });
            let complete = complete(&frozen, &bonded);
            [frozen, complete]
        });
        let motions = analysed(&vibration, true);
        let tool_motion = tool_in(&cycle);

        // Sources.
        let longest = tool_motion.as_ref().map_or(&vibration, |(vibration, _)| vibration);
        let end = graph.add(End {
            cycle: cycle.clone(),
            longest: longest.clone(),
        });
        let microphones = inputs::microphones::array(design)?;
        let workpiece_sound = WorkpieceSound {
            radiator: radiator.clone(),
            bodies: bodies.clone(),
            loads: loads.clone(),
            acts,
            loss_factors: driven_bodies.loss_factors.clone(),
            motions: motions.clone(),
        };
        let workpiece = graph.add(WorkpieceSource {
            radiated: graph.add(WorkpieceRadiated {
                sound: workpiece_sound.clone(),
                at_microphones,
            }),
            bodies: bodies.clone(),
            top_hz: structure.iter().map(|stages| stages.top_hz).collect(),
            cycle: cycle.clone(),
            end: end.clone(),
            microphones: microphones.clone(),
            centre: inputs::microphones::workpiece_centre(design),
        });
        let openings = inputs::exhaust::openings(design)?;
        let exhaust_of = |cycle: &Stored<CycleRecord>, end: &Stored<f64>| Exhaust {
            openings: openings.clone(),
            outlet: inputs::exhaust::outlet(design),
            microphones: microphones.clone(),
            cycle: cycle.clone(),
            end: end.clone(),
            noise_seed: options.noise_seed,
        };
        let exhaust = graph.add(exhaust_of(&cycle, &end));
        let body_sound = |cycle: &Stored<CycleRecord>, motion: Option<Stored<BodyMotion>>| BodySound {
            housing: tool.as_ref().zip(motion).map(|(stages, motion)| Housing {
                body: stages.body.clone(),
                top_hz: stages.top_hz,
                motion,
                radiator: tool_radiator.clone(),
                loads: tool_loads.clone(),
                acts,
                loss_factor: stages.loss_factor,
                cap: cap_radiator.clone(),
            }),
            volume: design.body.volume(design.piston.bore),
            air,
            range_hz,
            cycle: cycle.clone(),
        };
        let of_tool = tool_motion.as_ref().map(|(_, motion)| motion.clone());
        let sensors = Sensors {
            accelerometers: inputs::sensors::accelerometers(design)?,
            cycle: cycle.clone(),
            vibration: vibration.clone(),
            motions: motions.iter().chain(&of_tool).cloned().collect(),
        };
        let levels = graph.add(ShotLevels {
            workpiece: workpiece_sound,
            openings: openings.clone(),
            body: body_sound(&cycle, of_tool.clone()),
            cycle: cycle.clone(),
            end: end.clone(),
            range_hz,
            bodies: bodies
                .iter()
                .cloned()
                .chain(tool.iter().map(|stages| stages.body.clone()))
                .collect(),
            responses: [&vibration]
                .into_iter()
                .chain(tool_motion.iter().map(|(response, _)| response))
                .cloned()
                .collect(),
            sensors: (!sensors.accelerometers.is_empty()).then(|| sensors.clone()),
        });
        let housing_at_microphones = tool_radiation.as_ref().map(|(_, (.., whole))| HousingAtMicrophones {
            whole: whole.clone(),
            cap: cap_radiation.as_ref().map(|(.., cap)| cap.clone()),
        });
        let body = graph.add(BodySource {
            sound: body_sound(&cycle, of_tool.clone()),
            at_microphones: housing_at_microphones,
            end: end.clone(),
            microphones: microphones.clone(),
            sphere: inputs::microphones::tool_sphere(design),
        });

        // What stands beside them: sensors, other starts, checks, the same shot one way, fields.
        let sensors = graph.add(sensors);
        let transducers = graph.add(Transducers {
            transducers: inputs::sensors::transducers(design),
            cycle: cycle.clone(),
        });
        let energy = |vibration: &Stored<Vibration>| {
            graph.add(WorkpieceEnergy {
                radiator: radiator.clone(),
                motions: analysed(vibration, false),
            })
        };
        let own_key = vibration.key();
        let loading = compared_motions.map(|both| ImpedanceComparison {
            report: (!workpiece_is_linear).then(|| {
                graph.add(ResponseReport {
                    bodies: Vec::new(),
                    vibration: both[1].clone(),
                })
            }),
            workpiece: both.map(|vibration| match vibration.key() == own_key {
                true => graph.add(WorkpieceEnergy {
                    radiator: radiator.clone(),
                    motions: motions.clone(),
                }),
                false => energy(&vibration),
            }),
            workpiece_is_linear,
            body: tool.as_ref().zip(tool_fluid.as_ref()).map(|(stages, _)| {
                let frozen = tool_analysed(stages, &frozen_tool_in(stages, &cycle));
                [Some(frozen), of_tool.clone()].map(|motion| {
                    graph.add(BodyEnergy {
                        sound: body_sound(&cycle, motion),
                    })
                })
            }),
        });
        let scatters = shot.can_lose_contact() && design.analysis.starts > 1;
        let starts = scatters.then(|| {
            let others = (1..design.analysis.starts).map(|start| energy(&driven(start, two_way).vibration));
            graph.add(OtherStarts {
                first: workpiece.clone(),
                others: others.collect(),
                range_hz,
            })
        });
        let response_report = graph.add(ResponseReport {
            bodies: bodies.clone(),
            vibration: vibration.clone(),
        });
        let tool_report = tool.as_ref().zip(tool_motion.as_ref()).map(|(stages, (vibration, _))| {
            graph.add(ToolReport {
                shot: tool_shot.clone(),
                body: stages.body.clone(),
                vibration: vibration.clone(),
            })
        });
        let one_way = coupled.map(|both| {
            let lumped_shot = driven(0, false);
            let motion = tool_in(&lumped).map(|(_, motion)| motion);
            OneWay {
                report: graph.add(CouplingReport(both)),
                workpiece: energy(&lumped_shot.vibration),
                exhaust: graph.add(exhaust_of(&lumped, &end)),
                body: graph.add(BodyEnergy {
                    sound: body_sound(&lumped, motion),
                }),
                cycle: lumped.clone(),
            }
        });
        let of_field = tool.as_ref().zip(of_tool.clone());
        let fields = graph.add(SoundFields {
            method: field_method,
            bodies,
            motions: motions.clone(),
            tool: of_field.map(|(stages, motion)| ToolField {
                body: stages.body.clone(),
                motion,
                elements: tool_radiation.map(|(elements, (_, radiator, _))| (elements, radiator)),
                nose: inputs::radiation::nose(design).into(),
            }),
            air,
            cuts: inputs::microphones::cuts(design),
        });
        let of_structure = structure.iter().zip(motions).enumerate();
        let of_structure = of_structure.map(|(index, (stages, motion))| MovingBody {
            body: stages.body.clone(),
            loss_factor: stages.loss_factor,
            vibration: vibration.clone(),
            index,
            motion,
        });
        let of_tool = tool.as_ref().zip(tool_motion);
        let of_tool = of_tool.map(|(stages, (vibration, motion))| MovingBody {
            body: stages.body.clone(),
            loss_factor: stages.loss_factor,
            vibration,
            index: 0,
            motion,
        });
        Ok(Self {
            moving: of_structure.chain(of_tool).collect(),
            graph: graph.clone(),
            usable,
            begin,
            cycle,
            structure,
            tool,
            vibration,
            end,
            workpiece,
            exhaust,
            body,
            levels,
            structures,
            sensors,
            transducers,
            fields,
            starts,
            response_report,
            tool_report,
            one_way,
            loading,
            noise_seed: options.noise_seed,
        })
    }
}

/// Radiation of the workpiece with its support.
struct RadiationStages {
    /// The radiator.
    radiator: Stored<Box<dyn Radiator>>,
    /// The same with its pressures at the microphones.
    at_microphones: Stored<Box<dyn Radiator>>,
    /// How its sound field is computed.
    field: FieldMethod,
    /// The key of its radiation matrix.
    matrix_key: Option<Digest>,
}

/// Radiation of the workpiece with its support.
fn workpiece_radiation(
    graph: &Graph,
    design: &Design,
    bodies: &[Stored<Body>],
    (air, shared): (Air, SharedShapes),
) -> Result<RadiationStages, Error> {
    let radiator = |method| {
        graph.add(WorkpieceRadiator {
            method,
            bodies: bodies.to_vec(),
            air,
        })
    };
    Ok(match inputs::radiation::workpiece(design)? {
        WorkpieceRadiation::BoundaryElements(elements) => {
            let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
            let standards = match shared.workpiece {
                true => standards(graph, design, &kinds[..bodies.len()])?,
                false => Standards::new(),
            };
            let shape = RadiatingShape::Workpiece(elements.clone());
            let places = inputs::radiation::workpiece_places(design);
            let radiation = by_shape(graph, (&shape, &places), &standards, bodies);
            let (at_microphones, matrix) = (radiation.at_microphones(graph), radiation.matrix);
            RadiationStages {
                radiator: radiator(WorkpieceMethod::BoundaryElements(matrix.clone())),
                at_microphones: radiator(WorkpieceMethod::BoundaryElements(at_microphones)),
                matrix_key: Some(*matrix.key()),
                field: FieldMethod::BoundaryElements(elements, matrix),
            }
        }
        WorkpieceRadiation::Erp(covered) => {
            let radiator = radiator(WorkpieceMethod::Erp(covered));
            RadiationStages {
                at_microphones: radiator.clone(),
                radiator,
                field: FieldMethod::Erp,
                matrix_key: None,
            }
        }
        WorkpieceRadiation::Rayleigh(top) => {
            let alone = graph.add(FlushMatrix {
                places: top.places.clone(),
                top_hz: top.top_hz,
                air: FlushMatrix::computed_air(&air),
                body: bodies[0].clone(),
            });
            let matrix_key = Some(*alone.key());
            let radiator = radiator(WorkpieceMethod::Rayleigh(top.clone(), alone));
            RadiationStages {
                at_microphones: radiator.clone(),
                field: FieldMethod::Rayleigh(top, radiator.clone()),
                radiator,
                matrix_key,
            }
        }
    })
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

fn cycle_stage(design: &Design) -> Result<Cycle, Error> {
    Ok(Cycle {
        parameters: inputs::cycle::parameters(design)?,
        settings: inputs::cycle::cycle_settings(design),
    })
}

/// The noise of a cycle's openings one by one, from which the sound at any place follows
/// ([`ExhaustNoise::at`]): exhaust holes, a muffler's outlet where there is one, trigger vent.
///
/// # Errors
/// Openings, plenum or muffler that cannot be, air that leaves against a higher pressure.
pub fn exhaust_openings(design: &Design, record: &CycleRecord) -> Result<Vec<ExhaustNoise>, Error> {
    Ok(noise(&inputs::exhaust::openings(design)?, record)?.2.openings)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

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

    /// Keys of the radiation matrices depend on surfaces and modes alone.
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

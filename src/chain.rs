//! The chain from a design to ranked sources: which stage reads which output.
//!
//! [`Chain::new`] adds the stages of a design to a graph without computing anything. [`Chain::run`] (`run.rs`) computes
//! the outputs that a result needs, in parallel, and ranks the sources.

mod bodies;
mod context;
mod cycle;
mod motion;
mod radiation;
mod reference;
mod shot;

use std::time::Instant;

use crate::design::{Design, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::model::sources::{self, SourceStages};
use crate::stages::bodies::BodyKind;
use crate::stages::cycle::{Engine, ShotRecord};
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::modal_efficiency::{BodyEfficiencies, EfficiencyMethod, ModalEfficiencies};
use crate::stages::motion_bands::{BodyBands, MotionBands};
use crate::stages::requirements::Preflight;
use crate::stages::response::{CouplingReport, Reported, ResponseChecks, ResponseReport, Vibration};
use crate::stages::sensors::{SensorRecord, Sensors};
use crate::stages::sound_fields::{FieldMethod, Fields, SoundFields, ToolField};
use crate::stages::spectra::MovingBody;
use crate::stages::tool_response::ToolChecks;
use crate::stages::transducers::{PressureRecord, Transducers};
use crate::stages::{Digest, Stored};
use bodies::Bodies;
pub(crate) use bodies::RecordedBody;
pub use bodies::{BodyStages, CheckedBody, check_bodies, solved_bodies};
pub(crate) use context::Context;
pub use cycle::{cycle, shot};
pub(crate) use cycle::{cycle_stage, engine};
pub(crate) use motion::{Drive, Motions};
use radiation::Radiators;
pub use reference::SharedShapes;
pub(crate) use shot::ShotStages;

/// Modifications of the physics for a run of the same design, used by studies and by tests of physical laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Factor on the forces of the shot on the workpiece if the cycle is coupled one way \[-\].
    pub workpiece_force_scale: f64,
    /// Seed of the jet noise at the microphones; levels do not depend on it.
    pub noise_seed: u32,
    /// Shapes shared with other designs.
    pub shared: SharedShapes,
}

impl Default for Options {
    /// No modifications.
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
    /// Preflight checks of each body.
    pub(crate) usable: Vec<Stored<Preflight>>,
    /// Bodies whose surfaces the design has recorded.
    pub(crate) recorded: Vec<RecordedBody>,
    /// Start time of the run.
    pub(crate) begin: Instant,
    /// The engine of the cycle.
    pub(crate) engine: Engine,
    /// The nailing cycle.
    pub cycle: Stored<ShotRecord>,
    /// Workpiece, and worktable if there is one; empty for a tool without a workpiece.
    pub structure: Vec<BodyStages>,
    /// The tool's body, unless it is rigid.
    pub tool: Option<BodyStages>,
    /// Response of workpiece and support; nothing reads it for a tool without a workpiece.
    pub vibration: Stored<Vibration>,
    /// All elastic bodies: the workpiece, its support, the tool.
    pub moving: Vec<MovingBody>,
    /// End of all records \[s\].
    pub end: Stored<f64>,
    /// The sources, in the order of their list.
    pub(crate) sources: Vec<SourceStages>,
    /// Levels of all sources, without further results.
    pub levels: Stored<Levels>,
    /// Keys of modes and of radiation in standard air, which are shared by shots with the same structures.
    pub(crate) structures: Vec<Digest>,
    /// Motion of the elastic bodies in third octaves.
    pub motion: Stored<Vec<BodyBands>>,
    /// Radiation efficiencies of the modes: of workpiece and support, and of an elastic tool.
    pub(crate) efficiencies: Vec<Stored<Vec<BodyEfficiencies>>>,
    /// Signals of the sensors.
    pub sensors: Stored<Vec<SensorRecord>>,
    /// Signals of the pressure transducers.
    pub transducers: Stored<Vec<PressureRecord>>,
    /// Sound fields for inspection.
    pub fields: Stored<Fields>,
    /// Checks of workpiece and support; none for a tool without a workpiece.
    pub(crate) response_report: Option<Stored<ResponseChecks>>,
    /// Checks of an elastic tool.
    pub(crate) tool_report: Option<Stored<ToolChecks>>,
    /// The same shot with one-way coupling, if the shot is coupled two ways.
    pub(crate) one_way: Option<OneWay>,
    /// See [`Options`].
    pub(crate) noise_seed: u32,
}

/// A shot with two-way coupling and the same design's shot with one-way coupling.
pub(crate) struct OneWay {
    pub(crate) report: Stored<Reported>,
    pub(crate) cycle: Stored<ShotRecord>,
}

impl Chain {
    /// Adds the stages of a design to a graph.
    ///
    /// # Errors
    /// If the values of the design do not yield valid inputs.
    pub fn new(graph: &Graph, design: &Design, options: Options) -> Result<Self, Error> {
        Self::with_engine(graph, design, cycle::engine(design)?, options)
    }

    /// The same with the nailing cycle of another design, whose modes and radiation matrices need not be computed. The
    /// cycle drives the bodies one way.
    ///
    /// # Errors
    /// Same as [`new`](Self::new).
    pub(crate) fn with_engine(graph: &Graph, design: &Design, engine: Engine, options: Options) -> Result<Self, Error> {
        let begin = Instant::now();
        let context = Context {
            graph,
            design,
            air: inputs::air(design)?,
            shared: options.shared,
        };
        let bodies = Bodies::add(graph, design)?;
        let radiators = Radiators::add(context, &bodies)?;
        let drive = Drive {
            lumped: graph.add(engine.clone()),
            engine: engine.clone(),
            force_scale: options.workpiece_force_scale,
        };
        let motions = Motions::new(context, &bodies, &radiators, drive)?;
        let shot = ShotStages::add(context, &motions, options.noise_seed)?;
        let present = sources::ALL.into_iter().filter(|source| source.is_present(&engine));
        let added = present.map(|source| source.add(&shot));
        let sources = added.collect::<Result<Vec<SourceStages>, Error>>()?;
        let sensors = Sensors {
            accelerometers: inputs::sensors::accelerometers(design)?,
            cycle: shot.cycle.clone(),
            vibration: shot.of_structure().cloned(),
            motions: shot.all_motions(),
        };
        let levels = graph.add(ShotLevels {
            sources: sources.iter().map(|source| source.analysis.clone()).collect(),
            cycle: shot.cycle.clone(),
            range_hz: motions.range_hz,
            bodies: bodies.modal().cloned().collect(),
            responses: shot.responses(),
            sensors: (!sensors.accelerometers.is_empty()).then(|| sensors.clone()),
        });
        let modal = bodies.modal().map(|body| *body.key());
        Ok(Self {
            engine: engine.clone(),
            motion: graph.add(MotionBands { bodies: shot.moving() }),
            efficiencies: modal_efficiencies(&shot).map(|stage| graph.add(stage)).collect(),
            moving: shot.moving(),
            graph: graph.clone(),
            begin,
            sensors: graph.add(sensors),
            structures: modal.chain(radiators.matrix_keys()).collect(),
            noise_seed: options.noise_seed,
            levels,
            transducers: graph.add(Transducers {
                transducers: inputs::sensors::transducers(design)?,
                cycle: shot.cycle.clone(),
            }),
            fields: graph.add(sound_fields(&shot)),
            response_report: shot.of_structure().map(|vibration| {
                graph.add(ResponseReport {
                    bodies: bodies.structure_bodies(),
                    vibration: vibration.clone(),
                })
            }),
            one_way: shot.coupled.map(|both| OneWay {
                report: graph.add(CouplingReport(both)),
                cycle: motions.lumped.clone(),
            }),
            tool_report: shot.tool_report,
            cycle: shot.cycle,
            vibration: shot.vibration,
            end: shot.end,
            sources,
            usable: bodies.usable,
            recorded: bodies.recorded,
            structure: bodies.structure,
            tool: bodies.tool,
        })
    }
}

impl Chain {
    /// Names of the sources of the tool.
    pub fn source_names(&self) -> impl Iterator<Item = &'static str> {
        self.sources.iter().map(|own| own.source.name())
    }
}

/// The radiation efficiencies of the modes: of workpiece and support, and of an elastic tool.
fn modal_efficiencies(shot: &ShotStages<'_>) -> impl Iterator<Item = ModalEfficiencies> {
    let air = shot.context.air;
    let (radiators, loads) = (shot.radiators, || shot.radiators.workpiece_loads.clone());
    let structure = shot.of_structure().map(|_| ModalEfficiencies {
        method: match &radiators.workpiece.field {
            FieldMethod::BoundaryElements(_, matrix) => EfficiencyMethod::BoundaryElements {
                matrix: matrix.clone(),
                loads: loads(),
            },
            FieldMethod::Rayleigh(..) => EfficiencyMethod::FlushTop { loads: loads() },
            FieldMethod::Erp | FieldMethod::Absent => EfficiencyMethod::NotComputed {
                reason: "the method of this source takes radiation efficiency 1",
            },
        },
        bodies: shot.bodies.structure_bodies(),
        air,
    });
    let tool = shot.bodies.tool.as_ref().map(|stages| ModalEfficiencies {
        method: match &radiators.tool {
            Some(tool) => EfficiencyMethod::BoundaryElements {
                matrix: tool.whole.radiator.clone(),
                loads: tool.loads.clone(),
            },
            None => EfficiencyMethod::NotComputed {
                reason: "the method of this source is a sphere of its volume, without modes of its own",
            },
        },
        bodies: vec![stages.body.clone()],
        air,
    });
    structure.into_iter().chain(tool)
}

/// The sound fields of the bodies in a shot.
fn sound_fields(shot: &ShotStages<'_>) -> SoundFields {
    let name = |body| sources::of_body(body).map_or("", |source| source.name());
    let tool = shot.bodies.tool.as_ref().zip(shot.tool.as_ref());
    let elements = shot.radiators.tool.as_ref();
    SoundFields {
        source: name(BodyKind::Workpiece),
        method: shot.radiators.workpiece.field.clone(),
        bodies: shot.bodies.structure_bodies(),
        motions: shot.structure.clone(),
        tool: tool.map(|(stages, tool)| ToolField {
            source: name(BodyKind::Tool),
            body: stages.body.clone(),
            motion: tool.motion.clone(),
            elements: elements.map(|tool| (tool.elements.clone(), tool.whole.radiator.clone())),
            nose: inputs::radiation::nose(shot.context.design).into(),
        }),
        air: shot.context.air,
        cuts: inputs::microphones::cuts(shot.context.design),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::stages::bodies::BodyKind;
    use crate::stages::sound_fields::FieldMethod;
    use radiation::workpiece_radiation;

    /// Prefixes of keys that affect neither meshes nor modes nor load vectors.
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

    /// Key of the elimination order of the tool.
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
            let context = Context {
                graph: &graph,
                design,
                air: inputs::air(design).unwrap(),
                shared: SharedShapes::default(),
            };
            match workpiece_radiation(context, &bodies).unwrap().field {
                FieldMethod::BoundaryElements(_, matrix) => *matrix.key(),
                FieldMethod::Rayleigh(..) | FieldMethod::Erp | FieldMethod::Absent => panic!("boundary elements"),
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

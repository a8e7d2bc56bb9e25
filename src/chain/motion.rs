//! Motion of the bodies of a design: of workpiece and support for each start and coupling, and of the tool for each
//! cycle.

use nailnoise_acoustics::radiation::radiator::Loading;

use super::bodies::{Bodies, BodyStages};
use super::context::Context;
use super::radiation::Radiators;
use crate::design::{Carrier, Coupling, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::Stored;
use crate::stages::bodies::BodySensors;
use crate::stages::cycle::{Engine, ShotRecord};
use crate::stages::response::{
    Coupled, CoupledCycle, CoupledResponse, CoupledVibration, LinearResponse, Response, ShotInputs, Structure,
    Vibration,
};
use crate::stages::spectra::{BodyAnalysis, BodyMotion};
use crate::stages::tool_response::{ToolResponse, ToolShot};

/// Builder of the stages that compute the motion of a design's bodies.
pub(crate) struct Motions<'a> {
    graph: &'a Graph,
    /// The bodies.
    pub(crate) bodies: &'a Bodies,
    /// How they radiate.
    pub(crate) radiators: &'a Radiators,
    /// The cycle with a lumped workpiece.
    pub(crate) lumped: Stored<ShotRecord>,
    /// The engine of the cycle.
    pub(crate) engine: Engine,
    /// The shot on workpiece and support.
    pub(crate) shot: ShotInputs,
    /// The shot on the tool.
    pub(crate) tool_shot: ToolShot,
    /// Workpiece and support.
    pub(crate) structure: Structure,
    /// Sensors on each body of the structure, and on the tool.
    on_structure: Vec<Option<Stored<BodySensors>>>,
    on_tool: Option<Stored<BodySensors>>,
    /// Factor on the forces of the shot on the workpiece if the cycle is coupled one way \[-\].
    pub(crate) force_scale: f64,
    /// Range of the levels \[Hz\].
    pub(crate) range_hz: [f64; 2],
    /// Whether the bodies act back on the cycle.
    pub(crate) two_way: bool,
}

/// The cycle that drives the bodies.
pub(crate) struct Drive {
    /// The engine of the cycle.
    pub(crate) engine: Engine,
    /// The cycle with a lumped workpiece.
    pub(crate) lumped: Stored<ShotRecord>,
    /// Factor on the forces of the shot on the workpiece if the cycle is coupled one way \[-\].
    pub(crate) force_scale: f64,
}

/// Motion of an elastic tool.
pub(crate) struct ToolMotion {
    /// Its response.
    pub(crate) vibration: Stored<Vibration>,
    /// Spectra of its response.
    pub(crate) motion: Stored<BodyMotion>,
}

/// Motion of workpiece and support, with the cycle that drives it.
pub(crate) struct DrivenVibration {
    /// The cycle.
    pub(crate) cycle: Stored<ShotRecord>,
    /// The motion.
    pub(crate) vibration: Stored<Vibration>,
    /// Both combined, if they are coupled two ways.
    pub(crate) coupled: Option<Stored<Coupled>>,
}

impl<'a> Motions<'a> {
    /// Creates the builder for the bodies of a design.
    ///
    /// # Errors
    /// If the values of the design do not yield valid inputs.
    pub(crate) fn new(
        context: Context<'a>,
        bodies: &'a Bodies,
        radiators: &'a Radiators,
        drive: Drive,
    ) -> Result<Self, Error> {
        let Context { graph, design, .. } = context;
        let carriers = [Carrier::Workpiece, Carrier::Worktable];
        let on_structure = bodies.structure.iter().zip(carriers);
        let on_structure = on_structure.map(|(stages, carrier)| stages.sensors(graph, design, carrier));
        let on_tool = bodies.tool.as_ref();
        let on_tool = on_tool.map(|stages| stages.sensors(graph, design, Carrier::Tool));
        let loads = &radiators.workpiece_loads;
        Ok(Self {
            graph,
            bodies,
            radiators,
            lumped: drive.lumped,
            shot: inputs::response::shot(design, &drive.engine)?,
            tool_shot: inputs::response::tool(design, &drive.engine),
            structure: Structure {
                bodies: bodies.structure_bodies(),
                loss_factors: bodies.structure.iter().map(|stages| stages.loss_factor).collect(),
                fluid: radiators.acts.damps().then(|| loads.clone()),
            },
            on_structure: on_structure.collect::<Result<_, _>>()?,
            on_tool: on_tool.transpose()?.flatten(),
            engine: drive.engine,
            force_scale: drive.force_scale,
            range_hz: [design.analysis.range_low, design.analysis.range_high],
            two_way: design.support.coupling == Coupling::TwoWay,
        })
    }

    /// Whether the full radiation impedance is used: it is requested, and the contact neither opens nor acts back on
    /// the cycle.
    pub(crate) fn is_linear(&self) -> bool {
        self.radiators.acts == Loading::Full && !self.two_way && !self.shot.can_lose_contact()
    }

    /// The shot from one of its initial states, with the radiation impedance frozen at each mode's resonance.
    pub(crate) fn driven(&self, start: u32, two_way: bool) -> DrivenVibration {
        let shot = self.shot.with_start(start);
        if !two_way {
            return DrivenVibration {
                cycle: self.lumped.clone(),
                vibration: self.one_way(shot),
                coupled: None,
            };
        }
        let both = self.graph.add(CoupledResponse {
            shot,
            structure: self.structure.clone(),
            engine: self.engine.clone(),
        });
        DrivenVibration {
            cycle: self.graph.add(CoupledCycle(both.clone())),
            vibration: self.graph.add(CoupledVibration(both.clone())),
            coupled: Some(both),
        }
    }

    fn one_way(&self, shot: ShotInputs) -> Stored<Vibration> {
        self.graph.add(Response {
            shot,
            structure: self.structure.clone(),
            cycle: self.lumped.clone(),
            force_scale: self.force_scale,
        })
    }

    /// A response whose contact cannot open, with the full radiation impedance.
    pub(crate) fn with_complete_impedance(&self, frozen: &Stored<Vibration>, shot: &ShotInputs) -> Stored<Vibration> {
        self.graph.add(LinearResponse {
            frozen: frozen.clone(),
            radiator: self.radiators.workpiece.radiator.clone(),
            bodies: self.structure.bodies.clone(),
            loss_factors: self.structure.loss_factors.clone(),
            fluid: self.radiators.workpiece_loads.clone(),
            supports: shot.supports.clone(),
            guided: false,
        })
    }

    /// The same shot with one-way coupling and bonded contacts: with the frozen and with the full impedance.
    pub(crate) fn bonded(&self) -> [Stored<Vibration>; 2] {
        let bonded = self.shot.bonded();
        let frozen = self.one_way(bonded.clone());
        let complete = self.with_complete_impedance(&frozen, &bonded);
        [frozen, complete]
    }

    /// Spectra of workpiece and support, with the signals of their sensors if requested.
    pub(crate) fn analysed(&self, vibration: &Stored<Vibration>, with_sensors: bool) -> Vec<Stored<BodyMotion>> {
        let bodies = self.bodies.structure.iter().zip(&self.on_structure).enumerate();
        let analysis = bodies.map(|(index, (stages, sensors))| BodyAnalysis {
            vibration: vibration.clone(),
            index,
            range_hz: self.range_up_to(stages.top_hz),
            sensors: sensors.clone().filter(|_| with_sensors),
        });
        analysis.map(|stage| self.graph.add(stage)).collect()
    }

    /// Motion and spectra of an elastic tool in a cycle, with the radiation impedance that applies.
    pub(crate) fn tool(&self, cycle: &Stored<ShotRecord>) -> Option<ToolMotion> {
        let stages = self.bodies.tool.as_ref()?;
        let frozen = self.frozen_tool(stages, cycle);
        let complete = self.radiators.tool.as_ref();
        let complete = complete.filter(|_| self.radiators.acts == Loading::Full);
        let vibration = match complete {
            None => frozen,
            Some(tool) => self.graph.add(LinearResponse {
                frozen,
                radiator: tool.whole.radiator.clone(),
                bodies: vec![stages.body.clone()],
                loss_factors: vec![stages.loss_factor],
                fluid: tool.loads.clone(),
                supports: Vec::new(),
                guided: true,
            }),
        };
        let motion = self.tool_analysed(stages, &vibration);
        Some(ToolMotion { vibration, motion })
    }

    /// Spectra of an elastic tool with the frozen radiation impedance, for comparison with the full one.
    pub(crate) fn tool_with_frozen_impedance(&self, cycle: &Stored<ShotRecord>) -> Option<Stored<BodyMotion>> {
        let stages = self.bodies.tool.as_ref()?;
        self.radiators.tool.as_ref()?;
        Some(self.tool_analysed(stages, &self.frozen_tool(stages, cycle)))
    }

    fn frozen_tool(&self, stages: &BodyStages, cycle: &Stored<ShotRecord>) -> Stored<Vibration> {
        let loads = self.radiators.tool.as_ref().map(|tool| tool.loads.clone());
        self.graph.add(ToolResponse {
            shot: self.tool_shot.clone(),
            body: stages.body.clone(),
            loss_factor: stages.loss_factor,
            fluid: loads.filter(|_| self.radiators.acts.damps()),
            cycle: cycle.clone(),
        })
    }

    fn tool_analysed(&self, stages: &BodyStages, vibration: &Stored<Vibration>) -> Stored<BodyMotion> {
        self.graph.add(BodyAnalysis {
            vibration: vibration.clone(),
            index: 0,
            range_hz: self.range_up_to(stages.top_hz),
            sensors: self.on_tool.clone(),
        })
    }

    /// The range of the levels, limited to a frequency \[Hz\].
    fn range_up_to(&self, top_hz: f64) -> [f64; 2] {
        let [low, high] = self.range_hz;
        [low, top_hz.min(high)]
    }
}

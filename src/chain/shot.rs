//! The shot whose sound is computed: its cycle, and the motion of its bodies.

use nailnoise_acoustics::signals::SourceSpectrum;

use super::bodies::{Bodies, BodyStages};
use super::context::Context;
use super::motion::{DrivenVibration, Motions, ToolMotion};
use super::radiation::Radiators;
use crate::design::inputs;
use crate::error::Error;
use crate::stages::Stored;
use crate::stages::apart::Apart;
use crate::stages::cycle::ShotRecord;
use crate::stages::microphones::MicrophoneArray;
use crate::stages::response::{Coupled, End, Vibration};
use crate::stages::sources::{AnalysedSource, Analysis, Emission, Energy};
use crate::stages::spectra::{BodyMotion, MovingBody};
use crate::stages::tool_response::{ToolChecks, ToolReport};

/// The stages of a shot up to the motion of the bodies, to which sources add their own.
pub(crate) struct ShotStages<'a> {
    /// Context for adding stages.
    pub(crate) context: Context<'a>,
    /// The bodies.
    pub(crate) bodies: &'a Bodies,
    /// How they radiate.
    pub(crate) radiators: &'a Radiators,
    /// Adds the bodies' motion in other shots of the design.
    pub(crate) motions: &'a Motions<'a>,
    /// The microphones.
    pub(crate) microphones: MicrophoneArray,
    /// Seed of the jet noise at the microphones.
    pub(crate) noise_seed: u32,
    /// The nailing cycle.
    pub(crate) cycle: Stored<ShotRecord>,
    /// Cycle and structure combined, if they are coupled two ways.
    pub(crate) coupled: Option<Stored<Coupled>>,
    /// Response of workpiece and support with the radiation impedance frozen at each mode's resonance.
    pub(crate) frozen: Stored<Vibration>,
    /// Response of workpiece and support; nothing reads it for a tool without a workpiece.
    pub(crate) vibration: Stored<Vibration>,
    /// Motion of workpiece and support.
    pub(crate) structure: Vec<Stored<BodyMotion>>,
    /// Motion of an elastic tool.
    pub(crate) tool: Option<ToolMotion>,
    /// Checks of an elastic tool.
    pub(crate) tool_report: Option<Stored<ToolChecks>>,
    /// End of all records \[s\].
    pub(crate) end: Stored<f64>,
}

impl<'a> ShotStages<'a> {
    /// Adds the motion of the bodies in the shot of a design.
    ///
    /// # Errors
    /// If the values of the design do not yield valid inputs.
    pub(super) fn add(context: Context<'a>, motions: &'a Motions<'a>, noise_seed: u32) -> Result<Self, Error> {
        let Context { graph, design, .. } = context;
        let DrivenVibration {
            cycle,
            vibration: frozen,
            coupled,
        } = motions.driven(0, motions.two_way);
        let vibration = match motions.is_linear() {
            true => motions.with_complete_impedance(&frozen, &motions.shot),
            false => frozen.clone(),
        };
        let tool = motions.tool(&cycle);
        let tool_report = motions.bodies.tool.as_ref().zip(tool.as_ref());
        let tool_report = tool_report.map(|(stages, tool)| {
            graph.add(ToolReport {
                shot: motions.tool_shot.clone(),
                body: stages.body.clone(),
                vibration: tool.vibration.clone(),
            })
        });
        Ok(Self {
            context,
            bodies: motions.bodies,
            radiators: motions.radiators,
            motions,
            microphones: inputs::microphones::array(design)?,
            noise_seed,
            end: graph.add(End {
                cycle: cycle.clone(),
                longest: tool
                    .as_ref()
                    .map(|tool| tool.vibration.clone())
                    .or_else(|| (!motions.bodies.structure.is_empty()).then(|| vibration.clone())),
            }),
            structure: motions.analysed(&vibration, true),
            cycle,
            coupled,
            frozen,
            vibration,
            tool,
            tool_report,
        })
    }

    /// Adds the energy of a source as a function of frequency.
    pub(crate) fn energy<E: Emission>(&self, emission: E) -> Stored<Apart<SourceSpectrum>> {
        self.context.graph.add(Energy(emission))
    }

    /// Adds the energy of a source as a function of frequency and time.
    pub(crate) fn analysis<E: Emission>(&self, emission: E) -> Stored<AnalysedSource> {
        self.context.graph.add(Analysis {
            emission,
            cycle: self.cycle.clone(),
            end: self.end.clone(),
            range_hz: self.motions.range_hz,
        })
    }

    /// Motion of workpiece and support, followed by that of the tool.
    pub(super) fn all_motions(&self) -> Vec<Stored<BodyMotion>> {
        let tool = self.tool.iter().map(|tool| &tool.motion);
        self.structure.iter().chain(tool).cloned().collect()
    }

    /// Response of workpiece and support; none for a tool without a workpiece.
    pub(super) fn of_structure(&self) -> Option<&Stored<Vibration>> {
        (!self.bodies.structure.is_empty()).then_some(&self.vibration)
    }

    /// Responses of workpiece and support, and of the tool.
    pub(super) fn responses(&self) -> Vec<Stored<Vibration>> {
        let tool = self.tool.iter().map(|tool| &tool.vibration);
        self.of_structure().into_iter().chain(tool).cloned().collect()
    }

    /// The elastic bodies in motion: workpiece, support, tool.
    pub(super) fn moving(&self) -> Vec<MovingBody> {
        let moving = |stages: &BodyStages, vibration: &Stored<Vibration>, index: usize, motion: &Stored<BodyMotion>| {
            MovingBody {
                body: stages.body.clone(),
                loss_factor: stages.loss_factor,
                vibration: vibration.clone(),
                index,
                motion: motion.clone(),
            }
        };
        let structure = self.bodies.structure.iter().zip(&self.structure).enumerate();
        let structure = structure.map(|(index, (stages, motion))| moving(stages, &self.vibration, index, motion));
        let tool = self.bodies.tool.iter().zip(&self.tool);
        let tool = tool.map(|(stages, tool)| moving(stages, &tool.vibration, 0, &tool.motion));
        structure.chain(tool).collect()
    }
}

//! Sources of a shot: the sound of its bodies in motion, and of its exhaust.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::SourceSpectrum;
use nailnoise_dynamics::CycleRecord;

use super::bodies::Bodies;
use super::motion::Motions;
use super::radiation::Radiators;
use crate::design::{Design, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::Stored;
use crate::stages::exhaust::{Cycles, Exhaust, ExhaustSource, Openings};
use crate::stages::microphones::MicrophoneArray;
use crate::stages::response::Vibration;
use crate::stages::sources::{
    BodyEnergy, BodySound, BodySource, Housing, HousingAtMicrophones, SurfaceSource, WorkpieceEnergy,
    WorkpieceRadiated, WorkpieceSound, WorkpieceSource,
};
use crate::stages::spectra::BodyMotion;

/// Builder of the stages that compute the sources of a shot.
pub(super) struct Sources<'a> {
    graph: &'a Graph,
    design: &'a Design,
    bodies: &'a Bodies,
    radiators: &'a Radiators,
    motions: &'a Motions<'a>,
    air: Air,
    microphones: MicrophoneArray,
    /// Openings through which the tool exhausts.
    pub(super) openings: Openings,
    noise_seed: u32,
}

impl<'a> Sources<'a> {
    /// For a design in an ambient air, with the seed of the jets' noise at the microphones.
    ///
    /// # Errors
    /// Values of the design that do not yield inputs.
    pub(super) fn new(
        graph: &'a Graph,
        design: &'a Design,
        (bodies, radiators, motions): (&'a Bodies, &'a Radiators, &'a Motions<'a>),
        (air, noise_seed): (Air, u32),
    ) -> Result<Self, Error> {
        Ok(Self {
            graph,
            design,
            bodies,
            radiators,
            motions,
            air,
            microphones: inputs::microphones::array(design)?,
            openings: inputs::exhaust::openings(design)?,
            noise_seed,
        })
    }

    /// Sound of workpiece and support in motion.
    pub(super) fn workpiece_sound(&self, motions: &[Stored<BodyMotion>]) -> WorkpieceSound {
        WorkpieceSound {
            radiator: self.radiators.workpiece.radiator.clone(),
            bodies: self.bodies.structure_bodies(),
            loads: self.radiators.workpiece_loads.clone(),
            acts: self.radiators.acts,
            loss_factors: self.motions.structure.loss_factors.clone(),
            motions: motions.to_vec(),
        }
    }

    /// The workpiece with its support as a source.
    pub(super) fn workpiece(
        &self,
        sound: &WorkpieceSound,
        (cycle, end): (&Stored<CycleRecord>, &Stored<f64>),
    ) -> Stored<SurfaceSource> {
        self.graph.add(WorkpieceSource {
            radiated: self.graph.add(WorkpieceRadiated {
                sound: sound.clone(),
                at_microphones: self.radiators.workpiece.at_microphones.clone(),
            }),
            bodies: self.bodies.structure_bodies(),
            top_hz: self.bodies.structure.iter().map(|stages| stages.top_hz).collect(),
            cycle: cycle.clone(),
            end: end.clone(),
            microphones: self.microphones.clone(),
            centre: inputs::microphones::workpiece_centre(self.design),
        })
    }

    /// Energy of workpiece and support in a motion.
    pub(super) fn workpiece_energy(&self, motions: Vec<Stored<BodyMotion>>) -> Stored<SourceSpectrum> {
        self.graph.add(WorkpieceEnergy {
            radiator: self.radiators.workpiece.radiator.clone(),
            motions,
        })
    }

    /// The same for a vibration without sensors.
    pub(super) fn energy_without_sensors(&self, vibration: &Stored<Vibration>) -> Stored<SourceSpectrum> {
        self.workpiece_energy(self.motions.analysed(vibration, false))
    }

    /// The exhaust as a source.
    pub(super) fn exhaust(&self, cycles: &Cycles, end: &Stored<f64>) -> Stored<ExhaustSource> {
        self.graph.add(Exhaust {
            openings: self.openings.clone(),
            outlet: inputs::exhaust::outlet(self.design),
            microphones: self.microphones.clone(),
            cycles: cycles.clone(),
            end: end.clone(),
            noise_seed: self.noise_seed,
        })
    }

    /// Sound of the tool's body in a cycle, with the motion of its housing where that is elastic.
    pub(super) fn body_sound(&self, cycle: &Stored<CycleRecord>, motion: Option<Stored<BodyMotion>>) -> BodySound {
        let design = self.design;
        let tool = self.radiators.tool.as_ref();
        let cap = tool.and_then(|tool| tool.cap.as_ref());
        BodySound {
            housing: self.bodies.tool.as_ref().zip(motion).map(|(stages, motion)| Housing {
                body: stages.body.clone(),
                top_hz: stages.top_hz,
                motion,
                radiator: tool.map(|tool| tool.whole.radiator.clone()),
                loads: tool.map(|tool| tool.loads.clone()),
                acts: self.radiators.acts,
                loss_factor: stages.loss_factor,
                cap: cap.map(|cap| cap.radiator.clone()),
            }),
            volume: design.body.volume(design.piston.bore),
            air: self.air,
            range_hz: self.motions.range_hz,
            cycle: cycle.clone(),
        }
    }

    /// The tool's body as a source.
    pub(super) fn body(&self, sound: BodySound, end: &Stored<f64>) -> Stored<SurfaceSource> {
        let at_microphones = self.radiators.tool.as_ref().map(|tool| HousingAtMicrophones {
            whole: tool.whole.at_microphones.clone(),
            cap: tool.cap.as_ref().map(|cap| cap.at_microphones.clone()),
        });
        self.graph.add(BodySource {
            sound,
            at_microphones,
            end: end.clone(),
            microphones: self.microphones.clone(),
            sphere: inputs::microphones::tool_sphere(self.design),
        })
    }

    /// Energies of the tool's body, and of its cap where that counts to another source.
    pub(super) fn body_energy(
        &self,
        cycle: &Stored<CycleRecord>,
        motion: Option<Stored<BodyMotion>>,
    ) -> Stored<(SourceSpectrum, Option<SourceSpectrum>)> {
        self.graph.add(BodyEnergy {
            sound: self.body_sound(cycle, motion),
        })
    }
}

//! The workpiece with its support as one source.

use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::radiation::radiator::{Detail, FluidLoads, Loading, MovingBody, Pressures, Radiator};
use nailnoise_acoustics::signals::SourceSpectrum;
use serde::Serialize;

use super::blow::Blow;
use crate::error::Error;
use crate::stages::apart::Apart;
use crate::stages::bodies::Body;
use crate::stages::cycle::ShotRecord;
use crate::stages::intervals::EventEdges;
use crate::stages::microphones::{Heard, MicrophoneArray};
use crate::stages::sound::{Sound, SoundSource};
use crate::stages::sources::{Emission, SourceSound};
use crate::stages::spectra::BodyMotion;
use crate::stages::truncation::{LimitedPart, truncations};
use crate::stages::{Code, Postcard, Progress, Stage, Stored, Uncached, all, code};

/// Name of the source.
pub(crate) const NAME: &str = "workpiece";

/// Code that the stages of this module call.
pub(crate) const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    model_sources_workpiece,
    stages_bodies,
    stages_apart,
    stages_intervals,
    stages_microphones,
    stages_radiation,
    stages_response,
    stages_sound,
    stages_sources,
    stages_spectra,
    stages_truncation,
    stages_cycle
);

/// Inputs of the sound of the workpiece with its support.
#[derive(Clone, Serialize)]
pub(crate) struct WorkpieceSound {
    /// How it radiates.
    pub(crate) radiator: Stored<Box<dyn Radiator>>,
    /// The bodies.
    pub(crate) bodies: Vec<Stored<Body>>,
    /// Fluid loads of the air on the modes of each body.
    pub(crate) loads: Stored<Vec<FluidLoads>>,
    /// Fluid loads that act on their motion.
    pub(crate) acts: Loading,
    /// Loss factor of the modes of each \[-\].
    pub(crate) loss_factors: Vec<f64>,
    /// Motion of each body.
    pub(crate) motions: Vec<Stored<BodyMotion>>,
    /// Model of the blow on the fastener in it; none without a fastener.
    pub(super) blow: Option<Blow>,
}

impl WorkpieceSound {
    fn sound(&self, detail: Detail) -> Result<Sound, Error> {
        let bodies = all(&self.bodies)?;
        let motions = all(&self.motions)?;
        let loads = self.loads.get()?;
        let moving: Vec<MovingBody<'_>> = bodies
            .iter()
            .zip(&motions)
            .enumerate()
            .map(|(index, (body, motion))| MovingBody {
                name: body.name,
                omega: &body.omega,
                modes: body.basis.hz.len(),
                zeta: 0.5 * self.loss_factors[index],
                loads: loads.get(index),
                acts: self.acts,
                spectra: &motion.spectra,
            })
            .collect();
        let mut sound = Sound::from(self.radiator.get()?.sound(NAME, &moving, detail)?);
        if let Some(blow) = self.blow {
            sound.uncertainty = blow.widened(sound.uncertainty, &sound.spectrum);
        }
        Ok(sound)
    }
}

impl Emission for WorkpieceSound {
    const CODE: Code = CODE;

    fn energy(&self) -> Result<Apart<SourceSpectrum>, Error> {
        let motions = all(&self.motions)?;
        let spectra: Vec<&ModalSpectra> = motions.iter().map(|motion| &motion.spectra).collect();
        Ok(Apart::whole(self.radiator.get()?.energy(NAME, &spectra)?))
    }

    fn analysed(&self, edges: &EventEdges, range_hz: [f64; 2]) -> Result<Apart<SoundSource>, Error> {
        let sound = self.sound(Detail::Levels)?;
        Ok(Apart::whole(SoundSource::new(sound, edges, range_hz)))
    }
}

/// Radiation of the workpiece with its support. Separate from [`WorkpieceSource`], because only that one needs the end
/// of all records. That end may depend on the tool, whose modes take longer to compute.
#[derive(Serialize)]
pub(crate) struct WorkpieceRadiated {
    /// Inputs of the sound.
    pub(crate) sound: WorkpieceSound,
    /// How it radiates, with pressures at the microphones.
    pub(crate) at_microphones: Stored<Box<dyn Radiator>>,
}

/// Sound over frequency and time, and the pressures at the microphones if the radiator gives them.
pub(crate) struct Radiated {
    sound: Sound,
    pressures: Option<Pressures>,
}

impl Stage for WorkpieceRadiated {
    type Output = Radiated;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation of the workpiece";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Radiated, Error> {
        let motions = all(&self.sound.motions)?;
        let spectra: Vec<&ModalSpectra> = motions.iter().map(|motion| &motion.spectra).collect();
        Ok(Radiated {
            sound: self.sound.sound(Detail::Report)?,
            pressures: self.at_microphones.get()?.pressures(&spectra)?,
        })
    }
}

/// Sound of the workpiece with its support.
#[derive(Serialize)]
pub(crate) struct WorkpieceSource {
    /// Its radiation.
    pub(crate) radiated: Stored<Radiated>,
    /// The bodies.
    pub(crate) bodies: Vec<Stored<Body>>,
    /// Frequency up to which the result includes the motion of each body \[Hz\].
    pub(crate) top_hz: Vec<f64>,
    /// The cycle, whose events separate the intervals.
    pub(crate) cycle: Stored<ShotRecord>,
    /// End of all records \[s\].
    pub(crate) end: Stored<f64>,
    /// The microphones.
    pub(crate) microphones: MicrophoneArray,
    /// Middle of the workpiece, the origin of its sound if only its power is known \[m\].
    pub(crate) centre: [f64; 3],
}

impl Stage for WorkpieceSource {
    type Output = SourceSound;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "sound of the workpiece";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<SourceSound, Error> {
        let (radiated, end, bodies) = (self.radiated.get()?, *self.end.get()?, all(&self.bodies)?);
        let Radiated { sound, pressures } = &*radiated;
        let received = match pressures {
            Some(pressures) => self.microphones.pressures(pressures, &sound.spectrum, end)?,
            None => self.microphones.spread_evenly(self.centre, sound, end)?,
        };
        let parts = bodies.iter().zip(&self.top_hz).map(|(body, top_hz)| LimitedPart {
            name: body.name.into(),
            contribution: body.name.into(),
            top_hz: *top_hz,
        });
        let range = self.microphones.range_hz;
        let truncations = truncations((NAME, &sound.spectrum), range, parts);
        let edges = EventEdges::new(&self.cycle.get()?.events, end);
        let source = SoundSource::new(sound.clone(), &edges, range);
        Ok(SourceSound {
            heard: Apart::whole(Heard { source, received }),
            truncations,
            checks: Vec::new(),
            histories: Vec::new(),
        })
    }
}

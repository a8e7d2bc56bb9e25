//! The tool's body as a source: rigid, or elastic by boundary elements or as the sphere of its volume.

use nailnoise_acoustics::radiation::boundary_elements::ModalBem;
use nailnoise_acoustics::radiation::radiator::{
    Detail, FluidLoads, Loading, MovingBody, Pressures, Radiator, RigidSphere,
};
use nailnoise_acoustics::radiation::{
    CompactErp, Erp, ModalSpectra, PartOfSurface, RadiatingSurface, radiated_energy, radiated_signals,
    sphere_efficiency,
};
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};
use nailnoise_acoustics::{AcousticsError, Air};
use nailnoise_meshes::open_faces;
use nalgebra::Complex;
use serde::Serialize;

use super::fitting::{FittingWall, WallSound};
use crate::error::Error;
use crate::result::{CrossCheck, Uncertainty};
use crate::stages::apart::{Apart, Moved, PartError};
use crate::stages::bodies::Body;
use crate::stages::cycle::ShotRecord;
use crate::stages::intervals::EventEdges;
use crate::stages::microphones::{Heard, MicrophoneArray, ToolSphere};
use crate::stages::sound::{Sound, SoundSource, sum_with};
use crate::stages::sources::{Emission, SourceSound};
use crate::stages::spectra::BodyMotion;
use crate::stages::truncation::{LimitedPart, truncations};
use crate::stages::{Code, Postcard, Progress, Stage, Stored, code};

/// Name of the source.
pub(crate) const NAME: &str = "body";

/// Code that the stages of this module call.
pub(crate) const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    model_sources_housing,
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

/// Name of the part of the source that counts towards the exhaust by the convention of wrapping.
const CAP: &str = "cap";

/// Name of that part together with the wall of the exhaust's fitting.
const CAP_AND_FITTING: &str = "cap and fitting";

/// Name of the part of the source that the elastic modes radiate.
const VIBRATION: &str = "housing";

/// Inputs of the sound of the tool's body.
#[derive(Clone, Serialize)]
pub(crate) struct HousingSound {
    /// Its elastic housing; none for a rigid body.
    pub(crate) elastic: Option<Elastic>,
    /// Its volume \[m³\].
    pub(crate) volume: f64,
    /// The ambient air.
    pub(crate) air: Air,
    /// Range over which sources are compared \[Hz\].
    pub(crate) range_hz: [f64; 2],
    /// The cycle.
    pub(crate) cycle: Stored<ShotRecord>,
    /// The wall of the fitting on its exhaust.
    pub(crate) fitting: Option<FittingWall>,
}

/// A housing as a radiator with pressures at the microphones.
#[derive(Clone, Serialize)]
pub(crate) struct HousingAtMicrophones {
    /// The whole.
    pub(crate) whole: Stored<ModalBem>,
    /// Matrix with only the cap in motion, after each mode of the full body, if the cap counts towards another source.
    pub(crate) cap: Option<Stored<ModalBem>>,
}

/// An elastic housing in motion.
#[derive(Clone, Serialize)]
pub(crate) struct Elastic {
    /// The body.
    pub(crate) body: Stored<Body>,
    /// Highest frequency at which the result includes its motion \[Hz\].
    pub(crate) top_hz: f64,
    /// Its motion.
    pub(crate) motion: Stored<BodyMotion>,
    /// Its radiation by boundary elements, if the design requests them.
    pub(crate) radiator: Option<Stored<ModalBem>>,
    /// Fluid loads of the air on its modes, if boundary elements yield them.
    pub(crate) loads: Option<Stored<Vec<FluidLoads>>>,
    /// Fluid loads that act on its motion.
    pub(crate) acts: Loading,
    /// Loss factor of its modes \[-\].
    pub(crate) loss_factor: f64,
    /// Its cap, if that counts to another source.
    pub(crate) cap: Option<Cap>,
}

/// The outer side of the cap, which counts to another source.
#[derive(Clone, Serialize)]
pub(crate) struct Cap {
    /// Radiation of the housing with only the cap in motion, after each mode of the full body.
    pub(crate) radiator: Stored<ModalBem>,
    /// Name of the source to which it is assigned.
    pub(crate) counts_to: &'static str,
}

impl HousingSound {
    fn sound(&self, detail: Detail) -> Result<Sound, Error> {
        let record = self.cycle.get()?;
        let Some(housing) = &self.elastic else {
            return Ok(self.rigid(&record).sound_with_check(NAME)?.into());
        };
        let (body, motion) = (housing.body.get()?, housing.motion.get()?);
        match &housing.radiator {
            Some(bem) => {
                let loads = housing.loads.as_ref().map(Stored::get).transpose()?;
                let moving = MovingBody {
                    name: body.name,
                    omega: &body.omega,
                    modes: body.basis.hz.len(),
                    zeta: 0.5 * housing.loss_factor,
                    loads: loads.as_ref().and_then(|all| all.first()),
                    acts: housing.acts,
                    spectra: &motion.spectra,
                };
                self.by_boundary_elements((&*bem.get()?, detail), &body, &moving, &record)
            }
            None => self.as_sphere(&body, &motion.spectra, &record),
        }
    }

    /// Energy and signals of its cap, if that counts towards another source, and the name of that source.
    fn cap(&self) -> Result<Option<(PartOfSurface, &'static str)>, Error> {
        let housing = self.elastic.as_ref();
        let Some((housing, cap)) = housing.and_then(|housing| Some((housing, housing.cap.as_ref()?))) else {
            return Ok(None);
        };
        let motion = housing.motion.get()?;
        let part = PartOfSurface::new(CAP, &*cap.radiator.get()?, &motion.spectra)?;
        Ok(Some((part, cap.counts_to)))
    }

    /// The wall of the exhaust's fitting, if any, in the motion of the source, and the uncertainty of both.
    fn wall(&self, whole: &mut Sound) -> Result<Option<(&FittingWall, WallSound)>, Error> {
        let Some(fitting) = &self.fitting else {
            return Ok(None);
        };
        let wall = match &self.elastic {
            Some(housing) => {
                let (body, motion) = (housing.body.get()?, housing.motion.get()?);
                fitting.on_body(&body, &motion.spectra, (&self.air, whole))?
            }
            None => fitting.on_rigid_tool(&*self.cycle.get()?, self.range_hz, (&self.air, whole))?,
        };
        whole.uncertainty = fitting.widened(whole, &wall.sound, (&self.air, self.range_hz));
        Ok(Some((fitting, wall)))
    }

    /// The source without its cap, and the cap, analysed between the events.
    fn without_cap(&self, sound: Sound, edges: &EventEdges) -> Result<Apart<SoundSource>, Error> {
        let uncertainty = sound.uncertainty.clone();
        let whole = SoundSource::new(sound, edges, self.range_hz);
        let Some((cap, counts_to)) = self.cap()? else {
            return Ok(Apart::whole(whole));
        };
        let cap = SoundSource::of_part(cap, uncertainty, edges, self.range_hz);
        Ok(Apart {
            own: whole.without(&cap).map_err(AcousticsError::from)?,
            moved: Some(moved(cap, counts_to)),
        })
    }

    fn rigid<'a>(&'a self, record: &'a ShotRecord) -> RigidSphere<'a> {
        RigidSphere {
            acceleration: record.tool_acceleration(),
            sample_interval: record.sample_interval,
            volume: self.volume,
            air: &self.air,
            range_hz: self.range_hz,
        }
    }

    /// By boundary elements, in a report next to the sound of a sphere.
    fn by_boundary_elements(
        &self,
        (bem, detail): (&ModalBem, Detail),
        body: &Body,
        moving: &MovingBody<'_>,
        record: &ShotRecord,
    ) -> Result<Sound, Error> {
        let mut sound = Sound::from(bem.sound(NAME, &[*moving], detail)?);
        if detail == Detail::Report {
            let sphere = self.energy_as_sphere(bem, body, moving.spectra, record)?;
            sound.cross_check = Some(CrossCheck {
                quantity: "the tool's body".into(),
                lw_db: sound.spectrum.level(self.range_hz, Weighting::Z),
                other: "rigid motion and ERP of a sphere of its volume".into(),
                other_lw_db: sphere.level(self.range_hz, Weighting::Z),
            });
        }
        sound.uncertainty.basis += "; the workpiece neither reflects nor shields";
        Ok(sound)
    }

    /// The energy of [`Self::as_sphere`], from the surface of the boundary elements.
    fn energy_as_sphere(
        &self,
        bem: &ModalBem,
        body: &Body,
        spectra: &ModalSpectra,
        record: &ShotRecord,
    ) -> Result<SourceSpectrum, Error> {
        let mut elastic = spectra.clone();
        elastic
            .accelerations
            .rows_mut(0, rigid_modes(body))
            .fill(Complex::default());
        let mut housing = radiated_energy(VIBRATION, &bem.reference(), &elastic)?;
        housing.contributions.clear();
        for (energy, &hz) in housing.energy_density.iter_mut().zip(&housing.frequency) {
            *energy *= sphere_efficiency(self.volume, &self.air, hz);
        }
        let rigid = self.rigid(record).sound(NAME)?.spectrum;
        Ok(SourceSpectrum::sum(NAME, "as a sphere", &[rigid, housing]))
    }

    /// Rigid motion as that of the sphere of its volume, elastic modes by their ERP into the open air times the
    /// radiation efficiency of that sphere.
    fn as_sphere(&self, body: &Body, spectra: &ModalSpectra, record: &ShotRecord) -> Result<Sound, Error> {
        let mut sound = Sound::from(self.rigid(record).sound(NAME)?);
        sound.spectrum.source = "rigid motion".to_owned();
        let (rigid, surface) = (rigid_modes(body), &body.surface);
        let elastic = body.omega.len() - rigid;
        let open = open_faces(surface, None)?;
        let shapes = body.skin.columns(rigid, elastic);
        let erp = Erp::new(
            &RadiatingSurface::of_faces(surface, shapes, |point| open[point.face])?,
            &self.air,
        );
        let spectra = ModalSpectra {
            frequency: spectra.frequency.clone(),
            accelerations: spectra.accelerations.rows(rigid, elastic).into_owned(),
            range_hz: spectra.range_hz,
        };
        let reference = radiated_energy(VIBRATION, &erp, &spectra)?;
        let compact = CompactErp::new(erp, self.volume, &self.air)?;
        let vibration = radiated_energy(VIBRATION, &compact, &spectra)?;
        let signals = (VIBRATION, radiated_signals(&compact, &spectra, &vibration)?);
        let rigid = sound.spectrum;
        let range = self.range_hz;
        let weighted = |part: &SourceSpectrum| rigid.energy(range, Weighting::A) + part.energy(range, Weighting::A);
        let (here, above) = (weighted(&vibration), weighted(&reference));
        sound.cross_check = Some(CrossCheck {
            quantity: "vibration of the housing".into(),
            lw_db: vibration.level(range, Weighting::Z),
            other: "ERP, radiation efficiency 1".into(),
            other_lw_db: reference.level(range, Weighting::Z),
        });
        sound.uncertainty = Uncertainty {
            minus: None,
            plus: (here > 0.0).then(|| 10.0 * (above / here).log10()),
            basis: "radiation efficiency of the housing's vibration: that of an oscillating sphere of the tool's \
                volume is \
                    taken; up to 1"
                .to_owned(),
        };
        let source_range = spectra.range_hz;
        sound.spectrum = SourceSpectrum::sum(
            NAME,
            "rigid motion, ERP of the housing as compact body",
            &[rigid, vibration],
        );
        sound.spectrum.range_hz = source_range;
        sound.signals[0].0 = "rigid motion";
        sound.signals.push(signals);
        Ok(sound)
    }
}

/// The cap as a part that counts towards a source. The error of the housing may be entirely in its cap.
fn moved<T>(part: T, counts_to: &'static str) -> Moved<T> {
    Moved {
        to: counts_to.into(),
        error: PartError::OfWhole,
        part,
    }
}

impl Emission for HousingSound {
    const CODE: Code = CODE;

    fn energy(&self) -> Result<Apart<SourceSpectrum>, Error> {
        let mut sound = self.sound(Detail::Levels)?;
        let wall = self.wall(&mut sound)?;
        let whole = sound.spectrum;
        let apart = match self.cap()? {
            Some((cap, counts_to)) => Apart {
                own: whole.without(&cap.spectrum).map_err(AcousticsError::from)?,
                moved: Some(moved(cap.spectrum, counts_to)),
            },
            None => Apart::whole(whole),
        };
        Ok(match wall {
            Some((fitting, wall)) => fitting.assign(apart, wall.sound.spectrum, with_wall),
            None => apart,
        })
    }

    fn analysed(&self, edges: &EventEdges, _: [f64; 2]) -> Result<Apart<SoundSource>, Error> {
        let mut sound = self.sound(Detail::Levels)?;
        let wall = self.wall(&mut sound)?;
        let apart = self.without_cap(sound, edges)?;
        Ok(match wall {
            Some((fitting, wall)) => {
                let wall = SoundSource::new(wall.sound, edges, self.range_hz);
                fitting.assign(apart, wall, source_with_wall)
            }
            None => apart,
        })
    }
}

/// A spectrum with that of the wall.
fn with_wall(own: &SourceSpectrum, wall: &SourceSpectrum) -> SourceSpectrum {
    let mut sum = sum_with(own, wall);
    if sum.source == CAP {
        CAP_AND_FITTING.clone_into(&mut sum.source);
    }
    sum
}

/// A source with the wall.
fn source_with_wall(own: &SoundSource, wall: &SoundSource) -> SoundSource {
    let spectrum = with_wall(&own.spectrum, &wall.spectrum);
    SoundSource {
        spectrum,
        ..own.with(wall)
    }
}

/// A source and its sound at the microphones with the wall.
fn heard_with_wall(own: &Heard, wall: &Heard) -> Heard {
    Heard {
        source: source_with_wall(&own.source, &wall.source),
        received: own.received.with(&wall.received, 1.0),
    }
}

/// How many modes are rigid: those of a free body, whose frequencies rise, come first.
fn rigid_modes(body: &Body) -> usize {
    body.omega.iter().take_while(|&&omega| omega == 0.0).count()
}

/// Sound of the tool's body.
#[derive(Serialize)]
pub(crate) struct HousingSource {
    /// Inputs of the sound.
    pub(crate) sound: HousingSound,
    /// Its housing as a radiator with pressures at the microphones, if it is elastic and solved by boundary elements.
    pub(crate) at_microphones: Option<HousingAtMicrophones>,
    /// End of all records \[s\].
    pub(crate) end: Stored<f64>,
    /// The microphones.
    pub(crate) microphones: MicrophoneArray,
    /// The tool as the sphere of its volume.
    pub(crate) sphere: ToolSphere,
}

impl Stage for HousingSource {
    type Output = SourceSound;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "sound of the tool's body";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<SourceSound, Error> {
        let mut sound = self.sound.sound(Detail::Report)?;
        let wall = self.sound.wall(&mut sound)?;
        let (record, end) = (self.sound.cycle.get()?, *self.end.get()?);
        let housing = self.sound.elastic.as_ref();
        let by_pressures = self.at_microphones.as_ref().zip(housing);
        let pressures = match by_pressures {
            Some((at, housing)) => Radiator::pressures(&*at.whole.get()?, &[&housing.motion.get()?.spectra])?,
            None => None,
        };
        let by_body = pressures.as_ref().map(|found| Pressures {
            frequency: found.frequency.clone(),
            values: Default::default(),
            ..*found
        });
        let mut received = match &pressures {
            Some(pressures) => self.microphones.pressures(pressures, &sound.spectrum, end)?,
            None => self
                .microphones
                .oscillating_sphere(&self.sphere, &record, &sound, end)?,
        };
        let parts = housing.map(|housing| LimitedPart {
            name: "tool".into(),
            contribution: VIBRATION.into(),
            top_hz: housing.top_hz,
        });
        let range = self.microphones.range_hz;
        let truncations = truncations((NAME, &sound.spectrum), range, parts);
        let edges = EventEdges::new(&record.events, end);
        let Apart { own: source, moved } = self.sound.without_cap(sound, &edges)?;
        let cap = by_pressures.and_then(|(at, housing)| Some((at.cap.as_ref()?, &housing.motion)));
        let moved = match (moved, cap, pressures) {
            (Some(moved), Some((bem, motion)), Some(whole)) => {
                let motion = motion.get()?;
                let still = ModalSpectra {
                    accelerations: &motion.spectra.accelerations * Complex::default(),
                    ..motion.spectra.clone()
                };
                let cap = Radiator::pressures(&*bem.get()?, &[&still, &motion.spectra])?;
                let cap = cap.map(|cap| self.microphones.part(&whole, &cap, &moved.part.spectrum, end));
                cap.transpose()?.map(|received| {
                    let Moved {
                        to,
                        error,
                        part: source,
                    } = moved;
                    let part = Heard { source, received };
                    Moved { to, error, part }
                })
            }
            _ => None,
        };
        if let Some(cap) = &moved {
            received = received.with(&cap.part.received, -1.0);
        }
        let mut heard = Apart {
            own: Heard { source, received },
            moved,
        };
        if let Some((fitting, wall)) = wall {
            let places = self.microphones.receivers();
            let around = (self.microphones.reflecting_plane, &self.microphones.air);
            let found = fitting.pressures(&wall, &places, around, by_body.as_ref())?;
            let received = self.microphones.pressures(&found, &wall.sound.spectrum, end)?;
            let source = SoundSource::new(wall.sound, &edges, self.sound.range_hz);
            heard = fitting.assign(heard, Heard { source, received }, heard_with_wall);
        }
        Ok(SourceSound {
            heard,
            truncations,
            checks: Vec::new(),
            histories: Vec::new(),
        })
    }
}

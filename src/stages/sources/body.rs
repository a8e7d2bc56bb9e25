//! The tool's body as a source: rigid, or elastic by boundary elements or as the sphere of its volume.

use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_acoustics::radiation::{
    CompactErp, Erp, ModalSpectra, PartOfSurface, RadiatingSurface, radiated_energy, radiated_signals,
    sphere_efficiency,
};
use nailnoise_acoustics::radiator::{Detail, FluidLoads, Loading, MovingBody, Radiator, RigidSphere};
use nailnoise_acoustics::{AcousticsError, Air};
use nailnoise_dynamics::CycleRecord;
use nailnoise_meshes::open_faces;
use nalgebra::Complex;
use serde::Serialize;

use super::{CODE, SurfaceSource};
use crate::error::Error;
use crate::result::{CrossCheck, Uncertainty};
use crate::stages::bodies::Body;
use crate::stages::convention::MovedPart;
use crate::stages::intervals::EventEdges;
use crate::stages::microphones::{MicrophoneArray, ToolSphere};
use crate::stages::sound::{Sound, SoundSource};
use crate::stages::spectra::BodyMotion;
use crate::stages::truncation::{Part, truncations};
use crate::stages::{Code, Input, Postcard, Progress, Stage, Stored};

/// Name of the source.
const NAME: &str = "body";

/// Name of the part of the source that counts to the exhaust by the convention of wrapping.
const CAP: &str = "cap";

/// Name of the part of the source that the elastic modes radiate.
const VIBRATION: &str = "housing";

/// Inputs of the sound of the tool's body.
#[derive(Clone, Serialize)]
pub struct BodySound {
    /// Its elastic housing; none for a rigid body.
    pub housing: Option<Housing>,
    /// Its volume \[m³\].
    pub volume: f64,
    /// The ambient air.
    pub air: Air,
    /// Range over which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
    /// The cycle.
    pub cycle: Stored<CycleRecord>,
}

/// A housing as a radiator with pressures at the microphones.
#[derive(Clone, Serialize)]
pub struct HousingAtMicrophones {
    /// The whole.
    pub whole: Stored<ModalBem>,
    /// Matrix with only the cap in motion, after each mode of the full body, if the cap counts to another source.
    pub cap: Option<Stored<ModalBem>>,
}

/// An elastic housing in motion.
#[derive(Clone, Serialize)]
pub struct Housing {
    /// The body.
    pub body: Stored<Body>,
    /// Frequency up to which the result includes its motion \[Hz\].
    pub top_hz: f64,
    /// Its motion.
    pub motion: Stored<BodyMotion>,
    /// Its radiation by boundary elements, if the design requests them.
    pub radiator: Option<Stored<ModalBem>>,
    /// Fluid loads of the air on its modes, if boundary elements yield them.
    pub loads: Option<Stored<Vec<FluidLoads>>>,
    /// Fluid loads that act on its motion.
    pub acts: Loading,
    /// Loss factor of its modes \[-\].
    pub loss_factor: f64,
    /// Its radiation with only the cap in motion, after each mode of the full body, if the cap counts to another
    /// source.
    pub cap: Option<Stored<ModalBem>>,
}

impl BodySound {
    /// The inputs that it reads in every case.
    pub(in crate::stages) fn inputs(&self) -> Vec<&dyn Input> {
        let mut inputs: Vec<&dyn Input> = vec![&self.cycle];
        if let Some(housing) = &self.housing {
            inputs.extend([&housing.body as &dyn Input, &housing.motion]);
            inputs.extend(housing.radiator.iter().map(|radiator| radiator as &dyn Input));
            inputs.extend(housing.loads.iter().map(|loads| loads as &dyn Input));
            inputs.extend(housing.cap.iter().map(|cap| cap as &dyn Input));
        }
        inputs
    }

    /// Its sound.
    pub(in crate::stages) fn sound(&self, detail: Detail) -> Result<Sound, Error> {
        let record = self.cycle.get()?;
        let Some(housing) = &self.housing else {
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

    /// Energy and signals of its cap, if that counts to another source.
    pub(in crate::stages) fn cap(&self) -> Result<Option<PartOfSurface>, Error> {
        let housing = self.housing.as_ref();
        let Some((housing, cap)) = housing.and_then(|housing| Some((housing, housing.cap.as_ref()?))) else {
            return Ok(None);
        };
        let motion = housing.motion.get()?;
        Ok(Some(PartOfSurface::new(CAP, &*cap.get()?, &motion.spectra)?))
    }

    /// The source without its cap, and the cap, analysed between the events.
    pub(in crate::stages) fn analysed(
        &self,
        sound: Sound,
        edges: &EventEdges,
    ) -> Result<(SoundSource, Option<SoundSource>), Error> {
        let uncertainty = sound.uncertainty.clone();
        let whole = SoundSource::new(sound, edges, self.range_hz);
        let Some(cap) = self.cap()? else {
            return Ok((whole, None));
        };
        let cap = SoundSource::of_part(cap, uncertainty, edges, self.range_hz);
        Ok((whole.without(&cap).map_err(AcousticsError::from)?, Some(cap)))
    }

    fn rigid<'a>(&'a self, record: &'a CycleRecord) -> RigidSphere<'a> {
        RigidSphere {
            acceleration: &record.tool.acceleration,
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
        record: &CycleRecord,
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
        record: &CycleRecord,
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

    /// Rigid motion as that of the sphere of its volume, elastic modes by their ERP into the open air times the radiation
    /// efficiency of that sphere.
    fn as_sphere(&self, body: &Body, spectra: &ModalSpectra, record: &CycleRecord) -> Result<Sound, Error> {
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
            basis: "radiation efficiency of the housing's vibration: that of an oscillating sphere of the tool's volume is \
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

/// How many modes are rigid: those of a free body, whose frequencies rise, come first.
fn rigid_modes(body: &Body) -> usize {
    body.omega.iter().take_while(|&&omega| omega == 0.0).count()
}

/// Sound of the tool's body.
#[derive(Serialize)]
pub struct BodySource {
    /// Inputs of the sound.
    pub sound: BodySound,
    /// Its housing as a radiator with pressures at the microphones, if it is elastic and solved by boundary elements.
    pub at_microphones: Option<HousingAtMicrophones>,
    /// End of all records \[s\].
    pub end: Stored<f64>,
    /// The microphones.
    pub microphones: MicrophoneArray,
    /// The tool as the sphere of its volume.
    pub sphere: ToolSphere,
}

impl Stage for BodySource {
    type Output = SurfaceSource;
    type Codec = Postcard;
    const NAME: &'static str = "sound of the tool's body";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        let mut inputs = self.sound.inputs();
        inputs.push(&self.end);
        if let Some(housing) = &self.at_microphones {
            inputs.push(&housing.whole);
            inputs.extend(housing.cap.iter().map(|cap| cap as &dyn Input));
        }
        inputs
    }

    fn compute(&self, _: &Progress) -> Result<SurfaceSource, Error> {
        let sound = self.sound.sound(Detail::Report)?;
        let (record, end) = (self.sound.cycle.get()?, *self.end.get()?);
        let housing = self.sound.housing.as_ref();
        let by_pressures = self.at_microphones.as_ref().zip(housing);
        let pressures = match by_pressures {
            Some((at, housing)) => Radiator::pressures(&*at.whole.get()?, &[&housing.motion.get()?.spectra])?,
            None => None,
        };
        let mut received = match &pressures {
            Some(pressures) => self.microphones.pressures(pressures, &sound.spectrum, end)?,
            None => self
                .microphones
                .oscillating_sphere(&self.sphere, &record, &sound, end)?,
        };
        let parts = housing.map(|housing| Part {
            name: "tool".into(),
            contribution: VIBRATION.into(),
            top_hz: housing.top_hz,
        });
        let range = self.microphones.range_hz;
        let truncations = truncations((NAME, &sound.spectrum), range, parts);
        let (source, cap) = self.sound.analysed(sound, &EventEdges::new(&record.events, end))?;
        let moving = by_pressures.and_then(|(at, housing)| Some((at.cap.as_ref()?, &housing.motion)));
        let moved = match (cap, moving, pressures) {
            (Some(source), Some((bem, motion)), Some(whole)) => {
                let motion = motion.get()?;
                let still = ModalSpectra {
                    accelerations: &motion.spectra.accelerations * Complex::default(),
                    ..motion.spectra.clone()
                };
                let cap = Radiator::pressures(&*bem.get()?, &[&still, &motion.spectra])?;
                let cap = cap.map(|cap| self.microphones.part(&whole, &cap, &source.spectrum, end));
                cap.transpose()?.map(|received| MovedPart { source, received })
            }
            _ => None,
        };
        if let Some(cap) = &moved {
            received = received.with(&cap.received, -1.0);
        }
        Ok(SurfaceSource {
            source,
            received,
            truncations,
            moved,
        })
    }
}

/// Energy over frequency of the tool's body, and of its cap if that counts to another source.
#[derive(Serialize)]
pub struct BodyEnergy {
    /// Inputs of the sound.
    pub sound: BodySound,
}

impl Stage for BodyEnergy {
    /// The body without its cap, and the cap.
    type Output = (SourceSpectrum, Option<SourceSpectrum>);
    type Codec = Postcard;
    const NAME: &'static str = "energy of the tool's body";
    const CODE: Code = CODE;

    fn inputs(&self) -> Vec<&dyn Input> {
        self.sound.inputs()
    }

    fn compute(&self, _: &Progress) -> Result<(SourceSpectrum, Option<SourceSpectrum>), Error> {
        let whole = self.sound.sound(Detail::Levels)?.spectrum;
        let Some(cap) = self.sound.cap()? else {
            return Ok((whole, None));
        };
        let rest = whole.without(&cap.spectrum).map_err(AcousticsError::from)?;
        Ok((rest, Some(cap.spectrum)))
    }
}

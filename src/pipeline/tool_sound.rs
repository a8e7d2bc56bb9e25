//! Sound of the tool's elastic housing.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_acoustics::radiation::{
    CompactErp, Erp, ModalSpectra, radiated_energy, radiated_signals, sphere_efficiency,
};
use nailnoise_dynamics::CycleRecord;
use nailnoise_meshes::open_faces;
use nalgebra::Complex;

use super::Tool;
use super::radiation::{by_boundary_elements, rigid_tool};
use crate::design::Design;
use crate::error::Error;
use crate::result::{CrossCheck, Uncertainty};
use crate::stages::radiation::radiating_surface;
use crate::stages::sound::Sound;

/// Name of the part of the source that the elastic modes radiate.
pub(super) const VIBRATION: &str = "housing";

impl Tool {
    /// Its sound: by boundary elements where the design asks for them, beside that of a sphere.
    ///
    /// # Errors
    /// Those of surface and radiation.
    pub(super) fn sound(&self, design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
        let Some(bem) = &self.bem else {
            return self.sound_as_sphere(design, record, air);
        };
        let damping = self.damping.as_ref().map(std::slice::from_ref);
        let mut sound = by_boundary_elements("body", bem, (&[&self.body], damping), &self.spectra)?;
        let range = [design.analysis.range_low, design.analysis.range_high];
        sound.cross_check = Some(CrossCheck {
            quantity: "the tool's body".into(),
            lw_db: sound.spectrum.level(range, Weighting::Z),
            other: "rigid motion and ERP of a sphere of its volume".into(),
            other_lw_db: self.as_sphere(bem, design, record, air)?.level(range, Weighting::Z),
        });
        sound.uncertainty.basis += "; what is nailed neither reflects nor shades";
        Ok(sound)
    }

    /// How many modes are rigid: those of a free body, whose frequencies rise, come first.
    fn rigid(&self) -> usize {
        self.body.omega.iter().take_while(|&&omega| omega == 0.0).count()
    }

    /// The energy of [`Self::sound_as_sphere`], from the skin of the boundary elements.
    fn as_sphere(
        &self,
        bem: &ModalBem,
        design: &Design,
        record: &CycleRecord,
        air: &Air,
    ) -> Result<SourceSpectrum, Error> {
        let mut elastic = self.spectra.clone();
        elastic.accelerations.rows_mut(0, self.rigid()).fill(Complex::default());
        let mut housing = radiated_energy(VIBRATION, &bem.reference(), &elastic)?;
        housing.contributions.clear();
        for (energy, &hz) in housing.energy_density.iter_mut().zip(&housing.frequency) {
            *energy *= sphere_efficiency(design.body.volume(), air, hz);
        }
        let rigid = rigid_tool(design, record, air)?.spectrum;
        Ok(SourceSpectrum::sum("body", "as a sphere", &[rigid, housing]))
    }

    /// Rigid motion as that of the sphere of its volume, elastic modes by their ERP into the open air times the radiation
    /// efficiency of that sphere.
    fn sound_as_sphere(&self, design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
        let mut sound = rigid_tool(design, record, air)?;
        sound.spectrum.source = "rigid motion".to_owned();
        let (rigid, surface) = (self.rigid(), &self.body.surface);
        let elastic = self.body.omega.len() - rigid;
        let open = open_faces(surface, None)?;
        let shapes = self.body.skin.columns(rigid, elastic);
        let erp = Erp::new(&radiating_surface(surface, shapes, |point| open[point.face])?, air);
        let spectra = ModalSpectra {
            frequency: self.spectra.frequency.clone(),
            accelerations: self.spectra.accelerations.rows(rigid, elastic).into_owned(),
            range_hz: self.spectra.range_hz,
        };
        let range = [design.analysis.range_low, design.analysis.range_high];
        let reference = radiated_energy(VIBRATION, &erp, &spectra)?;
        let compact = CompactErp::new(erp, design.body.volume(), air)?;
        let vibration = radiated_energy(VIBRATION, &compact, &spectra)?;
        let signals = (VIBRATION, radiated_signals(&compact, &spectra, &vibration)?);
        let rigid = sound.spectrum;
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
            "body",
            "rigid motion, ERP of the housing as compact body",
            &[rigid, vibration],
        );
        sound.spectrum.range_hz = source_range;
        sound.signals[0].0 = "rigid motion";
        sound.signals.push(signals);
        Ok(sound)
    }
}

//! A body in rigid motion along one axis, modelled as a sphere of equal volume.

use super::{RadiatedSound, RadiationBand, RadiationReport, Uncertainty};
use crate::air::Air;
use crate::error::AcousticsError;
use crate::radiation::sound::rigid_body_far_field;
use crate::radiation::{rigid_body_energy, rigid_body_signals, sphere_efficiency};
use crate::signals::fourier::TransformSettings;
use crate::signals::{SourceSpectrum, Weighting, energy_level};

/// A body in rigid motion.
#[derive(Debug, Clone, Copy)]
pub struct RigidSphere<'a> {
    /// Its acceleration \[m/s²\].
    pub acceleration: &'a [f64],
    /// Interval of the samples \[s\].
    pub sample_interval: f64,
    /// Its volume \[m³\].
    pub volume: f64,
    /// The air around it.
    pub air: &'a Air,
    /// Analysed range \[Hz\].
    pub range_hz: [f64; 2],
}

impl RigidSphere<'_> {
    /// Energy and signal of the body: a lower bound if the body also vibrates.
    ///
    /// # Errors
    /// Same as [`rigid_body_energy`].
    pub fn sound(&self, source: &'static str) -> Result<RadiatedSound, AcousticsError> {
        let Self {
            acceleration,
            sample_interval,
            volume,
            air,
            ..
        } = *self;
        let settings = self.settings();
        let signals = rigid_body_signals(acceleration, sample_interval, volume, air, &settings)?;
        Ok(RadiatedSound {
            spectrum: rigid_body_energy(source, acceleration, sample_interval, volume, air, &settings)?,
            signals: vec![(source, signals)],
            uncertainty: Uncertainty {
                minus: Some(0.0),
                plus: None,
                basis: "rigid motion only: vibration of the housing adds to it".to_owned(),
            },
            report: None,
        })
    }

    /// Same as `sound`, with a second evaluation of the power: from the resistance of the sphere's surface, and from
    /// its far field.
    ///
    /// # Errors
    /// Same as [`Self::sound`].
    pub fn sound_with_check(&self, source: &'static str) -> Result<RadiatedSound, AcousticsError> {
        let Self {
            acceleration,
            sample_interval,
            volume,
            air,
            ..
        } = *self;
        let sound = self.sound(source)?;
        let far_field = rigid_body_far_field(source, acceleration, sample_interval, volume, air, &self.settings())?;
        Ok(RadiatedSound {
            report: Some(report(&far_field, &sound.spectrum, volume, air)),
            ..sound
        })
    }

    fn settings(&self) -> TransformSettings {
        TransformSettings {
            range_hz: self.range_hz,
            ..TransformSettings::default()
        }
    }
}

/// The report of a rigid tool modelled as a sphere of equal volume, with its power in closed form from the resistance
/// of its surface and from its far field. With radiation efficiency 1, the surface would radiate
///
/// ```text
/// E_1(f) = E(f) (4 + (k a)^4) / (k a)^4
/// ```
fn report(far_field: &SourceSpectrum, surface: &SourceSpectrum, volume: f64, air: &Air) -> RadiationReport {
    let range = far_field.range_hz;
    let of_bin = |(hz, energy): (&f64, &f64)| energy / sphere_efficiency(volume, air, *hz);
    let erp = SourceSpectrum {
        energy_density: surface
            .frequency
            .iter()
            .zip(&surface.energy_density)
            .map(of_bin)
            .collect(),
        ..surface.clone()
    };
    let level = |spectrum: &SourceSpectrum| energy_level(spectrum.energy(range, Weighting::A));
    let [by_field, by_surface, by_erp] = [far_field, surface, &erp].map(|spectrum| spectrum.band_levels(range));
    let rows = by_field.iter().zip(&by_surface).zip(&by_erp);
    RadiationReport {
        join_hz: [range[1]; 2],
        solved_hz: [range[1]; 2],
        frequencies: far_field.frequency.len(),
        interpolation_error: 0.0,
        surface_difference_db: level(surface)
            .zip(level(far_field))
            .map(|(surface, field)| surface - field),
        limit_error_db: [0.0; 2],
        blend_error_db: None,
        erp_lwa_db: level(&erp),
        fluid_loading: None,
        modes: Vec::new(),
        bands: rows
            .filter(|((field, _), _)| field.band.high > range[0] && field.band.low < range[1])
            .map(|((field, surface), erp)| RadiationBand {
                hz: field.band.nominal_hz(),
                lw_db: field.lw,
                surface_lw_db: surface.lw,
                erp_lw_db: erp.lw,
                limit_lw_db: None,
            })
            .collect(),
    }
}

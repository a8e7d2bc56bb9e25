//! A surface flush with the surrounding sand, by Rayleigh's integral.

use super::{AbsorbingSand, FlushSound};
use crate::error::AcousticsError;
use crate::radiation::fluid_loading::DryModes;
use crate::radiation::radiator::fluid_loading::needs_no_mass;
use crate::radiation::radiator::{
    Detail, FluidLoading, FluidLoads, Loading, MovingBody, Pressures, RadiatedSound, RadiationBand, RadiationReport,
    Radiator, Uncertainty, damping_ratios, mode_shares,
};
use crate::radiation::{Erp, ModalRadiation, ModalSpectra, mode_energies, radiated_energy, radiated_signals};
use crate::signals::{BandLevel, SourceSpectrum, Weighting, energy_level, energy_weights};

/// One body whose surface is flush with sand.
pub struct FlushRadiator {
    /// Its radiation from spherical waves and from the intensity on the surface, and its pressure at the receivers.
    pub sound: FlushSound,
    /// Its equivalent radiated power.
    pub erp: Erp,
    /// The sand as an absorber.
    pub sand: AbsorbingSand,
}

impl Radiator for FlushRadiator {
    fn energy(&self, source: &str, motions: &[&ModalSpectra]) -> Result<SourceSpectrum, AcousticsError> {
        radiated_energy(source, &self.sound.waves, motions[0])
    }

    fn sound(
        &self,
        source: &'static str,
        bodies: &[MovingBody<'_>],
        detail: Detail,
    ) -> Result<RadiatedSound, AcousticsError> {
        let (waves, motion) = (&self.sound.waves, bodies[0].spectra);
        let spectrum = radiated_energy(source, waves, motion)?;
        let signals = vec![(source, radiated_signals(waves, motion, &spectrum)?)];
        let report = match detail {
            Detail::Levels => None,
            Detail::Report => {
                let ratios = self.sound.surface.ratios(waves, motion)?;
                let erp = radiated_energy(source, &self.erp, motion)?;
                let mut report = report(&self.sound, &spectrum, &ratios, &erp);
                let weights = energy_weights(&spectrum.frequency, spectrum.range_hz, Weighting::A);
                let energies = mode_energies(waves, motion, &weights)?;
                report.modes = mode_shares(bodies, &energies);
                report.fluid_loading = FluidLoading::new(bodies, &energies, report.solved_hz[1]);
                Some(report)
            }
        };
        Ok(RadiatedSound {
            uncertainty: sand_band(&spectrum, &self.sand, motion.range_hz),
            spectrum,
            signals,
            report,
        })
    }

    fn loads(&self, bodies: &[DryModes], acts: Loading) -> Result<Vec<FluidLoads>, AcousticsError> {
        needs_no_mass(acts, "Rayleigh's integral over the surface in sand")?;
        let of_body = |body: &DryModes| FluidLoads::damping_only(damping_ratios(&self.sound.waves, body.omega()));
        Ok(bodies.iter().map(of_body).collect())
    }

    fn pressures(&self, motions: &[&ModalSpectra]) -> Result<Option<Pressures>, AcousticsError> {
        let motion = motions[0];
        let pressures = &self.sound.pressures;
        Ok(Some(Pressures {
            method: "Rayleigh's integral",
            frequency: motion.frequency.clone(),
            values: pressures.pressures(&self.sound.waves, &motion.frequency, &motion.accelerations),
            fade_hz: None,
            range_hz: motion.range_hz,
            interpolation_error: pressures.error(),
        }))
    }
}

/// The report of a flush surface: its power from spherical waves, from the intensity on the surface (`ratios` per
/// band), and with radiation efficiency 1.
fn report(flush: &FlushSound, waves: &SourceSpectrum, ratios: &[Option<f64>], erp: &SourceSpectrum) -> RadiationReport {
    let range = waves.range_hz;
    let ratio_of = |band: i32| {
        let place = flush.surface.bands().iter().position(|own| own.index == band)?;
        ratios[place]
    };
    let bands = waves.band_levels(range);
    let (mut by_waves, mut by_surface) = (0.0, 0.0);
    for band in &bands {
        if let Some(ratio) = ratio_of(band.band.index) {
            let energy = waves.energy(
                [band.band.low.max(range[0]), band.band.high.min(range[1])],
                Weighting::A,
            );
            by_waves += energy;
            by_surface += ratio * energy;
        }
    }
    let inside = |b: &BandLevel| b.band.high > range[0] && b.band.low < range[1];
    let rows = bands.iter().zip(erp.band_levels(range));
    RadiationReport {
        // No other method is used above.
        join_hz: [flush.waves.highest_hz().min(range[1]); 2],
        solved_hz: [flush.waves.highest_hz().min(range[1]); 2],
        frequencies: flush.waves.sampled_hz().len(),
        interpolation_error: flush.waves.interpolation_error(),
        surface_difference_db: (by_waves > 0.0).then(|| 10.0 * (by_surface / by_waves).log10()),
        limit_error_db: [0.0; 2],
        blend_error_db: None,
        erp_lwa_db: energy_level(erp.energy(range, Weighting::A)),
        fluid_loading: None,
        modes: Vec::new(),
        bands: rows
            .filter(|(waves, _)| inside(waves))
            .map(|(waves, erp)| RadiationBand {
                hz: waves.band.nominal_hz(),
                lw_db: waves.lw,
                surface_lw_db: waves
                    .lw
                    .zip(ratio_of(waves.band.index))
                    .map(|(lw, ratio)| lw + 10.0 * ratio.log10()),
                erp_lw_db: erp.lw,
                limit_lw_db: None,
            })
            .collect(),
    }
}

/// Uncertainty due to the absorption of the sand, which ranges from that of an infinite plane of sand to none.
fn sand_band(source: &SourceSpectrum, sand: &AbsorbingSand, range_hz: [f64; 2]) -> Uncertainty {
    let plane: Vec<f64> = source
        .frequency
        .iter()
        .map(|&hz| sand.infinite_plane_factor(hz))
        .collect();
    let with_share = |share: f64| {
        let factor = |g: &f64| g.powf(share - sand.share);
        let density = source
            .energy_density
            .iter()
            .zip(&plane)
            .map(|(e, g)| e * factor(g))
            .collect();
        let changed = SourceSpectrum {
            energy_density: density,
            contributions: Vec::new(),
            ..source.clone()
        };
        changed.level(range_hz, Weighting::A)
    };
    let difference = |share: f64| Some((with_share(share)? - source.level(range_hz, Weighting::A)?).abs());
    Uncertainty {
        minus: difference(1.0),
        plus: difference(0.0),
        basis: "absorption by the sand, from that of an infinite plane to none".to_owned(),
    }
}

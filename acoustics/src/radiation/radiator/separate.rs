//! Non-interacting bodies with radiation efficiency 1.

use super::fluid_loading::needs_no_mass;
use super::{Detail, FluidLoads, Loading, MovingBody, Pressures, RadiatedSound, Radiator, Uncertainty, motions};
use crate::error::AcousticsError;
use crate::radiation::fluid_loading::DryModes;
use crate::radiation::{Erp, ModalSpectra, radiated_energy, radiated_signals};
use crate::signals::SourceSpectrum;

/// Radiation efficiency of a plate near coincidence, for the upper end of the uncertainty.
///
/// Chosen as that of baffled modes with three half-waves along each side, whose peaks by Wallace's integral (C. E.
/// Wallace 1972, "Radiation resistance of a rectangular panel", J. Acoust. Soc. Am. 51, 946-952) are 1.83 for a square
/// plate and 1.72 for one twice as long as it is wide. Modes with five half-waves peak at 2.2. A single such mode at
/// coincidence would exceed the upper end by 1 dB. The choice has no effect on levels, and the interval has no lower
/// end.
const HIGHEST_EFFICIENCY: f64 = 1.76;

/// Bodies whose equivalent radiated powers are added. They have no directivity and no radiation damping, and at low
/// frequencies the equivalent radiated power is far too high.
pub struct SeparateBodies(pub Vec<(&'static str, Erp)>);

impl Radiator for SeparateBodies {
    fn energy(&self, source: &str, motions: &[&ModalSpectra]) -> Result<SourceSpectrum, AcousticsError> {
        let parts = self.0.iter().zip(motions);
        let parts = parts.map(|((name, erp), motion)| radiated_energy(*name, erp, motion));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let mut sum = SourceSpectrum::sum(source, "ERP", &parts);
        if let Some(first) = motions.first() {
            sum.range_hz = first.range_hz;
        }
        Ok(sum)
    }

    fn sound(
        &self,
        source: &'static str,
        bodies: &[MovingBody<'_>],
        _: Detail,
    ) -> Result<RadiatedSound, AcousticsError> {
        let mut signals = Vec::new();
        for ((name, erp), body) in self.0.iter().zip(bodies) {
            let part = radiated_energy(*name, erp, body.spectra)?;
            signals.push((*name, radiated_signals(erp, body.spectra, &part)?));
        }
        Ok(RadiatedSound {
            spectrum: self.energy(source, &motions(bodies))?,
            signals,
            uncertainty: Uncertainty {
                minus: None,
                plus: Some(10.0 * HIGHEST_EFFICIENCY.log10()),
                basis: "radiation efficiency taken as 1: near coincidence it is higher, at low frequencies far lower"
                    .to_owned(),
            },
            report: None,
        })
    }

    fn loads(&self, bodies: &[DryModes], acts: Loading) -> Result<Vec<FluidLoads>, AcousticsError> {
        needs_no_mass(acts, "radiation efficiency 1")?;
        let of_body = |body: &DryModes| FluidLoads::damping_only(vec![0.0; body.count()]);
        Ok(bodies.iter().map(of_body).collect())
    }

    fn pressures(&self, _: &[&ModalSpectra]) -> Result<Option<Pressures>, AcousticsError> {
        Ok(None)
    }
}

//! Radiation of vibrating structures: power with a second evaluation, and pressures at receivers.
//!
//! A [`Radiator`] represents one or several bodies with their surroundings:
//! [`ModalBem`](super::boundary_elements::ModalBem), a surface
//! [flush with sand](super::flush_with_sand::FlushRadiator), or bodies of radiation efficiency 1
//! ([`SeparateBodies`]). A rigid tool radiates as a [sphere](RigidSphere) of equal volume.

mod boundary_elements;
pub(crate) mod fluid_loading;
mod loading_report;
mod moving_body;
mod report;
mod separate;
mod sphere;

pub use boundary_elements::FADE_OCTAVES;
pub use fluid_loading::{FluidLoads, Loading};
pub use loading_report::FluidLoading;
pub use moving_body::MovingBody;
pub use report::{ModeShare, RadiationBand, RadiationReport, Uncertainty};
pub use separate::SeparateBodies;
pub use sphere::RigidSphere;

use crate::error::AcousticsError;
use crate::radiation::fluid_loading::{DryModes, Impedance};
use crate::radiation::{ModalRadiation, ModalSpectra};
use crate::signals::{PowerSignals, SourceSpectrum};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// One or several bodies that radiate together, for example the workpiece and the table under it.
///
/// Motions are given by body, in the order of the bodies in the radiator.
pub trait Radiator: Send + Sync {
    /// Energy spectrum of the source `source`.
    ///
    /// # Errors
    /// If the number of modes differs from the bodies', or the range exceeds the radiator's.
    fn energy(&self, source: &str, motions: &[&ModalSpectra]) -> Result<SourceSpectrum, AcousticsError>;

    /// Energy spectrum and signals of the source `source`, with the second evaluation of its power if available and
    /// requested by `detail`.
    ///
    /// # Errors
    /// Same as [`Self::energy`].
    fn sound(
        &self,
        source: &'static str,
        bodies: &[MovingBody<'_>],
        detail: Detail,
    ) -> Result<RadiatedSound, AcousticsError>;

    /// The effects of the fluid on each mode of each body.
    ///
    /// # Errors
    /// If the mass should act: an error for a method without reactance, and those of
    /// [`WetModes::new`](crate::radiation::fluid_loading::WetModes::new).
    fn loads(&self, bodies: &[DryModes], acts: Loading) -> Result<Vec<FluidLoads>, AcousticsError>;

    /// Pressures at the receivers of the radiator; `None` if only its power is known.
    ///
    /// # Errors
    /// Same as [`Self::energy`].
    fn pressures(&self, motions: &[&ModalSpectra]) -> Result<Option<Pressures>, AcousticsError>;

    /// Radiation impedance of the modes of all bodies, one body after another; none if the method provides no
    /// reactance.
    fn impedance(&self) -> Option<&dyn Impedance> {
        None
    }
}

/// Level of detail of the sound computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Everything needed for levels: energy, signals and uncertainty. The parts of a surface are combined.
    Levels,
    /// Also the comparisons in a report: other methods, shares of the modes, fluid loading.
    Report,
}

/// The sound of a radiator.
pub struct RadiatedSound {
    /// Energy over frequency, with the parts of the surface as contributions.
    pub spectrum: SourceSpectrum,
    /// The same energy over time: named parts of the source.
    pub signals: Vec<(&'static str, PowerSignals)>,
    /// Uncertainty of the method.
    pub uncertainty: Uncertainty,
    /// The second evaluation of its power, if requested.
    pub report: Option<RadiationReport>,
}

/// Pressures at receivers.
pub struct Pressures {
    /// Label of the method.
    pub method: &'static str,
    /// Frequencies \[Hz\].
    pub frequency: Vec<f64>,
    /// Fourier transform of the pressure, receivers x frequencies \[Pa s\].
    pub values: DMatrix<Complex<f64>>,
    /// Range over which they fade out, to be replaced by averages without phase, if any \[Hz\].
    pub fade_hz: Option<[f64; 2]>,
    /// Range of validity \[Hz\].
    pub range_hz: [f64; 2],
    /// Error of the interpolation over frequency, relative to the loudest mode at any receiver \[-\].
    pub interpolation_error: f64,
}

/// Damping ratio that radiation adds to modes with these angular frequencies \[rad/s\], for unit modal mass; zero for
/// rigid modes:
///
/// ```text
/// zeta_j = R_jj(omega_j) / (2 omega_j)
/// ```
pub fn damping_ratios(radiation: &dyn ModalRadiation, omega: &[f64]) -> Vec<f64> {
    let lowest = TAU;
    let motion = |(j, w): (usize, &f64)| {
        let hz = (w.max(lowest) / TAU).min(radiation.highest_hz());
        (hz, vec![(j, 1.0)])
    };
    let motions: Vec<(f64, Vec<(usize, f64)>)> = omega.iter().enumerate().map(motion).collect();
    let ratio = |(r, w): (f64, &f64)| if *w > lowest { (r / (2.0 * w)).max(0.0) } else { 0.0 };
    let resistances = radiation.sparse_forms(&motions);
    resistances.into_iter().zip(omega).map(ratio).collect()
}

/// Contribution of each mode to the energy of all bodies, given the energies of all modes; the static corrections of a
/// body are combined.
pub(crate) fn mode_shares(bodies: &[MovingBody<'_>], energies: &[f64]) -> Vec<ModeShare> {
    let total: f64 = energies.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut energies = energies.iter();
    let mut shares = Vec::new();
    for body in bodies {
        let mut rest = 0.0;
        let mass = |number: usize| Some(body.loads?.mass.as_ref()?[number]);
        for (number, (omega, energy)) in body.omega.iter().zip(&mut energies).enumerate() {
            if number >= body.modes {
                rest += energy;
                continue;
            }
            shares.push(ModeShare {
                body: body.name.into(),
                mode: Some(number + 1),
                hz: Some(omega / TAU),
                radiation_damping: body
                    .loads
                    .filter(|_| body.acts.damps())
                    .map(|loads| loads.damping[number]),
                added_mass: mass(number),
                shift_hz: mass(number).map(|mass| loading_report::shift(mass) * omega / TAU),
                share: energy / total,
            });
        }
        shares.push(ModeShare {
            body: body.name.into(),
            mode: None,
            hz: None,
            radiation_damping: None,
            added_mass: None,
            shift_hz: None,
            share: rest / total,
        });
    }
    shares
}

/// The motions of moving bodies.
fn motions<'a>(bodies: &[MovingBody<'a>]) -> Vec<&'a ModalSpectra> {
    bodies.iter().map(|body| body.spectra).collect()
}

impl Radiator for Box<dyn Radiator> {
    fn energy(&self, source: &str, motions: &[&ModalSpectra]) -> Result<SourceSpectrum, AcousticsError> {
        self.as_ref().energy(source, motions)
    }

    fn sound(
        &self,
        source: &'static str,
        bodies: &[MovingBody<'_>],
        detail: Detail,
    ) -> Result<RadiatedSound, AcousticsError> {
        self.as_ref().sound(source, bodies, detail)
    }

    fn loads(&self, bodies: &[DryModes], acts: Loading) -> Result<Vec<FluidLoads>, AcousticsError> {
        self.as_ref().loads(bodies, acts)
    }

    fn pressures(&self, motions: &[&ModalSpectra]) -> Result<Option<Pressures>, AcousticsError> {
        self.as_ref().pressures(motions)
    }

    fn impedance(&self) -> Option<&dyn Impedance> {
        self.as_ref().impedance()
    }
}

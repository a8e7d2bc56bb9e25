use super::{AbsorbingSand, Rayleigh, SoundAbovePlane, SurfaceResistances};
use crate::air::Air;
use crate::error::AcousticsError;
use crate::radiation::{SampledRadiation, Sampling};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Radiation of a surface flush with a plane: from spherical waves, from the intensity on the surface, and as pressures
/// at points above.
///
/// The radiation of the surface without sand depends only on the wavelength and can be converted to different air
/// conditions:
///
/// ```text
/// R(f; rho, c) = (rho c)/(rho0 c0) R0(f c0/c)        p/a (f; rho, c) = rho/rho0 (p/a)0 (f c0/c)
/// ```
///
/// Absorbing sand multiplies R by its factor g(f), and p by the square root of g. Moving sand has its own wavenumber,
/// so it is computed for each state of the air, up to the frequency at which its motion ends. Above that frequency, the
/// radiation is [continued](FlushSound::continued) by that of the surface without sand. Only long sound waves matter in
/// the range where the sand moves; for these, a tenth of the surface's points suffices.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FlushSound {
    /// Its resistance, from spherical waves.
    pub waves: SampledRadiation,
    /// Resistance from pairs of points, in bands.
    pub surface: SurfaceResistances,
    /// Pressures at points above the plane.
    pub pressures: SoundAbovePlane,
}

impl FlushSound {
    /// Largest ratio between the speeds of sound of two states of the air for which a resistance can be converted: the
    /// centre of a one-third-octave band then stays in that band.
    pub const WIDEST: f64 = 1.122_018_454_301_963_3;

    /// Samples to the tolerance of `sampling`, with pressures at `places` above the plane, with the travel time from
    /// `origin` removed; `progress` is called after each frequency.
    ///
    /// # Errors
    /// The errors of [`Rayleigh::sampled`] and [`SoundAbovePlane::new`].
    pub fn new(
        surface: &Rayleigh,
        sampling: &Sampling,
        places: &[Point3<f64>],
        origin: Point3<f64>,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Self, AcousticsError> {
        let few = surface.up_to(sampling.range_hz[1]);
        let waves = few.sampled(sampling, progress)?;
        let observed = if places.iter().all(|place| few.is_far(place)) {
            &few
        } else {
            surface
        };
        Ok(Self {
            pressures: SoundAbovePlane::new(observed, &waves, places, origin)?,
            waves: waves.with_roots(),
            surface: SurfaceResistances::new(&few, sampling.range_hz[1]),
        })
    }

    /// Converts from `computed`, the air of the computation without absorbing sand, to `air` with the sand `absorbing`.
    #[must_use]
    pub fn in_air(self, computed: &Air, air: &Air, absorbing: Option<AbsorbingSand>) -> Self {
        let (speed, density) = (air.sound_speed / computed.sound_speed, air.density / computed.density);
        let left = |hz: f64| absorbing.map_or(1.0, |sand| sand.factor(hz));
        let factor = |hz: f64| density * speed * left(hz);
        let method = Rayleigh::method(absorbing.is_some(), false);
        let waves = self.waves.in_air(method, speed, factor);
        let factors: Vec<f64> = waves.samples_hz().iter().map(|&hz| density * left(hz).sqrt()).collect();
        Self {
            pressures: self.pressures.in_air(speed, &factors),
            waves,
            surface: self.surface.in_air(speed, factor),
        }
    }

    /// Joins this radiation, up to its highest frequency, with `above` beyond it.
    #[must_use]
    pub fn continued(self, above: Self) -> Self {
        let (waves, taken) = self.waves.continued(above.waves);
        Self {
            waves,
            surface: self.surface.continued(above.surface),
            pressures: self.pressures.continued(above.pressures, &taken),
        }
    }
}

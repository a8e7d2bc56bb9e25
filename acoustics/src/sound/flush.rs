use super::SoundAbovePlane;
use crate::air::Air;
use crate::error::AcousticsError;
use crate::radiation::{AbsorbingSand, Rayleigh, SampledRadiation, Sampling, SurfaceEvaluations};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// A surface flush in a plane: how it radiates, the same by the intensity on it, and what places hear of it.
///
/// What the surface does by itself depends on the wavelength alone and can be taken over to another air:
///
/// ```text
/// R(f; rho, c) = (rho c)/(rho0 c0) R0(f c0/c)        p/a (f; rho, c) = rho/rho0 (p/a)0 (f c0/c)
/// ```
///
/// Sand that absorbs multiplies R by its factor g(f) and p by the root of it. Sand that moves has a wavenumber of its own;
/// it is computed in every air, up to where it comes to rest, and [continued](FlushSound::continued) by the surface alone.
/// That is a matter of long waves, for which the surface's points are carried to a tenth of their number.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FlushSound {
    /// Its resistance, by spherical waves.
    pub waves: SampledRadiation,
    /// The same by pairs of points, band by band.
    pub surface: SurfaceEvaluations,
    /// What places hear.
    pub heard: SoundAbovePlane,
}

impl FlushSound {
    /// Largest ratio of two airs' speeds of sound over which a resistance is carried: the middle of a third-octave band
    /// then stays in that band.
    pub const WIDEST: f64 = 1.122_018_454_301_963_3;

    /// Sampled as finely as `sampling` asks, at `places` above the plane, freed of the travel time from `origin`; `progress`
    /// is called after each frequency sampled.
    ///
    /// # Errors
    /// Those of [`Rayleigh::sampled`] and [`SoundAbovePlane::new`].
    pub fn new(
        surface: &Rayleigh,
        sampling: &Sampling,
        places: &[Point3<f64>],
        origin: Point3<f64>,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Self, AcousticsError> {
        let few = surface.up_to(sampling.range_hz[1]);
        let waves = few.sampled(sampling, progress)?;
        let heard_of = if places.iter().all(|place| few.is_far(place)) {
            &few
        } else {
            surface
        };
        Ok(Self {
            heard: SoundAbovePlane::new(heard_of, &waves, places, origin)?,
            waves: waves.with_roots(),
            surface: SurfaceEvaluations::new(&few, sampling.range_hz[1]),
        })
    }

    /// In the air `air`, with sand around that absorbs, when it was computed in `computed` without any.
    #[must_use]
    pub fn in_air(self, computed: &Air, air: &Air, absorbing: Option<AbsorbingSand>) -> Self {
        let (speed, density) = (air.sound_speed / computed.sound_speed, air.density / computed.density);
        let left = |hz: f64| absorbing.map_or(1.0, |sand| sand.factor(hz));
        let factor = |hz: f64| density * speed * left(hz);
        let method = Rayleigh::method(absorbing.is_some(), false);
        let waves = self.waves.in_air(method, speed, factor);
        let heard: Vec<f64> = waves.samples_hz().iter().map(|&hz| density * left(hz).sqrt()).collect();
        Self {
            heard: self.heard.in_air(speed, &heard),
            waves,
            surface: self.surface.in_air(speed, factor),
        }
    }

    /// This up to its highest frequency, `above` from there on.
    #[must_use]
    pub fn continued(self, above: Self) -> Self {
        let (waves, taken) = self.waves.continued(above.waves);
        Self {
            waves,
            surface: self.surface.continued(above.surface),
            heard: self.heard.continued(above.heard, &taken),
        }
    }
}

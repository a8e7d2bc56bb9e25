//! Radiation of a block's top that is flush with the sand around it, by Rayleigh's integral.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::flush_with_sand::{AbsorbingSand, FlushSound, MovingSand, Rayleigh};
use nailnoise_acoustics::radiation::{RadiatingSurface, Sampling};
use nailnoise_meshes::QuadraturePoint;
use serde::Serialize;

use super::boundary_elements::{LOWEST_SAMPLE, Places};
use crate::error::Error;
use crate::stages::Progress;
use crate::stages::bodies::MovingSurface;

/// The block's top, flush with the sand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlushTop {
    /// Highest frequency of the block's motion in the analysed range \[Hz\].
    pub top_hz: f64,
    /// The microphones.
    pub places: Places,
    /// The sand as an absorber.
    pub absorbing: AbsorbingSand,
    /// The motion of the sand's surface with the block.
    pub moving: Option<MovingSand>,
}

impl FlushTop {
    /// The sand as an absorber, if it absorbs.
    fn absorber(&self) -> Option<AbsorbingSand> {
        (self.absorbing.share > 0.0).then_some(self.absorbing)
    }

    /// Rayleigh's integral over the top with the sand around it.
    ///
    /// # Errors
    /// The errors of surface and sand.
    pub fn rayleigh(&self, surface: &RadiatingSurface, air: &Air) -> Result<Rayleigh, Error> {
        let mut rayleigh = Rayleigh::new(surface, air)?;
        if let Some(sand) = self.absorber() {
            rayleigh = rayleigh.with_absorbing_sand(sand)?;
        }
        if let Some(sand) = self.moving {
            rayleigh = rayleigh.with_moving_sand(sand)?;
        }
        Ok(rayleigh)
    }

    /// The top in `air` and in its sand. Moving sand is computed for every state of the air, which takes little longer
    /// than reading it would.
    ///
    /// # Errors
    /// The errors of Rayleigh's integral.
    pub fn in_sand(
        &self,
        alone: FlushSound,
        surface: &RadiatingSurface,
        (computed, air): (&Air, &Air),
        progress: &Progress,
    ) -> Result<FlushSound, Error> {
        let sound = alone.in_air(computed, air, self.absorber());
        let Some(sand) = self.moving else {
            return Ok(sound);
        };
        let sampling = sampling_to(self.top_hz.min(sand.to_hz));
        let below = sampled(&self.rayleigh(surface, air)?, &sampling, &self.places, progress)?;
        Ok(below.continued(sound))
    }
}

/// The points of a block's top with the normal displacements of its modes.
///
/// # Errors
/// The errors of the surface.
pub fn top_of(block: &MovingSurface<'_>) -> Result<RadiatingSurface, Error> {
    let surface = block.surface;
    let top = |point: &QuadraturePoint| surface.patches[surface.faces[point.face].patch] == "top";
    Ok(RadiatingSurface::of_faces(surface, block.modes.as_view(), top)?)
}

/// A flush surface sampled over frequency, with its pressure at the microphones.
///
/// # Errors
/// The errors of Rayleigh's integral.
pub(super) fn sampled(
    rayleigh: &Rayleigh,
    sampling: &Sampling,
    places: &Places,
    progress: &Progress,
) -> Result<FlushSound, Error> {
    let points: Vec<_> = places.points.iter().map(|&point| point.into()).collect();
    progress.count_each(("Rayleigh's integral", "frequencies"), 0, |sampled| {
        Ok(FlushSound::new(
            rayleigh,
            sampling,
            &points,
            places.origin.into(),
            sampled,
        )?)
    })
}

pub(super) fn sampling_to(top_hz: f64) -> Sampling {
    Sampling {
        range_hz: [LOWEST_SAMPLE.min(0.5 * top_hz), top_hz],
        ..Sampling::default()
    }
}

//! Radiation of a block's top that is flush with the sand around it, by Rayleigh's integral.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::{AbsorbingSand, MovingSand, RadiatingSurface, Rayleigh, Sampling};
use nailnoise_acoustics::sound::FlushSound;
use nailnoise_meshes::{QuadraturePoint, Surface};
use nalgebra::{DMatrix, DMatrixView};
use serde::Serialize;

use super::MovingSurface;
use super::boundary_elements::{LOWEST_SAMPLE, Places};
use crate::error::Error;
use crate::stages::Progress;

/// Gauss points along each side of a face; the modes are quadratic on it, so their squares are integrated exactly on
/// rectangular faces.
pub(crate) const FACE_POINTS: usize = 3;

/// The block's top, flush with the sand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct FlushTop {
    /// Highest frequency of the analysis \[Hz\].
    pub(crate) range_high: f64,
    /// The microphones.
    pub(crate) places: Places,
    /// The sand as an absorber.
    pub(crate) absorbing: AbsorbingSand,
    /// The motion of the sand's surface with the block.
    pub(crate) moving: Option<MovingSand>,
}

impl FlushTop {
    /// The points of the block's top with the normal displacements of its modes.
    ///
    /// # Errors
    /// Those of the surface.
    pub(crate) fn surface(&self, block: &MovingSurface<'_>) -> Result<RadiatingSurface, Error> {
        let surface = block.surface;
        let top = |point: &QuadraturePoint| surface.patches[surface.faces[point.face].patch] == "top";
        radiating_surface(surface, block.modes.as_view(), top)
    }

    /// The sand as an absorber, if it absorbs.
    fn absorber(&self) -> Option<AbsorbingSand> {
        (self.absorbing.share > 0.0).then_some(self.absorbing)
    }

    /// Rayleigh's integral over the top with the sand around it.
    ///
    /// # Errors
    /// Those of surface and sand.
    pub(crate) fn rayleigh(&self, surface: &RadiatingSurface, air: &Air) -> Result<Rayleigh, Error> {
        let mut rayleigh = Rayleigh::new(surface, air)?;
        if let Some(sand) = self.absorber() {
            rayleigh = rayleigh.with_absorbing_sand(sand)?;
        }
        if let Some(sand) = self.moving {
            rayleigh = rayleigh.with_moving_sand(sand)?;
        }
        Ok(rayleigh)
    }

    /// The air in which the top by itself is computed: standard air, unless the wavelengths of `air` are far from it.
    pub(crate) fn computed_air(air: &Air) -> Air {
        let standard = Air::default();
        let apart = (air.sound_speed / standard.sound_speed).ln().abs() > FlushSound::WIDEST.ln();
        if apart { *air } else { standard }
    }

    /// How the resistance of a body with modes up to `top_hz` is sampled without sand.
    pub(crate) fn sampling(&self, top_hz: f64) -> Sampling {
        sampling_to(self.top(top_hz) * FlushSound::WIDEST)
    }

    fn top(&self, top_hz: f64) -> f64 {
        top_hz.min(self.range_high)
    }

    /// The top by itself, without sand.
    ///
    /// # Errors
    /// Those of Rayleigh's integral.
    pub(crate) fn alone(
        &self,
        surface: &RadiatingSurface,
        (computed, sampling): (&Air, &Sampling),
        progress: &Progress,
    ) -> Result<FlushSound, Error> {
        self.sampled(&Rayleigh::new(surface, computed)?, sampling, progress)
    }

    /// The top in `air` and in its sand. Sand that moves along is computed in every air, which takes little longer than
    /// reading it would.
    ///
    /// # Errors
    /// Those of Rayleigh's integral.
    pub(crate) fn in_sand(
        &self,
        alone: FlushSound,
        (surface, top_hz): (&RadiatingSurface, f64),
        (computed, air): (&Air, &Air),
        progress: &Progress,
    ) -> Result<FlushSound, Error> {
        let sound = alone.in_air(computed, air, self.absorber());
        let Some(sand) = self.moving else {
            return Ok(sound);
        };
        let sampling = sampling_to(self.top(top_hz).min(sand.to_hz));
        let below = self.sampled(&self.rayleigh(surface, air)?, &sampling, progress)?;
        Ok(below.continued(sound))
    }

    fn sampled(&self, rayleigh: &Rayleigh, sampling: &Sampling, progress: &Progress) -> Result<FlushSound, Error> {
        let points: Vec<_> = self.places.points.iter().map(|&point| point.into()).collect();
        progress.count_each(("Rayleigh's integral", "frequencies"), 0, |sampled| {
            Ok(FlushSound::new(
                rayleigh,
                sampling,
                &points,
                self.places.origin.into(),
                sampled,
            )?)
        })
    }
}

fn sampling_to(top_hz: f64) -> Sampling {
    Sampling {
        range_hz: [LOWEST_SAMPLE.min(0.5 * top_hz), top_hz],
        ..Sampling::default()
    }
}

/// The points of a surface that are `shown`, with the normal displacements of modes, (3 x points) x modes.
///
/// # Errors
/// Those of the surface.
pub(crate) fn radiating_surface(
    surface: &Surface,
    shapes: DMatrixView<'_, f32>,
    shown: impl Fn(&QuadraturePoint) -> bool,
) -> Result<RadiatingSurface, Error> {
    let points: Vec<QuadraturePoint> = surface.quadrature(FACE_POINTS)?.into_iter().filter(shown).collect();
    let mut modes = DMatrix::zeros(points.len(), shapes.ncols());
    for (shape, mut column) in shapes.column_iter().zip(modes.column_iter_mut()) {
        for (point, value) in points.iter().zip(column.iter_mut()) {
            let nodes = &surface.faces[point.face].nodes;
            *value = nodes
                .iter()
                .zip(&point.shape)
                .map(|(&node, weight)| {
                    let moved = shape.fixed_rows::<3>(3 * node).map(f64::from);
                    weight * moved.dot(&point.normal)
                })
                .sum();
        }
    }
    let mut patches: Vec<usize> = points.iter().map(|p| surface.faces[p.face].patch).collect();
    let mut shown = patches.clone();
    shown.sort_unstable();
    shown.dedup(); // a patch that is wholly hidden has no level to show
    for patch in &mut patches {
        *patch = shown.partition_point(|p| p < patch);
    }
    Ok(RadiatingSurface::new(
        points.iter().map(|p| p.position).collect(),
        points.iter().map(|p| p.normal).collect(),
        points.iter().map(|p| p.weight).collect(),
        patches,
        shown.iter().map(|&patch| surface.patches[patch].clone()).collect(),
        modes,
    )?)
}

//! The frequency ranges that the colours show.

use super::super::surface::level;
use super::triangles::Triangles;

/// Range of levels shown below the highest \[dB\].
pub(super) const SHOWN: f64 = 30.0;

/// A choice of the frequency range that the colours show.
pub(super) struct View {
    pub(super) label: String,
    /// Level at the upper end of the colours \[dB re 1 pW s/m2\].
    pub(super) high: f64,
    /// Energies of the faces of each body \[J/m2\].
    pub(super) energies: Vec<Vec<f64>>,
}

impl View {
    pub(super) fn new(label: String, surfaces: &[Triangles<'_>], energies: Vec<Vec<f64>>) -> Self {
        let free = surfaces
            .iter()
            .zip(&energies)
            .flat_map(|(surface, own)| surface.faces[..surface.free].iter().map(|&face| own[face]));
        let high = level(free.fold(0.0, f64::max)).unwrap_or(0.0).ceil();
        Self { label, high, energies }
    }

    /// The level of a face relative to the range of the colours, 0 to 1.
    pub(super) fn shade(&self, body: usize, face: usize) -> f64 {
        let level = level(self.energies[body][face]).unwrap_or(f64::NEG_INFINITY);
        (1.0 - (self.high - level) / SHOWN).clamp(0.0, 1.0)
    }
}

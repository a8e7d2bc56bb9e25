//! Bands above the range of single frequencies, over which boundary elements are averaged.

/// Largest width of a band in octaves, and number of frequencies solved per band.
const WIDTH: f64 = 1.0 / 6.0;
const SAMPLES: usize = 3;

/// Width in octaves of the range above single frequencies where averages still use the same mesh. Even with that mesh's
/// four panels per wavelength, averages over a band scatter less than single frequencies do.
const ON_SAME_MESH: f64 = 0.5;

/// Largest number of bands per finer mesh: half an octave.
const ON_FINER_MESH: usize = 3;

/// Prevents rounding from adding a band.
const SLACK: f64 = 1e-9;

/// Adjacent bands of equal width, at most a sixth of an octave, from the upper end of single frequencies upwards. The
/// bands within half an octave use the mesh of single frequencies; those above need finer meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanBands {
    top: f64,
    octaves: f64,
}

/// A band over which boundary elements are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanBand {
    /// Centre \[Hz\].
    pub centre_hz: f64,
    /// Upper end \[Hz\].
    pub upper_hz: f64,
    /// Frequencies solved in the band \[Hz\].
    pub samples_hz: Vec<f64>,
}

impl MeanBands {
    /// The bands from the upper end of single frequencies to `to_hz` \[Hz\], at least one of a sixth of an octave;
    /// without `to_hz` they cover half an octave.
    pub fn new(top_hz: f64, to_hz: Option<f64>) -> Self {
        Self {
            top: top_hz,
            octaves: to_hz.map_or(ON_SAME_MESH, |to| (to / top_hz).log2().max(WIDTH)),
        }
    }

    /// Octaves covered by all bands.
    pub(crate) fn octaves(&self) -> f64 {
        self.octaves
    }

    /// The same number of octaves above a different upper end of single frequencies \[Hz\].
    pub(crate) fn of_octaves(top_hz: f64, octaves: f64) -> Self {
        Self { top: top_hz, octaves }
    }

    /// Number of bands.
    pub fn count(&self) -> usize {
        (self.octaves / WIDTH - SLACK).ceil() as usize
    }

    /// Number of bands that use the mesh of single frequencies.
    pub fn on_same_mesh(&self) -> usize {
        ((ON_SAME_MESH / self.width() + SLACK) as usize).min(self.count())
    }

    /// Number of frequencies solved in this many bands.
    pub fn samples(bands: usize) -> usize {
        SAMPLES * bands
    }

    /// Upper end of the last band \[Hz\].
    pub fn upper_hz(&self) -> f64 {
        self.upper_of(self.count())
    }

    /// Upper end of the bands that use the mesh of single frequencies \[Hz\].
    pub fn same_mesh_to_hz(&self) -> f64 {
        self.upper_of(self.on_same_mesh())
    }

    /// The finer meshes for the other bands, in ascending order: the highest frequency of each \[Hz\], and its number
    /// of bands. The bands are divided evenly among them, at most half an octave each.
    pub fn finer_meshes(&self) -> Vec<(f64, usize)> {
        let (first, rest) = (self.on_same_mesh(), self.count() - self.on_same_mesh());
        let meshes = rest.div_ceil(ON_FINER_MESH);
        let end = |mesh: usize| first + (rest * mesh).div_ceil(meshes.max(1));
        (1..=meshes)
            .map(|mesh| (self.upper_of(end(mesh)), end(mesh) - end(mesh - 1)))
            .collect()
    }

    /// All bands.
    pub fn all(&self) -> Vec<MeanBand> {
        let band = |i: usize| {
            let at = |share: f64| self.above((i as f64 + share) * self.width());
            MeanBand {
                centre_hz: at(0.5),
                upper_hz: self.upper_of(i + 1),
                samples_hz: (0..SAMPLES).map(|j| at((j as f64 + 0.5) / SAMPLES as f64)).collect(),
            }
        };
        (0..self.count()).map(band).collect()
    }

    /// Centre of the last band, in octaves above the lower end of the first band.
    pub(crate) fn last_octaves(&self) -> f64 {
        (self.count() as f64 - 0.5) * self.width()
    }

    /// The frequency this many octaves above the lower end of the first band \[Hz\].
    pub(crate) fn above(&self, octaves: f64) -> f64 {
        self.top * 2f64.powf(octaves)
    }

    fn upper_of(&self, bands: usize) -> f64 {
        self.above(bands as f64 * self.width())
    }

    fn width(&self) -> f64 {
        self.octaves / self.count() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_without_a_top_of_their_own_are_three_sixths_of_an_octave_on_the_same_mesh() {
        let bands = MeanBands::new(3200.0, None);
        assert_eq!([bands.count(), bands.on_same_mesh()], [3, 3]);
        assert!(bands.finer_meshes().is_empty());
        assert!((bands.upper_hz() / 3200.0 - 2f64.sqrt()).abs() < 1e-15);
        assert_eq!(MeanBands::new(3200.0, Some(3200.0 * 2f64.sqrt())).count(), 3);
    }

    #[test]
    fn bands_end_at_the_frequency_asked_for_and_are_no_wider_than_a_sixth_of_an_octave() {
        for to in [2500.0, 3000.0, 4000.0, 8000.0, 16e3] {
            let bands = MeanBands::new(2443.0, Some(to));
            let all = bands.all();
            let upper = all[all.len() - 1].upper_hz;
            assert!(
                (upper / f64::max(to, 2443.0 * 2f64.powf(WIDTH)) - 1.0).abs() < 1e-12,
                "{to}"
            );
            assert!(bands.width() <= WIDTH * (1.0 + 1e-12), "{to}");
            assert!(
                all.windows(2)
                    .all(|two| two[0].centre_hz < two[0].upper_hz && two[0].upper_hz < two[1].centre_hz)
            );
        }
    }

    #[test]
    fn every_band_has_a_mesh_that_reaches_its_upper_end() {
        for to in [3000.0, 4000.0, 5000.0, 8000.0, 20e3] {
            let bands = MeanBands::new(2443.0, Some(to));
            let finer = bands.finer_meshes();
            let mut number = bands.on_same_mesh();
            for (top, count) in &finer {
                number += count;
                assert!(*count > 0 && *count <= ON_FINER_MESH);
                assert_eq!(*top, bands.all()[number - 1].upper_hz);
            }
            assert_eq!(number, bands.count());
        }
    }
}

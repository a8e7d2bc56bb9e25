use super::directivity::MixingDirectivity;
use super::histogram::{PeakHistogram, Spreading};
use super::history::Burst;
use super::noise::{ExhaustNoise, UNSTEADY_FLOW};
use super::{shock, similarity};
use crate::air::Air;
use crate::checks::{InputError, ReceiverError, positive};
use crate::signals::{Contribution, Level, REFERENCE_PRESSURE, Weighting, energy_weights};
use nalgebra::Complex;
use std::f64::consts::PI;

/// Position of an outlet and directions of its jets.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlet {
    /// Position \[m\].
    pub position: [f64; 3],
    /// Directions of the jets as vectors of any length, one for each jet or group of jets. All jets or groups have the
    /// same share of the energy.
    pub directions: Vec<[f64; 3]>,
}

/// A rigid horizontal floor below outlet and receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// Its z \[m\].
    pub height: f64,
    /// Coherence between the jet noise radiated towards the floor and towards the receiver, 0 to 1.
    ///
    /// 1 represents a point source that emits the same signal in all directions, so that direct and reflected sound
    /// interfere. With 0, energies are added. This is the limit for jet noise at high frequency, which is uncorrelated
    /// between directions that differ by tens of degrees. The unsteady outflow is always treated as a point source.
    pub coherence: f64,
}

/// Sound exposure at a receiver due to one opening.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceivedNoise {
    /// Frequencies \[Hz\], those of the opening's spectrum.
    pub frequency: Vec<f64>,
    /// One-sided spectral density of the sound exposure int p^2 dt \[Pa² s/Hz\].
    pub exposure_density: Vec<f64>,
    /// Its parts `mixing`, `shock` and `unsteady flow`, in the same unit.
    pub parts: Vec<Contribution>,
}

impl ReceivedNoise {
    /// Sound exposure between two frequencies \[Pa² s\], with the weighting applied under the integral.
    pub fn exposure(&self, range_hz: [f64; 2], weighting: Weighting) -> f64 {
        let weights = energy_weights(&self.frequency, range_hz, weighting);
        weights.iter().zip(&self.exposure_density).map(|(w, e)| w * e).sum()
    }

    /// Sound exposure level L_E between two frequencies \[dB re (20 uPa)² s\].
    pub fn level(&self, range_hz: [f64; 2], weighting: Weighting) -> Level {
        let exposure = self.exposure(range_hz, weighting);
        (exposure > 0.0).then(|| 10.0 * (exposure / REFERENCE_PRESSURE.powi(2)).log10())
    }
}

/// lg(U_j/c0) of the first tabulated directivity, the step, and the number of values, which cover the range of the
/// table.
const FIRST: f64 = -0.4;
const STEP: f64 = 0.01;
const SPEEDS: usize = 81;

/// Path of the sound from the outlet to the receiver, directly or via the floor.
struct Path {
    length: f64,
    /// D at [`SPEEDS`] jet speeds, averaged over the jets.
    directivities: Vec<f64>,
}

impl Path {
    fn new(outlet: &Outlet, point: [f64; 3]) -> Result<Self, ReceiverError> {
        let way: [f64; 3] = std::array::from_fn(|i| point[i] - outlet.position[i]);
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let length = positive("distance of a receiver from the exhaust [m]", norm(way))?;
        let angle = |direction: &[f64; 3]| {
            let jet = positive("length of a jet's direction", norm(*direction))?;
            let along: f64 = way.iter().zip(direction).map(|(a, b)| a * b).sum();
            Ok::<f64, ReceiverError>((along / (length * jet)).clamp(-1.0, 1.0).acos())
        };
        // Angles between the directions of the jets and the path.
        let angles = outlet.directions.iter().map(angle).collect::<Result<Vec<f64>, _>>()?;
        let at = |i: usize| {
            let directivity = MixingDirectivity::new(FIRST + STEP * i as f64);
            let sum: f64 = angles.iter().map(|&angle| directivity.at(angle)).sum();
            sum / angles.len() as f64
        };
        let directivities = (0..SPEEDS).map(at).collect();
        Ok(Self { length, directivities })
    }
}

impl ExhaustNoise {
    /// Noise at a point in free space or above a floor.
    ///
    /// ```text
    /// E_p = rho0 c0/(4 pi) sum_bursts E_W [ D/r^2 + D'/r'^2 + 2 gamma sqrt(D D')/(r r') cos k(r' - r) ]      jets
    /// E_p = rho0 c0/(4 pi) E_W | e^{-jkr}/r + e^{-jkr'}/r' |^2                                       unsteady flow
    /// ```
    ///
    /// The primed path leads to the image of the receiver in the floor, and leaves the outlet in a different direction;
    /// gamma is [`Floor::coherence`]. For mixing noise, D is [`MixingDirectivity`] at the jet speed of each burst; for
    /// shock noise it is 1, because NASA TM-83199 treats shock noise as omnidirectional. The spectrum of a burst is the
    /// same in all directions. Shielding and reflection by bodies are neglected.
    ///
    /// # Errors
    /// If the receiver is at the outlet, a jet has no direction, the floor is not below both, or the coherence is
    /// outside 0 .. 1.
    pub fn at(
        &self,
        outlet: &Outlet,
        point: [f64; 3],
        floor: Option<&Floor>,
        air: &Air,
    ) -> Result<ReceivedNoise, ReceiverError> {
        let paths = Paths::new(outlet, point, floor, air)?;
        let (frequency, history) = (&self.spectrum.frequency, &self.history);
        let muffled = |mut density: Vec<f64>| {
            if let Some(passed) = &history.passed {
                density.iter_mut().zip(passed).for_each(|(e, factor)| *e *= factor);
            }
            density
        };
        let [mixing, shock] = paths.jets(frequency).densities(&history.mixing, &history.shocks);
        let outflow = self
            .spectrum
            .contributions
            .iter()
            .find(|part| part.name == UNSTEADY_FLOW);
        let outflow = outflow.map_or(vec![0.0; frequency.len()], |part| {
            let energy = frequency.iter().zip(&part.energy_density);
            energy
                .map(|(&hz, e)| e * paths.point_source_pressure(hz).norm_sqr())
                .collect()
        });
        let intensity = air.impedance() / (4.0 * PI);
        let parts: Vec<Contribution> = [
            ("mixing", muffled(mixing)),
            ("shock", muffled(shock)),
            (UNSTEADY_FLOW, outflow),
        ]
        .into_iter()
        .map(|(name, density)| Contribution {
            name: name.to_owned(),
            energy_density: density.into_iter().map(|e| intensity * e).collect(),
        })
        .collect();
        let exposure_density = (0..frequency.len())
            .map(|k| parts.iter().map(|part| part.energy_density[k]).sum())
            .collect();
        Ok(ReceivedNoise {
            frequency: frequency.clone(),
            exposure_density,
            parts,
        })
    }
}

/// Paths of the sound from an outlet to a receiver.
pub(super) struct Paths {
    direct: Path,
    reflected: Option<Path>,
    coherence: f64,
    /// k/f \[s/m\].
    wavenumber: f64,
}

impl Paths {
    pub(super) fn new(
        outlet: &Outlet,
        point: [f64; 3],
        floor: Option<&Floor>,
        air: &Air,
    ) -> Result<Self, ReceiverError> {
        positive("number of directions of the exhaust", outlet.directions.len() as f64)?;
        Ok(Self {
            coherence: floor.map_or(0.0, |floor| floor.coherence),
            wavenumber: 2.0 * PI / air.sound_speed,
            direct: Path::new(outlet, point)?,
            reflected: floor.map(|floor| floor.path(outlet, point)).transpose()?,
        })
    }

    /// Length of the direct path \[m\].
    pub(super) fn direct_length(&self) -> f64 {
        self.direct.length
    }

    /// Propagation of jet noise along the paths at some frequencies.
    pub(super) fn jets(&self, frequency: &[f64]) -> Jets<'_> {
        let normal = similarity::total();
        let cross = self.reflected.as_ref().filter(|_| self.coherence > 0.0);
        Jets {
            paths: self,
            mixing: Spreading::new(|x| similarity::shape(x) / normal, frequency),
            shocks: Spreading::new(shock::shape, frequency),
            interference: cross.map(|path| frequency.iter().map(|&hz| self.interference(hz, path)).collect()),
        }
    }

    /// e^{-jkr}/r + e^{-jkr'}/r' \[1/m\].
    pub(super) fn point_source_pressure(&self, hz: f64) -> Complex<f64> {
        let wave = |r: f64| Complex::from_polar(1.0 / r, -self.wavenumber * hz * r);
        let direct = wave(self.direct.length);
        self.reflected
            .as_ref()
            .map_or(direct, |path| direct + wave(path.length))
    }

    /// cos k(r' - r).
    fn interference(&self, hz: f64, reflected: &Path) -> f64 {
        (self.wavenumber * hz * (reflected.length - self.direct.length)).cos()
    }
}

/// Noise of jets at a receiver at several frequencies.
pub(super) struct Jets<'a> {
    paths: &'a Paths,
    mixing: Spreading,
    shocks: Spreading,
    /// cos k(r' - r), if direct and reflected sound interfere.
    interference: Option<Vec<f64>>,
}

impl Jets<'_> {
    /// Energy densities of mixing and shock noise divided by r² at the receiver, upstream of a muffler.
    pub(super) fn densities(&self, mixing: &[Burst], shocks: &[Burst]) -> [Vec<f64>; 2] {
        [
            self.density(mixing, |path, i| path.directivities[i], &self.mixing),
            self.density(shocks, |_, _| 1.0, &self.shocks),
        ]
    }

    /// Energy density of the bursts divided by r² at the receiver, with a path's directivity at [`SPEEDS`] jet speeds.
    fn density(&self, bursts: &[Burst], directivity: impl Fn(&Path, usize) -> f64, shape: &Spreading) -> Vec<f64> {
        let (direct, reflected) = (&self.paths.direct, &self.paths.reflected);
        let alone = |path: &Path, i: usize| directivity(path, i) / path.length.powi(2);
        let both = |i: usize| alone(direct, i) + reflected.as_ref().map_or(0.0, |path| alone(path, i));
        let mut density = spread(bursts, both, shape);
        if let Some((path, interference)) = reflected.as_ref().zip(self.interference.as_ref()) {
            let together = |i: usize| 2.0 * self.paths.coherence * (alone(direct, i) * alone(path, i)).sqrt();
            let cross = spread(bursts, together, shape);
            for ((e, cross), cos) in density.iter_mut().zip(cross).zip(interference) {
                *e += cross * cos;
            }
        }
        density
    }
}

impl Floor {
    /// The path to the image of the receiver in the floor.
    fn path(&self, outlet: &Outlet, point: [f64; 3]) -> Result<Path, ReceiverError> {
        for z in [outlet.position[2], point[2]] {
            if z.is_nan() || z < self.height {
                return Err(ReceiverError::BelowFloor { z, floor: self.height });
            }
        }
        if !(0.0..=1.0).contains(&self.coherence) {
            return Err(InputError::OutsideRange {
                what: "coherence of direct and reflected jet noise",
                value: self.coherence,
                low: 0.0,
                high: 1.0,
            }
            .into());
        }
        Path::new(outlet, [point[0], point[1], 2.0 * self.height - point[2]])
    }
}

/// Spectrum of the bursts, each multiplied by the gain at its jet speed, which is interpolated between [`SPEEDS`]
/// values.
fn spread(bursts: &[Burst], gain: impl Fn(usize) -> f64, shape: &Spreading) -> Vec<f64> {
    let gains: Vec<f64> = (0..SPEEDS).map(gain).collect();
    let mut histogram = PeakHistogram::new();
    for burst in bursts {
        let gain = super::mixing::interpolate(&gains, (burst.lg_velocity - FIRST) / STEP);
        histogram.deposit(burst.peak_hz, gain * burst.energy);
    }
    histogram.spread(shape)
}

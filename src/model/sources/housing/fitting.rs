//! The wall of the pipe on the exhaust, which the cap carries along.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::radiator::Pressures;
use nailnoise_acoustics::radiation::sound::oscillating_sphere_pressure;
use nailnoise_acoustics::radiation::{
    ModalSpectra, OscillatingPipe, PipeWall, radiated_energy, radiated_signals, sphere_efficiency,
};
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::signals::{Weighting, energy_weights};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

use crate::error::Error;
use crate::result::Uncertainty;
use crate::stages::apart::{Apart, Moved, PartError};
use crate::stages::bodies::Body;
use crate::stages::cycle::ShotRecord;
use crate::stages::radiation::CapSurface;
use crate::stages::sound::Sound;

/// Name of the part.
const NAME: &str = "fitting";

/// The wall of the fitting on the exhaust.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct FittingWall {
    /// Length \[m\].
    pub(crate) length: f64,
    /// Outer radius \[m\].
    pub(crate) outer_radius: f64,
    /// Thickness \[m\].
    pub(crate) thickness: f64,
    /// Cosine of the angle between its axis and the driving direction.
    pub(crate) alignment: f64,
    /// Where it is \[m\].
    pub(crate) position: [f64; 3],
    /// Distance of its middle from that of the tool \[m\].
    pub(crate) distance: f64,
    /// The surface that carries it.
    pub(crate) cap: CapSurface,
    /// Name of the source to which it is assigned, if not the body.
    pub(crate) counts_to: Option<&'static str>,
}

/// The wall of the fitting as a source.
pub(super) struct WallSound {
    /// Its energy and signal.
    pub(super) sound: Sound,
    /// Its motion.
    spectra: ModalSpectra,
}

impl FittingWall {
    /// Its sound, moved by the mean of the cap's elastic and rigid motion along the driving axis. `whole` is the sound
    /// of the body that carries it.
    ///
    /// # Errors
    /// A wall that cannot be.
    pub(super) fn on_body(
        &self,
        body: &Body,
        motion: &ModalSpectra,
        (air, whole): (&Air, &Sound),
    ) -> Result<WallSound, Error> {
        self.moved(motion.combined(&mean_lift(body, &self.cap)), air, whole)
    }

    /// Its sound on a rigid tool.
    ///
    /// # Errors
    /// A wall that cannot be; the errors of the transform.
    pub(super) fn on_rigid_tool(
        &self,
        record: &ShotRecord,
        range_hz: [f64; 2],
        (air, whole): (&Air, &Sound),
    ) -> Result<WallSound, Error> {
        let settings = TransformSettings {
            range_hz,
            ..TransformSettings::default()
        };
        // The cycle counts downwards as positive.
        let lift: Vec<f64> = record.tool_acceleration().iter().map(|a| -a).collect();
        let spectra =
            ModalSpectra::from_accelerations(1, lift.len(), record.sample_interval, &settings, |_| lift.clone())?;
        self.moved(spectra, air, whole)
    }

    fn moved(&self, spectra: ModalSpectra, air: &Air, whole: &Sound) -> Result<WallSound, Error> {
        let wall = PipeWall {
            length: self.length,
            outer_radius: self.outer_radius,
            thickness: self.thickness,
            alignment: self.alignment,
        };
        let pipe = OscillatingPipe::new(NAME, wall, air)?;
        let mut spectrum = radiated_energy(NAME, &pipe, &spectra)?;
        spectrum.contributions.clear();
        let signals = radiated_signals(&pipe, &spectra, &spectrum)?;
        Ok(WallSound {
            sound: Sound {
                spectrum,
                signals: vec![(NAME, signals)],
                openings: Vec::new(),
                uncertainty: whole.uncertainty.clone(),
                cross_check: None,
                radiation: None,
            },
            spectra,
        })
    }

    /// Pressures of the wall at places above a reflecting plane: those of a sphere with the volume of the pipe and the
    /// power of the wall. Frequencies and ranges are those of the body's pressures, if known.
    ///
    /// # Errors
    /// A place inside the sphere.
    pub(super) fn pressures(
        &self,
        wall: &WallSound,
        places: &[Point3<f64>],
        (plane, air): (f64, &Air),
        like: Option<&Pressures>,
    ) -> Result<Pressures, Error> {
        let volume = PI * self.outer_radius.powi(2) * self.length;
        let radius = (0.75 * volume / PI).cbrt();
        let spectra = &wall.spectra;
        let frequency = like.map_or_else(|| spectra.frequency.clone(), |like| like.frequency.clone());
        let signal = wall.sound.signals[0].1.combined_signal();
        let mut values = DMatrix::zeros(places.len(), frequency.len());
        for (mut bin, &hz) in values.column_iter_mut().zip(&frequency) {
            let at = spectra.frequency.partition_point(|own| *own < hz * (1.0 - 1e-9));
            let Some(x) = signal.get(at).filter(|_| hz > 0.0) else {
                continue;
            };
            // The sphere's signal at unit acceleration, sqrt(R)/(j omega).
            let resistance = air.impedance() * 4.0 * PI * radius * radius / 3.0 * sphere_efficiency(volume, air, hz);
            let unit = Complex::new(0.0, -resistance.sqrt() / (TAU * hz));
            for (p, place) in bin.iter_mut().zip(places) {
                let (centre, up) = (Point3::from(self.position), Vector3::z());
                *p = oscillating_sphere_pressure(hz, volume, centre, up, *place, Some(plane), air)? * x / unit;
            }
        }
        Ok(Pressures {
            method: "oscillating sphere of the pipe's volume",
            frequency,
            values,
            fade_hz: like.and_then(|like| like.fade_hz),
            range_hz: like.map_or(spectra.range_hz, |like| like.range_hz),
            interpolation_error: 0.0,
        })
    }

    /// A source with the wall, which is part of the source or of the part that is assigned to another one.
    pub(super) fn assign<T>(&self, source: Apart<T>, wall: T, add: impl Fn(&T, &T) -> T) -> Apart<T> {
        let Some(to) = self.counts_to else {
            return Apart {
                own: add(&source.own, &wall),
                moved: source.moved,
            };
        };
        let moved = match source.moved {
            Some(cap) => Moved {
                part: add(&cap.part, &wall),
                ..cap
            },
            None => Moved {
                to: to.into(),
                error: PartError::OfWhole,
                part: wall,
            },
        };
        Apart {
            own: source.own,
            moved: Some(moved),
        }
    }

    /// The uncertainty of a body with this wall. The wall may not radiate at all: a flexible pipe follows the cap only
    /// below the modes of the pipe. The sum of their energies does not include the interaction of the two either. For
    /// parallel dipoles at the distance d, it is at most
    ///
    /// ```text
    /// 2 g(kd) sqrt(E_b E_w),  g = min(1, 3/kd)
    /// ```
    ///
    /// of either sign, because g bounds 3 (sin x/x + 2 cos x/x^2 - 2 sin x/x^3) for dipoles behind each other, and half
    /// of that for dipoles side by side.
    pub(super) fn widened(&self, whole: &Sound, wall: &Sound, (air, range_hz): (&Air, [f64; 2])) -> Uncertainty {
        let spectrum = &wall.spectrum;
        let weights = energy_weights(&spectrum.frequency, range_hz, Weighting::A);
        let pairs = spectrum.frequency.iter().zip(&spectrum.energy_density).zip(weights);
        let exchanged: f64 = pairs
            .filter(|(_, weight)| *weight > 0.0)
            .map(|((&hz, own), weight)| {
                let bound = (3.0 * air.sound_speed / (TAU * hz * self.distance)).min(1.0);
                2.0 * weight * bound * (own * whole.spectrum.density_at(hz)).sqrt()
            })
            .sum();
        let [body, own] = [whole, wall].map(|sound| sound.spectrum.energy(range_hz, Weighting::A));
        let Uncertainty { minus, plus, basis } = whole.uncertainty.clone();
        let (less, more) = (exchanged.max(own) / (body + own), exchanged / (body + own));
        Uncertainty {
            minus: minus
                .filter(|_| less < 1.0)
                .map(|minus| minus - 10.0 * (1.0 - less).log10()),
            plus: plus.map(|plus| plus + 10.0 * (1.0 + more).log10()),
            basis: basis + "; the wall of the exhaust's fitting may be silent, and exchanges sound with the body",
        }
    }
}

/// Mean displacement of the cap along the driving axis in each mode, 1 x modes: over its area, or of the whole mass if
/// the body has no such surface.
fn mean_lift(body: &Body, cap: &CapSurface) -> DMatrix<f64> {
    let surface = &body.surface;
    let modes = body.skin.ncols();
    let (mut sum, mut area) = (DMatrix::zeros(1, modes), 0.0);
    for point in surface.quadrature(2).into_iter().flatten() {
        let face = &surface.faces[point.face];
        let inside = match *cap {
            CapSurface::Above { height, radius } => {
                point.position.z >= height && point.position.x.hypot(point.position.y) <= radius
            }
            CapSurface::Named(name) => surface.patches[face.patch] == name,
        };
        if !inside {
            continue;
        }
        area += point.weight;
        for (&node, shape) in face.nodes.iter().zip(&point.shape) {
            let lift = body.skin.row(3 * node + 2);
            for (sum, lift) in sum.iter_mut().zip(lift.iter()) {
                *sum += point.weight * shape * f64::from(*lift);
            }
        }
    }
    if area > 0.0 {
        return sum / area;
    }
    DMatrix::from_iterator(1, modes, body.lift.iter().map(|lift| lift / body.lift.norm_squared()))
}

//! Motion of the elastic bodies in third octaves, to compare with bodies on which accelerometers were placed.

use std::f64::consts::TAU;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::{Erp, ModalRadiation, ModalSpectra, RadiatingSurface};
use nailnoise_acoustics::signals::{Band, Weighting, bands_of, energy_weights};
use nailnoise_meshes::open_faces;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bodies::Body;
use super::spectra::MovingBody;
use super::{Code, Postcard, Progress, Stage, code};
use crate::error::Error;

/// Motion of a body in a one-third-octave band, over the whole shot. The RMS values are means over the area of the
/// outer surface and over 1 s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BandMotion {
    /// Exact mid-band frequency \[Hz\].
    pub hz: f64,
    /// Time integral of the kinetic energy \[J s\].
    pub kinetic_energy_j_s: f64,
    /// RMS normal velocity \[m/s\].
    pub rms_velocity_m_s: f64,
    /// RMS normal acceleration \[m/s2\].
    pub rms_acceleration_m_s2: f64,
}

/// Motion of a body in the third octaves of the analysed range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodyBands {
    /// The body.
    pub body: String,
    /// The bands, in ascending order.
    pub bands: Vec<BandMotion>,
}

/// Motion of the elastic bodies of a shot in third octaves.
///
/// ```text
/// int E_kin dt = int sum_i |V_i|^2 df        <v^2> x 1 s = 2 int int |v_n|^2 dS/S df
/// ```
///
/// V_i are the Fourier transforms of the velocities of mass-normalised modes.
#[derive(Clone, Serialize)]
pub struct MotionBands {
    /// The bodies in motion.
    pub bodies: Vec<MovingBody>,
}

impl Stage for MotionBands {
    type Output = Vec<BodyBands>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "motion in bands";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_response,
        stages_motion_bands,
        stages_spectra,
        stages_cycle
    );

    fn compute(&self, _: &Progress) -> Result<Vec<BodyBands>, Error> {
        let of = |moving: &MovingBody| {
            let moving = moving.get()?;
            of_body(&moving.body, &moving.motion.spectra)
        };
        self.bodies.iter().map(of).collect()
    }
}

fn of_body(body: &Body, spectra: &ModalSpectra) -> Result<BodyBands, Error> {
    let open = open_faces(&body.surface, None)?;
    let modes = body.skin.columns(0, spectra.accelerations.nrows());
    let surface = RadiatingSurface::of_faces(&body.surface, modes, |point| open[point.face])?;
    let (area, air) = (surface.weights().iter().sum::<f64>(), Air::default());
    let frequency = &spectra.frequency[..];
    let forms = Erp::new(&surface, &air).energy_forms(frequency, &spectra.accelerations);
    // Densities over frequency, bin by bin: sum |V_i|^2, and twice the mean of |v_n|^2.
    let kinetic = |bin: usize| spectra.accelerations.column(bin).norm_squared() / (TAU * frequency[bin]).powi(2);
    let mean = |bin: usize| 2.0 * forms.column(bin).sum() / (air.impedance() * area);
    let densities: Vec<[f64; 3]> = (0..frequency.len())
        .map(|bin| {
            let (kinetic, mean) = (kinetic(bin), mean(bin));
            [kinetic, mean, mean * (TAU * frequency[bin]).powi(2)]
        })
        .collect();
    let of_band = |band: &Band| {
        let weights = energy_weights(frequency, [band.low, band.high], Weighting::Z);
        let mut sums = [0.0; 3];
        for (densities, weight) in densities.iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
            sums.iter_mut().zip(densities).for_each(|(sum, of)| *sum += weight * of);
        }
        let [kinetic, velocity, acceleration] = sums;
        BandMotion {
            hz: band.hz,
            kinetic_energy_j_s: kinetic,
            rms_velocity_m_s: velocity.sqrt(),
            rms_acceleration_m_s2: acceleration.sqrt(),
        }
    };
    Ok(BodyBands {
        body: body.name.to_owned(),
        bands: bands_of(spectra.range_hz).par_iter().map(of_band).collect(),
    })
}

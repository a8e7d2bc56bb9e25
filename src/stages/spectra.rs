//! Motion of a body in a shot: Fourier transforms of its modal accelerations, and its acceleration at sensors.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_fem::vibration::{ModalResponse, Motion};
use nalgebra::DMatrix;
use serde::Serialize;

use super::bodies::{Body, BodySensors};
use super::response::Vibration;
use super::{Code, Progress, Stage, Stored, Uncached, code};
use crate::error::Error;

/// Number of modes whose motion is computed together: their forces are one matrix product.
const BLOCK: usize = 32;

/// Analyses the motion of one body of a response. Its output is not stored, because it is an intermediate result of
/// hundreds of megabytes.
#[derive(Clone, Serialize)]
pub struct BodyAnalysis {
    /// The response.
    pub vibration: Stored<Vibration>,
    /// Index of the body in it.
    pub index: usize,
    /// Range of the spectra \[Hz\].
    pub range_hz: [f64; 2],
    /// Sensors on the body.
    pub sensors: Option<Stored<BodySensors>>,
}

/// A body in motion, for exports.
#[derive(Clone, Serialize)]
pub struct MovingBody {
    /// The body.
    pub body: Stored<Body>,
    /// Loss factor of its modes \[-\].
    pub loss_factor: f64,
    /// The response to which it belongs.
    pub vibration: Stored<Vibration>,
    /// Its index in that response.
    pub index: usize,
    /// Its motion.
    pub motion: Stored<BodyMotion>,
}

impl MovingBody {
    /// The body with its motion.
    ///
    /// # Errors
    /// [`Error`] of the stages that make it.
    pub fn get(&self) -> Result<BodyInMotion, Error> {
        Ok(BodyInMotion {
            body: self.body.get()?,
            loss_factor: self.loss_factor,
            vibration: self.vibration.get()?,
            index: self.index,
            motion: self.motion.get()?,
        })
    }
}

/// A body with its motion in a shot.
#[derive(Debug, Clone)]
pub struct BodyInMotion {
    /// The body.
    pub body: Arc<Body>,
    /// Loss factor of its modes \[-\].
    pub loss_factor: f64,
    /// The response to which it belongs.
    pub vibration: Arc<Vibration>,
    /// Its index in that response.
    pub index: usize,
    /// Its motion.
    pub motion: Arc<BodyMotion>,
}

/// Motion of a body.
#[derive(Debug)]
pub struct BodyMotion {
    /// Fourier transforms of its modal accelerations.
    pub spectra: ModalSpectra,
    /// Its acceleration at the sensors on it.
    pub sensors: SensorMotion,
}

/// Acceleration of an elastic body at its sensors, before their band limits are applied.
#[derive(Debug, Clone)]
pub struct SensorMotion {
    /// Names of the sensors.
    pub names: Vec<String>,
    /// Acceleration along their axes at the samples of the body's response: samples x sensors \[m/s2\].
    pub acceleration: DMatrix<f64>,
}

impl SensorMotion {
    pub(super) fn of(&self, name: &str) -> Option<Vec<f64>> {
        let column = self.names.iter().position(|own| own == name)?;
        Some(self.acceleration.column(column).iter().copied().collect())
    }
}

impl Stage for BodyAnalysis {
    type Output = BodyMotion;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "modal spectra";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_response,
        stages_spectra
    );

    fn compute(&self, _: &Progress) -> Result<BodyMotion, Error> {
        let vibration = self.vibration.get()?;
        let response = &vibration.response;
        let (names, shapes) = match &self.sensors {
            Some(sensors) => {
                let sensors = sensors.get()?;
                (sensors.names.clone(), sensors.shapes.clone())
            }
            None => (Vec::new(), DMatrix::zeros(response.modes(self.index)?, 0)),
        };
        let coordinates = vibration.coordinates[self.index].as_ref();
        let shapes = coordinates.map_or_else(|| shapes.clone(), |coordinates| coordinates.tr_mul(&shapes));
        let (mut spectra, acceleration) = body_spectra(response, self.index, self.range_hz, &shapes)?;
        if let Some(coordinates) = coordinates {
            spectra = spectra.combined(coordinates);
        }
        Ok(BodyMotion {
            spectra,
            sensors: SensorMotion { names, acceleration },
        })
    }
}

/// Spectra within `range_hz` of the modal accelerations of the body at `index` of a response, and accelerations of
/// points of that body at the response's samples (samples x points). `points` (modes x points) contains the
/// displacement of each mode at these points.
///
/// # Errors
/// The errors of the response and of the Fourier transform.
fn body_spectra(
    response: &ModalResponse,
    index: usize,
    range_hz: [f64; 2],
    points: &DMatrix<f64>,
) -> Result<(ModalSpectra, DMatrix<f64>), Error> {
    let settings = TransformSettings {
        range_hz,
        ..TransformSettings::default()
    };
    let sum = Mutex::new(OrderedSum {
        sum: DMatrix::zeros(response.samples(), points.ncols()),
        next: 0,
        early: BTreeMap::new(),
    });
    let spectra = ModalSpectra::from_blocks(
        points.nrows(),
        BLOCK,
        response.samples(),
        response.step,
        &settings,
        |modes| {
            let motion = response.modal(index, modes.clone(), Motion::Acceleration)?;
            if points.ncols() > 0 {
                let part = &motion * points.rows(modes.start, modes.len());
                sum.lock().unwrap_or_else(PoisonError::into_inner).add(modes, part);
            }
            Ok::<_, Error>(motion)
        },
    )?;
    let OrderedSum { sum, .. } = sum.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok((spectra, sum))
}

/// A sum whose terms arrive in any order and are added in a fixed order, so that the result does not depend on the
/// threads.
struct OrderedSum {
    sum: DMatrix<f64>,
    /// First mode of the next term.
    next: usize,
    /// Terms that arrived early, each with the mode that follows it.
    early: BTreeMap<usize, (usize, DMatrix<f64>)>,
}

impl OrderedSum {
    fn add(&mut self, modes: Range<usize>, term: DMatrix<f64>) {
        self.early.insert(modes.start, (modes.end, term));
        while let Some((end, term)) = self.early.remove(&self.next) {
            self.sum += term;
            self.next = end;
        }
    }
}

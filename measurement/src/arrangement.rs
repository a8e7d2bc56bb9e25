//! Positions of the microphones, and meanings of the other channels.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::sound::{Iso3744Box, environmental_correction};
use nailnoise_acoustics::signals::{COMMON_RANGE_HZ, REFERENCE_PRESSURE};
use nalgebra::Point3;

use super::manifest::{Manifest, Setup};
use crate::error::MeasurementError;
use crate::markers::MarkerEvents;

/// Microphones and other channels of a test, in the order of the channels of a [`Shot`](super::Shot).
#[derive(Debug, Clone)]
pub struct Arrangement {
    /// Support of the workpiece.
    pub setup: Setup,
    /// Centre of the device \[m\].
    pub centre: Point3<f64>,
    /// Positions of the microphones \[m\].
    pub microphones: Vec<Point3<f64>>,
    /// Names of the microphones.
    pub microphone_names: Vec<String>,
    /// Height of the reflecting plane \[m\].
    pub plane: f64,
    /// The air.
    pub air: Air,
    /// Equivalent absorption area of the room \[m2\]; `None` in a free field over a reflecting plane.
    pub absorption: Option<f64>,
    /// Frequency range of the levels \[Hz\].
    pub range_hz: [f64; 2],
    /// Names of the accelerometers.
    pub accelerometers: Vec<String>,
    /// Names of the pressure transducers.
    pub transducers: Vec<String>,
    /// Events of the markers.
    pub events: MarkerEvents,
}

/// Frequency range of the levels \[Hz\], the same as in a run.
const RANGE: [f64; 2] = COMMON_RANGE_HZ;

/// A part of tool or workpiece that carries an accelerometer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The tool's handle.
    Handle,
    /// The block of wood.
    Block,
    /// The edge of the sandbox.
    BoxEdge,
    /// The table under its centre.
    Table,
}

impl Part {
    /// Names of its channels: that in the published tests, and that in the shipped designs.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Self::Handle => ["N", "handle"],
            Self::Block => ["W", "block_top"],
            Self::BoxEdge => ["SE", "sand_edge"],
            Self::Table => ["TC", "table_centre"],
        }
    }
}

impl Arrangement {
    /// The arrangement described by a manifest.
    ///
    /// # Errors
    /// If the air properties are impossible.
    pub fn of(manifest: &Manifest) -> Result<Self, MeasurementError> {
        Ok(Self {
            setup: manifest.setup,
            centre: manifest.centre.into(),
            microphones: manifest.microphones.iter().map(|own| own.position.into()).collect(),
            microphone_names: manifest.microphones.iter().map(|own| own.name.clone()).collect(),
            plane: manifest.plane,
            air: Air::at(manifest.temperature, manifest.static_pressure)?
                .of_gas(manifest.gas_constant, manifest.heat_capacity_ratio)?,
            absorption: manifest.absorption,
            range_hz: RANGE,
            events: manifest.events.clone(),
            accelerometers: manifest.accelerometers.clone(),
            transducers: manifest.pressures.clone(),
        })
    }

    /// The measurement surface.
    pub fn surface(&self) -> Iso3744Box {
        Iso3744Box::around(self.centre.z - self.plane)
    }

    /// Travel time from the device's centre to each microphone \[s\].
    pub fn travel_times(&self) -> Vec<f64> {
        let time = |place: &Point3<f64>| (place - self.centre).norm() / self.air.sound_speed;
        self.microphones.iter().map(time).collect()
    }

    /// Environmental correction K2 \[dB\].
    ///
    /// # Errors
    /// If the absorption area is not positive.
    pub fn room_correction(&self) -> Result<f64, MeasurementError> {
        match self.absorption {
            Some(absorption) => Ok(environmental_correction(self.surface().area(), absorption)?),
            None => Ok(0.0),
        }
    }

    /// Single-event sound power level \[dB re 1 pW s\] for a mean exposure over the microphones \[Pa2 s\]; `None` for
    /// zero exposure.
    ///
    /// ```text
    /// L_WA,1s = 10 lg(mean_m E_m/(20 uPa)^2 s) + 10 lg(S/1 m2) - K2
    /// ```
    pub fn level(&self, mean_exposure: f64, room_correction: f64) -> Option<f64> {
        let area = self.surface().area();
        (mean_exposure > 0.0).then(|| {
            10.0 * (mean_exposure / REFERENCE_PRESSURE.powi(2)).log10() + 10.0 * area.log10() - room_correction
        })
    }

    /// Index of the first accelerometer on one of these parts, in their order.
    pub fn accelerometer(&self, parts: &[Part]) -> Option<usize> {
        let mut names = parts.iter().flat_map(|part| part.names());
        names.find_map(|name| self.accelerometers.iter().position(|own| own == name))
    }

    /// Index of a transducer.
    pub fn transducer(&self, name: &str) -> Option<usize> {
        self.transducers.iter().position(|own| own == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrangement(height: f64) -> Arrangement {
        let centre = Point3::new(0.0, 0.0, height);
        let surface = Iso3744Box::around(height);
        Arrangement {
            setup: Setup::Worktable,
            centre,
            microphones: surface.positions_around(Point3::origin()),
            microphone_names: (1..=9).map(|number| format!("mic{number}")).collect(),
            plane: 0.0,
            air: Air::default(),
            absorption: None,
            range_hz: [50.0, 10_000.0],
            accelerometers: vec!["W".into(), "N".into()],
            transducers: vec!["PT-I".into()],
            events: MarkerEvents::default(),
        }
    }

    /// 80 dB at every microphone around the published worktable.
    #[test]
    fn the_level_is_that_of_the_mean_exposure_over_the_surface() {
        let table = arrangement(0.93775);
        let exposure = 1e8 * REFERENCE_PRESSURE.powi(2);
        assert!((table.level(exposure, 0.0).unwrap_or(0.0) - 92.901).abs() < 5e-4);
        assert!((arrangement(0.1725).surface().area() - 13.38).abs() < 5e-3);
    }

    #[test]
    fn a_room_of_200_m2_costs_1_43_db() {
        let mut table = arrangement(0.93775);
        table.absorption = Some(200.0);
        assert!((table.room_correction().unwrap_or(0.0) - 1.430).abs() < 5e-4);
    }

    #[test]
    fn a_corner_is_sqrt_3_m_away() {
        let table = arrangement(0.93775);
        let times = table.travel_times();
        assert!((times[4] * table.air.sound_speed - 3f64.sqrt()).abs() < 1e-12);
    }
}

//! Levels of the unwrapped sources in recorded shots: the values that a measurement of the recordings should find.

use schemars::JsonSchema;
use serde::Serialize;

use super::sources::{energies, mean_density};
use super::{BareShot, VirtualTest};
use crate::error::Error;
use crate::measurement::arrangement::Arrangement;
use crate::measurement::lines::{Bands, OneSecond};
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::MeasuredBand;
use crate::measurement::wrapping::{Configuration, Role};

/// A source as measured by the array alone, averaged over the shots of the configuration that measures it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BareSource {
    /// Its name.
    pub source: &'static str,
    /// Number of shots.
    pub shots: usize,
    /// A-weighted single-event sound power level \[dB re 1 pW s\].
    pub lwa_db: Option<f64>,
    /// The same in one-third octaves.
    pub bands: Vec<MeasuredBand>,
}

/// Collects the energies of the sources for each shot.
pub struct BareLevels<'a> {
    arrangement: &'a Arrangement,
    room: f64,
    transform: OneSecond,
    bands: Bands,
    /// A-weighted energies over the range and by band, one pair per shot, in the order of [`Role::ALL`].
    energies: [Vec<(f64, Vec<f64>)>; 3],
}

impl<'a> BareLevels<'a> {
    /// For the shots of a test.
    ///
    /// # Errors
    /// The errors of the room correction.
    pub fn new(test: &'a VirtualTest<'_>) -> Result<Self, Error> {
        let transform = OneSecond::new(test.synthesis.rate);
        Ok(Self {
            arrangement: &test.arrangement,
            room: test.arrangement.room_correction()?,
            bands: Bands::new(&transform.frequencies(), test.arrangement.range_hz),
            transform,
            energies: Default::default(),
        })
    }

    /// Adds the shot of a configuration, for the source that this configuration measures.
    pub fn add(&mut self, configuration: Configuration, shot: &BareShot) {
        if let Some(place) = configuration.source().map(|role| role as usize) {
            let density = mean_density(&shot.sources[place], &self.transform);
            self.energies[place].push(energies(&density, &self.bands));
        }
    }

    /// Mean levels of the shots.
    pub fn sources(&self) -> Vec<BareSource> {
        let mean = |energies: &mut dyn Iterator<Item = f64>| {
            let levels: Vec<f64> = energies
                .filter_map(|energy| self.arrangement.level(energy, self.room))
                .collect();
            RepeatedLevel::of(&levels).map(|level| level.db)
        };
        let of = |(source, shots): (Role, &Vec<(f64, Vec<f64>)>)| BareSource {
            source: source.name(),
            shots: shots.len(),
            lwa_db: mean(&mut shots.iter().map(|own| own.0)),
            bands: (self.bands.nominal_hz().into_iter().enumerate())
                .map(|(band, hz)| MeasuredBand {
                    hz,
                    lwa_db: mean(&mut shots.iter().map(|own| own.1[band])),
                })
                .collect(),
        };
        Role::ALL.into_iter().zip(&self.energies).map(of).collect()
    }
}

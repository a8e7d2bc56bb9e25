use super::error::ExhaustError;
use crate::air::Air;
use crate::checks::{finite, positive, same_length};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Uniformly sampled flow through an opening into the ambient air, from the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowHistory {
    /// Sample interval \[s\].
    pub sample_interval: f64,
    /// Outward mass flow \[kg/s\]; negative for inflow.
    pub mass_flow: Vec<f64>,
    /// Absolute stagnation pressure upstream of the opening \[Pa\].
    pub pressure: Vec<f64>,
    /// Stagnation temperature upstream of the opening \[K\].
    pub temperature: Vec<f64>,
    /// Absolute pressure in the chamber downstream of the opening \[Pa\], which the outflow fills; `None` for an
    /// opening into the air.
    pub back_pressure: Option<Vec<f64>>,
}

impl FlowHistory {
    /// The gas into which the jets of a sample discharge: the air, or in a chamber the outflow itself at its stagnation
    /// temperature, because throttling conserves enthalpy.
    pub(super) fn surroundings(&self, sample: usize, air: &Air) -> Air {
        match &self.back_pressure {
            Some(behind) => air.perfect_gas(self.temperature[sample], behind[sample]),
            None => *air,
        }
    }

    pub(super) fn check(&self) -> Result<(), ExhaustError> {
        let n = self.mass_flow.len();
        positive("sample interval [s]", self.sample_interval)?;
        same_length("pressure before the opening", self.pressure.len(), n)?;
        same_length("temperature before the opening", self.temperature.len(), n)?;
        finite("exhaust mass flow", &self.mass_flow)?;
        finite("pressure before the opening", &self.pressure)?;
        finite("temperature before the opening", &self.temperature)?;
        if let Some(behind) = &self.back_pressure {
            same_length("pressure behind the opening", behind.len(), n)?;
            finite("pressure behind the opening", behind)?;
            for &p in behind {
                positive("pressure behind the opening [Pa]", p)?;
            }
        }
        for &t in &self.temperature {
            positive("temperature before the opening [K]", t)?;
        }
        Ok(())
    }
}

/// Round holes through which air leaves as independent jets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Opening {
    /// Number of holes n.
    pub count: usize,
    /// Diameter d of one hole \[m\].
    pub diameter: f64,
    /// Discharge coefficient C_d.
    pub discharge_coefficient: f64,
    /// Distance between the centres of neighbouring holes \[m\], if known.
    pub pitch: Option<f64>,
}

impl Opening {
    /// The acoustically effective jets: separate jets if the holes are more than 3 d apart, otherwise one merged jet of
    /// the same total area. Holes of unknown pitch are treated as separate.
    pub fn merged(&self) -> Self {
        match self.pitch {
            Some(pitch) if self.count > 1 && pitch <= 3.0 * self.diameter => Self {
                count: 1,
                diameter: self.diameter * (self.count as f64).sqrt(),
                discharge_coefficient: self.discharge_coefficient,
                pitch: None,
            },
            _ => *self,
        }
    }

    /// Geometric area of all holes \[m²\].
    pub fn area(&self) -> f64 {
        self.count as f64 * PI / 4.0 * self.diameter * self.diameter
    }

    /// Effective area C_d A_geo of all holes \[m²\].
    pub fn effective_area(&self) -> f64 {
        self.discharge_coefficient * self.area()
    }

    /// Checks that the total area of the holes agrees with `area` \[m²\] within one percent.
    ///
    /// # Errors
    /// [`ExhaustError::HoleArea`] if it does not.
    pub fn check_area(&self, area: f64) -> Result<(), ExhaustError> {
        let found = self.area();
        if (found - area).abs() <= 0.01 * area {
            return Ok(());
        }
        Err(ExhaustError::HoleArea {
            count: self.count,
            diameter: self.diameter,
            found,
            area,
        })
    }

    pub(super) fn check(&self) -> Result<(), ExhaustError> {
        positive("number of exhaust holes", self.count as f64)?;
        positive("diameter of an exhaust hole [m]", self.diameter)?;
        positive("discharge coefficient of the exhaust", self.discharge_coefficient)?;
        if let Some(pitch) = self.pitch {
            positive("pitch of the exhaust holes [m]", pitch)?;
        }
        match self.pitch {
            Some(pitch) if self.count > 1 && pitch <= 3.0 * self.diameter => Err(ExhaustError::MergingJets {
                count: self.count,
                diameter: self.diameter,
                pitch,
                merged: self.diameter * (self.count as f64).sqrt(),
            }),
            _ => Ok(()),
        }
    }
}

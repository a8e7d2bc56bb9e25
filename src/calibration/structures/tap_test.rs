//! A tap test of a plate: its inputs with their distributions, its peaks, and the modes that it predicts.
//!
//! A peak of a mobility does not identify its mode, and a mode with a node at the sensor or at the hammer does not have
//! a peak. A prediction therefore assigns peaks to modes in ascending order, by the assignment of the highest
//! likelihood. The number of modes without a peak below the last assigned one is a further reading: it is 0, with a
//! standard error of 2. Two missing modes thus cost as much likelihood as one frequency that is off by one standard
//! error.

use std::borrow::Cow;

use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::{Datum, ErrorLaw, Prediction, Reading};

use super::plate::{Plate, PlateMode, Ritz};

/// Name of the number of modes without a peak.
pub(super) const UNSEEN: &str = "modes without a peak";

/// Standard error of that number \[E\].
const ERROR_OF_UNSEEN: f64 = 2.0;

/// Number of modes that may be considered in addition to the number of peaks.
const MOST_UNSEEN: usize = 12;

/// Distribution of an input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// Normal, with mean and standard deviation.
    Normal(f64, f64),
    /// The logarithm is normal, with mean and standard deviation.
    LogNormal(f64, f64),
}

impl Law {
    /// The value at a point of a standard normal variable.
    pub(super) fn at(self, z: f64) -> f64 {
        match self {
            Self::Normal(mean, deviation) => mean + deviation * z,
            Self::LogNormal(mean, deviation) => (mean + deviation * z).exp(),
        }
    }
}

/// An input of a plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Input {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) law: Law,
}

/// The inputs in their order.
pub(super) const LENGTH: usize = 0;
pub(super) const WIDTH: usize = 1;
pub(super) const THICKNESS: usize = 2;
pub(super) const MASS: usize = 3;
pub(super) const E_L: usize = 4;
pub(super) const E_R: usize = 5;
pub(super) const G_LR: usize = 6;
pub(super) const G_LT: usize = 7;
pub(super) const G_RT: usize = 8;
pub(super) const NU_LR: usize = 9;
pub(super) const AIR_SHARE: usize = 10;
pub(super) const INPUTS: usize = 11;

/// A plate with its peaks.
#[derive(Debug, Clone)]
pub(super) struct TapTest {
    pub(super) name: String,
    pub(super) inputs: [Input; INPUTS],
    /// Density of the air \[kg/m³\].
    pub(super) air_density: f64,
    /// Peaks in ascending order \[Hz\].
    pub(super) peaks: Vec<f64>,
    /// Whether each peak is only predicted.
    pub(super) is_check: Vec<bool>,
    /// Standard deviation of a peak's reading \[Hz\].
    pub(super) errors: Vec<f64>,
    /// Standard deviation of the model, as a share of the frequency.
    pub(super) discrepancy: f64,
}

impl TapTest {
    /// The plate at a point of the inputs.
    pub(super) fn plate(&self, z: &[f64]) -> Plate {
        let at = |k: usize| self.inputs[k].law.at(z[k]);
        Plate {
            size: [LENGTH, WIDTH, THICKNESS].map(at),
            mass: at(MASS),
            e_l: at(E_L),
            e_r: at(E_R),
            g_lr: at(G_LR),
            g_lt: at(G_LT),
            g_rt: at(G_RT),
            nu_lr: at(NU_LR),
            air_density: self.air_density,
            air_share: at(AIR_SHARE).max(0.0),
        }
    }

    /// The readings: the peaks in their order, then the number of modes without one. Those that count condition the
    /// inputs.
    pub(super) fn data(&self, counts: &[bool]) -> Vec<Datum> {
        let datum = |k: usize, name: String, value: f64, scale: f64| Datum {
            name,
            condition: 0,
            reading: Reading::Value(value),
            scale,
            shared: Vec::new(),
            counts: counts[k],
        };
        let peaks = self.peaks.iter().enumerate();
        let mut data: Vec<Datum> = peaks
            .map(|(k, hz)| datum(k, format!("{hz} Hz"), *hz, self.scale(k)))
            .collect();
        data.push(datum(self.peaks.len(), UNSEEN.to_owned(), 0.0, ERROR_OF_UNSEEN));
        data
    }

    /// Standard deviation of a peak, from its reading and the model \[Hz\].
    fn scale(&self, peak: usize) -> f64 {
        self.errors[peak].hypot(self.discrepancy * self.peaks[peak])
    }

    /// The mode of each peak, and the number of modes without one. Peaks that do not count take the nearest mode.
    pub(super) fn assigned(&self, modes: &[PlateMode], counts: &[bool]) -> Assignment {
        let counting: Vec<usize> = (0..self.peaks.len()).filter(|&k| counts[k]).collect();
        let first = &modes[..modes.len().min(counting.len() + MOST_UNSEEN)];
        let fit = |peak: usize, mode: &PlateMode| {
            let residual = (self.peaks[peak] - mode.hz) / self.scale(peak);
            ErrorLaw::Student.log_density(residual)
        };
        // best[j]: highest log-likelihood of the peaks so far if the last one has mode j.
        let mut best: Vec<f64> = Vec::new();
        let mut before: Vec<Vec<usize>> = Vec::new();
        for (place, &peak) in counting.iter().enumerate() {
            let mut leading: Option<usize> = None;
            let (mut now, mut from) = (vec![f64::NEG_INFINITY; first.len()], vec![0; first.len()]);
            for (j, mode) in first.iter().enumerate() {
                if place == 0 {
                    now[j] = fit(peak, mode);
                } else if let Some(i) = leading {
                    (now[j], from[j]) = (fit(peak, mode) + best[i], i);
                }
                if place > 0 && leading.is_none_or(|i| best[j] > best[i]) {
                    leading = Some(j);
                }
            }
            best = now;
            before.push(from);
        }
        let unseen = |last: usize| (last + 1).saturating_sub(counting.len());
        let total = |&j: &usize| best[j] + ErrorLaw::Student.log_density(unseen(j) as f64 / ERROR_OF_UNSEEN);
        let last = (0..best.len()).max_by(|a, b| total(a).total_cmp(&total(b)));
        let mut of_peak: Vec<usize> = self.peaks.iter().map(|hz| nearest(modes, *hz)).collect();
        let mut mode = last.unwrap_or(0);
        for (place, &peak) in counting.iter().enumerate().rev() {
            of_peak[peak] = mode;
            mode = before[place][mode];
        }
        let end = last.map_or(0, |last| last + 1);
        let is_seen = |mode: &usize| of_peak.contains(mode);
        Assignment {
            unseen: (0..end).filter(|mode| !is_seen(mode)).count(),
            of_peak,
        }
    }
}

/// The mode nearest to a frequency.
fn nearest(modes: &[PlateMode], hz: f64) -> usize {
    let distance = |k: &usize| (modes[*k].hz / hz).ln().abs();
    let found = (0..modes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    found.unwrap_or(0)
}

/// Modes to which peaks belong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Assignment {
    /// Index of the mode of each peak.
    pub(super) of_peak: Vec<usize>,
    /// Number of modes without a peak below the last one with a peak.
    pub(super) unseen: usize,
}

/// A plate as a simulation.
pub(super) struct Simulation<'a> {
    pub(super) ritz: &'a Ritz,
    pub(super) test: &'a TapTest,
    /// Whether each reading conditions the inputs.
    pub(super) counts: Vec<bool>,
}

impl Simulator for Simulation<'_> {
    fn variables(&self) -> usize {
        INPUTS
    }

    fn predict(&self, z: &[f64], _: usize) -> Result<Vec<Prediction>, Cow<'static, str>> {
        let modes = self.ritz.modes(&self.test.plate(z)).ok_or("not positive definite")?;
        let assigned = self.test.assigned(&modes, &self.counts);
        let hz = assigned.of_peak.iter().map(|&mode| Prediction::Value(modes[mode].hz));
        let unseen = Prediction::Value(assigned.unseen as f64);
        Ok(hz.chain([unseen]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(peaks: &[f64]) -> TapTest {
        let input = Input {
            name: "",
            unit: "",
            law: Law::Normal(1.0, 0.0),
        };
        TapTest {
            name: String::new(),
            inputs: [input; INPUTS],
            air_density: 1.2,
            peaks: peaks.to_vec(),
            is_check: vec![false; peaks.len()],
            errors: vec![0.1; peaks.len()],
            discrepancy: 0.01,
        }
    }

    fn modes(hz: &[f64]) -> Vec<PlateMode> {
        let mode = |hz: &f64| PlateMode {
            hz: *hz,
            nodal_lines: [0, 2],
        };
        hz.iter().map(mode).collect()
    }

    #[test]
    fn peaks_skip_modes_that_none_of_them_meets() {
        let modes = modes(&[50.0, 75.0, 120.0, 140.0, 200.0, 230.0]);
        let assigned = test(&[50.2, 120.5, 198.0]).assigned(&modes, &[true; 4]);
        assert_eq!(assigned.of_peak, [0, 2, 4]);
        assert_eq!(assigned.unseen, 2);
    }

    /// Two peaks near one mode are two modes.
    #[test]
    fn each_peak_has_its_own_mode_in_ascending_order() {
        let assigned = test(&[99.0, 101.0]).assigned(&modes(&[100.0, 108.0, 300.0]), &[true; 3]);
        assert_eq!(assigned.of_peak, [0, 1]);
        assert_eq!(assigned.unseen, 0);
    }

    #[test]
    fn a_peak_that_does_not_count_takes_the_nearest_mode_and_no_other_peaks() {
        let modes = modes(&[50.0, 75.0, 120.0]);
        let assigned = test(&[50.0, 52.0, 75.0]).assigned(&modes, &[true, false, true, true]);
        assert_eq!(assigned.of_peak, [0, 0, 1]);
        assert_eq!(assigned.unseen, 0);
    }

    /// Compared with all ascending assignments.
    #[test]
    fn the_assignment_is_the_most_likely_of_all() {
        let hz = [50.0, 53.0, 70.0, 74.0, 110.0, 112.0];
        let own = test(&[52.0, 71.5, 111.0]);
        let log = |places: &[usize]| -> f64 {
            let peaks = own.peaks.iter().zip(places).enumerate();
            let fits: f64 = peaks
                .map(|(k, (peak, &j))| ErrorLaw::Student.log_density((peak - hz[j]) / own.scale(k)))
                .sum();
            fits + ErrorLaw::Student.log_density((places[2] - 2) as f64 / ERROR_OF_UNSEEN)
        };
        let mut best = (f64::NEG_INFINITY, vec![]);
        for i in 0..4 {
            for j in i + 1..5 {
                for k in j + 1..6 {
                    let found = log(&[i, j, k]);
                    if found > best.0 {
                        best = (found, vec![i, j, k]);
                    }
                }
            }
        }
        assert_eq!(own.assigned(&modes(&hz), &[true; 4]).of_peak, best.1);
    }
}

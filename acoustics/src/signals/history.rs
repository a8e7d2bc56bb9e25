use super::{Level, energy_level};
use serde::{Deserialize, Serialize};

/// A-weighted sound power over time on uniform cells.
///
/// Cell n contains the mean power between `start` + (n - 1/2) dt and `start` + (n + 1/2) dt, so sums over the cells are
/// energies without gaps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PowerHistory {
    /// Midpoint of the first cell \[s\].
    pub start: f64,
    /// Length of a cell \[s\].
    pub sample_interval: f64,
    /// Mean A-weighted power of each cell \[W\].
    pub power: Vec<f64>,
}

impl PowerHistory {
    /// The history multiplied by a factor, which may be negative.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            power: self.power.iter().map(|power| factor * power).collect(),
            ..*self
        }
    }

    /// Energy of the complete history \[J\].
    pub fn total(&self) -> f64 {
        self.power.iter().sum::<f64>() * self.sample_interval
    }

    /// Energies between adjacent `edges` \[J\]; the edges \[s\] must not decrease. They add up to [`Self::total`]:
    /// energy before the first edge belongs to the first interval, energy after the last edge to the last.
    ///
    /// A cell cut by an edge is divided in proportion to time.
    pub fn energies_between(&self, edges: &[f64]) -> Vec<f64> {
        let intervals = edges.len().saturating_sub(1);
        if intervals == 0 {
            return Vec::new();
        }
        let mut energies = vec![0.0; intervals];
        let dt = self.sample_interval;
        let mut at = 0;
        for (n, power) in self.power.iter().enumerate() {
            let end = self.start + (n as f64 + 0.5) * dt;
            let mut left = 1.0;
            while at + 1 < intervals && edges[at + 1] < end {
                // Fraction of the remainder of the cell that lies before the edge.
                let before = (left - (end - edges[at + 1]) / dt).clamp(0.0, left);
                energies[at] += before * power * dt;
                left -= before;
                at += 1;
            }
            energies[at] += left * power * dt;
        }
        energies
    }

    /// The sum of the histories of several sources, in `cells` cells of `sample_interval` \[s\] starting at `start`
    /// \[s\]; the total energy of the given histories is preserved.
    pub fn sum(histories: &[Self], start: f64, sample_interval: f64, cells: usize) -> Self {
        let edges: Vec<f64> = (0..=cells + 2)
            .map(|n| start + (n as f64 - 1.5) * sample_interval)
            .collect();
        let mut power = vec![0.0; cells];
        for history in histories {
            // The first and the last cell receive the energy outside.
            let energies = history.energies_between(&edges);
            let inside = energies.iter().skip(1).take(cells);
            power
                .iter_mut()
                .zip(inside)
                .for_each(|(p, e)| *p += e / sample_interval);
        }
        Self {
            start,
            sample_interval,
            power,
        }
    }
}

/// Energy and levels of a source between two events.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IntervalLevels {
    /// Start \[s\].
    pub from: f64,
    /// End \[s\].
    pub to: f64,
    /// A-weighted energy \[J\]; the energies of all intervals add up to that of the source.
    pub energy: f64,
    /// Level L_WA,1s of `energy` \[dB re 1 pW s\].
    pub lwa: Level,
    /// A-weighted energy of the signal windowed to the interval \[J\].
    pub cut_energy: f64,
    /// Level L_WA,1s of `cut_energy` \[dB re 1 pW s\].
    pub lwa_cut: Level,
}

impl IntervalLevels {
    /// Levels from energies \[J\].
    pub fn new(from: f64, to: f64, energy: f64, cut_energy: f64) -> Self {
        Self {
            from,
            to,
            energy,
            lwa: energy_level(energy),
            cut_energy,
            lwa_cut: energy_level(cut_energy),
        }
    }

    /// Intervals with energies multiplied by a factor, which may be negative.
    pub fn scaled(intervals: &[Self], factor: f64) -> Vec<Self> {
        let scaled = |own: &Self| Self::new(own.from, own.to, factor * own.energy, factor * own.cut_energy);
        intervals.iter().map(scaled).collect()
    }

    /// Sum of the intervals of independent sources: energies add. All must have the same edges.
    pub fn sum(parts: &[Vec<Self>]) -> Vec<Self> {
        let Some((first, others)) = parts.split_first() else {
            return Vec::new();
        };
        let add = |(i, own): (usize, &Self)| {
            let also = |value: fn(&Self) -> f64| {
                let others: f64 = others.iter().filter_map(|part| part.get(i)).map(value).sum();
                value(own) + others
            };
            Self::new(own.from, own.to, also(|p| p.energy), also(|p| p.cut_energy))
        };
        first.iter().enumerate().map(add).collect()
    }
}

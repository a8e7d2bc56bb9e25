//! Predicted results of a wrapping test of a design, over draws of its ranges and of its wraps.

use nailnoise_acoustics::random::uniform;

use super::measurements::MeasuredQuantity;
use crate::decibels::{energy, energy_sum};
use crate::design::{Design, Value};
use crate::error::Error;
use crate::measurement::arrangement::Part;
use crate::measurement::manifest::Setup;
use crate::measurement::wrapping::{Role, Wrapping, configurations, separated};
use crate::model::sources::by_name;
use crate::stages::levels::{Levels, SourceLevels};
use crate::study::{Draw, Draws};
use crate::virtual_test::exact::{ExactTest, exact};
use crate::virtual_test::{BareShot, VirtualTest, wrapping};

/// Fraction of the draws below and above an interval.
const TAIL: f64 = 0.05;

/// Minimum number of draws for an interval.
const LEAST_DRAWS: usize = 8;

/// Levels of a wrapping test \[dB\]; NaN if no energy remains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TestLevels {
    /// The total, E_1.
    pub total: f64,
    /// X_5, X_3, X_4: workpiece, exhaust and body minus the residual.
    pub separated: [f64; 3],
    /// The bound U.
    pub bound: f64,
    /// The closure C.
    pub closure: f64,
    /// The unwrapped workpiece, as measured by the array.
    pub workpiece: f64,
}

/// Predictions of a design.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// Name of the design.
    pub name: String,
    /// Support of its workpiece.
    pub setup: Setup,
    own: TestLevels,
    drawn: Vec<TestLevels>,
    structures: usize,
    /// RMS acceleration of the block over 1 s \[g\], for the design and for the draws.
    block_rms: Option<f64>,
    drawn_block_rms: Vec<f64>,
    /// Mean speed of the nail over its length \[m/s\], for the design and for the draws.
    speed: Option<f64>,
    drawn_speed: Vec<f64>,
    /// Length of the nail \[m\].
    nail_length: f64,
}

/// A predicted value with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Value of the design itself.
    pub own: f64,
    /// 5th and 95th percentile of the draws.
    pub interval: Option<[f64; 2]>,
}

impl Predicted {
    /// Number of draws.
    pub fn draws(&self) -> usize {
        self.drawn.len()
    }

    /// Number of structures drawn; 0 if they are fixed.
    pub fn structures(&self) -> usize {
        self.structures
    }
}

/// A quantity that can be predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The bound of the workpiece from the test's own steps.
    Bound(Setup),
    /// The unwrapped workpiece, which is below any valid bound.
    Workpiece(Setup),
    /// The total.
    Total(Setup),
    /// A source minus the residual.
    Source(Setup, Role),
    /// The sum of the three sources minus the residual.
    Sum(Setup),
    /// The sum of exhaust and body minus the residual.
    Others(Setup),
    /// The closure.
    Closure(Setup),
    /// Total on the table minus total in sand.
    Fall,
    /// RMS of the block's acceleration.
    BlockRms(Setup),
    /// Mean speed of the nail.
    Speed,
    /// Time in which the nail travels its length \[ms\].
    PenetrationTime,
}

impl Quantity {
    /// The quantities with which an entry is compared; empty if the program predicts nothing of this kind.
    pub fn of(entry: &MeasuredQuantity) -> Vec<Self> {
        use Setup::{Sandbox, Worktable};
        match entry.id.as_str() {
            "lwa_workpiece_worktable" => vec![Self::Bound(Worktable), Self::Workpiece(Worktable)],
            "lwa_workpiece_sandbox" => vec![Self::Bound(Sandbox), Self::Workpiece(Sandbox)],
            "lwa_exhaust_sandbox" | "exhaust, corrected, sandbox" => vec![Self::Source(Sandbox, Role::Exhaust)],
            "lwa_total_fall" => vec![Self::Fall],
            "closure_worktable" => vec![Self::Closure(Worktable)],
            "closure_sandbox" => vec![Self::Closure(Sandbox)],
            "rms_w_worktable" => vec![Self::BlockRms(Worktable)],
            "rms_w_sandbox" => vec![Self::BlockRms(Sandbox)],
            "mean_penetration_speed" => vec![Self::Speed],
            "penetration_time" => vec![Self::PenetrationTime],
            "total, worktable" => vec![Self::Total(Worktable)],
            "total, sandbox" => vec![Self::Total(Sandbox)],
            "exhaust and body together, corrected, worktable" => vec![Self::Others(Worktable)],
            "exhaust, corrected, worktable" => vec![Self::Source(Worktable, Role::Exhaust)],
            "body, corrected, worktable" => vec![Self::Source(Worktable, Role::Body)],
            "body, corrected, sandbox" => vec![Self::Source(Sandbox, Role::Body)],
            "workpiece as measured directly (X5), worktable" => vec![Self::Source(Worktable, Role::Workpiece)],
            "workpiece as measured directly (X5), sandbox" => vec![Self::Source(Sandbox, Role::Workpiece)],
            "sum of the three corrected sources, worktable" => vec![Self::Sum(Worktable)],
            _ => Vec::new(),
        }
    }

    /// Whether the measurement only bounds it from above.
    pub fn is_bounded_above(self) -> bool {
        matches!(self, Self::Workpiece(_))
    }

    /// Whether it results from the test's own steps, so that a printed bound is compared as a value.
    pub fn is_test_outcome(self) -> bool {
        matches!(self, Self::Bound(_))
    }

    /// Whether it is a level.
    pub fn is_level(self) -> bool {
        !matches!(
            self,
            Self::Closure(_) | Self::Fall | Self::BlockRms(_) | Self::Speed | Self::PenetrationTime
        )
    }

    /// Description of the quantity compared with an entry.
    pub fn in_words(self, entry: &MeasuredQuantity) -> String {
        match self {
            Self::Bound(_) => format!("{}: upper bound, processed like the measurement", entry.quantity),
            Self::Workpiece(_) => format!(
                "{}: level of the source itself, which must not exceed the bound",
                entry.quantity
            ),
            Self::BlockRms(setup) => format!("{}, {}", entry.quantity, setup.as_str()),
            _ => entry.quantity.clone(),
        }
    }

    /// Its prediction by each of the designs whose workpiece is supported as in the test, with their names.
    pub fn predicted(self, all: &[Predicted]) -> Vec<(String, Found)> {
        let of = |setup: Setup| all.iter().filter(move |own| own.setup == setup);
        let each = |setup: Setup, value: &dyn Fn(&Predicted) -> Option<Found>| -> Vec<(String, Found)> {
            let found = of(setup).filter_map(|own| Some((own.name.clone(), value(own)?)));
            found.collect()
        };
        let levels = |setup: Setup, value: &dyn Fn(&TestLevels) -> f64| {
            each(setup, &|own| {
                found(value(&own.own), own.drawn.iter().map(value).collect())
            })
        };
        let sum = |levels: &[f64]| energy_sum(levels.iter().copied());
        match self {
            Self::Bound(setup) => levels(setup, &|own| own.bound),
            Self::Workpiece(setup) => levels(setup, &|own| own.workpiece),
            Self::Total(setup) => levels(setup, &|own| own.total),
            Self::Source(setup, role) => levels(setup, &|own| own.separated[role as usize]),
            Self::Sum(setup) => levels(setup, &|own| sum(&own.separated)),
            Self::Others(setup) => levels(setup, &|own| sum(&own.separated[1..])),
            Self::Closure(setup) => levels(setup, &|own| own.closure),
            Self::Fall => {
                let pairs = of(Setup::Worktable).flat_map(|table| of(Setup::Sandbox).map(move |sand| (table, sand)));
                let fall = |(table, sand): (&Predicted, &Predicted)| {
                    // The draws of both are common if they were drawn together.
                    let drawn = table.drawn.iter().zip(&sand.drawn);
                    let drawn = drawn.map(|(a, b)| a.total - b.total).collect();
                    let found = found(table.own.total - sand.own.total, drawn)?;
                    Some((format!("{}, {}", table.name, sand.name), found))
                };
                pairs.filter_map(fall).collect()
            }
            Self::BlockRms(setup) => each(setup, &|own| found(own.block_rms?, own.drawn_block_rms.clone())),
            // The published speed is that of the nailer; the support hardly affects it.
            Self::Speed | Self::PenetrationTime => {
                let quantity = |own: &Predicted, speed: f64| match self {
                    Self::Speed => speed,
                    _ => 1e3 * own.nail_length / speed,
                };
                let first = all.iter().find_map(|own| {
                    let drawn = own.drawn_speed.iter().map(|speed| quantity(own, *speed));
                    let found = found(quantity(own, own.speed?), drawn.collect())?;
                    Some((own.name.clone(), found))
                });
                first.into_iter().collect()
            }
        }
    }
}

/// A value with the interval of its draws; `None` if it does not exist.
fn found(own: f64, drawn: Vec<f64>) -> Option<Found> {
    if !own.is_finite() {
        return None;
    }
    let mut drawn: Vec<f64> = drawn.into_iter().filter(|value| value.is_finite()).collect();
    drawn.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let place = share * (drawn.len() - 1) as f64;
        let (below, rest) = (place.floor() as usize, place.fract());
        drawn[below] + rest * (drawn[(below + 1).min(drawn.len() - 1)] - drawn[below])
    };
    let interval = (drawn.len() >= LEAST_DRAWS).then(|| [quantile(TAIL), quantile(1.0 - TAIL)]);
    Some(Found { own, interval })
}

/// Predicts the wrapping test of a design. `shot` is its own shot; `drawn` are draws of its ranges, with the levels of
/// the design itself. Draws of the wraps depend on `seed`.
///
/// A draw changes each band of a source by the same amount as the band's radiated level; the directivity at the
/// microphones is that of the design itself.
///
/// # Errors
/// The errors of the energies.
pub fn predict(
    test: &VirtualTest<'_>,
    design: &Design,
    shot: &BareShot,
    (nominal, drawn): (&Levels, &Draws),
    seed: u64,
) -> Result<Predicted, Error> {
    let rate = design.test.sampling_rate;
    let background = design.acoustics.background_level;
    let own = exact(
        &test.arrangement,
        rate,
        &wrapping(design),
        &test.densities(shot),
        background,
    )?;
    let levels = drawn.draws.iter().enumerate().map(|(place, draw)| {
        let wraps = drawn_wraps(design, seed, place as u64);
        levels_of(&own, &wraps, |source, band| change(nominal, draw, source, band))
    });
    let block = test
        .arrangement
        .accelerometer(&[Part::Block])
        .and_then(|place| shot.sensors.get(place));
    let drawn_rms = |draw: &Draw| {
        let own = draw
            .levels
            .sensors
            .iter()
            .find(|(name, _)| Some(name) == block.map(|own| &own.name))?;
        Some(own.1)
    };
    let own_speed = shot.cycle.figures.get("mean_drive_speed");
    Ok(Predicted {
        name: design.name().to_owned(),
        setup: test.arrangement.setup,
        own: levels_of(&own, &wrapping(design), |_, _| 0.0),
        drawn: levels.collect(),
        structures: drawn.structures,
        block_rms: block.map(|own| own.level().rms_g),
        drawn_block_rms: drawn.draws.iter().filter_map(drawn_rms).collect(),
        speed: own_speed,
        nail_length: design.nail.length,
        drawn_speed: drawn
            .draws
            .iter()
            .filter_map(|draw| draw.shot.mean_drive_speed)
            .collect(),
    })
}

/// Change of a band of a source of the test in a draw, relative to the design itself \[dB\].
fn change(nominal: &Levels, draw: &Draw, role: usize, hz: f64) -> f64 {
    let plays = |name: &str| by_name(name).is_some_and(|source| source.role() as usize == role);
    let band = |levels: &Levels, errors: &[f64]| {
        let sources = levels.sources.iter().zip(errors).filter(|(own, _)| plays(&own.source));
        let energy = |(own, error): (&SourceLevels, &f64)| {
            let level = own.bands.iter().find(|(band, _)| (band / hz - 1.0).abs() < 1e-6)?.1?;
            Some(10f64.powf(0.1 * (level + error)))
        };
        let energy: f64 = sources.filter_map(energy).sum();
        (energy > 0.0).then(|| 10.0 * energy.log10())
    };
    let without_error = vec![0.0; nominal.sources.len()];
    match (band(nominal, &without_error), band(&draw.levels, &draw.method_db)) {
        (Some(before), Some(after)) => after - before,
        _ => 0.0,
    }
}

/// The wraps of a draw: each of their keys with a range is uniform over it.
fn drawn_wraps(design: &Design, seed: u64, draw: u64) -> Wrapping {
    let mut drawn = design.clone();
    let entries = design.entries();
    let ranged = entries.iter().filter(|entry| entry.key.starts_with("test.wraps."));
    let changes: Vec<(&str, Value)> = ranged
        .enumerate()
        .filter_map(|(place, entry)| {
            let [low, high] = entry.range?;
            let share = uniform(seed, draw, 1000 + place as u64);
            Some((entry.key.as_str(), Value::Number(low + share * (high - low))))
        })
        .collect();
    // Values within the ranges of a design that was read are valid.
    let set = drawn.set(&changes);
    debug_assert!(set.is_ok(), "{set:?}");
    wrapping(&drawn)
}

/// Levels of a test with the sources of `own`, changed in each band by `change(source, hz)` \[dB\], with these wraps.
fn levels_of(own: &ExactTest, wraps: &Wrapping, change: impl Fn(usize, f64) -> f64) -> TestLevels {
    let mut total = [0.0; 5];
    let mut workpiece = 0.0;
    for band in &own.bands {
        let sources = [0, 1, 2].map(|s: usize| energy(band.sources_db[s].map(|level| level + change(s, band.hz))));
        workpiece += sources[0];
        let mixed = configurations(&wraps.at(band.hz).matrix(), &sources, 0.0);
        total.iter_mut().zip(mixed).for_each(|(sum, e)| *sum += e);
    }
    // The background covers the complete range and is the same in each configuration.
    let background = energy(own.background_db);
    total.iter_mut().for_each(|e| *e += background);
    let parts = separated(&total);
    let level = |energy: f64| if energy > 0.0 { 10.0 * energy.log10() } else { f64::NAN };
    TestLevels {
        total: level(total[0]),
        separated: [parts.workpiece, parts.exhaust, parts.body].map(level),
        bound: level(parts.bound),
        closure: level(parts.closure),
        workpiece: level(workpiece),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_holds_the_middle_nine_tenths_of_the_draws() {
        let drawn: Vec<f64> = (0..=100).map(f64::from).collect();
        let found = found(50.0, drawn).and_then(|own| own.interval);
        assert_eq!(found, Some([5.0, 95.0]));
    }

    #[test]
    fn few_draws_give_no_interval_and_a_missing_value_nothing() {
        assert_eq!(found(1.0, vec![1.0; 3]).map(|own| own.interval), Some(None));
        assert_eq!(found(f64::NAN, Vec::new()), None);
    }
}

//! What to measure next: the gain of usual measurements in the interval of the total and in the order of the sources,
//! from the available draws and their levels.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use nailnoise_calibration::likelihood::ErrorLaw;
use nailnoise_calibration::next::{Further, Outputs, gain};
use nailnoise_calibration::statistics::{quantile_of, rank_correlation};
use nailnoise_dynamics::network::{Assembly, AssemblyText};
use rayon::prelude::*;
use serde::Serialize;

use super::assembly_quantities::{self, AssemblyQuantity};
use super::level_quantities::{LevelQuantity, Position};
use super::quantities::{Chamber, Moment, Quantity};
use super::shot::Shot;
use super::spread::Spread;
use super::tool::Tool;
use crate::design::{Design, JointDraws, Value};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::TOTAL;
use crate::stages::Progress;
use crate::store::Store;
use crate::study::{DrawsAtHand, Request, draws, levels_of};

/// Pressures of the supply at which shots could be measured, as shares of the design's gauge pressure.
const PRESSURES: [f64; 3] = [1.0, 0.75, 1.15];

/// A pound-force on a square inch \[Pa\].
const PSI: f64 = 6_894.757_293_168_361;

/// Shots of a usual measurement.
const SHOTS: f64 = 5.0;

/// A usual measurement: its name, quantity, error of one reading and minutes.
#[derive(Clone)]
struct Usual {
    name: Cow<'static, str>,
    quantity: Quantity,
    error: Spread,
    minutes: f64,
}

const fn percent(share: f64) -> Spread {
    Spread {
        share: 0.01 * share,
        amount: 0.0,
    }
}

const fn amount(amount: f64) -> Spread {
    Spread { share: 0.0, amount }
}

/// Errors of one reading, and minutes of a measurement: of a depth, the air of a shot, a speed by film, a pressure by a
/// transducer.
const DEPTH: (Spread, f64) = (amount(0.2e-3), 10.0);
const AIR: (Spread, f64) = (percent(4.0), 15.0);
const SPEED: (Spread, f64) = (percent(2.0), 240.0);
const PRESSURE: (Spread, f64) = (percent(2.0), 180.0);

/// Usual measurements of a shot at the design's pressure. Depths are measured at the other pressures, too.
static USUAL: [Usual; 9] = [
    Usual {
        name: Cow::Borrowed("head depth"),
        quantity: Quantity::HeadDepth,
        error: DEPTH.0,
        minutes: DEPTH.1,
    },
    Usual {
        name: Cow::Borrowed("air per shot"),
        quantity: Quantity::AirPerShot,
        error: AIR.0,
        minutes: AIR.1,
    },
    Usual {
        name: Cow::Borrowed("trigger to valve opening"),
        quantity: Quantity::Interval { from: 0, to: 6 },
        error: amount(0.2e-3),
        minutes: 15.0,
    },
    Usual {
        name: Cow::Borrowed("drive time"),
        quantity: Quantity::Interval { from: 6, to: 9 },
        error: amount(0.1e-3),
        minutes: 30.0,
    },
    Usual {
        name: Cow::Borrowed("valve opening to exhaust"),
        quantity: Quantity::Interval { from: 6, to: 14 },
        error: amount(0.2e-3),
        minutes: 15.0,
    },
    Usual {
        name: Cow::Borrowed("mean drive speed"),
        quantity: Quantity::MeanDriveSpeed,
        error: SPEED.0,
        minutes: SPEED.1,
    },
    Usual {
        name: Cow::Borrowed("peak pressure above the piston"),
        quantity: Quantity::PeakPressure(Chamber::AbovePiston),
        error: PRESSURE.0,
        minutes: PRESSURE.1,
    },
    Usual {
        name: Cow::Borrowed("peak pressure of the return volume"),
        quantity: Quantity::PeakPressure(Chamber::Return),
        error: PRESSURE.0,
        minutes: PRESSURE.1,
    },
    Usual {
        name: Cow::Borrowed("pressure above the piston at full depth"),
        quantity: Quantity::Pressure(Chamber::AbovePiston, Moment::event(9)),
        error: PRESSURE.0,
        minutes: PRESSURE.1,
    },
];

impl Usual {
    /// Whether it is the depth of a fastener, which is measured at other pressures, too.
    fn is_depth(&self) -> bool {
        match &self.quantity {
            Quantity::HeadDepth => true,
            Quantity::OfAssembly(AssemblyQuantity::Figure(own)) => own.unit == "m",
            _ => false,
        }
    }
}

/// The usual measurements of an assembly, with the errors and minutes of those of the tool of the keys: depths and
/// speeds of fasteners, air, and the peak pressure of each volume.
fn of_assembly(assembly: &Assembly) -> Vec<Usual> {
    let figures = assembly_quantities::figures(assembly).into_iter().filter_map(|own| {
        let (error, minutes) = match own.unit {
            "m" => DEPTH,
            "m/s" => SPEED,
            _ => return None,
        };
        Some(Usual {
            name: own.name.replace('_', " ").into(),
            quantity: Quantity::OfAssembly(AssemblyQuantity::Figure(own)),
            error,
            minutes,
        })
    });
    let air = assembly_quantities::air_per_shot(assembly).map(|own| Usual {
        name: "air per shot".into(),
        quantity: Quantity::OfAssembly(own),
        error: AIR.0,
        minutes: AIR.1,
    });
    let pressures = assembly.volumes.iter().map(|own| Usual {
        name: format!("peak pressure of {}", own.name).into(),
        quantity: Quantity::OfAssembly(AssemblyQuantity::PeakPressure {
            volume: own.name.clone(),
        }),
        error: PRESSURE.0,
        minutes: PRESSURE.1,
    });
    figures.chain(air).chain(pressures).collect()
}

/// Minutes to measure a key on the disassembled tool; errors of a length, and of any other quantity.
const DIRECT_MINUTES: f64 = 60.0;
const DIRECT_LENGTH: f64 = 0.1e-3;
const DIRECT_SHARE: f64 = 0.01;

/// Level of all sources at one microphone, single shots: minutes, error of a reading and of the model \[dB\].
const LEVEL_MINUTES: f64 = 45.0;
const LEVEL_ERROR: f64 = 0.7;

/// Name of that measurement.
const LEVEL: &str = "level at one microphone";

/// Names under which a file states minutes of keys of the tool and of levels.
const DIRECT_EFFORT: &str = "direct";
const LEVEL_EFFORT: &str = "level";

/// Names of further measurements whose minutes a file may state.
pub(super) fn efforts() -> impl Iterator<Item = &'static str> {
    let mut names: Vec<&'static str> = USUAL.iter().map(|own| own.quantity.name()).collect();
    names.dedup();
    names.into_iter().chain([DIRECT_EFFORT, LEVEL_EFFORT])
}

/// Number of keys of a known study that are weighed: those with which the total correlates most.
const KEYS_OF_STUDY: usize = 6;

/// Tables of keys that a part of the tool states.
const PARTS: [&str; 6] = ["piston.", "head_valve.", "chambers.", "exhaust.", "body.", "tool."];

/// Table of an assembly's numbers.
const OF_ASSEMBLY: &str = "cycle.";

/// Units of keys that callipers, scales or a fill of water measure.
const MEASURABLE: [&str; 4] = ["m", "kg", "m2", "m3"];

/// A measurement that could be made next.
#[derive(Debug, Clone, Serialize)]
pub struct NextRow {
    /// What to measure.
    pub measurement: String,
    /// Pressure of the supply; empty for a key of the tool.
    pub condition: String,
    /// Standard deviation of its error, including that of the model, in the unit.
    pub error: f64,
    /// SI unit.
    pub unit: String,
    /// Effort \[min\].
    pub minutes: f64,
    /// Width of the 90 % interval of the total now, and on average with it \[dB\].
    pub width: [f64; 2],
    /// Largest probability of a source to be first now, and on average with it.
    pub first: [f64; 2],
    /// Decrease of the width per hour of work \[dB/h\].
    pub narrower_an_hour: f64,
    /// Increase of the probability per hour of work \[1/h\].
    pub surer_an_hour: f64,
    /// Whether there are too few draws for it. Its gain is then a lower bound.
    pub is_bound: bool,
}

/// Draws of a calibration whose levels are computed.
pub(super) struct Levelled<'a> {
    pub(super) tool: &'a Tool,
    pub(super) design: &'a Design,
    /// The draws of the keys.
    pub(super) joint: JointDraws,
    /// Points of the rows.
    pub(super) points: Vec<&'a [f64]>,
    /// Minutes that the user states, by name.
    pub(super) effort: &'a BTreeMap<String, f64>,
}

impl Levelled<'_> {
    /// The measurements in the order of the gain per hour of work, from the levels of `count` draws.
    ///
    /// # Errors
    /// The errors of a study.
    pub(super) fn next(
        &self,
        graph: &Graph,
        count: usize,
        seed: u64,
        progress: &Progress,
    ) -> Result<Vec<NextRow>, Error> {
        let drawn = self.design.with_joint_draws(Arc::new(self.joint.clone()));
        let made = draws(graph, &drawn, &Request::new(count, seed), progress)?;
        let row = |candidate: u64| self.joint.row_of(candidate, seed);
        let rows: Vec<usize> = made.draws.iter().map(|own| row(own.candidate)).collect();
        let total = levels_of(&made, TOTAL);
        let sources = made.draws.first().map_or(&[][..], |own| &own.levels.sources);
        let levels: Vec<Vec<f64>> = sources.iter().map(|own| levels_of(&made, &own.source)).collect();
        let loudest = |draw: usize| {
            let order = (0..levels.len()).max_by(|&a, &b| levels[a][draw].total_cmp(&levels[b][draw]));
            order.unwrap_or(0)
        };
        let first: Vec<usize> = (0..made.draws.len()).map(loudest).collect();
        let outputs = Outputs {
            output: &total,
            first: &first,
        };
        let mut found = Vec::new();
        let minutes = |name: &str, usual: f64| self.effort.get(name).copied().unwrap_or(usual);
        let sound = Candidate {
            minutes: minutes(LEVEL_EFFORT, LEVEL_MINUTES),
            ..level(&total)
        };
        found.extend(sound.row(outputs, seed));
        progress.stage("shots that could be measured");
        let ambient = self.design.ambient.pressure;
        let usual = match &self.tool.assembly {
            Some(assembly) => of_assembly(assembly),
            None => USUAL.to_vec(),
        };
        for share in PRESSURES {
            let gauge = share * (self.design.supply.pressure - ambient);
            let shots = self.shots(ambient + gauge, &rows);
            let condition = format!("{:.0} psig", gauge / PSI);
            for usual in &usual {
                if share != 1.0 && !usual.is_depth() {
                    continue;
                }
                let end = self.design.analysis.cycle_end;
                let predict = |shot: &Option<Shot>| {
                    let predicted = shot
                        .as_ref()
                        .map(|own| usual.quantity.predict(own, &self.design.ambient, end));
                    predicted.map_or(f64::NAN, |own| own.value())
                };
                let predictions: Vec<f64> = shots.iter().map(predict).collect();
                let middle = median(&predictions);
                let [reading, scatter, model] = [
                    usual.error.at(middle),
                    usual.quantity.scatter(middle),
                    usual.quantity.discrepancy(middle),
                ];
                let candidate = Candidate {
                    name: usual.name.clone().into_owned(),
                    condition: condition.clone(),
                    unit: usual.quantity.dimension().unit(),
                    minutes: minutes(usual.quantity.name(), usual.minutes),
                    predictions,
                    scale: ((reading * reading + scatter * scatter) / SHOTS + model * model).sqrt(),
                };
                found.extend(candidate.row(outputs, seed));
            }
        }
        for variable in 0..self.tool.keys() {
            let name = self.tool.name(variable);
            let unit = self.tool.sampler.variables()[variable].unit();
            let predictions = rows.iter().map(|&row| self.joint.rows[row][variable]).collect();
            let candidate = of_part(self.design, name, unit, predictions).map(|own| Candidate {
                minutes: minutes(DIRECT_EFFORT, DIRECT_MINUTES),
                ..own
            });
            found.extend(candidate.and_then(|own| own.row(outputs, seed)));
        }
        found.sort_by(|a, b| b.narrower_an_hour.total_cmp(&a.narrower_an_hour));
        Ok(found)
    }

    /// Shots of rows at a pressure of the supply \[Pa\].
    fn shots(&self, pressure: f64, rows: &[usize]) -> Vec<Option<Shot>> {
        let of = |&row: &usize| {
            let mut own = self.tool.design(self.design, self.points[row])?;
            own.set(&[("supply.pressure", Value::Number(pressure))]).ok()?;
            Shot::of(&own, own.analysis.cycle_end, false).ok()
        };
        rows.par_iter().map(of).collect()
    }
}

/// The measurements that the draws of a known study can weigh, in the order of the gain per hour of work: the level at
/// a microphone, and keys of parts. Empty without a study.
///
/// # Errors
/// If a design cannot be digested, or a provided study does not follow its layout.
pub fn next_of_study(store: &Store, design: &Design) -> Result<Vec<NextRow>, Error> {
    /// Seed of the readings.
    const SEED: u64 = 1;
    let Some(draws) = DrawsAtHand::of(store, design)? else {
        return Ok(Vec::new());
    };
    let loudest = |draw: usize| {
        let order =
            (0..draws.sources.len()).max_by(|&a, &b| draws.sources[a].1[draw].total_cmp(&draws.sources[b].1[draw]));
        order.unwrap_or(0)
    };
    let first: Vec<usize> = (0..draws.total.len()).map(loudest).collect();
    let outputs = Outputs {
        output: &draws.total,
        first: &first,
    };
    let mut parts: Vec<(f64, Candidate)> = draws
        .keys
        .iter()
        .filter_map(|own| {
            let candidate = of_part(design, &own.name, &own.unit, own.values.clone())?;
            Some((rank_correlation(&own.values, &draws.total).abs(), candidate))
        })
        .collect();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let parts = parts.into_iter().take(KEYS_OF_STUDY).map(|(_, own)| own);
    let candidates: Vec<Candidate> = parts.chain([level(&draws.total)]).collect();
    let rows = candidates.into_par_iter().filter_map(|own| own.row(outputs, SEED));
    let mut rows: Vec<NextRow> = rows.collect();
    rows.sort_by(|a, b| b.narrower_an_hour.total_cmp(&a.narrower_an_hour));
    Ok(rows)
}

/// The level of all sources at one microphone: its difference from the sound power level is known to within the model's
/// error.
fn level(total: &[f64]) -> Candidate {
    let sound = LevelQuantity::Sound {
        source: None,
        position: Position::Microphone(0),
        band: None,
    };
    let shots = LEVEL_ERROR.hypot(sound.scatter()) / SHOTS.sqrt();
    Candidate {
        name: LEVEL.to_owned(),
        condition: String::new(),
        unit: "dB".to_owned(),
        minutes: LEVEL_MINUTES,
        predictions: total.to_vec(),
        scale: shots.hypot(sound.discrepancy()),
    }
}

/// A key of a part of a design's tool; none if it cannot be measured on the part. The numbers and keys of an assembly
/// belong to parts.
fn of_part(design: &Design, name: &str, unit: &str, predictions: Vec<f64>) -> Option<Candidate> {
    let is_own = |own: &AssemblyText| name.starts_with(OF_ASSEMBLY) || own.declared().contains_key(name);
    let is_part = PARTS.iter().any(|part| name.starts_with(part)) || design.assembly().is_some_and(is_own);
    if !is_part || !MEASURABLE.contains(&unit) {
        return None;
    }
    let scale = match unit {
        "m" => DIRECT_LENGTH,
        _ => DIRECT_SHARE * median(&predictions).abs(),
    };
    Some(Candidate {
        name: name.to_owned(),
        condition: String::new(),
        unit: unit.to_owned(),
        minutes: DIRECT_MINUTES,
        predictions,
        scale,
    })
}

/// A measurement that is weighed.
struct Candidate {
    name: String,
    condition: String,
    unit: String,
    minutes: f64,
    predictions: Vec<f64>,
    scale: f64,
}

impl Candidate {
    fn row(self, outputs: Outputs<'_>, seed: u64) -> Option<NextRow> {
        if self.scale.is_nan() || self.scale <= 0.0 {
            return None;
        }
        let further = Further {
            predictions: &self.predictions,
            scale: self.scale,
            law: ErrorLaw::Student,
        };
        let gain = gain(further, outputs, seed)?;
        let hours = self.minutes / 60.0;
        Some(NextRow {
            measurement: self.name,
            condition: self.condition,
            error: self.scale,
            unit: self.unit,
            minutes: self.minutes,
            width: gain.width,
            first: gain.first,
            narrower_an_hour: (gain.width[0] - gain.width[1]) / hours,
            surer_an_hour: (gain.first[1] - gain.first[0]) / hours,
            is_bound: gain.is_bound,
        })
    }
}

/// Median of the finite values.
fn median(values: &[f64]) -> f64 {
    let mut finite: Vec<f64> = values.iter().copied().filter(|own| own.is_finite()).collect();
    quantile_of(&mut finite, 0.5)
}

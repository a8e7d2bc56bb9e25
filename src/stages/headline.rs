//! Headline of a shot that does not end as it should: the outcome, the figure by which it misses, and the inputs that
//! would change it most. Reports, tables, pages and Python all show this text before the levels.

use nailnoise_dynamics::{Outcome, Parameters, simulate};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cycle::{Cycle, NailerShot};
use super::{Code, Postcard, Progress, Stage, code};
use crate::error::Error;

/// Maximum number of inputs named.
const NAMED: usize = 3;

/// Fraction of the figure by which an input must change it to be named.
const NOTABLE: f64 = 0.01;

/// Headline of a shot that does not drive its nail and open its exhaust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Headline {
    /// Name of the outcome, such as `underdriven`.
    pub outcome: String,
    /// The outcome with its figures, in a sentence.
    pub text: String,
    /// Whether the exhaust opens; if not, the level of the exhaust is that of the trigger vent.
    pub exhaust_opens: bool,
    /// The figure by which the shot misses: a length, speed or pressure; smaller is better.
    pub figure: Figure,
    /// At most three inputs that improve the figure most, changed one at a time within their ranges.
    pub inputs: Vec<Influence>,
}

/// A figure of the shot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figure {
    /// Its name.
    pub name: String,
    /// Its value in the SI unit.
    pub value: f64,
    /// The SI unit.
    pub unit: String,
}

/// An input at an end of its range at which the shot misses by less.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Influence {
    /// The key.
    pub key: String,
    /// Its value in the design, with a readable unit.
    pub from: String,
    /// Its value at that end of its range, with a readable unit.
    pub to: String,
    /// Name of the outcome there.
    pub outcome: String,
    /// The figure there, in its SI unit.
    pub figure: f64,
}

/// Quantities by which a shot can miss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Miss {
    /// Length of the nail above the surface.
    Protrusion,
    /// Depth of the head below the surface.
    HeadDepth,
    /// Speed at which the piston meets the bumper.
    BumperSpeed,
    /// Lift of the head valve that is missing for the intake to open.
    Lift,
    /// Rise of the tool that is missing for the trigger valve to be released.
    Rise,
    /// Overpressure above the piston when the record ends.
    PressureLeft,
}

impl Miss {
    /// The quantity for an outcome; `None` if nothing is missed.
    pub(crate) fn of(outcome: Outcome) -> Option<Self> {
        match outcome {
            Outcome::Drives => None,
            Outcome::Underdriven => Some(Self::Protrusion),
            Outcome::Overdriven => Some(Self::HeadDepth),
            Outcome::StrikesBumper => Some(Self::BumperSpeed),
            Outcome::DoesNotOpen => Some(Self::Lift),
            Outcome::DoesNotRelease => Some(Self::Rise),
            Outcome::DoesNotExhaust => Some(Self::PressureLeft),
        }
    }

    /// Whether an input that leads to this outcome helps, which it does not if the shot then misses in another way. A
    /// nail that is driven too deep at the end of a range is driven correctly somewhere inside it.
    fn reaches(self, outcome: Outcome) -> bool {
        let depth = |miss| matches!(miss, Self::Protrusion | Self::HeadDepth);
        Self::of(outcome).is_none_or(|other| other == self || depth(other) && depth(self))
    }

    /// Its name and SI unit.
    fn described(self) -> [&'static str; 2] {
        match self {
            Self::Protrusion => ["protrusion of the nail", "m"],
            Self::HeadDepth => ["depth of the head below the surface", "m"],
            Self::BumperSpeed => ["speed of the piston at the bumper", "m/s"],
            Self::Lift => ["missing lift of the head valve", "m"],
            Self::Rise => ["missing rise of the tool", "m"],
            Self::PressureLeft => ["overpressure left above the piston", "Pa"],
        }
    }

    /// Its value in readable form.
    fn shown(self, value: f64) -> String {
        match self {
            Self::Protrusion if value < 0.0 => format!("its head is {:.1} mm below the surface", -1e3 * value),
            Self::Protrusion => format!("{:.1} mm protrude", 1e3 * value),
            Self::HeadDepth if value < 0.0 => format!("{:.1} mm protrude", -1e3 * value),
            Self::HeadDepth => format!("{:.1} mm deep", 1e3 * value),
            Self::BumperSpeed => format!("{value:.1} m/s"),
            Self::Lift | Self::Rise => format!("{:.2} mm missing", 1e3 * value.max(0.0)),
            Self::PressureLeft => format!("{:.0} kPa left", 1e-3 * value),
        }
    }

    /// Its value in a shot.
    fn value(self, shot: NailerShot<'_>, parameters: &Parameters) -> f64 {
        match self {
            Self::Protrusion => -shot.figures.summary.head_depth,
            Self::HeadDepth => shot.figures.summary.head_depth,
            Self::BumperSpeed => bumper_speed(shot),
            Self::Lift => parameters.head_valve.intake_lap - highest(shot.record.history("valve_lift").iter().copied()),
            Self::Rise => parameters.contacts.guard_travel - rise(shot),
            Self::PressureLeft => pressure_left(shot, parameters),
        }
    }
}

fn highest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// Largest rise of the nose off the wood \[m\].
fn rise(shot: NailerShot<'_>) -> f64 {
    let [wood, nose] = ["workpiece", "tool"].map(|body| shot.record.history(&format!("{body}.position")));
    highest(wood.iter().zip(nose).map(|(wood, nose)| wood - nose))
}

/// Speed of the piston against the tool when it first meets the bumper; 0 if it does not \[m/s\].
fn bumper_speed(shot: NailerShot<'_>) -> f64 {
    let met = shot
        .figures
        .log
        .iter()
        .find(|entry| entry.crossing == nailnoise_dynamics::Crossing::PistonAtBumper && entry.is_rising());
    met.map_or(0.0, |entry| entry.state.piston_velocity)
}

/// P_1 - P_a at the end of the record \[Pa\].
fn pressure_left(shot: NailerShot<'_>, parameters: &Parameters) -> f64 {
    let last = shot.record.history("above_piston.pressure").last().copied();
    last.map_or(0.0, |pressure| pressure - parameters.ambient.pressure)
}

/// The outcome of a shot in a sentence, whether or not the nail is driven.
pub fn sentence(shot: NailerShot<'_>, parameters: &Parameters) -> String {
    let depth = 1e3 * shot.figures.summary.head_depth;
    let head = match depth {
        0.0.. => format!("the head of the nail ends {depth:.1} mm below the surface"),
        _ => format!("{:.1} mm of the nail protrude", -depth),
    };
    let left = format!(
        "{:.0} kPa of overpressure are left above the piston after {:.0} ms",
        1e-3 * pressure_left(shot, parameters),
        1e3 * shot.record.time(shot.record.len().saturating_sub(1))
    );
    let milli = |length: f64| format!("{:.2} mm", 1e3 * length);
    match shot.figures.outcome {
        Outcome::Drives => format!("the nail is driven, its head {depth:.1} mm below the surface"),
        Outcome::Overdriven => format!(
            "the nail is overdriven: its head ends {depth:.1} mm below the surface, where {:.1} mm are allowed; the \
             model of the \
             wood under a head is not valid at this depth",
            1e3 * parameters.nail.overdrive_limit
        ),
        Outcome::StrikesBumper => format!(
            "the piston strikes the bumper at {:.1} m/s before it stops on the wood; {head}",
            bumper_speed(shot)
        ),
        Outcome::Underdriven => format!("the nail is not driven to its length: {head}"),
        Outcome::DoesNotOpen => format!(
            "no shot: the head valve lifts by {} and opens the intake at {}",
            milli(highest(shot.record.history("valve_lift").iter().copied())),
            milli(parameters.head_valve.intake_lap)
        ),
        Outcome::DoesNotRelease => format!(
            "the exhaust does not open: the tool rises by {} and releases the trigger valve at {}, with no \
             `trigger.release_after` \
             within the record; {left}",
            milli(rise(shot)),
            milli(parameters.contacts.guard_travel)
        ),
        Outcome::DoesNotExhaust => format!("the exhaust does not open before the record ends; {left}"),
    }
}

impl Headline {
    /// The headline of a shot without the inputs that change it; `None` if the nail is driven and the exhaust opens.
    pub fn of(shot: NailerShot<'_>, parameters: &Parameters) -> Option<Self> {
        let miss = Miss::of(shot.figures.outcome)?;
        let exhaust_opens = shot.figures.events.t13.is_some();
        let mut text = sentence(shot, parameters);
        let said = matches!(
            shot.figures.outcome,
            Outcome::DoesNotOpen | Outcome::DoesNotRelease | Outcome::DoesNotExhaust
        );
        if !exhaust_opens && !said {
            text.push_str(&format!(
                "; the exhaust does not open, and {:.0} kPa of overpressure are left above the piston",
                1e-3 * pressure_left(shot, parameters)
            ));
        }
        if !exhaust_opens {
            text.push_str("; the level of the exhaust is that of the trigger vent");
        }
        let [name, unit] = miss.described().map(str::to_owned);
        Some(Self {
            outcome: shot.figures.outcome.name().to_owned(),
            text,
            exhaust_opens,
            figure: Figure {
                name,
                value: miss.value(shot, parameters),
                unit,
            },
            inputs: Vec::new(),
        })
    }

    /// The headline of a finished result without one, from an earlier version of the program.
    pub fn of_finished(outcome: &str, head_depth: Option<f64>, exhaust_opens: bool) -> Option<Self> {
        let found = Outcome::ALL.into_iter().find(|own| own.name() == outcome)?;
        Miss::of(found)?;
        let depth = head_depth.unwrap_or(0.0);
        let [name, unit] = Miss::HeadDepth.described().map(str::to_owned);
        Some(Self {
            outcome: outcome.to_owned(),
            text: format!(
                "the shot {}: the head of the nail ends {:.1} mm {} the surface",
                match found {
                    Outcome::Overdriven | Outcome::Underdriven => format!("is {outcome}"),
                    _ => outcome.replace('_', " "),
                },
                1e3 * depth.abs(),
                if depth < 0.0 { "above" } else { "below" }
            ),
            exhaust_opens,
            figure: Figure {
                name,
                value: depth,
                unit,
            },
            inputs: Vec::new(),
        })
    }

    /// Text about the inputs that would change it most; `None` if unknown.
    pub fn advice(&self) -> Option<String> {
        if self.inputs.is_empty() {
            return None;
        }
        let miss = Outcome::ALL.into_iter().find(|own| own.name() == self.outcome);
        let miss = miss.and_then(Miss::of);
        let input = |own: &Influence| {
            let there = match own.outcome.as_str() {
                "drives" => "drives".to_owned(),
                other => {
                    let figure = miss.map_or_else(String::new, |miss| format!(", {}", miss.shown(own.figure)));
                    format!("{}{figure}", other.replace('_', " "))
                }
            };
            format!("`{}` {} -> {} ({there})", own.key, own.from, own.to)
        };
        let inputs: Vec<String> = self.inputs.iter().map(input).collect();
        Some(format!(
            "inputs that would change it most, each over its range: {}",
            inputs.join("; ")
        ))
    }

    /// The sentence and the inputs, one line each.
    pub fn lines(&self) -> Vec<String> {
        std::iter::once(self.text.clone()).chain(self.advice()).collect()
    }
}

/// Largest number of shots whose ends are named one by one; of more, the ends are counted.
const LISTED: usize = 4;

/// Reason why levels of shots with different outcomes must not be compared; `ends` are their names and headlines.
pub fn unlike<'a>(ends: impl IntoIterator<Item = (&'a str, Option<&'a Headline>)>) -> Option<String> {
    let ends: Vec<(&str, Option<&Headline>)> = ends.into_iter().collect();
    let kind = |end: Option<&Headline>| end.map(|own| (own.outcome.clone(), own.exhaust_opens));
    let (_, first) = *ends.first()?;
    if ends.iter().all(|(_, end)| kind(*end) == kind(first)) {
        return None;
    }
    let word = |own: &Headline| match (own.outcome.as_str(), own.exhaust_opens) {
        (outcome @ ("overdriven" | "underdriven"), false) => format!("is {outcome} and does not exhaust"),
        (outcome @ ("overdriven" | "underdriven"), true) => format!("is {outcome}"),
        (outcome, _) => outcome.replace('_', " "),
    };
    let ended = |end: &Option<&Headline>| end.map_or_else(|| "drives".to_owned(), word);
    let said: Vec<String> = if ends.len() <= LISTED {
        ends.iter()
            .map(|(name, end)| format!("{name} {}", ended(end)))
            .collect()
    } else {
        let mut counts: Vec<(String, usize)> = Vec::new();
        for word in ends.iter().map(|(_, end)| ended(end)) {
            match counts.iter_mut().find(|(own, _)| *own == word) {
                Some((_, count)) => *count += 1,
                None => counts.push((word, 1)),
            }
        }
        counts.iter().map(|(word, count)| format!("{word}: {count}")).collect()
    };
    Some(format!(
        "the shots do not end alike ({}): differences of their levels are not the effect of a change on the noise of \
         a driven nail",
        said.join(", ")
    ))
}

/// An input at one end of its range.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Moved {
    /// The key.
    pub(crate) key: String,
    /// Its value in the design and at the end, with readable units.
    pub(crate) shown: [String; 2],
    /// The cycle there.
    pub(crate) cycle: Cycle,
}

/// The figure by which a shot misses, with each input at the ends of its range.
#[derive(Serialize)]
pub(crate) struct Influences {
    /// The figure.
    pub(crate) miss: Miss,
    /// The cycle of the design.
    pub(crate) base: Cycle,
    /// The inputs.
    pub(crate) moved: Vec<Moved>,
}

impl Stage for Influences {
    type Output = Vec<Influence>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "inputs of the outcome";
    const CODE: Code = code![dynamics, stages_cycle, stages_headline];

    fn compute(&self, _: &Progress) -> Result<Vec<Influence>, Error> {
        let figure = |cycle: &Cycle| {
            // A shot that fails yields no figure.
            let record = simulate(&cycle.parameters, &cycle.settings).ok()?;
            Some((
                record.figures.outcome,
                self.miss.value((&record).into(), &cycle.parameters),
            ))
        };
        let Some((_, here)) = figure(&self.base) else {
            return Ok(Vec::new());
        };
        let moved = self.moved.par_iter().map(|own| Some((own, figure(&own.cycle)?)));
        let moved: Vec<_> = moved.collect();
        let moved = moved.into_iter().flatten();
        let better = moved.filter(|(_, (outcome, there))| {
            let gains = here - there > NOTABLE * here.abs().max(f64::MIN_POSITIVE);
            *outcome == Outcome::Drives || gains && self.miss.reaches(*outcome)
        });
        let mut better: Vec<_> = better.collect();
        better.sort_by(|(_, a), (_, b)| {
            let drives = |outcome| outcome == Outcome::Drives;
            drives(b.0).cmp(&drives(a.0)).then(a.1.total_cmp(&b.1))
        });
        let mut named: Vec<Influence> = Vec::new();
        for (own, (outcome, figure)) in better {
            // Both ends of a range may be better.
            if named.len() < NAMED && named.iter().all(|other| other.key != own.key) {
                let [from, to] = own.shown.clone();
                named.push(Influence {
                    key: own.key.clone(),
                    from,
                    to,
                    outcome: outcome.name().to_owned(),
                    figure,
                });
            }
        }
        Ok(named)
    }
}

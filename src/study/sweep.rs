//! Levels over a grid of values.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use nailnoise_dynamics::Outcome;
use serde::Serialize;

use super::draws::common_draws;
use super::jobs::{levels_of_shot, on_threads, reason};
use super::level_table::total_of;
use super::paired::{Change, changes};
use super::request::Request;
use super::variables::without_sensors;
use crate::chain::{self, Chain, Options};
use crate::cost::{self, MemoryLimit};
use crate::design::inputs;
use crate::design::inputs::cycle::parameters;
use crate::design::{Assignment, AssignmentError, Design, DesignError, Problem};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::Performance;
use crate::stages::Progress;
use crate::stages::headline::Headline;
use crate::stages::levels::Levels;
use crate::study::StudyError;

/// Maximum number of points of a grid.
const MOST: usize = 100_000;

/// A key, and the values that a sweep assigns to it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Axis {
    /// Full name of the key.
    pub key: String,
    /// Values as in a design file, but without quotes.
    pub values: Vec<String>,
}

/// A point of the grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweptPoint {
    /// The value of each key, in the order of the axes.
    pub values: Vec<String>,
    /// Its levels; `None` if the values are not a valid design or the shot cannot be computed.
    pub levels: Option<Levels>,
    /// Level of the sum of all sources \[dB re 1 pW s\].
    pub total_db: Option<f64>,
    /// Reserve of the drive, air per shot, and rate, with the lumped workpiece; none without levels.
    pub performance: Option<Performance>,
    /// Headline of its shot, if the shot does not drive.
    pub headline: Option<Headline>,
    /// Reason why levels are missing; empty otherwise.
    pub refused: String,
    /// Folder of its films; `None` if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folder: Option<String>,
    /// Each source, then the total, over common draws of all points, with the change from the first point; `None` if no
    /// draws are requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawn: Option<Vec<Change>>,
}

impl std::str::FromStr for Axis {
    type Err = String;

    /// `KEY=LOW..HIGH:N` with equal steps, `KEY=LOW..HIGH:N:log` with equal ratios, or `KEY=A,B,C`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text
            .split_once('=')
            .ok_or("give KEY=VALUES, as in supply.pressure=80psig..110psig:7")?;
        let key = key.trim().to_owned();
        let values: Vec<String> = match values.split_once("..") {
            Some((low, rest)) => range(low, rest)?,
            None => values.split(',').map(|value| value.trim().to_owned()).collect(),
        };
        if key.is_empty() || values.iter().any(String::is_empty) {
            return Err(format!("`{text}` lacks a key or a value"));
        }
        Ok(Self { key, values })
    }
}

/// The values of a range.
fn range(low: &str, rest: &str) -> Result<Vec<String>, String> {
    let mut parts = rest.split(':');
    let high = parts.next().unwrap_or_default();
    let count = parts.next().and_then(|count| count.trim().parse::<usize>().ok());
    let count = count.filter(|count| (2..=MOST).contains(count));
    let count = count.ok_or("give the number of values behind the range: LOW..HIGH:7, two or more")?;
    let log = match parts.next().map(str::trim) {
        None => false,
        Some("log") => true,
        Some(other) => return Err(format!("`{other}` is not a spacing; `log` is one")),
    };
    let ((from, unit_of_low), (to, unit)) = (number(low)?, number(high)?);
    if !unit_of_low.is_empty() && unit_of_low != unit {
        return Err(format!(
            "both ends of the range need the same unit, not `{unit_of_low}` and `{unit}`"
        ));
    }
    if log && from.min(to) <= 0.0 {
        return Err("a range with equal ratios lies above zero".to_owned());
    }
    let value = |place: usize| {
        let part = place as f64 / (count - 1) as f64;
        let value = if log {
            from * (to / from).powf(part)
        } else {
            from + part * (to - from)
        };
        // Twelve digits remove the rounding errors of the steps.
        let value: f64 = format!("{value:.11e}").parse().unwrap_or(value);
        format!("{value} {unit}").trim().to_owned()
    };
    Ok((0..count).map(value).collect())
}

/// A number and the unit that follows it.
pub(crate) fn number(text: &str) -> Result<(f64, String), String> {
    let text = text.trim();
    let ends = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    let parsed = ends
        .into_iter()
        .find_map(|end| Some((text[..end].trim().parse::<f64>().ok()?, text[end..].trim())));
    let (value, unit) = parsed.ok_or_else(|| format!("`{text}` does not begin with a number"))?;
    Ok((value, unit.to_owned()))
}

/// The grid of all values; the last axis varies fastest.
fn grid(axes: &[Axis]) -> Vec<Vec<String>> {
    axes.iter().fold(vec![Vec::new()], |points, axis| {
        let longer = |point: &Vec<String>| {
            let point = point.clone();
            axis.values
                .iter()
                .map(move |value| [&point[..], std::slice::from_ref(value)].concat())
        };
        points.iter().flat_map(longer).collect()
    })
}

/// Assignments for the values of a point.
fn assignments(axes: &[Axis], values: &[String]) -> Result<Vec<Assignment>, AssignmentError> {
    let pairs = axes.iter().zip(values);
    pairs
        .map(|(axis, value)| format!("{}={value}", axis.key).parse())
        .collect()
}

/// The design in a file with changes common to all points, at a point of the grid.
///
/// # Errors
/// If values are impossible in any design, or conflict.
pub fn at_point((path, changes): (&Path, &[Assignment]), axes: &[Axis], values: &[String]) -> Result<Design, Error> {
    let own = assignments(axes, values).map_err(|error| StudyError::NoAxis { error })?;
    Ok(Design::load_with(path, &[changes, &own].concat())?)
}

/// Checks that the axes form a grid.
///
/// # Errors
/// [`StudyError::NothingToVary`], and [`StudyError::VariedTwice`]: the later values of a key would replace the earlier
/// ones in every point.
pub fn distinct(axes: &[Axis]) -> Result<(), Error> {
    if axes.is_empty() {
        return Err(StudyError::NothingToVary.into());
    }
    let twice = (1..axes.len()).find(|&place| axes[..place].iter().any(|before| before.key == axes[place].key));
    twice.map_or(Ok(()), |place| {
        let key = axes[place].key.clone();
        Err(StudyError::VariedTwice { key }.into())
    })
}

/// Levels of the design in a file, with changes common to all points, over a grid of values; with a `request`, also
/// over common draws of all points. Points with conflicting values are rejected with their conflict.
///
/// # Errors
/// A key or value that no design can have. No key, or the same key twice. A point that needs more memory than allowed.
/// A grid with too many points.
pub fn sweep(
    graph: &Graph,
    (path, changes): (&Path, &[Assignment]),
    axes: &[Axis],
    request: Option<&Request>,
    memory: MemoryLimit,
    progress: &Progress,
) -> Result<Vec<SweptPoint>, Error> {
    distinct(axes)?;
    let count = axes
        .iter()
        .map(|axis| axis.values.len())
        .try_fold(1_usize, usize::checked_mul);
    if count.is_none_or(|count| count > MOST) {
        return Err(StudyError::SweptTooMuch { most: MOST }.into());
    }
    let points = grid(axes);
    let mut designs = Vec::with_capacity(points.len());
    for values in &points {
        designs.push(match at_point((path, changes), axes, values) {
            Ok(design) => {
                cost::refuse(&design, &cost::of_run(&design)?, memory)?;
                Ok(without_sensors(&design))
            }
            Err(Error::Design(DesignError {
                problem: Problem::Conflict { conflict, .. },
                ..
            })) => Err(conflict.to_string()),
            Err(error) => return Err(error),
        });
    }
    // Structures stay in memory while the points that share them are computed.
    let anchor = designs.iter().find_map(|design| design.as_ref().ok());
    let anchor = anchor
        .map(|design| Chain::new(graph, design, Options::default()))
        .transpose()?;
    let done = AtomicUsize::new(0);
    let results = on_threads(points.len(), |place| {
        let design = designs[place].as_ref().ok();
        let computed = design.map(|design| levels_of_shot(Chain::new(graph, design, Options::default())));
        progress.done(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, points.len() as u64);
        computed
    });
    drop(anchor);
    let mut drawn = match request {
        None => vec![None; points.len()],
        Some(request) => drawn(graph, &designs, request, progress)?,
    }
    .into_iter();
    let failures: Vec<&Error> = results
        .iter()
        .flatten()
        .filter_map(|result| result.as_ref().err())
        .collect();
    let computed = designs.iter().zip(&results).map(|both| match both {
        (Err(conflict), _) => (None, conflict.clone()),
        (_, Some(Err(error))) => (None, reason(error, failures.iter().copied())),
        (_, result) => {
            let levels = result.as_ref().and_then(|levels| levels.as_ref().ok());
            (levels.cloned(), String::new())
        }
    });
    let shot = |(design, (levels, _)): (&Result<Design, String>, &(Option<Levels>, String))| match (design, levels) {
        (Ok(design), Some(levels)) => shot(design, levels).map(Some),
        _ => Ok(None),
    };
    let computed: Vec<_> = computed.collect();
    let shots = designs.iter().zip(&computed).map(shot);
    let mut shots = shots.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten();
    let point = |(values, (levels, refused)): (Vec<String>, (Option<Levels>, String))| {
        let shot = levels.as_ref().and_then(|_| shots.next());
        SweptPoint {
            values,
            performance: shot.as_ref().and_then(|shot| shot.performance),
            headline: shot.and_then(|shot| shot.headline),
            total_db: levels.as_ref().and_then(total_of),
            levels,
            refused,
            folder: None,
            drawn: drawn.next().flatten(),
        }
    };
    Ok(points.into_iter().zip(computed).map(point).collect())
}

/// A design's shot with its lumped workpiece.
#[derive(Default)]
struct Shot {
    performance: Option<Performance>,
    headline: Option<Headline>,
}

/// The shot of a design with these levels; a headline only if the tool of the keys does not drive with the coupling of
/// the design.
fn shot(design: &Design, levels: &Levels) -> Result<Shot, Error> {
    if let Some(cycle) = inputs::assembly::cycle(design)? {
        let record = cycle.record()?;
        return Ok(Shot {
            performance: Some(Performance::of_assembly(&record, &cycle.assembly, &design.ambient)),
            headline: None,
        });
    }
    let (record, parameters) = (chain::cycle(design)?, parameters(design)?);
    let missed = levels.outcome != Outcome::Drives.name();
    Ok(Shot {
        performance: Some(Performance::of(&record.figures, &parameters)),
        headline: missed.then(|| Headline::of((&record).into(), &parameters)).flatten(),
    })
}

/// Levels over common draws of each point that is a valid design, with the change from the first of them.
fn drawn(
    graph: &Graph,
    designs: &[Result<Design, String>],
    request: &Request,
    progress: &Progress,
) -> Result<Vec<Option<Vec<Change>>>, Error> {
    let own: Vec<&Design> = designs.iter().filter_map(|design| design.as_ref().ok()).collect();
    let made = common_draws(graph, &own, request, progress)?;
    let mut of_points = made.iter().map(|own| changes(&made[0], own));
    let point = |design: &Result<Design, String>| design.as_ref().ok().and_then(|_| of_points.next());
    Ok(designs.iter().map(point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        text.parse::<Axis>().map(|axis| axis.values).unwrap_or_default()
    }

    #[test]
    fn ranges_have_equal_steps_or_ratios_and_keep_the_unit() {
        assert_eq!(
            values("supply.pressure=80psig..110psig:4"),
            ["80 psig", "90 psig", "100 psig", "110 psig"]
        );
        assert_eq!(
            values("wood.density=400..480 kg/m3:3"),
            ["400 kg/m3", "440 kg/m3", "480 kg/m3"]
        );
        assert_eq!(values("a.b=1..100:3:log"), ["1", "10", "100"]);
        assert_eq!(values("exhaust.holes=3, 5,12"), ["3", "5", "12"]);
    }

    #[test]
    fn what_is_no_axis_is_refused() {
        for text in [
            "a.b",
            "a.b=",
            "=1",
            "a.b=1..2",
            "a.b=1..2:1",
            "a.b=1 m..2 s:3",
            "a.b=0..2:3:log",
            "a.b=x..2:3",
            "a.b=1..2:3:cubic",
        ] {
            assert!(text.parse::<Axis>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_last_axis_is_the_fastest() {
        let axes = ["a=1,2", "b=x,y"].map(|text| text.parse::<Axis>().unwrap_or_else(|error| panic!("{error}")));
        assert_eq!(grid(&axes), [["1", "x"], ["1", "y"], ["2", "x"], ["2", "y"]]);
    }
}

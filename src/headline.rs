//! The headline of a design's shot, with the inputs that affect it most.

use std::path::Path;

use nailnoise_dynamics::Settings;

use crate::chain;
use crate::design::inputs::cycle::{cycle_settings, parameters};
use crate::design::{Assignment, Design, Value};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::cycle::{Cycle, NailerShot};
pub use crate::stages::headline::{Figure, Headline, Influence, sentence, unlike};
use crate::stages::headline::{Influences, Miss, Moved};
use crate::study::{Axis, Parameter, SweptPoint, at_point, taking_part};
use crate::wording::in_one_unit;

/// Sampling interval of cycles with other inputs \[s\]; the slow motion of the tool does not need a finer one.
const SAMPLES: f64 = 50e-6;

/// The headline of the shot of the design itself; `None` for an assembly, because a headline states how the tool of the
/// keys drove a nail.
///
/// # Errors
/// The errors of the cycle and of its parameters.
pub(crate) fn headline_of(graph: &Graph, design: &Design) -> Result<Option<Headline>, Error> {
    match design.assembly() {
        None => headline(graph, design, (&chain::cycle(design)?).into()),
        Some(_) => Ok(None),
    }
}

/// The headline of a shot of a design; `None` if the nail is driven and the exhaust opens.
///
/// Each input of the cycle that has a range is set to both ends of it, with a lumped workpiece regardless of the
/// coupling of the design. These cycles are computed only for a headline, and cached.
///
/// # Errors
/// The errors of the cycle's parameters.
pub fn headline(graph: &Graph, design: &Design, shot: NailerShot<'_>) -> Result<Option<Headline>, Error> {
    let own = parameters(design)?;
    let Some((mut headline, miss)) = Headline::of(shot, &own).zip(Miss::of(shot.figures.outcome)) else {
        return Ok(None);
    };
    let settings = Settings {
        sample_interval: SAMPLES,
        ..cycle_settings(design)
    };
    let cycle = |parameters| Cycle {
        parameters,
        settings: settings.clone(),
    };
    let mut moved = Vec::new();
    for input in taking_part(design)? {
        for end in input.range.into_iter().filter(|end| *end != input.number()) {
            let mut other = design.clone();
            let value = input.hold(end);
            let set = other.set(&[(input.key.as_str(), value.clone())]);
            let Some(parameters) = set
                .ok()
                .filter(|()| other.conflict().is_none())
                .and(parameters(&other).ok())
            else {
                continue;
            };
            moved.push(Moved {
                key: input.key.clone(),
                shown: shown(design, &input, value),
                cycle: cycle(parameters),
            });
        }
    }
    let base = cycle(own);
    headline.inputs = (*graph.get(Influences { miss, base, moved })?).clone();
    Ok(Some(headline))
}

/// The value of an input and another one, quantities in one readable unit with four digits.
fn shown(design: &Design, input: &Parameter, value: Value) -> [String; 2] {
    match (&input.value, &value) {
        (Value::Number(own), Value::Number(other)) => {
            let (values, unit) = in_one_unit(&input.unit, [*own, *other]);
            values.map(|value| format!("{value} {unit}").trim_end().to_owned())
        }
        _ => [input.value.clone(), value].map(|value| design.value_in_words(&input.key, value)),
    }
}

/// Adds the most influential inputs to the first headline of a sweep.
///
/// # Errors
/// The errors of the design of that point and of its cycle.
pub fn explain_first(
    graph: &Graph,
    base: (&Path, &[Assignment]),
    axes: &[Axis],
    points: &mut [SweptPoint],
) -> Result<(), Error> {
    if let Some(point) = points.iter_mut().find(|point| point.headline.is_some()) {
        let design = at_point(base, axes, &point.values)?;
        point.headline = headline(graph, &design, (&chain::cycle(&design)?).into())?.or(point.headline.take());
    }
    Ok(())
}

/// Lines printed above the levels of a sweep: that the shots do not have the same outcome, and the outcome of the first
/// that does not drive.
pub fn alarms(points: &[SweptPoint]) -> Vec<String> {
    let computed: Vec<&SweptPoint> = points.iter().filter(|point| point.levels.is_some()).collect();
    let name = |point: &SweptPoint| point.values.join(", ");
    let names: Vec<String> = computed.iter().map(|point| name(point)).collect();
    let ends = names.iter().zip(&computed);
    let unlike = unlike(ends.map(|(name, point)| (name.as_str(), point.headline.as_ref())));
    let first = computed
        .iter()
        .find_map(|point| Some((name(point), point.headline.as_ref()?)));
    let first = first.into_iter().flat_map(|(name, headline)| {
        let lines = headline.lines().into_iter();
        lines.map(move |line| format!("{name}: {line}"))
    });
    unlike.into_iter().chain(first).collect()
}

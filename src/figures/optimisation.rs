//! Charts of an optimisation: its course, the front, and the objective over each variable.

use super::chart::{Axis, Chart, Panel, Series, Shape};
use super::palette::{BLACK, GREY};
use crate::optimisation::{Domain, Objective, Optimisation, Trial, is_level};
use crate::study::number_and_unit;
use crate::wording::readable;

/// Index in the palette of designs that meet the constraints.
const FEASIBLE: usize = 0;

/// Index in the palette of the best designs.
const BEST: usize = 1;

/// Charts of the designs that were tried.
pub fn optimisation(found: &Optimisation) -> Vec<Chart> {
    let subject = format!("{}: {} designs with levels", found.design.name, found.with_levels());
    let chart = |name: &str, title, caption: String, panels| Chart {
        name: name.to_owned(),
        title,
        subject: subject.clone(),
        caption,
        panels,
        events: Vec::new(),
    };
    let mut charts = Vec::new();
    let Some(first) = found.objectives.first() else {
        return charts;
    };
    if let [_, second, ..] = found.objectives.as_slice() {
        let caption = "Each point is a design. No other design that meets the constraints betters one of the front in \
                       both.";
        charts.push(chart(
            "front",
            "Front",
            caption.to_owned(),
            vec![front(found, first, second)],
        ));
    }
    let caption = "Each point is a design, in the order in which they were tried; the line is the best so far.";
    charts.push(chart(
        "course",
        "Course",
        caption.to_owned(),
        vec![course(found, first)],
    ));
    let panels = (0..found.variables.len()).map(|place| over(found, first, place));
    let caption = "The same designs over each key that was varied.";
    charts.push(chart(
        "variables",
        "Over the variables",
        caption.to_owned(),
        panels.collect(),
    ));
    charts
}

/// Value of an objective in the unit of its axis.
fn value(objective: &Objective, trial: &Trial) -> Option<f64> {
    let value = trial.shot.as_ref()?.figure(&objective.figure)?;
    Some(match is_level(&objective.figure) {
        true => value,
        false => readable(crate::wording::unit_of_figure(&objective.figure)).1 * value,
    })
}

fn axis(objective: &Objective, series: &[Series], ordinates: bool) -> Axis {
    let unit = match is_level(&objective.figure) {
        true => "dB",
        false => readable(crate::wording::unit_of_figure(&objective.figure)).0,
    };
    let label = match is_level(&objective.figure) {
        true => format!("{}, L_{{WA,1s}}", objective.figure),
        false => objective.figure.replace('_', " "),
    };
    let values = series
        .iter()
        .flat_map(|own| if ordinates { &own.y } else { &own.x })
        .copied();
    Axis::holding(label, unit, values)
}

/// Candidates with levels, each with its number, starting at 1.
fn computed(found: &Optimisation) -> impl Iterator<Item = (usize, &Trial)> {
    let all = found.trials.iter().enumerate();
    all.filter(|(_, own)| own.shot.as_ref().is_some_and(|shot| shot.levels.is_some()))
}

/// Text with the values of the variables, shown under the pointer.
fn note(found: &Optimisation, place: usize, trial: &Trial) -> String {
    let values = found.variables.iter().zip(&trial.values);
    let values: Vec<String> = values.map(|(own, value)| format!("{} {value}", own.key)).collect();
    format!("candidate {}: {}", place + 1, values.join(", "))
}

/// Points of the designs in groups: best, feasible, infeasible.
fn points(found: &Optimisation, at: &dyn Fn(usize, &Trial) -> Option<[f64; 2]>) -> Vec<Series> {
    let kinds = [
        ("best", BEST),
        ("meets the constraints", FEASIBLE),
        ("breaks a constraint", GREY),
    ];
    let kind = |place: usize, trial: &Trial| match (found.front.contains(&place), trial.feasible) {
        (true, _) => BEST,
        (_, true) => FEASIBLE,
        _ => GREY,
    };
    let series = kinds.into_iter().map(|(name, colour)| {
        let own = computed(found).filter(|(place, trial)| kind(*place, trial) == colour);
        let mut own: Vec<([f64; 2], String)> = own
            .filter_map(|(place, trial)| Some((at(place, trial)?, note(found, place, trial))))
            .collect();
        // Abscissas are ascending.
        own.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        Series {
            x: own.iter().map(|(point, _)| point[0]).collect(),
            y: own.iter().map(|(point, _)| point[1]).collect(),
            notes: own.into_iter().map(|(_, note)| note).collect(),
            ..Series::over(name, colour, Shape::Points, [])
        }
    });
    series.filter(|own| !own.x.is_empty()).collect()
}

fn course(found: &Optimisation, objective: &Objective) -> Panel {
    let order: Vec<usize> = computed(found).map(|(place, _)| place).collect();
    let number = |place: usize| {
        order
            .iter()
            .position(|own| *own == place)
            .map(|number| (number + 1) as f64)
    };
    let mut series = points(found, &|place, trial| Some([number(place)?, value(objective, trial)?]));
    let mut best: Option<f64> = None;
    let better = |a: f64, b: f64| if objective.maximised { a.max(b) } else { a.min(b) };
    let so_far = computed(found).map(|(_, trial)| {
        let own = value(objective, trial).filter(|_| trial.feasible);
        best = own.map(|own| best.map_or(own, |best| better(best, own))).or(best);
        best
    });
    let mut line = Series::over("best so far", BEST, Shape::Line, so_far.collect::<Vec<_>>());
    line.x.iter_mut().for_each(|x| *x += 1.0);
    series.push(line);
    let x = Axis::new("Design with levels", "", [0.0, order.len().max(1) as f64 + 1.0]);
    if let Some(start) = value(objective, &found.start) {
        series.push(Series::rule("the design itself", &x, start));
    }
    Panel {
        y: axis(objective, &series, true),
        x,
        height: 70,
        series,
    }
}

fn front(found: &Optimisation, first: &Objective, second: &Objective) -> Panel {
    let at = |trial: &Trial| Some([value(first, trial)?, value(second, trial)?]);
    let mut series = points(found, &|_, trial| at(trial));
    let line: Vec<[f64; 2]> = found.best().filter_map(at).collect();
    let single = |name: &str, colour, shape, points: &[[f64; 2]]| Series {
        x: points.iter().map(|point| point[0]).collect(),
        y: points.iter().map(|point| point[1]).collect(),
        ..Series::over(name, colour, shape, [])
    };
    series.push(single("", BEST, Shape::Line, &line));
    if let Some(start) = at(&found.start) {
        series.insert(0, single("the design itself", BLACK, Shape::Points, &[start]));
    }
    Panel {
        x: axis(first, &series, false),
        y: axis(second, &series, true),
        height: 90,
        series,
    }
}

fn over(found: &Optimisation, objective: &Objective, place: usize) -> Panel {
    let variable = &found.variables[place];
    let x = match &variable.domain {
        Domain::Choices(choices) => Axis::categories(&variable.key, "", choices.clone()),
        Domain::Range { low, high, unit, .. } => {
            let label = match unit.as_str() {
                "" => variable.key.clone(),
                unit => format!("{} ({unit})", variable.key),
            };
            Axis::holding(label, "", [*low, *high].into_iter())
        }
    };
    let at = |value: &str| match &variable.domain {
        // At the centre of the category.
        Domain::Choices(choices) => Some(choices.iter().position(|own| own == value)? as f64 + 0.5),
        Domain::Range { .. } => Some(number_and_unit(value).ok()?.0),
    };
    let series = points(found, &|_, trial| {
        Some([at(&trial.values[place])?, value(objective, trial)?])
    });
    Panel {
        x,
        y: axis(objective, &series, true),
        height: 55,
        series,
    }
}

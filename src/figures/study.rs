//! Charts of a study: intervals of levels, probabilities of orders, most influential inputs, convergence.

use super::chart::{Axis, Chart, Panel, Series, Shape};
use super::levels::{SHOWN, in_palette};
use super::palette::BLACK;
use crate::study::{
    Axis as SweepAxis, Change, Contributions, Draws, Estimate, InputChanges, LabelledStudy, OneAtATime, Quantiles,
    StudyResult, SweptPoint, Variable, VariableKind, column, levels_of, number_and_unit, value_at,
};

/// Number of inputs in the chart of level changes, and the smallest change shown \[dB\].
const SWINGS: usize = 10;
const LEAST_SWING: f64 = 0.05;

/// Number of inputs of each output shown as scatter plots.
const SCATTERED: usize = 2;

/// Charts of the results.
pub fn study(result: &StudyResult) -> Vec<Chart> {
    let subject = format!("{}: {} draws", result.design.name, result.draws);
    let chart = |name: &str, title, caption: &str, panels| Chart {
        name: name.to_owned(),
        title,
        subject: subject.clone(),
        caption: caption.to_owned(),
        panels,
        events: Vec::new(),
    };
    let mut charts = vec![chart(
        "study-levels",
        "Level of each source",
        "A-weighted single-event sound power levels, dB re 1 pW s: 90 % of the draws lie in the bar, half below its \
         line; the dot is the design itself.",
        vec![sources(result)],
    )];
    charts.push(chart(
        "study-orders",
        "Order of the sources",
        "Probability of each order of the sources, loudest first.",
        vec![orders(result)],
    ));
    charts.push(chart(
        "study-bands",
        "Level in bands",
        "A-weighted one-third-octave levels, dB re 1 pW s: 90 % of the draws lie in the bar, half below its line.",
        vec![labelled(result, "Mid-band frequency", "Hz", |source| &source.bands)],
    ));
    // A study of few draws has a single point, so that the chart would be empty.
    if result.convergence.len() > 1 {
        charts.push(chart(
            "study-convergence",
            "Convergence",
            "Probability of being the loudest over the first draws, with its 90 % interval.",
            vec![convergence(result)],
        ));
    }
    if let Some(own) = &result.one_at_a_time {
        charts.push(chart(
            "study-one-at-a-time",
            "One input at a time",
            "Change of the level of the design with one input at the 5th (upper bar) and the 95th percentile (lower \
             bar) of its distribution.",
            own.outputs
                .iter()
                .enumerate()
                .filter_map(|(place, name)| swings(own, place, name))
                .collect(),
        ));
    }
    charts
}

/// Changes of a level, largest first; `None` if no input changes it.
fn swings(own: &OneAtATime, output: usize, name: &str) -> Option<Panel> {
    let mut inputs: Vec<&InputChanges> = own
        .inputs
        .iter()
        .filter(|input| input.largest(output) >= LEAST_SWING)
        .collect();
    inputs.sort_by(|a, b| b.largest(output).total_cmp(&a.largest(output)));
    inputs.truncate(SWINGS);
    let widest = inputs.first()?.largest(output);
    let series = |end: usize, name: &str| {
        let changes: Vec<Option<f64>> = inputs.iter().map(|input| input.ends[end].change_db[output]).collect();
        let note = |change: &Option<f64>| change.map_or_else(|| "-".to_owned(), |change| format!("{change:+.1} dB"));
        Series {
            notes: changes.iter().map(note).collect(),
            ..Series::over(name, end, Shape::Swings(vec![0.0; changes.len()]), changes)
        }
        .sideways()
    };
    Some(Panel {
        x: Axis::new(format!("Change of {name}"), "dB", [-1.05 * widest, 1.05 * widest]),
        height: 8 * inputs.len() as u32,
        y: Axis::categories("Input", "", inputs.iter().map(|input| input.variable.clone()).collect()),
        series: vec![series(0, "at P5"), series(1, "at P95")],
    })
}

fn whiskers(name: &str, colour: usize, rows: &[(usize, &Quantiles)]) -> Series {
    let value = |estimate: &Estimate| estimate.value.unwrap_or(f64::NAN);
    let note = |(_, own): &(usize, &Quantiles)| {
        format!(
            "P5 {:.1}, P50 {:.1}, P95 {:.1} dB",
            value(&own.p05),
            value(&own.p50),
            value(&own.p95)
        )
    };
    Series {
        name: name.to_owned(),
        colour,
        shape: Shape::Whiskers(rows.iter().map(|(_, own)| [value(&own.p05), value(&own.p95)]).collect()),
        x: rows.iter().map(|(place, _)| *place as f64).collect(),
        y: rows.iter().map(|(_, own)| value(&own.p50)).collect(),
        notes: rows.iter().map(note).collect(),
    }
}

/// A level axis that shows the upper ends of all bars, and at most `shown` dB below the highest.
fn axis_of_levels(series: &[Series], shown: f64) -> Axis {
    let upper = series.iter().flat_map(|series| match &series.shape {
        Shape::Whiskers(ends) => ends.iter().map(|[_, high]| Some(*high)).collect::<Vec<_>>(),
        _ => series.y.iter().copied().map(Some).collect(),
    });
    Axis::levels("L_{WA,1s}", "dB", shown, &[Series::over("", 0, Shape::Line, upper)])
}

fn sources(result: &StudyResult) -> Panel {
    let names: Vec<String> = result
        .sources
        .iter()
        .map(|own| own.source.clone())
        .chain(["total".to_owned()])
        .collect();
    let own = result
        .sources
        .iter()
        .map(|own| &own.level.level_db)
        .chain([&result.total.level_db]);
    let rows: Vec<(usize, &Quantiles)> = own.enumerate().collect();
    let nominal = result.sources.iter().map(|own| own.level.nominal_db);
    let nominal = nominal.chain([result.total.nominal_db]);
    let design = Series::over("the design itself", 1, Shape::Points, nominal);
    let design = Series {
        // In the middle of each category.
        x: design.x.iter().map(|place| place + 0.46).collect(),
        ..design
    };
    let series = vec![design, whiskers("draws", BLACK, &rows)];
    Panel {
        x: Axis::categories("Source", "", names),
        y: axis_of_levels(&series, 45.0),
        height: 60,
        series,
    }
}

fn orders(result: &StudyResult) -> Panel {
    let names: Vec<String> = result.orders.iter().map(|own| own.order.join(" > ")).collect();
    let share = |own: &Estimate| own.value.map(|value| 100.0 * value);
    let series = Series {
        notes: result
            .orders
            .iter()
            .map(|own| format!("{:.0} %", 100.0 * own.probability.value.unwrap_or(0.0)))
            .collect(),
        ..Series::over(
            "",
            BLACK,
            Shape::Bars(Vec::new()),
            result.orders.iter().map(|own| share(&own.probability)),
        )
    };
    Panel {
        // The probability follows each bar.
        x: Axis::new("Probability", "%", [0.0, 110.0]),
        height: 8 * names.len() as u32,
        y: Axis::categories("Order, loudest first", "", names),
        series: vec![series.sideways()],
    }
}

fn labelled(
    result: &StudyResult,
    x: &str,
    unit: &'static str,
    of: impl Fn(&crate::study::SourceStudy) -> &Vec<LabelledStudy>,
) -> Panel {
    let labels: Vec<String> = result.sources.first().map_or_else(Vec::new, |source| {
        of(source).iter().map(|own| own.label.clone()).collect()
    });
    let series = result.sources.iter().enumerate().map(|(place, source)| {
        let rows: Vec<(usize, &Quantiles)> = of(source)
            .iter()
            .filter_map(|own| Some((labels.iter().position(|label| *label == own.label)?, &own.level_db)))
            .collect();
        whiskers(&source.source, in_palette(&source.source, place), &rows)
    });
    let series: Vec<Series> = series.collect();
    Panel {
        x: Axis::categories(x, unit, labels),
        y: axis_of_levels(&series, SHOWN),
        height: 80,
        series,
    }
}

fn convergence(result: &StudyResult) -> Panel {
    let draws: Vec<f64> = result.convergence.iter().map(|own| own.draws as f64).collect();
    let mut series = Vec::new();
    for (place, source) in result.sources.iter().enumerate() {
        let colour = in_palette(&source.source, place);
        let estimates: Vec<&Estimate> = result
            .convergence
            .iter()
            .filter_map(|own| own.first.get(place))
            .collect();
        let values: Vec<f64> = estimates.iter().map(|own| own.value.unwrap_or(f64::NAN)).collect();
        let end = |end: usize| {
            estimates
                .iter()
                .map(|own| own.interval[end].unwrap_or(f64::NAN))
                .collect::<Vec<_>>()
        };
        series.push(Series::line(&source.source, colour, &draws, &values));
        series.push(Series {
            x: draws.clone(),
            y: end(1),
            ..Series::over("", colour, Shape::Band(end(0)), [])
        });
    }
    Panel {
        x: Axis::new("Draws", "", [0.0, draws.last().copied().unwrap_or(1.0)]),
        y: Axis::new("P(first)", "", [0.0, 1.0]),
        height: 55,
        series,
    }
}

/// Value of a variable in the design, and the level of an output there; none where one of them is not known.
fn nominal(result: &StudyResult, variable: &Variable, output: &str) -> Option<[f64; 2]> {
    let report = result.variables.iter().find(|own| own.name == variable.name)?;
    let level = |name: &str| match name {
        "total" => result.total.nominal_db,
        source => result.source(source)?.level.nominal_db,
    };
    let level = match output.split_once(" less ") {
        Some((a, b)) => level(a)? - level(b)?,
        None => level(output)?,
    };
    Some([value_at(variable, report.nominal_place?)?, level])
}

/// Scatter plots of levels against the inputs that affect them most, one dot per draw: for the total and for the
/// difference of the two loudest sources.
pub fn scatter(result: &StudyResult, made: &Draws) -> Vec<Chart> {
    let of_interest = |own: &&Contributions| own.output == "total" || own.output.contains(" less ");
    let outputs = result.contributions.iter().filter(of_interest);
    let panel = |own: &Contributions, input: &crate::study::Contribution| {
        let variable = made.variables.iter().find(|variable| variable.name == input.variable)?;
        let mut points: Vec<(f64, f64)> = column(made, &input.variable)
            .into_iter()
            .zip(levels_of(made, &own.output))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        let ends = |values: &[f64]| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let margin = 0.03 * (high - low).max(1e-12);
            [low - margin, high + margin]
        };
        let nominal = nominal(result, variable, &own.output);
        let with_nominal = |values: &[f64], own: Option<f64>| values.iter().copied().chain(own).collect::<Vec<_>>();
        let across = ends(&with_nominal(&x, nominal.map(|own| own[0])));
        let up = ends(&with_nominal(&y, nominal.map(|own| own[1])));
        let label = match (&variable.kind, variable.unit()) {
            (VariableKind::Method(_), _) => format!("{}: place in its range", input.variable),
            (_, "") => input.variable.clone(),
            (_, unit) => format!("{} ({unit})", input.variable),
        };
        let dots = Series {
            x,
            y,
            ..Series::over("draws", 0, Shape::Points, [])
        };
        let design = nominal.map(|[x, y]| Series {
            x: vec![x],
            y: vec![y],
            ..Series::over("the design itself", 1, Shape::Points, [])
        });
        Some(Panel {
            x: Axis::new(label, "", across),
            y: Axis::new(own.output.clone(), "dB", up),
            height: 55,
            series: design.into_iter().chain([dots]).collect(),
        })
    };
    let charts = outputs.enumerate().map(|(place, own)| Chart {
        name: format!("study-deciding-{}", place + 1),
        title: "What decides",
        subject: format!("{}: {} draws", result.design.name, result.draws),
        caption: format!(
            "{}: a dot for each draw, over the inputs that decide it most, and one for the design itself.",
            own.output
        ),
        panels: own
            .inputs
            .iter()
            .take(SCATTERED)
            .filter_map(|input| panel(own, input))
            .collect(),
        events: Vec::new(),
    });
    charts.filter(|chart| !chart.panels.is_empty()).collect()
}

/// Levels over the values of the first axis of a sweep, with a line for each source. With more axes, there is one line
/// for each combination of their values, only for the total. Numbers in one unit have a linear axis; over common draws
/// it has bands.
pub fn sweep(design: &str, axes: &[SweepAxis], points: &[SweptPoint]) -> Chart {
    let scale = Scale::of(axes.first());
    let line = |name: &str, colour: usize, of: &dyn Fn(&SweptPoint) -> Option<f64>, others: Option<&[String]>| {
        let own = points
            .iter()
            .filter(|point| others.is_none_or(|others| point.values[1..] == *others));
        scale.series(
            name,
            colour,
            own.filter_map(|point| Some((scale.place(point)?, of(point)?)))
                .collect(),
        )
    };
    let series: Vec<Series> = if axes.len() == 1 {
        let sources = points.iter().find_map(|point| point.levels.as_ref());
        let sources = sources
            .into_iter()
            .flat_map(|levels| levels.sources.iter().map(|own| own.source.clone()));
        let own = sources.enumerate().map(|(index, name)| {
            let level = |point: &SweptPoint| point.levels.as_ref()?.sources.get(index)?.lwa_db;
            line(&name, in_palette(&name, index), &level, None)
        });
        own.chain([line("total", BLACK, &|point| point.total_db, None)])
            .collect()
    } else {
        let mut others: Vec<&[String]> = Vec::new();
        for point in points.iter().filter(|point| point.values.len() > 1) {
            if !others.contains(&&point.values[1..]) {
                others.push(&point.values[1..]);
            }
        }
        let total = |point: &SweptPoint| point.total_db;
        let own = others.iter().enumerate();
        own.map(|(index, others)| line(&others.join(", "), index % BLACK, &total, Some(others)))
            .collect()
    };
    let mut panels = vec![Panel {
        x: scale.axis(),
        y: Axis::levels("L_{WA,1s}", "dB", 45.0, &series),
        height: 80,
        series,
    }];
    // Bars of the total for each of the other values would overlap.
    if axes.len() == 1 && points.iter().any(|point| point.drawn.is_some()) {
        let sources = points.iter().find_map(|point| point.drawn.as_ref());
        let names: Vec<&str> = sources.into_iter().flatten().map(|own| own.source.as_str()).collect();
        let of = |index: usize, name: &str, quantiles: &dyn Fn(&Change) -> Quantiles| {
            let own = points
                .iter()
                .filter_map(|point| Some((scale.place(point)?, quantiles(point.drawn.as_ref()?.get(index)?))));
            let colour = match name {
                "total" => BLACK,
                name => in_palette(name, index),
            };
            scale.intervals(name, colour, own.collect())
        };
        let named = names.iter().enumerate();
        let series: Vec<Series> = named
            .clone()
            .flat_map(|(index, name)| of(index, name, &|own| own.level_db))
            .collect();
        panels.push(Panel {
            x: scale.axis(),
            y: axis_of_levels(&series, SHOWN),
            height: 80,
            series,
        });
        let total = named.filter(|(_, name)| **name == "total");
        let series: Vec<Series> = total
            .flat_map(|(index, _)| of(index, "total", &|own| own.change_db))
            .collect();
        let ends = series
            .iter()
            .flat_map(|own| own.y.iter().chain(lower_ends(own)).copied());
        panels.push(Panel {
            y: Axis::holding("Change from the first point", "dB", ends.chain([0.0])),
            x: scale.axis(),
            height: 60,
            series,
        });
    }
    let over_draws = match panels.len() {
        1 => "",
        _ => " Below: 90 % of the common draws lie in the pale area, half below its line.",
    };
    Chart {
        name: "sweep".to_owned(),
        title: "Sweep",
        subject: design.to_owned(),
        caption: format!("A-weighted single-event sound power levels over the values, dB re 1 pW s.{over_draws}"),
        panels,
        events: Vec::new(),
    }
}

/// The horizontal axis of a sweep.
enum Scale<'a> {
    /// Values one after the other.
    Categories { label: &'a str, names: &'a [String] },
    /// Numbers in one unit.
    Numbers { label: String, values: Vec<f64> },
}

impl<'a> Scale<'a> {
    fn of(axis: Option<&'a SweepAxis>) -> Self {
        let (label, names) = axis.map_or(("", &[][..]), |axis| (axis.key.as_str(), axis.values.as_slice()));
        let numbers = names.iter().map(|name| number_and_unit(name));
        let numbers: Vec<(f64, String)> = numbers.collect::<Result<_, _>>().unwrap_or_default();
        let units = numbers.iter().all(|(_, unit)| *unit == numbers[0].1);
        match numbers.first() {
            Some((_, unit)) if units && numbers.len() > 1 => Self::Numbers {
                label: if unit.is_empty() {
                    label.to_owned()
                } else {
                    format!("{label} ({unit})")
                },
                values: numbers.into_iter().map(|(number, _)| number).collect(),
            },
            _ => Self::Categories { label, names },
        }
    }

    fn axis(&self) -> Axis {
        match self {
            Self::Categories { label, names } => Axis::categories(*label, "", names.to_vec()),
            Self::Numbers { label, values } => Axis::holding(label, "", values.iter().copied()),
        }
    }

    /// Place of a point on the axis.
    fn place(&self, point: &SweptPoint) -> Option<f64> {
        let value = point.values.first()?;
        match self {
            Self::Categories { names, .. } => Some(names.iter().position(|name| name == value)? as f64),
            Self::Numbers { .. } => Some(number_and_unit(value).ok()?.0),
        }
    }

    fn series(&self, name: &str, colour: usize, mut points: Vec<(f64, f64)>) -> Series {
        match self {
            Self::Categories { names, .. } => {
                let of = |place: usize| points.iter().find(|own| own.0 == place as f64).map(|own| own.1);
                Series::over(name, colour, Shape::Steps, (0..names.len()).map(of))
            }
            Self::Numbers { .. } => {
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                Series {
                    x: points.iter().map(|own| own.0).collect(),
                    y: points.iter().map(|own| own.1).collect(),
                    ..Series::over(name, colour, Shape::Line, [])
                }
            }
        }
    }

    /// Medians with the range from P5 to P95.
    fn intervals(&self, name: &str, colour: usize, mut rows: Vec<(f64, Quantiles)>) -> Vec<Series> {
        if let Self::Categories { .. } = self {
            let rows: Vec<(usize, &Quantiles)> = rows.iter().map(|(place, own)| (*place as usize, own)).collect();
            return vec![whiskers(name, colour, &rows)];
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let value = |estimate: &Estimate| estimate.value.unwrap_or(f64::NAN);
        let of = |end: &dyn Fn(&Quantiles) -> f64| rows.iter().map(|(_, own)| end(own)).collect::<Vec<f64>>();
        let x: Vec<f64> = rows.iter().map(|(x, _)| *x).collect();
        let series = |name: &str, shape: Shape, y: Vec<f64>| Series {
            x: x.clone(),
            y,
            ..Series::over(name, colour, shape, [])
        };
        vec![
            series(name, Shape::Line, of(&|own| value(&own.p50))),
            series("", Shape::Band(of(&|own| value(&own.p05))), of(&|own| value(&own.p95))),
        ]
    }
}

/// Lower ends of bars and areas.
fn lower_ends(series: &Series) -> Vec<&f64> {
    match &series.shape {
        Shape::Whiskers(ends) => ends.iter().flatten().collect(),
        Shape::Band(lower) => lower.iter().collect(),
        _ => Vec::new(),
    }
}

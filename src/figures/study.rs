//! Charts of a study: intervals of levels, probabilities of orders, most influential inputs, convergence.

use super::chart::{Axis, Chart, Panel, Series, Shape};
use super::levels::{SHOWN, in_palette};
use super::palette::BLACK;
use crate::study::{
    Axis as SweepAxis, Contributions, Draws, Estimate, InputChanges, LabelledStudy, OneAtATime, Quantiles, StudyResult,
    SweptPoint, VariableKind, column, levels_of,
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
         line.",
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
    charts.push(chart(
        "study-convergence",
        "Convergence",
        "Probability of being the loudest over the first draws, with its 90 % interval.",
        vec![convergence(result)],
    ));
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
        Shape::Whiskers(ends) => ends.iter().map(|[_, high]| Some(*high)).collect(),
        _ => Vec::new(),
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
    let series = vec![whiskers("", BLACK, &rows)];
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
        let (across, up) = (ends(&x), ends(&y));
        let label = match (&variable.kind, variable.unit()) {
            (VariableKind::Method(_), _) => format!("{}: place in its range", input.variable),
            (_, "") => input.variable.clone(),
            (_, unit) => format!("{} ({unit})", input.variable),
        };
        let dots = Series {
            x,
            y,
            ..Series::over("", 0, Shape::Points, [])
        };
        Some(Panel {
            x: Axis::new(label, "", across),
            y: Axis::new(own.output.clone(), "dB", up),
            height: 55,
            series: vec![dots],
        })
    };
    let charts = outputs.enumerate().map(|(place, own)| Chart {
        name: format!("study-deciding-{}", place + 1),
        title: "What decides",
        subject: format!("{}: {} draws", result.design.name, result.draws),
        caption: format!(
            "{}: a dot for each draw, over the inputs that decide it most.",
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
/// for each combination of their values, only for the total.
pub fn sweep(design: &str, axes: &[SweepAxis], points: &[SweptPoint]) -> Chart {
    let names: Vec<String> = axes.first().map_or_else(Vec::new, |axis| axis.values.clone());
    let place = |point: &SweptPoint| names.iter().position(|name| point.values.first() == Some(name));
    let line = |name: &str, colour: usize, of: &dyn Fn(&SweptPoint) -> Option<f64>, others: Option<&[String]>| {
        let mut levels = vec![None; names.len()];
        for point in points
            .iter()
            .filter(|point| others.is_none_or(|others| point.values[1..] == *others))
        {
            if let Some(place) = place(point) {
                levels[place] = of(point);
            }
        }
        Series::over(name, colour, Shape::Steps, levels)
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
        let mut others: Vec<&[String]> = points.iter().map(|point| &point.values[1..]).collect();
        others.sort();
        others.dedup();
        let total = |point: &SweptPoint| point.total_db;
        let own = others.iter().enumerate();
        own.map(|(index, others)| line(&others.join(", "), index % BLACK, &total, Some(others)))
            .collect()
    };
    let across = || Axis::categories(axes.first().map_or("", |axis| axis.key.as_str()), "", names.clone());
    let mut panels = vec![Panel {
        x: across(),
        y: Axis::levels("L_{WA,1s}", "dB", 45.0, &series),
        height: 80,
        series,
    }];
    // Bars of the total for each of the other values would overlap.
    if axes.len() == 1 && points.iter().any(|point| point.drawn.is_some()) {
        let sources = points.iter().find_map(|point| point.drawn.as_ref());
        let sources = sources.into_iter().flatten().enumerate();
        let series = sources.map(|(index, source)| {
            let level = |point: &'_ SweptPoint| Some((place(point)?, point.drawn.as_ref()?.get(index)?.level_db));
            let rows: Vec<(usize, Quantiles)> = points.iter().filter_map(level).collect();
            let rows: Vec<(usize, &Quantiles)> = rows.iter().map(|(place, own)| (*place, own)).collect();
            let colour = match source.source.as_str() {
                "total" => BLACK,
                name => in_palette(name, index),
            };
            whiskers(&source.source, colour, &rows)
        });
        let series: Vec<Series> = series.collect();
        panels.push(Panel {
            x: across(),
            y: axis_of_levels(&series, SHOWN),
            height: 80,
            series,
        });
    }
    let over_draws = match panels.len() {
        1 => "",
        _ => " Below: 90 % of the common draws lie in the bar, half below its line.",
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

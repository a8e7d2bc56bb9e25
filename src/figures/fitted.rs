//! Charts of fitted penetration laws: data with law and band, and residuals against every predictor.

use nailnoise_penetration::fit::{Drive, FittedLaw, Scatter, VARIABLES, Variable};

use super::chart::{Axis, Chart, Panel, Series, Shape};

/// Number of points of a curve.
const POINTS: usize = 200;
/// Maximum number of data points in a figure; above it, every n-th point is drawn.
const MOST_POINTS: usize = 6000;
/// Maximum number of panels in a figure.
const MOST_PANELS: usize = 6;
/// Confidence level of the bands.
const CONFIDENCE: f64 = 0.95;

/// The data of each condition with the law and its band, for conditions spread over the data.
pub fn fit(subject: &str, law: &FittedLaw, drives: &[Drive]) -> Chart {
    let mut groups: Vec<&str> = Vec::new();
    for drive in drives {
        if !groups.contains(&drive.group.as_str()) {
            groups.push(&drive.group);
        }
    }
    let shown = groups.len().min(MOST_PANELS);
    // Spread over the conditions instead of the first ones.
    let chosen = (0..shown).map(|k| groups[k * groups.len() / shown]);
    let panels = chosen.map(|group| panel(group, law, drives)).collect();
    Chart {
        name: "fit".to_owned(),
        title: "Fitted penetration law",
        subject: format!(
            "{subject}, {}",
            match groups.len() {
                1 => "one condition".to_owned(),
                all if all == shown => format!("{all} conditions"),
                all => format!("{shown} of {all} conditions"),
            }
        ),
        caption: "Measured penetration resistance over depth, the fitted law, and its bands.".to_owned(),
        panels,
        events: Vec::new(),
    }
}

fn panel(group: &str, law: &FittedLaw, drives: &[Drive]) -> Panel {
    let own: Vec<&Drive> = drives.iter().filter(|drive| drive.group == group).collect();
    let mut points: Vec<(f64, f64, f64)> = own
        .iter()
        .flat_map(|drive| {
            let scale = drive.conditions.force_scale();
            drive
                .points
                .iter()
                .map(move |p| (p.depth, p.speed, scale * p.root * p.root))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let conditions = own[0].conditions;
    let deepest = points.last().map_or(0.0, |point| point.0);
    // The speed of a projectile at a depth, taken from the nearest measured point.
    let speed = |depth: f64| {
        let right = points.partition_point(|point| point.0 < depth).min(points.len() - 1);
        points[right].1
    };
    let depth = |i: usize| deepest * (i as f64 / POINTS as f64).max(1e-9);
    let curve = |values: Vec<f64>, colour: usize, shape: Shape, name: &str| Series {
        x: (0..=POINTS).map(|i| 1e3 * depth(i)).collect(),
        ..Series::over(name, colour, shape, values.into_iter().map(|force| Some(1e-3 * force)))
    };
    let band = |scatter: Scatter| -> (Vec<f64>, Vec<f64>) {
        (0..=POINTS)
            .map(|i| law.band(&conditions, (depth(i), speed(depth(i))), CONFIDENCE, scatter))
            .map(|[low, high]| (1e-3 * low, high))
            .unzip()
    };
    let forces = (0..=POINTS)
        .map(|i| law.force(&conditions, depth(i), speed(depth(i))))
        .collect();
    let [(law_low, law_high), (shot_low, shot_high)] = [band(Scatter::Law), band(Scatter::Shot)];
    let series = vec![
        curve(forces, 1, Shape::Line, "law"),
        Series {
            x: points.iter().map(|point| 1e3 * point.0).collect(),
            ..Series::over(
                "measured",
                0,
                Shape::Points,
                points.iter().map(|point| Some(1e-3 * point.2)),
            )
        },
        curve(law_high, 6, Shape::Band(law_low), "95 % of the law"),
        curve(shot_high, 1, Shape::Band(shot_low), "95 % of one shot"),
    ];
    Panel {
        x: Axis::new(format!("{group}: depth of the nail's tip"), "mm", [0.0, 1e3 * deepest]),
        y: Axis::around("Resistance", "kN", &series),
        height: 50,
        series,
    }
}

/// Residuals of s against depth and every variable that changes in the data.
pub fn residuals(subject: &str, drives: &[Drive], residuals: &[f64]) -> Chart {
    let rows: Vec<[f64; VARIABLES]> = drives
        .iter()
        .flat_map(|drive| drive.points.iter().map(|p| drive.conditions.values(p.depth, p.speed)))
        .collect();
    let every = rows.len().div_ceil(MOST_POINTS).max(1);
    let labels = [
        "x = y/NL",
        "rate = NL rho v^2/H_M",
        "slender = D/NL",
        "inertia = NL rho v0^2/H_M",
        "decay = v/v0",
        "energy = M v0^2/(H_M NL^2)",
    ];
    let mut panels = Vec::new();
    for variable in Variable::ALL {
        let mut points: Vec<(f64, f64)> = rows
            .iter()
            .zip(residuals)
            .step_by(every)
            .map(|(row, residual)| (row[variable as usize], *residual))
            .filter(|point| point.0.is_finite())
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            continue;
        };
        if last.0 - first.0 <= 1e-9 * last.0.abs() {
            continue;
        }
        let x = Axis::holding(labels[variable as usize], "", points.iter().map(|point| point.0));
        let series = vec![
            Series::rule("", &x, 0.0),
            Series {
                x: points.iter().map(|point| point.0).collect(),
                ..Series::over("", 0, Shape::Points, points.iter().map(|p| Some(p.1)))
            },
        ];
        panels.push(Panel {
            x,
            y: Axis::around("Residual of s", "", &series),
            height: 40,
            series,
        });
    }
    Chart {
        name: "residuals".to_owned(),
        title: "Residuals of the penetration law",
        subject: subject.to_owned(),
        caption: "Measured less fitted s = sqrt(F_r/(H_M NL)) against each variable of the data.".to_owned(),
        panels,
        events: Vec::new(),
    }
}

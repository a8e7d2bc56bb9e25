//! Charts in the units of a reader.

use super::{Axis, Chart, Series, Shape};
use crate::units::{Conversion, Units, renamed, unit_of};

impl Chart {
    /// The chart with texts and axes in these units.
    pub fn in_units(mut self, units: Units) -> Self {
        if units == Units::Si {
            return self;
        }
        let text = |text: &mut String| *text = units.text(text).into_owned();
        text(&mut self.subject);
        text(&mut self.caption);
        for panel in &mut self.panels {
            let (x, y) = (axis(units, &mut panel.x), axis(units, &mut panel.y));
            for series in &mut panel.series {
                text(&mut series.name);
                series.notes.iter_mut().for_each(text);
                values(series, x, y);
            }
        }
        self
    }
}

/// Charts with texts and axes in these units.
pub fn in_units(charts: Vec<Chart>, units: Units) -> Vec<Chart> {
    charts.into_iter().map(|chart| chart.in_units(units)).collect()
}

/// Converts an axis. A linear axis has a unit, or one in brackets at the end of its label.
fn axis(units: Units, axis: &mut Axis) -> Option<Conversion> {
    for category in &mut axis.categories {
        *category = units.text(category).into_owned();
    }
    let largest = axis.range.map(f64::abs).into_iter().fold(0.0, f64::max);
    let labelled = axis.unit.is_empty() && axis.label.ends_with(')');
    let unit = if labelled { unit_of(&axis.label) } else { axis.unit };
    let conversion = units.conversion(unit, largest).filter(|_| axis.categories.is_empty())?;
    if labelled {
        axis.label = renamed(&axis.label, conversion);
    } else {
        axis.unit = conversion.unit;
    }
    axis.range = axis.range.map(|end| conversion.of(end));
    Some(conversion)
}

fn values(series: &mut Series, x: Option<Conversion>, y: Option<Conversion>) {
    let each = |values: &mut Vec<f64>, by: Option<Conversion>| {
        if let Some(by) = by {
            values.iter_mut().for_each(|value| *value = by.of(*value));
        }
    };
    each(&mut series.x, x);
    each(&mut series.y, y);
    match &mut series.shape {
        Shape::Line | Shape::Broad | Shape::Dashed | Shape::Steps | Shape::Points => {}
        // Horizontal bars have their lengths along x.
        Shape::Bars(marks) => each(marks, y.or(x)),
        Shape::Band(ends) => each(ends, y),
        Shape::Spans(ends) | Shape::Swings(ends) => each(ends, x),
        Shape::Whiskers(ends) | Shape::Errors(ends) => {
            if let Some(by) = y {
                ends.iter_mut().for_each(|pair| *pair = pair.map(|end| by.of(end)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Panel;

    #[test]
    fn curves_and_axes_are_converted_together() {
        let series = Series {
            x: vec![0.0, 1.0],
            y: vec![0.0, 25.4],
            ..Series::over("bumper at 25.4 mm", 0, Shape::Band(vec![50.8, 0.0]), [])
        };
        let chart = Chart {
            name: "motion".to_owned(),
            title: "Motion",
            subject: String::new(),
            caption: "over 2 m".to_owned(),
            panels: vec![Panel {
                x: Axis::new("Time", "ms", [0.0, 1.0]),
                y: Axis::new("Travel", "mm", [0.0, 50.8]),
                height: 30,
                series: vec![series],
            }],
            events: Vec::new(),
        };
        let shown = &chart.in_units(Units::Us).panels[0];
        assert_eq!((shown.x.unit, shown.y.unit), ("ms", "in"));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(shown.y.range[1], 2.0) && close(shown.series[0].y[1], 1.0));
        assert!(matches!(&shown.series[0].shape, Shape::Band(ends) if close(ends[0], 2.0)));
        assert_eq!(shown.series[0].name, "bumper at 1.000 in");
        assert_eq!(shown.series[0].x, [0.0, 1.0]);
    }
}

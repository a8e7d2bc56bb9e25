//! The data of a chart: axes, series and events, independent of the renderer for print or page.

use nailnoise_dynamics::network::EventTime;

/// A long line is thinned to the extremes in this number of columns.
const COLUMNS: usize = 900;

/// Panels, one below the other, that show one subject. `_{...}` in a text is a subscript.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Name of its file, without extension, and of its place on a page.
    pub name: String,
    /// Heading.
    pub title: &'static str,
    /// The design and its result.
    pub subject: String,
    /// Description of the chart, in sentences.
    pub caption: String,
    /// Panels, from the top.
    pub panels: Vec<Panel>,
    /// Events on a horizontal time axis, in order.
    pub events: Vec<Event>,
}

/// A pair of axes with its series.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Height of the axes in print \[mm\].
    pub height: u32,
    /// Series; the first is drawn on top.
    pub series: Vec<Series>,
}

impl Panel {
    /// Series with their places in drawing order: the last one is drawn on top, and it is the first of the panel. Bands
    /// lie below the lines and error bars on the bars of all series.
    pub(crate) fn in_order(&self) -> impl Iterator<Item = (usize, &Series)> {
        let layer = |own: &Series| match own.shape {
            Shape::Band(_) => 0,
            Shape::Errors(_) => 2,
            _ => 1,
        };
        (0..3).flat_map(move |place| {
            let series = self.series.iter().enumerate().rev();
            series.filter(move |(_, own)| layer(own) == place)
        })
    }
}

/// A linear axis, or one of categories.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its unit; empty if it has none.
    pub unit: &'static str,
    /// Values at the ends, in the unit; category `i` covers `i..i + 1`. The first category is on top of a vertical
    /// axis.
    pub range: [f64; 2],
    /// Names of the categories; none on a linear axis.
    pub categories: Vec<String>,
    /// Categories with a tick.
    pub ticks: Vec<usize>,
}

/// Data with an entry in the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Entry in the legend; no entry if it is empty.
    pub name: String,
    /// Index of its colour in the palette.
    pub colour: usize,
    /// Its shape.
    pub shape: Shape,
    /// Abscissas in the unit of the axis, ascending; positions on an axis of categories.
    pub x: Vec<f64>,
    /// Ordinates in the unit of the axis; values that are not finite leave a gap.
    pub y: Vec<f64>,
    /// Text for each point, next to it or shown under the pointer; may be empty.
    pub notes: Vec<String>,
}

/// Shape in which a series is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A line through the points.
    Line,
    /// A wide line through the points.
    Broad,
    /// A dashed line through the points.
    Dashed,
    /// A horizontal line across each category.
    Steps,
    /// A bar from the lower end of the axis for each category, next to those of other series. Lines across the bars
    /// mark these values, if any. The bars are horizontal if the vertical axis has the categories.
    Bars(Vec<f64>),
    /// A dot at each point.
    Points,
    /// A bar for each category between these ordinates, crossed by a line at `y`, next to those of other series.
    Whiskers(Vec<[f64; 2]>),
    /// An error bar between these ordinates over each bar of the series before.
    Errors(Vec<[f64; 2]>),
    /// The area between the points and these ordinates.
    Band(Vec<f64>),
    /// Horizontal bars from these abscissas to `x` in the categories `y` of the vertical axis, each joined to the next.
    Spans(Vec<f64>),
    /// Horizontal bars from these abscissas to `x` in the categories `y` of the vertical axis, next to those of other
    /// series.
    Swings(Vec<f64>),
}

/// An event on a time axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its time, in the unit of the axis.
    pub at: f64,
    /// Its symbol.
    pub symbol: String,
    /// Its name.
    pub name: String,
}

impl Axis {
    /// A linear axis.
    pub(crate) fn new(label: impl Into<String>, unit: &'static str, range: [f64; 2]) -> Self {
        Self {
            label: label.into(),
            unit,
            range,
            categories: Vec::new(),
            ticks: Vec::new(),
        }
    }

    /// An axis that contains zero and the ordinates of all series, with a margin of 5 % at ends other than zero.
    pub(crate) fn around(label: impl Into<String>, unit: &'static str, series: &[Series]) -> Self {
        let values = series.iter().flat_map(|series| series.y.iter().copied());
        let [low, high] = ends(values).map_or([0.0; 2], |ends| ends.map(|end| 1.05 * end));
        let [low, high] = [low.min(0.0), high.max(0.0)];
        Self::new(label, unit, if low < high { [low, high] } else { [0.0, 1.0] })
    }

    /// An axis that contains these values, with a margin of 5 %.
    pub(crate) fn holding(label: impl Into<String>, unit: &'static str, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = ends(values).unwrap_or([0.0, 1.0]);
        // Values that differ only by rounding would give ticks without digits.
        let margin = (0.05 * (high - low)).max(1e-6 * high.abs()).max(f64::MIN_POSITIVE);
        Self::new(label, unit, [low - margin, high + margin])
    }

    /// A level axis that ends above the highest level of all series and covers `shown` dB.
    pub(crate) fn levels(label: impl Into<String>, unit: &'static str, shown: f64, series: &[Series]) -> Self {
        let highest = ends(series.iter().flat_map(|series| series.y.iter().copied())).map_or(0.0, |[_, high]| high);
        let end = 5.0 * ((highest + 1.0) / 5.0).ceil();
        Self::new(label, unit, [end - shown, end])
    }

    /// An axis of categories, each with a tick.
    pub(crate) fn categories(label: impl Into<String>, unit: &'static str, categories: Vec<String>) -> Self {
        Self {
            ticks: (0..categories.len()).collect(),
            range: [0.0, categories.len().max(1) as f64],
            categories,
            ..Self::new(label, unit, [0.0; 2])
        }
    }

    /// Label and unit.
    pub(crate) fn title(&self) -> String {
        match self.unit {
            "" => self.label.clone(),
            unit => format!("{} ({unit})", self.label),
        }
    }
}

impl Series {
    /// A line, thinned in such a way that every peak remains.
    pub(crate) fn line(name: impl Into<String>, colour: usize, x: &[f64], y: &[f64]) -> Self {
        let kept = thin(y);
        let of = |values: &[f64]| kept.iter().map(|&index| values[index]).collect();
        Self {
            x: of(x),
            y: of(y),
            ..Self::over(name, colour, Shape::Line, [])
        }
    }

    /// A value for each category; a missing value leaves a gap.
    pub(crate) fn over(
        name: impl Into<String>,
        colour: usize,
        shape: Shape,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Self {
        let y: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        Self {
            name: name.into(),
            colour,
            shape,
            x: (0..y.len()).map(|place| place as f64).collect(),
            y,
            notes: Vec::new(),
        }
    }

    /// The series with abscissas and ordinates exchanged, for horizontal bars.
    pub(crate) fn sideways(self) -> Self {
        Self {
            x: self.y,
            y: self.x,
            ..self
        }
    }

    /// A dashed grey line across the axis.
    pub(crate) fn rule(name: impl Into<String>, axis: &Axis, value: f64) -> Self {
        Self {
            x: axis.range.to_vec(),
            y: vec![value; 2],
            ..Self::over(name, super::palette::GREY, Shape::Dashed, [])
        }
    }
}

/// The events that occur, in ms.
pub(crate) fn events(events: &[EventTime]) -> Vec<Event> {
    let taking_place = events.iter().filter_map(|event| {
        Some(Event {
            at: 1e3 * event.time?,
            symbol: symbol(&event.name),
            name: match event.description.as_str() {
                "" => event.name.replace('_', " "),
                words => words.to_owned(),
            },
        })
    });
    let mut events: Vec<Event> = taking_place.collect();
    // In a published form of the equations, t2 may precede t1.
    events.sort_by(|a, b| a.at.total_cmp(&b.at));
    events
}

/// `t13` with its number as subscript; other names unchanged.
pub(crate) fn symbol(event: &str) -> String {
    let subscript = |digit: char| char::from_u32(0x2080 + digit.to_digit(10)?);
    match event
        .strip_prefix('t')
        .map(|number| number.chars().map(subscript).collect())
    {
        Some(Some(number)) => ["t".to_owned(), number].concat(),
        _ => event.to_owned(),
    }
}

/// A text with its subscripts `_{...}` enclosed in `before` and `after`.
pub(crate) fn subscripts(text: &str, before: &str, after: &str) -> String {
    let mut parts = text.split("_{");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| match part.split_once('}') {
        Some((below, rest)) if !below.contains('<') => [&text, before, below, after, rest].concat(),
        _ => [&text, "_{", part].concat(),
    })
}

/// Least and greatest finite value.
fn ends(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite());
    finite
        .map(|value| [value; 2])
        .reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
}

/// Indices of the first, lowest and highest point of every column, and of the last point.
fn thin(y: &[f64]) -> Vec<usize> {
    let column = y.len().div_ceil(COLUMNS).max(1);
    if column < 3 {
        return (0..y.len()).collect();
    }
    let mut kept = Vec::with_capacity(3 * COLUMNS + 1);
    for first in (0..y.len()).step_by(column) {
        let own = first..(first + column).min(y.len());
        let by = |a: &usize, b: &usize| y[*a].total_cmp(&y[*b]);
        kept.extend([
            first,
            own.clone().min_by(by).unwrap_or(first),
            own.max_by(by).unwrap_or(first),
        ]);
    }
    kept.extend(y.len().checked_sub(1));
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_lie_below_all_lines() {
        let series = |shape| Series::over("", 0, shape, [Some(0.0)]);
        let panel = Panel {
            x: Axis::new("", "", [0.0, 1.0]),
            y: Axis::new("", "", [0.0, 1.0]),
            height: 10,
            series: vec![
                series(Shape::Line),
                series(Shape::Band(vec![0.0])),
                series(Shape::Errors(vec![[0.0; 2]])),
                series(Shape::Line),
            ],
        };
        let order: Vec<usize> = panel.in_order().map(|(place, _)| place).collect();
        assert_eq!(order, [1, 3, 0, 2]);
    }

    #[test]
    fn a_spike_of_one_sample_stays() {
        let mut y = vec![0.0; 20_000];
        y[12_345] = 7.0;
        y[777] = -3.0;
        let kept = thin(&y);
        assert!(kept.contains(&12_345) && kept.contains(&777) && kept.contains(&19_999));
        assert!(kept.len() <= 3 * COLUMNS + 1 && kept.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn an_axis_holds_zero_and_every_finite_value() {
        let range = |y: &[f64]| {
            let series = Series::over("", 0, Shape::Line, y.iter().copied().map(Some));
            Axis::around("", "", &[series]).range
        };
        assert_eq!(range(&[1.0, f64::NAN, 2.0]), [0.0, 2.1]);
        assert_eq!(range(&[-1.0, 1.0]), [-1.05, 1.05]);
        assert_eq!(range(&[]), [0.0, 1.0]);
    }

    #[test]
    fn subscripts_end_where_they_are_closed() {
        assert_eq!(subscripts("L_{WA} of {a}, b_{c", "<", ">"), "L<WA> of {a}, b_{c");
    }

    #[test]
    fn numbers_of_events_are_subscripts() {
        assert_eq!(["t13", "end", "total"].map(symbol), ["t₁₃", "end", "total"]);
    }
}

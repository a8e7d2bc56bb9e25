//! Tables of a comparison, the same for the terminal and the page.

use nailnoise_quantities::rounded;
use serde_json::Value;

use super::{Cell, Column, Table, dash, decibels, fixed};
use crate::comparison::{Comparison, Labelled, Levels, ValueRow};
use crate::result::{Ends, PerformanceFigure};
use crate::study::legend;
use crate::wording::{band, change, readable, readable_at};

/// Significant digits of the values of a design.
const DIGITS: usize = 6;

impl Comparison {
    /// A column of words, followed by one for each design.
    fn columns(&self, first: &str, of_design: impl Fn(&str) -> Column) -> Vec<Column> {
        let designs = self.designs.iter().map(|name| of_design(name));
        std::iter::once(Column::words(first)).chain(designs).collect()
    }

    /// Keys whose values differ.
    pub(crate) fn input_table(&self) -> Table {
        let mut columns = self.columns("key", |name| Column::short(name));
        columns[0] = Column::keys("key");
        let rows = self.inputs.iter().map(|row| {
            let numbers = || row.values.iter().filter_map(Value::as_f64);
            let largest = numbers().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let (unit, factor) = readable_at(&row.unit, largest);
            std::iter::once(labelled(&row.key, unit))
                .chain(row.values.iter().map(|value| plain(value, factor)))
                .map(Cell::from)
                .collect()
        });
        Table::new(columns, rows)
    }

    /// Levels of the sources and of the total, with their changes.
    pub(crate) fn level_table(&self) -> Table {
        let sources = self.sources.iter().map(|row| (row.source.as_str(), &row.levels));
        self.table_of_levels("source", sources.chain([("total", &self.total)]))
            .with_sum()
    }

    /// Levels of a source in its bands, or between events.
    pub(crate) fn labelled_table(&self, first: &str, own: &[Labelled]) -> Table {
        self.table_of_levels(first, own.iter().map(|own| (own.label.as_str(), &own.levels)))
    }

    fn table_of_levels<'a>(&self, first: &str, rows: impl Iterator<Item = (&'a str, &'a Levels)>) -> Table {
        let changes = self.designs.iter().skip(1).map(|name| {
            Column::number(match self.designs.len() {
                2 => "change".to_owned(),
                _ => format!("change, {name}"),
            })
        });
        let columns = self
            .columns(first, |name| Column::number(name))
            .into_iter()
            .chain(changes);
        let row = |(label, levels): (&str, &Levels)| {
            let own = levels
                .level_db
                .iter()
                .map(|level| Cell::from(decibels(*level)).strong());
            let changes = levels.change_db.iter().skip(1).map(|db| dash(*db, change).into());
            std::iter::once(Cell::from(label)).chain(own).chain(changes).collect()
        };
        Table::new(columns, rows.map(row))
    }

    /// Only the errors of the methods.
    pub(crate) fn method_table(&self) -> Table {
        let rows = self.sources.iter().map(|row| {
            let bands = row.uncertainty_db.iter().map(|bounds| band(*bounds).into());
            std::iter::once(Cell::from(row.source.as_str())).chain(bands).collect()
        });
        Table::new(
            self.columns("source", |name| Column::number(format!("{name} dB"))),
            rows,
        )
    }

    /// The sources of each design, by their rank.
    pub(crate) fn ranking_table(&self) -> Table {
        let places = self.rankings.iter().map(Vec::len).max().unwrap_or(0);
        let rows = (0..places).map(|place| {
            let of_each = self
                .rankings
                .iter()
                .map(|own| own.get(place).map_or("", String::as_str).into());
            std::iter::once(Cell::from((place + 1).to_string()))
                .chain(of_each)
                .collect()
        });
        Table::new(self.columns("place", |name| Column::short(name)), rows)
    }

    /// Performance and consumption of the designs, which show the cost of noise reduction. None if no result states
    /// them.
    pub(crate) fn performance_table(&self) -> Option<Table> {
        let figures: Vec<_> = self
            .performance
            .iter()
            .map(|own| own.map(|own| own.figures()))
            .collect();
        let named = figures.iter().flatten().next()?;
        let rows = named.iter().enumerate().map(|(place, figure)| {
            let value = |own: &Option<[PerformanceFigure; 4]>| {
                let value = own.as_ref().and_then(|own| own[place].value.clone());
                Cell::from(dash(value, |value| value))
            };
            std::iter::once(labelled(figure.name, figure.unit).into())
                .chain(figures.iter().map(value))
                .collect()
        });
        let columns = self.columns("reserve and consumption of the shot", |name| Column::number(name));
        Some(Table::new(columns, rows))
    }

    /// Outcomes, and the figures and events that differ.
    pub(crate) fn shot_table(&self) -> Table {
        let outcomes = self.outcomes.iter().map(|outcome| outcome.replace('_', " ").into());
        let outcomes = std::iter::once(Cell::from("outcome")).chain(outcomes).collect();
        let figures = self.cycle.iter().filter(|row| differ(row)).map(|row| {
            let (unit, factor) = readable(row.unit);
            let name = row.name.replace('_', " ");
            let values = row
                .values
                .iter()
                .map(|value| dash(value.map(|value| factor * value), significant));
            std::iter::once(labelled(&name, unit))
                .chain(values)
                .map(Cell::from)
                .collect()
        });
        let events = self.events.iter().filter(|row| differ(row)).map(|row| {
            let values = row.values.iter().map(|time| fixed(time.map(|time| 1e3 * time), 3));
            std::iter::once(labelled(&self.event_words.in_words(&row.name), "ms"))
                .chain(values)
                .map(Cell::from)
                .collect()
        });
        let rows = std::iter::once(outcomes).chain(figures).chain(events);
        Table::new(self.columns("figure", |name| Column::number(name)), rows)
    }

    /// Sentences about sources that the designs compute by different methods.
    pub(crate) fn unlike_methods(&self) -> Vec<String> {
        let unlike = self.sources.iter().filter_map(|row| {
            let methods: Vec<&str> = row.methods.iter().flatten().map(String::as_str).collect();
            methods.windows(2).any(|pair| pair[0] != pair[1]).then(|| {
                let methods = methods.join("; ");
                format!(
                    "{}: computed by different methods ({methods}), whose errors do not cancel",
                    row.source
                )
            })
        });
        unlike.collect()
    }

    /// Interval and P(first) of each source in each design; `None` if no study applies to any of them.
    pub(crate) fn interval_table(&self) -> Option<Table> {
        self.studies.iter().flatten().next()?;
        let named = || self.designs.iter().zip(&self.studies);
        let columns = named().flat_map(|(name, study)| {
            let first = study.as_ref().map_or_else(String::new, |study| {
                let [_, first] = legend::headings(study);
                first
            });
            [format!("{name} dB"), first].map(Column::number)
        });
        let sources = self.sources.iter().map(|row| row.source.as_str()).chain(["total"]);
        let row = |source: &str| {
            let cells = self.studies.iter().flat_map(|study| match study {
                Some(study) => legend::cells(study, source),
                None => ["-".to_owned(), String::new()],
            });
            std::iter::once(source.to_owned())
                .chain(cells)
                .map(Cell::from)
                .collect()
        };
        let basis = named().map(|(name, study)| match study {
            None => format!("{name}: no study serves it, or its result states none"),
            Some(study) => {
                let ends = match study.ends {
                    Ends::Percentiles => "P5 to P95",
                    Ends::Extremes => "lowest to highest level",
                };
                format!("{name}: {ends} of {} draws", study.draws)
            }
        });
        let sharing = "designs share most of their errors, so that a change is more certain than the levels: \
                       `--draws` states its interval";
        let table = Table::new(
            std::iter::once(Column::words("source")).chain(columns),
            sources.map(row),
        );
        Some(table.with_sum().with_legend(basis.chain([sharing.to_owned()])))
    }
}

/// Whether values differ by more than the table's rounding.
fn differ(row: &ValueRow) -> bool {
    row.values.iter().any(|value| match (value, row.values[0]) {
        (Some(a), Some(b)) => (a - b).abs() > 1e-6 * a.abs().max(b.abs()),
        (a, b) => a.is_some() != b.is_some(),
    })
}

/// A name followed by its unit, if any.
fn labelled(name: &str, unit: &str) -> String {
    match unit {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

fn significant(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

/// A value of the design, a number multiplied by this factor.
fn plain(value: &Value, factor: f64) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(word) => word.clone(),
        // If a value is not stated in this unit, its last digits are meaningless.
        Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), |value| rounded(factor * value, DIGITS, 1e7)),
        other => other.to_string(),
    }
}

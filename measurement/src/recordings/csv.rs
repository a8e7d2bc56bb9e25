//! Tables: each column has a heading; one column contains times, the others channels.
//!
//! The time column has the heading `t` or one that begins with `time`; otherwise it is the only column in a unit of
//! time. A heading may include a unit, as in `time [ms]`, `time_ms` or `N (g)`, or the unit may be in the row below.

use nailnoise_quantities::dimension::TIME;

use super::axis::even_axis;
use super::fault::Fault;
use super::{Numbers, Refusal, Selector, Track};
use nailnoise_documents::tables::{Heading, Table, TableFault, si_of, time};

/// Reads columns of a table.
pub(super) fn decode(bytes: &[u8], channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let table = Table::read(bytes, |headings| headings.iter().any(Heading::is_time));
    let table = table.map_err(|fault| (0, fault.into()))?;
    let headings = &table.headings;
    let known = table.known();
    let time = time(headings).ok_or_else(|| (0, Fault::NoTime { known: known.clone() }))?;
    let unit = headings[time].unit.as_str();
    let seconds = if unit.is_empty() { Ok(1.0) } else { si_of(unit, TIME) };
    let seconds = seconds.map_err(|problem| {
        let unit = unit.to_owned();
        (0, Fault::TimeUnit { unit, problem })
    })?;
    let columns = channels
        .iter()
        .enumerate()
        .map(|(index, selector)| column(selector, headings, &known).map_err(|fault| (index, fault)));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let places: Vec<usize> = [time].into_iter().chain(columns.iter().copied()).collect();
    let found = table.columns(&places).map_err(|fault| {
        let place = match &fault {
            TableFault::Line { column, .. } => column.map_or(0, |place| place.saturating_sub(1)),
            _ => 0,
        };
        (place, fault.into())
    })?;
    let mut values = found.values.into_iter();
    let times: Vec<f64> = values
        .next()
        .unwrap_or_default()
        .iter()
        .map(|time| seconds * time)
        .collect();
    let (rate, start) = even_axis(&times).map_err(|fault| (0, fault))?;
    let tracks = values.zip(&columns).enumerate().map(|(index, (samples, column))| {
        if samples.len() > times.len() {
            let line = found.lines.get(times.len()).map_or(0, |line| *line as u64);
            let problem = "it has a sample and no time".to_owned();
            return Err((index, Fault::Line { line, problem }));
        }
        Ok(Track {
            rate,
            start: Some(start),
            samples,
            numbers: Numbers::InUnit,
            unit: headings[*column].unit.clone(),
            measures: None,
        })
    });
    tracks.collect()
}

impl From<TableFault> for Fault {
    fn from(fault: TableFault) -> Self {
        match fault {
            TableFault::Foreign(foreign) => Self::Foreign(foreign),
            TableFault::Line { line, problem, .. } => Self::Line {
                line: line as u64,
                problem,
            },
            TableFault::Binary | TableFault::NoColumns => Self::Format {
                problem: format!("it is neither a WAV nor a universal file, and as a table {fault}"),
            },
        }
    }
}

/// The column of a channel, found by its complete heading or else by its name without unit.
fn column(selector: &Selector, headings: &[Heading], known: &str) -> Result<usize, Fault> {
    let Selector::Column(name) = selector else {
        return Err(Fault::Selector {
            format: "a CSV file",
            expected: "column",
        });
    };
    for part in [
        |heading: &Heading| heading.text.clone(),
        |heading: &Heading| heading.name.clone(),
    ] {
        let mut found = headings
            .iter()
            .enumerate()
            .filter(|(_, heading)| part(heading) == *name);
        match (found.next(), found.next()) {
            (Some((column, _)), None) => return Ok(column),
            (Some(_), Some(_)) => return Err(Fault::TwoColumns { column: name.clone() }),
            (None, _) => {}
        }
    }
    Err(Fault::NoColumn {
        column: name.clone(),
        known: known.to_owned(),
    })
}

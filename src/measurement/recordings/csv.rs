//! CSV files: a heading for each column, a column of times, a column for each channel.
//!
//! Fields are separated by commas, semicolons or tabs, whichever the first line has; lines that begin with # are
//! comments. The column of times has the heading `t`, or one that begins with `time`. A heading may end with a unit:
//! `time [ms]`, `time_ms`, `N (g)`.

use ::csv::{ByteRecord, ReaderBuilder, Trim};
use nailnoise_quantities::dimension::TIME;
use nailnoise_quantities::measure;

use super::fault::Fault;
use super::{Numbers, Refusal, Selector, Track, even_axis};

/// Most characters of headings that a message shows.
const SHOWN: usize = 120;

/// Reads columns of a CSV file.
pub(super) fn decode(bytes: &[u8], channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes.split(|byte| *byte == b'\n').find(|line| !line.starts_with(b"#"));
    let delimiter = [b';', b'\t']
        .into_iter()
        .find(|mark| first.is_some_and(|line| line.contains(mark)));
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter.unwrap_or(b','))
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes);
    let headings = reader.byte_headers().map_err(|error| (0, line(&error)))?;
    let headings: Vec<Heading> = headings.iter().map(Heading::of).collect();
    let whole: Vec<&str> = headings.iter().map(|heading| heading.text.as_str()).collect();
    let known: String = whole.join(", ").chars().take(SHOWN).collect();
    if bytes.is_empty() || headings.len() < 2 {
        let problem = "it is neither a WAV nor a universal file, and its first line has not two headings".to_owned();
        return Err((0, Fault::Format { problem }));
    }
    let time = headings.iter().position(Heading::is_time);
    let time = time.ok_or_else(|| (0, Fault::NoTime { known: known.clone() }))?;
    let unit = headings[time].unit.as_str();
    let seconds = if unit.is_empty() {
        Ok(1.0)
    } else {
        measure(&format!("1 {unit}"), TIME)
    };
    let seconds = seconds.map_err(|problem| {
        let unit = unit.to_owned();
        (0, Fault::Unit { unit, problem })
    })?;
    let columns = channels
        .iter()
        .enumerate()
        .map(|(index, selector)| column(selector, &headings, &known).map_err(|fault| (index, fault)));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let mut times = Vec::new();
    let mut samples = vec![Vec::new(); columns.len()];
    let mut record = ByteRecord::new();
    while reader
        .read_byte_record(&mut record)
        .map_err(|error| (0, line(&error)))?
    {
        let at = record.position().map_or(0, ::csv::Position::line);
        let value =
            |column: usize| number(&record[column]).ok_or_else(|| not_a_number(at, whole[column], &record[column]));
        times.push(seconds * value(time).map_err(|fault| (0, fault))?);
        for (index, column) in columns.iter().enumerate() {
            samples[index].push(value(*column).map_err(|fault| (index, fault))?);
        }
    }
    let (rate, start) = even_axis(&times).map_err(|fault| (0, fault))?;
    let tracks = samples.into_iter().zip(&columns).map(|(samples, column)| Track {
        rate,
        start: Some(start),
        samples,
        numbers: Numbers::InUnit,
        unit: headings[*column].unit.clone(),
    });
    Ok(tracks.collect())
}

/// A heading, its name without the unit, and the unit.
struct Heading {
    text: String,
    name: String,
    unit: String,
}

impl Heading {
    fn of(field: &[u8]) -> Self {
        let text = String::from_utf8_lossy(field).trim().to_owned();
        let bracket = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
            let (name, unit) = text.strip_suffix(close)?.rsplit_once(open)?;
            Some((name.trim().to_owned(), unit.trim().to_owned()))
        });
        let underscore = || {
            let unit = text.strip_prefix("time_").or_else(|| text.strip_prefix("Time_"))?;
            Some(("time".to_owned(), unit.to_owned()))
        };
        let (name, unit) = bracket
            .or_else(underscore)
            .unwrap_or_else(|| (text.clone(), String::new()));
        Self { text, name, unit }
    }

    fn is_time(&self) -> bool {
        let name = self.name.to_lowercase();
        name == "t" || name == "time" || name.starts_with("time ")
    }
}

/// The column of a channel: that of its whole heading, else that of its name without unit.
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

fn number(field: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    number.is_finite().then_some(number)
}

fn not_a_number(line: u64, heading: &str, field: &[u8]) -> Fault {
    let shown: String = String::from_utf8_lossy(field).chars().take(40).collect();
    Fault::Line {
        line,
        problem: format!("\"{heading}\" is \"{shown}\", which is no finite number"),
    }
}

/// The fault of a line that the reader refuses.
fn line(error: &::csv::Error) -> Fault {
    let at = error.position().map_or(1, ::csv::Position::line);
    let problem = match error.kind() {
        ::csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("it has {len} fields, the first line has {expected_len}")
        }
        kind => format!("{kind:?}"),
    };
    Fault::Line { line: at, problem }
}

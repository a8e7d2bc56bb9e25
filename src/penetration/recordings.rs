//! Recordings of drives, as CSV or universal files, and their points.

use std::path::Path;

use nailnoise_meshes::uff;
use nailnoise_penetration::fit::{Cleaned, Cleaning, Drive, Trace};
use nailnoise_quantities::Dimension;

use super::drives::{Row, digest};
use super::{DEPTH, FORCE, PenetrationError, TIME, read_bytes, unreadable};
use nailnoise_documents::tables::{Heading, Table, si_of};

/// Specific data types in a universal file: time and frequency.
const TIME_TYPE: i64 = 17;
const FREQUENCY_TYPE: i64 = 18;

/// Description of the table in a recording.
const NAMES: &str = "a line names the columns: time_s,depth_m,force_n, or with other units as \"depth [mm]\" (time \
    optional at \
                     constant speed)";

/// Cleans the recording of a row; also returns the digest of its file.
///
/// # Errors
/// [`PenetrationError::Data`] with the recording's file and line.
pub fn clean(row: &Row, how: &Cleaning) -> Result<(Drive, Cleaned, String), PenetrationError> {
    let help = format!("line {} of {} names it", row.place.1, row.place.0.display());
    let bytes = read_bytes(&row.file).map_err(|cause| unreadable(&row.file, &cause, &help))?;
    let digest = digest(&bytes);
    let (trace, lines) = if uff::is_universal(&bytes) {
        histories(&row.file, &bytes)?
    } else {
        columns(&row.file, &bytes)?
    };
    let cleaned = trace
        .clean(&row.conditions, &row.masses, how)
        .map_err(|error| PenetrationError::Data {
            path: row.file.clone(),
            line: error
                .sample()
                .and_then(|sample| lines.get(sample).copied())
                .unwrap_or(1),
            problem: error.to_string(),
            help: error.remedy().to_owned(),
        })?;
    let drive = Drive {
        id: row.id.clone(),
        group: row.group.clone(),
        nail: row.nail.clone(),
        wood: row.wood.clone(),
        conditions: row.conditions,
        points: cleaned.points.clone(),
    };
    Ok((drive, cleaned, digest))
}

/// The samples of a recording, with the line of each.
type Samples = (Trace, Vec<usize>);

/// Depth and force from datasets 58 of a universal file.
fn histories(path: &Path, bytes: &[u8]) -> Result<Samples, PenetrationError> {
    let data = |line: usize, problem: String, help: &str| PenetrationError::Data {
        path: path.to_owned(),
        line,
        problem,
        help: help.to_owned(),
    };
    let (mut all, mut faults) = (Vec::new(), Vec::new());
    for function in uff::functions(bytes, path) {
        match function {
            // A spectrum of the force is not a history.
            Ok(function) if function.kinds[0] == FREQUENCY_TYPE => {}
            Ok(function) => all.push(function),
            Err(fault) => faults.push(fault),
        }
    }
    // A dataset that cannot be read may be the missing one.
    let has = |kinds: &[i64]| all.iter().any(|function| kinds.contains(&function.kinds[1]));
    if let Some(fault) = faults.first().filter(|_| !(has(&[8]) && has(&[9, 13]))) {
        return Err(PenetrationError::Universal {
            cause: fault.to_string(),
        });
    }
    let one = |what: &str, kinds: &[i64]| {
        let mut found = all.iter().filter(|function| kinds.contains(&function.kinds[1]));
        match (found.next(), found.next()) {
            (Some(function), None) => Ok(function),
            (first, second) => Err(data(
                second.or(first).map_or(1, |function| function.line),
                format!(
                    "it holds {} of {what}",
                    if first.is_none() {
                        "no dataset 58"
                    } else {
                        "two datasets 58"
                    }
                ),
                "give one dataset 58 with specific data type 8 (displacement) and one with 9 or 13 (force), a file a \
                 drive",
            )),
        }
    };
    let (depth, force) = (one("displacement", &[8])?, one("force", &[9, 13])?);
    if depth.abscissa != force.abscissa {
        return Err(data(
            force.line,
            "displacement and force have different abscissas".to_owned(),
            "sample both at the same times",
        ));
    }
    // Without a label, the units are those of the file.
    let [metres, newtons] = uff::units(bytes, path)
        .map_err(|fault| PenetrationError::Universal {
            cause: fault.to_string(),
        })?
        .unwrap_or([1.0; 2]);
    let scaled = |function: &uff::Function, dimension: Dimension, own: f64| -> Result<Vec<f64>, PenetrationError> {
        let unit = &function.units[1];
        let factor = match unit.as_str() {
            "" => Ok(own),
            unit => si_of(unit, dimension),
        };
        let factor = factor.map_err(|problem| {
            data(
                function.line,
                format!("the unit \"{unit}\": {problem}"),
                "label the ordinate's unit, as mm or N; without a label it is that of dataset 164, or SI",
            )
        })?;
        Ok(function.ordinate.iter().map(|value| factor * value).collect())
    };
    let seconds = match depth.units[0].as_str() {
        "" => Ok(1.0),
        unit => si_of(unit, TIME.dimension),
    };
    let time = match seconds {
        _ if depth.kinds[0] != TIME_TYPE => Vec::new(),
        Ok(seconds) => depth.abscissa.iter().map(|time| seconds * time).collect(),
        Err(problem) => {
            let problem = format!("the unit \"{}\" of the times: {problem}", depth.units[0]);
            return Err(data(
                depth.line,
                problem,
                "label the times in s or ms; an empty label is s",
            ));
        }
    };
    let trace = Trace {
        time,
        depth: scaled(depth, DEPTH.dimension, metres)?,
        force: scaled(force, FORCE.dimension, newtons)?,
    };
    Ok((trace, force.lines.clone()))
}

/// Samples from a table.
fn columns(path: &Path, bytes: &[u8]) -> Result<Samples, PenetrationError> {
    let names = |headings: &[Heading], of| headings.iter().any(|heading| heading.is_of(of));
    let table = Table::read(bytes, |headings| names(headings, DEPTH) && names(headings, FORCE));
    let table = table.map_err(|fault| PenetrationError::of_table(path, fault, 1, NAMES))?;
    let data = |problem: String, help: &str| PenetrationError::Data {
        path: path.to_owned(),
        line: table.line,
        problem,
        help: help.to_owned(),
    };
    let (mut places, mut factors) = (Vec::new(), Vec::new());
    for of in [TIME, DEPTH, FORCE] {
        let mut found = table
            .headings
            .iter()
            .enumerate()
            .filter(|(_, heading)| heading.is_of(of));
        let Some((place, heading)) = found.next() else {
            if of.dimension == TIME.dimension {
                continue;
            }
            return Err(data(format!("its columns are \"{}\"", table.known()), NAMES));
        };
        if found.next().is_some() {
            return Err(data(format!("two columns are the {}", of.name), "name one column so"));
        }
        let factor = heading.factor(of).map_err(|problem| {
            let problem = format!("the unit of \"{}\": {problem}", heading.text);
            data(problem, "give a unit as in time [ms], depth [mm], force [kN]")
        });
        places.push(place);
        factors.push(factor?);
    }
    let help = "give every line a number for every column, with one decimal mark";
    let read = table.columns(&places);
    let read = read.map_err(|fault| PenetrationError::of_table(path, fault, table.line, help))?;
    let shortest = read.values.iter().map(Vec::len).min().unwrap_or(0);
    if read.values.iter().any(|values| values.len() > shortest) {
        let line = read.lines.get(shortest).copied().unwrap_or(table.line);
        let problem = "a column ends before the others".to_owned();
        return Err(PenetrationError::Data {
            path: path.to_owned(),
            line,
            problem,
            help: help.to_owned(),
        });
    }
    let mut scaled = read
        .values
        .into_iter()
        .zip(factors)
        .map(|(values, factor)| values.into_iter().map(|value| factor * value).collect::<Vec<f64>>());
    let time = if places.len() == 3 {
        scaled.next().unwrap_or_default()
    } else {
        Vec::new()
    };
    let [depth, force] = [scaled.next().unwrap_or_default(), scaled.next().unwrap_or_default()];
    Ok((Trace { time, depth, force }, read.lines))
}

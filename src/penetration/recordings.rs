//! Recordings of drives, as CSV or universal files, and their points.

use std::path::Path;

use nailnoise_dynamics::prf::fit::{Cleaned, Cleaning, Drive, Trace};
use nailnoise_meshes::uff;
use nailnoise_quantities::dimension::{FORCE, LENGTH};
use nailnoise_quantities::{Dimension, measure};

use super::drives::{Row, digest};
use super::{PenetrationError, read_text, unreadable};

/// Specific data type of time in a universal file.
const TIME: i64 = 17;

/// The recording of a row, cleaned, and the digest of its file.
///
/// # Errors
/// [`PenetrationError::Data`] with the recording's file and line.
pub fn clean(row: &Row, how: &Cleaning) -> Result<(Drive, Cleaned, String), PenetrationError> {
    let help = format!("line {} of {} names it", row.place.1, row.place.0.display());
    let text = read_text(&row.file).map_err(|cause| unreadable(&row.file, &cause, &help))?;
    let digest = digest(text.as_bytes());
    let universal = text.lines().find(|line| !line.trim().is_empty());
    let (trace, lines) = match universal {
        Some(line) if line.trim() == "-1" => histories(&row.file, &text)?,
        _ => columns(&row.file, &text)?,
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

/// The samples of a recording, and the line of each.
type Samples = (Trace, Vec<usize>);

/// Depth and force from datasets 58 of a universal file.
fn histories(path: &Path, text: &str) -> Result<Samples, PenetrationError> {
    let data = |line: usize, problem: String, help: &str| PenetrationError::Data {
        path: path.to_owned(),
        line,
        problem,
        help: help.to_owned(),
    };
    let all = uff::functions(text.as_bytes(), path).map_err(|cause| PenetrationError::Universal {
        cause: cause.to_string(),
    })?;
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
                "give one dataset 58 with specific data type 8 (displacement) and one with 9 or 13 (force), a file a drive",
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
    let scaled = |function: &uff::Function, dimension: Dimension| -> Result<Vec<f64>, PenetrationError> {
        let unit = &function.units[1];
        let factor = match unit.as_str() {
            "" => Ok(1.0),
            unit => measure(&format!("1 {unit}"), dimension),
        };
        let factor = factor.map_err(|problem| {
            data(
                function.line,
                format!("the unit \"{unit}\": {problem}"),
                "label the ordinate's unit, as mm or N; an empty label is SI",
            )
        })?;
        Ok(function.ordinate.iter().map(|value| factor * value).collect())
    };
    let trace = Trace {
        time: if depth.kinds[0] == TIME {
            depth.abscissa.clone()
        } else {
            Vec::new()
        },
        depth: scaled(depth, LENGTH)?,
        force: scaled(force, FORCE)?,
    };
    Ok((trace, force.lines.clone()))
}

/// Samples from a CSV file.
fn columns(path: &Path, text: &str) -> Result<Samples, PenetrationError> {
    let data = |line: usize, problem: String, help: &str| PenetrationError::Data {
        path: path.to_owned(),
        line,
        problem,
        help: help.to_owned(),
    };
    const NAMES: &str = "the first line names the columns: time_s,depth_m,force_n (time_s optional at constant speed)";
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let Some((first, headings)) = lines.next() else {
        return Err(data(1, "it is empty".to_owned(), NAMES));
    };
    let headings: Vec<&str> = headings.split(',').map(str::trim).collect();
    let place = |name: &str| headings.iter().position(|heading| *heading == name);
    let (time, Some(depth), Some(force)) = (place("time_s"), place("depth_m"), place("force_n")) else {
        let shown: String = headings.join(",").chars().take(60).collect();
        return Err(data(first, format!("its columns are \"{shown}\""), NAMES));
    };
    let mut trace = Trace::default();
    let mut places = Vec::new();
    for (number, line) in lines {
        let mut values = [0.0; 3];
        let mut count = 0;
        for (column, field) in line.split(',').enumerate() {
            count += 1;
            let target = match Some(column) {
                c if c == time => 0,
                c if c == Some(depth) => 1,
                c if c == Some(force) => 2,
                _ => continue,
            };
            match field.trim().parse::<f64>() {
                Ok(value) if value.is_finite() => values[target] = value,
                _ => {
                    let shown: String = field.trim().chars().take(40).collect();
                    let problem = format!("{} is \"{shown}\", no number", headings.get(column).unwrap_or(&""));
                    return Err(data(number, problem, "give numbers with a point before the decimals"));
                }
            }
        }
        if count != headings.len() {
            let problem = format!("it has {count} fields, and the first line names {}", headings.len());
            return Err(data(number, problem, "give every line a field for every column"));
        }
        if time.is_some() {
            trace.time.push(values[0]);
        }
        trace.depth.push(values[1]);
        trace.force.push(values[2]);
        places.push(number);
    }
    Ok((trace, places))
}

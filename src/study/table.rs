//! `draws.csv` and `draws.h5`: one row per draw.

use super::draws::Draws;
use super::level_table::LevelTable;
use super::variables::{Drawn, Variable, VariableKind};
use crate::design::Value;
use crate::error::Error;
use crate::output;

/// The draws as CSV and as HDF5, where each column is a data set. The columns are structure and candidate of each draw,
/// levels including the errors of methods \[dB re 1 pW s\], these errors \[dB\], figures of the shot, and the variables
/// in SI units. Fields of fixed variables are empty.
///
/// # Errors
/// [`Error::Table`] if rows differ in length; [`Error::Hdf5`].
pub fn draw_files(made: &Draws) -> Result<[Vec<u8>; 2], Error> {
    let (header, rows) = table(made);
    Ok([output::table(&header, &rows)?, output::table_hdf5(&header, &rows)?])
}

/// Headings, and one row per draw.
fn table(made: &Draws) -> (Vec<String>, Vec<Vec<String>>) {
    let levels = LevelTable::new(&made.draws);
    let sources = &levels.names;
    let totals = levels.totals();
    let of_variable = |variable: &Variable| match variable.unit() {
        "" => format!("{} [-]", variable.name),
        unit => format!("{} [{unit}]", variable.name),
    };
    let inputs = || {
        made.variables
            .iter()
            .enumerate()
            .filter(|(_, own)| !matches!(own.kind, VariableKind::Method(_)))
    };
    let header = ["draw", "structure", "candidate", "outcome"]
        .map(str::to_owned)
        .into_iter();
    let header = header
        .chain(sources.iter().map(|source| format!("L_WA,1s {source} [dB]")))
        .chain(["L_WA,1s total [dB]".to_owned()])
        .chain(sources.iter().map(|source| format!("method.{source} [dB]")))
        .chain(["mean_drive_speed [m/s]", "penetration [m]", "exhaust_mass [kg]"].map(str::to_owned))
        .chain(inputs().map(|(_, variable)| of_variable(variable)));
    let rows = made.draws.iter().enumerate().map(|(index, draw)| {
        let decibels = |level: f64| {
            if level.is_finite() {
                format!("{level:.4}")
            } else {
                String::new()
            }
        };
        let figure = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
        let shot = &draw.shot;
        let figures = [shot.mean_drive_speed, Some(shot.penetration), Some(shot.exhaust_mass)].map(figure);
        let names = [
            index.to_string(),
            draw.structure.to_string(),
            draw.candidate.to_string(),
            draw.levels.outcome.clone(),
        ];
        let drawn = inputs().map(
            |(place, variable)| match (variable.drawn(draw.shares[place]), &variable.kind) {
                (Some(Drawn::Value(Value::Number(value))), _) => format!("{value:e}"),
                (Some(Drawn::Value(Value::Count(count))), _) => count.to_string(),
                (Some(Drawn::Alternative(chosen)), VariableKind::Alternatives(options)) => options[chosen].name.clone(),
                _ => String::new(),
            },
        );
        let errors = draw
            .method_db
            .iter()
            .take(sources.len())
            .map(|error| format!("{error:.4}"));
        let own = levels.levels[index].iter().chain([&totals[index]]);
        let own: Vec<String> = own.copied().map(decibels).collect();
        names
            .into_iter()
            .chain(own)
            .chain(errors)
            .chain(figures)
            .chain(drawn)
            .collect::<Vec<_>>()
    });
    (header.collect(), rows.collect())
}

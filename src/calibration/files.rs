//! Files of a calibration: the draws as a table, and a design with the ranges of the keys that moved.

use std::fmt::Write as _;
use std::path::Path;

use super::posterior::Posterior;
use super::redraw::{Redrawn, is_redrawn};
use super::result::{CalibrationResult, MovedKey, Table, moved_keys};
use super::toml_line::{normal_distribution, toml_value, unit_suffix};
use crate::design::{Assignment, Design, JointDraws};
use crate::error::Error;
use crate::output;

/// Name of the file with the joint draws.
pub const JOINT: &str = "calibrated.draws";

/// Contents of the files.
pub struct Files {
    /// `posterior.csv`: one row per draw.
    pub draws: Vec<u8>,
    /// `calibrated.draws`: the draws of the keys.
    pub joint: Vec<u8>,
    /// `calibrated.toml` without its first line, which names its base relative to a folder.
    design: String,
    base: std::path::PathBuf,
}

impl Files {
    /// The calibrated design as a file in the given folder.
    pub fn design(&self, folder: &Path) -> String {
        let base = std::path::absolute(&self.base).unwrap_or_else(|_| self.base.clone());
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let base = relative(&base, &folder);
        format!("base = {}\n{}", toml::Value::String(base), self.design)
    }
}

/// A path relative to a folder (both absolute), with forward slashes.
fn relative(path: &Path, folder: &Path) -> String {
    let common = path
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    // Different drives of Windows have no common parent.
    if common == 0 {
        return path.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(common).map(|_| "..".to_owned());
    let down = path
        .components()
        .skip(common)
        .map(|own| own.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// The files of a posterior.
///
/// # Errors
/// [`Error::Table`] if rows differ in length.
pub(super) fn files(
    posterior: &Posterior,
    design: &Design,
    result: &CalibrationResult,
    (table, joint): (&Table, &JointDraws),
    (narrowed, redraw): (&[Assignment], &[Redrawn]),
) -> Result<Files, Error> {
    let mut moved = moved_keys(posterior, result, table);
    moved.retain(|own| !is_redrawn(redraw, own.key));
    let joint = joint.without(|name| is_redrawn(redraw, name));
    let header = std::iter::once("draw".to_owned()).chain(table.names.iter().cloned());
    let rows = table.rows.iter().enumerate().map(|(draw, row)| {
        let numbers = row.iter().map(|own| {
            if own.is_finite() {
                own.to_string()
            } else {
                String::new()
            }
        });
        std::iter::once(draw.to_string()).chain(numbers).collect::<Vec<_>>()
    });
    Ok(Files {
        draws: output::table(header, rows)?,
        joint: serde_json::to_vec(&joint).map_err(Error::Json)?,
        design: calibrated(design, result, &moved)
            + &narrowed
                .iter()
                .filter(|own| !is_redrawn(redraw, own.key()))
                .map(|own| own.file_line() + "\n")
                .collect::<String>(),
        base: design.path().to_owned(),
    })
}

/// The design file without its base.
fn calibrated(design: &Design, result: &CalibrationResult, moved: &[MovedKey<'_>]) -> String {
    let mut text = format!(
        "# {} calibrated with {}: {} draws, seed {}.\n\
         # Values are those of the draw in the middle of all; ranges contain the draws of each key.\n",
        design.name(),
        result.measured,
        result.draws,
        result.seed
    );
    if !result.converged {
        text.push_str("# The sampler had not converged.\n");
    }
    let _ = writeln!(text, "study.draws = \"{JOINT}\"");
    let entries = design.entries();
    // Writing to a string cannot fail.
    for own in moved {
        let [low, high] = own.ends;
        let provenance = toml::Value::String(format!("computed: calibrated with {}", result.measured));
        if let Some((entry, solution)) = design.drawn_derived().find(|(entry, _)| entry.key == own.key) {
            let mut moved = design.clone();
            let follower = |design: &Design| {
                design
                    .entries()
                    .into_iter()
                    .find(|entry| entry.key == solution.follower)
            };
            if let (Ok(()), Some(entry)) = (moved.set(&[(solution.change, own.value.clone())]), follower(&moved)) {
                let value = toml_value(&entry.value, &entry.unit);
                let _ = writeln!(text, "{} = {{ value = {value}, provenance = {provenance} }}", entry.key);
            }
            let follows = solution.follower.rsplit('.').next().unwrap_or(solution.follower);
            let _ = writeln!(
                text,
                "{} = {{ range = \"{low:?} .. {high:?}{}\", distribution = \"normal\", follows = \"{follows}\", \
                 provenance = {provenance} }}",
                own.key,
                unit_suffix(&entry.unit)
            );
        } else if let Some(entry) = entries.iter().find(|entry| entry.key == own.key) {
            let line = normal_distribution(entry, &own.value, own.ends, &provenance);
            let _ = writeln!(text, "{line}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_base_is_named_relative_to_the_folder_of_the_file() {
        let of = |path: &str, folder: &str| relative(Path::new(path), Path::new(folder));
        assert_eq!(of("/a/b/tool.toml", "/a/out/tool"), "../../b/tool.toml");
        assert_eq!(of("/a/tool.toml", "/a"), "tool.toml");
    }
}

//! Reads the measurements of a call.

use std::path::Path;

use super::error::CalibrationError;
use super::measurements::{Direct, Measurements};
use super::reader::{self, Reader};
use super::request::Request;
use super::shot;
use super::toml_line;
use crate::design::{Assignment, Design, Value};
use crate::error::Error;
use crate::study::cycle_variables;

/// Name of the measurements if there are none.
const NO_MEASUREMENTS: &str = "no measurements";

/// The measurements of a call.
pub(super) struct Inputs {
    /// The design with the measured values and errors of keys that the cycle does not use.
    pub(super) design: Design,
    /// Name of their file.
    pub(super) file: String,
    pub(super) measured: Measurements,
    /// Readings of the cycle that are only predicted, and levels.
    pub(super) held_out: Vec<usize>,
    pub(super) held_levels: Vec<usize>,
}

impl Inputs {
    /// Reads the measurements, and finds those held out among them.
    ///
    /// # Errors
    /// The first fault in the measurements, with its place; or if no measurement has a name that is held out.
    pub(super) fn read(
        design: &Design,
        assignments: &[Assignment],
        measured: Option<&Path>,
        request: &Request,
    ) -> Result<Self, Error> {
        let file = measured.map_or_else(|| NO_MEASUREMENTS.to_owned(), |path| path.display().to_string());
        let (design, measured) = read(design, assignments, measured)?;
        let held_out = request.hold_out.iter().map(|name| {
            let known = measured.data.iter().map(|own| own.name.as_str());
            let known = known.chain(measured.levels.iter().map(|own| own.name.as_str()));
            // The readings of a file have the name of its measurement with a suffix.
            let is_held = |own: &str| {
                let rest = own.strip_prefix(name.as_str());
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
            };
            let exact = known.clone().position(|own| own == name);
            let places: Vec<usize> = match exact {
                Some(place) => vec![place],
                None => (0..)
                    .zip(known.clone())
                    .filter(|(_, own)| is_held(own))
                    .map(|(place, _)| place)
                    .collect(),
            };
            match places.is_empty() {
                false => Ok(places),
                true => Err(CalibrationError::HeldOut {
                    name: name.clone(),
                    known: known.collect::<Vec<_>>().join(", "),
                }),
            }
        });
        let held_out = held_out.collect::<Result<Vec<Vec<usize>>, _>>()?.concat();
        let of_cycle = measured.data.len();
        let (held_out, held_levels): (Vec<usize>, Vec<usize>) = held_out.into_iter().partition(|&own| own < of_cycle);
        let held_levels: Vec<usize> = held_levels.into_iter().map(|own| own - of_cycle).collect();
        Ok(Self {
            design,
            file,
            measured,
            held_out,
            held_levels,
        })
    }
}

/// Reads the measurements of a design in a file; none without a file. The cycle's own keys are narrowed as variables
/// of the sampler. Other measured keys affect the levels only, so their ranges are narrowed in the design.
///
/// # Errors
/// The first fault, with its place; or if the design is calibrated already.
pub(super) fn read(
    design: &Design,
    assignments: &[Assignment],
    measured: Option<&Path>,
) -> Result<(Design, Measurements), Error> {
    if let Some(joint) = &design.study().draws {
        let measured = joint.measured.clone();
        return Err(CalibrationError::Calibrated { measured }.into());
    }
    let Some(path) = measured else {
        return Ok((design.clone(), Measurements::default()));
    };
    let document = reader::text(path)?;
    let measurements = |design: &Design, assignments: &[Assignment]| -> Result<Measurements, Error> {
        let with = |own: &[Assignment]| Design::load_with(design.path(), &[assignments, own].concat());
        let assembly = shot::assembly_of(design)?;
        let reader = Reader {
            design,
            assembly: assembly.as_ref(),
            with: &with,
        };
        Ok(reader.read(&document)?)
    };
    let first = measurements(design, assignments)?;
    let narrowed = narrowed(design, &first.direct, path)?;
    if narrowed.is_empty() {
        return Ok((design.clone(), first));
    }
    let all = [assignments, &narrowed].concat();
    let design = Design::load_with(design.path(), &all)?;
    let mut measured = measurements(&design, &all)?;
    let note = |own: &Assignment| {
        format!(
            "the cycle does not use `{}`: its measurement narrows the levels only",
            own.key()
        )
    };
    measured.notes.extend(narrowed.iter().map(note));
    measured.narrowed = narrowed;
    Ok((design, measured))
}

/// Values and ranges of the measured keys that the cycle does not use. The ends of a range are two standard deviations
/// from the value, or those of the design.
fn narrowed(design: &Design, direct: &[Direct], file: &Path) -> Result<Vec<Assignment>, Error> {
    if direct.is_empty() {
        return Ok(Vec::new());
    }
    let of_cycle = cycle_variables(design)?;
    let entries = design.entries();
    let provenance = toml::Value::String(format!("computed: measured directly, {}", file.display()));
    let assignment = |own: &Direct| {
        let is_of_cycle = of_cycle.iter().any(|variable| variable.name == own.key);
        let entry = entries.iter().find(|entry| entry.key == own.key)?;
        let [low, high] = entry.range?;
        if is_of_cycle {
            return None;
        }
        let value = own.value.clamp(low, high);
        let ends = [value - 2.0 * own.deviation, value + 2.0 * own.deviation].map(|end| end.clamp(low, high));
        let value = match entry.value {
            Value::Count(_) => Value::Count(value.round() as u32),
            _ => Value::Number(value),
        };
        toml_line::normal_distribution(entry, &value, ends, &provenance)
            .parse()
            .ok()
    };
    Ok(direct.iter().filter_map(assignment).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const MEASURED: &str = r#"
        schema = "nailnoise-calibration/1"
        [direct]
        "wood.loss_factor" = { value = 0.031, error = 0.002 }
        "support.worktable.top_thickness" = { value = "38.5 mm", error = "0.2 mm" }
        "piston.rod_protrusion" = { value = "12 mm", error = "0.5 mm" }
        [condition]
        own = { outcome = "drives" }
        [measured]
        depth = { condition = "own", quantity = "head_depth", value = "2 mm", error = "1 mm" }
    "#;

    /// The cycle uses the protrusion of the rod only.
    #[test]
    fn a_measured_key_of_the_levels_is_narrowed_in_the_design() {
        let file = std::env::temp_dir().join(format!("nailnoise-direct-{}.toml", std::process::id()));
        std::fs::write(&file, MEASURED).unwrap();
        let design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let (narrowed, measured) = read(&design, &[], Some(&file)).unwrap();
        std::fs::remove_file(&file).unwrap();
        let of = |design: &Design, key: &str| {
            let entry = design.entries().into_iter().find(|entry| entry.key == key).unwrap();
            let Value::Number(value) = entry.value else {
                panic!("{key} is a number")
            };
            let [low, high] = entry.range.unwrap();
            [low, value, high]
        };
        let near = |key: &str, expected: [f64; 3]| {
            let found = of(&narrowed, key);
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(is_near, "{key}: {found:?}");
        };
        near("wood.loss_factor", [0.027, 0.031, 0.035]);
        near("support.worktable.top_thickness", [38.1e-3, 38.5e-3, 38.9e-3]);
        let key = "piston.rod_protrusion";
        assert_eq!(of(&narrowed, key), of(&design, key));
        assert_eq!(measured.narrowed.len(), 2);
        assert!(
            measured
                .notes
                .iter()
                .any(|own| own.contains("does not use `wood.loss_factor`"))
        );
        let under = &measured.conditions[0].design;
        assert_eq!(of(under, "wood.loss_factor"), of(&narrowed, "wood.loss_factor"));
    }
}

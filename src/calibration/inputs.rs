//! Reads the measurements of a call.

use std::path::Path;

use super::error::CalibrationError;
use super::measurements::Measurements;
use super::posterior::Request;
use super::reader::{self, Reader};
use super::shot;
use crate::design::{Assignment, Design};
use crate::error::Error;

/// Name of the measurements if there are none.
const NO_MEASUREMENTS: &str = "no measurements";

/// The measurements of a call.
pub(super) struct Inputs {
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
        let measured = read(design, assignments, measured)?;
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
            file,
            measured,
            held_out,
            held_levels,
        })
    }
}

/// Reads the measurements of a design in a file; none without a file.
///
/// # Errors
/// The first fault, with its place; or if the design is calibrated already.
pub(super) fn read(
    design: &Design,
    assignments: &[Assignment],
    measured: Option<&Path>,
) -> Result<Measurements, Error> {
    if let Some(joint) = &design.study().draws {
        let measured = joint.measured.clone();
        return Err(CalibrationError::Calibrated { measured }.into());
    }
    let with = |own: &[Assignment]| Design::load_with(design.path(), &[assignments, own].concat());
    let assembly = shot::assembly_of(design)?;
    let reader = Reader {
        design,
        assembly: assembly.as_ref(),
        with: &with,
    };
    Ok(match measured {
        Some(path) => reader.read(&reader::text(path)?)?,
        None => Measurements::default(),
    })
}

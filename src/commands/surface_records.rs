//! Records of a body's surfaces, written for its design.

use std::path::Path;

use super::bodies::Input;
use crate::atomic_write;
use crate::design::inputs::recorded_surfaces::{SurfaceMeasure, area_decimals};
use crate::design::{Design, SurfaceOf};
use crate::error::Error;
use crate::stages::bodies::BodyKind;
use crate::wording::trimmed;

/// Refuses a record that cannot be written, before the body is meshed.
///
/// # Errors
/// [`Error::RecordOfMesh`] for a file that is not a design, [`Error::Exists`] for a file that is there already.
pub(super) fn refuse(path: &Path, input: &Input) -> Result<(), Error> {
    if !input.is_design() {
        return Err(Error::RecordOfMesh {
            path: input.path().to_owned(),
        });
    }
    match path.exists() {
        true => Err(Error::Exists { path: path.to_owned() }),
        false => Ok(()),
    }
}

/// Writes the records of a body's surfaces to a file.
///
/// # Errors
/// [`Error::RecordOfBuiltIn`] for a body that is not from a file; [`Error::Write`].
pub(super) fn write(path: &Path, design: &Design, kind: BodyKind, measures: &[SurfaceMeasure]) -> Result<(), Error> {
    if !design.is_from_file(kind.into()) {
        return Err(Error::RecordOfBuiltIn {
            design: design.name().to_owned(),
            body: kind.name(),
            key: key(kind),
        });
    }
    atomic_write::write(path, toml(design, kind, measures).as_bytes())
}

/// A warning that records of a body have no effect.
pub(super) fn idle(design: &Design, kind: BodyKind) -> Option<String> {
    let own = design.idle_records().filter(|(_, body)| *body == SurfaceOf::from(kind));
    let names: Vec<String> = own.map(|(name, _)| format!("recorded_surfaces.{name}")).collect();
    (!names.is_empty()).then(|| {
        format!(
            "records of surfaces without effect, because a run solves no {} from a file (`{}`): {}",
            kind.name(),
            key(kind),
            names.join(", ")
        )
    })
}

/// The key that names the file of a body.
fn key(kind: BodyKind) -> &'static str {
    match kind {
        BodyKind::Workpiece => "workpiece.mesh",
        BodyKind::Worktable => "support.worktable.mesh",
        BodyKind::Tool => "body.mesh",
    }
}

/// The records of all surfaces that a run can use, as tables of a design.
fn toml(design: &Design, kind: BodyKind, measures: &[SurfaceMeasure]) -> String {
    let file = Path::new(design.mesh_of(kind.into()));
    let file = file.file_name().unwrap_or_default().to_string_lossy();
    let body = kind.name();
    let mut text = format!(
        "# Surfaces of the {body} in {}, recorded by nailnoise {}. A file in which one of them has moved is refused.\n",
        file.escape_debug(),
        env!("CARGO_PKG_VERSION")
    );
    for surface in SurfaceOf::from(kind).surfaces() {
        let surface = surface.as_str();
        if let Some(measure) = measures.iter().find(|measure| measure.name == surface) {
            text.push_str(&format!("\n[recorded_surfaces.{body}_{surface}]\n"));
            text.push_str(&format!("body = \"{body}\"\nsurface = \"{surface}\"\n"));
            text.push_str(&values(measure));
        }
    }
    text
}

/// Area, centre and mean normal of a surface: to 0.01 cm2 or four digits, to 0.01 mm, and to 0.001.
fn values(measure: &SurfaceMeasure) -> String {
    let decimals = area_decimals(measure.area);
    let mut text = format!("area = \"{} cm2\"\n", trimmed(1e4 * measure.area, decimals));
    for (axis, c) in ["x", "y", "z"].iter().zip(&measure.centre) {
        text.push_str(&format!("{axis} = \"{} mm\"\n", trimmed(1e3 * c, 2)));
    }
    for (axis, c) in ["x", "y", "z"].iter().zip(&measure.normal) {
        text.push_str(&format!("normal_{axis} = {}\n", trimmed(*c, 3)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_record_states_every_value_with_its_unit_and_no_negative_zero() {
        let measure = SurfaceMeasure {
            name: "cap".to_owned(),
            area: 40.714_99e-4,
            centre: Vector3::new(-1e-9, 0.012_345, 0.302),
            normal: Vector3::new(0.0, -1e-5, 1.0),
        };
        let expected = "area = \"40.71 cm2\"\nx = \"0 mm\"\ny = \"12.35 mm\"\nz = \"302 mm\"\nnormal_x = 0\n\
                        normal_y = 0\nnormal_z = 1\n";
        assert_eq!(values(&measure), expected);
    }

    #[test]
    fn a_small_area_keeps_four_digits() {
        let measure = SurfaceMeasure {
            name: "seat".to_owned(),
            area: 0.012_346e-4,
            centre: Vector3::zeros(),
            normal: Vector3::zeros(),
        };
        assert!(
            values(&measure).starts_with("area = \"0.01235 cm2\"\n"),
            "{}",
            values(&measure)
        );
    }
}

//! A mesh or solid geometry in a user's file.

use std::path::{Path, PathBuf};

use nailnoise_meshes::msh::{self, Imported};
use nailnoise_meshes::{MeshError, SolidGeometry, read_regular};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::error::Error;
use crate::stages::Digest;
use crate::stages::bodies::BodyError;

/// A mesh or solid geometry in a file, identified by its content.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshFile {
    #[serde(skip)]
    path: PathBuf,
    content: Digest,
    /// Length of one unit of the file \[m\].
    unit: f64,
    /// Longest element side of a solid geometry \[m\]; `None` for a mesh.
    element: Option<f64>,
    /// Number of the single solid to be meshed; `None` to mesh all.
    #[serde(skip_serializing_if = "Option::is_none")]
    solid: Option<usize>,
    /// Permitted length of its longest side; `None` for a file that does not represent a body.
    expected: Option<Extent>,
}

/// The length of one unit of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileUnit {
    /// \[m\]
    pub metres: f64,
    /// The option or key with which the user gave it; `None` for the default millimetre.
    pub given_in: Option<&'static str>,
}

impl FileUnit {
    /// Default unit of CAD programs \[m\].
    pub const USUAL: f64 = 1e-3;

    /// The unit from a key of the design, which counts as given if it is not the default.
    pub fn of_key(metres: f64, key: &'static str) -> Self {
        Self {
            metres,
            given_in: (metres != Self::USUAL).then_some(key),
        }
    }

    /// The unit from a command-line option.
    pub fn of_option(metres: Option<f64>, option: &'static str) -> Self {
        Self {
            metres: metres.unwrap_or(Self::USUAL),
            given_in: metres.map(|_| option),
        }
    }
}

/// Permitted length of a body, to detect a file that is read in a wrong unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extent {
    /// Description of the part that it represents.
    pub what: &'static str,
    /// Its longest side along an axis \[m\].
    pub longest: [f64; 2],
    /// Key of the unit of its file.
    pub key: &'static str,
}

/// Units of length in files, most common first.
const UNITS: [(&str, f64); 5] = [
    ("1 mm", 1e-3),
    ("1 m", 1.0),
    ("1 in", 0.0254),
    ("1 cm", 1e-2),
    ("1 um", 1e-6),
];

impl Extent {
    fn fits(&self, extent: f64) -> bool {
        (self.longest[0]..=self.longest[1]).contains(&extent)
    }

    /// The error that no such body is this long \[m\], for a file that is read in a unit \[m\] or states its own
    /// (`None`).
    fn refuse(&self, path: &Path, extent: f64, unit: Option<f64>) -> Error {
        let read_as = |other: f64| unit.map(|unit| extent / unit * other);
        let better = UNITS
            .iter()
            .find_map(|&(name, other)| Some((name, read_as(other)?)).filter(|(_, long)| self.fits(*long)));
        let remedy = match (unit, better) {
            (None, None) if states_unit(path) => {
                "the file states its unit, so that no key changes it; check which part it shows, or \
                 export it again in its true size"
                    .to_owned()
            }
            (_, Some((name, long))) => {
                let long = millimetres(long);
                format!("give `{} = \"{name}\"`, with which it is {long} long", self.key)
            }
            (None, None) => "the file states that its lengths are in m; write it again in the right unit".to_owned(),
            (Some(_), None) => format!(
                "give the length of one unit of the file in `{}`, or check what it shows",
                self.key
            ),
        };
        BodyError::Extent {
            path: path.to_owned(),
            what: self.what,
            found: format!(
                "{} long {}",
                millimetres(extent),
                match unit {
                    None if states_unit(path) => "by the unit that it states".to_owned(),
                    unit => format!("with a unit of {}", millimetres(unit.unwrap_or(1.0))),
                }
            ),
            expected: self.longest.map(millimetres).join(" to "),
            remedy,
        }
        .into()
    }
}

fn millimetres(length: f64) -> String {
    let rounded = format!("{:.2e}", length * 1e3).parse::<f64>().unwrap_or(length * 1e3);
    format!("{rounded} mm")
}

impl MeshFile {
    /// A file with its unit. A solid geometry is meshed with elements no longer than `element` \[m\].
    ///
    /// # Errors
    /// [`MeshError::UnknownKind`] for another kind of file, and [`MeshError::Read`]. [`BodyError::NoSize`] for a solid
    /// geometry without an element size. [`BodyError::StatedUnit`] if a unit is given for a file that states its own.
    pub fn new(path: &Path, unit: FileUnit, element: Option<f64>, expected: Option<Extent>) -> Result<Self, Error> {
        let element = if is_solid(path)? {
            Some(element.ok_or(BodyError::NoSize)?)
        } else {
            None
        };
        if let Some(given_in) = unit.given_in.filter(|_| states_unit(path)) {
            return Err(BodyError::StatedUnit {
                path: path.to_owned(),
                given: millimetres(unit.metres),
                given_in,
            }
            .into());
        }
        let bytes = read_regular(path, msh::LARGEST).map_err(|source| MeshError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            content: Sha256::digest(bytes).into(),
            unit: if states_unit(path) {
                FileUnit::USUAL
            } else {
                unit.metres
            },
            element,
            solid: None,
            expected,
        })
    }

    /// The same file, with only one solid meshed, given by its number starting at 1.
    ///
    /// # Errors
    /// [`BodyError::NoSolids`] for a file that is a mesh.
    pub fn with_solid(self, solid: Option<usize>) -> Result<Self, Error> {
        if solid.is_some() && !self.needs_gmsh() {
            return Err(BodyError::NoSolids { path: self.path }.into());
        }
        Ok(Self { solid, ..self })
    }

    /// Reads a mesh, or has gmsh mesh a solid geometry.
    ///
    /// # Errors
    /// The errors of reading and meshing, [`BodyError::Extent`] for a body that is far too large or too small.
    pub fn import(&self) -> Result<Imported, Error> {
        let Some(element) = self.element else {
            let imported = msh::read(&self.path, self.unit)?;
            let extent = longest_side(&imported);
            return match &self.expected {
                Some(expected) if !expected.fits(extent) => {
                    Err(expected.refuse(&self.path, extent, (!imported.states_metres).then_some(self.unit)))
                }
                _ => Ok(imported),
            };
        };
        // gmsh gives lengths in millimetres regardless of the file's unit. BREP files have no unit, and gmsh keeps
        // their numbers; with a unit of 1 mm they stay the same.
        let scale = self.unit / FileUnit::USUAL;
        let expected = self.expected.map_or([0.0, f64::INFINITY], |expected| expected.longest);
        let solid = SolidGeometry {
            path: &self.path,
            size: element / scale,
            expected: expected.map(|longest| longest / scale),
            solid: self.solid,
        };
        let mut imported = solid.mesh().map_err(|error| match (error, &self.expected) {
            (MeshError::Extent { extent, .. }, Some(expected)) => {
                let unit = (!states_unit(&self.path)).then_some(self.unit);
                expected.refuse(&self.path, extent * scale, unit)
            }
            (error, _) => error.into(),
        })?;
        imported.mesh.nodes.iter_mut().for_each(|p| *p *= scale);
        Ok(imported)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Longest element side of a solid geometry \[m\]; `None` for a mesh.
    pub fn element_size(&self) -> Option<f64> {
        self.element
    }

    /// Whether gmsh makes its mesh.
    pub fn needs_gmsh(&self) -> bool {
        self.element.is_some()
    }
}

/// Longest side of a mesh along an axis \[m\].
fn longest_side(imported: &Imported) -> f64 {
    let (low, high) = imported.mesh.bounds();
    (high - low).max()
}

/// Whether files of this type, given by the extension, state their unit of length: STEP and IGES do, BREP does not.
pub fn states_unit(path: &Path) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    [".step", ".stp", ".igs", ".iges"].iter().any(|end| name.ends_with(end))
}

/// Whether a file is a solid geometry instead of a mesh, by its extension.
fn is_solid(path: &Path) -> Result<bool, MeshError> {
    let name = path.to_string_lossy().to_lowercase();
    let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
    if ends(&[".msh", ".msh.gz"]) {
        Ok(false)
    } else if ends(&[".step", ".stp", ".brep", ".igs", ".iges"]) {
        Ok(true)
    } else {
        Err(MeshError::UnknownKind { path: path.to_owned() })
    }
}

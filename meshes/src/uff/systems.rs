//! Coordinate systems of universal files: datasets 18 and 2420.
//!
//! A node refers to two of them: one for its coordinates and one for its displacements. Modal-test software uses this
//! to give each sensor its own axes.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Matrix3, Point3, Vector3};

use super::dataset::{Block, UffError};

/// Directions of a node's displacement axes in global components: row i is axis i.
pub type Axes = Matrix3<f64>;

/// Kind of a coordinate system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Cartesian,
    Cylindrical,
    /// Read but not supported, because programs differ in the order of its angles.
    Spherical,
}

/// A coordinate system as defined in its file, relative to a reference system.
#[derive(Debug, Clone, Copy)]
struct System {
    kind: Kind,
    /// Label of the reference system of the other fields; 0 is the global system.
    reference: u64,
    /// Row i is axis i.
    axes: Matrix3<f64>,
    origin: Point3<f64>,
}

/// Number of lines of a system in dataset 18 and in dataset 2420.
const LINES: [usize; 2] = [4, 6];

/// Number of lines before the first system of dataset 2420: number and name of the part.
const PART: usize = 2;

/// The label of the global system in datasets 2411 and 781; labels begin at 1 in I-DEAS.
const GLOBAL: u64 = 1;

/// Largest deviation of the axes in dataset 2420 from orthonormal.
const ORTHONORMAL: f64 = 1e-4;

/// The coordinate systems of a file by label.
#[derive(Debug, Default)]
pub(super) struct Systems(HashMap<u64, System>);

/// A node as defined in its file.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalNode {
    /// Label of the system of its coordinates.
    pub(super) definition: u64,
    /// Label of the system of its displacements.
    pub(super) displacement: u64,
    pub(super) position: Point3<f64>,
    pub(super) dataset: u64,
    /// Line of the file, from 1.
    pub(super) line: usize,
}

impl Systems {
    /// Reads dataset 18: label, kind, reference, colour, method; name; origin, a point on +x, a point in the +x +z half
    /// plane.
    pub(super) fn read_18(&mut self, block: &Block<'_>) -> Result<(), UffError> {
        let expected =
            "a coordinate system: label, kind, reference system, colour, method 1 (origin, +x axis, +xz plane)";
        let mut line = 0;
        while line < block.lines.len() {
            let header = block.numbers(line, expected)?;
            let &[label, kind, reference, _, method] = header.as_slice() else {
                return Err(block.error(line, expected));
            };
            if method != 1.0 {
                return Err(block.error(line, expected));
            }
            let kind = kind_of(block, line, kind)?;
            let expected = "nine coordinates: of the origin, of a point on the +x axis and of a point in the +xz plane";
            let mut points = block.numbers(line + 2, expected)?;
            points.extend(block.numbers(line + 3, expected)?);
            let &[ox, oy, oz, xx, xy, xz, px, py, pz] = points.as_slice() else {
                return Err(block.error(line + 2, expected));
            };
            let origin = Point3::new(ox, oy, oz);
            let x = Point3::new(xx, xy, xz) - origin;
            let y = (Point3::new(px, py, pz) - origin).cross(&x);
            let (Some(x), Some(y)) = (x.try_normalize(0.0), y.try_normalize(1e-9 * x.norm_squared())) else {
                return Err(block.error(line + 2, "points that are not on one line"));
            };
            let axes = Matrix3::from_rows(&[x.transpose(), y.transpose(), x.cross(&y).transpose()]);
            self.insert(
                block,
                line,
                label,
                System {
                    kind,
                    reference: reference as u64,
                    axes,
                    origin,
                },
            )?;
            line += LINES[0];
        }
        Ok(())
    }

    /// Reads dataset 2420: label, kind, colour; name; three rows with one axis each; and the origin.
    pub(super) fn read_2420(&mut self, block: &Block<'_>) -> Result<(), UffError> {
        let mut line = PART;
        while line < block.lines.len() {
            let expected = "a coordinate system: label, kind, colour";
            let header = block.numbers(line, expected)?;
            let &[label, kind, ..] = header.as_slice() else {
                return Err(block.error(line, expected));
            };
            let kind = kind_of(block, line, kind)?;
            let row = |line: usize| -> Result<Vector3<f64>, UffError> {
                let expected = "a row of a transformation matrix: three numbers";
                let row = block.numbers(line, expected)?;
                match row.as_slice() {
                    &[x, y, z] => Ok(Vector3::new(x, y, z)),
                    _ => Err(block.error(line, expected)),
                }
            };
            let rows = [row(line + 2)?, row(line + 3)?, row(line + 4)?];
            let axes = Matrix3::from_rows(&rows.map(|row| row.transpose()));
            if (axes * axes.transpose() - Matrix3::identity()).amax() > ORTHONORMAL || axes.determinant() < 0.0 {
                return Err(block.error(line + 2, "rows that are right-handed unit vectors at right angles"));
            }
            let system = System {
                kind,
                reference: 0,
                axes,
                origin: Point3::from(row(line + 5)?),
            };
            self.insert(block, line, label, system)?;
            line += LINES[1];
        }
        Ok(())
    }

    fn insert(&mut self, block: &Block<'_>, line: usize, label: f64, system: System) -> Result<(), UffError> {
        if label.fract() != 0.0 || label < 0.0 {
            return Err(block.error(line, "a label that is a whole number"));
        }
        match self.0.insert(label as u64, system) {
            Some(other) if other.axes != system.axes || other.origin != system.origin => {
                Err(block.error(line, "a label that no other coordinate system has"))
            }
            _ => Ok(()),
        }
    }

    /// Converts lengths from the unit of the file to metres.
    pub(super) fn scale(&mut self, metres: f64) {
        self.0.values_mut().for_each(|system| system.origin *= metres);
    }

    /// A system relative to the global one; none for the global system itself.
    fn global(&self, label: u64, node: &LocalNode, path: &Path) -> Result<Option<System>, UffError> {
        let mut found: Option<System> = None;
        let mut next = label;
        // A chain longer than the number of systems is a cycle.
        for _ in 0..=self.0.len() {
            let by_default = |label: u64| label == 0 || (label == GLOBAL && node.dataset != 15);
            let Some(&system) = self.0.get(&next) else {
                return match by_default(next) {
                    true => Ok(found),
                    false => Err(self.unknown(next, node, path)),
                };
            };
            if system.kind != Kind::Cartesian && found.is_some() {
                break;
            }
            found = Some(match found {
                None => system,
                Some(inner) => System {
                    axes: inner.axes * system.axes,
                    origin: system.origin + system.axes.tr_mul(&inner.origin.coords),
                    ..inner
                },
            });
            if system.reference == 0 {
                return Ok(found);
            }
            next = system.reference;
        }
        Err(UffError::Reference {
            path: path.to_owned(),
            system: label,
        })
    }

    fn unknown(&self, system: u64, node: &LocalNode, path: &Path) -> UffError {
        let mut known: Vec<u64> = self.0.keys().copied().collect();
        known.sort_unstable();
        let known: Vec<String> = known.iter().map(u64::to_string).collect();
        UffError::NoSystem {
            path: path.to_owned(),
            line: node.line,
            dataset: node.dataset,
            system,
            known: if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            },
        }
    }

    /// Position of a node in the global system \[m\], and the axes of its displacements; none if they are the global
    /// ones.
    pub(super) fn resolve(&self, node: &LocalNode, path: &Path) -> Result<(Point3<f64>, Option<Axes>), UffError> {
        let form = |found, expected| UffError::Form {
            path: path.to_owned(),
            line: node.line,
            dataset: node.dataset,
            found,
            expected,
        };
        let spherical = || {
            form(
                "a node in a spherical coordinate system (kind 2)",
                "one in a Cartesian system (kind 0), or export the nodes in global axes (system 0)",
            )
        };
        let position = match self.global(node.definition, node, path)? {
            None => node.position,
            Some(system) if system.kind == Kind::Cartesian => system.origin + system.axes.tr_mul(&node.position.coords),
            Some(system) if system.kind == Kind::Cylindrical => {
                return Err(form(
                    "a node with coordinates in a cylindrical system",
                    "coordinates in a Cartesian one",
                ));
            }
            Some(_) => return Err(spherical()),
        };
        let axes = match self.global(node.displacement, node, path)? {
            None => None,
            Some(system) => Some(match system.kind {
                Kind::Cartesian => system.axes,
                Kind::Spherical => return Err(spherical()),
                Kind::Cylindrical => {
                    // Components along radius, angle and axis at the node. On the axis itself, where the radius has no
                    // direction, those along x are used.
                    let local = system.axes * (position - system.origin);
                    let angle = local.y.atan2(local.x);
                    let (s, c) = angle.sin_cos();
                    Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0) * system.axes
                }
            }),
        };
        Ok((position, axes.filter(|axes| *axes != Matrix3::identity())))
    }
}

fn kind_of(block: &Block<'_>, line: usize, kind: f64) -> Result<Kind, UffError> {
    match kind as i64 {
        0 => Ok(Kind::Cartesian),
        1 => Ok(Kind::Cylindrical),
        2 => Ok(Kind::Spherical),
        _ => Err(block.error(
            line,
            "a Cartesian (0), cylindrical (1) or spherical (2) coordinate system",
        )),
    }
}

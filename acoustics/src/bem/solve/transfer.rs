//! Projects normal velocities from the faces of volume meshes onto panels that do not match them.

use super::neumann::Patterns;
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::mesh::symmetry::{Image, Parity};
use crate::checks::{InputError, same_length};
use nailnoise_meshes::{FaceKind, Surface};
use nalgebra::{DMatrix, Matrix4, Vector2, Vector3};
use std::ops::Range;

/// Largest fraction of a panel that may be uncovered or covered twice.
const COVER: f64 = 1e-6;

/// A part of the body with its own volume mesh. The panels of some patches lie on its flat faces.
#[derive(Clone, Debug)]
pub struct MovingPart<'a> {
    /// Skin of the volume mesh, with flat, straight-sided faces.
    pub skin: &'a Surface,
    /// Modal displacements of the skin's points, (3 x points) x modes.
    pub modes: &'a DMatrix<f64>,
    /// Patches of the boundary that belong to this part.
    pub patches: Range<usize>,
}

impl Boundary {
    /// Normal velocities of all modes of all parts (one part after another), separated by parity with respect to the
    /// mirror planes.
    ///
    /// On each panel, this is the least-squares fit to the polynomials of the faces, integrated exactly over every
    /// intersection of a face with the panel. The volume flow of each panel equals that of the faces, whatever the mesh
    /// size.
    ///
    /// # Errors
    /// [`BemError::Uncovered`] if the faces of its part do not cover a panel; [`InputError::Length`] for modes of a
    /// different mesh.
    pub fn transfer(&self, parts: &[MovingPart<'_>]) -> Result<Vec<Patterns>, BemError> {
        let modes = parts.iter().map(|p| p.modes.ncols()).sum();
        let mirrors = self.mirrors().map(|mirror| mirror.is_some());
        let mut result: Vec<Patterns> = Parity::all(mirrors)
            .into_iter()
            .map(|parity| Patterns {
                parity,
                velocities: DMatrix::zeros(self.velocity_values(), modes),
            })
            .collect();
        let images: Vec<Image> = self.images().into_iter().filter(|i| i.sign_along(2) > 0.0).collect();
        let mut first_mode = 0;
        for part in parts {
            let by_point = by_point(part)?;
            let faces = flat_faces(part.skin);
            let mut first = 0;
            for (p, panel) in self.mesh().panels.iter().enumerate() {
                let corners = panel.corners().len();
                if part.patches.contains(&panel.patch) {
                    for &image in &images {
                        let values = self.on_panel(p, image, part.skin, &faces, &by_point)?;
                        for patterns in &mut result {
                            let share = patterns.parity.sign(image) / images.len() as f64;
                            for (i, value) in values.iter().enumerate() {
                                for (m, v) in value.iter().enumerate() {
                                    patterns.velocities[(first + i, first_mode + m)] += share * v;
                                }
                            }
                        }
                    }
                }
                first += corners;
            }
            first_mode += part.modes.ncols();
        }
        Ok(result)
    }

    /// Corner values of every mode on a panel's image.
    fn on_panel(
        &self,
        panel: usize,
        image: Image,
        skin: &Surface,
        faces: &[FlatFace],
        by_point: &DMatrix<f64>,
    ) -> Result<Vec<Vec<f64>>, BemError> {
        let mesh = self.mesh();
        let place = |xi: [f64; 2]| {
            let x = mesh.point_at(panel, xi).position;
            Vector3::from_fn(|axis, _| self.mirrored(image, axis, x[axis]))
        };
        let kind = mesh.panels[panel].kind();
        let outline: Vec<Vector3<f64>> = kind.natural_nodes()[..kind.corners()]
            .iter()
            .map(|&xi| place(xi))
            .collect();
        let area = mesh.point_at(panel, kind.centre()).area_vector().normalize();
        let normal = Vector3::from_fn(|axis, _| image.sign_along(axis) * area[axis]);
        let frame = Frame::new(outline[0], normal);
        let own: Vec<Vector2<f64>> = outline.iter().map(|x| frame.flat(x)).collect();
        let size = (outline[0] - outline[kind.corners() / 2]).norm();
        // Moments of the corner functions per unit displacement of the skin's points.
        let mut weights: Vec<(usize, [f64; 4])> = Vec::new();
        let mut mass = Matrix4::identity();
        mass.view_mut((0, 0), (kind.corners(), kind.corners())).fill(0.0);
        let (mut covered, whole) = (0.0, signed_area(&own).abs());
        for face in faces {
            let off = (face.centre - outline[0]).dot(&normal).abs();
            let apart = (face.centre - outline[0]).norm() > face.reach + 2.0 * size;
            if apart || off > 1e-6 * size || face.normal.dot(&normal) < 1.0 - 1e-6 {
                continue;
            }
            let theirs: Vec<Vector2<f64>> = face.corners.iter().map(|x| frame.flat(x)).collect();
            let piece = clip(&theirs, &own);
            let nodes = &skin.faces[face.number].nodes;
            for k in 2..piece.len() {
                let (a, b, c) = (piece[0], piece[k - 1], piece[k]);
                let twice = (b - a).perp(&(c - a)).abs();
                covered += 0.5 * twice;
                for (xi, w) in rules::triangle(12) {
                    let at = a + (b - a) * xi[0] + (c - a) * xi[1];
                    let here = kind.linear().at(natural(kind, &own, at)).n;
                    let there = face.kind.at(natural(face.kind, &theirs, at)).n;
                    for i in 0..kind.corners() {
                        for j in 0..kind.corners() {
                            mass[(i, j)] += w * twice * here[i] * here[j];
                        }
                    }
                    for (&node, n) in nodes.iter().zip(there) {
                        let slot = weights.iter().position(|(known, _)| *known == node).unwrap_or_else(|| {
                            weights.push((node, [0.0; 4]));
                            weights.len() - 1
                        });
                        for (to, phi) in weights[slot].1.iter_mut().zip(here) {
                            *to += w * twice * phi * n;
                        }
                    }
                }
            }
        }
        let gap = (covered / whole - 1.0).abs();
        let inverse = mass.try_inverse().filter(|_| gap < COVER);
        let Some(inverse) = inverse else {
            return Err(BemError::Uncovered {
                panel,
                at: place(kind.centre()).into(),
                share: covered / whole,
            });
        };
        let mut values = vec![vec![0.0; by_point.nrows()]; kind.corners()];
        for (node, moments) in weights {
            for (i, value) in values.iter_mut().enumerate() {
                let factor: f64 = (0..kind.corners()).map(|j| inverse[(i, j)] * moments[j]).sum();
                for axis in (0..3).filter(|&axis| normal[axis] != 0.0) {
                    let column = by_point.column(3 * node + axis);
                    let weight = factor * normal[axis];
                    value.iter_mut().zip(column.iter()).for_each(|(v, u)| *v += weight * u);
                }
            }
        }
        Ok(values)
    }
}

/// Modal displacements of the skin's points, modes x (3 x points).
fn by_point(part: &MovingPart<'_>) -> Result<DMatrix<f64>, InputError> {
    let rows = 3 * part.skin.points.len();
    same_length("rows of the modal displacements", part.modes.nrows(), rows)?;
    Ok(part.modes.transpose())
}

/// A straight-sided face of a skin.
struct FlatFace {
    number: usize,
    kind: FaceKind,
    corners: Vec<Vector3<f64>>,
    centre: Vector3<f64>,
    reach: f64,
    normal: Vector3<f64>,
}

fn flat_faces(skin: &Surface) -> Vec<FlatFace> {
    let face = |(number, f): (usize, &nailnoise_meshes::SurfaceFace)| {
        let corners: Vec<Vector3<f64>> = f.nodes[..f.kind.corners()]
            .iter()
            .map(|&n| skin.points[n].coords)
            .collect();
        let centre = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
        let reach = corners.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        let last = corners.len() - 1;
        FlatFace {
            number,
            kind: f.kind,
            normal: (corners[1] - corners[0])
                .cross(&(corners[last] - corners[0]))
                .normalize(),
            corners,
            centre,
            reach,
        }
    };
    skin.faces.iter().enumerate().map(face).collect()
}

/// Coordinate system in a plane.
struct Frame {
    origin: Vector3<f64>,
    axes: [Vector3<f64>; 2],
}

impl Frame {
    fn new(origin: Vector3<f64>, normal: Vector3<f64>) -> Self {
        let mut across = Vector3::zeros();
        across[normal.iamin()] = 1.0;
        let first = across.cross(&normal).normalize();
        Self {
            origin,
            axes: [first, normal.cross(&first)],
        }
    }

    fn flat(&self, x: &Vector3<f64>) -> Vector2<f64> {
        let d = x - self.origin;
        Vector2::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]))
    }
}

fn signed_area(polygon: &[Vector2<f64>]) -> f64 {
    let n = polygon.len();
    0.5 * (0..n).map(|i| polygon[i].perp(&polygon[(i + 1) % n])).sum::<f64>()
}

/// The intersection of two convex polygons (Sutherland & Hodgman 1974).
fn clip(polygon: &[Vector2<f64>], by: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let turn = signed_area(by).signum();
    let mut piece = polygon.to_vec();
    for k in 0..by.len() {
        let (a, b) = (by[k], by[(k + 1) % by.len()]);
        let inside = |x: &Vector2<f64>| turn * (b - a).perp(&(x - a));
        let whole = std::mem::take(&mut piece);
        for i in 0..whole.len() {
            let (x, y) = (whole[i], whole[(i + 1) % whole.len()]);
            let (dx, dy) = (inside(&x), inside(&y));
            if dx >= 0.0 {
                piece.push(x);
            }
            if dx * dy < 0.0 {
                piece.push(x + (y - x) * (dx / (dx - dy)));
            }
        }
    }
    piece
}

/// Natural coordinates of a point in a straight-sided triangle or quadrilateral, by Newton's method.
fn natural(kind: FaceKind, corners: &[Vector2<f64>], at: Vector2<f64>) -> [f64; 2] {
    let mut xi = kind.centre();
    // The map is bilinear, but linear on the parallelograms of a regular mesh, where one step suffices up to rounding.
    for _ in 0..20 {
        let shape = kind.linear().at(xi);
        let (mut x, mut t) = (Vector2::zeros(), [Vector2::zeros(); 2]);
        for (a, corner) in corners.iter().enumerate() {
            x += shape.n[a] * corner;
            t[0] += shape.dn[a][0] * corner;
            t[1] += shape.dn[a][1] * corner;
        }
        let (rest, jacobian) = (at - x, t[0].perp(&t[1]));
        let step = [rest.perp(&t[1]) / jacobian, t[0].perp(&rest) / jacobian];
        xi = [xi[0] + step[0], xi[1] + step[1]];
        if step[0].abs() + step[1].abs() < 1e-13 {
            break;
        }
    }
    xi
}

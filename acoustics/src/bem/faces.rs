//! The flat faces of a body, each of which radiates at high frequencies as if flush in a plane.

use super::boundary::Boundary;
use super::panel::PanelShape;
use super::problem::Patterns;
use super::rules;
use super::symmetry::Image;
use crate::air::Air;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{DMatrix, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Frequencies over which a kernel is averaged.
const AVERAGED: usize = 16;

/// Step of a kernel's table over distance, in units of 1/k at the highest frequency.
const STEP: f64 = 0.05;

/// How far normals of one plane may differ, and its points lie off it over the body's size.
const FLAT: f64 = 1e-6;

/// A reflecting plane at right angles to a face: a point in it and its unit normal into the air.
#[derive(Clone, Copy, Debug)]
struct Wall {
    at: Vector3<f64>,
    normal: Vector3<f64>,
}

/// Neighbouring panels in one plane.
#[derive(Clone, Debug)]
struct Face {
    panels: Vec<usize>,
    /// Images in the mirror planes across which the face continues, itself first.
    images: Vec<Image>,
    wall: Option<Wall>,
}

/// Flat faces of a boundary that are wide against the wave, and the panels that belong to none.
///
/// A face radiates by Rayleigh's integral (flush in a plane, the rest of the body out of sight):
///
/// ```text
/// R = rho0 c0 k^2/(2 pi) Phi_n^T S K S Phi_n       K_ab = sin(k r_ab)/(k r_ab)
/// ```
///
/// which tends to the equivalent radiated power for k -> infinity, and unlike it knows how long the waves on the face are
/// against those in air. A wall at right angles (the floor, or the larger face it stands on) reflects: images of the points
/// are summed. Different faces radiate independently. Panels outside of all faces, as curved ones, radiate the equivalent
/// radiated power.
#[derive(Clone, Debug)]
pub(super) struct Faces<'a> {
    boundary: &'a Boundary,
    faces: Vec<Face>,
    others: Vec<usize>,
}

/// Patches with what a face adds to each.
type OfPatches = Vec<(usize, DMatrix<f64>)>;

impl<'a> Faces<'a> {
    /// Faces at least as large as the square of the wavelength \[m\].
    pub(super) fn new(boundary: &'a Boundary, wavelength: f64) -> Self {
        let sheets = Sheets::new(boundary);
        let (mut faces, mut others) = (Vec::new(), Vec::new());
        for panels in sheets.groups() {
            let face = sheets.face(panels);
            let area: f64 = face.panels.iter().map(|&p| boundary.mesh().panel_area(p)).sum();
            if sheets.normals[face.panels[0]].is_some() && area * face.images.len() as f64 >= wavelength * wavelength {
                faces.push(face);
            } else {
                others.extend(face.panels);
            }
        }
        Self {
            boundary,
            faces,
            others,
        }
    }

    /// Whether there is no such face.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Resistance of every patch in the mean over each range of frequencies \[Hz\], parity by parity, range by range.
    pub(super) fn resistances(
        &self,
        motions: &[Patterns],
        ranges: &[[f64; 2]],
        air: &Air,
    ) -> Vec<Vec<Vec<DMatrix<f64>>>> {
        let patches = self.boundary.mesh().patches.len();
        let zeros = |p: &Patterns| vec![DMatrix::zeros(p.velocities.ncols(), p.velocities.ncols()); patches];
        let mut all: Vec<Vec<Vec<DMatrix<f64>>>> = motions.iter().map(|m| vec![zeros(m); ranges.len()]).collect();
        let mut tasks = Vec::new();
        for face in &self.faces {
            tasks.extend((0..ranges.len()).map(|range| (Some(face), range)));
        }
        if !self.others.is_empty() {
            tasks.push((None, 0));
        }
        let found: Vec<Vec<OfPatches>> = tasks
            .par_iter()
            .map(|&(face, range)| match face {
                Some(face) => self.of_face(face, motions, ranges[range], air),
                None => self.of_others(motions, air),
            })
            .collect();
        for ((face, range), found) in tasks.into_iter().zip(found) {
            for (parity, parts) in found.into_iter().enumerate() {
                for (patch, part) in parts {
                    let held = match face {
                        Some(_) => range..range + 1,
                        None => 0..ranges.len(),
                    };
                    held.for_each(|range| all[parity][range][patch] += &part);
                }
            }
        }
        all
    }

    /// What a face adds to its patches, parity by parity.
    fn of_face(&self, face: &Face, motions: &[Patterns], range: [f64; 2], air: &Air) -> Vec<OfPatches> {
        let kernel = Kernel::new(range, air, 2.0 * self.boundary.extents().norm());
        let points = Points::new(self.boundary, &face.panels, |edge| {
            // Gauss's rule follows a wave once it has more points than half the wave's phase across the panel.
            1 + (0.5 * kernel.highest * edge).ceil().max(1.0) as usize
        });
        let n = points.at.len();
        let of_image = |image: &Image| {
            let seen: Vec<Vector3<f64>> = points
                .at
                .iter()
                .map(|x| Vector3::from_fn(|axis, _| self.boundary.mirrored(*image, axis, x[axis])))
                .collect();
            let reflected = face.wall.map(|wall| {
                let reflect = |y: &Vector3<f64>| y - 2.0 * (y - wall.at).dot(&wall.normal) * wall.normal;
                seen.iter().map(reflect).collect::<Vec<_>>()
            });
            Mat::from_fn(n, n, |i, j| {
                let x = points.at[i];
                let wall = reflected.as_ref().map_or(0.0, |y| kernel.at((x - y[j]).norm()));
                // As exact as what is kept of a resistance.
                (kernel.at((x - seen[j]).norm()) + wall) as f32
            })
        };
        let kernels: Vec<Mat<f32>> = face.images.iter().map(of_image).collect();
        let factor = self.boundary.copies() as f64 * air.impedance() / (2.0 * PI);
        let patches = points.patches();
        let of_parity = |Patterns { parity, velocities }: &Patterns| {
            let (moving, flows) = points.flows(velocities);
            let mut pressures = Mat::<f32>::zeros(n, moving.len());
            for (image, kernel) in face.images.iter().zip(&kernels) {
                let sign = parity.sign(*image) as f32;
                matmul(
                    pressures.as_mut(),
                    Accum::Add,
                    kernel.as_ref(),
                    flows.as_ref(),
                    sign,
                    Par::Seq,
                );
            }
            let patch = |&patch: &usize| {
                let own = |i: usize, j: usize| if points.patch[i] == patch { flows[(i, j)] } else { 0.0 };
                let (own, mut form) = (
                    Mat::from_fn(n, moving.len(), own),
                    Mat::zeros(moving.len(), moving.len()),
                );
                let (left, right) = (own.transpose(), pressures.as_ref());
                matmul(form.as_mut(), Accum::Replace, left, right, 1.0f32, Par::Seq);
                let mut whole = DMatrix::zeros(velocities.ncols(), velocities.ncols());
                for (j, &to_j) in moving.iter().enumerate() {
                    for (i, &to_i) in moving.iter().enumerate() {
                        whole[(to_i, to_j)] = 0.5 * factor * (f64::from(form[(i, j)]) + f64::from(form[(j, i)]));
                    }
                }
                (patch, whole)
            };
            patches.iter().map(patch).collect()
        };
        motions.iter().map(of_parity).collect()
    }

    /// Equivalent radiated power of what belongs to no face, parity by parity.
    fn of_others(&self, motions: &[Patterns], air: &Air) -> Vec<OfPatches> {
        let points = Points::new(self.boundary, &self.others, |_| 3);
        let factor = self.boundary.copies() as f64 * air.impedance();
        let of_parity = |Patterns { velocities, .. }: &Patterns| {
            let patch = |&patch: &usize| {
                let rows: Vec<usize> = (0..points.at.len()).filter(|&i| points.patch[i] == patch).collect();
                let own = DMatrix::from_fn(rows.len(), velocities.ncols(), |i, mode| {
                    points.velocity(rows[i], velocities, mode) * (factor * points.weights[rows[i]]).sqrt()
                });
                (patch, own.tr_mul(&own))
            };
            points.patches().iter().map(patch).collect()
        };
        motions.iter().map(of_parity).collect()
    }
}

/// Quadrature points of some panels.
struct Points {
    at: Vec<Vector3<f64>>,
    weights: Vec<f64>,
    patch: Vec<usize>,
    /// First velocity value of the point's panel, and the corner functions there.
    shapes: Vec<(usize, Vec<f64>)>,
}

impl Points {
    /// With as many along each side of a panel as `order` says for the length of its longest \[m\].
    fn new(boundary: &Boundary, panels: &[usize], order: impl Fn(f64) -> usize) -> Self {
        let mesh = boundary.mesh();
        let corners: Vec<usize> = mesh.panels.iter().map(|p| p.corners().len()).collect();
        let mut first = vec![0; corners.len()];
        for p in 1..corners.len() {
            first[p] = first[p - 1] + corners[p - 1];
        }
        let mut points = Self {
            at: Vec::new(),
            weights: Vec::new(),
            patch: Vec::new(),
            shapes: Vec::new(),
        };
        for &p in panels {
            let kind = mesh.panels[p].kind();
            let at = |k: usize| mesh.points[mesh.panels[p].corners()[k % corners[p]]];
            let longest = (0..corners[p]).map(|k| (at(k + 1) - at(k)).norm()).fold(0.0, f64::max);
            let rule = match (corners[p], order(longest)) {
                (3, order) => rules::triangle(if order > 3 { 12 } else { 7 }),
                (_, order) => rules::square(order),
            };
            for (xi, w) in rule {
                let point = mesh.point_at(p, xi);
                points.at.push(point.position.coords);
                points.weights.push(w * point.area_vector().norm());
                points.patch.push(mesh.panels[p].patch);
                points
                    .shapes
                    .push((first[p], kind.linear().at(xi).n[..corners[p]].to_vec()));
            }
        }
        points
    }

    /// Their patches, each once.
    fn patches(&self) -> Vec<usize> {
        let mut patches = self.patch.clone();
        patches.sort_unstable();
        patches.dedup();
        patches
    }

    fn velocity(&self, point: usize, velocities: &DMatrix<f64>, mode: usize) -> f64 {
        let (first, shape) = &self.shapes[point];
        shape
            .iter()
            .enumerate()
            .map(|(c, n)| n * velocities[(first + c, mode)])
            .sum()
    }

    /// Modes that move any of the points, and weight times velocity, points x those modes.
    fn flows(&self, velocities: &DMatrix<f64>) -> (Vec<usize>, Mat<f32>) {
        let moves = |mode: &usize| {
            let values = velocities.column(*mode);
            let moved = |(first, shape): &(usize, Vec<f64>)| (0..shape.len()).any(|c| values[first + c] != 0.0);
            self.shapes.iter().any(moved)
        };
        let moving: Vec<usize> = (0..velocities.ncols()).filter(moves).collect();
        let flow = |i: usize, j: usize| (self.weights[i] * self.velocity(i, velocities, moving[j])) as f32;
        let flows = Mat::from_fn(self.at.len(), moving.len(), flow);
        (moving, flows)
    }
}

/// The mean of k² sin(kr)/(kr) over a range of frequencies, evenly in their logarithm, tabulated over distance.
struct Kernel {
    /// The largest wavenumber \[1/m\].
    highest: f64,
    step: f64,
    values: Vec<f64>,
}

impl Kernel {
    fn new([low, high]: [f64; 2], air: &Air, farthest: f64) -> Self {
        let wavenumber = |hz: f64| 2.0 * PI * hz / air.sound_speed;
        let rule = crate::radiation::gauss_legendre(AVERAGED);
        let numbers: Vec<(f64, f64)> = rule
            .into_iter()
            .map(|(x, w)| (wavenumber(low * (high / low).powf(0.5 * (1.0 + x))), 0.5 * w))
            .collect();
        let step = STEP / wavenumber(high);
        let value = |i: usize| {
            let r = i as f64 * step;
            let one = |&(k, w): &(f64, f64)| w * k * k * if i == 0 { 1.0 } else { (k * r).sin() / (k * r) };
            numbers.iter().map(one).sum()
        };
        let values = (0..(farthest / step).ceil() as usize + 2).map(value).collect();
        Self {
            highest: wavenumber(high),
            step,
            values,
        }
    }

    fn at(&self, r: f64) -> f64 {
        let place = r / self.step;
        let i = (place as usize).min(self.values.len() - 2);
        let t = place - i as f64;
        (1.0 - t) * self.values[i] + t * self.values[i + 1]
    }
}

/// How panels lie to each other.
struct Sheets<'a> {
    boundary: &'a Boundary,
    /// Normal of every flat panel.
    normals: Vec<Option<Vector3<f64>>>,
    /// Neighbours across edges: panel, and a point of the edge.
    beyond: Vec<Vec<(usize, Vector3<f64>)>>,
    size: f64,
}

impl<'a> Sheets<'a> {
    fn new(boundary: &'a Boundary) -> Self {
        let mesh = boundary.mesh();
        let size = boundary.extents().norm();
        let normal = |p: usize| {
            let panel = &mesh.panels[p];
            let at = mesh.points[panel.nodes()[0]];
            let normal = mesh.point_at(p, panel.kind().centre()).area_vector().normalize();
            let off = |&n: &usize| (mesh.points[n] - at).dot(&normal).abs();
            panel.nodes().iter().all(|n| off(n) <= FLAT * size).then_some(normal)
        };
        let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
        let mut beyond = vec![Vec::new(); mesh.panels.len()];
        for (p, panel) in mesh.panels.iter().enumerate() {
            let c = panel.corners();
            for k in 0..c.len() {
                let (a, b) = (c[k], c[(k + 1) % c.len()]);
                if let Some(q) = edges.insert((a.min(b), a.max(b)), p) {
                    let at = mesh.points[a].coords;
                    beyond[p].push((q, at));
                    beyond[q].push((p, at));
                }
            }
        }
        Self {
            boundary,
            normals: (0..mesh.panels.len()).map(normal).collect(),
            beyond,
            size,
        }
    }

    /// Panels that share a plane, group by group; a curved panel is a group of its own.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut known = vec![false; self.normals.len()];
        let mut groups = Vec::new();
        for seed in 0..self.normals.len() {
            if std::mem::replace(&mut known[seed], true) {
                continue;
            }
            let (mut group, mut next) = (vec![seed], 0);
            while next < group.len() {
                let p = group[next];
                next += 1;
                for &(q, _) in &self.beyond[p] {
                    let together = self.normals[p]
                        .zip(self.normals[q])
                        .is_some_and(|(a, b)| a.dot(&b) > 1.0 - FLAT);
                    if together && !std::mem::replace(&mut known[q], true) {
                        group.push(q);
                    }
                }
            }
            groups.push(group);
        }
        groups
    }

    fn face(&self, panels: Vec<usize>) -> Face {
        let (Some(normal), mesh) = (self.normals[panels[0]], self.boundary.mesh()) else {
            return Face {
                panels,
                images: vec![Image::default()],
                wall: None,
            };
        };
        let mut touched = 0u8;
        for panel in panels.iter().map(|&p| &mesh.panels[p]) {
            let c = panel.corners();
            let in_planes = |k: usize| {
                self.boundary
                    .node_of(c[k % c.len()])
                    .map_or(0, |n| self.boundary.in_planes(n))
            };
            (0..c.len()).for_each(|k| touched |= in_planes(k) & in_planes(k + 1));
        }
        let continues = |axis: usize| touched & (1 << axis) != 0 && normal[axis].abs() < FLAT;
        let planes = self.boundary.planes();
        let floor = planes[2].filter(|_| continues(2)).map(|z| Wall {
            at: Vector3::new(0.0, 0.0, z),
            normal: Vector3::z(),
        });
        let across = [0, 1].map(|axis| planes[axis].filter(|_| continues(axis)));
        let wall = floor.or_else(|| self.wall(&panels, normal, across.map(|plane| plane.is_some())));
        Face {
            panels,
            images: Image::all(&[across[0], across[1], None]),
            wall,
        }
    }

    /// The face at right angles on which this one stands, if all of it does on one side.
    fn wall(&self, panels: &[usize], normal: Vector3<f64>, across: [bool; 2]) -> Option<Wall> {
        let mesh = self.boundary.mesh();
        let centre = |p: usize| mesh.point_at(p, mesh.panels[p].kind().centre()).position.coords;
        let neighbours = panels.iter().flat_map(|&p| &self.beyond[p]);
        let walls = neighbours.filter_map(|&(q, at)| {
            let wall = Wall {
                at,
                normal: self.normals[q]?,
            };
            let rises = (centre(q) - at).dot(&normal) > FLAT * self.size;
            let upright = wall.normal.dot(&normal).abs() < FLAT;
            let own = (0..2).all(|axis| !across[axis] || wall.normal[axis].abs() < FLAT);
            let above = |&p: &usize| {
                let corners = mesh.panels[p].corners();
                corners
                    .iter()
                    .all(|&n| (mesh.points[n].coords - at).dot(&wall.normal) >= -FLAT * self.size)
            };
            (rises && upright && own && panels.iter().all(above)).then_some(wall)
        });
        walls.into_iter().next()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bem::{BoundaryMesh, SolidBox};
    use crate::radiation::{RadiatingSurface, Rayleigh, gauss_legendre};
    use nalgebra::Point3;

    const TOP: [f64; 2] = [0.5, 0.4];

    /// A quarter of a box with `TOP` above and the height \[m\], its underside at 0; on a floor or free.
    fn quarter(height: f64, floor: Option<f64>) -> Boundary {
        let of_all = [SolidBox {
            low: [-0.5 * TOP[0], -0.5 * TOP[1], 0.0],
            high: [0.5 * TOP[0], 0.5 * TOP[1], height],
            part: 0,
        }];
        let planes = [Some(0.0), Some(0.0), floor];
        let names = ["sides", "above"].map(str::to_owned).to_vec();
        let mesh = BoundaryMesh::of_boxes(&of_all, planes, 0.02, names, |side| {
            usize::from(side.axis == 2 && side.upper)
        });
        Boundary::symmetric(mesh.unwrap(), [Some(0.0); 2], floor).unwrap()
    }

    /// A plate's mode on top, and uniform motion of the faces along y that vanishes elsewhere.
    fn motion(boundary: &Boundary) -> Vec<Patterns> {
        let velocities = boundary.project(2, |panel, _, point, values| {
            let (x, normal) = (point.position, point.area_vector().normalize());
            let above = boundary.mesh().panels[panel].patch == 1;
            values[0] = f64::from(u8::from(above)) * (PI * x.x / TOP[0]).cos() * (PI * x.y / TOP[1]).cos();
            values[1] = normal.y.abs();
        });
        vec![Patterns {
            parity: Default::default(),
            velocities,
        }]
    }

    fn near(hz: f64) -> [f64; 2] {
        [hz * 0.999_95, hz * 1.000_05]
    }

    #[test]
    fn a_face_radiates_as_rayleigh_says_and_at_high_frequencies_as_a_plane_wave() {
        let boundary = quarter(0.3, None);
        let faces = Faces::new(&boundary, 0.2);
        let air = Air::default();
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (x, wx) in gauss_legendre(48) {
            for (y, wy) in gauss_legendre(48) {
                points.push(Point3::new(0.5 * TOP[0] * x, 0.5 * TOP[1] * y, 0.3));
                weights.push(0.25 * TOP[0] * TOP[1] * wx * wy);
            }
        }
        let shape = |i: usize| (PI * points[i].x / TOP[0]).cos() * (PI * points[i].y / TOP[1]).cos();
        let modes = DMatrix::from_fn(points.len(), 1, |i, _| shape(i));
        let n = points.len();
        let surface = RadiatingSurface::new(
            points.clone(),
            vec![Vector3::z(); n],
            weights,
            vec![0; n],
            vec!["top".to_owned()],
            modes,
        );
        let rayleigh = Rayleigh::new(&surface.unwrap(), &air).unwrap();
        // Below and at coincidence (549 Hz) and above.
        for hz in [200.0, 549.0, 900.0, 2000.0, 4000.0] {
            let found = faces.resistances(&motion(&boundary), &[near(hz)], &air)[0][0][1][(0, 0)];
            let exact = rayleigh.resistance(hz)[0].real[(0, 0)];
            println!("{hz} Hz: {:+.2e}", found / exact - 1.0);
            assert!((found / exact - 1.0).abs() < 2e-3, "{hz} Hz: {found} {exact}");
        }
        // sigma = (1 - kappa^2/k^2)^(-1/2) in the mean, where edges no longer matter.
        let found = &faces.resistances(&motion(&boundary), &[[4000.0, 8000.0]], &air)[0][0][1];
        let plane_wave = air.impedance() * 0.25 * TOP[0] * TOP[1];
        let sigma = (1.0 - (549.0f64 / 5700.0).powi(2)).powf(-0.5);
        assert!(
            (found[(0, 0)] / plane_wave / sigma - 1.0).abs() < 5e-3,
            "{}",
            found[(0, 0)] / plane_wave
        );
    }

    #[test]
    fn a_floor_reflects() {
        let air = Air::default();
        let (standing, free) = (quarter(0.3, Some(0.0)), quarter(0.6, None));
        for hz in [300.0, 1000.0, 2500.0] {
            let of = |boundary: &Boundary| {
                Faces::new(boundary, 0.1).resistances(&motion(boundary), &[near(hz)], &air)[0][0][0][(1, 1)]
            };
            let ratio = of(&standing) / of(&free);
            assert!((ratio - 0.5).abs() < 1e-3, "{hz} Hz: {ratio}");
        }
    }

    #[test]
    fn what_is_small_against_the_wave_radiates_as_a_plane_wave() {
        let (air, boundary) = (Air::default(), quarter(0.3, None));
        let faces = Faces::new(&boundary, 0.5);
        assert!(faces.is_empty());
        let found = faces.resistances(&motion(&boundary), &[near(100.0), near(1000.0)], &air);
        let exact = air.impedance() * 2.0 * TOP[0] * 0.3;
        for range in &found[0] {
            assert!((range[0][(1, 1)] / exact - 1.0).abs() < 1e-9);
        }
    }

    /// A block on a slab: the block's sides stand on the slab, which stands on nothing.
    #[test]
    fn faces_are_found_with_their_walls() {
        let box_of = |[x, y]: [f64; 2], [low, high]: [f64; 2], part| SolidBox {
            low: [-0.5 * x, -0.5 * y, low],
            high: [0.5 * x, 0.5 * y, high],
            part,
        };
        let boxes = [box_of([0.2, 0.1], [0.0, 0.1], 0), box_of([0.4, 0.3], [-0.05, 0.0], 1)];
        let planes = [Some(0.0), Some(0.0), None];
        let mesh = BoundaryMesh::of_boxes(&boxes, planes, 0.02, vec![String::new()], |_| 0).unwrap();
        let boundary = Boundary::symmetric(mesh, [Some(0.0); 2], None).unwrap();
        let faces = Faces::new(&boundary, 1e-3);
        let found: Vec<(usize, Option<[f64; 3]>)> = faces
            .faces
            .iter()
            .map(|f| (f.images.len(), f.wall.map(|w| w.normal.into())))
            .collect();
        // Block: top, two sides on the slab's top; slab: top, underside, two sides.
        assert_eq!(found.iter().filter(|f| **f == (2, Some([0.0, 0.0, 1.0]))).count(), 2);
        assert_eq!(found.iter().filter(|f| **f == (4, None)).count(), 3);
        assert_eq!(found.iter().filter(|f| **f == (2, None)).count(), 2);
        assert_eq!((found.len(), faces.others.len()), (7, 0));
    }
}

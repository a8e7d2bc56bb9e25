//! The flat faces of a body. At high frequencies, each radiates as if flush with an infinite plane.

mod coplanar;
mod points;

use crate::air::Air;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::symmetry::Image;
use crate::bem::solve::neumann::Patterns;
use coplanar::{CoplanarPanels, Face, Wall};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{DMatrix, Vector3};
use points::{Kernel, Points};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Flat faces of a boundary that are large compared with the wavelength, and the remaining panels.
///
/// A face radiates by Rayleigh's integral, as if flush with an infinite plane. The rest of the body is ignored.
///
/// ```text
/// R = rho0 c0 k^2/(2 pi) Phi_n^T S K S Phi_n       K_ab = sin(k r_ab)/(k r_ab)
/// ```
///
/// It approaches the equivalent radiated power for k -> infinity. Unlike that power, it depends on the ratio of the
/// wavelength on the face to that in air. A perpendicular wall (the floor, or a larger face that this one adjoins)
/// reflects: the images of the points are added. Different faces radiate independently. Panels that belong to no face,
/// for example curved ones, radiate the equivalent radiated power.
#[derive(Clone, Debug)]
pub(crate) struct Faces<'a> {
    boundary: &'a Boundary,
    faces: Vec<Face>,
    others: Vec<usize>,
}

/// Number of columns of a symmetric matrix that are evaluated before they are copied to the other triangle.
const COLUMNS: usize = 16;

/// Contribution of a face to each of its patches.
type OfPatches = Vec<(usize, DMatrix<f64>)>;

impl<'a> Faces<'a> {
    /// Finds faces at least as large as the square of `wavelength` \[m\].
    pub(crate) fn new(boundary: &'a Boundary, wavelength: f64) -> Self {
        let sheets = CoplanarPanels::new(boundary);
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

    /// Whether there are no faces.
    pub(crate) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Resistance of each patch, averaged over each frequency range \[Hz\]; by parity, then by range.
    pub(crate) fn resistances(
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

    /// Contribution of a face to its patches, by parity.
    fn of_face(&self, face: &Face, motions: &[Patterns], range: [f64; 2], air: &Air) -> Vec<OfPatches> {
        let kernel = Kernel::new(range, air, 2.0 * self.boundary.extents().norm());
        let points = Points::new(self.boundary, &face.panels, |edge| {
            // Gauss's rule resolves a wave once it has more points than half the wave's phase change across the panel.
            1 + (0.5 * kernel.highest * edge).ceil().max(1.0) as usize
        });
        let n = points.at.len();
        let axes = [0, 1, 2].map(|axis| points.at.iter().map(|x| x[axis]).collect::<Vec<f64>>());
        let of_image = |image: &Image| {
            let seen = |y: &Vector3<f64>| {
                let seen = Vector3::from_fn(|axis, _| self.boundary.mirrored(*image, axis, y[axis]));
                let reflect = |wall: Wall| seen - 2.0 * (seen - wall.at).dot(&wall.normal) * wall.normal;
                std::iter::once(seen).chain(face.wall.map(reflect)).collect::<Vec<_>>()
            };
            // The matrix is symmetric, because the images of two points are equally far from the other point:
            // reflections in perpendicular planes commute.
            let mut values = Mat::zeros(n, n);
            let mut sums = vec![0.0; n];
            for start in (0..n).step_by(COLUMNS) {
                let end = n.min(start + COLUMNS);
                let x = axes.each_ref().map(|x| &x[start..]);
                for j in start..end {
                    let (places, sums) = (seen(&points.at[j]), &mut sums[start..]);
                    kernel.between(&places, x, sums);
                    // As accurate as a stored resistance.
                    let column = values.col_as_slice_mut(j)[start..].iter_mut();
                    column.zip(sums).for_each(|(value, sum)| *value = *sum as f32);
                }
                for i in end..n {
                    for j in start..end {
                        values[(j, i)] = values[(i, j)];
                    }
                }
            }
            values
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

    /// Equivalent radiated power of the panels that belong to no face, by parity.
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bem::{BoundaryMesh, SolidBox};
    use crate::radiation::RadiatingSurface;
    use crate::radiation::flush_with_sand::Rayleigh;
    use nailnoise_meshes::gauss_legendre;
    use nalgebra::Point3;

    const TOP: [f64; 2] = [0.5, 0.4];

    /// A quarter of a box with the top `TOP` and the given height \[m\], with its underside at 0; on a floor or free.
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

    /// A plate mode of the top, and uniform motion of the side faces along y.
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
        // Below, at (549 Hz) and above coincidence.
        for hz in [200.0, 549.0, 900.0, 2000.0, 4000.0] {
            let found = faces.resistances(&motion(&boundary), &[near(hz)], &air)[0][0][1][(0, 0)];
            let exact = rayleigh.resistance(hz)[0].real[(0, 0)];
            println!("{hz} Hz: {:+.2e}", found / exact - 1.0);
            assert!((found / exact - 1.0).abs() < 2e-3, "{hz} Hz: {found} {exact}");
        }
        // On average sigma = (1 - kappa^2/k^2)^(-1/2), at frequencies where edges no longer matter.
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

    /// A block on a slab: the sides of the block adjoin the slab, whose own faces adjoin none.
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
        // Block: top, and two sides on the slab's top; slab: top, underside, two sides.
        assert_eq!(found.iter().filter(|f| **f == (2, Some([0.0, 0.0, 1.0]))).count(), 2);
        assert_eq!(found.iter().filter(|f| **f == (4, None)).count(), 3);
        assert_eq!(found.iter().filter(|f| **f == (2, None)).count(), 2);
        assert_eq!((found.len(), faces.others.len()), (7, 0));
    }
}

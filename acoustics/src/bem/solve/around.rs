//! Pressure around the body for several parities at once, and checks of field points.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::cover::joined;
use super::far_field::{Radiated, Source};
use super::problem::{Exterior, SurfacePressure};
use crate::bem::mesh::symmetry::Image;
use crate::trig::{dot, green, load, minus};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Complex, Point3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// Largest number of points processed at once.
const CHUNK: usize = 32;
/// Their number is padded to a multiple of the vector width.
const LANES: usize = 8;

/// Largest number of parities.
const PARITIES: usize = 4;

impl Exterior {
    /// For each point, whether its pressure can be evaluated: it must be above the floor, outside the body, and at
    /// least the longest panel edge away from the surface.
    ///
    /// Inside a closed surface the solid angle is complete: int d . n / (4 pi r³) dS = 1.
    pub fn is_clear(&self, points: &[Point3<f64>]) -> Vec<bool> {
        let images = self.imaged(&self.boundary().images());
        let needed = self.boundary().mesh().longest_edge();
        let floor = self.boundary().floor().unwrap_or(f64::NEG_INFINITY);
        let clear = |point: &Point3<f64>| {
            let mut angle = 0.0;
            let mut nearest = f64::INFINITY;
            for (y, area) in images.iter().flatten() {
                let d = y - point.coords;
                let r = d.norm();
                nearest = nearest.min(r);
                angle += d.dot(area) / (4.0 * PI * r.powi(3));
            }
            point.z >= floor && nearest >= needed && angle < 0.5
        };
        points.iter().map(clear).collect()
    }

    /// Radius of the body about the centre of its footprint on the floor, or about its centre in free space, and that
    /// centre \[m\].
    pub fn reach(&self) -> (f64, Point3<f64>) {
        let (_, origin, radius) = self.quadrature();
        (radius, Point3::from(origin))
    }

    /// Positions and vector areas of all quadrature points of images.
    pub(crate) fn imaged(&self, images: &[Image]) -> Vec<Vec<(Vector3<f64>, Vector3<f64>)>> {
        let boundary = self.boundary();
        let (sources, origin, _) = self.quadrature();
        let of_image = |&image: &Image| {
            let place = |source: &Source| {
                let at = source.position + origin;
                (
                    Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, at[axis])),
                    Vector3::from_fn(|axis, _| image.sign_along(axis) * source.area[axis]),
                )
            };
            sources.iter().map(place).collect()
        };
        images.iter().map(of_image).collect()
    }

    /// Complex pressure at points that are [clear](Exterior::is_clear), for every pattern of several parities at one
    /// frequency. Returns a matrix of points x patterns for each parity \[Pa s/m for velocities in m/s\]. Same as
    /// [`Exterior::pressure_at`], at the cost of one parity.
    pub(crate) fn around(&self, points: &[Point3<f64>], all: &[Radiated<'_>]) -> Vec<Mat<Complex<f64>>> {
        self.around_by(&self.boundary().images(), points, all)
    }

    /// The contribution of the given images of the surface to [`Exterior::around`]; zero without images.
    pub(crate) fn around_by(
        &self,
        images: &[Image],
        points: &[Point3<f64>],
        all: &[Radiated<'_>],
    ) -> Vec<Mat<Complex<f64>>> {
        if let Some(halves) = self.with_real_velocities(all) {
            let halves: Vec<Radiated<'_>> = halves.iter().map(|(v, p)| (v, p)).collect();
            return self
                .around_of_real(images, points, &halves)
                .iter()
                .map(joined)
                .collect();
        }
        self.around_of_real(images, points, all)
    }

    /// The same for velocities of the air that are real.
    fn around_of_real(&self, images: &[Image], points: &[Point3<f64>], all: &[Radiated<'_>]) -> Vec<Mat<Complex<f64>>> {
        let zeros = |a: &Radiated<'_>| Mat::zeros(points.len(), a.0.ncols());
        let mut result: Vec<Mat<Complex<f64>>> = all.iter().map(zeros).collect();
        if images.is_empty() {
            return result;
        }
        let (nodes, values) = (self.boundary().nodes(), self.boundary().velocity_values());
        let (sources, _, _) = self.quadrature();
        let omega = 2.0 * PI * all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = omega / self.air().sound_speed;
        let on_flow = omega * self.air().density;
        let signs: Vec<Vec<f64>> = all
            .iter()
            .map(|(_, s)| images.iter().map(|&image| s.parity.sign(image)).collect())
            .collect();
        let images = self.imaged(images);
        // Real and imaginary part of the pressure.
        let pressures: Vec<[Mat<f64>; 2]> = all
            .iter()
            .map(|(_, SurfacePressure { pressure: p, .. })| {
                [
                    Mat::from_fn(nodes, p.ncols(), |i, m| p[(i, m)].re),
                    Mat::from_fn(nodes, p.ncols(), |i, m| p[(i, m)].im),
                ]
            })
            .collect();
        let mut on_p = vec![[Vec::new(), Vec::new()]; all.len()];
        let mut on_v = on_p.clone();
        for start in (0..points.len()).step_by(CHUNK) {
            let chunk = &points[start..points.len().min(start + CHUNK)];
            let width = chunk.len().next_multiple_of(LANES);
            // Incomplete vectors repeat the last point.
            let place = |axis: usize| std::array::from_fn(|i| chunk[i.min(chunk.len() - 1)][axis]);
            for (parts, rows) in [(&mut on_p, nodes), (&mut on_v, values)] {
                for part in parts.iter_mut().flatten() {
                    part.clear();
                    part.resize(rows * width, 0.0);
                }
            }
            Arch::new().dispatch(Waves {
                sources: &sources,
                images: &images,
                signs: &signs,
                k,
                points: [0, 1, 2].map(place),
                width,
                on_p: &mut on_p,
                on_v: &mut on_v,
            });
            for ((((to, pressure), (v, _)), on_p), on_v) in
                result.iter_mut().zip(&pressures).zip(all).zip(&on_p).zip(&on_v)
            {
                let modes = to.ncols();
                let mut sums = [0, 1].map(|_| Mat::<f64>::zeros(width, modes));
                let of = |m: &Vec<f64>, by: MatRef<'_, f64>, factor: f64, to: &mut Mat<f64>| {
                    let m = MatRef::from_column_major_slice(m, width, by.nrows());
                    matmul(to.as_mut(), Accum::Add, m, by, factor, Par::Seq);
                };
                let [re, im] = pressure.each_ref().map(Mat::as_ref);
                let flow = MatRef::from_column_major_slice(v.as_slice(), values, modes);
                // (a + jb)(p + jq) + j (c + jd) f
                of(&on_p[0], re, 1.0, &mut sums[0]);
                of(&on_p[1], im, -1.0, &mut sums[0]);
                of(&on_v[1], flow, -on_flow, &mut sums[0]);
                of(&on_p[0], im, 1.0, &mut sums[1]);
                of(&on_p[1], re, 1.0, &mut sums[1]);
                of(&on_v[0], flow, on_flow, &mut sums[1]);
                for row in 0..chunk.len() {
                    for mode in 0..modes {
                        to[(start + row, mode)] = Complex::new(sums[0][(row, mode)], sums[1][(row, mode)]);
                    }
                }
            }
        }
        result
    }
}

/// dG/dn and G, summed over all images, for a chunk of points and every parity.
struct Waves<'a> {
    sources: &'a [Source],
    images: &'a [Vec<(Vector3<f64>, Vector3<f64>)>],
    /// Signs of the images, by parity.
    signs: &'a [Vec<f64>],
    k: f64,
    points: [[f64; CHUNK]; 3],
    /// Number of points, including the repeated ones.
    width: usize,
    /// Weighted with the corner functions of the unknowns: parity, real and imaginary part, unknown, point.
    on_p: &'a mut [[Vec<f64>; 2]],
    /// Weighted with the corner functions of the panels: parity, real and imaginary part, velocity value, point.
    on_v: &'a mut [[Vec<f64>; 2]],
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: &Vector3<f64>) -> [S::f64s; 3] {
    [simd.splat_f64s(v.x), simd.splat_f64s(v.y), simd.splat_f64s(v.z)]
}

impl WithSimd for Waves<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (lanes, k) = (S::F64_LANES, simd.splat_f64s(self.k));
        let (zero, scale) = (simd.splat_f64s(0.0), simd.splat_f64s(0.25 / PI));
        for (number, source) in self.sources.iter().enumerate() {
            for first in (0..self.width).step_by(lanes) {
                let x = [
                    load::<S>(&self.points[0], first),
                    load::<S>(&self.points[1], first),
                    load::<S>(&self.points[2], first),
                ];
                let mut sums = [[zero; 4]; PARITIES];
                for (image, of_image) in self.images.iter().enumerate() {
                    let (y, area) = &of_image[number];
                    let d = minus(simd, x, splat(simd, y));
                    let along = dot(simd, d, splat(simd, area));
                    let [g_re, g_im, h_re, h_im] = green(simd, dot(simd, d, d), k, scale);
                    let slope = [simd.mul_f64s(h_re, along), simd.mul_f64s(h_im, along)];
                    for parity in 0..self.signs.len() {
                        let sign = simd.splat_f64s(self.signs[parity][image]);
                        let sum = &mut sums[parity];
                        sum[0] = simd.mul_add_e_f64s(sign, slope[0], sum[0]);
                        sum[1] = simd.mul_add_e_f64s(sign, slope[1], sum[1]);
                        sum[2] = simd.mul_add_e_f64s(sign, g_re, sum[2]);
                        sum[3] = simd.mul_add_e_f64s(sign, g_im, sum[3]);
                    }
                }
                for parity in 0..self.signs.len() {
                    let sum = sums[parity];
                    for part in 0..2 {
                        let flow = simd.mul_f64s(simd.splat_f64s(source.weight), sum[2 + part]);
                        for j in 0..source.corners {
                            let phi = simd.splat_f64s(source.phi[j]);
                            let at = source.nodes[j] * self.width + first;
                            let to = &mut self.on_p[parity][part][at..at + lanes];
                            let to = &mut S::as_mut_simd_f64s(to).0[0];
                            *to = simd.mul_add_e_f64s(phi, sum[part], *to);
                            let at = (source.first_value + j) * self.width + first;
                            let to = &mut self.on_v[parity][part][at..at + lanes];
                            let to = &mut S::as_mut_simd_f64s(to).0[0];
                            *to = simd.mul_add_e_f64s(phi, flow, *to);
                        }
                    }
                }
            }
        }
    }
}

//! Pressure around the body for several parities at once, and where points around it may stand.

use super::far_field::{Radiated, Source};
use super::problem::Exterior;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{Complex, Point3, Vector3};
use std::f64::consts::PI;

/// Points worked on at once.
const CHUNK: usize = 32;

impl Exterior {
    /// Whether the pressure at each point can be evaluated: it lies above the floor, outside the body, and off its
    /// surface by the longest edge of a panel.
    ///
    /// Inside a closed surface the solid angle is whole, int d . n / (4 pi r³) dS = 1.
    pub fn is_clear(&self, points: &[Point3<f64>]) -> Vec<bool> {
        let images = self.imaged();
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

    /// Radius of the body around the middle of its foot on the floor, or around its centre in free space, and that
    /// middle \[m\].
    pub fn reach(&self) -> (f64, Point3<f64>) {
        let (_, origin, radius) = self.quadrature();
        (radius, Point3::from(origin))
    }

    /// Positions and vector areas of all quadrature points of each image, the surface itself first.
    fn imaged(&self) -> Vec<Vec<(Vector3<f64>, Vector3<f64>)>> {
        let boundary = self.boundary();
        let (sources, origin, _) = self.quadrature();
        let of_image = |image| {
            let place = |source: &Source| {
                let at = source.position + origin;
                (
                    Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, at[axis])),
                    Vector3::from_fn(|axis, _| image.sign_along(axis) * source.area[axis]),
                )
            };
            sources.iter().map(place).collect()
        };
        boundary.images().into_iter().map(of_image).collect()
    }

    /// Complex pressure at points that are [clear](Exterior::is_clear) for every pattern of several parities of one
    /// frequency, for each parity points x patterns \[Pa s/m for velocities in m/s\]: as [`Exterior::pressure_at`], at the
    /// cost of one parity.
    pub(super) fn around(&self, points: &[Point3<f64>], all: &[Radiated<'_>]) -> Vec<Mat<Complex<f64>>> {
        let boundary = self.boundary();
        let (nodes, values) = (boundary.nodes(), boundary.velocity_values());
        let (sources, _, _) = self.quadrature();
        let imaged = self.imaged();
        let omega = 2.0 * PI * all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = omega / self.air().sound_speed;
        let on_flow = Complex::new(0.0, omega * self.air().density);
        let signs: Vec<Vec<f64>> = all
            .iter()
            .map(|(_, s)| {
                boundary
                    .images()
                    .into_iter()
                    .map(|image| s.parity.sign(image))
                    .collect()
            })
            .collect();
        let pressures: Vec<Mat<Complex<f64>>> = all
            .iter()
            .map(|(_, s)| Mat::from_fn(nodes, s.pressure.ncols(), |i, m| s.pressure[(i, m)]))
            .collect();
        let flows: Vec<Mat<Complex<f64>>> = all
            .iter()
            .map(|(v, _)| Mat::from_fn(values, v.ncols(), |i, m| on_flow * v[(i, m)]))
            .collect();
        let mut result: Vec<Mat<Complex<f64>>> =
            pressures.iter().map(|p| Mat::zeros(points.len(), p.ncols())).collect();
        for start in (0..points.len()).step_by(CHUNK) {
            let chunk = &points[start..points.len().min(start + CHUNK)];
            let mut on_p = vec![Mat::<Complex<f64>>::zeros(nodes, chunk.len()); all.len()];
            let mut on_v = vec![Mat::<Complex<f64>>::zeros(values, chunk.len()); all.len()];
            let mut waves = vec![[Complex::default(); 2]; imaged.len()];
            for (row, point) in chunk.iter().enumerate() {
                for (number, source) in sources.iter().enumerate() {
                    for (wave, image) in waves.iter_mut().zip(&imaged) {
                        let (y, area) = &image[number];
                        let d = point.coords - y;
                        let inverse = 1.0 / d.norm();
                        let (sine, cosine) = (k / inverse).sin_cos();
                        let size = inverse / (4.0 * PI);
                        let g = Complex::new(size * cosine, -size * sine);
                        let along = d.dot(area) * inverse * inverse;
                        *wave = [g * Complex::new(along, along * k / inverse), g * source.weight];
                    }
                    for (parity, signs) in signs.iter().enumerate() {
                        let mut sums = [Complex::default(); 2];
                        for (wave, sign) in waves.iter().zip(signs) {
                            sums[0] += wave[0] * *sign;
                            sums[1] += wave[1] * *sign;
                        }
                        let (mut on_p, mut on_v) = (on_p[parity].col_mut(row), on_v[parity].col_mut(row));
                        for j in 0..source.corners {
                            on_p[source.nodes[j]] += sums[0] * source.phi[j];
                            on_v[source.first_value + j] += sums[1] * source.phi[j];
                        }
                    }
                }
            }
            for (parity, to) in result.iter_mut().enumerate() {
                let mut to = to.as_mut().subrows_mut(start, chunk.len());
                let one = Complex::from(1.0);
                let (p, v) = (on_p[parity].transpose(), on_v[parity].transpose());
                matmul(
                    to.as_mut(),
                    Accum::Replace,
                    p,
                    pressures[parity].as_ref(),
                    one,
                    Par::Seq,
                );
                matmul(to.as_mut(), Accum::Add, v, flows[parity].as_ref(), one, Par::Seq);
            }
        }
        result
    }
}

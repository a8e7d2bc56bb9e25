#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use crate::bem::error::BemError;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::operators::blocks::{Block, N, W, X, fields};
use crate::bem::operators::far::corner_values;
use crate::bem::solver::problem::{Exterior, SurfacePressure};
use crate::checks::same_length;
use crate::trig::{load, load3, sin_cos};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nailnoise_meshes::FaceKind;
use nailnoise_meshes::gauss_legendre;
use nalgebra::{DMatrix, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Directions worked on at once.
const CHUNK: usize = 48;

/// A quadrature point: position, vector area, area, unknowns and velocity values with their corner functions.
pub(crate) struct Source {
    pub(crate) position: Vector3<f64>,
    pub(crate) area: Vector3<f64>,
    pub(crate) weight: f64,
    pub(crate) corners: usize,
    pub(crate) nodes: [usize; 4],
    pub(crate) first_value: usize,
    pub(crate) phi: [f64; 4],
}

/// A pressure on the surface with the velocities that cause it.
pub(crate) type Radiated<'a> = (&'a DMatrix<f64>, &'a SurfacePressure);

impl Exterior {
    /// Radiation resistance R (patterns x patterns) from the far field of the surface's pressure and velocity:
    ///
    /// ```text
    /// p -> e^{-jkr}/(4 pi r) F(d)     F(d) = int e^{jk d.y} (jk d.n p + j omega rho v_n) dS
    /// R = 1/(16 pi² rho c) Re int F^H F dOmega
    /// ```
    ///
    /// with the images in floor and mirror planes and the half space above the floor. Symmetric and positive
    /// semidefinite by construction, and independent of [`Exterior::impedance`], which integrates the intensity on the surface.
    ///
    /// # Errors
    /// Patterns or pressures of another length.
    pub fn far_field_resistance(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<DMatrix<f64>, BemError> {
        self.check_velocities(velocities)?;
        let mut all = self.far_field_resistances(&[(&self.at_points(velocities), solution)])?;
        Ok(all.pop().unwrap_or_default())
    }

    /// The same for several solutions at one frequency, whose waves are evaluated once, with the velocities at the points of
    /// all blocks, see [`Exterior::at_points`].
    pub(crate) fn far_field_resistances(
        &self,
        all: &[(&Mat<f32>, &SurfacePressure)],
    ) -> Result<Vec<DMatrix<f64>>, BemError> {
        let boundary = self.boundary();
        for (_, solution) in all {
            same_length("rows of the pressure", solution.pressure.nrows(), boundary.nodes())?;
        }
        let hz = all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let (sources, _, radius) = self.quadrature();
        let across = sources.iter().map(|s| s.position.xy().norm()).fold(0.0, f64::max);
        let planes = boundary.planes().map(|plane| plane.is_some());
        let directions = directions([k * radius, k * across], planes);
        let mut totals: Vec<Mat<f64>> = all.iter().map(|(v, _)| Mat::zeros(v.nrows(), v.nrows())).collect();
        self.in_directions(all, k, &directions, |chunk, parts| {
            for (part, total) in parts.iter().zip(&mut totals) {
                part.add_power(chunk, k, self.air().impedance(), total);
            }
        });
        Ok(totals.iter().map(resistance).collect())
    }

    /// Evaluates the waves of chunks of directions at all points; `each` receives the far field of every part.
    fn in_directions(
        &self,
        all: &[(&Mat<f32>, &SurfacePressure)],
        k: f64,
        directions: &[(Vector3<f64>, f64)],
        mut each: impl FnMut(&[(Vector3<f64>, f64)], &[Radiating<'_>]),
    ) {
        let boundary = self.boundary();
        let (_, origin, _) = self.quadrature();
        let planes = boundary.planes().map(|plane| plane.is_some());
        let (n, points) = (
            boundary.nodes(),
            self.blocks().iter().map(|b| b.corners * b.width).sum(),
        );
        let mut parts: Vec<Radiating<'_>> = all
            .iter()
            .map(|(v, solution)| Radiating::new(v, solution, planes))
            .collect();
        let odd: Vec<[bool; 3]> = all
            .iter()
            .map(|(_, s)| [0, 1, 2].map(|axis| s.parity.is_odd(axis)))
            .collect();
        let (mut corners, mut flows) = (Vec::new(), Vec::new());
        for chunk in directions.chunks(CHUNK) {
            let rows = chunk.len();
            parts.iter_mut().for_each(|part| part.clear(n, points, rows));
            for (row, (d, _)) in chunk.iter().enumerate() {
                let mut first = 0;
                for block in self.blocks() {
                    let size = 2 * block.corners * block.width;
                    corners.clear();
                    corners.resize(all.len() * size, 0.0);
                    flows.resize(all.len() * size, 0.0);
                    Arch::new().dispatch(Waves {
                        block,
                        direction: [k * d.x, k * d.y, k * d.z],
                        origin: [origin.x, origin.y, origin.z],
                        planes,
                        odd: &odd,
                        corners: &mut corners,
                        flows: &mut flows,
                    });
                    for ((part, corners), flows) in parts.iter_mut().zip(corners.chunks(size)).zip(flows.chunks(size)) {
                        part.add_corners(block, corners, row);
                        part.set_flows(flows, row * points + first);
                    }
                    first += block.corners * block.width;
                }
            }
            each(chunk, &parts);
        }
    }

    /// Far field F of every pattern of several parities in some directions, for each parity directions x patterns
    /// \[Pa s for velocities in m/s\]: p -> e^{-jkr}/(4 pi r) F, r the distance to the origin of [`Exterior::quadrature`].
    pub(crate) fn far_fields(&self, all: &[Radiated<'_>], directions: &[Vector3<f64>]) -> Vec<Mat<Complex<f64>>> {
        let hz = all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let count = |a: &Radiated<'_>| a.0.ncols();
        let mut fields: Vec<Mat<Complex<f64>>> = all.iter().map(|a| Mat::zeros(directions.len(), count(a))).collect();
        let directions: Vec<(Vector3<f64>, f64)> = directions.iter().map(|d| (*d, 1.0)).collect();
        let mut first = 0;
        let at_points: Vec<Mat<f32>> = all.iter().map(|a| self.at_points(a.0)).collect();
        let all: Vec<(&Mat<f32>, &SurfacePressure)> = at_points.iter().zip(all).map(|(v, a)| (v, a.1)).collect();
        self.in_directions(&all, k, &directions, |chunk, parts| {
            for (part, to) in parts.iter().zip(&mut fields) {
                let field = part.field(chunk.len(), k, self.air().impedance());
                for row in 0..chunk.len() {
                    for mode in 0..to.ncols() {
                        to[(first + row, mode)] = Complex::new(field[(mode, row)], field[(mode, chunk.len() + row)]);
                    }
                }
            }
            first += chunk.len();
        });
        fields
    }

    /// All quadrature points relative to an origin (the body's centre, or its foot on the floor), the origin, and the
    /// radius around it that holds them.
    pub(crate) fn quadrature(&self) -> (Vec<Source>, Vector3<f64>, f64) {
        let mut sources = Vec::new();
        for block in self.blocks() {
            let rule = rules::far(block.corners);
            let kind = if block.corners == 3 {
                FaceKind::Tri3
            } else {
                FaceKind::Quad4
            };
            for f in 0..block.panels.len() {
                for (b, (xi, _)) in rule.iter().enumerate() {
                    let get = |field: usize| block.points[(b * fields(block.corners) + field) * block.width + f];
                    let shape = kind.at(*xi);
                    sources.push(Source {
                        position: Vector3::new(get(X), get(X + 1), get(X + 2)),
                        area: Vector3::new(get(N), get(N + 1), get(N + 2)),
                        weight: get(W),
                        corners: block.corners,
                        nodes: block.local[f].map(|l| block.nodes[l]),
                        first_value: block.first_value[f],
                        phi: std::array::from_fn(|j| shape.n[j]),
                    });
                }
            }
        }
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for source in &sources {
            low = low.inf(&source.position);
            high = high.sup(&source.position);
        }
        let mut origin = 0.5 * (low + high);
        for (axis, plane) in self.boundary().planes().iter().enumerate() {
            origin[axis] = plane.unwrap_or(origin[axis]);
        }
        let mut radius: f64 = 0.0;
        for source in &mut sources {
            source.position -= origin;
            radius = radius.max(source.position.norm());
        }
        (sources, origin, radius)
    }
}

/// The far field of the patterns of one parity. With both mirrors and a floor, waves are real up to a power of j, and
/// only their real or imaginary part is stored. In single precision, as the pressure that radiates was solved.
struct Radiating<'a> {
    /// Real and imaginary part of the pressure side by side, unknowns x 2 patterns.
    pressure: Mat<f32>,
    /// Velocities at the points of the far rule, patterns x points.
    velocities: &'a Mat<f32>,
    /// Whether waves have a real and an imaginary part.
    parts: Vec<usize>,
    /// Unknowns x directions and points x directions, for each part.
    on_p: [Mat<f32>; 2],
    on_v: [Vec<f32>; 2],
}

impl<'a> Radiating<'a> {
    fn new(velocities: &'a Mat<f32>, solution: &SurfacePressure, planes: [bool; 3]) -> Self {
        let (n, modes) = (solution.pressure.nrows(), velocities.nrows());
        let odd = (0..3).filter(|&axis| solution.parity.is_odd(axis)).count();
        Self {
            pressure: Mat::from_fn(n, 2 * modes, |node, column| {
                let p = solution.pressure[(node, column % modes)];
                (if column < modes { p.re } else { p.im }) as f32
            }),
            velocities,
            parts: if planes == [true; 3] { vec![odd % 2] } else { vec![0, 1] },
            on_p: [Mat::new(), Mat::new()],
            on_v: [Vec::new(), Vec::new()],
        }
    }

    fn clear(&mut self, n: usize, points: usize, rows: usize) {
        for &part in &self.parts {
            self.on_p[part] = Mat::zeros(n, rows);
            self.on_v[part].resize(points * rows, 0.0);
        }
    }

    fn add_corners(&mut self, block: &Block, corners: &[f64], row: usize) {
        let size = block.corners * block.width;
        for &part in &self.parts {
            let mut to = self.on_p[part].col_mut(row);
            for j in 0..block.corners {
                let from = &corners[part * size + j * block.width..];
                for (value, local) in from.iter().zip(&block.local) {
                    to[block.nodes[local[j]]] += *value as f32;
                }
            }
        }
    }

    /// Stores the waves of a block's points, times the points' areas.
    fn set_flows(&mut self, flows: &[f64], at: usize) {
        let size = flows.len() / 2;
        for &part in &self.parts {
            let to = &mut self.on_v[part][at..at + size];
            let from = &flows[part * size..(part + 1) * size];
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from as f32);
        }
    }

    /// F of all patterns in the directions of a chunk, patterns x 2 directions: real parts, then imaginary ones.
    fn field(&self, rows: usize, k: f64, impedance: f64) -> Mat<f64> {
        let modes = self.velocities.nrows();
        let mut field = Mat::<f64>::zeros(modes, 2 * rows);
        for &part in &self.parts {
            let mut from_p = Mat::<f32>::zeros(2 * modes, rows);
            let mut from_v = Mat::<f32>::zeros(modes, rows);
            matmul(
                from_p.as_mut(),
                Accum::Replace,
                self.pressure.transpose(),
                self.on_p[part].as_ref(),
                1.0,
                Par::Seq,
            );
            let on_v = MatRef::from_column_major_slice(&self.on_v[part], self.velocities.ncols(), rows);
            matmul(
                from_v.as_mut(),
                Accum::Replace,
                self.velocities.as_ref(),
                on_v,
                1.0,
                Par::Seq,
            );
            for row in 0..rows {
                let (re, im) = from_p.col_as_slice(row).split_at(modes);
                for (m, ((&re, &im), &flow)) in re.iter().zip(im).zip(from_v.col_as_slice(row)).enumerate() {
                    let all = Complex::new(f64::from(re), f64::from(im) + k * impedance * f64::from(flow));
                    let all = if part == 0 { all } else { all * Complex::i() };
                    field[(m, row)] += all.re;
                    field[(m, rows + row)] += all.im;
                }
            }
        }
        field
    }

    /// Adds the power of all patterns in the directions of a chunk.
    fn add_power(&self, chunk: &[(Vector3<f64>, f64)], k: f64, impedance: f64, total: &mut Mat<f64>) {
        let rows = chunk.len();
        let mut field = self.field(rows, k, impedance);
        for (row, (_, w)) in chunk.iter().enumerate() {
            let root = (w / impedance).sqrt() / (4.0 * PI);
            for column in [row, rows + row] {
                field.col_mut(column).iter_mut().for_each(|f| *f *= root);
            }
        }
        matmul(
            total.as_mut(),
            Accum::Add,
            field.as_ref(),
            field.transpose(),
            1.0,
            Par::Seq,
        );
    }
}

/// R from the sum over the directions, symmetric to the bit.
fn resistance(total: &Mat<f64>) -> DMatrix<f64> {
    let modes = total.nrows();
    DMatrix::from_fn(modes, modes, |i, j| total[(i.min(j), i.max(j))])
}

/// e^{jk d.y} with its images at the points of a block: one direction, all parities.
struct Waves<'a> {
    block: &'a Block,
    /// k d.
    direction: [f64; 3],
    origin: [f64; 3],
    planes: [bool; 3],
    odd: &'a [[bool; 3]],
    /// k d . n e^{jk d.y} by corner functions: parity, part, corner, panel.
    corners: &'a mut [f64],
    /// e^{jk d.y} times the area: parity, part, point, panel.
    flows: &'a mut [f64],
}

impl WithSimd for Waves<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.block.corners {
            3 => self.run::<S, 3>(simd),
            _ => self.run::<S, 4>(simd),
        }
    }
}

/// A factor of e^{jk d.y}, with its image along one axis: f(t) and its derivative, t = k d_a y_a.
///
/// e^{jt} alone, 2 cos t with the image of a field that continues evenly across the plane t = 0, 2j sin t with that of
/// one that changes its sign.
#[inline(always)]
fn standing<S: Simd>(simd: S, t: S::f64s, plane: bool, odd: bool) -> [[S::f64s; 2]; 2] {
    let (sine, cosine) = sin_cos(simd, t);
    let (zero, two) = (simd.splat_f64s(0.0), simd.splat_f64s(2.0));
    let less = simd.neg_f64s(sine);
    match (plane, odd) {
        (false, _) => [[cosine, sine], [less, cosine]],
        (true, false) => [[simd.mul_f64s(two, cosine), zero], [simd.mul_f64s(two, less), zero]],
        (true, true) => [[zero, simd.mul_f64s(two, sine)], [zero, simd.mul_f64s(two, cosine)]],
    }
}

#[inline(always)]
fn times<S: Simd>(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> [S::f64s; 2] {
    [
        simd.negate_mul_add_e_f64s(a[1], b[1], simd.mul_f64s(a[0], b[0])),
        simd.mul_add_e_f64s(a[0], b[1], simd.mul_f64s(a[1], b[0])),
    ]
}

impl Waves<'_> {
    #[inline(always)]
    fn run<S: Simd, const E: usize>(self, simd: S) {
        let phi = corner_values::<E>();
        let (width, lanes) = (self.block.width, S::F64_LANES);
        let size = E * width;
        let zero = simd.splat_f64s(0.0);
        for chunk in 0..width / lanes {
            for b in 0..E {
                let start = b * fields(E) * width + chunk * lanes;
                let y = load3::<S>(&self.block.points, start + X * width, width);
                let n = load3::<S>(&self.block.points, start + N * width, width);
                let w = load::<S>(&self.block.points, start + W * width);
                // Value and slope of either sign, axis by axis.
                let mut waves = [[[[zero; 2]; 2]; 2]; 3];
                for c in 0..3 {
                    let (d, from) = (simd.splat_f64s(self.direction[c]), simd.splat_f64s(self.origin[c]));
                    let t = simd.mul_f64s(d, simd.sub_f64s(y[c], from));
                    waves[c][0] = standing(simd, t, self.planes[c], false);
                    waves[c][1] = standing(simd, t, self.planes[c], true);
                }
                for p in 0..self.odd.len() {
                    let odd = self.odd[p];
                    let [x, y, z] = [
                        waves[0][usize::from(odd[0])],
                        waves[1][usize::from(odd[1])],
                        waves[2][usize::from(odd[2])],
                    ];
                    let xy = times(simd, x[0], y[0]);
                    let value = times(simd, xy, z[0]);
                    let by_x = times(simd, times(simd, x[1], y[0]), z[0]);
                    let by_y = times(simd, times(simd, x[0], y[1]), z[0]);
                    let by_z = times(simd, xy, z[1]);
                    let by = [by_x, by_y, by_z];
                    let mut slope = [zero; 2];
                    for c in 0..3 {
                        let along = simd.mul_f64s(simd.splat_f64s(self.direction[c]), n[c]);
                        slope[0] = simd.mul_add_e_f64s(along, by[c][0], slope[0]);
                        slope[1] = simd.mul_add_e_f64s(along, by[c][1], slope[1]);
                    }
                    for part in 0..2 {
                        let at = (2 * p + part) * size + b * width + chunk * lanes;
                        let to = &mut self.flows[at..at + lanes];
                        S::as_mut_simd_f64s(to).0[0] = simd.mul_f64s(value[part], w);
                        for j in 0..E {
                            let start = (2 * p + part) * size + j * width + chunk * lanes;
                            let to = &mut S::as_mut_simd_f64s(&mut self.corners[start..start + lanes]).0[0];
                            *to = simd.mul_add_e_f64s(simd.splat_f64s(phi[b][j]), slope[part], *to);
                        }
                    }
                }
            }
        }
    }
}

/// Highest order of the spherical or cylindrical harmonics of a wave at the distance x / k from their origin (Wiscombe
/// 1980, rounded up).
fn order(x: f64) -> usize {
    (x + 4.0 * x.cbrt() + 4.0).ceil() as usize
}

/// Directions and weights that integrate the squared far field of a body over the unit sphere, or over its half above the
/// floor. k times its largest distance from the origin, `ka`, limits the spherical harmonics; that from the vertical axis,
/// `across`, times the sine of the polar angle limits those around the axis (Jacobi & Anger's expansion). With mirror
/// planes only the directions above them are listed, the others contribute as much.
fn directions([ka, across]: [f64; 2], planes: [bool; 3]) -> Vec<(Vector3<f64>, f64)> {
    let copies: f64 = planes[..2]
        .iter()
        .map(|mirror| if *mirror { 2.0 } else { 1.0 })
        .product();
    let mut result = Vec::new();
    for (z, w) in gauss_legendre((order(ka) + 1).next_multiple_of(2)) {
        if planes[2] && z < 0.0 {
            continue;
        }
        let r = (1.0 - z * z).sqrt();
        let around = (2 * order(across * r) + 1).next_multiple_of(4);
        for i in 0..around {
            // Half a step off the planes, so that every direction has its images.
            let (sine, cosine) = (2.0 * PI * (i as f64 + 0.5) / around as f64).sin_cos();
            if planes[0] && cosine < 0.0 || planes[1] && sine < 0.0 {
                continue;
            }
            let weight = copies * w * 2.0 * PI / around as f64;
            result.push((Vector3::new(r * cosine, r * sine, z), weight));
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// int e^{jk d.(x - y)} dOmega = 4 pi sin(kr)/kr, r = |x - y|, for points x, y of a cylinder.
    #[test]
    fn directions_integrate_the_waves_of_any_two_points() {
        for k in [0.1, 2.0, 15.0, 60.0] {
            let (across, half_height) = (0.5, 0.9);
            let ka = k * f64::hypot(across, half_height);
            let directions = directions([ka, k * across], [false; 3]);
            let place = |i: usize| {
                let angle = 2.4 * i as f64;
                let height = half_height * (1.0 - 2.0 * ((i * i) % 7) as f64 / 6.0);
                Vector3::new(across * angle.cos(), across * angle.sin(), height)
            };
            for (i, j) in (0..14).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let apart = place(i) - place(j);
                let found: f64 = directions.iter().map(|(d, w)| w * (k * d.dot(&apart)).cos()).sum();
                let kr = k * apart.norm();
                let exact = 4.0 * PI * if kr == 0.0 { 1.0 } else { kr.sin() / kr };
                assert!(
                    (found - exact).abs() < 1e-5 * 4.0 * PI,
                    "k {k}, {i}, {j}: {found} {exact}"
                );
            }
        }
    }
}

#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::cover::joined;
use super::neumann::at_points;
use super::problem::{Exterior, SurfacePressure, Threads};
use crate::bem::error::BemError;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::operators::blocks::{Block, N, W, X, fields};
use crate::bem::operators::far::corner_values;
use crate::bem::operators::kernel::load;
use crate::checks::same_length;
use crate::trig::single::sin_cos;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nailnoise_meshes::FaceKind;
use nailnoise_meshes::gauss_legendre;
use nalgebra::{DMatrix, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// Number of directions processed at once.
const CHUNK: usize = 48;

/// Number of portions into which the directions are divided for two threads.
const SHARES: usize = 2;

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

/// Velocities, and the surface pressure that they cause.
pub(crate) type Radiated<'a> = (&'a DMatrix<f64>, &'a SurfacePressure);

impl Exterior {
    /// Radiation resistance R (patterns x patterns) from the far field of the surface's pressure and velocity. The
    /// images in floor and mirror planes are included; with a floor, the far field is integrated over the half space
    /// above it.
    ///
    /// ```text
    /// p -> e^{-jkr}/(4 pi r) F(d)     F(d) = int e^{jk d.y} (jk d.n p + j omega rho v_n) dS
    /// R = 1/(16 pi² rho c) Re int F^H F dOmega
    /// ```
    ///
    /// By construction, R is symmetric and positive semidefinite. It is independent of [`Exterior::impedance`], which
    /// integrates the intensity on the surface.
    ///
    /// # Errors
    /// If patterns or pressures have the wrong length.
    pub fn far_field_resistance(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<DMatrix<f64>, BemError> {
        self.check_velocities(velocities)?;
        let mut all = self.far_field_resistances(&[(&at_points(self.blocks(), velocities), solution)], Threads::One)?;
        Ok(all.pop().unwrap_or_default())
    }

    /// The same for several solutions at one frequency, whose waves are evaluated only once; velocities are given at
    /// the points of all blocks, see [`at_points`].
    pub(crate) fn far_field_resistances(
        &self,
        all: &[(&Mat<f32>, &SurfacePressure)],
        threads: Threads,
    ) -> Result<Vec<DMatrix<f64>>, BemError> {
        let boundary = self.boundary();
        for (_, solution) in all {
            same_length("rows of the pressure", solution.pressure.nrows(), boundary.nodes())?;
        }
        let hz = all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let directions = self.directions(k);
        let of_share = |directions: &[(Vector3<f64>, f64)]| {
            let mut totals: Vec<Mat<f64>> = all.iter().map(|(v, _)| Mat::zeros(v.nrows(), v.nrows())).collect();
            self.in_directions(all, k, directions, |chunk, parts| {
                for (part, total) in parts.iter().zip(&mut totals) {
                    part.add_power(chunk, k, self.air().impedance(), total);
                }
            });
            totals
        };
        // Portions for the threads, which do not depend on their number.
        let share = directions.len().div_ceil(SHARES).next_multiple_of(CHUNK).max(CHUNK);
        let shares = threads.map(directions.chunks(share).collect(), of_share);
        let mut totals: Vec<Mat<f64>> = all.iter().map(|(v, _)| Mat::zeros(v.nrows(), v.nrows())).collect();
        for share in shares {
            totals.iter_mut().zip(share).for_each(|(total, part)| *total += part);
        }
        Ok(totals.iter().map(resistance).collect())
    }

    /// The same for solutions on a covered surface, whose R is Hermitian: real parts, then imaginary parts.
    pub(crate) fn far_field_powers(&self, all: &[Radiated<'_>]) -> Vec<[DMatrix<f64>; 2]> {
        let hz = all.first().map_or(0.0, |(_, solution)| solution.hz);
        let directions = self.directions(self.wavenumber(hz));
        let along: Vec<Vector3<f64>> = directions.iter().map(|(d, _)| *d).collect();
        let of_field = |field: Mat<Complex<f64>>| {
            let root = |row: usize| (directions[row].1 / self.air().impedance()).sqrt() / (4.0 * PI);
            let part = |of: fn(Complex<f64>) -> f64| {
                Mat::from_fn(field.nrows(), field.ncols(), |row, m| root(row) * of(field[(row, m)]))
            };
            let [re, im] = [part(|z| z.re), part(|z| z.im)];
            let product = |a: &Mat<f64>, b: &Mat<f64>| a.transpose() * b;
            let (real, half) = (product(&re, &re) + product(&im, &im), product(&re, &im));
            let modes = field.ncols();
            [
                resistance(&real),
                DMatrix::from_fn(modes, modes, |i, j| half[(i, j)] - half[(j, i)]),
            ]
        };
        self.far_fields(all, &along).into_iter().map(of_field).collect()
    }

    /// Directions and weights that integrate the power at the wavenumber k.
    fn directions(&self, k: f64) -> Vec<(Vector3<f64>, f64)> {
        let (sources, _, radius) = self.quadrature();
        let across = sources.iter().map(|s| s.position.xy().norm()).fold(0.0, f64::max);
        let planes = self.boundary().planes().map(|plane| plane.is_some());
        directions([k * radius, k * across], planes)
    }

    /// Evaluates the waves of chunks of directions at all points; `each` receives the far field of each part.
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
        let points = self.blocks().iter().map(|b| b.corners * b.width).sum();
        let mut parts: Vec<Radiating<'_>> = all
            .iter()
            .map(|(v, solution)| Radiating::new(v, solution, planes))
            .collect();
        for chunk in directions.chunks(CHUNK) {
            parts.iter_mut().for_each(|part| part.clear(boundary.nodes(), points));
            // An incomplete last chunk repeats its last direction.
            let along = |axis: usize| std::array::from_fn(|row| k * chunk[row.min(chunk.len() - 1)].0[axis]);
            let along: [[f64; CHUNK]; 3] = [0, 1, 2].map(along);
            let mut first = 0;
            for block in self.blocks() {
                Arch::new().dispatch(Waves {
                    block,
                    first,
                    middle: [0, 1, 2].map(|axis| phases(&along[axis], block.middle[axis] - origin[axis])),
                    along: along.map(|axis| axis.map(|v| v as f32)),
                    planes,
                    parts: &mut parts,
                });
                first += block.corners * block.width;
            }
            each(chunk, &parts);
        }
    }

    /// Far field F of every pattern of several parities in the given directions. Returns a matrix of directions x
    /// patterns for each parity \[Pa s for velocities in m/s\]. The pressure tends to e^{-jkr}/(4 pi r) F, where r is
    /// the distance from the origin of [`Exterior::quadrature`].
    pub(crate) fn far_fields(&self, all: &[Radiated<'_>], directions: &[Vector3<f64>]) -> Vec<Mat<Complex<f64>>> {
        if let Some(halves) = self.with_real_velocities(all) {
            let halves: Vec<Radiated<'_>> = halves.iter().map(|(v, p)| (v, p)).collect();
            return self
                .far_fields_of_real(&halves, directions)
                .iter()
                .map(joined)
                .collect();
        }
        self.far_fields_of_real(all, directions)
    }

    /// The same for velocities of the air that are real.
    fn far_fields_of_real(&self, all: &[Radiated<'_>], directions: &[Vector3<f64>]) -> Vec<Mat<Complex<f64>>> {
        let hz = all.first().map_or(0.0, |(_, solution)| solution.hz);
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let count = |a: &Radiated<'_>| a.0.ncols();
        let mut fields: Vec<Mat<Complex<f64>>> = all.iter().map(|a| Mat::zeros(directions.len(), count(a))).collect();
        let directions: Vec<(Vector3<f64>, f64)> = directions.iter().map(|d| (*d, 1.0)).collect();
        let mut first = 0;
        let velocities: Vec<Mat<f32>> = all.iter().map(|a| at_points(self.blocks(), a.0)).collect();
        let all: Vec<(&Mat<f32>, &SurfacePressure)> = velocities.iter().zip(all).map(|(v, a)| (v, a.1)).collect();
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

    /// All quadrature points relative to an origin (the centre of the body or of its footprint on the floor), the
    /// origin, and the radius of a sphere around it that encloses them.
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

/// The far field of the patterns of one parity. With both mirror planes and a floor, waves are real up to a power of j,
/// and only their real or imaginary part is stored. Products are in single precision; their error is less than that of
/// the equations.
struct Radiating<'a> {
    /// Real and imaginary part of the pressure as adjacent blocks, unknowns x 2 patterns.
    pressure: Mat<f32>,
    /// Velocities at the points of the far rule, patterns x points.
    velocities: &'a Mat<f32>,
    /// The parts of the waves, real and imaginary, that are nonzero.
    parts: Vec<usize>,
    /// Axes along which the field changes its sign.
    odd: [bool; 3],
    /// Values of each part for a chunk of directions, by unknown and by point.
    on_p: [Vec<f32>; 2],
    on_v: [Vec<f32>; 2],
}

impl<'a> Radiating<'a> {
    fn new(velocities: &'a Mat<f32>, solution: &SurfacePressure, planes: [bool; 3]) -> Self {
        let (n, modes) = (solution.pressure.nrows(), velocities.nrows());
        let odd = [0, 1, 2].map(|axis| solution.parity.is_odd(axis));
        Self {
            pressure: Mat::from_fn(n, 2 * modes, |node, column| {
                let p = solution.pressure[(node, column % modes)];
                (if column < modes { p.re } else { p.im }) as f32
            }),
            velocities,
            parts: if planes == [true; 3] {
                vec![powers_of_j(odd) % 2]
            } else {
                vec![0, 1]
            },
            odd,
            on_p: [Vec::new(), Vec::new()],
            on_v: [Vec::new(), Vec::new()],
        }
    }

    fn clear(&mut self, n: usize, points: usize) {
        for &part in &self.parts {
            self.on_p[part].clear();
            self.on_p[part].resize(n * CHUNK, 0.0);
            // Everything except the padding of blocks is overwritten.
            self.on_v[part].resize(points * CHUNK, 0.0);
        }
    }

    /// F of all patterns in a chunk of directions, patterns x 2 directions: real parts, then imaginary parts.
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
                in_rows(&self.on_p[part], self.pressure.nrows(), rows),
                1.0,
                Par::Seq,
            );
            matmul(
                from_v.as_mut(),
                Accum::Replace,
                self.velocities.as_ref(),
                in_rows(&self.on_v[part], self.velocities.ncols(), rows),
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

    /// Adds the power of all patterns in a chunk of directions.
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

/// R from the sum over the directions, exactly symmetric.
fn resistance(total: &Mat<f64>) -> DMatrix<f64> {
    let modes = total.nrows();
    DMatrix::from_fn(modes, modes, |i, j| total[(i.min(j), i.max(j))])
}

/// Unknowns or points x the directions of a chunk.
fn in_rows(waves: &[f32], count: usize, directions: usize) -> MatRef<'_, f32> {
    MatRef::from_row_major_slice(waves, count, CHUNK).subcols(0, directions)
}

/// k d_a y_a modulo 2 pi, reduced in double precision and then rounded to single.
fn phases(along: &[f64; CHUNK], y: f64) -> [f32; CHUNK] {
    along.map(|k| {
        let turns = (k * y / TAU).round();
        (k * y - TAU * turns) as f32
    })
}

/// Number of factors j in the standing waves between three planes.
fn powers_of_j(odd: [bool; 3]) -> usize {
    odd.into_iter().filter(|&odd| odd).count()
}

/// Evaluates e^{jk d.y} and its images at the points of a block, for a chunk of directions and all parities.
///
/// Uses single precision. The phase at the centre of the block is reduced in double precision, so that the error grows
/// only with the distance from that centre and not from the origin.
struct Waves<'a, 'b> {
    block: &'a Block,
    /// Index of its first point.
    first: usize,
    /// Phases at its centre, by axis.
    middle: [[f32; CHUNK]; 3],
    /// k d, by axis.
    along: [[f32; CHUNK]; 3],
    planes: [bool; 3],
    parts: &'a mut [Radiating<'b>],
}

impl WithSimd for Waves<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.block.corners {
            3 => self.run::<S, 3>(simd),
            _ => self.run::<S, 4>(simd),
        }
    }
}

/// A complex number as real and imaginary part.
type Pair<S> = [<S as Simd>::f32s; 2];

/// A function of one coordinate: its value and its derivative along the normal.
type Factor<T> = [T; 2];

/// A factor of e^{jk d.y} with its image along one axis: f(t) and its derivative times `along`, where t = k d_a y_a.
///
/// It is e^{jt} without an image, 2 cos t with the image of a field that is even about the plane t = 0, and 2j sin t
/// with that of an odd one.
#[inline(always)]
fn standing<S: Simd>(simd: S, [sine, cosine, along]: [S::f32s; 3], plane: bool, odd: bool) -> Factor<Pair<S>> {
    let zero = simd.splat_f32s(0.0);
    if !plane {
        let less = simd.neg_f32s(sine);
        return [
            [cosine, sine],
            [simd.mul_f32s(along, less), simd.mul_f32s(along, cosine)],
        ];
    }
    let [value, slope] = between_planes(simd, [sine, cosine, along], odd);
    if odd {
        [[zero, value], [zero, slope]]
    } else {
        [[value, zero], [slope, zero]]
    }
}

/// Same as `standing` with a plane, without the factor j.
#[inline(always)]
fn between_planes<S: Simd>(simd: S, [sine, cosine, along]: [S::f32s; 3], odd: bool) -> Factor<S::f32s> {
    let two = simd.splat_f32s(2.0);
    let (sine, cosine) = (simd.mul_f32s(two, sine), simd.mul_f32s(two, cosine));
    if odd {
        [sine, simd.mul_f32s(along, cosine)]
    } else {
        [cosine, simd.neg_f32s(simd.mul_f32s(along, sine))]
    }
}

/// The product of the factors of three axes, and its derivative along the normal.
#[inline(always)]
fn product<S: Simd>(simd: S, [x, y, z]: [Factor<S::f32s>; 3]) -> Factor<S::f32s> {
    let xy = simd.mul_f32s(x[0], y[0]);
    let slope = simd.mul_add_e_f32s(x[1], y[0], simd.mul_f32s(x[0], y[1]));
    [
        simd.mul_f32s(xy, z[0]),
        simd.mul_add_e_f32s(slope, z[0], simd.mul_f32s(xy, z[1])),
    ]
}

#[inline(always)]
fn complex_product<S: Simd>(simd: S, [x, y, z]: [Factor<Pair<S>>; 3]) -> Factor<Pair<S>> {
    let zero = [simd.splat_f32s(0.0); 2];
    let xy = add_times(simd, zero, x[0], y[0]);
    let slope = add_times(simd, add_times(simd, zero, x[1], y[0]), x[0], y[1]);
    [
        add_times(simd, zero, xy, z[0]),
        add_times(simd, add_times(simd, zero, slope, z[0]), xy, z[1]),
    ]
}

/// sum + a b.
#[inline(always)]
fn add_times<S: Simd>(simd: S, sum: Pair<S>, a: Pair<S>, b: Pair<S>) -> Pair<S> {
    [
        simd.negate_mul_add_e_f32s(a[1], b[1], simd.mul_add_e_f32s(a[0], b[0], sum[0])),
        simd.mul_add_e_f32s(a[0], b[1], simd.mul_add_e_f32s(a[1], b[0], sum[1])),
    ]
}

/// Adds `factor` times `value` to the vector that starts at `start`.
#[inline(always)]
fn add<S: Simd>(simd: S, to: &mut [f32], start: usize, factor: f32, value: S::f32s) {
    let to = &mut S::as_mut_simd_f32s(&mut to[start..start + S::F32_LANES]).0[0];
    *to = simd.mul_add_e_f32s(simd.splat_f32s(factor), value, *to);
}

/// A quadrature point in single precision.
struct Point<'a> {
    number: usize,
    /// Position relative to the centre of the block.
    position: [f32; 3],
    normal: [f32; 3],
    area: f32,
    /// Unknowns of its panel, with their corner functions.
    nodes: &'a [usize],
    phi: &'a [f32],
}

impl Point<'_> {
    /// Stores the value of a wave, and adds its derivative along the normal at the unknowns, for as many directions as
    /// fit in a vector.
    #[inline(always)]
    fn add_to<S: Simd>(&self, simd: S, [on_p, on_v]: [&mut [f32]; 2], row: usize, wave: Factor<S::f32s>, factor: f32) {
        let start = self.number * CHUNK + row;
        let to = &mut S::as_mut_simd_f32s(&mut on_v[start..start + S::F32_LANES]).0[0];
        *to = simd.mul_f32s(simd.splat_f32s(factor * self.area), wave[0]);
        for (node, phi) in self.nodes.iter().zip(self.phi) {
            add(simd, on_p, node * CHUNK + row, factor * self.area * phi, wave[1]);
        }
    }
}

impl Waves<'_, '_> {
    #[inline(always)]
    fn run<S: Simd, const E: usize>(mut self, simd: S) {
        let phi = corner_values::<E>().map(|point| point.map(|phi| phi as f32));
        let block = self.block;
        for (f, local) in block.local.iter().enumerate() {
            let nodes = local.map(|local| block.nodes[local]);
            for b in 0..E {
                let get = |field: usize| block.single[(b * fields(E) + field) * block.width + f];
                let point = Point {
                    number: self.first + b * block.width + f,
                    position: [get(X), get(X + 1), get(X + 2)],
                    normal: [get(N), get(N + 1), get(N + 2)],
                    area: get(W),
                    nodes: &nodes[..E],
                    phi: &phi[b],
                };
                for row in (0..CHUNK).step_by(S::F32_LANES) {
                    self.at_point(simd, &point, row);
                }
            }
        }
    }

    /// Evaluates all parities at a point, for as many directions from `row` as fit in a vector.
    #[inline(always)]
    fn at_point<S: Simd>(&mut self, simd: S, point: &Point<'_>, row: usize) {
        let zero = simd.splat_f32s(0.0);
        let mut waves = [[zero; 3]; 3];
        for axis in 0..3 {
            let k = load::<S>(&self.along[axis], row);
            let position = simd.splat_f32s(point.position[axis]);
            let t = simd.mul_add_e_f32s(k, position, load::<S>(&self.middle[axis], row));
            let (sine, cosine) = sin_cos(simd, t);
            waves[axis] = [sine, cosine, simd.mul_f32s(k, simd.splat_f32s(point.normal[axis]))];
        }
        let [x, y, z] = waves;
        let planes = self.planes;
        for Radiating { odd, on_p, on_v, .. } in self.parts.iter_mut() {
            let ([p_re, p_im], [v_re, v_im]) = (on_p, on_v);
            if planes == [true; 3] {
                let wave = product(
                    simd,
                    [
                        between_planes(simd, x, odd[0]),
                        between_planes(simd, y, odd[1]),
                        between_planes(simd, z, odd[2]),
                    ],
                );
                let (to, sign) = match powers_of_j(*odd) {
                    0 => ([p_re, v_re], 1.0),
                    1 => ([p_im, v_im], 1.0),
                    2 => ([p_re, v_re], -1.0),
                    _ => ([p_im, v_im], -1.0),
                };
                point.add_to(simd, to.map(Vec::as_mut_slice), row, wave, sign);
            } else {
                let [value, slope] = complex_product(
                    simd,
                    [
                        standing(simd, x, planes[0], odd[0]),
                        standing(simd, y, planes[1], odd[1]),
                        standing(simd, z, planes[2], odd[2]),
                    ],
                );
                point.add_to(simd, [p_re, v_re], row, [value[0], slope[0]], 1.0);
                point.add_to(simd, [p_im, v_im], row, [value[1], slope[1]], 1.0);
            }
        }
    }
}

/// Highest order of the spherical or cylindrical harmonics of a wave at the distance x / k from the origin (Wiscombe
/// 1980, rounded up).
fn order(x: f64) -> usize {
    (x + 4.0 * x.cbrt() + 4.0).ceil() as usize
}

/// Directions and weights that integrate the squared far field of a body over the unit sphere, or over its half above
/// the floor. The spherical harmonics are limited by `ka`, the product of k and the body's largest distance from the
/// origin. Those about the vertical axis are limited by `across`, the product with the largest distance from that axis,
/// times the sine of the polar angle (Jacobi-Anger expansion). With mirror planes, only directions on their upper side
/// are listed, because the others contribute equally.
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
            // Half a step from the planes, so that every direction has distinct images.
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::air::Air;
    use crate::bem::{Boundary, BoundaryMesh, Parity, SolidBox};

    /// F of the only pattern of a solution, from its definition in double precision with all images.
    fn defined(problem: &Exterior, (velocities, solution): Radiated<'_>, d: &Vector3<f64>) -> Complex<f64> {
        let omega = 2.0 * PI * solution.hz;
        let (k, rho) = (omega / problem.air().sound_speed, problem.air().density);
        let (sources, origin, _) = problem.quadrature();
        let images = problem.boundary().images();
        let mut sum = Complex::from(0.0);
        for (image, places) in images.iter().zip(problem.imaged(&images)) {
            for (source, (y, area)) in sources.iter().zip(places) {
                let corners = 0..source.corners;
                let p: Complex<f64> = corners
                    .clone()
                    .map(|j| solution.pressure[source.nodes[j]] * source.phi[j])
                    .sum();
                let v: f64 = corners
                    .map(|j| velocities[source.first_value + j] * source.phi[j])
                    .sum();
                let wave = Complex::from_polar(solution.parity.sign(*image), k * d.dot(&(y - origin)));
                sum += wave * Complex::i() * (k * d.dot(&area) * p + omega * rho * v * source.weight);
            }
        }
        sum
    }

    /// A box 1.2 m long in free space, on a floor, and between mirrors on a floor, at wavenumbers up to 60/m. The
    /// largest error is 1.6e-6 of the largest far field; velocities and pressures are random, so that their
    /// contributions mostly cancel.
    #[test]
    fn the_far_field_in_single_precision_equals_its_definition() {
        let air = Air::default();
        for (mirrors, floor) in [([false; 2], None), ([false; 2], Some(0.0)), ([true; 2], Some(0.0))] {
            let of_all = [SolidBox {
                low: [-0.6, -0.5, 0.0],
                high: [0.6, 0.5, 0.4],
                part: 0,
            }];
            let mirrors = mirrors.map(|mirror| mirror.then_some(0.0));
            let planes = [mirrors[0], mirrors[1], floor];
            let mesh = BoundaryMesh::of_boxes(&of_all, planes, 0.1, vec![String::new()], |_| 0).unwrap();
            let problem = Exterior::new(Boundary::symmetric(mesh, mirrors, floor).unwrap(), &air);
            let (values, nodes) = (problem.boundary().velocity_values(), problem.boundary().nodes());
            let noise = |i: usize, of: f64| (12.9 * i as f64 + of).sin();
            for k in [0.5, 10.0, 60.0] {
                let velocities = DMatrix::from_fn(values, 1, |i, _| noise(i, 0.0));
                let solution = |parity: Parity| SurfacePressure {
                    hz: k * air.sound_speed / (2.0 * PI),
                    parity,
                    pressure: DMatrix::from_fn(nodes, 1, |i, _| {
                        air.impedance() * Complex::new(noise(i, 1.0), noise(i, 2.0))
                    }),
                };
                let solutions: Vec<_> = Parity::all(mirrors.map(|m| m.is_some()))
                    .into_iter()
                    .map(solution)
                    .collect();
                let all: Vec<Radiated<'_>> = solutions.iter().map(|solution| (&velocities, solution)).collect();
                let up = |i: usize| Vector3::new(noise(i, 0.3), noise(i, 4.0), noise(i, 5.0).abs()).normalize();
                let directions: Vec<_> = (0..100).map(up).collect();
                for (found, of) in problem.far_fields(&all, &directions).iter().zip(all) {
                    let exact: Vec<_> = directions.iter().map(|d| defined(&problem, of, d)).collect();
                    let size = exact.iter().map(|f| f.norm()).fold(0.0, f64::max);
                    let errors = exact.iter().enumerate().map(|(i, f)| (found[(i, 0)] - f).norm() / size);
                    let error = errors.fold(0.0, f64::max);
                    println!("planes {planes:?}, k {k}: {error:.1e}");
                    assert!(error < 3e-6, "planes {planes:?}, k {k}: {error:e}");
                }
            }
        }
    }

    /// int e^{jk d.(x - y)} dOmega = 4 pi sin(kr)/kr, r = |x - y|, for points x, y in a cylinder.
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

//! The operators between two blocks of panels.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::blocks::{Block, C, N, W, X, fields};
use super::near::{NearPair, PairMatrices};
use super::panel::PanelShape;
use super::rules;
use super::symmetry::{Image, Parity};
use super::trig::{dot, green, load, load3, minus};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nailnoise_meshes::FaceKind;
use pulp::{Arch, Simd, WithSimd};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Wave number and coupling parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    pub(super) k: f64,
    pub(super) alpha: Complex<f64>,
}

/// Values between the corners of the panels e and f, with f running fastest so that vectors hold neighbouring panels:
/// `data[((part * rows + row) * corners_f + j) * width_f + f]`, part 0 real and 1 imaginary.
#[derive(Debug, Default)]
struct Buffer {
    data: Vec<f64>,
    rows: usize,
    columns: usize,
}

impl Buffer {
    fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        self.data.clear();
        self.data.resize(2 * rows * columns, 0.0);
    }

    fn add_scaled(&mut self, factor: f64, other: &Self) {
        for (to, from) in self.data.iter_mut().zip(&other.data) {
            *to += factor * from;
        }
    }

    fn start(&self, part: usize, row: usize) -> usize {
        (part * self.rows + row) * self.columns
    }

    fn add(&mut self, row: usize, column: usize, value: Complex<f64>) {
        let (re, im) = (self.start(0, row) + column, self.start(1, row) + column);
        self.data[re] += value.re;
        self.data[im] += value.im;
    }

    /// Real rows above imaginary rows.
    fn stacked(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.data, 2 * self.rows, self.columns)
    }
}

/// The operators of one pair of blocks. A = -K + alpha W acts on pressure, B = S + alpha K' on normal derivatives; by the
/// symmetry of S and W, and as K' is the transpose of K, one pass gives both directions.
#[derive(Debug, Default)]
struct Operators {
    /// A from f to the nodes of e.
    a: Buffer,
    /// Transpose of A from e to f: -K' + alpha W, at the nodes of e.
    a_back: Buffer,
    /// B from f to the nodes of e.
    b: Buffer,
    /// Transpose of B from e to f: S + alpha K, at the corners of the panels e.
    b_back: Buffer,
}

impl Operators {
    fn reset(&mut self, [e, f]: [&Block; 2], diagonal: bool) {
        let columns = f.corners * f.width;
        self.a.reset(e.nodes.len(), columns);
        self.b.reset(e.nodes.len(), columns);
        self.a_back.reset(if diagonal { 0 } else { e.nodes.len() }, columns);
        self.b_back
            .reset(if diagonal { 0 } else { e.corners * e.width }, columns);
    }

    fn add_scaled(&mut self, factor: f64, other: &Self) {
        self.a.add_scaled(factor, &other.a);
        self.a_back.add_scaled(factor, &other.a_back);
        self.b.add_scaled(factor, &other.b);
        self.b_back.add_scaled(factor, &other.b_back);
    }
}

/// Work space: the operators with one image, and their sum over the images for every parity.
#[derive(Debug, Default)]
pub(super) struct Tile {
    one: Operators,
    parities: Vec<Operators>,
    mask: Vec<f64>,
}

/// What the tiles of one frequency add up to.
#[derive(Debug)]
pub(super) struct Sums {
    /// -K + alpha W.
    pub(super) matrix: Mat<Complex<f64>>,
    /// (S + alpha K') v, real and imaginary part.
    pub(super) right: [Mat<f64>; 2],
}

impl Tile {
    /// Adds the operators between the blocks e and f (both directions if they differ) to the sums of every parity.
    ///
    /// `patterns` holds the normal velocities of a parity at the corners of each block's panels, panel fastest.
    #[allow(clippy::too_many_arguments)] // one call, in the hot loop
    pub(super) fn add(
        &mut self,
        images: &[Image],
        wave: Wave,
        [e, f]: [&Block; 2],
        patterns: &[(Parity, [&Mat<f64>; 2])],
        near: &[NearPair],
        integrate: impl Fn([usize; 2], &NearPair, &mut PairMatrices),
        sums: &mut [Sums],
    ) {
        let diagonal = std::ptr::eq(e, f);
        // With the even parity alone the images add up as they are.
        let even = matches!(patterns, [(parity, _)] if *parity == Parity::default());
        self.parities.resize_with(patterns.len(), Operators::default);
        self.parities.iter_mut().for_each(|p| p.reset([e, f], diagonal));
        self.one.reset([e, f], diagonal);
        for (number, &image) in images.iter().enumerate() {
            if !even && number > 0 {
                self.one.reset([e, f], diagonal);
            }
            self.mask.clear();
            for _ in &e.panels {
                self.mask.resize(self.mask.len() + f.panels.len(), 1.0);
                self.mask.resize(self.mask.len() + f.width - f.panels.len(), 0.0);
            }
            for pair in near.iter().filter(|p| p.image == number) {
                self.mask[pair.e * f.width + pair.f] = 0.0;
                if diagonal {
                    self.mask[pair.f * f.width + pair.e] = 0.0;
                }
            }
            let far = Far {
                wave,
                e,
                f,
                points: f.points_of(number),
                diagonal,
                mask: &self.mask,
                to: &mut self.one,
            };
            Arch::new().dispatch(far);
            let close = near.iter().filter(|p| p.image == number);
            self.one.add_near(wave, [e, f], diagonal, close, &integrate);
            if !even {
                for (to, (parity, _)) in self.parities.iter_mut().zip(patterns) {
                    to.add_scaled(parity.sign(image), &self.one);
                }
            }
        }
        let whole = if even {
            std::slice::from_ref(&self.one)
        } else {
            &self.parities
        };
        for ((operators, (_, patterns)), sums) in whole.iter().zip(patterns).zip(sums) {
            operators.gather([e, f], diagonal, *patterns, sums);
        }
    }
}

impl Operators {
    fn add_near<'a>(
        &mut self,
        wave: Wave,
        [e, f]: [&Block; 2],
        diagonal: bool,
        near: impl Iterator<Item = &'a NearPair>,
        integrate: &impl Fn([usize; 2], &NearPair, &mut PairMatrices),
    ) {
        for pair in near {
            let mut m = PairMatrices::default();
            integrate([e.panels[pair.e], f.panels[pair.f]], pair, &mut m);
            for i in 0..e.corners {
                for j in 0..f.corners {
                    let (s, k, kp, w) = (m.s[i][j], m.k[i][j], m.kp[i][j], wave.alpha * m.w[i][j]);
                    let (row, column) = (e.local[pair.e][i], j * f.width + pair.f);
                    let (back_row, back) = (f.local[pair.f][j], i * e.width + pair.e);
                    self.a.add(row, column, w - k);
                    self.b.add(row, column, s + wave.alpha * kp);
                    if !diagonal {
                        self.a_back.add(row, column, w - kp);
                        self.b_back.add(i * e.width + pair.e, column, s + wave.alpha * k);
                    } else if pair.e != pair.f {
                        self.a.add(back_row, back, w - kp);
                        self.b.add(back_row, back, s + wave.alpha * k);
                    }
                }
            }
        }
    }

    /// Adds corners to nodes and applies B to the patterns.
    fn gather(&self, [e, f]: [&Block; 2], diagonal: bool, patterns: [&Mat<f64>; 2], sums: &mut Sums) {
        let modes = patterns[0].ncols();
        let mut local = vec![0.0; 2 * e.nodes.len() * f.nodes.len()];
        let to_nodes = |buffer: &Buffer, local: &mut Vec<f64>| {
            local.clear();
            local.resize(2 * buffer.rows * f.nodes.len(), 0.0);
            for row in 0..2 * buffer.rows {
                let from = &buffer.data[row * buffer.columns..(row + 1) * buffer.columns];
                let to = &mut local[row * f.nodes.len()..(row + 1) * f.nodes.len()];
                for j in 0..f.corners {
                    for (value, nodes) in from[j * f.width..].iter().zip(&f.local) {
                        to[nodes[j]] += value;
                    }
                }
            }
        };
        let at = |local: &[f64], r: usize, c: usize, rows: usize| {
            let n = f.nodes.len();
            Complex::new(local[r * n + c], local[(rows + r) * n + c])
        };
        to_nodes(&self.a, &mut local);
        for (c, &column) in f.nodes.iter().enumerate() {
            for (r, &row) in e.nodes.iter().enumerate() {
                sums.matrix[(row, column)] += at(&local, r, c, e.nodes.len());
            }
        }
        let mut product = Mat::<f64>::zeros(2 * e.nodes.len(), modes);
        matmul(
            product.as_mut(),
            Accum::Replace,
            self.b.stacked(),
            patterns[1].as_ref(),
            1.0,
            Par::Seq,
        );
        spread(&e.nodes, product.as_ref(), sums);
        if diagonal {
            return;
        }
        to_nodes(&self.a_back, &mut local);
        for (r, &column) in e.nodes.iter().enumerate() {
            for (c, &row) in f.nodes.iter().enumerate() {
                sums.matrix[(row, column)] += at(&local, r, c, e.nodes.len());
            }
        }
        to_nodes(&self.b_back, &mut local);
        let rows = self.b_back.rows;
        let half = rows * f.nodes.len();
        let mut product = Mat::<f64>::zeros(2 * f.nodes.len(), modes);
        for part in 0..2 {
            let b = MatRef::from_row_major_slice(&local[part * half..(part + 1) * half], rows, f.nodes.len());
            let to: MatMut<'_, f64> = product.as_mut().subrows_mut(part * f.nodes.len(), f.nodes.len());
            matmul(to, Accum::Replace, b.transpose(), patterns[0].as_ref(), 1.0, Par::Seq);
        }
        spread(&f.nodes, product.as_ref(), sums);
    }
}

/// Adds the rows of a block's product, real above imaginary, to the right-hand sides.
fn spread(nodes: &[usize], product: MatRef<'_, f64>, sums: &mut Sums) {
    for (part, right) in sums.right.iter_mut().enumerate() {
        for m in 0..product.ncols() {
            for (r, &row) in nodes.iter().enumerate() {
                right[(row, m)] += product[(part * nodes.len() + r, m)];
            }
        }
    }
}

/// All pairs of panels of two blocks by the far rule, except those masked.
struct Far<'a> {
    wave: Wave,
    e: &'a Block,
    f: &'a Block,
    points: &'a [f64],
    diagonal: bool,
    mask: &'a [f64],
    to: &'a mut Operators,
}

impl WithSimd for Far<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match (self.e.corners, self.f.corners) {
            (3, 3) => self.run::<S, 3, 3>(simd),
            (3, _) => self.run::<S, 3, 4>(simd),
            _ => self.run::<S, 4, 4>(simd),
        }
    }
}

/// Corner functions at the points of the far rule.
fn corner_values<const E: usize>() -> [[f64; E]; E] {
    let kind = if E == 3 { FaceKind::Tri3 } else { FaceKind::Quad4 };
    let rule = rules::far(E);
    std::array::from_fn(|b| {
        let shape = kind.at(rule[b].0);
        std::array::from_fn(|j| shape.n[j])
    })
}

impl Far<'_> {
    #[inline(always)]
    fn run<S: Simd, const E: usize, const F: usize>(self, simd: S) {
        let zero = simd.splat_f64s(0.0);
        let one = simd.splat_f64s(1.0);
        let k = simd.splat_f64s(self.wave.k);
        let minus_k2 = simd.splat_f64s(-self.wave.k * self.wave.k);
        let alpha = [simd.splat_f64s(self.wave.alpha.re), simd.splat_f64s(self.wave.alpha.im)];
        let (phi_e, phi_f) = (corner_values::<E>(), corner_values::<F>());
        let (we, wf) = (self.e.width, self.f.width);
        let lanes = S::F64_LANES;
        for e in 0..self.e.panels.len() {
            // Position, vector area, area and curls of this panel's points.
            let mut own = [[0.0; 16]; E];
            for (a, own) in own.iter_mut().enumerate() {
                for (field, value) in own.iter_mut().enumerate().take(fields(E)) {
                    *value = self.e.points[(a * fields(E) + field) * we + e];
                }
            }
            for chunk in 0..wf / lanes {
                let m = load::<S>(self.mask, e * wf + chunk * lanes);
                let scale = simd.mul_f64s(m, simd.splat_f64s(0.25 / PI));
                let away = simd.sub_f64s(one, m);
                // S, K, K', -k² n . n mass; then the curls without the last function.
                let mut blocks = [[[[zero; F]; E]; 2]; 4];
                let mut curls = [[[zero; F]; E]; 2];
                for a in 0..E {
                    let (x, n) = (splat3(simd, &own[a], X), splat3(simd, &own[a], N));
                    let w = simd.splat_f64s(own[a][W]);
                    let mut rows = [[[zero; F]; 2]; 4];
                    for b in 0..F {
                        let start = b * fields(F) * wf + chunk * lanes;
                        let y = load3::<S>(self.points, start + X * wf, wf);
                        let v = load3::<S>(self.points, start + N * wf, wf);
                        let u = load::<S>(self.points, start + W * wf);
                        let d = minus(simd, x, y);
                        // Masked pairs are put at a distance of a metre and more: they may coincide.
                        let r2 = simd.add_f64s(dot(simd, d, d), away);
                        let [g_re, g_im, h_re, h_im] = green(simd, r2, k, scale);
                        let areas = simd.mul_f64s(w, u);
                        let dn_y = simd.mul_f64s(dot(simd, d, v), w);
                        let dn_x = simd.neg_f64s(simd.mul_f64s(dot(simd, d, n), u));
                        let nn = simd.mul_f64s(minus_k2, dot(simd, n, v));
                        let kernels = [
                            [simd.mul_f64s(g_re, areas), simd.mul_f64s(g_im, areas)],
                            [simd.mul_f64s(h_re, dn_y), simd.mul_f64s(h_im, dn_y)],
                            [simd.mul_f64s(h_re, dn_x), simd.mul_f64s(h_im, dn_x)],
                            [simd.mul_f64s(g_re, nn), simd.mul_f64s(g_im, nn)],
                        ];
                        for j in 0..F {
                            let phi = simd.splat_f64s(phi_f[b][j]);
                            for m in 0..4 {
                                for part in 0..2 {
                                    rows[m][part][j] = simd.mul_add_e_f64s(kernels[m][part], phi, rows[m][part][j]);
                                }
                            }
                        }
                        for j in 0..F - 1 {
                            let other = load3::<S>(self.points, start + (C + 3 * j) * wf, wf);
                            for i in 0..E - 1 {
                                let cc = dot(simd, splat3(simd, &own[a], C + 3 * i), other);
                                curls[0][i][j] = simd.mul_add_e_f64s(g_re, cc, curls[0][i][j]);
                                curls[1][i][j] = simd.mul_add_e_f64s(g_im, cc, curls[1][i][j]);
                            }
                        }
                    }
                    for i in 0..E {
                        let phi = simd.splat_f64s(phi_e[a][i]);
                        for m in 0..4 {
                            for part in 0..2 {
                                for j in 0..F {
                                    blocks[m][part][i][j] =
                                        simd.mul_add_e_f64s(phi, rows[m][part][j], blocks[m][part][i][j]);
                                }
                            }
                        }
                    }
                }
                // The curls of all corner functions add up to zero.
                for part in 0..2 {
                    for i in 0..E - 1 {
                        for j in 0..F - 1 {
                            let value = curls[part][i][j];
                            curls[part][i][F - 1] = simd.sub_f64s(curls[part][i][F - 1], value);
                            curls[part][E - 1][j] = simd.sub_f64s(curls[part][E - 1][j], value);
                            curls[part][E - 1][F - 1] = simd.add_f64s(curls[part][E - 1][F - 1], value);
                        }
                    }
                }
                for i in 0..E {
                    let row = self.e.local[e][i];
                    for j in 0..F {
                        let s = [blocks[0][0][i][j], blocks[0][1][i][j]];
                        let k = [blocks[1][0][i][j], blocks[1][1][i][j]];
                        let kp = [blocks[2][0][i][j], blocks[2][1][i][j]];
                        let hyper = [
                            simd.add_f64s(curls[0][i][j], blocks[3][0][i][j]),
                            simd.add_f64s(curls[1][i][j], blocks[3][1][i][j]),
                        ];
                        let column = j * wf + chunk * lanes;
                        let less_k = [simd.neg_f64s(k[0]), simd.neg_f64s(k[1])];
                        put(simd, &mut self.to.a, row, column, axpy(simd, alpha, hyper, less_k));
                        put(simd, &mut self.to.b, row, column, axpy(simd, alpha, kp, s));
                        if !self.diagonal {
                            let less_kp = [simd.neg_f64s(kp[0]), simd.neg_f64s(kp[1])];
                            put(
                                simd,
                                &mut self.to.a_back,
                                row,
                                column,
                                axpy(simd, alpha, hyper, less_kp),
                            );
                            put(simd, &mut self.to.b_back, i * we + e, column, axpy(simd, alpha, k, s));
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, own: &[f64; 16], field: usize) -> [S::f64s; 3] {
    [
        simd.splat_f64s(own[field]),
        simd.splat_f64s(own[field + 1]),
        simd.splat_f64s(own[field + 2]),
    ]
}

/// alpha x + y of complex numbers.
#[inline(always)]
fn axpy<S: Simd>(simd: S, alpha: [S::f64s; 2], x: [S::f64s; 2], y: [S::f64s; 2]) -> [S::f64s; 2] {
    let re = simd.mul_add_e_f64s(alpha[0], x[0], y[0]);
    let im = simd.mul_add_e_f64s(alpha[0], x[1], y[1]);
    [
        simd.negate_mul_add_e_f64s(alpha[1], x[1], re),
        simd.mul_add_e_f64s(alpha[1], x[0], im),
    ]
}

/// Adds a vector of complex values to a buffer.
#[inline(always)]
fn put<S: Simd>(simd: S, buffer: &mut Buffer, row: usize, column: usize, value: [S::f64s; 2]) {
    for part in 0..2 {
        let start = buffer.start(part, row) + column;
        let to = &mut S::as_mut_simd_f64s(&mut buffer.data[start..start + S::F64_LANES]).0[0];
        *to = simd.add_f64s(*to, value[part]);
    }
}

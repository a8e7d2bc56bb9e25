//! The operators between two blocks of panels.

use super::blocks::{Block, C, N, W, X, fields};
use super::boundary::Boundary;
use super::near::{NearPair, PairMatrices, dot};
use super::rules;
use super::trig::green;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
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

/// Work space of one pair of blocks. A = -K + alpha W acts on pressure, B = S + alpha K' on normal derivatives; by the
/// symmetry of S and W, and as K' is the transpose of K, one pass gives both directions.
#[derive(Debug, Default)]
pub(super) struct Tile {
    /// A from f to the nodes of e.
    a: Buffer,
    /// Transpose of A from e to f: -K' + alpha W, at the nodes of e.
    a_back: Buffer,
    /// B from f to the nodes of e.
    b: Buffer,
    /// Transpose of B from e to f: S + alpha K, at the corners of the panels e.
    b_back: Buffer,
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
    /// Adds the operators between the blocks e and f (both directions if they differ) to the sums.
    ///
    /// `patterns` holds the normal velocities at the corners of each block's panels, panel fastest.
    pub(super) fn add(
        &mut self,
        boundary: &Boundary,
        wave: Wave,
        [e, f]: [&Block; 2],
        patterns: [&Mat<f64>; 2],
        near: &[NearPair],
        integrate: impl Fn([usize; 2], &NearPair, &mut PairMatrices),
        sums: &mut Sums,
    ) {
        let diagonal = std::ptr::eq(e, f);
        let columns = f.corners * f.width;
        self.a.reset(e.nodes.len(), columns);
        self.b.reset(e.nodes.len(), columns);
        self.a_back.reset(if diagonal { 0 } else { e.nodes.len() }, columns);
        self.b_back
            .reset(if diagonal { 0 } else { e.corners * e.width }, columns);
        for image in [false, true] {
            let points = match (image, &f.image) {
                (false, _) => &f.points,
                (true, Some(points)) => points,
                (true, None) => continue,
            };
            self.mask.clear();
            self.mask
                .extend((0..e.panels.len() * f.width).map(|i| f64::from(u8::from(i % f.width < f.panels.len()))));
            for pair in near.iter().filter(|p| p.image == image) {
                self.mask[pair.e * f.width + pair.f] = 0.0;
                if diagonal {
                    self.mask[pair.f * f.width + pair.e] = 0.0;
                }
            }
            let far = Far {
                wave,
                e,
                f,
                points,
                diagonal,
                tile: &mut *self,
            };
            Arch::new().dispatch(far);
        }
        self.add_near(wave, [e, f], diagonal, near, integrate);
        debug_assert!(boundary.nodes() == sums.matrix.nrows());
        self.gather([e, f], diagonal, patterns, sums);
    }

    fn add_near(
        &mut self,
        wave: Wave,
        [e, f]: [&Block; 2],
        diagonal: bool,
        near: &[NearPair],
        integrate: impl Fn([usize; 2], &NearPair, &mut PairMatrices),
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
    tile: &'a mut Tile,
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
    let kind = if E == 3 {
        super::PanelKind::Tri3
    } else {
        super::PanelKind::Quad4
    };
    let rule = rules::far(E);
    std::array::from_fn(|b| {
        let shape = kind.shape(rule[b].0);
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
        // a + alpha b of complex numbers.
        let axpy = |a: [S::f64s; 2], b: [S::f64s; 2]| {
            let re = simd.mul_add_e_f64s(alpha[0], b[0], a[0]);
            let im = simd.mul_add_e_f64s(alpha[0], b[1], a[1]);
            [
                simd.negate_mul_add_e_f64s(alpha[1], b[1], re),
                simd.mul_add_e_f64s(alpha[1], b[0], im),
            ]
        };
        for e in 0..self.e.panels.len() {
            let mask = &self.tile.mask[e * wf..(e + 1) * wf];
            if mask.iter().all(|&m| m == 0.0) {
                continue;
            }
            let own = |a: usize, field: usize| simd.splat_f64s(self.e.points[(a * fields(E) + field) * we + e]);
            let own3 = |a: usize, field: usize| [0, 1, 2].map(|c| own(a, field + c));
            for chunk in 0..wf / lanes {
                let m = S::as_simd_f64s(&self.tile.mask[e * wf..(e + 1) * wf]).0[chunk];
                let scale = simd.mul_f64s(m, simd.splat_f64s(0.25 / PI));
                let away = simd.sub_f64s(one, m);
                let other = |b: usize, field: usize| {
                    let start = (b * fields(F) + field) * wf + chunk * lanes;
                    S::as_simd_f64s(&self.points[start..start + lanes]).0[0]
                };
                let other3 = |b: usize, field: usize| [0, 1, 2].map(|c| other(b, field + c));
                // S, K, K', -k² n . n mass; then the curls without the last function.
                let mut blocks = [[[[zero; F]; E]; 2]; 4];
                let mut curls = [[[zero; F]; E]; 2];
                for a in 0..E {
                    let (x, n, w) = (own3(a, X), own3(a, N), own(a, W));
                    let mut rows = [[[zero; F]; 2]; 4];
                    for b in 0..F {
                        let (y, v, u) = (other3(b, X), other3(b, N), other(b, W));
                        let d = [0, 1, 2].map(|c| simd.sub_f64s(x[c], y[c]));
                        // Masked pairs are put at a distance of a metre and more: they may coincide.
                        let r2 = simd.add_f64s(dot(simd, d, d), away);
                        let [g_re, g_im, h_re, h_im] = green(simd, r2, k, scale);
                        let areas = simd.mul_f64s(w, u);
                        let dn_y = simd.mul_f64s(dot(simd, d, v), w);
                        let dn_x = simd.neg_f64s(simd.mul_f64s(dot(simd, d, n), u));
                        let nn = simd.mul_f64s(minus_k2, dot(simd, n, v));
                        for (part, (g, h)) in [(g_re, h_re), (g_im, h_im)].into_iter().enumerate() {
                            let kernels = [
                                simd.mul_f64s(g, areas),
                                simd.mul_f64s(h, dn_y),
                                simd.mul_f64s(h, dn_x),
                                simd.mul_f64s(g, nn),
                            ];
                            for (row, kernel) in rows.iter_mut().zip(kernels) {
                                for (j, sum) in row[part].iter_mut().enumerate() {
                                    *sum = simd.mul_add_e_f64s(kernel, simd.splat_f64s(phi_f[b][j]), *sum);
                                }
                            }
                        }
                        for i in 0..E - 1 {
                            let c = own3(a, C + 3 * i);
                            for j in 0..F - 1 {
                                let cc = dot(simd, c, other3(b, C + 3 * j));
                                curls[0][i][j] = simd.mul_add_e_f64s(g_re, cc, curls[0][i][j]);
                                curls[1][i][j] = simd.mul_add_e_f64s(g_im, cc, curls[1][i][j]);
                            }
                        }
                    }
                    for (block, row) in blocks.iter_mut().zip(&rows) {
                        for part in 0..2 {
                            for i in 0..E {
                                let phi = simd.splat_f64s(phi_e[a][i]);
                                for j in 0..F {
                                    let sum = &mut block[part][i][j];
                                    *sum = simd.mul_add_e_f64s(phi, row[part][j], *sum);
                                }
                            }
                        }
                    }
                }
                // The curls of all corner functions add up to zero.
                for part in &mut curls {
                    for i in 0..E - 1 {
                        for j in 0..F - 1 {
                            let value = part[i][j];
                            part[i][F - 1] = simd.sub_f64s(part[i][F - 1], value);
                            part[E - 1][j] = simd.sub_f64s(part[E - 1][j], value);
                            part[E - 1][F - 1] = simd.add_f64s(part[E - 1][F - 1], value);
                        }
                    }
                }
                for i in 0..E {
                    for j in 0..F {
                        let [s, k, kp, nn] = [0, 1, 2, 3].map(|m| [blocks[m][0][i][j], blocks[m][1][i][j]]);
                        let hyper = [0, 1].map(|part| simd.add_f64s(curls[part][i][j], nn[part]));
                        let minus = |v: [S::f64s; 2]| v.map(|v| simd.neg_f64s(v));
                        let column = j * wf + chunk * lanes;
                        let add = |buffer: &mut Buffer, row: usize, value: [S::f64s; 2]| {
                            for (part, value) in value.into_iter().enumerate() {
                                let start = buffer.start(part, row) + column;
                                let to = &mut S::as_mut_simd_f64s(&mut buffer.data[start..start + lanes]).0[0];
                                *to = simd.add_f64s(*to, value);
                            }
                        };
                        let row = self.e.local[e][i];
                        add(&mut self.tile.a, row, axpy(minus(k), hyper));
                        add(&mut self.tile.b, row, axpy(s, kp));
                        if !self.diagonal {
                            add(&mut self.tile.a_back, row, axpy(minus(kp), hyper));
                            add(&mut self.tile.b_back, i * we + e, axpy(s, k));
                        }
                    }
                }
            }
        }
    }
}

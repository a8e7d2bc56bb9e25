//! Triangular solves with many right-hand sides.
//!
//! After factorisation, the columns of every supernode are rearranged into blocks of at most [`WIDTH`] columns. The
//! rows of a block, beginning with those of its unit triangle, are split into panels of [`HEIGHT`] rows. The values of
//! a panel are stored column by column. For a panel of the triangle, the values in its own columns follow, stored by
//! rows. A solve then reads the factor sequentially, and gathers and scatters complete rows of right-hand sides,
//! [`SIDES`] at a time.

use std::ops::Range;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{MatMut, MatRef};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::rows::{Row, Rows, SIDES};
use super::subtrees::{Member, Part, PartRows, Subtrees};

/// Columns of a block.
const WIDTH: usize = 64;

/// Rows of a panel: with one pair of vectors each, plus an operand and a value of L, they fill sixteen registers.
const HEIGHT: usize = 6;

/// Number of rows below a block of the top that one thread processes at a time.
const PIECE: usize = 64 * HEIGHT;

/// Rearranges the columns of every supernode in place as described above, and returns the diagonal D of L D L^T.
pub(crate) fn pack(symbolic: &SymbolicSupernodalCholesky<usize>, values: &mut [f64]) -> Vec<f64> {
    let mut diagonal = vec![0.0; symbolic.nrows()];
    let (mut rest, mut rest_diagonal) = (values, diagonal.as_mut_slice());
    let mut supernodes = Vec::with_capacity(symbolic.n_supernodes());
    for (s, range) in symbolic.col_ptr_for_val().windows(2).enumerate() {
        let (own, behind) = rest.split_at_mut(range[1] - range[0]);
        let columns = symbolic.supernode_end()[s] - symbolic.supernode_begin()[s];
        let (own_diagonal, behind_diagonal) = rest_diagonal.split_at_mut(columns);
        supernodes.push((own, own_diagonal));
        (rest, rest_diagonal) = (behind, behind_diagonal);
    }
    // Threads share the supernodes, whose values are only moved.
    let moved = supernodes.into_par_iter().with_min_len(8);
    moved.for_each_init(Vec::new, |columns, (target, diagonal)| {
        let n = diagonal.len();
        let rows = target.len() / n.max(1);
        columns.clear();
        columns.extend_from_slice(target);
        for (j, d) in diagonal.iter_mut().enumerate() {
            *d = columns[j * rows + j];
        }
        let mut place = 0;
        let mut put = |row: usize, column: usize| {
            target[place] = columns[column * rows + row];
            place += 1;
        };
        for first in (0..n).step_by(WIDTH) {
            let last = (first + WIDTH).min(n);
            for panel in (first..last).step_by(HEIGHT) {
                let panel_end = (panel + HEIGHT).min(last);
                for k in first..panel {
                    (panel..panel_end).for_each(|i| put(i, k));
                }
                for i in panel..panel_end {
                    (panel..i).for_each(|k| put(i, k));
                }
            }
            for panel in (last..rows).step_by(HEIGHT) {
                let panel_end = (panel + HEIGHT).min(rows);
                for k in first..last {
                    (panel..panel_end).for_each(|i| put(i, k));
                }
            }
        }
    });
    diagonal
}

/// Calls a method for a panel of `$height` <= [`HEIGHT`] rows, with the number of rows known at compile time.
macro_rules! of_height {
    ($height:expr, $x:expr, $method:ident($($argument:expr),*)) => {
        match $height {
            1 => $x.$method::<1>($($argument),*),
            2 => $x.$method::<2>($($argument),*),
            3 => $x.$method::<3>($($argument),*),
            4 => $x.$method::<4>($($argument),*),
            5 => $x.$method::<5>($($argument),*),
            _ => $x.$method::<HEIGHT>($($argument),*),
        }
    };
}

/// L and D of L D L^T.
pub(crate) struct Panels<'a> {
    pub(crate) symbolic: &'a SymbolicSupernodalCholesky<usize>,
    pub(crate) subtrees: &'a Subtrees,
    pub(crate) values: &'a [f64],
    pub(crate) diagonal: &'a [f64],
}

impl<'a> Panels<'a> {
    /// Overwrites X with (L D L^T)^-1 X; `room` is workspace.
    pub(crate) fn solve(&self, mut x: MatMut<'_, f64>, room: &mut PartRows) {
        for start in (0..x.ncols()).step_by(SIDES) {
            let width = SIDES.min(x.ncols() - start);
            self.forward(1.0, x.rb().subcols(start, width), room);
            self.backward(1.0, x.rb_mut().subcols_mut(start, width), room);
        }
    }

    /// Y = scale (L D L^T)^-1 X.
    pub(crate) fn solve_scaled(&self, scale: f64, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, room: &mut PartRows) {
        for start in (0..x.ncols()).step_by(SIDES) {
            let width = SIDES.min(x.ncols() - start);
            self.forward(scale, x.subcols(start, width), room);
            self.backward(scale, y.rb_mut().subcols_mut(start, width), room);
        }
    }

    /// Forward sweep of the subtrees in parallel, and both sweeps of the top, for a block of X.
    fn forward(&self, scale: f64, x: MatRef<'_, f64>, room: &mut PartRows) {
        let Subtrees { subtrees, top } = self.subtrees;
        let (mut rows, top_rows) = room.split(self.subtrees);
        (subtrees, &mut rows).into_par_iter().for_each(|(part, x_part)| {
            let (own, reached) = x_part.split_at_mut(part.len());
            part.gather(own, x);
            reached.fill(Row::ZERO);
            Arch::new().dispatch(Forward {
                panels: self,
                part,
                x: x_part,
            });
        });
        top.gather(top_rows, x);
        self.subtrees.add_reached(&rows, top_rows);
        self.top_forward(top_rows);
        self.scale(scale, top, top_rows);
        self.top_backward(top_rows);
    }

    /// Backward sweep of the subtrees, into a block of X.
    fn backward(&self, scale: f64, x: MatMut<'_, f64>, room: &mut PartRows) {
        let Subtrees { subtrees, top } = self.subtrees;
        let (rows, top_rows) = room.split(self.subtrees);
        let (own, of_top) = self.subtrees.rows_mut(x);
        let top_rows = &*top_rows;
        let of_subtrees = || {
            (subtrees, rows, own).into_par_iter().for_each(|(part, x_part, to)| {
                for (row, &at) in x_part[part.len()..].iter_mut().zip(&part.reached) {
                    *row = top_rows[at as usize];
                }
                self.scale(scale, part, x_part);
                Arch::new().dispatch(Backward {
                    panels: self,
                    part,
                    x: x_part,
                });
                Row::scatter(&x_part[..part.len()], to);
            });
        };
        rayon::join(of_subtrees, || top.scatter(top_rows, of_top));
    }

    /// X <- scale D^-1 X for the own rows of a part.
    fn scale(&self, scale: f64, part: &Part, rows: &mut [Row]) {
        let diagonal = part.rows.iter().flat_map(|range| &self.diagonal[range.clone()]);
        rows.iter_mut().zip(diagonal).for_each(|(row, d)| row.scale(scale / d));
    }

    /// The supernodes of the top are large, so threads share the panels of each block.
    fn top_forward(&self, x: &mut [Row]) {
        let (arch, mut sums) = (Arch::new(), Rows::default());
        for block in self.top_blocks() {
            arch.dispatch(Triangle {
                block: &block,
                x: &mut *x,
            });
            sums.resize(block.own + block.pattern.len());
            let pieces = sums.as_mut_slice().par_chunks_mut(PIECE).enumerate();
            pieces.for_each(|(k, sums)| {
                let (block, x, first) = (&block, &*x, k * PIECE);
                arch.dispatch(BelowForward { block, x, first, sums });
            });
            for (i, sum) in sums.as_slice().iter().enumerate() {
                x[block.target(i)].subtract(sum);
            }
        }
    }

    fn top_backward(&self, x: &mut [Row]) {
        let arch = Arch::new();
        let blocks: Vec<Block<'_>> = self.top_blocks().collect();
        for block in blocks.iter().rev() {
            let rows = block.own + block.pattern.len();
            let pieces = (0..rows.div_ceil(PIECE)).into_par_iter().map(|k| {
                let mut sums = vec![Row::ZERO; block.columns];
                let range = k * PIECE..rows.min((k + 1) * PIECE);
                arch.dispatch(BelowBackward {
                    block,
                    x: &*x,
                    range,
                    sums: &mut sums,
                });
                sums
            });
            let mut sums = [Row::ZERO; WIDTH];
            for piece in pieces.collect::<Vec<_>>() {
                sums.iter_mut().zip(&piece).for_each(|(sum, part)| sum.add(part));
            }
            arch.dispatch(TriangleBackward {
                block,
                x: &mut *x,
                sums: &mut sums,
            });
        }
    }

    fn top_blocks(&self) -> impl Iterator<Item = Block<'a>> {
        let top = &self.subtrees.top;
        top.supernodes.iter().flat_map(|member| {
            let supernode = Supernode::new(self, top, member);
            let mut place = 0;
            (0..supernode.columns)
                .step_by(WIDTH)
                .map(move |first| supernode.block(first, &mut place))
        })
    }
}

/// The forward sweep through a subtree, compiled like the other kernels for the vector instructions detected at run
/// time.
struct Forward<'a> {
    panels: &'a Panels<'a>,
    part: &'a Part,
    x: &'a mut [Row],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut x = Lanes { simd, rows: self.x };
        for member in &self.part.supernodes {
            let supernode = Supernode::new(self.panels, self.part, member);
            let mut place = 0;
            for first in (0..supernode.columns).step_by(WIDTH) {
                supernode.block(first, &mut place).forward(&mut x);
            }
        }
    }
}

struct Backward<'a> {
    panels: &'a Panels<'a>,
    part: &'a Part,
    x: &'a mut [Row],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut x = Lanes { simd, rows: self.x };
        let mut places = Vec::new();
        let mut sums = [Row::ZERO; WIDTH];
        for member in self.part.supernodes.iter().rev() {
            let supernode = Supernode::new(self.panels, self.part, member);
            places.clear();
            let mut place = 0;
            for first in (0..supernode.columns).step_by(WIDTH) {
                places.push((first, place));
                supernode.block(first, &mut place);
            }
            for &(first, mut place) in places.iter().rev() {
                supernode.block(first, &mut place).backward(&mut x, &mut sums);
            }
        }
    }
}

/// See [`Block::triangle_forward`].
struct Triangle<'a> {
    block: &'a Block<'a>,
    x: &'a mut [Row],
}

impl WithSimd for Triangle<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.block.triangle_forward(&mut Lanes { simd, rows: self.x });
    }
}

/// See [`Block::triangle_backward`].
struct TriangleBackward<'a> {
    block: &'a Block<'a>,
    x: &'a mut [Row],
    sums: &'a mut [Row; WIDTH],
}

impl WithSimd for TriangleBackward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let sums = &mut self.sums[..self.block.columns];
        self.block.triangle_backward(&mut Lanes { simd, rows: self.x }, sums);
    }
}

/// Sums of L_tk x_k over a block's columns, for rows t below it starting at `first`.
struct BelowForward<'a> {
    block: &'a Block<'a>,
    x: &'a [Row],
    first: usize,
    sums: &'a mut [Row],
}

impl WithSimd for BelowForward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, first, sums } = self;
        let x = &x[block.start..block.start + block.columns];
        let panels = &block.panels[first * block.columns..(first + sums.len()) * block.columns];
        for (panel, sums) in panels.chunks(HEIGHT * block.columns).zip(sums.chunks_mut(HEIGHT)) {
            of_height!(sums.len(), Products { simd, x }, rows_into(panel, sums));
        }
    }
}

/// Sums of L_tk x_t over the rows t in `range` below a block, for its columns k.
struct BelowBackward<'a> {
    block: &'a Block<'a>,
    x: &'a [Row],
    range: Range<usize>,
    sums: &'a mut [Row],
}

impl WithSimd for BelowBackward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, x, range, sums } = self;
        let x = Products { simd, x };
        let panels = &block.panels[range.start * block.columns..range.end * block.columns];
        for (p, panel) in panels.chunks(HEIGHT * block.columns).enumerate() {
            let top = range.start + HEIGHT * p;
            of_height!(
                panel.len() / block.columns,
                x,
                backward(panel, sums, |r| block.target(top + r))
            );
        }
    }
}

/// The rows of X as machine vectors, processed in pairs.
struct Lanes<'a, S: Simd> {
    simd: S,
    rows: &'a mut [Row],
}

impl<S: Simd> Lanes<'_, S> {
    /// Number of pairs of vectors in a row.
    const PAIRS: usize = SIDES / S::F64_LANES / 2;

    /// Pair `h` of row `i`.
    #[inline(always)]
    fn pair(&self, i: usize, h: usize) -> [S::f64s; 2] {
        self.rows[i].pair::<S>(h)
    }

    /// x_i -= sum for pair `h`.
    #[inline(always)]
    fn subtract(&mut self, i: usize, h: usize, sum: [S::f64s; 2]) {
        let row = self.rows[i].vectors_mut::<S>();
        for c in 0..2 {
            row[2 * h + c] = self.simd.sub_f64s(row[2 * h + c], sum[c]);
        }
    }

    /// sum + l x for a pair.
    #[inline(always)]
    fn add(simd: S, sum: &mut [S::f64s; 2], l: f64, x: [S::f64s; 2]) {
        let l = simd.splat_f64s(l);
        sum[0] = simd.mul_add_e_f64s(l, x[0], sum[0]);
        sum[1] = simd.mul_add_e_f64s(l, x[1], sum[1]);
    }

    /// View for operations that only read the rows.
    #[inline(always)]
    fn products(&self) -> Products<'_, S> {
        Products {
            simd: self.simd,
            x: self.rows,
        }
    }

    /// x_t -= sum over the columns of L_tk x_k for the `H` rows t of a panel whose columns begin at `start`.
    #[inline(always)]
    fn forward<const H: usize>(&mut self, panel: &[f64], start: usize, target: impl Fn(usize) -> usize) {
        let simd = self.simd;
        let from = start..start + panel.len() / H;
        for h in 0..Self::PAIRS {
            let mut sums = [[simd.splat_f64s(0.0); 2]; H];
            for (l, x_k) in panel.chunks_exact(H).zip(&self.rows[from.clone()]) {
                let x_k = x_k.pair::<S>(h);
                for r in 0..H {
                    Self::add(simd, &mut sums[r], l[r], x_k);
                }
            }
            for (r, sum) in sums.into_iter().enumerate() {
                self.subtract(target(r), h, sum);
            }
        }
    }

    /// x_t -= sum of L_tk x_k over the rows of the triangle that begins at `start`, from top to bottom.
    #[inline(always)]
    fn forward_triangle(&mut self, triangle: &[f64], start: usize, height: usize) {
        for h in 0..Self::PAIRS {
            let mut entries = triangle.iter();
            for i in 1..height {
                let mut sum = [self.simd.splat_f64s(0.0); 2];
                for (k, &l) in (0..i).zip(&mut entries) {
                    Self::add(self.simd, &mut sum, l, self.pair(start + k, h));
                }
                self.subtract(start + i, h, sum);
            }
        }
    }

    /// x_k -= sum of L_tk x_t over the rows of the triangle that begins at `start`, from bottom to top.
    #[inline(always)]
    fn backward_triangle(&mut self, triangle: &[f64], start: usize, height: usize) {
        for h in 0..Self::PAIRS {
            for k in (0..height.saturating_sub(1)).rev() {
                let mut sum = [self.simd.splat_f64s(0.0); 2];
                for i in k + 1..height {
                    let l = triangle[i * (i - 1) / 2 + k];
                    Self::add(self.simd, &mut sum, l, self.pair(start + i, h));
                }
                self.subtract(start + k, h, sum);
            }
        }
    }
}

/// Sums of products with rows of X, which are not changed.
#[derive(Clone, Copy)]
struct Products<'a, S: Simd> {
    simd: S,
    x: &'a [Row],
}

impl<S: Simd> Products<'_, S> {
    /// sum_t = sum over the columns of L_tk x_k for the `H` rows t of a panel.
    #[inline(always)]
    fn rows_into<const H: usize>(self, panel: &[f64], out: &mut [Row]) {
        let simd = self.simd;
        for h in 0..Lanes::<S>::PAIRS {
            let mut sums = [[simd.splat_f64s(0.0); 2]; H];
            for (l, x_k) in panel.chunks_exact(H).zip(self.x) {
                let x_k = x_k.pair::<S>(h);
                for r in 0..H {
                    Lanes::<S>::add(simd, &mut sums[r], l[r], x_k);
                }
            }
            for (out, sum) in out.iter_mut().zip(&sums) {
                out.vectors_mut::<S>()[2 * h..2 * h + 2].copy_from_slice(sum);
            }
        }
    }

    /// sum_k += sum of L_tk x_t over the `H` rows t of a panel.
    #[inline(always)]
    fn backward<const H: usize>(self, panel: &[f64], sums: &mut [Row], target: impl Fn(usize) -> usize) {
        let simd = self.simd;
        for h in 0..Lanes::<S>::PAIRS {
            let mut from = [[simd.splat_f64s(0.0); 2]; H];
            for (r, from) in from.iter_mut().enumerate() {
                *from = self.x[target(r)].pair::<S>(h);
            }
            for (l, sum) in panel.chunks_exact(H).zip(sums.iter_mut()) {
                let mut kept = sum.pair::<S>(h);
                for r in 0..H {
                    Lanes::<S>::add(simd, &mut kept, l[r], from[r]);
                }
                sum.vectors_mut::<S>()[2 * h..2 * h + 2].copy_from_slice(&kept);
            }
        }
    }
}

struct Supernode<'a> {
    start: usize,
    columns: usize,
    pattern: &'a [u32],
    values: &'a [f64],
}

/// Up to [`WIDTH`] columns of a supernode.
struct Block<'a> {
    /// First column.
    start: usize,
    columns: usize,
    /// Strict lower triangle, in panels.
    triangle: &'a [f64],
    /// Panels of the rows below: first those of the supernode's own later columns, then those of its pattern.
    panels: &'a [f64],
    own: usize,
    pattern: &'a [u32],
}

impl<'a> Supernode<'a> {
    #[inline(always)]
    fn new(panels: &Panels<'a>, part: &'a Part, member: &Member) -> Self {
        let (symbolic, s) = (panels.symbolic, member.supernode);
        let offsets = symbolic.col_ptr_for_val();
        Self {
            start: member.start,
            columns: symbolic.supernode_end()[s] - symbolic.supernode_begin()[s],
            pattern: part.pattern(member),
            values: &panels.values[offsets[s]..offsets[s + 1]],
        }
    }

    #[inline(always)]
    fn block(&self, first: usize, place: &mut usize) -> Block<'a> {
        let columns = WIDTH.min(self.columns - first);
        let own = self.columns - first - columns;
        let triangle = columns * (columns - 1) / 2;
        let panels = columns * (own + self.pattern.len());
        let values = &self.values[*place..*place + triangle + panels];
        *place += triangle + panels;
        Block {
            start: self.start + first,
            columns,
            triangle: &values[..triangle],
            panels: &values[triangle..],
            own,
            pattern: self.pattern,
        }
    }
}

impl Block<'_> {
    /// The row of X for row `i` below the triangle.
    #[inline(always)]
    fn target(&self, i: usize) -> usize {
        if i < self.own {
            self.start + self.columns + i
        } else {
            self.pattern[i - self.own] as usize
        }
    }

    /// The panels of the rows below, each with its first row.
    #[inline(always)]
    fn panels(&self) -> impl Iterator<Item = (usize, &[f64])> {
        let panels = self.panels.chunks(HEIGHT * self.columns);
        panels.enumerate().map(|(p, panel)| (HEIGHT * p, panel))
    }

    /// The rows `top..top + height` of the triangle: their panel and their own small triangle.
    #[inline(always)]
    fn own_panel(&self, top: usize, height: usize) -> (&[f64], &[f64]) {
        let start = top * top.saturating_sub(1) / 2;
        let end = (top + height) * (top + height - 1) / 2;
        self.triangle[start..end].split_at(top * height)
    }

    /// x_k = b_k - sum of L_ki x_i within the triangle, then x -= L x_k below it.
    #[inline(always)]
    fn forward<S: Simd>(&self, x: &mut Lanes<'_, S>) {
        self.triangle_forward(x);
        for (top, panel) in self.panels() {
            of_height!(
                panel.len() / self.columns,
                x,
                forward(panel, self.start, |r| self.target(top + r))
            );
        }
    }

    /// x_k = b_k - sum of L_ki x_i within the triangle.
    #[inline(always)]
    fn triangle_forward<S: Simd>(&self, x: &mut Lanes<'_, S>) {
        for top in (0..self.columns).step_by(HEIGHT) {
            let (start, height) = (self.start + top, HEIGHT.min(self.columns - top));
            let (panel, triangle) = self.own_panel(top, height);
            of_height!(height, x, forward(panel, self.start, |r| start + r));
            x.forward_triangle(triangle, start, height);
        }
    }

    /// x_k -= sum of L_ik x_i over the rows below, then within the triangle from its last row upwards; `sums` is
    /// workspace.
    #[inline(always)]
    fn backward<S: Simd>(&self, x: &mut Lanes<'_, S>, sums: &mut [Row; WIDTH]) {
        let sums = &mut sums[..self.columns];
        sums.fill(Row::ZERO);
        for (top, panel) in self.panels() {
            of_height!(
                panel.len() / self.columns,
                x.products(),
                backward(panel, sums, |r| self.target(top + r))
            );
        }
        self.triangle_backward(x, sums);
    }

    /// x_k -= its column's sum and the terms within the triangle, from its last row upwards.
    #[inline(always)]
    fn triangle_backward<S: Simd>(&self, x: &mut Lanes<'_, S>, sums: &mut [Row]) {
        for top in (0..self.columns).step_by(HEIGHT).rev() {
            let (start, height) = (self.start + top, HEIGHT.min(self.columns - top));
            let (panel, triangle) = self.own_panel(top, height);
            for (r, sum) in sums[top..top + height].iter().enumerate() {
                for h in 0..Lanes::<S>::PAIRS {
                    x.subtract(start + r, h, sum.pair::<S>(h));
                }
            }
            x.backward_triangle(triangle, start, height);
            of_height!(height, x.products(), backward(panel, sums, |r| start + r));
        }
    }
}

//! Triangular solves with many right-hand sides.
//!
//! After the factorisation every supernode's columns are laid out anew, in blocks of at most [`WIDTH`] columns. The rows
//! of a block, those of its own unit triangle first, are cut into panels of [`HEIGHT`] rows in which the values of one
//! column stand together; what a panel of the triangle holds of its own columns follows it by rows. A solve then reads
//! the factor front to back as a stream, and the right-hand sides, [`SIDES`] of them side by side in a row, are gathered
//! and scattered by whole rows.

use faer::MatMut;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use pulp::{Arch, Simd, WithSimd};

use crate::rows::{Row, Rows, SIDES};

/// Columns of a block.
const WIDTH: usize = 64;

/// Rows of a panel: with a pair of vectors each they, an operand and a value of L fill sixteen registers.
const HEIGHT: usize = 6;

/// Lays the columns of every supernode out in place as described above and returns the diagonal; `unit` says whether the
/// triangle's diagonal is that of L D L^T, else the columns of L L^T are divided by theirs and its square is returned.
pub(crate) fn pack(symbolic: &SymbolicSupernodalCholesky<usize>, values: &mut [f64], unit: bool) -> Vec<f64> {
    let mut diagonal = vec![0.0; symbolic.nrows()];
    let mut columns = Vec::new();
    for s in 0..symbolic.n_supernodes() {
        let (start, end) = (symbolic.supernode_begin()[s], symbolic.supernode_end()[s]);
        let range = symbolic.col_ptr_for_val()[s]..symbolic.col_ptr_for_val()[s + 1];
        let (n, rows) = (end - start, range.len() / (end - start).max(1));
        let target = &mut values[range];
        columns.clear();
        columns.extend_from_slice(target);
        for j in 0..n {
            let d = columns[j * rows + j];
            diagonal[start + j] = if unit { d } else { d * d };
            if !unit {
                columns[j * rows + j..(j + 1) * rows].iter_mut().for_each(|v| *v /= d);
            }
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
    }
    diagonal
}

/// Overwrites X by (L D L^T)^-1 X; `room` is room to work.
pub(crate) fn solve(
    symbolic: &SymbolicSupernodalCholesky<usize>,
    values: &[f64],
    diagonal: &[f64],
    mut x: MatMut<'_, f64>,
    room: &mut Rows,
) {
    for start in (0..x.ncols()).step_by(SIDES) {
        let width = SIDES.min(x.ncols() - start);
        room.gather(x.rb().subcols(start, width));
        Arch::new().dispatch(Sweeps {
            symbolic,
            values,
            diagonal,
            x: room.as_mut_slice(),
        });
        room.scatter(x.rb_mut().subcols_mut(start, width));
    }
}

/// Both sweeps, compiled for the vector instructions found at run time.
struct Sweeps<'a> {
    symbolic: &'a SymbolicSupernodalCholesky<usize>,
    values: &'a [f64],
    diagonal: &'a [f64],
    x: &'a mut [Row],
}

impl WithSimd for Sweeps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            symbolic,
            values,
            diagonal,
            x,
        } = self;
        let mut x = Lanes { simd, rows: x };
        let count = symbolic.n_supernodes();
        for s in 0..count {
            let supernode = Supernode::new(symbolic, values, s);
            let mut place = 0;
            for first in (0..supernode.columns).step_by(WIDTH) {
                let block = supernode.block(first, &mut place);
                block.forward(&mut x);
            }
        }
        for (i, d) in diagonal.iter().enumerate() {
            let inverse = simd.splat_f64s(1.0 / d);
            x.row_mut(i).iter_mut().for_each(|v| *v = simd.mul_f64s(*v, inverse));
        }
        let mut places = Vec::new();
        let mut sums = [Row::ZERO; WIDTH];
        for s in (0..count).rev() {
            let supernode = Supernode::new(symbolic, values, s);
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

/// The rows of X as vectors of the machine, taken in pairs.
struct Lanes<'a, S: Simd> {
    simd: S,
    rows: &'a mut [Row],
}

impl<S: Simd> Lanes<'_, S> {
    /// Pairs of vectors in a row.
    const PAIRS: usize = SIDES / S::F64_LANES / 2;

    #[inline(always)]
    fn row_mut(&mut self, i: usize) -> &mut [S::f64s] {
        self.rows[i].vectors_mut::<S>()
    }

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

    /// x_t -= sum over the columns of L_tk x_k for the `H` rows t of a panel, whose columns begin at `start`.
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

    /// sum_k += sum of L_tk x_t over the `H` rows t of a panel.
    #[inline(always)]
    fn backward<const H: usize>(&self, panel: &[f64], sums: &mut [Row], target: impl Fn(usize) -> usize) {
        let simd = self.simd;
        for h in 0..Self::PAIRS {
            let mut from = [[simd.splat_f64s(0.0); 2]; H];
            for (r, from) in from.iter_mut().enumerate() {
                *from = self.pair(target(r), h);
            }
            for (l, sum) in panel.chunks_exact(H).zip(sums.iter_mut()) {
                let mut kept = sum.pair::<S>(h);
                for r in 0..H {
                    Self::add(simd, &mut kept, l[r], from[r]);
                }
                sum.vectors_mut::<S>()[2 * h..2 * h + 2].copy_from_slice(&kept);
            }
        }
    }

    /// x_t -= sum of L_tk x_k over the rows of the triangle that begins at `start`, from above.
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

    /// x_k -= sum of L_tk x_t over the rows of the triangle that begins at `start`, from below.
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

/// Calls a method for a panel of `$height` rows, at most [`HEIGHT`], with their number known to the compiler.
macro_rules! of_height {
    ($height:expr, $x:ident.$method:ident($($argument:expr),*)) => {
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

struct Supernode<'a> {
    start: usize,
    columns: usize,
    pattern: &'a [usize],
    values: &'a [f64],
}

/// Up to [`WIDTH`] columns of a supernode.
struct Block<'a> {
    /// First column.
    start: usize,
    columns: usize,
    /// Strict lower triangle, in panels.
    triangle: &'a [f64],
    /// Panels of the rows below, first those of the supernode's own later columns, then those of its pattern.
    panels: &'a [f64],
    own: usize,
    pattern: &'a [usize],
}

impl<'a> Supernode<'a> {
    #[inline(always)]
    fn new(symbolic: &'a SymbolicSupernodalCholesky<usize>, values: &'a [f64], s: usize) -> Self {
        let start = symbolic.supernode_begin()[s];
        Self {
            start,
            columns: symbolic.supernode_end()[s] - start,
            pattern: symbolic.supernode(s).pattern(),
            values: &values[symbolic.col_ptr_for_val()[s]..symbolic.col_ptr_for_val()[s + 1]],
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
    /// The row of X that belongs to row `i` below the triangle.
    #[inline(always)]
    fn target(&self, i: usize) -> usize {
        if i < self.own {
            self.start + self.columns + i
        } else {
            self.pattern[i - self.own]
        }
    }

    /// The panels of the rows below, each with its first row.
    #[inline(always)]
    fn panels(&self) -> impl Iterator<Item = (usize, &[f64])> {
        let panels = self.panels.chunks(HEIGHT * self.columns);
        panels.enumerate().map(|(p, panel)| (HEIGHT * p, panel))
    }

    /// The rows `top..top + height` of the triangle: their panel and their own triangle.
    #[inline(always)]
    fn own_panel(&self, top: usize, height: usize) -> (&[f64], &[f64]) {
        let start = top * top.saturating_sub(1) / 2;
        let end = (top + height) * (top + height - 1) / 2;
        self.triangle[start..end].split_at(top * height)
    }

    /// x_k = b_k - sum of L_ki x_i within the triangle, then x -= L x_k below it.
    #[inline(always)]
    fn forward<S: Simd>(&self, x: &mut Lanes<'_, S>) {
        for top in (0..self.columns).step_by(HEIGHT) {
            let (start, height) = (self.start + top, HEIGHT.min(self.columns - top));
            let (panel, triangle) = self.own_panel(top, height);
            of_height!(height, x.forward(panel, self.start, |r| start + r));
            x.forward_triangle(triangle, start, height);
        }
        for (top, panel) in self.panels() {
            of_height!(
                panel.len() / self.columns,
                x.forward(panel, self.start, |r| self.target(top + r))
            );
        }
    }

    /// x_k -= sum of L_ik x_i over the rows below, then within the triangle from its last row up; `sums` is room to work.
    #[inline(always)]
    fn backward<S: Simd>(&self, x: &mut Lanes<'_, S>, sums: &mut [Row; WIDTH]) {
        let sums = &mut sums[..self.columns];
        sums.fill(Row::ZERO);
        for (top, panel) in self.panels() {
            of_height!(
                panel.len() / self.columns,
                x.backward(panel, sums, |r| self.target(top + r))
            );
        }
        for top in (0..self.columns).step_by(HEIGHT).rev() {
            let (start, height) = (self.start + top, HEIGHT.min(self.columns - top));
            let (panel, triangle) = self.own_panel(top, height);
            for (r, sum) in sums[top..top + height].iter().enumerate() {
                for h in 0..Lanes::<S>::PAIRS {
                    x.subtract(start + r, h, sum.pair::<S>(h));
                }
            }
            x.backward_triangle(triangle, start, height);
            of_height!(height, x.backward(panel, sums, |r| start + r));
        }
    }
}

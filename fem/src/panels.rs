//! Triangular solves with many right-hand sides.
//!
//! After the factorisation every supernode's columns are laid out anew, in blocks of at most [`WIDTH`] columns: the unit
//! triangle by rows, then panels of [`HEIGHT`] rows in which the values of one column stand together. A solve then reads
//! the factor front to back as a stream, and the right-hand sides, [`SIDES`] of them side by side in a row, are gathered
//! and scattered by whole rows.

use faer::MatMut;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use pulp::{Arch, Simd, WithSimd};

/// Columns of a block.
const WIDTH: usize = 32;

/// Rows of a panel.
const HEIGHT: usize = 4;

/// Right-hand sides solved at once.
const SIDES: usize = 16;

/// The right-hand sides' values of one unknown.
type Row = [f64; SIDES];

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
            for i in first..last {
                (first..i).for_each(|k| put(i, k));
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

/// Overwrites X by (L D L^T)^-1 X.
pub(crate) fn solve(
    symbolic: &SymbolicSupernodalCholesky<usize>,
    values: &[f64],
    diagonal: &[f64],
    mut x: MatMut<'_, f64>,
) {
    let n = x.nrows();
    let mut rows: Vec<Row> = vec![[0.0; SIDES]; n];
    for start in (0..x.ncols()).step_by(SIDES) {
        let width = SIDES.min(x.ncols() - start);
        for c in 0..width {
            for (row, value) in rows.iter_mut().zip(x.rb().col(start + c).iter()) {
                row[c] = *value;
            }
        }
        Arch::new().dispatch(Sweeps {
            symbolic,
            values,
            diagonal,
            x: &mut rows,
        });
        for c in 0..width {
            for (value, row) in x.rb_mut().col_mut(start + c).iter_mut().zip(&rows) {
                *value = row[c];
            }
        }
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
        let mut x = Lanes {
            simd,
            vectors: S::as_mut_simd_f64s(x.as_flattened_mut()).0,
        };
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
            x.row(i).iter_mut().for_each(|v| *v = simd.mul_f64s(*v, inverse));
        }
        let mut places = Vec::new();
        let mut sums = [[0.0; SIDES]; WIDTH];
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

/// The rows of X as vectors of the machine. They are taken in pairs: those of [`HEIGHT`] rows and a pair of operands fill
/// the registers.
struct Lanes<'a, S: Simd> {
    simd: S,
    vectors: &'a mut [S::f64s],
}

impl<S: Simd> Lanes<'_, S> {
    /// Vectors in a row.
    const ROW: usize = SIDES / S::F64_LANES;

    #[inline(always)]
    fn row(&mut self, i: usize) -> &mut [S::f64s] {
        &mut self.vectors[i * Self::ROW..(i + 1) * Self::ROW]
    }

    /// x_to -= l x_from.
    #[inline(always)]
    fn subtract(&mut self, to: usize, l: f64, from: usize) {
        let l = self.simd.splat_f64s(-l);
        let (to, from) = (to * Self::ROW, from * Self::ROW);
        for c in 0..Self::ROW {
            self.vectors[to + c] = self
                .simd
                .mul_add_e_f64s(l, self.vectors[from + c], self.vectors[to + c]);
        }
    }

    /// Pair `h` of row `i`.
    #[inline(always)]
    fn pair(&self, i: usize, h: usize) -> [S::f64s; 2] {
        let at = i * Self::ROW + 2 * h;
        [self.vectors[at], self.vectors[at + 1]]
    }

    /// sum + l x for a pair.
    #[inline(always)]
    fn add(simd: S, sum: &mut [S::f64s], l: f64, x: [S::f64s; 2]) {
        let l = simd.splat_f64s(l);
        sum[0] = simd.mul_add_e_f64s(l, x[0], sum[0]);
        sum[1] = simd.mul_add_e_f64s(l, x[1], sum[1]);
    }
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
    /// Strict lower triangle, by rows.
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

    /// Whole panels and the rows left over.
    #[inline(always)]
    fn split(&self) -> (usize, usize) {
        let below = self.own + self.pattern.len();
        (below / HEIGHT, below % HEIGHT)
    }

    /// x_k = b_k - sum of L_ki x_i within the triangle, then x -= L x_k below it.
    #[inline(always)]
    fn forward<S: Simd>(&self, x: &mut Lanes<'_, S>) {
        let simd = x.simd;
        let mut entries = self.triangle.iter();
        for i in 1..self.columns {
            for (k, &l) in (0..i).zip(&mut entries) {
                x.subtract(self.start + i, l, self.start + k);
            }
        }
        let (whole, height) = self.split();
        let (panels, rest) = self.panels.split_at(whole * HEIGHT * self.columns);
        for (p, panel) in panels.chunks_exact(HEIGHT * self.columns).enumerate() {
            for h in 0..Lanes::<S>::ROW / 2 {
                let mut sums = [[simd.splat_f64s(0.0); 2]; HEIGHT];
                for (k, l) in panel.chunks_exact(HEIGHT).enumerate() {
                    let x_k = x.pair(self.start + k, h);
                    for r in 0..HEIGHT {
                        Lanes::add(simd, &mut sums[r], l[r], x_k);
                    }
                }
                for (r, sum) in sums.iter().enumerate() {
                    let row = x.row(self.target(HEIGHT * p + r));
                    for c in 0..2 {
                        row[2 * h + c] = simd.sub_f64s(row[2 * h + c], sum[c]);
                    }
                }
            }
        }
        for (k, column) in rest.chunks_exact(height.max(1)).enumerate() {
            for (r, &l) in column.iter().enumerate() {
                x.subtract(self.target(HEIGHT * whole + r), l, self.start + k);
            }
        }
    }

    /// x_k -= sum of L_ik x_i over the rows below, then within the triangle from its last row up; `sums` is room to work.
    #[inline(always)]
    fn backward<S: Simd>(&self, x: &mut Lanes<'_, S>, sums: &mut [Row; WIDTH]) {
        let simd = x.simd;
        let sums = &mut sums[..self.columns];
        sums.fill([0.0; SIDES]);
        let sums = S::as_mut_simd_f64s(sums.as_flattened_mut()).0;
        let (whole, height) = self.split();
        let (panels, rest) = self.panels.split_at(whole * HEIGHT * self.columns);
        for (p, panel) in panels.chunks_exact(HEIGHT * self.columns).enumerate() {
            for h in 0..Lanes::<S>::ROW / 2 {
                let from: [_; HEIGHT] = std::array::from_fn(|r| x.pair(self.target(HEIGHT * p + r), h));
                for (l, sum) in panel.chunks_exact(HEIGHT).zip(sums.chunks_exact_mut(Lanes::<S>::ROW)) {
                    let sum = &mut sum[2 * h..2 * h + 2];
                    for r in 0..HEIGHT {
                        Lanes::add(simd, sum, l[r], from[r]);
                    }
                }
            }
        }
        for (column, sum) in rest
            .chunks_exact(height.max(1))
            .zip(sums.chunks_exact_mut(Lanes::<S>::ROW))
        {
            for (r, &l) in column.iter().enumerate() {
                for (h, sum) in sum.chunks_exact_mut(2).enumerate() {
                    Lanes::add(simd, sum, l, x.pair(self.target(HEIGHT * whole + r), h));
                }
            }
        }
        for (k, sum) in sums.chunks_exact(Lanes::<S>::ROW).enumerate() {
            for (v, sum) in x.row(self.start + k).iter_mut().zip(sum) {
                *v = simd.sub_f64s(*v, *sum);
            }
        }
        for i in (1..self.columns).rev() {
            let row = &self.triangle[i * (i - 1) / 2..i * (i + 1) / 2];
            for (k, &l) in row.iter().enumerate() {
                x.subtract(self.start + k, l, self.start + i);
            }
        }
    }
}

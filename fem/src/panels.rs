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

/// Half of them, as many as the registers hold sums for.
const HALF: usize = 8;

type Row = [[f64; HALF]; 2];

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
    let mut rows: Vec<Row> = vec![[[0.0; HALF]; 2]; n];
    for start in (0..x.ncols()).step_by(SIDES) {
        let width = SIDES.min(x.ncols() - start);
        for c in 0..width {
            for (row, value) in rows.iter_mut().zip(x.rb().col(start + c).iter()) {
                row[c / HALF][c % HALF] = *value;
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
                *value = row[c / HALF][c % HALF];
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
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            symbolic,
            values,
            diagonal,
            x,
        } = self;
        let count = symbolic.n_supernodes();
        for s in 0..count {
            let supernode = Supernode::new(symbolic, values, s);
            let mut place = 0;
            for first in (0..supernode.columns).step_by(WIDTH) {
                let block = supernode.block(first, &mut place);
                block.forward(x);
            }
        }
        for (row, d) in x.iter_mut().zip(diagonal) {
            for half in row {
                for v in half {
                    *v /= d;
                }
            }
        }
        let mut places = Vec::new();
        for s in (0..count).rev() {
            let supernode = Supernode::new(symbolic, values, s);
            places.clear();
            let mut place = 0;
            for first in (0..supernode.columns).step_by(WIDTH) {
                places.push((first, place));
                supernode.block(first, &mut place);
            }
            for &(first, mut place) in places.iter().rev() {
                supernode.block(first, &mut place).backward(x);
            }
        }
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

    /// x_k = b_k - sum of L_ki x_i within the triangle, then x -= L x_k below it.
    #[inline(always)]
    fn forward(&self, x: &mut [Row]) {
        let mut entries = self.triangle.iter();
        for i in 1..self.columns {
            let (done, rest) = x[self.start..self.start + self.columns].split_at_mut(i);
            for (x_k, &l) in done.iter().zip(&mut entries) {
                for h in 0..2 {
                    for c in 0..HALF {
                        rest[0][h][c] -= l * x_k[h][c];
                    }
                }
            }
        }
        let below = self.own + self.pattern.len();
        let whole = below / HEIGHT;
        let (panels, rest) = self.panels.split_at(whole * HEIGHT * self.columns);
        for (p, panel) in panels.chunks_exact(HEIGHT * self.columns).enumerate() {
            for h in 0..2 {
                let mut sum = [[0.0; HALF]; HEIGHT];
                let block = &x[self.start..self.start + self.columns];
                for (l, x_k) in panel.chunks_exact(HEIGHT).zip(block) {
                    for r in 0..HEIGHT {
                        for c in 0..HALF {
                            sum[r][c] += l[r] * x_k[h][c];
                        }
                    }
                }
                for r in 0..HEIGHT {
                    let to = &mut x[self.target(HEIGHT * p + r)][h];
                    for c in 0..HALF {
                        to[c] -= sum[r][c];
                    }
                }
            }
        }
        let height = below - whole * HEIGHT;
        for (k, column) in rest.chunks_exact(height.max(1)).enumerate() {
            let x_k = x[self.start + k];
            for (r, &l) in column.iter().enumerate() {
                let to = &mut x[self.target(HEIGHT * whole + r)];
                for h in 0..2 {
                    for c in 0..HALF {
                        to[h][c] -= l * x_k[h][c];
                    }
                }
            }
        }
    }

    /// x_k -= sum of L_ik x_i over the rows below, then within the triangle from its last row up.
    #[inline(always)]
    fn backward(&self, x: &mut [Row]) {
        let below = self.own + self.pattern.len();
        let whole = below / HEIGHT;
        let (panels, rest) = self.panels.split_at(whole * HEIGHT * self.columns);
        let mut sums: [Row; WIDTH] = [[[0.0; HALF]; 2]; WIDTH];
        let sums = &mut sums[..self.columns];
        for (p, panel) in panels.chunks_exact(HEIGHT * self.columns).enumerate() {
            let from: [Row; HEIGHT] = std::array::from_fn(|r| x[self.target(HEIGHT * p + r)]);
            for h in 0..2 {
                for (l, sum) in panel.chunks_exact(HEIGHT).zip(sums.iter_mut()) {
                    let mut s = sum[h];
                    for r in 0..HEIGHT {
                        for c in 0..HALF {
                            s[c] += l[r] * from[r][h][c];
                        }
                    }
                    sum[h] = s;
                }
            }
        }
        let height = below - whole * HEIGHT;
        for (column, sum) in rest.chunks_exact(height.max(1)).zip(sums.iter_mut()) {
            for (r, &l) in column.iter().enumerate() {
                let from = &x[self.target(HEIGHT * whole + r)];
                for h in 0..2 {
                    for c in 0..HALF {
                        sum[h][c] += l * from[h][c];
                    }
                }
            }
        }
        let block = &mut x[self.start..self.start + self.columns];
        for (x_k, sum) in block.iter_mut().zip(sums.iter()) {
            for h in 0..2 {
                for c in 0..HALF {
                    x_k[h][c] -= sum[h][c];
                }
            }
        }
        for i in (1..self.columns).rev() {
            let (done, rest) = block.split_at_mut(i);
            let row = &self.triangle[i * (i - 1) / 2..i * (i + 1) / 2];
            for (x_k, &l) in done.iter_mut().zip(row) {
                for h in 0..2 {
                    for c in 0..HALF {
                        x_k[h][c] -= l * rest[0][h][c];
                    }
                }
            }
        }
    }
}

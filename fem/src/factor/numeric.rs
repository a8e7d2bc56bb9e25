//! Numerical factorisation: L D L^T by supernodes, left-looking (Ng & Peyton 1993, SIAM J. Sci. Comput. 14, 1034-1056).
//!
//! To factorise a supernode, the contributions L_d D_d L_d^T of its descendants are subtracted from its columns of A,
//! and the columns are then eliminated. All descendants of a supernode of a subtree lie in the same subtree, so that
//! subtrees are factorised in parallel (see [`Subtrees`]). The few supernodes at the top are large: threads share their
//! columns when contributions are subtracted, and their rows during elimination, in pieces of [`WIDTH`] and [`HEIGHT`].
//!
//! The factorisation is our own, because faer's is parallel only within single supernodes. This does not pay off for
//! the many small supernodes of a thin-walled housing. The dense kernels are those of faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra_sparse::CscMatrix;
use rayon::prelude::*;

use super::subtrees::Subtrees;

/// Columns of a piece.
const WIDTH: usize = 128;

/// Rows of a piece.
const HEIGHT: usize = 256;

/// Supernodes with fewer values are processed by one thread.
const WORTHWHILE: usize = 100_000;

/// The descendants of each supernode that update it, ascending.
#[derive(Debug)]
pub(crate) struct Descendants {
    offsets: Vec<usize>,
    below: Vec<u32>,
}

impl Descendants {
    pub(crate) fn new(symbolic: &SymbolicSupernodalCholesky<usize>) -> Self {
        let (count, end) = (symbolic.n_supernodes(), symbolic.supernode_end());
        let mut owner = vec![0; symbolic.nrows()];
        for s in 0..count {
            owner[symbolic.supernode_begin()[s]..end[s]].fill(s);
        }
        // One row in each supernode that a pattern meets represents the others.
        let above = |d: usize| {
            let owners = symbolic.supernode(d).pattern().chunk_by(|&a, &b| owner[a] == owner[b]);
            owners.map(|rows| owner[rows[0]])
        };
        let mut offsets = vec![0; count + 1];
        (0..count).flat_map(above).for_each(|s| offsets[s + 1] += 1);
        for s in 0..count {
            offsets[s + 1] += offsets[s];
        }
        let mut next = offsets.clone();
        let mut below = vec![0; offsets[count]];
        for d in 0..count {
            for s in above(d) {
                below[next[s]] = d as u32;
                next[s] += 1;
            }
        }
        Self { offsets, below }
    }

    fn of(&self, s: usize) -> impl Iterator<Item = usize> {
        self.below[self.offsets[s]..self.offsets[s + 1]]
            .iter()
            .map(|&d| d as usize)
    }
}

/// A matrix and the pattern of its factor.
pub(crate) struct Numeric<'a> {
    pub(crate) symbolic: &'a SymbolicSupernodalCholesky<usize>,
    pub(crate) descendants: &'a Descendants,
    /// Lower triangle.
    pub(crate) a: &'a CscMatrix<f64>,
}

/// Workspace of one thread.
#[derive(Default)]
struct Room {
    scaled: Vec<f64>,
    update: Vec<f64>,
    places: Vec<u32>,
}

/// The first `rows` x `columns` of the workspace as a matrix.
fn within(room: &mut Vec<f64>, rows: usize, columns: usize) -> MatMut<'_, f64> {
    if room.len() < rows * columns {
        room.resize(rows * columns, 0.0);
    }
    MatMut::from_column_major_slice_mut(&mut room[..rows * columns], rows, columns)
}

impl Numeric<'_> {
    /// Writes L below the diagonal of every supernode and D on it; the part above the diagonal of a supernode's own
    /// rows is undefined.
    ///
    /// # Errors
    /// The index of a zero pivot.
    pub(crate) fn factorise(&self, subtrees: &Subtrees, values: &mut [f64]) -> Result<(), usize> {
        let offsets = self.symbolic.col_ptr_for_val();
        let mut parts = Vec::with_capacity(subtrees.subtrees.len());
        let (mut rest, mut taken) = (&mut *values, 0);
        for part in &subtrees.subtrees {
            let members = part.supernodes.first().zip(part.supernodes.last());
            let Some((first, last)) = members.map(|(a, b)| (a.supernode, b.supernode)) else {
                continue;
            };
            let (_, behind) = rest.split_at_mut(offsets[first] - taken);
            let (own, behind) = behind.split_at_mut(offsets[last + 1] - offsets[first]);
            parts.push((first..last + 1, own));
            (rest, taken) = (behind, offsets[last + 1]);
        }
        let pivots: Vec<Result<(), usize>> = {
            parts
                .into_par_iter()
                .map(|(supernodes, own)| {
                    let base = offsets[supernodes.start];
                    self.supernodes(supernodes, own, base)
                })
                .collect()
        };
        pivots.into_iter().collect::<Result<(), usize>>()?;
        self.supernodes(subtrees.top.supernodes.iter().map(|m| m.supernode), values, 0)
    }

    /// Factorises supernodes in ascending order; their values begin at `base`.
    fn supernodes(
        &self,
        supernodes: impl Iterator<Item = usize>,
        values: &mut [f64],
        base: usize,
    ) -> Result<(), usize> {
        let offsets = self.symbolic.col_ptr_for_val();
        let mut place = vec![0; self.symbolic.nrows()];
        let mut room = Room::default();
        for s in supernodes {
            let (below, from) = values.split_at_mut(offsets[s] - base);
            let own = &mut from[..offsets[s + 1] - offsets[s]];
            let start = self.symbolic.supernode_begin()[s];
            let columns = self.symbolic.supernode_end()[s] - start;
            let rows = own.len() / columns.max(1);
            for (i, &row) in self.symbolic.supernode(s).pattern().iter().enumerate() {
                place[row] = (columns + i) as u32;
            }
            (start..start + columns).for_each(|row| place[row] = (row - start) as u32);
            let slice = |(k, own): (usize, &mut [f64]), room: &mut Room| {
                let first = k * WIDTH;
                let target = MatMut::from_column_major_slice_mut(own, rows, own.len() / rows);
                self.gather(s, start + first, target, (&*below, base), &place, room);
            };
            if own.len() > WORTHWHILE {
                let slices = own.par_chunks_mut(WIDTH * rows).enumerate();
                slices.for_each_init(Room::default, |room, k| slice(k, room));
            } else {
                own.chunks_mut(WIDTH * rows)
                    .enumerate()
                    .for_each(|k| slice(k, &mut room));
            }
            let own = MatMut::from_column_major_slice_mut(own, rows, columns);
            { eliminate(own, &mut room) }.map_err(|pivot| start + pivot)?;
        }
        Ok(())
    }

    /// Writes A minus the contributions of descendants into columns of supernode `s`, starting at column `first` of the
    /// matrix.
    fn gather(
        &self,
        s: usize,
        first: usize,
        mut target: MatMut<'_, f64>,
        (below, base): (&[f64], usize),
        place: &[u32],
        room: &mut Room,
    ) {
        target.fill(0.0);
        let end = first + target.ncols();
        for j in first..end {
            let column = self.a.col(j);
            let mut to = target.rb_mut().col_mut(j - first);
            for (&i, &value) in column.row_indices().iter().zip(column.values()) {
                to[place[i] as usize] = value;
            }
        }
        let offsets = self.symbolic.col_ptr_for_val();
        for d in self.descendants.of(s) {
            let pattern = self.symbolic.supernode(d).pattern();
            let from = pattern.partition_point(|&row| row < first);
            let middle = pattern[from..].partition_point(|&row| row < end);
            if middle == 0 {
                continue;
            }
            let depth = self.symbolic.supernode_end()[d] - self.symbolic.supernode_begin()[d];
            let l = &below[offsets[d] - base..offsets[d + 1] - base];
            let l = MatRef::from_column_major_slice(l, depth + pattern.len(), depth);
            let tail = l.subrows(depth + from, pattern.len() - from);
            let Room { scaled, update, places } = room;
            let scaled = scale(l, tail.subrows(0, middle), scaled);
            places.clear();
            places.extend(pattern[from..].iter().map(|&row| place[row]));
            let columns_meet = pattern[from + middle - 1] + 1 - pattern[from] == middle;
            for top in (0..tail.nrows()).step_by(HEIGHT) {
                let height = HEIGHT.min(tail.nrows() - top);
                let rows = tail.subrows(top, height);
                let places = &places[top..top + height];
                let place = places[0] as usize;
                // If rows and columns are contiguous in both, the product needs no buffer.
                if columns_meet && places[height - 1] as usize + 1 - place == height {
                    let to = target
                        .rb_mut()
                        .submatrix_mut(place, pattern[from] - first, height, middle);
                    matmul(to, Accum::Add, rows, scaled.transpose(), -1.0, Par::Seq);
                    continue;
                }
                let mut update = within(update, height, middle);
                matmul(update.rb_mut(), Accum::Replace, rows, scaled.transpose(), 1.0, Par::Seq);
                for (j, &row) in pattern[from..from + middle].iter().enumerate() {
                    let to = target.rb_mut().col_mut(row - first).try_as_col_major_mut();
                    let from = update.rb().col(j).try_as_col_major();
                    if let (Some(to), Some(from)) = (to, from) {
                        let to = to.as_slice_mut();
                        for (&at, value) in places.iter().zip(from.as_slice()) {
                            to[at as usize] -= value;
                        }
                    }
                }
            }
        }
    }
}

/// L D for some rows of L, where D is on the diagonal of `l`.
fn scale<'a>(l: MatRef<'_, f64>, rows: MatRef<'_, f64>, room: &'a mut Vec<f64>) -> MatRef<'a, f64> {
    let mut scaled = within(room, rows.nrows(), rows.ncols());
    for k in 0..rows.ncols() {
        let d = l[(k, k)];
        for (to, from) in scaled.rb_mut().col_mut(k).iter_mut().zip(rows.col(k).iter()) {
            *to = d * from;
        }
    }
    scaled.into_const()
}

/// L D L^T of a supernode's own columns in blocks of [`WIDTH`]: each block subtracts the contributions of earlier ones
/// and is eliminated, with the rows below it processed piece by piece.
fn eliminate(mut l: MatMut<'_, f64>, room: &mut Room) -> Result<(), usize> {
    let (rows, columns) = (l.nrows(), l.ncols());
    for first in (0..columns).step_by(WIDTH) {
        let width = WIDTH.min(columns - first);
        let (before, own) = l.rb_mut().subcols_mut(0, first + width).split_at_col_mut(first);
        let before = before.rb();
        let scaled = scale(before, before.subrows(first, width), &mut room.scaled);
        let (mut diagonal, below) = own.subrows_mut(first, rows - first).split_at_row_mut(width);
        let take_over = |to: MatMut<'_, f64>, top: usize| {
            let rows = before.subrows(top, to.nrows());
            matmul(to, Accum::Add, rows, scaled.transpose(), -1.0, Par::Seq);
        };
        take_over(diagonal.rb_mut(), first);
        let request = cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(request);
        cholesky_in_place(
            diagonal.rb_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|LdltError::ZeroPivot { index }| first + index)?;
        let diagonal = diagonal.rb();
        let piece = |(k, mut rows): (usize, MatMut<'_, f64>)| {
            take_over(rows.rb_mut(), first + width + k * HEIGHT);
            solve_unit_lower_triangular_in_place(diagonal, rows.rb_mut().transpose_mut(), Par::Seq);
            for j in 0..width {
                let inverse = 1.0 / diagonal[(j, j)];
                rows.rb_mut().col_mut(j).iter_mut().for_each(|x| *x *= inverse);
            }
        };
        if below.nrows() * (first + width) > WORTHWHILE {
            below.par_row_chunks_mut(HEIGHT).enumerate().for_each(piece);
        } else {
            let (mut below, mut k) = (below, 0);
            while below.nrows() > 0 {
                let height = HEIGHT.min(below.nrows());
                let (rows, rest) = below.split_at_row_mut(height);
                piece((k, rows));
                (below, k) = (rest, k + 1);
            }
        }
    }
    Ok(())
}

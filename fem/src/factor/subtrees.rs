//! Divides the work with a factor among threads.
//!
//! Columns in different subtrees of the elimination tree do not affect each other. A subtree changes only its own rows
//! and some rows above it; the latter are all in the pattern of its root. [`Subtrees`] cuts the tree into subtrees and
//! the remaining top. Subtrees are processed in parallel, each with a separate buffer, and their contributions to the
//! rows of the top are summed in order. The division and every sum depend only on the pattern, so results are bitwise
//! independent of the number of threads.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{MatMut, MatRef};

use super::rows::{Row, Rows};

/// Largest share of the factor's values in one subtree, so that a small number of threads finishes at about the same
/// time.
const SHARE: f64 = 1.0 / 12.0;

/// Factors with fewer values are not divided, because waking a thread would take longer than its work.
const WORTHWHILE: usize = 200_000;

/// Supernodes whose rows are stored contiguously during processing: the part's own rows, followed by the rows of the
/// top that they reach.
#[derive(Debug)]
pub(crate) struct Part {
    /// The supernodes, ascending.
    pub(crate) supernodes: Vec<Member>,
    /// Positions within this part of the rows below its supernodes.
    pattern: Vec<u32>,
    /// Its own rows by their numbers in the matrix, ascending.
    pub(crate) rows: Vec<Range<usize>>,
    /// Positions within the top of the rows that follow its own.
    pub(crate) reached: Vec<u32>,
    /// All rows by their numbers in the matrix, ascending; each range with the position of its first row in this part.
    runs: Vec<(Range<usize>, usize)>,
}

/// A supernode of a part.
#[derive(Debug)]
pub(crate) struct Member {
    /// Its number.
    pub(crate) supernode: usize,
    /// Position of its first row within the part.
    pub(crate) start: usize,
    pattern: Range<usize>,
}

/// Rows of a block of vectors for every part: those of the subtrees with the rows they reach, followed by the top. They
/// share one allocation, so that the system can use large pages.
#[derive(Default)]
pub(crate) struct PartRows(Rows);

impl PartRows {
    /// The rows of each subtree, and those of the top.
    pub(crate) fn split(&mut self, parts: &Subtrees) -> (Vec<&mut [Row]>, &mut [Row]) {
        let sizes = parts.subtrees.iter().map(|part| part.len() + part.reached.len());
        self.0.resize(sizes.clone().sum::<usize>() + parts.top.len());
        let mut rest = self.0.as_mut_slice();
        let mut subtrees = Vec::with_capacity(parts.subtrees.len());
        for size in sizes {
            let (own, behind) = rest.split_at_mut(size);
            subtrees.push(own);
            rest = behind;
        }
        (subtrees, rest)
    }
}

/// The subtrees and the top.
#[derive(Debug)]
pub(crate) struct Subtrees {
    /// In ascending order of their rows.
    pub(crate) subtrees: Vec<Part>,
    /// All supernodes that are in no subtree.
    pub(crate) top: Part,
}

impl Part {
    /// Number of own rows.
    pub(crate) fn len(&self) -> usize {
        self.rows.iter().map(Range::len).sum()
    }

    /// Position of a row that is the part's own or that it reaches.
    #[inline(always)]
    pub(crate) fn place(&self, row: usize) -> usize {
        let (rows, start) = &self.runs[self.runs.partition_point(|(rows, _)| rows.end <= row)];
        start + row - rows.start
    }

    /// Copies the part's own rows of up to [`SIDES`](crate::factor::rows::SIDES) columns.
    pub(crate) fn gather(&self, rows: &mut [Row], x: MatRef<'_, f64>) {
        let mut at = 0;
        for range in &self.rows {
            Row::gather(&mut rows[at..at + range.len()], x.subrows(range.start, range.len()));
            at += range.len();
        }
    }

    /// Copies the part's own rows back to the slices made by [`Subtrees::rows_mut`].
    pub(crate) fn scatter(&self, rows: &[Row], x: Vec<MatMut<'_, f64>>) {
        let mut at = 0;
        for (range, x) in self.rows.iter().zip(x) {
            Row::scatter(&rows[at..at + range.len()], x);
            at += range.len();
        }
    }

    /// Positions of the rows below a supernode.
    pub(crate) fn pattern(&self, member: &Member) -> &[u32] {
        &self.pattern[member.pattern.clone()]
    }

    /// Creates a part from supernodes, ascending; `place` gives the position of each row in the part once `rows` are
    /// known.
    fn new(
        symbolic: &SymbolicSupernodalCholesky<usize>,
        supernodes: impl Iterator<Item = usize>,
        place: &mut [u32],
        reached_rows: &[usize],
    ) -> Self {
        let mut rows: Vec<Range<usize>> = Vec::new();
        let (mut members, mut start, mut patterns) = (Vec::new(), 0, 0);
        for supernode in supernodes {
            let range = symbolic.supernode_begin()[supernode]..symbolic.supernode_end()[supernode];
            for (k, row) in range.clone().enumerate() {
                place[row] = (start + k) as u32;
            }
            let below = symbolic.supernode(supernode).pattern().len();
            members.push(Member {
                supernode,
                start,
                pattern: patterns..patterns + below,
            });
            patterns += below;
            start += range.len();
            match rows.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => rows.push(range),
            }
        }
        let reached: Vec<u32> = reached_rows
            .iter()
            .enumerate()
            .map(|(k, &row)| std::mem::replace(&mut place[row], (start + k) as u32))
            .collect();
        let pattern = members.iter().flat_map(|m| symbolic.supernode(m.supernode).pattern());
        let reached_runs = reached_rows.chunk_by(|&a, &b| a + 1 == b);
        let runs = rows
            .iter()
            .cloned()
            .chain(reached_runs.map(|run| run[0]..run[0] + run.len()));
        let runs = runs.scan(0, |place, rows| {
            let start = *place;
            *place += rows.len();
            Some((rows, start))
        });
        Self {
            runs: runs.collect(),
            pattern: pattern.map(|&row| place[row]).collect(),
            supernodes: members,
            rows,
            reached,
        }
    }
}

impl Subtrees {
    pub(crate) fn new(symbolic: &SymbolicSupernodalCholesky<usize>) -> Self {
        let count = symbolic.n_supernodes();
        let cut = cut(symbolic);
        let mut place = vec![0; symbolic.nrows()];
        let inside = |s: usize| {
            let next = cut.partition_point(|range| range.end <= s);
            cut.get(next).is_some_and(|range| range.contains(&s))
        };
        let top = Part::new(symbolic, (0..count).filter(|&s| !inside(s)), &mut place, &[]);
        let subtrees = cut.iter().map(|range| {
            let reached = symbolic.supernode(range.end - 1).pattern();
            let part = Part::new(symbolic, range.clone(), &mut place, reached);
            // The next subtree must find the rows of the top at their original positions.
            for (&row, &at) in reached.iter().zip(&part.reached) {
                place[row] = at;
            }
            part
        });
        Self {
            subtrees: subtrees.collect(),
            top,
        }
    }
}

impl Subtrees {
    /// Adds the subtrees' contributions to the rows of the top, in the order of the subtrees.
    pub(crate) fn add_reached(&self, subtrees: &[&mut [Row]], top: &mut [Row]) {
        for (part, rows) in self.subtrees.iter().zip(subtrees) {
            for (&at, sum) in part.reached.iter().zip(&rows[part.len()..]) {
                top[at as usize].add(sum);
            }
        }
    }

    /// Splits X into the rows of each subtree and those of the top.
    pub(crate) fn rows_mut<'x>(&self, x: MatMut<'x, f64>) -> (Vec<MatMut<'x, f64>>, Vec<MatMut<'x, f64>>) {
        let of_subtrees = self
            .subtrees
            .iter()
            .flat_map(|part| part.rows.iter().map(|range| (range, true)));
        let of_top = self.top.rows.iter().map(|range| (range, false));
        let mut ranges: Vec<_> = of_subtrees.chain(of_top).collect();
        ranges.sort_unstable_by_key(|(range, _)| range.start);
        let mut rest = x;
        let (mut own, mut top) = (Vec::new(), Vec::new());
        for (range, in_subtree) in ranges {
            let (rows, behind) = rest.split_at_row_mut(range.len());
            if in_subtree { &mut own } else { &mut top }.push(rows);
            rest = behind;
        }
        (own, top)
    }
}

/// The subtrees as ranges of supernodes, ascending.
fn cut(symbolic: &SymbolicSupernodalCholesky<usize>) -> Vec<Range<usize>> {
    let count = symbolic.n_supernodes();
    if symbolic.len_val() < WORTHWHILE {
        return Vec::new();
    }
    let (begin, end, values) = (
        symbolic.supernode_begin(),
        symbolic.supernode_end(),
        symbolic.col_ptr_for_val(),
    );
    let parent = |s: usize| {
        let first = symbolic.supernode(s).pattern().first();
        first.map(|row| end.partition_point(|end| end <= row))
    };
    debug_assert_eq!(begin.len(), count);
    // For each supernode, its first descendant and the size of its subtree.
    let mut first: Vec<usize> = (0..count).collect();
    let mut size = vec![1; count];
    let mut children = vec![Vec::new(); count];
    let mut open = Vec::new();
    for s in 0..count {
        match parent(s) {
            Some(p) => {
                first[p] = first[p].min(first[s]);
                size[p] += size[s];
                children[p].push(s);
            }
            None => open.push(s),
        }
    }
    let weight = |s: usize| values[s + 1] - values[first[s]];
    let limit = SHARE * symbolic.len_val() as f64;
    let mut cut = Vec::new();
    while let Some(s) = open.pop() {
        // In a postorder, a subtree is a contiguous range; otherwise its root is added to the top.
        let range = size[s] == s + 1 - first[s];
        if range && weight(s) as f64 <= limit {
            cut.push(first[s]..s + 1);
        } else {
            open.append(&mut children[s]);
        }
    }
    cut.sort_unstable_by_key(|range| range.start);
    cut
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use nalgebra_sparse::CscMatrix;

    use super::*;
    use crate::factor::Symbolic;
    use crate::factor::order::{Graph, elimination_order};
    use crate::factor::sparse::{Split, product, reordered};

    /// The five-point Laplacian on a square grid in elimination order, minus a shift between its eigenvalues.
    fn grid(side: usize) -> CscMatrix<f64> {
        let n = side * side;
        let neighbours = |i: usize| {
            let (row, column) = (i / side, i % side);
            let near = [
                (row > 0).then(|| i - side),
                (column > 0).then(|| i - 1),
                (column + 1 < side).then(|| i + 1),
                (row + 1 < side).then(|| i + side),
            ];
            near.into_iter().flatten()
        };
        let mut graph = Graph {
            offsets: vec![0],
            targets: Vec::new(),
        };
        let (mut offsets, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..n {
            graph.targets.extend(neighbours(j));
            graph.offsets.push(graph.targets.len());
            rows.push(j);
            values.push(3.7);
            let below: Vec<usize> = neighbours(j).filter(|&i| i > j).collect();
            values.extend(below.iter().map(|_| -1.0));
            rows.extend(below);
            offsets.push(rows.len());
        }
        let mut place = vec![0; n];
        for (k, i) in elimination_order(&graph).unwrap().into_iter().enumerate() {
            place[i] = k;
        }
        let a = CscMatrix::try_from_csc_data(n, n, offsets, rows, values).unwrap();
        reordered(&a, |i| place[i]).unwrap()
    }

    const SIDE: usize = 150;

    fn block() -> Mat<f64> {
        Mat::from_fn(SIDE * SIDE, 21, |i, j| ((3 * i + 5 * j) as f64).sin())
    }

    #[test]
    fn every_row_is_in_one_part_and_reached_rows_are_those_of_the_top() {
        let symbolic = Symbolic::new(&grid(SIDE)).unwrap();
        let Subtrees { subtrees, top } = symbolic.subtrees();
        assert!(subtrees.len() > 8);
        let parts = subtrees.iter().chain([top]);
        let mut rows: Vec<usize> = parts.flat_map(|part| part.rows.iter().cloned().flatten()).collect();
        rows.sort_unstable();
        assert!(rows.into_iter().eq(0..SIDE * SIDE));
        for part in subtrees {
            for row in top.rows.iter().cloned().flatten() {
                let runs = part.runs.iter().filter(|(rows, _)| rows.contains(&row));
                for (rows, start) in runs {
                    let behind = start + row - rows.start - part.len();
                    assert_eq!(part.reached[behind] as usize, top.place(row));
                }
            }
        }
    }

    #[test]
    fn factor_solves_and_split_product_is_that_of_the_matrix() {
        let (a, x) = (grid(SIDE), block());
        let symbolic = Symbolic::new(&a).unwrap();
        let split = Split::new(&a, symbolic.subtrees());
        let mut b = split.product(x.as_ref());
        assert!((product(&a, x.as_ref()) - &b).norm_max() < 1e-13);
        symbolic.symmetric(&a, 0.0, Vec::new()).unwrap().solve(b.as_mut());
        assert!((b - x).norm_max() < 1e-10);
    }

    #[test]
    fn no_bit_depends_on_the_number_of_threads() {
        let (a, x) = (grid(SIDE), block());
        let symbolic = Symbolic::new(&a).unwrap();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let factor = symbolic.symmetric(&a, 0.0, Vec::new()).unwrap();
                let mut solved = x.clone();
                factor.solve(solved.as_mut());
                (solved, Split::new(&a, symbolic.subtrees()).product(x.as_ref()))
            })
        };
        let one = with(1);
        assert!(one == with(2) && one == with(3));
    }
}

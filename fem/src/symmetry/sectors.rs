//! Mirror symmetry: the eigenproblem separates into one for each combination of even and odd.
//!
//! A mirror plane maps the unknowns onto each other, q -> S q, where S is a signed permutation. If S^T K S = K and S^T
//! M S = M for k planes, every mode can be chosen even or odd in each plane. Let T_c be the orthonormal basis of the
//! vectors of one combination c:
//!
//! ```text
//! K_c = T_c^T K T_c,   M_c = T_c^T M T_c,   phi = T_c phi_c,   c = 1 .. 2^k
//! ```
//!
//! These are 2^k independent problems with 1/2^k of the unknowns each. Together the T_c form a square orthogonal
//! matrix, so inertia and orthogonality are preserved: no mode is lost or found twice, and modes whose frequencies
//! coincide by symmetry fall into different sectors.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

use faer::{Mat, MatRef};
use nalgebra_sparse::CscMatrix;
use rayon::prelude::*;

use crate::assembly::Mirror;
use crate::factor::order::{Graph, elimination_order};
use crate::factor::pencil::Pencil;
use crate::factor::sparse::{product, reordered, subtract};
use crate::factor::{Factor, Symbolic};
use crate::random::Random;
use crate::{FemError, System};

/// Largest asymmetry of a row of K or M relative to its diagonal. It bounds the relative error of lambda; in addition,
/// the residuals of the modes are checked on the full matrices afterwards.
const ASYMMETRY: f64 = 1e-11;

/// One of the independent problems K_c, M_c, with its own elimination order.
pub(crate) struct Sector<'a> {
    /// None if the sector is the complete body, whose K is used directly or in a different order.
    stiffness: Option<CscMatrix<f64>>,
    /// Stiffness matrix of the complete body in the order of its analysis; taken by the first factorisation.
    whole: Mutex<Option<CscMatrix<f64>>>,
    pub(crate) mass: Cow<'a, CscMatrix<f64>>,
    /// For each unknown of the body, the column and value of the only nonzero entry in its row of T_c, if any. None if
    /// T_c is the identity.
    rows: Option<Vec<Option<(usize, f64)>>>,
}

impl Sector<'_> {
    /// Whether the sector is the complete body, in its own order or another.
    pub(crate) fn is_whole(&self) -> bool {
        self.stiffness.is_none()
    }

    /// Whether the sector is the complete body in another order.
    pub(crate) fn reorders(&self) -> bool {
        self.is_whole() && self.rows.is_some()
    }

    /// K_c.
    pub(crate) fn stiffness<'s>(&'s self, system: &'s System) -> Result<Cow<'s, CscMatrix<f64>>, FemError> {
        if let Some(stiffness) = &self.stiffness {
            return Ok(Cow::Borrowed(stiffness));
        }
        let Some(rows) = &self.rows else {
            return Ok(Cow::Borrowed(&system.stiffness));
        };
        let kept = self.whole.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(stiffness) = kept {
            return Ok(Cow::Owned(stiffness));
        }
        let place = |e: usize| rows[e].map_or(e, |(at, _)| at);
        reordered(&system.stiffness, place).map(Cow::Owned)
    }

    /// Analyses the pattern of K_c.
    pub(crate) fn analyse(&self, system: &System) -> Result<Arc<Symbolic>, FemError> {
        if let (None, None, Some(known)) = (&self.stiffness, &self.rows, &system.symbolic) {
            return Ok(Arc::clone(known));
        }
        let stiffness = self.stiffness(system)?;
        let symbolic = Symbolic::new(&stiffness)?;
        if let Cow::Owned(stiffness) = stiffness {
            *self.whole.lock().unwrap_or_else(PoisonError::into_inner) = Some(stiffness);
        }
        Ok(Arc::new(symbolic))
    }

    /// K_c - sigma M_c.
    pub(crate) fn shifted(&self, system: &System, sigma: f64) -> Result<CscMatrix<f64>, FemError> {
        let mut a = self.stiffness(system)?.into_owned();
        subtract(&mut a, sigma, &self.mass);
        Ok(a)
    }

    /// The matrices used for residuals: those of the sector, or of the body if the sector is the body.
    pub(crate) fn pencil<'a>(&'a self, system: &'a System) -> Pencil<'a> {
        match &self.stiffness {
            Some(stiffness) => Pencil {
                stiffness,
                mass: &self.mass,
            },
            None => Pencil {
                stiffness: &system.stiffness,
                mass: &system.mass,
            },
        }
    }

    /// Overwrites x, in the order of [`Self::pencil`], with (K - sigma M)^-1 x.
    pub(crate) fn solve(&self, factor: &Factor<'_>, x: &mut Mat<f64>) {
        if self.reorders() {
            let mut part = self.restrict(x.as_ref());
            factor.solve(part.as_mut());
            *x = self.expand(part.as_ref());
        } else {
            factor.solve(x.as_mut());
        }
    }

    /// Number of unknowns.
    pub(crate) fn len(&self) -> usize {
        self.mass.nrows()
    }

    /// T_c x.
    pub(crate) fn expand(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let Some(rows) = &self.rows else {
            return x.to_owned();
        };
        let mut all = Mat::zeros(rows.len(), x.ncols());
        for j in 0..x.ncols() {
            let from = x.col(j);
            for (value, row) in all.col_mut(j).iter_mut().zip(rows) {
                *value = row.map_or(0.0, |(at, weight)| weight * from[at]);
            }
        }
        all
    }

    /// T_c^T f.
    pub(crate) fn restrict(&self, f: MatRef<'_, f64>) -> Mat<f64> {
        let Some(rows) = &self.rows else {
            return f.to_owned();
        };
        let mut part = Mat::zeros(self.len(), f.ncols());
        for j in 0..f.ncols() {
            for (value, row) in f.col(j).iter().zip(rows) {
                if let Some((at, weight)) = *row {
                    part[(at, j)] += weight * value;
                }
            }
        }
        part
    }
}

/// The independent problems that result from the mirror planes of K and M; a single one without symmetry.
pub(crate) fn sectors(system: &System) -> Result<Vec<Sector<'_>>, FemError> {
    divided(system, &respected(system))
}

/// The complete body as a single sector, in an elimination order.
pub(crate) fn whole(system: &System) -> Result<Vec<Sector<'_>>, FemError> {
    divided(system, &[])
}

fn divided<'a>(system: &'a System, mirrors: &[&Mirror]) -> Result<Vec<Sector<'a>>, FemError> {
    if mirrors.is_empty() && system.symbolic.is_some() {
        return Ok(vec![Sector {
            stiffness: None,
            whole: Mutex::new(None),
            mass: Cow::Borrowed(&system.mass),
            rows: None,
        }]);
    }
    let orbits = Orbits::new(mirrors, system.equations.len());
    if mirrors.is_empty() {
        let nodes = orbits.in_order_of_elimination(system)?;
        let mut place = vec![0; system.equations.len()];
        nodes.iter().flatten().enumerate().for_each(|(at, &e)| place[e] = at);
        let [stiffness, mass] = [&system.stiffness, &system.mass];
        let (stiffness, mass) = rayon::join(|| reordered(stiffness, |e| place[e]), || reordered(mass, |e| place[e]));
        return Ok(vec![Sector {
            stiffness: None,
            whole: Mutex::new(Some(stiffness?)),
            mass: Cow::Owned(mass?),
            rows: Some(place.into_iter().map(|at| Some((at, 1.0))).collect()),
        }]);
    }
    let (nodes, columns) = rayon::join(
        || orbits.in_order_of_elimination(system),
        || [&system.stiffness, &system.mass].map(|a| Columns::of(a, &orbits)),
    );
    let nodes = nodes?;
    let parities = (0..1 << mirrors.len()).into_par_iter();
    let sectors = parities.map(|parities| orbits.sector(mirrors, parities, &nodes, &columns));
    // A small body may have no vectors of some combination.
    let sectors = sectors.filter(|s| s.as_ref().map_or(true, |s| s.len() > 0));
    sectors.collect()
}

/// The mirrors S that leave K and M unchanged, tested by A S x = S A x for a random x.
fn respected(system: &System) -> Vec<&Mirror> {
    let mirrors = system.equations.mirrors();
    let mut random = Random::new(2);
    let x: Vec<f64> = (0..system.equations.len()).map(|_| random.next()).collect();
    let images: Vec<Vec<f64>> = mirrors.iter().map(|m| m.apply(&x)).collect();
    let columns = Mat::from_fn(x.len(), 1 + images.len(), |i, j| match j {
        0 => x[i],
        j => images[j - 1][i],
    });
    let mut kept = vec![true; mirrors.len()];
    for a in [&system.stiffness, &system.mass] {
        if mirrors.is_empty() {
            break;
        }
        let y = product(a, columns.as_ref());
        let first: Vec<f64> = y.col(0).iter().copied().collect();
        for (k, mirror) in mirrors.iter().enumerate() {
            let expected = mirror.apply(&first);
            // The diagonal entry comes first in each column of the lower triangle.
            kept[k] &= (0..x.len()).all(|i| {
                let diagonal = a.values()[a.col_offsets()[i]].abs();
                (y[(i, k + 1)] - expected[i]).abs() <= ASYMMETRY * diagonal
            });
        }
    }
    let planes = mirrors.iter().zip(kept).filter(|(_, kept)| *kept).map(|(m, _)| m);
    planes.collect()
}

/// Sets of unknowns that the mirrors map onto each other.
struct Orbits {
    /// The first unknown of the orbit of each unknown, which represents it.
    first: Vec<usize>,
}

impl Orbits {
    fn new(mirrors: &[&Mirror], n: usize) -> Self {
        let first = (0..n).map(|e| images(mirrors, e).map(|(i, _, _)| i).min().unwrap_or(e));
        Self { first: first.collect() }
    }

    fn represents(&self, e: usize) -> bool {
        self.first[e] == e
    }

    /// The representatives, node by node in an elimination order of the graph whose nodes are the orbits.
    fn in_order_of_elimination(&self, system: &System) -> Result<Vec<Vec<usize>>, FemError> {
        let node = |e: usize| system.equations.node(e);
        // Orbits of nodes, numbered in the order of their first unknowns.
        let mut number = vec![None; system.equations.nodes()];
        let mut members: Vec<Vec<usize>> = Vec::new();
        for e in (0..self.first.len()).filter(|&e| self.represents(e)) {
            let orbit = *number[node(e)].get_or_insert_with(|| {
                members.push(Vec::new());
                members.len() - 1
            });
            members[orbit].push(e);
        }
        let orbit = |e: usize| number[node(self.first[e])];
        let mut edges: Vec<Vec<usize>> = vec![Vec::new(); members.len()];
        // One unknown of a node represents the others, because elements couple all of them.
        let leads = |e: usize| e == 0 || node(e) != node(e - 1);
        for j in (0..self.first.len()).filter(|&j| leads(j)) {
            for &i in system.stiffness.col(j).row_indices() {
                let near = leads(i) && (self.represents(i) || self.represents(j));
                if let (true, Some(a), Some(b)) = (near, orbit(i), orbit(j))
                    && a != b
                {
                    edges[a].push(b);
                    edges[b].push(a);
                }
            }
        }
        let (mut offsets, mut targets) = (vec![0], Vec::new());
        for list in &mut edges {
            list.sort_unstable();
            list.dedup();
            targets.append(list);
            offsets.push(targets.len());
        }
        let order = elimination_order(&Graph { offsets, targets })?;
        Ok(order.into_iter().map(|k| std::mem::take(&mut members[k])).collect())
    }

    /// The sector whose vectors are odd in the planes whose bits are set.
    fn sector(
        &self,
        mirrors: &[&Mirror],
        parities: usize,
        nodes: &[Vec<usize>],
        columns: &[Columns; 2],
    ) -> Result<Sector<'static>, FemError> {
        let mut rows = vec![None; self.first.len()];
        let mut unknowns = Vec::new();
        for &e in nodes.iter().flatten() {
            // The sum over all images with the sign of the combination; for unknowns on a plane, vectors of the wrong
            // parity cancel.
            let parity = |planes: usize| 1.0 - 2.0 * f64::from((planes & parities).count_ones() % 2);
            let own: f64 = images(mirrors, e)
                .filter(|&(i, _, _)| i == e)
                .map(|(_, sign, planes)| sign * parity(planes))
                .sum();
            if own == 0.0 {
                continue;
            }
            // Each position occurs as often as e itself.
            let weight = (own / (1 << mirrors.len()) as f64).sqrt();
            for (i, sign, planes) in images(mirrors, e) {
                rows[i] = Some((unknowns.len(), weight * sign * parity(planes)));
            }
            unknowns.push(e);
        }
        let [stiffness, mass] = columns;
        Ok(Sector {
            stiffness: Some(stiffness.reduced(&unknowns, &rows)?),
            whole: Mutex::new(None),
            mass: Cow::Owned(mass.reduced(&unknowns, &rows)?),
            rows: Some(rows),
        })
    }
}

/// The images of unknown e under products of mirrors: unknown, sign, and the planes crossed as bits.
fn images<'a>(mirrors: &'a [&Mirror], e: usize) -> impl Iterator<Item = (usize, f64, usize)> + 'a {
    (0..1 << mirrors.len()).map(move |planes: usize| {
        let crossed = mirrors.iter().enumerate().filter(|(k, _)| planes >> k & 1 == 1);
        let (image, sign) = crossed.fold((e, 1.0), |(i, sign), (_, m)| (m.image[i], sign * m.sign[i]));
        (image, sign, planes)
    })
}

/// The columns that represent orbits, with both triangles.
struct Columns {
    /// Start of each unknown's column, which is empty unless the unknown represents its orbit.
    offsets: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl Columns {
    fn of(a: &CscMatrix<f64>, orbits: &Orbits) -> Self {
        let n = a.nrows();
        let mut offsets = vec![0; n + 1];
        let visit = |take: &mut dyn FnMut(usize, usize, f64)| {
            for (j, column) in a.col_iter().enumerate() {
                for (&i, &value) in column.row_indices().iter().zip(column.values()) {
                    if orbits.represents(j) {
                        take(j, i, value);
                    }
                    if i != j && orbits.represents(i) {
                        take(i, j, value);
                    }
                }
            }
        };
        visit(&mut |column, _, _| offsets[column + 1] += 1);
        for j in 0..n {
            offsets[j + 1] += offsets[j];
        }
        let mut next = offsets.clone();
        let mut entries = vec![(0, 0.0); offsets[n]];
        visit(&mut |column, row, value| {
            entries[next[column]] = (row, value);
            next[column] += 1;
        });
        Self { offsets, entries }
    }

    /// The lower triangle of T^T A T. Every member of an orbit contributes the same as its representative r, so column
    /// a is sum_i t_i A_ir / t_r, where t_r is the weight of r. The square of t_r is the inverse of the orbit's length.
    fn reduced(&self, unknowns: &[usize], rows: &[Option<(usize, f64)>]) -> Result<CscMatrix<f64>, FemError> {
        let n = unknowns.len();
        let (mut offsets, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut sum = vec![0.0; n];
        let mut seen = vec![usize::MAX; n];
        for (a, &r) in unknowns.iter().enumerate() {
            let start = indices.len();
            let own = rows[r].map_or(1.0, |(_, weight)| weight);
            for &(i, value) in &self.entries[self.offsets[r]..self.offsets[r + 1]] {
                let Some((b, weight)) = rows[i].filter(|&(b, _)| b >= a) else {
                    continue;
                };
                if seen[b] != a {
                    seen[b] = a;
                    sum[b] = 0.0;
                    indices.push(b);
                }
                sum[b] += weight / own * value;
            }
            indices[start..].sort_unstable();
            values.extend(indices[start..].iter().map(|&b| sum[b]));
            offsets.push(indices.len());
        }
        CscMatrix::try_from_csc_data(n, n, offsets, indices, values)
            .map_err(|e| FemError::Order { reason: e.to_string() })
    }
}

//! Modes of one body as combinations of the modes of another with the same outer surface.
//!
//! Radiation depends only on the normal velocity of the outer surface. Let B be the velocities of modes whose radiation
//! matrix R is known, and V those of the modes of interest. The fit of each parity is
//!
//! ```text
//! V = B T + rest,   T = (B^T W B + ridge)^-1 B^T W V      =>      R' = T^T R T
//! ```
//!
//! where W contains the areas of the panels. The rest is reported; it is orthogonal to the span of B.

use super::combination::Combination;
use super::independent::{gram, independent, weighted, weights};
use super::mesh_range::MeshRange;
use crate::bem::mesh::boundary::Boundary;
use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix, DVectorView};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Ridge parameter of the normal equations, relative to the squared velocity of each known mode. It limits the
/// amplitudes of nearly dependent modes, which would cancel in R, to a few hundred. Its contribution to the rest is
/// included in the reported rest.
const RIDGE: f64 = 1e-8;

/// Relative amplitude below which a mode's component of a parity counts as zero.
const ABSENT: f64 = 1e-6;

/// Modes of a body as combinations of modes on the same surface whose radiation is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfaceFit {
    /// Indices of the independent known modes of each parity, and T.
    parities: Vec<(Vec<usize>, Combination)>,
    /// V^T W V summed over all parities, and the same for the rest, which includes the loss between different meshes.
    #[serde(with = "crate::blocks")]
    whole: DMatrix<f64>,
    #[serde(with = "crate::blocks")]
    rest: DMatrix<f64>,
    /// rho c of the air of the known radiation \[Pa s/m\].
    impedance: f64,
}

impl SurfaceFit {
    /// Fits the modes of `body` with those of `known`, both on the finest mesh; none if the surfaces differ. If only
    /// their triangle meshes differ, the velocities of `body` are interpolated on the mesh of `known`
    /// ([`Boundary::interpolate_from`]). Any change due to interpolating there and back counts as part of the rest.
    pub fn new(known: &MeshRange, body: &MeshRange) -> Option<Self> {
        let boundary = known.problem.boundary();
        if known.patterns.len() != body.patterns.len() {
            return None;
        }
        let areas = weights(boundary);
        let modes = body.motions();
        let carried = body
            .patterns
            .par_iter()
            .map(|p| Carried::new(boundary, body, &p.velocities));
        let carried: Vec<Carried> = carried.collect::<Option<_>>()?;
        let squares: Vec<Vec<f64>> = carried.iter().map(|p| column_squares(&p.velocities, &areas)).collect();
        let square = |mode: usize| squares.iter().map(|of_parity| of_parity[mode]).sum::<f64>();
        let mut fit = Self {
            parities: Vec::new(),
            whole: DMatrix::zeros(modes, modes),
            rest: DMatrix::zeros(modes, modes),
            impedance: known.problem.air().impedance(),
        };
        let copies = boundary.copies() as f64;
        let chosen = independent(known);
        for (((pick, of_known), of_body), own) in chosen.iter().zip(&known.patterns).zip(&carried).zip(&squares) {
            if let Some(lost) = &of_body.lost {
                fit.rest += lost * copies;
            }
            let present: Vec<usize> = (0..modes)
                .filter(|&mode| own[mode] > ABSENT * ABSENT * square(mode))
                .collect();
            let (b, v) = (
                pick.of(of_known).velocities,
                of_body.velocities.select_columns(&present),
            );
            let weighted_b = weighted(&b, &areas).transpose();
            let t = solved(&(&weighted_b * &b), &weighted_b * &v);
            let left = &v - &b * &t;
            for (to, from) in [(&mut fit.whole, &v), (&mut fit.rest, &left)] {
                let gram = gram(from, &areas);
                for (j, &to_j) in present.iter().enumerate() {
                    for (i, &to_i) in present.iter().enumerate() {
                        to[(to_i, to_j)] += copies * gram[(i, j)];
                    }
                }
            }
            fit.parities
                .push((pick.modes.clone(), Combination::of_others(modes, present, t)));
        }
        Some(fit)
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.whole.nrows()
    }

    /// For each mode, the velocity that no combination represents, relative to the velocity of the mode \[-\]. Both are
    /// root mean squares over the surface. The ratio is 0 for a mode that does not move the surface.
    pub fn residuals(&self) -> Vec<f64> {
        let ratio = |(rest, whole): (&f64, &f64)| {
            if *whole > 0.0 {
                (rest / whole).max(0.0).sqrt()
            } else {
                0.0
            }
        };
        self.rest
            .diagonal()
            .iter()
            .zip(self.whole.diagonal().iter())
            .map(ratio)
            .collect()
    }

    /// Integrals over the surface of the squared velocity, in total and for the part that no combination represents,
    /// summed over the columns of `amplitudes`. The amplitudes are those of the modes from `first` onwards.
    pub fn squares(&self, first: usize, amplitudes: &DMatrix<Complex<f64>>) -> [f64; 2] {
        let n = amplitudes.nrows();
        [&self.whole, &self.rest].map(|gram| {
            let gram = gram.view((first, first), (n, n));
            let form = |part: DMatrix<f64>| part.dot(&(gram * &part));
            (form(amplitudes.map(|z| z.re)) + form(amplitudes.map(|z| z.im))).max(0.0)
        })
    }

    /// Energy spectrum of the motion that no combination represents, assuming radiation efficiency 1: 2 rho c a^H rest
    /// a / omega^2, for transforms of the modal accelerations at frequencies \[Hz\].
    pub(crate) fn rest_energy(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> Vec<f64> {
        let moved = real_product(&self.rest, accelerations);
        let columns = moved.column_iter().zip(accelerations.column_iter());
        let forms = columns.map(|(moved, a)| a.iter().zip(moved.iter()).map(|(a, m)| (a.conj() * m).re).sum());
        let energy = |(form, hz): (f64, &f64)| {
            let omega = TAU * hz;
            if omega > 0.0 {
                2.0 * self.impedance * form.max(0.0) / (omega * omega)
            } else {
                0.0
            }
        };
        forms.zip(frequency).map(energy).collect()
    }

    /// The combinations in the order of those of the known modes; none if those are for different modes.
    pub(crate) fn combinations_of(&self, known: &[Combination]) -> Option<Vec<Combination>> {
        let own: Vec<_> = self.parities.iter().filter(|(modes, _)| !modes.is_empty()).collect();
        let same = own.len() == known.len()
            && own
                .iter()
                .zip(known)
                .all(|((modes, _), known)| modes == known.independent());
        same.then(|| own.into_iter().map(|(_, combination)| combination.clone()).collect())
    }
}

/// Velocities of a body transferred to the mesh of the known modes.
struct Carried<'a> {
    velocities: Cow<'a, DMatrix<f64>>,
    /// Gram matrix, weighted with areas, of the change due to transfer to that mesh and back; none on the same mesh.
    lost: Option<DMatrix<f64>>,
}

impl<'a> Carried<'a> {
    fn new(boundary: &Boundary, body: &MeshRange, velocities: &'a DMatrix<f64>) -> Option<Self> {
        let own = body.problem.boundary();
        let (ours, theirs) = (boundary.mesh(), own.mesh());
        if ours.points == theirs.points && ours.panels == theirs.panels {
            return Some(Self {
                velocities: Cow::Borrowed(velocities),
                lost: None,
            });
        }
        let there = boundary.interpolate_from(own, velocities)?;
        let lost = velocities - own.interpolate_from(boundary, &there)?;
        Some(Self {
            velocities: Cow::Owned(there),
            lost: Some(gram(&lost, &weights(own))),
        })
    }
}

/// Weighted squares of all columns.
fn column_squares(values: &DMatrix<f64>, weights: &[f64]) -> Vec<f64> {
    let square = |column: DVectorView<'_, f64>| column.iter().zip(weights).map(|(v, w)| v * v * w).sum();
    values.column_iter().map(square).collect()
}

/// T from the normal equations with their ridge, with every known mode scaled to unit velocity.
fn solved(normal: &DMatrix<f64>, right: DMatrix<f64>) -> DMatrix<f64> {
    let scale: Vec<f64> = normal
        .diagonal()
        .iter()
        .map(|g| g.max(f64::MIN_POSITIVE).sqrt().recip())
        .collect();
    let mut scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] * scale[i] * scale[j]
    });
    for i in 0..scaled.nrows() {
        scaled[(i, i)] += RIDGE;
    }
    let mut t = right;
    let scale_rows = |t: &mut DMatrix<f64>| {
        for mut column in t.column_iter_mut() {
            column.iter_mut().zip(&scale).for_each(|(v, s)| *v *= s);
        }
    };
    scale_rows(&mut t);
    if let Some(cholesky) = scaled.cholesky() {
        cholesky.solve_mut(&mut t);
    } else {
        // Impossible with a ridge above the rounding of the products; zero amplitudes leave everything in the rest.
        t.fill(0.0);
    }
    scale_rows(&mut t);
    t
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::air::Air;
    use crate::bem::{BoundaryMesh, Exterior, Patterns, SolidBox};
    use crate::radiation::boundary_elements::ModalBem;
    use crate::radiation::{ModalRadiation, Sampling};

    /// Highest frequency of the tests \[Hz\].
    const TOP_HZ: f64 = 300.0;

    /// A quarter of a box in free space, 0.4 x 0.3 x 0.2 m. Its panels move with each of these functions.
    fn moving(shapes: &[&dyn Fn([f64; 3]) -> f64]) -> MeshRange {
        let whole = [SolidBox {
            low: [-0.2, -0.15, 0.0],
            high: [0.2, 0.15, 0.2],
            part: 0,
        }];
        let planes = [Some(0.0), Some(0.0), None];
        let mesh = BoundaryMesh::of_boxes(&whole, planes, 0.07, vec!["all".to_owned()], |_| 0).unwrap();
        let boundary = Boundary::symmetric(mesh, [Some(0.0), Some(0.0)], None).unwrap();
        let velocities = boundary.project(shapes.len(), |_, _, point, values| {
            let x = point.position;
            for (value, shape) in values.iter_mut().zip(shapes) {
                *value = shape([x.x, x.y, x.z]);
            }
        });
        MeshRange {
            problem: Exterior::new(boundary, &Air::default()),
            top_hz: TOP_HZ,
            patterns: vec![Patterns {
                parity: Default::default(),
                velocities,
            }],
        }
    }

    const ONE: &dyn Fn([f64; 3]) -> f64 = &|_| 1.0;
    const HEIGHT: &dyn Fn([f64; 3]) -> f64 = &|[_, _, z]| z;
    const BENT: &dyn Fn([f64; 3]) -> f64 = &|[x, y, _]| x * x - 0.5 * y * y;

    #[test]
    fn the_known_modes_fit_themselves_and_their_combinations() {
        let known = moving(&[ONE, HEIGHT, BENT]);
        let itself = SurfaceFit::new(&known, &known).unwrap();
        let mixed = moving(&[&|x| 2.0 * ONE(x) - HEIGHT(x), &|x| HEIGHT(x) + 30.0 * BENT(x)]);
        let fit = SurfaceFit::new(&known, &mixed).unwrap();
        for residual in itself.residuals().into_iter().chain(fit.residuals()) {
            assert!(residual < 1e-6, "{residual}");
        }
    }

    #[test]
    fn what_no_combination_holds_is_the_residual() {
        let (known, odd) = (moving(&[ONE]), moving(&[HEIGHT]));
        let fit = SurfaceFit::new(&known, &odd).unwrap();
        // z minus its mean over the surface.
        let areas = weights(known.problem.boundary());
        let z = odd.patterns[0].velocities.column(0);
        let whole: f64 = areas.iter().sum();
        let mean = z.iter().zip(&areas).map(|(z, a)| z * a).sum::<f64>() / whole;
        let square = |m: f64| z.iter().zip(&areas).map(|(z, a)| (z - m).powi(2) * a).sum::<f64>();
        let exact = (square(mean) / square(0.0)).sqrt();
        assert!(
            (fit.residuals()[0] / exact - 1.0).abs() < 1e-6,
            "{:?} {exact}",
            fit.residuals()
        );
        assert!(exact > 0.1);
        // Four quarters move, with the squares of the amplitudes.
        let [of_whole, of_rest] = fit.squares(0, &DMatrix::from_element(1, 1, Complex::new(0.0, 3.0)));
        assert!((of_whole / (36.0 * square(0.0)) - 1.0).abs() < 1e-9);
        assert!((of_rest / (36.0 * square(mean)) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn another_surface_has_no_fit() {
        let (known, mut other) = (moving(&[ONE]), moving(&[ONE]));
        let finer = other.problem.boundary().mesh().clone();
        let mut shifted = finer;
        shifted.points.iter_mut().for_each(|point| point.z += 0.01);
        let boundary = Boundary::symmetric(shifted, [Some(0.0), Some(0.0)], None).unwrap();
        other.problem = Exterior::new(boundary, &Air::default());
        assert!(SurfaceFit::new(&known, &other).is_none());
    }

    /// R' = T^T R T, compared with boundary elements for the combined motion.
    #[test]
    fn combined_modes_radiate_as_boundary_elements_of_their_own() {
        let known = moving(&[ONE, HEIGHT, BENT]);
        let mixed = || moving(&[&|x| ONE(x) - 4.0 * HEIGHT(x), &|x| HEIGHT(x) + 30.0 * BENT(x)]);
        let fit = SurfaceFit::new(&known, &mixed()).unwrap();
        let sampling = Sampling {
            range_hz: [100.0, TOP_HZ],
            tolerance: 1e-3,
            ..Sampling::default()
        };
        let solve = |level| ModalBem::new(vec![level], &sampling, &|| ()).unwrap();
        let (carried, own) = (solve(known).of_modes(&fit).unwrap(), solve(mixed()));
        assert!(own.of_modes(&fit).is_none(), "the fit belongs to the known modes");
        for hz in [100.0, 170.0, 250.0, 500.0, 2000.0] {
            let [a, b] = [&carried, &own].map(|bem| bem.resistance(hz).real);
            for (i, j) in [(0, 0), (0, 1), (1, 1)] {
                let scale = (b[(i, i)] * b[(j, j)]).sqrt();
                assert!((a[(i, j)] - b[(i, j)]).abs() < 2e-3 * scale, "{hz} Hz: {a} against {b}");
            }
        }
    }
}

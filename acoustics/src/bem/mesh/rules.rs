//! Quadrature on panels and on pairs of panels.

use nailnoise_meshes::{FaceKind, gauss_legendre};
use nalgebra::DMatrix;

/// A point in natural coordinates and its weight.
pub(crate) type Node = ([f64; 2], f64);

/// Gauss points and weights on \[0, 1\].
fn unit_gauss(n: usize) -> Vec<(f64, f64)> {
    gauss_legendre(n)
        .into_iter()
        .map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w))
        .collect()
}

/// Points and weights on \[0, 1\] for integrals of s f(s), exact for f of degree 2n - 1. They follow from the
/// eigenvalues of the Jacobi matrix of the polynomials orthogonal with respect to s (Golub & Welsch, *Math. Comp.* 23,
/// 1969).
///
/// gauss-quad 0.3 is not used: its Gauss-Jacobi rules place the middle of an odd number of points at zero, which is
/// correct only for symmetric weights.
fn unit_gauss_jacobi(n: usize) -> Vec<(f64, f64)> {
    let entry = |i: usize, j: usize| {
        let k = i.max(j) as f64;
        match i.abs_diff(j) {
            0 => 1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0)),
            1 => (k * (k + 1.0)).sqrt() / (2.0 * k + 1.0),
            _ => 0.0,
        }
    };
    let eigen = DMatrix::from_fn(n, n, entry).symmetric_eigen();
    let node = |i: usize| {
        let weight = 0.5 * eigen.eigenvectors[(0, i)].powi(2);
        (0.5 * (1.0 + eigen.eigenvalues[i]), weight)
    };
    (0..n).map(node).collect()
}

/// The n x n product rule on the square \[-1, 1\]^2.
pub(crate) fn square(n: usize) -> Vec<Node> {
    let line = gauss_legendre(n);
    line.iter()
        .flat_map(|&(y, wy)| line.iter().map(move |&(x, wx)| ([x, y], wx * wy)))
        .collect()
}

/// Symmetric rules on the unit triangle with 3, 7, 12 and 16 points, of degree 2, 5, 6 and 8 (Strang & Fix 1973;
/// Dunavant 1985).
pub(crate) fn triangle(points: usize) -> Vec<Node> {
    // Barycentric orbits: (a, a, 1 - 2a) with its weight, then (a, b, c) with its weight; the weights sum to one.
    type Orbits = (f64, &'static [(f64, f64)], &'static [(f64, f64, f64)]);
    let (centre, threes, sixes): Orbits = match points {
        3 => (0.0, &[(1.0 / 6.0, 1.0 / 3.0)], &[]),
        7 => (
            0.225,
            &[
                (0.470_142_064_105_115_1, 0.132_394_152_788_506_2),
                (0.101_286_507_323_456_34, 0.125_939_180_544_827_15),
            ],
            &[],
        ),
        16 => (
            0.144_315_607_677_787_17,
            &[
                (0.459_292_588_292_723_1, 0.095_091_634_267_284_63),
                (0.170_569_307_751_760_2, 0.103_217_370_534_718_25),
                (0.050_547_228_317_030_98, 0.032_458_497_623_198_08),
            ],
            &[(
                0.263_112_829_634_638_1,
                0.008_394_777_409_957_605,
                0.027_230_314_174_434_993,
            )],
        ),
        _ => (
            0.0,
            &[
                (0.249_286_745_170_910_42, 0.116_786_275_726_379_37),
                (0.063_089_014_491_502_23, 0.050_844_906_370_206_82),
            ],
            &[(
                0.310_352_451_033_784_4,
                0.053_145_049_844_816_95,
                0.082_851_075_618_373_57,
            )],
        ),
    };
    let mut rule = Vec::new();
    if centre > 0.0 {
        rule.push(([1.0 / 3.0, 1.0 / 3.0], 0.5 * centre));
    }
    for &(a, w) in threes {
        let b = 1.0 - 2.0 * a;
        rule.extend([[a, a], [b, a], [a, b]].map(|p| (p, 0.5 * w)));
    }
    for &(a, b, w) in sixes {
        let c = 1.0 - a - b;
        rule.extend([[a, b], [b, a], [a, c], [c, a], [b, c], [c, b]].map(|p| (p, 0.5 * w)));
    }
    rule
}

/// The rule for distant pairs, which has as many points as the panel has corners.
pub(crate) fn far(corners: usize) -> Vec<Node> {
    match corners {
        3 => triangle(3),
        _ => square(2),
    }
}

/// A rule that integrates areas and masses of curved panels to high accuracy.
pub(crate) fn fine(kind: FaceKind) -> Vec<Node> {
    match kind.corners() {
        3 => triangle(12),
        _ => square(4),
    }
}

/// How two triangles touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Contact {
    Identical,
    /// Their first two vertices coincide.
    Edge,
    /// Their first vertices coincide.
    Vertex,
}

/// A pair of points: barycentric coordinates in the first and second triangle, and the weight with respect to twice the
/// area of each.
pub(crate) type PairNode = ([f64; 3], [f64; 3], f64);

/// The rule of Sauter & Schwab (*Boundary Element Methods*, 2011, section 5.2) for two touching triangles. It has n
/// Gauss points in each of three directions and n - 1 in the direction away from the singularity.
///
/// A change of variables for every position of the singularity makes the integrand analytic. For kernels that grow as
/// 1/s or 1/s², the Jacobian is s³ in the direction away from the singularity; a factor s remains, and a rule for s
/// f(s) needs one point less.
pub(crate) fn sauter_schwab(contact: Contact, n: usize) -> Vec<PairNode> {
    let line = unit_gauss(n);
    let away = unit_gauss_jacobi(n - 1);
    let mut rule = Vec::new();
    // Points of the reference triangle 0 < x2 < x1 < 1 with vertices (0, 0), (1, 0), (1, 1).
    let barycentric = |[x1, x2]: [f64; 2]| [1.0 - x1, x1 - x2, x2];
    for &(s, ws) in &away {
        for &(a, wa) in &line {
            for &(b, wb) in &line {
                for &(c, wc) in &line {
                    let w = ws * wa * wb * wc * s.powi(2);
                    let mut push = |x: [f64; 2], y: [f64; 2], factor: f64| {
                        let scaled = |p: [f64; 2]| barycentric([s * p[0], s * p[1]]);
                        rule.push((scaled(x), scaled(y), w * factor));
                    };
                    match contact {
                        Contact::Identical => {
                            let factor = a * a * b;
                            let pairs = [
                                ([1.0, 1.0 - a + a * b], [1.0 - a * b * c, 1.0 - a]),
                                ([1.0, a * (1.0 - b + b * c)], [1.0 - a * b, a * (1.0 - b)]),
                                ([1.0 - a * b * c, a * (1.0 - b * c)], [1.0, a * (1.0 - b)]),
                            ];
                            for (x, y) in pairs {
                                push(x, y, factor);
                                push(y, x, factor);
                            }
                        }
                        Contact::Edge => {
                            push([1.0, a * c], [1.0 - a * b, a * (1.0 - b)], a * a);
                            let factor = a * a * b;
                            let far = [1.0 - a * b * c, a * b * (1.0 - c)];
                            push([1.0, a], far, factor);
                            push([1.0 - a * b, a * (1.0 - b)], [1.0, a * b * c], factor);
                            push(far, [1.0, a], factor);
                            push([1.0 - a * b * c, a * (1.0 - b * c)], [1.0, a * b], factor);
                        }
                        Contact::Vertex => {
                            push([1.0, a], [b, b * c], b);
                            push([b, b * c], [1.0, a], b);
                        }
                    }
                }
            }
        }
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral of x1^a x2^b over the reference triangle in barycentric form: x1 = l1 + l2, x2 = l2.
    fn exact(a: i32, b: i32) -> f64 {
        1.0 / (f64::from(b + 1) * f64::from(a + b + 2))
    }

    #[test]
    fn pair_rules_integrate_polynomials() {
        for contact in [Contact::Identical, Contact::Edge, Contact::Vertex] {
            let rule = sauter_schwab(contact, 6);
            for [a, b, c, d] in [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 2], [1, 1, 2, 0], [0, 2, 1, 1]] {
                let x = |l: [f64; 3], a: i32, b: i32| (l[1] + l[2]).powi(a) * l[2].powi(b);
                let sum: f64 = rule.iter().map(|&(p, q, w)| w * x(p, a, b) * x(q, c, d)).sum();
                let exact = exact(a, b) * exact(c, d);
                assert!(
                    (sum / exact - 1.0).abs() < 1e-12,
                    "{contact:?} {a}{b}{c}{d}: {sum} {exact}"
                );
            }
        }
    }

    #[test]
    fn triangle_rules_integrate_to_their_degree() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (points, degree) in [(3, 2), (7, 5), (12, 6), (16, 8)] {
            let rule = triangle(points);
            assert_eq!(rule.len(), points);
            for a in 0..=degree {
                for b in 0..=degree - a {
                    let sum: f64 = rule.iter().map(|([x, y], w)| w * x.powi(a) * y.powi(b)).sum();
                    let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
                    assert!(
                        (sum / exact - 1.0).abs() < 1e-12,
                        "{points} points, {a} {b}: {sum} {exact}"
                    );
                }
            }
        }
    }

    /// Two unit right triangles: the 4-D integral of 1/r over a triangle and itself, compared with the closed form of
    /// the inner integral.
    #[test]
    fn touching_pairs_converge_fast() {
        for contact in [Contact::Identical, Contact::Edge, Contact::Vertex] {
            let y_vertices = match contact {
                Contact::Identical => [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                Contact::Edge => [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
                Contact::Vertex => [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.3], [0.0, -1.0, 0.0]],
            };
            let x_vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0f64]];
            let value = |n: usize| -> f64 {
                let at = |v: &[[f64; 3]; 3], l: [f64; 3], k: usize| l[0] * v[0][k] + l[1] * v[1][k] + l[2] * v[2][k];
                sauter_schwab(contact, n)
                    .iter()
                    .map(|&(p, q, w)| {
                        let d = [0, 1, 2].map(|k| at(&x_vertices, p, k) - at(&y_vertices, q, k));
                        w / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
                    })
                    .sum()
            };
            let exact = value(14);
            let errors = [2, 3, 4, 5].map(|n| (value(n) / exact - 1.0).abs());
            println!("{contact:?} {errors:?}");
            assert!(
                errors[2] < 2e-4 && errors[3] < 0.5 * errors[1],
                "{contact:?}: {errors:?}"
            );
        }
    }
}

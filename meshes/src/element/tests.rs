use nalgebra::{Matrix3, Vector3};

use super::{ElementKind, FaceKind};

const INSIDE: [f64; 3] = [0.21, 0.34, 0.17];

#[test]
fn shape_functions_are_one_at_their_node_and_zero_at_the_others() {
    for kind in ElementKind::ALL {
        let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
        for (a, c) in kind.natural_nodes().iter().enumerate() {
            kind.shape(*c, &mut n, &mut dn);
            for (b, value) in n[..kind.nodes()].iter().enumerate() {
                assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15, "{kind:?} {a} {b}");
            }
        }
    }
    for kind in FaceKind::ALL {
        let (mut n, mut dn) = ([0.0; 9], [[0.0; 2]; 9]);
        for (a, c) in kind.natural_nodes().iter().enumerate() {
            kind.shape(*c, &mut n, &mut dn);
            for (b, value) in n[..kind.nodes()].iter().enumerate() {
                assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15, "{kind:?} {a} {b}");
            }
        }
    }
}

#[test]
fn shape_functions_sum_to_one_and_leave_the_rest_alone() {
    for kind in ElementKind::ALL {
        let (mut n, mut dn) = ([7.0; 28], [[7.0; 3]; 28]);
        kind.shape(INSIDE, &mut n, &mut dn);
        let (mut sum, mut slope) = (-1.0, Vector3::zeros());
        for a in 0..kind.nodes() {
            sum += n[a];
            slope += Vector3::from(dn[a]);
        }
        assert!(sum.abs() < 1e-15 && slope.amax() < 1e-15, "{kind:?}");
        assert!(n[kind.nodes()..].iter().all(|&v| v == 7.0), "{kind:?}");
    }
    for kind in FaceKind::ALL {
        let (mut n, mut dn) = ([7.0; 10], [[7.0; 2]; 10]);
        kind.shape([0.2, 0.3], &mut n, &mut dn);
        let sum: f64 = n[..kind.nodes()].iter().sum();
        assert!((sum - 1.0).abs() < 1e-15, "{kind:?}");
        assert!(n[kind.nodes()..].iter().all(|&v| v == 7.0), "{kind:?}");
    }
}

#[test]
fn gradients_agree_with_differences() {
    let h = 1e-6;
    for kind in ElementKind::ALL {
        let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
        kind.shape(INSIDE, &mut n, &mut dn);
        for k in 0..3 {
            let (mut up, mut down, mut skip) = ([0.0; 27], [0.0; 27], [[0.0; 3]; 27]);
            let mut at = INSIDE;
            at[k] += h;
            kind.shape(at, &mut up, &mut skip);
            at[k] -= 2.0 * h;
            kind.shape(at, &mut down, &mut skip);
            for a in 0..kind.nodes() {
                assert!(((up[a] - down[a]) / (2.0 * h) - dn[a][k]).abs() < 1e-9, "{kind:?} {a}");
            }
        }
    }
    for kind in FaceKind::ALL {
        let xi = [0.3, 0.4];
        let (mut n, mut dn) = ([0.0; 9], [[0.0; 2]; 9]);
        kind.shape(xi, &mut n, &mut dn);
        for k in 0..2 {
            let (mut up, mut down, mut skip) = ([0.0; 9], [0.0; 9], [[0.0; 2]; 9]);
            let mut at = xi;
            at[k] += h;
            kind.shape(at, &mut up, &mut skip);
            at[k] -= 2.0 * h;
            kind.shape(at, &mut down, &mut skip);
            for a in 0..kind.nodes() {
                assert!(((up[a] - down[a]) / (2.0 * h) - dn[a][k]).abs() < 1e-9, "{kind:?} {a}");
            }
        }
    }
}

#[test]
fn the_space_holds_every_polynomial_of_its_order() {
    for kind in ElementKind::ALL {
        let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
        kind.shape(INSIDE, &mut n, &mut dn);
        let degree = kind.order() as i32;
        for (i, j, k) in powers(degree) {
            let monomial = |x: [f64; 3]| x[0].powi(i) * x[1].powi(j) * x[2].powi(k);
            let value: f64 = kind.natural_nodes().iter().zip(&n).map(|(&x, n)| n * monomial(x)).sum();
            assert!((value - monomial(INSIDE)).abs() < 1e-15, "{kind:?} x^{i} y^{j} z^{k}");
        }
    }
}

fn powers(degree: i32) -> impl Iterator<Item = (i32, i32, i32)> {
    (0..=degree).flat_map(move |i| (0..=degree - i).flat_map(move |j| (0..=degree - i - j).map(move |k| (i, j, k))))
}

/// The faces match the volume element: their shape functions are its restrictions, their normals point outwards, and
/// the divergence theorem yields its volume.
#[test]
fn faces_close_the_element_with_outward_normals() {
    for kind in ElementKind::ALL {
        let nodes = kind.natural_nodes();
        let centre = Vector3::from(kind.centre());
        let mut volume = 0.0;
        for (number, local) in kind.faces().iter().enumerate() {
            let face = kind.face_kind(number);
            assert_eq!(local.len(), face.nodes(), "{kind:?}");
            let (mut n, mut dn) = ([0.0; 9], [[0.0; 2]; 9]);
            let (mut whole, mut skip) = ([0.0; 27], [[0.0; 3]; 27]);
            for (xi, weight) in face.rule(3).expect("a rule") {
                face.shape(xi, &mut n, &mut dn);
                let mut x = Vector3::zeros();
                let mut t = [Vector3::zeros(); 2];
                for (a, &node) in local.iter().enumerate() {
                    let p = Vector3::from(nodes[node]);
                    x += n[a] * p;
                    t[0] += dn[a][0] * p;
                    t[1] += dn[a][1] * p;
                }
                let normal = t[0].cross(&t[1]);
                assert!(normal.dot(&(x - centre)) > 0.0, "{kind:?} face {number}");
                volume += weight * normal.dot(&x) / 3.0;
                kind.shape(x.into(), &mut whole, &mut skip);
                for (node, value) in whole[..kind.nodes()].iter().enumerate() {
                    let expected = local.iter().position(|&l| l == node).map_or(0.0, |a| n[a]);
                    assert!((value - expected).abs() < 1e-14, "{kind:?} face {number} node {node}");
                }
            }
        }
        let exact: f64 = kind.rule().expect("a rule").iter().map(|p| p.1).sum();
        assert!((volume - exact).abs() < 1e-14, "{kind:?}: {volume} against {exact}");
    }
}

/// In VTK's numbering, the mid-side nodes follow the edges in order, and then come the centres of the faces -x to +z.
#[test]
fn mid_sides_and_centres_stand_where_vtk_has_them() {
    for kind in ElementKind::ALL.into_iter().filter(|k| k.order() == 2) {
        let nodes = kind.natural_nodes();
        for (i, &[a, b]) in kind.edges().iter().enumerate() {
            let middle: [f64; 3] = std::array::from_fn(|k| (nodes[a][k] + nodes[b][k]) / 2.0);
            assert_eq!(middle, nodes[kind.corners() + i], "{kind:?}");
        }
    }
    let centres = &ElementKind::Hex27.natural_nodes()[20..];
    for (face, centre) in centres[..6].iter().enumerate() {
        let mut expected = [0.0; 3];
        expected[face / 2] = if face % 2 == 0 { -1.0 } else { 1.0 };
        assert_eq!(*centre, expected);
    }
    let types = ElementKind::ALL.map(|kind| kind.vtk_type() as u8);
    assert_eq!(types, [12, 25, 29, 10, 24, 26]);
    assert_eq!(FaceKind::ALL.map(|kind| kind.vtk_type() as u8), [5, 22, 9, 23, 28]);
    for kind in FaceKind::ALL {
        let (nodes, corners) = (kind.natural_nodes(), kind.corners());
        for mid in corners..kind.nodes().min(2 * corners) {
            let (a, b) = (nodes[mid - corners], nodes[(mid - corners + 1) % corners]);
            assert_eq!([0, 1].map(|k| (a[k] + b[k]) / 2.0), nodes[mid], "{kind:?}");
        }
    }
}

fn factorial(n: i32) -> f64 {
    (1..=n).map(f64::from).product()
}

/// The integral of x^i y^j z^k over the natural domain.
fn moment(kind: ElementKind, i: i32, j: i32, k: i32) -> f64 {
    let line = |n: i32| if n % 2 == 0 { 2.0 / f64::from(n + 1) } else { 0.0 };
    match kind.corners() {
        8 => line(i) * line(j) * line(k),
        6 => factorial(i) * factorial(j) / factorial(i + j + 2) * line(k),
        _ => factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3),
    }
}

#[test]
fn volume_rules_have_the_degree_stated() {
    for kind in ElementKind::ALL {
        let degree = match kind {
            ElementKind::Hex8 => 3,
            ElementKind::Tet4 => 2,
            ElementKind::Wedge15 => 4,
            _ => 5,
        };
        let rule = kind.rule().expect("a rule");
        assert!(rule.iter().all(|p| p.1 > 0.0 && kind.outside(p.0) < 0.0), "{kind:?}");
        for (i, j, k) in powers(degree) {
            let sum: f64 = rule
                .iter()
                .map(|(x, w)| w * x[0].powi(i) * x[1].powi(j) * x[2].powi(k))
                .sum();
            assert!(
                (sum - moment(kind, i, j, k)).abs() < 5e-15 * moment(kind, 0, 0, 0),
                "{kind:?} x^{i} y^{j} z^{k}: {sum} against {}",
                moment(kind, i, j, k)
            );
        }
    }
}

/// The mass of the natural element, m_ab = integral of N_a N_b, computed with its rule and with a finer one.
#[test]
fn rules_integrate_the_mass_exactly() {
    for kind in ElementKind::ALL {
        let mass = |rule: &[([f64; 3], f64)]| -> Vec<f64> {
            let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
            let count = kind.nodes();
            let mut m = vec![0.0; count * count];
            for (xi, w) in rule {
                kind.shape(*xi, &mut n, &mut dn);
                for a in 0..count {
                    for b in 0..count {
                        m[count * a + b] += w * n[a] * n[b];
                    }
                }
            }
            m
        };
        // Gauss points collapsed onto the shape: maps (u, v, w) in [0, 1]^3 to barycentric coordinates.
        let gauss = crate::gauss_legendre(6);
        let mut fine = Vec::new();
        for &(u, wu) in &gauss {
            for &(v, wv) in &gauss {
                for &(t, wt) in &gauss {
                    let w = wu * wv * wt;
                    let (p, q, r) = ((1.0 + u) / 2.0, (1.0 + v) / 2.0, (1.0 + t) / 2.0);
                    fine.push(match kind.corners() {
                        8 => ([u, v, t], w),
                        6 => ([p, (1.0 - p) * q, t], w * (1.0 - p) / 4.0),
                        _ => (
                            [p, (1.0 - p) * q, (1.0 - p) * (1.0 - q) * r],
                            w * (1.0 - p).powi(2) * (1.0 - q) / 8.0,
                        ),
                    });
                }
            }
        }
        let (coarse, fine) = (mass(&kind.rule().expect("a rule")), mass(&fine));
        for (a, b) in coarse.iter().zip(&fine) {
            assert!((a - b).abs() < 1e-14, "{kind:?}: {a} against {b}");
        }
    }
}

#[test]
fn face_rules_have_the_degree_stated() {
    for kind in [FaceKind::Tri6, FaceKind::Quad8] {
        for n in 1..=9 {
            let degree = match (kind.corners(), n) {
                (3, 2) => 4,
                _ => 2 * n - 1,
            };
            let rule = kind.rule(n as usize).expect("a rule");
            assert!(rule.iter().all(|p| p.1 > 0.0 && kind.outside(p.0) < 0.0));
            for (i, j, _) in powers(degree).filter(|p| p.2 == 0) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x[0].powi(i) * x[1].powi(j)).sum();
                let line = |n: i32| if n % 2 == 0 { 2.0 / f64::from(n + 1) } else { 0.0 };
                let exact = match kind.corners() {
                    3 => factorial(i) * factorial(j) / factorial(i + j + 2),
                    _ => line(i) * line(j),
                };
                assert!(
                    (sum - exact).abs() < 2e-14,
                    "{kind:?} n {n} x^{i} y^{j}: {sum} against {exact}"
                );
            }
        }
    }
}

/// Elements are right-handed in their natural coordinates.
#[test]
fn the_identity_map_has_a_unit_jacobian() {
    for kind in ElementKind::ALL {
        let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
        kind.shape(INSIDE, &mut n, &mut dn);
        let mut j = Matrix3::zeros();
        for (a, x) in kind.natural_nodes().iter().enumerate() {
            j += Vector3::from(*x) * Vector3::from(dn[a]).transpose();
        }
        assert!((j - Matrix3::identity()).amax() < 1e-14, "{kind:?}");
    }
}

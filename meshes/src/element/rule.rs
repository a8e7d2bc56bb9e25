//! Quadrature rules on the natural domains of elements and faces.

use super::{ElementKind, FaceKind, Family};
use crate::{MeshError, gauss_legendre};

impl ElementKind {
    /// Points and weights that integrate the mass and stiffness matrices of this kind exactly if the element is an
    /// affine image of its natural domain. The weights sum to the volume of that domain.
    ///
    /// | kind | rule | degree |
    /// |---|---|---|
    /// | Hex8 | 2 x 2 x 2 Gauss points | 3 in each direction |
    /// | Hex20, Hex27 | 3 x 3 x 3 Gauss points | 5 in each direction |
    /// | Tet4 | 4 points (Hammer & Stroud 1956) | 2 |
    /// | Tet10 | 14 points (Walkington 2000) | 5 |
    /// | Wedge15 | 6 points (Dunavant 1985) x 3 Gauss points | 4 in the triangle, 5 along t |
    ///
    /// # Errors
    /// None in practice: the Gauss rules used here exist.
    pub fn rule(self) -> Result<Vec<([f64; 3], f64)>, MeshError> {
        let points = match self.family() {
            Family::Hex => {
                let gauss = gauss_legendre(self.order() + 1);
                let mut points = Vec::with_capacity(gauss.len().pow(3));
                for &(z, wz) in &gauss {
                    for &(y, wy) in &gauss {
                        points.extend(gauss.iter().map(|&(x, wx)| ([x, y, z], wx * wy * wz)));
                    }
                }
                points
            }
            Family::Tet if self.order() == 1 => {
                let a = (5.0 - 5f64.sqrt()) / 20.0;
                vertices(a).map(|xi| (xi, 1.0 / 24.0)).to_vec()
            }
            Family::Tet => tetrahedron_of_degree_5(),
            Family::Wedge => {
                let triangle = DUNAVANT_4.iter().flat_map(|&(a, w)| orbit(a).map(|xi| (xi, w / 2.0)));
                let gauss = gauss_legendre(3);
                triangle
                    .flat_map(|([r, s], w)| gauss.iter().map(move |&(t, wt)| ([r, s, t], w * wt)))
                    .collect()
            }
        };
        Ok(points)
    }
}

impl FaceKind {
    /// Points and weights that integrate polynomials of degree 2n - 1 exactly. Quadrilaterals have n x n Gauss points,
    /// exact to that degree in each direction. Triangles have 1 point for n = 1, 6 for n = 2 (degree 4) and 7 for n = 3
    /// (degree 5, both Dunavant 1985). For larger n, triangles use the product rule of n x (n + 1) Gauss points on the
    /// collapsed square. All weights are positive and sum to the area of the natural domain.
    ///
    /// # Errors
    /// [`MeshError::GaussPoints`] unless 1 <= n <= 9 (10 on quadrilaterals).
    pub fn rule(self, n: usize) -> Result<Vec<([f64; 2], f64)>, MeshError> {
        if n == 0 {
            return Err(MeshError::GaussPoints { points: n });
        }
        if self.corners() == 4 {
            let gauss = gauss_legendre(n);
            return Ok(gauss
                .iter()
                .flat_map(|&(y, wy)| gauss.iter().map(move |&(x, wx)| ([x, y], wx * wy)))
                .collect());
        }
        let centre = ([1.0 / 3.0; 2], 0.5);
        let six = |orbits: &[(f64, f64)]| -> Vec<([f64; 2], f64)> {
            orbits
                .iter()
                .flat_map(|&(a, w)| orbit(a).map(|xi| (xi, w / 2.0)))
                .collect()
        };
        Ok(match n {
            1 => vec![centre],
            2 => six(&DUNAVANT_4),
            3 => {
                // Radon's rule in closed form; Dunavant's table has the same values.
                let s = 15f64.sqrt();
                let mut points = six(&[
                    ((6.0 - s) / 21.0, (155.0 - s) / 1200.0),
                    ((6.0 + s) / 21.0, (155.0 + s) / 1200.0),
                ]);
                points.push((centre.0, 9.0 / 80.0));
                points
            }
            n => {
                // r = u, s = (1 - u) v with the Jacobian 1 - u, which costs one degree along u.
                let (along, across) = (gauss_legendre(n + 1), gauss_legendre(n));
                along
                    .iter()
                    .flat_map(|&(u, wu)| {
                        let u = (1.0 + u) / 2.0;
                        across
                            .iter()
                            .map(move |&(v, wv)| ([u, (1.0 - u) * (1.0 + v) / 2.0], wu * wv * (1.0 - u) / 4.0))
                    })
                    .collect()
            }
        })
    }
}

/// For the two orbits of the 6-point rule of degree 4, the barycentric coordinate shared by two vertices, and the
/// weight on a triangle of unit area (Dunavant 1985, Int. J. Numer. Meth. Eng. 21, 1129-1148).
const DUNAVANT_4: [(f64, f64); 2] = [
    (0.445_948_490_915_965, 0.223_381_589_678_011),
    (0.091_576_213_509_771, 0.109_951_743_655_322),
];

/// The three points of a triangle with the barycentric coordinates a, a, 1 - 2a.
fn orbit(a: f64) -> [[f64; 2]; 3] {
    [[a, a], [1.0 - 2.0 * a, a], [a, 1.0 - 2.0 * a]]
}

/// The four points of a tetrahedron with the barycentric coordinates a, a, a, 1 - 3a.
fn vertices(a: f64) -> [[f64; 3]; 4] {
    let b = 1.0 - 3.0 * a;
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]]
}

/// The 14-point rule of degree 5 with positive weights (Walkington 2000, Quadrature on simplices of arbitrary
/// dimension): two orbits a, a, a, 1 - 3a and one b, b, 1/2 - b, 1/2 - b.
fn tetrahedron_of_degree_5() -> Vec<([f64; 3], f64)> {
    const ORBITS: [(f64, f64); 2] = [
        (0.310_885_919_263_300_6, 0.112_687_925_718_015_85),
        (0.092_735_250_310_891_23, 0.073_493_043_116_361_95),
    ];
    const EDGE: (f64, f64) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_466);
    let (b, w) = EDGE;
    let c = 0.5 - b;
    let edges = [[b, b, c], [b, c, b], [c, b, b], [c, c, b], [c, b, c], [b, c, c]];
    ORBITS
        .iter()
        .flat_map(|&(a, w)| vertices(a).map(|xi| (xi, w / 6.0)))
        .chain(edges.map(|xi| (xi, w / 6.0)))
        .collect()
}

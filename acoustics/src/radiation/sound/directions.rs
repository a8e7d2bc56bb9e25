use nailnoise_meshes::gauss_legendre;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Directions on rings of constant height, for plots and for integrals over a sphere or over its half above a floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Directions {
    /// Unit vectors, ring by ring from the lowest.
    pub vectors: Vec<Vector3<f64>>,
    /// Solid angle of each direction \[sr\].
    pub weights: Vec<f64>,
    /// Number of directions per ring.
    pub around: usize,
}

impl Directions {
    /// Gauss points in height on `rings` rings, with equally spaced angles on each. Spherical harmonics are integrated
    /// exactly up to order `around` - 1 and up to 2 `rings` - 1. The latter limit is twice as high on the half sphere
    /// for functions that are even in height.
    pub fn new(rings: usize, around: usize, half: bool) -> Self {
        let rule = gauss_legendre(if half { 2 * rings } else { rings });
        let mut all = Self {
            vectors: Vec::new(),
            weights: Vec::new(),
            around,
        };
        for (z, w) in rule.into_iter().filter(|(z, _)| !half || *z > 0.0) {
            let r = (1.0 - z * z).sqrt();
            for i in 0..around {
                let (sine, cosine) = (2.0 * PI * i as f64 / around as f64).sin_cos();
                all.vectors.push(Vector3::new(r * cosine, r * sine, z));
                all.weights.push(2.0 * PI * w / around as f64);
            }
        }
        all
    }
}

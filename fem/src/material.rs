//! Linear elastic materials: isotropic and orthotropic with oriented axes.

use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{any, group, modulus};
use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3};

use crate::FemError;

group! {
    /// An orthotropic solid: axis 1 along the grain, 2 and 3 across it.
    Orthotropic {
        /// Young's modulus along axis 1.
        e1: f64 = modulus(), "E_1";
        /// Young's modulus along axis 2.
        e2: f64 = modulus(), "E_2";
        /// Young's modulus along axis 3.
        e3: f64 = modulus(), "E_3";
        /// Shear modulus in the plane of axes 1 and 2.
        g12: f64 = modulus(), "G_12";
        /// Shear modulus in the plane of axes 1 and 3.
        g13: f64 = modulus(), "G_13";
        /// Shear modulus in the plane of axes 2 and 3.
        g23: f64 = modulus(), "G_23";
        /// Contraction along axis 2 for a pull along axis 1.
        nu12: f64 = any(NUMBER).within(-10.0, 10.0), "nu_12";
        /// Contraction along axis 3 for a pull along axis 1.
        nu13: f64 = any(NUMBER).within(-10.0, 10.0), "nu_13";
        /// Contraction along axis 3 for a pull along axis 2.
        nu23: f64 = any(NUMBER).within(-10.0, 10.0), "nu_23";
    }
}

/// A linear elastic material in global axes.
///
/// sigma = C epsilon with Voigt order xx, yy, zz, yz, xz, xy and engineering shear strains.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    density: f64,
    stiffness: Matrix6<f64>,
    slowest_shear: f64,
}

impl serde::Serialize for Material {
    /// Serialised as density, stiffness by columns and smallest shear modulus.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.density, self.stiffness.as_slice(), self.slowest_shear).serialize(serializer)
    }
}

/// Tensor indices of the Voigt components.
pub(crate) const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

impl Material {
    /// Creates an isotropic material from Young's modulus `e` \[Pa\], Poisson's ratio `nu` and `density` \[kg/m^3\].
    ///
    /// # Errors
    /// [`FemError::NotPositive`], or [`FemError::NotPositiveDefinite`] unless -1 < nu < 1/2.
    pub fn isotropic(e: f64, nu: f64, density: f64) -> Result<Self, FemError> {
        if !(nu.is_finite() && nu > -1.0) {
            return Err(FemError::NotPositiveDefinite { eigenvalue: 1.0 + nu });
        }
        let g = e / (2.0 * (1.0 + nu));
        let constants = Orthotropic {
            e1: e,
            e2: e,
            e3: e,
            g12: g,
            g13: g,
            g23: g,
            nu12: nu,
            nu13: nu,
            nu23: nu,
        };
        Self::orthotropic(&constants, &Matrix3::identity(), density)
    }

    /// Creates an orthotropic material; the columns of `axes` are its directions 1, 2 and 3 in global coordinates. The
    /// axes may be left-handed, because the material equals its mirror image.
    ///
    /// Poisson's ratio nu_ij is the contraction along j per extension along i under stress along i, so nu_ij / E_i =
    /// nu_ji / E_j. The compliance in material axes is that of Lekhnitskii (*Theory of Elasticity of an Anisotropic
    /// Body*, section 3). Its entries are S_ii = 1 / E_i, S_ij = -nu_ij / E_i, S_44 = 1 / G_23, S_55 = 1 / G_13 and
    /// S_66 = 1 / G_12. The stiffness in global axes is C_ijkl = Q_ip Q_jq Q_kr Q_ls C'_pqrs, where Q = `axes` and C' =
    /// S^-1.
    ///
    /// # Errors
    /// [`FemError::NotPositive`], [`FemError::NotPositiveDefinite`] or [`FemError::Axes`].
    pub fn orthotropic(constants: &Orthotropic, axes: &Matrix3<f64>, density: f64) -> Result<Self, FemError> {
        let c = constants;
        let positive = [
            ("Young's modulus E_1", c.e1),
            ("Young's modulus E_2", c.e2),
            ("Young's modulus E_3", c.e3),
            ("shear modulus G_12", c.g12),
            ("shear modulus G_13", c.g13),
            ("shear modulus G_23", c.g23),
            ("density", density),
        ];
        for (what, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(FemError::NotPositive { what, value });
            }
        }
        let deviation = (axes.transpose() * axes - Matrix3::identity()).amax();
        // NaN axes are rejected as well.
        if deviation.is_nan() || deviation > 1e-9 {
            return Err(FemError::Axes { deviation });
        }
        let normal = Matrix3::new(
            1.0 / c.e1,
            -c.nu12 / c.e1,
            -c.nu13 / c.e1,
            -c.nu12 / c.e1,
            1.0 / c.e2,
            -c.nu23 / c.e2,
            -c.nu13 / c.e1,
            -c.nu23 / c.e2,
            1.0 / c.e3,
        );
        let scale = Matrix3::from_diagonal(&normal.diagonal().map(|s| 1.0 / s.sqrt()));
        let eigenvalue = (scale * normal * scale).symmetric_eigenvalues().min();
        if eigenvalue.is_nan() || eigenvalue < 1e-9 {
            return Err(FemError::NotPositiveDefinite { eigenvalue });
        }
        let inverse = normal
            .try_inverse()
            .ok_or(FemError::NotPositiveDefinite { eigenvalue })?;
        let mut local = Matrix6::zeros();
        local
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&((inverse + inverse.transpose()) / 2.0));
        for (k, g) in [c.g23, c.g13, c.g12].into_iter().enumerate() {
            local[(3 + k, 3 + k)] = g;
        }
        let stiffness = if *axes == Matrix3::identity() {
            local
        } else {
            rotate(&local, axes)
        };
        Ok(Self {
            density,
            stiffness,
            slowest_shear: c.g12.min(c.g13).min(c.g23),
        })
    }

    /// Density \[kg/m^3\].
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Stiffness C in global axes \[Pa\].
    pub fn stiffness(&self) -> &Matrix6<f64> {
        &self.stiffness
    }

    /// Speed of the slowest shear wave along a material axis, sqrt(G_min / rho) \[m/s\], used to choose the element
    /// size.
    pub fn slowest_speed(&self) -> f64 {
        (self.slowest_shear / self.density).sqrt()
    }

    /// Speeds of the slowest and the fastest plane wave in the direction of the unit vector n \[m/s\]. The eigenvalues
    /// of the Christoffel matrix Gamma_ik = C_ijkl n_j n_l are rho c^2 (Auld, *Acoustic Fields and Waves in Solids*,
    /// section 7.C).
    pub(crate) fn wave_speeds(&self, n: &Vector3<f64>) -> [f64; 2] {
        // Strain of the displacement e_k e^(j n.x), in the order xx, yy, zz, yz, xz, xy.
        let strain = Matrix6x3::new(
            n.x, 0.0, 0.0, //
            0.0, n.y, 0.0, //
            0.0, 0.0, n.z, //
            0.0, n.z, n.y, //
            n.z, 0.0, n.x, //
            n.y, n.x, 0.0,
        );
        let christoffel = strain.transpose() * self.stiffness * strain / self.density;
        let squares = christoffel.symmetric_eigenvalues();
        [squares.min().sqrt(), squares.max().sqrt()]
    }

    /// The stiffness tensor C_ijkl, which is contracted with displacement gradients.
    pub(crate) fn tensor(&self) -> [[[[f64; 3]; 3]; 3]; 3] {
        tensor(&self.stiffness)
    }
}

/// Voigt index of a pair of tensor indices.
const fn voigt(i: usize, j: usize) -> usize {
    if i == j { i } else { 6 - i - j }
}

fn tensor(c: &Matrix6<f64>) -> [[[[f64; 3]; 3]; 3]; 3] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| std::array::from_fn(|k| std::array::from_fn(|l| c[(voigt(i, j), voigt(k, l))])))
    })
}

fn rotate(local: &Matrix6<f64>, q: &Matrix3<f64>) -> Matrix6<f64> {
    let c = tensor(local);
    let rotated = Matrix6::from_fn(|row, column| {
        let ((i, j), (k, l)) = (VOIGT[row], VOIGT[column]);
        let mut sum = 0.0;
        for p in 0..3 {
            for r in 0..3 {
                for s in 0..3 {
                    for t in 0..3 {
                        sum += q[(i, p)] * q[(j, r)] * q[(k, s)] * q[(l, t)] * c[p][r][s][t];
                    }
                }
            }
        }
        sum
    });
    (rotated + rotated.transpose()) / 2.0
}

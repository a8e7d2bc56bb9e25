//! Modes of a free rectangular plate of wood, whose grain runs along its length.
//!
//! Theory of Reissner and Mindlin with the deflection w and the rotations p = theta_x, q = theta_y (x along the grain):
//!
//! ```text
//! 2 U = int D11 p_x^2 + 2 D12 p_x q_y + D22 q_y^2 + D66 (p_y + q_x)^2 + A55 (w_x + p)^2 + A44 (w_y + q)^2
//! 2 T = omega^2 int rho h w^2 + rho h^3/12 (p^2 + q^2)
//! D11 = E_L h^3/(12 s),  D22 = E_R h^3/(12 s),  D12 = nu_LR D22,  D66 = G_LR h^3/12,  s = 1 - nu_LR^2 E_R/E_L
//! A55 = 5/6 G_LT h,  A44 = 5/6 G_RT h
//! ```
//!
//! w, p and q are sums of products of Legendre polynomials (Ritz; Liew, Xiang and Kitipornchai, "Transverse vibration
//! of thick rectangular plates", Computers and Structures 49, 1 (1993)). Normalised polynomials are orthonormal, and
//! the derivative of one is a sum of lower ones, so that all integrals are exact products of derivative matrices.
//! Symmetry about both centre lines separates four classes. The rotations are eliminated statically. This is exact for
//! the stiffness. Their inertia shifts a mode by about (k h)^2/24, here by at most 0.1 %.
//!
//! Air moves along with the plate. An infinite plate with bending waves of wavenumber k, slower than sound, carries the
//! mass 2 rho_0/k per area (Cremer, Heckl and Petersson, "Structure-borne sound", 2005, chapter 6). A free plate
//! carries less, because the pressure equalises around its edges; `air_share` is the fraction.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix};

/// Shear correction factor (Reissner).
const SHEAR: f64 = 5.0 / 6.0;

/// A free plate. R is the direction across the grain in its plane, T that of its thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plate {
    /// Length along the grain, width and thickness \[m\].
    pub(super) size: [f64; 3],
    /// \[kg\].
    pub(super) mass: f64,
    /// Young's modulus along the grain \[Pa\].
    pub(super) e_l: f64,
    /// Young's modulus across the grain \[Pa\].
    pub(super) e_r: f64,
    /// Shear modulus in the plane of the plate \[Pa\].
    pub(super) g_lr: f64,
    /// Shear modulus of bending along the grain \[Pa\].
    pub(super) g_lt: f64,
    /// Shear modulus of bending across the grain, the rolling shear modulus \[Pa\].
    pub(super) g_rt: f64,
    /// Contraction across the grain for a pull along it.
    pub(super) nu_lr: f64,
    /// Density of the air \[kg/m³\].
    pub(super) air_density: f64,
    /// Mass of air that moves along, as a share of that on an infinite plate.
    pub(super) air_share: f64,
}

/// A bending mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlateMode {
    /// Frequency in air \[Hz\].
    pub(super) hz: f64,
    /// Number of nodal lines across the grain, and along it.
    pub(super) nodal_lines: [usize; 2],
}

/// The polynomials of a plate, with their integrals.
pub(super) struct Ritz {
    classes: Vec<Class>,
}

/// Polynomials of one symmetry. Each matrix maps coefficients of a field to those of a derivative on a side of 2.
struct Class {
    /// Degrees of the polynomials of w.
    degrees: Vec<[usize; 2]>,
    /// w_x and w_y, in the polynomials of p and q.
    slopes: [DMatrix<f64>; 2],
    /// p_x and q_y, in the polynomials of w.
    curvatures: [DMatrix<f64>; 2],
    /// p_y and q_x, in polynomials of the opposite symmetry.
    twists: [DMatrix<f64>; 2],
}

impl Ritz {
    /// Polynomials up to a degree along each side; at least 4.
    pub(super) fn new([along, across]: [usize; 2]) -> Self {
        let symmetries = [[0, 0], [0, 1], [1, 0], [1, 1]];
        let class = |[x, y]: [usize; 2]| {
            let degrees = |most: usize, parity: usize| (parity..=most).step_by(2).collect::<Vec<_>>();
            let (x, x_p) = (degrees(along, x), degrees(along - 1, 1 - x));
            let (y, y_q) = (degrees(across, y), degrees(across - 1, 1 - y));
            let same = |of: &[usize]| DMatrix::<f64>::identity(of.len(), of.len());
            Class {
                degrees: x.iter().flat_map(|&m| y.iter().map(move |&n| [m, n])).collect(),
                slopes: [
                    derivative(&x_p, &x).kronecker(&same(&y)),
                    same(&x).kronecker(&derivative(&y_q, &y)),
                ],
                curvatures: [
                    derivative(&x, &x_p).kronecker(&same(&y)),
                    same(&x).kronecker(&derivative(&y, &y_q)),
                ],
                twists: [
                    same(&x_p).kronecker(&derivative(&y_q, &y)),
                    derivative(&x_p, &x).kronecker(&same(&y_q)),
                ],
            }
        };
        Self {
            classes: symmetries.map(class).into(),
        }
    }

    /// Bending modes in ascending order. `None` if the elastic constants are not positive definite.
    pub(super) fn modes(&self, plate: &Plate) -> Option<Vec<PlateMode>> {
        let mut modes = Vec::new();
        for class in &self.classes {
            modes.extend(class.modes(plate)?);
        }
        modes.sort_by(|a, b| a.hz.total_cmp(&b.hz));
        Some(modes)
    }
}

/// Derivatives of normalised Legendre polynomials of degrees `columns` as sums of those of degrees `rows`:
/// p_n' = sum over k = n-1, n-3, .. of ((2n+1)(2k+1))^(1/2) p_k.
fn derivative(rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |row, column| {
        let (k, n) = (rows[row], columns[column]);
        let is_term = k < n && (n - k) % 2 == 1;
        if is_term {
            ((2 * n + 1) as f64 * (2 * k + 1) as f64).sqrt()
        } else {
            0.0
        }
    })
}

impl Class {
    /// Bending modes of one symmetry.
    fn modes(&self, plate: &Plate) -> Option<Vec<PlateMode>> {
        let [a, b, h] = plate.size;
        let per_area = plate.mass / (a * b);
        let s = 1.0 - plate.nu_lr * plate.nu_lr * plate.e_r / plate.e_l;
        if s <= 0.0 {
            return None;
        }
        let cube = h.powi(3) / 12.0;
        let (d11, d22, d66) = (plate.e_l * cube / s, plate.e_r * cube / s, plate.g_lr * cube);
        let (d12, a55, a44) = (plate.nu_lr * d22, SHEAR * plate.g_lt * h, SHEAR * plate.g_rt * h);
        let (to_x, to_y) = (2.0 / a, 2.0 / b);
        let [w_x, w_y] = [&self.slopes[0] * to_x, &self.slopes[1] * to_y];
        let [p_x, q_y] = [&self.curvatures[0] * to_x, &self.curvatures[1] * to_y];
        let [p_y, q_x] = [&self.twists[0] * to_y, &self.twists[1] * to_x];

        let (of_p, of_q, of_w) = (w_x.nrows(), w_y.nrows(), self.degrees.len());
        let mut rotations = DMatrix::zeros(of_p + of_q, of_p + of_q);
        let own = |shear: f64, bending: f64, curvature: &DMatrix<f64>, twist: &DMatrix<f64>| {
            DMatrix::identity(curvature.ncols(), curvature.ncols()) * shear
                + curvature.tr_mul(curvature) * bending
                + twist.tr_mul(twist) * d66
        };
        let both = p_x.tr_mul(&q_y) * d12 + p_y.tr_mul(&q_x) * d66;
        rotations
            .view_mut((0, 0), (of_p, of_p))
            .copy_from(&own(a55, d11, &p_x, &p_y));
        rotations
            .view_mut((of_p, of_p), (of_q, of_q))
            .copy_from(&own(a44, d22, &q_y, &q_x));
        rotations.view_mut((0, of_p), (of_p, of_q)).copy_from(&both);
        rotations.view_mut((of_p, 0), (of_q, of_p)).copy_from(&both.transpose());
        let mut coupling = DMatrix::zeros(of_p + of_q, of_w);
        coupling.view_mut((0, 0), (of_p, of_w)).copy_from(&(&w_x * a55));
        coupling.view_mut((of_p, 0), (of_q, of_w)).copy_from(&(&w_y * a44));

        let follow = -Cholesky::new(rotations)?.solve(&coupling);
        let gradient = [w_x.tr_mul(&w_x), w_y.tr_mul(&w_y)];
        let stiffness = &gradient[0] * a55 + &gradient[1] * a44 + coupling.tr_mul(&follow);
        let inertia = DMatrix::identity(of_w, of_w) * per_area + follow.tr_mul(&follow) * (per_area * h * h / 12.0);
        let [gradient_x, gradient_y] = gradient;
        let gradient = gradient_x + gradient_y;
        let inverse = Cholesky::new(inertia)?.l().try_inverse()?;
        let eigen = (&inverse * stiffness * inverse.transpose()).symmetric_eigen();
        let shapes = inverse.tr_mul(&eigen.eigenvectors);

        let mut order: Vec<usize> = (0..of_w).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let mut free: Vec<usize> = (0..of_w)
            .filter(|&k| self.degrees[k][0] + self.degrees[k][1] > 1)
            .collect();
        // The rest are motions of the rigid plate.
        let rigid = of_w - free.len();
        let modes = order.into_iter().skip(rigid).map(|own| {
            let shape = shapes.column(own);
            let squares = shape.norm_squared();
            let wavenumber = ((&gradient * shape).dot(&shape) / squares).sqrt();
            let with_air = 1.0 + 2.0 * plate.air_share * plate.air_density / (wavenumber * per_area);
            let largest = (0..free.len()).max_by(|&i, &j| shape[free[i]].abs().total_cmp(&shape[free[j]].abs()));
            let term = largest.map_or(0, |place| free.swap_remove(place));
            PlateMode {
                hz: (eigen.eigenvalues[own].max(0.0) / with_air).sqrt() / TAU,
                nodal_lines: self.degrees[term],
            }
        });
        Some(modes.collect())
    }
}

#[cfg(test)]
mod tests {
    use nailnoise_fem::{Constraints, Material, ModalSettings, Orthotropic, assemble, modes};
    use nailnoise_meshes::{Block, block};
    use nalgebra::Matrix3;

    use super::*;

    const SPRUCE: Plate = Plate {
        size: [0.58, 0.214, 4.8e-3],
        mass: 0.236,
        e_l: 10.9e9,
        e_r: 0.64e9,
        g_lr: 0.58e9,
        g_lt: 0.59e9,
        g_rt: 0.04e9,
        nu_lr: 0.39,
        air_density: 0.0,
        air_share: 0.7,
    };

    fn hz(plate: &Plate, degrees: [usize; 2]) -> Vec<f64> {
        Ritz::new(degrees)
            .modes(plate)
            .unwrap()
            .iter()
            .map(|own| own.hz)
            .collect()
    }

    #[test]
    fn modes_are_those_of_the_solid_elements() {
        let [length, width, thickness] = SPRUCE.size;
        let mesh = block(&Block {
            size: SPRUCE.size,
            divisions: [24, 12, 1],
            origin: [0.0; 3],
        })
        .unwrap();
        // Moduli through the thickness have hardly any effect.
        let constants = Orthotropic {
            e1: SPRUCE.e_l,
            e2: SPRUCE.e_r,
            e3: 0.42e9,
            g12: SPRUCE.g_lr,
            g13: SPRUCE.g_lt,
            g23: SPRUCE.g_rt,
            nu12: SPRUCE.nu_lr,
            nu13: 0.49,
            nu23: 0.64,
        };
        let density = SPRUCE.mass / (length * width * thickness);
        let wood = Material::orthotropic(&constants, &Matrix3::identity(), density).unwrap();
        let system = assemble(&mesh, &[wood], &Constraints::free()).unwrap();
        let solid = modes(&system, &ModalSettings::below(620.0), &|_, _| ()).unwrap();
        let solid: Vec<f64> = solid.hz.iter().copied().filter(|hz| *hz > 1.0).collect();
        assert!(solid.len() > 12, "{solid:?}");
        let plate = hz(&SPRUCE, [12, 8]);
        for (plate, solid) in plate.iter().zip(&solid) {
            assert!((plate / solid - 1.0).abs() < 0.01, "{plate} Hz, solid {solid} Hz");
        }
    }

    /// Without contraction the plate is a free beam along each side: f = (4.730041/a)^2 h/(4 pi) (E/(3 rho))^(1/2).
    #[test]
    fn a_thin_plate_without_contraction_bends_as_a_beam() {
        let stiff = 1e13;
        let thin = 1e-3;
        let [length, width, _] = SPRUCE.size;
        let plate = Plate {
            size: [length, width, thin],
            nu_lr: 0.0,
            g_lt: stiff,
            g_rt: stiff,
            ..SPRUCE
        };
        let [a, b, h] = plate.size;
        let density = plate.mass / (a * b * h);
        let beam = |side: f64, e: f64| (4.730041 / side).powi(2) * h * (e / (3.0 * density)).sqrt() / (2.0 * TAU);
        let found = Ritz::new([10, 8]).modes(&plate).unwrap();
        for (lines, expected) in [([2, 0], beam(a, plate.e_l)), ([0, 2], beam(b, plate.e_r))] {
            let own = found.iter().find(|own| own.nodal_lines == lines).unwrap();
            assert!((own.hz / expected - 1.0).abs() < 1e-3, "{own:?}, beam {expected} Hz");
        }
    }

    /// Ritz' frequencies fall with further polynomials, and those of the first modes have converged.
    #[test]
    fn frequencies_converge_from_above() {
        let [few, more, many] = [[8, 6], [12, 8], [16, 12]].map(|degrees| hz(&SPRUCE, degrees));
        for k in 0..16 {
            assert!(few[k] > more[k] * (1.0 - 1e-9) && more[k] > many[k] * (1.0 - 1e-9));
            assert!(more[k] / many[k] < 1.004, "mode {k}: {} and {} Hz", more[k], many[k]);
        }
    }

    #[test]
    fn frequencies_rise_with_half_of_the_moduli() {
        let harder = Plate {
            e_l: 1.02 * SPRUCE.e_l,
            e_r: 1.02 * SPRUCE.e_r,
            g_lr: 1.02 * SPRUCE.g_lr,
            g_lt: 1.02 * SPRUCE.g_lt,
            g_rt: 1.02 * SPRUCE.g_rt,
            ..SPRUCE
        };
        for (soft, hard) in hz(&SPRUCE, [8, 6]).iter().zip(hz(&harder, [8, 6])) {
            assert!((hard / soft - 1.02_f64.sqrt()).abs() < 1e-6);
        }
    }

    #[test]
    fn air_lowers_low_modes_most() {
        let in_air = Plate {
            air_density: 1.2,
            ..SPRUCE
        };
        let ratios: Vec<f64> = hz(&in_air, [8, 6])
            .iter()
            .zip(hz(&SPRUCE, [8, 6]))
            .map(|(air, vacuum)| air / vacuum)
            .collect();
        assert!(
            ratios.iter().take(6).all(|own| (0.95..0.995).contains(own)),
            "{ratios:?}"
        );
        assert!(ratios[1] < ratios[8], "{ratios:?}");
    }
}

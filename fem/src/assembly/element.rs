//! Element stiffness and mass matrices.

use nailnoise_meshes::{ElementKind, ElementRef, Mesh};
use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use crate::{FemError, Material};

/// Shape functions and gradients at the quadrature points of an element kind.
///
/// The same rule serves both matrices, see [`ElementKind::rule`]. It is exact on affine elements, so the mass is
/// consistent and the stiffness has exactly six zero-energy modes; reduced rules would add spurious ones.
pub(crate) struct Rule {
    points: Vec<RulePoint>,
    nodes: usize,
}

struct RulePoint {
    weight: f64,
    n: Vec<f64>,
    dn: Vec<[f64; 3]>,
}

impl Rule {
    pub(crate) fn new(kind: ElementKind) -> Result<Self, FemError> {
        let point = |(xi, weight)| {
            let (mut n, mut dn) = (vec![0.0; kind.nodes()], vec![[0.0; 3]; kind.nodes()]);
            kind.shape(xi, &mut n, &mut dn);
            RulePoint { weight, n, dn }
        };
        Ok(Self {
            points: kind.rule()?.into_iter().map(point).collect(),
            nodes: kind.nodes(),
        })
    }
}

/// Material data used by the elements: the stiffness tensor and the density.
pub(crate) struct ElementMaterial {
    c: [[[[f64; 3]; 3]; 3]; 3],
    density: f64,
}

impl From<&Material> for ElementMaterial {
    fn from(material: &Material) -> Self {
        Self {
            c: material.tensor(),
            density: material.density(),
        }
    }
}

/// Stiffness and mass of one element by node pairs with b <= a; pair (a, b) is stored at a (a + 1) / 2 + b.
#[derive(Default)]
pub(crate) struct ElementMatrices {
    /// K_ab, the 3 x 3 block of nodes a and b.
    pub(crate) stiffness: Vec<[[f64; 3]; 3]>,
    /// m_ab, equal for all directions.
    pub(crate) mass: Vec<f64>,
}

/// Integrates one element.
///
/// K_ab,ij = C_ikjl integral of dN_a/dx_k dN_b/dx_l dV,  m_ab = rho integral of N_a N_b dV.
///
/// The integrals of gradient products are computed first and contracted with C once. This is possible because C is
/// constant within the element, and costs a fraction of B^T C B at every point.
pub(crate) fn integrate(
    mesh: &Mesh,
    index: usize,
    element: ElementRef<'_>,
    rule: &Rule,
    material: &ElementMaterial,
) -> Result<ElementMatrices, FemError> {
    let n = rule.nodes;
    let pairs = n * (n + 1) / 2;
    let mut products = vec![[0.0; 9]; pairs];
    let mut mass = vec![0.0; pairs];
    let mut gradients = vec![[0.0; 3]; n];
    for point in &rule.points {
        let mut j = Matrix3::zeros();
        for (a, &node) in element.nodes.iter().enumerate() {
            j += mesh.nodes[node].coords * Vector3::from(point.dn[a]).transpose();
        }
        let determinant = j.determinant();
        let inverse = match j.try_inverse() {
            Some(inverse) if determinant > 0.0 => inverse,
            _ => {
                return Err(FemError::Inverted {
                    element: index,
                    determinant,
                });
            }
        };
        for (gradient, dn) in gradients.iter_mut().zip(&point.dn) {
            *gradient = (inverse.transpose() * Vector3::from(*dn)).into();
        }
        Arch::new().dispatch(Products {
            dv: point.weight * determinant,
            density: material.density,
            n: &point.n,
            gradients: &gradients,
            products: &mut products,
            mass: &mut mass,
        });
    }
    let stiffness = products.iter().map(|g| contract(&material.c, g)).collect();
    Ok(ElementMatrices { stiffness, mass })
}

/// Adds the products of gradients and of shape functions at one quadrature point, compiled for the vector instructions
/// detected at run time.
struct Products<'a> {
    dv: f64,
    density: f64,
    n: &'a [f64],
    gradients: &'a [[f64; 3]],
    products: &'a mut [[f64; 9]],
    mass: &'a mut [f64],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut pairs = self.products.iter_mut().zip(self.mass);
        for (a, gradient) in self.gradients.iter().enumerate() {
            let scaled = gradient.map(|g| g * self.dv);
            let m = self.density * self.dv * self.n[a];
            let up_to_a = self.gradients[..=a].iter().zip(self.n);
            for ((g, n_b), (product, mass)) in up_to_a.zip(&mut pairs) {
                for k in 0..3 {
                    for l in 0..3 {
                        product[3 * k + l] += scaled[k] * g[l];
                    }
                }
                *mass += m * n_b;
            }
        }
    }
}

fn contract(c: &[[[[f64; 3]; 3]; 3]; 3], g: &[f64; 9]) -> [[f64; 3]; 3] {
    let mut block = [[0.0; 3]; 3];
    for (i, row) in block.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let mut sum = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    sum += c[i][k][j][l] * g[3 * k + l];
                }
            }
            *entry = sum;
        }
    }
    block
}

//! Stress of displacement fields at a point.

use nailnoise_meshes::Mesh;
use nalgebra::{DMatrix, Matrix3, Matrix6xX, Point3, Vector3, Vector6};

use crate::{FemError, Material};

/// Stress at a point for each displacement field \[Pa\], 6 x fields, in the order xx, yy, zz, yz, xz, xy.
///
/// sigma = C epsilon, with the strain of the element that contains the point. Strains are discontinuous between
/// elements; on a common face the result is from one of them. `shapes` are displacements \[m\], 3 nodes x fields;
/// `materials` are those of the parts.
///
/// # Errors
/// If the point is outside the mesh or the element is inverted.
pub fn stress_at(
    mesh: &Mesh,
    materials: &[Material],
    shapes: &DMatrix<f64>,
    point: Point3<f64>,
) -> Result<Matrix6xX<f64>, FemError> {
    let place = mesh.locate(point)?;
    let element = mesh.element(place.element);
    let kind = element.kind;
    // Shape functions reproduce the natural coordinates, like any linear field of them.
    let corners = kind.natural_nodes().iter().zip(&place.weights);
    let xi: Vector3<f64> = corners.map(|(node, weight)| Vector3::from(*node) * *weight).sum();
    let (mut n, mut slopes) = (vec![0.0; kind.nodes()], vec![[0.0; 3]; kind.nodes()]);
    kind.shape(xi.into(), &mut n, &mut slopes);
    let mut jacobian = Matrix3::zeros();
    for (&node, slope) in element.nodes.iter().zip(&slopes) {
        jacobian += mesh.nodes[node].coords * Vector3::from(*slope).transpose();
    }
    let inverse = jacobian.try_inverse().ok_or(FemError::Inverted {
        element: place.element,
        determinant: 0.0,
    })?;
    let gradients: Vec<Vector3<f64>> = slopes
        .iter()
        .map(|slope| inverse.transpose() * Vector3::from(*slope))
        .collect();
    let stiffness = materials[mesh.parts[place.element]].stiffness();
    let mut stress = Matrix6xX::zeros(shapes.ncols());
    for (field, mut own) in shapes.column_iter().zip(stress.column_iter_mut()) {
        let mut strain = Vector6::zeros();
        for (&node, g) in element.nodes.iter().zip(&gradients) {
            let [u, v, w] = [0, 1, 2].map(|axis| field[3 * node + axis]);
            strain += Vector6::new(
                u * g.x,
                v * g.y,
                w * g.z,
                v * g.z + w * g.y,
                u * g.z + w * g.x,
                u * g.y + v * g.x,
            );
        }
        own.copy_from(&(stiffness * strain));
    }
    Ok(stress)
}

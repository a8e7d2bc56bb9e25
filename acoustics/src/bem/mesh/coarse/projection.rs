//! Projects the normal velocities of a surface onto a coarser one.

use super::curved::{Curved, Found, Nearest};
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::checks::same_length;
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;

/// Cosine of the largest angle between the normal at a point and that of the panel that receives the point's volume
/// flow; it applies only if such a panel exists.
pub(super) const ALIKE: f64 = 0.5;

/// Contribution of a panel of the finer surface to a panel of the coarser one: moments of the corner functions of the
/// former with those of the latter.
type Given = (usize, [[f64; 4]; 3]);

impl Boundary {
    /// Projects normal velocities of the surface `finer` (corner values of its panels x patterns, see
    /// [`Boundary::project`]) onto this triangle mesh, see [`Boundary::coarsened`].
    ///
    /// Each point x of the finer surface contributes its volume flow v dS at the point xi of the nearest panel with a
    /// similar normal. On every panel the velocity is linear and has the moments of these contributions,
    ///
    /// ```text
    /// int N_i v dS = sum_x N_i(xi(x)) v(x) dS(x)
    /// ```
    ///
    /// so that the total volume flow equals that of the finer surface. Its first moments agree to within the size of a
    /// panel.
    ///
    /// # Errors
    /// If the velocities have the wrong length; [`InputError::Length`](crate::InputError) if any panel is not a
    /// triangle.
    pub fn project_from(&self, finer: &Self, velocities: &DMatrix<f64>) -> Result<DMatrix<f64>, BemError> {
        same_length(
            "rows of the normal velocities",
            velocities.nrows(),
            finer.velocity_values(),
        )?;
        let panels = self.mesh().panels.len();
        same_length("corners of triangles", self.velocity_values(), 3 * panels)?;
        if velocities.is_empty() {
            return Ok(DMatrix::zeros(3 * panels, velocities.ncols()));
        }
        let surface = Nearest::new(
            (0..panels)
                .flat_map(|p| Curved::of(self.mesh(), p))
                .map(|(_, curved)| curved)
                .collect(),
        );
        let given: Vec<Vec<Given>> = (0..finer.mesh().panels.len())
            .into_par_iter()
            .map(|p| finer.given(p, &surface))
            .collect();
        let mut moments = DMatrix::<f64>::zeros(3 * panels, velocities.ncols());
        let mut first = 0;
        for (panel, given) in finer.mesh().panels.iter().zip(&given) {
            let corners = panel.corners().len();
            for (to, block) in given {
                for mode in 0..velocities.ncols() {
                    for (i, row) in block.iter().enumerate() {
                        let own = (0..corners).map(|j| row[j] * velocities[(first + j, mode)]);
                        moments[(3 * to + i, mode)] += own.sum::<f64>();
                    }
                }
            }
            first += corners;
        }
        for p in 0..panels {
            let mut mass = Matrix3::<f64>::zeros();
            for (xi, w) in rules::fine(self.mesh().panels[p].kind()) {
                let dw = w * self.mesh().point_at(p, xi).area_vector().norm();
                let n = FaceKind::Tri3.at(xi).n;
                mass += Matrix3::from_fn(|i, j| dw * n[i] * n[j]);
            }
            let inverse = mass.try_inverse().unwrap_or_else(Matrix3::zeros);
            for mode in 0..velocities.ncols() {
                let b = Vector3::from_fn(|i, _| moments[(3 * p + i, mode)]);
                moments.fixed_view_mut::<3, 1>(3 * p, mode).copy_from(&(inverse * b));
            }
        }
        Ok(moments)
    }

    /// Contributions of a panel to those of a coarser surface.
    fn given(&self, panel: usize, surface: &Nearest) -> Vec<Given> {
        let kind = self.mesh().panels[panel].kind();
        let mut given: Vec<Given> = Vec::new();
        for (xi, w) in quarters(kind) {
            let point = self.mesh().point_at(panel, xi);
            let area = point.area_vector();
            let (dw, normal, place) = (w * area.norm(), area.normalize(), point.position.coords);
            let alike = surface.find(&place, |n| n.dot(&normal) > ALIKE);
            let Some(Found {
                triangle, xi: there, ..
            }) = alike.or_else(|| surface.find(&place, |_| true))
            else {
                continue;
            };
            let (own, theirs) = (kind.linear().at(xi).n, FaceKind::Tri3.at(there).n);
            let slot = given
                .iter()
                .position(|(known, _)| *known == triangle)
                .unwrap_or_else(|| {
                    given.push((triangle, [[0.0; 4]; 3]));
                    given.len() - 1
                });
            for (row, theirs) in given[slot].1.iter_mut().zip(theirs) {
                row.iter_mut()
                    .zip(own)
                    .for_each(|(value, own)| *value += dw * theirs * own);
            }
        }
        given
    }
}

/// The quadrature rule of a panel applied to its quarters, because borders of larger panels may run through it.
fn quarters(kind: FaceKind) -> Vec<([f64; 2], f64)> {
    let of_all = rules::fine(kind);
    let quarter = |[[x, y], [a, b], [c, d]]: [[f64; 2]; 3]| {
        let part = move |&([r, s], w): &([f64; 2], f64)| ([x + a * r + c * s, y + b * r + d * s], 0.25 * w);
        of_all.iter().map(part).collect::<Vec<_>>()
    };
    let all: [[[f64; 2]; 3]; 4] = if kind.corners() == 3 {
        let (across, up) = ([0.5, 0.0], [0.0, 0.5]);
        [
            [[0.0, 0.0], across, up],
            [[0.5, 0.0], across, up],
            [[0.0, 0.5], across, up],
            [[0.5, 0.5], [-0.5, 0.0], [0.0, -0.5]],
        ]
    } else {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|middle| [middle, [0.5, 0.0], [0.0, 0.5]])
    };
    all.into_iter().flat_map(quarter).collect()
}

use crate::error::{AcousticsError, finite, same_length};
use nailnoise_meshes::{QuadraturePoint, Surface};
use nalgebra::{DMatrix, Point3, Vector3};

/// A surface as the radiation operators see it: quadrature points and the modes' normal displacements there.
#[derive(Debug, Clone)]
pub struct RadiatingSurface {
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    weights: Vec<f64>,
    patch: Vec<usize>,
    patch_names: Vec<String>,
    normal_modes: DMatrix<f64>,
}

impl RadiatingSurface {
    /// A surface from its quadrature.
    ///
    /// * `points` \[m\], `normals` (outward, unit), `weights` \[m²\]: one each per quadrature point
    /// * `patch`: index into `patch_names` per point
    /// * `normal_modes`: points x modes, normal component of the modal displacement; per unit of modal coordinate
    ///
    /// # Errors
    /// Lengths that differ, a patch without a name, values that are not finite.
    pub fn new(
        points: Vec<Point3<f64>>,
        normals: Vec<Vector3<f64>>,
        weights: Vec<f64>,
        patch: Vec<usize>,
        patch_names: Vec<String>,
        normal_modes: DMatrix<f64>,
    ) -> Result<Self, AcousticsError> {
        let n = points.len();
        same_length("surface normals", normals.len(), n)?;
        same_length("surface weights", weights.len(), n)?;
        same_length("patch indices", patch.len(), n)?;
        same_length("rows of the normal modes", normal_modes.nrows(), n)?;
        finite("surface weights", &weights)?;
        finite("normal modes", normal_modes.as_slice())?;
        for (point, &p) in patch.iter().enumerate() {
            if p >= patch_names.len() {
                return Err(AcousticsError::Patch {
                    point,
                    patch: p,
                    patches: patch_names.len(),
                });
            }
        }
        for (p, v) in points.iter().zip(&normals) {
            finite("surface points", p.coords.as_slice())?;
            finite("surface normals", v.as_slice())?;
        }
        Ok(Self {
            points,
            normals,
            weights,
            patch,
            patch_names,
            normal_modes,
        })
    }

    /// Patches of a mesh's skin with `order` x `order` Gauss points on every face; no names mean all patches.
    ///
    /// `nodal_modes`: modal displacements of the volume's nodes, (3 x nodes) x modes. The normal component is formed
    /// per face, because a node on an edge has no single normal.
    ///
    /// # Errors
    /// An unknown patch, an order the mesh has no rule for, a number of rows that does not fit the mesh's nodes.
    pub fn of_skin(
        skin: &Surface,
        patches: &[&str],
        order: usize,
        nodal_modes: &DMatrix<f64>,
    ) -> Result<Self, AcousticsError> {
        let nodes = skin.volume_nodes.iter().max().map_or(0, |&n| n + 1);
        if nodal_modes.nrows() < 3 * nodes || !nodal_modes.nrows().is_multiple_of(3) {
            let found = nodal_modes.nrows();
            return Err(AcousticsError::Length {
                what: "rows of the nodal modes",
                found,
                expected: 3 * nodes,
            });
        }
        let wanted: Vec<usize> = match patches {
            [] => (0..skin.patches.len()).collect(),
            names => names.iter().map(|name| skin.patch(name)).collect::<Result<_, _>>()?,
        };
        let patch_of = |face: usize| wanted.iter().position(|&p| p == skin.faces[face].patch);
        let quadrature = skin.quadrature(order)?;
        let (points, patch): (Vec<&QuadraturePoint>, Vec<usize>) = quadrature
            .iter()
            .filter_map(|q| patch_of(q.face).map(|p| (q, p)))
            .unzip();
        let mut normal_modes = DMatrix::zeros(points.len(), nodal_modes.ncols());
        for (mode, mut column) in normal_modes.column_iter_mut().enumerate() {
            let phi = nodal_modes.column(mode);
            for (value, q) in column.iter_mut().zip(&points) {
                let corners = skin.faces[q.face].nodes.iter().zip(&q.shape);
                *value = corners
                    .map(|(&corner, shape)| {
                        let row = 3 * skin.volume_nodes[corner];
                        shape * (q.normal.x * phi[row] + q.normal.y * phi[row + 1] + q.normal.z * phi[row + 2])
                    })
                    .sum();
            }
        }
        Self::new(
            points.iter().map(|q| q.position).collect(),
            points.iter().map(|q| q.normal).collect(),
            points.iter().map(|q| q.weight).collect(),
            patch,
            wanted.iter().map(|&p| skin.patches[p].clone()).collect(),
            normal_modes,
        )
    }

    /// Quadrature points \[m\].
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// Outward unit normals.
    pub fn normals(&self) -> &[Vector3<f64>] {
        &self.normals
    }

    /// Quadrature weights \[m²\].
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Patch index of every point.
    pub fn patch(&self) -> &[usize] {
        &self.patch
    }

    /// Names of the patches.
    pub fn patch_names(&self) -> &[String] {
        &self.patch_names
    }

    /// Normal modal displacements, points x modes.
    pub fn normal_modes(&self) -> &DMatrix<f64> {
        &self.normal_modes
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.normal_modes.ncols()
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// The part of the surface whose points pass the test, with all patch names kept.
    pub fn filtered(&self, keep: impl Fn(usize) -> bool) -> Self {
        let rows: Vec<usize> = (0..self.points.len()).filter(|&i| keep(i)).collect();
        Self {
            points: rows.iter().map(|&i| self.points[i]).collect(),
            normals: rows.iter().map(|&i| self.normals[i]).collect(),
            weights: rows.iter().map(|&i| self.weights[i]).collect(),
            patch: rows.iter().map(|&i| self.patch[i]).collect(),
            patch_names: self.patch_names.clone(),
            normal_modes: self.normal_modes.select_rows(&rows),
        }
    }
}

use super::error::RadiationError;
use crate::checks::{finite, same_length};
use crate::error::AcousticsError;
use nailnoise_meshes::{QuadraturePoint, Surface};
use nalgebra::{DMatrix, DMatrixView, Point3, Vector3};

/// Number of Gauss points along each side of a face; modes are quadratic there, so their squares are integrated exactly
/// on rectangular faces.
pub(crate) const FACE_POINTS: usize = 3;

/// A surface as input to the radiation operators: quadrature points and normal modal displacements there.
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
    /// Creates a surface from its quadrature.
    ///
    /// * `points` \[m\], `normals` (outward, unit), `weights` \[m²\]: one each per quadrature point.
    /// * `patch`: index into `patch_names` per point.
    /// * `normal_modes`: points x modes, normal component of the modal displacement; per unit of modal coordinate.
    ///
    /// # Errors
    /// If lengths differ, a patch has no name, or values are not finite.
    pub fn new(
        points: Vec<Point3<f64>>,
        normals: Vec<Vector3<f64>>,
        weights: Vec<f64>,
        patch: Vec<usize>,
        patch_names: Vec<String>,
        normal_modes: DMatrix<f64>,
    ) -> Result<Self, RadiationError> {
        let n = points.len();
        same_length("surface normals", normals.len(), n)?;
        same_length("surface weights", weights.len(), n)?;
        same_length("patch indices", patch.len(), n)?;
        same_length("rows of the normal modes", normal_modes.nrows(), n)?;
        finite("surface weights", &weights)?;
        finite("normal modes", normal_modes.as_slice())?;
        for (point, &p) in patch.iter().enumerate() {
            if p >= patch_names.len() {
                return Err(RadiationError::Patch {
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

    /// The quadrature points of those faces of a surface that are `shown`, with normal modal displacements from
    /// `shapes`, the displacements of the surface's points in each mode, (3 x points) x modes. The normal component is
    /// computed per face, because the normal at a node on an edge is not unique.
    ///
    /// # Errors
    /// If the number of rows does not match the surface's points; errors of the surface.
    pub fn of_faces(
        surface: &Surface,
        shapes: DMatrixView<'_, f32>,
        shown: impl Fn(&QuadraturePoint) -> bool,
    ) -> Result<Self, AcousticsError> {
        same_length("rows of the modes", shapes.nrows(), 3 * surface.points.len())?;
        let points: Vec<QuadraturePoint> = surface.quadrature(FACE_POINTS)?.into_iter().filter(shown).collect();
        let mut modes = DMatrix::zeros(points.len(), shapes.ncols());
        for (shape, mut column) in shapes.column_iter().zip(modes.column_iter_mut()) {
            for (point, value) in points.iter().zip(column.iter_mut()) {
                let nodes = &surface.faces[point.face].nodes;
                *value = nodes
                    .iter()
                    .zip(&point.shape)
                    .map(|(&node, weight)| {
                        let moved = shape.fixed_rows::<3>(3 * node).map(f64::from);
                        weight * moved.dot(&point.normal)
                    })
                    .sum();
            }
        }
        let mut patches: Vec<usize> = points.iter().map(|p| surface.faces[p.face].patch).collect();
        let mut shown = patches.clone();
        shown.sort_unstable();
        shown.dedup(); // a completely hidden patch has no level to show
        for patch in &mut patches {
            *patch = shown.partition_point(|p| p < patch);
        }
        Ok(Self::new(
            points.iter().map(|p| p.position).collect(),
            points.iter().map(|p| p.normal).collect(),
            points.iter().map(|p| p.weight).collect(),
            patches,
            shown.iter().map(|&patch| surface.patches[patch].clone()).collect(),
            modes,
        )?)
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

    /// The part of the surface whose points pass the test, with all patch names retained.
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

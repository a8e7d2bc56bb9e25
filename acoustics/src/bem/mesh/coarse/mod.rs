//! Coarser surfaces for lower frequencies: larger curved triangles on the same surface, and the projection of
//! velocities on them.
//!
//! ```text
//! lines       sharp edges, borders of patches, boundaries in planes: their vertices stay on them
//! collapse    short edges are collapsed, edges between neighbours flipped
//! curved      nearest point of a surface
//! sides       midpoints of sides are moved onto the finer surface
//! projection  each point of the finer surface contributes its volume flow to one panel of the coarser one
//! interpolation  transfer of velocities to another mesh of the same surface with similar fineness
//! ```

mod collapse;
mod curved;
mod interpolation;
mod lines;
mod projection;
mod sides;

use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::checks::positive;
use collapse::Collapse;
use curved::{Curved, Nearest};
use nalgebra::{Point3, Vector3};

impl Boundary {
    /// The same surface with fewer triangles, with edges of at most `edge` \[m\] (or the longest edge of this surface,
    /// if longer).
    ///
    /// Edges are collapsed to one of their ends, the shortest first, as long as triangles remain well shaped and within
    /// 40 degrees of the surface's normals (after Botsch & Kobbelt, *Proc. Eurographics SGP*, 2004, with half-edges);
    /// vertices are thus a subset of this surface's. Sharp edges, borders of patches and the boundaries of the surface
    /// in floor and mirror planes are preserved. Midpoints of sides are moved onto this surface. The triangles are then
    /// as curved as the surface, and the enclosed volume, hence the mass of displaced air, is preserved.
    ///
    /// # Errors
    /// If `edge` is not positive; those of [`Boundary::symmetric`].
    pub fn coarsened(&self, edge: f64) -> Result<Self, BemError> {
        let edge = positive("length of edges [m]", edge)?.max(self.mesh().longest_edge());
        let mesh = self.mesh();
        let points: Vec<Vector3<f64>> = mesh.points.iter().map(|p: &Point3<f64>| p.coords).collect();
        let (mut triangles, mut patch) = (Vec::new(), Vec::new());
        for (p, panel) in mesh.panels.iter().enumerate() {
            let halves = Curved::of(mesh, p);
            patch.extend(halves.iter().map(|_| panel.patch));
            triangles.extend(halves);
        }
        let mut fewer = Collapse::new(&points, lines::lines(&points, &triangles, &patch), edge);
        fewer.run();
        let surface = Nearest::new(triangles.into_iter().map(|(_, curved)| curved).collect());
        let coarse = sides::curved_panels(&fewer, &surface, &mesh.patches);
        Self::symmetric(coarse, self.mirrors(), self.floor())
    }
}

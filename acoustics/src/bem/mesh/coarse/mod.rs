//! Coarser surfaces for lower frequencies: larger curved triangles on the same surface, and the projection of
//! velocities on them.
//!
//! ```text
//! lines       sharp edges, borders of patches, ends in planes: their vertices stay on them
//! collapse    short edges are collapsed, sides of neighbours flipped
//! curved      nearest point of a surface
//! sides       midpoints of sides are moved to the finer surface
//! projection  each point of the finer surface contributes its volume flow to one panel of the coarser
//! interpolation  velocities on another mesh of the same surface, as fine
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
    /// The same surface with fewer triangles, whose edges measure at most `edge` \[m\] (or as much as the longest edge
    /// of this surface).
    ///
    /// Vertices are some of this surface's: its edges are collapsed to one of their ends, the shortest first, while
    /// triangles stay well shaped and within 40 degrees of the surface's own normals (after Botsch & Kobbelt, *Proc.
    /// Eurographics SGP*, 2004, with half-edges). Sharp edges, borders of patches and the ends of the surface in floor
    /// and mirror planes stay in place. Midpoints of sides are moved to this surface. The triangles are then as curved
    /// as it is, and the enclosed volume, the mass of air that it displaces, is preserved.
    ///
    /// # Errors
    /// A length that is not positive, and those of [`Boundary::symmetric`].
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

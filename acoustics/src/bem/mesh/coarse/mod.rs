//! Coarser surfaces for lower frequencies: larger curved triangles on the body's own surface, and its velocities carried
//! over to them.
//!
//! ```text
//! lines       sharp edges, borders of patches, ends in planes: vertices on them stay on them
//! collapse    short edges are collapsed, sides of neighbours flipped
//! curved      the point of a surface that lies nearest to a place
//! sides       middles of sides are put on the finer surface
//! carried     each point of the finer surface gives its velocity to one panel of the coarser
//! ```

mod carried;
mod collapse;
mod curved;
mod lines;
mod sides;

use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::checks::positive;
use collapse::Collapse;
use curved::{Curved, Nearest};
use nalgebra::{Point3, Vector3};

impl Boundary {
    /// The same surface by fewer triangles, with edges that measure up to `edge` \[m\] (where this surface's are longer, as
    /// much as those).
    ///
    /// Vertices are some of this surface's: its edges are collapsed to one of their ends, the shortest first, while
    /// triangles stay well shaped and within 40 degrees of the surface's own normals (after Botsch & Kobbelt, *Proc.
    /// Eurographics SGP*, 2004, with half-edges). Sharp edges, borders of patches and where the surface ends in floor and
    /// mirror planes stay where they are. Middles of sides are put on this surface, so that the triangles are curved as it
    /// is and the volume inside, the mass of air that it displaces, is kept.
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

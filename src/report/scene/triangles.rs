//! The triangles of a body's surface in the order in which the page draws them.

use std::ops::Range;

use nailnoise_meshes::JOINT;
use nalgebra::Vector3;

use super::super::surface::ColouredSurface;

/// A triangulated surface: corners of the triangles and the face of each, free faces first, and part by part in each.
pub(super) struct Triangles<'a> {
    pub(super) painted: &'a ColouredSurface<'a>,
    pub(super) corners: Vec<[usize; 3]>,
    pub(super) faces: Vec<usize>,
    pub(super) free: usize,
    pub(super) parts: Vec<Part>,
}

/// A part of a body's mesh that has faces.
pub(super) struct Part {
    /// Its name in the mesh.
    pub(super) name: String,
    /// Its free triangles.
    pub(super) free: Range<usize>,
    /// Its covered triangles.
    pub(super) covered: Range<usize>,
    /// Whether it lies on the joint of a workpiece with two pieces, and can be lifted from the other.
    pub(super) on_joint: bool,
}

impl<'a> Triangles<'a> {
    /// Splits the faces into triangles between their corners.
    pub(super) fn new(painted: &'a ColouredSurface<'a>) -> Self {
        let (mesh, surface) = (&painted.body.mesh, &painted.body.surface);
        let part_of = |face: usize| mesh.parts[surface.faces[face].of.element];
        let mut found = Self {
            painted,
            corners: Vec::new(),
            faces: Vec::new(),
            free: 0,
            parts: Vec::new(),
        };
        let mut ranges = vec![[0..0, 0..0]; mesh.part_names.len()];
        for (place, free) in [true, false].into_iter().enumerate() {
            for (part, ranges) in ranges.iter_mut().enumerate() {
                let first = found.faces.len();
                let all = 0..surface.faces.len();
                for index in all.filter(|&face| painted.free[face] == free && part_of(face) == part) {
                    let face = &surface.faces[index];
                    for last in 2..face.kind.corners() {
                        found.corners.push([0, last - 1, last].map(|corner| face.nodes[corner]));
                        found.faces.push(index);
                    }
                }
                ranges[place] = first..found.faces.len();
            }
            if free {
                found.free = found.faces.len();
            }
        }
        let upper = surface.patches.iter().position(|patch| patch == JOINT[1]);
        let parts = mesh.part_names.iter().zip(ranges).enumerate();
        let parts = parts.map(|(part, (name, [free, covered]))| Part {
            name: name.clone(),
            on_joint: (0..surface.faces.len())
                .any(|face| part_of(face) == part && Some(surface.faces[face].patch) == upper),
            free,
            covered,
        });
        found.parts = parts
            .filter(|part| !part.free.is_empty() || !part.covered.is_empty())
            .collect();
        found
    }

    /// The points that the triangles use, in ascending order.
    pub(super) fn used(&self) -> Vec<usize> {
        let mut used: Vec<usize> = self.corners.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// The position of a point in the room \[m\].
    pub(super) fn place(&self, point: usize) -> Vector3<f64> {
        self.painted.body.surface.points[point].coords + self.painted.origin
    }

    /// The lowest point of a part in the room \[m\].
    fn lowest(&self, part: &Part) -> f64 {
        let triangles = [&part.free, &part.covered].into_iter().flat_map(|range| range.clone());
        let points = triangles.flat_map(|triangle| self.corners[triangle]);
        points.map(|point| self.place(point).z).fold(f64::INFINITY, f64::min)
    }
}

/// The level of each part in the stack of bodies that lie on each other, for each body: 0 for the lowest. Parts of one
/// body have the same level, except a board on its joint.
pub(super) fn stacking_levels(surfaces: &[Triangles<'_>]) -> Vec<Vec<usize>> {
    let lowest = |surface: &Triangles<'_>, on_joint: bool| {
        let own = surface.parts.iter().filter(|part| part.on_joint == on_joint);
        own.map(|part| surface.lowest(part)).fold(f64::INFINITY, f64::min)
    };
    let mut pieces: Vec<(usize, bool, f64)> = Vec::new();
    for (body, surface) in surfaces.iter().enumerate() {
        for on_joint in [false, true] {
            if surface.parts.iter().any(|part| part.on_joint == on_joint) {
                pieces.push((body, on_joint, lowest(surface, on_joint)));
            }
        }
    }
    pieces.sort_by(|a, b| a.2.total_cmp(&b.2));
    let level = |body: usize, part: &Part| {
        let own = |piece: &(usize, bool, f64)| piece.0 == body && piece.1 == part.on_joint;
        pieces.iter().position(own).unwrap_or_default()
    };
    let levels =
        |(body, surface): (usize, &Triangles<'_>)| surface.parts.iter().map(|part| level(body, part)).collect();
    surfaces.iter().enumerate().map(levels).collect()
}

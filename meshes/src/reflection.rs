//! Mirrors half of a symmetric body to make the complete mesh.

use crate::{ElementKind, FaceRef, Mesh};

/// Largest distance from the symmetry plane at which a node counts as lying in it \[m\]: several times 15 nm, the step
/// to which coordinates are rounded.
const IN_PLANE: f64 = 1e-7;

impl Mesh {
    /// Adds the mirror image of all elements, which lie at y >= 0, in the plane y = 0, including their parts and
    /// groups. Both halves share the nodes in the plane. Returns the original of each element and node.
    ///
    /// The mesh is then exactly symmetric. Even and odd modes, and even and odd sound fields, are independent problems
    /// of half the size.
    pub(crate) fn add_image(&mut self) -> Images {
        let (nodes, elements) = (self.nodes.len(), self.element_count());
        let mut node_of: Vec<usize> = (0..nodes).collect();
        let image: Vec<usize> = (0..nodes)
            .map(|node| {
                let at = self.nodes[node];
                if at.y.abs() <= IN_PLANE {
                    self.nodes[node].y = 0.0;
                    return node;
                }
                self.nodes.push([at.x, -at.y, at.z].into());
                node_of.push(node);
                self.nodes.len() - 1
            })
            .collect();
        for element in 0..elements {
            let (kind, start) = (self.kinds[element], self.offsets[element]);
            for local in kind.reflected_nodes() {
                self.connectivity.push(image[self.connectivity[start + local]]);
            }
            self.kinds.push(kind);
            self.parts.push(self.parts[element]);
            self.offsets.push(self.connectivity.len());
        }
        let mut groups = std::mem::take(&mut self.groups);
        for group in &mut groups {
            // A face in the plane has become internal.
            group
                .faces
                .retain(|&face| self.face_nodes(face).into_iter().any(|node| image[node] != node));
            let images = group.faces.iter().map(|face| FaceRef {
                element: elements + face.element,
                face: self.kinds[face.element].reflected_face(face.face),
            });
            let images: Vec<FaceRef> = images.collect();
            group.faces.extend(images);
        }
        groups.retain(|group| !group.faces.is_empty());
        self.groups = groups;
        Images {
            elements: (0..elements).chain(0..elements).collect(),
            nodes: node_of,
        }
    }
}

/// For each element and node of a mirrored mesh, its original; those of the first half are their own originals.
pub(crate) struct Images {
    pub(crate) elements: Vec<usize>,
    pub(crate) nodes: Vec<usize>,
}

impl ElementKind {
    /// For each local node of a mirrored element, the corresponding local node of the original. The first two natural
    /// coordinates are exchanged, so that the mirrored element is not inverted.
    fn reflected_nodes(self) -> impl Iterator<Item = usize> {
        let natural = self.natural_nodes();
        natural.iter().map(|&[x, y, z]| {
            let there = natural.iter().position(|&other| other == [y, x, z]);
            there.unwrap_or_default()
        })
    }

    /// The number of a face after mirroring its element.
    fn reflected_face(self, face: usize) -> usize {
        let reflected: Vec<usize> = self.reflected_nodes().collect();
        let (faces, corners) = (self.faces(), self.face_kind(face).corners());
        let own = |node: &usize| faces[face].contains(&reflected[*node]);
        let there = faces
            .iter()
            .position(|nodes| nodes.len() == faces[face].len() && nodes[..corners].iter().all(own));
        there.unwrap_or(face)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::{FaceGroup, FaceNodes, Surface};

    /// One element at y > 0 with one face in the plane y = 0; every face is a group.
    fn half(kind: ElementKind) -> Mesh {
        let natural = kind.natural_nodes();
        let least = natural.iter().map(|xi| xi[1]).fold(f64::INFINITY, f64::min);
        let faces = 0..kind.faces().len();
        Mesh {
            nodes: natural.iter().map(|&[x, y, z]| [x, y - least, z].into()).collect(),
            kinds: vec![kind],
            offsets: vec![0, kind.nodes()],
            connectivity: (0..kind.nodes()).collect(),
            parts: vec![0],
            part_names: vec!["body".to_owned()],
            groups: faces
                .map(|face| FaceGroup {
                    name: face.to_string(),
                    faces: vec![FaceRef { element: 0, face }],
                })
                .collect(),
        }
    }

    #[test]
    fn an_image_has_the_volume_of_its_element_and_is_not_inverted() {
        for kind in ElementKind::ALL {
            let mut mesh = half(kind);
            let volume = mesh.part_volumes().unwrap()[0];
            mesh.add_image();
            assert_eq!(mesh.inverted(), 0, "{kind:?}");
            assert!(
                (mesh.part_volumes().unwrap()[0] / volume - 2.0).abs() < 1e-12,
                "{kind:?}"
            );
        }
    }

    #[test]
    fn an_element_and_its_image_share_the_face_in_the_plane_alone() {
        for kind in ElementKind::ALL {
            let mut mesh = half(kind);
            mesh.add_image();
            assert_eq!(Surface::of(&mesh).faces.len(), 2 * (kind.faces().len() - 1), "{kind:?}");
        }
    }

    #[test]
    fn a_group_holds_the_images_of_its_faces_and_none_in_the_plane() {
        for kind in ElementKind::ALL {
            let mut mesh = half(kind);
            mesh.add_image();
            assert_eq!(mesh.groups.len(), kind.faces().len() - 1);
            let places = |nodes: FaceNodes, sign: f64| {
                let place = |node: usize| [mesh.nodes[node].x, sign * mesh.nodes[node].y, mesh.nodes[node].z];
                let mut places: Vec<[f64; 3]> = nodes.into_iter().map(place).collect();
                places.sort_by(|a, b| a.partial_cmp(b).unwrap());
                places
            };
            for group in &mesh.groups {
                let [of_half, of_image] = [0, 1].map(|k| mesh.face_nodes(group.faces[k]));
                assert_eq!(places(of_half, 1.0), places(of_image, -1.0), "{kind:?}");
            }
        }
    }
}

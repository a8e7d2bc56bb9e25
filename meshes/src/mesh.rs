//! The volume mesh that all stages share.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::points;
use crate::{ElementKind, FaceKind, FaceNodes, MeshError};

/// A volume mesh: nodes, elements that each belong to a part, and named groups of element faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Node positions \[m\].
    #[serde(with = "points")]
    pub nodes: Vec<Point3<f64>>,
    /// Kind of each element.
    pub kinds: Vec<ElementKind>,
    /// Start of each element in `connectivity`, followed by the end of the last: one entry more than elements.
    pub offsets: Vec<usize>,
    /// Node indices of all elements, in VTK order.
    pub connectivity: Vec<usize>,
    /// Part of each element, an index into `part_names`.
    pub parts: Vec<usize>,
    /// Names of the parts; each part has one material.
    pub part_names: Vec<String>,
    /// Named groups of element faces.
    pub groups: Vec<FaceGroup>,
}

/// A named group of element faces, such as `top` or `floor`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaceGroup {
    /// Name of the group.
    pub name: String,
    /// The faces in it.
    pub faces: Vec<FaceRef>,
}

/// One face of one element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FaceRef {
    /// Element index.
    pub element: usize,
    /// Face number within the element, see [`ElementKind::faces`].
    pub face: usize,
}

/// A view of one element.
#[derive(Clone, Copy, Debug)]
pub struct ElementRef<'a> {
    /// Its kind.
    pub kind: ElementKind,
    /// Its nodes, in VTK order.
    pub nodes: &'a [usize],
    /// Its part.
    pub part: usize,
}

impl Mesh {
    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.kinds.len()
    }

    /// The element with index `e`.
    pub fn element(&self, e: usize) -> ElementRef<'_> {
        ElementRef {
            kind: self.kinds[e],
            nodes: &self.connectivity[self.offsets[e]..self.offsets[e + 1]],
            part: self.parts[e],
        }
    }

    /// All elements in order.
    pub fn elements(&self) -> impl Iterator<Item = ElementRef<'_>> {
        (0..self.element_count()).map(|e| self.element(e))
    }

    /// Finds a face group by name.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], with the available names.
    pub fn group(&self, name: &str) -> Result<&FaceGroup, MeshError> {
        self.groups
            .iter()
            .find(|g| g.name == name)
            .ok_or_else(|| MeshError::UnknownGroup {
                name: name.to_owned(),
                known: self
                    .groups
                    .iter()
                    .map(|g| g.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            })
    }

    /// Volume nodes of a face, ordered so that its normal points outwards: corners, then mid-side nodes, then the
    /// centre.
    pub fn face_nodes(&self, face: FaceRef) -> FaceNodes {
        let element = self.element(face.element);
        FaceNodes::of(
            element.kind.faces()[face.face]
                .iter()
                .map(|&local| element.nodes[local]),
        )
    }

    /// Shape of a face.
    pub fn face_kind(&self, face: FaceRef) -> FaceKind {
        self.kinds[face.element].face_kind(face.face)
    }

    /// The nodes of a face group, in ascending order without duplicates.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], with the available names.
    pub fn group_nodes(&self, name: &str) -> Result<Vec<usize>, MeshError> {
        let mut nodes: Vec<usize> = self
            .group(name)?
            .faces
            .iter()
            .flat_map(|&f| self.face_nodes(f))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Appends the nodes and elements of another mesh. Parts and groups of the same name are merged; no nodes are
    /// shared.
    pub fn join(&mut self, other: &Self) {
        let (nodes, elements, corners) = (self.nodes.len(), self.element_count(), self.connectivity.len());
        self.nodes.extend(&other.nodes);
        self.kinds.extend(&other.kinds);
        self.connectivity
            .extend(other.connectivity.iter().map(|node| nodes + node));
        self.offsets
            .extend(other.offsets.iter().skip(1).map(|offset| corners + offset));
        let part_of: Vec<usize> = other.part_names.iter().map(|name| self.part_named(name)).collect();
        self.parts.extend(other.parts.iter().map(|&part| part_of[part]));
        for group in &other.groups {
            let moved = group.faces.iter().map(|face| FaceRef {
                element: elements + face.element,
                face: face.face,
            });
            match self.groups.iter_mut().find(|own| own.name == group.name) {
                Some(own) => own.faces.extend(moved),
                None => self.groups.push(FaceGroup {
                    name: group.name.clone(),
                    faces: moved.collect(),
                }),
            }
        }
    }

    /// Index of the part of this name, which is added if missing.
    fn part_named(&mut self, name: &str) -> usize {
        self.part_names.iter().position(|own| own == name).unwrap_or_else(|| {
            self.part_names.push(name.to_owned());
            self.part_names.len() - 1
        })
    }

    /// The two extreme corners of the bounding box of all nodes \[m\].
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.nodes.iter().fold(
            (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
            |(low, high), p| (low.inf(p), high.sup(p)),
        )
    }
}

//! The volume mesh that all stages share.

use nalgebra::Point3;

use crate::{ElementKind, FaceKind, FaceNodes, MeshError};

/// A volume mesh: nodes, elements with a part each, named groups of element faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Node positions \[m\].
    pub nodes: Vec<Point3<f64>>,
    /// Kind of each element.
    pub kinds: Vec<ElementKind>,
    /// Start of each element in `connectivity`, and its end: one entry more than elements.
    pub offsets: Vec<usize>,
    /// Node indices of all elements, in VTK order.
    pub connectivity: Vec<usize>,
    /// Part of each element, an index into `part_names`.
    pub parts: Vec<usize>,
    /// Names of the parts; a part has one material.
    pub part_names: Vec<String>,
    /// Named groups of element faces.
    pub groups: Vec<FaceGroup>,
}

/// Faces of elements under one name, such as `top` or `floor`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaceGroup {
    /// Name of the group.
    pub name: String,
    /// The faces in it.
    pub faces: Vec<FaceRef>,
}

/// One face of one element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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

    /// The face group of this name.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`] with the names there are.
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

    /// Volume nodes of a face, outward by the right-hand rule: corners, then mid-sides, then the centre.
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

    /// The nodes of a face group, ascending, each once.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`] with the names there are.
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

    /// The smallest and the largest corner of the box around all nodes \[m\].
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.nodes.iter().fold(
            (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
            |(low, high), p| (low.inf(p), high.sup(p)),
        )
    }
}

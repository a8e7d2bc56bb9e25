//! The raw contents of a `.msh` file: numbered nodes, elements with their groups, group names.

use super::MshError;

/// Comment that states the unit in files written here; the format has no field for it.
pub(super) const IN_METRES: &str = "lengths in m";

/// The contents of a file as read.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Raw {
    /// Dimension, number and name of each named group.
    pub(super) names: Vec<(i64, i64, String)>,
    /// First line of the comments.
    pub(super) comment: String,
    /// Number and position of each node.
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    /// Number of each element.
    pub(super) numbers: Vec<u64>,
    /// gmsh type of each element.
    pub(super) kinds: Vec<&'static Kind>,
    /// Index into `groups` of each element.
    pub(super) group: Vec<usize>,
    /// Number of the geometric entity of each element; 0 if it has none.
    pub(super) entity: Vec<i64>,
    /// The distinct sets of physical groups of elements; `groups[0]` is the empty set.
    pub(super) groups: Vec<Vec<i64>>,
    /// Start of each element's nodes in `nodes_of`, followed by the end of the last: one entry more than elements.
    pub(super) offsets: Vec<usize>,
    /// Numbers of the nodes of all elements, in gmsh's order.
    pub(super) nodes_of: Vec<u64>,
}

/// A gmsh element type.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) code: i64,
    pub(super) name: &'static str,
    pub(super) dimension: i64,
    pub(super) nodes: usize,
}

const fn kind(code: i64, name: &'static str, dimension: i64, nodes: usize) -> Kind {
    Kind {
        code,
        name,
        dimension,
        nodes,
    }
}

/// gmsh element types up to second order, and those of higher order that messages name.
const KINDS: [Kind; 28] = [
    kind(1, "line of 2 nodes", 1, 2),
    kind(2, "triangle of 3 nodes", 2, 3),
    kind(3, "quadrangle of 4 nodes", 2, 4),
    kind(4, "tetrahedron of 4 nodes", 3, 4),
    kind(5, "hexahedron of 8 nodes", 3, 8),
    kind(6, "prism of 6 nodes", 3, 6),
    kind(7, "pyramid of 5 nodes", 3, 5),
    kind(8, "line of 3 nodes", 1, 3),
    kind(9, "triangle of 6 nodes", 2, 6),
    kind(10, "quadrangle of 9 nodes", 2, 9),
    kind(11, "tetrahedron of 10 nodes", 3, 10),
    kind(12, "hexahedron of 27 nodes", 3, 27),
    kind(13, "prism of 18 nodes", 3, 18),
    kind(14, "pyramid of 14 nodes", 3, 14),
    kind(15, "point", 0, 1),
    kind(16, "quadrangle of 8 nodes", 2, 8),
    kind(17, "hexahedron of 20 nodes", 3, 20),
    kind(18, "prism of 15 nodes", 3, 15),
    kind(19, "pyramid of 13 nodes", 3, 13),
    kind(20, "triangle of 9 nodes", 2, 9),
    kind(21, "triangle of 10 nodes", 2, 10),
    kind(26, "line of 4 nodes", 1, 4),
    kind(29, "tetrahedron of 20 nodes", 3, 20),
    kind(30, "tetrahedron of 35 nodes", 3, 35),
    kind(36, "quadrangle of 16 nodes", 2, 16),
    kind(90, "prism of 40 nodes", 3, 40),
    kind(92, "hexahedron of 64 nodes", 3, 64),
    kind(118, "pyramid of 30 nodes", 3, 30),
];

impl Kind {
    /// Looks up a type by its number; `element` is for the message.
    pub(super) fn of(code: i64, element: u64) -> Result<&'static Self, MshError> {
        KINDS.iter().find(|kind| kind.code == code).ok_or(MshError::Element {
            element,
            code,
            name: "unknown here",
        })
    }
}

impl Raw {
    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Numbers of the nodes of one element.
    pub(super) fn element_nodes(&self, element: usize) -> &[u64] {
        &self.nodes_of[self.offsets[element]..self.offsets[element + 1]]
    }

    /// Adds a node.
    pub(super) fn node(&mut self, node: u64, position: [f64; 3]) -> Result<(), MshError> {
        if position.iter().any(|x| !x.is_finite()) {
            let [x, y, z] = position;
            return Err(MshError::Coordinate { node, x, y, z });
        }
        self.nodes.push((node, position));
        Ok(())
    }

    /// Index of a set of physical groups.
    pub(super) fn group_set(&mut self, set: &[i64]) -> usize {
        // Elements of one group are consecutive in a file, so the set is usually the last one used.
        if let Some(&last) = self.group.last()
            && self.groups[last] == set
        {
            return last;
        }
        self.groups.iter().position(|own| own == set).unwrap_or_else(|| {
            self.groups.push(set.to_vec());
            self.groups.len() - 1
        })
    }

    /// Adds an element whose nodes have just been appended to `nodes_of`.
    pub(super) fn element(&mut self, number: u64, kind: &'static Kind, group: usize, entity: i64) {
        self.numbers.push(number);
        self.kinds.push(kind);
        self.group.push(group);
        self.entity.push(entity);
        self.offsets.push(self.nodes_of.len());
    }
}

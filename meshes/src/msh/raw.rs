//! A `.msh` file as it stands: numbered nodes, elements with their groups, names of groups.

use super::MshError;
use super::cursor::{Cursor, Encoding};
use super::{v2, v4};

/// The content of a file before anything is made of it.
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
    /// Physical groups that elements stand in, each set once; `groups[0]` is the empty set.
    pub(super) groups: Vec<Vec<i64>>,
    /// Start of each element's nodes in `nodes_of`, and the end: one entry more than elements.
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

/// Element types of gmsh up to second order, and those of higher order that need a name in a message.
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
    /// The type of this number; `element` is for the message.
    pub(super) fn of(code: i64, element: u64) -> Result<&'static Self, MshError> {
        KINDS.iter().find(|kind| kind.code == code).ok_or(MshError::Element {
            element,
            code,
            name: "unknown here",
        })
    }
}

impl Raw {
    /// Reads a file.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, MshError> {
        let mut cursor = Cursor::new(bytes);
        if !matches!(cursor.open(), Ok(Some(name)) if name == "MeshFormat") {
            return Err(MshError::NotMsh);
        }
        let version = header(&mut cursor)?;
        let mut raw = Self {
            groups: vec![Vec::new()],
            offsets: vec![0],
            ..Self::default()
        };
        let mut entities = v4::Entities::default();
        let (mut has_nodes, mut has_elements) = (false, false);
        while let Some(section) = cursor.open()? {
            match (section.as_str(), version) {
                ("PhysicalNames", _) => {
                    raw.read_names(&mut cursor)?;
                    cursor.close()?;
                }
                ("Entities", Version::V4) => {
                    entities = v4::Entities::read(&mut cursor)?;
                    cursor.close()?;
                }
                ("Nodes", _) => {
                    has_nodes = true;
                    match version {
                        Version::V2 => v2::nodes(&mut cursor, &mut raw)?,
                        Version::V4 => v4::nodes(&mut cursor, &mut raw)?,
                    }
                    cursor.close()?;
                }
                ("Elements", _) => {
                    has_elements = true;
                    match version {
                        Version::V2 => v2::elements(&mut cursor, &mut raw)?,
                        Version::V4 => v4::elements(&mut cursor, &entities, &mut raw)?,
                    }
                    cursor.close()?;
                }
                ("Comments", _) => {
                    raw.comment = cursor.line();
                    cursor.skip_section()?;
                }
                _ => cursor.skip_section()?,
            }
        }
        for (section, found) in [("Nodes", has_nodes), ("Elements", has_elements)] {
            if !found {
                return Err(MshError::NoSection { section });
            }
        }
        Ok(raw)
    }

    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Numbers of the nodes of one element.
    pub(super) fn element_nodes(&self, element: usize) -> &[u64] {
        &self.nodes_of[self.offsets[element]..self.offsets[element + 1]]
    }

    /// Takes up a node.
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
        // Elements of one group follow each other in a file: the last set is the one in most cases.
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

    /// Takes up an element whose nodes have just been appended to `nodes_of`.
    pub(super) fn element(&mut self, number: u64, kind: &'static Kind, group: usize) {
        self.numbers.push(number);
        self.kinds.push(kind);
        self.group.push(group);
        self.offsets.push(self.nodes_of.len());
    }

    fn read_names(&mut self, cursor: &mut Cursor<'_>) -> Result<(), MshError> {
        let count = cursor.text_integer()?;
        let count = cursor.count("names", u64::try_from(count).unwrap_or(u64::MAX), 7)?;
        for _ in 0..count {
            let (dimension, number) = (cursor.text_integer()?, cursor.text_integer()?);
            let name = cursor.quoted()?;
            self.names.push((dimension, number, name));
        }
        Ok(())
    }
}

#[derive(Debug, Clone, Copy)]
enum Version {
    V2,
    V4,
}

fn header(cursor: &mut Cursor<'_>) -> Result<Version, MshError> {
    let word = cursor.word()?;
    let version = match word {
        "2.2" | "2.1" | "2" | "2.0" => Version::V2,
        "4.1" => Version::V4,
        _ => {
            let found = word.chars().take(20).collect();
            return Err(MshError::Version { found });
        }
    };
    let binary = cursor.text_integer()?;
    let size = cursor.text_integer()?;
    let header = |what, found: i64, expected| MshError::Header {
        what,
        found: found.to_string(),
        expected,
    };
    match (version, size) {
        (Version::V2, 8) | (Version::V4, 4 | 8) => {}
        _ => return Err(header("data size", size, "numbers of 8 bytes are read")),
    }
    match binary {
        0 => {}
        1 => {
            cursor.end_of_line();
            let swapped = match cursor.raw_four()? {
                [1, 0, 0, 0] => false,
                [0, 0, 0, 1] => true,
                found => {
                    let found = i64::from(i32::from_le_bytes(found));
                    return Err(header("byte order", found, "a binary 1 tells the order of bytes"));
                }
            };
            let size = if size == 4 { 4 } else { 8 };
            cursor.encoding = Encoding::Binary { swapped, size };
        }
        _ => return Err(header("file type", binary, "0 is text and 1 is binary")),
    }
    cursor.close()?;
    Ok(version)
}

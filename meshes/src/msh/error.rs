//! Faults of a `.msh` file.

/// Faults of a `.msh` file; node and element numbers are those of the file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MshError {
    /// The file does not start like a `.msh` file.
    #[error("it does not begin with $MeshFormat: it is not a .msh file; write one with gmsh -format msh41")]
    NotMsh,
    /// The format version is not supported.
    #[error(
        "it has format version {found}; versions 1, 2, 4.0 and 4.1 are read: convert it with \
         gmsh FILE.msh -save -format msh41 -o NEW.msh"
    )]
    Version {
        /// The version found.
        found: String,
    },
    /// A word of the header has an invalid value.
    #[error("its header says {what} {found}; {expected}")]
    Header {
        /// Name of the word.
        what: &'static str,
        /// The value found.
        found: String,
        /// The value expected.
        expected: &'static str,
    },
    /// The file ends too early.
    #[error("it ends within ${section}, at byte {byte}; the file is cut off: write it again")]
    Truncated {
        /// The incomplete section.
        section: String,
        /// Length of the file.
        byte: usize,
    },
    /// A word that should be a number is not.
    #[error("line {line}, in ${section}: found \"{found}\", expected {expected}")]
    Number {
        /// Line in the file, from 1, counting line feeds in binary data too.
        line: usize,
        /// The section.
        section: String,
        /// The word found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A count is too large for the rest of the file.
    #[error("${section} announces {count} {what}, the rest of the file ({bytes} bytes) cannot hold them")]
    Count {
        /// The section.
        section: String,
        /// The items counted.
        what: &'static str,
        /// The count announced.
        count: u64,
        /// Bytes left in the file.
        bytes: usize,
    },
    /// A section does not end where its count implies.
    #[error("${section} continues beyond the end given by its counts (byte {byte}); the counts are wrong")]
    SectionEnd {
        /// The section.
        section: String,
        /// Position of the expected end.
        byte: usize,
    },
    /// A required section is missing.
    #[error("it has no ${section}; save the mesh with its nodes and elements")]
    NoSection {
        /// The section.
        section: &'static str,
    },
    /// A coordinate is not finite.
    #[error("node {node} lies at ({x}, {y}, {z}); coordinates must be finite")]
    Coordinate {
        /// Number of the node.
        node: u64,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Third coordinate.
        z: f64,
    },
    /// Two nodes have the same number.
    #[error("node {node} is given twice; renumber the nodes (gmsh: Mesh.Renumber)")]
    DuplicateNode {
        /// The number.
        node: u64,
    },
    /// Two volume elements have the same number.
    #[error(
        "element number {element} is given twice with different nodes; renumber the elements (gmsh: Mesh.Renumber)"
    )]
    DuplicateNumber {
        /// The number.
        element: u64,
    },
    /// Two elements have the same nodes.
    #[error("element {element} has the same nodes as element {first}; remove one (gmsh: Coherence Mesh)")]
    DuplicateElement {
        /// The later one.
        element: u64,
        /// The earlier one.
        first: u64,
    },
    /// An element refers to a missing node.
    #[error("element {element} refers to node {node}, which does not exist; save all nodes")]
    DanglingElement {
        /// The element.
        element: u64,
        /// The node referred to.
        node: u64,
    },
    /// A named surface element lies on no volume element.
    #[error(
        "element {element} of the surface group \"{group}\" lies on no volume element; \
         save the volume that it bounds, with the same nodes"
    )]
    DanglingFace {
        /// The surface element.
        element: u64,
        /// Its group.
        group: String,
    },
    /// An element uses a node more than once.
    #[error("element {element} uses node {node} twice; it has no volume: remove or repair it")]
    Collapsed {
        /// The element.
        element: u64,
        /// The node.
        node: u64,
    },
    /// An element is of an unsupported type.
    #[error(
        "element {element} is of gmsh type {code} ({name}); use hexahedra of 8, 20 or 27 nodes, tetrahedra of 4 or 10, \
         prisms of 15 (gmsh: Mesh.ElementOrder = 2, for prisms and 20 nodes Mesh.SecondOrderIncomplete = 1)"
    )]
    Element {
        /// The element.
        element: u64,
        /// Its type number.
        code: i64,
        /// Its name.
        name: &'static str,
    },
    /// There are no volume elements.
    #[error("it has no volume element ({surfaces} surface elements); mesh in three dimensions (gmsh -3)")]
    NoVolume {
        /// Number of surface elements found.
        surfaces: usize,
    },
    /// A volume element belongs to no named group.
    #[error(
        "element {element} belongs to no named volume group; the named groups are: {known}. \
         Give every volume one (gmsh: Physical Volume(\"housing\") = {{...}};)"
    )]
    NoGroup {
        /// The first such element.
        element: u64,
        /// The available groups, comma separated, or `none`.
        known: String,
    },
    /// A volume element belongs to two named groups.
    #[error("element {element} belongs to the volume groups \"{first}\" and \"{second}\"; a part has one material")]
    TwoGroups {
        /// The element.
        element: u64,
        /// One group.
        first: String,
        /// The other.
        second: String,
    },
}

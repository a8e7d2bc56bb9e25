//! Writes `.msh` files.

use std::collections::HashMap;

use super::build::kind_of;
use crate::{FaceKind, Mesh};

/// Format of a `.msh` file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Version 2.2 as text, which most programs read.
    Text22,
    /// Version 2.2 as little-endian binary.
    Binary22,
    /// Version 4.1 as text.
    Text41,
    /// Version 4.1 as little-endian binary.
    Binary41,
}

/// Writes a mesh as a `.msh` file: its parts as named volumes, its face groups as named surfaces; lengths in metres.
///
/// Nodes and elements are numbered from 1 in the order of the mesh, with the faces of groups after the elements. The
/// comments contain `comment`, on one line, and state that lengths are in metres. See [`compressed`](super::compressed)
/// for `.msh.gz`.
pub fn to_bytes(mesh: &Mesh, format: Format, comment: &str) -> Vec<u8> {
    let mut out = Out {
        bytes: Vec::new(),
        binary: matches!(format, Format::Binary22 | Format::Binary41),
    };
    let (version, binary) = match format {
        Format::Text22 => ("2.2", 0),
        Format::Binary22 => ("2.2", 1),
        Format::Text41 => ("4.1", 0),
        Format::Binary41 => ("4.1", 1),
    };
    out.text(&format!("$MeshFormat\n{version} {binary} 8\n"));
    if out.binary {
        out.int(1);
        out.line();
    }
    out.text("$EndMeshFormat\n");
    let (comment, between) = (comment.replace('\n', " "), if comment.is_empty() { "" } else { "; " });
    out.text(&format!(
        "$Comments\n{comment}{between}{}\n$EndComments\n",
        super::raw::IN_METRES
    ));
    out.text("$PhysicalNames\n");
    out.text(&format!("{}\n", mesh.part_names.len() + mesh.groups.len()));
    for (k, group) in mesh.groups.iter().enumerate() {
        out.text(&format!("2 {} \"{}\"\n", k + 1, group.name));
    }
    for (k, part) in mesh.part_names.iter().enumerate() {
        out.text(&format!("3 {} \"{part}\"\n", k + 1));
    }
    out.text("$EndPhysicalNames\n");
    let blocks = blocks(mesh);
    match format {
        Format::Text22 | Format::Binary22 => version_2(&mut out, mesh, &blocks),
        Format::Text41 | Format::Binary41 => version_4(&mut out, mesh, &blocks),
    }
    out.bytes
}

/// Elements of one type in one group.
struct Block {
    dimension: i32,
    code: i32,
    group: usize,
    /// Nodes of each element in gmsh's order, from 1.
    elements: Vec<Vec<usize>>,
}

/// Volume elements in runs of equal type and part, followed by the faces of each group.
fn blocks(mesh: &Mesh) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut push = |dimension: i32, code: i32, group: usize, nodes: Vec<usize>| match blocks.last_mut() {
        Some(last) if (last.dimension, last.code, last.group) == (dimension, code, group) => last.elements.push(nodes),
        _ => blocks.push(Block {
            dimension,
            code,
            group,
            elements: vec![nodes],
        }),
    };
    let types: HashMap<_, _> = [4, 5, 11, 12, 17, 18]
        .into_iter()
        .filter_map(|code| kind_of(code).map(|(kind, tail)| (kind, (code as i32, tail))))
        .collect();
    for view in mesh.elements() {
        let (code, tail) = types[&view.kind];
        let mut nodes = vec![0; view.nodes.len()];
        for (k, &node) in view.nodes.iter().enumerate() {
            let place = if k < view.kind.corners() {
                k
            } else {
                tail[k - view.kind.corners()]
            };
            nodes[place] = node + 1;
        }
        push(3, code, view.part, nodes);
    }
    for (group, faces) in mesh.groups.iter().enumerate() {
        for &face in &faces.faces {
            // The node order of surface elements is the same in VTK and gmsh.
            let code = match mesh.face_kind(face) {
                FaceKind::Tri3 => 2,
                FaceKind::Quad4 => 3,
                FaceKind::Tri6 => 9,
                FaceKind::Quad9 => 10,
                FaceKind::Quad8 => 16,
            };
            push(2, code, group, mesh.face_nodes(face).iter().map(|n| n + 1).collect());
        }
    }
    blocks
}

fn version_2(out: &mut Out, mesh: &Mesh, blocks: &[Block]) {
    out.text(&format!("$Nodes\n{}\n", mesh.nodes.len()));
    for (k, p) in mesh.nodes.iter().enumerate() {
        out.int(k as i32 + 1);
        p.iter().for_each(|&x| out.double(x));
        out.row();
    }
    let count: usize = blocks.iter().map(|block| block.elements.len()).sum();
    out.line_if_binary();
    out.text(&format!("$EndNodes\n$Elements\n{count}\n"));
    let mut number = 0;
    for block in blocks {
        if out.binary {
            out.int(block.code);
            out.int(block.elements.len() as i32);
            out.int(2);
        }
        let group = block.group as i32 + 1;
        for nodes in &block.elements {
            number += 1;
            out.int(number);
            if !out.binary {
                out.int(block.code);
                out.int(2);
            }
            out.int(group);
            out.int(group);
            nodes.iter().for_each(|&node| out.int(node as i32));
            out.row();
        }
    }
    out.line_if_binary();
    out.text("$EndElements\n");
}

fn version_4(out: &mut Out, mesh: &Mesh, blocks: &[Block]) {
    out.text("$Entities\n");
    [0, 0, mesh.groups.len(), mesh.part_names.len()]
        .into_iter()
        .for_each(|count| out.size(count));
    out.row();
    let (low, high) = mesh.bounds();
    for k in (1..=mesh.groups.len()).chain(1..=mesh.part_names.len()) {
        out.int(k as i32);
        low.iter().chain(high.iter()).for_each(|&x| out.double(x));
        out.size(1);
        out.int(k as i32);
        out.size(0);
        out.row();
    }
    out.line_if_binary();
    out.text("$EndEntities\n$Nodes\n");
    let count = mesh.nodes.len();
    [1, count, 1, count].into_iter().for_each(|n| out.size(n));
    out.row();
    [3, 1, 0].into_iter().for_each(|n| out.int(n));
    out.size(count);
    out.row();
    for k in 1..=count {
        out.size(k);
        out.row();
    }
    for p in &mesh.nodes {
        p.iter().for_each(|&x| out.double(x));
        out.row();
    }
    out.line_if_binary();
    out.text("$EndNodes\n$Elements\n");
    let count: usize = blocks.iter().map(|block| block.elements.len()).sum();
    [blocks.len(), count, 1, count].into_iter().for_each(|n| out.size(n));
    out.row();
    let mut number = 0;
    for block in blocks {
        [block.dimension, block.group as i32 + 1, block.code]
            .into_iter()
            .for_each(|n| out.int(n));
        out.size(block.elements.len());
        out.row();
        for nodes in &block.elements {
            number += 1;
            out.size(number);
            nodes.iter().for_each(|&node| out.size(node));
            out.row();
        }
    }
    out.line_if_binary();
    out.text("$EndElements\n");
}

/// Output of numbers as text or binary.
struct Out {
    bytes: Vec<u8>,
    binary: bool,
}

impl Out {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn int(&mut self, value: i32) {
        if self.binary {
            self.bytes.extend_from_slice(&value.to_le_bytes());
        } else {
            self.text(&format!("{value} "));
        }
    }

    fn size(&mut self, value: usize) {
        if self.binary {
            self.bytes.extend_from_slice(&(value as u64).to_le_bytes());
        } else {
            self.text(&format!("{value} "));
        }
    }

    fn double(&mut self, value: f64) {
        if self.binary {
            self.bytes.extend_from_slice(&value.to_le_bytes());
        } else {
            self.text(&format!("{value} "));
        }
    }

    /// Ends a line of text.
    fn row(&mut self) {
        if !self.binary {
            self.line();
        }
    }

    fn line_if_binary(&mut self) {
        if self.binary {
            self.line();
        }
    }

    fn line(&mut self) {
        self.bytes.push(b'\n');
    }
}

//! Converts a file's contents to a [`Mesh`]: parts, named face groups, VTK node order.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Point3;

use super::MshError;
use super::raw::{IN_METRES, Raw};
use crate::{ElementKind, FaceGroup, FaceRef, Mesh, MeshError};

/// For each node of a VTK element after its corners, its position in gmsh's order.
const HEX20: [usize; 12] = [8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15];
/// The edges as in [`HEX20`], then the faces (gmsh: -z, -y, -x, +x, +y, +z; VTK: -x, +x, -y, +y, -z, +z), then the
/// centre.
const HEX27: [usize; 19] = [8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26];
const TET10: [usize; 6] = [4, 5, 6, 7, 9, 8];
/// gmsh orders the edges (0,1), (0,2), (0,3), (1,2), (1,4), (2,5), (3,4), (3,5), (4,5). VTK lists those of the lower
/// triangle, then those of the upper one, then the vertical ones.
const WEDGE15: [usize; 9] = [6, 9, 7, 12, 14, 13, 8, 10, 11];

/// The element kind of a gmsh type, and the positions of its nodes after the corners in gmsh's order.
pub(super) fn kind_of(code: i64) -> Option<(ElementKind, &'static [usize])> {
    Some(match code {
        4 => (ElementKind::Tet4, &[]),
        5 => (ElementKind::Hex8, &[]),
        11 => (ElementKind::Tet10, &TET10),
        12 => (ElementKind::Hex27, &HEX27),
        17 => (ElementKind::Hex20, &HEX20),
        18 => (ElementKind::Wedge15, &WEDGE15),
        _ => return None,
    })
}

/// A mesh with the node and element numbers of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The mesh; its lengths are those of the file times the requested scale.
    pub mesh: Mesh,
    /// For each element of the mesh, its number in the file.
    pub element_numbers: Vec<u64>,
    /// For each node of the mesh, its number in the file.
    pub node_numbers: Vec<u64>,
    /// Number of nodes in the file that no volume element uses; they are omitted.
    pub unused_nodes: usize,
    /// First comment line of the file without the unit; empty if there is none.
    pub comment: String,
    /// Whether the file states that its lengths are in metres, so that no unit is needed.
    pub states_metres: bool,
    /// Remarks for the user on how the mesh was made.
    pub notes: Vec<String>,
}

impl Imported {
    /// Wraps a mesh that was not read from a file.
    pub fn built(mesh: Mesh) -> Self {
        Self {
            mesh,
            element_numbers: Vec::new(),
            node_numbers: Vec::new(),
            unused_nodes: 0,
            comment: String::new(),
            states_metres: false,
            notes: Vec::new(),
        }
    }

    /// Checks the mesh for damage, see [`Mesh::validate`].
    ///
    /// # Errors
    /// Same as [`Mesh::validate`].
    pub fn validate(&self) -> Result<(), MeshError> {
        let number = |element: usize| self.element_numbers.get(element).copied().unwrap_or(element as u64);
        self.mesh.validate(number)
    }

    /// Adds the mirror image of the mesh in the plane y = 0, see [`Mesh::add_image`]. Mirrored elements and nodes take
    /// the numbers of their originals.
    pub(crate) fn add_image(&mut self) {
        let images = self.mesh.add_image();
        self.element_numbers = images.elements.iter().map(|&of| self.element_numbers[of]).collect();
        self.node_numbers = images.nodes.iter().map(|&of| self.node_numbers[of]).collect();
    }
}

impl Raw {
    /// Builds a mesh. Lengths are multiplied by `scale` unless a comment in the file states that they are in metres.
    pub(super) fn build(self, scale: f64) -> Result<Imported, MshError> {
        let (scale, comment, states_metres) = match self.comment.strip_suffix(IN_METRES) {
            Some(rest) => (1.0, rest.trim_end_matches([';', ' ']).to_owned(), true),
            None => (scale, self.comment.clone(), false),
        };
        let place = self.places()?;
        let volumes: Vec<usize> = (0..self.len()).filter(|&e| self.kinds[e].dimension == 3).collect();
        if volumes.is_empty() {
            let surfaces = self.kinds.iter().filter(|kind| kind.dimension == 2).count();
            return Err(MshError::NoVolume { surfaces });
        }
        let used = self.used_nodes(&volumes, &place)?;
        let mut index = vec![usize::MAX; self.nodes.len()];
        for (new, &old) in used.iter().enumerate() {
            index[old] = new;
        }
        let mut built = Imported {
            mesh: Mesh {
                nodes: used
                    .iter()
                    .map(|&old| Point3::from(self.nodes[old].1.map(|x| x * scale)))
                    .collect(),
                kinds: Vec::with_capacity(volumes.len()),
                offsets: vec![0],
                connectivity: Vec::new(),
                parts: Vec::with_capacity(volumes.len()),
                part_names: Vec::new(),
                groups: Vec::new(),
            },
            element_numbers: Vec::with_capacity(volumes.len()),
            node_numbers: used.iter().map(|&old| self.nodes[old].0).collect(),
            unused_nodes: self.nodes.len() - used.len(),
            comment,
            states_metres,
            notes: Vec::new(),
        };
        self.volumes(&volumes, &place, &index, &mut built)?;
        self.faces(&place, &index, &mut built.mesh)?;
        Ok(built)
    }

    /// Index of each node by its number.
    fn places(&self) -> Result<HashMap<u64, usize>, MshError> {
        let mut place = HashMap::with_capacity(self.nodes.len());
        for (index, &(node, _)) in self.nodes.iter().enumerate() {
            if place.insert(node, index).is_some() {
                return Err(MshError::DuplicateNode { node });
            }
        }
        Ok(place)
    }

    fn used_nodes(&self, volumes: &[usize], place: &HashMap<u64, usize>) -> Result<Vec<usize>, MshError> {
        let mut used = vec![false; self.nodes.len()];
        for &element in volumes {
            for node in self.element_nodes(element) {
                used[self.place_of(element, *node, place)?] = true;
            }
        }
        Ok((0..used.len()).filter(|&node| used[node]).collect())
    }

    fn place_of(&self, element: usize, node: u64, place: &HashMap<u64, usize>) -> Result<usize, MshError> {
        place.get(&node).copied().ok_or(MshError::DanglingElement {
            element: self.numbers[element],
            node,
        })
    }

    /// Names of the groups of one dimension, by number.
    fn names_of(&self, dimension: i64) -> HashMap<i64, &str> {
        self.names
            .iter()
            .filter(|(own, _, _)| *own == dimension)
            .map(|(_, number, name)| (number.abs(), name.as_str()))
            .collect()
    }

    /// Lists all groups for a message.
    fn known(&self) -> String {
        let dimension = |d: i64| match d {
            0 => "point",
            1 => "curve",
            2 => "surface",
            _ => "volume",
        };
        let mut known: Vec<String> = self
            .names
            .iter()
            .map(|(d, _, name)| format!("{} \"{name}\"", dimension(*d)))
            .collect();
        let mut unnamed: Vec<(i64, i64)> = (0..self.len())
            .flat_map(|e| self.groups[self.group[e]].iter().map(move |&g| (e, g.abs())))
            .map(|(e, group)| (self.kinds[e].dimension, group))
            .filter(|(d, group)| !self.names.iter().any(|(own, number, _)| (own, number) == (d, group)))
            .collect();
        unnamed.sort_unstable();
        unnamed.dedup();
        known.extend(
            unnamed
                .iter()
                .map(|(d, group)| format!("{} {group} without a name", dimension(*d))),
        );
        if known.is_empty() {
            "none".to_owned()
        } else {
            known.join(", ")
        }
    }

    fn volumes(
        &self,
        volumes: &[usize],
        place: &HashMap<u64, usize>,
        index: &[usize],
        built: &mut Imported,
    ) -> Result<(), MshError> {
        let names = self.names_of(3);
        let mut part_of: HashMap<String, usize> = HashMap::new();
        let mut seen: HashMap<Vec<usize>, usize> = HashMap::with_capacity(volumes.len());
        let mut of_number: HashMap<u64, usize> = HashMap::with_capacity(volumes.len());
        // In version 2.2, an element that belongs to two groups is written twice under two numbers.
        for &element in volumes {
            let (number, kind) = (self.numbers[element], self.kinds[element]);
            let Some((own, tail)) = kind_of(kind.code) else {
                let (code, name) = (kind.code, kind.name);
                return Err(MshError::Element {
                    element: number,
                    code,
                    name,
                });
            };
            let groups = &self.groups[self.group[element]];
            let mut of_element = groups.iter().filter_map(|group| names.get(&group.abs()).copied());
            let by_number;
            let name = match of_element.next() {
                Some(name) => name,
                None if self.names.is_empty() => {
                    by_number = match groups.first() {
                        Some(group) => format!("volume group {}", group.abs()),
                        None => format!("volume {}", self.entity[element]),
                    };
                    by_number.as_str()
                }
                None => {
                    return Err(MshError::NoGroup {
                        element: number,
                        known: self.known(),
                    });
                }
            };
            let two = |second: &str| MshError::TwoGroups {
                element: number,
                first: name.to_owned(),
                second: second.to_owned(),
            };
            if let Some(second) = of_element.find(|second| *second != name) {
                return Err(two(second));
            }
            let in_file = self.element_nodes(element);
            let nodes: Vec<usize> = (0..own.corners())
                .chain(tail.iter().copied())
                .map(|k| Ok(index[self.place_of(element, in_file[k], place)?]))
                .collect::<Result<_, MshError>>()?;
            let mut sorted = nodes.clone();
            sorted.sort_unstable();
            if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
                let node = built.node_numbers[pair[0]];
                return Err(MshError::Collapsed { element: number, node });
            }
            let next = built.mesh.kinds.len();
            if let Some(&first) = seen.get(&sorted) {
                let first_name = &built.mesh.part_names[built.mesh.parts[first]];
                return Err(if first_name == name {
                    let first = built.element_numbers[first];
                    MshError::DuplicateElement { element: number, first }
                } else {
                    MshError::TwoGroups {
                        element: number,
                        first: first_name.clone(),
                        second: name.to_owned(),
                    }
                });
            }
            seen.insert(sorted, next);
            if of_number.insert(number, next).is_some() {
                return Err(MshError::DuplicateNumber { element: number });
            }
            let part = part_of.get(name).copied().unwrap_or_else(|| {
                built.mesh.part_names.push(name.to_owned());
                part_of.insert(name.to_owned(), built.mesh.part_names.len() - 1);
                built.mesh.part_names.len() - 1
            });
            built.mesh.connectivity.extend(nodes);
            built.mesh.offsets.push(built.mesh.connectivity.len());
            built.mesh.kinds.push(own);
            built.mesh.parts.push(part);
            built.element_numbers.push(number);
        }
        Ok(())
    }

    /// Face groups in the order of their names. A face between two elements is attributed to the first one.
    fn faces(&self, place: &HashMap<u64, usize>, index: &[usize], mesh: &mut Mesh) -> Result<(), MshError> {
        let names = self.names_of(2);
        let mut behind: HashMap<[usize; 4], FaceRef> = HashMap::new();
        for (element, view) in mesh.elements().enumerate() {
            for (face, local) in view.kind.faces().iter().enumerate() {
                let corners = view.kind.face_kind(face).corners();
                let key = corner_key(local[..corners].iter().map(|&k| view.nodes[k]));
                behind.entry(key).or_insert(FaceRef { element, face });
            }
        }
        let mut groups: BTreeMap<&str, Vec<FaceRef>> = BTreeMap::new();
        for element in 0..self.len() {
            if self.kinds[element].dimension != 2 {
                continue;
            }
            let named = self.groups[self.group[element]]
                .iter()
                .filter_map(|group| names.get(&group.abs()).copied());
            for group in named {
                let corners = match self.kinds[element].code {
                    2 | 9 | 20 | 21 => 3,
                    _ => 4,
                };
                let mut nodes = Vec::with_capacity(corners);
                for &node in &self.element_nodes(element)[..corners] {
                    nodes.push(index[self.place_of(element, node, place)?]);
                }
                let face = behind
                    .get(&corner_key(nodes.into_iter()))
                    .ok_or_else(|| MshError::DanglingFace {
                        element: self.numbers[element],
                        group: group.to_owned(),
                    })?;
                groups.entry(group).or_default().push(*face);
            }
        }
        mesh.groups = groups
            .into_iter()
            .map(|(name, mut faces)| {
                faces.sort_unstable();
                faces.dedup();
                FaceGroup {
                    name: name.to_owned(),
                    faces,
                }
            })
            .collect();
        Ok(())
    }
}

/// The corners of a face in ascending order, which are the same for both elements that share it.
fn corner_key(corners: impl Iterator<Item = usize>) -> [usize; 4] {
    let mut key = [usize::MAX; 4];
    for (slot, node) in key.iter_mut().zip(corners) {
        *slot = node;
    }
    key.sort_unstable();
    key
}

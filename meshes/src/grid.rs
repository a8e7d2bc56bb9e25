//! Structured meshes: filled cells of a rectangular grid become 20-node hexahedra.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::{ElementKind, FaceGroup, FaceRef, Mesh, MeshError};

/// A rectangular grid. Meshes of different bodies conform where their grid lines coincide.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    lines: [Vec<f64>; 3],
}

impl Grid {
    /// Creates a grid from its lines along x, y and z \[m\], at least two each, strictly ascending.
    ///
    /// # Errors
    /// [`MeshError::NoElements`] or [`MeshError::GridLines`].
    pub fn new(x: Vec<f64>, y: Vec<f64>, z: Vec<f64>) -> Result<Self, MeshError> {
        let lines = [x, y, z];
        for ((line, axis), what) in lines.iter().zip(['x', 'y', 'z']).zip(["x", "y", "z"]) {
            if line.len() < 2 {
                return Err(MeshError::NoElements { what });
            }
            // The condition also rejects NaN.
            if let Some(i) =
                (1..line.len()).find(|&i| line[i - 1].partial_cmp(&line[i]) != Some(std::cmp::Ordering::Less))
            {
                return Err(MeshError::GridLines {
                    axis,
                    index: i,
                    value: line[i],
                });
            }
        }
        Ok(Self { lines })
    }

    /// Number of cells along x, y and z.
    pub fn cells(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| self.lines[k].len() - 1)
    }

    /// Centre of a cell \[m\].
    pub fn centre(&self, cell: [usize; 3]) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|k| (self.lines[k][cell[k]] + self.lines[k][cell[k] + 1]) / 2.0))
    }

    /// Meshes the filled cells.
    ///
    /// `part` returns the part of a cell by its index, or none if the cell is empty. `name` returns the group of an
    /// outer face, given its part, its outward direction (axis 0 to 2, and whether towards larger coordinates) and its
    /// centre. Elements and nodes are numbered with x varying fastest, then y, then z.
    pub fn mesh(
        &self,
        part_names: &[&str],
        part: impl Fn([usize; 3]) -> Option<usize>,
        name: impl Fn(usize, usize, bool, Point3<f64>) -> &'static str,
    ) -> Mesh {
        let [nx, ny, nz] = self.cells();
        let mut mesh = Mesh {
            nodes: Vec::new(),
            kinds: Vec::new(),
            offsets: vec![0],
            connectivity: Vec::new(),
            parts: Vec::new(),
            part_names: part_names.iter().map(|&s| s.to_owned()).collect(),
            groups: Vec::new(),
        };
        let cells: Vec<[usize; 3]> = (0..nz)
            .flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
            .filter(|&c| part(c).is_some())
            .collect();
        let index = self.number_nodes(&cells, &mut mesh);
        for &cell in &cells {
            let nodes = lattice_nodes(cell).map(|l| index[&l]);
            mesh.connectivity.extend(nodes);
            mesh.offsets.push(mesh.connectivity.len());
            mesh.kinds.push(ElementKind::Hex20);
            mesh.parts.extend(part(cell));
        }
        for (element, &cell) in cells.iter().enumerate() {
            for axis in 0..3 {
                for upper in [false, true] {
                    let neighbour = neighbour(cell, axis, upper, self.cells());
                    if neighbour.is_some_and(|c| part(c).is_some()) {
                        continue;
                    }
                    let mut centre = self.centre(cell);
                    centre[axis] = self.lines[axis][cell[axis] + usize::from(upper)];
                    let group = name(mesh.parts[element], axis, upper, centre);
                    let face = FaceRef {
                        element,
                        face: 2 * axis + usize::from(upper),
                    };
                    match mesh.groups.iter_mut().find(|g| g.name == group) {
                        Some(g) => g.faces.push(face),
                        None => mesh.groups.push(FaceGroup {
                            name: group.to_owned(),
                            faces: vec![face],
                        }),
                    }
                }
            }
        }
        mesh
    }

    /// Numbers the nodes in use. Keys are positions on a lattice of twice the resolution, ordered z, y, x.
    fn number_nodes(&self, cells: &[[usize; 3]], mesh: &mut Mesh) -> HashMap<[usize; 3], usize> {
        let mut used: Vec<[usize; 3]> = cells
            .iter()
            .flat_map(|&c| lattice_nodes(c))
            .map(|[x, y, z]| [z, y, x])
            .collect();
        used.sort_unstable();
        used.dedup();
        mesh.nodes = used.iter().map(|&[z, y, x]| self.lattice_point([x, y, z])).collect();
        used.iter().enumerate().map(|(i, &[z, y, x])| ([x, y, z], i)).collect()
    }

    fn lattice_point(&self, at: [usize; 3]) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|k| {
            let (line, i) = (&self.lines[k], at[k] / 2);
            if at[k].is_multiple_of(2) {
                line[i]
            } else {
                (line[i] + line[i + 1]) / 2.0
            }
        }))
    }
}

fn lattice_nodes(cell: [usize; 3]) -> [[usize; 3]; 20] {
    let natural = ElementKind::Hex20.natural_nodes();
    std::array::from_fn(|a| std::array::from_fn(|k| 2 * cell[k] + (natural[a][k] + 1.0) as usize))
}

fn neighbour(cell: [usize; 3], axis: usize, upper: bool, cells: [usize; 3]) -> Option<[usize; 3]> {
    let mut next = cell;
    next[axis] = if upper {
        cell[axis] + 1
    } else {
        cell[axis].checked_sub(1)?
    };
    (next[axis] < cells[axis]).then_some(next)
}

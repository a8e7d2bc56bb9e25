//! Mirror planes of a mesh.

use nailnoise_meshes::Mesh;

use crate::Material;
use crate::material::VOIGT;

/// Distance within which a node and the mirror image of another count as coincident, relative to the body's size.
const SAME_PLACE: f64 = 1e-8;

/// Smallest number of unknowns for which dividing the problem pays off.
const WORTHWHILE: usize = 3000;

/// A mirror plane as a signed permutation: unknown e becomes `sign[e]` times unknown `image[e]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mirror {
    pub(crate) image: Vec<usize>,
    pub(crate) sign: Vec<f64>,
}

impl Mirror {
    /// The planes through the middle of the mesh, perpendicular to its axes, that map the positions of the unknowns
    /// onto each other; `equation_of` and `dof_of` number the unknowns. [`crate::symmetry::sectors`] checks whether K
    /// and M have the same symmetry.
    pub(crate) fn candidates(mesh: &Mesh, equation_of: &[Option<usize>], dof_of: &[usize]) -> Vec<Self> {
        let mut nodes: Vec<usize> = dof_of.iter().map(|dof| dof / 3).collect();
        nodes.sort_unstable();
        nodes.dedup();
        // Rotations of rigid masses have no position to mirror.
        if dof_of.len() < WORTHWHILE || nodes.last().is_none_or(|&n| n >= mesh.nodes.len()) {
            return Vec::new();
        }
        let places = Places::new(mesh, nodes);
        let mirror = |axis: usize| {
            let opposite = places.opposite(axis)?;
            let mut mirror = Self {
                image: vec![0; dof_of.len()],
                sign: vec![1.0; dof_of.len()],
            };
            for (e, &dof) in dof_of.iter().enumerate() {
                mirror.image[e] = equation_of[3 * opposite[dof / 3] + dof % 3]?;
                mirror.sign[e] = if dof % 3 == axis { -1.0 } else { 1.0 };
            }
            let involution = (0..dof_of.len()).all(|e| mirror.image[mirror.image[e]] == e);
            involution.then_some(mirror)
        };
        (0..3).filter_map(mirror).collect()
    }

    /// S x.
    pub(crate) fn apply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (e, value) in x.iter().enumerate() {
            y[self.image[e]] = self.sign[e] * value;
        }
        y
    }
}

/// Nodes sorted along a direction. No two nodes of a regular mesh have the same coordinate along it.
struct Places<'a> {
    mesh: &'a Mesh,
    /// The connected piece of each node; where two pieces touch, both have a node at the same position.
    pieces: Vec<Option<usize>>,
    sorted: Vec<(f64, usize)>,
    lower: [f64; 3],
    upper: [f64; 3],
}

impl<'a> Places<'a> {
    /// Incommensurable components, so that different nodes of a grid have different coordinates along this direction.
    const DIRECTION: [f64; 3] = [0.563_912_4, 0.611_737_9, 0.554_801_7];

    fn new(mesh: &'a Mesh, nodes: Vec<usize>) -> Self {
        let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &node in &nodes {
            for axis in 0..3 {
                lower[axis] = lower[axis].min(mesh.nodes[node][axis]);
                upper[axis] = upper[axis].max(mesh.nodes[node][axis]);
            }
        }
        let mut sorted: Vec<(f64, usize)> = nodes
            .into_iter()
            .map(|n| (Self::height(std::array::from_fn(|axis| mesh.nodes[n][axis])), n))
            .collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            mesh,
            pieces: mesh.piece_of_nodes(),
            sorted,
            lower,
            upper,
        }
    }

    fn height(point: [f64; 3]) -> f64 {
        (0..3).map(|axis| Self::DIRECTION[axis] * point[axis]).sum()
    }

    /// For each node, the node at its mirror image in the middle plane; none if any node has no counterpart.
    fn opposite(&self, axis: usize) -> Option<Vec<usize>> {
        let size = (0..3).map(|a| self.upper[a] - self.lower[a]).fold(0.0, f64::max);
        let near = SAME_PLACE * size;
        let mut opposite = vec![0; self.mesh.nodes.len()];
        for &(_, node) in &self.sorted {
            let mut place: [f64; 3] = std::array::from_fn(|a| self.mesh.nodes[node][a]);
            place[axis] = self.lower[axis] + self.upper[axis] - place[axis];
            let height = Self::height(place);
            let start = self.sorted.partition_point(|&(h, _)| h < height - 2.0 * near);
            let there = self.sorted[start..]
                .iter()
                .take_while(|&&(h, _)| h < height + 2.0 * near)
                .map(|&(_, n)| n)
                .filter(|&n| (0..3).all(|a| (self.mesh.nodes[n][a] - place[a]).abs() < near));
            let own = |n: &usize| self.pieces[*n] == self.pieces[node];
            opposite[node] = there.clone().find(own).or_else(|| there.clone().next())?;
        }
        Some(opposite)
    }
}

/// Number of symmetry planes of a mesh and its materials, through its middle and perpendicular to the axes.
/// [`crate::modes`] uses them if constraints and attachments are symmetric as well and the model is large enough.
pub fn mirror_planes(mesh: &Mesh, materials: &[Material]) -> usize {
    let mut nodes = mesh.connectivity.clone();
    nodes.sort_unstable();
    nodes.dedup();
    if 3 * nodes.len() < WORTHWHILE {
        return 0;
    }
    let places = Places::new(mesh, nodes);
    // A strain component changes its sign with each of its two axes that is mirrored.
    let odd = |component: usize, axis: usize| {
        VOIGT[component].0 != VOIGT[component].1 && (VOIGT[component].0 == axis || VOIGT[component].1 == axis)
    };
    let kept = |material: &Material, axis: usize| {
        let c = material.stiffness();
        (0..6).all(|i| (0..6).all(|j| odd(i, axis) == odd(j, axis) || c[(i, j)].abs() <= 1e-12 * c.amax()))
    };
    (0..3)
        .filter(|&axis| materials.iter().all(|m| kept(m, axis)) && places.opposite(axis).is_some())
        .count()
}

//! Fixed degrees of freedom.

use std::collections::BTreeSet;

use nailnoise_meshes::Mesh;

use crate::FemError;

/// Displacement components fixed at zero; they are eliminated, not penalised.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Constraints {
    held: BTreeSet<(usize, usize)>,
}

impl Constraints {
    /// No constraints: a free body.
    pub fn free() -> Self {
        Self::default()
    }

    /// Fixes all three displacements at the nodes of a face group.
    ///
    /// # Errors
    /// [`FemError::Mesh`] if there is no such group.
    pub fn clamped(mesh: &Mesh, group: &str) -> Result<Self, FemError> {
        let mut constraints = Self::free();
        for node in mesh.group_nodes(group)? {
            for axis in 0..3 {
                constraints.hold(node, axis);
            }
        }
        Ok(constraints)
    }

    /// Fixes one displacement component (axis 0, 1, 2 for x, y, z) of one node.
    pub fn hold(&mut self, node: usize, axis: usize) {
        self.held.insert((node, axis));
    }

    /// Whether this component is fixed.
    pub fn holds(&self, node: usize, axis: usize) -> bool {
        self.held.contains(&(node, axis))
    }

    /// The fixed components, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.held.iter().copied()
    }
}

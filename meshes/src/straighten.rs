//! Moves mid-side nodes that fold an element to the middle of its straight edges.

use crate::{Mesh, POOR};

impl Mesh {
    /// Makes the edges straight of every element whose Jacobians are poor (ratio below [`POOR`]) until none is left
    /// that straight edges would help; returns the number of edges.
    ///
    /// A mesher that bends the sides of an element onto a curved surface may fold it where a wall is thin. A chord
    /// differs from its arc by l^2/(8 r), some hundredths of a millimetre.
    pub fn straighten(&mut self) -> usize {
        let mut straight = 0;
        // Each pass bends neighbours less; one that still changes an edge is followed by another.
        loop {
            let poor: Vec<usize> = (0..self.element_count())
                .filter(|&element| self.jacobian(element).ratio < POOR)
                .collect();
            let before = straight;
            for element in poor {
                let range = self.offsets[element]..self.offsets[element + 1];
                let (kind, nodes) = (self.kinds[element], &self.connectivity[range]);
                if kind.order() < 2 {
                    continue;
                }
                for (k, &[a, b]) in kind.edges().iter().enumerate() {
                    // Mid-side nodes follow the corners in the order of the edges.
                    let middle = nalgebra::center(&self.nodes[nodes[a]], &self.nodes[nodes[b]]);
                    let node = &mut self.nodes[nodes[kind.corners() + k]];
                    if *node != middle {
                        *node = middle;
                        straight += 1;
                    }
                }
            }
            if straight == before {
                return straight;
            }
        }
    }
}

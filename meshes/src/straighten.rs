//! Straightens edges whose curved mid-side nodes fold an element.

use crate::{Mesh, POOR};

impl Mesh {
    /// Straightens the edges of every element with a poor ratio of Jacobians (below [`POOR`]) until straightening helps
    /// no further element; returns the number of edges straightened.
    ///
    /// A mesher that curves an element's sides to follow a surface may fold the element where a wall is thin. A chord
    /// deviates from its arc by l^2/(8 r), a few hundredths of a millimetre.
    pub fn straighten(&mut self) -> usize {
        let mut straight = 0;
        // Each pass makes neighbours less curved, so passes are repeated until no edge changes.
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
                    // Mid-side nodes follow the corners, in the order of the edges.
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

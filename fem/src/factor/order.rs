//! The elimination order: nested dissection of the node graph, followed by a postorder.

use feral_metis::{CscPattern, MetisOptions, metis_order_full};

use crate::FemError;

/// An undirected graph without loops; the neighbours of i, ascending, are `targets[offsets[i]..offsets[i + 1]]`.
pub(crate) struct Graph {
    pub(crate) offsets: Vec<usize>,
    pub(crate) targets: Vec<usize>,
}

impl Graph {
    pub(crate) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    pub(crate) fn neighbours(&self, i: usize) -> &[usize] {
        &self.targets[self.offsets[i]..self.offsets[i + 1]]
    }
}

/// The nodes in elimination order.
///
/// Nested dissection (George 1973; multilevel after Karypis & Kumar 1998) leads to low fill. A postorder of its
/// elimination tree does not change the fill and makes columns of equal pattern adjacent. Of several children, the one
/// with the longest column is placed next to its parent, which enlarges supernodes.
pub(crate) fn elimination_order(graph: &Graph) -> Result<Vec<usize>, FemError> {
    let dofs = 3 * graph.len();
    let narrow = |v: &[usize]| v.iter().map(|&i| i32::try_from(i)).collect::<Result<Vec<i32>, _>>();
    let col_ptr = narrow(&graph.offsets).map_err(|_| FemError::TooLarge { dofs })?;
    let row_idx = narrow(&graph.targets).map_err(|_| FemError::TooLarge { dofs })?;
    let pattern = CscPattern::new(graph.len(), &col_ptr, &row_idx).ok_or_else(|| FemError::Order {
        reason: "the node graph is malformed".to_owned(),
    })?;
    let (order, _, _) =
        metis_order_full(&pattern, &MetisOptions::default()).map_err(|e| FemError::Order { reason: e.to_string() })?;
    let order: Vec<usize> = order.into_iter().map(|i| i as usize).collect();
    let parent = elimination_tree(graph, &order);
    Ok(postorder(&parent).into_iter().map(|k| order[k]).collect())
}

/// Parent of each position of `order` in the elimination tree; none for a root (Liu 1990, algorithm 4.2).
fn elimination_tree(graph: &Graph, order: &[usize]) -> Vec<Option<usize>> {
    let mut position = vec![0; order.len()];
    for (k, &node) in order.iter().enumerate() {
        position[node] = k;
    }
    let mut parent = vec![None; order.len()];
    let mut ancestor: Vec<Option<usize>> = vec![None; order.len()];
    for (k, &node) in order.iter().enumerate() {
        for &neighbour in graph.neighbours(node) {
            let mut i = position[neighbour];
            while i < k {
                let next = ancestor[i].replace(k);
                match next {
                    Some(j) => i = j,
                    None => {
                        parent[i] = Some(k);
                        break;
                    }
                }
            }
        }
    }
    parent
}

/// A postorder of the forest. The child with the largest subtree comes last, next to its parent.
fn postorder(parent: &[Option<usize>]) -> Vec<usize> {
    let n = parent.len();
    let mut size = vec![1usize; n];
    // Parents follow their children, so a single sweep sums the subtrees.
    for (i, p) in parent.iter().enumerate() {
        if let Some(p) = *p {
            size[p] += size[i];
        }
    }
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut roots = Vec::new();
    for (i, p) in parent.iter().enumerate() {
        match p {
            Some(p) => children[*p].push(i),
            None => roots.push(i),
        }
    }
    for list in &mut children {
        list.sort_by_key(|&i| (size[i], i));
    }
    let mut order = Vec::with_capacity(n);
    for root in roots {
        let mut stack = vec![(root, 0)];
        while let Some((i, next)) = stack.pop() {
            if let Some(&child) = children[i].get(next) {
                stack.push((i, next + 1));
                stack.push((child, 0));
            } else {
                order.push(i);
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(n: usize) -> Graph {
        let (mut offsets, mut targets) = (vec![0], Vec::new());
        for i in 0..n {
            targets.extend(i.checked_sub(1));
            targets.extend((i + 1 < n).then_some(i + 1));
            offsets.push(targets.len());
        }
        Graph { offsets, targets }
    }

    #[test]
    fn order_is_a_permutation_and_the_same_each_time() {
        let graph = path(1000);
        let order = elimination_order(&graph).unwrap();
        assert_eq!(order, elimination_order(&graph).unwrap());
        let mut sorted = order;
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..1000));
    }

    #[test]
    fn tree_of_a_path_in_natural_order_is_the_path() {
        let parent = elimination_tree(&path(5), &[0, 1, 2, 3, 4]);
        assert_eq!(parent, [Some(1), Some(2), Some(3), Some(4), None]);
    }

    #[test]
    fn postorder_puts_children_before_parents_and_the_heavier_one_last() {
        // 4 has the children 0 and 3; 3, 2 and 1 form a chain.
        let parent = [Some(4), Some(2), Some(3), Some(4), None];
        assert_eq!(postorder(&parent), [0, 1, 2, 3, 4]);
        let parent = [Some(1), Some(2), Some(4), Some(4), None];
        assert_eq!(postorder(&parent), [3, 0, 1, 2, 4]);
    }
}

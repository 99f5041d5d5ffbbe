//! A fill-reducing order of elimination: nested dissection by coordinates, then postordered.

use crate::geometry::{Vector, bounding_box};
use crate::mesh::TriMesh;

/// Parts of at most this many nodes are not cut further.
const LEAF: usize = 8;

/// Orders the nodes of a mesh for elimination.
///
/// The mesh is cut recursively at the median of its longer direction; the nodes on the cut come after
/// both halves (George 1973). A postorder of the elimination tree follows, so that the columns of a
/// supernode stand side by side.
pub fn elimination_order(mesh: &TriMesh) -> Vec<u32> {
    let (starts, neighbours) = mesh.topology().node_neighbours();
    let graph = Graph { starts: &starts, neighbours: &neighbours };
    let mut nodes: Vec<u32> = (0..mesh.points().len() as u32).collect();
    let mut order = Vec::with_capacity(nodes.len());
    let mut mark = vec![Side::Outside; nodes.len()];
    dissect(mesh.points(), &graph, &mut nodes, &mut mark, &mut order);
    postorder(&graph, &order)
}

struct Graph<'a> {
    starts: &'a [u32],
    neighbours: &'a [u32],
}

impl Graph<'_> {
    fn around(&self, node: u32) -> &[u32] {
        &self.neighbours[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Left,
    Right,
}

fn dissect(points: &[Vector], graph: &Graph<'_>, part: &mut [u32], mark: &mut [Side], order: &mut Vec<u32>) {
    if part.len() <= LEAF {
        order.extend_from_slice(part);
        return;
    }
    let corners: Vec<Vector> = part.iter().map(|&n| points[n as usize]).collect();
    let [low, high] = bounding_box(&corners);
    let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
    let coordinate = |n: u32| points[n as usize][axis];
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |a, b| coordinate(*a).total_cmp(&coordinate(*b)).then(a.cmp(b)));
    // Nodes on the median line all go to the right, which makes a grid line a clean cut.
    let median = coordinate(part[middle]);
    let is_left = |n: u32| if median > low[axis] { coordinate(n) < median } else { coordinate(n) <= median };
    for &n in part.iter() {
        mark[n as usize] = if is_left(n) { Side::Left } else { Side::Right };
    }
    let touches = |n: u32, side: Side| graph.around(n).iter().any(|&m| mark[m as usize] == side);
    let on_left: Vec<u32> = part.iter().copied().filter(|&n| is_left(n) && touches(n, Side::Right)).collect();
    let on_right: Vec<u32> =
        part.iter().copied().filter(|&n| !is_left(n) && touches(n, Side::Left)).collect();
    let mut separator = if on_left.len() < on_right.len() { on_left } else { on_right };
    separator.sort_unstable_by(|a, b| {
        let (p, q) = (points[*a as usize], points[*b as usize]);
        p[1 - axis].total_cmp(&q[1 - axis]).then(a.cmp(b))
    });
    for &n in part.iter() {
        mark[n as usize] = Side::Outside;
    }
    for &n in &separator {
        mark[n as usize] = Side::Left;
    }
    let keep = |n: &u32| mark[*n as usize] == Side::Outside;
    let mut left: Vec<u32> = part.iter().copied().filter(|n| keep(n) && is_left(*n)).collect();
    let mut right: Vec<u32> = part.iter().copied().filter(|n| keep(n) && !is_left(*n)).collect();
    for &n in &separator {
        mark[n as usize] = Side::Outside;
    }
    if left.len() + right.len() == part.len() {
        // Two unconnected halves, or all nodes in one place: nothing separates them.
        if left.is_empty() || right.is_empty() {
            order.extend_from_slice(part);
            return;
        }
    }
    dissect(points, graph, &mut left, mark, order);
    dissect(points, graph, &mut right, mark, order);
    order.extend_from_slice(&separator);
}

/// Renumbers an order by a postorder of its elimination tree, which keeps the fill (Liu 1990).
fn postorder(graph: &Graph<'_>, order: &[u32]) -> Vec<u32> {
    const ROOT: u32 = u32::MAX;
    let n = order.len();
    let mut position = vec![0u32; n];
    for (k, &node) in order.iter().enumerate() {
        position[node as usize] = k as u32;
    }
    let mut parent = vec![ROOT; n];
    let mut ancestor = vec![ROOT; n];
    for (k, &node) in order.iter().enumerate() {
        for &m in graph.around(node) {
            let mut i = position[m as usize] as usize;
            // Climb to the root of i's subtree, compressing the path.
            while i < k {
                let next = ancestor[i];
                ancestor[i] = k as u32;
                if next == ROOT {
                    parent[i] = k as u32;
                    break;
                }
                i = next as usize;
            }
        }
    }
    let mut first_child = vec![ROOT; n];
    let mut sibling = vec![ROOT; n];
    for k in (0..n).rev() {
        if parent[k] != ROOT {
            sibling[k] = first_child[parent[k] as usize];
            first_child[parent[k] as usize] = k as u32;
        }
    }
    let mut result = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in (0..n).filter(|&k| parent[k] == ROOT) {
        stack.push(root as u32);
        while let Some(&top) = stack.last() {
            let child = first_child[top as usize];
            if child == ROOT {
                result.push(order[top as usize]);
                stack.pop();
            } else {
                first_child[top as usize] = sibling[child as usize];
                stack.push(child);
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::block;

    /// Counts the entries of the Cholesky factor of the node graph by symbolic elimination.
    fn fill(mesh: &TriMesh, order: &[u32]) -> usize {
        let (starts, neighbours) = mesh.topology().node_neighbours();
        let graph = Graph { starts: &starts, neighbours: &neighbours };
        let mut position = vec![0usize; order.len()];
        for (k, &n) in order.iter().enumerate() {
            position[n as usize] = k;
        }
        let mut columns = vec![std::collections::BTreeSet::new(); order.len()];
        let mut total = 0;
        for (k, &n) in order.iter().enumerate() {
            for &m in graph.around(n) {
                if position[m as usize] > k {
                    columns[k].insert(position[m as usize]);
                }
            }
            let column = std::mem::take(&mut columns[k]);
            total += 1 + column.len();
            if let Some(&parent) = column.first() {
                columns[parent].extend(column.iter().copied().filter(|&i| i > parent));
            }
        }
        total
    }

    #[test]
    fn order_is_a_permutation_with_less_fill_than_the_natural_one() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [40, 20]).unwrap();
        let order = elimination_order(&mesh);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        let natural: Vec<u32> = (0..mesh.points().len() as u32).collect();
        assert_eq!(sorted, natural);
        let (ours, banded) = (fill(&mesh, &order), fill(&mesh, &natural));
        assert!(2 * ours < banded, "fill {ours} against {banded} in the natural order");
    }

    #[test]
    fn tiny_and_degenerate_meshes_are_ordered() {
        for cells in [[1, 1], [1, 40], [40, 1]] {
            let mesh = block([0.0, 0.0], [1.0, 1.0], cells).unwrap();
            assert_eq!(elimination_order(&mesh).len(), mesh.points().len());
        }
    }
}

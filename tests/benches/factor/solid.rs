//! The stiffness of a cube of linear tetrahedra, and its nested dissection.

use fem_core::cholesky::Front;
use fem_core::ordering::ROOT;
use fem_core::sparse::SymmetricCsc;
use std::ops::Range;

/// The Lamé constants for Poisson's number 0.3 and Young's modulus 1.
const LAME: [f64; 2] = [0.3 / (1.3 * 0.4), 1.0 / 2.6];
/// Parts of at most this many nodes are not cut further.
const LEAF: usize = 8;
/// The paths along the edges of a cube from its first corner to the opposite one: six tetrahedra.
const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// A cube of cubes, each split into six tetrahedra; its lowest face is clamped, and the nodes above it have three unknowns each.
#[derive(Clone, Copy)]
pub(crate) struct Solid {
    /// Along each axis.
    pub(crate) cells: usize,
}

impl Solid {
    /// The number of a node above the clamped face, level by level.
    fn node(self, [x, y, z]: [usize; 3]) -> Option<usize> {
        let side = self.cells + 1;
        Some((z.checked_sub(1)? * side + y) * side + x)
    }

    /// The stiffness with the unknowns in the order of the nodes.
    pub(crate) fn stiffness(self) -> SymmetricCsc {
        let n = self.cells;
        let mut columns = vec![std::collections::BTreeMap::new(); 3 * n * (n + 1) * (n + 1)];
        for cube in (0..n.pow(3)).map(|k| [k % n, k / n % n, k / (n * n)]) {
            for path in PATHS {
                let mut corners = [cube; 4];
                // Along a path only one coordinate changes between a corner and the next one, which gives the gradients.
                let mut gradients = [[0.0; 3]; 4];
                for (k, axis) in path.into_iter().enumerate() {
                    corners[k + 1] = corners[k];
                    corners[k + 1][axis] += 1;
                    gradients[k][axis] -= 1.0;
                    gradients[k + 1][axis] += 1.0;
                }
                let nodes = corners.map(|corner| self.node(corner));
                for (a, ga) in nodes.iter().zip(gradients).filter_map(|(node, g)| Some(((*node)?, g))) {
                    for (b, gb) in nodes.iter().zip(gradients).filter_map(|(node, g)| Some(((*node)?, g))) {
                        let product: f64 = (0..3).map(|k| ga[k] * gb[k]).sum();
                        for (i, j) in (0..9).map(|k| (k % 3, k / 3)).filter(|(i, j)| 3 * a + i >= 3 * b + j) {
                            let shear = ga[j] * gb[i] + if i == j { product } else { 0.0 };
                            let value = (LAME[0] * ga[i] * gb[j] + LAME[1] * shear) / 6.0;
                            *columns[3 * b + j].entry((3 * a + i) as u32).or_insert(0.0) += value;
                        }
                    }
                }
            }
        }
        let mut matrix = SymmetricCsc { starts: vec![0], rows: vec![], values: vec![] };
        for column in columns {
            matrix.rows.extend(column.keys());
            matrix.values.extend(column.values());
            matrix.starts.push(matrix.rows.len() as u32);
        }
        matrix
    }

    /// The unknowns in the order of elimination, and its tree: boxes of nodes are cut at the middle plane across their longest side.
    pub(crate) fn dissection(self) -> (Vec<usize>, Vec<Front>) {
        let (mut order, mut fronts) = (vec![], vec![]);
        let level = 0..self.cells + 1;
        self.cut([level.clone(), level.clone(), 1..level.end], &mut order, &mut fronts);
        (order, fronts)
    }

    /// Appends the unknowns and fronts of a box of nodes; returns the number of its last front.
    fn cut(self, part: [Range<usize>; 3], order: &mut Vec<usize>, fronts: &mut Vec<Front>) -> u32 {
        let nodes: usize = part.iter().map(Range::len).product();
        let axis = (0..3).max_by_key(|&axis| part[axis].len()).unwrap();
        let (mut own, mut children) = (part.clone(), vec![]);
        if nodes > LEAF && part[axis].len() > 2 {
            let Range { start, end } = part[axis];
            let middle = (start + end) / 2;
            for half in [start..middle, middle + 1..end] {
                let mut half_box = part.clone();
                half_box[axis] = half;
                children.push(self.cut(half_box, order, fronts));
            }
            own[axis] = middle..middle + 1;
        }
        let first = order.len() as u32;
        for (z, y) in own[2].clone().flat_map(|z| own[1].clone().map(move |y| (z, y))) {
            let nodes = own[0].clone().filter_map(|x| self.node([x, y, z]));
            order.extend(nodes.flat_map(|node| (0..3).map(move |c| 3 * node + c)));
        }
        children.iter().for_each(|&child| fronts[child as usize].parent = fronts.len() as u32);
        fronts.push(Front { columns: first..order.len() as u32, parent: ROOT });
        fronts.len() as u32 - 1
    }
}

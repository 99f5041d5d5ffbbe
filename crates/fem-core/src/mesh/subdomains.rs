//! Cuts a mesh into subdomains: recursive bisection by coordinates, then repair. A subdomain is connected through facets: a cell that hangs by an
//! edge or a node would be a mechanism.

use super::Mesh;
use super::topology::NONE;
use crate::partition::Partition;
use crate::space::Space;

/// Rounds of repair. What is still apart then is a subdomain of its own.
const ROUNDS: usize = 20;

impl<S: Space> Mesh<S> {
    /// Cuts the mesh into subdomains of nearly equal numbers of cells, each connected through facets. There are more than `count` if the mesh has
    /// pieces, and fewer if it has fewer cells.
    ///
    /// Returns the cells of each, ascending. The result depends on the mesh alone.
    pub fn subdomains(&self, count: usize) -> Vec<Vec<u32>> {
        let centres: Vec<S::Vector> =
            (0..self.cells().len()).map(|t| self.corners(t).into_iter().sum::<S::Vector>()).collect();
        let mut subdomain_of = vec![0; centres.len()];
        let mut cells: Vec<u32> = (0..centres.len() as u32).collect();
        bisect::<S>(&centres, &mut cells, (0, count.clamp(1, centres.len().max(1))), &mut subdomain_of);
        let mut apart = Vec::new();
        for _ in 0..ROUNDS {
            apart = self.loose_parts(&subdomain_of);
            let moved = apart.iter().filter(|part| self.move_part(part, &mut subdomain_of)).count();
            if moved == 0 {
                break;
            }
        }
        let mut next = count;
        for part in apart {
            part.iter().for_each(|cell| subdomain_of[*cell as usize] = next);
            next += 1;
        }
        let mut found = vec![Vec::new(); next.max(1)];
        for (cell, subdomain) in subdomain_of.into_iter().enumerate() {
            found[subdomain].push(cell as u32);
        }
        found.retain(|cells| !cells.is_empty());
        found
    }

    /// Lists the cells of each part of a subdomain that no facet joins to its largest part, small ones first.
    fn loose_parts(&self, subdomain_of: &[usize]) -> Vec<Vec<u32>> {
        let mut sets = Partition::new(subdomain_of.len());
        for [a, b] in self.topology().facet_cells() {
            if *b != NONE && subdomain_of[*a as usize] == subdomain_of[*b as usize] {
                sets.join(*a as usize, *b as usize);
            }
        }
        let mut parts: Vec<Vec<u32>> = vec![Vec::new(); subdomain_of.len()];
        (0..subdomain_of.len()).for_each(|cell| parts[sets.first(cell)].push(cell as u32));
        parts.retain(|cells| !cells.is_empty());
        let subdomain = |part: &Vec<u32>| subdomain_of[part[0] as usize];
        // Largest first in each subdomain; of equal ones the one with the first cell.
        parts.sort_by_key(|part| (subdomain(part), usize::MAX - part.len(), part[0]));
        let mut loose: Vec<Vec<u32>> =
            parts.chunk_by(|a, b| subdomain(a) == subdomain(b)).flat_map(|own| own[1..].to_vec()).collect();
        loose.sort_by_key(|part| (part.len(), part[0]));
        loose
    }

    /// Moves a part to the neighbour with which it has most facets in common; `false` if it has no neighbour.
    fn move_part(&self, part: &[u32], subdomain_of: &mut [usize]) -> bool {
        let own = subdomain_of[part[0] as usize];
        let mut met: Vec<usize> = Vec::new();
        for cell in part {
            for facet in self.topology().cell_facets()[*cell as usize] {
                let neighbours = self.topology().facet_cells()[facet].into_iter();
                met.extend(neighbours.filter(|t| *t != NONE).map(|t| subdomain_of[t as usize]));
            }
        }
        met.retain(|subdomain| *subdomain != own);
        met.sort_unstable();
        let most = met.chunk_by(|a, b| a == b).max_by_key(|same| (same.len(), usize::MAX - same[0]));
        let Some(to) = most.map(|same| same[0]) else { return false };
        part.iter().for_each(|cell| subdomain_of[*cell as usize] = to);
        true
    }
}

/// Cuts cells across the longest side of their centres, until each part is one subdomain.
///
/// * `first`, `count`: the number of the first subdomain, and how many they become.
fn bisect<S: Space>(
    centres: &[S::Vector],
    cells: &mut [u32],
    (first, count): (usize, usize),
    subdomain_of: &mut [usize],
) {
    if count <= 1 || cells.len() <= 1 {
        cells.iter().for_each(|cell| subdomain_of[*cell as usize] = first);
        return;
    }
    let at = |cell: u32| centres[cell as usize];
    let (mut low, mut high) = (at(cells[0]), at(cells[0]));
    for cell in cells.iter() {
        for c in 0..S::DIM {
            low[c] = low[c].min(at(*cell)[c]);
            high[c] = high[c].max(at(*cell)[c]);
        }
    }
    let axis =
        (1..S::DIM).fold(0, |axis, c| if high[c] - low[c] > high[axis] - low[axis] { c } else { axis });
    let left = count / 2;
    let middle = (cells.len() * left / count).clamp(1, cells.len() - 1);
    // Cells in one column of a grid have the same coordinate: the others decide.
    let order = |a: &u32, b: &u32| {
        let along = |k: usize| at(*a)[(axis + k) % S::DIM].total_cmp(&at(*b)[(axis + k) % S::DIM]);
        (1..S::DIM).fold(along(0), |order, k| order.then_with(|| along(k))).then(a.cmp(b))
    };
    cells.select_nth_unstable_by(middle, order);
    let (a, b) = cells.split_at_mut(middle);
    bisect::<S>(centres, a, (first, left), subdomain_of);
    bisect::<S>(centres, b, (first + left, count - left), subdomain_of);
}

#[cfg(test)]
mod tests {
    use crate::geometry::Vector;
    use crate::mesh::generate::{block, cuboid};
    use crate::mesh::topology::NONE;
    use crate::mesh::{Mesh, TriMesh};
    use crate::partition::Partition;
    use crate::space::Space;

    /// Checks that every cell is in one subdomain and that each is connected through facets.
    fn check<S: Space>(mesh: &Mesh<S>, count: usize) -> Vec<usize> {
        let found = mesh.subdomains(count);
        let mut all: Vec<u32> = found.concat();
        all.sort_unstable();
        assert_eq!(all, (0..mesh.cells().len() as u32).collect::<Vec<_>>());
        for cells in &found {
            let mut sets = Partition::new(mesh.cells().len());
            for [a, b] in mesh.topology().facet_cells() {
                if *b != NONE && [a, b].iter().all(|t| cells.binary_search(t).is_ok()) {
                    sets.join(*a as usize, *b as usize);
                }
            }
            let first = sets.first(cells[0] as usize);
            assert!(cells.iter().all(|cell| sets.first(*cell as usize) == first));
        }
        found.iter().map(Vec::len).collect()
    }

    #[test]
    fn subdomains_are_connected_and_nearly_equal() {
        let plane = block([0.0, 0.0], [2.0, 1.0], [30, 17]).unwrap();
        for count in [1, 2, 3, 8, 31, 1020, 5000] {
            let sizes = check(&plane, count);
            assert!(sizes.len() <= count.min(1020));
            let mean = 1020.0 / sizes.len() as f64;
            assert!(count > 31 || sizes.iter().all(|n| (*n as f64 - mean).abs() < 0.5 * mean), "{sizes:?}");
        }
        let solid = cuboid([0.0; 3], [1.0, 1.0, 1.0], [6, 7, 5]).unwrap();
        for count in [2, 8, 27, 64] {
            let sizes = check(&solid, count);
            assert_eq!(sizes.len(), count);
        }
    }

    #[test]
    fn pieces_apart_are_subdomains_of_their_own() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [9.0, 0.0], [10.0, 0.0], [9.0, 1.0]];
        let points = points.map(|[x, y]| Vector::new(x, y)).to_vec();
        let mesh = TriMesh::new(points, vec![[0u32, 1, 2], [1, 3, 2], [4, 5, 6]], Vec::new()).unwrap();
        assert_eq!(check(&mesh, 1), [2, 1]);
        // The bisection parts the two cells that are joined.
        assert_eq!(check(&mesh, 2), [1, 1, 1]);
    }
}

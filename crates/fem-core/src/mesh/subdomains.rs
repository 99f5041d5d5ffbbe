//! Cuts a mesh into subdomains: recursive bisection by coordinates, through few facets, then repair. A subdomain is connected through facets: a cell that
//! hangs by an edge or a node would be a mechanism.

use super::Mesh;
use super::id::NodeId;
use super::topology::NONE;
use crate::partition::Partition;
use crate::space::Space;

/// Rounds of repair. What is still apart then is a subdomain of its own.
const ROUNDS: usize = 20;

/// Rounds in which cells go to the subdomain with which they have most facets in common.
const SMOOTHING: usize = 3;

/// A bisection may be off the middle by one part of this many: the layers of a regular mesh are not cut through.
const OFF_THE_MIDDLE: usize = 12;

/// So far off it must meet fewer facets by this fraction.
const PENALTY: f64 = 0.5;

impl<S: Space> Mesh<S> {
    /// Cuts the mesh into subdomains of nearly equal numbers of cells, each connected through facets. There are more than `count` if the mesh has
    /// pieces, and fewer if it has few cells.
    ///
    /// Returns the cells of each, ascending. The result depends on the mesh alone.
    pub fn subdomains(&self, count: usize) -> Vec<Vec<u32>> {
        let centres: Vec<S::Vector> =
            (0..self.cells().len()).map(|t| self.corners(t).into_iter().sum::<S::Vector>()).collect();
        let mut subdomain_of = vec![0; centres.len()];
        let mut cells: Vec<u32> = (0..centres.len() as u32).collect();
        self.bisect(&centres, &mut cells, (0, count.clamp(1, centres.len().max(1))), &mut subdomain_of);
        for _ in 0..SMOOTHING {
            self.smooth(&mut subdomain_of);
        }
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

    /// Counts the nodes of each subdomain, and those that it shares with others.
    ///
    /// * `count`: see [`Self::subdomains`].
    pub fn shared_nodes(&self, count: usize) -> Vec<(usize, usize)> {
        let nodes: Vec<Vec<NodeId>> =
            self.subdomains(count).iter().map(|cells| self.nodes_of(cells)).collect();
        let mut uses = vec![0u32; self.points().len()];
        nodes.iter().flatten().for_each(|node| uses[*node] += 1);
        let shared = |own: &Vec<NodeId>| own.iter().filter(|node| uses[**node] > 1).count();
        nodes.iter().map(|own| (own.len(), shared(own))).collect()
    }

    /// Lists the nodes of some cells, ascending.
    pub(crate) fn nodes_of(&self, cells: &[u32]) -> Vec<NodeId> {
        let mut nodes: Vec<NodeId> = cells.iter().flat_map(|t| self.cells()[*t as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
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

    /// Cuts cells across the longest side of their centres, until each part is one subdomain: near the middle, through few facets.
    ///
    /// * `first`, `count`: the number of the first subdomain, and how many they become; `subdomain_of`: is `first` of these cells, and of no others.
    fn bisect(
        &self,
        centres: &[S::Vector],
        cells: &mut [u32],
        (first, count): (usize, usize),
        subdomain_of: &mut [usize],
    ) {
        if count <= 1 || cells.len() <= 1 {
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
        // Cells in one column of a grid have the same coordinate: the others decide.
        let order = |a: &u32, b: &u32| {
            let along = |k: usize| at(*a)[(axis + k) % S::DIM].total_cmp(&at(*b)[(axis + k) % S::DIM]);
            (1..S::DIM).fold(along(0), |order, k| order.then_with(|| along(k))).then(a.cmp(b))
        };
        let (left, last) = (count / 2, cells.len() - 1);
        let middle = (cells.len() * left / count).clamp(1, last);
        let off = cells.len() / OFF_THE_MIDDLE;
        let (start, end) = (middle.saturating_sub(off).max(1), (middle + off).min(last));
        cells.select_nth_unstable_by(start, order);
        let (_, rest) = cells.split_at_mut(start);
        if end > start {
            rest.select_nth_unstable_by(end - start, order);
            rest[..end - start].sort_unstable_by(order);
        }
        rest.iter().for_each(|cell| subdomain_of[*cell as usize] = first + left);
        let between =
            |cell: &u32, of: &[usize]| self.neighbours(*cell).filter(|other| of[*other] == first).count();
        let mut facets: usize = rest.iter().map(|cell| between(cell, subdomain_of)).sum();
        let cost = |facets: usize, place: usize| {
            facets as f64 * (1.0 + PENALTY * place.abs_diff(middle) as f64 / off.max(1) as f64)
        };
        let mut best = (cost(facets, start), start);
        // One cell after the other goes to the first part.
        for (place, cell) in (start..end).zip(&*rest) {
            let second = self.neighbours(*cell).filter(|other| subdomain_of[*other] == first + left).count();
            facets = facets + second - between(cell, subdomain_of);
            subdomain_of[*cell as usize] = first;
            let found = cost(facets, place + 1);
            if found < best.0 {
                best = (found, place + 1);
            }
        }
        let (a, b) = cells.split_at_mut(best.1);
        b.iter().for_each(|cell| subdomain_of[*cell as usize] = first + left);
        self.bisect(centres, a, (first, left), subdomain_of);
        self.bisect(centres, b, (first + left, count - left), subdomain_of);
    }

    /// Returns the cells that have a facet in common with a cell.
    fn neighbours(&self, cell: u32) -> impl Iterator<Item = usize> + '_ {
        let facets = self.topology().cell_facets()[cell as usize].into_iter();
        let both = facets.flat_map(|facet| self.topology().facet_cells()[facet]);
        both.filter(move |other| *other != NONE && *other != cell).map(|other| other as usize)
    }

    /// Moves cells that have more facets in common with another subdomain than with their own.
    fn smooth(&self, subdomain_of: &mut [usize]) {
        for cell in 0..subdomain_of.len() {
            let mut met: Vec<usize> = self.neighbours(cell as u32).map(|other| subdomain_of[other]).collect();
            met.sort_unstable();
            let own = met.iter().filter(|of| **of == subdomain_of[cell]).count();
            let most = met.chunk_by(|a, b| a == b).max_by_key(|same| (same.len(), usize::MAX - same[0]));
            if let Some(most) = most.filter(|same| same.len() > own) {
                subdomain_of[cell] = most[0];
            }
        }
    }

    /// Moves a part to the neighbour with which it has most facets in common; `false` if it has no neighbour.
    fn move_part(&self, part: &[u32], subdomain_of: &mut [usize]) -> bool {
        let own = subdomain_of[part[0] as usize];
        let neighbours = part.iter().flat_map(|cell| self.neighbours(*cell));
        let mut met: Vec<usize> = neighbours.map(|other| subdomain_of[other]).collect();
        met.retain(|subdomain| *subdomain != own);
        met.sort_unstable();
        let most = met.chunk_by(|a, b| a == b).max_by_key(|same| (same.len(), usize::MAX - same[0]));
        let Some(to) = most.map(|same| same[0]) else { return false };
        part.iter().for_each(|cell| subdomain_of[*cell as usize] = to);
        true
    }
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
    fn layers_of_a_regular_mesh_are_not_cut_through() {
        // 15 cells along each edge are halved into 7 and 8.
        let mesh = cuboid([0.0; 3], [1.0, 1.0, 1.0], [15, 15, 15]).unwrap();
        let mut sizes = check(&mesh, 8);
        sizes.sort_unstable();
        let cells = |sides: [usize; 3]| 6 * sides.iter().product::<usize>();
        let [a, b, c, d] = [[7, 7, 7], [7, 7, 8], [7, 8, 8], [8, 8, 8]].map(cells);
        assert_eq!(sizes, [a, b, b, b, c, c, c, d]);
        assert_eq!(
            mesh.shared_nodes(8).into_iter().map(|(_, count)| count).max(),
            Some(9 * 9 * 9 - 8 * 8 * 8)
        );
    }

    #[test]
    fn pieces_apart_are_subdomains_of_their_own() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [9.0, 0.0], [10.0, 0.0], [9.0, 1.0]];
        let points = points.map(|[x, y]| Vector::new(x, y)).to_vec();
        let mesh = TriMesh::new(points, vec![[0u32, 1, 2], [1, 3, 2], [4, 5, 6]], Vec::new()).unwrap();
        assert_eq!(check(&mesh, 1), [2, 1]);
        // The bisection parts the two cells that are joined, and the smoothing joins them again.
        assert_eq!(check(&mesh, 2), [2, 1]);
    }
}

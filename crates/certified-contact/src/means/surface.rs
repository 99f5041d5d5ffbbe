//! Pairs of nodes on a contact surface that are near each other.
//!
//! ```math
//! K_ki = w_k max(0, 1 − |x_k − x_i| / h_ki) w_i,   h_ki = ½ (h_k + h_i)
//! ```
//! with the size `h` of the coarser side's faces, `h² = 2/√3 A`: the edge length of equilateral triangles with as much area `A` for each node. Each own node
//! of a side has the area of the pairs that are nearer to it than to other own nodes, along edges. Pairs beside which no node was put in keep their
//! pressure.

use super::{Near, recover as recover_from};
use fem_core::geometry::norm;
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem};
use fem_core::space::Solid;
use nalgebra::Vector3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The area of a pair of equilateral triangles over the square of their edges.
const RHOMBUS: f64 = 0.866_025_403_784_438_6;

/// The pairs that faces join with each pair, and their places.
struct Graph {
    joined: Vec<Vec<u32>>,
    places: Vec<Vector3<f64>>,
}

/// Recovers the pressure at the pairs of a contact surface.
///
/// * `own`: of each side, the pairs whose node was not put in; `pressure`: `P_i/A_i`, replaced.
pub(crate) fn recover(
    (problem, pair): (&ContactProblem<Solid>, &ContactPair<Solid>),
    own: &[Vec<bool>; 2],
    forces: &[f64],
    pressure: &mut [f64],
) {
    let pairs = pair.interface.pairs();
    let points = problem.bodies[pair.body].mesh().points();
    let graph = Graph::new(&pair.interface, pairs.iter().map(|pair| points[pair.nodes[0]]).collect());
    let areas: Vec<f64> = pairs.iter().map(|pair| pair.weight).collect();
    let near = graph.near(&graph.sizes(own, &areas));
    pressure.copy_from_slice(&recover_from(&near, &areas, forces));
}

impl Graph {
    fn new(interface: &ContactInterface<Solid>, places: Vec<Vector3<f64>>) -> Self {
        let mut joined = vec![Vec::new(); places.len()];
        for face in interface.facets() {
            let corners = || face.free_corners().map(|corner| face.pairs[corner]);
            for i in corners() {
                joined[i as usize].extend(corners().filter(|j| *j != i));
            }
        }
        for near in &mut joined {
            near.sort_unstable();
            near.dedup();
        }
        Self { joined, places }
    }

    fn distance(&self, i: usize, j: u32) -> f64 {
        norm(self.places[i] - self.places[j as usize])
    }

    /// Computes the size of the coarser side's faces at each pair, m; zero if no node was put in there or beside it.
    fn sizes(&self, own: &[Vec<bool>; 2], areas: &[f64]) -> Vec<f64> {
        let matches = |k: usize| own[0][k] && own[1][k];
        let is_cut = |k: usize| !matches(k) || self.joined[k].iter().any(|j| !matches(*j as usize));
        let of_sides = own.each_ref().map(|own| self.areas_of_own(own, areas));
        let size = |k: usize| (of_sides[0][k].max(of_sides[1][k]) / RHOMBUS).sqrt();
        (0..areas.len()).map(|k| if is_cut(k) { size(k) } else { 0.0 }).collect()
    }

    /// Adds up the area of the own node that is nearest to each pair; pairs that no own node reaches share theirs.
    fn areas_of_own(&self, own: &[bool], areas: &[f64]) -> Vec<f64> {
        let mut nearest = vec![None; own.len()];
        // Distances are not negative: their bits have their order.
        let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> =
            (0..own.len() as u32).filter(|k| own[*k as usize]).map(|k| Reverse((0, k, k))).collect();
        while let Some(Reverse((bits, k, from))) = queue.pop() {
            let place = k as usize;
            if nearest[place].is_some() {
                continue;
            }
            nearest[place] = Some(from as usize);
            for j in self.joined[place].iter().filter(|j| nearest[**j as usize].is_none()) {
                queue.push(Reverse(((f64::from_bits(bits) + self.distance(place, *j)).to_bits(), *j, from)));
            }
        }
        let (mut sums, mut left) = (vec![0.0; own.len()], 0.0);
        for (from, area) in nearest.iter().zip(areas) {
            from.map_or_else(|| left += area, |from: usize| sums[from] += area);
        }
        nearest.into_iter().map(|from| from.map_or(left, |from| sums[from])).collect()
    }

    /// Lists the pairs of different nodes with a positive factor, each once: those that a path of such nodes joins.
    fn near(&self, sizes: &[f64]) -> Vec<Near> {
        let mut found = Vec::new();
        let mut seen = vec![u32::MAX; sizes.len()];
        let mut path = Vec::new();
        for i in (0..sizes.len()).filter(|i| sizes[*i] > 0.0) {
            seen[i] = i as u32;
            path.push(i as u32);
            while let Some(k) = path.pop() {
                for j in &self.joined[k as usize] {
                    let place = *j as usize;
                    let factor = 1.0 - self.distance(i, *j) / (0.5 * (sizes[i] + sizes[place]));
                    if seen[place] == i as u32 || sizes[place] == 0.0 || factor <= 0.0 {
                        continue;
                    }
                    seen[place] = i as u32;
                    path.push(*j);
                    if place > i {
                        found.push(Near { places: [i as u32, *j], factor });
                    }
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `n` by `n` pairs with a distance of 1, each joined with its neighbours along the axes and one diagonal, and their areas.
    fn square(n: usize) -> (Graph, Vec<f64>) {
        let at = |k: usize| [(k % n) as i64, (k / n) as i64];
        let is_joined = |k: usize, j: usize| {
            let [dx, dy] = [0, 1].map(|axis| at(j)[axis] - at(k)[axis]);
            [[1, 0], [0, 1], [1, 1]].iter().any(|[x, y]| [dx, dy] == [*x, *y] || [-dx, -dy] == [*x, *y])
        };
        let joined = |k: usize| (0..n * n).filter(|j| is_joined(k, *j)).map(|j| j as u32).collect::<Vec<_>>();
        let area = |k: usize| at(k).map(|x| if x % (n as i64 - 1) == 0 { 0.5 } else { 1.0 }).iter().product();
        let places = (0..n * n).map(|k| Vector3::new(at(k)[0] as f64, at(k)[1] as f64, 0.0)).collect();
        let graph = Graph { joined: (0..n * n).map(joined).collect(), places };
        (graph, (0..n * n).map(area).collect())
    }

    /// The second side has each second pair of the left half along both axes, and all pairs of the right one.
    fn own(n: usize) -> [Vec<bool>; 2] {
        let second = |k: usize| 2 * (k % n) >= n || ((k % n) % 2, (k / n) % 2) == (0, 0);
        [vec![true; n * n], (0..n * n).map(second).collect()]
    }

    fn recovered(n: usize, force: impl Fn(usize, f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let (graph, areas) = square(n);
        let forces: Vec<f64> = areas.iter().enumerate().map(|(k, area)| force(k, *area)).collect();
        (recover_from(&graph.near(&graph.sizes(&own(n), &areas)), &areas, &forces), areas)
    }

    #[test]
    fn a_constant_pressure_remains_and_no_force_is_lost() {
        for p in recovered(9, |_, area| 3.0 * area).0 {
            assert!((p - 3.0).abs() < 1e-12, "{p}");
        }
        let force = |k: usize, _| (k * k % 37) as f64;
        let (found, areas) = recovered(9, force);
        let sum: f64 = found.iter().zip(&areas).map(|(p, area)| p * area).sum();
        let expected: f64 = (0..81).map(|k| force(k, 1.0)).sum();
        assert!((sum - expected).abs() < 1e-12 * expected, "{sum} {expected}");
    }

    #[test]
    fn oscillations_go_where_nodes_were_put_in_and_pressures_stay_where_all_match() {
        let force = |k: usize, area: f64| area * (10.0 + [4.0, -4.0][(k % 9 + k / 9) % 2]);
        let (found, areas) = recovered(9, force);
        for k in 0..81 {
            let (x, y) = (k % 9, k / 9);
            if x >= 6 {
                assert!((found[k] - force(k, 1.0)).abs() < 1e-12, "{x} {y} {}", found[k]);
            } else if (1..4).contains(&x) && (1..8).contains(&y) {
                assert!((found[k] - 10.0).abs() < 1.5, "{x} {y} {}", found[k]);
            }
        }
        assert_eq!(areas[0], 0.25);
    }

    #[test]
    fn faces_without_any_own_node_share_one_size() {
        let (graph, areas) = square(5);
        let none = vec![false; 25];
        assert_eq!(graph.areas_of_own(&none, &areas), vec![16.0; 25]);
        let mut one = none;
        one[12] = true;
        assert_eq!(graph.areas_of_own(&one, &areas), vec![16.0; 25]);
    }
}

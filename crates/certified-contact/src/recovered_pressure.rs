//! The pressure along a contact line whose nodes did not match.
//!
//! A node that the common refinement puts into an edge of a body cuts cells there; the mesh behind it is as coarse as before. The nodal
//! forces `P_i` oscillate from such a node to the next, and so does `P_i/ℓ_i`. Their mean over the cells of the coarser side does not:
//! ```math
//! m_k = ∑_i K_ki P_i,   K_ki = w_k max(0, 1 − |x_k − x_i|) w_i,   x(s) = ∫ ds/h
//! ```
//! with the length `h` of the uncut edge of the coarser side at `s`: `x` counts its edges. The weights `w` are such that forces `P_i = ℓ_i`
//! give a mean of 1; then `Σ m_k ℓ_k = Σ P_i` as well. If the nodes of both sides match at a place, it is `P_i/ℓ_i` there. At the end of a line an
//! edge that continues beyond it counts as cut.
//!
//! Nodes of later refinements are ends of uncut edges, so that the mean becomes as local as the mesh; a node of the common refinement still counts as a
//! cut then, since the forces beside it still oscillate. On a mesh on which contact is narrower than such an edge, the mean is far below the largest nodal pressure.
//!
//! Averaging smears the ends of the contact zone: open nodes get a force, and their neighbours in contact lose it. A second mean shows how much:
//! it would carry `ℓ_k K_ki ℓ_i (m_k − m_i)` from a node `k` in contact to an open node `i` with `m_i < m_k`. As much flows back, but no more
//! than node `i` has:
//! ```math
//! p_k = m_k + ∑_{i open} t_i K_ki ℓ_i (m_k − m_i)
//! p_i = m_i − t_i ∑_{k in contact} K_ki ℓ_k (m_k − m_i)
//! ```
//! with the largest `t_i ≤ 1` for which `p_i ≥ 0`. So `Σ p_k ℓ_k = Σ P_i`, and no pressure is negative. Between nodes that are all in contact a second mean
//! of this kind only brings the oscillation back: there `p = m`.
//!
//! On bisected meshes `P_i/ℓ_i` alternates as well, whether the nodes match or not: neighbouring nodes have different numbers of triangles, and
//! their forces differ by a term of first order in the edge length that changes its sign. The mean of the two ends of an edge has an error of second
//! order. So in the end each node between uncut edges in contact takes the mean of its edges' means, weighted by their lengths, which keeps `Σ p_k ℓ_k`:
//! ```math
//! ℓ_k p_k ← ℓ_k p_k + ∑_{edges k-i} ¼ h_ki (p_i − p_k)
//! ```

use fem_core::interface::{ContactFacet, ContactInterface, ContactProblem};

/// Nodes nearer to the next uncut edge than this, in edges, are at its end.
const ROUND_OFF: f64 = 1e-12;

/// Nodes with at most this part of the largest force are open.
const OPEN: f64 = 1e-9;

/// Weights are found to this precision.
const PRECISION: f64 = 1e-14;

/// Iterations for the weights; 40 are enough for meshes of constant size.
const MAX_ITERATIONS: usize = 200;

/// Computes the pressure that is recovered over the cells of the coarser side of a pair, at its pairs of nodes, Pa. `None` if all nodes
/// matched from the first mesh on, and against an obstacle: it is `P_i/ℓ_i` then.
///
/// * `forces`: normal forces at the pairs of nodes, `|n_i| P_i`, N/m.
///
/// # Panics
/// If there is no such pair, or not one force per pair of nodes.
pub fn recovered_pressure(problem: &ContactProblem, pair: usize, forces: &[f64]) -> Option<Vec<f64>> {
    let of = &problem.contacts[pair];
    let pairs = of.interface.pairs();
    assert!(forces.len() == pairs.len(), "{} forces, and {} pairs of nodes", forces.len(), pairs.len());
    let bodies = of.bodies()?;
    let own = [0, 1].map(|side: usize| -> Vec<bool> {
        let body = &problem.bodies[bodies[side]];
        pairs.iter().map(|pair| !body.is_inserted(pair.nodes[side])).collect()
    });
    if own.iter().flatten().all(|own| *own) {
        return None;
    }
    let mut pressure: Vec<f64> = pairs.iter().zip(forces).map(|(pair, p)| p / pair.weight).collect();
    for chain in chains(&of.interface, &own[0]).into_iter().filter(|chain| chain.len() > 1) {
        let lengths: Vec<f64> = chain.iter().map(|(k, _)| pairs[*k].weight).collect();
        let forces: Vec<f64> = chain.iter().map(|(k, _)| forces[*k]).collect();
        for ((k, _), p) in chain.iter().zip(recover(&chain, &own, &lengths, &forces)) {
            pressure[*k] = p;
        }
    }
    Some(levelled(&of.interface, &own, forces, pressure))
}

/// Replaces the pressure of each node by the mean of its edges' means; nothing flows to or from nodes without contact, nor along cut edges.
fn levelled(
    interface: &ContactInterface,
    own: &[Vec<bool>; 2],
    forces: &[f64],
    mut pressure: Vec<f64>,
) -> Vec<f64> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let takes_part = |k: &u32| {
        let k = *k as usize;
        forces[k] > OPEN * largest && own[0][k] && own[1][k]
    };
    let between = |edge: &&ContactFacet| is_free(edge) && edge.pairs.iter().all(takes_part);
    let flow = |edge: &ContactFacet| {
        let [p, q] = edge.pairs.map(|k| pressure[k as usize]);
        (edge.pairs, 0.25 * edge.measure * (q - p))
    };
    let flows: Vec<([u32; 2], f64)> = interface.facets().iter().filter(between).map(flow).collect();
    for ([i, j], force) in flows {
        let [i, j] = [i, j].map(|k| k as usize);
        pressure[i] += force / interface.pairs()[i].weight;
        pressure[j] -= force / interface.pairs()[j].weight;
    }
    pressure
}

/// Recovers the pressure at the pairs of a run.
///
/// * `lengths`, `forces`: at the pairs, in their order along the run.
fn recover(chain: &Chain, own: &[Vec<bool>; 2], lengths: &[f64], forces: &[f64]) -> Vec<f64> {
    let closed = chain[0].0 == chain[chain.len() - 1].0;
    let near = neighbours(chain, closed, own);
    let weights = weights(&near, &lengths[..chain.len() - usize::from(closed)]);
    let weighted: Vec<f64> = weights.iter().zip(forces).map(|(w, force)| w * force).collect();
    let mean: Vec<f64> = weights.iter().zip(sums(&near, &weighted)).map(|(w, sum)| w * sum).collect();
    let returned = returned(&near, &weights, lengths, forces, &mean);
    // An open node that gives back all that it has keeps round-off.
    mean.iter().zip(returned).map(|(mean, returned)| (mean + returned).max(0.0)).collect()
}

/// Computes the force that flows back from open nodes to nodes in contact, by length, Pa.
fn returned(near: &[Near], weights: &[f64], lengths: &[f64], forces: &[f64], mean: &[f64]) -> Vec<f64> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let open: Vec<bool> = forces.iter().map(|force| *force <= OPEN * largest).collect();
    // Node in contact, open node, and the force between them.
    let flows: Vec<(usize, usize, f64)> = near
        .iter()
        .filter_map(|Near { places, factor }| {
            let [i, j] = places.map(|place| place as usize);
            let (k, i) = if open[j] { (i, j) } else { (j, i) };
            let force = lengths[k] * weights[k] * factor * weights[i] * lengths[i] * (mean[k] - mean[i]);
            (open[i] && !open[k] && force > 0.0).then_some((k, i, force))
        })
        .collect();
    let mut leaving = vec![0.0; mean.len()];
    for (_, i, force) in &flows {
        leaving[*i] += force;
    }
    let mut returned = vec![0.0; mean.len()];
    for (k, i, force) in flows {
        let has = mean[i] * lengths[i];
        let force = if leaving[i] > has { force * (has / leaving[i]) } else { force };
        returned[k] += force / lengths[k];
        returned[i] -= force / lengths[i];
    }
    returned
}

/// A run of pairs joined by edges, with their arc lengths; a closed one ends with its first pair.
type Chain = [(usize, f64)];

/// Tells whether both ends of an edge have unknowns.
fn is_free(edge: &&ContactFacet) -> bool {
    edge.clamped == [None; 2]
}

/// Lists the runs of a contact line, from an own node on if it is closed.
fn chains(interface: &ContactInterface, own: &[bool]) -> Vec<Box<Chain>> {
    let count = interface.pairs().len();
    let mut next = vec![None; count];
    let mut has_previous = vec![false; count];
    for edge in interface.facets().iter().filter(is_free) {
        let [i, j] = edge.pairs.map(|k| k as usize);
        next[i] = Some((j, edge.measure));
        has_previous[j] = true;
    }
    let mut seen = vec![false; count];
    let starts = (0..count).filter(|k| !has_previous[*k]);
    // Closed lines have no start of their own.
    let starts = starts.chain((0..count).filter(|k| own[*k]));
    let mut found = Vec::new();
    for start in starts {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut chain = vec![(start, 0.0)];
        let (mut last, mut s) = (start, 0.0);
        while let Some((pair, length)) = next[last] {
            s += length;
            chain.push((pair, s));
            if std::mem::replace(&mut seen[pair], true) {
                break;
            }
            last = pair;
        }
        found.push(chain.into());
    }
    found
}

/// Pairs of nodes of a run that are less than an edge apart, and their factor `1 − |x_k − x_i|`.
struct Near {
    places: [u32; 2],
    factor: f64,
}

/// Lists the pairs of different nodes with a positive factor.
fn neighbours(chain: &Chain, closed: bool, own: &[Vec<bool>; 2]) -> Vec<Near> {
    let x = edges_before(chain, closed, own);
    let total = x[chain.len() - 1];
    let count = chain.len() - usize::from(closed);
    let mut found = Vec::new();
    for i in 0..count {
        for step in 1..count {
            let j = (i + step) % count;
            let around = j < i;
            let distance = x[j] - x[i] + if around { total } else { 0.0 };
            // On a closed line the other way may be shorter: then the pair is found from the other node.
            if around && !closed || distance >= 1.0 - ROUND_OFF || closed && 2.0 * distance > total {
                break;
            }
            found.push(Near { places: [i as u32, j as u32], factor: 1.0 - distance });
        }
    }
    found
}

/// Computes `x` at the nodes of a run: the number of uncut edges before it, of the side on which they are longer.
fn edges_before(chain: &Chain, closed: bool, own: &[Vec<bool>; 2]) -> Vec<f64> {
    let last = chain.len() - 1;
    // A closed line continues behind its end.
    let arc = |i: usize| if i > last { chain[last].1 + chain[i - last].1 } else { chain[i].1 };
    let mut uncut = vec![0.0_f64; last];
    for own in own {
        let is_end = |i: usize| own[chain[i].0] || !closed && (i == 0 || i == last);
        let mut ends: Vec<usize> = (0..last + usize::from(!closed)).filter(|i| is_end(*i)).collect();
        if closed && let Some(first) = ends.first().copied() {
            ends.push(first + last);
        }
        for edge in ends.windows(2) {
            let length = arc(edge[1]) - arc(edge[0]);
            (edge[0]..edge[1]).for_each(|i| uncut[i % last] = uncut[i % last].max(length));
        }
    }
    let mut x = vec![0.0; last + 1];
    for i in 0..last {
        x[i + 1] = x[i] + (chain[i + 1].1 - chain[i].1) / uncut[i];
    }
    x
}

/// Computes `Σ_i K_ki x_i`.
fn sums(near: &[Near], x: &[f64]) -> Vec<f64> {
    let mut sums = x.to_vec();
    for Near { places, factor } in near {
        let [i, j] = places.map(|place| place as usize);
        sums[i] += factor * x[j];
        sums[j] += factor * x[i];
    }
    sums
}

/// Finds the weights with `w_k Σ_i K_ki w_i ℓ_i = 1`, by the iteration of Sinkhorn and Knopp in its symmetric form (Knight, Ruiz and Ucar 2014).
fn weights(near: &[Near], lengths: &[f64]) -> Vec<f64> {
    let mut weights = vec![1.0; lengths.len()];
    for _ in 0..MAX_ITERATIONS {
        let weighted: Vec<f64> = weights.iter().zip(lengths).map(|(w, l)| w * l).collect();
        let mut largest = 0.0_f64;
        for (w, sum) in weights.iter_mut().zip(sums(near, &weighted)) {
            largest = largest.max((*w * sum - 1.0).abs());
            *w = (*w / sum).sqrt();
        }
        if largest <= PRECISION {
            break;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact_geometry::common_refinement::common_refinement;
    use contact_geometry::{ContactNormal, Refinable};
    use fem_core::body::Body;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::interface::Gap;
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::block;
    use fem_core::space::Plane;

    /// A closed line of eight pairs from pair `first` on; the first side has the even ones, the second one has 0, 3 and 5.
    fn closed(first: usize) -> (Box<Chain>, [Vec<bool>; 2]) {
        let mut s = 0.0;
        let mut chain = Vec::new();
        for k in 0..=8 {
            let pair = (first + k) % 8;
            chain.push((pair, s));
            s += edge(pair);
        }
        (
            chain.into(),
            [(0..8).map(|k| k % 2 == 0).collect(), (0..8).map(|k| [0, 3, 5].contains(&k)).collect()],
        )
    }

    /// The length of the edge from a pair to the next one.
    fn edge(pair: usize) -> f64 {
        1.0 + 0.3 * (pair as f64).sin()
    }

    /// The length that belongs to a pair.
    fn length(pair: usize) -> f64 {
        0.5 * (edge(pair) + edge((pair + 7) % 8))
    }

    /// The pressure by pair.
    fn recovered(first: usize, force: impl Fn(usize) -> f64) -> Vec<f64> {
        let (chain, own) = closed(first);
        let [lengths, forces]: [Vec<f64>; 2] =
            [&length as &dyn Fn(usize) -> f64, &force].map(|of| chain.iter().map(|(k, _)| of(*k)).collect());
        let mut by_pair = vec![0.0; 8];
        for ((k, _), p) in chain.iter().zip(recover(&chain, &own, &lengths, &forces)) {
            by_pair[*k] = p;
        }
        by_pair
    }

    #[test]
    fn a_constant_pressure_remains_and_no_force_is_lost() {
        for p in recovered(0, |k| 3.0 * length(k)) {
            assert!((p - 3.0).abs() < 1e-12, "{p}");
        }
        let force = |k: usize| (k * k) as f64;
        let found = recovered(0, force);
        let sums = (0..8).map(|k| [found[k] * length(k), force(k)]);
        let [sum, expected] = sums.fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
        assert!((sum - expected).abs() < 1e-12 * expected, "{sum} {expected}");
        // A single force is spread to both sides.
        let spread = recovered(0, |k| f64::from(u8::from(k == 4)));
        assert!(spread[3] > 0.0 && spread[5] > 0.0 && spread[4] < 1.0 / length(4), "{spread:?}");
    }

    #[test]
    fn what_the_mean_carries_to_open_nodes_flows_back() {
        // Eight edges of length 1; the second side has no odd node. Nodes 5 to 8 are open.
        let chain: Vec<(usize, f64)> = (0..9).map(|k| (k, k as f64)).collect();
        let own = [vec![true; 9], (0..9).map(|k| k % 2 == 0).collect()];
        let lengths: Vec<f64> = (0..9).map(|k| if k % 8 == 0 { 0.5 } else { 1.0 }).collect();
        let forces = [0.5, 1.2, 0.8, 1.2, 0.8, 0.0, 0.0, 0.0, 0.0];
        let found = recover(&chain, &own, &lengths, &forces);
        let near = neighbours(&chain, false, &own);
        let weights = weights(&near, &lengths);
        let weighted: Vec<f64> = weights.iter().zip(forces).map(|(w, force)| w * force).collect();
        let mean: Vec<f64> = weights.iter().zip(sums(&near, &weighted)).map(|(w, sum)| w * sum).collect();
        // Node 4 is next to the end of contact, node 5 is open; all others are an edge away from it.
        assert!(found[4] > mean[4] + 0.05 && (0.0..mean[5] - 0.05).contains(&found[5]), "{found:?} {mean:?}");
        for k in [0, 1, 2, 3, 6, 7, 8] {
            assert!((found[k] - mean[k]).abs() < 1e-12, "{k}: {found:?} {mean:?}");
        }
        let sum: f64 = found.iter().zip(&lengths).map(|(p, l)| p * l).sum();
        assert!((sum - forces.iter().sum::<f64>()).abs() < 1e-12, "{sum}");
        // An open node between two high pressures gives back what it has, and no more; one beside a low pressure takes nothing from it.
        for forces in [
            [0.5, 9.0, 0.0, 9.0, 1.0, 1.0, 1.0, 1.0, 0.5],
            [0.5, 1.0, 0.8, 1.2, 0.0, 0.1, 0.0, 0.0, 0.0],
            [0.5, 9.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0],
        ] {
            let found = recover(&chain, &own, &lengths, &forces);
            assert!(found.iter().all(|p| *p >= 0.0), "{found:?}");
            let sum: f64 = found.iter().zip(&lengths).map(|(p, l)| p * l).sum();
            assert!((sum - forces.iter().sum::<f64>()).abs() < 1e-12 * sum, "{sum}");
        }
    }

    #[test]
    fn the_start_of_a_closed_line_does_not_matter() {
        let force = |k: usize| (k * 3 % 7) as f64;
        let expected = recovered(0, force);
        // Both sides have pair 0, only the first one has 2 and 4.
        for first in [2, 4] {
            for (p, expected) in recovered(first, force).iter().zip(&expected) {
                assert!((p - expected).abs() < 1e-12, "{first}: {p} {expected}");
            }
        }
    }

    #[test]
    fn nodes_of_later_refinements_are_ends_of_uncut_edges() {
        let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let part = |y: f64, cells: usize| {
            let mesh = block([0.0, y], [1.0, 1.0], [cells, 3]).unwrap();
            Body::new(mesh, steel.clone(), &BoundaryConditions::new()).unwrap()
        };
        let (surfaces, normal) = (["bottom", "top"], ContactNormal::Averaged);
        let common = common_refinement([part(0.0, 3), part(-1.0, 4)], surfaces, normal).unwrap();
        let gap = Gap::Given(0.0.into());
        let interface = contact_geometry::pair_refined(&common, surfaces, &gap, normal).unwrap();
        let mut problem = ContactProblem::between(common.bodies, interface);
        // The recovered pressure at the only loaded node, over its nodal pressure: no neighbour is in contact.
        let part_left = |problem: &ContactProblem, x: f64| {
            let pairs = problem.contacts[0].interface.pairs();
            let place = |k: usize| problem.bodies[0].mesh().points()[pairs[k].nodes[0]][0];
            let at = (0..pairs.len()).find(|k| (place(*k) - x).abs() < 1e-9).unwrap();
            let forces: Vec<f64> = (0..pairs.len()).map(|k| f64::from(u8::from(k == at))).collect();
            recovered_pressure(problem, 0, &forces).unwrap()[at] * pairs[at].weight
        };
        assert!(part_left(&problem, 0.25) < 0.7);
        let mut edges = Plane::cuts(&problem).unwrap();
        for _ in 0..2 {
            let marked: Vec<Vec<bool>> =
                problem.bodies.iter().map(|body| vec![true; body.mesh().topology().facets().len()]).collect();
            let finer = contact_geometry::refined(&problem, &edges, &marked).unwrap();
            edges = finer.refinements.iter().map(|r| r.refinement_edges.clone()).collect();
            problem = finer.problem;
        }
        // No edge beside 0.125 is cut; 0.25 is still a cut of the first body.
        assert!((part_left(&problem, 0.125) - 1.0).abs() < 1e-12);
        assert!(part_left(&problem, 0.25) < 0.7);
    }

    #[test]
    fn nodes_that_match_keep_their_pressure_on_graded_edges() {
        // Edges of 1, 1, 0.5, 0.25 and 0.125; the second side has no node 1.
        let s = [0.0, 1.0, 2.0, 2.5, 2.75, 2.875];
        let chain: Vec<(usize, f64)> = s.into_iter().enumerate().collect();
        let own = [vec![true; 6], vec![true, false, true, true, true, true]];
        let lengths = [0.5, 1.0, 0.75, 0.375, 0.1875, 0.0625];
        let forces = [1.0, 0.0, 0.0, 3.0, 0.0, 1.0];
        let found = recover(&chain, &own, &lengths, &forces);
        for k in 3..6 {
            assert!((found[k] - forces[k] / lengths[k]).abs() < 1e-12, "{k}: {found:?}");
        }
        assert!(found[0] < 2.0 && found[1] > 0.0, "{found:?}");
    }
}

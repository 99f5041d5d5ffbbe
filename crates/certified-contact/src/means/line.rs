//! Runs of pairs of nodes along a contact line, and their means.

use super::{Near, recover as recover_from};
use fem_core::interface::{ContactFacet, ContactInterface};

/// Nodes nearer to the next uncut edge than this, in edges, are at its end.
const ROUND_OFF: f64 = 1e-12;

/// Recovers the pressure at the pairs of each run of a contact line.
///
/// * `own`: of each side, the pairs whose node was not put in; `pressure`: `P_i/ℓ_i`, replaced.
pub(crate) fn recover(
    interface: &ContactInterface,
    own: &[Vec<bool>; 2],
    forces: &[f64],
    pressure: &mut [f64],
) {
    for chain in chains(interface, &own[0]).into_iter().filter(|chain| chain.len() > 1) {
        let lengths: Vec<f64> = chain.iter().map(|(k, _)| interface.pairs()[*k].weight).collect();
        let forces: Vec<f64> = chain.iter().map(|(k, _)| forces[*k]).collect();
        for ((k, _), p) in chain.iter().zip(recover_run(&chain, own, &lengths, &forces)) {
            pressure[*k] = p;
        }
    }
}

/// Recovers the pressure at the pairs of a run.
///
/// * `lengths`, `forces`: at the pairs, in their order along the run.
fn recover_run(chain: &Chain, own: &[Vec<bool>; 2], lengths: &[f64], forces: &[f64]) -> Vec<f64> {
    let closed = chain[0].0 == chain[chain.len() - 1].0;
    let count = chain.len() - usize::from(closed);
    recover_from(&neighbours(chain, closed, own), &lengths[..count], &forces[..count])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::means::{means, weights};

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
        for ((k, _), p) in chain.iter().zip(recover_run(&chain, &own, &lengths, &forces)) {
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
        let found = recover_run(&chain, &own, &lengths, &forces);
        let near = neighbours(&chain, false, &own);
        let weights = weights(&near, &lengths);
        let mean = means(&near, &weights, &forces);
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
            let found = recover_run(&chain, &own, &lengths, &forces);
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
    fn nodes_that_match_keep_their_pressure_on_graded_edges() {
        // Edges of 1, 1, 0.5, 0.25 and 0.125; the second side has no node 1.
        let s = [0.0, 1.0, 2.0, 2.5, 2.75, 2.875];
        let chain: Vec<(usize, f64)> = s.into_iter().enumerate().collect();
        let own = [vec![true; 6], vec![true, false, true, true, true, true]];
        let lengths = [0.5, 1.0, 0.75, 0.375, 0.1875, 0.0625];
        let forces = [1.0, 0.0, 0.0, 3.0, 0.0, 1.0];
        let found = recover_run(&chain, &own, &lengths, &forces);
        for k in 3..6 {
            assert!((found[k] - forces[k] / lengths[k]).abs() < 1e-12, "{k}: {found:?}");
        }
        assert!(found[0] < 2.0 && found[1] > 0.0, "{found:?}");
    }
}

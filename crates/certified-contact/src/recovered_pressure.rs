//! The pressure along a contact line whose nodes did not match.
//!
//! A node that the common refinement puts into an edge of a body cuts cells there; the mesh behind it is as coarse as before. The nodal
//! forces `P_i` oscillate from such a node to the next, and so does `P_i/ℓ_i`. The forces on the hat functions `φ_j` of the side with the
//! coarser mesh, without those nodes, do not:
//! ```math
//! p_j = \frac{\sum_i φ_j(s_i) P_i}{\sum_i φ_j(s_i) ℓ_i}
//! ```
//! linear between the nodes `j`. The sum of the forces remains: `Σ p(s_i) ℓ_i = Σ P_i`.

use fem_core::interface::{ContactInterface, ContactProblem};

/// Computes the pressure that is recovered on the coarser side of a pair, at its pairs of nodes, Pa. `None` if all nodes matched from the
/// first mesh on, and against an obstacle: it is `P_i/ℓ_i` then.
///
/// * `forces`: normal forces at the pairs of nodes, `|n_i| P_i`, N/m.
///
/// # Panics
/// If there is no such pair, or not one force per pair of nodes.
pub fn recovered_pressure(problem: &ContactProblem, pair: usize, forces: &[f64]) -> Option<Vec<f64>> {
    let of = &problem.contacts[pair];
    let pairs = of.interface.pairs();
    assert!(forces.len() == pairs.len(), "{} forces, and {} pairs of nodes", forces.len(), pairs.len());
    let mut pressure: Vec<f64> =
        pairs.iter().zip(forces).map(|(pair, p)| p / pair.tributary_length).collect();
    if problem.obstacle_of(of).is_some() {
        return None;
    }
    let cuts = [0, 1].map(|side: usize| -> Vec<bool> {
        let body = &problem.bodies[of.bodies[side]];
        pairs.iter().map(|pair| body.is_inserted(pair.nodes[side])).collect()
    });
    let count = |side: usize| cuts[side].iter().filter(|cut| **cut).count();
    // The side with more nodes of the other one has fewer of its own.
    let own: Vec<bool> = cuts[usize::from(count(1) > count(0))].iter().map(|cut| !cut).collect();
    if own.iter().all(|own| *own) {
        return None;
    }
    for chain in chains(&of.interface, &own) {
        recover(&chain, (&own, forces), &of.interface, &mut pressure);
    }
    Some(pressure)
}

/// A run of pairs joined by edges, with their arc lengths; a closed one ends with its first pair.
type Chain = Vec<(usize, f64)>;

/// Lists the runs of a contact line, from an own node on if it is closed.
fn chains(interface: &ContactInterface, own: &[bool]) -> Vec<Chain> {
    let count = interface.pairs().len();
    let mut next = vec![None; count];
    let mut has_previous = vec![false; count];
    for edge in interface.edges().iter().filter(|edge| edge.clamped.is_none()) {
        let [i, j] = edge.pairs.map(|k| k as usize);
        next[i] = Some((j, edge.length));
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
        found.push(chain);
    }
    found
}

/// Recovers the pressure along one run.
fn recover(
    chain: &[(usize, f64)],
    (own, forces): (&[bool], &[f64]),
    interface: &ContactInterface,
    pressure: &mut [f64],
) {
    let last = chain.len() - 1;
    let kept: Vec<usize> = (0..chain.len()).filter(|i| *i == 0 || *i == last || own[chain[*i].0]).collect();
    if kept.len() == chain.len() {
        return;
    }
    let closed = chain[0].0 == chain[last].0;
    // Forces and lengths on the hat functions of the kept nodes.
    let mut sums = vec![[0.0; 2]; kept.len()];
    let share = |i: usize, piece: usize| {
        let [a, b] = [kept[piece], kept[piece + 1]].map(|k| chain[k].1);
        (chain[i].1 - a) / (b - a)
    };
    let place = |i: usize| kept.partition_point(|k| *k <= i).saturating_sub(1).min(kept.len() - 2);
    for i in 0..if closed { last } else { last + 1 } {
        let (pair, piece) = (chain[i].0, place(i));
        let x = share(i, piece);
        for (k, part) in [(piece, 1.0 - x), (piece + 1, x)] {
            sums[k][0] += part * forces[pair];
            sums[k][1] += part * interface.pairs()[pair].tributary_length;
        }
    }
    if closed && let (Some(first), Some(end)) = (sums.first().copied(), sums.last().copied()) {
        let both = [first[0] + end[0], first[1] + end[1]];
        let ends = [0, kept.len() - 1];
        ends.into_iter().for_each(|k| sums[k] = both);
    }
    let at: Vec<f64> = sums.iter().map(|[force, length]| force / length).collect();
    for i in 0..=last {
        let piece = place(i);
        let x = share(i, piece);
        pressure[chain[i].0] = (1.0 - x) * at[piece] + x * at[piece + 1];
    }
}

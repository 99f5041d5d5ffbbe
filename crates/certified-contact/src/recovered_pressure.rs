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
//!
//! On a surface areas take the place of lengths, and the distance over the size of the coarser side's faces that of `x`: see [`crate::means`].

use crate::means::OPEN;
use crate::space::ContactSpace;
use fem_core::interface::{ContactFacet, ContactInterface, ContactProblem};
use fem_core::space::Space;

/// Computes the pressure that is recovered over the cells of the coarser side of a pair, at its pairs of nodes, Pa. `None` if all nodes
/// matched from the first mesh on, and against an obstacle: it is `P_i/ℓ_i` then.
///
/// * `forces`: normal forces at the pairs of nodes, `|n_i| P_i`, N/m or N.
///
/// # Panics
/// If there is no such pair, or not one force per pair of nodes.
pub fn recovered_pressure<S: ContactSpace>(
    problem: &ContactProblem<S>,
    pair: usize,
    forces: &[f64],
) -> Option<Vec<f64>> {
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
    S::recover_over_cells(problem, pair, &own, forces, &mut pressure);
    Some(levelled(&of.interface, &own, forces, pressure))
}

/// Replaces the pressure of each node by the mean of its facets' means; nothing flows to or from nodes without contact, nor along cut facets.
fn levelled<S: Space>(
    interface: &ContactInterface<S>,
    own: &[Vec<bool>; 2],
    forces: &[f64],
    mut pressure: Vec<f64>,
) -> Vec<f64> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let takes_part = |k: &u32| {
        let k = *k as usize;
        forces[k] > OPEN * largest && own[0][k] && own[1][k]
    };
    let between = |facet: &&ContactFacet<S>| {
        facet.free_corners().count() == S::DIM && facet.pairs.as_ref().iter().all(takes_part)
    };
    let share = |facet: &ContactFacet<S>| facet.measure / S::DIM as f64;
    let flow = |facet: &ContactFacet<S>| {
        let sum: f64 = facet.pairs.as_ref().iter().map(|k| pressure[*k as usize]).sum();
        let mean = sum / S::DIM as f64;
        (facet.pairs, S::axes(|k| share(facet) * (mean - pressure[facet.pairs[k] as usize])))
    };
    let flows: Vec<_> = interface.facets().iter().filter(between).map(flow).collect();
    for (pairs, flows) in flows {
        for (k, force) in pairs.as_ref().iter().zip(flows.as_ref()) {
            pressure[*k as usize] += force / interface.pairs()[*k as usize].weight;
        }
    }
    pressure
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
}

//! The choice of cells to refine: the contribution of each cell to the error of the mesh, and the smallest set with a given
//! share of it.
//!
//! The contribution of the iteration is not used: it falls with further iterations, not with finer cells. Source: Dörfler
//! 1996.

use crate::cre::minus;
use crate::estimate::Estimate;
use crate::recovery::Recovery;
use fem_core::interface::ContactProblem;

/// `‖σ̂ − σ(u)‖²` from this fraction of `e_CRE²` on is reduced as well, if the iteration is at most this fraction of it.
const CONTACT_PART: f64 = 0.1;

/// Computes the part that refinement can reduce, for each triangle of each body, J/m: `‖τ − σ̂‖²`, and for the
/// triangles at a contact edge half of its contact term `2∫ p o` each.
///
/// The contact term belongs to the mesh once the iteration has converged: it is nonzero only where contact ends
/// within an edge. So does `‖σ̂ − σ(u)‖²`, which is then what the pressure of the bound differs from the forces at the nodes; it is
/// added if it is a large part of the bound.
pub fn contributions<S: Recovery>(problem: &ContactProblem<S>, estimate: &Estimate<S>) -> Vec<Vec<f64>> {
    let cre = &estimate.cre;
    let mut by_cell = cre.discretisation_by_cell.clone();
    let [contact, iteration] =
        [estimate.unchecked().parts.contact, estimate.unchecked().parts.iteration].map(|part| part * part);
    if contact > CONTACT_PART * cre.e_cre().powi(2) && iteration <= CONTACT_PART * contact {
        for ((body, fields), cells) in problem.bodies.iter().zip(&estimate.pair.bodies).zip(&mut by_cell) {
            let stresses = fields.equilibrated.finite_element.iter().zip(&fields.stress);
            for (t, ((recovered, computed), cell)) in stresses.zip(cells).enumerate() {
                let difference = minus::<S>(*recovered, *computed);
                *cell += body.mesh().measure(t) * body.material(t).complementary(difference, difference);
            }
        }
    }
    for (pair, terms) in problem.contacts.iter().zip(&cre.by_contact_edge) {
        for (edge, term) in pair.interface.facets().iter().zip(terms) {
            // Against an obstacle it belongs to the one triangle.
            let share = if pair.partner.is_obstacle() { 1.0 } else { 0.5 };
            for (side, b) in pair.elastic_sides() {
                let topology = problem.bodies[b].mesh().topology();
                by_cell[b][topology.facet_cells()[edge.facets[side]][0] as usize] += share * term;
            }
        }
    }
    by_cell
}

/// One cell of one body with its contribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// The body, from 0.
    pub body: usize,
    /// Triangle of that body.
    pub cell: u32,
    /// Its contribution, J/m.
    pub squared: f64,
}

/// Sorts the cells of all bodies by their contributions, the largest first; equal ones by body and number, so that
/// the order is deterministic. Cells without a contribution are omitted.
pub fn ranking<C: AsRef<[f64]>>(contributions: &[C]) -> Vec<Contribution> {
    let mut ranked: Vec<Contribution> = Vec::new();
    for (body, cells) in contributions.iter().enumerate() {
        let positive = cells.as_ref().iter().enumerate().filter(|(_, c)| **c > 0.0);
        ranked.extend(positive.map(|(cell, &squared)| Contribution { body, cell: cell as u32, squared }));
    }
    debug_assert!(ranked.iter().all(|c| c.squared > 0.0));
    ranked.sort_by(|a, b| b.squared.total_cmp(&a.squared).then((a.body, a.cell).cmp(&(b.body, b.cell))));
    ranked
}

/// Counts the cells of the smallest set that contributes at least `fraction` of the whole: this many
/// of the first cells of a [`ranking`].
///
/// * `fraction`: of the squared error, from 0 to 1.
pub fn bulk(ranked: &[Contribution], fraction: f64) -> usize {
    let total = ranked.iter().fold(0.0, |sum, c| sum + c.squared);
    let mut sum = 0.0;
    for (count, c) in ranked.iter().enumerate() {
        if sum >= fraction * total {
            return count;
        }
        sum += c.squared;
    }
    ranked.len()
}

/// Marks the smallest set of cells of all bodies that contributes at least `fraction` of the whole (Dörfler marking).
///
/// If all contributions are zero, no cell is marked. Costs `O(n log n)`.
///
/// ```
/// use cre_estimator::marking::doerfler;
/// let marked = doerfler(&[vec![1.0, 4.0, 1.0], vec![4.0]], 0.5);
/// assert_eq!(marked, [vec![false, true, false], vec![true]]);
/// ```
pub fn doerfler<C: AsRef<[f64]>>(contributions: &[C], fraction: f64) -> Vec<Vec<bool>> {
    let ranked = ranking(contributions);
    let mut marked: Vec<Vec<bool>> =
        contributions.iter().map(|cells| vec![false; cells.as_ref().len()]).collect();
    for c in &ranked[..bulk(&ranked, fraction)] {
        marked[c.body][c.cell as usize] = true;
    }
    marked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_set_is_marked_and_ties_go_to_the_first() {
        let first: Vec<f64> = (0..40).map(|k| f64::from((k * 7) % 13)).collect();
        let second = vec![3.0; 9];
        for fraction in [0.1, 0.3, 0.5, 0.9, 1.0] {
            let marked = doerfler(&[&first, &second], fraction);
            let all: Vec<(f64, bool)> =
                first.iter().chain(&second).copied().zip(marked.iter().flatten().copied()).collect();
            let total: f64 = all.iter().map(|c| c.0).sum();
            let share: f64 = all.iter().filter(|c| c.1).map(|c| c.0).sum();
            let smallest = all.iter().filter(|c| c.1).map(|c| c.0).fold(f64::INFINITY, f64::min);
            let largest_left = all.iter().filter(|c| !c.1).map(|c| c.0).fold(0.0, f64::max);
            assert!(share >= fraction * total && share - smallest < fraction * total, "{fraction}");
            assert!(largest_left <= smallest, "{fraction}");
        }
        // Among equal ones the lower numbers come first.
        assert_eq!(doerfler(&[vec![1.0; 4], vec![1.0; 2]], 0.5)[0], [true, true, true, false]);
    }

    #[test]
    fn the_whole_is_reached_and_nothing_is_nothing() {
        let cells: Vec<f64> = (1..200).map(|k| 0.1 / f64::from(k)).collect();
        assert!(doerfler(&[cells, vec![]], 1.0)[0].iter().all(|m| *m));
        assert_eq!(doerfler(&[vec![0.0, 0.0], vec![0.0]], 0.5), [vec![false; 2], vec![false]]);
        assert_eq!(doerfler(&[vec![1.0, 0.0], vec![]], 1.0)[0], [true, false]);
    }
}

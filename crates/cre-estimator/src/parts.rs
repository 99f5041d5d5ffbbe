//! The parts of the bound.

use crate::admissible::{AdmissiblePair, consistent_forces};
use crate::cre::Cre;
use crate::pressure;
use crate::recovery::Recovery;
use crate::side::side_sign;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactProblem, ContactState, Partner};
use neumann_neumann::{BodySolver, BodySolvers, ResidualEnergy};

/// The parts of `e_CRE`, square root of J/m, each ≥ 0: the squares of all but `round_off` add up to `(e_CRE − round_off)²`.
///
/// With `σ̂` in FE equilibrium with the pressure `p`, the algebraic part of (17) is `‖σ̂ − σ(v)‖² + 2∫ p o + ‖l‖²`. Its
/// field `û − v` is the sum of two: `K z = −R` removes the residual of the iteration, and `K a` is the difference between the
/// consistent loads of `p` and the nodal forces. The mixed term is shared in proportion to `‖z‖²` and `‖a‖²`; the part
/// of the iteration is at most `η_NNDD²`; the rest belongs to the contact law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Parts {
    /// Of the mesh, `‖τ − σ̂‖`: reduced by refinement.
    pub mesh: f64,
    /// Of the iteration, at most `η_NNDD`: reduced by more iterations.
    pub iteration: f64,
    /// Of the contact law, which holds only at the nodes: this part remains at the exact solution of the discrete
    /// problem.
    pub contact: f64,
    /// Of the lift on curved contact lines, and of nodes that penetrate by rounding, `√(‖l‖² + 2∫ p l_n)`.
    pub lift: f64,
    /// Of gaps that curved edges cannot represent: the opening beyond the linear one between closed nodes.
    pub gap_data: f64,
    /// Of friction, (32): zero without it, and if the slip keeps its sign and friction its limit.
    pub friction: f64,
    /// The allowance for round-off.
    pub round_off: f64,
}

impl Parts {
    /// Returns the name and value of each part.
    pub fn list(&self) -> [(&'static str, f64); 7] {
        [
            ("mesh", self.mesh),
            ("iteration", self.iteration),
            ("contact", self.contact),
            ("lift", self.lift),
            ("gap_data", self.gap_data),
            ("friction", self.friction),
            ("round_off", self.round_off),
        ]
    }

    /// Returns the name of the largest part.
    pub fn largest(&self) -> &'static str {
        let list = self.list();
        list.iter().fold(list[0], |largest, part| if part.1 > largest.1 { *part } else { largest }).0
    }
}

/// Contributions to `2∫ p o` with the lift, J/m.
#[derive(Clone, Copy, Debug, Default)]
struct ContactTerm {
    contact: f64,
    gap_data: f64,
    lift: f64,
}

/// Splits a bound into its parts.
///
/// * `balanced`: the contact forces of the state by row, in balance with the loads of floating bodies, N/m.
/// * `eta_nndd`: `η_NNDD` of the state, square root of J/m.
pub(crate) fn parts<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    (state, balanced): (&ContactState<'_, S>, &[Vec<f64>]),
    (pair, cre): (&AdmissiblePair<S>, &Cre),
    eta_nndd: f64,
    round_off: f64,
) -> Parts {
    let problem = solvers.problem();
    let eta_squared = eta_nndd * eta_nndd;
    let term = contact_terms(problem, state, pair, cre);
    let fields = (cre.algebraic_squared - cre.contact_squared()).max(0.0);
    let lumping = lumping(solvers, balanced, pair);
    let share = if eta_squared > 0.0 { eta_squared / (eta_squared + lumping) } else { 0.0 };
    let iteration = (fields * share).min(eta_squared);
    let squares = [
        cre.discretisation_squared,
        iteration,
        fields - iteration + term.contact,
        term.lift,
        term.gap_data,
        cre.friction_squared(),
    ];
    // The two sides of the split differ by rounding errors.
    let sum: f64 = squares.iter().sum();
    let factor = if sum > 0.0 { cre.e_cre_squared.max(0.0) / sum } else { 0.0 };
    let [mesh, iteration, contact, lift, gap_data, friction] = squares.map(|x| (x * factor).sqrt());
    // The root of a square may be off by one digit.
    let iteration = iteration.min(eta_nndd);
    Parts { mesh, iteration, contact, lift, gap_data, friction, round_off }
}

/// Computes `‖a‖²`, J/m: the energy of the difference between the consistent loads of the pressures and the nodal forces,
/// by row.
fn lumping<S: Recovery>(solvers: &BodySolvers<'_, S>, forces: &[Vec<f64>], pair: &AdmissiblePair<S>) -> f64 {
    let problem = solvers.problem();
    let difference = |k: usize| -> Vec<f64> {
        let consistent = consistent_forces(&problem.contacts[k].interface, &pair.contacts[k]);
        consistent.iter().zip(&forces[k]).map(|(m, r)| m - r).collect()
    };
    let differences: Vec<Vec<f64>> = (0..problem.contacts.len()).map(difference).collect();
    let energy = |(b, solver): (usize, &BodySolver<'_, S>)| {
        let Some(body) = solver.whole() else {
            let mut on_nodes = vec![S::Vector::ZERO; problem.bodies[b].mesh().points().len()];
            for (k, side) in problem.sides_of(Partner::Body(b)) {
                for (row, difference) in problem.contacts[k].rows().zip(&differences[k]) {
                    on_nodes[row.nodes[side]] += row.direction * (side_sign(side) * difference);
                }
            }
            let along = solver.rough_along_unknowns(&on_nodes);
            return solver.residual_energies(vec![along]).iter().map(ResidualEnergy::whole).sum();
        };
        let signed = |(k, side): (usize, usize)| -> Vec<f64> {
            differences[k].iter().map(|d| side_sign(side) * d).collect()
        };
        let load =
            body.dofs().interface_forces(&problem.sides_of(Partner::Body(b)).map(signed).collect::<Vec<_>>());
        let mut w = vec![0.0; load.len()];
        body.interface().trace_from_force(&load, &mut w);
        w.iter().zip(&load).map(|(w, d)| w * d).sum::<f64>().max(0.0)
    };
    solvers.bodies().iter().enumerate().map(energy).sum()
}

/// Splits the contact terms, edge by edge.
fn contact_terms<S: Recovery>(
    problem: &ContactProblem<S>,
    state: &ContactState<'_, S>,
    pair: &AdmissiblePair<S>,
    cre: &Cre,
) -> ContactTerm {
    let mut sum = ContactTerm::default();
    for (k, of) in problem.contacts.iter().enumerate() {
        let (interface, opening) = (&of.interface, state.contacts[k].opening);
        let found = S::middle_openings(interface, problem.places_of(of).map(|b| state.displacement[b]));
        let middle = |facet: &ContactFacet<S>| facet.mean_openings(opening);
        let linear: Vec<f64> = interface.facets().iter().flat_map(middle).collect();
        let terms = |middle: &[f64]| {
            pressure::contact_terms(interface, &pair.contacts[k].edge_pressure, opening, middle)
        };
        let (found, linear) = (terms(&found), terms(&linear));
        let friction = cre.friction_by_contact_edge[k].iter().chain(std::iter::repeat(&0.0));
        let without = cre.by_contact_edge[k].iter().zip(friction).map(|(all, friction)| all - friction);
        for ((all, found), linear) in without.zip(found).zip(linear) {
            let contact = linear.min(all).max(0.0);
            let gap_data = (found.min(all) - contact).max(0.0);
            sum.contact += contact;
            sum.gap_data += gap_data;
            sum.lift += (all - contact - gap_data).max(0.0);
        }
    }
    sum
}

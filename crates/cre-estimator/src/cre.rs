//! The constitutive relation error of an admissible pair, and its exact split.
//!
//! Sources: for contact, Coorevits, Hild and Pelle 2000; for contact solved by domain decomposition, Gallimard and Sassi 2010.

use crate::admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair};
use crate::pressure;
use crate::recovery::Recovery;
use fem_core::body::Body;
use fem_core::each_body;
use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::norm::{from_squared, sum_over_cells};
use fem_core::space::Space;
use rayon::prelude::*;

/// The constitutive relation error, J/m, (15), and its contributions, (17):
/// ```math
/// e_CRE²  = ∑ ‖τ − σ(v)‖² + 2 ∫ p o
///         = ∑ ‖τ − σ̂‖² + [∑ ‖σ̂ − σ(v)‖² + 2 ∫ p o]
/// ```
/// Sides on springs add (41). On curved contact lines `o` is the opening with the lift `l`, and `‖l‖²` is added: (26). With friction (32) is added to both sides, and (36) with a lift.
#[derive(Clone, Debug)]
pub struct Cre {
    /// `e_CRE²`, a bound of `‖u − v‖² + ‖σ − τ‖²`.
    pub e_cre_squared: f64,
    /// Contribution of every triangle of each body, `‖τ − σ(v)‖²`.
    pub by_cell: Vec<Vec<f64>>,
    /// Part of the mesh in every triangle of each body, `‖τ − σ̂‖²`: the part that refinement can reduce.
    pub discretisation_by_cell: Vec<Vec<f64>>,
    /// Contribution of every contact edge of each pair: `2∫ p o`, its share of `‖l‖²`, and what friction adds.
    pub by_contact_edge: Vec<Vec<f64>>,
    /// The term of friction on every contact edge of each pair, (32); empty without friction.
    pub friction_by_contact_edge: Vec<Vec<f64>>,
    /// `Σ‖τ − σ̂‖²`: the part of the mesh.
    pub discretisation_squared: f64,
    /// `Σ‖σ̂ − σ(v)‖² + 2∫ p o + ‖l‖²`: the part of the iteration and of the contact law, which holds only at nodes.
    pub algebraic_squared: f64,
}

impl Cre {
    /// Returns `e_CRE`.
    pub fn e_cre(&self) -> f64 {
        from_squared(self.e_cre_squared)
    }

    /// Returns the relative defect of the split, `|e² − (discretisation² + algebraic²)|/e²`: round-off.
    pub fn split_defect(&self) -> f64 {
        let sum = self.discretisation_squared + self.algebraic_squared;
        if self.e_cre_squared == sum { 0.0 } else { (self.e_cre_squared - sum).abs() / self.e_cre_squared }
    }
}

/// Computes the constitutive relation error of an admissible pair, (15).
///
/// The split has no cross term, because `τ − σ̂` is orthogonal to every FE strain that vanishes on Γ_D. Both
/// sides of it are computed independently: [`Cre::split_defect`] compares them.
pub fn constitutive_relation_error<S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &AdmissiblePair<S>,
) -> Cre {
    let of_body = |b: usize| {
        let (body, fields) = (&problem.bodies[b], &pair.bodies[b]);
        let of_cell = |t: usize| {
            let to =
                |stress: &[S::Tensor]| S::cell_distance_squared(body, &fields.equilibrated, t, stress[t]);
            (to(&fields.stress), to(&fields.equilibrated.finite_element))
        };
        let (to_given, to_finite_element) =
            (0..body.mesh().cells().len()).into_par_iter().with_min_len(512).map(of_cell).unzip();
        let mut distances: [Vec<f64>; 2] = [to_given, to_finite_element];
        for (distances, displacement) in distances.iter_mut().zip([Some(&fields.displacement[..]), None]) {
            let terms = fields.equilibrated.spring_terms(body, displacement);
            terms.for_each(|(cell, term)| distances[cell] += term);
        }
        distances
    };
    Cre::from_cells(problem, pair, each_body(problem.bodies.len(), of_body))
}

impl Cre {
    /// Sums up `‖τ − σ(v)‖²` and `‖τ − σ̂‖²` of all cells of each body.
    pub(crate) fn from_cells<S: Recovery>(
        problem: &ContactProblem<S>,
        pair: &AdmissiblePair<S>,
        distances: Vec<[Vec<f64>; 2]>,
    ) -> Self {
        let mut by_contact_edge = contact_terms(problem, pair);
        let friction =
            |(of, contact): (&ContactPair<S>, &AdmissibleContact<S>)| contact.facet_friction.terms(of);
        let friction_by_contact_edge: Vec<Vec<f64>> =
            problem.contacts.iter().zip(&pair.contacts).map(friction).collect();
        for (sums, terms) in by_contact_edge.iter_mut().zip(&friction_by_contact_edge) {
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let contact: f64 = by_contact_edge.iter().flatten().sum();
        let algebraic = |(body, fields): (&Body<S>, &AdmissibleBody<S>)| {
            distance_squared(body, &fields.equilibrated.finite_element, &fields.stress)
                + fields.equilibrated.spring_distance(body, &fields.displacement)
        };
        let (by_cell, discretisation_by_cell): (Vec<_>, Vec<_>) =
            distances.into_iter().map(<(Vec<f64>, Vec<f64>)>::from).unzip();
        let total = |bodies: &[Vec<f64>]| bodies.iter().map(|cells| of_cells(cells)).sum::<f64>();
        Self {
            e_cre_squared: total(&by_cell) + contact,
            discretisation_squared: total(&discretisation_by_cell),
            algebraic_squared: problem.bodies.iter().zip(&pair.bodies).map(algebraic).sum::<f64>() + contact,
            by_cell,
            discretisation_by_cell,
            by_contact_edge,
            friction_by_contact_edge,
        }
    }

    /// Sums up what friction adds on all pairs, (32), J/m.
    pub fn friction_squared(&self) -> f64 {
        self.friction_by_contact_edge.iter().flatten().sum()
    }

    /// Sums up `2∫ p o + ‖l‖²` of all pairs and what friction adds, J/m.
    pub fn contact_squared(&self) -> f64 {
        self.by_contact_edge.iter().flatten().sum()
    }
}

/// Adds up the contributions of the triangles of one body, J/m.
pub(crate) fn of_cells(cells: &[f64]) -> f64 {
    sum_over_cells(cells.len(), |t| cells[t])
}

/// Computes `2∫ p o` and the share of `‖l‖²` of every contact edge, J/m.
fn contact_terms<S: Recovery>(problem: &ContactProblem<S>, pair: &AdmissiblePair<S>) -> Vec<Vec<f64>> {
    let of_pair = |(of, contact): (&ContactPair<S>, &AdmissibleContact<S>)| {
        let AdmissibleContact { edge_pressure, opening, middle_opening, .. } = contact;
        pressure::contact_terms(&of.interface, edge_pressure, opening, middle_opening)
    };
    let mut terms: Vec<Vec<f64>> = problem.contacts.iter().zip(&pair.contacts).map(of_pair).collect();
    if pair.lift_energy > 0.0 {
        let weights = |(of, contact): (&ContactPair<S>, &AdmissibleContact<S>)| -> Vec<f64> {
            let square = |k: u32| contact.lift.by_pair[k as usize].powi(2);
            of.interface
                .facets()
                .iter()
                .map(|edge| edge.free_corners().map(|corner| square(edge.pairs[corner])).sum())
                .collect()
        };
        let weights: Vec<Vec<f64>> = problem.contacts.iter().zip(&pair.contacts).map(weights).collect();
        let whole: f64 = weights.iter().flatten().sum();
        for (term, weight) in terms.iter_mut().flatten().zip(weights.iter().flatten()) {
            *term += pair.lift_energy * weight / whole;
        }
    }
    terms
}

/// Computes `‖σ − τ‖²` for two stresses constant in the triangles, J/m.
pub(crate) fn distance_squared<S: Recovery>(body: &Body<S>, a: &[S::Tensor], b: &[S::Tensor]) -> f64 {
    sum_over_cells(a.len(), |t| {
        let d = minus::<S>(a[t], b[t]);
        body.mesh().measure(t) * body.material(t).complementary(d, d)
    })
}

/// Subtracts two tensors.
pub(crate) fn minus<S: Space>(a: S::Tensor, b: S::Tensor) -> S::Tensor {
    let [a, b]: [S::Components<f64>; 2] = [a.into(), b.into()];
    S::components(|k| a[k] - b[k]).into()
}

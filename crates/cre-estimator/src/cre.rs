//! The constitutive relation error of an admissible pair, and its exact split.
//!
//! Sources: for contact, Coorevits, Hild and Pelle 2000; for contact solved by domain decomposition, Gallimard and Sassi 2010.

use crate::admissible::AdmissiblePair;
use crate::johnson_mercier::{self, CellStress};
use crate::pressure;
use fem_core::body::Body;
use fem_core::double_double::DoubleDouble;
use fem_core::each_body;
use fem_core::interface::{ContactEdge, ContactProblem};
use fem_core::norm::{from_squared, sum_over_triangles};
use fem_core::tensor::SymTensor2;
use rayon::prelude::*;

/// The constitutive relation error, J/m, (15), and its contributions, (17):
/// ```math
/// e_{CRE}^2 = \sum ‖τ - σ(v)‖^2 + 2 ∫ p\,o = \sum ‖τ - \hat σ‖^2 + \Bigl[ \sum ‖\hat σ - σ(v)‖^2 + 2 ∫ p\,o \Bigr]
/// ```
/// On curved contact lines `o` is the opening with the lift `l`, and `‖l‖²` is added: (26).
#[derive(Clone, Debug)]
pub struct Cre {
    /// `e_CRE²`, a bound of `‖u − v‖² + ‖σ − τ‖²`.
    pub e_cre_squared: f64,
    /// Contribution of every triangle of each body, `‖τ − σ(v)‖²`.
    pub by_cell: [Vec<f64>; 2],
    /// Part of the mesh in every triangle of each body, `‖τ − σ̂‖²`: the part that refinement can reduce.
    pub discretisation_by_cell: [Vec<f64>; 2],
    /// Contribution of every contact edge, `2∫ p o` and its share of `‖l‖²`.
    pub by_contact_edge: Vec<f64>,
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
pub fn constitutive_relation_error(problem: &ContactProblem, pair: &AdmissiblePair) -> Cre {
    let of_body = |b: usize| {
        let body = &problem.bodies[b];
        (0..body.mesh().triangles().len())
            .into_par_iter()
            .with_min_len(512)
            .map(|t| cell_distances(problem, pair, b, t, &pair.equilibrated[b].cell(body, t)))
            .collect()
    };
    Cre::from_cells(problem, pair, each_body(of_body))
}

/// Computes `‖τ − σ(v)‖²` and `‖τ − σ̂‖²` of one triangle, J/m.
pub(crate) fn cell_distances(
    problem: &ContactProblem,
    pair: &AdmissiblePair,
    b: usize,
    t: usize,
    tau: &CellStress,
) -> [f64; 2] {
    let body = &problem.bodies[b];
    let (area, material) = (body.mesh().area(t), body.material(t));
    [pair.stress[b][t], pair.equilibrated[b].finite_element[t]]
        .map(|constant| johnson_mercier::distance_squared(tau, constant, area, material))
}

impl Cre {
    /// Sums up [`cell_distances`] of all triangles.
    pub(crate) fn from_cells(
        problem: &ContactProblem,
        pair: &AdmissiblePair,
        distances: [Vec<[f64; 2]>; 2],
    ) -> Self {
        let interface = &problem.interface;
        let mut by_contact_edge =
            pressure::contact_terms(interface, &pair.edge_pressure, &pair.opening, &pair.middle_opening);
        if pair.lift.energy > 0.0 {
            let weight =
                |edge: &ContactEdge| edge.pairs.map(|k| pair.lift.by_pair[k as usize].powi(2)).iter().sum();
            let weights: Vec<f64> = interface.edges().iter().map(weight).collect();
            let whole: f64 = weights.iter().sum();
            for (term, weight) in by_contact_edge.iter_mut().zip(weights) {
                *term += pair.lift.energy * weight / whole;
            }
        }
        let contact: f64 = by_contact_edge.iter().sum();
        let algebraic = |b: usize| {
            distance_squared(&problem.bodies[b], &pair.equilibrated[b].finite_element, &pair.stress[b])
        };
        let column =
            |k: usize| [0, 1].map(|b: usize| distances[b].iter().map(|x| x[k]).collect::<Vec<f64>>());
        let (by_cell, discretisation_by_cell) = (column(0), column(1));
        let total = |cells: &[Vec<f64>; 2]| {
            cells.iter().map(|cells| sum_over_triangles(cells.len(), |t| cells[t])).sum::<f64>()
        };
        Self {
            e_cre_squared: total(&by_cell) + contact,
            discretisation_squared: total(&discretisation_by_cell),
            algebraic_squared: algebraic(0) + algebraic(1) + contact,
            by_cell,
            discretisation_by_cell,
            by_contact_edge,
        }
    }
}

/// The results of one triangle in a pass over the cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellMeasure {
    /// See [`cell_distances`].
    pub(crate) distances: [f64; 2],
    /// Sum of the nine stresses of [`CellStress`] xx, yy, xy without rounding, Pa.
    pub(crate) sum: [DoubleDouble; 3],
}

/// Mean stresses of the triangles.
pub(crate) fn means(cells: &[CellMeasure]) -> Vec<[DoubleDouble; 3]> {
    cells.par_iter().with_min_len(4096).map(|c| c.sum.map(|s| s / DoubleDouble::from(9.0))).collect()
}

/// [`means`] in double precision.
pub(crate) fn rough_means(cells: &[CellMeasure]) -> Vec<SymTensor2> {
    let mean = |c: &CellMeasure| {
        let [xx, yy, xy] = c.sum.map(|s| s.high / 9.0);
        SymTensor2::new(xx, yy, xy)
    };
    cells.iter().map(mean).collect()
}

impl CellMeasure {
    /// Measures the stress of a triangle.
    #[inline(always)]
    pub(crate) fn new(distances: [f64; 2], tau: &CellStress) -> Self {
        let mut sum = [DoubleDouble::ZERO; 3];
        for part in tau {
            for s in part {
                sum[0] = sum[0] + s.xx;
                sum[1] = sum[1] + s.yy;
                sum[2] = sum[2] + s.xy;
            }
        }
        Self { distances, sum }
    }
}

/// Computes `‖σ − τ‖²` for two stresses constant in the triangles, J/m.
pub(crate) fn distance_squared(body: &Body, a: &[SymTensor2], b: &[SymTensor2]) -> f64 {
    sum_over_triangles(a.len(), |t| {
        let d = a[t].minus(b[t]);
        body.mesh().area(t) * body.material(t).complementary(d, d)
    })
}

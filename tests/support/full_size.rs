//! The paper's iteration with whole bodies: the judge of the one in the interface unknowns.
//!
//! Two held bodies with one pair, the first carries λ; θ is fixed, and each body takes half of the imbalance. One full-size solve per body
//! and step and the full sparse contact problem: neither a Schur complement nor a factor is shared with the program's iteration.

use crate::model::{ContactProblem, Made, Vector};
use contact_qp::{BoundState, BoxQp, MatrixView, QpSettings, SparseRows, solve_box};
use fem_core::assembly::System;
use fem_core::cholesky::{Cholesky, Front};
use fem_core::ordering::ROOT;

/// One iteration.
#[derive(Clone, Debug)]
pub struct Iteration {
    /// λ, `r¹`, `r²` and `v²` on the interface.
    pub lambda: Vec<f64>,
    /// Reaction of Ω₁.
    pub reaction: Vec<f64>,
    /// Contact force of Ω₂.
    pub contact_force: Vec<f64>,
    /// Trace of Ω₂.
    pub trace: Vec<f64>,
    /// Active bounds.
    pub active: Vec<bool>,
    /// `2 ‖w¹‖`.
    pub eta_nndd: f64,
    /// `ε_t`.
    pub precision: f64,
    /// Displacements of step 1.
    pub displacement: [Vec<Vector>; 2],
    /// Number of calls of Clarabel.
    pub clarabel_calls: usize,
}

/// Removes the interface from a tree of fronts; its children become roots.
fn without_interface(fronts: &[Front]) -> Vec<Front> {
    let kept = fronts.len() - 1;
    let mut fronts = fronts[..kept].to_vec();
    for front in fronts.iter_mut().filter(|f| f.parent as usize == kept) {
        front.parent = ROOT;
    }
    fronts
}

/// Iterates from λ = 0.
///
/// # Errors
/// A body that is not held; a contact problem that is rejected.
pub fn iterate(
    problem: &ContactProblem,
    theta: f64,
    iterations: usize,
    settings: &QpSettings,
) -> Made<Vec<Iteration>> {
    let [first, second] = [0, 1].map(|b| System::assemble(&problem.bodies[b], &problem.side(b)));
    let systems = [first?, second?];
    let [first, second] = [0, 1].map(|b| Cholesky::new(&systems[b].stiffness, systems[b].dofs.fronts()));
    let neumann = [first?, second?];
    let starts = [0, 1].map(|b| systems[b].dofs.len() - systems[b].dofs.interface_len());
    let inner = without_interface(systems[0].dofs.fronts());
    let dirichlet = Cholesky::new(&systems[0].stiffness.leading(starts[0]), &inner)?;
    let (columns, rows, values) = systems[1].stiffness.upper();
    let n = systems[1].dofs.len();
    let matrix = MatrixView::SparseUpper { n, column_starts: &columns, row_indices: &rows, values: &values };
    let linear: Vec<f64> = systems[1].load.iter().map(|f| -f).collect();
    let (mut lower, upper, rows) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n], SparseRows::new(n));
    let pairs = problem.contacts[0].interface.pairs();
    let mut lambda = vec![0.0; pairs.len()];
    let (mut start, mut found): (Option<Vec<BoundState>>, Vec<Iteration>) = (None, Vec::new());
    for _ in 0..iterations {
        // (8): K¹_II u_I = f_I − K¹_IC λ, r¹ = (K¹ u − f)_C.
        let System { stiffness, load, dofs } = &systems[0];
        let mut u = vec![0.0; load.len()];
        u[starts[0]..].copy_from_slice(&lambda);
        let coupling = stiffness.multiply(&u);
        let mut inside: Vec<f64> = load.iter().zip(&coupling).map(|(f, k)| f - k).take(starts[0]).collect();
        dirichlet.solve(&mut inside);
        u[..starts[0]].copy_from_slice(&inside);
        let forces = stiffness.multiply(&u);
        let reaction: Vec<f64> = (starts[0]..u.len()).map(|j| forces[j] - load[j]).collect();
        // (9): min ½ uᵀ K² u − fᵀ u, v² ≥ λ − g.
        let bounds = lambda.iter().zip(pairs).map(|(l, p)| l - p.gap);
        lower[starts[1]..].iter_mut().zip(bounds).for_each(|(lower, bound)| *lower = bound);
        let qp =
            BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows: &rows, right_side: &[] };
        let mut contact = solve_box(&qp, start.as_deref(), settings)?;
        let force = contact.multipliers.split_off(starts[1]);
        let active = contact.states[starts[1]..].iter().map(|place| *place == BoundState::Lower).collect();
        start = Some(contact.states);
        // (10), (11): K w = ∓½ (r¹ + r²).
        let imbalance: Vec<f64> = reaction.iter().zip(&force).map(|(a, b)| a + b).collect();
        let corrections = [0, 1].map(|b: usize| {
            let mut w = vec![0.0; systems[b].dofs.len()];
            let share = [-0.5, 0.5][b];
            w[starts[b]..].iter_mut().zip(&imbalance).for_each(|(w, j)| *w = share * j);
            neumann[b].solve(&mut w);
            w.split_off(starts[b])
        });
        let [w1, w2] = &corrections;
        // (22), (24), and the update.
        let work: f64 = imbalance.iter().zip(w1).map(|(j, w)| -2.0 * j * w).sum();
        let largest = |r: &[f64]| r.iter().zip(pairs).map(|(r, p)| (r / p.weight).abs()).fold(0.0, f64::max);
        let next = lambda.iter().zip(w1.iter().zip(w2)).map(|(l, (a, b))| l + theta * (a - b)).collect();
        found.push(Iteration {
            lambda: std::mem::replace(&mut lambda, next),
            precision: 2.0 * largest(&imbalance) / (largest(&reaction) + largest(&force)),
            reaction,
            contact_force: force,
            trace: contact.x[starts[1]..].to_vec(),
            active,
            eta_nndd: work.sqrt(),
            displacement: [dofs.displacement(&u), systems[1].dofs.displacement(&contact.x)],
            clarabel_calls: contact.counts.clarabel_calls(),
        });
    }
    Ok(found)
}

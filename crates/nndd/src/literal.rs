//! The literal path: one full-size solve per body and step, and the full sparse contact problem.
//!
//! It shares neither the Schur complement nor its factor with the condensed path, and is the reference for
//! testing the condensed path.

use crate::error::NnddError;
use crate::iterate::ContactAnswer;
use crate::steps::{Steps, answer, each_role};
use contact_qp::{ActiveSet, BoundQp, MatrixView, QpSettings};
use fem_core::assembly::System;
use fem_core::cholesky::{Cholesky, Front};
use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::ordering::ROOT;
use fem_core::sparse::SymmetricCsc;

pub(crate) struct LiteralSteps {
    systems: [System; 2],
    /// Factor of `K¹` with the interface normals imposed.
    dirichlet: Cholesky,
    /// Factors of `K¹`, `K²` with the interface free.
    neumann: [Cholesky; 2],
    /// `K²` by its upper triangle, and `−f²`.
    contact: (Vec<usize>, Vec<usize>, Vec<f64>),
    linear: Vec<f64>,
    bounded: Vec<usize>,
}

fn factorise(matrix: &SymmetricCsc, fronts: &[Front]) -> Result<Cholesky, NnddError> {
    Ok(Cholesky::new(matrix, fronts)?)
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

impl LiteralSteps {
    pub(crate) fn new(problem: &ContactProblem, pair: &ContactPair) -> Result<Self, NnddError> {
        let [first, second] = each_role(|role| {
            let b = [pair.imposed(), pair.unilateral()][role];
            System::assemble(&problem.bodies[b], &problem.side(b).oriented(pair.roles.sign()))
        });
        let systems = [first?, second?];
        let interior = systems[0].dofs.len() - systems[0].dofs.interface_len();
        let neumann = |s: &System| factorise(&s.stiffness, s.dofs.fronts());
        let inner = without_interface(systems[0].dofs.fronts());
        let [first, second] = each_role(|role| neumann(&systems[role]));
        let dofs = &systems[1].dofs;
        Ok(Self {
            dirichlet: factorise(&systems[0].stiffness.leading(interior), &inner)?,
            neumann: [first?, second?],
            contact: systems[1].stiffness.upper(),
            linear: systems[1].load.iter().map(|f| -f).collect(),
            bounded: (dofs.len() - dofs.interface_len()..dofs.len()).collect(),
            systems,
        })
    }
}

impl Steps for LiteralSteps {
    fn dirichlet(&self, lambda: &[f64]) -> Vec<f64> {
        let System { stiffness, load, .. } = &self.systems[0];
        let interior = load.len() - lambda.len();
        // K_II u_I = f_I − K_IC λ
        let mut x = vec![0.0; load.len()];
        x[interior..].copy_from_slice(lambda);
        let coupling = stiffness.multiply(&x);
        let mut u: Vec<f64> = load[..interior].iter().zip(&coupling).map(|(f, k)| f - k).collect();
        self.dirichlet.solve(&mut u);
        x[..interior].copy_from_slice(&u);
        let forces = stiffness.multiply(&x);
        (interior..x.len()).map(|j| forces[j] - load[j]).collect()
    }

    fn contact(
        &self,
        lower: &[f64],
        warm_start: Option<&ActiveSet>,
        settings: &QpSettings,
    ) -> Result<ContactAnswer, NnddError> {
        let (starts, rows, values) = &self.contact;
        let matrix = MatrixView::SparseUpper {
            n: self.linear.len(),
            column_starts: starts,
            row_indices: rows,
            values,
        };
        let qp = BoundQp { matrix, linear: &self.linear, bounded: &self.bounded, lower };
        let solution = contact_qp::solve(&qp, warm_start, settings)?;
        let trace = solution.x[self.linear.len() - lower.len()..].to_vec();
        Ok(answer(solution, trace))
    }

    fn neumann(&self, body: usize, force: &[f64]) -> Vec<f64> {
        let n = self.systems[body].dofs.len();
        let mut x = vec![0.0; n];
        x[n - force.len()..].copy_from_slice(force);
        self.neumann[body].solve(&mut x);
        x.split_off(n - force.len())
    }
}

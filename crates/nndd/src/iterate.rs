//! The data of one iteration, and the part that is kept as history.

use crate::active_set::ActiveSet;
use crate::recovery;
use contact_qp::{KktResiduals, QpPath, QpStatus};
use fem_core::body::RigidMotion;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, NodePair};
use fem_core::prepared::PreparedProblem;
use std::ops::Range;

/// The contact problem of step 1: how it was solved.
#[derive(Clone, Debug)]
pub struct ContactAnswer {
    /// Normal trace `v²` of Ω₂, m.
    pub normal_trace: Vec<f64>,
    /// Contact force `r² ≥ 0`, N/m.
    pub normal_reaction: Vec<f64>,
    /// Active bounds.
    pub active: ActiveSet,
    /// How the programme ended.
    pub status: QpStatus,
    /// Method that produced the answer.
    pub path: QpPath,
    /// Iterations of that method.
    pub iterations: usize,
    /// Number of calls of Clarabel.
    pub clarabel_calls: usize,
    /// Its KKT residuals, relative.
    pub kkt: KktResiduals,
}

/// How the quadratic programme that determined an iterate was solved: the slowest one of the bodies in the iteration, that of all
/// forces in the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Programme {
    /// Method that produced the answer.
    pub path: QpPath,
    /// Iterations of that method.
    pub iterations: usize,
}

/// What determines the displacements of an iterate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recovery {
    /// In bodies that their supports hold, without friction, the normal traces, which are imposed; in the others the contact forces.
    #[default]
    Traces,
    /// The contact forces and the rigid motions: `u = K⁺ (f − Bᵀ P) + R a`.
    Forces,
}

/// One iteration: the admissible pair of step 1 and the results of step 2.
///
/// The arrays have one entry per pair of nodes, pair after pair, see [`Self::blocks`]. Traces and forces of a pair are along
/// the outward normal of its Ω₁, the body that carries λ there.
#[derive(Clone, Debug)]
pub struct Iterate {
    /// Number, from 1.
    pub iteration: usize,
    /// The imposed normal trace λ of this iteration, m.
    pub lambda: Vec<f64>,
    /// Reaction `r¹` of Ω₁ to λ, N/m.
    pub reaction: Vec<f64>,
    /// Response of Ω₂ to λ.
    pub contact: ContactAnswer,
    /// How the programme that determined this iterate was solved.
    pub programme: Programme,
    /// Opening `o = v² − (λ − g) ≥ 0`, m.
    pub opening: Vec<f64>,
    /// θ of the update that follows.
    pub theta: f64,
    /// `ε_t = 2 max|t¹+t²| / (max|t¹|+max|t²|)`, dimensionless (24).
    pub precision: f64,
    /// `η_NNDD = ‖w̄‖`, `S₁ w̄ = r¹ + r²`, (22): the guaranteed bound of the iteration's
    /// error, square root of an energy. For an assembly see the page of this crate.
    pub eta_nndd: f64,
    /// What determines the displacements.
    pub recovery: Recovery,
    /// The rigid motions of the floating bodies: body, motion, and by how much. Part of the displacements if they are
    /// recovered from forces.
    pub motions: Vec<(usize, RigidMotion, f64)>,
    /// What belongs to friction; empty without it.
    pub tangential: Tangential,
}

/// The tangential part of an iterate: one entry per pair of nodes of each pair with friction, pair after pair, see
/// [`Iterate::tangential_blocks`]. The tangent is `(−n_y, n_x)`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Tangential {
    /// The imposed trace λ of Ω₁ along the tangent that goes with its outward normal, m.
    pub lambda: Vec<f64>,
    /// Reaction of Ω₁ to it: at the discrete solution the friction force with the opposite sign, N/m.
    pub reaction: Vec<f64>,
    /// Friction force `Q` of Ω₂, `|Q| ≤ S`: `−Q t` on the first body of the pair and `+Q t` on the second, N/m.
    pub force: Vec<f64>,
    /// Slip `w` of the first body of the pair against the second, exactly 0 if friction is below its limit, m.
    pub slip: Vec<f64>,
    /// The limit `S` of the friction force, N/m.
    pub limit: Vec<f64>,
}

impl Iterate {
    /// Counts the pairs in contact: those with a positive force. A pair that touches without a force does
    /// not count, since its bound may count as active or not.
    pub fn contact_nodes(&self) -> usize {
        self.contact.normal_reaction.iter().filter(|&&r| r > 0.0).count()
    }

    /// Returns the normal traces of Ω₁ and Ω₂, m.
    pub fn traces(&self) -> [&[f64]; 2] {
        [&self.lambda, &self.contact.normal_trace]
    }

    /// Returns the normal forces of Ω₁ and Ω₂, `r¹` and `r²`, N/m.
    pub fn forces(&self) -> [&[f64]; 2] {
        [&self.reaction, &self.contact.normal_reaction]
    }

    /// Recovers the displacement of each body, Cartesian, m.
    ///
    /// * `problem`: the one that was solved.
    ///
    /// # Panics
    /// If the problem has another number of bodies, pairs or pairs of nodes.
    pub fn displacements(&self, problem: &PreparedProblem) -> Vec<Vec<Vector>> {
        let blocks: Vec<Range<usize>> = self.blocks(problem.problem()).collect();
        let tangential: Vec<Range<usize>> = self.tangential_blocks(problem.problem()).collect();
        let on_side = |k: usize, side: usize| {
            let roles = problem.problem().contacts[k].roles;
            let role = roles.of_side(side);
            let forces = self.forces()[role][blocks[k].clone()].iter();
            let along_tangent =
                &[&self.tangential.reaction, &self.tangential.force][role][tangential[k].clone()];
            forces.chain(along_tangent).map(|force| roles.sign() * force).collect()
        };
        let traces = |b: usize| match self.recovery {
            Recovery::Traces => self.interface_unknowns(problem, b),
            Recovery::Forces => None,
        };
        recovery::displacements(problem, traces, on_side, &self.motions)
    }

    /// Returns the interface unknowns of a body, m, from its traces; `None` if the body may move rigidly or has friction, or if its
    /// rows depend on each other.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn interface_unknowns(&self, problem: &PreparedProblem, body: usize) -> Option<Vec<f64>> {
        let (contact, dofs) = (problem.problem(), problem.bodies()[body].dofs());
        if problem.rigid_motions().iter().any(|of| of.body == body) {
            return None;
        }
        let blocks: Vec<Range<usize>> = self.blocks(contact).collect();
        let mut unknowns = vec![None; dofs.interface_len()];
        for (block, (k, side)) in contact.sides_of(body).enumerate() {
            let pair = &contact.contacts[k];
            if pair.friction.acts() {
                return None;
            }
            let traces = &self.traces()[pair.roles.of_side(side)][blocks[k].clone()];
            for (row, trace) in dofs.rows(block).iter().zip(traces) {
                let mut terms = row.terms.iter().filter(|term| term.1 != 0.0);
                let (Some((unknown, factor)), None) = (terms.next(), terms.next()) else { return None };
                let value = (pair.roles.sign() * trace - row.imposed) / factor;
                if unknowns[*unknown as usize].replace(value).is_some() {
                    return None;
                }
            }
        }
        unknowns.into_iter().collect()
    }

    /// Lists where the values of each pair are in the arrays.
    pub fn blocks(&self, problem: &ContactProblem) -> impl Iterator<Item = Range<usize>> {
        let mut start = 0;
        problem.contacts.iter().map(move |pair| {
            let end = start + pair.interface.pairs().len();
            debug_assert!(end <= self.lambda.len(), "the problem is another one than that of the iterate");
            std::mem::replace(&mut start, end)..end
        })
    }

    /// Lists where the values of each pair are in the arrays of [`Self::tangential`]; nothing for pairs without friction.
    pub fn tangential_blocks(&self, problem: &ContactProblem) -> impl Iterator<Item = Range<usize>> {
        let mut start = 0;
        problem.contacts.iter().map(move |pair| {
            let end = start + pair.row_count() - pair.interface.pairs().len();
            std::mem::replace(&mut start, end)..end
        })
    }

    /// Returns λ in the rows of all pairs, as [`crate::Start::lambda`] has it, m.
    pub fn lambda_by_row(&self, problem: &ContactProblem) -> Vec<f64> {
        let blocks = self.blocks(problem).zip(self.tangential_blocks(problem));
        let of_pair = |(pairs, tangents): (Range<usize>, Range<usize>)| {
            [&self.lambda[pairs], &self.tangential.lambda[tangents]].concat()
        };
        blocks.flat_map(of_pair).collect()
    }

    /// Computes the contact force `Σ r²_i`, N/m.
    pub fn contact_force(&self) -> f64 {
        self.contact.normal_reaction.iter().sum()
    }

    /// Computes the contact forces of Ω₁ and Ω₂, `F₁ = −Σ r¹_i` and `F₂ = Σ r²_i`, N/m, positive in compression. They are
    /// equal at the discrete solution.
    pub fn contact_forces(&self) -> [f64; 2] {
        self.contact_forces_of(0..self.reaction.len())
    }

    /// Computes the contact forces of one pair, see [`Self::contact_forces`].
    ///
    /// * `block`: see [`Self::blocks`].
    pub fn contact_forces_of(&self, block: Range<usize>) -> [f64; 2] {
        let [first, second] = self.forces().map(|forces| forces[block.clone()].iter().sum::<f64>());
        // A sum of zeros can be −0.
        [-first, second].map(|force| force + 0.0)
    }
}

/// The row of one iteration in a history.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationRow {
    /// Number, from 1.
    pub iteration: usize,
    /// θ of the update that follows.
    pub theta: f64,
    /// `ε_t`.
    pub precision: f64,
    /// `η_NNDD`.
    pub eta_nndd: f64,
    /// Pairs in contact.
    pub contact_nodes: usize,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// How the quadratic programme was solved, see [`Iterate::programme`].
    pub qp_path: QpPath,
    /// Iterations of that method.
    pub qp_iterations: usize,
    /// Largest relative KKT residual of its solution.
    pub qp_kkt: f64,
}

impl From<&Iterate> for IterationRow {
    fn from(it: &Iterate) -> Self {
        Self {
            iteration: it.iteration,
            theta: it.theta,
            precision: it.precision,
            eta_nndd: it.eta_nndd,
            contact_nodes: it.contact_nodes(),
            contact_force: it.contact_force(),
            qp_path: it.programme.path,
            qp_iterations: it.programme.iterations,
            qp_kkt: it.contact.kkt.max(),
        }
    }
}

/// Computes `ε_t = 2 max|t¹+t²| / (max|t¹|+max|t²|)`, the paper's precision, (24), with `t_i = r_i/ℓ_i`.
pub(crate) fn precision<'a>(
    pairs: impl Iterator<Item = &'a NodePair> + Clone,
    r1: &[f64],
    r2: &[f64],
) -> f64 {
    let largest = |r: &dyn Fn(usize) -> f64| {
        let tractions = pairs.clone().enumerate().map(|(i, pair)| (r(i) / pair.tributary_length).abs());
        // A NaN must show: it would pass for a small imbalance.
        tractions.fold(0.0, |largest: f64, t| if t > largest || t.is_nan() { t } else { largest })
    };
    let scale = largest(&|i| r1[i]) + largest(&|i| r2[i]);
    if scale == 0.0 { 0.0 } else { 2.0 * largest(&|i| r1[i] + r2[i]) / scale }
}

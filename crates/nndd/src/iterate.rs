//! The data of one iteration, and the part that is kept as history.

use crate::active_set::ActiveSet;
use contact_qp::{KktResiduals, QpPath, QpStatus};
use fem_core::contact_system::{BodyField, BodyFields, BodyRow, ContactRow, ContactRows, ContactSystem};
use std::ops::Range;

/// The contact problem of step 1: how it was solved.
#[derive(Clone, Debug)]
pub struct UnilateralSolution {
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
pub struct QpStats {
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
/// The arrays have one entry per pair of nodes, pair after pair, see [`fem_core::interface::ContactProblem::blocks`]. Traces and forces of a pair are along
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
    pub contact: UnilateralSolution,
    /// How the programme that determined this iterate was solved.
    pub programme: QpStats,
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
    /// The amounts of the rigid motions of the floating bodies, see [`ContactRows::motions`]. Part of the displacements if they are
    /// recovered from forces.
    pub amounts: Vec<f64>,
    /// What belongs to friction; empty without it.
    pub tangential: Tangential,
    /// The Newton step that it belongs to, from 1, and its inner iterations so far, see [`crate::Method::NewtonNn`]; 0 otherwise.
    pub step: [usize; 2],
    /// Its own fields, if the rows do not determine them.
    pub own: Option<OwnFields>,
}

/// The fields of an iterate whose forces on the two bodies of a row differ from the contact force.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OwnFields {
    /// The data of the displacements.
    pub(crate) bodies: Vec<BodyField>,
    /// The forces of Ω₂ that hold its displacement, by pair of nodes, N/m.
    pub(crate) reaction: Vec<f64>,
}

/// The tangential part of an iterate: one entry per row along a tangent, pair after pair, see
/// [`fem_core::interface::ContactProblem::tangential_blocks`] and [`fem_core::interface::ContactPair::tangents`].
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
    /// Returns the iterate of a problem without friction that has further pairs of nodes, at which nothing happens.
    ///
    /// * `places`: for each pair of nodes of that problem its number here; `None`: it has zero openings, traces and forces.
    #[must_use]
    pub fn spread(&self, places: &[Option<usize>]) -> Self {
        let numbers = |values: &[f64]| -> Vec<f64> {
            places.iter().map(|place| place.map_or(0.0, |k| values[k])).collect()
        };
        let active = places.iter().map(|place| place.is_some_and(|k| self.contact.active.is_active(k)));
        let own = self.own.as_ref();
        Self {
            lambda: numbers(&self.lambda),
            reaction: numbers(&self.reaction),
            opening: numbers(&self.opening),
            contact: UnilateralSolution {
                normal_trace: numbers(&self.contact.normal_trace),
                normal_reaction: numbers(&self.contact.normal_reaction),
                active: ActiveSet::new(active.collect()),
                ..self.contact.clone()
            },
            own: own.map(|own| OwnFields { reaction: numbers(&own.reaction), bodies: own.bodies.clone() }),
            ..self.clone()
        }
    }

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

    /// Returns the forces that hold the displacements of Ω₁ and Ω₂: those of [`Self::forces`], unless `r²` balances more than its own body.
    pub fn reactions(&self) -> [&[f64]; 2] {
        [&self.reaction, self.own.as_ref().map_or(&self.contact.normal_reaction, |own| &own.reaction)]
    }

    /// Returns the data that determine the displacements, for [`fem_core::prepared::PreparedProblem::displacements`].
    ///
    /// * `system`: the one that was solved.
    ///
    /// # Panics
    /// If the system has another number of bodies, pairs or pairs of nodes.
    pub fn fields(&self, system: &ContactSystem<'_>) -> BodyFields {
        if let Some(own) = &self.own {
            return BodyFields { bodies: own.bodies.clone(), amounts: self.amounts.clone() };
        }
        let rows = &system.rows;
        let forces = [
            rows.joined(&self.reaction, &self.tangential.reaction),
            rows.joined(&self.contact.normal_reaction, &self.tangential.force),
        ];
        let on_body = |row: &BodyRow| match self.role(system, row) {
            0 => forces[0][row.row],
            _ => 0.0 - forces[1][row.row],
        };
        let of_body = |b: usize| {
            let traces = match self.recovery {
                Recovery::Traces => self.interface_unknowns(system, b),
                Recovery::Forces => None,
            };
            traces.map_or_else(|| BodyField::Forces(system.on_unknowns(b, on_body)), BodyField::Traces)
        };
        let bodies = (0..system.bodies.len()).map(of_body).collect();
        BodyFields { bodies, amounts: self.amounts.clone() }
    }

    /// Returns the role of the body of a row, 0 for Ω₁, 1 for Ω₂.
    fn role(&self, system: &ContactSystem<'_>, row: &BodyRow) -> usize {
        system.rows.pairs[system.rows.rows[row.row].pair].roles.of_side(row.side)
    }

    /// Returns the interface unknowns of a body, m, from its traces; `None` if the body may move rigidly or has friction, or if its
    /// rows depend on each other.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn interface_unknowns(&self, system: &ContactSystem<'_>, body: usize) -> Option<Vec<f64>> {
        let rows = &system.rows;
        if system.floats(body) {
            return None;
        }
        let mut unknowns = vec![None; system.bodies[body].len()];
        for row in &system.of_body[body] {
            let pair = &rows.pairs[rows.rows[row.row].pair];
            let (false, [(unknown, factor)]) = (pair.has_friction(), row.terms.as_slice()) else {
                return None;
            };
            let place = rows.rows[row.row].node_pair;
            let trace = match self.role(system, row) {
                0 => self.lambda[place],
                _ => 0.0 - self.contact.normal_trace[place],
            };
            if unknowns[*unknown].replace((trace - row.imposed) / factor).is_some() {
                return None;
            }
        }
        unknowns.into_iter().collect()
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
    /// * `block`: see [`fem_core::interface::ContactProblem::blocks`].
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
    /// See [`Iterate::step`].
    pub step: [usize; 2],
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
            step: it.step,
        }
    }
}

/// Computes `ε_t = 2 max|t¹+t²| / (max|t¹|+max|t²|)`, the paper's precision, (24), with `t_i = r_i/ℓ_i`.
pub(crate) fn precision(rows: &ContactRows, r1: &[f64], r2: &[f64]) -> f64 {
    let normal = |row: &&ContactRow| !row.law.is_tangential();
    let lengths: Vec<f64> = rows.rows.iter().filter(normal).map(|row| row.length).collect();
    let largest = |r: &dyn Fn(usize) -> f64| {
        let tractions = lengths.iter().enumerate().map(|(i, length)| (r(i) / length).abs());
        // A NaN must show: it would pass for a small imbalance.
        tractions.fold(0.0, |largest: f64, t| if t > largest || t.is_nan() { t } else { largest })
    };
    let scale = largest(&|i| r1[i]) + largest(&|i| r2[i]);
    if scale == 0.0 { 0.0 } else { 2.0 * largest(&|i| r1[i] + r2[i]) / scale }
}

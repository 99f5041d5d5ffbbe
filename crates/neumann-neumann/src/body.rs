//! The linear problems of the bodies of a prepared problem: directly, or by conjugate gradients over their subdomains.

use crate::balancing::Balancing;
use crate::broken::{Broken, Load};
use crate::error::BalancingError;
use crate::skeleton::Skeleton;
use contact_qp::{RowSelection, SparseRows};
use fem_core::body::Body;
use fem_core::condensation::CondensedBody;
use fem_core::double_double::PreciseVector;
use fem_core::each_body;
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactProblem;
use fem_core::mesh::id::NodeId;
use fem_core::prepared::{FactorisedBody, PreparedProblem};
use fem_core::residual::{SplitField, refine};
use fem_core::space::{Plane, Space};
use fem_core::subdomains::{CutBody, Subdomain};
use std::borrow::Cow;

/// η below this fraction of the energy norm is rounding.
const FLOOR: f64 = 1e-15;

/// A correction that grows below this fraction of the energy norm is rounding.
const NOISE: f64 = 1e-10;

/// A displacement of least energy is known to this fraction of its norm: its energy is off by the square.
const ENOUGH: f64 = 1e-6;

/// Times that conjugate gradients begin again from the residual of the traces themselves, at most.
const RESTARTS: usize = 20;

/// Beginning again must have lowered η to this fraction.
const GAIN: f64 = 0.5;

/// A prepared problem, with the solvers of its bodies.
pub struct BodySolvers<'a, S: Space = Plane> {
    prepared: &'a PreparedProblem<S>,
    bodies: Vec<BodySolver<'a, S>>,
}

/// Solves the linear problems of one body.
pub enum BodySolver<'a, S: Space = Plane> {
    /// In one piece.
    Whole(&'a CondensedBody<S>),
    /// In subdomains.
    Cut(Box<CutSolver<'a, S>>),
}

/// A body in subdomains with its operators.
pub struct CutSolver<'a, S: Space> {
    body: &'a CutBody<S>,
    broken: Broken<'a>,
    linear: Balancing,
}

/// A bound of `Rᵀ K⁻¹ R` of a residual, J/m in the plane, J in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualEnergy {
    /// The energy with all interface unknowns held, those that subdomains share among them.
    pub inside: f64,
    /// The contribution of the interface unknowns.
    pub interface: f64,
}

impl ResidualEnergy {
    /// Returns the whole bound.
    pub fn whole(&self) -> f64 {
        self.inside + self.interface
    }
}

impl<'a, S: Space> BodySolvers<'a, S> {
    /// Makes the operators of all bodies in subdomains.
    ///
    /// # Errors
    /// See [`BalancingError`].
    pub fn new(prepared: &'a PreparedProblem<S>) -> Result<Self, BalancingError> {
        let of_body = |b: usize| BodySolver::new(prepared, b);
        let bodies = each_body(prepared.bodies().len(), of_body).into_iter().collect::<Result<_, _>>()?;
        Ok(Self { prepared, bodies })
    }

    /// Returns the problem with its factorised bodies.
    pub fn prepared(&self) -> &'a PreparedProblem<S> {
        self.prepared
    }

    /// Returns the problem.
    pub fn problem(&self) -> &'a ContactProblem<S> {
        self.prepared.problem()
    }

    /// Returns the solvers.
    pub fn bodies(&self) -> &[BodySolver<'a, S>] {
        &self.bodies
    }
}

impl<'a, S: Space> BodySolver<'a, S> {
    fn new(prepared: &'a PreparedProblem<S>, b: usize) -> Result<Self, BalancingError> {
        Ok(match &prepared.bodies()[b] {
            FactorisedBody::Whole(body) => Self::Whole(body),
            FactorisedBody::Cut(body) => {
                let broken = Broken::new(Cow::Owned(prepared.system_of(b, &[])), &[])?;
                let linear = Balancing::new(&broken, Skeleton::new(&broken, &[], &[]))?;
                Self::Cut(Box::new(CutSolver { body, broken, linear }))
            }
        })
    }

    /// Returns the factor of a body in one piece.
    pub fn whole(&self) -> Option<&'a CondensedBody<S>> {
        match self {
            Self::Whole(body) => Some(body),
            Self::Cut(_) => None,
        }
    }

    /// Computes the displacement (Cartesian, m) under the body's loads and further nodal forces: the Neumann problem.
    ///
    /// * `forces`: node and Cartesian force, N/m.
    pub fn displacement_from_nodal_forces(&self, forces: &[(NodeId, S::Vector)]) -> Vec<S::Vector> {
        match self {
            Self::Whole(body) => body.displacement_from_nodal_forces(forces),
            Self::Cut(body) => body.displacement_from_nodal_forces(forces),
        }
    }

    /// Computes the displacement (Cartesian, m) under given forces alone; zero where displacements are imposed.
    ///
    /// * `forces`: see [`Self::rough_along_unknowns`], N/m.
    pub fn correction(&self, mut forces: Vec<f64>) -> Vec<S::Vector> {
        match self {
            Self::Whole(body) => {
                body.factor().solve(&mut forces);
                body.dofs().correction(&forces)
            }
            Self::Cut(body) => body.field(body.split(&forces), false),
        }
    }

    /// Computes the parts of nodal forces along the unknowns, N/m. Of a body in subdomains: of one after the other, a shared node in the first
    /// of them.
    pub fn rough_along_unknowns(&self, residual: &[S::Vector]) -> Vec<f64> {
        match self {
            Self::Whole(body) => body.rough_along_unknowns(residual),
            Self::Cut(body) => body.along(residual, S::Vector::ZERO, CondensedBody::rough_along_unknowns),
        }
    }

    /// [`Self::rough_along_unknowns`] of forces in double-double numbers.
    pub fn along_unknowns(&self, residual: &[PreciseVector<S>]) -> Vec<f64> {
        match self {
            Self::Whole(body) => body.along_unknowns(residual),
            Self::Cut(body) => {
                body.along(residual, S::axes(|_| Default::default()), CondensedBody::along_unknowns)
            }
        }
    }

    /// Bounds `Rᵀ K⁻¹ R` of some residuals. The bound is equal to it if the body is in one piece, see [`CondensedBody::residual_energies`] and
    /// [`Balancing::energy_bound`].
    ///
    /// * `residuals`: see [`Self::rough_along_unknowns`], N/m.
    pub fn residual_energies(&self, residuals: Vec<Vec<f64>>) -> Vec<ResidualEnergy> {
        match self {
            Self::Whole(body) => {
                let energies = body.residual_energies(residuals).into_iter();
                energies.map(|[inside, interface]| ResidualEnergy { inside, interface }).collect()
            }
            Self::Cut(body) => residuals.iter().map(|residual| body.residual_energy(residual)).collect(),
        }
    }

    /// Corrects a displacement by the residual of its equilibrium, see [`CondensedBody::refine`].
    ///
    /// * `held`: of a body in one piece alone.
    pub fn refine(
        &self,
        body: &Body<S>,
        loads: &[(NodeId, S::Vector)],
        held: bool,
        field: &mut SplitField<S>,
    ) {
        match self {
            Self::Whole(condensed) => {
                condensed.refine(body, loads, held, field);
            }
            Self::Cut(cut) => {
                let measure = |residual: &[PreciseVector<S>]| {
                    let mut along =
                        cut.along(residual, S::axes(|_| Default::default()), CondensedBody::along_unknowns);
                    let size = cut.residual_energy(&along).whole().sqrt();
                    along.iter_mut().for_each(|force| *force = -*force);
                    (size, along)
                };
                refine(body, loads, field, measure, |forces| cut.field(cut.split(&forces), false));
            }
        }
    }
}

impl<S: Space> CutSolver<'_, S> {
    fn displacement_from_nodal_forces(&self, forces: &[(NodeId, S::Vector)]) -> Vec<S::Vector> {
        let mut all = vec![S::Vector::ZERO; self.body.nodes()];
        forces.iter().for_each(|(node, force)| all[*node] += *force);
        let along = self.along(&all, S::Vector::ZERO, CondensedBody::rough_along_unknowns);
        self.field(self.split(&along), true)
    }

    /// Expresses nodal forces in the unknowns of all subdomains, one after the other.
    fn along<T: Copy + Sync>(
        &self,
        forces: &[T],
        zero: T,
        of: impl Fn(&CondensedBody<S>, &[T]) -> Vec<f64> + Sync,
    ) -> Vec<f64> {
        let own = self.body.at_homes(forces, zero);
        let parts = self.body.subdomains();
        each_body(parts.len(), |k| of(&parts[k].condensed, &own[k])).concat()
    }

    /// Takes the forces of each subdomain.
    fn split<'f>(&self, mut forces: &'f [f64]) -> Vec<&'f [f64]> {
        let mut found = Vec::with_capacity(self.body.subdomains().len());
        for of in self.body.subdomains() {
            let (own, rest) = forces.split_at(of.condensed.dofs().len());
            found.push(own);
            forces = rest;
        }
        found
    }

    /// Condenses forces: of each subdomain the forward half of its solve, and the loads on all interface unknowns.
    fn condensed(&self, forces: &[&[f64]], loads: bool) -> (Vec<Vec<f64>>, Load) {
        let parts = self.body.subdomains();
        let of = |k: usize| {
            let Subdomain { condensed, free, loads: own, .. } = &parts[k];
            let dofs = condensed.dofs();
            let along = |moved: &Vec<S::Vector>| -> f64 {
                let terms = forces[k].iter().enumerate().filter(|(_, force)| **force != 0.0);
                let of_term = |(unknown, force): (usize, &f64)| {
                    let (node, c) = dofs.unknown(unknown);
                    force * dofs.component(node, c, moved[node])
                };
                terms.map(of_term).sum()
            };
            let mut along: Vec<f64> = free.iter().map(along).collect();
            if loads {
                along.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
            let forward = condensed.forward(forces[k].to_vec(), loads);
            let load = condensed.condensed_part(&forward);
            (forward, (load, along))
        };
        let (forward, condensed): (Vec<Vec<f64>>, Vec<_>) = each_body(parts.len(), of).into_iter().unzip();
        (forward, self.broken.load_of(&condensed))
    }

    /// Computes the displacement under forces, and with the body's loads and what supports impose, if asked.
    fn field(&self, forces: Vec<&[f64]>, loads: bool) -> Vec<S::Vector> {
        let (forward, load) = self.condensed(&forces, loads);
        let x = solve(&self.broken, &self.linear, &load);
        let field = |k: usize, condensed: &CondensedBody<S>| {
            condensed.recovered(forward[k].clone(), &x[self.broken.of_body(k)], loads)
        };
        joined(self.body, field)
    }

    fn residual_energy(&self, residual: &[f64]) -> ResidualEnergy {
        let (forward, load) = self.condensed(&self.split(residual), false);
        let inside = |(forward, of): (&Vec<f64>, &Subdomain<S>)| -> f64 {
            forward[..forward.len() - of.shared.len()].iter().map(|y| y * y).sum()
        };
        ResidualEnergy {
            inside: forward.iter().zip(self.body.subdomains()).map(inside).sum(),
            interface: self.linear.energy_bound(&self.broken, &load.forces),
        }
    }
}

/// Solves for the traces under a load, to round-off.
fn solve(broken: &Broken<'_>, linear: &Balancing, load: &Load) -> Vec<f64> {
    let mut inner = linear.step_1(broken, load, &vec![0.0; broken.len()]);
    let [floor, noise] = [FLOOR, NOISE].map(|part| part * part * inner.energy);
    for _ in 0..=RESTARTS {
        let (before, x) = (inner.squared, inner.x.clone());
        // What is only rounding grows.
        let is_noise = |squared: f64| squared <= floor || squared <= noise && squared > before;
        while !is_noise(inner.squared) && linear.update(broken, &mut inner) {}
        let again = linear.step_1_again(broken, load, &inner.x);
        if !(again.squared < GAIN * GAIN * before) {
            return if again.squared < before { inner.x } else { x };
        }
        inner = again;
    }
    inner.x
}

/// Joins the fields of all subdomains.
fn joined<S: Space>(
    body: &CutBody<S>,
    field: impl Fn(usize, &CondensedBody<S>) -> Vec<S::Vector> + Sync,
) -> Vec<S::Vector> {
    let parts = body.subdomains();
    body.joined(&each_body(parts.len(), |k| field(k, &parts[k].condensed)))
}

/// Computes the displacement of nearly least energy of a body that has given traces, without loads and with supports at rest (Cartesian, m), and the largest
/// difference of its traces from the given ones, m: supports may not allow them.
///
/// * `traces`: along the retained directions, block by block, m.
///
/// # Errors
/// See [`BalancingError`].
pub fn correction_from_traces<S: Space>(
    prepared: &PreparedProblem<S>,
    body: usize,
    traces: &[Vec<f64>],
) -> Result<(Vec<S::Vector>, f64), BalancingError> {
    let system = prepared.system_of(body, traces);
    // The traces resist motions of a body that its supports do not hold.
    let motions = &system.rows.motions;
    let mut lines = SparseRows::new(system.rows.len());
    motions.iter().for_each(|of| lines.push(of.traces.iter().copied()));
    let groups = vec![0; motions.len()];
    let resisted = RowSelection::new(&lines, &vec![0.0; motions.len()], &groups, S::NORMAL_ERROR)?.rows;
    let broken = Broken::new(Cow::Owned(system), &resisted)?;
    let count = broken.rows.len();
    let closed = Skeleton::new(&broken, &vec![true; count], &vec![0.0; count]);
    let linear = Balancing::new(&broken, closed)?;
    let load = Load { forces: vec![0.0; broken.len()], size: 0.0 };
    // The traces are given at every iteration: what is left costs energy alone.
    let mut inner = linear.step_1(&broken, &load, &vec![0.0; broken.len()]);
    let enough = ENOUGH * ENOUGH * inner.energy;
    while inner.squared > enough && linear.update(&broken, &mut inner) {}
    let x = inner.x;
    let defect = broken.openings(&x).iter().fold(0.0f64, |most, o| most.max(o.abs()));
    let field = |k: usize, condensed: &CondensedBody<S>| {
        condensed.recovered(vec![0.0; condensed.dofs().len()], &x[broken.of_body(k)], false)
    };
    let field = match &prepared.bodies()[body] {
        FactorisedBody::Whole(condensed) => field(0, condensed),
        FactorisedBody::Cut(cut) => joined(cut, field),
    };
    Ok((field, defect))
}

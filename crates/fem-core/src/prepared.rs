//! A contact problem that is ready to be solved.

use crate::assembly::{AssemblyError, System, external_forces};
use crate::body::{Body, Cut};
use crate::condensation::{CondensationError, CondensedBody};
use crate::dof::DofMap;
use crate::geometry::Point;
use crate::interface::{ContactPair, ContactProblem, Roles};
use crate::mesh::MeshError;
use crate::parallel::each_body;
use crate::space::{Plane, Space};
use crate::subdomains::{CutBody, FactorError, may_be_cut};

pub use crate::motions::{AssemblyMotion, BodyMotion};
use rayon::prelude::*;
use thiserror::Error;

/// A contact problem with its factorised bodies and their loads: all that an iteration and an estimator need. Bodies that
/// their supports do not hold are factorised with springs, see [`System::stabilised`].
#[derive(Clone, Debug)]
pub struct PreparedProblem<S: Space = Plane> {
    problem: ContactProblem<S>,
    bodies: Vec<FactorisedBody<S>>,
    external_forces: Vec<Vec<S::Vector>>,
    rigid_motions: Vec<BodyMotion<S>>,
}

/// The next step of the preparation, for all bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The order of the unknowns, and the tree of fronts.
    Ordering,
    /// Stiffness and load.
    Assembly,
    /// The factor and the interface operator.
    Factorisation,
    /// Nothing: all is ready.
    Ready,
}

/// A body, factorised in one piece or in subdomains.
#[derive(Clone, Debug)]
pub enum FactorisedBody<S: Space = Plane> {
    /// In one piece.
    Whole(Box<CondensedBody<S>>),
    /// In subdomains.
    Cut(CutBody<S>),
}

impl<S: Space> FactorisedBody<S> {
    /// Returns the factor of a body in one piece.
    pub fn whole(&self) -> Option<&CondensedBody<S>> {
        match self {
            Self::Whole(body) => Some(body),
            Self::Cut(_) => None,
        }
    }

    /// Returns a body in subdomains.
    pub fn cut(&self) -> Option<&CutBody<S>> {
        match self {
            Self::Whole(_) => None,
            Self::Cut(body) => Some(body),
        }
    }

    /// Counts the unknowns.
    pub fn unknowns(&self) -> usize {
        match self {
            Self::Whole(body) => body.dofs().len(),
            Self::Cut(body) => body.unknowns(),
        }
    }

    /// Counts its factors: one, or one for each subdomain.
    pub fn factors(&self) -> usize {
        self.cut().map_or(1, |cut| cut.subdomains().len())
    }
}

/// Why a problem could not be prepared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// A system that cannot be assembled.
    #[error("body {}: {source}", body + 1)]
    Assembly {
        /// The body, from 0.
        body: usize,
        /// The error of the assembly.
        source: AssemblyError,
    },
    /// A stiffness that cannot be factorised.
    #[error("body {}: {source}", body + 1)]
    Factor {
        /// The body, from 0.
        body: usize,
        /// The error of the factorisation.
        source: CondensationError,
    },
    /// The cells of a subdomain make no mesh.
    #[error("body {}: {source}", body + 1)]
    Subdomain {
        /// The body, from 0.
        body: usize,
        /// The cause.
        source: MeshError,
    },
    /// A bonded pair, whose bodies were not joined.
    #[error("pair {} is bonded; join its bodies first, see `fem_core::interface::Bonds`", pair + 1)]
    Bonded {
        /// The pair, from 0.
        pair: usize,
    },
    /// A contact at the rim of a cut that is not free along its axis.
    #[error(
        "pair {}: its contact continues across a cut at {point}, and is pressed or rubbed along the axis of the cut there", pair + 1
    )]
    ContactAcrossCut {
        /// The pair, from 0.
        pair: usize,
        /// The middle of a facet.
        point: Point,
    },
    /// The caller ended it.
    #[error("ended before all bodies were factorised")]
    Stopped,
}

impl<S: Space> PreparedProblem<S> {
    /// Assembles and factorises all bodies, in parallel.
    ///
    /// # Errors
    /// A body without unique solution.
    pub fn new(problem: ContactProblem<S>) -> Result<Self, PrepareError> {
        Self::prepare(problem, &[], |_| true)
    }

    /// [`Self::new`], asking before each stage whether to continue.
    ///
    /// * `subdomains`: of each body, how many; missing entries count as 1. Bodies with rigid sides or with cuts of bolts stay in one piece.
    ///
    /// # Errors
    /// A body without unique solution; [`PrepareError::Stopped`] if the answer is `false`.
    pub fn prepare(
        problem: ContactProblem<S>,
        subdomains: &[usize],
        mut proceed: impl FnMut(Stage) -> bool,
    ) -> Result<Self, PrepareError> {
        let mut before = |stage| if proceed(stage) { Ok(()) } else { Err(PrepareError::Stopped) };
        if let Some(pair) = problem.contacts.iter().position(ContactPair::<S>::is_bonded) {
            return Err(PrepareError::Bonded { pair });
        }
        if let Some((pair, point)) = problem.contact_across_cut() {
            return Err(PrepareError::ContactAcrossCut { pair, point: point.into() });
        }
        let wanted =
            |b: usize| subdomains.get(b).copied().filter(|_| may_be_cut(&problem.bodies[b])).unwrap_or(1);
        let (whole, cut): (Vec<usize>, Vec<usize>) = (0..problem.bodies.len()).partition(|b| wanted(*b) <= 1);
        before(Stage::Ordering)?;
        let dofs =
            each_body(whole.len(), |k| DofMap::new(&problem.bodies[whole[k]], &problem.side(whole[k])));
        before(Stage::Assembly)?;
        let assemble = |(k, dofs): (usize, DofMap<S>)| {
            System::stabilised(&problem.bodies[whole[k]], dofs)
                .map_err(|source| PrepareError::Assembly { body: whole[k], source })
        };
        let systems = each_of(dofs, assemble)?;
        before(Stage::Factorisation)?;
        let factorise = |(k, system): (usize, System<S>)| {
            CondensedBody::factorise(system, problem.bodies[whole[k]].mesh().points())
                .map_err(|source| PrepareError::Factor { body: whole[k], source })
        };
        let mut whole = each_of(systems, factorise)?.into_iter();
        let mut bodies = Vec::with_capacity(problem.bodies.len());
        for body in 0..problem.bodies.len() {
            bodies.push(match cut.binary_search(&body) {
                Ok(_) => FactorisedBody::Cut(
                    CutBody::new(&problem.bodies[body], &problem.side(body), wanted(body))
                        .map_err(|error| of_subdomain(body, error))?,
                ),
                Err(_) => match whole.next() {
                    Some(found) => FactorisedBody::Whole(Box::new(found)),
                    None => unreachable!("{} factors for {} bodies", bodies.len(), problem.bodies.len()),
                },
            });
        }
        before(Stage::Ready)?;
        Ok(Self::of(problem, bodies))
    }

    /// Prepares a problem whose bodies differ from factorised ones in the amounts of what their conditions impose, see
    /// [`ContactProblem::with_factors`]: nothing is factorised, unless the supports of a body are others.
    ///
    /// * `factorised`: as [`Self::into_parts`] returns them; with none, or with bodies in subdomains, this is [`Self::prepare`].
    ///
    /// # Errors
    /// See [`Self::prepare`].
    pub fn prepare_again(
        problem: ContactProblem<S>,
        factorised: Vec<FactorisedBody<S>>,
        subdomains: &[usize],
        mut proceed: impl FnMut(Stage) -> bool,
    ) -> Result<Self, PrepareError> {
        let whole = |body| match body {
            FactorisedBody::Whole(body) => Some(*body),
            FactorisedBody::Cut(_) => None,
        };
        let factorised: Vec<CondensedBody<S>> = factorised.into_iter().filter_map(whole).collect();
        let known = |(b, body): (usize, &CondensedBody<S>)| {
            body.dofs().with_imposed(problem.bodies.get(b)?, &problem.side(b))
        };
        let dofs: Option<Vec<DofMap<S>>> = factorised.iter().enumerate().map(known).collect();
        let Some(dofs) = dofs.filter(|dofs| dofs.len() == problem.bodies.len()) else {
            return Self::prepare(problem, subdomains, proceed);
        };
        let mut before = |stage| if proceed(stage) { Ok(()) } else { Err(PrepareError::Stopped) };
        before(Stage::Assembly)?;
        let load = |(b, (body, dofs)): (usize, (CondensedBody<S>, DofMap<S>))| {
            let system = System::stabilised(&problem.bodies[b], dofs)
                .map_err(|source| PrepareError::Assembly { body: b, source })?;
            Ok(FactorisedBody::Whole(Box::new(body.with_loads(system))))
        };
        let bodies = each_of(factorised.into_iter().zip(dofs).collect(), load)?;
        before(Stage::Ready)?;
        Ok(Self::of(problem, bodies))
    }

    fn of(problem: ContactProblem<S>, bodies: Vec<FactorisedBody<S>>) -> Self {
        let external_forces = each_body(bodies.len(), |b| external_forces(&problem.bodies[b]));
        let rigid_motions = problem.rigid_motions_under(&external_forces);
        Self { problem, bodies, external_forces, rigid_motions }
    }

    /// Returns the problem.
    pub fn problem(&self) -> &ContactProblem<S> {
        &self.problem
    }

    /// Returns the problem and its factorised bodies.
    pub fn into_parts(self) -> (ContactProblem<S>, Vec<FactorisedBody<S>>) {
        (self.problem, self.bodies)
    }

    /// Returns the factorised bodies.
    pub fn bodies(&self) -> &[FactorisedBody<S>] {
        &self.bodies
    }

    /// Returns a factorised body in one piece, to replace its condensed load.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn whole_mut(&mut self, body: usize) -> Option<&mut CondensedBody<S>> {
        match &mut self.bodies[body] {
            FactorisedBody::Whole(body) => Some(body),
            FactorisedBody::Cut(_) => None,
        }
    }

    /// Returns the nodal forces of tractions and body force of each body, Cartesian, N/m.
    pub fn external_forces(&self) -> &[Vec<S::Vector>] {
        &self.external_forces
    }

    /// Returns the rigid motions of all floating bodies, in the order of the bodies: for each body a basis.
    pub fn rigid_motions(&self) -> &[BodyMotion<S>] {
        &self.rigid_motions
    }

    /// Computes the displacement of each node in a rigid motion, see [`ContactProblem::moved_by`].
    pub fn moved_by(&self, of: &BodyMotion<S>) -> Vec<S::Vector> {
        self.problem.moved_by(of)
    }

    /// Computes the displacements of the nodes of a body without loads under a unit shortening of each cut whose force is given, each with the number
    /// of the body.
    pub fn cut_responses(&self) -> Vec<(usize, Vec<S::Vector>)> {
        let bodies = self.problem.bodies.iter().zip(&self.bodies).enumerate();
        let of_body = |(b, (body, factorised)): (usize, (&Body<S>, &FactorisedBody<S>))| {
            // Bodies with such cuts are in one piece.
            let Some(condensed) = factorised.whole() else { return Vec::new() };
            let given = body.cuts().iter().filter(|cut| cut.force.is_some());
            let response = |cut: &Cut<S>| {
                let mut solution = condensed.rough_along_unknowns(&body.unit_cut_forces(cut));
                condensed.factor().solve(&mut solution);
                (b, condensed.dofs().correction(&solution))
            };
            given.map(response).collect::<Vec<_>>()
        };
        bodies.flat_map(of_body).collect()
    }

    /// Counts the pairs of nodes of all pairs.
    pub fn node_pairs(&self) -> usize {
        self.problem.node_pairs()
    }

    /// Counts the rows of all pairs, see [`ContactProblem::rows`].
    pub fn rows(&self) -> usize {
        self.problem.rows()
    }

    /// Gives the bodies of a pair other roles. No body changes, and no factor.
    ///
    /// # Panics
    /// If there is no such pair.
    pub fn set_roles(&mut self, pair: usize, roles: Roles) {
        self.problem.contacts[pair].roles = roles;
    }

    /// Replaces the gaps of a pair, m, and returns the old ones: the problem for increments about a state.
    ///
    /// # Panics
    /// If there is no such pair, or not one gap per pair of nodes.
    pub fn replace_gaps(&mut self, pair: usize, gaps: &[f64]) -> Vec<f64> {
        self.problem.contacts[pair].interface.replace_gaps(gaps)
    }
}

/// Names the body of a subdomain that could not be factorised.
fn of_subdomain(body: usize, error: FactorError) -> PrepareError {
    match error {
        FactorError::Mesh(source) => PrepareError::Subdomain { body, source },
        FactorError::Assembly(source) => PrepareError::Assembly { body, source },
        FactorError::Condensation(source) => PrepareError::Factor { body, source },
    }
}

/// Makes something of what there is of each body, in parallel.
fn each_of<T: Send, U: Send, E: Send>(
    bodies: Vec<T>,
    make: impl Fn((usize, T)) -> Result<U, E> + Sync + Send,
) -> Result<Vec<U>, E> {
    let made: Vec<Result<U, E>> = bodies.into_par_iter().enumerate().with_max_len(1).map(make).collect();
    made.into_iter().collect()
}

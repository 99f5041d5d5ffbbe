//! Problems with bonded pairs: their bodies are joined, solved as one, and the solution is given back to each of them.

use crate::error::SolveError;
use crate::results::{self, Results};
use crate::settings::Settings;
use crate::solution::CertifiedSolution;
use crate::space::ContactSpace;
use fem_core::assembly::external_forces;
use fem_core::geometry::Coordinates;
use fem_core::interface::{Bonds, ContactProblem, Partner};
use fem_core::prepared::{AssemblyMotion, PrepareError};
use fem_core::space::Space;
use nndd::{ActiveSet, NnddError, Start};

/// Takes the start of the pairs of nodes that the joined problem has.
pub(crate) fn start_of<S: Space>(bonds: &Bonds<S>, start: &Start) -> Start {
    let active = start.active.as_ref().map(|active| ActiveSet::new(bonds.kept(active.as_slice())));
    Start { lambda: bonds.kept(&start.lambda), active }
}

/// Takes the settings of the pairs that the joined problem has.
pub(crate) fn settings_of<S: Space>(bonds: &Bonds<S>, settings: &Settings<S>) -> Settings<S> {
    let pairs = settings.imposed_by_pair.iter().zip(&bonds.pairs);
    let imposed_by_pair = pairs.filter(|(_, joined)| joined.is_some()).map(|(imposed, _)| *imposed).collect();
    Settings { imposed_by_pair, ..settings.clone() }
}

/// Gives the solution of the joined problem back to the bodies that were joined.
///
/// * `bonds`: made of `problem`, without the joined problem, which is the one of the solution.
pub(crate) fn separated<S: ContactSpace>(
    mut problem: ContactProblem<S>,
    mut bonds: Bonds<S>,
    solution: CertifiedSolution<S>,
) -> CertifiedSolution<S> {
    bonds.joined = solution.problem;
    for (pair, joined) in problem.contacts.iter_mut().zip(&bonds.pairs) {
        if let Some(k) = joined {
            pair.roles = bonds.joined.contacts[*k].roles;
        }
    }
    for (joined, whole) in bonds.joined.bodies.iter().enumerate() {
        let mut found = whole.cuts().iter().map(|cut| cut.shortening);
        for member in bonds.members(joined) {
            let body = &mut problem.bodies[member];
            let own: Vec<f64> = found.by_ref().take(body.cuts().len()).collect();
            body.shorten(&own);
        }
    }
    let first = |body: usize| bonds.members(body).next().unwrap_or(body);
    problem.left_out = bonds.joined.left_out.clone();
    problem.left_out.iter_mut().for_each(|of| of.body = first(of.body));
    let mut nndd = solution.nndd;
    nndd.last = nndd.last.spread(&bonds.node_pairs);
    let estimate = solution.estimate.map(|estimate| estimate.of_parts(&problem, &bonds));
    let forces: Vec<Vec<S::Vector>> = problem.bodies.iter().map(external_forces).collect();
    let cut = |joined: usize| bonds.members(joined).map(move |member| (member, joined));
    let mut subdomains = vec![1; problem.bodies.len()];
    for (member, joined) in (0..solution.subdomains.len()).flat_map(cut) {
        subdomains[member] = solution.subdomains[joined];
    }
    let results = estimate.as_ref().zip(solution.results).map(|(estimate, whole)| {
        let own = results::results((&problem, &forces, &subdomains), &nndd.last, estimate, None);
        with_reactions(&problem, &bonds, own, whole)
    });
    // The offsets do work as well.
    let work: f64 = forces
        .iter()
        .zip(&bonds.parts)
        .map(|(forces, part)| forces.iter().map(|f| f.times(&part.offset)).sum::<f64>())
        .sum();
    let bounds = solution.bounds.map(|mut bounds| {
        bounds.potential_energy.iter_mut().for_each(|bound| *bound -= work);
        let number =
            |joined: usize| bonds.pairs.iter().position(|pair| *pair == Some(joined)).unwrap_or(joined);
        bounds.contact_force = bounds.contact_force.map_err(|reason| reason.renumbered(number));
        bounds
    });
    let unknowns = unknowns(&problem, &bonds, &solution.unknowns);
    CertifiedSolution { problem, nndd, estimate, results, bounds, unknowns, subdomains, ..solution }
}

/// Takes the reactions of supports and rigid sides from the results of the joined bodies: at a merged node a support takes the forces of all of them.
fn with_reactions<S: Space>(
    problem: &ContactProblem<S>,
    bonds: &Bonds<S>,
    own: Results<S>,
    whole: Results<S>,
) -> Results<S> {
    // The supports of a joined body are those of its members, one after the other.
    let order = |count: &dyn Fn(usize) -> usize| -> Vec<usize> {
        let members = (0..bonds.joined.bodies.len()).flat_map(|joined| bonds.members(joined));
        members.flat_map(|member| std::iter::repeat_n(member, count(member))).collect()
    };
    let mut reactions = whole.reactions;
    let supports = order(&|body| problem.bodies[body].supports().len());
    reactions.iter_mut().zip(supports).for_each(|(reaction, body)| reaction.body = body);
    reactions.sort_by_key(|reaction| reaction.body);
    let mut rigid_sides = whole.rigid_sides;
    let sides = order(&|body| problem.bodies[body].rigid_sides().len());
    for (side, body) in rigid_sides.iter_mut().zip(sides) {
        side.body = body;
        side.motion.translation += bonds.parts[body].offset;
    }
    rigid_sides.sort_by_key(|side| side.body);
    Results { reactions, rigid_sides, ..own }
}

/// Counts the unknowns of each body: merged nodes count in the first of their bodies.
fn unknowns<S: Space>(problem: &ContactProblem<S>, bonds: &Bonds<S>, joined: &[usize]) -> Vec<usize> {
    let mut left = joined.to_vec();
    let mut found = vec![0; problem.bodies.len()];
    for body in 0..joined.len() {
        let members: Vec<usize> = bonds.members(body).collect();
        let nodes: usize = members.iter().map(|member| problem.bodies[*member].mesh().points().len()).sum();
        for member in members.iter().skip(1) {
            let share = problem.bodies[*member].mesh().points().len() as f64 / nodes as f64;
            found[*member] = (joined[body] as f64 * share) as usize;
            left[body] -= found[*member];
        }
        if let Some(first) = members.first() {
            found[*first] = left[body];
        }
    }
    found
}

/// Says which of the given bodies move.
pub(crate) fn of_members<S: Space>(bonds: &Bonds<S>, mut of: AssemblyMotion<S>) -> AssemblyMotion<S> {
    let (bodies, largest) = (std::mem::take(&mut of.bodies), std::mem::take(&mut of.largest));
    for ((partner, motion), size) in bodies.into_iter().zip(largest) {
        let members: Vec<Partner> = match partner.body() {
            Some(body) => bonds.members(body).map(Partner::Body).collect(),
            None => vec![partner],
        };
        of.largest.extend(members.iter().map(|_| size));
        of.bodies.extend(members.into_iter().map(|member| (member, motion)));
    }
    of
}

impl<S: Space> SolveError<S> {
    /// Says what an error of the joined bodies means for the given ones.
    pub(crate) fn of_members(self, bonds: &Bonds<S>) -> Self {
        let first = |body: usize| bonds.members(body).next().unwrap_or(body);
        let number =
            |joined: usize| bonds.pairs.iter().position(|pair| *pair == Some(joined)).unwrap_or(joined);
        match self {
            Self::Nndd(NnddError::WithinABody { pair }) => {
                Self::Nndd(NnddError::WithinABody { pair: number(pair) })
            }
            Self::NotHeld { motion } => Self::NotHeld { motion: of_members(bonds, motion) },
            Self::OutsideCones { motion } => Self::OutsideCones { motion: of_members(bonds, motion) },
            Self::Prepare(PrepareError::Assembly { body, source }) => {
                Self::Prepare(PrepareError::Assembly { body: first(body), source })
            }
            Self::Prepare(PrepareError::Factor { body, source }) => {
                Self::Prepare(PrepareError::Factor { body: first(body), source })
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests;

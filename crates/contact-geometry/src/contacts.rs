//! A contact problem of bodies and the names of their sides: surfaces are paired as they are if their nodes match, and refined to match if
//! they do not.

use super::ContactNormal;
use super::common_refinement::{Changes, CommonRefinementError, Measured, Surfaces, common_refinements};
use super::facing::{FacingSide, facing_edges};
use super::obstacle::against;
use super::overlay::{OverlayChanges, OverlayError};
use super::pairing::pair_surfaces;
use fem_core::body::{Body, BodyError};
use fem_core::geometry::norm;
use fem_core::interface::{ContactInterface, ContactProblem, Friction, Gap, InterfaceError, Obstacle};
use fem_core::mesh::id::FacetId;
use fem_core::space::{Plane, Space};
use std::collections::{BTreeSet, HashMap};
use thiserror::Error;

/// Surfaces whose edges are farther from a smooth curve, in their lengths, are bent.
const BENT: f64 = 1e-6;
/// A pair is refined at most this often: another pair of the same body may put nodes on its line.
const MOST_REFINEMENTS: usize = 4;

/// A pair as its user describes it.
#[derive(Clone, Debug)]
pub struct Contact<S: Space = Plane> {
    /// Its name, which names copies of sides that belong to it alone.
    pub name: String,
    /// The sides that may touch.
    pub sides: Sides<S>,
    /// The law of friction.
    pub friction: Option<Friction<S>>,
}

/// The sides of a pair.
#[derive(Clone, Debug)]
pub enum Sides<S: Space = Plane> {
    /// A side of each of two bodies.
    Bodies {
        /// The numbers of the bodies.
        bodies: [usize; 2],
        /// A group of facets of each.
        surfaces: [String; 2],
        /// The initial gap.
        gap: Gap<S>,
        /// The direction of contact.
        normal: ContactNormal<S>,
    },
    /// A side of a body, and an obstacle.
    Obstacle {
        /// The number of the body.
        body: usize,
        /// Its group of facets.
        surface: String,
        /// The obstacle.
        obstacle: Obstacle<S>,
        /// The initial gap; the distance from the obstacle if it is not given.
        gap: Option<Gap<S>>,
    },
}

impl<S: Space> Sides<S> {
    /// Lists the bodies and their sides.
    pub fn members(&self) -> impl Iterator<Item = (usize, &String)> {
        let (first, second) = match self {
            Self::Bodies { bodies: [a, b], surfaces: [first, second], .. } => {
                ((*a, first), Some((*b, second)))
            }
            Self::Obstacle { body, surface, .. } => ((*body, surface), None),
        };
        std::iter::once(first).chain(second)
    }
}

/// A problem, and what refining surfaces in common changed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Paired<S: Space = Plane> {
    /// The problem; pairs in the order given.
    pub problem: ContactProblem<S>,
    /// By pair; `None` if its surfaces match as they are.
    pub refined: Vec<Option<Refined>>,
    /// The same of surfaces of solids.
    pub overlaid: Vec<Option<OverlayChanges>>,
}

impl<S: Space> Paired<S> {
    /// Takes a problem whose surfaces match as they are.
    pub fn of(problem: ContactProblem<S>) -> Self {
        let count = problem.contacts.len();
        Self { problem, refined: vec![None; count], overlaid: vec![None; count] }
    }
}

/// The common refinement of a pair.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Refined {
    /// The nodes that it added and moved.
    pub changes: Changes,
    /// True if the surfaces are bent: a measured gap is taken between smooth curves.
    pub bent: bool,
    /// Lengths of the surfaces as they were, m.
    pub lengths: [f64; 2],
}

/// Why bodies and sides make no contact problem.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PairingError {
    /// The surfaces of a pair cannot be paired.
    #[error("pair {pair}: {error}")]
    Interface {
        /// The number of the pair.
        pair: usize,
        /// The reason.
        error: InterfaceError,
    },
    /// The surfaces of a pair have no common refinement.
    #[error("pair {pair}: {error}")]
    Refinement {
        /// The number of the pair.
        pair: usize,
        /// The reason.
        error: CommonRefinementError,
    },
    /// The surfaces of a pair of solids cannot be laid over each other.
    #[error("pair {pair}: {error}")]
    Overlay {
        /// The number of the pair.
        pair: usize,
        /// The reason.
        error: OverlayError,
    },
    /// The conditions of a body do not fit its refined mesh.
    #[error("body {body}: {error}")]
    Body {
        /// The number of the body.
        body: usize,
        /// The reason.
        error: BodyError,
    },
}

/// Pairs the sides of bodies. If the nodes of two surfaces do not match, both get a common refinement.
///
/// ```
/// # use contact_geometry::{Contact, ContactNormal, Sides, paired};
/// # use fem_core::{body::Body, boundary::BoundaryConditions, interface::Gap, mesh::generate::block};
/// # use fem_core::material::{Hypothesis, LinearElastic};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain)?;
/// # let body = |y: f64, cells: usize| -> Result<Body, Box<dyn std::error::Error>> {
/// #     Ok(Body::new(block([0.0, y], [2.0, 1.0], [cells, 2])?, steel.clone(), &BoundaryConditions::new())?)
/// # };
/// let (upper, lower) = (body(1.0, 4)?, body(0.0, 3)?);
/// let surfaces = ["bottom", "top"].map(str::to_owned);
/// let sides = Sides::Bodies { bodies: [0, 1], surfaces, gap: Gap::Touching, normal: ContactNormal::Averaged };
/// let contact = Contact { name: "blocks".to_owned(), sides, friction: None };
/// let paired = paired(vec![upper, lower], &[contact])?;
/// assert_eq!(paired.problem.contacts[0].interface.pairs().len(), 7);
/// assert!(paired.refined[0].is_some());
/// # Ok(()) }
/// ```
///
/// # Errors
/// Surfaces that cannot be paired and have no common refinement, a law of friction that makes no sense, and conditions that do
/// not fit a refined mesh.
///
/// # Panics
/// If there is no such body.
pub fn paired(bodies: Vec<Body>, contacts: &[Contact]) -> Result<Paired, PairingError> {
    let count = contacts.len();
    let sides = contacts.iter().map(|c| c.sides.members().map(|(_, side)| side.clone()).collect());
    let (measured, refined) = (vec![None; count], vec![None; count]);
    let mut matching = Matching { contacts, sides: sides.collect(), measured, refined, bodies };
    matching.separate_sides();
    let interfaces = matching.interfaces()?;
    let problem = assembled(matching.bodies, contacts, interfaces)?;
    Ok(Paired { refined: matching.refined, ..Paired::of(problem) })
}

/// Makes the problem of bodies and the interfaces of their pairs.
///
/// # Errors
/// A law of friction that makes no sense.
pub(super) fn assembled<S: Space>(
    bodies: Vec<Body<S>>,
    contacts: &[Contact<S>],
    interfaces: Vec<ContactInterface<S>>,
) -> Result<ContactProblem<S>, PairingError> {
    let mut problem = ContactProblem::new(bodies);
    for (pair, (contact, interface)) in contacts.iter().zip(interfaces).enumerate() {
        problem = match &contact.sides {
            Sides::Bodies { bodies, .. } => problem.contact(*bodies, interface),
            Sides::Obstacle { body, obstacle, .. } => problem.obstacle(*body, interface, obstacle.clone()),
        };
        if let Some(friction) = &contact.friction {
            problem = problem
                .with_friction(pair, friction.clone())
                .map_err(|error| PairingError::Interface { pair, error })?;
        }
    }
    Ok(problem)
}

/// Bodies while their contact surfaces are made to match.
struct Matching<'a> {
    contacts: &'a [Contact],
    bodies: Vec<Body>,
    /// The contact sides of each pair: the sides given, or copies that belong to the pair alone.
    sides: Vec<Vec<String>>,
    /// The common refinement of each pair, as it was measured; `None` if the nodes of its surfaces match.
    measured: Vec<Option<Measured>>,
    refined: Vec<Option<Refined>>,
}

impl Matching<'_> {
    /// Pairs the surfaces of all pairs, those that do not match after a common refinement: then all pairs of the changed bodies are made again.
    fn interfaces(&mut self) -> Result<Vec<ContactInterface>, PairingError> {
        let count = self.contacts.len();
        let mut of_body: HashMap<usize, Vec<usize>> = HashMap::new();
        for (k, contact) in self.contacts.iter().enumerate() {
            contact.sides.members().for_each(|(b, _)| of_body.entry(b).or_default().push(k));
        }
        let mut refined = vec![0; count];
        let mut interfaces: Vec<Option<ContactInterface>> = (0..count).map(|_| None).collect();
        let mut missing: Vec<usize> = (0..count).collect();
        while !missing.is_empty() {
            // The pairs that are to be refined, each with the reason.
            let mut waiting: Vec<(usize, InterfaceError)> = Vec::new();
            let mut again = BTreeSet::new();
            for pair in missing {
                let error = match self.interface(pair) {
                    Ok(interface) => {
                        interfaces[pair] = Some(interface);
                        continue;
                    }
                    Err(error) => error,
                };
                again.insert(pair);
                let first = refined[pair] == 0;
                let apart = matches!(error, InterfaceError::NotFacing { .. }) && first;
                if apart && self.take_facing(pair) {
                    continue;
                }
                let occupied = matches!(error, InterfaceError::Occupied { .. }) && first;
                let mismatch = error.is_mismatch() && refined[pair] < MOST_REFINEMENTS;
                if self.surfaces(pair).is_some() && (occupied || mismatch) {
                    waiting.push((pair, error));
                } else if again.len() == 1 {
                    return Err(PairingError::Interface { pair, error });
                }
            }
            for body in self.refine(&waiting, &mut refined)? {
                // Pairs of one body may share nodes.
                again.extend(of_body.get(&body).into_iter().flatten());
            }
            missing = again.into_iter().collect();
        }
        Ok(interfaces.into_iter().flatten().collect())
    }

    /// Gives pairs that share a side, and pairs with a side on which something acts, sides of their own: each takes what faces
    /// it, and the rest keeps its conditions.
    fn separate_sides(&mut self) {
        let contacts = self.contacts;
        let mut uses: HashMap<(usize, &str), usize> = HashMap::new();
        for (b, side) in contacts.iter().flat_map(|contact| contact.sides.members()) {
            *uses.entry((b, side)).or_default() += 1;
        }
        let mut known: HashMap<(usize, &str), FacingSide> = HashMap::new();
        for (pair, contact) in contacts.iter().enumerate() {
            let shared = |(b, side): (usize, &String)| {
                let body = &self.bodies[b];
                let edges = body.mesh().group(side).unwrap_or(&[]);
                uses[&(b, side.as_str())] > 1 || edges.iter().any(|edge| !body.is_free(*edge))
            };
            let Sides::Bodies { bodies: [a, b], surfaces: [first, second], .. } = &contact.sides else {
                continue;
            };
            if contact.sides.members().any(shared) {
                let both = [(*a, first.as_str()), (*b, second.as_str())];
                for of in both {
                    known.entry(of).or_insert_with(|| FacingSide::new(&self.bodies[of.0], of.1));
                }
                self.take_edges(pair, facing_edges(both.map(|of| &known[&of])));
            }
        }
    }

    /// Returns the surfaces of a pair of bodies as they are now; `None` against an obstacle.
    fn surfaces(&self, pair: usize) -> Option<Surfaces<'_>> {
        match (&self.contacts[pair].sides, &self.sides[pair][..]) {
            (Sides::Bodies { bodies, normal, .. }, [first, second]) => {
                Some(Surfaces { bodies: *bodies, groups: [first, second], normal: *normal })
            }
            _ => None,
        }
    }

    /// Gives a pair sides of its own, with the edges that face each other. Tells whether there are any, and fewer than
    /// before.
    fn take_facing(&mut self, pair: usize) -> bool {
        // Against an obstacle the pairing itself takes what faces it.
        let Some(Surfaces { bodies, groups, .. }) = self.surfaces(pair) else { return false };
        let sides = [0, 1].map(|k| FacingSide::new(&self.bodies[bodies[k]], groups[k]));
        self.take_edges(pair, facing_edges(sides.each_ref()))
    }

    fn take_edges(&mut self, pair: usize, edges: [Vec<FacetId>; 2]) -> bool {
        let Contact { name, sides, .. } = &self.contacts[pair];
        let before = sides.members().zip(&self.sides[pair]);
        let before = before.map(|((b, _), side)| self.bodies[b].mesh().group(side));
        let fewer = before.zip(&edges).any(|(before, now)| before.is_some_and(|all| all.len() > now.len()));
        if edges.iter().any(Vec::is_empty) {
            return false;
        }
        for (member, ((b, surface), edges)) in sides.members().zip(edges).enumerate() {
            let own = format!("{surface} in contact {name}");
            self.bodies[b].add_group(&own, edges);
            self.sides[pair][member] = own;
        }
        fewer
    }

    /// Pairs the surfaces of a pair, which may have been refined in common.
    fn interface(&self, pair: usize) -> Result<ContactInterface, InterfaceError> {
        match &self.contacts[pair].sides {
            Sides::Bodies { bodies, gap, normal, .. } => {
                let bodies = bodies.map(|b| &self.bodies[b]);
                let surfaces = [&*self.sides[pair][0], &*self.sides[pair][1]];
                match &self.measured[pair] {
                    Some(measured) => pair_surfaces(bodies, surfaces, gap, *normal, Some(measured)),
                    None => pair_surfaces(bodies, surfaces, gap, *normal, None),
                }
            }
            Sides::Obstacle { body, surface, obstacle, gap } => {
                against(&self.bodies[*body], surface, obstacle, gap.as_ref())
            }
        }
    }

    /// Refines the surfaces of pairs in common, of several at once if they are apart, and returns the bodies that were changed.
    ///
    /// * `waiting`: pairs of bodies, each with the reason why it must be refined; `refined`: how often each pair was refined.
    fn refine(
        &mut self,
        waiting: &[(usize, InterfaceError)],
        refined: &mut [usize],
    ) -> Result<BTreeSet<usize>, PairingError> {
        let sides = self.sides.clone();
        let surfaces = |(pair, _): &(usize, InterfaceError)| {
            let groups = [sides[*pair][0].as_str(), sides[*pair].get(1)?.as_str()];
            self.surfaces(*pair).map(|now| Surfaces { groups, ..now })
        };
        let surfaces: Vec<Surfaces<'_>> = waiting.iter().filter_map(surfaces).collect();
        let length =
            |pair: &Surfaces<'_>| [0, 1].map(|b| length(&self.bodies[pair.bodies[b]], pair.groups[b]));
        let lengths: Vec<[f64; 2]> = surfaces.iter().map(length).collect();
        let mut changed = BTreeSet::new();
        for (place, found) in common_refinements(&mut self.bodies, &surfaces) {
            let (pair, ref reason) = waiting[place];
            refined[pair] += 1;
            match found {
                Ok((measured, changes)) => {
                    if let Some(changes) = changes {
                        let mut facing = measured.facing.iter().flatten();
                        let bent = facing.any(|f| f.sagitta > BENT * f.spacing);
                        self.refined[pair] = Some(Refined { changes, bent, lengths: lengths[place] });
                    }
                    self.measured[pair] = Some(measured);
                    changed.extend(surfaces[place].bodies);
                }
                // Sides that face each other only in part.
                Err(_) if refined[pair] == 1 && self.take_facing(pair) => {}
                // The load on the side is what the user can change.
                Err(_) if matches!(reason, InterfaceError::Occupied { .. }) => {
                    return Err(PairingError::Interface { pair, error: reason.clone() });
                }
                Err(error) => return Err(PairingError::Refinement { pair, error }),
            }
        }
        for &body in &changed {
            // A part of a side may end at a new node.
            let reselected = self.bodies[body].reselected();
            self.bodies[body] = reselected.map_err(|error| PairingError::Body { body, error })?;
        }
        Ok(changed)
    }
}

/// Adds up the edges of a side.
fn length(body: &Body, side: &str) -> f64 {
    let edges = body.mesh().group(side).unwrap_or(&[]).iter();
    edges.map(|&edge| body.mesh().facet_corners(edge)).map(|[p, q]| norm(q - p)).sum()
}

//! Bodies, the pairs in which they touch, and a state of both.

use super::{
    ContactFacet, ContactInterface, Friction, Gap, InterfaceError, InterfaceSide, NodePair, Obstacle,
    Partner, Retained, RigidLine, Roles, SlipBefore,
};
use crate::body::{
    Body, BodyError, ConditionPlace, Cut, Difference, DifferenceSum, PERPENDICULAR, RigidMotion,
};
use crate::geometry::Coordinates;
use crate::mesh::id::FacetId;
use crate::space::{Plane, Solid, Space};
use std::ops::Range;
use thiserror::Error;

/// Two bodies in contact, or a body and an obstacle, and where.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactPair<S: Space = Plane> {
    /// The first body, by its number in [`ContactProblem::bodies`].
    pub body: usize,
    /// The second body, or an obstacle.
    pub partner: Partner,
    /// Their contact line.
    pub interface: ContactInterface<S>,
    /// Who carries λ in an iteration.
    pub roles: Roles,
    /// The law of friction.
    pub friction: Friction<S>,
    /// The slip of earlier load steps; `None` in the first step, from rest.
    pub slip_before: Option<SlipBefore<S>>,
}

impl<S: Space> ContactPair<S> {
    /// Joins a body and a partner without friction; the first body carries λ, or the obstacle.
    fn new(body: usize, partner: Partner, interface: ContactInterface<S>) -> Self {
        let roles = if partner.is_obstacle() { Roles::SECOND } else { Roles::FIRST };
        Self { body, partner, interface, roles, friction: Friction::None, slip_before: None }
    }

    /// Returns the first and the second partner.
    pub fn partners(&self) -> [Partner; 2] {
        [Partner::Body(self.body), self.partner]
    }

    /// Returns both bodies; `None` against an obstacle.
    pub fn bodies(&self) -> Option<[usize; 2]> {
        Some([self.body, self.partner.body()?])
    }

    /// Lists the sides that are bodies, both or the first: side and body.
    pub fn elastic_sides(&self) -> impl Iterator<Item = (usize, usize)> + use<S> {
        [Some(self.body), self.partner.body()].into_iter().flatten().enumerate()
    }

    /// Returns who carries λ, Ω₁; an obstacle always does.
    pub fn imposed(&self) -> Partner {
        self.partners()[self.roles.imposed()]
    }

    /// Returns the side of a partner in this pair, 0 or 1; `None` if it has none.
    pub fn side_of(&self, partner: Partner) -> Option<usize> {
        self.partners().iter().position(|of| *of == partner)
    }
}

/// Why conditions cannot be imposed with other amounts.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LoadFactorError {
    /// The conditions of a body.
    #[error("body {}: {source}", body + 1)]
    Body {
        /// Its number, from 0.
        body: usize,
        /// The error of this body.
        source: BodyError,
    },
    /// Clamped contact nodes.
    #[error(transparent)]
    Interface(#[from] InterfaceError),
}

/// A part of a body's load that was left out: it turns the body along its contact, which resists only by the error of the polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LeftOut<S: Space = Plane> {
    /// The body.
    pub body: usize,
    /// The motion, the largest displacement of the body is 1 m.
    pub motion: RigidMotion<S>,
    /// The load along the motion, N/m.
    pub load: f64,
    /// Over the sum of the sizes of its terms.
    pub share: f64,
}

/// Bodies, and the pairs in which they touch.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactProblem<S: Space = Plane> {
    /// The bodies.
    pub bodies: Vec<Body<S>>,
    /// The rigid obstacles.
    pub obstacles: Vec<Obstacle<S>>,
    /// The pairs.
    pub contacts: Vec<ContactPair<S>>,
    /// Loads that were left out; finer meshes and other amounts of the loads begin without.
    pub left_out: Vec<LeftOut<S>>,
    /// Forces of the rows that balance the loads, N/m, if it is known how the assembly is held: the question need not be asked again as long as
    /// they do. Empty if not.
    pub balancing: Vec<f64>,
}

impl<S: Space> ContactProblem<S> {
    /// Takes bodies that do not touch yet.
    pub fn new(bodies: Vec<Body<S>>) -> Self {
        Self {
            bodies,
            obstacles: Vec::new(),
            contacts: Vec::new(),
            left_out: Vec::new(),
            balancing: Vec::new(),
        }
    }

    /// Takes two bodies and the interface between them.
    pub fn between(bodies: [Body<S>; 2], interface: ContactInterface<S>) -> Self {
        Self::new(bodies.into()).contact([0, 1], interface)
    }

    /// Adds a pair.
    ///
    /// # Panics
    /// If there is no such body.
    #[must_use]
    pub fn contact(mut self, bodies: [usize; 2], interface: ContactInterface<S>) -> Self {
        let count = self.bodies.len();
        assert!(bodies.iter().all(|b| *b < count), "a pair of the bodies {bodies:?}, and {count} bodies");
        self.contacts.push(ContactPair::new(bodies[0], Partner::Body(bodies[1]), interface));
        self
    }

    /// Adds a pair of a body and a rigid obstacle, which carries λ.
    ///
    /// * `interface`: of the body and this obstacle.
    ///
    /// # Panics
    /// If there is no such body.
    #[must_use]
    pub fn obstacle(mut self, body: usize, interface: ContactInterface<S>, obstacle: Obstacle<S>) -> Self {
        let count = self.bodies.len();
        assert!(body < count, "an obstacle for body {body}, and {count} bodies");
        let obstacle = obstacle.facing(&self.bodies[body], &interface);
        self.contacts.push(ContactPair::new(body, Partner::Obstacle(self.obstacles.len()), interface));
        self.obstacles.push(obstacle);
        self
    }

    /// Tells whether a pair has a law of friction.
    pub fn has_friction(&self) -> bool {
        self.contacts.iter().any(|pair| pair.friction.acts())
    }

    /// Returns the obstacle of a pair, if it has one.
    pub fn obstacle_of(&self, pair: &ContactPair<S>) -> Option<&Obstacle<S>> {
        match pair.partner {
            Partner::Body(_) => None,
            Partner::Obstacle(k) => self.obstacles.get(k),
        }
    }

    /// Lists all bodies, and then all obstacles.
    pub fn partners(&self) -> impl Iterator<Item = Partner> + use<S> {
        (0..self.bodies.len()).map(Partner::Body).chain((0..self.obstacles.len()).map(Partner::Obstacle))
    }

    /// Returns the places of a pair in lists of all bodies and then all obstacles, such as [`ContactState::displacement`].
    pub fn places_of(&self, pair: &ContactPair<S>) -> [usize; 2] {
        pair.partners().map(|partner| partner.place(self.bodies.len()))
    }

    /// Sets who carries λ in every pair of bodies.
    #[must_use]
    pub fn with_roles(mut self, roles: Roles) -> Self {
        let pairs = self.contacts.iter_mut().filter(|pair| !pair.partner.is_obstacle());
        pairs.for_each(|pair| pair.roles = roles);
        self
    }

    /// Returns who carries λ in each pair.
    pub fn roles(&self) -> Vec<Roles> {
        self.contacts.iter().map(|pair| pair.roles).collect()
    }

    /// Returns the only pair, if it joins two bodies. Bodies that touch nothing do not count.
    pub fn only_pair(&self) -> Option<&ContactPair<S>> {
        match self.contacts.as_slice() {
            [pair] if !pair.partner.is_obstacle() && !pair.is_within_a_body() && !pair.is_bonded() => {
                Some(pair)
            }
            _ => None,
        }
    }

    /// Returns the only pair of two bodies, if it has no friction and no support holds a contact node of it along the normal.
    pub fn plain_pair(&self) -> Option<&ContactPair<S>> {
        self.only_pair().filter(|pair| !pair.friction.acts() && !self.has_held_nodes(pair))
    }

    /// Tells whether a support holds a contact node of one of the bodies along the normal.
    pub(crate) fn has_held_nodes(&self, pair: &ContactPair<S>) -> bool {
        let held = |(side, b): (usize, usize)| {
            let constraints = self.bodies[b].node_constraints();
            pair.interface.pairs().iter().any(|p| constraints[p.nodes[side]].is_clamped())
        };
        pair.elastic_sides().any(held)
    }

    /// Lists the sides of a body or an obstacle: number of the pair, and 0 if it is the first of it, 1 if it is the second.
    pub fn sides_of(&self, partner: Partner) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.contacts.iter().enumerate().flat_map(move |(k, pair)| {
            let sides = pair.partners().into_iter().enumerate().filter(move |(_, of)| *of == partner);
            sides.map(move |(side, _)| (k, side))
        })
    }

    /// Lists the sides of all bodies and then all obstacles, see [`Self::sides_of`], in one pass over the pairs.
    pub fn sides(&self) -> Vec<Vec<(usize, usize)>> {
        let mut sides = vec![Vec::new(); self.bodies.len() + self.obstacles.len()];
        for (k, pair) in self.contacts.iter().enumerate() {
            self.places_of(pair)
                .into_iter()
                .enumerate()
                .for_each(|(side, place)| sides[place].push((k, side)));
        }
        sides
    }

    /// Lists the directions that a body retains as interface unknowns: one block per side, in the order of
    /// [`Self::sides_of`], each with the rows of its pair.
    pub fn side(&self, body: usize) -> InterfaceSide<S> {
        self.sides_of(Partner::Body(body)).fold(InterfaceSide::default(), |all, (k, side)| {
            let rows = self.contacts[k].rows();
            all.with_block(rows.map(|row| Retained { node: row.nodes[side], direction: row.direction }))
        })
    }

    /// Tells whether a body carries λ in some pair.
    pub fn carries_lambda(&self, body: usize) -> bool {
        self.contacts.iter().any(|pair| pair.imposed() == Partner::Body(body))
    }

    /// Lists the bodies, bodies that carry λ in some pair first: an order that does not depend on the numbers of two
    /// bodies.
    pub fn by_role(&self) -> Vec<usize> {
        let (mut first, second): (Vec<_>, Vec<_>) =
            (0..self.bodies.len()).partition(|b| self.carries_lambda(*b));
        first.extend(second);
        first
    }

    /// Finds a contact facet at the rim of a cut along whose axis it is pressed or rubbed: the contact does not know of the jump there. Returns the
    /// pair and the middle of the facet.
    pub fn contact_across_cut(&self) -> Option<(usize, S::Vector)> {
        for (k, pair) in self.contacts.iter().enumerate() {
            for (side, b) in pair.elastic_sides() {
                let body = &self.bodies[b];
                for facet in pair.interface.facets() {
                    let own = facet.facets[side];
                    let nodes = body.mesh().topology().facets()[own];
                    let meets = |cut: &&Cut<S>| nodes.into_iter().any(|node| cut.has(node));
                    let Some(cut) = body.cuts().iter().find(meets) else { continue };
                    let along = |corner: usize| {
                        let normal = pair.interface.corner_pair(facet, corner).normal;
                        normal.times(&cut.axis).abs() > PERPENDICULAR
                    };
                    if pair.friction.acts() || (0..S::DIM).any(along) {
                        return Some((k, body.mesh().facet_middle(own)));
                    }
                }
            }
        }
        None
    }

    /// Counts the nodes of all bodies.
    pub fn nodes(&self) -> usize {
        self.bodies.iter().map(|body| body.mesh().points().len()).sum()
    }

    /// Counts the node pairs of all pairs.
    pub fn node_pairs(&self) -> usize {
        self.contacts.iter().map(|pair| pair.interface.pairs().len()).sum()
    }

    /// Lists the places of each pair in arrays of one entry per pair of nodes, pair after pair.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> {
        consecutive(self.contacts.iter().map(|pair| pair.interface.pairs().len()))
    }

    /// Lists the places of each pair in arrays of one entry per row along a tangent; nothing for pairs without friction.
    pub fn tangential_blocks(&self) -> impl Iterator<Item = Range<usize>> {
        consecutive(self.contacts.iter().map(|pair| pair.row_count() - pair.interface.pairs().len()))
    }

    /// Lists the rows along the normals of each pair.
    pub(crate) fn normal_rows(&self) -> impl Iterator<Item = Range<usize>> {
        let rows = consecutive(self.contacts.iter().map(ContactPair::<S>::row_count));
        rows.zip(&self.contacts).map(|(rows, pair)| rows.start..rows.start + pair.interface.pairs().len())
    }

    /// Joins values along normals and along tangents to one value per row, pair after pair.
    pub fn by_row(&self, normals: &[f64], tangentials: &[f64]) -> Vec<f64> {
        let blocks = self.blocks().zip(self.tangential_blocks());
        blocks.flat_map(|(pairs, tangents)| [&normals[pairs], &tangentials[tangents]].concat()).collect()
    }

    /// Counts the rows of all pairs: without friction one per node pair, with friction two, in space three.
    pub fn rows(&self) -> usize {
        self.contacts.iter().map(ContactPair::<S>::row_count).sum()
    }
}

impl<S: Space> ContactProblem<S> {
    /// Gives a pair a law of friction.
    ///
    /// # Errors
    /// A limit or a coefficient that is negative or not finite; surfaces of solids along which the normal changes; a side that a support holds
    /// along itself.
    ///
    /// # Panics
    /// If there is no such pair.
    pub fn with_friction(mut self, pair: usize, friction: Friction<S>) -> Result<Self, InterfaceError> {
        let count = self.contacts.len();
        assert!(pair < count, "friction for pair {pair}, and {count} pairs");
        self.contacts[pair].friction = friction;
        let of = &self.contacts[pair];
        of.check_friction(&self.bodies[of.body])?;
        for (side, b) in of.elastic_sides().filter(|_| of.friction.acts()) {
            let of_body = &self.bodies[b];
            let facets = of.interface.facets().iter().map(|facet| facet.facets[side]);
            let held =
                |facet: &FacetId| of_body.facet_condition(*facet).is_some_and(|of| !of.reaction.is_none());
            if let Some(facet) = facets.into_iter().find(held) {
                let point = of_body.mesh().facet_middle(facet).into();
                return Err(InterfaceError::HeldAgainstSlip { body: side, point, words: S::WORDS });
            }
        }
        Ok(self)
    }

    /// Starts a load step of a pair from the slip that earlier steps left: the law of friction then holds for the slip of this step.
    ///
    /// # Errors
    /// Numbers that are not finite, or not one per row along a tangent and per contact facet.
    ///
    /// # Panics
    /// If there is no such pair.
    pub fn with_slip(mut self, pair: usize, before: SlipBefore<S>) -> Result<Self, InterfaceError> {
        let count = self.contacts.len();
        assert!(pair < count, "slip of pair {pair}, and {count} pairs");
        before.check(&self.contacts[pair])?;
        self.contacts[pair].slip_before = Some(before);
        Ok(self)
    }

    /// Multiplies what the conditions of the bodies impose, and the gaps of pairs: the next load step on the same meshes. Obstacles and laws of
    /// friction remain, and the slip before the step.
    ///
    /// * `factor`: of a condition of a body, dimensionless; `of_gap`: of the gap of a pair.
    ///
    /// # Errors
    /// Conditions that contradict each other then, or press clamped nodes into each other.
    pub fn with_factors(
        &self,
        factor: &dyn Fn(usize, ConditionPlace) -> f64,
        of_gap: &dyn Fn(usize) -> f64,
    ) -> Result<Self, LoadFactorError> {
        let scaled = |(b, body): (usize, &Body<S>)| {
            body.with_factors(&|place| factor(b, place))
                .map_err(|source| LoadFactorError::Body { body: b, source })
        };
        let bodies = self.bodies.iter().enumerate().map(scaled).collect::<Result<Vec<_>, _>>()?;
        let mut contacts = self.contacts.clone();
        for (k, pair) in contacts.iter_mut().enumerate() {
            let first = &bodies[pair.body];
            let clamped = |of: &NodePair<S>| match pair.partner {
                Partner::Obstacle(k) => self.obstacles[k].clamped(first, of),
                Partner::Body(second) => super::clamped_ends::clamped([first, &bodies[second]], of),
            };
            pair.interface = pair.interface.clone().scaled_gap(of_gap(k)).with_supports(first, &clamped)?;
        }
        Ok(Self {
            bodies,
            obstacles: self.obstacles.clone(),
            contacts,
            left_out: Vec::new(),
            balancing: self.balancing.clone(),
        })
    }
}

impl ContactProblem {
    /// Measures for each pair the difference between the initial gap and the one on the contact edges, relative to
    /// its largest value: `G·n/|n|`, with gap `G` and normal `n` linear between the node pairs. `None` if the two are
    /// equal to round-off.
    pub fn interpolated_gaps(&self) -> Vec<Option<Difference>> {
        let of_pair = |pair: &ContactPair| {
            // The distance from a plane is linear.
            let circle = |line: &&RigidLine| matches!(line, RigidLine::Circle { .. });
            let line = self.obstacle_of(pair).map(|obstacle| &obstacle.line).filter(circle);
            // Arc lengths and gaps are measured on one of the bodies.
            let measured_on = pair.partners()[pair.interface.measured_on].body().unwrap_or(pair.body);
            pair.interface.interpolated_gap(&self.bodies[measured_on], line)
        };
        self.contacts.iter().map(of_pair).collect()
    }
}

impl ContactProblem<Solid> {
    /// Measures for each pair the difference between the initial gap and the one on the contact faces, relative to its largest value. `None` if
    /// the two are equal to round-off; drawn gaps between flat sides, and distances from planes, are linear. The distance from a sphere or a cylinder
    /// is not: the faces are flat, see [`ContactInterface::middle_openings`].
    pub fn interpolated_solid_gaps(&self) -> Vec<Option<Difference>> {
        let samples = Solid::facet_samples();
        let of_pair = |pair: &ContactPair<Solid>| {
            let round = |line: &&RigidLine<Solid>| !matches!(line, RigidLine::Plane { .. });
            let line = self.obstacle_of(pair).map(|obstacle| &obstacle.line).filter(round);
            let meant = |x| match (&pair.interface.gap, line) {
                (Gap::Given(gap), _) => Some(gap.at(x)),
                (Gap::Touching | Gap::Bonded { .. }, _) | (_, None) => None,
                (_, Some(line)) => Some(line.distance(x).0),
            };
            let points = self.bodies[pair.body].mesh().points();
            let sum = DifferenceSum::of(pair.interface.facets(), |sum, facet| {
                let nodes = facet.pairs.map(|k| &pair.interface.pairs()[k as usize]);
                let corners = nodes.map(|node| points[node.nodes[0]]);
                if meant(corners[0]).is_none() {
                    return;
                }
                let meant = |x| meant(x).unwrap_or_default();
                match line {
                    None => sum.facet::<Solid>(&samples, (&corners, &nodes.map(|node| node.gap)), meant),
                    Some(_) => {
                        let made = |at: &[f64; 3]| ContactFacet::<Solid>::gap(nodes, at);
                        sum.facet_with::<Solid>(&samples, &corners, made, meant);
                    }
                }
            });
            sum.difference()
        };
        self.contacts.iter().map(of_pair).collect()
    }
}

/// Lists consecutive ranges of given lengths.
fn consecutive(lengths: impl Iterator<Item = usize>) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    lengths.map(move |length| {
        let end = start + length;
        std::mem::replace(&mut start, end)..end
    })
}

/// Displacement fields with their nodal contact forces, whatever their source.
#[derive(Clone, Debug)]
pub struct ContactState<'a, S: Space = Plane> {
    /// Nodal displacements of each body, Cartesian, m; after them the displacements of the points of each obstacle.
    pub displacement: Vec<&'a [S::Vector]>,
    /// Forces and openings of each pair.
    pub contacts: Vec<PairState<'a>>,
}

/// Forces and openings along one pair.
#[derive(Clone, Copy, Debug)]
pub struct PairState<'a> {
    /// Contact force on Ω₂ at each pair of nodes, `r²_i ≥ 0`, N/m.
    pub contact_force: &'a [f64],
    /// Opening `o_i = g_i − (v¹_i − v²_i) ≥ 0` at each pair of nodes, m.
    pub opening: &'a [f64],
    /// Friction force `Q_i` at each pair of nodes, N/m, along the tangent on the second body; empty without friction.
    pub friction_force: &'a [f64],
    /// Slip `w_i = (u^a_i − u^b_i)·t_i` at each pair of nodes, exactly zero if they stick, m; empty without friction.
    pub slip: &'a [f64],
}

impl<'a> PairState<'a> {
    /// Takes forces and openings of a pair without friction.
    pub fn frictionless(contact_force: &'a [f64], opening: &'a [f64]) -> Self {
        Self { contact_force, opening, friction_force: &[], slip: &[] }
    }
}

impl<'a, S: Space> ContactState<'a, S> {
    /// Takes the fields of two bodies with one pair without friction.
    pub fn between(displacement: [&'a [S::Vector]; 2], contact_force: &'a [f64], opening: &'a [f64]) -> Self {
        let contacts = vec![PairState::frictionless(contact_force, opening)];
        Self { displacement: displacement.into(), contacts }
    }
}

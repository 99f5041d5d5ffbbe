//! Evaluates boundary conditions on a mesh: nodal constraints and edge tractions.

mod rollers;
mod single_node;
mod springs;

use super::facet_functions::linear_by_moments;
use super::rigid::{Equation, Given, RigidSide};
use super::springs::SpringSide;
use super::{Body, BodyError, ConditionList, ConditionPlace, FacetCondition, NodeConstraint, SupportSet};
use super::{cuts, force, heat};
use crate::boundary::{BoundaryConditions, FacetSelection, Load, RigidCondition, ScalarData, Support};
use crate::directions::Directions;
use crate::geometry::{Coordinates, Point, norm};
use crate::material::Materials;
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::space::Space;
use std::collections::{BTreeMap, HashMap};
use std::sync::OnceLock;

/// Two directions closer than this (sine of the angle) are the same.
pub(super) const SAME_DIRECTION: f64 = 1e-9;

/// Values that differ by less, relative to the largest that their conditions impose, are the same.
const SAME_VALUE: f64 = 1e-12;

/// The edges that each condition applies to, in the order of the conditions.
#[derive(Clone, Debug, Default)]
pub(super) struct Selected {
    pub(super) displacements: Vec<Vec<FacetId>>,
    /// The node of each displacement condition that is on a single one; it has no edge.
    pub(super) nodes: Vec<Option<NodeId>>,
    pub(super) tractions: Vec<Vec<FacetId>>,
    pub(super) rigid: Vec<Vec<FacetId>>,
    pub(super) springs: Vec<Vec<FacetId>>,
}

/// Evaluates conditions on a mesh, on the edges they select or on those `inherited` from a coarser mesh.
pub(super) fn evaluate<S: Space>(
    mesh: Mesh<S>,
    materials: Materials<S>,
    conditions: &BoundaryConditions<S>,
    inherited: Option<Selected>,
) -> Result<Body<S>, BodyError> {
    let cells = mesh.cells().len();
    if !materials.fit(cells) {
        return Err(BodyError::Materials { found: materials.len(), cells });
    }
    let force = conditions.body_force;
    if !force.is_finite() {
        return Err(BodyError::BodyForce { force: force.into() });
    }
    let temperature = heat::evaluate(&mesh, conditions)?;
    let forces = force::evaluate(&mesh, &materials, conditions)?;
    let mut work = Evaluation {
        constraints: vec![NodeConstraint::FREE; mesh.points().len()],
        magnitudes: vec![0.0; mesh.points().len()],
        turned: Vec::new(),
        facets: vec![FacetCondition::FREE; mesh.topology().boundary_facets().len()],
        mesh: &mesh,
        materials: &materials,
    };
    let inherited = inherited.as_ref();
    let mut selected = Selected::default();
    let supports = work.impose_all(conditions, inherited, &mut selected)?;
    let rigid_sides = work.stiffen_all(conditions, inherited)?;
    selected.rigid = rigid_sides.iter().map(|side| side.edges.clone()).collect();
    selected.tractions = work.load_all(conditions, inherited)?;
    let springs = work.spring_all(conditions, inherited)?;
    selected.springs = springs.iter().map(SpringSide::facet_ids).collect();
    let roller_turn = work.roller_turn();
    let (node_constraints, facet_conditions) = (work.constraints, work.facets);
    let cuts = cuts::evaluate(&mesh, conditions, &node_constraints, &facet_conditions)?;
    let cut_strains = cuts::strains(&mesh, &cuts);
    let conditions = conditions.clone();
    let free_motion = OnceLock::new();
    Ok(Body {
        mesh,
        materials,
        node_constraints,
        facet_conditions,
        supports,
        rigid_sides,
        springs,
        roller_turn,
        temperature,
        cuts,
        cut_strains,
        forces,
        conditions,
        selected,
        curves: Default::default(),
        surfaces: Default::default(),
        inserted: Vec::new(),
        free_motion,
    })
}

pub(super) struct Evaluation<'a, S: Space> {
    pub(super) mesh: &'a Mesh<S>,
    pub(super) materials: &'a Materials<S>,
    constraints: Vec<NodeConstraint<S>>,
    /// Size of the data imposed on each node, m: the scale of their round-off.
    magnitudes: Vec<f64>,
    pub(super) facets: Vec<FacetCondition<S>>,
    turned: Vec<Turned<S>>,
}

/// A node on a curved roller, fixed in another direction than the normal of one of its edges.
struct Turned<S: Space> {
    node: NodeId,
    /// The facet's normal, and what is imposed along it.
    normal: S::Vector,
    value: f64,
    /// Sine of the angle between the two.
    sine: f64,
}

/// A datum and the direction in which it fixes the nodes of a facet.
struct Imposed<'a, S: Space> {
    direction: S::Vector,
    data: &'a ScalarData<S>,
    /// Largest absolute value at the nodes of the condition's edges, m.
    magnitude: f64,
}

impl<S: Space> Evaluation<'_, S> {
    /// Imposes all displacement conditions; adds the edges or the node of each, and returns what it holds.
    fn impose_all(
        &mut self,
        conditions: &BoundaryConditions<S>,
        inherited: Option<&Selected>,
        selected: &mut Selected,
    ) -> Result<Vec<SupportSet<S>>, BodyError> {
        let mut supports = Vec::new();
        for (index, condition) in conditions.displacements.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Displacement, index };
            let (facets, node, held) = match condition.edges.node {
                Some(at) => {
                    let known = inherited.and_then(|known| known.nodes[index]);
                    let node = known.map_or_else(|| self.node_at(place, at), Ok)?;
                    (Vec::new(), Some(node), self.impose_at(place, node, &condition.support)?)
                }
                None => {
                    let known = inherited.map(|known| &known.displacements);
                    let edges = self.edges_of(place, &condition.edges, known)?;
                    let held = self.impose(place, &edges, &condition.support)?;
                    (edges, None, held)
                }
            };
            let (nodes, reactions) = held.into_iter().unzip();
            supports.push(SupportSet { group: condition.edges.on.clone(), nodes, reactions });
            selected.displacements.push(facets);
            selected.nodes.push(node);
        }
        Ok(supports)
    }

    /// Makes sides rigid.
    fn stiffen_all(
        &mut self,
        conditions: &BoundaryConditions<S>,
        inherited: Option<&Selected>,
    ) -> Result<Vec<RigidSide<S>>, BodyError> {
        let mut sides = Vec::new();
        for (index, condition) in conditions.rigid.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Rigid, index };
            let facets = self.edges_of(place, &condition.edges, inherited.map(|known| &known.rigid))?;
            sides.push(self.stiffen(place, &facets, condition)?);
        }
        Ok(sides)
    }

    /// Makes a side rigid. Supports that hold one of its nodes, at its ends, hold the whole side.
    fn stiffen(
        &mut self,
        place: ConditionPlace,
        edges: &[FacetId],
        condition: &RigidCondition<S>,
    ) -> Result<RigidSide<S>, BodyError> {
        let topology = self.mesh.topology();
        let points = self.mesh.points();
        let middle = |facet: FacetId| self.mesh.facet_middle(facet);
        let origin = points[topology.facets()[edges[0]][0]];
        let numbers = condition.motion.into_iter().flatten();
        let loads = S::motion(condition.force, condition.moment);
        let about = condition.about.unwrap_or_default();
        for value in numbers.chain(loads).chain(about.entries().iter().copied()) {
            finite(place, origin, value)?;
        }
        let (piece_of, _) = topology.pieces();
        let piece = piece_of[topology.facets()[edges[0]][0]];
        let mut equations = Vec::new();
        for (edge, position) in self.places(edges).collect::<Vec<_>>() {
            if !self.facets[position].reaction.is_none() {
                return Err(BodyError::RigidOccupied { place, point: middle(edge).into() });
            }
            for node in topology.facets()[edge] {
                let point = points[node];
                let constraint = &self.constraints[node];
                if constraint.rigid_side.is_some() || piece_of[node] != piece {
                    return Err(BodyError::RigidOccupied { place, point: point.into() });
                }
                let imposed = constraint.components();
                equations.extend(imposed.map(|(direction, value)| Equation { point, direction, value }));
            }
        }
        for (_, position) in self.places(edges).collect::<Vec<_>>() {
            self.facets[position].reaction = Directions::ALL;
        }
        let given = Given { condition, edges: edges.to_vec(), equations, piece };
        let side = RigidSide::new(self.mesh, given).map_err(|(equation, found)| BodyError::Conflict {
            place,
            point: equation.point.into(),
            values: [equation.value, found],
        })?;
        for &node in &side.nodes {
            let imposed = side.imposed.at(points[node]);
            let rigid_side = (!side.motions.is_empty()).then_some(place.index as u32);
            self.constraints[node] = NodeConstraint { held: Directions::ALL, imposed, rigid_side };
        }
        Ok(side)
    }

    /// Applies all loads; returns the edges of each.
    fn load_all(
        &mut self,
        conditions: &BoundaryConditions<S>,
        inherited: Option<&Selected>,
    ) -> Result<Vec<Vec<FacetId>>, BodyError> {
        let mut selected = Vec::new();
        for (index, condition) in conditions.tractions.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Traction, index };
            let edges = self.edges_of(place, &condition.edges, inherited.map(|known| &known.tractions))?;
            self.load(place, &edges, &condition.load)?;
            selected.push(edges);
        }
        Ok(selected)
    }

    /// Returns the edges of a condition: known from a coarser mesh, or selected.
    pub(super) fn edges_of(
        &self,
        place: ConditionPlace,
        selection: &FacetSelection<S>,
        known: Option<&Vec<Vec<FacetId>>>,
    ) -> Result<Vec<FacetId>, BodyError> {
        known.map_or_else(|| self.select(place, selection), |known| Ok(known[place.index].clone()))
    }

    /// Selects boundary edges.
    fn select(
        &self,
        place: ConditionPlace,
        selection: &FacetSelection<S>,
    ) -> Result<Vec<FacetId>, BodyError> {
        if selection.node.is_some() {
            return Err(BodyError::SingleNode { place });
        }
        let group = selection.on.clone();
        let Some(edges) = self.mesh.group(&group) else {
            let names: Vec<&str> = self.mesh.groups().keys().map(String::as_str).collect();
            let known = names.join(", ");
            return Err(BodyError::UnknownGroup { place, group, known, words: S::WORDS });
        };
        let tolerance = 1e-9 * self.mesh.diagonal();
        let inside = |p: S::Vector| {
            selection.part.is_none_or(|part| {
                (0..S::DIM).all(|c| p[c] >= part[c][0] - tolerance && p[c] <= part[c][1] + tolerance)
            })
        };
        let mut selected = Vec::new();
        for &edge in edges {
            let corners = self.mesh.facet_corners(edge);
            if !corners.into_iter().all(inside) {
                continue;
            }
            if !self.mesh.topology().is_boundary(edge) {
                let corners = corners.into_iter().map(Point::from).collect();
                return Err(BodyError::InteriorFacet { place, group, corners, words: S::WORDS });
            }
            selected.push(edge);
        }
        if selected.is_empty() {
            return Err(BodyError::EmptySelection { place, group, words: S::WORDS });
        }
        Ok(selected)
    }

    /// Pairs boundary edges with their places among the boundary edges.
    pub(super) fn places<'s>(
        &'s self,
        edges: &'s [FacetId],
    ) -> impl Iterator<Item = (FacetId, usize)> + use<'s, S> {
        edges.iter().map(|&edge| (edge, self.mesh.topology().boundary_place(edge)))
    }

    /// Imposes one condition; returns the directions in which it holds each node.
    fn impose(
        &mut self,
        place: ConditionPlace,
        edges: &[FacetId],
        support: &Support<S>,
    ) -> Result<BTreeMap<NodeId, Directions<S>>, BodyError> {
        let mut holds = BTreeMap::new();
        let normals = match support {
            Support::Normal(_) => rollers::flattened(self.mesh, edges),
            Support::Components(_) => HashMap::new(),
        };
        let at_nodes = rollers::at_nodes(self.mesh, &normals);
        let magnitude = |data: &ScalarData<S>| {
            let all = edges.iter().flat_map(|&e| self.mesh.topology().facets()[e]);
            all.fold(0.0f64, |largest, n| largest.max(data.at(self.mesh.points()[n]).abs()))
        };
        let magnitudes = match support {
            Support::Normal(data) => S::data(|_| Some((data, magnitude(data)))),
            Support::Components(all) => S::data(|c| all[c].as_ref().map(|d| (d, magnitude(d)))),
        };
        for (edge, position) in self.places(edges).collect::<Vec<_>>() {
            let all = Directions::<S>::ALL;
            let directions = normals.get(&edge).map_or(all.basis(), std::slice::from_ref);
            for (&direction, known) in directions.iter().zip(magnitudes.as_ref()) {
                let Some((data, magnitude)) = *known else { continue };
                let reaction = &mut self.facets[position].reaction;
                *reaction = reaction.with(direction, SAME_DIRECTION);
                for node in self.mesh.topology().facets()[edge] {
                    let held =
                        at_nodes.get(&node).map_or(direction, |all| rollers::mean::<S>(all, direction));
                    let value = self.constrain(place, node, &Imposed { direction: held, data, magnitude })?;
                    if held != direction {
                        let sine = Directions::<S>::along(direction).sine(held);
                        self.turned.push(Turned { node, normal: direction, value, sine });
                    }
                    let reaction = holds.entry(node).or_insert(Directions::NONE);
                    *reaction = reaction.with(held, SAME_DIRECTION);
                }
            }
        }
        Ok(holds)
    }

    /// Adds a condition to a node, and returns the imposed value.
    fn constrain(
        &mut self,
        place: ConditionPlace,
        node: NodeId,
        imposed: &Imposed<'_, S>,
    ) -> Result<f64, BodyError> {
        let (point, direction) = (self.mesh.points()[node], imposed.direction);
        let value = finite(place, point, imposed.data.at(point))?;
        let magnitude = &mut self.magnitudes[node];
        *magnitude = magnitude.max(imposed.magnitude);
        let constraint = &mut self.constraints[node];
        let sine = constraint.held.sine(direction);
        if sine <= SAME_DIRECTION {
            let known = constraint.imposed.times(&constraint.held.components(direction));
            let close = (known - value).abs() <= SAME_VALUE * *magnitude;
            return if close {
                Ok(value)
            } else {
                Err(BodyError::Conflict { place, point: point.into(), values: [known, value] })
            };
        }
        // Round-off grows as the directions come near each other.
        *magnitude /= sine;
        constraint.impose(direction, value);
        Ok(value)
    }

    /// Computes [`Body::roller_turn`] when all conditions are imposed.
    fn roller_turn(&self) -> f64 {
        let violates = |t: &&Turned<S>| {
            let constraint = &self.constraints[t.node];
            let difference = (constraint.displacement().times(&t.normal) - t.value).abs();
            !constraint.is_clamped() || difference > SAME_VALUE * self.magnitudes[t.node]
        };
        self.turned.iter().filter(violates).fold(0.0, |largest, t| largest.max(t.sine))
    }

    fn load(&mut self, place: ConditionPlace, edges: &[FacetId], load: &Load<S>) -> Result<(), BodyError> {
        for (edge, position) in self.places(edges).collect::<Vec<_>>() {
            let traction = self.facet_traction(place, edge, load)?;
            let condition = &mut self.facets[position];
            let held = condition.reaction;
            if traction.into_iter().any(|t| norm(held.components(t)) > SAME_DIRECTION * norm(t)) {
                let point = self.mesh.facet_middle(edge).into();
                return Err(BodyError::LoadOnSupport { place, point, words: S::WORDS });
            }
            for (total, t) in condition.traction.as_mut().iter_mut().zip(traction) {
                *total += t - held.project(t);
            }
        }
        Ok(())
    }

    /// Computes the linear traction with the moments of the given one, by its values at the corners of a facet.
    fn facet_traction(
        &self,
        place: ConditionPlace,
        facet: FacetId,
        load: &Load<S>,
    ) -> Result<S::Axes<S::Vector>, BodyError> {
        let corners = self.mesh.facet_corners(facet);
        let normal = self.mesh.facet_normal(facet);
        let finite_at = |point: S::Vector, t: S::Vector| {
            t.entries().iter().try_for_each(|t| finite(place, point, *t).map(|_| ()))
        };
        let constant = match load {
            Load::Vector(all) => {
                let all: Option<Vec<f64>> = all.as_ref().iter().map(ScalarData::constant).collect();
                all.map(|all| S::Vector::of(|c| all[c]))
            }
            Load::Pressure(q) => q.constant().map(|q| normal * -q),
        };
        if let Some(t) = constant {
            finite_at(corners[0], t)?;
            return Ok(S::axes(|_| t));
        }
        let at = |point: S::Vector| {
            let t = match load {
                Load::Vector(all) => S::Vector::of(|c| all[c].at(point)),
                Load::Pressure(q) => normal * -q.at(point),
            };
            finite_at(point, t)?;
            Ok(t)
        };
        // The quadrature has no point at the nodes, but a singular load there must be detected.
        for corner in corners {
            at(corner)?;
        }
        let mut moments = S::ZEROS;
        for (weights, share) in S::facet_rule() {
            let inner = (1..S::DIM).fold(corners[0] * weights[0], |sum, k| sum + corners[k] * weights[k]);
            let t = at(inner)?;
            for k in 0..S::DIM {
                moments[k] += t * (share * weights[k]);
            }
        }
        Ok(linear_by_moments::<S, S::Vector>(&moments))
    }
}

pub(super) fn finite(place: ConditionPlace, point: impl Into<Point>, value: f64) -> Result<f64, BodyError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(BodyError::NotFinite { place, point: point.into(), value })
    }
}

#[cfg(test)]
mod tests;

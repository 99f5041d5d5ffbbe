//! Bodies that are bonded become one: nodes of their bonded sides are merged.

use super::{Body, FacetCondition, NodeConstraint, RigidSide, SupportSet, cuts};
use crate::boundary::BoundaryConditions;
use crate::directions::Directions;
use crate::geometry::{Coordinates, Point, norm};
use crate::material::Materials;
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::{Cell, Mesh, MeshError};
use crate::space::Space;
use std::sync::OnceLock;
use thiserror::Error;

/// Two directions closer than this (sine of the angle) are the same.
const SAME_DIRECTION: f64 = 1e-9;
/// Imposed values that differ by less, relative to their sizes and those of the offsets, are the same.
const SAME_VALUE: f64 = 1e-12;
/// Merged nodes may be this far apart, as a part of the smaller body.
const SAME_PLACE: f64 = 1e-6;

/// Why bodies cannot become one.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum JoinError {
    /// Merged nodes are at different places.
    #[error("the bonded sides do not coincide: their nodes at {point} are {distance:.3e} apart")]
    Apart {
        /// The node of the first body.
        point: Point,
        /// The distance, m.
        distance: f64,
    },
    /// Supports hold both sides of a bond.
    #[error(
        "supports hold both sides of the bond at {point} with displacements that differ by something else than its offset: they impose {} \
         and {} along one direction, without the offset", values[0], values[1]
    )]
    Supports {
        /// The node.
        point: Point,
        /// The values that each imposes on the displacement of the whole, m.
        values: [f64; 2],
    },
    /// A rigid side ends at a support of another body.
    #[error("a rigid side of one bonded body and a support of the other one hold the same node at {point}")]
    Rigid {
        /// The node.
        point: Point,
    },
    /// The bodies have different body forces, or one that varies.
    #[error("the bonded bodies have different body forces, or one that varies, which is not solved yet")]
    BodyForce,
    /// A body changes its temperature.
    #[error(
        "a bonded body changes its temperature, which is not solved yet; one body with regions of both materials is solved"
    )]
    Heat,
    /// A body is on springs.
    #[error("a bonded body is on springs, which is not solved yet")]
    Springs,
    /// A cut of a body ends at a bonded side.
    #[error("a cut ends at the bonded side at {point}, and the other body continues there")]
    Cut {
        /// The node.
        point: Point,
    },
    /// A load or a support on a bonded side.
    #[error("a load or a support acts on the bonded side at {point}")]
    Occupied {
        /// The middle of the facet.
        point: Point,
    },
    /// The cells of the bodies make no mesh.
    #[error("the bonded bodies make no mesh: {0}")]
    Mesh(#[from] MeshError),
}

/// Nodes of the bodies, the nodes with which they are merged, and the number of each in the body that they become.
pub(crate) struct Merged {
    /// By body and node.
    pub(crate) nodes: Vec<Vec<NodeId>>,
    count: usize,
}

impl Merged {
    /// Numbers the nodes of all bodies one after the other, merged ones once.
    ///
    /// * `counts`: of the nodes of each body; `same`: pairs of nodes, each with the number of its body.
    pub(crate) fn new(counts: &[usize], same: &[[(usize, NodeId); 2]]) -> Self {
        let first: Vec<usize> =
            counts.iter().scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count))).collect();
        let mut parent: Vec<usize> = (0..counts.iter().sum()).collect();
        for pair in same {
            let [a, b] = pair.map(|(body, node)| root(&mut parent, first[body] + node.index()));
            parent[a.max(b)] = a.min(b);
        }
        let (mut number, mut count) = (vec![0; parent.len()], 0);
        for node in 0..parent.len() {
            let own = root(&mut parent, node);
            number[node] = if own == node { count } else { number[own] };
            count += usize::from(own == node);
        }
        let of_body = |(first, count): (&usize, &usize)| {
            number[*first..first + count].iter().map(|k| NodeId::new(*k)).collect()
        };
        Self { nodes: first.iter().zip(counts).map(of_body).collect(), count }
    }
}

/// Finds the smallest number of the set of a number.
fn root(parent: &mut [usize], mut number: usize) -> usize {
    while parent[number] != number {
        parent[number] = parent[parent[number]];
        number = parent[number];
    }
    number
}

impl<S: Space> Body<S> {
    /// Makes one body of several. Its displacement is that of each part less the offset of the part.
    ///
    /// Curves and declared surfaces, and what its conditions were made of, are left out: it is solved, and not refined.
    ///
    /// * `parts`: each with its offset, m; `merged`: their nodes.
    ///
    /// # Errors
    /// See [`JoinError`].
    pub(crate) fn joined(parts: &[(&Self, S::Vector)], merged: &Merged) -> Result<Self, JoinError> {
        let body_force = parts[0].0.conditions.body_force;
        let varies = |part: &Self| part.has_varying_force() || part.conditions.body_force != body_force;
        if parts.iter().any(|(part, _)| varies(part)) {
            return Err(JoinError::BodyForce);
        }
        if parts.iter().any(|(part, _)| part.has_heat()) {
            return Err(JoinError::Heat);
        }
        if parts.iter().any(|(part, _)| !part.springs.is_empty()) {
            return Err(JoinError::Springs);
        }
        let mesh = joined_mesh(parts, merged)?;
        let mut joined = Self {
            materials: joined_materials(parts),
            node_constraints: vec![NodeConstraint::FREE; mesh.points().len()],
            facet_conditions: vec![FacetCondition::FREE; mesh.topology().boundary_facets().len()],
            supports: Vec::new(),
            rigid_sides: Vec::new(),
            springs: Vec::new(),
            temperature: Vec::new(),
            cuts: Vec::new(),
            cut_strains: Vec::new(),
            forces: Vec::new(),
            roller_turn: parts.iter().map(|(part, _)| part.roller_turn).fold(0.0, f64::max),
            conditions: BoundaryConditions { body_force, ..BoundaryConditions::default() },
            selected: Default::default(),
            curves: Default::default(),
            surfaces: Default::default(),
            inserted: Vec::new(),
            free_motion: OnceLock::new(),
            mesh,
        };
        for ((part, offset), nodes) in parts.iter().zip(&merged.nodes) {
            joined.take_constraints(part, *offset, nodes)?;
            joined.take_facets(part, nodes)?;
            joined.take_sides(part, *offset, nodes);
        }
        joined.take_cuts(parts, merged)?;
        Ok(joined)
    }

    /// Adds the constraints of the nodes of a part. A support holds on its own side of a bond.
    fn take_constraints(
        &mut self,
        part: &Self,
        offset: S::Vector,
        nodes: &[NodeId],
    ) -> Result<(), JoinError> {
        let first_side = self.rigid_sides.len() as u32;
        for (of, node) in part.node_constraints.iter().zip(nodes) {
            if of.held.is_none() {
                continue;
            }
            let mut of = *of;
            let scale = norm(of.imposed) + norm(offset);
            of.imposed -= of.held.components(offset);
            of.rigid_side = of.rigid_side.map(|side| side + first_side);
            let point = self.mesh.points()[*node].into();
            let known = &mut self.node_constraints[*node];
            if known.held.is_none() {
                *known = of;
                continue;
            }
            if known.rigid_side.is_some() || of.rigid_side.is_some() {
                return Err(JoinError::Rigid { point });
            }
            let scale = scale + norm(known.imposed);
            for (direction, value) in of.components() {
                if known.held.sine(direction) > SAME_DIRECTION {
                    known.impose(direction, value);
                    continue;
                }
                let before = known.imposed.times(&known.held.components(direction));
                if !((before - value).abs() <= SAME_VALUE * scale) {
                    return Err(JoinError::Supports { point, values: [before, value] });
                }
            }
        }
        Ok(())
    }

    /// Adds the conditions of the facets of a part.
    fn take_facets(&mut self, part: &Self, nodes: &[NodeId]) -> Result<(), JoinError> {
        for (facet, condition) in part.mesh.topology().boundary_facets().iter().zip(&part.facet_conditions) {
            let (Some(own), order) = self.mesh.facet_of_part(&part.mesh, *facet, nodes) else { continue };
            if self.mesh.topology().is_boundary(own) {
                let place = self.mesh.topology().boundary_place(own);
                let traction = S::axes(|k| condition.traction[order[k]]);
                self.facet_conditions[place] = FacetCondition { traction, ..*condition };
            } else if !part.is_free(*facet) {
                return Err(JoinError::Occupied { point: part.mesh.facet_middle(*facet).into() });
            }
        }
        Ok(())
    }

    /// Adds the cuts of all parts.
    fn take_cuts(&mut self, parts: &[(&Self, S::Vector)], merged: &Merged) -> Result<(), JoinError> {
        if parts.iter().all(|(part, _)| part.cuts.is_empty()) {
            return Ok(());
        }
        let mut bodies_at = vec![0u32; merged.count];
        merged.nodes.iter().flatten().for_each(|node| bodies_at[node.index()] += 1);
        let mut first_cell = 0;
        for ((part, _), nodes) in parts.iter().zip(&merged.nodes) {
            for cut in &part.cuts {
                if let Some(node) = cut.nodes.iter().find(|node| bodies_at[nodes[node.index()].index()] > 1) {
                    return Err(JoinError::Cut { point: part.mesh.points()[*node].into() });
                }
                let facet = |of: FacetId| self.mesh.facet_of_part(&part.mesh, of, nodes).0;
                self.cuts.push(cut.on_joined(facet, nodes, first_cell));
            }
            first_cell += part.mesh.cells().len() as u32;
        }
        self.cut_strains = cuts::strains(&self.mesh, &self.cuts);
        Ok(())
    }

    /// Adds the supports and the rigid sides of a part.
    fn take_sides(&mut self, part: &Self, offset: S::Vector, nodes: &[NodeId]) {
        for set in &part.supports {
            let mut held: Vec<(NodeId, Directions<S>)> =
                set.nodes.iter().map(|node| nodes[node.index()]).zip(set.reactions.iter().copied()).collect();
            held.sort_unstable_by_key(|(node, _)| *node);
            let (nodes, reactions) = held.into_iter().unzip();
            self.supports.push(SupportSet { group: set.group.clone(), nodes, reactions });
        }
        for side in &part.rigid_sides {
            let mut edges: Vec<FacetId> = side
                .edges
                .iter()
                .filter_map(|facet| self.mesh.facet_of_part(&part.mesh, *facet, nodes).0)
                .collect();
            edges.sort_unstable();
            let (piece_of, _) = self.mesh.topology().pieces();
            let piece = side.nodes.first().map_or(0, |node| piece_of[nodes[node.index()]]);
            self.rigid_sides.push(side.on_joined(edges, nodes, piece, offset));
        }
    }
}

impl<S: Space> RigidSide<S> {
    /// Creates the same side of the body that several became.
    ///
    /// * `edges`: its facets there; `numbers`: of the nodes of its body; `offset`: of the displacements of its body, m.
    fn on_joined(&self, edges: Vec<FacetId>, numbers: &[NodeId], piece: u32, offset: S::Vector) -> Self {
        let mut side = self.clone();
        let mut forces: Vec<(NodeId, S::Vector)> =
            self.nodes.iter().map(|node| numbers[node.index()]).zip(self.forces.iter().copied()).collect();
        forces.sort_unstable_by_key(|(node, _)| *node);
        (side.nodes, side.forces) = forces.into_iter().unzip();
        side.ends = self.ends.iter().map(|node| numbers[node.index()]).collect();
        side.ends.sort_unstable();
        side.edges = edges;
        side.imposed.piece = piece;
        side.motions.iter_mut().for_each(|motion| motion.piece = piece);
        side.imposed.translation -= offset;
        side
    }
}

impl<S: Space> Mesh<S> {
    /// Finds a facet of a part in the mesh that several became, and for each of its corners there the corner in the part.
    ///
    /// * `numbers`: of the nodes of the part.
    pub fn facet_of_part(
        &self,
        part: &Self,
        facet: FacetId,
        numbers: &[NodeId],
    ) -> (Option<FacetId>, S::Axes<usize>) {
        let corners = part.topology().facets()[facet];
        let moved = S::axes(|k| numbers[corners[k].index()]);
        let found = self.topology().find_facet(moved);
        let own = found.map_or(moved, |found| self.topology().facets()[found]);
        let place = |node: NodeId| moved.into_iter().position(|other| other == node).unwrap_or(0);
        (found, S::axes(|k| place(own[k])))
    }
}

/// Makes the mesh of several bodies, without the names of sides.
fn joined_mesh<S: Space>(parts: &[(&Body<S>, S::Vector)], merged: &Merged) -> Result<Mesh<S>, JoinError> {
    let mut points: Vec<Option<S::Vector>> = vec![None; merged.count];
    let mut cells: Vec<Cell<S>> = Vec::new();
    let size = parts.iter().map(|(part, _)| part.mesh.diagonal()).fold(f64::INFINITY, f64::min);
    for ((part, _), nodes) in parts.iter().zip(&merged.nodes) {
        for (point, node) in part.mesh.points().iter().zip(nodes) {
            let known = points[node.index()].get_or_insert(*point);
            let distance = norm(*known - *point);
            if !(distance <= SAME_PLACE * size) {
                return Err(JoinError::Apart { point: (*known).into(), distance });
            }
        }
        let numbered = |cell: &Cell<S>| S::corners(|k| nodes[cell[k].index()]);
        cells.extend(part.mesh.cells().iter().map(numbered));
    }
    Ok(Mesh::oriented(points.into_iter().flatten().collect(), cells, Vec::new())?)
}

/// Lists the materials of several bodies one after the other.
fn joined_materials<S: Space>(parts: &[(&Body<S>, S::Vector)]) -> Materials<S> {
    let (mut list, mut of_cell) = (Vec::new(), Vec::new());
    for (part, _) in parts {
        let first = list.len();
        list.extend_from_slice(part.materials.list());
        of_cell.extend((0..part.mesh.cells().len()).map(|cell| (first + part.materials.index(cell)) as u32));
    }
    Materials::by_cell(list, of_cell)
}

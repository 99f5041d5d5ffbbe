//! Moves new nodes of solids onto declared surfaces, so far that no cell turns over or becomes flat.

use super::Body;
use crate::geometry::{Coordinates, norm};
use crate::mesh::bisect::{BodyNode, BodyTets, EdgeOrder};
use crate::mesh::id::{FacetId, NodeId};
use crate::rigid_line::RigidLine;
use crate::space::{Solid, Space};
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet, HashMap};

type Vector = <Solid as Space>::Vector;

/// A cell keeps at least this part of its volume when a node moves.
const LEAST_VOLUME: f64 = 0.3;
/// The parts of the way that are tried.
const FRACTIONS: [f64; 3] = [1.0, 0.5, 0.25];
/// The part of a node's move that its neighbours inside the body make with it.
const RING: [f64; 3] = [0.0, 0.5, 0.8];
/// Nodes within this fraction of the size of a body are on their surface.
const ON_SURFACE: f64 = 1e-12;
/// Steps of Newton's method, at most.
const ROUNDS: usize = 20;
/// Cosine of the angle below which a side continues a declared surface: 20 degrees.
const CONTINUES: f64 = 0.94;
/// Two normals closer than this are one: that of the same side.
const SAME_NORMAL: f64 = 1e-8;

/// A body whose mesh becomes finer.
pub struct FinerBody<'a> {
    body: &'a Body<Solid>,
    tets: &'a BodyTets,
    /// Positions of its nodes, m.
    pub points: Vec<Vector>,
    /// Where each node that may move has to go: its surfaces, and the planes in which it stays.
    on: BTreeMap<NodeId, Vec<RigidLine<Solid>>>,
    /// True of nodes inside the body, of no named face and of one material.
    is_free: Vec<bool>,
    around: Vec<Vec<u32>>,
}

impl<'a> FinerBody<'a> {
    /// Puts new nodes into the middles of their edges.
    ///
    /// * `tets`: the halved tetrahedra of the body; `surfaces`: on which its old faces lie.
    pub fn new(
        body: &'a Body<Solid>,
        tets: &'a BodyTets,
        surfaces: &BTreeMap<FacetId, RigidLine<Solid>>,
    ) -> Self {
        let points = tets.points(body.mesh());
        let mut new =
            Self { body, tets, points, on: BTreeMap::new(), is_free: Vec::new(), around: Vec::new() };
        if surfaces.values().any(|line| !matches!(line, RigidLine::Plane { .. })) {
            new.find_constraints(surfaces);
        }
        new
    }

    fn find_constraints(&mut self, surfaces: &BTreeMap<FacetId, RigidLine<Solid>>) {
        let (mesh, tets) = (self.body.mesh(), self.tets);
        for (nodes, face) in tets.faces_on(|face| surfaces.contains_key(&face)) {
            for node in nodes {
                let lines = self.on.entry(node).or_default();
                if !lines.contains(&surfaces[&face]) {
                    lines.push(surfaces[&face]);
                }
            }
        }
        let topology = mesh.topology();
        let is_side = |face: FacetId| topology.is_boundary(face) && !surfaces.contains_key(&face);
        for (nodes, _) in tets.faces_on(is_side) {
            let corners = nodes.map(|node| self.points[node]);
            let normal = Solid::facet_normal(&corners);
            for node in nodes {
                let Some(lines) = self.on.get_mut(&node) else { continue };
                let is_known = |line: &RigidLine<Solid>| match line {
                    RigidLine::Plane { normal: other, .. } => {
                        norm(normal.cross(other)) <= SAME_NORMAL * norm(*other)
                    }
                    _ => false,
                };
                // A side that continues the surface gives way: in its plane the surface is far from the node.
                let continues = |line: &RigidLine<Solid>| {
                    !matches!(line, RigidLine::Plane { .. })
                        && line.distance(self.points[node]).1.dot(&normal).abs() > CONTINUES
                };
                if !lines.iter().any(|line| is_known(line) || continues(line)) {
                    lines.push(RigidLine::Plane { point: corners[0], normal });
                }
            }
        }
        self.is_free = vec![true; self.points.len()];
        let named: BTreeSet<FacetId> = mesh.groups().values().flatten().copied().collect();
        let materials = self.body.materials();
        let between = |face: FacetId| {
            let [a, b] = topology.facet_cells()[face].map(|cell| cell as usize);
            topology.is_boundary(face) || named.contains(&face) || materials.index(a) != materials.index(b)
        };
        for (nodes, _) in tets.faces_on(between) {
            nodes.iter().for_each(|node| self.is_free[node.index()] = false);
        }
        self.around = vec![Vec::new(); self.points.len()];
        for (number, cell) in (0..).zip(tets.cells()) {
            cell.iter().for_each(|node| self.around[node.index()].push(number));
        }
    }

    /// Finds the way of a node to its surfaces, m; zero if it is there.
    fn way(&self, node: NodeId) -> Vector {
        let Some(lines) = self.on.get(&node) else { return Vector::zeros() };
        let start = self.points[node];
        let limit = ON_SURFACE * self.body.mesh().diagonal();
        if lines.iter().all(|line| line.distance(start).0.abs() <= limit) {
            return Vector::zeros();
        }
        let mut at = start;
        for _ in 0..ROUNDS {
            let rows: Vec<(f64, Vector)> = lines.iter().map(|line| line.distance(at)).collect();
            let matrix = DMatrix::from_fn(rows.len(), 3, |row, c| rows[row].1[c]);
            let right = DVector::from_fn(rows.len(), |row, _| rows[row].0);
            let Ok(step) = matrix.svd(true, true).solve(&right, SAME_NORMAL) else { break };
            at += Vector::new(step[0], step[1], step[2]);
            if step.norm() <= limit {
                break;
            }
        }
        if at.is_finite() { at - start } else { Vector::zeros() }
    }

    /// Moves a node, and its neighbours inside the body by a part of that; `None` if a cell would lose too much of its volume.
    fn moved(&self, node: NodeId, by: Vector, ring: f64) -> Option<HashMap<NodeId, Vector>> {
        let mut moved = HashMap::from([(node, self.points[node] + by)]);
        let cells =
            |node: NodeId| self.around[node.index()].iter().map(|cell| self.tets.cells()[*cell as usize]);
        if ring > 0.0 {
            let near = cells(node).flatten().filter(|other| self.is_free[other.index()]);
            moved.extend(near.map(|other| (other, self.points[other] + ring * by)));
        }
        let measure = |corners: [Vector; 4]| Solid::measure(&corners);
        let keeps = |cell: [NodeId; 4]| {
            let after = measure(cell.map(|n| moved.get(&n).copied().unwrap_or(self.points[n])));
            after >= LEAST_VOLUME * measure(cell.map(|n| self.points[n]))
        };
        let all = moved.keys().all(|node| cells(*node).all(keeps));
        all.then_some(moved)
    }

    /// Lists the nodes that are not on their surfaces.
    #[cfg(test)]
    fn off(&self) -> Vec<NodeId> {
        self.on.keys().copied().filter(|node| self.way(*node) != Vector::zeros()).collect()
    }
}

/// Moves the new nodes of bodies onto their surfaces, one after the other in the order of their creation, by 1, ½, ¼ or 0 of the way: no cell loses
/// more than 70 % of its volume by one move. Nodes with one representative move by the same part of their ways. Nodes that an earlier
/// refinement could not move are tried again, and those that were inserted into the faces of a first mesh move as well.
pub fn move_onto_surfaces(bodies: &mut [FinerBody<'_>], order: &EdgeOrder) {
    let mut classes: BTreeMap<u32, Vec<BodyNode>> = BTreeMap::new();
    for (b, body) in bodies.iter().enumerate() {
        let of = order.representatives(b);
        let moves = |node: &&NodeId| !order.is_first((b, **node)) || body.body.is_inserted(**node);
        for node in body.on.keys().filter(moves) {
            classes.entry(of[node.index()]).or_default().push((b, *node));
        }
    }
    for class in classes.values() {
        let ways: Vec<Vector> = class.iter().map(|(b, node)| bodies[*b].way(*node)).collect();
        if ways.iter().all(|way| *way == Vector::zeros()) {
            continue;
        }
        let tries = FRACTIONS.into_iter().flat_map(|part| RING.map(|ring| (part, ring)));
        let moved = |(part, ring): (f64, f64)| -> Option<Vec<_>> {
            let all = class.iter().zip(&ways);
            all.map(|((b, node), way)| Some((*b, bodies[*b].moved(*node, part * way, ring)?))).collect()
        };
        let Some(found) = tries.into_iter().find_map(moved) else { continue };
        for (b, moved) in found {
            moved.into_iter().for_each(|(node, to)| bodies[b].points[node] = to);
        }
    }
}

#[cfg(test)]
mod tests;

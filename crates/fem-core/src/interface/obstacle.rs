//! Rigid obstacles: lines that do not deform, held or moved, or free to move under a force.

use super::clamped_ends::Line;
use super::matching::{TOLERANCE, walk};
use super::normals::SUPPORT;
use super::refinement::measure_arc;
use super::{ContactFacet, ContactInterface, Gap, GapChange, InterfaceError, NodePair, facet_size, pairing};
use crate::body::{Body, RigidMotion};
use crate::geometry::{self, Coordinates, cross, norm};
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::topology::NONE;
use crate::space::{Plane, Space};
use std::collections::HashMap;

/// Cosine of the largest angle between a contact edge and the obstacle: 60 degrees.
const FACING: f64 = 0.5;
/// An overlap of the undeformed body up to this fraction of its diagonal is rounding of the mesh: it touches.
const TOUCHING: f64 = 1e-6;
/// A change of the gap up to this fraction of the body's diagonal is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The line of a rigid obstacle, in space its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidLine<S: Space = Plane> {
    /// A straight line, or a plane.
    Plane {
        /// A point of it, m.
        point: S::Vector,
        /// Out of the obstacle, to the body; of any length except zero.
        normal: S::Vector,
    },
    /// A circle, or a sphere.
    Circle {
        /// Its centre, m.
        centre: S::Vector,
        /// Its radius, m.
        radius: f64,
        /// True if the body is inside, so that the obstacle is a hole.
        inside: bool,
    },
    /// An endless cylinder in space; in the plane a strip.
    Cylinder {
        /// A point of its axis, m.
        point: S::Vector,
        /// The direction of its axis, of any length except zero.
        axis: S::Vector,
        /// Its radius, m.
        radius: f64,
        /// True if the body is inside, so that the obstacle is a bore.
        inside: bool,
    },
}

impl<S: Space> RigidLine<S> {
    /// Computes the distance of a point from the line, m, negative inside the obstacle, and the unit normal out of the
    /// body, into the obstacle.
    pub fn distance(&self, point: S::Vector) -> (f64, S::Vector) {
        match *self {
            Self::Plane { point: origin, normal } => {
                let out = normal / norm(normal);
                ((point - origin).times(&out), -out)
            }
            Self::Circle { centre, radius, inside } => round::<S>(point - centre, radius, inside),
            Self::Cylinder { point: start, axis, radius, inside } => {
                round::<S>(across::<S>(point - start, axis), radius, inside)
            }
        }
    }

    /// Computes the frozen normal of a body at a point, into the obstacle: `±(x − c)/R` if it is round, from its centre or its axis, and of length
    /// one if it is a plane. With one `R` for all nodes, `n_i·(ω × x_j) + n_j·(ω × x_i) = 0`: rotations about the centre or the axis open nothing.
    pub(super) fn frozen_normal(&self, point: S::Vector) -> S::Vector {
        let out =
            |arm: S::Vector, radius: f64, inside: bool| arm * (if inside { 1.0 } else { -1.0 } / radius);
        match *self {
            Self::Plane { .. } => self.distance(point).1,
            Self::Circle { centre, radius, inside } => out(point - centre, radius, inside),
            Self::Cylinder { point: start, axis, radius, inside } => {
                out(across::<S>(point - start, axis), radius, inside)
            }
        }
    }
}

/// Computes the part of an arm across an axis.
fn across<S: Space>(arm: S::Vector, axis: S::Vector) -> S::Vector {
    arm - axis * (arm.times(&axis) / axis.times(&axis))
}

/// Computes distance and normal of a round obstacle, see [`RigidLine::distance`].
///
/// * `arm`: from its centre or its axis.
fn round<S: Space>(arm: S::Vector, radius: f64, inside: bool) -> (f64, S::Vector) {
    let length = norm(arm);
    let out = if length > 0.0 { arm * (1.0 / length) } else { S::AXES[0] };
    if inside { (radius - length, out) } else { (length - radius, -out) }
}

/// A rigid obstacle in a pair with one body: each component of its motion is imposed, or free under its load.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Obstacle<S: Space = Plane> {
    /// Its line.
    pub line: RigidLine<S>,
    /// Imposed displacements along the axes, m, and rotations about [`Self::about`], radians, in the order of [`Space::MOTIONS`]; `None`: free.
    pub motion: S::Components<Option<f64>>,
    /// Resultant of its load, N/m; it acts along free components only.
    pub force: S::Vector,
    /// Moment of its load about [`Self::about`], N.
    pub moment: S::Spin,
    /// The point about which it rotates, m.
    pub about: S::Vector,
    /// The point that faces each contact node of the body, m; set by [`super::ContactProblem::obstacle`].
    pub(super) points: Vec<S::Vector>,
}

impl<S: Space> Obstacle<S> {
    /// Creates a fixed obstacle.
    pub fn fixed(line: RigidLine<S>) -> Self {
        let about = match line {
            RigidLine::Plane { point, .. } | RigidLine::Cylinder { point, .. } => point,
            RigidLine::Circle { centre, .. } => centre,
        };
        Self {
            line,
            motion: S::components(|_| Some(0.0)),
            force: S::Vector::ZERO,
            moment: S::Spin::default(),
            about,
            points: Vec::new(),
        }
    }

    /// Imposes a translation.
    ///
    /// * `by`: the displacement, m.
    #[must_use]
    pub fn moved(mut self, by: impl Into<S::Vector>) -> Self {
        let by = by.into();
        self.motion = S::components(|k| if k < S::DIM { Some(by[k]) } else { self.motion[k] });
        self
    }

    /// Lets the components without an imposed value move under a load.
    ///
    /// * `motion`: imposed values, see [`Self::motion`]; `None`: free. `force`, N/m, and `moment` about `about`, N.
    #[must_use]
    pub fn stamp(
        mut self,
        motion: S::Components<Option<f64>>,
        (force, moment): (impl Into<S::Vector>, S::Spin),
        about: impl Into<S::Vector>,
    ) -> Self {
        self.motion = motion;
        (self.force, self.moment, self.about) = (force.into(), moment, about.into());
        self
    }

    /// Returns the points that face the contact nodes, m.
    pub fn points(&self) -> &[S::Vector] {
        &self.points
    }

    /// Computes the imposed displacement of each of its points, m: zero along free components.
    pub fn imposed(&self) -> Vec<S::Vector> {
        self.points.iter().map(|p| self.imposed_at(*p)).collect()
    }

    fn imposed_at(&self, point: S::Vector) -> S::Vector {
        let (translation, spin) = S::parts(&S::components(|k| self.motion[k].unwrap_or(0.0)));
        translation + S::turned(spin, point - self.about)
    }

    /// Tells whether its motion is imposed.
    fn is_held(&self) -> bool {
        self.motion.as_ref().iter().all(Option::is_some)
    }

    /// Returns what is imposed on a node of a body and on the obstacle's point that faces it, if a support clamps the node, m.
    pub(super) fn clamped(&self, body: &Body<S>, pair: &NodePair<S>) -> Option<[S::Vector; 2]> {
        let constraint = &body.node_constraints()[pair.nodes[0]];
        let facing = || self.imposed_at(self.point_facing(body, pair));
        constraint.is_clamped().then(|| [constraint.displacement(), facing()])
    }

    /// Returns the nearest point to a node; the node itself if its normal is not of length one. Both move alike along the normal, and between
    /// nodes a rotation about the centre then opens nothing.
    fn point_facing(&self, body: &Body<S>, pair: &NodePair<S>) -> S::Vector {
        let point = body.mesh().points()[pair.nodes[0]];
        if pair.normal_length() != 1.0 {
            return point;
        }
        point + pair.normal * self.line.distance(point).0
    }

    /// Lists its free motions, each with the work of the load along a unit of the motion.
    pub fn free_motions(&self) -> Vec<(RigidMotion<S>, f64)> {
        let size = self.size();
        let load = S::motion(self.force, self.moment);
        let free = (0..S::COMPONENTS).filter(|k| self.motion[*k].is_none());
        free.map(|k| {
            // A rotation is scaled so that it is comparable with a translation.
            let unit = if k < S::DIM { 1.0 } else { 1.0 / size };
            let (translation, spin) = S::parts(&S::components(|j| if j == k { unit } else { 0.0 }));
            let motion = RigidMotion { piece: 0, translation, spin, centre: self.about };
            (motion, if k < S::DIM { load[k] } else { load[k] / size })
        })
        .collect()
    }

    /// Computes the size of its load, N/m: the moment counts by the size of the contact.
    pub fn load_size(&self) -> f64 {
        let load = S::motion(self.force, self.moment);
        let moments = (S::DIM..S::COMPONENTS).map(|k| load[k].abs());
        norm(self.force) + moments.fold(0.0, f64::hypot) / self.size()
    }

    /// Returns the size of the contact, m.
    fn size(&self) -> f64 {
        geometry::diagonal(&self.points).max(f64::MIN_POSITIVE)
    }

    /// Computes the displacement of each of its points in a rigid motion, m.
    pub fn moved_by(&self, motion: &RigidMotion<S>) -> Vec<S::Vector> {
        self.points.iter().map(|p| motion.at(*p)).collect()
    }

    /// Takes the points that face the contact nodes of its body.
    pub(super) fn facing(mut self, body: &Body<S>, interface: &ContactInterface<S>) -> Self {
        self.points = interface.pairs().iter().map(|pair| self.point_facing(body, pair)).collect();
        self
    }
}

impl ContactInterface {
    /// Pairs a side of a body with a rigid obstacle: each node with the nearest point of the line. Edges that do not face the
    /// line, by more than 60 degrees, are free. The gap is linear along the edges. A node at an end of a straight side that a
    /// support clamps has no pair if the obstacle's motion is imposed: the opening there is known, and its edge takes the pressure of
    /// its other end.
    ///
    /// * `surface`: the edge group; `obstacle`: the one that the pair is made with.
    /// * `gap`: overrides the distance from the line, which is then at most 5 % of an edge; `None`: the distance, ≥ 0 to rounding of
    ///   the mesh.
    ///
    /// # Errors
    /// A side that does not face the line, overlaps it, or is held or loaded, a clamped node that is pressed into the obstacle, see
    /// [`InterfaceError`].
    pub fn against(
        body: &Body,
        surface: &str,
        obstacle: &Obstacle,
        gap: Option<&Gap>,
    ) -> Result<Self, InterfaceError> {
        let line = &obstacle.line;
        let mesh = body.mesh();
        let all = pairing::group(body, 0, surface)?;
        let edges: Vec<FacetId> = all.iter().copied().filter(|edge| faces(body, line, *edge)).collect();
        if edges.is_empty() {
            return Err(InterfaceError::NotFacing { point: mesh.facet_middle(all[0]).into() });
        }
        pairing::check_free(body, 0, surface, &edges)?;
        let chain = walk(body, &edges);
        check_apart(body, line, &edges, gap)?;
        let mut line_of_nodes = Chained { may_be_clamped: obstacle.is_held(), ..Chained::default() };
        for stretch in &chain {
            line_of_nodes.add(body, line, stretch.nodes.as_slice(), &stretch.edges, gap)?;
        }
        let gap_change = gap.and_then(|_| change(body, line, &line_of_nodes.pairs));
        let gap = gap.cloned().unwrap_or(Gap::Geometric);
        let (interface, _) = line_of_nodes.into_interface(body, obstacle, gap)?;
        Ok(Self { gap_change, ..interface })
    }

    /// Creates the interface of a refined body against the same obstacle, and the parents of its pairs.
    ///
    /// * `middle`: the new node in the middle of each old edge, or [`NodeId::NONE`].
    pub(super) fn refined_against(
        &self,
        body: &Body,
        middle: &[NodeId],
        obstacle: &Obstacle,
    ) -> Result<(Self, Vec<[u32; 2]>), InterfaceError> {
        let line = &obstacle.line;
        let (old_pairs, old_edges, _) = self.line();
        let old_arcs = self.line_arc_lengths();
        let gap = if matches!(self.gap, Gap::Geometric) { None } else { Some(&self.gap) };
        let mut starting = vec![None; old_pairs.len()];
        old_edges.iter().for_each(|edge| starting[edge.pairs[0] as usize] = Some(edge));
        let mut found = Chained { may_be_clamped: obstacle.is_held(), ..Chained::default() };
        let mut parents = Vec::new();
        let mut number = vec![0; old_pairs.len()];
        for (k, pair) in old_pairs.iter().enumerate() {
            number[k] = found.pairs.len() as u32;
            found.pairs.push(NodePair { weight: 0.0, ..*pair });
            found.arc_lengths.push(old_arcs[k]);
            parents.push([k as u32; 2]);
            let halved = starting[k].map(|edge| (edge, middle[edge.facets[0].index()]));
            if let Some((edge, node)) = halved.filter(|(_, node)| *node != NodeId::NONE) {
                found.pairs.push(found.pair(body, line, node, gap)?);
                found.arc_lengths.push(old_arcs[k] + 0.5 * edge.measure);
                parents.push(edge.pairs);
            }
        }
        for edge in old_edges {
            let [i, j] = edge.pairs.map(|k| number[k as usize]);
            let ends = match middle[edge.facets[0].index()] {
                NodeId::NONE => vec![[i, j]],
                _ => vec![[i, i + 1], [i + 1, j]],
            };
            for ends in ends {
                let [a, b] = ends.map(|k| found.pairs[k as usize].nodes[0]);
                if let Some(edge) = body.mesh().topology().find_edge(a, b) {
                    found.join(body, ends, edge);
                }
            }
        }
        if body.has_curves() {
            found.arc_lengths = measure_arc(found.pairs.len(), &found.edges);
        }
        let (interface, numbers) = found.into_interface(body, obstacle, self.gap.clone())?;
        let kept = parents.into_iter().zip(numbers).filter(|(_, n)| *n != NONE);
        let parents = kept.map(|(parents, _)| self.numbers(parents)).collect();
        Ok((interface, parents))
    }
}

/// Refuses a side with a node inside the obstacle, with the deepest one; if the gap is given, a side that is apart from it or
/// inside by more than a part of an edge.
pub(super) fn check_apart<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    facets: &[FacetId],
    gap: Option<&Gap<S>>,
) -> Result<(), InterfaceError> {
    let mesh = body.mesh();
    let given = matches!(gap, Some(Gap::Given(_) | Gap::Touching));
    let at = |node: NodeId, facet: FacetId| {
        let spacing = facet_size::<S>(mesh.facet_measure(facet));
        let distance = line.distance(mesh.points()[node]).0;
        let off = if given { distance.abs() - TOLERANCE * spacing } else { -distance };
        (off, distance, node, spacing)
    };
    let nodes = |facet: &FacetId| mesh.topology().facets()[*facet].into_iter();
    let all = facets.iter().flat_map(|facet| nodes(facet).map(|node| at(node, *facet)));
    let Some((off, distance, node, spacing)) = all.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let point = mesh.points()[node];
    if given && off > 0.0 {
        return Err(InterfaceError::Distance { point: point.into(), gap: distance, spacing });
    }
    if !given && off > TOUCHING * mesh.diagonal() {
        return Err(InterfaceError::Overlap { point: point.into(), depth: off, spacing });
    }
    Ok(())
}

/// Creates the pair of a node and an obstacle, without a weight.
///
/// * `nodes`: the node, and the number of the pair.
pub(super) fn pair_with<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    nodes: [NodeId; 2],
    gap: Option<&Gap<S>>,
) -> Result<NodePair<S>, InterfaceError> {
    let point = body.mesh().points()[nodes[0]];
    let (distance, normal) = line.distance(point);
    let gap = match gap {
        Some(Gap::Given(data)) => data.at(point),
        Some(Gap::Touching) => 0.0,
        Some(Gap::Geometric) | None => {
            let size = body.mesh().diagonal();
            if distance < -TOUCHING * size {
                let around = body.mesh().topology().cells_around(nodes[0]).first();
                let root = 1.0 / S::DIM as f64;
                let spacing = around.map_or(size, |t| body.mesh().measure(*t as usize).powf(root));
                return Err(InterfaceError::Overlap { point: point.into(), depth: -distance, spacing });
            }
            distance.max(0.0)
        }
    };
    if !(gap >= 0.0 && gap.is_finite()) {
        return Err(InterfaceError::BadGap { point: point.into(), value: gap });
    }
    Ok(NodePair { nodes, normal, gap, weight: 0.0 })
}

/// Tells whether a facet faces an obstacle, to 60 degrees.
pub(super) fn faces<S: Space>(body: &Body<S>, line: &RigidLine<S>, facet: FacetId) -> bool {
    line.distance(body.mesh().facet_middle(facet)).1.times(&body.mesh().facet_normal(facet)) >= FACING
}

/// Finds the node at which a given gap differs most from the distance of the line.
pub(super) fn change<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    pairs: &[NodePair<S>],
) -> Option<GapChange<S>> {
    let points = body.mesh().points();
    let change = |pair: &NodePair<S>| {
        let point = points[pair.nodes[0]];
        GapChange { point, drawn: line.distance(point).0, used: pair.gap / pair.normal_length() }
    };
    let size = |c: &GapChange<S>| (c.used - c.drawn).abs();
    let largest = pairs.iter().map(change).max_by(|a, b| size(a).total_cmp(&size(b)));
    largest.filter(|c| size(c) > ROUND_OFF * body.mesh().diagonal())
}

/// Pairs and edges along an obstacle.
#[derive(Default)]
struct Chained {
    pairs: Vec<NodePair>,
    edges: Vec<ContactFacet>,
    /// At each pair, m.
    arc_lengths: Vec<f64>,
    /// The arc length so far, m.
    arc_length: f64,
    /// Set if a support may clamp a node: the obstacle's motion is imposed.
    may_be_clamped: bool,
}

impl Chained {
    /// Makes the interface without clamped pairs, and lists the number of each pair in it, or [`NONE`].
    fn into_interface(
        self,
        body: &Body,
        obstacle: &Obstacle,
        gap: Gap,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        let profiles = vec![None; self.edges.len()];
        let line = Line { pairs: self.pairs, edges: self.edges, arc_lengths: self.arc_lengths, profiles };
        let (mut interface, numbers) =
            line.without_clamped(body, &|pair| obstacle.clamped(body, pair), gap, 0)?;
        interface.pairs.iter_mut().enumerate().for_each(|(k, pair)| pair.nodes[1] = NodeId::new(k));
        Ok((interface, numbers))
    }

    /// Adds a stretch.
    fn add(
        &mut self,
        body: &Body,
        line: &RigidLine,
        nodes: &[NodeId],
        edges: &[FacetId],
        gap: Option<&Gap>,
    ) -> Result<(), InterfaceError> {
        let mut number: HashMap<NodeId, u32> = HashMap::new();
        for (k, &node) in nodes.iter().enumerate() {
            if k > 0 {
                self.arc_length += body.mesh().facet_measure(edges[k - 1]);
            }
            number.insert(node, self.pairs.len() as u32);
            let pair = self.pair(body, line, node, gap)?;
            self.pairs.push(pair);
            self.arc_lengths.push(self.arc_length);
        }
        for (k, &edge) in edges.iter().enumerate() {
            let ends = [nodes[k], nodes[(k + 1) % nodes.len()]].map(|n| number[&n]);
            self.join(body, ends, edge);
        }
        Ok(())
    }

    /// Creates the pair of a node and the obstacle.
    fn pair(
        &self,
        body: &Body,
        line: &RigidLine,
        node: NodeId,
        gap: Option<&Gap>,
    ) -> Result<NodePair, InterfaceError> {
        let (point, normal) = (body.mesh().points()[node], line.distance(body.mesh().points()[node]).1);
        let constraint = &body.node_constraints()[node];
        let allowed = self.may_be_clamped && constraint.is_clamped();
        if !allowed && norm(constraint.held.components(normal)) > SUPPORT {
            return Err(InterfaceError::SupportedNode { body: 0, point: point.into() });
        }
        pair_with(body, line, [node, NodeId::new(self.pairs.len())], gap)
    }

    /// Adds the edge between two pairs and its length to their tributary lengths.
    fn join(&mut self, body: &Body, ends: [u32; 2], edge: FacetId) {
        let length = body.mesh().facet_measure(edge);
        for k in ends {
            self.pairs[k as usize].weight += 0.5 * length;
        }
        let [a, b] = ends.map(|k| self.pairs[k as usize].normal);
        let bent = norm(a - b) > super::SAME_NORMAL || cross(a, b).abs() > super::SAME_NORMAL;
        self.edges.push(ContactFacet {
            pairs: ends,
            facets: [edge; 2],
            measure: length,
            bent,
            clamped: None,
        });
    }
}

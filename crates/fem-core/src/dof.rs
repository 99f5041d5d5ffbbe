//! The unknowns of a body: node frames, imposed values, and their number in the order of elimination.

mod fronts;

use crate::body::{Body, NodeConstraint, RigidMotion};
use crate::cholesky::Front;
use crate::directions::dual;
use crate::geometry::{PARALLEL, Vector, cross, norm, perpendicular};
use crate::interface::{InterfaceSide, Retained};
use crate::mesh::id::NodeId;
use crate::ordering;
use fronts::Fronts;
use std::collections::BTreeMap;

/// Number of an imposed component in [`DofMap::number`].
pub const IMPOSED: u32 = u32::MAX;

/// A product of an axis and a direction that is this close to a whole number is that number.
const DUAL: f64 = 1e-14;

/// An axis whose length is this close to one is of length one.
const UNIT: f64 = 1e-14;

/// Maps displacement components to unknowns.
///
/// Each node has an orthonormal frame `(a, a⊥)`: Cartesian, or rotated into the direction of a roller or
/// of the contact normal. A contact node with normal `n` that is fixed along `d`, not perpendicular to `n`, has the
/// frame dual to the two: `e₀·n = e₁·d = 1`, `e₀·d = e₁·n = 0`. Its unknown is also the normal trace `u·n`, and its
/// force is due to a pressure along `n`. A free node whose normal is not of length one has `e₀ = n/|n|²`. A node with two
/// retained directions has the frame dual to these. The nodes of a rigid side follow the free motions of the side, one
/// unknown each. Unknowns are numbered in the order of elimination: nodes, rigid sides, interface; on the interface in the
/// order of the retained directions.
#[derive(Clone, Debug)]
pub struct DofMap {
    axes: Vec<Vector>,
    /// The second axes of the nodes whose frame is not orthogonal, by node.
    oblique: Vec<(NodeId, Vector)>,
    numbers: Vec<[u32; 2]>,
    imposed: Vec<[f64; 2]>,
    /// 2·node + component of every unknown.
    unknowns: Vec<u32>,
    interface: usize,
    /// The trace along each retained direction, block by block.
    rows: Vec<Vec<TraceRow>>,
    fronts: Vec<Front>,
    rigid: RigidUnknowns,
}

/// The unknowns of the rigid sides that are free to move.
#[derive(Clone, Debug, Default, PartialEq)]
struct RigidUnknowns {
    /// The number of the first one; the others follow.
    first: usize,
    /// The motion of each unknown, and its side.
    motions: Vec<(RigidMotion, u32)>,
    /// The nodes of all sides, ascending: place and side.
    nodes: Vec<(NodeId, Vector, u32)>,
}

impl RigidUnknowns {
    fn new(body: &Body, first: usize) -> Self {
        let mut found = Self { first, ..Self::default() };
        let sides = body.rigid_sides().iter().enumerate();
        for (k, side) in sides.filter(|(_, side)| !side.motions.is_empty()) {
            found.motions.extend(side.motions.iter().map(|motion| (*motion, k as u32)));
            let points = body.mesh().points();
            found.nodes.extend(side.nodes.iter().map(|n| (*n, points[*n], k as u32)));
        }
        found.nodes.sort_unstable_by_key(|(node, ..)| *node);
        found
    }

    /// Returns the motion of an unknown, and the places of the nodes that follow it; `None` for the unknowns of nodes.
    fn of(&self, unknown: usize) -> Option<(&RigidMotion, impl Iterator<Item = (usize, Vector)> + '_)> {
        let (motion, side) = self.motions.get(unknown.checked_sub(self.first)?)?;
        let nodes = self.nodes.iter().filter(move |(.., s)| s == side);
        Some((motion, nodes.map(|(node, point, _)| (node.index(), *point))))
    }

    /// Lists the unknowns that a node follows, with its displacement per unit of each.
    fn followed(&self, node: usize) -> impl Iterator<Item = (usize, Vector)> + '_ {
        let place = self.nodes.binary_search_by_key(&NodeId::new(node), |(node, ..)| *node).ok();
        place.into_iter().flat_map(move |place| {
            let (_, point, side) = self.nodes[place];
            let motions = self.motions.iter().enumerate().filter(move |(_, (_, s))| *s == side);
            motions.map(move |(k, (motion, _))| (self.first + k, motion.at(point)))
        })
    }
}

/// The trace along a retained direction in the interface unknowns `x`: `Σ a_k x_k + c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceRow {
    /// Interface unknowns with their factors; a factor of zero belongs to no unknown.
    terms: [(u32, f64); 2],
    /// The constant, which supports impose, m.
    pub imposed: f64,
}

impl TraceRow {
    /// Lists the interface unknowns with their factors, none of which is 0.
    pub fn terms(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.terms.iter().filter(|term| term.1 != 0.0).map(|(k, a)| (*k as usize, *a))
    }
}

impl DofMap {
    /// Numbers the unknowns of a body whose interface is `side` (empty for a body alone).
    pub fn new(body: &Body, side: &InterfaceSide) -> Self {
        let nodes = body.mesh().points().len();
        let Frames { axes, oblique, fixed, imposed, kept } = Frames::new(body, side);
        let mut numbers = vec![[IMPOSED; 2]; nodes];
        let mut unknowns = Vec::with_capacity(2 * nodes);
        let mut give = |node: usize, c: usize, unknowns: &mut Vec<u32>| {
            if !fixed[node][c] && numbers[node][c] == IMPOSED {
                numbers[node][c] = unknowns.len() as u32;
                unknowns.push((2 * node + c) as u32);
            }
        };
        let dissection = ordering::dissect(body.mesh());
        let mut fronts = Fronts::default();
        for part in &dissection.parts {
            for &node in &dissection.order[part.nodes.clone()] {
                let node = node.index();
                for c in [0, 1].into_iter().filter(|c| !kept[node][*c]) {
                    give(node, c, &mut unknowns);
                }
            }
            fronts.part(part.parent, unknowns.len());
        }
        let rigid = RigidUnknowns::new(body, unknowns.len());
        for (k, (_, side)) in rigid.motions.iter().enumerate() {
            unknowns.push((2 * body.rigid_sides()[*side as usize].nodes[0].index() + k % 2) as u32);
        }
        fronts.above(unknowns.len());
        let interior = unknowns.len();
        for retained in side.retained() {
            let node = retained.node.index();
            for c in [0, 1].into_iter().filter(|c| kept[node][*c]) {
                give(node, c, &mut unknowns);
            }
        }
        let interface = unknowns.len() - interior;
        let fronts = fronts.finish(interior, interface);
        debug_assert_eq!(fronts.last().map_or(0, |f| f.columns.end as usize), unknowns.len());
        let rows = Vec::new();
        let mut map = Self { axes, oblique, numbers, imposed, unknowns, interface, rows, fronts, rigid };
        map.rows = map.rows_of(side);
        map
    }

    /// Returns the same unknowns with the values that the supports of `body` impose now; `None` if its supports, its rigid sides or its
    /// retained directions differ from this map's.
    ///
    /// * `body`: on the same mesh.
    pub fn with_imposed(&self, body: &Body, side: &InterfaceSide) -> Option<Self> {
        let Frames { axes, oblique, fixed, imposed, kept } = Frames::new(body, side);
        let rigid = RigidUnknowns::new(body, self.rigid.first);
        let first = (self.unknowns.len() - self.interface) as u32;
        let known = |number: u32, fixed: bool, kept: bool| match number {
            IMPOSED => fixed,
            number => !fixed && kept == (number >= first),
        };
        let mut flags = self.numbers.iter().zip(fixed.iter().zip(&kept));
        let same = self.numbers.len() == fixed.len()
            && flags.all(|(numbers, (fixed, kept))| (0..2).all(|c| known(numbers[c], fixed[c], kept[c])))
            && (&axes, &oblique, &rigid) == (&self.axes, &self.oblique, &self.rigid);
        if !same {
            return None;
        }
        let mut map = Self { imposed, ..self.clone() };
        map.rows = map.rows_of(side);
        Some(map)
    }

    /// Returns the number of unknowns.
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Tells whether all displacements are imposed.
    pub fn is_empty(&self) -> bool {
        self.unknowns.is_empty()
    }

    /// Returns the fronts of the factorisation, the interface last.
    pub fn fronts(&self) -> &[Front] {
        &self.fronts
    }

    /// Returns the number of interface unknowns, the last ones.
    pub fn interface_len(&self) -> usize {
        self.interface
    }

    /// Returns the trace along each retained direction of a block.
    ///
    /// # Panics
    /// If there is no such block.
    pub fn rows(&self, block: usize) -> &[TraceRow] {
        &self.rows[block]
    }

    /// Computes the trace along every retained direction, block by block, m: `B v` and what supports impose.
    ///
    /// * `v`: the interface unknowns, m.
    pub fn traces(&self, v: &[f64]) -> Vec<Vec<f64>> {
        let trace = |row: &TraceRow| row.terms().map(|(k, a)| a * v[k]).sum::<f64>() + row.imposed;
        self.rows.iter().map(|block| block.iter().map(trace).collect()).collect()
    }

    /// Computes the forces on the interface unknowns, N/m: `Bᵀ r`.
    ///
    /// * `forces`: along the retained directions, block by block, N/m.
    ///
    /// # Panics
    /// If there is not one force per retained direction.
    pub fn interface_forces(&self, forces: &[Vec<f64>]) -> Vec<f64> {
        let sizes = |blocks: &mut dyn Iterator<Item = usize>| blocks.collect::<Vec<_>>();
        let (found, expected) =
            (sizes(&mut forces.iter().map(Vec::len)), sizes(&mut self.rows.iter().map(Vec::len)));
        assert!(found == expected, "{found:?} forces by block, and {expected:?} retained directions");
        let mut sum = vec![0.0; self.interface];
        for (row, force) in self.rows.iter().flatten().zip(forces.iter().flatten()) {
            for (k, a) in row.terms() {
                sum[k] += a * force;
            }
        }
        sum
    }

    /// Expresses the traces along all retained directions in the interface unknowns, block by block.
    fn rows_of(&self, side: &InterfaceSide) -> Vec<Vec<TraceRow>> {
        let blocks = (0..side.blocks()).map(|block| &side.retained()[side.block(block)]);
        blocks.map(|block| block.iter().map(|retained| self.row(retained)).collect()).collect()
    }

    /// Expresses the trace along a retained direction in the interface unknowns.
    fn row(&self, retained: &Retained) -> TraceRow {
        let (node, start) = (retained.node.index(), (self.unknowns.len() - self.interface) as u32);
        let mut row = TraceRow { terms: [(0, 0.0); 2], imposed: 0.0 };
        for c in [0, 1] {
            let factor = self.axis(node, c).dot(&retained.direction);
            // Frames are dual to the retained directions to round-off.
            let whole = factor.round();
            let factor = if (factor - whole).abs() <= DUAL { whole } else { factor };
            match self.numbers[node][c] {
                IMPOSED => row.imposed += factor * self.imposed[node][c],
                number if number >= start => row.terms[c] = (number - start, factor),
                // The trace does not depend on the other component.
                _ => {}
            }
        }
        row
    }

    /// Returns the unknown of component `c` in the node's frame, or [`IMPOSED`].
    pub fn number(&self, node: usize, c: usize) -> u32 {
        self.numbers[node][c]
    }

    /// Returns the imposed value of component `c` in the node's frame; 0 for an unknown.
    pub fn imposed(&self, node: usize, c: usize) -> f64 {
        self.imposed[node][c]
    }

    /// Lists the unknowns of rigid sides that a node follows, with its displacement per unit of each.
    pub fn followed(&self, node: usize) -> impl Iterator<Item = (usize, Vector)> + '_ {
        self.rigid.followed(node)
    }

    /// Tells whether a rigid side is free to move.
    pub fn has_rigid(&self) -> bool {
        !self.rigid.motions.is_empty()
    }

    /// Tells whether an unknown belongs to a rigid side, not to a node.
    pub fn is_rigid(&self, number: usize) -> bool {
        self.rigid.of(number).is_some()
    }

    /// Lists the nodes that an unknown moves, with their displacement per unit of it: one node, unless it belongs to a rigid side.
    pub fn moved(&self, number: usize) -> impl Iterator<Item = (usize, Vector)> + '_ {
        let side = self.rigid.of(number);
        let (node, c) = self.unknown(number);
        let own = side.is_none().then(|| (node, self.axis(node, c)));
        let of_side =
            side.into_iter().flat_map(|(motion, nodes)| nodes.map(|(node, point)| (node, motion.at(point))));
        own.into_iter().chain(of_side)
    }

    /// Returns node and component of an unknown; of a rigid side's, one of its nodes.
    pub fn unknown(&self, number: usize) -> (usize, usize) {
        let code = self.unknowns[number] as usize;
        (code / 2, code % 2)
    }

    /// Returns the interface unknowns of a displacement, m.
    ///
    /// * `at`: the displacement of a node.
    pub fn interface_components(&self, at: impl Fn(usize) -> Vector) -> Vec<f64> {
        let interface = self.unknowns.len() - self.interface..self.unknowns.len();
        let component = |(node, c): (usize, usize)| self.component(node, c, at(node));
        interface.map(|unknown| component(self.unknown(unknown))).collect()
    }

    /// Returns axis `c` of a node's frame: displacements are sums of them, forces act along them.
    pub fn axis(&self, node: usize, c: usize) -> Vector {
        if c == 0 {
            return self.axes[node];
        }
        if !self.oblique.is_empty()
            && let Ok(place) = self.oblique.binary_search_by_key(&NodeId::new(node), |o| o.0)
        {
            return self.oblique[place].1;
        }
        perpendicular(self.axes[node])
    }

    /// Returns component `c` of a displacement in a node's frame: the displacement is the sum of the axes times the components.
    pub fn component(&self, node: usize, c: usize, displacement: Vector) -> f64 {
        if self.is_orthogonal(node) {
            return displacement.dot(&self.axis(node, c));
        }
        let [own, other] = [c, 1 - c].map(|c| self.axis(node, c));
        displacement.perp(&other) / own.perp(&other)
    }

    /// Tells whether the two axes of a node's frame are perpendicular to each other and of length one.
    pub fn is_orthogonal(&self, node: usize) -> bool {
        self.oblique.binary_search_by_key(&NodeId::new(node), |o| o.0).is_err()
    }

    /// Tells whether a node's frame is the Cartesian one.
    pub fn is_cartesian(&self, node: usize) -> bool {
        // The second of two directions may be −y.
        self.axes[node] == Vector::x() && self.is_orthogonal(node)
    }

    /// Expands unknowns into nodal displacements in Cartesian components, imposed values included.
    pub fn displacement(&self, x: &[f64]) -> Vec<Vector> {
        self.expand(x, 1.0)
    }

    /// Expands unknowns into a nodal correction, which vanishes where displacements are imposed.
    pub fn correction(&self, x: &[f64]) -> Vec<Vector> {
        self.expand(x, 0.0)
    }

    fn expand(&self, x: &[f64], imposed_factor: f64) -> Vec<Vector> {
        let value = |node: usize, c: usize| match self.numbers[node][c] {
            IMPOSED => imposed_factor * self.imposed[node][c],
            number => x[number as usize],
        };
        let at = |node: usize| {
            let local = Vector::new(value(node, 0), value(node, 1));
            if self.is_cartesian(node) {
                return local;
            }
            local[0] * self.axis(node, 0) + local[1] * self.axis(node, 1)
        };
        let mut all: Vec<Vector> = (0..self.numbers.len()).map(at).collect();
        for (node, ..) in &self.rigid.nodes {
            for (unknown, per_unit) in self.rigid.followed(node.index()) {
                all[*node] += x[unknown] * per_unit;
            }
        }
        all
    }
}

/// The frames of all nodes, and the values imposed along their axes.
struct Frames {
    axes: Vec<Vector>,
    /// Second axes that are not perpendicular to the first, by node; sorted at the end.
    oblique: Vec<(NodeId, Vector)>,
    fixed: Vec<[bool; 2]>,
    imposed: Vec<[f64; 2]>,
    /// True if a component is an interface unknown.
    kept: Vec<[bool; 2]>,
}

impl Frames {
    fn new(body: &Body, side: &InterfaceSide) -> Self {
        let nodes = body.mesh().points().len();
        let mut frames = Self {
            axes: vec![Vector::x(); nodes],
            oblique: Vec::new(),
            fixed: vec![[false; 2]; nodes],
            imposed: vec![[0.0; 2]; nodes],
            kept: vec![[false; 2]; nodes],
        };
        let mut second = BTreeMap::new();
        for &Retained { node, direction } in side.retained() {
            let place = node.index();
            if !frames.kept[place][0] {
                frames.kept[place][0] = true;
                frames.axes[place] = direction;
            } else if cross(frames.axes[place], direction).abs() > PARALLEL {
                second.entry(node).or_insert(direction);
            }
        }
        for (node, constraint) in body.node_constraints().iter().enumerate() {
            frames.constrain(node, constraint, second.contains_key(&NodeId::new(node)));
        }
        for (node, direction) in second {
            if frames.fixed[node.index()] == [false; 2] {
                frames.kept[node.index()] = [true; 2];
                frames.make_dual(node, direction);
            }
        }
        frames.oblique.sort_unstable_by_key(|(node, _)| *node);
        frames.scale(side);
        frames
    }

    /// Takes what a support imposes on a node.
    ///
    /// * `two`: whether the node has two retained directions.
    fn constrain(&mut self, node: usize, constraint: &NodeConstraint, two: bool) {
        let value = constraint.imposed[0];
        match *constraint.held.basis() {
            [] => {}
            [direction] if self.kept[node][0] && !two => {
                self.fixed[node][1] = true;
                let axis = self.axes[node];
                if direction.dot(&axis).abs() <= PARALLEL {
                    self.imposed[node][1] = value * direction.dot(&perpendicular(axis)).signum();
                    return;
                }
                // The pairing has checked that the support is far enough from the normal.
                self.make_dual(NodeId::new(node), direction);
                self.imposed[node][1] = value;
            }
            [direction] => {
                self.axes[node] = direction;
                self.fixed[node][0] = true;
                self.imposed[node][0] = value;
                // Of two retained directions one unknown remains.
                self.kept[node] = [false, two];
            }
            _ => {
                self.axes[node] = Vector::x();
                self.fixed[node] = [true; 2];
                self.imposed[node] = constraint.imposed.into();
            }
        }
    }

    /// Divides the first axes that are retained directions by their length squared: the unknown is the trace along the direction.
    fn scale(&mut self, side: &InterfaceSide) {
        let mut nodes: Vec<NodeId> = side.retained().iter().map(|retained| retained.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut scaled = Vec::new();
        for node in nodes {
            let place = node.index();
            let (axis, length) = (self.axes[place], norm(self.axes[place]));
            let unit = (length - 1.0).abs() <= UNIT || !self.kept[place][0];
            if !unit && self.oblique.binary_search_by_key(&node, |o| o.0).is_err() {
                self.axes[place] = 1.0 / (length * length) * axis;
                scaled.push((node, 1.0 / length * perpendicular(axis)));
            }
        }
        self.oblique.extend(scaled);
        self.oblique.sort_unstable_by_key(|(node, _)| *node);
    }

    /// Gives a node the frame dual to its first axis and another vector.
    fn make_dual(&mut self, node: NodeId, second: Vector) {
        let axis = &mut self.axes[node.index()];
        let frame = dual([*axis, second]);
        *axis = frame[0];
        self.oblique.push((node, frame[1]));
    }
}

//! The unknowns of a body: node frames, imposed values, and their number in the order of elimination.

mod frames;
mod fronts;

use crate::body::{Body, RigidMotion};
use crate::cholesky::Front;
use crate::geometry::Coordinates;
use crate::interface::{InterfaceSide, Retained};
use crate::mesh::id::NodeId;
use crate::ordering;
use crate::space::{Plane, Space};
use frames::{CARTESIAN, Frame, Frames};
use fronts::Fronts;

/// Number of an imposed component in [`DofMap::number`].
pub const IMPOSED: u32 = u32::MAX;

/// A product of an axis and a direction that is this close to a whole number is that number.
const DUAL: f64 = 1e-14;

/// Maps displacement components to unknowns.
///
/// Each node has a frame of as many vectors as there are axes: Cartesian, or fitted to the directions that are retained or held there. If these
/// are orthonormal, so is the frame; otherwise it is dual to them, so that each unknown is the trace along its direction, and its
/// force acts along that direction. If supports leave fewer directions free than are retained, or if directions are nearly parallel, the frame is
/// orthonormal, and the traces follow from its unknowns. The nodes of a rigid side follow the free motions of the side, one
/// unknown each. Unknowns are numbered in the order of elimination: nodes, rigid sides, interface; on the interface in the
/// order of the retained directions.
#[derive(Clone, Debug)]
pub struct DofMap<S: Space = Plane> {
    /// The place of each node's frame in `frames`, or [`CARTESIAN`].
    frame_of: Vec<u32>,
    frames: Vec<Frame<S>>,
    numbers: Vec<S::Axes<u32>>,
    imposed: Vec<S::Axes<f64>>,
    /// Number of axes times node + component of every unknown.
    unknowns: Vec<u32>,
    interface: usize,
    /// The trace along each retained direction, block by block.
    rows: Vec<Vec<TraceRow>>,
    fronts: Vec<Front>,
    rigid: RigidUnknowns<S>,
}

/// The unknowns of the rigid sides that are free to move.
#[derive(Clone, Debug, Default, PartialEq)]
struct RigidUnknowns<S: Space> {
    /// The number of the first one; the others follow.
    first: usize,
    /// The motion of each unknown, and its side.
    motions: Vec<(RigidMotion<S>, u32)>,
    /// The nodes of all sides, ascending: place and side.
    nodes: Vec<(NodeId, S::Vector, u32)>,
}

impl<S: Space> RigidUnknowns<S> {
    fn new(body: &Body<S>, first: usize) -> Self {
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

    /// Returns the motion of an unknown, and its side; `None` for the unknowns of nodes.
    fn of(&self, unknown: usize) -> Option<(&RigidMotion<S>, u32)> {
        let (motion, side) = self.motions.get(unknown.checked_sub(self.first)?)?;
        Some((motion, *side))
    }

    /// Lists the nodes of a side, with their places.
    fn nodes_of(&self, side: u32) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
        let nodes = self.nodes.iter().filter(move |(.., s)| *s == side);
        nodes.map(|(node, point, _)| (node.index(), *point))
    }

    /// Lists the unknowns that a node follows, with its displacement per unit of each.
    fn followed(&self, node: usize) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
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
    terms: [(u32, f64); 3],
    /// The constant, which supports impose, m.
    pub imposed: f64,
}

impl TraceRow {
    /// Lists the interface unknowns with their factors, none of which is 0.
    pub fn terms(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.terms.iter().filter(|term| term.1 != 0.0).map(|(k, a)| (*k as usize, *a))
    }
}

impl<S: Space> DofMap<S> {
    /// Numbers the unknowns of a body whose interface is `side` (empty for a body alone).
    pub fn new(body: &Body<S>, side: &InterfaceSide<S>) -> Self {
        let nodes = body.mesh().points().len();
        let Frames { frame_of, frames, fixed, imposed, kept } = Frames::new(body, side);
        let mut numbers = vec![S::axes(|_| IMPOSED); nodes];
        let mut unknowns = Vec::with_capacity(S::DIM * nodes);
        let mut give = |node: usize, c: usize, unknowns: &mut Vec<u32>| {
            if !fixed[node][c] && numbers[node][c] == IMPOSED {
                numbers[node][c] = unknowns.len() as u32;
                unknowns.push((S::DIM * node + c) as u32);
            }
        };
        let dissection = ordering::dissect(body.mesh());
        let mut fronts = Fronts::default();
        for part in &dissection.parts {
            for &node in &dissection.order[part.nodes.clone()] {
                let node = node.index();
                for c in (0..S::DIM).filter(|c| !kept[node][*c]) {
                    give(node, c, &mut unknowns);
                }
            }
            fronts.part(part.parent, unknowns.len());
        }
        let rigid = RigidUnknowns::new(body, unknowns.len());
        for (k, (_, side)) in rigid.motions.iter().enumerate() {
            let node = body.rigid_sides()[*side as usize].nodes[0].index();
            unknowns.push((S::DIM * node + k % S::DIM) as u32);
        }
        fronts.above(unknowns.len());
        let interior = unknowns.len();
        for retained in side.retained() {
            let node = retained.node.index();
            for c in (0..S::DIM).filter(|c| kept[node][*c]) {
                give(node, c, &mut unknowns);
            }
        }
        let interface = unknowns.len() - interior;
        let fronts = fronts.finish(interior, interface);
        debug_assert_eq!(fronts.last().map_or(0, |f| f.columns.end as usize), unknowns.len());
        let rows = Vec::new();
        let mut map = Self { frame_of, frames, numbers, imposed, unknowns, interface, rows, fronts, rigid };
        map.rows = map.rows_of(side);
        map
    }

    /// Returns the same unknowns with the values that the supports of `body` impose now; `None` if its supports, its rigid sides or its
    /// retained directions differ from this map's.
    ///
    /// * `body`: on the same mesh.
    pub(crate) fn with_imposed(&self, body: &Body<S>, side: &InterfaceSide<S>) -> Option<Self> {
        let Frames { frame_of, frames, fixed, imposed, kept } = Frames::new(body, side);
        let rigid = RigidUnknowns::new(body, self.rigid.first);
        let first = (self.unknowns.len() - self.interface) as u32;
        let known = |number: u32, fixed: bool, kept: bool| match number {
            IMPOSED => fixed,
            number => !fixed && kept == (number >= first),
        };
        let mut flags = self.numbers.iter().zip(fixed.iter().zip(&kept));
        let same = self.numbers.len() == fixed.len()
            && flags
                .all(|(numbers, (fixed, kept))| (0..S::DIM).all(|c| known(numbers[c], fixed[c], kept[c])))
            && (&frame_of, &frames, &rigid) == (&self.frame_of, &self.frames, &self.rigid);
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

    /// Counts the blocks of retained directions.
    pub fn blocks(&self) -> usize {
        self.rows.len()
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
    fn rows_of(&self, side: &InterfaceSide<S>) -> Vec<Vec<TraceRow>> {
        let blocks = (0..side.blocks()).map(|block| &side.retained()[side.block(block)]);
        blocks.map(|block| block.iter().map(|retained| self.row(retained)).collect()).collect()
    }

    /// Expresses the trace along a retained direction in the interface unknowns.
    fn row(&self, retained: &Retained<S>) -> TraceRow {
        let (node, start) = (retained.node.index(), (self.unknowns.len() - self.interface) as u32);
        let mut row = TraceRow { terms: [(0, 0.0); 3], imposed: 0.0 };
        for c in 0..S::DIM {
            let factor = self.axis(node, c).times(&retained.direction);
            // Frames are dual to the retained directions to round-off.
            let whole = factor.round();
            let factor = if (factor - whole).abs() <= DUAL { whole } else { factor };
            match self.numbers[node][c] {
                IMPOSED => row.imposed += factor * self.imposed[node][c],
                number if number >= start => row.terms[c] = (number - start, factor),
                // The trace does not depend on the other components.
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
    pub(crate) fn followed(&self, node: usize) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
        self.rigid.followed(node)
    }

    /// Tells whether a rigid side is free to move.
    pub(crate) fn has_rigid(&self) -> bool {
        !self.rigid.motions.is_empty()
    }

    /// Tells whether an unknown belongs to a rigid side, not to a node.
    pub(crate) fn is_rigid(&self, number: usize) -> bool {
        self.rigid.of(number).is_some()
    }

    /// Lists the nodes that an unknown moves, with their displacement per unit of it: one node, unless it belongs to a rigid side.
    pub fn moved(&self, number: usize) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
        let side = self.rigid.of(number);
        let (node, c) = self.unknown(number);
        let own = side.is_none().then(|| (node, self.axis(node, c)));
        let of_side = side.into_iter().flat_map(|(motion, side)| {
            self.rigid.nodes_of(side).map(|(node, point)| (node, motion.at(point)))
        });
        own.into_iter().chain(of_side)
    }

    /// Returns node and component of an unknown; of a rigid side's, one of its nodes.
    pub fn unknown(&self, number: usize) -> (usize, usize) {
        let code = self.unknowns[number] as usize;
        (code / S::DIM, code % S::DIM)
    }

    /// Returns the interface unknowns of a displacement, m.
    ///
    /// * `at`: the displacement of a node.
    pub(crate) fn interface_components(&self, at: impl Fn(usize) -> S::Vector) -> Vec<f64> {
        let interface = self.unknowns.len() - self.interface..self.unknowns.len();
        let component = |(node, c): (usize, usize)| self.component(node, c, at(node));
        interface.map(|unknown| component(self.unknown(unknown))).collect()
    }

    /// Returns axis `c` of a node's frame: displacements are sums of them, forces act along them.
    #[inline]
    pub fn axis(&self, node: usize, c: usize) -> S::Vector {
        self.frame(node).map_or(S::AXES[c], |frame| frame.axes[c])
    }

    /// Returns component `c` of a displacement in a node's frame: the displacement is the sum of the axes times the components.
    pub fn component(&self, node: usize, c: usize, displacement: S::Vector) -> f64 {
        match self.frame(node) {
            Some(frame) if !frame.orthonormal => {
                let across = S::across(&frame.axes)[c];
                across.times(&displacement) / across.times(&frame.axes[c])
            }
            _ => displacement.times(&self.axis(node, c)),
        }
    }

    /// Tells whether the axes of a node's frame are perpendicular to each other and of length one.
    pub(crate) fn is_orthonormal(&self, node: usize) -> bool {
        self.frame(node).is_none_or(|frame| frame.orthonormal)
    }

    /// Tells whether a node's frame is the Cartesian one.
    pub(crate) fn is_cartesian(&self, node: usize) -> bool {
        self.frame(node).is_none()
    }

    /// Returns the frame of a node; `None` if it is Cartesian.
    #[inline]
    fn frame(&self, node: usize) -> Option<&Frame<S>> {
        match self.frame_of[node] {
            CARTESIAN => None,
            place => Some(&self.frames[place as usize]),
        }
    }

    /// Expands unknowns into nodal displacements in Cartesian components, imposed values included.
    pub fn displacement(&self, x: &[f64]) -> Vec<S::Vector> {
        self.expand(x, 1.0)
    }

    /// Expands unknowns into a nodal correction, which vanishes where displacements are imposed.
    pub fn correction(&self, x: &[f64]) -> Vec<S::Vector> {
        self.expand(x, 0.0)
    }

    fn expand(&self, x: &[f64], imposed_factor: f64) -> Vec<S::Vector> {
        let value = |node: usize, c: usize| match self.numbers[node][c] {
            IMPOSED => imposed_factor * self.imposed[node][c],
            number => x[number as usize],
        };
        let at = |node: usize| {
            let local = S::Vector::of(|c| value(node, c));
            match self.frame(node) {
                None => local,
                Some(Frame { axes, .. }) => {
                    (1..S::DIM).fold(axes[0] * local[0], |sum, c| sum + axes[c] * local[c])
                }
            }
        };
        let mut all: Vec<S::Vector> = (0..self.numbers.len()).map(at).collect();
        for (node, ..) in &self.rigid.nodes {
            for (unknown, per_unit) in self.rigid.followed(node.index()) {
                all[*node] += per_unit * x[unknown];
            }
        }
        all
    }
}

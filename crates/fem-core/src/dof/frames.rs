//! The frames of nodes: bases fitted to the directions that are retained or held.

use crate::body::{Body, NodeConstraint};
use crate::directions::{Directions, dual};
use crate::geometry::{Coordinates, PARALLEL, norm};
use crate::interface::InterfaceSide;
use crate::space::Space;
use std::collections::BTreeMap;

/// Means 'no frame but the Cartesian axes'.
pub(super) const CARTESIAN: u32 = u32::MAX;

/// Directions whose dual vectors are longer than this, those within a degree, have no dual frame: its stiffness has the square of that length, and
/// forces lose as many digits.
const LONGEST: f64 = 60.0;

/// A vector whose length is this close to one is of length one; so are whole numbers.
const UNIT: f64 = 1e-14;

/// The basis in which the displacement of a node is expressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame<S: Space> {
    pub(super) axes: S::Axes<S::Vector>,
    /// True if the axes are perpendicular to each other and of length one.
    pub(super) orthonormal: bool,
}

/// The frames of all nodes, and the values imposed along their axes.
pub(super) struct Frames<S: Space> {
    /// The place of each node's frame, or [`CARTESIAN`].
    pub(super) frame_of: Vec<u32>,
    pub(super) frames: Vec<Frame<S>>,
    pub(super) fixed: Vec<S::Axes<bool>>,
    pub(super) imposed: Vec<S::Axes<f64>>,
    /// True if a component is an interface unknown.
    pub(super) kept: Vec<S::Axes<bool>>,
}

impl<S: Space> Frames<S> {
    pub(super) fn new(body: &Body<S>, side: &InterfaceSide<S>) -> Self {
        let nodes = body.mesh().points().len();
        let mut frames = Self {
            frame_of: vec![CARTESIAN; nodes],
            frames: Vec::new(),
            fixed: vec![S::axes(|_| false); nodes],
            imposed: vec![S::axes(|_| 0.0); nodes],
            kept: vec![S::axes(|_| false); nodes],
        };
        let mut retained: BTreeMap<usize, Retained<S>> = BTreeMap::new();
        for one in side.retained() {
            retained.entry(one.node.index()).or_default().add(one.direction);
        }
        for (node, constraint) in body.node_constraints().iter().enumerate() {
            let own = retained.get(&node);
            if own.is_some() || !constraint.held.is_none() {
                frames.fit(node, own.map_or(&[], |own| &own.directions), constraint);
            }
        }
        frames
    }

    /// Fits the frame of a node to its retained directions and to what supports hold.
    fn fit(&mut self, node: usize, retained: &[S::Vector], constraint: &NodeConstraint<S>) {
        let held = constraint.held.basis();
        let count = held.len();
        if count == S::DIM {
            self.fixed[node] = S::axes(|_| true);
            self.imposed[node] = S::axes(|c| constraint.imposed[c]);
            return;
        }
        let beside = |r: &S::Vector| held.iter().all(|d| d.times(r).abs() <= PARALLEL);
        let with = |all: Directions<S>, r: &S::Vector| all.with(*r / norm(*r), PARALLEL);
        let all = retained.iter().fold(constraint.held, with);
        let independent = all.count() == count + retained.len();
        let dual_axes = || {
            let vectors = [retained, held, all.complement().basis()].concat();
            let axes = dual::<S>(S::axes(|c| vectors[c]));
            let short = |c: usize| norm(axes[c]) * norm(vectors[c]) <= LONGEST;
            (0..S::DIM).all(short).then_some(axes)
        };
        let frame = match retained {
            [] => self.perpendicular(node, constraint, None),
            [r] if count == 0 || (count + 1 == S::DIM && beside(r)) => {
                self.perpendicular(node, constraint, Some(*r))
            }
            _ if let Some(axes) = independent.then(dual_axes).flatten() => {
                let first = retained.len();
                self.kept[node] = S::axes(|c| c < first);
                self.fixed[node] = S::axes(|c| (first..first + count).contains(&c));
                self.imposed[node] =
                    S::axes(|c| if self.fixed[node][c] { constraint.imposed[c - first] } else { 0.0 });
                Frame { axes, orthonormal: false }
            }
            _ => {
                // Fewer unknowns remain than directions are retained, or these are nearly parallel.
                let free = constraint.held.complement();
                let kept = all.count() - count;
                let basis = if all.is_all() { free.basis() } else { &all.basis()[count..] };
                let mut vectors = [held, basis].concat();
                vectors.extend_from_slice(all.complement().basis());
                self.fixed[node] = S::axes(|c| c < count);
                self.kept[node] = S::axes(|c| (count..count + kept).contains(&c));
                self.imposed[node] = S::axes(|c| if c < count { constraint.imposed[c] } else { 0.0 });
                Frame { axes: S::axes(|c| vectors[c]), orthonormal: true }
            }
        };
        self.frame_of[node] = self.frames.len() as u32;
        self.frames.push(frame);
    }

    /// Makes a frame of one retained direction, or of the held ones, and of what is perpendicular to them.
    fn perpendicular(
        &mut self,
        node: usize,
        constraint: &NodeConstraint<S>,
        retained: Option<S::Vector>,
    ) -> Frame<S> {
        let count = constraint.held.count();
        let Some(direction) = retained else {
            let beside = constraint.held.complement();
            let vectors = [constraint.held.basis(), beside.basis()].concat();
            self.fixed[node] = S::axes(|c| c < count);
            self.imposed[node] = S::axes(|c| if c < count { constraint.imposed[c] } else { 0.0 });
            return Frame { axes: S::axes(|c| vectors[c]), orthonormal: true };
        };
        let length = norm(direction);
        let orthonormal = (length - 1.0).abs() <= UNIT;
        let unit = if orthonormal { direction } else { direction * (1.0 / length) };
        let others = Directions::<S>::along(unit).complement();
        let others = others.basis();
        // The unknown is the trace along the direction, whatever its length.
        let first = if orthonormal { direction } else { direction * (1.0 / (length * length)) };
        self.kept[node] = S::axes(|c| c == 0);
        if count > 0 {
            let known = constraint.displacement();
            self.fixed[node] = S::axes(|c| c > 0);
            self.imposed[node] =
                S::axes(|c| if c > 0 { along(constraint, others[c - 1], known) } else { 0.0 });
        }
        Frame { axes: S::axes(|c| if c == 0 { first } else { others[c - 1] }), orthonormal }
    }
}

/// Computes the component of the imposed displacement along a direction; exactly, if it is one of those that are held.
fn along<S: Space>(constraint: &NodeConstraint<S>, direction: S::Vector, known: S::Vector) -> f64 {
    let mut components = constraint.components().map(|(d, value)| (d.times(&direction), value));
    let same = components.find(|(cosine, _)| (cosine.abs() - 1.0).abs() <= UNIT);
    same.map_or_else(|| known.times(&direction), |(cosine, value)| value * cosine.signum())
}

/// The retained directions of a node that are independent of each other.
#[derive(Default)]
struct Retained<S: Space> {
    directions: Vec<S::Vector>,
    span: Option<Directions<S>>,
}

impl<S: Space> Retained<S> {
    fn add(&mut self, direction: S::Vector) {
        let unit = direction / norm(direction);
        let span = self.span.unwrap_or(Directions::NONE);
        let more = span.with(unit, PARALLEL);
        if more.count() > span.count() {
            self.directions.push(direction);
            self.span = Some(more);
        }
    }
}

//! Why boundary conditions, declared curves and surfaces, or materials do not fit a mesh.

use super::ConditionPlace;
use crate::geometry::{Point, shown};
use crate::space::Words;
use thiserror::Error;

/// Writes from where to where an edge runs, or between which points a face is.
fn between(corners: &[Point]) -> String {
    match corners {
        [a, b] => format!("from {a} to {b}"),
        _ => format!("between {}", corners.iter().map(Point::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// Why boundary conditions are invalid on a mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BodyError {
    /// There is no group of that name.
    #[error("{place}: there is no {} group \"{group}\"; the groups are: {known}", words.facet)]
    UnknownGroup {
        /// The condition.
        place: ConditionPlace,
        /// The name it uses.
        group: String,
        /// The existing names.
        known: String,
        /// The words for its cells.
        words: &'static Words,
    },
    /// The condition applies to no facet.
    #[error("{place}: no {} of \"{group}\" lies in the given part", words.facet)]
    EmptySelection {
        /// The condition.
        place: ConditionPlace,
        /// The group.
        group: String,
        /// The words for its cells.
        words: &'static Words,
    },
    /// No boundary node is at the place of a support on a single node.
    #[error("{place}: no boundary node is at {point}; the nearest one is at {nearest}")]
    NoNode {
        /// The condition.
        place: ConditionPlace,
        /// The place.
        point: Point,
        /// The nearest boundary node.
        nearest: Point,
    },
    /// A condition on a single node is not made of Cartesian components of a displacement.
    #[error(
        "{place} is on a single node, which has neither a length nor a normal: it takes `ux` and `uy` of a displacement only"
    )]
    SingleNode {
        /// The condition.
        place: ConditionPlace,
    },
    /// The group has a facet inside the body.
    #[error(
        "{place}: \"{group}\" has the {} {} inside the body; only boundary {} can be held or loaded",
        words.facet, between(corners), words.facets
    )]
    InteriorFacet {
        /// The condition.
        place: ConditionPlace,
        /// The group.
        group: String,
        /// Corners of the facet.
        corners: Vec<Point>,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A value is infinite or NaN.
    #[error("{place}: the value at {point} is {value}; a finite number is needed")]
    NotFinite {
        /// The condition.
        place: ConditionPlace,
        /// The point at which it was evaluated.
        point: Point,
        /// The resulting value.
        value: f64,
    },
    /// Two conditions impose different displacements on a node.
    #[error(
        "{place} and an earlier one impose different displacements on the node at {point}: {values:?} along the same direction"
    )]
    Conflict {
        /// The later condition.
        place: ConditionPlace,
        /// The node.
        point: Point,
        /// The two values.
        values: [f64; 2],
    },
    /// A load acts in a direction in which the displacement is imposed.
    #[error(
        "{place} loads the {} at {point} in a direction in which its displacement is imposed; remove one of the two",
        words.facet
    )]
    LoadOnSupport {
        /// The traction condition.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// The stiffness of springs is negative or not finite.
    #[error(
        "{place}: the stiffness at {point} is {value}; it is a traction per displacement, and not negative"
    )]
    Stiffness {
        /// The spring condition.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
        /// The value.
        value: f64,
    },
    /// Springs act in a direction that a support holds, or across one at an angle.
    #[error(
        "{place}: at {point} the springs act along a direction that a support holds, or at an angle to one: the support takes their force"
    )]
    SpringOnSupport {
        /// The spring condition.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
    },
    /// Springs are much stiffer than the body beside them.
    #[error(
        "{place}: at {point} the springs are {ratio:.1e} times as stiff as the cells beside them: rounding takes their force"
    )]
    TooStiff {
        /// The spring condition.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
        /// Their stiffness times the size of the facet over Young's modulus.
        ratio: f64,
    },
    /// Springs are much softer than the body beside them.
    #[error(
        "{place}: at {point} the stiffness of the springs is {ratio:.1e} times that of the cells beside them: rounding hides the strains of what they hold"
    )]
    TooSoft {
        /// The spring condition.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
        /// Their stiffness times the size of the facet over Young's modulus.
        ratio: f64,
    },
    /// A rigid side has another condition, or a node of another rigid side.
    #[error(
        "{place} has another condition at {point}; a rigid side takes none, and two of them have no common node"
    )]
    RigidOccupied {
        /// The rigid side.
        place: ConditionPlace,
        /// The point with the other condition.
        point: Point,
    },
    /// A side that is declared as an arc is straight, or a part of it has a single edge.
    #[error(
        "{place}: no arc passes through the nodes of the part that begins at {point}: it has {edges} edges and is straight, or has \
         fewer than two"
    )]
    NoArc {
        /// The curved side.
        place: ConditionPlace,
        /// Its first node.
        point: Point,
        /// Its edges.
        edges: usize,
    },
    /// A node of a side that is declared as an arc is off the circle through three of its nodes.
    #[error(
        "{place}: the node at {point} is {distance:.3e} off the circle through three nodes of this part, with the centre \
         {centre} and the radius {}",
        shown(*radius)
    )]
    OffArc {
        /// The curved side.
        place: ConditionPlace,
        /// The node that is farthest off.
        point: Point,
        /// Its distance from the circle, m.
        distance: f64,
        /// Centre of the circle.
        centre: Point,
        /// Its radius, m.
        radius: f64,
    },
    /// A facet belongs to two curves or surfaces.
    #[error("{place} has {} {} at {point} that an earlier one has, too", words.article, words.facet)]
    CurvedTwice {
        /// The later curved side.
        place: ConditionPlace,
        /// Middle of the facet.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// No cylinder or sphere passes through the nodes of a side: it is flat, or has too few of them.
    #[error(
        "{place}: no {kind} passes through the nodes of the part with the face at {point}: it is flat, or has too few nodes"
    )]
    NoSurface {
        /// The declared surface.
        place: ConditionPlace,
        /// The kind of the surface.
        kind: &'static str,
        /// Middle of a face.
        point: Point,
    },
    /// A node of a side is off the declared surface.
    #[error("{place}: the node at {point} is {distance:.3e} off the {kind} through the nodes of this part")]
    OffSurface {
        /// The declared surface.
        place: ConditionPlace,
        /// The kind of the surface.
        kind: &'static str,
        /// The node that is farthest off.
        point: Point,
        /// Its distance, m.
        distance: f64,
    },
    /// No facet lies in the plane of a cut.
    #[error(
        "{place}: no {} inside the body lies in its plane, within its box: the mesh must have {} along the cut, from side to side",
        words.facet,
        words.facets
    )]
    CutMisses {
        /// The cut.
        place: ConditionPlace,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A cut ends inside the body.
    #[error("{place} ends inside the body, at {point}: the {} of the mesh do not follow its plane there, or its box ends", words.facets)]
    CutEnds {
        /// The cut.
        place: ConditionPlace,
        /// The node.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A cut has several parts.
    #[error(
        "{place} has {parts} parts that do not touch each other: one cut goes through one shank; give each a cut with a box of its own"
    )]
    CutParts {
        /// The cut.
        place: ConditionPlace,
        /// Their number.
        parts: usize,
    },
    /// A support or springs hold a node of a cut along its axis.
    #[error(
        "{place}: at {point} a support, a rigid side or springs hold the rim of the cut along its axis; only what is perpendicular to the axis can continue across a cut"
    )]
    CutHeld {
        /// The cut.
        place: ConditionPlace,
        /// The node, or the middle of the facet.
        point: Point,
    },
    /// Two cuts have a common node.
    #[error("{place} meets an earlier cut at {point}; two cuts have no common point")]
    CutTwice {
        /// The later cut.
        place: ConditionPlace,
        /// The node.
        point: Point,
    },
    /// The body force is infinite or NaN.
    #[error("the body force is {force}; finite numbers are needed")]
    BodyForce {
        /// The force found.
        force: Point,
    },
    /// The materials do not fit the mesh.
    #[error("{found} cells have a material and the mesh has {cells}, or a material index does not exist")]
    Materials {
        /// Cells that have a material.
        found: usize,
        /// Cells of the mesh.
        cells: usize,
    },
}

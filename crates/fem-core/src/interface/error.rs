//! Errors of the pairing of two contact surfaces.

use crate::geometry::{Point, shown};
use crate::space::Words;
use thiserror::Error;

/// Says what is wrong with a given normal.
fn away(degrees: f64, point: Point) -> String {
    if degrees.is_nan() {
        "has no direction: its length is zero or out of range".into()
    } else {
        format!(
            "is {degrees:.1} degrees from the first body's outward normal at {point}; at most 60 degrees are allowed"
        )
    }
}

/// Why two surfaces cannot be paired.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InterfaceError {
    /// There is no group of that name.
    #[error("body {body} has no {} group \"{group}\" for its contact surface; the groups are: {known}", words.facet)]
    UnknownSurface {
        /// 0 or 1.
        body: usize,
        /// The name given.
        group: String,
        /// The existing names.
        known: String,
        /// The words for its cells.
        words: &'static Words,
    },
    /// The group has no facet, or one inside the body.
    #[error("the contact surface \"{group}\" of body {body} {reason}")]
    NoSurface {
        /// 0 or 1.
        body: usize,
        /// The name given.
        group: String,
        /// The reason why it is no contact surface.
        reason: String,
    },
    /// A contact facet also has a support across it, or a load.
    #[error(
        "the contact {0} of body {body} at {point} also has {what}; a contact {0} can have neither load nor imposed displacement, but along itself",
        words.facet
    )]
    Occupied {
        /// 0 or 1.
        body: usize,
        /// Middle of the facet.
        point: Point,
        /// "a load" or "an imposed displacement across it".
        what: &'static str,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A contact node has no partner.
    #[error(
        "the surfaces do not match: the contact node of body {body} at {point} is {distance:.3e} from the nearest \
         contact node of the other body, with edges of length {spacing:.3e} around it; use matching meshes \
         (at most 5 % of the edge apart)"
    )]
    NotMatching {
        /// 0 or 1.
        body: usize,
        /// The node.
        point: Point,
        /// Distance to the nearest node of the other surface.
        distance: f64,
        /// Local edge length.
        spacing: f64,
    },
    /// The gap is given, but the surfaces do not coincide.
    #[error(
        "the surfaces do not match: the gap is given, but at {point} the bodies {} {:.3e}; the edges there are \
         {spacing:.3e} long",
        if *gap > 0.0 { "are apart by" } else { "overlap by" }, gap.abs()
    )]
    Distance {
        /// Node of the first body.
        point: Point,
        /// Distance along the normal, m, negative if the bodies overlap.
        gap: f64,
        /// The shorter edge there.
        spacing: f64,
    },
    /// Paired nodes are joined by a facet in only one body.
    #[error("the surfaces do not match: the contact {} of body {body} at {point} has no partner", words.facet)]
    FacetWithoutPartner {
        /// 0 or 1.
        body: usize,
        /// Middle of the facet.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// The two surfaces face the same direction.
    #[error("the two surfaces do not face each other at {point}")]
    NotFacing {
        /// Middle of the edge.
        point: Point,
    },
    /// The contact line turns too sharply to have a normal.
    #[error(
        "the contact line turns by {degrees:.1} degrees near {point}; at most 60 degrees between neighbouring edges give a \
         normal: refine the surface there, end it at the corner, or give the normal (`contact.normal`)"
    )]
    Curved {
        /// The node at which it turns.
        point: Point,
        /// Angle between neighbouring normals.
        degrees: f64,
    },
    /// The given normal has no direction, or does not point out of the first body.
    #[error(
        "the given contact normal {normal} {}",
        away(*degrees, *point)
    )]
    NormalAway {
        /// As given.
        normal: Point,
        /// Middle of the edge.
        point: Point,
        /// Angle between the two; NaN if the given one has no direction.
        degrees: f64,
    },
    /// The surfaces are cut into different numbers of edges or stretches.
    #[error(
        "the surfaces do not match: near {point} the first body's has {} {what}, the second's {}; to measure a gap along \
         the normal they need the same number, node facing node",
        counts[0], counts[1]
    )]
    Counts {
        /// First point of the stretch of the first body.
        point: Point,
        /// "stretches", "edges" and so on.
        what: &'static str,
        /// The number on each body.
        counts: [usize; 2],
    },
    /// Paired nodes do not face each other along the normal.
    #[error(
        "the surfaces do not match: the node at {point} and its partner do not face each other along the contact normal: \
         they are {offset:.3e} apart across it, with edges of length {spacing:.3e}"
    )]
    Offset {
        /// Node of the first body.
        point: Point,
        /// Distance across the normal.
        offset: f64,
        /// Local edge length.
        spacing: f64,
    },
    /// No gap is given, and the surfaces do not touch.
    #[error(
        "no gap is given, and the surfaces {} {:.3e} at {point}, where this is largest",
        if *gap > 0.0 { "are apart by" } else { "overlap by" }, gap.abs()
    )]
    NotTouching {
        /// Place on the first body.
        point: Point,
        /// Distance along the normal, m, negative where the bodies overlap.
        gap: f64,
    },
    /// The bodies overlap before anything is loaded.
    #[error("the bodies overlap: deepest by {depth:.3e} at {point} (the edges there are {spacing:.3e} long)")]
    Overlap {
        /// Node of the first body.
        point: Point,
        /// Depth, m.
        depth: f64,
        /// Local edge length.
        spacing: f64,
    },
    /// The interference is deeper than a body is thick.
    #[error("the bodies interfere by {depth:.3e} at {point}, and body {body} is thinner than that there")]
    TooDeep {
        /// 0 or 1.
        body: usize,
        /// The middle of a facet of the first body.
        point: Point,
        /// Depth, m.
        depth: f64,
    },
    /// The surfaces are farther apart than the size of the smaller body.
    #[error(
        "the surfaces are {distance:.3e} apart at {point}, more than the size {size:.3e} of the smaller body"
    )]
    TooFar {
        /// Node of the first body.
        point: Point,
        /// Gap, m.
        distance: f64,
        /// Diagonal of the smaller body.
        size: f64,
    },
    /// Supports press clamped contact nodes into each other, or a clamped node into an obstacle.
    #[error(
        "both sides are clamped at the contact node or edge at {point}, and their supports and the gap press them {depth:.3e} into each other \
         there"
    )]
    ClampedOverlap {
        /// Node of the first body.
        point: Point,
        /// Depth, m.
        depth: f64,
    },
    /// The normal turns too much along a contact face of a solid, or from it to a neighbour.
    #[error(
        "the contact normal turns by {degrees:.0} degrees at the face with its middle at {point}; at most 60 are allowed along a face, and \
         from one face to the next"
    )]
    CoarseFace {
        /// The middle of the face.
        point: Point,
        /// The angle.
        degrees: f64,
    },
    /// A contact side of a solid has faces on a declared surface and others.
    #[error(
        "the contact surface of body {body} has faces on different declared surfaces, or on none: one of them is at {point}"
    )]
    MixedSurface {
        /// 0 or 1.
        body: usize,
        /// The middle of a face.
        point: Point,
    },
    /// A support holds a contact node of a solid along the normal, or supports hold both nodes of all pairs.
    #[error(
        "the contact node of body {body} at {point} is held by a support along the contact normal, within 30 degrees, or all \
         contact nodes are clamped on both sides; end the contact surface or the support one face earlier"
    )]
    HeldNode {
        /// 0 or 1.
        body: usize,
        /// The node.
        point: Point,
    },
    /// The normal displacement of a contact node is imposed by a support.
    #[error(
        "the contact node of body {body} at {point} is held by a support along the contact normal, within 30 degrees, or \
         in two directions; only nodes at the ends of a straight line may be, if both bodies are clamped there: end the \
         contact surface or the support one edge earlier"
    )]
    SupportedNode {
        /// 0 or 1.
        body: usize,
        /// The node.
        point: Point,
    },
    /// The initial gap is not finite.
    #[error("the initial gap at {point} is {}; it must be a finite number", shown(*value))]
    BadGap {
        /// The node.
        point: Point,
        /// The gap there, m.
        value: f64,
    },
    /// A pair with friction has a facet that a support holds along itself.
    #[error(
        "the contact {0} of body {body} at {point} is held along itself, so that it cannot slip, and the pair has friction", words.facet
    )]
    HeldAgainstSlip {
        /// 0 or 1.
        body: usize,
        /// The middle of the facet.
        point: Point,
        /// The words for what the body consists of.
        words: &'static Words,
    },
    /// The limit of Tresca's friction is negative or not finite.
    #[error("the friction limit at {point} is {}; it must be a finite number >= 0", shown(*value))]
    BadFrictionLimit {
        /// The node of the first body.
        point: Point,
        /// The limit there, Pa.
        value: f64,
    },
    /// The slip of an earlier load step belongs to another contact line, or is not finite.
    #[error(
        "the slip of the step before has {found} finite values, and the contact line has {expected} {of}"
    )]
    BadSlip {
        /// The things that have one value each: rows along tangents, or facets.
        of: &'static str,
        /// Finite values.
        found: usize,
        /// Their number on the contact line.
        expected: usize,
    },
    /// A load step after the first is to be refined.
    #[error(
        "the slip of earlier load steps is known on their mesh only; refine the problem before its first step"
    )]
    SlipOnCoarserMesh,
    /// The coefficient of Coulomb's friction is negative or not finite.
    #[error("the coefficient of friction is {}; it must be a finite number >= 0", shown(*value))]
    BadFrictionCoefficient {
        /// The coefficient given.
        value: f64,
    },
}

impl InterfaceError {
    /// Tells whether the surfaces failed to match node by node, so that a common refinement may help.
    pub fn is_mismatch(&self) -> bool {
        matches!(
            self,
            Self::NotMatching { .. }
                | Self::FacetWithoutPartner { .. }
                | Self::Counts { .. }
                | Self::Offset { .. }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::space::{Plane, Space};

    #[test]
    fn a_normal_without_direction_is_said_shortly() {
        let normal = Vector::new(0.0, -1e-320).into();
        let said =
            InterfaceError::NormalAway { normal, point: Vector::new(1.0, 2.0).into(), degrees: f64::NAN }
                .to_string();
        assert!(said.contains("(0, -1e-320) has no direction") && !said.contains("NaN"), "{said}");
        let away = InterfaceError::NormalAway {
            normal: Vector::new(0.0, -1.0).into(),
            point: Vector::new(1.0, 2.0).into(),
            degrees: 90.0,
        };
        assert!(away.to_string().contains("(0, -1) is 90.0 degrees from the first body's"), "{away}");
    }

    #[test]
    fn places_of_300_digits_are_shown_with_an_exponent() {
        let point = Point::from(Vector::new(1e300, -1e-300));
        for error in [
            InterfaceError::Occupied { body: 0, point, what: "a load", words: Plane::WORDS },
            InterfaceError::NotMatching { body: 0, point, distance: 1e300, spacing: 1e-300 },
            InterfaceError::Distance { point, gap: 1e300, spacing: 1e-300 },
            InterfaceError::FacetWithoutPartner { body: 0, point, words: Plane::WORDS },
            InterfaceError::NotFacing { point },
            InterfaceError::Curved { point, degrees: 90.0 },
            InterfaceError::NormalAway { normal: point, point, degrees: 90.0 },
            InterfaceError::Counts { point, what: "edges", counts: [1, 2] },
            InterfaceError::Offset { point, offset: 1e300, spacing: 1e-300 },
            InterfaceError::Overlap { point, depth: 1e300, spacing: 1e-300 },
            InterfaceError::TooDeep { body: 0, point, depth: 1e300 },
            InterfaceError::TooFar { point, distance: 1e300, size: 1e-300 },
            InterfaceError::SupportedNode { body: 0, point },
            InterfaceError::BadGap { point, value: -1e300 },
            InterfaceError::BadFrictionLimit { point, value: -1e300 },
        ] {
            let said = error.to_string();
            assert!(said.contains("(1e300, -1e-300)") && !said.contains("00000"), "{said}");
        }
    }
}

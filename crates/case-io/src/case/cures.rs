//! What was expected and one fix, for the errors of fem-core that a case file can bring about.

use fem_core::body::BodyError;
use fem_core::interface::InterfaceError;
use fem_core::interface::common_refinement::CommonRefinementError;

/// What was expected, and one fix.
type Cure = (&'static str, &'static str);

const SIDE: Cure = (
    "the name of one of them",
    "look at the sides with `nndd mesh FILE`; a generator's are in `nndd new paper`",
);
const BOUNDARY: Cure = (
    "edges of the boundary, at least one",
    "take the edges inside the body out of the group, or name another side",
);

pub(super) fn of_body(error: &BodyError) -> Cure {
    match error {
        BodyError::UnknownGroup { .. } => SIDE,
        BodyError::EmptySelection { .. } => {
            ("a part that holds both ends of an edge", "make `part` larger, or leave it out")
        }
        BodyError::InteriorEdge { .. } => BOUNDARY,
        BodyError::NotFinite { .. } => (
            "an expression that is finite at every node of the side",
            "change the expression where it divides by zero or leaves its range",
        ),
        BodyError::Conflict { .. } => (
            "one value for a node in one direction",
            "give both conditions the same value there, or end one of them earlier with `part`",
        ),
        BodyError::LoadOnSupport { .. } => (
            "a load only in a direction in which the side is free",
            "take that component out of the load or out of the support",
        ),
        BodyError::RigidOccupied { .. } => (
            "a rigid side of one piece, without other conditions and apart from other rigid sides",
            "take the other condition out, or end one of the two sides earlier with `part`",
        ),
        BodyError::BodyForce { .. } => ("two finite numbers", "write the numbers themselves"),
        BodyError::Materials { .. } => {
            ("a material for every cell", "give every [[body.region]] a material that is there")
        }
    }
}

pub(super) fn of_interface(error: &InterfaceError) -> Cure {
    match error {
        InterfaceError::UnknownSurface { .. } => SIDE,
        InterfaceError::NoSurface { .. } => BOUNDARY,
        InterfaceError::Occupied { .. } => (
            "contact edges that are free",
            "take the condition out, or leave the contact edges out of it with `part`",
        ),
        InterfaceError::Distance { gap, .. } if *gap > 0.0 => (
            "surfaces that touch if the gap is a number, within 5 % of an edge",
            "write `gap = \"geometric\"` to measure it, or move one of the bodies",
        ),
        InterfaceError::NotTouching { gap, .. } if *gap > 0.0 => (
            "surfaces that touch, to 1e-6 of the smaller body's size, or a gap",
            "write `gap = \"geometric\"` to keep this distance, or `gap = 0.0` to close it",
        ),
        InterfaceError::NotTouching { .. } => (
            "surfaces that touch, to 1e-6 of the smaller body's size",
            "write `gap = 0.0` to close this overlap, or move one of the bodies; `gap = \"geometric\"` keeps a distance, \
             but no overlap",
        ),
        InterfaceError::Distance { .. } | InterfaceError::Overlap { .. } => (
            "bodies that touch or are apart",
            "move one of the bodies by this depth; a distance is measured with `gap = \"geometric\"`",
        ),
        InterfaceError::TooFar { .. } => (
            "bodies closer to each other than they are large",
            "move one of them, or check the units of the two",
        ),
        InterfaceError::NormalAway { .. } | InterfaceError::NotFacing { .. } => (
            "a normal out of the first body, into the second",
            "leave `contact.normal` out, and name the two sides that face each other",
        ),
        InterfaceError::Curved { .. } => {
            ("a surface without sharp corners", "end the contact surface at the corner, or refine it there")
        }
        InterfaceError::SupportedNode { .. } => (
            "contact nodes that can move along the contact normal, or ends of a straight line where both bodies are clamped",
            "end the contact surface or the support one edge earlier",
        ),
        InterfaceError::ClampedOverlap { .. } => (
            "imposed displacements that do not press the clamped ends into each other",
            "change one of the two displacements, or end the contact surface one edge earlier",
        ),
        InterfaceError::BadGap { .. } => {
            ("a finite number >= 0", "change the expression; `gap = \"geometric\"` measures the gap")
        }
        InterfaceError::NotMatching { .. }
        | InterfaceError::EdgeWithoutPartner { .. }
        | InterfaceError::Counts { .. }
        | InterfaceError::Offset { .. } => {
            ("surfaces whose nodes face each other", "mesh the two sides with the same divisions")
        }
    }
}

pub(super) fn of_refinement(error: &CommonRefinementError) -> Cure {
    match error {
        CommonRefinementError::NoSurface { .. } => BOUNDARY,
        CommonRefinementError::NoOverlap { .. } => (
            "two surfaces that face each other, at least in part",
            "check `contact.surfaces`: the side of the first body, then that of the second",
        ),
        CommonRefinementError::Offset { .. } => {
            ("nodes that coincide or are well apart", "mesh the two sides with the same end and divisions")
        }
        CommonRefinementError::Folded { .. } => {
            ("surfaces that face each other one to one", "end the contact surface at the corner")
        }
        // Mesh, Body and future variants.
        _ => ("a body that can be cut along its contact side", "mesh the two sides with the same divisions"),
    }
}

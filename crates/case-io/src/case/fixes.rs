//! Expected input and one fix for each error of fem-core that a case file can cause.

use crate::case_file::Reader;
use crate::diagnostic::significant;
use contact_geometry::OverlayError;
use contact_geometry::common_refinement::CommonRefinementError;
use fem_core::body::{BodyError, JoinError};
use fem_core::interface::{BondError, InterfaceError};
use fem_core::material::MaterialError;

/// The expected input, and one fix.
type Fix = (&'static str, &'static str);

const SIDE: Fix =
    ("the name of one of them", "write one of these; `nndd mesh FILE` shows where the sides of a mesh are");
const BOUNDARY: Fix = (
    "edges of the boundary, at least one",
    "take the edges inside the body out of the group, or name another side",
);

pub(super) fn of_body(error: &BodyError) -> Fix {
    match error {
        BodyError::UnknownGroup { .. } => SIDE,
        BodyError::EmptySelection { .. } => {
            ("a part that holds both ends of an edge", "make `part` larger, or leave it out")
        }
        BodyError::InteriorFacet { .. } => BOUNDARY,
        BodyError::NoNode { .. } => (
            "a boundary node of the first mesh, to 1e-6 of the body's diagonal",
            "write the coordinates of the nearest one, or put a node of the mesh there",
        ),
        BodyError::SingleNode { .. } => ("`ux`, `uy` or `fixed` on a single node", "name a side with edges"),
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
        BodyError::Stiffness { .. } => (
            "a stiffness that is finite and not negative on every part of the side",
            "change the expression where it is negative, or end the springs earlier with `part`",
        ),
        BodyError::TooStiff { .. } => (
            "springs at most 1e6 times as stiff as the body beside them",
            "hold the side by a [[body.displacement]], or check the units of `stiffness`: force / length³",
        ),
        BodyError::TooSoft { .. } => (
            "springs at most 1e12 times as soft as the body beside them",
            "take the springs out, or check the units of `stiffness`: force / length³",
        ),
        BodyError::CutMisses { .. } | BodyError::CutEnds { .. } => (
            "a plane along facets of the mesh, from boundary to boundary of the shank, to 1e-6 of the body's diagonal",
            "move the plane to a layer of nodes inside the body, or make `box` larger; in Gmsh, split the shank with the plane \
             (`BooleanFragments` of the shank and a rectangle in the plane) and mesh again",
        ),
        BodyError::CutParts { .. } => (
            "a plane that cuts one shank",
            "write `box = { x = [0.0, 1.0] }` around the shank, and a cut for each other one",
        ),
        BodyError::CutHeld { .. } => (
            "a rim that is free along the axis of the cut",
            "move the plane away from the support, or take the component along the axis out of it",
        ),
        BodyError::CutTwice { .. } => {
            ("cuts apart from each other", "move one of the two planes, or end one of them with a `box`")
        }
        BodyError::SpringOnSupport { .. } => (
            "springs along directions in which the side is free",
            "take the springs or the support out, or write the other direction into `along`",
        ),
        BodyError::NoArc { .. } => (
            "a bent side with three nodes or more",
            "take this [[body.curve]] out, or write `kind = \"smooth\"`",
        ),
        BodyError::OffArc { .. } => (
            "nodes on one circle, to 1e-6 of its radius",
            "write `kind = \"smooth\"`, name only the edges of the arc, or write the nodes of the mesh with more digits",
        ),
        BodyError::CurvedTwice { .. } => (
            "at most one [[body.curve]] or [[body.surface]] for every edge or face",
            "take one of the two tables out, or the edge or face out of one of the sides",
        ),
        BodyError::NoSurface { .. } => (
            "a curved side with five nodes or more",
            "write the kind that the side has, or take this [[body.surface]] out",
        ),
        BodyError::OffSurface { .. } => (
            "nodes on one surface, to 1e-6 of the size of the side",
            "write the kind that the side has, name only the faces on it, or write the nodes of the mesh with more digits",
        ),
        BodyError::BodyForce { .. } => ("two finite numbers", "write the numbers themselves"),
        BodyError::Materials { .. } => {
            ("a material for every cell", "give every [[body.region]] a material that is there")
        }
    }
}

pub(super) fn of_interface(error: &InterfaceError) -> Fix {
    match error {
        InterfaceError::UnknownSurface { .. } => SIDE,
        InterfaceError::NoSurface { .. } => BOUNDARY,
        InterfaceError::HeldAgainstSlip { .. } => (
            "friction, or a support along the side",
            "take `friction` out, or leave the contact side out of the support with `part`",
        ),
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
        // The fix is that of [`press_fit`].
        InterfaceError::NotTouching { .. } => ("surfaces that touch, to 1e-6 of the smaller body's size", ""),
        InterfaceError::Distance { .. } => {
            ("surfaces that touch if the gap is a number, within 5 % of an edge", "")
        }
        InterfaceError::Overlap { .. } => ("bodies that touch or are apart", ""),
        InterfaceError::TooDeep { .. } => (
            "an interference that is smaller than the bodies are thick",
            "check the sign and the unit of the gap: a distance is positive, a press fit negative",
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
        InterfaceError::CoarseFace { .. } => (
            "faces along which the normal turns by at most 60 degrees",
            "refine the contact side there, or end it before the place",
        ),
        InterfaceError::MixedSurface { .. } => (
            "a contact side on one declared surface, or on none",
            "write a [[contact]] for each surface, or declare the rest of the side",
        ),
        InterfaceError::HeldNode { .. } => (
            "contact nodes that can move along the normal",
            "end the contact surface or the support one face earlier",
        ),
        InterfaceError::SupportedNode { .. } => (
            "contact nodes that can move along the contact normal, or ends of a straight line where both bodies are clamped",
            "end the contact surface or the support one edge earlier",
        ),
        InterfaceError::ClampedOverlap { .. } => (
            "imposed displacements that do not press clamped nodes into each other",
            "change one of the two displacements, or end the contact surface earlier",
        ),
        InterfaceError::BadGap { .. } => {
            ("a finite number", "change the expression; `gap = \"geometric\"` measures the gap")
        }
        InterfaceError::BadSlip { .. } | InterfaceError::SlipOnCoarserMesh => {
            ("load steps on one mesh", "leave [adapt] out of a case with [[step]]")
        }
        InterfaceError::BadFrictionLimit { .. } | InterfaceError::BadFrictionCoefficient { .. } => {
            ("a finite number >= 0", "change the number or the expression of `friction`")
        }
        InterfaceError::NotMatching { .. }
        | InterfaceError::FacetWithoutPartner { .. }
        | InterfaceError::Counts { .. }
        | InterfaceError::Offset { .. } => {
            ("surfaces whose nodes face each other", "mesh the two sides with the same divisions")
        }
    }
}

/// Returns the ways to keep an overlap that is drawn, or to be without it; `None` for other errors.
pub(super) fn press_fit(error: &InterfaceError) -> Option<String> {
    let (depth, close) = match error {
        InterfaceError::NotTouching { gap, .. } if *gap < 0.0 => (-gap, ", or write `gap = 0.0` to close it"),
        InterfaceError::Distance { gap, .. } if *gap < 0.0 => (-gap, ""),
        InterfaceError::Overlap { depth, .. } => (*depth, ""),
        _ => return None,
    };
    Some(format!(
        "for a press fit write `gap = \"geometric\"` and `interference = true`, which keeps this overlap, or draw surfaces that touch and write \
         `gap = {}` or an expression; if it is a mistake, move one of the bodies{close}",
        significant(-depth)
    ))
}

/// Returns message and fix for an error between a body and an obstacle, if the error's own words are about two bodies.
pub(super) fn against_obstacle(error: &InterfaceError) -> Option<(String, Fix)> {
    Some(match error {
        InterfaceError::NotFacing { point } => (
            format!("has no edge on this side that faces the obstacle; one of them is at {point}"),
            (
                "a side that faces the obstacle, to 60 degrees",
                "name the side that faces it, or turn the obstacle round: its `normal` points out of it, and `side` says where the \
                 body is",
            ),
        ),
        InterfaceError::Overlap { point, depth, .. } => (
            format!("overlaps the obstacle: deepest by {depth:.3e} at {point}"),
            (
                "a body that touches the obstacle or is apart from it",
                "move the obstacle by this depth, write `interference = true` for a press fit, or `gap = 0.0` if it is the rounding of a bent \
                 side",
            ),
        ),
        InterfaceError::TooDeep { point, depth, .. } => (
            format!("interferes with the obstacle by {depth:.3e} at {point}, and is thinner than that there"),
            (
                "an interference that is smaller than the body is thick",
                "check the place of the obstacle, and the sign of the gap: a distance is positive",
            ),
        ),
        InterfaceError::Distance { point, gap, spacing } => (
            format!(
                "{} {:.3e} at {point} (the edges there are {spacing:.3e} long), but the gap is given",
                if *gap > 0.0 { "is apart from the obstacle by" } else { "overlaps the obstacle by" },
                gap.abs()
            ),
            (
                "a side that touches the obstacle, within 5 % of an edge, if the gap is a number",
                "leave `gap` out: the distance from the obstacle is measured then; or move the obstacle",
            ),
        ),
        InterfaceError::SupportedNode { point, .. } => (
            format!(
                "has a contact node at {point} that a support holds along the normal of the obstacle, within 30 degrees, or in two \
                 directions"
            ),
            (
                "contact nodes that can move along the obstacle's normal, or ends of a straight side that are clamped, if the obstacle \
                 is fixed or its motion is imposed",
                "end the contact surface or the support one edge earlier",
            ),
        ),
        InterfaceError::ClampedOverlap { point, depth } => (
            format!(
                "is clamped at {point}, an end of its contact side, and its support presses it {depth:.3e} into the obstacle there"
            ),
            (
                "imposed displacements that leave the clamped end outside the obstacle",
                "change the displacement or the obstacle's motion, or end the contact surface one edge earlier",
            ),
        ),
        _ => return None,
    })
}

pub(super) fn of_refinement(error: &CommonRefinementError) -> Fix {
    match error {
        CommonRefinementError::NoSurface { .. } => BOUNDARY,
        CommonRefinementError::NoOverlap { .. } => (
            "two surfaces that face each other, at least in part",
            "check `contact.surfaces`: the side of the first body, then that of the second",
        ),
        CommonRefinementError::Folded { .. } => {
            ("surfaces that face each other one to one", "end the contact surface at the corner")
        }
        // Mesh, Body and future variants.
        _ => ("a body that can be cut along its contact side", "mesh the two sides with the same divisions"),
    }
}

pub(super) fn of_overlay(error: &OverlayError) -> Fix {
    match error {
        OverlayError::NoOverlap { .. } => (
            "two surfaces that face each other, at least in part",
            "check `contact.surfaces`: the side of the first body, then that of the second",
        ),
        OverlayError::Steep { .. } | OverlayError::Folded { .. } => (
            "surfaces that match, or patches that face one way",
            "split the pair into patches, or mesh both sides alike, in Gmsh by `Periodic Surface {pin} = {hole} Translate {0, 0, 0};` or \
             BooleanFragments",
        ),
        OverlayError::Thin { .. } => (
            "nodes of the two sides that are apart, or in the same place",
            "mesh one of the two sides with other divisions, or both alike",
        ),
        OverlayError::MeasuredGap => (
            "a gap that is given, flat surfaces, or surfaces that match",
            "mesh both sides alike, take a rigid sphere or cylinder (`obstacle`) for the stiffer body, or write `gap = 0.0` if they touch",
        ),
        // Mesh, Body and future variants.
        _ => ("a body that can be cut along its contact side", "mesh the two sides with the same divisions"),
    }
}

/// Returns what bonded bodies have to be, and a fix.
pub(super) fn of_bonds(error: &BondError) -> Fix {
    match error {
        BondError::Circle { .. } => {
            ("offsets that add up to zero around every circle of bonds", "change one of the offsets")
        }
        BondError::Friction { .. } => {
            ("pairs without friction beside bonds", "take friction out, or mesh the bonded bodies as one")
        }
        BondError::Bent { .. } => {
            ("flat contact sides beside an offset", "take the offset out, or move the mesh of one body by it")
        }
        BondError::NoNode { .. } => {
            ("a contact side with a node that can move", "make its mesh finer, or take the pair out")
        }
        BondError::Interface { .. } => {
            ("an offset that leaves room where bonded bodies touch", "change the offset, or the contact side")
        }
        BondError::Join { source, .. } => match source {
            JoinError::Apart { .. } => (
                "bonded sides whose nodes coincide, to 1e-6 of the smaller body",
                "mesh both sides alike: curved sides that do not match cannot be bonded",
            ),
            JoinError::Supports { .. } => (
                "supports that differ by the offset where both sides of a bond are held",
                "hold one of the two sides there, or change the offset",
            ),
            JoinError::Cut { .. } => {
                ("a rim of the cut apart from bonded sides", "move the plane of the cut away from the bond")
            }
            JoinError::Rigid { .. } => (
                "rigid sides that end beside the supports of the other body",
                "let one of the two end elsewhere",
            ),
            JoinError::BodyForce => {
                ("one body force for all bonded bodies", "give them the same `body_force`")
            }
            JoinError::Occupied { .. } => {
                ("bonded sides without loads and supports", "take the condition off the bonded side")
            }
            _ => (
                "bodies that make a sound mesh together",
                "check that the bodies only share their bonded sides",
            ),
        },
        _ => ("bodies that can be bonded", "mesh them as one body"),
    }
}

/// Reports constants that make no material.
pub(super) fn refuse_material(r: &Reader<'_>, error: &MaterialError) {
    let (expected, fix) = of_material(error);
    r.refuse(material_key(error), error.to_string(), expected, fix);
}

/// Returns what constants of a material have to be, and a fix.
pub(super) fn of_material(error: &MaterialError) -> Fix {
    match error {
        MaterialError::Young { .. } | MaterialError::Modulus { .. } => {
            ("a finite number > 0, well within the range of numbers", "check the units; steel has 210e9 Pa")
        }
        MaterialError::Poisson { .. } => {
            ("a number > -1 and < 0.5", "write 0.49 or less for a nearly incompressible material")
        }
        MaterialError::PoissonPair { name: "poisson_13" | "poisson_23", .. } => (
            "Poisson's ratios for which the strain energy is positive",
            "lower it: poisson_ij is the strain along j for a stress along i, and belongs to young_i",
        ),
        MaterialError::PoissonPair { .. } | MaterialError::PoissonTriple { .. } => (
            "Poisson's ratios for which the strain energy is positive",
            "lower it: poisson_12 is the strain along 2 for a stress along 1, and belongs to young_1",
        ),
        MaterialError::Expansion { .. } => {
            ("a number from -1 to 1", "write it per unit of temperature, such as 1.2e-5")
        }
        MaterialError::ExpansionOfStiffness => (
            "`young` and `poisson`, or the constants of an orthotropic material",
            "write these constants, or `hypothesis = \"plane_stress\"`",
        ),
        MaterialError::Density { .. } => {
            ("a number from 0 to 1e100", "write a density in units that agree with the others")
        }
        MaterialError::NotFinite { .. } => ("a finite number", "write the number itself"),
        MaterialError::Axes => ("two vectors that span a plane", "write the vectors along axes 1 and 2"),
        MaterialError::NotSymmetric { .. } => {
            ("a symmetric matrix", "write the entry above the diagonal and its mirror image alike")
        }
        MaterialError::NearlySingular { .. } => (
            "eigenvalues that differ by a factor of at most 1e12",
            "check the units of all rows; the last holds the shear modulus, in the same unit as the others",
        ),
        MaterialError::NotPositiveDefinite { .. } => {
            ("a matrix whose strain energy is positive", "check the signs, and that no diagonal entry is 0")
        }
    }
}

/// Returns the key that an error is about.
pub(super) fn material_key(error: &MaterialError) -> &'static str {
    match error {
        MaterialError::Young { .. } => "young",
        MaterialError::Poisson { .. } => "poisson",
        MaterialError::Modulus { name, .. } | MaterialError::PoissonPair { name, .. } => name,
        MaterialError::PoissonTriple { .. } => "poisson_12",
        MaterialError::NotFinite { name: "angle", .. } => "angle",
        MaterialError::Axes => "axes",
        MaterialError::Expansion { .. } | MaterialError::ExpansionOfStiffness => "expansion",
        MaterialError::Density { .. } => "density",
        MaterialError::NotFinite { .. }
        | MaterialError::NotSymmetric { .. }
        | MaterialError::NearlySingular { .. }
        | MaterialError::NotPositiveDefinite { .. } => "stiffness",
    }
}

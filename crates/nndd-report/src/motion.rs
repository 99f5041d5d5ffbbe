//! Rigid motions in words.

use crate::words::components;
use case_io::Case;
use case_io::case::Dimension;
use fem_core::body::RigidMotion;
use fem_core::geometry::{Coordinates, shown};
use fem_core::interface::Partner;
use fem_core::prepared::AssemblyMotion;
use fem_core::space::Space;

/// Names a body or an obstacle.
pub(crate) fn member<S: Dimension>(case: &Case<S>, of: Partner) -> String {
    match of {
        Partner::Body(body) => format!("body \"{}\"", case.bodies[body].name),
        Partner::Obstacle(obstacle) => {
            let obstacles = case.contacts.iter().filter(|contact| contact.obstacle.is_some());
            let name = obstacles.map(|contact| &contact.name).nth(obstacle);
            format!("the obstacle of \"{}\"", name.map_or("", String::as_str))
        }
    }
}

/// Describes a motion of the assembly.
pub(crate) fn all_move<S: Dimension>(case: &Case<S>, motion: &AssemblyMotion<S>) -> String {
    let of =
        |(partner, moved): &(Partner, RigidMotion<S>)| format!("{} {}", member(case, *partner), moves(moved));
    motion.bodies.iter().map(of).collect::<Vec<_>>().join(" and ")
}

/// Describes a rigid motion.
pub(crate) fn moves<S: Space>(motion: &RigidMotion<S>) -> String {
    // Round-off is not shown.
    let rounded = |v: S::Vector| components(v.entries(), |x| shown((x * 1e4).round() / 1e4 + 0.0));
    match S::screw(motion.translation, motion.spin) {
        None => format!("can move by {}", rounded(motion.translation)),
        Some((arm, None)) => format!("can rotate about {}", rounded(motion.centre + arm)),
        Some((arm, Some(axis))) => {
            format!("can rotate about the axis {} through {}", rounded(axis), rounded(motion.centre + arm))
        }
    }
}

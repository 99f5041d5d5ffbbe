//! Rigid motions in words.

use case_io::Case;
use fem_core::body::RigidMotion;
use fem_core::geometry::shown;
use fem_core::interface::Partner;

/// Names a body or an obstacle.
pub(crate) fn member(case: &Case, of: Partner) -> String {
    match of {
        Partner::Body(body) => format!("body \"{}\"", case.bodies[body].name),
        Partner::Obstacle(obstacle) => {
            let obstacles = case.contacts.iter().filter(|contact| contact.obstacle.is_some());
            let name = obstacles.map(|contact| &contact.name).nth(obstacle);
            format!("the obstacle of \"{}\"", name.map_or("", String::as_str))
        }
    }
}

/// Describes a rigid motion.
pub(crate) fn moves(motion: &RigidMotion) -> String {
    // Round-off is not shown.
    let r = |x: f64| shown((x * 1e4).round() / 1e4 + 0.0);
    let [x, y] = motion.translation.into();
    let small = 1e-9 * motion.translation.norm();
    if motion.spin.abs() <= small {
        return format!("can move by ({}, {})", r(x), r(y));
    }
    // t + ω e_z × (x − c) = 0 at the centre of rotation.
    let [a, b] = [motion.centre[0] - y / motion.spin, motion.centre[1] + x / motion.spin];
    format!("can rotate about ({}, {})", r(a), r(b))
}

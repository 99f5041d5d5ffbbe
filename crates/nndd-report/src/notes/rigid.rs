//! Notes about rigid sides and obstacles.

use crate::motion;
use crate::space::ReportSpace;
use case_io::Case;
use case_io::case::BodyCase;
use fem_core::body::{Body, RigidSide, SupportSet};
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactProblem, Obstacle, Partner, RigidLine};

/// Supports and axes are parallel up to this sine.
const PARALLEL: f64 = 1e-6;

/// Says which supports hold nodes of a rigid side along a component that the side imposes as well: the problem determines the sum of both reactions.
pub(super) fn shared_reactions<S: ReportSpace>(given: &BodyCase<S>, body: &Body<S>) -> Vec<String> {
    let both = |(side, set): (&RigidSide<S>, &SupportSet<S>)| {
        let on_side = |node: &&_| side.nodes.contains(node);
        let shared: Vec<_> = set.nodes.iter().zip(&set.reactions).filter(|(node, _)| on_side(node)).collect();
        let holds = |c: usize| {
            let axis = S::Vector::of(|k| f64::from(u8::from(k == c)));
            side.imposes[c] && shared.iter().any(|(_, held)| norm(held.project(axis)) > PARALLEL)
        };
        let keys: Vec<&str> = (0..S::DIM).filter(|c| holds(*c)).map(|c| S::MOTIONS[c]).collect();
        (!keys.is_empty()).then(|| {
            format!(
                "body \"{}\": the rigid side \"{}\" imposes `{}`, and a support on \"{}\" holds nodes of it in that direction: only the sum of \
                 their forces is determined, and the report shows one way to split it",
                given.name,
                side.group,
                keys.join("`, `"),
                set.group
            )
        })
    };
    let sides = body.rigid_sides().iter().flat_map(|side| body.supports().iter().map(move |set| (side, set)));
    sides.filter_map(both).collect()
}

/// Says which round obstacles only contact keeps from moving aside.
pub(super) fn free_aside<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Vec<String> {
    let along_axis = |obstacle: &Obstacle<S>, c: usize| match obstacle.line {
        RigidLine::Cylinder { axis, .. } => axis[c].abs() >= (1.0 - PARALLEL) * norm(axis),
        _ => false,
    };
    let is_free = |obstacle: &Obstacle<S>, c: usize| {
        obstacle.motion[c].is_none() && obstacle.force[c] == 0.0 && !along_axis(obstacle, c)
    };
    let note = |(k, obstacle): (usize, &Obstacle<S>)| {
        let round = !matches!(obstacle.line, RigidLine::Plane { .. });
        let keys: Vec<&str> =
            (0..S::DIM).filter(|c| round && is_free(obstacle, *c)).map(|c| S::MOTIONS[c]).collect();
        let fix: Vec<String> = keys.iter().map(|key| format!("`{key} = 0.0`")).collect();
        (!keys.is_empty()).then(|| {
            format!(
                "{}: `{}` is neither imposed nor loaded, so only contact keeps it from moving aside; write {} if it must not",
                motion::member(case, Partner::Obstacle(k)),
                keys.join("`, `"),
                fix.join(", ")
            )
        })
    };
    problem.obstacles.iter().enumerate().filter_map(note).collect()
}

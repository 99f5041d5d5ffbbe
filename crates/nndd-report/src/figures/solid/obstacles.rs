//! Rigid obstacles as nets of lines, as far as bodies face them.

use super::Model;
use crate::plot::{Entry, OUTLINE};
use crate::render::{Line, Vector};
use fem_core::interface::{Partner, RigidLine};
use fem_core::space::Solid;
use std::f64::consts::{PI, TAU};

/// Lines of a net in each direction, less one, and points of a curved line, less one.
const LINES: usize = 6;
const POINTS: usize = 48;
/// A net is this many times as large as the side that faces it.
const BEYOND: f64 = 1.2;

impl Model<'_> {
    /// Draws all obstacles where their motion, multiplied by the factor of the displacements, takes them.
    pub(super) fn obstacles(&self) -> Vec<Line> {
        let problem = self.solution.problem;
        let mut lines = Vec::new();
        for pair in &problem.contacts {
            let (Some(obstacle), Some(Partner::Obstacle(place))) =
                (problem.obstacle_of(pair), pair.partners().into_iter().find(|of| of.is_obstacle()))
            else {
                continue;
            };
            let nodes = pair.interface.pairs().iter().map(|of| self.rest(pair.body, of.nodes[0]));
            let nodes: Vec<Vector> = nodes.collect();
            let centre = nodes.iter().sum::<Vector>() / nodes.len().max(1) as f64;
            let reach = BEYOND * nodes.iter().map(|node| (node - centre).norm()).fold(0.0, f64::max);
            let motion = self.estimate.and_then(|estimate| estimate.pair.obstacles.get(place)?.first());
            let moved = motion.map_or(Vector::zeros(), |u| self.factor * u);
            for line in net(&obstacle.line, centre, reach) {
                let ends = line.windows(2).map(|pair| [pair[0] + moved, pair[1] + moved]);
                let line = |ends| Line { ends, colour: Entry::Obstacle.colour(), width: OUTLINE };
                lines.extend(ends.map(line));
            }
        }
        lines
    }
}

/// Returns lines on an obstacle near a point.
fn net(obstacle: &RigidLine<Solid>, centre: Vector, reach: f64) -> Vec<Vec<Vector>> {
    let steps = |count: usize| (0..=count).map(move |k| 2.0 * k as f64 / count as f64 - 1.0);
    match *obstacle {
        RigidLine::Plane { point, normal } => {
            let [_, across, along] = frame(normal);
            let n = normal / normal.norm();
            let foot = centre - n * (centre - point).dot(&n);
            let at = |x: f64, y: f64| foot + reach * (x * across + y * along);
            let lines = steps(LINES).map(|x| vec![at(x, -1.0), at(x, 1.0)]);
            lines.chain(steps(LINES).map(|y| vec![at(-1.0, y), at(1.0, y)])).collect()
        }
        RigidLine::Circle { centre: middle, radius, .. } => {
            let [out, across, along] = frame(centre - middle);
            let most = (reach / radius).min(PI);
            let at = |polar: f64, turn: f64| {
                let level = turn.cos() * across + turn.sin() * along;
                middle + radius * (polar.cos() * out + polar.sin() * level)
            };
            let part = |k: usize| k as f64 / LINES as f64;
            let rings = (1..=LINES).map(|k| steps(POINTS).map(|t| at(part(k) * most, PI * t)).collect());
            let spokes = (0..2 * LINES).map(|k| {
                (0..=POINTS / 2)
                    .map(|j| at(most * 2.0 * j as f64 / POINTS as f64, 0.5 * TAU * part(k)))
                    .collect()
            });
            rings.chain(spokes).collect()
        }
        RigidLine::Cylinder { point, axis, radius, .. } => {
            let [along, ..] = frame(axis);
            let foot = point + along * (centre - point).dot(&along);
            let away = centre - foot;
            let out = if away.norm() > 1e-6 * radius { away / away.norm() } else { frame(axis)[1] };
            let across = along.cross(&out);
            let most = (reach / radius).min(PI);
            let at = |turn: f64, height: f64| {
                foot + radius * (turn.cos() * out + turn.sin() * across) + reach * height * along
            };
            let rings = steps(LINES).map(|y| steps(POINTS).map(|t| at(most * t, y)).collect());
            let straight = steps(2 * LINES).map(|t| vec![at(most * t, -1.0), at(most * t, 1.0)]);
            rings.chain(straight).collect()
        }
    }
}

/// Completes a direction to three perpendicular unit vectors, itself first.
fn frame(direction: Vector) -> [Vector; 3] {
    let length = direction.norm();
    let first = if length > 0.0 { direction / length } else { Vector::z() };
    let mut axis = Vector::zeros();
    axis[first.abs().imin()] = 1.0;
    let second = first.cross(&axis).normalize();
    [first, second, first.cross(&second)]
}

//! Rigid obstacles: the part of their lines that is near the bodies, and hatches on the side where they are.

use super::axis::{drawable, extent};
use super::colour::{GREY, INK};
use super::look::{Look, Marker};
use super::sheet::{FINE, PIXEL, Panel, Sheet, path};
use fem_core::geometry::{Vector, norm, perpendicular};
use fem_core::interface::RigidLine;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// A rigid obstacle.
pub(crate) struct ObstaclePicture<'a> {
    /// Its line.
    pub(crate) line: RigidLine,
    /// The points that face the contact nodes.
    pub(crate) points: &'a [Vector],
    /// How it moves.
    pub(crate) motion: Motion,
    /// The translation that is imposed on it; zero along free components.
    pub(crate) imposed: Vector,
    /// Its load: a force, and a moment, counter-clockwise.
    pub(crate) load: (Vector, f64),
}

/// A motion without strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// A point, and its displacement.
    pub(crate) centre: Vector,
    pub(crate) translation: Vector,
    /// The rotation about it, counter-clockwise, radians.
    pub(crate) spin: f64,
}

impl Motion {
    /// The displacement of a point.
    pub(super) fn at(&self, point: Vector) -> Vector {
        self.translation + self.spin * perpendicular(point - self.centre)
    }
}

pub(super) const OBSTACLE: Look = Look::new("rigid obstacle", INK, 2.0 * PIXEL, Marker::None);
/// The line extends beyond the contact at each end by this part of the contact's length, and at least by the second part
/// of the bodies' size.
const BEYOND: f64 = 0.15;
const LEAST_BEYOND: f64 = 0.05;
/// Parts of an arc for each turn.
const PARTS: f64 = 180.0;
/// Distance of the hatches, and their length.
const HATCHES: f64 = 9.0 * PIXEL;
pub(super) const HATCH: f64 = 10.0 * PIXEL;
/// Hatches at most.
const MOST_HATCHES: usize = 1000;

impl ObstaclePicture<'_> {
    /// The points of the line near the contact, and the normal into the obstacle at each.
    ///
    /// * `size`: of the bodies.
    pub(super) fn near(&self, size: f64) -> Vec<[Vector; 2]> {
        let whole = |v: &Vector| v.iter().all(|x| drawable(*x));
        let points = || self.points.iter().filter(|p| whole(p));
        let beyond = |length: f64| (BEYOND * length).max(LEAST_BEYOND * size);
        let found: Vec<Vector> = match self.line {
            RigidLine::Plane { point, normal } => {
                let along = perpendicular(normal) / norm(normal);
                let Some((from, to)) = extent(points().map(|p| along.dot(&(p - point)))) else {
                    return vec![];
                };
                let more = beyond(to - from);
                [from - more, to + more].map(|s| point + s * along).to_vec()
            }
            // Cases of the plane have no cylinders.
            RigidLine::Cylinder { .. } => return vec![],
            RigidLine::Circle { centre, radius, .. } => {
                let mut angles: Vec<f64> =
                    points().map(|p| (p[1] - centre[1]).atan2(p[0] - centre[0])).collect();
                angles.sort_by(f64::total_cmp);
                // The arc without its largest gap.
                let after = |k: usize| angles.get(k + 1).copied().unwrap_or(angles[0] + TAU);
                let gap = |k: &usize| after(*k) - angles[*k];
                let Some(widest) = (0..angles.len()).max_by(|j, k| gap(j).total_cmp(&gap(k))) else {
                    return vec![];
                };
                let open = gap(&widest);
                let more = beyond(radius * (TAU - open)) / radius;
                let (from, to) = match open > 2.0 * more {
                    true => (after(widest) - more, angles[widest] + TAU + more),
                    false => (0.0, TAU),
                };
                let count = ((to - from) / TAU * PARTS).ceil().max(2.0);
                let at = |k: usize| from + k as f64 / count * (to - from);
                let place = |a: f64| centre + radius * Vector::new(a.cos(), a.sin());
                (0..=count as usize).map(|k| place(at(k))).collect()
            }
        };
        found
            .into_iter()
            .map(|p| [p, self.line.distance(p).1])
            .filter(|[p, n]| whole(p) && whole(n))
            .collect()
    }

    /// The middle of its contact, and the normal into it there.
    pub(super) fn middle(&self) -> [Vector; 2] {
        let mean = self.points.iter().sum::<Vector>() / self.points.len().max(1) as f64;
        let (distance, normal) = self.line.distance(mean);
        [mean + distance * normal, normal]
    }
}

/// Draws a line with hatches on the side to which the normals point.
pub(super) fn hatched(sheet: &mut Sheet, panel: &Panel<'_>, line: &[[Vector; 2]]) {
    let places: Vec<Vector> = line.iter().map(|[p, _]| panel.place(*p)).collect();
    let mut hatches = String::new();
    // From half a distance on, so that the ends stay free.
    let (mut next, mut drawn) = (0.5 * HATCHES, 0);
    for (ends, normals) in places.windows(2).zip(line.windows(2)) {
        let length = norm(ends[1] - ends[0]);
        let middle = normals[0][1] + normals[1][1];
        let out = Vector::new(middle[0], -middle[1]) / norm(middle);
        let way = FRAC_1_SQRT_2 * (out + perpendicular(out));
        while next < length && drawn < MOST_HATCHES {
            let at = ends[0] + next / length * (ends[1] - ends[0]);
            hatches += &path(&[at, at + HATCH * way]);
            (next, drawn) = (next + HATCHES, drawn + 1);
        }
        next -= length;
    }
    sheet.stroke(&hatches, GREY, FINE);
    sheet.line(&OBSTACLE, &places);
}

/// An arrow around a place, counter-clockwise or clockwise: the points of its line, and of its head.
pub(super) fn turning(at: Vector, radius: f64, counter_clockwise: bool, head: [f64; 2]) -> [Vec<Vector>; 2] {
    // Downwards is positive on the sheet.
    let sign = if counter_clockwise { -1.0 } else { 1.0 };
    let place = |k: usize| {
        let angle = sign * (0.25 + 1.25 * k as f64 / 20.0) * PI;
        at + radius * Vector::new(angle.cos(), angle.sin())
    };
    let line: Vec<Vector> = (0..=20).map(place).collect();
    let out = (line[20] - at) / radius;
    let way = sign * perpendicular(out);
    let half = head[1] * out;
    [line.clone(), vec![line[20] + half, line[20] + head[0] * way, line[20] - half]]
}

//! Smooth curves through the nodes of a polygon: circles if the nodes lie on one, nearly cubics otherwise.

use crate::geometry::{Vector, angle_between, cross, norm, right_normal};

/// A line whose edge normals differ by at most this (sine of the angle) is straight.
pub const STRAIGHT: f64 = 1e-6;

/// The piece of a smooth curve between two neighbouring nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arch {
    ends: [Vector; 2],
    slopes: [f64; 2],
}

impl Arch {
    /// Creates the piece between two nodes with given normals of the curve.
    pub fn new(ends: [Vector; 2], normals: [Vector; 2]) -> Self {
        let [from, to] = ends;
        let (along, across) = (1.0 / norm(to - from) * (to - from), right_normal(from, to));
        let slope = |n: Vector| 2.0 * n.dot(&along) / (n.dot(&across) + norm(n));
        Self { ends, slopes: [-slope(normals[0]), slope(normals[1])] }
    }

    /// Returns the slopes at the two ends, each positive if the curve rises there towards the middle: `2 tan φ/2`
    /// for normals turned by `φ` against the chord's, with which the cubic has the height of a circle's arc.
    pub fn slopes(&self) -> [f64; 2] {
        self.slopes
    }

    /// Computes the point over a fraction of the chord: of a circle if the slopes are equal, otherwise nearly of a cubic with these
    /// slopes. If they are unequal, as beside a corner of a straight line, the larger one is limited to twice the smaller.
    pub fn at(&self, t: f64) -> Vector {
        let [from, to] = self.ends;
        let height = norm(to - from) * self.height(t)[0];
        (1.0 - t) * from + t * to + height * right_normal(from, to)
    }

    /// Computes the direction of the curve over a fraction of the chord, of any length.
    pub fn tangent(&self, t: f64) -> Vector {
        let [from, to] = self.ends;
        to - from + norm(to - from) * self.height(t)[1] * right_normal(from, to)
    }

    /// Computes the height over a fraction of the chord and its derivative, over the length of the chord.
    fn height(&self, t: f64) -> [f64; 2] {
        let [a, b] = self.slopes;
        let [a, b] = if a * b > 0.0 {
            let limit = 2.0 * a.abs().min(b.abs());
            [a, b].map(|x| x.clamp(-limit, limit))
        } else {
            [0.0; 2]
        };
        let cubic = t * (1.0 - t) * ((1.0 - t) * a + t * b);
        let slope = (1.0 - 2.0 * t) * ((1.0 - t) * a + t * b) + t * (1.0 - t) * (b - a);
        // The height of the arc with the mean slope over the height of its cubic: 1 in the middle of the edge.
        let squared = (0.25 * (a + b)).powi(2);
        if !(squared < 0.5) {
            return [cubic, slope];
        }
        let root = (0.25 * (1.0 + squared).powi(2) - squared * (2.0 * t - 1.0).powi(2)).sqrt();
        let round = 1.0 / (root + 0.5 * (1.0 - squared));
        let bend = 2.0 * squared * (2.0 * t - 1.0) / root * round * round;
        [cubic * round, slope * round + cubic * bend]
    }

    /// Computes the fraction of the chord over which a point lies.
    pub fn fraction(&self, point: Vector) -> f64 {
        let chord = self.ends[1] - self.ends[0];
        (point - self.ends[0]).dot(&chord) / chord.dot(&chord)
    }

    /// Returns the normal of the curve at one of its two ends, on the right of the chord; `None` at other points. The piece itself may be flatter there, see
    /// [`Self::at`].
    pub(crate) fn end_normal(&self, point: Vector) -> Option<Vector> {
        let [from, to] = self.ends;
        let end = self.ends.iter().position(|end| *end == point)?;
        let half = [-0.5, 0.5][end] * self.slopes[end];
        let along = 1.0 / norm(to - from) * (to - from);
        let squared = half * half;
        Some(1.0 / (1.0 + squared) * ((1.0 - squared) * right_normal(from, to) + 2.0 * half * along))
    }

    /// Returns the chord.
    pub(crate) fn chord(&self) -> Vector {
        self.ends[1] - self.ends[0]
    }
}

/// A node that is farther from the chord of its edge, over its length, was moved onto a curve.
const OFF_CHORD: f64 = 1e-12;

/// Tells whether a new node of an edge was moved onto a curve.
pub fn is_off_chord(node: Vector, [from, to]: [Vector; 2]) -> bool {
    let chord = to - from;
    cross(node - from, chord).abs() > OFF_CHORD * chord.dot(&chord)
}

/// Computes unit normals of the smooth curve through the points of a polygon: of the circle through each and its neighbours.
///
/// * `closed`: whether the line continues smoothly from its last point, which is then its first one.
pub fn smooth_normals(points: &[Vector], closed: bool) -> Vec<Vector> {
    let n = points.len();
    // Weighted by the length of the *other* edge, the mean is the normal of the circle through the three points.
    let mut normals = nodal_normals(points, closed, |edge| 1.0 / edge);
    if n > 3 && !closed {
        // Beside a corner the edge at a free end is straight: no circle continues beyond the corner.
        if is_corner([3, 2, 1, 0].map(|k| points[k])) {
            normals[0] = right_normal(points[0], points[1]);
        }
        if is_corner([n - 4, n - 3, n - 2, n - 1].map(|k| points[k])) {
            normals[n - 1] = right_normal(points[n - 2], points[n - 1]);
        }
    }
    normals
}

/// Computes unit normals at the points of a polygon: means of the right normals of the two edges, weighted as `weight` says by
/// their lengths. At a free end of a curved line the normal is the neighbour's mirrored at the last edge, which is
/// exact for a circle.
///
/// * `closed`: see [`smooth_normals`].
pub fn nodal_normals(points: &[Vector], closed: bool, weight: impl Fn(f64) -> f64) -> Vec<Vector> {
    let n = points.len();
    let weighted = |k: usize| {
        let [a, b] = [points[k], points[k + 1]];
        weight(norm(b - a)) * right_normal(a, b)
    };
    let unit = |v: Vector| 1.0 / norm(v) * v;
    let seam = if closed { Some(unit(weighted(n - 2) + weighted(0))) } else { None };
    let end = |edge: usize, neighbour: usize| {
        let own = unit(weighted(edge));
        let next = unit(weighted(neighbour - 1) + weighted(neighbour));
        let mirrored = 2.0 * next.dot(&own) * own - next;
        if cross(own, next).abs() > STRAIGHT { mirrored } else { own }
    };
    let normals = (0..n).map(|k| match k {
        _ if k == 0 || k + 1 == n => match seam {
            Some(normal) => normal,
            None if n == 2 => unit(weighted(0)),
            None if k == 0 => end(0, 1),
            None => end(n - 2, n - 2),
        },
        k => unit(weighted(k - 1) + weighted(k)),
    });
    normals.collect()
}

/// A node at which a line turns this many times as much over its length as at the next one is a corner.
const CORNER: f64 = 4.0;

/// Tells whether the third of four points in a row is a corner: the line turns there, and much less at the second.
pub fn is_corner(points: [Vector; 4]) -> bool {
    let edge = |k: usize| points[k + 1] - points[k];
    // On a circle the turn is half the length of both edges over the radius, however long they are.
    let curvature = |k: usize| angle_between(edge(k - 1), edge(k)) / (norm(edge(k - 1)) + norm(edge(k)));
    curvature(2) > CORNER * curvature(1)
}

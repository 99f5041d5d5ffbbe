//! The line on which both surfaces are measured: one side's polygon with its averaged normals, frozen.

use fem_core::body::Piece;
use fem_core::geometry::{Vector, angle_between, cross, norm, perpendicular, right_normal};
use fem_core::smooth::{Arch, is_corner, nodal_normals, smooth_normals};

/// The gap between two neighbouring pairs, measured between smooth curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    /// At ⅓ and ⅔ of the edge, m, negative where the curves overlap.
    pub(crate) gaps: [f64; 2],
    /// Uncertainty of the curves, m.
    pub(crate) uncertainty: f64,
    /// The pieces of the first and of the second body there, if both are known exactly.
    pub(crate) pieces: Option<[Piece; 2]>,
}

/// Maximum number of steps to the point of a smooth curve on a normal.
const ROUNDS: usize = 40;

/// A polygon with a normal at each node, linear between them, and its arc length `s`. A closed one ends
/// with its first point.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    points: Vec<Vector>,
    normals: Vec<Vector>,
    /// Unit normals of the smooth curve through the points: of the circle through each and its neighbours.
    smooth_normals: Vec<Vector>,
    arc: Vec<f64>,
    /// Over each edge the declared curve, or the line of a straight stretch: it takes the place of the smooth curve.
    pieces: Vec<Option<Piece>>,
    closed: bool,
}

impl Curve {
    /// Creates the curve through at least two points; normals are the means of the edges' right normals, weighted by
    /// length.
    pub(crate) fn new(points: Vec<Vector>) -> Self {
        Self::continued(points, [None; 2])
    }

    /// [`Self::new`] of a part of an outline: an end at which the outline continues smoothly has the normal of an inner node, the
    /// mean over all its edges.
    ///
    /// * `beyond`: the next points of the outline before and after an open line.
    pub(crate) fn continued(points: Vec<Vector>, beyond: [Option<Vector>; 2]) -> Self {
        let n = points.len();
        let ends = |k: usize| [points[k], points[n - 1 - k]];
        let beyond = if points[0] == points[n - 1] {
            [None; 2]
        } else {
            smooth_beyond([ends(0), ends(1)], (n > 2).then(|| ends(2)), beyond)
        };
        let (before, after) = (beyond[0].as_slice(), beyond[1].as_slice());
        let outline = [before, &points, after].concat();
        let inner = |all: Vec<Vector>| all[before.len()..before.len() + n].to_vec();
        let closed = outline.len() > 3 && outline[0] == outline[outline.len() - 1];
        let normals = inner(nodal_normals(&outline, closed, |edge| edge));
        let smooth_normals = inner(smooth_normals(&outline, closed));
        let mut arc = vec![0.0];
        for k in 1..n {
            arc.push(arc[k - 1] + norm(points[k] - points[k - 1]));
        }
        let closed = n > 3 && points[0] == points[n - 1];
        Self { points, normals, smooth_normals, arc, pieces: vec![None; n - 1], closed }
    }

    /// Keeps the curve open although its ends meet: in a corner.
    pub(crate) fn kept_open(mut self, open: bool) -> Self {
        self.closed &= !open;
        self
    }

    /// Starts a closed curve at a point of its last edge, with the normal at that point.
    pub(crate) fn begun_at(&self, seam: Vector) -> Self {
        let n = self.points.len();
        let [from, to] = [self.points[n - 2], self.points[n - 1]];
        let before = norm(seam - from);
        let t = before / norm(to - from);
        let normal = (1.0 - t) * self.normals[n - 2] + t * self.normals[n - 1];
        let around = |all: &[Vector], first: Vector| [&[first], &all[..n - 1], &[first]].concat();
        let offset = self.length() - self.arc[n - 2] - before;
        let arc = self.arc[..n - 1].iter().map(|s| s + offset);
        let arc = [0.0].into_iter().chain(arc).chain([self.length()]).collect();
        Self {
            points: around(&self.points, seam),
            normals: around(&self.normals, normal),
            smooth_normals: around(&self.smooth_normals, normal),
            arc,
            pieces: [&self.pieces[n - 2..], &self.pieces].concat(),
            closed: self.closed,
        }
    }

    /// Puts pieces over the edges, which are known exactly. A smooth curve beside a piece begins with its normal.
    pub(crate) fn with_pieces(mut self, pieces: Vec<Option<Piece>>) -> Self {
        let (last, closed) = (pieces.len(), self.is_closed());
        for k in 0..=last {
            let before = if k > 0 { Some(k - 1) } else { closed.then(|| last - 1) };
            let after = if k < last { Some(k) } else { closed.then_some(0) };
            let known = [before, after].map(|edge| edge.and_then(|edge| pieces[edge]));
            if let [Some(piece), None] | [None, Some(piece)] = known {
                let normal = piece.normal(self.points[k], self.smooth_normals[k]);
                if normal.dot(&self.smooth_normals[k]) >= SMOOTH {
                    self.smooth_normals[k] = normal;
                }
            }
        }
        self.pieces = pieces;
        self
    }

    /// Returns the pieces over an edge of each of two curves, if both are known exactly.
    pub(crate) fn both(curves: [&Self; 2], edge: [usize; 2]) -> Option<[Piece; 2]> {
        Some([curves[0].pieces[edge[0]]?, curves[1].pieces[edge[1]]?])
    }

    /// Uses one direction as the normal everywhere if it is at most 60 degrees from the normal of every edge.
    pub(crate) fn along(mut self, direction: Vector) -> Self {
        let unit = 1.0 / norm(direction) * direction;
        if self.points.windows(2).all(|w| unit.dot(&right_normal(w[0], w[1])) >= 0.5) {
            self.normals.fill(unit);
        }
        self
    }

    /// Replaces the normals at the nodes for which there is another one.
    pub(crate) fn with_normals(mut self, at: impl Fn(usize) -> Option<Vector>) -> Self {
        for (k, normal) in self.normals.iter_mut().enumerate() {
            *normal = at(k).unwrap_or(*normal);
        }
        self
    }

    /// Turns the normal at the first or the last node into a direction or its opposite, if the line's own turn
    /// permits it, see [`turns_into`].
    pub(crate) fn turn_end(&mut self, last: bool, direction: Vector) {
        let n = self.normals.len();
        let (k, neighbour) = if last { (n - 1, n - 2) } else { (0, 1) };
        let (normal, next) = (self.normals[k], self.normals[neighbour]);
        let free = normal.dot(&direction).signum() * direction;
        if turns_into(normal, free, angle_between(normal, next)) {
            self.normals[k] = free;
        }
    }

    /// Tells whether the curve is closed.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Returns the vector from the first point to the last.
    pub(super) fn chord(&self) -> Vector {
        self.points[self.points.len() - 1] - self.points[0]
    }

    /// Bounds, along an axis, the region that the normals sweep up to the corners of a box: it contains all points of
    /// the box that have a projection on the curve.
    pub(super) fn reach(&self, axis: Vector, corners: [Vector; 4]) -> [f64; 2] {
        // The linear normal is shortest in the middle of an edge.
        let middle = |w: &[Vector]| 0.5 * norm(w[0] + w[1]);
        let shortest = self.normals.windows(2).map(middle).fold(f64::INFINITY, f64::min);
        if !(shortest > 0.1) {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let farthest = |p: &Vector| corners.iter().map(|c| norm(*c - *p)).fold(0.0, f64::max);
        let far = self.points.iter().map(farthest).fold(0.0, f64::max) / shortest;
        let width = far * self.normals.iter().map(|n| n.dot(&axis).abs()).fold(0.0, f64::max);
        self.points
            .iter()
            .map(|p| p.dot(&axis))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
                [low.min(place - width), high.max(place + width)]
            })
    }

    /// Computes the point of a smooth curve through the nodes over edge `k`, at a fraction `t` of the edge: for
    /// points of a circle this is the circle, otherwise nearly a cubic that is normal to the circles' normals at the
    /// nodes, see [`Arch`].
    ///
    /// On a piece it is the point of the piece on the normal of the chord.
    pub(crate) fn smooth(&self, k: usize, t: f64) -> Vector {
        let [from, to] = [self.points[k], self.points[k + 1]];
        let on_chord = (1.0 - t) * from + t * to;
        match self.pieces[k] {
            Some(piece) => piece.meet(on_chord, right_normal(from, to)).unwrap_or(on_chord),
            None => self.arch(k).at(t),
        }
    }

    /// Computes the point of the smooth curve over edge `k` that lies on the normal of `line` at its arc length `s`.
    pub(crate) fn smooth_crossing(&self, k: usize, line: &Self, s: f64) -> Vector {
        let (r, n) = line.at(s);
        let span = cross(self.points[k + 1] - self.points[k], n);
        let mut t = line.crossing(s, self.points[k], self.points[k + 1]).clamp(0.0, 1.0);
        // The height changes little along the edge, so each step gains a digit or more.
        for _ in 0..ROUNDS {
            let step = cross(r - self.smooth(k, t), n) / span;
            t = (t + step).clamp(0.0, 1.0);
            if !(step.abs() > f64::EPSILON) {
                break;
            }
        }
        self.smooth(k, t)
    }

    /// Estimates the distance of edge `k` from the curve that it represents, m: an eighth of its length times its turn.
    pub(crate) fn sagitta(&self, k: usize) -> f64 {
        let length = norm(self.points[k + 1] - self.points[k]);
        let piece = self.pieces[k].unwrap_or_else(|| Piece::Smooth(self.arch(k)));
        piece.sagitta(length)
    }

    /// Estimates the uncertainty of the smooth curve over edge `k`, m: the difference between the heights from the
    /// slopes at its two ends, the largest of this edge and its neighbours. Zero on circles and straight lines, of
    /// third order if the curvature changes, of the order of the sagitta beside corners. Pieces have none.
    pub(crate) fn uncertainty(&self, k: usize) -> f64 {
        let edges = self.points.len() - 1;
        if self.pieces[k].is_some() {
            return 0.0;
        }
        let own = |k: usize| {
            if self.pieces[k].is_some() {
                return 0.0;
            }
            let [a, b] = self.arch(k).slopes();
            norm(self.points[k + 1] - self.points[k]) / 8.0 * (a - b).abs()
        };
        let wraps = self.is_closed();
        let before = if k > 0 { Some(k - 1) } else { wraps.then_some(edges - 1) };
        let after = if k + 1 < edges { Some(k + 1) } else { wraps.then_some(0) };
        [Some(k), before, after].into_iter().flatten().map(own).fold(0.0, f64::max)
    }

    /// Returns the piece of the smooth curve over edge `k`.
    fn arch(&self, k: usize) -> Arch {
        Arch::new([k, k + 1].map(|k| self.points[k]), [k, k + 1].map(|k| self.smooth_normals[k]))
    }

    /// Returns the arc length of each node, m.
    pub(crate) fn arc(&self) -> &[f64] {
        &self.arc
    }

    /// Returns the whole length, m.
    pub(crate) fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Returns point and normal at an arc length; before and after the ends the line continues straight.
    pub(crate) fn at(&self, s: f64) -> (Vector, Vector) {
        let last = self.points.len() - 2;
        let k = self.arc.partition_point(|a| *a <= s).saturating_sub(1).min(last);
        if s == self.arc[k] {
            return (self.points[k], self.normals[k]);
        }
        let t = (s - self.arc[k]) / (self.arc[k + 1] - self.arc[k]);
        let mix = |a: Vector, b: Vector, t: f64| (1.0 - t) * a + t * b;
        (
            mix(self.points[k], self.points[k + 1], t),
            mix(self.normals[k], self.normals[k + 1], t.clamp(0.0, 1.0)),
        )
    }

    /// Finds the node nearest to a point.
    pub(crate) fn nearest(&self, q: Vector) -> usize {
        let distance = |k: &usize| norm(self.points[*k] - q);
        (0..self.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// Finds the arc length whose normal meets the point: `(q − r(s)) × n(s) = 0`, a quadratic on each edge. NaN
    /// if there is no such arc length.
    ///
    /// * `hint`: the edge to try first; on return the edge found.
    pub(crate) fn parameter(&self, q: Vector, hint: &mut usize) -> f64 {
        let last = self.points.len() - 2;
        // Positive past the normal of node k.
        let past = |k: usize| (q - self.points[k]).dot(&perpendicular(self.normals[k]));
        let mut k = (*hint).min(last);
        while k < last && past(k + 1) >= 0.0 {
            k += 1;
        }
        while k > 0 && past(k) < 0.0 {
            k -= 1;
        }
        *hint = k;
        let (r, e) = (self.points[k], self.points[k + 1] - self.points[k]);
        let length = self.arc[k + 1] - self.arc[k];
        if past(k) < 0.0 {
            // Before the beginning: the first normal continues.
            let n = self.normals[k];
            return self.arc[k] + cross(q - r, n) / cross(e, n) * length;
        }
        if past(k + 1) >= 0.0 {
            let n = self.normals[k + 1];
            let beyond = cross(q - self.points[k + 1], n) / cross(e, n);
            return self.arc[k + 1] + beyond * length;
        }
        let (n, m) = (self.normals[k], self.normals[k + 1] - self.normals[k]);
        let a = -cross(e, m);
        let b = cross(q - r, m) - cross(e, n);
        let c = cross(q - r, n);
        let t = -2.0 * c / (b + b.signum() * (b * b - 4.0 * a * c).sqrt());
        self.arc[k] + t * length
    }

    /// Finds where the normal at an arc length crosses the segment `a`-`b`: a fraction of the way from `a`.
    pub(crate) fn crossing(&self, s: f64, a: Vector, b: Vector) -> f64 {
        let (r, n) = self.at(s);
        cross(r - a, n) / cross(b - a, n)
    }
}

/// Cosine of the largest turn of a smooth outline at a node, 30 degrees.
const SMOOTH: f64 = 0.866;

/// Returns the points beyond the two ends of a line at which the outline continues smoothly: it turns by at most 30 degrees there,
/// and not much more than at the next node.
///
/// * `ends`: the two ends, and the points next to them; `next`: the third points, `None` if the line is a single edge.
/// * `beyond`: the points beyond the ends.
pub(crate) fn smooth_beyond(
    ends: [[Vector; 2]; 2],
    next: Option<[Vector; 2]>,
    beyond: [Option<Vector>; 2],
) -> [Option<Vector>; 2] {
    let at = |e: usize| {
        let (end, inner) = (ends[0][e], ends[1][e]);
        // The next node of a single edge is its other end.
        let third = next.map_or(beyond[1 - e], |next| Some(next[e]))?;
        let goes_on = |out: &Vector| {
            let [a, b] = [end - inner, *out - end];
            a.dot(&b) >= SMOOTH * norm(a) * norm(b) && !is_corner([third, inner, end, *out])
        };
        beyond[e].filter(goes_on)
    };
    [at(0), at(1)]
}

/// Tells whether a normal should be turned into the direction that a support leaves free: if that direction is within
/// the uncertainty of the polygon's normal there, twice its turn from node to node. At the end of a circle's polygon
/// the edge's normal is off by half its turn, and the free direction of a symmetry axis is the circle's own normal.
pub(crate) fn turns_into(normal: Vector, free: Vector, turn: f64) -> bool {
    angle_between(normal, free) <= 2.0 * turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_a_corner_the_edge_at_an_end_of_the_line_is_straight() {
        for turn in [0.005, 0.05, 0.5] {
            let bent = |x: f64| Vector::new(x, turn * (x - 0.2f64).max(0.0));
            for xs in
                [vec![0.0, 0.2, 0.5, 0.75, 1.0], vec![0.0, 0.2, 0.35, 0.5, 1.0], vec![-1.0, -0.5, 0.2, 1.0]]
            {
                let points: Vec<Vector> = xs.iter().map(|x| bent(*x)).collect();
                let back: Vec<Vector> = points.iter().rev().copied().collect();
                for curve in [Curve::new(points), Curve::new(back)] {
                    for (k, t) in (0..curve.points.len() - 1).flat_map(|k| [0.2, 0.5, 0.9].map(|t| (k, t))) {
                        let point = curve.smooth(k, t);
                        let off = (point[1] - bent(point[0])[1]).abs();
                        assert!(off < 1e-15, "{turn} {k} {t}: {off:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_smooth_curve_through_points_of_a_circle_is_one() {
        let circle = |from: f64, to: f64, n: u32| -> Vec<Vector> {
            let at = |k| f64::from(k) / f64::from(n);
            (0..=n)
                .map(|k| from + (to - from) * at(k))
                .map(|a| Vector::new(2.0 * a.cos(), 2.0 * a.sin()))
                .collect()
        };
        let mut whole = circle(0.0, std::f64::consts::TAU, 24);
        whole[24] = whole[0];
        for points in [whole, circle(0.2, 1.5, 5), circle(1.5, 0.2, 5)] {
            let curve = Curve::new(points.clone());
            for k in 0..points.len() - 1 {
                let half = (0.5 * curve.arc()[1] / 2.0).asin();
                let exact = 2.0 - 2.0 * half.cos();
                assert!((curve.sagitta(k) / exact - 1.0).abs() < 1e-12, "{k} {}", curve.sagitta(k));
                for t in [0.0, 0.1, 0.5, 0.8] {
                    let off = (norm(curve.smooth(k, t)) - 2.0).abs();
                    assert!(off < 1e-14, "{k} {t} {off:e}");
                }
            }
        }
        // For any uneven subdivision of the circle.
        let uneven: Vec<Vector> = [0.0f64, 0.3, 0.35, 0.6, 1.1, 1.15, 1.3]
            .iter()
            .map(|a| Vector::new(2.0 * a.cos(), 2.0 * a.sin()))
            .collect();
        let curve = Curve::new(uneven);
        for (k, t) in (0..6).flat_map(|k| [0.1, 0.5, 0.8].map(|t| (k, t))) {
            let off = (norm(curve.smooth(k, t)) - 2.0).abs();
            assert!(off < 1e-13 && curve.uncertainty(k) < 1e-13, "{k} {t} {off:e}");
        }
        let mut whole = circle(0.0, std::f64::consts::TAU, 24);
        whole[24] = whole[0];
        let closed = Curve::new(whole);
        let middle = 0.5 * (closed.points[23] + closed.points[0]);
        let begun = closed.begun_at(middle);
        assert_eq!((begun.points[1], begun.points[24]), (closed.points[0], closed.points[23]));
        for k in [0, 25] {
            assert!(cross(begun.normals[k], begun.points[k]).abs() < 1e-14);
        }
        assert!((begun.arc[1] - 0.5 * closed.arc[1]).abs() < 1e-14 && begun.length() == closed.length());
        assert!((begun.arc[2] - 1.5 * closed.arc[1]).abs() < 1e-14);
        // A corner of straight lines stays a corner, and the uncertainty beside it is of the order of the corner.
        let corner =
            Curve::new([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.4], [4.0, 0.8]].map(Vector::from).into());
        assert_eq!(corner.smooth(1, 0.5), Vector::new(1.5, 0.0));
        assert!((0..4).all(|k| (0.02..0.1).contains(&corner.uncertainty(k))));
    }

    #[test]
    fn the_parameter_inverts_points_off_an_arc() {
        // Oriented so that the outward normal of the body on the left points away from the centre.
        let arc = |k: usize| {
            let angle = 0.9 * k as f64 / 7.0 - 0.4;
            Vector::new(2.0 * angle.cos(), 2.0 * angle.sin())
        };
        let curve = Curve::new((0..8).map(arc).collect());
        let mut hint = 7;
        for k in 0..=100 {
            let s = curve.length() * (f64::from(k) / 100.0 * 1.2 - 0.1);
            let (r, n) = curve.at(s);
            for d in [0.0, 0.3, -0.2] {
                let found = curve.parameter(r + d * n, &mut hint);
                assert!((found - s).abs() < 1e-13, "{s} {d}: {found}");
            }
            let [a, b] = [r + Vector::new(-0.3, -0.5), r + Vector::new(0.9, 0.7)];
            let t = curve.crossing(s, a, b);
            let x = (1.0 - t) * a + t * b;
            assert!(cross(x - r, n).abs() < 1e-14);
        }
    }
}

//! The line on which both surfaces are measured: one side's polygon with its averaged normals, frozen.

use crate::geometry::{Vector, add, cross, dot, norm, perpendicular, right_normal, scale, sub};

/// A polygon with a normal at each node, linear between them, and its arc length `s`.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    points: Vec<Vector>,
    normals: Vec<Vector>,
    arc: Vec<f64>,
}

impl Curve {
    /// Makes the curve of at least two points; normals are the means of the edges' right normals, weighted by length.
    pub(super) fn new(points: Vec<Vector>) -> Self {
        let n = points.len();
        let edge = |k: usize| [points[k], points[k + 1]];
        let weighted = |k: usize| {
            let [a, b] = edge(k);
            scale(norm(sub(b, a)), right_normal(a, b))
        };
        let normals = (0..n).map(|k| {
            let sum = match k {
                0 => weighted(0),
                k if k + 1 == n => weighted(n - 2),
                k => add(weighted(k - 1), weighted(k)),
            };
            scale(1.0 / norm(sum), sum)
        });
        let normals = normals.collect();
        let mut arc = vec![0.0];
        for k in 1..n {
            arc.push(arc[k - 1] + norm(sub(points[k], points[k - 1])));
        }
        Self { points, normals, arc }
    }

    /// Returns the arc length of each node, m.
    pub(super) fn arc(&self) -> &[f64] {
        &self.arc
    }

    /// Returns the whole length, m.
    pub(super) fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Returns point and normal at an arc length; before and after the ends the line goes straight on.
    pub(super) fn at(&self, s: f64) -> (Vector, Vector) {
        let last = self.points.len() - 2;
        let k = self.arc.partition_point(|a| *a <= s).saturating_sub(1).min(last);
        if s == self.arc[k] {
            return (self.points[k], self.normals[k]);
        }
        let t = (s - self.arc[k]) / (self.arc[k + 1] - self.arc[k]);
        let mix = |a: Vector, b: Vector, t: f64| add(scale(1.0 - t, a), scale(t, b));
        (
            mix(self.points[k], self.points[k + 1], t),
            mix(self.normals[k], self.normals[k + 1], t.clamp(0.0, 1.0)),
        )
    }

    /// Finds the node nearest to a point.
    pub(super) fn nearest(&self, q: Vector) -> usize {
        let distance = |k: &usize| norm(sub(self.points[*k], q));
        (0..self.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// Finds the arc length whose normal meets the point: `(q − r(s)) × n(s) = 0`, a quadratic on each edge. Not a number
    /// where there is none.
    ///
    /// * `hint`: the edge to look at first; it becomes the edge found.
    pub(super) fn parameter(&self, q: Vector, hint: &mut usize) -> f64 {
        let last = self.points.len() - 2;
        // Positive past the normal of node k.
        let past = |k: usize| dot(sub(q, self.points[k]), perpendicular(self.normals[k]));
        let mut k = (*hint).min(last);
        while k < last && past(k + 1) >= 0.0 {
            k += 1;
        }
        while k > 0 && past(k) < 0.0 {
            k -= 1;
        }
        *hint = k;
        let (r, e) = (self.points[k], sub(self.points[k + 1], self.points[k]));
        let length = self.arc[k + 1] - self.arc[k];
        if past(k) < 0.0 {
            // Before the beginning: the first normal goes on.
            let n = self.normals[k];
            return self.arc[k] + cross(sub(q, r), n) / cross(e, n) * length;
        }
        if past(k + 1) >= 0.0 {
            let n = self.normals[k + 1];
            let beyond = cross(sub(q, self.points[k + 1]), n) / cross(e, n);
            return self.arc[k + 1] + beyond * length;
        }
        let (n, m) = (self.normals[k], sub(self.normals[k + 1], self.normals[k]));
        let a = -cross(e, m);
        let b = cross(sub(q, r), m) - cross(e, n);
        let c = cross(sub(q, r), n);
        let t = -2.0 * c / (b + b.signum() * (b * b - 4.0 * a * c).sqrt());
        self.arc[k] + t * length
    }

    /// Finds where the normal at an arc length crosses the segment `a`-`b`: a fraction of the way from `a`.
    pub(super) fn crossing(&self, s: f64, a: Vector, b: Vector) -> f64 {
        let (r, n) = self.at(s);
        cross(sub(r, a), n) / cross(sub(b, a), n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parameter_inverts_points_off_an_arc() {
        // Walked so that the outward normal of the body on the left points away from the centre.
        let arc = |k: usize| {
            let angle = 0.9 * k as f64 / 7.0 - 0.4;
            [2.0 * angle.cos(), 2.0 * angle.sin()]
        };
        let curve = Curve::new((0..8).map(arc).collect());
        let mut hint = 7;
        for k in 0..=100 {
            let s = curve.length() * (f64::from(k) / 100.0 * 1.2 - 0.1);
            let (r, n) = curve.at(s);
            for d in [0.0, 0.3, -0.2] {
                let found = curve.parameter(add(r, scale(d, n)), &mut hint);
                assert!((found - s).abs() < 1e-13, "{s} {d}: {found}");
            }
            let [a, b] = [add(r, [-0.3, -0.5]), add(r, [0.9, 0.7])];
            let t = curve.crossing(s, a, b);
            let x = add(scale(1.0 - t, a), scale(t, b));
            assert!(cross(sub(x, r), n).abs() < 1e-14);
        }
    }
}

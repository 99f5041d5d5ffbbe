//! Vectors of the plane, and the operations on them shared by the other modules; some serve any [`crate::space::Space`].

mod coordinates;

pub use coordinates::Coordinates;
pub use nalgebra::Vector2;

/// A point or vector of the plane, in the length unit of the user's data. `[x, y].into()` makes one of an array.
///
/// nalgebra has sums, multiples and `a.dot(&b)`; [`norm`] here does not overflow as early as nalgebra's.
pub type Vector = Vector2<f64>;

/// Writes a number exactly, with an exponent if it has many digits: for messages.
///
/// ```
/// use fem_core::geometry::shown;
/// assert_eq!([0.0, -2.5, 1e-300, 1e300].map(shown), ["0", "-2.5", "1e-300", "1e300"]);
/// ```
pub fn shown(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) || !x.is_finite() {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// Computes the out-of-plane component of `a × b`, twice the signed area of the triangle they span.
#[inline]
pub fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Computes the Euclidean length of a vector without undue overflow.
#[inline]
pub fn norm<V: Coordinates>(a: V) -> f64 {
    a.length()
}

/// A point as messages show it: `(x, y)` or `(x, y, z)`, see [`shown`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    entries: [f64; 3],
    count: usize,
}

impl<V: Coordinates> From<V> for Point {
    fn from(point: V) -> Self {
        let given = point.entries();
        Self { entries: [0, 1, 2].map(|k| given.get(k).copied().unwrap_or(0.0)), count: given.len() }
    }
}

impl std::ops::Index<usize> for Point {
    type Output = f64;

    fn index(&self, k: usize) -> &f64 {
        &self.entries[k]
    }
}

impl Point {
    /// Writes the point with numbers of a given form.
    pub(crate) fn shown_with(&self, number: impl Fn(f64) -> String) -> String {
        format!("({})", self.entries[..self.count].iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
    }
}

impl std::fmt::Display for Point {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.shown_with(shown))
    }
}

/// Rotates a vector by +90 degrees, `(x, y) ↦ (−y, x)`.
#[inline]
pub fn perpendicular(a: Vector) -> Vector {
    Vector::new(-a[1], a[0])
}

/// A part of a side is flat if its nodes are within this fraction of its size of a line or plane: coordinates in a file have few digits.
pub const FLAT_SIDE: f64 = 1e-5;

/// Sine of the angle below which directions count as parallel or perpendicular.
pub const PARALLEL: f64 = 1e-9;

/// Computes the angle between two directions, from 0 to π.
#[inline]
pub fn angle_between(a: Vector, b: Vector) -> f64 {
    cross(a, b).abs().atan2(a.dot(&b))
}

/// Computes the unit normal on the right of the path from `from` to `to`: the outward normal of a
/// body whose boundary is traversed counter-clockwise.
#[inline]
pub fn right_normal(from: Vector, to: Vector) -> Vector {
    let t = to - from;
    let length = norm(t);
    Vector::new(t[1] / length, -t[0] / length)
}

/// Computes the signed area of a triangle, positive when its corners run counter-clockwise.
#[inline]
pub fn signed_area(corners: [Vector; 3]) -> f64 {
    0.5 * cross(corners[1] - corners[0], corners[2] - corners[0])
}

/// The smallest area over the squared longest side of a triangle whose sign is not round-off.
const FLAT: f64 = 1e-14;

/// Computes the signed area of a triangle; `None` if its sign is round-off, or if it is not finite.
#[inline]
pub fn sure_area(corners: [Vector; 3]) -> Option<f64> {
    let area = signed_area(corners);
    let square = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm_squared();
    let longest = square(0).max(square(1)).max(square(2));
    (area.is_finite() && area.abs() > FLAT * longest).then_some(area)
}

/// Computes the smallest angle of a triangle, in degrees; not positive when its corners run clockwise.
#[inline]
pub fn smallest_angle(corners: [Vector; 3]) -> f64 {
    let at = |k: usize| {
        let (u, v) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
        cross(u, v).atan2(u.dot(&v)).to_degrees()
    };
    at(0).min(at(1)).min(at(2))
}

/// Computes the axis-aligned bounding box `[lower left, upper right]` of a set of points.
///
/// Returns two infinite corners in the wrong order for an empty set.
pub fn bounding_box<V: Coordinates>(points: &[V]) -> [V; 2] {
    let mut low = V::of(|_| f64::INFINITY);
    let mut high = V::of(|_| f64::NEG_INFINITY);
    for p in points {
        for c in 0..p.entries().len() {
            low[c] = low[c].min(p[c]);
            high[c] = high[c].max(p[c]);
        }
    }
    [low, high]
}

/// Computes the length of the bounding box's diagonal, the length scale of geometric tolerances.
pub fn diagonal<V: Coordinates>(points: &[V]) -> f64 {
    let [low, high] = bounding_box(points);
    if points.is_empty() { 0.0 } else { norm(high - low) }
}

/// Cuts off the part of a convex polygon in which `inside` is negative.
///
/// * `inside`: linear, such as the signed distance from a line, m.
pub fn clipped(polygon: &[Vector], inside: impl Fn(Vector) -> f64) -> Vec<Vector> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (p, q) = (inside(a), inside(b));
        if p >= 0.0 {
            kept.push(a);
        }
        if (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0) {
            kept.push(a + p / (p - q) * (b - a));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_normal_points_out_of_a_counter_clockwise_body() {
        // The bottom side of the unit square, traversed to the right: outward is down.
        assert_eq!(right_normal(Vector::zeros(), Vector::new(2.0, 0.0)), Vector::new(0.0, -1.0));
    }

    #[test]
    fn area_changes_sign_with_orientation() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]].map(Vector::from);
        assert_eq!(signed_area(corners), 1.0);
        assert_eq!(signed_area([corners[0], corners[2], corners[1]]), -1.0);
    }
}

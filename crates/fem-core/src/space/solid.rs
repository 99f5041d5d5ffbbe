//! The space of three dimensions.

use super::{Item, Number, Space, TRANSLATION, Words};
use crate::geometry::{Coordinates, diagonal};
use crate::quadrature::RADON7;
use crate::tensor::SymTensor3;
use nalgebra::{Matrix3, Matrix6, Vector3};
use std::array::from_fn;
use std::fmt::Debug;

/// The space of three dimensions: tetrahedra and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solid;

/// The smallest volume over the cube of the longest edge of a tetrahedron whose sign is not round-off.
const FLAT: f64 = 1e-14;

/// The corners of the facets of a tetrahedron of positive volume; the remaining corner is on the inner side.
const FACETS: [[usize; 3]; 4] = [[0, 2, 1], [1, 2, 3], [0, 3, 2], [0, 1, 3]];

/// Computes the triple product of the edges from the first corner, six times the volume.
#[inline(always)]
fn triple([o, a, b, c]: &[Vector3<f64>; 4]) -> f64 {
    (a - o).cross(&(b - o)).dot(&(c - o))
}

/// Computes the normal of a triangle, as long as twice its area.
#[inline]
fn across([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// A tetrahedron is beyond a face if its corners are, but for this fraction of their distance: rounding.
const BEYOND: f64 = 1e-13;

/// Tells whether a tetrahedron lies beyond face `k` of another one.
fn is_beyond(of: &[Vector3<f64>; 4], k: usize, other: &[Vector3<f64>; 4]) -> bool {
    let [p, q, r] = FACETS[k].map(|place| of[place]);
    let normal = across(&[p, q, r]);
    let rounding = BEYOND * BEYOND * normal.norm_squared();
    other.iter().all(|x| {
        let arm = x - p;
        let height = arm.dot(&normal);
        height >= 0.0 || height * height <= rounding * arm.norm_squared()
    })
}

/// Cuts off the part of a tetrahedron in which `inside` is negative, and adds what remains to `kept`.
///
/// * `inside`: linear, such as the signed distance from a plane.
fn cut(corners: [Vector3<f64>; 4], inside: &impl Fn(Vector3<f64>) -> f64, kept: &mut Vec<[Vector3<f64>; 4]>) {
    let values = corners.map(inside);
    halved(corners, values, kept);
}

/// [`cut`] with the values at the corners. An edge that is cut parts the tetrahedron in two; a new corner is 0, so this ends.
fn halved(corners: [Vector3<f64>; 4], values: [f64; 4], kept: &mut Vec<[Vector3<f64>; 4]>) {
    let inner = (0..4).find(|k| values[*k] > 0.0);
    let outer = (0..4).find(|k| values[*k] < 0.0);
    let (Some(inner), Some(outer)) = (inner, outer) else {
        if inner.is_some() {
            kept.push(corners);
        }
        return;
    };
    let share = values[inner] / (values[inner] - values[outer]);
    let crossing = corners[inner] + (corners[outer] - corners[inner]) * share;
    for replaced in [inner, outer] {
        let (mut corners, mut values) = (corners, values);
        (corners[replaced], values[replaced]) = (crossing, 0.0);
        halved(corners, values, kept);
    }
}

/// An edge of a face is cut in this many parts where the face is sampled, by a seven-point rule in each small triangle.
const SAMPLED_PARTS: usize = 6;

impl Space for Solid {
    const DIM: usize = 3;
    const COMPONENTS: usize = 6;
    const MOTIONS: &'static [&'static str] =
        &["ux", "uy", "uz", "rotation about x", "rotation about y", "rotation about z"];
    const WORDS: &'static Words = &Words {
        cell: "tetrahedron",
        cells: "tetrahedra",
        facet: "face",
        facets: "faces",
        article: "a",
        measure: "volume",
        sound: "corners not in one plane, and not turned over",
    };
    const AXES: [Vector3<f64>; 3] =
        [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];
    const ZEROS: [Vector3<f64>; 3] = [Vector3::new(0.0, 0.0, 0.0); 3];
    const ONE_TANGENT: bool = false;
    // Normals are those of flat faces, or of spheres and cylinders as they are declared; points of a file have six digits.
    const NORMAL_ERROR: f64 = 1e-5;

    type Vector = Vector3<f64>;
    type Tensor = SymTensor3;
    type Place = [f64; 3];
    type Matrix = Matrix6<f64>;
    type Spin = Vector3<f64>;
    type Axes<T: Item> = [T; 3];
    type Corners<T: Item> = [T; 4];
    type Components<T: Item> = [T; 6];
    type Data<T: Clone + Debug + Send + Sync> = [T; 3];

    #[inline(always)]
    fn axes<T: Item>(value: impl FnMut(usize) -> T) -> [T; 3] {
        from_fn(value)
    }

    #[inline(always)]
    fn corners<T: Item>(value: impl FnMut(usize) -> T) -> [T; 4] {
        from_fn(value)
    }

    #[inline(always)]
    fn components<T: Item>(value: impl FnMut(usize) -> T) -> [T; 6] {
        from_fn(value)
    }

    fn data<T: Clone + Debug + Send + Sync>(value: impl FnMut(usize) -> T) -> [T; 3] {
        from_fn(value)
    }

    fn complement(basis: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
        match basis {
            [] => Self::AXES,
            [a] => {
                // The axis that is farthest from the vector.
                let axis = Self::AXES[a.iamin()];
                let b = a.cross(&axis).normalize();
                [b, a.cross(&b), Vector3::zeros()]
            }
            [a, b] => [a.cross(b), Vector3::zeros(), Vector3::zeros()],
            _ => Self::ZEROS,
        }
    }

    #[inline(always)]
    fn cofactors<T: Number>([a, b, c]: &[[T; 3]; 3]) -> [[T; 3]; 3] {
        let cross = |a: &[T; 3], b: &[T; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        [cross(b, c), cross(c, a), cross(a, b)]
    }

    #[inline(always)]
    fn facet(k: usize) -> [usize; 3] {
        FACETS[k]
    }

    #[inline(always)]
    fn measure(corners: &[Vector3<f64>; 4]) -> f64 {
        triple(corners) / 6.0
    }

    fn sure_measure(corners: &[Vector3<f64>; 4]) -> Option<f64> {
        let edges = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
        let longest = edges.map(|(i, j)| (corners[i] - corners[j]).length()).fold(0.0, f64::max);
        let volume = Self::measure(corners);
        (volume.is_finite() && volume.abs() > FLAT * longest.powi(3)).then_some(volume)
    }

    #[inline(always)]
    fn gradients(corners: &[Vector3<f64>; 4], measure: f64) -> [Vector3<f64>; 4] {
        let sixth = 1.0 / (6.0 * measure);
        let [a, b, c] = [1, 2, 3].map(|k| corners[k] - corners[0]);
        let [one, two, three] = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|normal| normal * sixth);
        [-(one + two + three), one, two, three]
    }

    fn place(point: Vector3<f64>) -> [f64; 3] {
        point.into()
    }

    fn common_part(a: &[Vector3<f64>; 4], b: &[Vector3<f64>; 4]) -> Vec<[Vector3<f64>; 4]> {
        if (0..4).any(|k| is_beyond(a, k, b) || is_beyond(b, k, a)) {
            return Vec::new();
        }
        let mut parts = vec![*a];
        for [p, q, r] in FACETS {
            let normal = across(&[b[p], b[q], b[r]]);
            let mut kept = Vec::new();
            for part in parts {
                cut(part, &|x| (b[p] - x).dot(&normal), &mut kept);
            }
            parts = kept;
        }
        parts
    }

    fn smallest_angle(corners: &[Vector3<f64>; 4]) -> f64 {
        let normals = Self::gradients(corners, Self::measure(corners));
        let angle = |(i, j): (usize, usize)| {
            let (a, b) = (normals[i], -normals[j]);
            a.cross(&b).length().atan2(a.dot(&b)).to_degrees()
        };
        (0..4).flat_map(|i| (0..i).map(move |j| (i, j))).map(angle).fold(180.0, f64::min)
    }

    fn facet_measure(corners: &[Vector3<f64>; 3]) -> f64 {
        0.5 * across(corners).length()
    }

    fn facet_normal(corners: &[Vector3<f64>; 3]) -> Vector3<f64> {
        let normal = across(corners);
        normal / normal.length()
    }

    fn facet_rule() -> &'static [([f64; 3], f64)] {
        &RADON7
    }

    fn facet_samples() -> Vec<([f64; 3], f64)> {
        let parts = SAMPLED_PARTS as f64;
        // The parts of one row, upright and upside down, by their first corners.
        let upright = |i: usize, j: usize| ([i as f64, j as f64], 1.0);
        let turned = |i: usize, j: usize| ([(i + 1) as f64, (j + 1) as f64], -1.0);
        let of_row = |i: usize| {
            let row = SAMPLED_PARTS - i;
            (0..row).map(move |j| upright(i, j)).chain((1..row).map(move |j| turned(i, j - 1)))
        };
        let sample = |([i, j], sign): ([f64; 2], f64)| {
            RADON7.map(|(b, weight)| {
                let [x, y] = [(i + sign * b[1]) / parts, (j + sign * b[2]) / parts];
                ([1.0 - x - y, x, y], weight / (parts * parts))
            })
        };
        (0..SAMPLED_PARTS).flat_map(of_row).flat_map(sample).collect()
    }

    fn flat_normal(faces: &[[Vector3<f64>; 3]], fraction: f64) -> Option<Vector3<f64>> {
        let sum: Vector3<f64> = faces.iter().map(across).sum();
        let (start, normal) = (faces.first()?[0], sum / sum.length());
        let limit = fraction * diagonal(faces.as_flattened());
        let is_near = |x: &Vector3<f64>| (x - start).dot(&normal).abs() <= limit;
        faces.iter().flatten().all(is_near).then_some(normal)
    }

    #[inline(always)]
    fn turned(spin: Vector3<f64>, arm: Vector3<f64>) -> Vector3<f64> {
        spin.cross(&arm)
    }

    fn moment(arm: Vector3<f64>, force: Vector3<f64>) -> Vector3<f64> {
        arm.cross(&force)
    }

    fn motion(translation: Vector3<f64>, spin: Vector3<f64>) -> [f64; 6] {
        from_fn(|k| if k < 3 { translation[k] } else { spin[k - 3] })
    }

    fn parts(motion: &[f64; 6]) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::from_fn(|k, _| motion[k]), Vector3::from_fn(|k, _| motion[k + 3]))
    }

    fn screw(t: Vector3<f64>, w: Vector3<f64>) -> Option<(Vector3<f64>, Option<Vector3<f64>>)> {
        let turn = w.length();
        (turn > TRANSLATION * t.length()).then(|| (w.cross(&t) / (turn * turn), Some(w / turn)))
    }

    fn spin_of(moment: Vector3<f64>, arms: impl Iterator<Item = (f64, Vector3<f64>)>) -> Vector3<f64> {
        let square = |x: Vector3<f64>| Matrix3::identity() * x.norm_squared() - x * x.transpose();
        let inertia: Matrix3<f64> = arms.map(|(weight, arm)| weight * square(arm)).sum();
        inertia.try_inverse().map_or_else(Vector3::zeros, |inverse| inverse * moment)
    }
}

#[cfg(test)]
mod tests;

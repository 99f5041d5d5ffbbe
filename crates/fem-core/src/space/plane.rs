//! The plane.

use super::{Item, Number, Space, TRANSLATION, Words};
use crate::geometry::{
    Coordinates, clipped, cross, perpendicular, right_normal, signed_area, smallest_angle, sure_area,
};
use crate::quadrature::GAUSS5;
use crate::tensor::SymTensor2;
use nalgebra::{Matrix3, Vector2};
use std::array::from_fn;
use std::fmt::Debug;

/// The plane: triangles and edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane;

/// [`GAUSS5`] in barycentric coordinates.
const RULE: [([f64; 2], f64); 5] = {
    let mut rule = [([0.0; 2], 0.0); 5];
    let mut k = 0;
    while k < rule.len() {
        let (s, weight) = GAUSS5[k];
        rule[k] = ([1.0 - s, s], weight);
        k += 1;
    }
    rule
};

/// An edge is sampled in this many parts, by a five-point rule in each.
pub(crate) const SAMPLED_PARTS: usize = 33;

impl Space for Plane {
    const DIM: usize = 2;
    const COMPONENTS: usize = 3;
    const MOTIONS: &'static [&'static str] = &["ux", "uy", "rotation"];
    const WORDS: &'static Words = &Words {
        cell: "triangle",
        cells: "triangles",
        facet: "edge",
        facets: "edges",
        article: "an",
        measure: "area",
        sound: "corners not on one line, and counter-clockwise",
    };
    const AXES: [Vector2<f64>; 2] = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
    const ZEROS: [Vector2<f64>; 2] = [Vector2::new(0.0, 0.0); 2];
    const ONE_TANGENT: bool = true;
    // Normals of curved lines are those of polygons.
    const NORMAL_ERROR: f64 = 1e-3;

    type Vector = Vector2<f64>;
    type Tensor = SymTensor2;
    type Place = [f64; 2];
    type Matrix = Matrix3<f64>;
    type Spin = f64;
    type Axes<T: Item> = [T; 2];
    type Corners<T: Item> = [T; 3];
    type Components<T: Item> = [T; 3];
    type Data<T: Clone + Debug + Send + Sync> = [T; 2];

    #[inline(always)]
    fn axes<T: Item>(value: impl FnMut(usize) -> T) -> [T; 2] {
        from_fn(value)
    }

    #[inline(always)]
    fn corners<T: Item>(value: impl FnMut(usize) -> T) -> [T; 3] {
        from_fn(value)
    }

    #[inline(always)]
    fn components<T: Item>(value: impl FnMut(usize) -> T) -> [T; 3] {
        from_fn(value)
    }

    fn data<T: Clone + Debug + Send + Sync>(value: impl FnMut(usize) -> T) -> [T; 2] {
        from_fn(value)
    }

    fn complement(basis: &[Vector2<f64>]) -> [Vector2<f64>; 2] {
        match basis {
            [] => Self::AXES,
            [direction] => [perpendicular(*direction), Vector2::zeros()],
            _ => Self::ZEROS,
        }
    }

    #[inline(always)]
    fn cofactors<T: Number>([a, b]: &[[T; 2]; 2]) -> [[T; 2]; 2] {
        [[b[1], -b[0]], [-a[1], a[0]]]
    }

    #[inline(always)]
    fn facet(k: usize) -> [usize; 2] {
        [k, (k + 1) % 3]
    }

    #[inline(always)]
    fn measure(corners: &[Vector2<f64>; 3]) -> f64 {
        signed_area(*corners)
    }

    #[inline]
    fn sure_measure(corners: &[Vector2<f64>; 3]) -> Option<f64> {
        sure_area(*corners)
    }

    #[inline(always)]
    fn gradients(corners: &[Vector2<f64>; 3], measure: f64) -> [Vector2<f64>; 3] {
        let half = 1.0 / (2.0 * measure);
        from_fn(|k| {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            Vector2::new((a[1] - b[1]) * half, (b[0] - a[0]) * half)
        })
    }

    fn place(point: Vector2<f64>) -> [f64; 2] {
        [point[0], point[1]]
    }

    fn common_part(a: &[Vector2<f64>; 3], b: &[Vector2<f64>; 3]) -> Vec<[Vector2<f64>; 3]> {
        let mut polygon = a.to_vec();
        for k in 0..3 {
            let (from, along) = (b[k], b[(k + 1) % 3] - b[k]);
            polygon = clipped(&polygon, |p| cross(along, p - from));
            if polygon.len() < 3 {
                return Vec::new();
            }
        }
        polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]]).collect()
    }

    fn smallest_angle(corners: &[Vector2<f64>; 3]) -> f64 {
        smallest_angle(*corners)
    }

    #[inline]
    fn facet_measure([a, b]: &[Vector2<f64>; 2]) -> f64 {
        (b - a).length()
    }

    #[inline]
    fn facet_normal([a, b]: &[Vector2<f64>; 2]) -> Vector2<f64> {
        right_normal(*a, *b)
    }

    fn facet_rule() -> &'static [([f64; 2], f64)] {
        &RULE
    }

    fn facet_samples() -> Vec<([f64; 2], f64)> {
        let parts = SAMPLED_PARTS as f64;
        let rules = (0..SAMPLED_PARTS).flat_map(|part| GAUSS5.map(|rule| (part as f64, rule)));
        let sample = |(part, (point, weight)): (f64, (f64, f64))| {
            let s = (part + point) / parts;
            ([1.0 - s, s], weight / parts)
        };
        rules.map(sample).collect()
    }

    fn flat_normal(edges: &[[Vector2<f64>; 2]], fraction: f64) -> Option<Vector2<f64>> {
        // Chains have one end that no edge leads to, and one that none leaves.
        let start = edges.iter().map(|e| e[0]).find(|a| edges.iter().all(|e| e[1] != *a))?;
        let end = edges.iter().map(|e| e[1]).find(|b| edges.iter().all(|e| e[0] != *b))?;
        let normal = right_normal(start, end);
        let limit = fraction * (end - start).length();
        let is_near = |x: &Vector2<f64>| (x - start).dot(&normal).abs() <= limit;
        edges.iter().flatten().all(is_near).then_some(normal)
    }

    #[inline(always)]
    fn turned(spin: f64, arm: Vector2<f64>) -> Vector2<f64> {
        spin * perpendicular(arm)
    }

    fn moment(arm: Vector2<f64>, force: Vector2<f64>) -> f64 {
        cross(arm, force)
    }

    fn motion(translation: Vector2<f64>, spin: f64) -> [f64; 3] {
        [translation[0], translation[1], spin]
    }

    fn parts([x, y, spin]: &[f64; 3]) -> (Vector2<f64>, f64) {
        (Vector2::new(*x, *y), *spin)
    }

    fn screw(t: Vector2<f64>, w: f64) -> Option<(Vector2<f64>, Option<Vector2<f64>>)> {
        (w.abs() > TRANSLATION * t.length()).then(|| (Vector2::new(-t[1] / w, t[0] / w), None))
    }

    fn spin_of(moment: f64, arms: impl Iterator<Item = (f64, Vector2<f64>)>) -> f64 {
        moment / arms.map(|(weight, arm)| weight * arm.norm_squared()).sum::<f64>()
    }
}

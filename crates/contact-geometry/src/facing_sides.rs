//! The sides of different bodies that face each other, whether or not they are paired.

use super::FACING;
use fem_core::geometry::{Coordinates, bounding_box};
use fem_core::mesh::Mesh;
use fem_core::mesh::id::FacetId;
use fem_core::space::Space;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Two sides of different bodies that face each other.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FacingSides {
    /// The bodies, the smaller number first.
    pub bodies: [usize; 2],
    /// A side of each.
    pub sides: [String; 2],
    /// The largest distance along the normal between the middles of two of their facets that face each other, m.
    pub distance: f64,
}

/// A facet of a named side.
struct Facet<'a, S: Space> {
    body: usize,
    sides: &'a [&'a str],
    middle: S::Vector,
    normal: S::Vector,
    /// The largest distance of a corner from the middle, m.
    radius: f64,
    corners: S::Axes<S::Vector>,
}

/// Lists the sides of different bodies that face each other: those with two facets whose normals are opposite within 60 degrees, and whose middles are
/// no farther apart than a part of the larger facet's radius along its normal, and half of it across. Sides may face each other in part.
///
/// * `meshes`: of the bodies; `reach`: this part, positive and at most 1.
///
/// The time is proportional to `F log F` for `F` facets of named sides.
pub fn facing_sides<S: Space>(meshes: &[&Mesh<S>], reach: f64) -> Vec<FacingSides> {
    let names: Vec<BTreeMap<FacetId, Vec<&str>>> = meshes.iter().map(|mesh| names_of_facets(mesh)).collect();
    let facets: Vec<Facet<'_, S>> =
        meshes.iter().zip(&names).enumerate().flat_map(|(b, (mesh, names))| facets(b, mesh, names)).collect();
    let boxes = facets.iter().enumerate().map(|(k, facet)| {
        let [low, high] = bounding_box(facet.corners.as_ref()).map(S::place);
        GeomWithData::new(Rectangle::from_corners(low, high), k)
    });
    let tree = RTree::bulk_load(boxes.collect());
    let mut found = BTreeMap::new();
    for facet in &facets {
        let [low, high] = bounding_box(facet.corners.as_ref());
        let margin = S::Vector::of(|_| facet.radius);
        let around = AABB::from_corners(S::place(low - margin), S::place(high + margin));
        for other in tree.locate_in_envelope_intersecting(&around).map(|near| &facets[near.data]) {
            let distance = facet.distance(other).filter(|distance| *distance <= reach * facet.radius);
            if let Some(distance) = distance.filter(|_| other.body != facet.body) {
                insert(&mut found, [facet, other], distance);
            }
        }
    }
    let of = |((bodies, sides), distance)| FacingSides { bodies, sides, distance };
    found.into_iter().map(of).collect()
}

/// Lists the sides of each facet that has a name.
fn names_of_facets<S: Space>(mesh: &Mesh<S>) -> BTreeMap<FacetId, Vec<&str>> {
    let mut names: BTreeMap<FacetId, Vec<&str>> = BTreeMap::new();
    for (name, facets) in mesh.groups() {
        facets.iter().for_each(|facet| names.entry(*facet).or_default().push(name));
    }
    names
}

fn facets<'a, S: Space>(
    b: usize,
    mesh: &'a Mesh<S>,
    names: &'a BTreeMap<FacetId, Vec<&'a str>>,
) -> impl Iterator<Item = Facet<'a, S>> {
    names.iter().map(move |(&id, sides)| {
        let (middle, corners) = (mesh.facet_middle(id), mesh.facet_corners(id));
        let radius = corners.as_ref().iter().map(|x| (*x - middle).length()).fold(0.0, f64::max);
        Facet { body: b, sides, middle, normal: mesh.facet_normal(id), radius, corners }
    })
}

impl<S: Space> Facet<'_, S> {
    /// Computes the distance along the normal of a facet that is not larger, if it faces this one.
    fn distance(&self, other: &Self) -> Option<f64> {
        let way = other.middle - self.middle;
        let ahead = way.times(&self.normal);
        let across = (way - self.normal * ahead).length();
        let faces = other.radius <= self.radius
            && self.normal.times(&other.normal) <= FACING
            && across <= 0.5 * self.radius;
        faces.then_some(ahead.abs())
    }
}

/// The bodies and sides of facets that face each other, with the largest distance.
type Found = BTreeMap<([usize; 2], [String; 2]), f64>;

fn insert<S: Space>(found: &mut Found, mut of: [&Facet<'_, S>; 2], distance: f64) {
    of.sort_by_key(|facet| facet.body);
    for first in of[0].sides {
        for second in of[1].sides {
            let sides = [*first, *second].map(str::to_owned);
            let largest = found.entry((of.map(|facet| facet.body), sides)).or_insert(distance);
            *largest = largest.max(distance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::mesh::generate::{block, cuboid};

    fn named<S: Space>(meshes: &[Mesh<S>], reach: f64) -> Vec<String> {
        let name =
            |of: FacingSides| format!("{} {} {} {}", of.bodies[0], of.sides[0], of.bodies[1], of.sides[1]);
        facing_sides(&meshes.iter().collect::<Vec<_>>(), reach).into_iter().map(name).collect()
    }

    #[test]
    fn boxes_on_and_beside_each_other_face_at_one_side_each() {
        // The second box is on the first one, with other cells; the third is beside it, a little apart; the fourth is far away.
        let at = |x: [f64; 3], cells| cuboid(x, [1.0; 3], cells).unwrap();
        let bodies = [
            at([0.0; 3], [2; 3]),
            at([0.0, 0.0, 1.0], [3; 3]),
            at([1.02, 0.0, 0.0], [2; 3]),
            at([5.0, 0.0, 0.0], [2; 3]),
        ];
        assert_eq!(named(&bodies, 1.0), ["0 top 1 bottom", "0 right 2 left"]);
        // A face reaches 0.37 from its middle.
        assert_eq!(named(&bodies, 0.04), ["0 top 1 bottom"]);
        let distances: Vec<f64> =
            facing_sides(&bodies.each_ref(), 1.0).iter().map(|facing| facing.distance).collect();
        assert!(distances[0] < 1e-14 && (distances[1] - 0.02).abs() < 1e-14, "{distances:?}");
        let at = |x: [f64; 2], cells| block(x, [1.0; 2], cells).unwrap();
        let bodies = [at([0.0; 2], [2; 2]), at([0.0, 1.0], [3; 2]), at([1.02, 0.0], [2; 2])];
        assert_eq!(named(&bodies, 1.0), ["0 top 1 bottom", "0 right 2 left"]);
    }

    #[test]
    fn sides_that_share_an_edge_do_not_face() {
        let at = |x: [f64; 3]| cuboid(x, [1.0; 3], [2; 3]).unwrap();
        assert!(named(&[at([0.0; 3]), at([1.0, 0.0, 1.0])], 1.0).is_empty());
        assert!(named(&[at([0.0; 3])], 1.0).is_empty());
    }
}

//! The sides of different bodies that face each other, whether or not they are paired.

use super::FACING;
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, bounding_box};
use fem_core::mesh::id::FacetId;
use fem_core::space::Space;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::{BTreeMap, BTreeSet};

/// Two sides of different bodies that face each other.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct FacingSides {
    /// The bodies, the smaller number first.
    pub bodies: [usize; 2],
    /// A side of each.
    pub sides: [String; 2],
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
/// no farther apart than the larger facet's radius along its normal, and half of it across. Sides may face each other in part.
///
/// The time is proportional to `F log F` for `F` facets of named sides.
pub fn facing_sides<S: Space>(bodies: &[Body<S>]) -> Vec<FacingSides> {
    let names: Vec<BTreeMap<FacetId, Vec<&str>>> = bodies.iter().map(names_of_facets).collect();
    let facets: Vec<Facet<'_, S>> =
        bodies.iter().zip(&names).enumerate().flat_map(|(b, (body, names))| facets(b, body, names)).collect();
    let boxes = facets.iter().enumerate().map(|(k, facet)| {
        let [low, high] = bounding_box(facet.corners.as_ref()).map(S::place);
        GeomWithData::new(Rectangle::from_corners(low, high), k)
    });
    let tree = RTree::bulk_load(boxes.collect());
    let mut found = BTreeSet::new();
    for facet in &facets {
        let [low, high] = bounding_box(facet.corners.as_ref());
        let margin = S::Vector::of(|_| facet.radius);
        let around = AABB::from_corners(S::place(low - margin), S::place(high + margin));
        for other in tree.locate_in_envelope_intersecting(&around).map(|near| &facets[near.data]) {
            if other.body != facet.body && facet.faces(other) {
                insert(&mut found, [facet, other]);
            }
        }
    }
    found.into_iter().collect()
}

/// Lists the sides of each facet that has a name.
fn names_of_facets<S: Space>(body: &Body<S>) -> BTreeMap<FacetId, Vec<&str>> {
    let mut names: BTreeMap<FacetId, Vec<&str>> = BTreeMap::new();
    for (name, facets) in body.mesh().groups() {
        facets.iter().for_each(|facet| names.entry(*facet).or_default().push(name));
    }
    names
}

fn facets<'a, S: Space>(
    b: usize,
    body: &'a Body<S>,
    names: &'a BTreeMap<FacetId, Vec<&'a str>>,
) -> impl Iterator<Item = Facet<'a, S>> {
    let mesh = body.mesh();
    names.iter().map(move |(&id, sides)| {
        let (middle, corners) = (mesh.facet_middle(id), mesh.facet_corners(id));
        let radius = corners.as_ref().iter().map(|x| (*x - middle).length()).fold(0.0, f64::max);
        Facet { body: b, sides, middle, normal: mesh.facet_normal(id), radius, corners }
    })
}

impl<S: Space> Facet<'_, S> {
    /// Tells if a facet that is not larger faces this one.
    fn faces(&self, other: &Self) -> bool {
        let way = other.middle - self.middle;
        let ahead = way.times(&self.normal);
        let across = (way - self.normal * ahead).length();
        other.radius <= self.radius
            && self.normal.times(&other.normal) <= FACING
            && ahead.abs() <= self.radius
            && across <= 0.5 * self.radius
    }
}

fn insert<S: Space>(found: &mut BTreeSet<FacingSides>, mut of: [&Facet<'_, S>; 2]) {
    of.sort_by_key(|facet| facet.body);
    for first in of[0].sides {
        for second in of[1].sides {
            let sides = [*first, *second].map(str::to_owned);
            found.insert(FacingSides { bodies: of.map(|facet| facet.body), sides });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::Mesh;
    use fem_core::mesh::generate::{block, cuboid};
    use fem_core::space::Solid;

    fn solid(mesh: Mesh<Solid>) -> Body<Solid> {
        let steel = LinearElastic::isotropic_solid(1.0, 0.3).unwrap();
        Body::new(mesh, steel, &BoundaryConditions::default()).unwrap()
    }

    fn plane(mesh: Mesh) -> Body {
        let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, steel, &BoundaryConditions::new()).unwrap()
    }

    fn named<S: Space>(bodies: &[Body<S>]) -> Vec<String> {
        let name =
            |of: FacingSides| format!("{} {} {} {}", of.bodies[0], of.sides[0], of.bodies[1], of.sides[1]);
        facing_sides(bodies).into_iter().map(name).collect()
    }

    #[test]
    fn boxes_on_and_beside_each_other_face_at_one_side_each() {
        // The second box is on the first one, with other cells; the third is beside it, a little apart; the fourth is far away.
        let at = |x: [f64; 3], cells| solid(cuboid(x, [1.0; 3], cells).unwrap());
        let bodies = [
            at([0.0; 3], [2; 3]),
            at([0.0, 0.0, 1.0], [3; 3]),
            at([1.02, 0.0, 0.0], [2; 3]),
            at([5.0, 0.0, 0.0], [2; 3]),
        ];
        assert_eq!(named(&bodies), ["0 top 1 bottom", "0 right 2 left"]);
        let at = |x: [f64; 2], cells| plane(block(x, [1.0; 2], cells).unwrap());
        let bodies = [at([0.0; 2], [2; 2]), at([0.0, 1.0], [3; 2]), at([1.02, 0.0], [2; 2])];
        assert_eq!(named(&bodies), ["0 top 1 bottom", "0 right 2 left"]);
    }

    #[test]
    fn sides_that_share_an_edge_do_not_face() {
        let at = |x: [f64; 3]| solid(cuboid(x, [1.0; 3], [2; 3]).unwrap());
        assert!(named(&[at([0.0; 3]), at([1.0, 0.0, 1.0])]).is_empty());
        assert!(named(&[at([0.0; 3])]).is_empty());
    }
}

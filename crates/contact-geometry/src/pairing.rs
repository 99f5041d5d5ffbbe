//! Pairs two matching contact surfaces.

use super::common_refinement::{CommonRefinement, Measured};
use super::geometric_gap::{self, GeometricGap, Surfaces};
use super::matching::{self, Stretch};
use super::{ContactNormal, depth, normals, outline, profile};
use fem_core::body::Body;
use fem_core::boundary::ScalarData;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::Line;
use fem_core::interface::{ContactFacet, ContactInterface, Gap, InterfaceError, NodePair};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Plane, Space};

/// Pairs the contact surfaces of two bodies node by node. A pair at an end of a straight line that both bodies
/// clamp is removed, and its edge takes the pressure of its other end. Paired nodes face each other along the
/// contact normal to round-off; for non-matching surfaces see [`common_refinement`](crate::common_refinement::common_refinement).
///
/// * `surfaces`: the edge group of the first and of the second body.
/// * `gap`: the initial gap along the normal.
///
/// # Errors
/// Surfaces that do not match, do not face each other, have undeclared corners above 60 degrees, or are held or loaded, see
/// [`InterfaceError`].
pub fn pair(
    first: &Body,
    second: &Body,
    surfaces: [&str; 2],
    gap: &Gap,
) -> Result<ContactInterface, InterfaceError> {
    pair_along(first, second, surfaces, gap, ContactNormal::Averaged)
}

/// [`pair()`] with a choice of the contact normal.
///
/// At a contact node of a curved line that a support fixes in one direction, the normal is the free direction if
/// that is within twice the line's turn from node to node: on the axis of symmetry of a curved line, that is the
/// line's own normal. Otherwise a support does not change the normal.
///
/// # Errors
/// See [`pair()`]; a given normal that does not point out of the first body.
pub fn pair_along(
    first: &Body,
    second: &Body,
    surfaces: [&str; 2],
    gap: &Gap,
    normal: ContactNormal,
) -> Result<ContactInterface, InterfaceError> {
    pair_surfaces([first, second], surfaces, gap, normal, None)
}

/// Pairs the surfaces of two bodies after a common refinement, with the same `surfaces` and `normal`.
///
/// # Errors
/// See [`pair()`].
pub fn pair_refined(
    common: &CommonRefinement,
    surfaces: [&str; 2],
    gap: &Gap,
    normal: ContactNormal,
) -> Result<ContactInterface, InterfaceError> {
    pair_surfaces(common.bodies.each_ref(), surfaces, gap, normal, Some(&common.measured))
}

/// Pairs the surfaces. After a common refinement the bodies may have changed elsewhere: other pairs have put nodes into them.
///
/// * `common`: the refinement that made the surfaces match, if there was one.
pub(super) fn pair_surfaces(
    bodies: [&Body; 2],
    surfaces: [&str; 2],
    gap: &Gap,
    normal: ContactNormal,
    common: Option<&Measured>,
) -> Result<ContactInterface, InterfaceError> {
    let edges = [surface(bodies[0], 0, surfaces[0])?, surface(bodies[1], 1, surfaces[1])?];
    let chain = matching::walk(bodies[0], edges[0]);
    let (chain, partners, facing) = match (common, gap) {
        (Some(common), _) => {
            let (chain, facing) = matching::refined(bodies[0], chain, common)?;
            (chain, facing.iter().map(|f| f.nodes[1]).collect(), Some(facing))
        }
        (None, gap) => {
            let partner = match gap {
                Gap::Given(_) | Gap::Touching | Gap::Bonded { .. } => {
                    let nodes = chain.iter().flat_map(|s| s.nodes.iter().copied());
                    matching::nearest(bodies, edges, nodes, |point| point)?
                }
                Gap::Geometric | Gap::Interference => matching::along(bodies, edges, &chain)?,
            };
            let chain = match normal {
                ContactNormal::Averaged => matching::ended_at_corners(bodies, chain, &partner),
                ContactNormal::Fixed(_) => chain,
            };
            let partners: Vec<NodeId> = chain.iter().flat_map(|s| &s.nodes).map(|n| partner[n]).collect();
            (chain, partners, None)
        }
    };
    let (mut pairs, arc_lengths) = make_pairs(bodies, &chain, &partners);
    let edges = make_edges(bodies, edges, &chain, &pairs)?;
    normals::choose(bodies, &chain, &mut pairs, &edges, normal, facing.as_deref())?;
    let radial = match normal {
        ContactNormal::Averaged => outline::radial(bodies, &pairs, &edges),
        ContactNormal::Fixed(_) => None,
    };
    if let Some(radial) = radial {
        pairs.iter_mut().for_each(|pair| pair.normal = radial.normal(bodies, pair.nodes));
    }
    let drawn = GeometricGap::measure(bodies, &pairs, &edges, facing.as_deref())?;
    let between = match (gap, common) {
        (Gap::Given(_), _) => vec![None; edges.len()],
        (_, Some(common)) => profile::of_refined(&pairs, &edges, &common.between),
        (_, None) => profile::of_matching(bodies, &chain, (&pairs, drawn.gaps()), &edges),
    };
    let surfaces = Surfaces { drawn: &drawn, facets: &edges, between: &between };
    let points = bodies[0].mesh().points();
    match gap {
        Gap::Given(data) => {
            if let Some(facing) = &facing {
                geometric_gap::check_distances(points, facing)?;
            }
            given_gap(points, &mut pairs, data)?;
        }
        Gap::Touching | Gap::Bonded { .. } => surfaces.check_touching(points, &pairs)?,
        Gap::Geometric | Gap::Interference => surfaces.take_gaps(points, &mut pairs, gap)?,
    }
    depth::check(bodies.map(Some), &pairs, &edges)?;
    let profiles = match gap.is_measured() {
        true => profile::profiles(&pairs, &edges, &between),
        false => vec![None; edges.len()],
    };
    let gap_change = drawn.change(points, &pairs);
    let (interface, _) = Line { pairs, edges, arc_lengths, profiles }.between(bodies, gap.clone(), 0)?;
    Ok(interface.with_gap_change(gap_change).with_radial(radial))
}

/// Returns the facets of a group that may touch.
pub(super) fn surface<'a, S: Space>(
    body: &'a Body<S>,
    number: usize,
    group: &str,
) -> Result<&'a [FacetId], InterfaceError> {
    let facets = self::group(body, number, group)?;
    check_free(body, number, group, facets)?;
    Ok(facets)
}

/// Returns the facets of a group, at least one.
pub(super) fn group<'a, S: Space>(
    body: &'a Body<S>,
    number: usize,
    group: &str,
) -> Result<&'a [FacetId], InterfaceError> {
    let mesh = body.mesh();
    let Some(facets) = mesh.group(group) else {
        let known = mesh.groups().keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let (group, words) = (group.to_string(), S::WORDS);
        return Err(InterfaceError::UnknownSurface { body: number, group, known, words });
    };
    if facets.is_empty() {
        let reason = format!("has no {}", S::WORDS.facet);
        return Err(InterfaceError::NoSurface { body: number, group: group.to_string(), reason });
    }
    Ok(facets)
}

/// A support is along a facet if the sine of the angle between them is at most this.
const ALONG_FACET: f64 = 1e-6;

/// Refuses contact facets inside the body, and facets that are held, but for supports along them, or loaded.
pub(super) fn check_free<S: Space>(
    body: &Body<S>,
    number: usize,
    group: &str,
    edges: &[FacetId],
) -> Result<(), InterfaceError> {
    let fault = || InterfaceError::NoSurface {
        body: number,
        group: group.to_string(),
        reason: format!("has {} {} inside the body", S::WORDS.article, S::WORDS.facet),
    };
    for &edge in edges {
        let condition = body.facet_condition(edge).ok_or_else(fault)?;
        let point = body.mesh().facet_middle(edge);
        if norm(condition.reaction.components(body.mesh().facet_normal(edge))) > ALONG_FACET {
            return Err(InterfaceError::Occupied {
                body: number,
                point: point.into(),
                what: "an imposed displacement across it",
                words: S::WORDS,
            });
        }
        if condition.traction != S::ZEROS {
            return Err(InterfaceError::Occupied {
                body: number,
                point: point.into(),
                what: "a load",
                words: S::WORDS,
            });
        }
    }
    Ok(())
}

/// Creates the pairs of all stretches, and the arc length at each.
///
/// * `partners`: the second body's nodes, stretch by stretch.
fn make_pairs(bodies: [&Body; 2], chain: &[Stretch], partners: &[NodeId]) -> (Vec<NodePair>, Vec<f64>) {
    let mut pairs = Vec::with_capacity(partners.len());
    let mut arc_lengths = Vec::with_capacity(partners.len());
    let mut arc_length = 0.0;
    for stretch in chain {
        for (k, &node) in stretch.nodes.iter().enumerate() {
            if k > 0 {
                arc_length += bodies[0].mesh().facet_measure(stretch.edges[k - 1]);
            }
            pairs.push(NodePair {
                nodes: [node, partners[pairs.len()]],
                normal: Vector::zeros(),
                gap: 0.0,
                weight: 0.0,
            });
            arc_lengths.push(arc_length);
        }
        // The edge that closes the stretch has no further pair.
        if let Some(&edge) = stretch.edges.get(stretch.nodes.len() - 1) {
            arc_length += bodies[0].mesh().facet_measure(edge);
        }
    }
    (pairs, arc_lengths)
}

/// Evaluates a given gap at the first body's nodes.
pub(super) fn given_gap<S: Space>(
    points: &[S::Vector],
    pairs: &mut [NodePair<S>],
    data: &ScalarData<S>,
) -> Result<(), InterfaceError> {
    for pair in pairs {
        let point = points[pair.nodes[0]];
        let value = data.at(point);
        if !value.is_finite() {
            return Err(InterfaceError::BadGap { point: point.into(), value });
        }
        pair.gap = value * norm(pair.normal);
    }
    Ok(())
}

fn make_edges(
    bodies: [&Body; 2],
    surfaces: [&[FacetId]; 2],
    chain: &[Stretch],
    pairs: &[NodePair],
) -> Result<Vec<ContactFacet>, InterfaceError> {
    let mut edges = Vec::new();
    let mut first = 0;
    let mut seen = std::collections::HashSet::new();
    for stretch in chain {
        for (k, &edge) in stretch.edges.iter().enumerate() {
            let ends = [k, k + 1].map(|k| first + k % stretch.nodes.len());
            let [from, to] = ends.map(|k| pairs[k].nodes[1]);
            let found = bodies[1].mesh().topology().find_edge(from, to);
            let Some(other) = found.filter(|e| surfaces[1].binary_search(e).is_ok()) else {
                return Err(InterfaceError::FacetWithoutPartner {
                    words: Plane::WORDS,
                    body: 0,
                    point: bodies[0].mesh().facet_middle(edge).into(),
                });
            };
            if bodies[0].mesh().facet_normal(edge).dot(&bodies[1].mesh().facet_normal(other)) >= -0.5 {
                return Err(InterfaceError::NotFacing { point: bodies[0].mesh().facet_middle(edge).into() });
            }
            seen.insert(other);
            let length = bodies[0].mesh().facet_measure(edge);
            let pairs = ends.map(|k| k as u32);
            // The line decides which edges are bent once it is complete.
            edges.push(ContactFacet {
                pairs,
                facets: [edge, other],
                measure: length,
                bent: false,
                clamped: [None; 2],
            });
        }
        first += stretch.nodes.len();
    }
    match surfaces[1].iter().find(|e| !seen.contains(*e)) {
        Some(&edge) => Err(InterfaceError::FacetWithoutPartner {
            words: Plane::WORDS,
            body: 1,
            point: bodies[1].mesh().facet_middle(edge).into(),
        }),
        None => Ok(edges),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::block;

    fn body(y: f64, cells: [usize; 2], conditions: BoundaryConditions) -> Body {
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(block([0.0, y], [2.0, 1.0], cells).unwrap(), material, &conditions).unwrap()
    }

    fn no_gap() -> Gap {
        Gap::Given(0.0.into())
    }

    #[test]
    fn stacked_blocks_match() {
        let upper = body(1.0, [4, 2], BoundaryConditions::new().displace("left", Some(0.0.into()), None));
        let lower = body(0.0, [4, 3], BoundaryConditions::new().fix("bottom"));
        let interface = crate::pair(&upper, &lower, ["bottom", "top"], &no_gap()).unwrap();
        assert_eq!(interface.pairs().len(), 5);
        assert_eq!(interface.measure(), 2.0);
        assert!(interface.pairs().iter().all(|p| p.normal == Vector::new(0.0, -1.0)));
        assert_eq!(interface.arc_lengths()[4], 2.0);
        // Lumped and consistent mass agree on constants.
        let lengths: Vec<f64> = interface.pairs().iter().map(|p| p.weight).collect();
        assert_eq!(interface.mass(&[1.0; 5]), lengths);
    }

    /// Two whole rings side by side, as one body.
    fn two_rings(radii: [f64; 2], surface: &str) -> Body {
        let (mut points, mut cells, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for x in [0.0, 9.0] {
            let mesh = fem_core::mesh::generate::ring([x, 0.0], radii, [0.0, 360.0], [12, 1]).unwrap();
            let first = points.len();
            points.extend_from_slice(mesh.points());
            cells.extend(mesh.cells().iter().map(|t| t.map(|n| NodeId::new(n.index() + first))));
            let ends = |e: &fem_core::mesh::id::FacetId| {
                mesh.topology().facets()[*e].map(|n| NodeId::new(n.index() + first))
            };
            edges.extend(mesh.group(surface).unwrap().iter().map(ends));
        }
        let mesh = fem_core::mesh::TriMesh::new(points, cells, vec![(surface.into(), edges)]).unwrap();
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
    }

    #[test]
    fn the_arc_length_goes_on_past_the_edge_that_closes_a_line() {
        let bodies = [two_rings([1.0, 1.5], "inner"), two_rings([0.5, 1.0], "outer")];
        let interface = crate::pair(&bodies[0], &bodies[1], ["inner", "outer"], &no_gap()).unwrap();
        let places = interface.arc_lengths();
        let edge = 2.0 * 15.0f64.to_radians().sin();
        for (k, s) in places.iter().enumerate() {
            assert!((s - k as f64 * edge).abs() < 1e-13, "{k} {s}");
        }
        assert_eq!(places.len(), 24);
    }

    #[test]
    fn what_cannot_be_paired_is_refused() {
        let fixed = || BoundaryConditions::new().fix("bottom");
        let upper = body(1.0, [4, 2], BoundaryConditions::new());
        let pair = |a: &Body, b: &Body, s| crate::pair(a, b, s, &no_gap()).unwrap_err();
        let finer = body(0.0, [5, 2], fixed());
        assert!(matches!(pair(&upper, &finer, ["bottom", "top"]), InterfaceError::NotMatching { .. }));
        let lower = body(0.0, [4, 2], fixed());
        assert!(matches!(
            pair(&upper, &lower, ["bottm", "top"]),
            InterfaceError::UnknownSurface { body: 0, .. }
        ));
        let far = body(-0.2, [4, 2], fixed());
        assert!(matches!(pair(&upper, &far, ["bottom", "top"]), InterfaceError::NotMatching { .. }));
        let loaded = body(0.0, [4, 2], fixed().pressure("top", 1.0));
        assert!(matches!(pair(&upper, &loaded, ["bottom", "top"]), InterfaceError::Occupied { body: 1, .. }));
        let held = body(0.0, [4, 2], fixed().displace("left", None, Some(0.0.into())));
        // Along the normal.
        assert!(matches!(pair(&upper, &held, ["bottom", "top"]), InterfaceError::SupportedNode { .. }));
        let same = body(1.0, [4, 2], fixed());
        assert!(matches!(pair(&upper, &same, ["left", "left"]), InterfaceError::NotFacing { .. }));
        let with = |gap: f64| crate::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(gap.into()));
        assert!(matches!(with(f64::NAN), Err(InterfaceError::BadGap { .. })));
        // Both blocks are 1 m thick.
        assert!(with(-0.9).is_ok());
        let deep = with(-1.1).unwrap_err();
        assert!(matches!(deep, InterfaceError::TooDeep { depth, .. } if (depth - 1.1).abs() < 1e-15));
    }
}

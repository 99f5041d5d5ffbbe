//! Meshes whose nodes move onto declared curves.

use contact_geometry::common_refinement::common_refinement;
use contact_geometry::{ContactNormal, RefinedProblem};
use fem_core::body::{Body, BodyError, CurveKind, CurvedSide};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, cross, norm};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::ring;
use fem_core::mesh::id::NodeId;
use fem_core::mesh::refine::RefinementEdges;

fn side(on: &str, kind: CurveKind) -> CurvedSide {
    CurvedSide { on: on.into(), kind }
}

fn body(mesh: TriMesh, sides: &[CurvedSide]) -> Result<Body, BodyError> {
    let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(mesh, steel, &BoundaryConditions::new()).unwrap().with_curves(sides)
}

/// A ring with both radii declared.
fn curved_ring(centre: [f64; 2], radii: [f64; 2], cells: [usize; 2], kind: CurveKind) -> Body {
    let mesh = ring(centre, radii, [0.0, 360.0], cells).unwrap();
    body(mesh, &[side("inner", kind), side("outer", kind)]).unwrap()
}

/// Halves all edges, several times.
fn refined(mut problem: ContactProblem, times: usize) -> ContactProblem {
    let mut edges: Vec<RefinementEdges> =
        problem.bodies.iter().map(|b| RefinementEdges::longest(b.mesh())).collect();
    for _ in 0..times {
        let all: Vec<Vec<bool>> =
            problem.bodies.iter().map(|b| vec![true; b.mesh().topology().facets().len()]).collect();
        let RefinedProblem { problem: finer, refinements, .. } =
            contact_geometry::refined(&problem, &edges, &all).unwrap();
        edges = refinements.into_iter().map(|r| r.refinement_edges).collect();
        problem = finer;
    }
    problem
}

fn nodes_of(body: &Body, group: &str) -> Vec<Vector> {
    let mesh = body.mesh();
    let ends = mesh.group(group).unwrap().iter().flat_map(|e| mesh.facet_corners(*e));
    ends.collect()
}

#[test]
fn new_nodes_lie_on_the_circle_and_old_ones_stay() {
    for kind in [CurveKind::Arc, CurveKind::Smooth] {
        let coarse = curved_ring([3.0, -1.0], [1.0, 2.0], [12, 2], kind);
        let fine = refined(ContactProblem::new(vec![coarse.clone()]), 3).bodies.remove(0);
        assert_eq!(fine.mesh().points()[..coarse.mesh().points().len()], *coarse.mesh().points());
        assert!(fine.nodes_on_chords().is_empty());
        for (group, radius) in [("inner", 1.0), ("outer", 2.0)] {
            assert_eq!(fine.mesh().group(group).unwrap().len(), 96);
            for p in nodes_of(&fine, group) {
                let off = norm(p - Vector::new(3.0, -1.0)) - radius;
                assert!(off.abs() < 4e-15, "{kind:?} {group}: {off:e}");
            }
        }
        let area: f64 = (0..fine.mesh().cells().len()).map(|t| fine.mesh().measure(t)).sum();
        // Polygons of 96 edges: equal ones on an arc, nearly so on a smooth curve.
        let turn = std::f64::consts::TAU / 96.0;
        let tolerance = if kind == CurveKind::Arc { 1e-12 } else { 1e-4 };
        assert!((area - 48.0 * turn.sin() * 3.0).abs() < tolerance, "{kind:?} {area}");
    }
}

#[test]
fn a_side_that_is_no_arc_is_refused() {
    let mesh = || ring([0.0; 2], [1.0, 2.0], [0.0, 90.0], [6, 2]).unwrap();
    let arc = |mesh: TriMesh, on: &str| body(mesh, &[side(on, CurveKind::Arc)]).map(|_| ()).unwrap_err();
    assert!(matches!(arc(mesh(), "start"), BodyError::NoArc { edges: 2, .. }));
    assert!(matches!(arc(mesh(), "rim"), BodyError::UnknownGroup { .. }));
    let twice = [side("inner", CurveKind::Arc), side("inner", CurveKind::Smooth)];
    assert!(matches!(body(mesh(), &twice), Err(BodyError::CurvedTwice { .. })));
    for (off, refused) in [(0.9e-6, false), (1.1e-6, true)] {
        let mesh = mesh();
        let moved = |p: &Vector| {
            let at_60 = (p[1].atan2(p[0]).to_degrees() - 60.0).abs() < 1e-9 && norm(*p) < 1.1;
            if at_60 { (1.0 + off) * p } else { *p }
        };
        let points: Vec<Vector> = mesh.points().iter().map(moved).collect();
        let edges = |group: &str| {
            let all = mesh.group(group).unwrap().iter();
            (group.to_owned(), all.map(|e| mesh.topology().facets()[*e]).collect::<Vec<_>>())
        };
        let moved = TriMesh::new(points, mesh.cells().to_vec(), vec![edges("inner")]).unwrap();
        match body(moved, &[side("inner", CurveKind::Arc)]) {
            Err(BodyError::OffArc { point, distance, radius, centre, .. }) if refused => {
                assert!(
                    (distance - off).abs() < 1e-12 && (radius - 1.0).abs() < 1e-12,
                    "{distance} {radius}"
                );
                assert!(centre[0].hypot(centre[1]) < 1e-12 && (point[0] - 0.5).abs() < 1e-5, "{point}");
            }
            Ok(_) if !refused => {}
            other => panic!("{off}: {other:?}"),
        }
    }
}

#[test]
fn a_node_whose_cell_would_turn_over_stays_on_the_chord() {
    // Cells of 0.02 at the side of a hole whose arc is 0.034 above its chords.
    let mesh = ring([0.0; 2], [1.0, 1.02], [0.0, 360.0], [12, 1]).unwrap();
    let inner = body(mesh, &[side("inner", CurveKind::Arc)]).unwrap();
    let fine = refined(ContactProblem::new(vec![inner]), 1).bodies.remove(0);
    assert_eq!(fine.nodes_on_chords().len(), 12);
    for node in fine.nodes_on_chords() {
        let off = norm(fine.mesh().points()[*node]) - 15f64.to_radians().cos();
        assert!(off.abs() < 1e-15, "{off:e}");
    }
    assert!((0..fine.mesh().cells().len()).all(|t| fine.mesh().measure(t) > 0.0));
    // Larger cells have room for the arc.
    let large = curved_ring([0.0; 2], [1.0, 1.2], [12, 1], CurveKind::Arc);
    let fine = refined(ContactProblem::new(vec![large]), 2).bodies.remove(0);
    assert!(fine.nodes_on_chords().is_empty(), "{}", fine.nodes_on_chords().len());
}

#[test]
fn nodes_of_a_smooth_curve_approach_an_ellipse_by_the_third_power_and_keep_corners() {
    // The largest distance from the ellipse x²/4 + y² = 1, to first order.
    let off = |cells: usize| {
        let mesh = ring([0.0; 2], [1.0, 2.0], [0.0, 360.0], [cells, 2]).unwrap();
        let points: Vec<Vector> = mesh.points().iter().map(|p| Vector::new(2.0 * p[0], p[1])).collect();
        let all = mesh.group("inner").unwrap().iter();
        let edges = all.map(|e| mesh.topology().facets()[*e]).collect();
        let mesh = TriMesh::new(points, mesh.cells().to_vec(), vec![("hole".into(), edges)]).unwrap();
        let curved = body(mesh, &[side("hole", CurveKind::Smooth)]).unwrap();
        let fine = refined(ContactProblem::new(vec![curved]), 2).bodies.remove(0);
        let distance = |p: Vector| {
            let f = p[0] * p[0] / 4.0 + p[1] * p[1] - 1.0;
            (f / norm(Vector::new(p[0] / 2.0, 2.0 * p[1]))).abs()
        };
        nodes_of(&fine, "hole").into_iter().map(distance).fold(0.0, f64::max)
    };
    let [coarse, fine] = [off(24), off(48)];
    // The chords of 24 edges are off by 1e-2.
    assert!(coarse < 1.5e-3 && coarse / fine > 7.0, "{coarse:e} {fine:e}");
    let square = fem_core::mesh::generate::block([0.0; 2], [1.0; 2], [2, 2]).unwrap();
    let mut square = square;
    let all = square.topology().boundary_facets().to_vec();
    square.add_group("all", all);
    let fine =
        refined(ContactProblem::new(vec![body(square, &[side("all", CurveKind::Smooth)]).unwrap()]), 2);
    for p in nodes_of(&fine.bodies[0], "all") {
        assert!(p.iter().any(|x| *x == 0.0 || *x == 1.0), "{p}");
    }
}

#[test]
fn a_closed_smooth_side_keeps_its_only_corner() {
    // A drop: a circle of 270 degrees and two straight sides that meet at a right angle.
    let angles = (0..=18).map(|k| (f64::from(k) * 15.0 - 45.0).to_radians());
    let mut outline: Vec<Vector> = angles.map(|a| Vector::new(a.cos(), a.sin())).collect();
    let (from, to, tip) = (outline[18], outline[0], Vector::new(0.0, -2f64.sqrt()));
    let between = |a: Vector, b: Vector| (1..4).map(move |k| a + f64::from(k) / 4.0 * (b - a));
    outline.extend(between(from, tip).chain([tip]).chain(between(tip, to)));
    let count = outline.len();
    let mut points = outline;
    points.push(Vector::zeros());
    let node = NodeId::new;
    let triangles = (0..count).map(|k| [node(count), node(k), node((k + 1) % count)]).collect();
    let edges = (0..count).map(|k| [node(k), node((k + 1) % count)]).collect();
    let mesh = TriMesh::new(points, triangles, vec![("rim".into(), edges)]).unwrap();
    let drop = body(mesh, &[side("rim", CurveKind::Smooth)]).unwrap();
    let fine = refined(ContactProblem::new(vec![drop]), 2).bodies.remove(0);
    // The edges that meet at the tip are straight.
    for p in nodes_of(&fine, "rim").into_iter().filter(|p| p[1] < -1.1) {
        assert!((p[1] + 2f64.sqrt() - p[0].abs()).abs() < 1e-12, "{p}");
    }
}

#[test]
fn polygons_that_seem_to_be_curves_are_listed_unless_they_are_declared() {
    let mesh = || ring([0.0; 2], [1.0, 2.0], [0.0, 90.0], [6, 2]).unwrap();
    // The edges at the ends of an arc turn at one end only.
    assert_eq!(body(mesh(), &[]).unwrap().undeclared_curves().len(), 8);
    assert_eq!(body(mesh(), &[side("inner", CurveKind::Arc)]).unwrap().undeclared_curves().len(), 4);
    // A hexagon is one.
    let hexagon = ring([0.0; 2], [1.0, 2.0], [0.0, 360.0], [6, 2]).unwrap();
    assert!(body(hexagon, &[]).unwrap().undeclared_curves().is_empty());
}

/// A pin in a hole, and the contact line between them.
fn pin(centre: [f64; 2], radii: [f64; 2], cells: [usize; 2], kind: CurveKind) -> ContactProblem {
    let pin = curved_ring(centre, [0.5, radii[0]], [cells[0], 2], kind);
    let hole = curved_ring([0.0; 2], [radii[1], 2.0], [cells[1], 2], kind);
    let interface = |bodies: [&Body; 2]| {
        contact_geometry::pair(bodies[0], bodies[1], ["outer", "inner"], &Gap::Geometric)
    };
    if cells[0] == cells[1] && centre == [0.0; 2] {
        let interface = interface([&pin, &hole]).unwrap();
        return ContactProblem::between([pin, hole], interface);
    }
    let sides = ["outer", "inner"];
    let common = common_refinement([pin, hole], sides, ContactNormal::Averaged).unwrap();
    let interface =
        contact_geometry::pair_refined(&common, sides, &Gap::Geometric, ContactNormal::Averaged).unwrap();
    ContactProblem::between(common.bodies, interface)
}

#[test]
fn pairs_on_two_curves_face_each_other_and_their_gap_is_that_of_the_circles() {
    let cases = [
        ([0.0; 2], [0.99, 1.0], [24, 24], CurveKind::Arc),
        ([0.0; 2], [0.99, 1.0], [20, 33], CurveKind::Arc),
        ([0.004, -0.003], [0.99, 1.0], [24, 24], CurveKind::Arc),
        ([0.004, -0.003], [0.99, 1.0], [36, 25], CurveKind::Arc),
        ([0.0; 2], [0.99, 1.0], [24, 24], CurveKind::Smooth),
        ([0.004, -0.003], [0.99, 1.0], [36, 25], CurveKind::Smooth),
    ];
    for (centre, radii, cells, kind) in cases {
        let fine = refined(pin(centre, radii, cells, kind), 3);
        let pair = &fine.contacts[0].interface;
        let points = [0, 1].map(|b| fine.bodies[b].mesh().points());
        assert!(pair.pairs().len() >= 160);
        for p in pair.pairs() {
            let [on_pin, in_hole] = [0, 1].map(|b| points[b][p.nodes[b]]);
            assert!((norm(on_pin - Vector::from(centre)) - radii[0]).abs() < 1e-12, "{cells:?} {on_pin}");
            assert!((norm(in_hole) - radii[1]).abs() < 1e-12, "{cells:?} {in_hole}");
            let apart = in_hole - on_pin;
            // From the pin's node along the normal to the hole's circle.
            assert!((apart.dot(&p.normal) - p.gap).abs() < 1e-12, "{cells:?} {apart} {}", p.gap);
            assert!(cross(apart, p.normal).abs() < 1e-12, "{cells:?} {:e}", cross(apart, p.normal));
        }
        let length: f64 = pair.facets().iter().map(|e| e.measure).sum();
        let last = pair.arc_lengths().last().unwrap();
        assert!((length - std::f64::consts::TAU * radii[0]).abs() < 2e-3 && *last < length);
        let closing = pair.facets().iter().find(|e| e.pairs[1] < e.pairs[0]).unwrap();
        assert!((last + closing.measure - length).abs() < 1e-12);
    }
}

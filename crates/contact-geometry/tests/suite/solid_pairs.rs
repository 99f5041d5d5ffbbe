//! Flat contact surfaces of solids: pairs, areas, and what is refused.

use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactInterface, ContactProblem, Gap, InterfaceError, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::space::Solid;
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

type Vector = Vector3<f64>;
type Conditions = BoundaryConditions<Solid>;
type Result = std::result::Result<ContactInterface<Solid>, InterfaceError>;

/// Moves the nodes of a box on `z ≤ 1 ≤ z + 1` of 4 × 3 × 2 cells.
fn body(z: f64, conditions: &Conditions, to: impl Fn(Vector) -> Vector) -> Body<Solid> {
    cells(z, [4, 3, 2], conditions, to)
}

fn cells(z: f64, cells: [usize; 3], conditions: &Conditions, to: impl Fn(Vector) -> Vector) -> Body<Solid> {
    let mesh: TetMesh = cuboid([0.0, 0.0, z], [2.0, 1.5, 1.0], cells).unwrap();
    let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
    let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
    let points = mesh.points().iter().map(|x| to(*x)).collect();
    let mesh = Mesh::new(points, mesh.cells().to_vec(), groups).unwrap();
    Body::new(mesh, LinearElastic::isotropic_solid(10.0, 0.3).unwrap(), conditions).unwrap()
}

fn free() -> Conditions {
    Conditions::default()
}

fn pair(upper: &Body<Solid>, lower: &Body<Solid>, gap: &Gap<Solid>) -> Result {
    contact_geometry::pair_solids(upper, lower, ["bottom", "top"], gap)
}

fn given(gap: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> Gap<Solid> {
    Gap::Given(ScalarData::Function(Arc::new(gap)))
}

#[test]
fn tilted_surfaces_are_paired_with_one_normal_and_exact_areas() {
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let shift = Vector::new(3.0, -2.0, 0.5);
    let [upper, lower] = [1.0, 0.0].map(|z| body(z, &free(), |x| turn * x + shift));
    let interface = pair(&upper, &lower, &Gap::Touching).unwrap();
    assert_eq!((interface.pairs().len(), interface.facets().len()), (20, 24));
    assert!((interface.measure() - 3.0).abs() < 1e-14);
    let down = turn * -Vector::z();
    for pair in interface.pairs() {
        assert!((pair.normal - down).norm() < 1e-14 && pair.gap == 0.0);
        let [a, b] = [(0, &upper), (1, &lower)].map(|(b, body)| body.mesh().points()[pair.nodes[b]]);
        assert!((a - b).norm() < 1e-14);
    }
    // Lumped and consistent mass agree on constants, and a linear pressure has the right moment.
    let weights: Vec<f64> = interface.pairs().iter().map(|pair| pair.weight).collect();
    for (mass, weight) in interface.mass(&[1.0; 20]).iter().zip(&weights) {
        assert!((mass - weight).abs() < 1e-15);
    }
    let along: Vec<f64> = interface
        .pairs()
        .iter()
        .map(|pair| (turn.inverse() * (upper.mesh().points()[pair.nodes[0]] - shift))[0])
        .collect();
    let moment: f64 = interface.mass(&along).iter().zip(&along).map(|(m, x)| m * x).sum();
    // ∫ x² over 2 × 1.5.
    assert!((moment - 1.5 * 8.0 / 3.0).abs() < 1e-13, "{moment}");
    let pressures: Vec<[f64; 3]> = interface.facets().iter().map(|f| interface.pressure(f, &along)).collect();
    let force: Vector = interface.pressure_forces(&pressures).iter().sum();
    assert!((force - 3.0 * down).norm() < 1e-13, "{force}");
}

#[test]
fn gaps_are_given_or_measured() {
    let lower = body(0.0, &free(), |x| x);
    let apart = body(1.25, &free(), |x| x);
    let measured = pair(&apart, &lower, &Gap::Geometric).unwrap();
    assert!(measured.pairs().iter().all(|pair| pair.gap == 0.25));
    assert!(measured.gap_change().is_none());
    // A wedge: linear along the surface, and both sides are flat.
    let wedge = body(1.0, &free(), |x| x + Vector::z() * (0.1 * x[0]));
    let flat = contact_geometry::pair_solids(&lower, &wedge, ["top", "bottom"], &Gap::Geometric).unwrap();
    for pair in flat.pairs() {
        assert!((pair.gap - 0.1 * lower.mesh().points()[pair.nodes[0]][0]).abs() < 1e-15);
    }
    let upper = body(1.0, &free(), |x| x);
    let used = pair(&upper, &lower, &given(|x| 0.01 * x[1])).unwrap();
    let change = used.gap_change().unwrap();
    assert_eq!((change.drawn, change.used), (0.0, 0.015));
}

#[test]
fn normals_of_bent_surfaces_are_means_and_one_flat_surface_gives_its_own() {
    let height = |x: Vector| 0.1 * x[0] * x[0];
    let bend = move |x: Vector| x + Vector::z() * height(x);
    let held = free().roller("front", 0.0).roller("back", 0.0);
    let [upper, lower] = [1.0, 0.0].map(|z| body(z, &held, bend));
    let interface = pair(&upper, &lower, &Gap::Touching).unwrap();
    assert!(interface.has_bent_facets() && interface.pairs().iter().all(|pair| pair.gap == 0.0));
    for pair in interface.pairs() {
        // Faces are 0.5 wide and rise by 0.1 (2 x + 0.5) from x on; one or two thirds of those at a node are on one side of it.
        let (x, normal) = (upper.mesh().points()[pair.nodes[0]][0], pair.normal);
        let slope = if x == 0.0 {
            0.05
        } else if x == 2.0 {
            0.35
        } else {
            0.2 * x
        };
        assert!((normal.norm() - 1.0).abs() < 1e-14 && normal[1].abs() < 1e-14, "{normal}");
        assert!((normal[0] / normal[2] + slope).abs() < 0.05 / 3.0 + 1e-14, "{normal} at {x}");
    }
    // On a flat surface the bent one is a gap.
    let flat = body(0.0, &free(), |x| x);
    for (first, second) in [(&upper, &flat), (&flat, &upper)] {
        let names = if std::ptr::eq(first, &upper) { ["bottom", "top"] } else { ["top", "bottom"] };
        let found = contact_geometry::pair_solids(first, second, names, &Gap::Geometric).unwrap();
        assert!(!found.has_bent_facets());
        for pair in found.pairs() {
            let point = first.mesh().points()[pair.nodes[0]];
            assert!((pair.gap - height(point)).abs() < 1e-14 && pair.normal[2].abs() == 1.0, "{pair:?}");
        }
    }
}

#[test]
fn surfaces_that_are_folded_or_do_not_match_are_refused() {
    let (upper, lower) = (body(1.0, &free(), |x| x), body(0.0, &free(), |x| x));
    let refused = |upper: &Body<Solid>, lower: &Body<Solid>, gap: &Gap<Solid>| {
        let error = pair(upper, lower, gap).unwrap_err();
        (error.to_string(), error)
    };
    // A surface that is folded at x = 1, by more than 60 degrees.
    let folded = |x: Vector| x + Vector::z() * (0.8 * (x[0] - 1.0).abs() * x[2].min(2.0 - x[2]));
    let [above, below] = [1.0, 0.0].map(|z| body(z, &free(), folded));
    let (said, error) = refused(&above, &below, &Gap::Touching);
    assert!(matches!(error, InterfaceError::CoarseFace { .. }), "{said}");
    assert!(said.contains("the contact normal turns by 77 degrees at the face"), "{said}");
    let finer = cells(0.0, [5, 3, 2], &free(), |x| x);
    assert!(matches!(refused(&upper, &finer, &Gap::Touching).1, InterfaceError::NotMatching { .. }));
    // The same nodes, joined by the other diagonals.
    let mirrored = body(0.0, &free(), |x| Vector::new(2.0 - x[0], x[1], x[2]));
    let (said, error) = refused(&upper, &mirrored, &Gap::Touching);
    assert!(matches!(error, InterfaceError::FacetWithoutPartner { body: 0, .. }), "{said}");
    assert!(said.contains("the contact face of body 0"), "{said}");
    let far = body(-0.2, &free(), |x| x);
    assert!(matches!(refused(&upper, &far, &given(|_| 0.0)).1, InterfaceError::NotMatching { .. }));
    let near = body(-0.005, &free(), |x| x);
    assert!(matches!(refused(&upper, &near, &Gap::Touching).1, InterfaceError::NotTouching { .. }));
    let into = body(0.005, &free(), |x| x);
    assert!(matches!(refused(&upper, &into, &Gap::Geometric).1, InterfaceError::Overlap { .. }));
    let beside = body(0.0, &free(), |x| x + Vector::x() * 1e-3);
    assert!(matches!(refused(&upper, &beside, &Gap::Touching).1, InterfaceError::Offset { .. }));
    let same = contact_geometry::pair_solids(&upper, &upper, ["top", "top"], &Gap::Touching);
    assert!(matches!(same, Err(InterfaceError::NotFacing { .. })));
    assert!(matches!(refused(&upper, &lower, &given(|_| f64::NAN)).1, InterfaceError::BadGap { .. }));
    assert!(matches!(refused(&upper, &lower, &given(|_| -5.0)).1, InterfaceError::TooDeep { .. }));
}

#[test]
fn surfaces_that_are_held_or_loaded_are_refused_in_the_words_of_solids() {
    let upper = body(1.0, &free(), |x| x);
    let against = |conditions: &Conditions| pair(&upper, &body(0.0, conditions, |x| x), &Gap::Touching);
    let said = |conditions: &Conditions| against(conditions).unwrap_err().to_string();
    assert!(said(&free().pressure("top", 1.0)).contains("the contact face of body 1"));
    assert!(said(&free().roller("top", 0.0)).contains("has an imposed displacement"));
    // Along the normal at the nodes of one edge; across it, or with another body that can move, nothing is wrong.
    let held = free().components("left", [None, None, Some(0.0.into())]);
    assert!(said(&held).contains("is held by a support along the contact normal"));
    against(&free().roller("left", 0.0).roller("front", 0.0)).unwrap();
    against(&free().fix("left")).unwrap();
    let unknown = contact_geometry::pair_solids(&upper, &upper, ["lid", "top"], &Gap::Touching).unwrap_err();
    assert!(unknown.to_string().contains("no face group \"lid\""), "{unknown}");
}

/// Nodes on x = 0 move alike in both bodies, or apart; the surfaces bulge, and the normals turn.
#[test]
fn pairs_that_both_bodies_clamp_are_removed_if_their_supports_do_not_press() {
    let bulge = |x: Vector| x - Vector::z() * (0.2 * (1.0 - (x[2] - 1.0).abs()) * x[1] * x[1]);
    let moved = |z: f64, by: [f64; 3], to: &dyn Fn(Vector) -> Vector| {
        body(z, &free().components("left", by.map(|u| Some(u.into()))), to)
    };
    let paired = |by: [f64; 3], to: &dyn Fn(Vector) -> Vector| {
        pair(&moved(1.0, [0.0; 3], to), &moved(0.0, by, to), &Gap::Touching)
    };
    for (to, bent) in [(&bulge as &dyn Fn(Vector) -> Vector, true), (&|x| x, false)] {
        for apart in [0.0, 0.3] {
            let found = paired([0.0, 0.0, -apart], to).unwrap();
            assert_eq!((found.pairs().len(), found.clamped().len(), found.facets().len()), (16, 4, 24));
            assert_eq!((found.has_bent_facets(), found.is_whole()), (bent, false));
            let weights: f64 = found.pairs().iter().map(|pair| pair.weight).sum();
            let corners = found.facets().iter().map(|face| face.measure * face.free_corners().count() as f64);
            assert!((weights - corners.sum::<f64>() / 3.0).abs() < 1e-14);
            let by_pair: Vec<f64> = (0..16).map(f64::from).collect();
            for face in found.facets() {
                for corner in 0..3 {
                    let pair = found.corner_pair(face, corner);
                    let [a, b, c] = upper_corners(&moved(1.0, [0.0; 3], to), face.facets[0]);
                    assert!([a, b, c].contains(&pair.nodes[0]));
                    if let Some(clamped) = face.clamped[corner] {
                        let opening = -apart * pair.normal[2];
                        assert!((clamped.opening - opening).abs() < 1e-15 && clamped.jump[2] == apart);
                        let around = &found.clamped()[clamped.number as usize].around;
                        let mean = around.iter().map(|k| f64::from(*k)).sum::<f64>() / around.len() as f64;
                        assert!((1..=4).contains(&around.len()));
                        assert!((found.corners(face, &by_pair)[corner] - mean).abs() < 1e-14);
                    }
                }
            }
        }
        let pressed = paired([0.0, 0.0, 0.3], to);
        assert!(matches!(pressed, Err(InterfaceError::ClampedOverlap { depth, .. }) if depth > 0.2));
    }
    // Along the surface: it opens at the nodes where y = 0, and not where the surface rises.
    assert!(paired([0.0, -0.1, 0.0], &|x| x).is_ok());
    let along = paired([0.0, -0.1, 0.0], &bulge).and(paired([0.0, 0.1, 0.0], &bulge));
    assert!(matches!(along, Err(InterfaceError::ClampedOverlap { .. })), "{along:?}");
    // Everything is clamped.
    let all = |z: f64| body(z, &free().fix("left").fix("right").fix("front").fix("back"), |x| x);
    let few = |z: f64| cells(z, [1, 1, 2], &free().fix("left").fix("right"), |x| x);
    assert_eq!(pair(&all(1.0), &all(0.0), &Gap::Touching).unwrap().pairs().len(), 6);
    let none = pair(&few(1.0), &few(0.0), &Gap::Touching);
    assert!(matches!(none, Err(InterfaceError::HeldNode { .. })), "{none:?}");
}

fn upper_corners(body: &Body<Solid>, face: FacetId) -> [NodeId; 3] {
    body.mesh().topology().facets()[face]
}

#[test]
fn a_side_is_paired_with_a_plane() {
    // A side that bulges to the plane: linear between its nodes, with their distances as gaps.
    let body = body(0.0, &free(), |x| x - Vector::z() * (0.1 * x[0] * (2.0 - x[0]) * (1.0 - x[2])));
    let plane = RigidLine::Plane { point: Vector::new(0.0, 0.0, -0.1), normal: Vector::new(0.0, 0.0, 3.0) };
    let plane = Obstacle::fixed(plane);
    let interface = contact_geometry::solid_against(&body, "bottom", &plane, None).unwrap();
    for pair in interface.pairs() {
        let point = body.mesh().points()[pair.nodes[0]];
        assert!((pair.gap - point[2] - 0.1).abs() < 1e-15 && pair.normal == -Vector::z());
    }
    assert!(interface.measure() > 3.0);
    let refused = |surface: &str, line: RigidLine<Solid>| {
        contact_geometry::solid_against(&body, surface, &Obstacle::fixed(line), None).unwrap_err()
    };
    assert!(matches!(refused("left", plane.line), InterfaceError::NotFacing { .. }));
    let high = RigidLine::Plane { point: Vector::zeros(), normal: Vector::z() };
    let deepest = refused("bottom", high);
    assert!(matches!(deepest, InterfaceError::Overlap { depth, .. } if (depth - 0.1).abs() < 1e-15));
}

#[test]
fn normals_against_round_obstacles_are_arms_over_the_radius_and_gaps_are_distances() {
    let body = body(0.0, &free(), |x| x);
    let (centre, radius) = (Vector::new(1.0, 0.5, -3.0), 2.5);
    let sphere = |inside| RigidLine::Circle { centre, radius, inside };
    let axis = Vector::new(0.0, 3.0, 0.0);
    let cylinder = |inside| RigidLine::Cylinder { point: centre, axis, radius, inside };
    // Above the obstacle, and below the top of a hollow.
    for (side, inside, radius) in [("bottom", false, 2.5), ("top", true, 5.0)] {
        let round = |line: RigidLine<Solid>| match line {
            RigidLine::Circle { centre, inside, .. } => RigidLine::Circle { centre, radius, inside },
            RigidLine::Cylinder { point, axis, inside, .. } => {
                RigidLine::Cylinder { point, axis, radius, inside }
            }
            line => line,
        };
        for line in [round(sphere(inside)), round(cylinder(inside))] {
            let obstacle = Obstacle::fixed(line);
            let found = contact_geometry::solid_against(&body, side, &obstacle, None).unwrap();
            for pair in found.pairs() {
                let mut arm = body.mesh().points()[pair.nodes[0]] - centre;
                if let RigidLine::Cylinder { .. } = line {
                    arm[1] = 0.0;
                }
                let sign = if inside { 1.0 } else { -1.0 };
                assert!((pair.normal - arm * (sign / radius)).norm() < 1e-15, "{pair:?}");
                let distance = sign * (radius - arm.norm());
                assert!((pair.gap - distance * pair.normal_length()).abs() < 1e-14, "{pair:?}");
            }
            assert!(found.has_bent_facets());
            let problem = ContactProblem::new(vec![body.clone()]).obstacle(0, found, obstacle);
            let gap = problem.interpolated_solid_gaps()[0].unwrap();
            assert!(gap.largest > 1e-3 && gap.largest < 0.2, "{gap:?}");
            let interface = &problem.contacts[0].interface;
            // Rotations about the centre open nothing, neither at the nodes nor between them.
            for spin in [Vector::x(), Vector::y(), Vector::z()] {
                let spin = if let RigidLine::Cylinder { .. } = line { Vector::y() } else { spin };
                let turned =
                    |k: usize| spin.cross(&(body.mesh().points()[interface.pairs()[k].nodes[0]] - centre));
                let still = interface.middle_openings(|_| Vector::zeros());
                for (still, turned) in still.iter().zip(interface.middle_openings(turned)) {
                    assert!((still - turned).abs() < 1e-14, "{still} {turned}");
                }
            }
        }
    }
    let refused =
        |line| contact_geometry::solid_against(&body, "bottom", &Obstacle::fixed(line), None).unwrap_err();
    let small = RigidLine::Circle { centre: Vector::new(1.2, 0.6, -0.11), radius: 0.1, inside: false };
    assert!(matches!(refused(small), InterfaceError::CoarseFace { degrees, .. } if degrees > 60.0));
    assert!(matches!(refused(sphere(true)), InterfaceError::NotFacing { .. }));
    let deep = RigidLine::Circle { centre, radius: 3.25, inside: false };
    assert!(matches!(refused(deep), InterfaceError::Overlap { depth, .. } if (depth - 0.25).abs() < 1e-12));
}

#[test]
fn the_area_in_contact_lies_between_two_numbers() {
    let [upper, lower] = [1.0, 0.0].map(|z| body(z, &free(), |x| x));
    let interface = pair(&upper, &lower, &Gap::Touching).unwrap();
    let area = |closed: &dyn Fn(Vector) -> bool| {
        let found = interface.contact_area(|k| closed(upper.mesh().points()[interface.pairs()[k].nodes[0]]));
        [found.inner, found.outer, found.patches.len() as f64]
    };
    // Cells of 0.5 × 0.5, each cut from its lowest to its highest corner.
    assert_eq!(area(&|_| true), [3.0, 3.0, 1.0]);
    assert_eq!(area(&|_| false), [0.0; 3]);
    assert_eq!(area(&|x| x[0] < 0.6), [0.75, 1.5, 1.0]);
    // Two strips at the ends, which the open column between them divides.
    assert_eq!(area(&|x| (x[0] - 1.0).abs() > 0.4), [1.5, 3.0, 2.0]);
    // One node inside has six triangles around it, the two corners of the side that no diagonal meets one, the others two.
    assert_eq!(area(&|x| x[0] == 0.5 && x[1] == 0.5), [0.0, 0.75, 1.0]);
    assert_eq!(area(&|x| x[0] == 2.0 && x[1] == 0.0), [0.0, 0.125, 1.0]);
    assert_eq!(area(&|x| x[0] == 0.0 && x[1] == 0.0), [0.0, 0.25, 1.0]);
}

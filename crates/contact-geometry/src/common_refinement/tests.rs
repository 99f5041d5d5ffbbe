use super::*;
use crate::ContactNormal;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::norm;
use fem_core::interface::{ContactInterface, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::block;
use fem_core::mesh::id::FacetId;

fn body(origin: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Body {
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block(origin, size, cells).unwrap(), material, &BoundaryConditions::new()).unwrap()
}

fn common_refinement(
    bodies: [Body; 2],
    surfaces: [&str; 2],
) -> Result<CommonRefinement, CommonRefinementError> {
    super::common_refinement(bodies, surfaces, ContactNormal::Averaged)
}

fn pair(bodies: &[Body; 2]) -> ContactInterface {
    crate::pair(&bodies[0], &bodies[1], ["bottom", "top"], &Gap::Given(0.0.into())).unwrap()
}

fn area(body: &Body) -> f64 {
    (0..body.mesh().cells().len()).map(|t| body.mesh().measure(t)).sum()
}

#[test]
fn blocks_of_any_ratio_match() {
    for (m, n) in [(2, 3), (6, 7), (17, 40), (16, 23), (8, 31), (3, 200), (1, 400)] {
        let upper = body([0.0, 1.0], [2.0, 1.0], [m, (m / 2).max(1)]);
        let lower = body([0.0, 0.0], [2.0, 1.0], [n, (n / 2).min(20)]);
        let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
        let interface = pair(&common.bodies);
        assert!((interface.measure() - 2.0).abs() < 1e-14);
        let changes = common.changes.unwrap();
        for body in &common.bodies {
            assert!((area(body) - 2.0).abs() < 1e-12);
        }
        assert_eq!(changes.free, [0.0; 2]);
        // At least the nodes at the ends are shared.
        assert!(interface.pairs().len() <= m + n);
        assert!(changes.smallest_angle.iter().all(|a| *a > 5.0), "{changes:?}");
    }
}

#[test]
fn matching_surfaces_stay_as_they_are() {
    let bodies = [body([0.0, 1.0], [2.0, 1.0], [7, 3]), body([0.0, 0.0], [2.0, 1.0], [7, 5])];
    let points = bodies.each_ref().map(|b| b.mesh().points().to_vec());
    let common = common_refinement(bodies, ["bottom", "top"]).unwrap();
    assert_eq!(common.changes, None);
    assert_eq!(common.bodies.each_ref().map(|b| b.mesh().points().to_vec()), points);
}

fn mesh_of(body: &Body) -> (Vec<Vector>, Vec<[NodeId; 3]>, Vec<FacetId>) {
    let (points, cells) = (body.mesh().points().to_vec(), body.mesh().cells().to_vec());
    (points, cells, body.mesh().groups().values().flatten().copied().collect())
}

#[test]
fn the_order_of_the_bodies_does_not_matter() {
    // 23 against 23: equal numbers of edges, half an edge apart.
    for (m, n, width) in [(16, 23, 2.0), (23, 16, 2.0), (5, 80, 1.7), (23, 23, 1.95)] {
        let one = || body([0.0, 1.0], [width, 1.0], [m, 8]);
        let two = || body([0.0, 0.0], [2.0, 1.0], [n, 9]);
        let given = common_refinement([one(), two()], ["bottom", "top"]).unwrap();
        let turned = common_refinement([two(), one()], ["top", "bottom"]).unwrap();
        for b in 0..2 {
            assert_eq!(mesh_of(&given.bodies[b]), mesh_of(&turned.bodies[1 - b]), "{m}:{n}");
        }
        let [a, b] = [given.changes.unwrap(), turned.changes.unwrap()];
        assert_eq!((a.added[0], a.snapped[1]), (b.added[1], b.snapped[0]));
    }
}

#[test]
fn only_the_common_stretch_is_in_contact() {
    let upper = body([0.0, 1.0], [2.0, 1.0], [7, 4]);
    let lower = body([0.55, 0.0], [3.0, 1.0], [13, 5]);
    let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
    let changes = common.changes.unwrap();
    assert!((changes.free[0] - 0.55).abs() < 1e-14 && (changes.free[1] - 1.55).abs() < 1e-14, "{changes:?}");
    let interface = pair(&common.bodies);
    assert!((interface.measure() - 1.45).abs() < 1e-14);
    for (b, area_before) in [(0, 2.0), (1, 3.0)] {
        assert!((area(&common.bodies[b]) - area_before).abs() < 1e-13);
        let end = |k: usize| common.bodies[b].mesh().points()[interface.pairs()[k].nodes[b]];
        assert!(
            (end(0)[0] - 0.55).abs() < 1e-15 && (end(interface.pairs().len() - 1)[0] - 2.0).abs() < 1e-15
        );
    }
}

#[test]
fn what_has_no_common_refinement_is_refused() {
    let refused = |origin: [f64; 2], size: [f64; 2], cells, names| {
        let upper = body([0.0, 1.0], [2.0, 1.0], [7, 4]);
        common_refinement([upper, body(origin, size, cells)], names).unwrap_err()
    };
    let names = ["bottom", "top"];
    let beside = refused([2.5, 0.0], [2.0, 1.0], [9, 4], names);
    assert!(matches!(beside, CommonRefinementError::NoOverlap { .. }), "{beside}");
    let touching = refused([2.0, 0.0], [2.0, 1.0], [9, 4], names);
    assert!(matches!(touching, CommonRefinementError::NoOverlap { .. }), "{touching}");
    let same_way = refused([0.0, 0.0], [2.0, 1.0], [9, 4], ["bottom", "bottom"]);
    assert!(matches!(same_way, CommonRefinementError::NoOverlap { .. }), "{same_way}");
    let across = refused([0.0, 0.0], [2.0, 1.0], [9, 4], ["bottom", "left"]);
    assert!(matches!(across, CommonRefinementError::NoOverlap { .. }), "{across}");
    let misspelt = refused([0.0, 0.0], [2.0, 1.0], [9, 4], ["bottom", "tip"]);
    assert!(matches!(misspelt, CommonRefinementError::NoSurface { body: 1, .. }), "{misspelt}");
}

#[test]
fn ends_at_any_offset_are_accepted() {
    for share in [1e-7, 1e-5, 1e-3, 0.011, 0.03, 0.049, 0.051, 0.3] {
        for sign in [1.0, -1.0] {
            let upper = body([0.0, 1.0], [2.0, 1.0], [10, 4]);
            let lower = body([0.0, 0.0], [2.0 + sign * share * 0.2, 1.0], [10, 4]);
            let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
            let angles = common.changes.map_or([90.0; 2], |changes| changes.smallest_angle);
            assert!(angles.iter().all(|angle| *angle > 4.0), "{share} {sign}: {angles:?}");
        }
    }
}

#[test]
fn conditions_pass_on_and_held_nodes_stay() {
    // A support on a part of the side above the contact line, and a group that begins in the middle of the line.
    let mesh = block([0.0, 1.0], [2.0, 1.0], [8, 4]).unwrap();
    let topology = mesh.topology();
    let mut groups: Vec<(String, Vec<[NodeId; 2]>)> = (mesh.groups().iter())
        .map(|(name, edges)| (name.clone(), edges.iter().map(|&e| topology.facets()[e]).collect()))
        .collect();
    groups.push(("half".into(), (0..4).map(|k| [k, k + 1].map(NodeId::new)).collect()));
    let mesh = TriMesh::new(mesh.points().to_vec(), mesh.cells().to_vec(), groups).unwrap();
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let part = fem_core::boundary::FacetSelection::group("left").within([[0.0, 0.0], [1.0, 1.3]]);
    let conditions = BoundaryConditions::new().displace(part, Some(0.0.into()), None).pressure("top", 2.0);
    let upper = Body::new(mesh, material, &conditions).unwrap();
    let supports = upper.supports().to_vec();
    // 1 % of an edge from the upper one's nodes, with twice as many.
    let shift =
        |x: Vector| if x[0] > 1e-9 && x[0] < 2.0 - 1e-9 { Vector::new(x[0] + 0.0025, x[1]) } else { x };
    let lower = body([0.0, 0.0], [2.0, 1.0], [16, 4]);
    let points = lower.mesh().points().iter().map(|x| shift(*x)).collect();
    let lower = super::moved::replaced(&lower, 1, points, &Default::default()).unwrap();
    let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
    let changes = common.changes.unwrap();
    // Six of the seven inner nodes slide; the one where "half" ends stays, and the lower one's node moves onto it.
    assert_eq!((changes.snapped, changes.added), ([6, 1], [8, 0]), "{changes:?}");
    let middle = common.bodies[0].mesh().points()[4];
    assert_eq!(middle, Vector::new(1.0, 1.0));
    let [upper, _] = &common.bodies;
    assert_eq!(upper.supports(), supports);
    assert_eq!(upper.mesh().group("half").unwrap().len(), 8);
    for &e in upper.mesh().group("top").unwrap() {
        assert_eq!(upper.facet_condition(e).unwrap().traction, [Vector::new(0.0, -2.0); 2]);
    }
}

/// A body of one of three shapes below (or above) a contact line, whose inner contact nodes are shifted along the line by a
/// part of an edge: `place` takes the fraction along the line, from 0 to 1, and the height above it.
fn shifted(place: impl Fn(f64, f64) -> Vector, closed: bool, cells: usize, offset: f64, side: f64) -> Body {
    let (across, n) = (3u32, cells as u32);
    let columns = if closed { n } else { n + 1 };
    let points = (0..columns).flat_map(|k| {
        let moves = closed || (k > 0 && k < n);
        let s = (f64::from(k) + if moves { offset } else { 0.0 }) / f64::from(n);
        (0..=across).map(move |j| (s, side * 0.25 * f64::from(j))).collect::<Vec<_>>()
    });
    let points: Vec<Vector> = points.map(|(s, h)| place(s, h)).collect();
    let node = |k: u32, j: u32| (k % columns) * (across + 1) + j;
    let square = |k: u32, j: u32| {
        let [a, b, c, d] = [node(k, j), node(k + 1, j), node(k + 1, j + 1), node(k, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let cells = (0..n).flat_map(|k| (0..across).flat_map(move |j| square(k, j)));
    let line = (0..n).map(|k| [node(k, 0), node(k + 1, 0)]).collect();
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let mesh = TriMesh::new(points, cells.collect(), vec![("line".into(), line)]).unwrap();
    Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
}

/// A point at a fraction of a line and at a height above it.
type Place = fn(f64, f64) -> Vector;

/// Points on a straight line, on an arc of 70 degrees and on a whole circle, each of radius 2 at height 0.
fn lines() -> [(Place, bool); 3] {
    [
        (|s, h| Vector::new(3.0 * s, h), false),
        (|s, h| Vector::new((2.0 + h) * (1.9 - 1.2 * s).cos(), (2.0 + h) * (1.9 - 1.2 * s).sin()), false),
        (
            |s, h| {
                let angle = -std::f64::consts::TAU * s;
                Vector::new((2.0 + h) * angle.cos(), (2.0 + h) * angle.sin())
            },
            true,
        ),
    ]
}

#[test]
fn nodes_that_are_paired_face_each_other_whatever_their_offset() {
    for (line, (place, closed)) in lines().into_iter().enumerate() {
        for gap in [Gap::Touching, Gap::Given(0.0.into()), Gap::Geometric] {
            let apart = if matches!(gap, Gap::Geometric) { 0.03 } else { 0.0 };
            for offset in [0.0, 1e-7, 0.05, -0.05, 0.1, -0.1, 0.24, -0.24, 0.49] {
                let upper = shifted(|s, h| place(s, h + apart), closed, 24, 0.0, 1.0);
                let lower = shifted(place, closed, 24, offset, -1.0);
                let case = format!("line {line}, {gap:?}, offset {offset}");
                let direct = crate::pair(&upper, &lower, ["line"; 2], &gap);
                assert_eq!(direct.is_ok(), offset == 0.0, "{case}: {direct:?}");
                let common = common_refinement([upper, lower], ["line"; 2]).unwrap();
                let normal = ContactNormal::Averaged;
                let interface = crate::pair_refined(&common, ["line"; 2], &gap, normal)
                    .unwrap_or_else(|e| panic!("{case}: {e}"));
                let changed = common.changes.map_or([0; 2], |c| [c.snapped[0] + c.snapped[1], c.added[0]]);
                let inner = if closed { 24 } else { 23 };
                let expected = match offset.abs() {
                    0.0 => changed == [0, 0],
                    x if x < 0.2 => changed == [inner, 0],
                    _ => changed[0] <= 1 && changed[1] >= inner - 1,
                };
                assert!(expected, "{case}: {changed:?}");
                if let Some(changes) = common.changes.filter(|_| offset.abs() < 0.2) {
                    let moved = changes.largest_move[0].max(changes.largest_move[1]);
                    let edge = [3.0, 2.4, 2.0 * std::f64::consts::TAU][line] / 24.0;
                    assert!((moved / (offset.abs() * edge) - 1.0).abs() < 0.03, "{case}: {moved:e}");
                }
                let points = common.bodies.each_ref().map(|b| b.mesh().points());
                for pair in interface.pairs() {
                    let [a, b] = [0, 1].map(|k| points[k][pair.nodes[k]]);
                    let across = fem_core::geometry::cross(pair.normal, b - a);
                    assert!(across.abs() < 1e-13, "{case}: {across:e} at {a:?}");
                    // Between the nodes of an arc the normal, linear, is shorter than one and not quite radial.
                    let gap = pair.gap / norm(pair.normal);
                    assert!((gap - apart).abs() <= 1e-6 * apart, "{case}: gap {gap} at {a:?}");
                }
                assert_eq!(interface.gap_change(), None, "{case}");
            }
        }
    }
}

#[test]
fn ends_that_nearly_coincide_are_moved_and_said() {
    let upper = body([0.0, 1.0], [2.0, 1.0], [10, 4]);
    let lower = body([0.0, 0.0], [2.0 + 1e-3, 1.0], [10, 4]);
    let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
    let changes = common.changes.unwrap();
    assert_eq!(changes.added, [0, 0]);
    assert!((changes.largest_move[1] - 1e-3).abs() < 1e-15, "{changes:?}");
    let interface = pair(&common.bodies);
    assert_eq!(interface.pairs().len(), 11);
    assert!((interface.measure() - 2.0).abs() < 1e-14);
}

#[test]
fn surfaces_that_do_not_touch_are_refused_unless_a_gap_is_given() {
    use fem_core::interface::InterfaceError;
    for (place, closed) in lines() {
        for (apart, cells) in [(3e-3, 24), (-3e-3, 24), (3e-3, 35), (-3e-3, 35), (2e-5, 35), (0.0, 35)] {
            let upper = shifted(|s, h| place(s, h + apart), closed, 24, 0.0, 1.0);
            let lower = shifted(place, closed, cells, 0.0, -1.0);
            let common = common_refinement([upper, lower], ["line"; 2]).unwrap();
            let with = |gap: Gap| crate::pair_refined(&common, ["line"; 2], &gap, ContactNormal::Averaged);
            let touching = with(Gap::Touching);
            match touching {
                Err(InterfaceError::NotTouching { gap, .. }) if apart != 0.0 => {
                    assert!((gap - apart).abs() < 1e-12, "{gap} {apart}");
                }
                // Circles cut differently overlap as polygons, by their sagittas, and touch as circles.
                Ok(_) => assert_eq!(apart, 0.0),
                other => panic!("{apart} {cells}: {other:?}"),
            }
            match with(Gap::Geometric) {
                Err(InterfaceError::Overlap { depth, .. }) if apart < 0.0 => {
                    assert!((depth + apart).abs() < 1e-12);
                }
                Ok(_) => assert!(apart >= 0.0),
                other => panic!("{apart} {cells}: {other:?}"),
            }
            match with(Gap::Given(0.0.into())).unwrap().gap_change() {
                Some(change) => assert!(apart != 0.0 && (change.drawn - apart).abs() < 1e-12, "{change:?}"),
                None => assert_eq!(apart, 0.0),
            }
        }
    }
}

#[test]
fn pairs_that_are_apart_are_cut_at_once_as_they_would_be_alone() {
    // Three blocks on one long body; the second touches the surroundings of the first.
    let places = [0.3, 1.6, 5.3];
    let groups = ["first", "second", "third"];
    let mut base = body([0.0, 0.0], [8.0, 1.0], [8, 2]);
    for (name, x) in groups.iter().zip(places) {
        let mesh = base.mesh();
        let over = |edge: &FacetId| mesh.facet_corners(*edge).iter().any(|p| p[0] > x && p[0] < x + 1.0);
        let edges = mesh.group("top").unwrap().iter().copied().filter(over).collect();
        base.add_group(name, edges);
    }
    let mut bodies: Vec<Body> = places.iter().map(|x| body([*x, 1.0], [1.0, 1.0], [3, 3])).collect();
    bodies.push(base);
    let pair = |k: usize| Surfaces {
        bodies: [k, 3],
        groups: ["bottom", groups[k]],
        normal: ContactNormal::Averaged,
    };
    let mut alone = bodies.clone();
    let mut expected = Vec::new();
    for k in [0, 2, 1] {
        let (_, found) = common_refinements(&mut alone, &[pair(k)]).remove(0);
        expected.push(found.unwrap());
    }
    let mut together = bodies;
    let all = common_refinements(&mut together, &[pair(0), pair(1), pair(2)]);
    assert_eq!(all.iter().map(|(k, _)| *k).collect::<Vec<_>>(), [0, 2]);
    let last = common_refinements(&mut together, &[pair(1)]).remove(0);
    let found = all.into_iter().chain([last]).map(|(_, found)| found.unwrap());
    for ((measured, changes), (known, of_known)) in found.zip(expected) {
        assert_eq!(changes, of_known);
        let gaps = |of: &Measured| {
            of.facing.iter().flatten().map(|f| (f.normal, f.gap, f.spacing)).collect::<Vec<_>>()
        };
        assert_eq!(gaps(&measured), gaps(&known));
    }
    for (body, known) in together.iter().zip(&alone) {
        let places = |body: &Body| {
            let mut all: Vec<[u64; 2]> =
                body.mesh().points().iter().map(|p| [p[0].to_bits(), p[1].to_bits()]).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(places(body), places(known));
    }
}

#[test]
fn surfaces_that_cannot_match_change_no_body() {
    let mut bodies = vec![
        body([0.0, 1.0], [1.0, 1.0], [2, 2]),
        body([3.0, 5.0], [1.0, 1.0], [2, 2]),
        body([0.0, 0.0], [2.0, 1.0], [3, 1]),
    ];
    let before = bodies.clone();
    let apart = Surfaces { bodies: [1, 2], groups: ["right", "left"], normal: ContactNormal::Averaged };
    let (_, found) = common_refinements(&mut bodies, &[apart]).remove(0);
    assert!(matches!(found, Err(CommonRefinementError::NoOverlap { .. })), "{found:?}");
    let points = |all: &[Body]| all.iter().map(|b| b.mesh().points().to_vec()).collect::<Vec<_>>();
    assert_eq!(points(&bodies), points(&before));
}

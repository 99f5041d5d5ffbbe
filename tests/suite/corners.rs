//! Corners between declared arcs and straight stretches of one contact side: the line ends there, and another one begins.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, CertifiedSolution, Criterion, Imposed, Settings, Silent, solve,
    solve_adaptively,
};
use contact_geometry::ContactNormal;
use fem_core::body::{Body, CurveKind, CurvedSide};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, angle_between};
use fem_core::interface::{ContactProblem, Friction, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, ring};
use nndd::NnddSettings;
use tests::distance::{Outcome, outcome};
use tests::kinked;
use tests::run::{paired_in_common, relative_difference};
use tests::shapes::moved;

const SIDES: [&str; 2] = ["bottom", "top"];

/// Makes a body above or below the line; the two parts of it together are a group, too.
fn body(above: bool, angle: f64, cells: [usize; 2], conditions: &BoundaryConditions) -> Body {
    let steel =
        LinearElastic::isotropic(if above { 1000.0 } else { 1500.0 }, 0.3, Hypothesis::PlaneStrain).unwrap();
    let mut body = Body::new(kinked::mesh(above, angle, cells).unwrap(), steel, conditions).unwrap();
    let edges = kinked::PARTS.iter().flat_map(|part| body.mesh().group(part).unwrap().to_vec()).collect();
    body.add_group(SIDES[usize::from(!above)], edges);
    body.with_curves(&[CurvedSide { on: "round".to_owned(), kind: CurveKind::Arc }]).unwrap()
}

/// Both bodies: the upper one is pressed by a force and does not move sideways, or its top is moved down.
fn bodies(angle: f64, cells: [[usize; 2]; 2], held: bool) -> [Body; 2] {
    let down = |x: f64| -0.02 * (1.0 + 0.3 * x);
    let above = match held {
        true => BoundaryConditions::new().displace("top", Some(0.004.into()), Some((-0.01).into())),
        false => BoundaryConditions::new().displace("left", Some(0.0.into()), None).traction(
            "top",
            [0.0.into(), fem_core::boundary::ScalarData::function(move |p| 1000.0 * down(p[0]))],
        ),
    };
    [
        body(true, angle, cells[0], &above),
        body(false, angle, cells[1], &BoundaryConditions::new().fix("bottom")),
    ]
}

/// One pair with the whole side, and two pairs with its parts.
fn one_and_two(bodies: &[Body; 2]) -> [ContactProblem; 2] {
    let pair = |sides| contact_geometry::pair(&bodies[0], &bodies[1], sides, &Gap::Touching).unwrap();
    let one = ContactProblem::between(bodies.clone(), pair(SIDES));
    let two = ContactProblem::new(bodies.to_vec())
        .contact([0, 1], pair(["flat"; 2]))
        .contact([0, 1], pair(["round"; 2]));
    [one, two]
}

fn solved(problem: ContactProblem, settings: &Settings) -> CertifiedSolution {
    let solution = solve(problem, settings, &mut Silent).unwrap();
    assert!(solution.is_certified(), "{:?}", solution.estimate.map(|e| e.admissibility));
    solution
}

/// Checks that two runs have the same forces and bound.
fn assert_same(name: &str, [one, two]: [&CertifiedSolution; 2]) {
    let bounds = [one, two].map(|of| of.estimate.as_ref().unwrap().unchecked().e_cre);
    let forces = [one, two].map(|of| of.last().contact.normal_reaction.clone());
    let total = [one, two].map(|of| of.results.as_ref().unwrap().contact_force);
    assert!((bounds[0] / bounds[1] - 1.0).abs() < 1e-9, "{name}: {bounds:?}");
    assert!(relative_difference(&forces[0], &forces[1]) < 1e-9, "{name}: {forces:?}");
    assert!((total[0] / total[1] - 1.0).abs() < 1e-9, "{name}: {total:?}");
}

/// Checks that two runs have the same history: in units of the first entry, or of the bound if that is an exact solution.
fn assert_same_history(name: &str, [one, two]: [&CertifiedSolution; 2]) {
    let history =
        |of: &CertifiedSolution| -> Vec<f64> { of.rows.iter().map(|row| row.iteration.eta_nndd).collect() };
    let [first, second] = [one, two].map(history);
    assert_eq!(first.len(), second.len(), "{name}: {first:?} {second:?}");
    let off = first.iter().zip(&second).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let bound = one.estimate.as_ref().unwrap().unchecked().e_cre;
    assert!(off <= 1e-9 * first[0].max(bound), "{name}: {first:?} {second:?}");
}

#[test]
fn a_corner_ends_the_line_on_one_side_as_between_two_sides() {
    for degrees in [5.0f64, -5.0, 1.5, 25.0] {
        let angle = degrees.to_radians();
        let of_problem = |held: bool, settings: &Settings| {
            let problems = one_and_two(&bodies(angle, [[16, 6], [16, 8]], held));
            let interface = &problems[0].contacts[0].interface;
            let (pairs, arc_lengths) = (interface.pairs(), interface.arc_lengths());
            assert_eq!(pairs.len(), 18, "{degrees}");
            let [before, after] = [&pairs[8], &pairs[9]];
            assert_eq!((before.nodes, arc_lengths[8]), (after.nodes, arc_lengths[9]));
            let turn = angle_between(before.normal, after.normal).to_degrees();
            assert!((turn - degrees.abs()).abs() < 1e-9, "{degrees}: {turn}");
            assert_eq!(before.normal, -Vector::y());
            let [one, two] = problems.map(|problem| solved(problem, settings));
            let name = format!("{degrees} degrees, held {held}");
            assert_same(&name, [&one, &two]);
            assert_same_history(&name, [&one, &two]);
        };
        let exact = Settings::default();
        of_problem(false, &exact);
        let mut iteration = Settings::default().with_method(NnddSettings::default());
        iteration.criterion = Criterion::EtaNndd { tolerance: 1e-3 };
        iteration.imposed = Imposed::First;
        of_problem(true, &iteration);
    }
}

/// Solves until the bound is met and returns the solution and the numbers of nodes of all steps.
fn adapted(problem: ContactProblem, target: f64) -> (CertifiedSolution, Vec<usize>) {
    let answer =
        solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(target), &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    let nodes = answer.history.iter().map(|step| step.nodes).collect();
    (answer.solution, nodes)
}

#[test]
fn refinement_goes_through_a_corner() {
    let angle = 5.0f64.to_radians();
    let [one, two] =
        one_and_two(&bodies(angle, [[8, 4], [8, 4]], false)).map(|problem| adapted(problem, 0.04));
    assert!(one.1.len() > 2 && one.1 == two.1, "{:?} {:?}", one.1, two.1);
    assert_same("refined", [&one.0, &two.0]);
    assert_same_history("refined", [&one.0, &two.0]);
    let pairs = one.0.problem.contacts[0].interface.pairs();
    let points = one.0.problem.bodies[0].mesh().points();
    let at_corner: Vec<Vector> =
        pairs.iter().filter(|p| points[p.nodes[0]] == Vector::zeros()).map(|p| p.normal).collect();
    assert_eq!(at_corner.len(), 2);
    let last = one.0.problem.contacts[0].interface.arc_lengths()[pairs.len() - 1];
    assert!((last / one.0.problem.contacts[0].interface.measure() - 1.0).abs() < 1e-12);
}

#[test]
fn a_corner_of_surfaces_that_do_not_match_ends_the_line() {
    for (degrees, cells) in
        [(5.0f64, [[14, 6], [22, 8]]), (-5.0, [[26, 8], [10, 4]]), (20.0, [[10, 4], [16, 6]])]
    {
        for exchanged in [false, true] {
            let mut bodies = bodies(degrees.to_radians(), cells, false);
            let mut sides = SIDES;
            if exchanged {
                bodies.reverse();
                sides.reverse();
            }
            let (problem, changes) =
                paired_in_common(bodies, sides, &Gap::Touching, ContactNormal::Averaged).unwrap();
            let changes = changes.unwrap();
            assert_eq!(changes.free, [0.0; 2], "{changes:?}");
            let interface = &problem.contacts[0].interface;
            let points = problem.bodies[0].mesh().points();
            let corner: Vec<Vector> = interface
                .pairs()
                .iter()
                .filter(|p| points[p.nodes[0]].norm() < 1e-9)
                .map(|p| p.normal)
                .collect();
            let [a, b] = corner[..] else { panic!("{degrees}, {exchanged}: {corner:?}") };
            assert!((angle_between(a, b).to_degrees() - degrees.abs()).abs() < 1e-9);
            assert_eq!(interface.facets().len() + 2, interface.pairs().len());
            let found = outcome(problem, 2).unwrap();
            println!("{degrees} degrees, exchanged {exchanged}: {found:?}");
            let Outcome::Certified { bound, error } = found else { panic!("{found:?}") };
            // At a closed corner the bodies cannot slide, so that pressures grow there.
            assert!(bound >= error && bound < 2.0 * error, "{bound} {error}");
        }
    }
}

/// Makes a body between the side and y = ±1, all of which is declared as a smooth curve, or nothing.
fn other(angle: f64, cells: [usize; 2], smooth: bool) -> Body {
    let below = body(false, angle, cells, &BoundaryConditions::new().fix("bottom"));
    let curves = CurvedSide { on: "top".to_owned(), kind: CurveKind::Smooth };
    below.with_curves(if smooth { std::slice::from_ref(&curves) } else { &[] }).unwrap()
}

#[test]
fn a_smooth_piece_of_the_other_side_gives_the_normal_of_a_corner() {
    let angle = 5.0f64.to_radians();
    let [above, _] = bodies(angle, [[16, 6], [16, 6]], false);
    let at_corner = |bodies: [&Body; 2], sides: [&str; 2]| -> Vec<Vector> {
        let interface = contact_geometry::pair(bodies[0], bodies[1], sides, &Gap::Given(0.0.into())).unwrap();
        let points = bodies[0].mesh().points();
        interface.pairs().iter().filter(|p| points[p.nodes[0]] == Vector::zeros()).map(|p| p.normal).collect()
    };
    // The normal of the smooth curve is between the vertical and the normal of the edge behind the corner.
    let smooth = other(angle, [16, 6], true);
    let found = at_corner([&above, &smooth], SIDES);
    let [normal] = found[..] else { panic!("{found:?}") };
    let tilt = angle_between(normal, -Vector::y()).to_degrees();
    assert!(normal[0] < 0.0 && (1.0..6.0).contains(&tilt), "{tilt}");
    // A polygon is not known: the corner is the first body's, or missing.
    let unknown = other(angle, [16, 6], false);
    assert_eq!(at_corner([&above, &unknown], SIDES).len(), 2);
    assert_eq!(at_corner([&unknown, &above], ["top", "bottom"]).len(), 1);
}

#[test]
fn a_corner_on_a_straight_side_has_the_normal_of_that_side() {
    for (cells, first) in
        [([[22, 8], [14, 6]], true), ([[22, 8], [14, 6]], false), ([[11, 5], [26, 8]], true)]
    {
        let [_, below] = bodies(5.0f64.to_radians(), [cells[1]; 2], false);
        let mesh = block([-1.5, 0.0], [3.0, 1.0], cells[0]).unwrap();
        let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let pressed = BoundaryConditions::new()
            .displace("left", Some(0.0.into()), None)
            .displace("right", Some(0.0.into()), None)
            .traction("top", [0.0.into(), (-10.0).into()]);
        let above = Body::new(mesh, steel, &pressed).unwrap();
        let (bodies, sides) =
            if first { ([above, below], SIDES) } else { ([below, above], ["top", "bottom"]) };
        let (problem, _) = paired_in_common(bodies, sides, &Gap::Geometric, ContactNormal::Averaged).unwrap();
        let interface = &problem.contacts[0].interface;
        assert_eq!(interface.pairs().len(), interface.facets().len() + 1);
        let lower = usize::from(first);
        let points = problem.bodies[lower].mesh().points();
        let corner = interface.pairs().iter().find(|p| points[p.nodes[lower]] == Vector::zeros()).unwrap();
        assert!(corner.normal[0].abs() < 1e-12 && corner.gap.abs() < 1e-12, "{corner:?}");
        let found = outcome(problem, 2).unwrap();
        let Outcome::Certified { bound, error } = found else { panic!("{found:?}") };
        println!("{cells:?} {bound} {error}");
        assert!(bound >= error && bound < 1.5 * error, "{bound} {error}");
    }
}

#[test]
fn corners_at_a_distance_end_the_line_too() {
    for (degrees, cells) in
        [(10.0f64, [[14, 6], [22, 8]]), (-10.0, [[14, 6], [22, 8]]), (10.0, [[16, 6], [16, 6]])]
    {
        let [mut above, below] = bodies(degrees.to_radians(), cells, true);
        let gap = 0.004;
        let mesh = moved(above.mesh(), |p| p + gap * Vector::y()).unwrap();
        let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let down = BoundaryConditions::new().displace("top", Some(0.001.into()), Some((-0.01).into()));
        let round = CurvedSide { on: "round".to_owned(), kind: CurveKind::Arc };
        above = Body::new(mesh, steel, &down).unwrap().with_curves(&[round]).unwrap();
        let problem =
            paired_in_common([above, below], SIDES, &Gap::Geometric, ContactNormal::Averaged).unwrap().0;
        let interface = &problem.contacts[0].interface;
        assert_eq!(interface.pairs().len(), interface.facets().len() + 2);
        let found = outcome(problem, 2).unwrap();
        println!("{degrees} {cells:?} {found:?}");
        let Outcome::Certified { bound, error } = found else { panic!("{found:?}") };
        assert!(bound >= error && bound < 2.0 * error, "{bound} {error}");
    }
}

/// A ring whose outer or inner side is a drop with a corner at angle 0, and whose other side is a circle.
fn drop(inside: bool, cells: [usize; 2], conditions: &BoundaryConditions) -> Body {
    let mesh = ring([0.0; 2], if inside { [0.5, 1.0] } else { [1.0, 2.5] }, [0.0, 360.0], cells).unwrap();
    let place = |p: Vector| {
        let (r, turn) = (p.norm(), p[1].atan2(p[0]).abs() / std::f64::consts::PI);
        let weight = if inside { (r - 0.5) / 0.5 } else { (2.5 - r) / 1.5 };
        (1.0 + weight * 0.8 * (1.0 - turn).powi(2) / r) * p
    };
    let mesh = moved(&mesh, place).unwrap();
    let steel =
        LinearElastic::isotropic(if inside { 1500.0 } else { 1000.0 }, 0.3, Hypothesis::PlaneStrain).unwrap();
    let on = if inside { "outer" } else { "inner" }.to_owned();
    Body::new(mesh, steel, conditions)
        .unwrap()
        .with_curves(&[CurvedSide { on, kind: CurveKind::Smooth }])
        .unwrap()
}

#[test]
fn a_closed_line_with_one_corner_begins_and_ends_there() {
    for around in [[40, 40], [40, 57], [57, 40]] {
        let pressed = BoundaryConditions::new().displace(
            "outer",
            Some(fem_core::boundary::ScalarData::function(|p| -0.01 * p[0])),
            Some(fem_core::boundary::ScalarData::function(|p| -0.01 * p[1])),
        );
        let inside = drop(true, [around[0], 4], &BoundaryConditions::new().fix("inner"));
        let outside = drop(false, [around[1], 6], &pressed);
        let sides = ["outer", "inner"];
        let problem = if around[0] == around[1] {
            let interface = contact_geometry::pair(&inside, &outside, sides, &Gap::Touching).unwrap();
            ContactProblem::between([inside, outside], interface)
        } else {
            paired_in_common([inside, outside], sides, &Gap::Given(0.0.into()), ContactNormal::Averaged)
                .unwrap()
                .0
        };
        let interface = &problem.contacts[0].interface;
        assert_eq!(interface.pairs().len(), interface.facets().len() + 1);
        let ends = [0, interface.pairs().len() - 1].map(|k| interface.pairs()[k]);
        assert_eq!(ends[0].nodes, ends[1].nodes);
        assert!(angle_between(ends[0].normal, ends[1].normal).to_degrees() > 20.0);
        assert!(
            (interface.arc_lengths()[interface.pairs().len() - 1] / interface.measure() - 1.0).abs() < 1e-12
        );
        let found = outcome(problem, 2).unwrap();
        println!("{around:?} {found:?}");
        let Outcome::Certified { bound, error } = found else { panic!("{found:?}") };
        assert!(bound >= error && bound < 2.0 * error, "{bound} {error}");
    }
}

#[test]
fn friction_acts_on_both_sides_of_a_corner() {
    let settings = Settings::default();
    let problems = one_and_two(&bodies(5.0f64.to_radians(), [[16, 6], [16, 6]], false));
    let [one, two] = problems.map(|mut problem| {
        for k in 0..problem.contacts.len() {
            problem = problem.with_friction(k, Friction::Tresca { limit: 0.5.into() }).unwrap();
        }
        solved(problem, &settings)
    });
    assert_same("friction", [&one, &two]);
}

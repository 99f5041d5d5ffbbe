//! Corners between declared arcs and straight stretches of one contact side: the line ends there, and another one begins.
//!
//! ```text
//!   ┌───────────┬───────────┐   pressed down
//!   │           │     Ω₁    │
//!   ────────────┐‾‾‾‾──___ _│   y = f(x): flat for x ≤ 0, an arc for x ≥ 0 that begins at an angle
//!   │           │     Ω₂    │
//!   └───────────┴───────────┘   held
//! ```

use certified_contact::{
    AdaptSettings, AdaptiveEnd, CertifiedSolution, Criterion, Imposed, Settings, Silent, solve,
    solve_adaptively,
};
use fem_core::body::{Body, CurveKind, CurvedSide};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::{Vector, angle_between};
use fem_core::interface::{ContactInterface, ContactNormal, ContactProblem, Friction, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::id::EdgeId;
use nndd::NnddSettings;
use tests::distance::{Outcome, outcome};
use tests::run::{paired_in_common, relative_difference};
use tests::shapes::moved;

const SIDES: [&str; 2] = ["bottom", "top"];
const RADIUS: f64 = 3.0;

/// The height of the side, which turns by an angle at x = 0, down if it is positive.
fn height(x: f64, angle: f64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let past = x.max(0.0) + RADIUS * sine;
    let root = (RADIUS * RADIUS - past * past).sqrt();
    // Without a difference of nearly equal numbers.
    -(x.max(0.0)) * (x.max(0.0) + 2.0 * RADIUS * sine) / (root + RADIUS * cosine)
}

/// Makes a body above or below the side; the two parts of it are also groups of their own.
fn body(above: bool, angle: f64, cells: [usize; 2], conditions: &BoundaryConditions) -> Body {
    let mesh = block([-1.0, if above { 0.0 } else { -1.0 }], [2.0, 1.0], cells).unwrap();
    let mesh = moved(&mesh, |p| p + (1.0 - p[1].abs()) * height(p[0], angle) * Vector::y()).unwrap();
    let steel =
        LinearElastic::isotropic(if above { 1000.0 } else { 1500.0 }, 0.3, Hypothesis::PlaneStrain).unwrap();
    let mut body = Body::new(mesh, steel, conditions).unwrap();
    let edges = body.mesh().group(SIDES[usize::from(!above)]).unwrap().to_vec();
    let (round, flat): (Vec<EdgeId>, Vec<EdgeId>) =
        edges.into_iter().partition(|e| body.mesh().edge_middle(*e)[0] > 0.0);
    body.add_group("round", round);
    body.add_group("flat", flat);
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
    let pair = |sides| ContactInterface::pair(&bodies[0], &bodies[1], sides, &Gap::Touching).unwrap();
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

/// Checks that two runs have the same history, forces and bound.
fn assert_same(name: &str, [one, two]: [&CertifiedSolution; 2]) {
    let history =
        |of: &CertifiedSolution| of.rows.iter().map(|row| row.iteration.eta_nndd).collect::<Vec<f64>>();
    let [first, second] = [one, two].map(history);
    assert_eq!(first.len(), second.len(), "{name}: {first:?} {second:?}");
    // In units of the first, since the last of an exact solution is round-off.
    let off = first.iter().zip(&second).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let bounds = [one, two].map(|of| of.estimate.as_ref().unwrap().unchecked().e_cre);
    let forces = [one, two].map(|of| of.last().contact.normal_reaction.clone());
    let total = [one, two].map(|of| of.results.as_ref().unwrap().contact_force);
    assert!(off <= 1e-9 * first[0].max(bounds[0]), "{name}: {first:?} {second:?}");
    assert!((bounds[0] / bounds[1] - 1.0).abs() < 1e-9, "{name}: {bounds:?}");
    assert!(relative_difference(&forces[0], &forces[1]) < 1e-9, "{name}: {forces:?}");
    assert!((total[0] / total[1] - 1.0).abs() < 1e-9, "{name}: {total:?}");
}

#[test]
fn a_corner_ends_the_line_on_one_side_as_between_two_sides() {
    for degrees in [5.0f64, -5.0, 1.5, 25.0] {
        let angle = degrees.to_radians();
        let of_problem = |held: bool, settings: &Settings| {
            let problems = one_and_two(&bodies(angle, [[16, 6], [16, 8]], held));
            let pairs = problems[0].contacts[0].interface.pairs();
            assert_eq!(pairs.len(), 18, "{degrees}");
            let [before, after] = [&pairs[8], &pairs[9]];
            assert_eq!((before.nodes, before.arc_length), (after.nodes, after.arc_length));
            let turn = angle_between(before.normal, after.normal).to_degrees();
            assert!((turn - degrees.abs()).abs() < 1e-9, "{degrees}: {turn}");
            assert_eq!(before.normal, -Vector::y());
            let [one, two] = problems.map(|problem| solved(problem, settings));
            assert_same(&format!("{degrees} degrees, held {held}"), [&one, &two]);
        };
        let exact = Settings::default();
        of_problem(false, &exact);
        let mut iteration = Settings::default().with_method(NnddSettings::default());
        iteration.criterion = Criterion::EtaNndd { tolerance: 1e-3 };
        iteration.imposed = Imposed::First;
        of_problem(true, &iteration);
    }
}

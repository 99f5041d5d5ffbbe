//! Supports on single nodes: they may remove rigid motions, and carry no force in a certified solution.

use case_io::Case;
use certified_contact::{AdaptSettings, CertifiedSolution, Settings, Silent, solve, solve_adaptively};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
use fem_core::geometry::norm;
use fem_core::interface::ContactProblem;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_distance_squared;
use tests::finer::{finer, halve};

const YOUNG: f64 = 2000.0;

/// A square of side 1 that three components at two corners hold, under the tractions of `σ_xx = 12 y − 6 + more`: on the left
/// side `−σ_xx`, on the right side `σ_xx` times `right`.
fn square(cells: usize, more: f64, right: f64) -> ContactProblem {
    let mesh = block([0.0, 0.0], [1.0, 1.0], [cells, cells]).unwrap();
    let material = LinearElastic::isotropic(YOUNG, 0.3, Hypothesis::PlaneStress).unwrap();
    let bending = move |factor: f64| ScalarData::function(move |x| factor * (12.0 * x[1] - 6.0 + more));
    let conditions = BoundaryConditions::new()
        .displace(FacetSelection::node("first", [0.0, 0.0]), Some(0.0.into()), Some(0.0.into()))
        .displace(FacetSelection::node("second", [0.0, 1.0]), Some(0.0.into()), None)
        .traction("left", [bending(-1.0), 0.0.into()])
        .traction("right", [bending(right), 0.0.into()]);
    ContactProblem::new(vec![Body::new(mesh, material, &conditions).unwrap()])
}

fn solved(problem: ContactProblem) -> CertifiedSolution {
    solve(problem, &Settings::default(), &mut Silent).unwrap()
}

/// `a(u, u)` of the exact solution: `∫ σ_xx²/E`, with `σ_xx = 12 y − 6 + more`.
fn exact(more: f64) -> f64 {
    (12.0 + more * more) / YOUNG
}

fn energy(solution: &CertifiedSolution) -> f64 {
    solution.results.as_ref().unwrap().energy_norm_squared[0]
}

#[test]
fn loads_in_balance_are_certified_and_the_points_carry_nothing() {
    for (cells, more) in [(3, 0.0), (8, 0.0), (8, 5.0), (17, 1.0)] {
        let solution = solved(square(cells, more, 1.0));
        assert!(solution.is_certified(), "{:?}", solution.estimate.unwrap().admissibility);
        // Supports impose zero and loads are represented exactly: the error of the energy is the squared error in the energy norm.
        let error = (exact(more) - energy(&solution)).sqrt();
        let bound = solution.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
        assert!(bound >= error && bound < 2.0 * error, "{cells} {more}: {bound:e} {error:e}");
        let results = solution.results.as_ref().unwrap();
        assert_eq!(results.reactions.len(), 2);
        assert!(results.reactions.iter().all(|r| norm(r.force) < 1e-11), "{:?}", results.reactions);
        assert!(solution.problem.bodies[0].supports().iter().all(|set| set.nodes.len() == 1));
    }
}

#[test]
fn finer_meshes_keep_the_node() {
    let coarse = square(3, 2.0, 1.0);
    let held = coarse.bodies[0].supports().to_vec();
    let finer = halve(&halve(&coarse).unwrap().problem).unwrap().problem;
    assert_eq!(finer.bodies[0].supports(), held);
    let answer =
        solve_adaptively(coarse, &Settings::default(), &AdaptSettings::new(0.05), &mut Silent).unwrap();
    let solution = &answer.solution;
    assert!(solution.is_certified() && answer.history.len() > 1, "{:?}", answer.end);
    let error = (exact(2.0) - energy(solution)).sqrt();
    let bound = solution.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
    assert!(bound >= error && bound < 2.0 * error, "{bound:e} {error:e}");
}

#[test]
fn a_point_that_carries_a_force_takes_the_certificate_away() {
    for [more, right] in [[1.0, 1.0 + 1e-6], [1.0, 0.0], [0.0, 0.5]] {
        let solution = solved(square(8, more, right));
        assert!(!solution.is_certified());
        let estimate = solution.estimate.as_ref().unwrap();
        let failed: Vec<_> = estimate.admissibility.failed().map(|(name, _)| name).collect();
        assert!(failed.contains(&"boundary_traction"), "{failed:?}");
        assert!(estimate.certificate().is_none());
    }
}

/// A block on a wider one, pressed down; one node of the block keeps it from sliding.
const PRESSED: &str = "schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = \"block\"
material = \"m\"
generator = { kind = \"block\", origin = [1.0, 1.0], size = [1.0, 1.0], cells = [6, 6] }
[[body.side]]
name = \"pin\"
point = [1.0, 2.0]
[[body.displacement]]
on = \"pin\"
ux = 0.0
[[body.traction]]
on = \"top\"
vector = [0.0, \"-1 - (x - 1.5) / 2\"]
[[body]]
name = \"base\"
material = \"m\"
generator = { kind = \"block\", size = [3.0, 1.0], cells = [18, 6] }
[[body.displacement]]
on = \"bottom\"
fixed = true
[contact]
surfaces = [\"bottom\", \"top\"]
gap = 0.0
";

#[test]
fn a_node_keeps_a_pressed_block_from_sliding() {
    let problem = || Case::parse(PRESSED, "case.toml", &[]).unwrap().build().unwrap().0;
    let solution = solved(problem());
    assert!(solution.is_certified(), "{:?}", solution.estimate.unwrap().admissibility);
    let results = solution.results.as_ref().unwrap();
    assert!(
        norm(results.reactions[0].force) < 1e-11 && results.reactions[0].on == "pin",
        "{:?}",
        results.reactions
    );
    let fields = &solution.estimate.as_ref().unwrap().pair.bodies;
    let u = fields.iter().map(|body| body.displacement.clone()).collect();
    let (finer, u) = finer(problem(), u, 2).unwrap();
    let reference = solved(finer);
    let exact = &reference.estimate.as_ref().unwrap().pair.bodies;
    let bodies = reference.problem.bodies.iter().zip(exact).zip(&u);
    let squared: f64 =
        bodies.map(|((body, exact), u)| energy_distance_squared(body, u, &exact.displacement)).sum();
    let bound = solution.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
    assert!(bound > squared.sqrt() && bound < 3.0 * squared.sqrt(), "{bound:e} {:e}", squared.sqrt());
}

#[test]
fn conditions_on_a_single_node_are_checked() {
    let body = |conditions: BoundaryConditions| {
        let mesh = block([0.0, 0.0], [1.0, 1.0], [4, 4]).unwrap();
        Body::new(mesh, LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStress).unwrap(), &conditions)
    };
    let pin = |at: [f64; 2]| FacetSelection::node("pin", at);
    let refused = |conditions| body(conditions).unwrap_err().to_string();
    assert!(body(BoundaryConditions::new().fix(pin([0.25 + 1e-7, 0.0]))).is_ok());
    // A node inside the body is no place for a support.
    let inside = refused(BoundaryConditions::new().fix(pin([0.5, 0.25])));
    assert!(inside.contains("no boundary node is at (0.5, 0.25)"), "{inside}");
    assert!(refused(BoundaryConditions::new().fix(pin([f64::NAN, 0.0]))).contains("a finite number"));
    for conditions in [
        BoundaryConditions::new().roller(pin([0.0, 0.0]), 0.0),
        BoundaryConditions::new().pressure(pin([0.0, 0.0]), 1.0),
    ] {
        assert!(refused(conditions).contains("is on a single node"));
    }
}

//! The bound with Tresca friction, and the residual with Coulomb's.

use contact_qp::QpSettings;
use cre_estimator::{Estimate, Relaxation, estimate_with};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction, Gap, Obstacle, RigidLine, Roles};
use fem_core::material::{Hypothesis, LinearElastic, Materials};
use fem_core::mesh::generate::{block, ring};
use nndd::{CoulombSettings, ExactSolution, solve_coulomb, solve_exactly};
use tests::distance::{Outcome, distance, outcome};
use tests::friction::{along_edge, blocks, patch, pushed_middle, pushed_over_plane, rings};
use tests::prepare;
use tests::random::Random;
use tests::run::state_of;
use tests::tresca;

const BEST: Relaxation = Relaxation::Tolerance { tolerance: 1e-12, max_steps: 400 };

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

/// Returns the exact solution with its displacements, and its estimate.
fn estimated(
    problem: &ContactProblem,
    relaxation: Relaxation,
) -> ((ExactSolution, Vec<Vec<Vector>>), Estimate) {
    let prepared = prepare(problem);
    let exact = if problem.contacts.iter().any(|pair| pair.friction.coulomb().is_some()) {
        let mut settings = CoulombSettings::default();
        (settings.tolerance, settings.max_steps) = (1e-13, 80);
        solve_coulomb(&prepared.system(), &settings, None, || true).unwrap().exact
    } else {
        solve_exactly(&prepared.system(), &QpSettings::default()).unwrap()
    };
    let displacement = prepared.displacements(&exact.fields);
    let estimate = estimate_with(&prepared, &state_of(&exact, &displacement), relaxation).unwrap();
    assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
    // The split of a bound of round-off is round-off.
    let something = estimate.cre.e_cre() > 1e-5 * estimate.energy_norm();
    assert!(!something || estimate.cre.split_defect() < 1e-12, "{:e}", estimate.cre.split_defect());
    assert!(estimate.cre.friction_by_contact_edge.iter().flatten().all(|term| *term >= 0.0));
    ((exact, displacement), estimate)
}

#[test]
fn the_bound_has_the_figures_of_an_independent_code() {
    for (friction, [e, discretisation, algebraic]) in [
        (Friction::tresca(1.0), [0.180289842531, 0.179386394605, 0.0180263349]),
        (Friction::tresca(4.0), [0.169652101413, 0.168472891411, 0.0199679837]),
        (Friction::tresca(8.0), [0.163245296348, 0.161955761633, 0.0204782337]),
        (Friction::Coulomb { mu: 0.3 }, [0.182607249418, 0.181570347909, 0.0194323519]),
        (Friction::Coulomb { mu: 0.6 }, [0.182720275607, 0.181411984118, 0.0218263862]),
    ] {
        let coulomb = friction.coulomb().is_some();
        let (_, estimate) = estimated(&blocks([18, 9], friction).unwrap(), BEST);
        let cre = &estimate.cre;
        println!("{} {} {}", cre.e_cre(), cre.discretisation_squared.sqrt(), cre.algebraic_squared.sqrt());
        near(cre.e_cre(), e, 1e-9);
        near(cre.discretisation_squared.sqrt(), discretisation, 1e-9);
        near(cre.algebraic_squared.sqrt(), algebraic, 1e-8);
        // Nothing is certified with the law of Coulomb.
        assert_eq!(estimate.certificate().is_none(), coulomb);
        assert_eq!(estimate.for_frozen_limit().is_some(), coulomb);
        if e == 0.169652101413 {
            near(cre.friction_squared(), 2.9596776e-6, 1e-7);
            near(cre.contact_squared() - cre.friction_squared(), 3.3689584e-4, 1e-7);
            near(estimate.unchecked().parts.friction.powi(2), 2.9596776e-6, 1e-7);
        }
    }
}

#[test]
fn a_patch_has_no_error() {
    for friction in [Friction::tresca(3.0), Friction::Coulomb { mu: 0.3 }] {
        let (_, estimate) = estimated(&patch(friction).unwrap(), Relaxation::default());
        let relative = estimate.cre.e_cre() / estimate.energy_norm();
        println!("{relative:e}");
        assert!(relative < 3e-7, "{relative:e}");
    }
}

#[test]
fn without_a_limit_the_bound_is_the_frictionless_one_and_without_end_that_of_a_bond() {
    let cells = [18, 9];
    let (_, without) = estimated(&blocks(cells, Friction::None).unwrap(), Relaxation::Steps(2));
    let (_, zero) = estimated(&blocks(cells, Friction::tresca(0.0)).unwrap(), Relaxation::Steps(2));
    near(zero.cre.e_cre(), without.cre.e_cre(), 1e-12);
    near(zero.unchecked().eta_nndd.max(1e-9), without.unchecked().eta_nndd.max(1e-9), 1e-3);
    // Any large limit gives the same bound: full stick on closed contact.
    let [a, b] =
        [1e2, 1e4].map(|s| estimated(&blocks(cells, Friction::tresca(s)).unwrap(), Relaxation::Steps(2)).1);
    near(a.cre.e_cre(), b.cre.e_cre(), 1e-9);
    // Nothing slips, so that friction adds nothing.
    assert!(a.cre.friction_squared() < 1e-12 * a.cre.e_cre_squared);
}

/// A sector of a ring within another one, pressed outwards and onto a plane with friction at its end: its outer line, which bends, and the
/// straight one meet at a node.
fn sector_on_plane(cells: [usize; 2], friction: &Friction) -> ContactProblem {
    // The outer one is so stiff that the lift moves the inner one.
    let part = |young, radii, conditions: &BoundaryConditions| {
        let steel = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(ring([0.0; 2], radii, [0.0, 60.0], cells).unwrap(), steel, conditions).unwrap()
    };
    let inner = BoundaryConditions::new().pressure("inner", 20.0).pressure("end", 60.0);
    let outer = BoundaryConditions::new().fix("outer");
    let bodies = vec![part(1000.0, [1.0, 1.5], &inner), part(1e5, [1.5, 2.0], &outer)];
    let line = contact_geometry::pair(&bodies[0], &bodies[1], ["outer", "inner"], &Gap::Geometric).unwrap();
    let plane = Obstacle::fixed(RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() });
    let foot = contact_geometry::against(&bodies[0], "start", &plane, None).unwrap();
    let problem = ContactProblem::new(bodies).contact([0, 1], line).obstacle(0, foot, plane);
    problem.with_friction(1, friction.clone()).unwrap()
}

#[test]
fn the_bound_counts_the_slip_that_the_lift_of_another_contact_line_adds() {
    let problem = sector_on_plane([8, 3], &Friction::tresca(5.0));
    let (_, estimate) = estimated(&problem, Relaxation::Steps(2));
    let [bent, straight] = &estimate.pair.contacts[..] else { panic!("two pairs") };
    assert_eq!(bent.lift.body, 0);
    let field = bent.lift.field(&problem, &problem.contacts[0].interface);
    let foot = problem.contacts[1].interface.pairs();
    let shared = field.iter().find(|(node, _)| foot.iter().any(|pair| pair.nodes[0] == *node));
    let (_, l) = shared.expect("the lift does not move the node of both lines");
    // It leaves both: up from the plane, and inwards from the outer ring.
    assert!(l[0] < -1e-9 && l[1] > 1e-9, "{l:?}");
    let largest = straight.facet_friction.lifted[0].iter().flatten().fold(0.0f64, |m, l| m.max(l[0].abs()));
    assert!((largest - l[0].abs()).abs() < 1e-15, "{largest} {l:?}");
    // And the bound holds.
    let Outcome::Certified { bound, error } = outcome(problem, 2).unwrap() else { panic!("not certified") };
    println!("bound {bound} error {error}");
    assert!(error <= bound, "{error} {bound}");
}

#[test]
fn the_bound_of_bodies_that_friction_holds_is_in_balance() {
    for push in [6.0, 14.0] {
        let (_, estimate) = estimated(&pushed_middle(push, [18, 9], &Friction::tresca(4.0)).unwrap(), BEST);
        println!("push {push}: {:e} {:e}", estimate.pair.pressure_shift, estimate.pair.rigid_balance);
        assert!(estimate.certificate().is_some() && estimate.pair.rigid_balance < 1e-12);
        // The pressure at the nodes alone is out of balance.
        assert!(estimate.pair.pressure_shift > 1e-8);
    }
    for push in [2.0, 6.0] {
        let coulomb = Friction::Coulomb { mu: 0.3 };
        let (_, estimate) = estimated(&pushed_middle(push, [18, 9], &coulomb).unwrap(), Relaxation::Steps(2));
        assert!(estimate.for_frozen_limit().is_some() && estimate.pair.rigid_balance < 1e-12);
    }
}

#[test]
fn the_residual_of_a_block_pushed_over_a_plane() {
    // With q = 0 at the corner on the line of symmetry; the independent code printed five digits.
    let problem = pushed_over_plane(16, Friction::Coulomb { mu: 1.0 }).unwrap();
    let (_, estimate) = estimated(&problem, BEST);
    println!("e_b {}", estimate.cre.e_cre());
    near(estimate.cre.e_cre(), 0.51725, 1e-5);
}

/// Returns the bound and the distance to a mesh with four times as many cells in each direction.
fn bound_and_error(problem: &ContactProblem, relaxation: Relaxation) -> [f64; 2] {
    let ((_, displacement), estimate) = estimated(problem, relaxation);
    let u = &displacement[..problem.bodies.len()];
    [estimate.unchecked().e_cre, distance(problem, u, 2).unwrap()]
}

#[test]
fn the_bound_is_above_the_error_on_random_problems() {
    let mut random = Random::new(31);
    for k in 0..12 {
        let (a, b) = (8.0 * random.unit(), 8.0 * random.unit());
        // Linear along the line, so that finer meshes have the same limit.
        let limit = ScalarData::function(move |x: Vector| a + 0.5 * (b - a) * x[0]);
        let friction = Friction::tresca(limit);
        let problem = match k % 3 {
            0 => blocks([6 + k, 4], friction).unwrap(),
            1 => blocks([8, 4], friction).unwrap().with_roles(Roles::SECOND),
            _ => pushed_middle(1.9 * (a + b) * random.unit(), [8, 4], &friction).unwrap(),
        };
        let [bound, error] = bound_and_error(&problem, Relaxation::Steps(2));
        println!("{k}: {bound:.4e} {error:.4e} {:.3}", bound / error);
        assert!(bound >= error && bound < 1.6 * error, "{k}: {bound} {error}");
    }
}

#[test]
fn the_bound_holds_on_bent_lines() {
    let mut random = Random::new(32);
    let (mut lifted, mut slipped) = (0, 0);
    for k in 0..8 {
        let s = 1.2 * random.unit() + 0.05;
        let turn = 0.01 * (2.0 * random.unit() - 1.0);
        let problem = rings(turn, [12 + k, 4], Friction::tresca(s)).unwrap();
        let ((exact, _), estimate) = estimated(&problem, Relaxation::Steps(2));
        let contact = &estimate.pair.contacts[0];
        lifted += usize::from(contact.lift.largest() > 0.0);
        slipped += usize::from(exact.friction[0].slip.iter().any(|w| *w != 0.0));
        // Constant friction on each edge, at most the limit.
        let line = &problem.contacts[0].interface;
        for (edge, traction) in line.facets().iter().zip(&contact.facet_friction.traction) {
            let [a, b] = along_edge(line, edge, traction);
            assert!((a - b).abs() <= 1e-15 * s && a.abs() <= s * (1.0 + 1e-15));
        }
        let [bound, error] = bound_and_error(&problem, Relaxation::Steps(2));
        println!("{k}: {bound:.4e} {error:.4e} {:.3}, {lifted} lifted, {slipped} slip", bound / error);
        assert!(bound >= error && bound < 2.0 * error, "{k}: {bound} {error}");
    }
    assert!(slipped >= 6);
    // With the law of Coulomb on a bent line: a residual, and no certificate.
    let (_, estimate) =
        estimated(&rings(0.01, [14, 4], Friction::Coulomb { mu: 0.3 }).unwrap(), Relaxation::Steps(2));
    assert!(estimate.certificate().is_none() && estimate.for_frozen_limit().is_some());
}

/// Random problems that every run of the tests solves; `cargo xtask reproduce friction` solves 560.
const SHARE: u64 = 140;

#[test]
fn the_bound_is_above_the_error_on_a_share_of_the_random_problems() {
    let mut certified = 0;
    for number in 0..SHARE {
        let (kind, text) = tresca::case(number);
        let found = tresca::trial(number, 1).unwrap();
        println!("{number}, {kind}: {found:?}");
        match found {
            Outcome::Certified { bound, error } => {
                certified += 1;
                assert!(bound >= error, "{number}, {kind}: {bound} {error}\n{text}");
            }
            Outcome::NotValid { .. } | Outcome::Refused(_) => {}
        }
    }
    assert!(10 * certified >= 9 * SHARE, "{certified} of {SHARE}");
}

#[test]
fn the_bound_of_the_default_settings_is_within_a_fifth_of_the_error() {
    for s in [1.0, 4.0, 8.0] {
        let problem = blocks([18, 9], Friction::tresca(s)).unwrap();
        let Outcome::Certified { bound, error } = outcome(problem, 3).unwrap() else { panic!("s = {s}") };
        println!("s = {s}: bound {bound:.6}, error {error:.6}, effectivity {:.4}", bound / error);
        assert!(bound >= error && bound <= 1.2 * error, "s = {s}: {bound} {error}");
    }
}

#[test]
fn closed_contact_that_sticks_is_a_bond() {
    let of = |young: f64| LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
    // The same cells as in the two blocks on each other.
    let mesh = block([0.0, 0.0], [2.0, 2.0], [12, 12]).unwrap();
    let above = |t: usize| mesh.corners(t).iter().map(|x| x[1]).sum::<f64>() > 3.0;
    let of_triangle = (0..mesh.cells().len()).map(|t| u32::from(above(t))).collect();
    let materials = Materials::by_cell(vec![of(1000.0), of(2000.0)], of_triangle);
    let moved = || Some(ScalarData::from(0.004));
    let down = || Some(ScalarData::function(|x: Vector| -0.02 - 0.002 * x[0]));
    let top = BoundaryConditions::new().displace("top", moved(), down());
    let bonded = Body::new(mesh, materials, &top.clone().fix("bottom")).unwrap();
    let whole = tests::run::solve_alone(&bonded);
    let problem =
        tests::friction::two_blocks([12, 6], &top, &BoundaryConditions::new().fix("bottom")).unwrap();
    for s in [1e3, 1e6, 1e12] {
        let problem = problem.clone().with_friction(0, Friction::tresca(s)).unwrap();
        let ((exact, displacement), estimate) = estimated(&problem, Relaxation::Steps(2));
        assert!(exact.contact_force[0].iter().all(|p| *p > 0.0), "the contact is closed");
        assert!(estimate.certificate().is_some());
        let mut apart = 0.0f64;
        for (body, u) in problem.bodies.iter().zip(&displacement) {
            for (x, u) in body.mesh().points().iter().zip(u) {
                let node = bonded.mesh().points().iter().position(|y| (x - y).norm() < 1e-12).unwrap();
                apart = apart.max((u - whole[node]).norm());
            }
        }
        println!("s = {s:e}: {apart:e} apart");
        assert!(apart <= 1e-9 * 0.024, "s = {s}: {apart:e}");
    }
}

//! Load steps: what friction keeps of the path of the loads.

use certified_contact::nndd::{CoulombSettings, CoulombStatus};
use certified_contact::{CertifiedSolution, LoadSteps, Settings, Silent, SolveError, solve};
use cre_estimator::Relaxation;
use fem_core::body::{ConditionList, ConditionPlace};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction, InterfaceError, LoadFactorError, SlipBefore};
use fem_core::mesh::refine::RefinementEdges;
use fem_core::norm::energy_distance_squared;
use fem_core::prepared::{PreparedProblem, Stage};
use tests::friction::{PATCH_SLIP, SHEARED_BY, blocks, pushed_over_plane, rings, sheared};
use tests::prepare;

/// Factors of [`sheared`]: how far the top is moved of what shears and slips, and the shear on the sides.
fn shear(moved: f64, traction: f64) -> impl Fn(usize, ConditionPlace) -> f64 {
    move |_, place| match (place.list, place.index) {
        (ConditionList::Displacement, 0) => moved,
        (ConditionList::Traction, 2 | 3) => traction,
        _ => 1.0,
    }
}

fn certified(solution: &CertifiedSolution) -> f64 {
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{:?}", estimate.admissibility);
    estimate.certificate().unwrap().e_cre
}

#[test]
fn a_cycle_of_constant_shear_has_its_exact_slips() {
    // The top moves by u = q/3 · SHEARED_BY + w: friction q sticks below 3.
    let top = SHEARED_BY + PATCH_SLIP;
    // Forwards to slip, back within stick, back to slip the other way, forwards within stick.
    let path = [
        (top, 3.0, PATCH_SLIP),
        (top - SHEARED_BY, 0.0, 0.0),
        (top - 2.0 * SHEARED_BY - 0.001, -3.0, -0.001),
        (top - 0.5 * SHEARED_BY - 0.001, 1.5, 0.0),
        (top, 3.0, 0.001),
    ];
    let mut steps = LoadSteps::new(sheared([8, 4], Friction::tresca(3.0)).unwrap());
    for (k, (u, q, slip)) in path.into_iter().enumerate() {
        let solution = steps.solve(shear(u / top, q / 3.0), &Settings::default(), &mut Silent).unwrap();
        let bound = certified(&solution) / solution.estimate.as_ref().unwrap().energy_norm();
        println!("step {k}: bound {bound:.1e}");
        // A bound of round-off is its square root.
        assert!(bound < 1e-6, "step {k}: {bound:e}");
        let found = &solution.last().tangential;
        for w in &found.slip {
            assert!((w - slip).abs() < 1e-12, "step {k}: {w} {slip}");
        }
        let friction = solution.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap().force;
        assert!((friction - 2.0 * q).abs() < 1e-9, "step {k}: {friction} {q}");
    }
    assert_eq!(steps.count(), 5);
}

/// Makes the factors of [`blocks`]: `top` for the displacements of the first body, `traction` for its tractions, 1 for all else.
fn loaded(top: f64, traction: f64) -> impl Fn(usize, ConditionPlace) -> f64 {
    move |body, place| match (body, place.list) {
        (0, ConditionList::Displacement) => top,
        (0, ConditionList::Traction) => traction,
        _ => 1.0,
    }
}

#[test]
fn a_step_without_new_loads_changes_nothing() {
    let settings = Settings::default();
    for problem in [
        blocks([18, 9], Friction::tresca(4.0)).unwrap(),
        rings(0.02, [12, 3], Friction::tresca(4.0)).unwrap(),
    ] {
        let alone = solve(problem.clone(), &settings, &mut Silent).unwrap();
        let mut steps = LoadSteps::new(problem);
        let first = steps.solve(|_, _| 1.0, &settings, &mut Silent).unwrap();
        assert_eq!(certified(&alone), certified(&first));
        let again = steps.solve(|_, _| 1.0, &settings, &mut Silent).unwrap();
        certified(&again);
        let fields = [&alone, &again].map(|of| &of.estimate.as_ref().unwrap().pair.bodies);
        for (one, two) in fields[0].iter().zip(fields[1]) {
            for (u, v) in one.displacement.iter().zip(&two.displacement) {
                assert!((u - v).norm() < 1e-13, "{u} {v}");
            }
        }
        let slip = &again.last().tangential.slip;
        assert!(slip.iter().all(|w| w.abs() < 1e-14), "{slip:?}");
    }
}

#[test]
fn the_bound_of_a_step_is_above_the_error_of_its_increment() {
    for (cells, limit, second) in
        [([8, 4], 4.0, (1.0, 0.0)), ([12, 6], 2.0, (1.0, -1.0)), ([8, 4], 1.0, (0.7, 0.4))]
    {
        let mut steps = LoadSteps::new(blocks(cells, Friction::tresca(limit)).unwrap());
        certified(&steps.solve(loaded(1.0, 1.0), &Settings::default(), &mut Silent).unwrap());
        let solution = steps.solve(loaded(second.0, second.1), &Settings::default(), &mut Silent).unwrap();
        let bound = certified(&solution);
        let fields: Vec<Vec<Vector>> = solution
            .estimate
            .as_ref()
            .unwrap()
            .pair
            .bodies
            .iter()
            .map(|body| body.displacement.clone())
            .collect();
        // The same step on a finer mesh, from the same slip.
        let (mut problem, mut u) = (solution.problem.clone(), fields);
        for _ in 0..2 {
            (problem, u) = finer(problem, &u);
        }
        let fine = solve(problem, &Settings::default(), &mut Silent).unwrap();
        certified(&fine);
        let finest = &fine.estimate.as_ref().unwrap().pair.bodies;
        let squared = fine.problem.bodies.iter().zip(&u).zip(finest);
        let error =
            squared.map(|((body, u), v)| energy_distance_squared(body, u, &v.displacement)).sum::<f64>();
        println!("s = {limit}: {bound:.4e} {:.4e} {:.3}", error.sqrt(), bound / error.sqrt());
        assert!(bound >= error.sqrt() && bound < 1.6 * error.sqrt(), "{bound} {}", error.sqrt());
    }
}

/// Halves all cells, and takes displacements and the slip before the step along. The contact line is straight.
fn finer(problem: ContactProblem, u: &[Vec<Vector>]) -> (ContactProblem, Vec<Vec<Vector>>) {
    let mut from_rest = problem;
    let before: Vec<Option<SlipBefore>> =
        from_rest.contacts.iter_mut().map(|pair| pair.slip_before.take()).collect();
    let edges: Vec<RefinementEdges> =
        from_rest.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    let marked: Vec<Vec<bool>> =
        from_rest.bodies.iter().map(|body| vec![true; body.mesh().topology().facets().len()]).collect();
    let found = contact_geometry::refined(&from_rest, &edges, &marked).unwrap();
    let u = found.refinements.iter().zip(u).map(|(refinement, u)| refinement.prolong(u)).collect();
    let mut problem = found.problem;
    for (k, before) in before.into_iter().enumerate() {
        let Some(before) = before else { continue };
        let parents = &found.pairs[k].parents;
        let rows: Vec<f64> = parents
            .iter()
            .map(|of| 0.5 * (before.rows[of[0] as usize] + before.rows[of[1] as usize]))
            .collect();
        let pair = &problem.contacts[k];
        let of_edge = |edge: &fem_core::interface::ContactFacet| {
            edge.pairs.map(|i| pair.along_tangents(i as usize, &rows))
        };
        let jumps = pair.interface.facets().iter().map(of_edge).collect();
        problem = problem.with_slip(k, SlipBefore::new(rows, jumps)).unwrap();
    }
    (problem, u)
}

#[test]
fn a_cycle_dissipates_in_every_step_and_repeats() {
    // Pressed, then sheared there and back in 20 steps, twice.
    let mut steps = LoadSteps::new(blocks([18, 9], Friction::tresca(4.0)).unwrap());
    let path = (0..=20).map(|k: i32| 1.0 - f64::from((k % 20 - 10).abs()) / 10.0);
    let mut loops: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut dissipated = 0.0;
    for _ in 0..3 {
        let mut found = Vec::new();
        for amount in path.clone() {
            let factor = move |body, place: ConditionPlace| match (body, place.list) {
                (0, ConditionList::Traction) => 10.0 * amount,
                _ => 1.0,
            };
            let solution = steps.solve(factor, &Settings::default(), &mut Silent).unwrap();
            certified(&solution);
            let tangential = &solution.last().tangential;
            let work: f64 = tangential.force.iter().zip(&tangential.slip).map(|(q, w)| q * w).sum();
            assert!(work >= 0.0, "{work}");
            dissipated += work;
            found.push([amount, tangential.force.iter().sum()]);
        }
        loops.push(found);
    }
    assert!(dissipated > 0.0);
    // The first loop starts from rest; the others are the same.
    for (a, b) in loops[1].iter().zip(&loops[2]) {
        assert!((a[1] - b[1]).abs() < 1e-9 * b[1].abs().max(1.0), "{a:?} {b:?}");
    }
    let there_and_back = loops[1][5][1] - loops[1][15][1];
    println!("dissipated {dissipated:.3e}, half way there and back {there_and_back:.3e}");
    assert!(there_and_back.abs() > 1e-3, "the loop has no area: {there_and_back}");
}

#[test]
fn coulomb_friction_takes_steps_too() {
    let problem = pushed_over_plane(16, Friction::Coulomb { mu: 1.0 }).unwrap();
    let settings = CoulombSettings::default();
    let relaxation = Relaxation::Steps(2);
    let pushed = |amount: f64| {
        move |_, place: ConditionPlace| match (place.list, place.index) {
            (ConditionList::Traction, 0) => amount,
            _ => 1.0,
        }
    };
    let solved = |steps: &mut LoadSteps, amount: f64| {
        let found = steps.solve_coulomb(pushed(amount), &settings, relaxation, &mut Silent).unwrap();
        assert_eq!(found.solution.status, CoulombStatus::Converged);
        found
    };
    let at_once = solved(&mut LoadSteps::new(problem.clone()), 1.0);
    let mut steps = LoadSteps::new(problem);
    for amount in [0.5, 1.0] {
        solved(&mut steps, amount);
    }
    let again = solved(&mut steps, 1.0);
    let largest = again.solution.exact.friction[0].slip.iter().fold(0.0f64, |m, w| m.max(w.abs()));
    println!("{largest:e}");
    // The fixed point has a tolerance of 1e-6.
    assert!(largest < 1e-6, "{largest:e}");
    let [a, b] = [&at_once, &again].map(|of| of.displacement()[0][0][0]);
    println!("{a} {b}");
    // A monotone path: the same but for what slipped at the smaller pressure.
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
    // Unloaded, friction holds a part of the shift.
    let back = solved(&mut steps, 0.5).displacement()[0][0][0];
    let half =
        solved(&mut LoadSteps::new(pushed_over_plane(16, Friction::Coulomb { mu: 1.0 }).unwrap()), 0.5);
    let half = half.displacement()[0][0][0];
    println!("{half} {back}");
    assert!(back > half, "{half} {back}");
}

#[test]
fn slip_that_does_not_fit_and_refinement_of_a_later_step_are_refused() {
    let problem = blocks([4, 2], Friction::tresca(4.0)).unwrap();
    let nodes = problem.contacts[0].interface.pairs().len();
    let rest = Vector::zeros();
    for (nodes, edges, of) in [
        (vec![0.0; nodes - 1], vec![[rest; 2]; nodes - 1], "rows along tangents"),
        (vec![f64::NAN; nodes], vec![[rest; 2]; nodes - 1], "rows along tangents"),
        (vec![0.0; nodes], vec![[rest; 2]; nodes], "edges"),
        (vec![0.0; nodes], vec![[rest, Vector::new(0.0, f64::INFINITY)]; nodes - 1], "edges"),
    ] {
        let error = problem.clone().with_slip(0, SlipBefore::new(nodes, edges)).unwrap_err();
        assert!(matches!(&error, InterfaceError::BadSlip { of: found, .. } if *found == of), "{error}");
    }
    let fitting = SlipBefore::new(vec![0.0; nodes], vec![[rest; 2]; nodes - 1]);
    let problem = problem.with_slip(0, fitting).unwrap();
    let edges: Vec<RefinementEdges> =
        problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect();
    let marked: Vec<Vec<bool>> =
        problem.bodies.iter().map(|body| vec![true; body.mesh().topology().facets().len()]).collect();
    let error = contact_geometry::refined(&problem, &edges, &marked).unwrap_err().to_string();
    assert!(error.contains("refine the problem before its first step"), "{error}");
    // Factors that contradict each other.
    let mut steps = LoadSteps::new(problem);
    let wrong = steps.solve(|_, _| f64::NAN, &Settings::default(), &mut Silent).unwrap_err();
    assert!(matches!(wrong, SolveError::Factors(LoadFactorError::Body { body: 0, .. })), "{wrong}");
    assert_eq!(steps.count(), 0);
}

#[test]
fn bodies_with_other_loads_are_those_of_a_fresh_factorisation() {
    let problems = [
        blocks([8, 4], Friction::tresca(4.0)).unwrap(),
        rings(0.02, [12, 3], Friction::tresca(4.0)).unwrap(),
        pushed_over_plane(8, Friction::Coulomb { mu: 0.5 }).unwrap(),
        tests::assemblies::stamped().unwrap(),
    ];
    for problem in problems {
        let other =
            problem.with_factors(&|_, place| if place.index == 0 { 0.37 } else { -1.5 }, &|_| 1.0).unwrap();
        let (_, bodies) = prepare(&problem).into_parts();
        let again = PreparedProblem::prepare_again(other.clone(), bodies, &[], |stage| {
            assert_ne!(stage, Stage::Factorisation);
            true
        });
        let (again, fresh) = (again.unwrap(), prepare(&other));
        for (one, two) in again.bodies().iter().zip(fresh.bodies()) {
            let [one, two] = [one, two].map(|body| body.whole().unwrap());
            assert_eq!(one.interface().condensed_load(), two.interface().condensed_load());
            let none = vec![0.0; one.interface().len()];
            assert_eq!(one.displacement_from_force(&none), two.displacement_from_force(&none));
            assert_eq!(one.dofs().traces(&none), two.dofs().traces(&none));
        }
        assert_eq!(again.external_forces(), fresh.external_forces());
    }
}

#[test]
fn bodies_with_other_supports_are_factorised_again() {
    let (_, bodies) = prepare(&blocks([8, 4], Friction::None).unwrap()).into_parts();
    let mut stages = Vec::new();
    let held = BoundaryConditions::new().fix("left");
    let free = tests::friction::two_blocks([8, 4], &held, &BoundaryConditions::new().fix("bottom")).unwrap();
    let again = PreparedProblem::prepare_again(free.clone(), bodies, &[], |stage| {
        stages.push(stage);
        true
    });
    let (again, fresh) = (again.unwrap(), prepare(&free));
    assert!(stages.contains(&Stage::Factorisation));
    for (one, two) in again.bodies().iter().zip(fresh.bodies()) {
        let [one, two] = [one, two].map(|body| body.whole().unwrap());
        assert_eq!(one.interface().schur(), two.interface().schur());
    }
}

//! Friction: the exact solution with the laws of Tresca and Coulomb, against the figures of an independent code.

use contact_qp::{QpMethod, QpSettings};
use fem_core::boundary::ScalarData;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction, Partner, Roles};
use fem_core::norm::{energy_distance_squared, energy_norm_squared};
use nndd::stopping::Never;
use nndd::{
    Acceleration, CoulombSettings, CoulombSolution, CoulombStatus, ExactSolution, Method, NewtonSettings,
    NnddError, NnddSettings, NnddStatus, NodeState, Weights, solve_coulomb, solve_exactly, stiffer_roles,
};
use tests::friction::{
    PATCH, PATCH_SLIP, PATCH_TRACTION, blocks, patch, pushed_middle, pushed_over_plane, slope,
};
use tests::random::Random;
use tests::run::unresisted;
use tests::{iterates, prepare};

const CELLS: [usize; 2] = [18, 9];

fn coulomb(mu: f64) -> Friction {
    Friction::Coulomb { mu }
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

fn energies(problem: &ContactProblem, solution: &ExactSolution) -> Vec<f64> {
    problem
        .bodies
        .iter()
        .zip(displacement(problem, solution))
        .map(|(body, u)| energy_norm_squared(body, &u))
        .collect()
}

/// The states from left to right: | stick, > or < slip, o open.
fn zones(solution: &ExactSolution) -> String {
    let friction = &solution.friction[0];
    let mark = |(state, w): (&NodeState, &f64)| match state {
        NodeState::Open => 'o',
        NodeState::Stick => '|',
        NodeState::Slip if *w < 0.0 => '<',
        NodeState::Slip => '>',
    };
    friction.state.iter().zip(&friction.slip).map(mark).collect()
}

fn solved(problem: &ContactProblem) -> ExactSolution {
    let solution = solve_exactly(&prepare(problem).system(), &QpSettings::default()).unwrap();
    assert!(solution.status.is_solved() && solution.kkt.max() < 1e-12, "{:?}", solution.kkt);
    solution
}

fn converged(problem: &ContactProblem) -> CoulombSolution {
    let mut settings = CoulombSettings::default();
    (settings.tolerance, settings.max_steps) = (1e-13, 80);
    let found = solve_coulomb(&prepare(problem).system(), &settings, None, || true).unwrap();
    assert_eq!(found.status, CoulombStatus::Converged, "{:?}", found.changes);
    found
}

fn displacement(problem: &ContactProblem, exact: &ExactSolution) -> Vec<Vec<Vector>> {
    prepare(problem).displacements(&exact.fields)
}

/// Checks the nodal law: `|Q| ≤ S`, `Q w = S|w|`, exactly.
fn obeys_the_law(solution: &ExactSolution) {
    for (pair, (forces, openings)) in
        solution.friction.iter().zip(solution.contact_force.iter().zip(&solution.opening))
    {
        assert!(forces.iter().zip(openings).all(|(p, o)| *p >= 0.0 && *o >= 0.0 && p * o == 0.0));
        for i in 0..pair.force.len() {
            let (q, w, s) = (pair.force[i], pair.slip[i], pair.limit[i]);
            assert!(q.abs() <= s && (q * w - s * w.abs()).abs() == 0.0, "{i}: {q} {w} {s}");
        }
    }
}

fn has_figures(solution: &ExactSolution, problem: &ContactProblem, figures: [f64; 4], expected_zones: &str) {
    let [a1, a2, p, q] = figures;
    let found = energies(problem, solution);
    near(found[0], a1, 1e-9);
    near(found[1], a2, 1e-9);
    near(solution.contact_force[0].iter().sum(), p, 1e-9);
    near(solution.friction[0].force.iter().sum(), q, 1e-9);
    assert_eq!(zones(solution), expected_zones);
}

#[test]
fn tresca_has_the_figures_of_an_independent_code() {
    for (s, figures, expected) in [
        (1.0, [0.720365609154, 0.333137473681, 26.3958519702, 2.0], ">>>>>>>>>>>>>>>>ooo"),
        (4.0, [0.666934838661, 0.367422533138, 26.4209920856, 4.92638439911], "|||||||||||>>>>>ooo"),
        (8.0, [0.647810929286, 0.382005942119, 26.3779648973, 5.14956987778], "||||||||||||||||ooo"),
    ] {
        let problem = blocks(CELLS, Friction::tresca(s)).unwrap();
        let solution = solved(&problem);
        obeys_the_law(&solution);
        assert_eq!(solution.clarabel_calls, 0);
        has_figures(&solution, &problem, figures, expected);
        if s == 4.0 {
            near(*solution.friction[0].slip.last().unwrap(), 5.618746904e-3, 1e-9);
        }
    }
}

#[test]
fn coulomb_has_the_figures_of_an_independent_code() {
    for (mu, figures, expected) in [
        (0.3, [0.698430686688, 0.354783326205, 26.4822308467, 4.54856899229], "||||||||||>>>>>>ooo"),
        (0.6, [0.682882125647, 0.364235756451, 26.4540475087, 4.86635337656], "|||||||||||||>>>ooo"),
    ] {
        let problem = blocks(CELLS, coulomb(mu)).unwrap();
        let found = converged(&problem);
        obeys_the_law(&found.exact);
        has_figures(&found.exact, &problem, figures, expected);
        assert!(found.restarts == 0 && found.steps < 20, "{} steps", found.steps);
    }
}

#[test]
fn a_patch_slips_as_it_must() {
    let [p, s] = PATCH_TRACTION;
    let problems = [patch(Friction::tresca(s)).unwrap(), patch(coulomb(s / p)).unwrap()];
    let solutions = [solved(&problems[0]), converged(&problems[1]).exact];
    for (problem, solution) in problems.iter().zip(&solutions) {
        energies(problem, solution)
            .iter()
            .zip(PATCH)
            .for_each(|(found, expected)| near(*found, expected, 1e-9));
        for (node, i) in problem.contacts[0].interface.pairs().iter().zip(0..) {
            near(solution.contact_force[0][i], p * node.weight, 1e-10);
            near(solution.friction[0].force[i], s * node.weight, 1e-10);
            near(solution.friction[0].slip[i], PATCH_SLIP, 1e-10);
        }
    }
}

#[test]
fn no_limit_is_no_friction_and_a_large_one_is_a_bond() {
    let of = |friction: Friction| {
        let problem = blocks(CELLS, friction).unwrap();
        let exact = solved(&problem);
        (displacement(&problem, &exact), exact)
    };
    let largest = |a: &[Vec<Vector>], b: &[Vec<Vector>]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    assert!(largest(&of(Friction::None).0, &of(Friction::tresca(0.0)).0) < 1e-14);
    // Full stick is the same from some limit on.
    let [(u, a), (v, _)] = [1e2, 1e6].map(|s| of(Friction::tresca(s)));
    assert!(largest(&u, &v) < 1e-14 && a.friction[0].slip.iter().all(|w| *w == 0.0));
}

#[test]
fn roles_and_the_order_of_the_bodies_do_not_matter() {
    let problem = blocks([8, 4], Friction::tresca(4.0)).unwrap();
    let exchanged = tests::run::exchanged(problem.clone()).with_friction(0, Friction::tresca(4.0)).unwrap();
    let (a, b) = (solved(&problem), solved(&exchanged));
    // The normal points the other way, and the line is walked the other way: the slip of each pair keeps its sign.
    for i in 0..9 {
        let node = exchanged.contacts[0]
            .interface
            .pairs()
            .iter()
            .position(|p| p.nodes[1] == problem.contacts[0].interface.pairs()[i].nodes[0])
            .unwrap();
        assert!((a.friction[0].slip[i] - b.friction[0].slip[node]).abs() < 1e-14);
        near(b.friction[0].force[node], a.friction[0].force[i], 1e-10);
    }
}

#[test]
fn friction_holds_a_floating_body_up_to_its_capacity() {
    // Two lines of 2 with s = 4 resist 16.
    for push in [6.0, 14.0] {
        let problem = pushed_middle(push, CELLS, &Friction::tresca(4.0)).unwrap();
        let solution = solved(&problem);
        obeys_the_law(&solution);
        let forces: Vec<f64> = solution.friction.iter().map(|of| of.force.iter().sum()).collect();
        // Friction on the middle block: −Q t of the lower pair with t = (1, 0), + Q of the upper one.
        near(forces[1] - forces[0], -push, 1e-10);
    }
    let problem = pushed_middle(17.0, CELLS, &Friction::tresca(4.0)).unwrap();
    let motion = unresisted(&problem);
    let (body, moved) = &motion.bodies[0];
    assert_eq!((motion.bodies.len(), *body), (1, Partner::Body(1)));
    assert!((moved.translation - Vector::x()).norm() < 1e-9, "{moved:?}");
    near(motion.load, 1.0, 1e-9);
    // Without friction nothing resists.
    let free = pushed_middle(0.1, CELLS, &Friction::None).unwrap();
    assert!(matches!(
        solve_exactly(&prepare(&free).system(), &QpSettings::default()),
        Err(NnddError::NotHeld { .. })
    ));
}

#[test]
fn a_block_stays_on_a_slope_below_its_angle_of_friction() {
    // A body between two others: its friction is far from proportional to the pressure.
    for push in [2.0, 6.0, 9.0] {
        let problem = pushed_middle(push, CELLS, &coulomb(0.3)).unwrap();
        let found = converged(&problem);
        obeys_the_law(&found.exact);
        println!("push {push}: {} steps, {} restarts", found.steps, found.restarts);
        let forces: Vec<f64> = found.exact.friction.iter().map(|of| of.force.iter().sum()).collect();
        near(forces[1] - forces[0], -push, 1e-9);
    }
    for (tangent, mu) in [(0.2, 0.5), (0.45, 0.5), (0.49, 0.5)] {
        let problem = slope(tangent, [12, 6], coulomb(mu)).unwrap();
        let found = converged(&problem);
        obeys_the_law(&found.exact);
        // The weight is 20.
        near(found.exact.contact_force[0].iter().sum(), 20.0, 1e-10);
        near(found.exact.friction[0].force.iter().sum(), 20.0 * tangent, 1e-10);
    }
    let steep = slope(0.6, [12, 6], coulomb(0.5)).unwrap();
    match solve_coulomb(&prepare(&steep).system(), &CoulombSettings::default(), None, || true) {
        // No forces in the cones balance it.
        Err(NnddError::OutsideCones { motion }) => assert!(motion.work > 0.0),
        Ok(found) => panic!("{:?}", found.status),
        Err(other) => panic!("{other:?}"),
    }
    // The law of Coulomb is no programme.
    let slope = slope(0.2, [12, 6], coulomb(0.5)).unwrap();
    let refused = solve_exactly(&prepare(&slope).system(), &QpSettings::default());
    assert!(matches!(refused, Err(NnddError::Coulomb { pair: 0 })), "{refused:?}");
}

#[test]
fn a_block_pushed_over_a_plane_has_the_figures_of_an_independent_code() {
    for (cells, energy, friction, corner) in [
        (16, 216.341504105, 1416.20082867, 0.0283401251693),
        (32, 216.471147504, 1408.12042811, 0.0285256651388),
    ] {
        let problem = pushed_over_plane(cells, coulomb(1.0)).unwrap();
        let found = converged(&problem);
        obeys_the_law(&found.exact);
        near(energies(&problem, &found.exact)[0], energy, 1e-9);
        near(found.exact.contact_force[0].iter().sum(), 2000.0, 1e-10);
        near(found.exact.friction[0].force.iter().sum(), friction, 1e-9);
        let mesh = problem.bodies[0].mesh();
        let node = mesh.points().iter().position(|x| x.norm() < 1e-9).unwrap();
        near(displacement(&problem, &found.exact)[0][node][0], corner, 1e-9);
    }
}

/// The settings of an iteration with the condensed operators.
fn iteration(weights: Weights, acceleration: Acceleration, theta: Option<f64>) -> NnddSettings {
    let mut settings = NnddSettings::default();
    (settings.weights, settings.acceleration, settings.theta) = (weights, acceleration, theta);
    settings.max_iterations = 250;
    settings
}

#[test]
fn the_first_bounds_of_the_iteration_are_those_of_an_independent_code() {
    let prepared = prepare(&blocks(CELLS, Friction::tresca(4.0)).unwrap());
    let settings = iteration(Weights::Half, Acceleration::None, Some(0.4));
    let (_, all) = iterates(&prepared, &settings, 1e-2).unwrap();
    for (iterate, expected) in all.iter().zip([1.332691243, 0.3523267742, 0.2279476676, 0.1558286877]) {
        near(iterate.eta_nndd, expected, 1e-9);
    }
    assert!(all.len() >= 4);
}

#[test]
fn the_iteration_converges_to_the_exact_solution_in_as_many_steps_as_an_independent_code() {
    let anderson = |weights| iteration(weights, Acceleration::Anderson, None);
    let plain = iteration(Weights::Stiffness, Acceleration::None, Some(1.0));
    let paper = iteration(Weights::Half, Acceleration::None, Some(0.4));
    for (s, counts) in [(1.0, [16, 23, 31, 87]), (4.0, [17, 21, 30, 104]), (8.0, [16, 19, 27, 106])] {
        for roles in [Roles::FIRST, Roles::SECOND] {
            let problem = blocks(CELLS, Friction::tresca(s)).unwrap().with_roles(roles);
            let prepared = prepare(&problem);
            let exact = solved(&problem);
            let displacement = displacement(&problem, &exact);
            let size = energies(&problem, &exact).iter().sum::<f64>().sqrt();
            let all = [anderson(Weights::Stiffness), anderson(Weights::Half), plain.clone(), paper.clone()];
            for (k, (settings, count)) in all.iter().zip(counts).enumerate() {
                // The paper's settings take long: with the stiffer body alone.
                if roles == Roles::SECOND && k > 0 {
                    continue;
                }
                let (solution, iterates) = iterates(&prepared, settings, 1e-10).unwrap();
                assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
                for iterate in &iterates {
                    let u = prepared.displacements(&iterate.fields(&prepared.system()));
                    let squared = problem.bodies.iter().zip(u.iter().zip(&displacement));
                    let squared: f64 =
                        squared.map(|(body, (u, v))| energy_distance_squared(body, u, v)).sum();
                    assert!(iterate.eta_nndd >= squared.sqrt() - 1e-10 * size, "{}", iterate.iteration);
                }
                let found = iterates.len();
                println!("s = {s}, {roles:?}, {k}: {found} iterations, {count} in the reference");
                if roles == Roles::FIRST {
                    assert!(10 * found.abs_diff(count) <= 3 * count, "{found} {count}");
                }
                for (found, expected) in solution.last.tangential.force.iter().zip(&exact.friction[0].force) {
                    assert!((found - expected).abs() < 1e-7, "{found} {expected}");
                }
            }
        }
    }
}

#[test]
fn the_iteration_holds_floating_bodies_by_friction() {
    let problem = pushed_middle(6.0, CELLS, &Friction::tresca(4.0)).unwrap();
    let mut prepared = prepare(&problem);
    for (k, roles) in stiffer_roles(&prepared.system()).into_iter().enumerate() {
        prepared.set_roles(k, roles);
    }
    let (solution, _) =
        iterates(&prepared, &iteration(Weights::Stiffness, Acceleration::Anderson, None), 1e-10).unwrap();
    assert_eq!(solution.status, NnddStatus::StoppedByCriterion);
    println!("{} iterations", solution.history.len());
    let exact = solved(&problem);
    let u = prepared.displacements(&solution.last.fields(&prepared.system()));
    let displacement = displacement(&problem, &exact);
    let squared = problem.bodies.iter().zip(u.iter().zip(&displacement));
    let squared: f64 = squared.map(|(body, (u, v))| energy_distance_squared(body, u, v)).sum();
    assert!(squared.sqrt() < 1e-9, "{squared:e}");
}

#[test]
fn what_friction_does_not_support_is_refused() {
    let prepared = prepare(&blocks([8, 4], Friction::tresca(4.0)).unwrap());
    // λ has both components.
    let short = nndd::solve(&prepared.system(), vec![0.0; 9], NnddSettings::default(), &mut Never);
    assert!(matches!(short, Err(NnddError::Length { found: 9, expected: 18, .. })), "{short:?}");
    let prepared = prepare(&blocks([8, 4], coulomb(0.3)).unwrap());
    for method in [Method::from(NnddSettings::default()), NewtonSettings::default().into()] {
        let refused = nndd::solve(&prepared.system(), vec![0.0; 18], method, &mut Never);
        assert!(matches!(refused, Err(NnddError::Coulomb { pair: 0 })), "{refused:?}");
    }
    for (friction, said) in [
        (Friction::tresca(-1.0), "the friction limit at (0, 1) is -1"),
        (Friction::tresca(f64::NAN), "NaN"),
        (coulomb(-0.1), "the coefficient of friction is -0.1"),
        (coulomb(f64::INFINITY), "inf"),
    ] {
        let error = blocks([8, 4], friction).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn sixty_exact_solutions_agree_with_an_interior_point_method() {
    let mut random = Random::new(41);
    let mut without = 0;
    for k in 0..60 {
        let [a, b] = [10.0 * random.unit(), 10.0 * random.unit()];
        let friction = Friction::tresca(ScalarData::function(move |x: Vector| a + 0.5 * (b - a) * x[0]));
        let problem = match k % 2 {
            0 => blocks([6 + k / 4, 4], friction).unwrap(),
            // The lines of 2 resist a + b each.
            _ => pushed_middle(1.99 * (a + b) * random.unit(), [6 + k / 4, 4], &friction).unwrap(),
        };
        let prepared = prepare(&problem);
        let found = solve_exactly(&prepared.system(), &QpSettings::default()).unwrap();
        let judge = QpSettings::default().with_method(QpMethod::Clarabel);
        let judge = solve_exactly(&prepared.system(), &judge).unwrap();
        assert!(found.status.is_solved() && judge.status.is_solved(), "{k}");
        obeys_the_law(&found);
        without += usize::from(found.clarabel_calls == 0);
        let [u, v] = [&found, &judge].map(|of| prepared.displacements(&of.fields).concat());
        assert!(u.iter().zip(&v).all(|(u, v)| (u - v).norm() < 1e-9), "{k}");
    }
    println!("{without} of 60 without Clarabel");
    assert!(without >= 57, "{without}");
}

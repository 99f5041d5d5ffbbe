//! Newton's method on the set of closed pairs with Neumann-Neumann steps inside.

use case_io::Case;
use certified_contact::support;
use contact_qp::QpSettings;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::ContactProblem;
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::PreparedProblem;
use nndd::stopping::{Decision, EtaNndd, StoppingCriterion};
use nndd::{
    ActiveSet, ExactSolution, Iterate, Method, NewtonSettings, NnddSolution, NnddStatus, Start,
    solve_exactly, solve_from, stiffer_roles,
};
use tests::assemblies::{THREE_FORCES, four, pressed, stack, stamped, three, tower};
use tests::blocks::Blocks;
use tests::rollers::Roller;
use tests::run::norm_and_distance;
use tests::{prepare, random_assemblies};

/// Random assemblies in one run of the tests.
const ASSEMBLIES: u64 = 60;

/// Keeps every iterate until `η ≤ tolerance · η(1)`.
struct All {
    stop: EtaNndd,
    iterates: Vec<Iterate>,
}

impl StoppingCriterion for All {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        self.iterates.push(iterate.clone());
        self.stop.check(iterate)
    }
}

fn prepared(problem: &ContactProblem) -> PreparedProblem {
    let mut prepared = prepare(problem);
    for (k, roles) in stiffer_roles(&prepared.system()).into_iter().enumerate() {
        prepared.set_roles(k, roles);
    }
    prepared
}

fn exact(prepared: &PreparedProblem) -> ExactSolution {
    solve_exactly(&prepared.system(), &QpSettings::default()).unwrap()
}

/// Solves to 1e-10 of the first bound, from a set if one is given.
fn solved(prepared: &PreparedProblem, active: Option<ActiveSet>) -> (NnddSolution, Vec<Iterate>) {
    let mut all = All { stop: EtaNndd::new(1e-10), iterates: Vec::new() };
    let start = Start { lambda: vec![0.0; prepared.node_pairs()], active };
    let method = Method::NewtonNn(NewtonSettings::default());
    (solve_from(&prepared.system(), start, &method, &mut all).unwrap(), all.iterates)
}

/// Counts inner iterations in all, and Newton steps.
fn counts(solution: &NnddSolution) -> [usize; 2] {
    let rows = &solution.history;
    let last_of_step = |k: &usize| rows.get(k + 1).is_none_or(|next| next.step[0] != rows[*k].step[0]);
    let inner = (0..rows.len()).filter(last_of_step).map(|k| rows[k].step[1]).sum();
    [inner, rows.last().map_or(0, |row| row.step[0])]
}

/// Checks every iterate: its bound is not below its distance from the discrete solution, and the last one has its forces.
fn check(prepared: &PreparedProblem, name: &str, solution: &NnddSolution, all: &[Iterate]) {
    let (exact, system) = (exact(prepared), prepared.system());
    let u = prepared.displacements(&exact.fields);
    for iterate in all {
        let v: Vec<Vec<Vector>> = prepared.displacements(&iterate.fields(&system));
        let [size, distance] = norm_and_distance(prepared.problem(), &u, &v);
        assert!(
            iterate.eta_nndd >= (1.0 - 1e-9) * distance - 1e-11 * size,
            "{name}, {:?}: {:e} {distance:e}",
            iterate.step,
            iterate.eta_nndd
        );
        assert!(iterate.opening.iter().chain(&iterate.contact.normal_reaction).all(|value| *value >= 0.0));
    }
    assert_eq!(solution.status, NnddStatus::StoppedByCriterion, "{name}");
    let expected = exact.contact_force.concat();
    let largest = expected.iter().fold(0.0f64, |most, p| most.max(*p));
    for (found, expected) in solution.last.contact.normal_reaction.iter().zip(&expected) {
        assert!((found - expected).abs() <= 1e-9 * largest, "{name}: {found} {expected}");
    }
}

/// The counts are those of an independent code from full contact, inner iterations and Newton steps, but that its open nodes are condensed, its
/// inner tolerance is 1e-2, and the last restart counts as a step.
#[test]
fn the_counts_are_those_of_an_independent_code() {
    let between = |young: &[f64]| stack(young, [18, 9], &BoundaryConditions::new(), &pressed());
    let two = |contrast: f64| Blocks::contrast(contrast).cells(80).problem();
    let cases = [
        ("stack", tower(3, [18, 9]), [9, 4]),
        ("5-stack", tower(5, [18, 9]), [12, 5]),
        ("9-stack", tower(9, [18, 9]), [16, 6]),
        ("4-cycle", four(), [7, 3]),
        ("3-cycle", three(true), [7, 2]),
        ("stack 1000, 10, 1000", between(&[1000.0, 10.0, 1000.0]), [5, 5]),
        ("stack 10, 1000, 1e5", between(&[10.0, 1000.0, 1e5]), [9, 4]),
        ("two blocks, 2", two(2.0), [7, 6]),
        ("two blocks, 20", two(20.0), [3, 2]),
        ("two blocks, 1/20", two(0.05), [8, 7]),
        ("two blocks, 1000", two(1000.0), [3, 2]),
        ("two blocks, 1/1000", two(0.001), [7, 7]),
    ];
    for (name, problem, [inner, steps]) in cases {
        let prepared = prepared(&problem.unwrap());
        let full = ActiveSet::new(vec![true; prepared.node_pairs()]);
        let (solution, all) = solved(&prepared, Some(full));
        let found = counts(&solution);
        println!("{name}: {found:?} inner iterations and steps, [{inner}, {steps}] in the reference");
        check(&prepared, name, &solution, &all);
        assert!(found[0] <= inner + 2 && found[1].abs_diff(steps) <= 1, "{name}: {found:?}");
    }
}

/// Rollers that contact alone holds, along vertical normals and along their own, have the forces of the exact solution. Sets shrink from half the
/// rim to a node or two, in 1 to 13 steps of few inner iterations.
#[test]
fn rollers_between_plates_have_the_forces_of_the_exact_solution() {
    let mut run = 0;
    for (number, vertical) in (0..8).flat_map(|number| [(number, true), (number, false)]) {
        let problem = Roller::new(number, vertical).unwrap().problem().unwrap();
        if support(&problem).unwrap().unresisted.is_some() {
            continue;
        }
        let prepared = prepared(&problem);
        let (solution, all) = solved(&prepared, None);
        let name = format!("roller {number}, vertical {vertical}");
        check(&prepared, &name, &solution, &all);
        let found = counts(&solution);
        println!("{name}: {found:?} inner iterations and steps");
        assert!(found[0] <= 25 && found[1] <= 13 && solution.clarabel_calls == 0, "{name}: {found:?}");
        run += 1;
    }
    assert_eq!(run, 16);
}

#[test]
fn rows_that_share_nodes_are_no_obstacle() {
    let prepared = prepared(&three(true).unwrap());
    let (solution, all) = solved(&prepared, None);
    check(&prepared, "3-cycle", &solution, &all);
    let blocks: Vec<_> = prepared.problem().blocks().collect();
    for (block, expected) in blocks.into_iter().zip(THREE_FORCES) {
        for found in solution.last.contact_forces_of(block) {
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
    }
}

#[test]
fn the_paper_begins_and_newton_ends() {
    for contrast in [2.0, 20.0, 0.05, 1000.0, 0.001] {
        let prepared = prepared(&Blocks::contrast(contrast).cells(80).problem().unwrap());
        let (solution, all) = solved(&prepared, None);
        check(&prepared, "two blocks", &solution, &all);
        // Two steps of the paper, and then few of Newton, whatever the contrast.
        assert!(solution.history.iter().take(2).all(|row| row.step == [0; 2]));
        assert!(
            solution.history.len() <= 6 && solution.last.step[0] <= 2,
            "{contrast}: {:?}",
            solution.history
        );
    }
}

#[test]
fn a_stamp_and_a_wall_are_bodies_like_others() {
    for (name, problem) in [("stamped", stamped()), ("4-cycle", four())] {
        let prepared = prepared(&problem.unwrap());
        let (solution, all) = solved(&prepared, None);
        check(&prepared, name, &solution, &all);
        let energies = |of: &Iterate| -> f64 {
            let u = prepared.displacements(&of.fields(&prepared.system()));
            prepared.problem().bodies.iter().zip(&u).map(|(body, u)| energy_norm_squared(body, u)).sum()
        };
        let expected = energies(&exact(&prepared).iterate(&prepared.system()));
        assert!((energies(&solution.last) - expected).abs() <= 1e-9 * expected, "{name}");
    }
}

#[test]
fn a_known_set_takes_one_step() {
    let prepared = prepared(&tower(5, [18, 9]).unwrap());
    let active = exact(&prepared).iterate(&prepared.system()).contact.active;
    let (solution, all) = solved(&prepared, Some(active));
    check(&prepared, "5-stack", &solution, &all);
    assert_eq!(solution.last.step[0], 1);
}

/// Bodies that touch without a load, or that supports move apart: forces are zero, and not what rounding leaves of a start that presses.
#[test]
fn forces_are_zero_if_nothing_presses() {
    let text = |rise: f64| {
        let body = |name: &str, y: f64, side: &str, uy: f64| {
            format!(
                "[[body]]\nname = \"{name}\"\nmaterial = \"m\"\n\
                 generator = {{ kind = \"block\", origin = [0.0, {y:?}], size = [2.0, 1.0], cells = [8, 4] }}\n\
                 [[body.displacement]]\non = \"{side}\"\nux = 0.0\nuy = {uy:?}\n"
            )
        };
        let contact =
            "[[contact]]\nbodies = [\"upper\", \"lower\"]\nsurfaces = [\"bottom\", \"top\"]\ngap = 0.0\n";
        let head = "schema = 1\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n";
        [head, &body("upper", 1.0, "top", rise), &body("lower", 0.0, "bottom", 0.0), contact].concat()
    };
    for rise in [0.0, 1e-3] {
        let case = Case::parse(&text(rise), "apart.toml", &[]).unwrap();
        let prepared = prepared(&case.build().unwrap().0);
        for active in [None, Some(ActiveSet::new(vec![true; prepared.node_pairs()]))] {
            let start = Start { lambda: vec![3e-4; prepared.node_pairs()], active };
            let method = Method::NewtonNn(NewtonSettings::default());
            let found = solve_from(&prepared.system(), start, &method, &mut EtaNndd::new(1e-10)).unwrap();
            assert_eq!((found.status, found.history.len()), (NnddStatus::StoppedByCriterion, 1), "{rise}");
            let Iterate { reaction, contact, eta_nndd, .. } = found.last;
            assert!(
                reaction.iter().chain(&contact.normal_reaction).all(|p| *p == 0.0),
                "{rise}: {reaction:?}"
            );
            assert_eq!(eta_nndd, 0.0);
        }
    }
}

/// Sets that come back for ever if all wrong rows change sides: Clarabel and active sets find the right one, which Newton's method completes.
#[test]
fn sets_that_come_back_are_taken_from_the_exact_solution() {
    for number in [165, 555, 615] {
        let (kind, text) = random_assemblies::case(number);
        let problem = Case::parse(&text, "assembly.toml", &[]).unwrap().build().unwrap().0;
        let prepared = prepared(&problem);
        let (solution, all) = solved(&prepared, None);
        check(&prepared, kind, &solution, &all);
        assert!(
            solution.clarabel_calls > 0 && solution.last.step[0] <= 20,
            "{number}: {:?}",
            solution.history
        );
    }
}

/// Random assemblies, floating and tipping bodies, cycles and walls among them: no state has a bound below its distance from the discrete
/// solution, and the end is convergence or round-off.
#[test]
fn no_state_of_a_random_assembly_has_a_false_bound() {
    let (mut states, mut solved, mut run) = (0, 0, 0);
    for number in 0..ASSEMBLIES {
        let (kind, text) = random_assemblies::case(number);
        // A few assemblies make no sense.
        let Ok((problem, _)) = Case::parse(&text, "assembly.toml", &[]).and_then(|case| case.build()) else {
            continue;
        };
        if support(&problem).unwrap().unresisted.is_some() {
            continue;
        }
        let prepared = prepared(&problem);
        let (exact, system) = (exact(&prepared), prepared.system());
        let u = prepared.displacements(&exact.fields);
        let mut all = All { stop: EtaNndd::new(1e-8), iterates: Vec::new() };
        let start = Start { lambda: vec![0.0; system.rows.len()], active: None };
        let method = Method::NewtonNn(NewtonSettings::default());
        let solution = solve_from(&system, start, &method, &mut all).unwrap();
        for iterate in &all.iterates {
            let v: Vec<Vec<Vector>> = prepared.displacements(&iterate.fields(&system));
            let [size, distance] = norm_and_distance(&problem, &u, &v);
            let (bound, step) = (iterate.eta_nndd, iterate.step);
            assert!(
                bound >= (1.0 - 1e-9) * distance - 1e-10 * size,
                "{number} ({kind}), {step:?}: {bound:e} {distance:e}"
            );
            assert!(
                iterate.opening.iter().chain(&iterate.contact.normal_reaction).all(|value| *value >= 0.0)
            );
        }
        states += all.iterates.len();
        run += 1;
        solved += usize::from(solution.status == NnddStatus::StoppedByCriterion);
        let ended = matches!(
            solution.status,
            NnddStatus::StoppedByCriterion | NnddStatus::Stalled { at_round_off: true, .. }
        );
        assert!(ended, "{number} ({kind}): {:?}", solution.status);
    }
    println!("{states} states, {solved} of {run} solved");
    assert!(run > 50 && states > 4 * run && 10 * solved > 9 * run, "{states} {solved} {run}");
}

//! Press fits: the figures of an independent prototype, Lamé's closed form, and why the gap on a curve is a vector.

use case_io::case::AnyCase;
use certified_contact::{LoadSteps, Settings, Silent, solve};
use contact_qp::QpSettings;
use cre_estimator::{
    AdmissiblePair, Estimate, Recovery, Relaxation, constitutive_relation_error, estimate_with,
};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::field::stresses;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap, InterfaceError};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::{energy_error_squared, energy_norm_squared};
use fem_core::space::Plane;
use nndd::stopping::Never;
use nndd::{NnddSettings, solve_exactly};
use tests::interference::{
    BLOCKS, BLOCKS_CONTACT, DELTA, ETA, Figures, RADII, RINGS, blocks, exact, paper_with, pressure, rings,
};
use tests::run::state_of;
use tests::{paper, prepare};

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
}

/// The exact solution of a discrete problem.
struct Solved {
    energies: Vec<f64>,
    displacement: Vec<Vec<Vector>>,
    forces: Vec<f64>,
    /// By EET alone, after two steps, and until nothing is left to gain.
    estimates: [Estimate; 3],
}

fn solved(problem: &ContactProblem) -> Solved {
    let prepared = prepare(problem);
    let exact = solve_exactly(&prepared.system(), &QpSettings::default()).unwrap();
    assert!(exact.status.is_solved());
    let displacement = prepared.displacements(&exact.fields);
    let energies =
        problem.bodies.iter().zip(&displacement).map(|(body, u)| energy_norm_squared(body, u)).collect();
    let state = state_of(&exact, &displacement);
    let estimates =
        [0, 2, 1000].map(|steps| estimate_with(&prepared, &state, Relaxation::Steps(steps)).unwrap());
    assert!(estimates.iter().all(|e| e.certificate().is_some() && e.cre.split_defect() < 1e-12));
    Solved { energies, forces: exact.contact_force[0].clone(), estimates, displacement }
}

/// Compares with printed figures. The bound after two steps depends on the order of the stars.
fn has_figures(of: &Solved, figures: &Figures, bounds: [f64; 3]) {
    of.energies.iter().zip(figures.energies).for_each(|(found, expected)| near(*found, expected, 1e-11));
    near(of.forces.iter().sum(), figures.force.0, 1e-11);
    assert_eq!(of.forces.iter().filter(|p| **p > 0.0).count(), figures.force.1);
    for ((found, expected), tolerance) in bounds.iter().zip(figures.bounds).zip([1e-11, 0.05, 1e-9]) {
        near(*found, expected, tolerance);
    }
}

#[test]
fn blocks_that_overlap_at_one_end_have_the_figures_of_an_independent_code() {
    let found = solved(&blocks().unwrap());
    has_figures(&found, &BLOCKS, found.estimates.each_ref().map(|e| e.unchecked().e_cre));
    let contact: f64 = found.estimates[2].cre.by_contact_edge.iter().flatten().sum();
    near(contact, BLOCKS_CONTACT, 1e-9);
}

/// Computes `e_CRE` with other middle openings, and the first body's nodes moved back by these amounts, m.
fn bound_with(
    problem: &ContactProblem,
    of: &AdmissiblePair,
    lift: &[f64],
    middle: impl Fn(&[Vector]) -> Vec<f64>,
) -> f64 {
    let interface = &problem.contacts[0].interface;
    let mut moved = of.bodies[0].displacement.clone();
    interface.pairs().iter().zip(lift).for_each(|(pair, l)| moved[pair.nodes[0]] -= *l * pair.normal);
    let mut pair = of.clone();
    pair.bodies[0].stress = stresses(&problem.bodies[0], &moved);
    pair.lift_energy = 0.0;
    let contact = &mut pair.contacts[0];
    (contact.opening, contact.middle_opening) = (lift.to_vec(), middle(&moved));
    (contact.lift.by_pair, contact.lift.energy) = (vec![0.0; lift.len()], 0.0);
    contact.added = [vec![], vec![]];
    constitutive_relation_error(problem, &pair).e_cre()
}

/// The amounts by which the prototype moves the first body's nodes: the middle openings of the edges beside each become ≥ 0. This program lifts less.
fn lift_of_the_prototype(middle: &[f64]) -> Vec<f64> {
    let mut lift = vec![0.0f64; middle.len() + 1];
    for (edge, middle) in middle.iter().enumerate() {
        for k in [edge, edge + 1] {
            lift[k] = lift[k].max(-middle / 7.5f64.to_radians().cos());
        }
    }
    lift
}

#[test]
fn rings_that_are_pressed_together_have_the_figures_of_an_independent_code() {
    let problem = rings([12, 6], -DELTA).unwrap();
    let interface = &problem.contacts[0].interface;
    let found = solved(&problem);
    let outer = &found.displacement[1];
    let middle = |inner: &[Vector]| Plane::middle_openings(interface, [inner, outer]);
    let given = middle(&found.displacement[0]);
    let lift = lift_of_the_prototype(&given);
    assert_eq!(given.iter().filter(|middle| **middle < 0.0).count(), 6);
    let bounds = found.estimates.each_ref().map(|e| bound_with(&problem, &e.pair, &lift, middle));
    has_figures(&found, &RINGS, bounds);
    let own = found.estimates.each_ref().map(|e| e.unchecked().e_cre);
    assert!(own.iter().zip(bounds).all(|(own, of_prototype)| *own < of_prototype), "{own:?}");
}

#[test]
fn a_gap_that_is_a_number_between_the_nodes_of_a_curve_gives_no_bound() {
    let problem = rings([12, 6], -DELTA).unwrap();
    let found = solved(&problem);
    let outer = &found.displacement[1];
    let interface = &problem.contacts[0].interface;
    let scalar = |inner: &[Vector]| {
        let vector = Plane::middle_openings(interface, [inner, outer]);
        vector.iter().map(|o| o - DELTA * (1.0 - 7.5f64.to_radians().cos())).collect()
    };
    let best = &found.estimates[2];
    let error = best.unchecked().e_cre / 1.055;
    let without_lift = bound_with(&problem, &best.pair, &[0.0; 13], scalar);
    // The prototype has 0.56.
    assert!((without_lift / error - 0.56).abs() < 0.01, "{}", without_lift / error);
    // With a vector next to nothing is lifted.
    assert!(best.pair.contacts[0].lift.largest() < 0.1 * DELTA * (1.0 - 7.5f64.to_radians().cos()));
}

#[test]
fn the_solution_of_lame_is_within_the_certified_error() {
    for (around, mean, energy) in [(6, 1.0183, 1.0154), (12, 1.0050, 1.0043), (24, 1.0013, 1.0011)] {
        let problem = rings([around, around / 2], -DELTA).unwrap();
        let solution = solve(problem.clone(), &Settings::default(), &mut Silent).unwrap();
        let estimate = solution.estimate.as_ref().unwrap();
        assert!(solution.is_certified());
        let force: f64 = solution.last().contact.normal_reaction.iter().sum();
        let pressed = force / problem.contacts[0].interface.measure() / pressure(DELTA);
        assert!((pressed - mean).abs() < 6e-5, "{around}: {pressed}");
        let sum: f64 = estimate.energy_norm_squared.iter().sum();
        let whole = std::f64::consts::FRAC_PI_2 * RADII[1] * pressure(DELTA) * DELTA;
        assert!((sum / whole - energy).abs() < 6e-5, "{around}: {}", sum / whole);
        let bodies = problem.bodies.iter().zip(&estimate.pair.bodies).zip(exact(DELTA));
        let error: f64 = bodies
            .map(|((body, of), lame)| energy_error_squared(body, &of.displacement, |x| lame.stress(x)))
            .sum();
        let effectivity = estimate.unchecked().e_cre / error.sqrt();
        assert!((1.0..1.2).contains(&effectivity), "{around}: {effectivity}");
    }
}

#[test]
fn the_iteration_needs_no_special_start() {
    let prepared = prepare(&paper_with((-0.02).into()).unwrap());
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 5;
    let from = |lambda: f64| {
        let start = vec![lambda; prepared.rows()];
        nndd::solve(&prepared.system(), start, &settings, &mut Never).unwrap().history
    };
    from(0.0).iter().zip(ETA).for_each(|(row, eta)| near(row.eta_nndd, eta, 1e-8));
    // The traces of the paper's problem, moved by the gap.
    from(-0.02).iter().zip(paper::ITERATIONS).for_each(|(row, (_, eta, ..))| near(row.eta_nndd, eta, 1e-8));
}

/// Blocks of height 1 that overlap as drawn, both clamped at the left or not.
fn drawn(overlap: f64, clamped: bool, gap: &Gap) -> Result<ContactProblem, InterfaceError> {
    let body = |y: f64, conditions: BoundaryConditions| {
        let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let conditions = if clamped { conditions.fix("left") } else { conditions };
        Body::new(block([0.0, y], [2.0, 1.0], [8, 4]).unwrap(), steel, &conditions).unwrap()
    };
    let bodies = [
        body(1.0 - overlap, BoundaryConditions::new().fix("top")),
        body(0.0, BoundaryConditions::new().fix("bottom")),
    ];
    let interface = contact_geometry::pair(&bodies[0], &bodies[1], ["bottom", "top"], gap)?;
    Ok(ContactProblem::between(bodies, interface))
}

#[test]
fn an_overlap_that_is_drawn_is_the_same_as_a_negative_gap() {
    let given = solved(&drawn(0.0, false, &Gap::Given((-0.02).into())).unwrap());
    let kept = solved(&drawn(0.02, false, &Gap::Interference).unwrap());
    given.energies.iter().zip(&kept.energies).for_each(|(a, b)| near(*a, *b, 1e-12));
    assert!(given.forces.iter().all(|p| *p > 0.0));
    let refused = drawn(0.02, false, &Gap::Geometric).unwrap_err();
    assert!(matches!(refused, InterfaceError::Overlap { depth, .. } if (depth - 0.02).abs() < 1e-14));
    let deep = drawn(1.02, false, &Gap::Interference).unwrap_err();
    assert!(matches!(deep, InterfaceError::TooDeep { depth, .. } if (depth - 1.02).abs() < 1e-14));
}

#[test]
fn an_overlap_of_clamped_nodes_is_refused_with_the_node_and_the_depth() {
    let error = drawn(0.0, true, &Gap::Given((-0.01).into())).unwrap_err();
    let InterfaceError::ClampedOverlap { point, depth } = error else { panic!("{error}") };
    assert!((depth - 0.01).abs() < 1e-14 && point.to_string() == "(0, 1)", "{point} {depth}");
}

#[test]
fn load_steps_scale_and_release_a_shrink_fit() {
    let mut steps = LoadSteps::new(rings([12, 6], -DELTA).unwrap());
    let mut force = |factor: f64| {
        steps.scale_gaps(vec![factor]);
        let solution = steps.solve(|_, _| 1.0, &Settings::default(), &mut Silent).unwrap();
        assert!(solution.is_certified(), "{factor}");
        solution.last().contact.normal_reaction.iter().sum::<f64>()
    };
    near(force(1.0), RINGS.force.0, 1e-6);
    near(force(0.5), 0.5 * RINGS.force.0, 1e-6);
    assert_eq!(force(0.0), 0.0);
}

#[test]
fn a_solid_sector_has_the_pressure_of_lame() {
    let bytes = include_bytes!("../cases/solid/press_fit.toml");
    // Lamé's pressure in MPa.
    let exact = 27.0433;
    let mut before = f64::INFINITY;
    for n in [1, 2] {
        let cells = format!("[{}, {}, {n}]", 6 * n, 3 * n);
        let overrides = [0, 1].map(|b| (format!("body.{b}.generator.cells"), cells.clone()));
        let AnyCase::Solid(case) = AnyCase::parse_bytes(bytes, "press_fit.toml", &overrides).unwrap() else {
            panic!("a case of the plane")
        };
        let (problem, _) = case.build().unwrap();
        let area = problem.contacts[0].interface.measure();
        let solution = solve(problem, &Settings::default(), &mut Silent).unwrap();
        let estimate = solution.estimate.as_ref().unwrap();
        assert!(solution.is_certified());
        // The normals are ±(x − c)/R, so that forces are those of the pressure.
        let force: f64 = solution.last().contact.normal_reaction.iter().sum();
        let off = (force / area / exact - 1.0).abs();
        let norm = estimate.energy_norm_squared.iter().sum::<f64>().sqrt();
        let relative = estimate.unchecked().e_cre / norm;
        assert!(off < relative && off < 0.5 * before, "{n}: {off} {relative}");
        before = off;
    }
}

//! Springs and elastic foundations: figures of an independent code, closed forms, nested meshes, refusals.
//!
//! The figures of [`CANONICAL`] are those of a prototype in another language, on the blocks of [`tests::paper`] with 18×9 cells each: `a(u, u)` of each
//! body, `∫ k (u − u₀)²`, and the bound by EET and with the best stress of the space.

use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use cre_estimator::{Estimate, Relaxation};
use fem_core::body::{Body, BodyError, FacetSprings};
use fem_core::boundary::{BoundaryConditions, ScalarData, SpringDirection, SpringRest};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, cuboid};
use fem_core::mesh::id::FacetId;
use fem_core::mesh_field::MeshField;
use fem_core::norm::{energy_distance_squared, energy_norm_squared, spring_energy};
use fem_core::space::Solid;
use nalgebra::Vector3;
use nndd::NewtonSettings;
use std::sync::Arc;

const ALL: SpringDirection = SpringDirection::All;

fn material(young: f64, hypothesis: Hypothesis) -> LinearElastic {
    LinearElastic::isotropic(young, 0.3, hypothesis).unwrap()
}

fn body(
    at: [f64; 2],
    size: [f64; 2],
    cells: [usize; 2],
    young: f64,
    conditions: &BoundaryConditions,
) -> Body {
    let material = material(young, Hypothesis::PlaneStrain);
    Body::new(block(at, size, cells).unwrap(), material, conditions).unwrap()
}

/// The paper's blocks, the lower one under these conditions instead of a clamp.
fn blocks(n: usize, lower: &BoundaryConditions) -> ContactProblem {
    let upper = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    let bodies = [
        body([0.0, 1.0], [2.0, 1.0], [18 * n, 9 * n], 2000.0, &upper),
        body([0.0, 0.0], [2.0, 1.0], [18 * n, 9 * n], 1000.0, lower),
    ];
    let gap = Gap::Given(0.0.into());
    let interface = contact_geometry::pair(&bodies[0], &bodies[1], ["bottom", "top"], &gap).unwrap();
    ContactProblem::between(bodies, interface)
}

/// The lower block alone, pulled and pressed at its top.
fn alone(n: usize, conditions: BoundaryConditions) -> ContactProblem {
    pulled(n, 1.0, conditions)
}

/// The same with other loads.
fn pulled(n: usize, load: f64, conditions: BoundaryConditions) -> ContactProblem {
    let load = [(5.0 * load).into(), ScalarData::function(move |x| -10.0 * load * x[0])];
    let conditions = conditions.traction("top", load);
    ContactProblem::new(vec![body([0.0, 0.0], [2.0, 1.0], [18 * n, 9 * n], 1000.0, &conditions)])
}

fn on_springs(k: f64) -> BoundaryConditions {
    BoundaryConditions::new().spring("bottom", k, ALL)
}

/// Springs that are relaxed at the displacement `(0.01 (1 + x), 0.01 (2 − x))`.
fn moved(k: f64) -> BoundaryConditions {
    let mut conditions = on_springs(k);
    let rest = [ScalarData::function(|x| 0.01 * (1.0 + x[0])), ScalarData::function(|x| 0.01 * (2.0 - x[0]))];
    conditions.springs[0].rest = SpringRest::Vector(rest);
    conditions
}

fn solved(problem: &ContactProblem, relaxation: Relaxation) -> CertifiedSolution {
    let mut settings = Settings::default().with_method(NewtonSettings::default());
    settings.relaxation = relaxation;
    solve(problem.clone(), &settings, &mut Silent).unwrap()
}

fn certified(problem: &ContactProblem, relaxation: Relaxation) -> Estimate {
    let solution = solved(problem, relaxation);
    let estimate = solution.estimate.unwrap();
    assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
    assert!(estimate.cre.split_defect() < 1e-12, "{:e}", estimate.cre.split_defect());
    estimate
}

/// The error of a solution on a mesh against the one on a finer, nested mesh.
fn error(coarse: &ContactProblem, fine: &ContactProblem) -> f64 {
    let [u, v] = [coarse, fine].map(|of| solved(of, Relaxation::NONE).estimate.unwrap());
    let of_body = |b: usize| {
        let field = MeshField::new(coarse.bodies[b].mesh(), &u.pair.bodies[b].displacement);
        let on_fine = field.on(fine.bodies[b].mesh());
        energy_distance_squared(&fine.bodies[b], &on_fine, &v.pair.bodies[b].displacement)
    };
    (0..coarse.bodies.len()).map(of_body).sum::<f64>().sqrt()
}

/// `∫ k (u − u₀)²` of all bodies.
fn stretch(problem: &ContactProblem, estimate: &Estimate) -> f64 {
    let of_body = |(body, fields): (&Body, &cre_estimator::AdmissibleBody)| -> f64 {
        let mesh = body.mesh();
        let of_facet = |(facet, springs): (FacetId, &FacetSprings)| {
            let nodes = mesh.topology().facets()[facet];
            let stretched = springs.stretched(&nodes.map(|n| fields.displacement[n]));
            springs.energy(&stretched.stretch, mesh.facet_measure(facet))
        };
        body.facet_springs().map(of_facet).sum()
    };
    problem.bodies.iter().zip(&estimate.pair.bodies).map(of_body).sum()
}

/// A problem with its figures.
type Figures = (fn(usize) -> ContactProblem, &'static [f64], f64, [f64; 3]);

/// `a` of each body, `∫ k (u − u₀)²`, and the bound by EET, after two steps, and with the best stress.
const CANONICAL: [Figures; 3] = [
    (
        |n| blocks(n, &on_springs(5000.0)),
        &[0.702117597073, 0.251367815175],
        0.0577885992626,
        [0.52289026378, 0.1956, 0.179518813977],
    ),
    (
        |n| alone(n, on_springs(5000.0)),
        &[0.517519833966],
        0.138312406526,
        [0.307492654323, 0.08417, 0.0819152079368],
    ),
    (
        |n| alone(n, moved(5000.0)),
        &[0.560859833396],
        0.139787219807,
        [0.218618061072, 0.07009, 0.068149235794],
    ),
];

#[test]
fn figures_of_an_independent_code() {
    let near = |found: f64, expected: f64, digits: f64| {
        assert!((found - expected).abs() <= digits * expected, "{found} {expected}");
    };
    for (problem, energies, springs, [eet, two, best]) in CANONICAL {
        let problem = problem(1);
        let estimate = certified(&problem, Relaxation::NONE);
        for (body, (fields, expected)) in problem.bodies.iter().zip(estimate.pair.bodies.iter().zip(energies))
        {
            let whole = energy_norm_squared(body, &fields.displacement);
            let of_springs = spring_energy(body, &fields.displacement);
            near(whole - of_springs, *expected, 1e-10);
        }
        near(stretch(&problem, &estimate), springs, 1e-10);
        near(estimate.unchecked().e_cre, eet, 1e-10);
        // Two steps depend on the stars: ours gain as much or more.
        let after = certified(&problem, Relaxation::Steps(2)).unchecked().e_cre;
        assert!(after <= 1.001 * two && after >= best, "{after} {two}");
        near(certified(&problem, Relaxation::Steps(400)).unchecked().e_cre, best, 2e-6);
    }
    let force = solved(&CANONICAL[0].0(1), Relaxation::NONE).results.unwrap();
    near(force.contact_force, 22.7217466866, 1e-11);
    assert_eq!(force.contacts[0].active, 16);
}

#[test]
fn the_bound_holds_on_nested_meshes_and_is_sharp() {
    // Soft to stiff: E/(k h) from 9e3 to 9e-4. Small loads: a body on soft springs turns.
    for k in [1.0, 100.0, 5e3, 1e7] {
        let [coarse, fine] = [1, 4].map(|n| {
            let load = 1e-4 * f64::min(k, 100.0);
            let load = [(0.5 * load).into(), ScalarData::function(move |x| -load * x[0])];
            let conditions = on_springs(k).traction("top", load);
            ContactProblem::new(vec![body([0.0, 0.0], [2.0, 1.0], [12 * n, 6 * n], 1000.0, &conditions)])
        });
        let error = error(&coarse, &fine);
        let eet = certified(&coarse, Relaxation::NONE).unchecked().e_cre / error;
        let relaxed = certified(&coarse, Relaxation::default()).unchecked().e_cre / error;
        assert!((1.0..1.25).contains(&relaxed), "{k}: {relaxed}");
        // The plain weight of EET lets soft springs ruin it: 40 at 9e3.
        assert!(eet < 5.0, "{k}: {eet}");
    }
}

#[test]
fn uniform_pressure_on_normal_springs_is_exact() {
    for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        let conditions = BoundaryConditions::new()
            .roller("left", 0.0)
            .spring("bottom", 40.0, SpringDirection::Normal)
            .pressure("top", 3.0);
        let mesh = block([0.0, 0.0], [2.0, 1.0], [7, 5]).unwrap();
        let body = Body::new(mesh, material(1000.0, hypothesis), &conditions).unwrap();
        let problem = ContactProblem::new(vec![body]);
        let solution = solved(&problem, Relaxation::default());
        let estimate = solution.estimate.as_ref().unwrap();
        assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
        assert!(estimate.unchecked().e_cre < 1e-11, "{:e}", estimate.unchecked().e_cre);
        let results = solution.results.unwrap();
        // The springs push back what the pressure pushes, and are 3/40 shorter.
        assert!((results.springs[0].force - Vector::new(0.0, 6.0)).norm() < 1e-12, "{:?}", results.springs);
        assert!(results.balance[0].force.norm() < 1e-12 && results.balance[0].moment.abs() < 1e-12);
        let bottom = problem.bodies[0].mesh().points().iter().zip(&estimate.pair.bodies[0].displacement);
        for (_, u) in bottom.filter(|(x, _)| x[1] == 0.0) {
            assert!((u[1] + 3.0 / 40.0).abs() < 1e-13, "{u:?}");
        }
        let [low, high] = solution.bounds.unwrap().energy_norm;
        let norm = estimate.energy_norm();
        assert!(low <= norm && norm <= high && high - low < 1e-10 * norm, "{low} {norm} {high}");
    }
}

/// The right half of a beam on an elastic foundation, 10 × 1, under a force of 1 on its first half length.
fn beam(n: usize) -> ContactProblem {
    let loaded = fem_core::boundary::FacetSelection::group("top").within([[0.0, 0.5], [0.0, 2.0]]);
    let conditions = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .spring("bottom", 10.0, SpringDirection::Normal)
        .traction(loaded, [0.0.into(), (-2.0).into()]);
    let mesh = block([0.0, 0.0], [10.0, 1.0], [40 * n, 4 * n]).unwrap();
    let body = Body::new(mesh, material(1000.0, Hypothesis::PlaneStress), &conditions).unwrap();
    ContactProblem::new(vec![body])
}

#[test]
fn a_beam_on_an_elastic_foundation_sinks_as_winkler_says() {
    // w(0) of the prototype at the bottom; Winkler's beam under a point force sinks by 0.0416 without shear.
    let expected = [-0.0407298, -0.0419661, -0.0423074];
    for (n, expected) in [1, 2, 4].into_iter().zip(expected) {
        let problem = beam(n);
        let estimate = certified(&problem, Relaxation::default());
        let points = problem.bodies[0].mesh().points().iter();
        let (_, sunk) = points
            .zip(&estimate.pair.bodies[0].displacement)
            .find(|(x, _)| x[0] == 0.0 && x[1] == 0.0)
            .unwrap();
        assert!((sunk[1] - expected).abs() < 6e-8, "{n}: {} {expected}", sunk[1]);
    }
    // λ⁴ = k/(4 E I), w(0) = P λ/(2 k)
    let lambda = (10.0f64 / (4.0 * 1000.0 / 12.0)).powf(0.25);
    assert!((2.0 * lambda / 20.0 - 0.0416179).abs() < 1e-6);
    let error = error(&beam(1), &beam(4));
    let bound = certified(&beam(1), Relaxation::default()).unchecked().e_cre;
    assert!(bound >= error && bound < 1.15 * error, "{bound} {error}");
}

#[test]
fn bounds_of_other_quantities_hold_on_springs() {
    for (problem, ..) in CANONICAL {
        let [coarse, fine] = [problem(1), problem(4)].map(|problem| solved(&problem, Relaxation::default()));
        let (bounds, exact) = (coarse.bounds.unwrap(), fine.bounds.unwrap());
        let within = |of: [f64; 2], exact: [f64; 2]| of[0] <= exact[1] && exact[0] <= of[1];
        assert!(within(bounds.energy_norm, exact.energy_norm));
        // The potential energy falls as the space grows.
        assert!(within(bounds.potential_energy, exact.potential_energy));
        assert!(exact.potential_energy[1] <= bounds.potential_energy[1]);
        if let (Ok(of), Ok(exact)) = (bounds.contact_force, exact.contact_force) {
            assert!(within(of, exact) && of[1] - of[0] < 8.0, "{of:?} {exact:?}");
        }
        let balance = coarse.results.unwrap().balance;
        assert!(balance.iter().all(|of| of.force.norm() < 1e-9 && of.moment.abs() < 1e-9), "{balance:?}");
    }
}

#[test]
fn springs_beside_rollers_on_contact_sides_and_along_vectors() {
    let kinds: [fn(usize) -> ContactProblem; 5] = [
        // A roller and springs in the other component.
        |n| pulled(n, 0.1, BoundaryConditions::new().roller("bottom", 0.0).spring("bottom", 2000.0, ALL)),
        // On the contact side.
        |n| blocks(n, &BoundaryConditions::new().fix("bottom").spring("top", 1000.0, ALL)),
        // Two springs on a side, at an angle to each other; one of them differs along the side.
        |n| {
            let slanted = SpringDirection::Vector(Vector::new(3.0, 4.0));
            let k = ScalarData::function(|x| if x[0] < 1.0 { 5e3 } else { 5e4 });
            let conditions = BoundaryConditions::new().spring("bottom", k, SpringDirection::Normal);
            pulled(n, 0.1, conditions.spring("bottom", 8e3, slanted))
        },
        // Springs beside a clamp, which wins at the common node, and on two sides.
        |n| {
            let conditions = BoundaryConditions::new().fix("left").spring("bottom", 3000.0, ALL);
            pulled(n, 0.1, conditions.spring("right", 100.0, SpringDirection::Normal))
        },
        // Held by springs and by the obstacle on which it lies.
        |n| {
            let conditions = BoundaryConditions::new()
                .spring("left", 50.0, SpringDirection::Vector(Vector::x()))
                .pressure("top", 2.0);
            let body = body([0.0, 0.0], [2.0, 1.0], [18 * n, 9 * n], 1000.0, &conditions);
            let floor = Obstacle::fixed(RigidLine::Plane { point: Vector::zeros(), normal: Vector::y() });
            let gap = Gap::Given(ScalarData::function(|x| 1e-4 * x[0] * x[0]));
            let interface = contact_geometry::against(&body, "bottom", &floor, Some(&gap)).unwrap();
            ContactProblem::new(vec![body]).obstacle(0, interface, floor)
        },
    ];
    for (k, kind) in kinds.into_iter().enumerate() {
        let (coarse, fine) = (kind(1), kind(4));
        let bound = certified(&coarse, Relaxation::default()).unchecked().e_cre;
        let error = error(&coarse, &fine);
        assert!(bound >= error && bound < 1.35 * error, "{k}: {bound} {error}");
    }
    // The same traction as from one spring with the sum of both.
    let twice = on_springs(300.0).spring("bottom", 700.0, ALL);
    let [a, b] = [pulled(1, 0.01, twice), pulled(1, 0.01, on_springs(1000.0))]
        .map(|of| certified(&of, Relaxation::NONE));
    assert!((a.unchecked().e_cre - b.unchecked().e_cre).abs() < 1e-10 * b.unchecked().e_cre);
    // No stiffness, no springs.
    let half = ScalarData::function(|x: Vector| if x[0] < 1.0 { 1e3 } else { 0.0 });
    let conditions = BoundaryConditions::new().spring("bottom", half, ALL);
    let part = fem_core::boundary::FacetSelection::group("bottom").within([[0.0, 1.0], [0.0, 0.0]]);
    let [a, b] = [conditions, BoundaryConditions::new().spring(part, 1e3, ALL)]
        .map(|conditions| certified(&pulled(1, 0.01, conditions), Relaxation::NONE).unchecked().e_cre);
    assert_eq!(a, b);
}

#[test]
fn what_springs_do_not_hold_or_do_twice_is_refused() {
    let made = |conditions: &BoundaryConditions| {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        Body::new(mesh, material(1000.0, Hypothesis::PlaneStrain), conditions)
    };
    // Normal springs on a straight side leave the slide, all springs hold everything, and normal ones on two sides do.
    let normal = || BoundaryConditions::new().spring("bottom", 1.0, SpringDirection::Normal);
    let slide = made(&normal()).unwrap().free_motion().unwrap();
    assert!(slide.to_string().contains("translate along"), "{slide}");
    assert!(made(&on_springs(1e-5)).unwrap().free_motion().is_none());
    let both = normal().spring("left", 1e6, SpringDirection::Normal);
    assert!(made(&both).unwrap().free_motion().is_none());
    let refused = |conditions: &BoundaryConditions| made(conditions).unwrap_err();
    let slanted = SpringDirection::Vector(Vector::new(1.0, 1.0));
    let roller = BoundaryConditions::new().roller("bottom", 0.0);
    for along in [SpringDirection::Normal, slanted] {
        let error = refused(&roller.clone().spring("bottom", 1.0, along));
        assert!(matches!(error, BodyError::SpringOnSupport { .. }), "{error}");
    }
    let clamp = BoundaryConditions::new().fix("bottom").spring("bottom", 1.0, ALL);
    assert!(matches!(refused(&clamp), BodyError::SpringOnSupport { .. }));
    for k in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&on_springs(k)), BodyError::Stiffness { .. }), "{k}");
    }
    // On edges of 0.5: E/h = 2000.
    assert!(matches!(refused(&on_springs(3e9)), BodyError::TooStiff { .. }));
    assert!(matches!(refused(&on_springs(1e-9)), BodyError::TooSoft { .. }));
    assert!(made(&on_springs(1e9)).is_ok() && made(&on_springs(1e-8)).is_ok());
    let mut nowhere = on_springs(1.0);
    nowhere.springs[0].rest = SpringRest::Component(ScalarData::function(|x| 1.0 / x[1]));
    assert!(matches!(refused(&nowhere), BodyError::NotFinite { .. }));
}

#[test]
fn rounding_of_soft_and_stiff_springs_is_in_the_bound() {
    // A rigid motion 1e5 to 1e11 times as large as the strains: what rounding hides is in the allowance.
    for k in [1e-2, 1e-5, 1e-7] {
        let load = 1e-3 * k;
        let problem = |n: usize| {
            let load = [(5.0 * load).into(), ScalarData::function(move |x| -10.0 * load * x[0])];
            let conditions = on_springs(k).traction("top", load);
            ContactProblem::new(vec![body([0.0, 0.0], [2.0, 1.0], [6 * n, 3 * n], 1000.0, &conditions)])
        };
        let (coarse, fine) = (problem(1), problem(4));
        let solution = solved(&coarse, Relaxation::default());
        let estimate = solution.estimate.unwrap();
        let bound = estimate.unchecked().e_cre;
        let error = error(&coarse, &fine);
        assert!(bound >= error, "{k}: {bound} {error}");
        assert!(bound - estimate.round_off < 1.3 * error, "{k}: {bound} {error}");
    }
    // Stiff springs that are relaxed far away: k (u − u₀) loses digits, the bound does not.
    for k in [1e6, 1e8, 9e9] {
        let (coarse, fine) = (alone(1, moved(k)), alone(2, moved(k)));
        let bound = certified(&coarse, Relaxation::default()).unchecked().e_cre;
        let error = error(&coarse, &fine);
        assert!(bound >= error && bound < 1.5 * error, "{k}: {bound} {error}");
    }
}

#[test]
fn two_sides_on_springs_around_a_hole_reach_the_best_stress() {
    // A wrench may pass from one side on springs to the other: no star changes it.
    let problem = |n: usize| {
        let conditions = BoundaryConditions::new()
            .spring("left", 3000.0, ALL)
            .spring("right", 500.0, ALL)
            .traction("top", [2.0.into(), (-8.0).into()]);
        ContactProblem::new(vec![body([0.0, 0.0], [8.0, 1.0], [16 * n, 2 * n], 1000.0, &conditions)])
    };
    let estimate = certified(&problem(1), Relaxation::Steps(60));
    assert_eq!(estimate.pair.bodies[0].relaxation.columns, 3);
    let history = &estimate.pair.bodies[0].relaxation.energy_history;
    assert!(history[history.len() - 1] < history[history.len() - 2]);
    assert!(estimate.unchecked().e_cre >= error(&problem(1), &problem(4)));
}

/// A box on springs under a load on its top.
fn cube(n: usize, springs: BoundaryConditions<Solid>, load: [f64; 3]) -> ContactProblem<Solid> {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4 * n, 2 * n, 2 * n]).unwrap();
    let material = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap();
    let load = load.map(|t| ScalarData::Function(Arc::new(move |x: Vector3<f64>| t * (1.0 + 0.3 * x[0]))));
    ContactProblem::new(vec![Body::new(mesh, material, &springs.traction("top", load)).unwrap()])
}

fn solid(problem: &ContactProblem<Solid>, relaxation: Relaxation) -> CertifiedSolution<Solid> {
    let mut settings = Settings::default().with_method(NewtonSettings::default());
    settings.relaxation = relaxation;
    let solution = solve(problem.clone(), &settings, &mut Silent).unwrap();
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(estimate.admissibility.is_valid(), "{:?}", estimate.admissibility);
    // The split of rounding has no digits.
    let cre = &estimate.cre;
    assert!(cre.split_defect() * cre.e_cre_squared < 1e-12 * cre.e_cre_squared.max(1e-12), "{cre:?}");
    solution
}

#[test]
fn solids_under_uniform_pressure_on_normal_springs_are_exact() {
    let conditions = BoundaryConditions::<Solid>::default()
        .roller("left", 0.0)
        .roller("front", 0.0)
        .spring("bottom", 40.0, SpringDirection::Normal)
        .pressure("top", 3.0);
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 3, 2]).unwrap();
    let material = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap();
    let problem = ContactProblem::new(vec![Body::new(mesh, material, &conditions).unwrap()]);
    let solution = solid(&problem, Relaxation::default());
    let estimate = solution.estimate.unwrap();
    assert!(estimate.unchecked().e_cre < 1e-11, "{:e}", estimate.unchecked().e_cre);
    for (x, u) in problem.bodies[0].mesh().points().iter().zip(&estimate.pair.bodies[0].displacement) {
        // Pressed by 3/40 as a whole, and by 3/1000 for each length.
        assert!(
            (u[2] + 3.0 / 40.0 + 3e-3 * x[2]).abs() < 1e-13 && (u[0] - 0.9e-3 * x[0]).abs() < 1e-13,
            "{u:?}"
        );
    }
    let results = solution.results.unwrap();
    assert!((results.springs[0].force - Vector3::new(0.0, 0.0, 6.0)).norm() < 1e-12, "{:?}", results.springs);
    assert!(results.balance[0].force.norm() < 1e-12 && results.balance[0].moment.norm() < 1e-12);
}

#[test]
fn the_bound_of_solids_holds_on_nested_meshes() {
    let all = |k: f64| BoundaryConditions::<Solid>::default().spring("bottom", k, SpringDirection::All);
    let slanted = SpringDirection::Vector(Vector3::new(1.0, 2.0, 2.0));
    let moved = |k: f64| {
        let mut conditions = all(k);
        let rest = [1e-4, -2e-4, 3e-4]
            .map(|u| ScalarData::Function(Arc::new(move |x: Vector3<f64>| u * (1.0 + x[0] - x[1]))));
        conditions.springs[0].rest = SpringRest::Vector(rest);
        conditions
    };
    let cases = [
        (all(1e5), [0.5, 0.2, -1.0]),
        (moved(2e3), [0.5, 0.2, -1.0]),
        (all(1.0), [5e-3, 2e-3, -1e-2]),
        (all(300.0).roller("left", 0.0).spring("left", 50.0, SpringDirection::All), [0.1, 0.2, -0.3]),
        (
            all(300.0).spring("back", 500.0, slanted).spring("back", 700.0, SpringDirection::Normal),
            [0.1, 0.2, -0.3],
        ),
    ];
    for (k, (conditions, load)) in cases.into_iter().enumerate() {
        let [coarse, fine] = [1, 3].map(|n| cube(n, conditions.clone(), load));
        let fields = [&coarse, &fine].map(|of| solid(of, Relaxation::NONE).estimate.unwrap());
        let u = MeshField::new(coarse.bodies[0].mesh(), &fields[0].pair.bodies[0].displacement);
        let on_fine = u.on(fine.bodies[0].mesh());
        let apart =
            energy_distance_squared(&fine.bodies[0], &on_fine, &fields[1].pair.bodies[0].displacement).sqrt();
        let eet = fields[0].unchecked().e_cre / apart;
        let relaxed = solid(&coarse, Relaxation::default()).estimate.unwrap().unchecked().e_cre / apart;
        let steps = solid(&coarse, Relaxation::Steps(60)).estimate.unwrap().unchecked().e_cre / apart;
        assert!(
            steps >= 1.0 && relaxed < 1.03 * steps && relaxed < 2.0 && eet < 12.0,
            "{k}: {eet} {relaxed} {steps}"
        );
    }
}

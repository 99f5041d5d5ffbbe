//! Friction of solids: in any position, on curved surfaces, in steps, on finer meshes, and with the law of Coulomb.
//!
//! `tests/suite/solids.rs` has the figures of an independent code.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, CertifiedSolution, LoadSteps, Settings, Silent, SolveError, solve,
    solve_adaptively, solve_coulomb,
};
use contact_geometry::{Contact, ContactNormal, Sides, paired_solids};
use cre_estimator::Relaxation;
use fem_core::body::{Body, ConditionList, ConditionPlace, DeclaredSurface, SurfaceKind};
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactProblem, Friction, Gap, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::{cuboid, tube};
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::space::Solid;
use nalgebra::{Rotation3, Vector3};
use nndd::{CoulombSettings, CoulombStatus, NnddError, NnddSettings, NodeState};
use std::sync::Arc;
use tests::solids::{OnSphere, of_case_with, on_each_other};

type Conditions = BoundaryConditions<Solid>;

fn turned(mesh: &TetMesh, turn: &Rotation3<f64>) -> TetMesh {
    let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
    let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
    Mesh::new(mesh.points().iter().map(|x| turn * x).collect(), mesh.cells().to_vec(), groups).unwrap()
}

fn certified(solution: &CertifiedSolution<Solid>) -> f64 {
    let found = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{:?}", found.admissibility);
    found.unchecked().e_cre
}

fn solved(problem: ContactProblem<Solid>) -> CertifiedSolution<Solid> {
    solve(problem, &Settings::default(), &mut Silent).unwrap()
}

/// Two boxes of 2 × 1 × 1 in a turned frame, the upper one shifted along the surface and pressed down.
fn shifted(
    cells: [[usize; 3]; 2],
    turn: &Rotation3<f64>,
    shift: [f64; 3],
    friction: &Friction<Solid>,
) -> ContactProblem<Solid> {
    let material = |modulus| LinearElastic::isotropic_solid(modulus, 0.3).unwrap();
    let mesh = |z: f64, cells| turned(&cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], cells).unwrap(), turn);
    let moved = turn * Vector3::from(shift);
    let values = [moved[0], moved[1], moved[2]].map(|value| Some(value.into()));
    let upper = Conditions::default().components("top", values);
    let bodies = vec![
        Body::new(mesh(1.0, cells[0]), material(2000.0), &upper).unwrap(),
        Body::new(mesh(0.0, cells[1]), material(1000.0), &Conditions::default().fix("bottom")).unwrap(),
    ];
    let surfaces = ["bottom", "top"].map(str::to_owned);
    let gap = Gap::Given(0.0.into());
    let sides = Sides::Bodies { bodies: [0, 1], surfaces, gap, normal: ContactNormal::Averaged };
    let contact = Contact { name: "boxes".into(), sides, friction: Some(friction.clone()) };
    paired_solids(bodies, &[contact]).unwrap().problem
}

#[test]
fn friction_does_not_depend_on_the_position_in_space() {
    let friction = Friction::tresca(3.0);
    let cells = [[4, 2, 2]; 2];
    let shift = [0.004, 0.003, -0.02];
    let plain = solved(shifted(cells, &Rotation3::identity(), shift, &friction));
    let before = &plain.results.as_ref().unwrap().contacts[0];
    let slides = before.friction.as_ref().unwrap();
    assert!(slides.measures[0] > 0.1 && slides.measures[1] > 0.1, "{slides:?}");
    // About a diagonal the axis from which tangents are made is a matter of rounding.
    let diagonal = Rotation3::rotation_between(&Vector3::z(), &Vector3::new(1.0, 1.0, 1.0)).unwrap();
    for turn in [diagonal, Rotation3::from_euler_angles(0.4, -0.7, 1.1)] {
        let found = solved(shifted(cells, &turn, shift, &friction));
        let bounds = [&plain, &found].map(certified);
        assert!((bounds[0] / bounds[1] - 1.0).abs() < 1e-4, "{bounds:?}");
        let after = &found.results.as_ref().unwrap().contacts[0];
        assert!((after.resultant - turn * before.resultant).norm() < 1e-9 * before.resultant.norm());
        let rubs = after.friction.as_ref().unwrap();
        assert!((rubs.resultant - turn * slides.resultant).norm() < 1e-9 * slides.force);
        assert!((rubs.max_slip / slides.max_slip - 1.0).abs() < 1e-9);
    }
}

#[test]
fn uniform_shear_slides_at_its_limit_with_an_exact_field() {
    // σ_zz = −10 and a shear of 3 along a direction between the axes; the slip is 0.004.
    let (pressure, s, slip) = (10.0, 3.0, 0.004);
    let along = Vector3::new(0.6, 0.8, 0.0);
    let body = |z: f64, modulus: f64, below: Vector3<f64>, ends: [&str; 2]| {
        let shear = modulus / 2.6;
        let field = move |x: Vector3<f64>| {
            let h = x[2] - z;
            let across = Vector3::new(x[0], x[1], 0.0) * (0.3 * pressure / modulus);
            below + across + along * (s * h / shear) - Vector3::z() * (pressure * h / modulus)
        };
        let component = |k: usize| Some(ScalarData::Function(Arc::new(move |x: Vector3<f64>| field(x)[k])));
        let fixed = Conditions::default().components(ends[0], [0, 1, 2].map(component));
        let sides = ["left", "right", "front", "back"].into_iter().zip([-0.6, 0.6, -0.8, 0.8]);
        let loaded = sides
            .fold(fixed, |all, (side, part)| all.traction(side, [0.0.into(), 0.0.into(), (s * part).into()]));
        let mesh = cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
        let body = Body::new(mesh, LinearElastic::isotropic_solid(modulus, 0.3).unwrap(), &loaded).unwrap();
        (body, field(Vector3::new(0.0, 0.0, z + 1.0)))
    };
    // Both materials widen alike under different moduli only if the ratio is the same at the surface: equal moduli.
    let (lower, top) = body(0.0, 1000.0, Vector3::zeros(), ["bottom", "top"]);
    let (upper, _) = body(1.0, 1000.0, top + along * slip, ["top", "bottom"]);
    let interface =
        contact_geometry::pair_solids(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    let problem = ContactProblem::between([upper, lower], interface);
    let found = solved(problem.with_friction(0, Friction::tresca(s)).unwrap());
    let results = found.results.as_ref().unwrap();
    let rubs = results.contacts[0].friction.as_ref().unwrap();
    println!("{} {rubs:?}", certified(&found));
    assert!(certified(&found) < 1e-6);
    // The area is 2.
    assert!((rubs.resultant - along * (2.0 * s)).norm() < 1e-9, "{rubs:?}");
    assert!((results.contacts[0].contact_force / (2.0 * pressure) - 1.0).abs() < 1e-9);
    assert!((rubs.max_slip / slip - 1.0).abs() < 1e-9 && rubs.measures[0] == 0.0, "{rubs:?}");
}

#[test]
fn surfaces_that_do_not_match_rub_too_and_meshes_are_refined() {
    let friction =
        Friction::tresca(ScalarData::Function(Arc::new(|x: Vector3<f64>| 2.0 + x[0] + 0.5 * x[1])));
    let problem = shifted([[4, 2, 2], [5, 3, 2]], &Rotation3::identity(), [0.003, 0.004, -0.02], &friction);
    let mut adapt = AdaptSettings::new(0.15);
    adapt.max_nodes = 4000;
    let found = solve_adaptively(problem, &Settings::default(), &adapt, &mut Silent).unwrap();
    let history: Vec<Option<f64>> = found.history.iter().map(|step| step.relative).collect();
    println!("{history:?} {:?}", found.history.iter().map(|step| step.nodes).collect::<Vec<_>>());
    assert!(matches!(found.end, AdaptiveEnd::TargetMet), "{:?}", found.end);
    assert!(history.len() > 2 && history.windows(2).all(|two| two[1] < two[0]));
    let rubs = found.solution.results.as_ref().unwrap().contacts[0].friction.clone().unwrap();
    assert!(rubs.measures.iter().all(|measure| *measure > 0.05), "{rubs:?}");
}

/// A box on a rigid plane that is pressed down and pushed along a direction.
fn on_plane(push: Vector3<f64>, friction: Friction<Solid>) -> ContactProblem<Solid> {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 0.5], [4, 2, 1]).unwrap();
    let vector = [push[0], push[1], push[2] - 5.0].map(ScalarData::from);
    let body = Body::new(
        mesh,
        LinearElastic::isotropic_solid(1000.0, 0.2).unwrap(),
        &Conditions::default().traction("top", vector),
    )
    .unwrap();
    let plane = Obstacle::fixed(RigidLine::Plane { point: Vector3::zeros(), normal: Vector3::z() });
    let interface = contact_geometry::solid_against(&body, "bottom", &plane, None).unwrap();
    ContactProblem::new(vec![body]).obstacle(0, interface, plane).with_friction(0, friction).unwrap()
}

#[test]
fn a_box_that_friction_holds_is_in_balance_and_one_that_it_does_not_hold_moves_along_the_push() {
    let along = Vector3::new(0.6, 0.8, 0.0);
    let held = solved(on_plane(along * 0.9, Friction::tresca(1.0)));
    assert!(certified(&held) > 0.0);
    let balance = held.estimate.as_ref().unwrap().admissibility.rigid_balance;
    let rubs = held.results.as_ref().unwrap().contacts[0].friction.clone().unwrap();
    assert!(balance < 1e-12 && (rubs.resultant - along * 1.8).norm() < 1e-9, "{balance} {rubs:?}");
    // Between the disc and its square.
    let pushed = on_plane(along * 1.1, Friction::tresca(1.0));
    match solve(pushed, &Settings::default(), &mut Silent) {
        Err(SolveError::NotHeld { motion }) => {
            let moved = motion.bodies[0].1.at(Vector3::zeros());
            assert!((moved.normalize() - along).norm() < 1e-3, "{moved:?}");
            assert!((motion.load - 0.2).abs() < 1e-3, "{}", motion.load);
        }
        other => panic!("{:?}", other.map(|found| found.is_certified())),
    }
}

#[test]
fn the_friction_of_coulomb_has_a_residual_and_grows_with_the_pressure() {
    let along = Vector3::new(0.6, 0.8, 0.0);
    let settings = CoulombSettings::default();
    let problem = on_plane(along, Friction::Coulomb { mu: 0.4 });
    let found = solve_coulomb(problem, &settings, Relaxation::Steps(2), &mut Silent).unwrap();
    assert_eq!(found.solution.status, CoulombStatus::Converged);
    let exact = &found.solution.exact;
    let (forces, rubs) = (&exact.contact_force[0], &exact.friction[0]);
    let nodes = forces.len();
    let mut slipping = 0;
    for (k, force) in forces.iter().enumerate() {
        let size = rubs.force[k].hypot(rubs.force[nodes + k]);
        assert!(size <= 0.4 * force * (1.0 + 1e-5) + 1e-12, "{size} {force}");
        let slip = [rubs.slip[k], rubs.slip[nodes + k]];
        if rubs.state[k] == NodeState::Slip {
            slipping += 1;
            let work = rubs.force[k] * slip[0] + rubs.force[nodes + k] * slip[1];
            assert!((work - size * slip[0].hypot(slip[1])).abs() <= 1e-12, "{work}");
        }
    }
    println!("{slipping} of {nodes} slip, {:?} in {} steps", found.relative_residual(), found.solution.steps);
    assert!(slipping > 0 && slipping < nodes);
    assert!(found.residual().is_some() && !found.has_one_sign() && found.conditional_estimate().is_none());
    let rubs = found.results.contacts[0].friction.as_ref().unwrap();
    assert!((rubs.resultant - along * 2.0).norm() < 1e-9);
}

#[test]
fn steps_remember_the_slip_and_a_monotone_path_ends_where_one_step_does() {
    let others = [("contact.0.friction.limit", "3.0")];
    let problem = of_case_with("tresca.toml", 2, 4, &others).unwrap();
    let factor = |amount: f64| {
        move |body: usize, place: ConditionPlace| match (body, place.list) {
            (0, ConditionList::Displacement | ConditionList::Traction) => amount,
            _ => 1.0,
        }
    };
    let solved = |steps: &mut LoadSteps<Solid>, amount: f64| {
        let found = steps.solve(factor(amount), &Settings::default(), &mut Silent).unwrap();
        assert!(found.is_certified());
        found
    };
    let norm = |of: &CertifiedSolution<Solid>| of.estimate.as_ref().unwrap().energy_norm();
    let mut steps = LoadSteps::new(problem.clone());
    let at_once = solved(&mut LoadSteps::new(problem), 1.0);
    let mut last = solved(&mut steps, 0.5);
    assert!(norm(&last) > 0.0);
    last = solved(&mut steps, 1.0);
    println!("{} {}", norm(&at_once), norm(&last));
    assert!((norm(&last) / norm(&at_once) - 1.0).abs() < 0.01);
    // The same loads again: nothing slips. Without loads friction keeps a part of the shift.
    let again = solved(&mut steps, 1.0);
    let slip = again.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap().max_slip;
    assert!(slip < 1e-12, "{slip}");
    let back = solved(&mut steps, 0.0);
    println!("{}", norm(&back));
    assert!(norm(&back) > 1e-3 * norm(&last), "{}", norm(&back));
    assert_eq!(steps.count(), 4);
}

#[test]
fn what_is_not_solved_is_refused() {
    let problem = shifted([[4, 2, 2]; 2], &Rotation3::identity(), [0.0, 0.0, -0.01], &Friction::tresca(1.0));
    let settings = Settings::<Solid>::default().with_method(NnddSettings::default());
    let refused = solve(problem, &settings, &mut Silent).unwrap_err();
    assert!(matches!(refused, SolveError::Nndd(NnddError::FrictionInSpace { pair: 0 })), "{refused}");
}

/// A pin of radius 1 in an eye that is held outside, with a moment about their axis and a pressure between them.
fn pin(cells: usize, moment: f64, limit: f64, eye_cells: usize) -> ContactProblem<Solid> {
    let steel = || LinearElastic::isotropic_solid(1000.0, 0.3).unwrap();
    let round = |name: &str| [DeclaredSurface { on: name.into(), kind: SurfaceKind::Cylinder }];
    let inner = tube([0.0; 3], [0.4, 1.0], 1.0, [0.0, 360.0], [cells, 2, 2]).unwrap();
    // A traction along the bore, linear on the chords of the nodes' circle of radius 0.4, has this moment for its size.
    let chord = std::f64::consts::TAU / cells as f64;
    let area: f64 = inner.group("inner").unwrap().iter().map(|facet| inner.facet_measure(*facet)).sum();
    let traction = moment / (area * 0.4 * (2.0 + chord.cos()) / 3.0);
    let along = |k: usize| {
        let value = move |x: Vector3<f64>| {
            let r = x[0].hypot(x[1]);
            // The pressure in the bore keeps the surfaces closed.
            let out = 10.0 * [x[0], x[1], 0.0][k] / r;
            out + traction * [-x[1], x[0], 0.0][k] / r
        };
        ScalarData::Function(Arc::new(value))
    };
    let loads = Conditions::default().traction("inner", [0, 1, 2].map(along));
    let inner = Body::new(inner, steel(), &loads).unwrap().with_surfaces(&round("outer")).unwrap();
    let outer = tube([0.0; 3], [1.0, 1.5], 1.0, [0.0, 360.0], [eye_cells, 1, 2]).unwrap();
    let outer = Body::new(outer, steel(), &Conditions::default().fix("outer")).unwrap();
    let outer = outer.with_surfaces(&round("inner")).unwrap();
    let interface =
        contact_geometry::pair_solids(&inner, &outer, ["outer", "inner"], &Gap::Given(0.0.into())).unwrap();
    let problem = ContactProblem::between([inner, outer], interface);
    problem.with_friction(0, Friction::tresca(limit)).unwrap()
}

#[test]
fn friction_alone_holds_a_pin_against_a_moment() {
    // The limit resists s A R = 2π s.
    for (moment, holds) in [(0.9, true), (1.1, false)] {
        let problem = pin(12, moment * 2.0 * std::f64::consts::PI * 2.0, 2.0, 12);
        let found = solve(problem, &Settings::default(), &mut Silent);
        match (found, holds) {
            (Ok(solution), true) => {
                let bound = certified(&solution);
                let friction = solution.results.as_ref().unwrap().contacts[0].friction.clone().unwrap();
                println!("{bound} {friction:?}");
                assert!(solution.relative().unwrap() < 1.0, "{bound}");
            }
            (Err(SolveError::NotHeld { .. }), false) => {}
            (found, _) => panic!("{moment}: {:?}", found.err().map(|error| error.to_string())),
        }
    }
}

#[test]
fn friction_on_curved_surfaces_has_the_limits_of_sliding_and_sticking() {
    let of = |limit: f64| {
        let problem = on_each_other(4, OnSphere::Tilted).unwrap();
        solved(problem.with_friction(0, Friction::tresca(limit)).unwrap())
    };
    let free = solved(on_each_other(4, OnSphere::Tilted).unwrap());
    let norms = |solution: &CertifiedSolution<Solid>| {
        solution.estimate.as_ref().unwrap().energy_norm_squared.iter().sum::<f64>()
    };
    let (slides, sticks, firm) = (of(1e-9), of(1e3), of(2e3));
    assert!((norms(&slides) / norms(&free) - 1.0).abs() < 1e-7);
    assert!((certified(&slides) / certified(&free) - 1.0).abs() < 1e-4);
    assert!((norms(&sticks) / norms(&firm) - 1.0).abs() < 1e-12);
    let slip = sticks.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap().max_slip;
    let moved = slides.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap().max_slip;
    println!("{slip:e} {moved:e} {} {} {}", certified(&slides), certified(&of(1.0)), certified(&sticks));
    assert!(slip < 1e-14 && moved > 1e-4, "{slip} {moved}");
}

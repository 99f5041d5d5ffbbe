//! Each term of a bound and each check has an effect of its own: left out, one of these fails.

use certified_contact::{Settings, Silent, solve};
use cre_estimator::{Estimate, Relaxation, check, estimate_with, friction};
use fem_core::assembly::external_forces;
use fem_core::boundary::{BoundaryConditions, FacetSelection, RigidCondition, ScalarData};
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactProblem, Friction};
use fem_core::norm::energy_norm_squared;
use nndd::solve_exactly;
use tests::assemblies::{stamped, tower};
use tests::friction::{along_edge, blocks, rings, two_blocks};
use tests::prepare;
use tests::run::state_of;

fn estimated(problem: &ContactProblem) -> Estimate {
    let prepared = prepare(problem);
    let exact = solve_exactly(&prepared.system(), &contact_qp::QpSettings::default()).unwrap();
    let estimate = estimate_with(
        &prepared,
        &state_of(&exact, &prepared.displacements(&exact.fields)),
        Relaxation::Steps(2),
    )
    .unwrap();
    assert!(estimate.certificate().is_some(), "{:?}", estimate.admissibility);
    estimate
}

#[test]
fn the_potential_energy_contains_the_work_of_a_stamps_force() {
    // Supports are homogeneous and nothing is apart, so J(u) = −½ a(u, u).
    let bounds = solve(stamped().unwrap(), &Settings::default(), &mut Silent).unwrap().bounds.unwrap();
    let [low, high] = bounds.energy_norm.map(|norm| -0.5 * norm * norm);
    let [from, to] = bounds.potential_energy;
    assert!(from <= low && high <= to, "[{from}, {to}], and a(u, u) says [{high}, {low}]");
}

#[test]
fn the_upper_bound_of_the_potential_energy_is_above_the_energy_of_the_lifted_field() {
    let mut lifted = 0;
    for (k, s) in [0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.1].into_iter().enumerate() {
        let problem = rings(0.003 * k as f64 - 0.008, [10 + k, 4], Friction::tresca(s)).unwrap();
        let answer = solve(problem, &Settings::default(), &mut Silent).unwrap();
        assert!(answer.is_certified());
        let (problem, estimate) = (&answer.problem, answer.estimate.as_ref().unwrap());
        let (pair, contact) = (&problem.contacts[0], &estimate.pair.contacts[0]);
        lifted += usize::from(contact.lift.largest() > 0.0);
        let mut energy = 0.0;
        for (b, body) in problem.bodies.iter().enumerate() {
            let mut u = estimate.pair.bodies[b].displacement.clone();
            if contact.lift.body == b {
                u = contact.lift.added_to(problem, &pair.interface, &u);
            }
            let work: f64 = external_forces(body).iter().zip(&u).map(|(f, u)| f.dot(u)).sum();
            energy += 0.5 * energy_norm_squared(body, &u) - work;
        }
        let mut slides = contact.facet_friction.clone();
        for added in &contact.facet_friction.lifted {
            slides.jump.as_flattened_mut().iter_mut().zip(added.as_flattened()).for_each(|(w, l)| *w += l);
        }
        energy += friction::sliding_work(pair, &slides);
        let [_, upper] = answer.bounds.unwrap().potential_energy;
        println!("{s}: {energy:e} {:e}", upper - energy);
        assert!(upper >= energy, "{s}: {upper:e} {energy:e}");
        // Friction adds the work on the lift's own slip, at least what it is at the limit.
        let forces = [&answer.last().tangential.reaction[..], &answer.last().tangential.force];
        let of_lift = friction::work_of_lift(pair, &contact.facet_friction, forces);
        assert!(contact.lift.largest() == 0.0 || of_lift > 0.0);
        assert!(upper - energy >= 0.1 * of_lift, "{s}: {:e} {of_lift:e}", upper - energy);
    }
    assert!(lifted >= 3, "{lifted}");
}

#[test]
fn friction_on_a_bent_edge_is_constant_and_within_the_limits_of_both_ends() {
    // A limit that changes along the line, at which everything slides.
    let limit = ScalarData::function(|x: Vector| 0.02 + 0.05 * x[1].abs());
    let problem = rings(0.01, [12, 4], Friction::tresca(limit)).unwrap();
    let contact = &estimated(&problem).pair.contacts[0];
    let mut at_limit = 0;
    let (line, of) = (&problem.contacts[0].interface, &contact.facet_friction);
    for ((edge, traction), [s, t]) in line.facets().iter().zip(&of.traction).zip(&of.limit) {
        let [a, b] = along_edge(line, edge, traction);
        let least = s.min(*t);
        assert!((a - b).abs() <= 1e-15 * least && a.abs() <= least * (1.0 + 1e-15), "{a} {b}: {s} {t}");
        at_limit += usize::from(s != t && a.abs() > 0.5 * least);
    }
    assert!(at_limit > 3, "{at_limit}");
}

#[test]
fn a_slip_that_is_not_that_of_the_fields_fails_the_check() {
    let problem = blocks([8, 4], Friction::tresca(4.0)).unwrap();
    let mut pair = estimated(&problem).pair;
    pair.contacts[0].slip[3] += 1e-6;
    let found = check(&problem, &pair);
    assert!(found.friction_cone > 1e-6 && !found.is_valid(), "{found:?}");
}

#[test]
fn a_floating_body_that_turns_far_fails_the_check() {
    let problem = tower(3, [6, 3]).unwrap();
    let mut pair = estimated(&problem).pair;
    let points = problem.bodies[1].mesh().points();
    for (u, x) in pair.bodies[1].displacement.iter_mut().zip(points) {
        *u += 0.2 * perpendicular(*x);
    }
    let found = check(&problem, &pair);
    assert!((found.rotation - 0.2).abs() < 1e-2, "{found:?}");
}

#[test]
fn a_rigid_side_whose_traction_has_another_resultant_fails_the_check() {
    let plate = RigidCondition {
        edges: FacetSelection::group("top"),
        motion: [Some(0.0), None, Some(0.0)],
        force: Vector::new(0.0, -20.0),
        moment: 0.0,
        about: None,
    };
    let top = BoundaryConditions::new().rigid(plate);
    let problem = two_blocks([6, 3], &top, &BoundaryConditions::new().fix("bottom")).unwrap();
    let mut pair = estimated(&problem).pair;
    let edge = problem.bodies[0].rigid_sides()[0].edges[0].index();
    pair.bodies[0].equilibrated.facet_moments[edge][0][1] += 1e-4;
    let found = check(&problem, &pair);
    assert!(found.rigid_balance > 1e-8, "{found:?}");
}

//! Problems with friction by one call: a certificate with Tresca's law, a residual with Coulomb's.

use certified_contact::nndd::{CoulombSettings, NnddError, NnddSettings};
use certified_contact::{
    AdaptSettings, CertifiedSolution, CoulombResult, Settings, Silent, SolveError, solve, solve_adaptively,
    solve_coulomb,
};
use cre_estimator::Relaxation;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Friction};
use tests::friction::{blocks, patch, pushed_middle, pushed_over_plane};

fn solved(problem: ContactProblem, settings: &Settings) -> CertifiedSolution {
    let solution = solve(problem, settings, &mut Silent).unwrap();
    let estimate = solution.estimate.as_ref().unwrap();
    assert!(solution.is_certified(), "{:?}", estimate.admissibility);
    solution
}

fn coulomb(problem: ContactProblem) -> CoulombResult {
    let mut settings = CoulombSettings::default();
    (settings.tolerance, settings.max_steps) = (1e-13, 80);
    solve_coulomb(problem, &settings, Relaxation::Steps(2), &mut Silent).unwrap()
}

#[test]
fn a_problem_with_the_friction_of_tresca_is_certified() {
    for (problem, friction) in [
        (blocks([18, 9], Friction::tresca(4.0)).unwrap(), [4.92638439911, f64::NAN]),
        (pushed_middle(6.0, [18, 9], &Friction::tresca(4.0)).unwrap(), [f64::NAN; 2]),
    ] {
        let exact = solved(problem.clone(), &Settings::default());
        let iterated = solved(problem, &Settings::default().with_method(NnddSettings::default()));
        for solution in [&exact, &iterated] {
            let results = solution.results.as_ref().unwrap();
            for (k, balance) in results.balance.iter().enumerate() {
                assert!(balance.force.norm() < 1e-9 && balance.moment.abs() < 1e-9, "{k}: {balance:?}");
            }
            for (k, pair) in results.contacts.iter().enumerate() {
                let found = pair.friction.as_ref().unwrap();
                // The first body is the upper one: n = (0, −1), t = (1, 0).
                assert!((pair.resultant + Vector::new(found.force, -pair.contact_force)).norm() < 1e-9);
                assert!(!(found.force - friction[k]).abs().ge(&1e-2), "{} {}", found.force, friction[k]);
            }
        }
        let (a, b) = (exact.bounds.unwrap(), iterated.bounds.unwrap());
        // Both enclose the same numbers.
        let (force, other) = (a.contact_force.unwrap(), b.contact_force.unwrap());
        assert!(force[0] <= other[1] && other[0] <= force[1], "{force:?} {other:?}");
        assert!(
            a.potential_energy[0] <= b.potential_energy[1] && b.potential_energy[0] <= a.potential_energy[1]
        );
        assert!((exact.relative().unwrap() / iterated.relative().unwrap() - 1.0).abs() < 1e-3);
    }
}

#[test]
fn the_potential_energy_of_a_patch_is_enclosed_to_round_off() {
    let solution = solved(patch(Friction::tresca(3.0)).unwrap(), &Settings::default());
    // ½ a − ℓ + ∫ s|w|, with the tractions of the sides doing work on the displacements.
    let [low, high] = solution.bounds.unwrap().potential_energy;
    let energy: f64 = tests::friction::PATCH.iter().sum();
    let work: f64 = (0..2)
        .map(|b| {
            let estimate = solution.estimate.as_ref().unwrap();
            let forces = fem_core::assembly::external_forces(&solution.problem.bodies[b]);
            forces.iter().zip(&estimate.pair.bodies[b].displacement).map(|(f, u)| f.dot(u)).sum::<f64>()
        })
        .sum();
    // The line is 2 long.
    let exact = 0.5 * energy - work + 2.0 * 3.0 * tests::friction::PATCH_SLIP;
    assert!(low <= exact + 1e-10 && exact <= high + 1e-10 && high - low < 1e-9, "{low} {exact} {high}");
    let slips = &solution.results.as_ref().unwrap().contacts[0].friction.as_ref().unwrap().slip_intervals;
    assert_eq!(slips, &[[0.0, 2.0]]);
}

#[test]
fn the_law_of_coulomb_has_a_residual_and_no_certificate() {
    for (mu, residual) in [(0.3, 0.182607249418), (0.6, 0.182720275607)] {
        let problem = blocks([18, 9], Friction::Coulomb { mu }).unwrap();
        let found = coulomb(problem.clone());
        let e_b = found.residual().unwrap();
        assert!(e_b > residual && e_b < 1.1 * residual, "{e_b}");
        // The same number bounds the distance to the problem with the limit μ p that is returned.
        let limits: Vec<f64> = found.frozen_limit().flatten().copied().collect();
        let points: Vec<f64> = problem.contacts[0]
            .interface
            .pairs()
            .iter()
            .map(|p| problem.bodies[0].mesh().points()[p.nodes[0]][0])
            .collect();
        let frozen = Friction::tresca(fem_core::boundary::ScalarData::function(move |x: Vector| {
            let k = points.iter().position(|y| (y - x[0]).abs() < 1e-9);
            k.map_or(f64::NAN, |k| limits[k])
        }));
        let mut settings = Settings::default();
        settings.relaxation = Relaxation::Steps(2);
        let tresca = solved(problem.with_friction(0, frozen).unwrap(), &settings);
        let bound = tresca.estimate.as_ref().unwrap().certificate().unwrap().e_cre;
        let of_frozen = found.bound_for_frozen_limit().unwrap();
        assert!((bound - of_frozen).abs() < 1e-9 * bound, "{bound} {of_frozen}");
        // All slip forwards; c = 0.3 κ with κ = 2.12 on these meshes.
        let c = found.coupling().unwrap();
        println!("μ = {mu}: κ = {}", c / mu);
        assert!((c / mu - 2.12).abs() < 0.005);
        match found.conditional_estimate() {
            Some(estimate) => assert!(mu == 0.3 && (estimate - e_b / (1.0 - c * c).sqrt()).abs() < 1e-15),
            None => assert!(mu == 0.6 && c >= 0.9),
        }
    }
    for (cells, kappa) in [(16, 1.09), (32, 1.14)] {
        let found = coulomb(pushed_over_plane(cells, Friction::Coulomb { mu: 1.0 }).unwrap());
        println!("{cells}: κ = {:?}, e_b = {:?}", found.coupling(), found.residual());
        assert!((found.coupling().unwrap() - kappa).abs() < 0.005);
        assert_eq!(found.conditional_estimate(), None);
    }
    // A body that only friction holds.
    let found = coulomb(pushed_middle(6.0, [18, 9], &Friction::Coulomb { mu: 0.3 }).unwrap());
    println!("e_b {:?} of {}, c = {:?}", found.residual(), found.energy_norm(), found.coupling());
    assert!(found.residual().is_some() && found.relative_residual().unwrap() < 0.5);
}

#[test]
fn what_has_no_certificate_yet_is_refused() {
    let tresca = || blocks([6, 3], Friction::tresca(4.0)).unwrap();
    let with_coulomb = || blocks([6, 3], Friction::Coulomb { mu: 0.3 }).unwrap();
    let settings = Settings::default();
    let refused = solve(with_coulomb(), &settings, &mut Silent).unwrap_err().to_string();
    assert!(refused.contains("solve_coulomb"), "{refused}");
    let refused = solve_adaptively(with_coulomb(), &settings, &AdaptSettings::new(0.1), &mut Silent);
    assert!(matches!(refused, Err(SolveError::Nndd(NnddError::Coulomb { pair: 0 }))));
    let coulomb = CoulombSettings::default();
    let refused = solve_coulomb(tresca(), &coulomb, Relaxation::NONE, &mut Silent);
    assert!(matches!(refused, Err(SolveError::NoCoulomb)));
}

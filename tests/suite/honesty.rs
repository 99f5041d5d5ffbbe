//! Extreme numbers: either a bound that holds, or no certificate. Never a wrong bound.

use certified_contact::{CertifiedSolution, Criterion, Settings, Silent, solve};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_error_squared;
use tests::signorini;

/// Solves a problem with the default settings; `None` if it is refused or not certified.
fn certified(problem: ContactProblem) -> Option<CertifiedSolution> {
    solve(problem, &Settings::default(), &mut Silent).ok().filter(CertifiedSolution::is_certified)
}

/// Solves the exact Signorini problem, the rows of nodes of the lower body moved by `row`, and holds the bound against
/// the error if there is one.
fn holds(materials: [(f64, f64); 2], row: impl Fn(f64) -> f64) -> bool {
    let bodies = signorini::bodies(materials, 0.0, [[16, 8]; 2], |x| Vector::new(x[0], row(x[1]))).unwrap();
    let interface =
        contact_geometry::pair(&bodies[0], &bodies[1], ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    let Some(found) = certified(ContactProblem::between(bodies, interface)) else { return false };
    let estimate = found.estimate.as_ref().unwrap();
    let exact = signorini::exact(materials, 0.0);
    let error: f64 = (0..2)
        .map(|b| {
            let displacement = &estimate.pair.bodies[b].displacement;
            energy_error_squared(&found.problem.bodies[b], displacement, |x| exact[b].stress(x))
        })
        .sum();
    assert!(
        estimate.unchecked().e_cre >= error.sqrt(),
        "{materials:?}: {} < {}",
        estimate.unchecked().e_cre,
        error.sqrt()
    );
    true
}

#[test]
fn a_contrast_of_nine_decades_has_a_bound_that_holds() {
    for contrast in [1e-9, 1e-6, 1e6, 1e9] {
        assert!(holds([(1.0, 0.3), (contrast, 0.3)], |y| y), "{contrast:e} is refused");
    }
}

#[test]
fn nearly_incompressible_bodies_have_a_bound_that_holds() {
    for poisson in [0.499, 0.4999, 0.499_999] {
        assert!(holds([(1.0, poisson), (3.0, poisson)], |y| y), "{poisson} is refused");
    }
    // Beyond that all digits may be lost: every certificate that is given must hold.
    for poisson in [0.499_999_99, 0.499_999_999_99, 0.499_999_999_999_99] {
        holds([(1.0, poisson), (3.0, poisson)], |y| y);
    }
}

#[test]
fn slivers_have_a_bound_that_holds() {
    // The row of nodes nearest to the contact, moved to it: angles of 0.1 degrees and less.
    for height in [2.2e-4, 1e-6, 1e-9, 1e-13] {
        let row = |y: f64| if (-0.2..-0.05).contains(&y) { -height } else { y };
        let certified = holds([(1.0, 0.3), (2.0, 0.2)], row);
        assert!(certified || height < 1e-5, "a height of {height:e} is refused");
    }
}

#[test]
fn a_stiffness_of_any_size_has_a_bound_that_holds() {
    for young in [1e-12, 1e-6, 1e6, 1e12] {
        assert!(holds([(young, 0.3), (2.0 * young, 0.2)], |y| y), "{young:e} is refused");
    }
}

/// Two blocks of length `length`, the upper one pressed down by `strain` times its height.
fn pressed(length: f64, young: f64, strain: f64) -> ContactProblem {
    pressed_at([0.0; 2], length, young, strain)
}

/// [`pressed`], the left end of the contact line at `place`.
fn pressed_at(place: [f64; 2], length: f64, young: f64, strain: f64) -> ContactProblem {
    let steel = |nu| LinearElastic::isotropic(young, nu, Hypothesis::PlaneStrain).unwrap();
    let push = Some((-strain * length).into());
    let upper = BoundaryConditions::new().displace("top", Some(0.0.into()), push);
    let mesh = |y: f64| block([place[0], place[1] + y * length], [2.0 * length, length], [12, 6]).unwrap();
    let upper = Body::new(mesh(0.0), steel(0.3), &upper).unwrap();
    let lower = Body::new(mesh(-1.0), steel(0.2), &BoundaryConditions::new().fix("bottom")).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn the_relative_error_does_not_depend_on_the_size_of_anything() {
    let expected = certified(pressed(1.0, 1.0, 0.01)).unwrap().relative().unwrap();
    for length in [1e-9, 1.0, 1e9] {
        for (young, strain) in [(1e12, 1e-12), (1e12, 1.0), (1.0, 1e-12), (1e-12, 1.0), (1.0, 1e12)] {
            let found = certified(pressed(length, young, strain));
            let found = found.unwrap_or_else(|| panic!("{length:e} {young:e} {strain:e} is refused"));
            let relative = found.relative().unwrap();
            assert!((relative / expected - 1.0).abs() < 1e-9, "{length:e} {young:e} {strain:e}: {relative}");
        }
    }
}

#[test]
fn far_from_the_origin_the_answer_is_the_same() {
    let expected = certified(pressed(1.0, 1.0, 0.01)).unwrap().relative().unwrap();
    for distance in [1e3, 1e6, 1e9, 1e12] {
        let found = certified(pressed_at([distance; 2], 1.0, 1.0, 0.01));
        let relative = found.unwrap_or_else(|| panic!("{distance:e} is refused")).relative().unwrap();
        // Coordinates keep 16 digits of the distance: the mesh changes by that much of a cell, a sixth of the body;
        // and what energies change by counts thirteenfold in the bound, which is a thirteenth of their root.
        let kept = 6.0 * 13.0 * distance * f64::EPSILON;
        assert!((relative / expected - 1.0).abs() < kept.max(1e-9), "{distance:e}: {relative} {expected}");
    }
}

/// Two blocks of cells `width` × `height`, the upper one moved away by `motion` and not touched by anything.
fn moved(cells: [usize; 2], [width, height]: [f64; 2], poisson: f64, motion: [f64; 2]) -> ContactProblem {
    let [nx, ny] = cells;
    let size = [width * nx as f64, height * ny as f64];
    let steel = |nu| LinearElastic::isotropic(1.0, nu, Hypothesis::PlaneStrain).unwrap();
    let lifted = BoundaryConditions::new().displace("top", Some(motion[0].into()), Some(motion[1].into()));
    let upper = Body::new(block([0.0, 0.0], size, cells).unwrap(), steel(poisson), &lifted).unwrap();
    let mesh = block([0.0, -size[1]], size, cells).unwrap();
    let lower = Body::new(mesh, steel(0.3), &BoundaryConditions::new().fix("bottom")).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn flat_cells_pass_the_checks_where_only_rounding_is_left() {
    // Only rounding: the allowance must cover it for every shape of the cells.
    for width in [0.02, 1.0, 20.0, 50.0, 200.0] {
        for cells in [[4, 4], [40, 20], [8, 64]] {
            let found = certified(moved(cells, [width, 1.0], 0.3, [1.0, 0.5]));
            assert!(found.is_some(), "cells {width} times as wide as high, {cells:?}");
        }
    }
}

#[test]
fn bodies_that_nothing_strains_converge() {
    // The energy norm is round-off here, and no measure of anything.
    for cells in [[4, 2], [18, 9]] {
        for lift in [0.01, 1.0] {
            let found =
                solve(moved(cells, [0.1, 0.1], 0.3, [0.0, lift]), &Settings::default(), &mut Silent).unwrap();
            assert_eq!(found.nndd.status, nndd::NnddStatus::StoppedByCriterion, "{cells:?} {lift}");
            assert!(
                found.is_certified() && found.estimate.as_ref().unwrap().unchecked().e_cre < 1e-10 * lift
            );
        }
    }
}

#[test]
fn a_mesh_that_is_not_exact_needs_its_ratio() {
    // A ratio that no iteration reaches: round-off is no excuse if the mesh has an error.
    let mut settings = Settings::default();
    settings.criterion = Criterion::Estimator { ratio: 1e-30, force_balance: None };
    settings.method = settings.method.with_max_iterations(200);
    let found = solve(pressed(1.0, 2.0, 0.01), &settings, &mut Silent).unwrap();
    assert!(
        matches!(found.nndd.status, nndd::NnddStatus::Stalled { at_round_off: true, .. }),
        "{:?}",
        found.nndd.status
    );
    assert!(found.is_certified());
}

#[test]
fn bounds_of_the_energies_allow_for_the_rounding_of_large_motions() {
    // ν = 0, both bodies pressed together between two plates: ε = −0.005 everywhere, which the space holds.
    let strain = 0.005;
    for shift in [0.0, 1024.0, 65_536.0] {
        let steel = || LinearElastic::isotropic(1.0, 0.0, Hypothesis::PlaneStrain).unwrap();
        let held =
            |side: &str, y: f64| BoundaryConditions::new().displace(side, Some(shift.into()), Some(y.into()));
        let mesh = |y: f64| block([0.0, y], [1.0, 1.0], [7, 5]).unwrap();
        let upper = Body::new(mesh(0.0), steel(), &held("top", shift - strain)).unwrap();
        let lower = Body::new(mesh(-1.0), steel(), &held("bottom", shift + strain)).unwrap();
        let interface =
            contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
        let found = certified(ContactProblem::between([upper, lower], interface)).unwrap();
        let bounds = found.bounds.unwrap();
        let holds = |name, [low, high]: [f64; 2], exact: f64| {
            assert!(
                low <= exact && exact <= high,
                "{name}, moved by {shift}: {exact:e} is not in [{low:e}, {high:e}]"
            );
            assert!(high - low <= 1e-4 * exact, "{name}, moved by {shift}: [{low:e}, {high:e}] says nothing");
        };
        // ½ E ε² on an area of 2; no loads.
        holds("J", bounds.potential_energy, strain * strain);
        holds("norm", bounds.energy_norm, 2f64.sqrt() * strain);
        holds("N", bounds.contact_force.unwrap(), strain);
    }
}

#[test]
fn numbers_too_small_for_their_squares_get_no_bound() {
    for strain in [1e-60, 1e-100, 1e-140, 1e-163, 1e-200] {
        let Some(found) = certified(pressed(1.0, 1000.0, strain)) else {
            assert!(strain < 1e-120, "{strain:e} is refused");
            continue;
        };
        let relative = found.relative().unwrap();
        let usual = certified(pressed(1.0, 1000.0, 0.01)).unwrap().relative().unwrap();
        assert!((relative / usual - 1.0).abs() < 1e-9, "{strain:e}: {relative} against {usual}");
    }
}

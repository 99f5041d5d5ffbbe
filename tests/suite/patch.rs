//! The contact patch is solved exactly: uniform pressure, exact energies, and a certificate of zero.

use certified_contact::{Settings, Silent, solve};
use cre_estimator::Estimate;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap, Roles};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::tensor::SymTensor2;
use nndd::{NnddSettings, NnddStatus};
use std::f64::consts::FRAC_PI_2;
use tests::{certify, iterates, patch, prepare, shapes};

#[test]
fn the_patch_is_exact_and_certified_as_exact() {
    let pairs = [
        [(1000.0, 0.3), (1000.0, 0.3)],
        [(2000.0, 0.0), (1000.0, 0.45)],
        [(1.0, 0.2), (50.0, 0.4)],
        [(300.0, -0.3), (2.0, 0.3)],
    ];
    for materials in pairs {
        for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
            for angle in [0.0, 0.3, FRAC_PI_2, 2.0, -2.8] {
                let problem = patch::problem(materials, hypothesis, angle).unwrap();
                let prepared = prepare(&problem);
                let (solution, _) = iterates(&prepared, &NnddSettings::default(), 1e-12).unwrap();
                let case = format!("{materials:?} {hypothesis:?} {angle}");
                let ended = matches!(
                    solution.status,
                    NnddStatus::StoppedByCriterion | NnddStatus::Stalled { at_round_off: true, .. }
                );
                assert!(ended, "{case}: {:?}", solution.status);
                let estimate = certify(&prepared, &solution.last).unwrap();
                let norm = assert_exact(&estimate, materials, hypothesis, &case);
                let [_, delta] = patch::compressions(materials, hypothesis);
                for l in &solution.last.lambda {
                    assert!((l - delta).abs() < 1e-10 * delta, "{case}: {l} against {delta}");
                }
                assert!(estimate.unchecked().eta_dis < 1e-10 * norm, "{case}");
                // With the allowance for round-off in the opening, a square root of it if normals are oblique.
                assert!(
                    estimate.unchecked().e_cre < 1e-7 * norm,
                    "{case}: {:e}",
                    estimate.unchecked().e_cre / norm
                );
            }
        }
    }
}

/// Asserts exact energies, uniform pressure and a valid certificate of zero; returns the energy norm.
pub(crate) fn assert_exact(
    estimate: &Estimate,
    materials: [(f64, f64); 2],
    hypothesis: Hypothesis,
    case: &str,
) -> f64 {
    assert!(estimate.admissibility.is_valid(), "{case}: {:?}", estimate.admissibility);
    let exact = patch::energies(materials, hypothesis);
    let norm = exact.iter().sum::<f64>().sqrt();
    for b in 0..2 {
        let energy = estimate.energy_norm_squared[b];
        assert!((energy - exact[b]).abs() < 1e-10 * exact[b], "{case}: {energy}");
    }
    for p in &estimate.pair.contacts[0].pressure {
        assert!((p - patch::PRESSURE).abs() < 1e-10 * patch::PRESSURE, "{case}: {p}");
    }
    assert!(estimate.cre.e_cre() < 1e-10 * norm, "{case}: {:e}", estimate.cre.e_cre() / norm);
    norm
}

/// Two blocks one above the other, sheared until the contact line between them rises by `slope`; the left side of both is
/// vertical and held in x, oblique to the contact line. Uniform pressure along the normal in both, no shear on the line: the
/// space holds the solution, whose displacement at the held nodes is not zero.
fn oblique(slope: f64) -> (ContactProblem, [f64; 2]) {
    let (young, nu, pressure) = (1000.0, 0.3, 7.0);
    let length = slope.hypot(1.0);
    let normal = [slope / length, -1.0 / length];
    let material = LinearElastic::isotropic(young, nu, Hypothesis::PlaneStrain).unwrap();
    let stress = |i: usize, j: usize| -pressure * normal[i] * normal[j];
    let strain = material.strain(SymTensor2 { xx: stress(0, 0), yy: stress(1, 1), xy: stress(0, 1) });
    let exact = move |x: Vector| {
        [0.02 + strain.xx * x[0] + strain.xy * x[1], -0.01 + strain.xy * x[0] + strain.yy * x[1]]
    };
    let body = |y: f64, driven: &str| {
        let sheared = |x: Vector| Vector::new(x[0], x[1] + slope * x[0]);
        let mesh = shapes::moved(&block([0.0, y], [2.0, 1.0], [6, 3]).unwrap(), sheared).unwrap();
        let [ux, uy] = [0, 1].map(|c| ScalarData::function(move |x| exact(x)[c]));
        let sides = BoundaryConditions::new()
            .displace(driven, Some(ux.clone()), Some(uy))
            .displace("left", Some(ux), None)
            .traction("left", [0.0.into(), (-stress(0, 1)).into()])
            .traction("right", [stress(0, 0).into(), stress(0, 1).into()]);
        Body::new(mesh, material.clone(), &sides).unwrap()
    };
    let (upper, lower) = (body(0.0, "top"), body(-1.0, "bottom"));
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    (ContactProblem::between([upper, lower], interface), [pressure, length])
}

#[test]
fn a_support_oblique_to_the_contact_line_leaves_the_patch_exact() {
    for slope in [0.0, 0.3, -0.5, 0.9] {
        let (problem, [pressure, length]) = oblique(slope);
        let normal = [slope / length, -1.0 / length];
        for pair in problem.contacts[0].interface.pairs() {
            let off = (pair.normal[0] - normal[0]).hypot(pair.normal[1] - normal[1]);
            assert!(off < 1e-14, "{slope}: {:?} against {normal:?}", pair.normal);
        }
        for problem in [problem.clone(), problem.with_roles(Roles::SECOND)] {
            let found = solve(problem, &Settings::default(), &mut Silent).unwrap();
            let estimate = found.estimate.as_ref().unwrap();
            let norm = estimate.energy_norm_squared.iter().sum::<f64>().sqrt();
            assert!(found.is_certified(), "{slope}: {:?}", estimate.admissibility);
            assert!(estimate.cre.e_cre() < 1e-10 * norm, "{slope}: {:e}", estimate.cre.e_cre() / norm);
            for p in &estimate.pair.contacts[0].pressure {
                assert!((p - pressure).abs() < 1e-9 * pressure, "{slope}: {p}");
            }
            let force = found.results.as_ref().unwrap().contact_force;
            assert!((force - 2.0 * length * pressure).abs() < 1e-9 * force, "{slope}: {force}");
        }
    }
}

//! Outcomes that no case file brings about: a certificate that fails its checks, a contact problem that is not solved.

use super::*;
use crate::host::Host;
use crate::{convert, report, run, solved, verdict};
use case_io::report::Report;
use certified_contact::Silent;
use contact_qp::QpStatus;

struct Nowhere;

impl Host for Nowhere {
    fn elapsed(&self) -> f64 {
        0.0
    }
}

fn solved() -> (Case, CertifiedSolution) {
    let small = ["body.0.generator.cells", "body.1.generator.cells"].map(|key| (key.into(), "[4, 2]".into()));
    let case = Case::parse(case_io::template::PAPER, "paper.toml", &small).unwrap();
    let problem = run::build(&case, &Nowhere).unwrap().problem;
    let solution = certified_contact::solve(problem, &convert::settings(&case), &mut Silent).unwrap();
    (case, solution)
}

fn reported(case: &Case, solution: CertifiedSolution) -> (Report, String) {
    let status = judge(case, &solution, None);
    let solved = solved::Solved::of(solved::RunResult::Certified(Box::new(solution)), status);
    let report = report::report(case, &solved, Default::default());
    let said = verdict::verdict(&report);
    (report, said)
}

#[test]
fn a_contact_problem_that_is_not_solved_is_status_5_with_its_own_status() {
    let (case, mut solution) = solved();
    for inner in [QpStatus::MaxIterations, QpStatus::NumericalError, QpStatus::Unbounded] {
        solution.nndd.status = NnddStatus::ContactQpUnsolved(inner);
        let status = judge(&case, &solution, None);
        assert_eq!((status.word.as_str(), status.code), ("stalled", 5));
        assert!(status.reason.contains(&inner.to_string()), "{}", status.reason);
    }
}

#[test]
fn the_advice_for_an_exact_programme_that_is_not_solved_is_no_setting_that_it_has_tried() {
    let (mut case, mut solution) = solved();
    solution.method = nndd::NewtonSettings::default().into();
    solution.nndd.last.recovery = nndd::Recovery::Forces;
    solution.nndd.status = NnddStatus::ContactQpUnsolved(QpStatus::PolishFailed);
    for qp in [QpChoice::Auto, QpChoice::ActiveSet, QpChoice::Clarabel] {
        case.solver.qp = qp;
        let reason = judge(&case, &solution, None).reason;
        assert!(reason.contains("other mesh sizes") && !reason.contains("solver.qp"), "{reason}");
    }
}

#[test]
fn a_bound_that_fails_its_checks_is_never_called_certified() {
    let (case, sound) = solved();
    let (report, said) = reported(&case, sound.clone());
    assert_eq!((report.status.code, report.certificate.as_ref().unwrap().valid), (0, true));
    assert!(said.contains("certified error <="));
    for check in 0..5 {
        let mut solution = sound.clone();
        let a = &mut solution.estimate.as_mut().unwrap().admissibility;
        let residuals = [
            &mut a.equilibrium,
            &mut a.traction_jump,
            &mut a.boundary_traction,
            &mut a.penetration,
            &mut a.pressure_sign,
        ];
        // A residual that is not a number must not pass either.
        *residuals.into_iter().nth(check).unwrap() = if check == 1 { f64::NAN } else { 1e-6 };
        let (report, said) = reported(&case, solution);
        assert_eq!((report.status.word.as_str(), report.status.code), ("not_certified", 6), "check {check}");
        assert!(
            !report.certificate.as_ref().unwrap().valid
                && report.certificate.as_ref().unwrap().bounds.energy_norm.is_none()
        );
        assert!(said.contains("NOT certified") && !said.contains("certified error"), "{said}");
    }
}

//! The end of a run whose bound rises.

use super::*;
use crate::observer::Silent;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::Gap;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use nndd::Start;

/// Solves each mesh, and reports relative bounds that rise from the second mesh on, until the last.
struct Rising(Settings);

const BOUNDS: [f64; 5] = [0.6, 0.5, 0.55, 0.7, 0.1];

impl SolveOnMesh for Rising {
    type Solution = CertifiedSolution;

    fn solve(
        &self,
        problem: ContactProblem,
        previous: Option<(crate::solution::RoleReason, Start)>,
        observer: &mut dyn Observer,
    ) -> Result<CertifiedSolution, SolveError> {
        self.0.solve(problem, previous, observer)
    }

    fn problem(solution: &CertifiedSolution) -> &ContactProblem {
        Settings::problem(solution)
    }

    fn estimates(solution: &CertifiedSolution) -> Vec<&Estimate> {
        Settings::estimates(solution)
    }

    fn last(solution: &CertifiedSolution) -> Option<&nndd::Iterate> {
        Settings::last(solution)
    }

    fn step(solution: &CertifiedSolution, number: usize) -> Step {
        Step { relative: Some(BOUNDS[number - 1]), ..solution.step(number) }
    }

    fn tell(_: &mut dyn Observer, _: &Step, _: &CertifiedSolution) {}

    fn cut_short(solution: &CertifiedSolution) -> Option<AdaptiveEnd> {
        Settings::cut_short(solution)
    }

    fn unsolved(&self, solution: &CertifiedSolution) -> Option<AdaptiveEnd> {
        self.0.unsolved(solution)
    }
}

fn problem() -> ContactProblem {
    let steel = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let pressed = BoundaryConditions::new().displace("left", Some(0.0.into()), None).displace(
        "top",
        None,
        Some((-0.01).into()),
    );
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [4, 2]).unwrap(), steel.clone(), &pressed).unwrap();
    let held = BoundaryConditions::new().fix("bottom");
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap(), steel, &held).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn a_run_whose_bound_rises_twice_ends_with_its_smallest() {
    let method = Rising(Settings::default());
    let found = begin(problem(), &method, &AdaptSettings::new(0.2), &mut Silent).unwrap();
    assert!(matches!(found.end, AdaptiveEnd::Rose), "{:?}", found.end);
    assert_eq!((found.history.len(), found.step), (4, 2));
    assert_eq!(found.solution.problem.nodes(), found.history[1].nodes);
}

#[test]
fn two_rises_in_a_row_are_needed() {
    let steps = |bounds: &[Option<f64>]| -> Vec<Step> {
        let of = |(k, relative): (usize, &Option<f64>)| Step {
            step: k + 1,
            nodes: 9,
            pairs: 3,
            load_step: None,
            e_cre: *relative,
            relative: *relative,
            certified: relative.is_some(),
            e_b: None,
            relative_residual: None,
            iterations: 1,
            energy_norm_squared: Some(1.0),
            peak_stress: None,
        };
        bounds.iter().enumerate().map(of).collect()
    };
    let rose = |bounds: &[Option<f64>]| rose_twice(&steps(bounds));
    assert!(rose(&[Some(0.3), Some(0.1), Some(0.2), Some(0.25)]));
    assert!(!rose(&[Some(0.1), Some(0.2)]) && !rose(&[Some(0.2), Some(0.1), Some(0.3)]));
    assert!(!rose(&[Some(0.1), Some(0.2), Some(0.2)]) && !rose(&[Some(0.1), None, Some(0.3)]));
    assert!(!rose(&[Some(0.1), Some(0.2), Some(0.3), Some(0.25)]));
}

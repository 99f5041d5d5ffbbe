//! The certificate: admissibility, the exact split, and the bound against exact errors.

use cre_estimator::{Estimate, estimate};
use fem_core::condensation::CondensedBody;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, ContactState};
use nndd::stopping::{Decision, EtaNndd, StoppingCriterion};
use nndd::{Iterate, NnddSettings};
use tests::{condense_both, paper, signorini};

pub(crate) fn displacements(bodies: &[CondensedBody; 2], iterate: &Iterate) -> [Vec<Vector>; 2] {
    [
        bodies[0].displacement_from_trace(&iterate.lambda),
        bodies[1].displacement_from_trace(&iterate.contact.normal_trace),
    ]
}

pub(crate) fn certify(problem: &ContactProblem, bodies: &[CondensedBody; 2], iterate: &Iterate) -> Estimate {
    let u = displacements(bodies, iterate);
    let state = ContactState {
        displacement: [&u[0], &u[1]],
        contact_force: &iterate.contact.normal_reaction,
        opening: &iterate.opening,
    };
    estimate(problem, bodies, &state).unwrap()
}

/// Certifies every iteration and hands it to a closure.
struct Every<'a, F: FnMut(&Iterate, &Estimate)> {
    problem: &'a ContactProblem,
    bodies: &'a [CondensedBody; 2],
    inner: EtaNndd,
    look: F,
}

impl<F: FnMut(&Iterate, &Estimate)> StoppingCriterion for Every<'_, F> {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        (self.look)(iterate, &certify(self.problem, self.bodies, iterate));
        self.inner.check(iterate)
    }
}

pub(crate) fn at_every_iteration(
    problem: &ContactProblem,
    settings: &NnddSettings,
    tolerance: f64,
    look: impl FnMut(&Iterate, &Estimate),
) {
    let bodies = condense_both(problem);
    let lambda = vec![0.0; problem.interface.pairs().len()];
    let mut stop = Every { problem, bodies: &bodies, inner: EtaNndd::new(tolerance), look };
    nndd::solve(problem, &bodies, lambda, settings, &mut stop).unwrap();
}

#[test]
fn every_iteration_of_the_papers_problem_is_admissible_and_splits_exactly() {
    let problem = paper::problem(paper::COARSE).unwrap();
    at_every_iteration(&problem, &NnddSettings::paper(0.4), 1e-8, |iterate, e| {
        println!("{} {:?} {} {} {} {:e} {}", iterate.iteration, e.admissibility, e.e_cre, e.eta_dis, iterate.eta_nndd, e.cre.split_defect(),
          (e.eta_dis.powi(2) + iterate.eta_nndd.powi(2)) / e.e_cre.powi(2));
        for f in 0..2 { println!("   {}", (0..e.pair.stress[f].len()).map(|t| e.pair.equilibrated[f].cell_distance_squared(&problem.bodies[f], t, e.pair.equilibrated[f].finite_element[t])).sum::<f64>().sqrt()); }
        assert!(e.admissibility.is_valid());
        assert!(e.cre.split_defect() < 1e-12);
    });
}

#[test]
fn the_bound_holds_at_every_iteration_against_the_exact_solution() {
    for materials in [[(1.0, 0.3), (1.0, 0.3)], [(1.0, 0.2), (20.0, 0.4)]] {
    for n in [8, 16, 32] {
        let problem = signorini::problem(materials, 0.0, [2 * n, n]).unwrap();
        let exact = signorini::exact(materials, 0.0);
        let bodies = condense_both(&problem);
        at_every_iteration(&problem, &NnddSettings::default(), 1e-10, |iterate, e| {
            let u = displacements(&bodies, iterate);
            let error: f64 = (0..2).map(|b| fem_core::norm::energy_error_squared(&problem.bodies[b], &u[b], |x| exact[b].stress(x))).sum();
            println!("{n} {} error {} bound {} eff {} eta {:e} a {:?}", iterate.iteration, error.sqrt(), e.e_cre, e.e_cre / error.sqrt(), iterate.eta_nndd, e.energy_norm_squared);
            assert!(e.e_cre >= error.sqrt());
        });
    }}
}

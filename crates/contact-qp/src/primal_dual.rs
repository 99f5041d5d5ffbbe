//! Primal-dual active-set steps: solve on the set, move every bound with a wrong sign, repeat.
//!
//! One step is `A ← {k ∈ A : r_k ≥ 0} ∪ {k ∉ A : x_k < l_k}`, a semi-smooth Newton step for the KKT conditions
//! (Hintermüller, Ito and Kunisch 2002). It ends after finitely many steps on M-matrices and, in practice,
//! on the Steklov-Poincaré operators of elastic bodies, but may cycle on other matrices.

use crate::active_set::ActiveSet;
use crate::error::QpError;
use crate::polish::{Admissible, Candidate, Prepared, ROUND_OFF};
use std::collections::HashSet;

/// What to do when a set repeats, that is, the steps cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum OnCycle {
    /// Stop; the caller has another method.
    Stop,
    /// From then on move one bound at a time, the last one with a wrong sign, and tolerate wrong signs up to this
    /// fraction of the force scale. In exact arithmetic this rule ends for every positive definite matrix
    /// (Murty 1974).
    SinglePivots { slack: f64 },
}

/// How the steps ended.
pub(crate) enum Outcome {
    /// All signs are correct.
    Found(Admissible),
    /// A set repeated, or the limit was reached.
    NotFound,
    /// `P_II` was not positive definite on some set.
    Singular(QpError),
}

/// Tries at most `limit` active sets, starting from `start`; returns the outcome and the number of sets tried.
pub(crate) fn run(
    problem: &Prepared<'_>,
    start: ActiveSet,
    limit: usize,
    on_cycle: OnCycle,
) -> (Outcome, usize) {
    let mut active = start;
    let mut visited = HashSet::new();
    let mut single_pivots = false;
    let mut slack = ROUND_OFF;
    for step in 1..=limit {
        let mut candidate = match Candidate::new(problem, &active) {
            Ok(candidate) => candidate,
            Err(error) => return (Outcome::Singular(error), step),
        };
        let wrong = wrong_signs(&mut candidate, problem, &active, slack);
        let Some(&last) = wrong.last() else {
            return (Outcome::Found(candidate.into_admissible(&problem.qp, &active)), step);
        };
        visited.insert(active.clone());
        if single_pivots {
            active.flip(last);
            continue;
        }
        wrong.into_iter().for_each(|k| active.flip(k));
        if visited.contains(&active) {
            match on_cycle {
                OnCycle::Stop => return (Outcome::NotFound, step),
                OnCycle::SinglePivots { slack: wider } => {
                    single_pivots = true;
                    slack = wider.max(slack);
                }
            }
        }
    }
    (Outcome::NotFound, limit)
}

/// Lists the wrong signs; a candidate without any is refined, then checked again.
fn wrong_signs(
    candidate: &mut Candidate,
    problem: &Prepared<'_>,
    active: &ActiveSet,
    slack: f64,
) -> Vec<usize> {
    let wrong = candidate.wrong_signs(problem, active, slack);
    if !wrong.is_empty() {
        return wrong;
    }
    candidate.refine(problem);
    candidate.wrong_signs(problem, active, slack)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{BoundQp, MatrixView};

    /// A positive definite matrix (leading minors 4, 11, 2) on which the steps from the empty set return to it
    /// after three: {} → {0, 2} → {0, 1} → {}. Checked in exact arithmetic.
    const CYCLING: BoundQp<'static> = BoundQp {
        matrix: MatrixView::Dense { n: 3, values: &[4.0, 5.0, -5.0, 5.0, 9.0, -5.0, -5.0, -5.0, 7.0] },
        linear: &[2.0, 1.0, -3.0],
        bounded: &[0, 1, 2],
        lower: &[0.0, 0.0, 0.0],
    };

    #[test]
    fn a_cycle_is_noticed() {
        let problem = Prepared::of(&CYCLING).unwrap();
        let (outcome, steps) = run(&problem, ActiveSet::none(3), 1000, OnCycle::Stop);
        assert!(matches!(outcome, Outcome::NotFound));
        assert_eq!(steps, 3);
    }

    #[test]
    fn single_pivots_end_a_cycle() {
        let problem = Prepared::of(&CYCLING).unwrap();
        let on_cycle = OnCycle::SinglePivots { slack: 1e-12 };
        let (outcome, steps) = run(&problem, ActiveSet::none(3), 1000, on_cycle);
        let Outcome::Found(answer) = outcome else { panic!("not found in {steps} steps") };
        // With A = {0}: 9 x₁ − 5 x₂ = −1 and −5 x₁ + 7 x₂ = 3, r₀ = 5 x₁ − 5 x₂ + 2.
        for (found, wanted) in answer.x.iter().zip([0.0, 4.0 / 19.0, 11.0 / 19.0]) {
            assert!((found - wanted).abs() < 1e-14);
        }
        assert!((answer.multipliers[0] - 3.0 / 19.0).abs() < 1e-14);
        assert!(steps > 3);
    }

    #[test]
    fn the_limit_counts_the_sets_tried() {
        let problem = Prepared::of(&CYCLING).unwrap();
        for limit in [0, 1, 2] {
            let (outcome, steps) = run(&problem, ActiveSet::none(3), limit, OnCycle::Stop);
            assert!(matches!(outcome, Outcome::NotFound));
            assert_eq!(steps, limit);
        }
    }
}

//! Results do not depend on the number of threads, bit for bit.

use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use tests::{heavy, paper};

/// Everything that comes out of a run, as bits.
fn bits(answer: &CertifiedSolution) -> Vec<u64> {
    let estimate = answer.estimate.as_ref().unwrap();
    let results = answer.results.as_ref().unwrap();
    let mut numbers: Vec<f64> = Vec::new();
    for row in &answer.rows {
        numbers.extend([row.iteration.precision, row.iteration.eta_nndd, row.iteration.contact_force]);
        numbers.extend(row.e_cre);
        numbers.extend(row.eta_dis);
    }
    for b in 0..2 {
        numbers.extend(estimate.pair.bodies[b].displacement.iter().flatten());
        numbers.extend(&estimate.cre.by_cell[b]);
        numbers.extend(estimate.pair.bodies[b].equilibrated.facet_moments.iter().flatten().flatten());
        numbers.extend(&results.balance[b].force);
        numbers.push(results.balance[b].moment);
    }
    numbers.extend(&answer.last().lambda);
    numbers.extend(&answer.last().contact.normal_reaction);
    numbers.extend([
        estimate.unchecked().e_cre,
        estimate.unchecked().eta_dis,
        results.max_von_mises.unwrap(),
        results.contact_force,
    ]);
    numbers.into_iter().map(f64::to_bits).collect()
}

fn same_on_every_pool(run: impl Fn() -> CertifiedSolution + Sync) {
    let [one, two, seven] = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bits(&run()))
    });
    assert!(one.len() > 100);
    assert_eq!(one, two);
    assert_eq!(one, seven);
}

#[test]
fn the_fine_problem_is_the_same_on_1_2_and_7_threads() {
    // 5760 triangles per body: more than one task of every parallel loop.
    same_on_every_pool(|| {
        solve(paper::problem(paper::FINE).unwrap(), &Settings::default(), &mut Silent).unwrap()
    });
}

#[test]
fn a_tilted_problem_is_the_same_on_1_2_and_7_threads() {
    same_on_every_pool(|| {
        solve(heavy::problem(0.3, 12).unwrap(), &Settings::default(), &mut Silent).unwrap()
    });
}

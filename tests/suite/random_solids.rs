//! A sample of the random solids of `cargo xtask reproduce adversarial`: no promise is violated.

use rayon::prelude::*;
use std::collections::BTreeSet;
use tests::random_solids::{FAMILIES, PROMISES, Problem, Trial};

/// Problems of the sample: of each family four or more.
const SAMPLE: u64 = 144;

/// Problems that violated a promise once.
const FOUND: [(u64, &str); 4] = [
    (559, "round obstacle driven by a force"),
    (2834, "slivers"),
    (3857, "round obstacle"),
    (3879, "round obstacle driven by a force"),
];

#[test]
fn every_promise_is_kept_in_a_sample_of_random_solids() {
    let found =
        FOUND.into_par_iter().map(|(number, family)| Trial::of(&Problem::of_family(number, family).unwrap()));
    let drawn = (1_000_000..1_000_000 + SAMPLE).into_par_iter().map(|n| Trial::new(n).unwrap());
    let trials: Vec<Trial> = found.chain(drawn).collect();
    let said = |t: &Trial| t.violations().map(|v| format!("{} {v:?}", t.number)).collect::<Vec<_>>();
    let violated: Vec<String> = trials.iter().flat_map(said).collect();
    assert!(violated.is_empty(), "{violated:#?}");
    let families: BTreeSet<&str> = trials.iter().map(|t| t.family).collect();
    assert_eq!(families.len(), FAMILIES.len());
    for promise in PROMISES {
        let judged = trials.iter().flat_map(|t| &t.verdicts).filter(|v| v.promise == promise).count();
        assert!(judged >= 20, "{promise:?} was judged {judged} times");
    }
    // Three of four problems of the study are certified, the others are not held, as half of those with friction, or too coarse for an admissible pressure;
    // their bounds are sharp enough for a bound that is too small by a half to be seen.
    let certified = trials.iter().filter(|t| t.refused.is_none()).count();
    assert!(3 * certified > 2 * trials.len(), "{certified} of {}", trials.len());
    let sharp = trials.iter().filter_map(|t| t.effectivity).filter(|e| *e < 2.0).count();
    assert!(10 * sharp > 3 * trials.len(), "{sharp} of {} bounds are below twice the error", trials.len());
}

/// Problems of the sample of adaptive runs: of each family two.
const REFINED: u64 = 62;

#[test]
fn every_promise_is_kept_on_the_meshes_of_adaptive_runs() {
    judge_refined(2_000_000, Trial::adaptive);
}

#[test]
fn every_promise_is_kept_where_surfaces_do_not_match() {
    judge_refined(3_000_000, Trial::overlaid);
}

fn judge_refined(first: u64, judge: fn(&Problem) -> Trial) {
    let trial = |number: u64| judge(&Problem::new(number).unwrap());
    let trials: Vec<Trial> = (first..first + REFINED).into_par_iter().map(trial).collect();
    let said =
        |t: &Trial| t.violations().map(|v| format!("{} {} {v:?}", t.number, t.family)).collect::<Vec<_>>();
    let violated: Vec<String> = trials.iter().flat_map(said).collect();
    let judged = trials.iter().filter(|t| t.refined > 1).count();
    let meshes: usize = trials.iter().map(|t| t.refined).sum();
    println!("{judged} of {} problems refined, {meshes} meshes", trials.len());
    assert!(violated.is_empty(), "{violated:#?}");
    assert!(3 * judged > trials.len(), "{judged} of {}", trials.len());
}

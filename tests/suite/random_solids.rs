//! Random stacks of solids: no bound is below the distance to the solution on a nested mesh.

use tests::random_solids::{Stack, Verdict, judge};

#[test]
fn no_bound_of_random_solids_in_contact_is_below_the_distance_to_a_finer_solution() {
    let (mut judged, mut without, mut refused) = (0, Vec::new(), Vec::new());
    let (mut effectivities, mut violated) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        match judge(&Stack::new(seed)).unwrap() {
            Verdict::Refused(reason) => refused.push((seed, reason)),
            Verdict::Without(reason) => without.push((seed, reason)),
            Verdict::Judged { effectivity, violations } => {
                judged += 1;
                violated.extend(violations.into_iter().map(|violation| (seed, violation)));
                effectivities.extend(effectivity);
            }
        }
    }
    println!("{judged} judged, without {without:?}, refused {refused:?}");
    effectivities.sort_by(f64::total_cmp);
    println!("{effectivities:?}");
    assert!(violated.is_empty(), "{violated:?}");
    assert!(judged > 45, "{judged} judged, without {without:?}, refused {refused:?}");
}

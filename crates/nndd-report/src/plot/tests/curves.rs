//! Figures of curves: sweeps, convergence, adaptive runs.

use super::*;
use case_io::report::{IterationRow, SweepPanel, SweepRow};

fn rows(n: usize) -> Vec<IterationRow> {
    (1..=n)
        .map(|k| IterationRow {
            iteration: k,
            eta_nndd: Some(0.5f64.powi(k as i32)),
            precision: Some(0.1 * 0.3f64.powi(k as i32)),
            eta_dis: (k % 2 == 0).then_some(0.9),
            ..IterationRow::default()
        })
        .collect()
}

const VALUES: [f64; 3] = [0.2, 0.4, 0.6];

fn constant(name: &str, value: Option<f64>) -> SweepPanel {
    let iteration = IterationRow { eta_nndd: value, eta_dis: value, e_cre: value, ..IterationRow::default() };
    let row = SweepRow { valid: true, iteration, ..SweepRow::default() };
    SweepPanel { name: name.into(), rows: vec![row; 3], ..SweepPanel::default() }
}

#[test]
fn sweep_names_its_panels_series_and_losses() {
    let mut fine = constant("fine <5994> & more", Some(0.2));
    for (row, eta) in fine.rows.iter_mut().zip([Some(0.5), Some(0.01), None]) {
        row.iteration.eta_nndd = eta;
    }
    let svg = sweep("Sweep", "solver.theta", &VALUES, &[constant("coarse", Some(1.0)), fine]);
    assert_whole(&svg);
    for text in ["coarse", "fine &lt;5994&gt; &amp; more", "eta_nndd", "eta_dis", "e_cre", "energy^1/2"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.contains("smallest eta_nndd at solver.theta = 0.4") && svg.contains("1 of 3 left out"));
}

#[test]
fn sweep_draws_no_point_of_a_run_that_is_not_valid() {
    let mut panel = constant("mesh", Some(0.2));
    let drawn = sweep("Sweep", "solver.theta", &VALUES, &[panel.clone()]);
    panel.rows.iter_mut().for_each(|row| row.valid = false);
    let none = sweep("Sweep", "solver.theta", &VALUES, &[panel]);
    assert!(!drawn.contains("no data") && none.contains("no data") && none.contains("3 of 3 left out"));
}

#[test]
fn sweep_of_nothing_says_so() {
    let empty = SweepPanel { name: "e".into(), ..SweepPanel::default() };
    for panels in [vec![], vec![empty], vec![constant("lost", None)], vec![constant("zero", Some(0.0))]] {
        let svg = sweep("Sweep", "theta", &VALUES, &panels);
        assert_whole(&svg);
        assert!(svg.contains("no data"));
    }
    for bad in BAD {
        let panels = [constant("bad", Some(bad)), constant("good", Some(1.0))];
        assert_whole(&sweep("Sweep", "theta", &[0.2, bad, 0.6], &panels));
    }
}

#[test]
fn convergence_shows_only_what_was_computed() {
    let svg = convergence("Convergence", &rows(12), &Labels::default());
    assert_whole(&svg);
    assert!(svg.contains("eta_nndd") && svg.contains("precision") && svg.contains("eta_dis"));
    assert!(!svg.contains("e_cre (total"), "a legend entry without data");
    assert!(svg.contains("1e-3"), "logarithmic ticks");
}

#[test]
fn convergence_of_odd_rows() {
    assert!(convergence("None", &[], &Labels::default()).contains("no data"));
    assert_whole(&convergence("One", &rows(1), &Labels::default()));
    for bad in BAD.into_iter().chain([0.0, -1.0]) {
        let mut odd = rows(5);
        odd[2].eta_nndd = Some(bad);
        odd[3].precision = Some(bad);
        odd[1].eta_dis = Some(bad);
        odd[4].e_cre = Some(bad);
        assert_whole(&convergence("Odd", &odd, &Labels::default()));
    }
    let mut many = rows(20_000);
    for (k, row) in many.iter_mut().enumerate() {
        row.eta_nndd = Some(if k % 2 == 0 { 1e-9 } else { 1.0 });
        row.precision = row.eta_nndd;
        row.e_cre = row.eta_nndd;
    }
    assert_whole(&convergence("Many", &many, &Labels::default()));
}

#[test]
fn adaptive_shows_the_rate_and_the_target() {
    let steps = [(380, Some(0.19)), (1000, Some(0.06)), (4000, Some(0.029))];
    let svg = adaptive(Measure::CertifiedError, &steps, 0.03, false);
    assert_whole(&svg);
    for text in ["certified relative error", "N^(-1/2)", "target", "nodes of all bodies"] {
        assert!(svg.contains(text), "{text}");
    }
    let svg = adaptive(Measure::Residual, &steps, 0.03, false);
    assert!(
        svg.contains("relative residual, no bound") && !svg.to_lowercase().contains("certified"),
        "{svg}"
    );
}

#[test]
fn adaptive_of_odd_steps() {
    for steps in [vec![], vec![(10, None)], vec![(0, Some(0.1))]] {
        let svg = adaptive(Measure::CertifiedError, &steps, 0.03, false);
        assert_whole(&svg);
        assert!(svg.contains("no data"));
    }
    let one = adaptive(Measure::CertifiedError, &[(380, Some(0.2))], 0.1, false);
    assert_whole(&one);
    assert!(!one.contains("N^(-1/2)"), "a rate of one point");
    for bad in BAD.into_iter().chain([0.0, -1.0]) {
        assert_whole(&adaptive(
            Measure::Residual,
            &[(100, Some(0.1)), (200, Some(bad)), (400, None)],
            bad,
            false,
        ));
    }
}

#[test]
fn words_are_large_enough_for_a_telephone() {
    // At 390 pixels the page is 366 wide; 14 of 480 are then 10.7 pixels.
    let svg = convergence("Convergence", &rows(12), &Labels::default());
    let sizes: Vec<f64> = svg
        .split("font-size=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().parse::<f64>().unwrap())
        .collect();
    let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(smallest * 366.0 / sheet::WIDTH >= 9.5, "{smallest}");
}

#[test]
fn forces_follow_the_factor_back_and_forth() {
    let labels = Labels::default();
    let forces: [Forces<'_>; 1] = [("line", [0.0, 2.0, 1.0].map(|f| [Some(4.0), Some(f)]).to_vec())];
    let svg = steps(&Along::Factor("push", &[0.0, 1.0, 0.0]), &forces, &labels);
    assert!(svg.contains("Forces against the factor of push"), "{svg}");
    let by_step = steps(&Along::Step, &forces, &labels);
    assert!(by_step.contains("Forces against the load step"), "{by_step}");
    // The first and the third disc have the same place; the one before them is the legend's.
    let places = |svg: &str| -> Vec<String> {
        let discs = svg.split("<circle cx=\"").skip(2);
        discs.map(|disc| disc.split('"').next().unwrap().to_owned()).collect()
    };
    let [a, b, c] = &places(&svg)[..] else { panic!("{svg}") };
    assert!(a == c && a != b);
    let [a, _, c] = &places(&by_step)[..] else { panic!("{by_step}") };
    assert!(a != c);
}

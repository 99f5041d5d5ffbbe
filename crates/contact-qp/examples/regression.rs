//! A bounded regression: how much of each of five known spectra is in a measured mixture? No amount is negative.
//!
//! ```text
//!     min  ½ ‖A c − y‖²,  c ≥ 0        P = AᵀA,  q = −Aᵀy
//! ```
//! The lines overlap, so plain least squares fits the noise with negative amounts.
#![allow(clippy::print_stdout)]

use contact_qp::{BoxQp, BoxSolution, MatrixView, QpError, QpSettings, SparseRows, solve_box};

const SPECTRA: usize = 5;
const CHANNELS: usize = 60;
/// The true amounts in the mixture.
const AMOUNTS: [f64; SPECTRA] = [2.0, 0.0, 1.0, 0.0, 0.5];

/// The normal equations of the mixture, whose measurement is disturbed by `noise`.
struct Mixture {
    matrix: Vec<f64>,
    linear: Vec<f64>,
}

impl Mixture {
    fn new(noise: f64) -> Self {
        // Gaussian lines around the channels 10, 18, 26, 34 and 42, 8 channels wide.
        let line = |k: usize, channel: usize| {
            let x = (channel as f64 - 10.0 - 8.0 * k as f64) / 8.0;
            (-x * x).exp()
        };
        let measured: Vec<f64> = (0..CHANNELS)
            .map(|c| {
                let mixture: f64 = (0..SPECTRA).map(|k| AMOUNTS[k] * line(k, c)).sum();
                mixture - noise * (2.7 * c as f64 + 0.3 * (c * c) as f64).sin()
            })
            .collect();
        let product = |k: usize, values: &dyn Fn(usize) -> f64| -> f64 {
            (0..CHANNELS).map(|c| line(k, c) * values(c)).sum()
        };
        let matrix =
            (0..SPECTRA * SPECTRA).map(|e| product(e % SPECTRA, &|c| line(e / SPECTRA, c))).collect();
        let linear = (0..SPECTRA).map(|k| -product(k, &|c| measured[c])).collect();
        Self { matrix, linear }
    }

    /// Fits the amounts, none less than a given one.
    fn fit(&self, least: f64) -> Result<BoxSolution, QpError> {
        let matrix = MatrixView::Dense { n: SPECTRA, values: &self.matrix };
        let (lower, upper, rows) = ([least; SPECTRA], [f64::INFINITY; SPECTRA], SparseRows::new(SPECTRA));
        let linear = &self.linear;
        let qp = BoxQp { matrix, linear, lower: &lower, upper: &upper, rows: &rows, right_side: &[] };
        solve_box(&qp, None, &QpSettings::default())
    }
}

fn main() -> Result<(), QpError> {
    let mixture = Mixture::new(0.3);
    let (plain, bounded) = (mixture.fit(f64::NEG_INFINITY)?, mixture.fit(0.0)?);
    println!("spectrum   true   plain fit   bounded fit   multiplier");
    for k in 0..SPECTRA {
        let (free, fit, r) = (plain.x[k], bounded.x[k], bounded.multipliers[k]);
        println!("{k:8}  {:5.2}  {free:10.3}  {fit:12.3}  {r:11.3}", AMOUNTS[k]);
    }
    println!("{} by {}, largest KKT residual {:.1e}", bounded.status, bounded.path, bounded.kkt.max());
    Ok(())
}

#[test]
fn bounds_remove_what_only_the_noise_asks_for() {
    let far = |fit: &[f64]| fit.iter().zip(AMOUNTS).map(|(c, a)| (c - a).powi(2)).sum::<f64>().sqrt();
    let clean = Mixture::new(0.0).fit(0.0).unwrap();
    assert!(far(&clean.x) < 1e-10, "{:?}", clean.x);
    let noisy = Mixture::new(0.3);
    let (plain, bounded) = (noisy.fit(f64::NEG_INFINITY).unwrap(), noisy.fit(0.0).unwrap());
    assert!(plain.x.iter().any(|c| *c < 0.0), "{:?}", plain.x);
    assert!(bounded.status.is_solved() && bounded.kkt.max() < 1e-12);
    assert!(bounded.x.iter().all(|c| *c >= 0.0) && bounded.multipliers.iter().any(|r| *r > 0.0));
    assert!(far(&bounded.x) < far(&plain.x), "{} {}", far(&bounded.x), far(&plain.x));
}

//! How the imbalance `r¹ + r²` is shared between the bodies.

use crate::settings::Weights;
use fem_core::condensation::OrientedBody;

/// Nodal weights, and the corresponding form of the update.
#[derive(Clone, Debug)]
pub(crate) struct NodalWeights {
    /// `d₁`, `d₂` at each pair, sum 1.
    pub(crate) share: [Vec<f64>; 2],
    /// The paper's update is `w¹ − w²`; with weights it is `d₁ w¹ − d₂ w²`.
    weigh_update: bool,
}

impl NodalWeights {
    pub(crate) fn new(bodies: &[OrientedBody<'_>; 2], weights: Weights) -> Self {
        let n = bodies[0].len();
        match weights {
            Weights::Half => Self { share: [vec![0.5; n], vec![0.5; n]], weigh_update: false },
            Weights::Stiffness => {
                let diagonal =
                    |b: &OrientedBody<'_>| -> Vec<f64> { (0..n).map(|i| b.schur()[i * n + i]).collect() };
                let (k1, k2) = (diagonal(&bodies[0]), diagonal(&bodies[1]));
                let first: Vec<f64> = k1.iter().zip(&k2).map(|(a, b)| a / (a + b)).collect();
                let second = first.iter().map(|d| 1.0 - d).collect();
                Self { share: [first, second], weigh_update: true }
            }
        }
    }

    /// Tells whether the bodies have equal weights, so that `w̄ = −2 w¹`.
    pub(crate) fn is_half(&self) -> bool {
        !self.weigh_update
    }

    /// Computes the loads of step 2: `−d₁ (r¹+r²)` and `+d₂ (r¹+r²)`.
    pub(crate) fn loads(&self, imbalance: &[f64]) -> [Vec<f64>; 2] {
        let share = |sign: f64, d: &[f64]| imbalance.iter().zip(d).map(|(s, d)| sign * d * s).collect();
        [share(-1.0, &self.share[0]), share(1.0, &self.share[1])]
    }

    /// Computes the direction of the update from the corrections' traces.
    pub(crate) fn update(&self, w: [&[f64]; 2]) -> Vec<f64> {
        let pairs = w[0].iter().zip(w[1]);
        if self.weigh_update {
            let share = self.share[0].iter().zip(&self.share[1]);
            pairs.zip(share).map(|((a, b), (d1, d2))| d1 * a - d2 * b).collect()
        } else {
            pairs.map(|(a, b)| a - b).collect()
        }
    }
}

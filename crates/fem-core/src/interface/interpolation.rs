//! The difference between a gap given as a function, or measured between curves, and its linear interpolant on
//! contact edges.

use super::{ContactInterface, Gap, RigidLine};
use crate::body::DifferenceSum;
use crate::body::{Body, Difference};
use crate::geometry::{Vector, norm};

impl ContactInterface {
    /// Measures the difference between the initial gap and the one on the contact edges, relative to its largest
    /// value, by sampling at [`crate::body::SAMPLES`] points: `g/|n|`, with
    /// gap `g` and normal `n` linear between the pairs. `None` if the two are equal to round-off.
    ///
    /// * `body`: the one on which it is measured; `line`: the obstacle's, if there is one.
    pub(super) fn interpolated_gap(&self, body: &Body, line: Option<&RigidLine>) -> Option<Difference> {
        let interface = self;
        let side = interface.measured_on;
        let points = body.mesh().points();
        let (pairs, edges, profiles) = interface.line();
        let edges: Vec<_> = edges.iter().zip(profiles).collect();
        let sum = DifferenceSum::of(&edges, |sum, (edge, profile)| {
            let pairs = edge.pairs.map(|k| &pairs[k as usize]);
            let ends = pairs.map(|pair| points[pair.nodes[side]]);
            let gaps = pairs.map(|pair| pair.gap);
            let between = |a: Vector, b: Vector, s: f64| (1.0 - s) * a + s * b;
            let linear = |s: f64| (1.0 - s) * gaps[0] + s * gaps[1];
            let meant = |s: f64| match (&interface.gap, profile, line) {
                (Gap::Given(data), ..) => data.at(between(ends[0], ends[1], s)),
                (Gap::Geometric, Some(profile), _) => profile.at(s),
                (Gap::Geometric, None, Some(line)) => line.distance(between(ends[0], ends[1], s)).0,
                (Gap::Geometric, None, None) | (Gap::Touching, ..) => linear(s),
            };
            // Between the pairs the normal is shorter than one, so the same number is a wider gap.
            let normal = |s: f64| norm(between(pairs[0].normal, pairs[1].normal, s));
            sum.compare(edge.measure, meant, |s| linear(s) / if edge.bent { normal(s) } else { 1.0 });
        });
        sum.difference()
    }
}

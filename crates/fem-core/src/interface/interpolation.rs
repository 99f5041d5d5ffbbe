//! The difference between a gap given as a function, or measured between curves, and its linear interpolant on
//! contact edges.

use super::{ContactInterface, Gap, RigidLine};
use crate::body::DifferenceSum;
use crate::body::{Body, Difference};
use crate::geometry::{Vector, norm};

impl ContactInterface {
    /// Measures the difference between the initial gap and the one on the contact edges, relative to its largest
    /// value, by sampling at [`crate::body::SAMPLES`] points: `G·n/|n|`, with
    /// gap `G` ([`super::NodePair::gap_vector`]) and normal `n` linear between the pairs. `None` if the two are equal to round-off.
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
            let on_bent = |s: f64| {
                let normal = between(pairs[0].normal, pairs[1].normal, s);
                between(pairs[0].gap_vector(), pairs[1].gap_vector(), s).dot(&normal) / norm(normal)
            };
            let factor = interface.gap_factor;
            let meant = |s: f64| match (&interface.gap, profile, line) {
                (Gap::Given(data), ..) => factor * data.at(between(ends[0], ends[1], s)),
                (Gap::Touching | Gap::Bonded { .. }, ..) => 0.0,
                (gap, Some(profile), _) => factor * gap.kept(profile.at(s)),
                (_, None, Some(line)) => factor * line.distance(between(ends[0], ends[1], s)).0,
                (_, None, None) => linear(s),
            };
            sum.compare(edge.measure, meant, |s| if edge.bent { on_bent(s) } else { linear(s) });
        });
        sum.difference()
    }
}

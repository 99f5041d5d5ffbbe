//! How far a gap given as a function, or measured between curves, is from what linear contact edges make of it.

use super::{ContactProblem, Gap};
use crate::body::Difference;
use crate::body::DifferenceSum;
use crate::geometry::{Vector, norm, sub};

impl ContactProblem {
    /// Measures how far the initial gap is from the one that is linear between the pairs, relative to its largest
    /// value; `None` where the two are the same to round-off.
    pub fn interpolated_gap(&self) -> Option<Difference> {
        let interface = &self.interface;
        let side = interface.measured_on;
        let points = self.bodies[side].mesh().points();
        let mut sum = DifferenceSum::default();
        for (edge, profile) in interface.edges.iter().zip(&interface.profiles) {
            let pairs = edge.pairs.map(|k| &interface.pairs[k as usize]);
            let ends = pairs.map(|pair| points[pair.nodes[side] as usize]);
            let gaps = pairs.map(|pair| pair.gap);
            let fraction = |x: Vector| norm(sub(x, ends[0])) / norm(sub(ends[1], ends[0]));
            match (&interface.gap, profile) {
                (Gap::Given(data), _) => sum.edge(ends, gaps, |x| data.at(x)),
                (Gap::Geometric, Some(profile)) => sum.edge(ends, gaps, |x| profile.at(fraction(x))),
                (Gap::Geometric, None) => {
                    sum.edge(ends, gaps, |x| (1.0 - fraction(x)) * gaps[0] + fraction(x) * gaps[1]);
                }
            }
        }
        sum.difference()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::boundary::{BoundaryConditions, ScalarData};
    use crate::interface::ContactInterface;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    #[test]
    fn only_a_gap_that_is_not_linear_differs() {
        let body = |y: f64| {
            let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
            let mesh = block([-1.0, y], [2.0, 1.0], [4, 1]).unwrap();
            Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
        };
        let problem = |gap: ScalarData| {
            let bodies = [body(0.0), body(-1.0)];
            let gap = Gap::Given(gap);
            let interface = ContactInterface::pair(&bodies[0], &bodies[1], ["bottom", "top"], &gap).unwrap();
            ContactProblem { bodies, interface }
        };
        assert_eq!(problem(0.1.into()).interpolated_gap(), None);
        assert_eq!(problem(ScalarData::function(|x| 0.1 + 0.05 * x[0])).interpolated_gap(), None);
        // Edges of length ½: x² is below its interpolant by h²/4 = 1/16 in the middle of each.
        for swap in [false, true] {
            let parabola = problem(ScalarData::function(|x| x[0] * x[0]));
            let parabola = if swap { parabola.swapped() } else { parabola };
            let difference = parabola.interpolated_gap().unwrap();
            assert!((difference.largest - 0.0625).abs() < 1e-12);
        }
    }
}

//! Gaps that are not linear along an edge.

use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;

#[test]
fn only_a_gap_that_is_not_linear_differs() {
    let body = |y: f64| {
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([-1.0, y], [2.0, 1.0], [4, 1]).unwrap();
        Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
    };
    let difference = |gap: ScalarData| {
        let [upper, lower] = [body(0.0), body(-1.0)];
        let gap = Gap::Given(gap);
        let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &gap).unwrap();
        ContactProblem::between([upper, lower], interface).interpolated_gaps()[0]
    };
    assert_eq!(difference(0.1.into()), None);
    assert_eq!(difference(ScalarData::function(|x| 0.1 + 0.05 * x[0])), None);
    // Edges of length ½: x² is below its interpolant by h²/4 = 1/16 in the middle of each.
    let difference = difference(ScalarData::function(|x| x[0] * x[0])).unwrap();
    assert!((difference.largest - 0.0625).abs() < 1e-12);
}

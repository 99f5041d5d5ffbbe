use super::*;
use crate::boundary::BoundaryConditions;
use crate::interface::{ContactInterface, Gap};
use crate::material::{Hypothesis, LinearElastic};
use crate::mesh::generate::block;

fn body(origin: Vector, size: Vector, cells: [usize; 2]) -> Body {
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    Body::new(block(origin, size, cells).unwrap(), material, &BoundaryConditions::new()).unwrap()
}

fn pair(bodies: &[Body; 2]) -> ContactInterface {
    ContactInterface::pair(&bodies[0], &bodies[1], ["bottom", "top"], &Gap::Given(0.0.into())).unwrap()
}

fn area(body: &Body) -> f64 {
    (0..body.mesh().triangles().len()).map(|t| body.mesh().area(t)).sum()
}

#[test]
fn blocks_of_any_ratio_match() {
    for (m, n) in [(2, 3), (6, 7), (17, 40), (16, 23), (8, 31), (3, 200), (1, 400)] {
        let upper = body([0.0, 1.0], [2.0, 1.0], [m, (m / 2).max(1)]);
        let lower = body([0.0, 0.0], [2.0, 1.0], [n, (n / 2).min(20)]);
        let common = common_refinement([upper, lower], ["bottom", "top"]).unwrap();
        let interface = pair(&common.bodies);
        assert!((interface.length() - 2.0).abs() < 1e-14);
        let changes = common.changes.unwrap();
        for body in &common.bodies {
            assert!((area(body) - 2.0).abs() < 1e-12);
        }
        assert_eq!(changes.free, [0.0; 2]);
        // Shared nodes at the ends at least.
        assert!(interface.pairs().len() <= m + n);
        assert!(changes.smallest_angle.iter().all(|a| *a > 5.0), "{changes:?}");
    }
}

#[test]
fn matching_surfaces_stay_as_they_are() {
    let bodies = [body([0.0, 1.0], [2.0, 1.0], [7, 3]), body([0.0, 0.0], [2.0, 1.0], [7, 5])];
    let points = bodies.each_ref().map(|b| b.mesh().points().to_vec());
    let common = common_refinement(bodies, ["bottom", "top"]).unwrap();
    assert_eq!(common.changes, None);
    assert_eq!(common.bodies.each_ref().map(|b| b.mesh().points().to_vec()), points);
}

//! Refined contact surfaces of solids.

use contact_geometry::{edge_order, halved};
use fem_core::body::{Body, DeclaredSurface, SurfaceKind};
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::tube;

#[test]
fn a_clearance_between_declared_cylinders_is_the_same_on_finer_meshes() {
    let body = |radii, name: &str| {
        let mesh = tube([0.0; 3], radii, 1.0, [0.0, 90.0], [3, 2, 2]).unwrap();
        let steel = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap();
        let declared = DeclaredSurface { on: name.into(), kind: SurfaceKind::Cylinder };
        Body::new(mesh, steel, &BoundaryConditions::default()).unwrap().with_surfaces(&[declared]).unwrap()
    };
    let (pin, eye) = (body([0.5, 1.0], "outer"), body([1.1, 2.0], "inner"));
    let interface = contact_geometry::pair_solids(&pin, &eye, ["outer", "inner"], &Gap::Geometric).unwrap();
    let mut problem = ContactProblem::between([pin, eye], interface);
    let mut order = edge_order(&problem).unwrap();
    for round in 0..5 {
        // The pin alone is marked.
        let cells = (0..problem.bodies[0].mesh().cells().len() as u32).filter(|k| round < 3 || k % 9 == 0);
        let found = halved(&problem, &order, &[cells.collect(), Vec::new()]).unwrap();
        (problem, order) = (found.problem, found.order);
        let points = [0, 1].map(|b: usize| problem.bodies[b].mesh().points());
        for pair in problem.contacts[0].interface.pairs() {
            let [x, y] = [0, 1].map(|b: usize| points[b][pair.nodes[b]]);
            assert!((x[0].hypot(x[1]) - 1.0).abs() < 1e-10 && (y[0].hypot(y[1]) - 1.1).abs() < 1e-10);
            assert!((pair.gap - 0.1).abs() < 1e-9, "{}", pair.gap);
            let arm = [x[0], x[1], 0.0];
            assert!((0..3).all(|c| (pair.normal[c] - arm[c]).abs() < 1e-9));
        }
        let [area, all] = [problem.contacts[0].interface.measure(), std::f64::consts::FRAC_PI_2];
        assert!(area < all && area > 0.97 * all, "{area}");
    }
    assert!(problem.node_pairs() > 90, "{}", problem.node_pairs());
}

//! Exact solutions of assemblies with many pairs on one body.

use contact_qp::QpSettings;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::block;
use fem_core::mesh::id::NodeId;
use nndd::{ExactSolution, solve_exactly};
use tests::prepare;

fn material() -> LinearElastic {
    LinearElastic::isotropic(1000.0, 0.2, Hypothesis::PlaneStrain).unwrap()
}

fn solved(problem: &ContactProblem) -> ExactSolution {
    let solution = solve_exactly(&prepare(problem).system(), &QpSettings::default()).unwrap();
    assert!(solution.status.is_solved() && solution.clarabel_calls == 0, "{:?}", solution.status);
    assert!(solution.kkt.max() < 1e-12, "{:?}", solution.kkt);
    solution
}

/// Blocks of width 1 that float, with distances of 1, on a long base that is held all along.
fn row(count: usize) -> ContactProblem {
    let flat = block([0.0, 0.0], [2.0 * count as f64, 1.0], [4 * count, 1]).unwrap();
    let facets = flat.topology().facets();
    let ends = |side: &str| flat.group(side).unwrap().iter().map(|edge| facets[*edge]);
    let middle = |[a, b]: &[NodeId; 2]| 0.5 * (flat.points()[*a][0] + flat.points()[*b][0]);
    let mut groups = vec![("bottom".to_owned(), ends("bottom").collect::<Vec<_>>())];
    for k in 0..count {
        let under = (2 * k) as f64..(2 * k + 1) as f64;
        groups.push((format!("top{k}"), ends("top").filter(|ends| under.contains(&middle(ends))).collect()));
    }
    let mesh = TriMesh::new(flat.points().to_vec(), flat.cells().to_vec(), groups).unwrap();
    let held = BoundaryConditions::new().fix("bottom");
    let mut bodies = vec![Body::new(mesh, material(), &held).unwrap()];
    let guided = BoundaryConditions::new().displace("left", Some(0.0.into()), None);
    let loaded = guided.traction("top", [0.0.into(), (-1.0).into()]);
    for k in 0..count {
        let mesh = block([2.0 * k as f64, 1.0], [1.0, 1.0], [2, 2]).unwrap();
        bodies.push(Body::new(mesh, material(), &loaded).unwrap());
    }
    let mut problem = ContactProblem::new(bodies);
    for k in 0..count {
        let (own, base) = (&problem.bodies[k + 1], &problem.bodies[0]);
        let surfaces = ["bottom", &format!("top{k}")];
        let interface = contact_geometry::pair(own, base, surfaces, &Gap::Touching).unwrap();
        problem = problem.contact([k + 1, 0], interface);
    }
    problem
}

#[test]
fn blocks_far_apart_on_a_long_base_do_not_feel_each_other() {
    // The flexibilities of the base decay: with 180 blocks most are negligible and left out, with 40 the matrix is full.
    let [few, many] = [40, 180].map(|count| solved(&row(count)));
    assert!(many.contact_force.len() * 3 > 512);
    for (k, forces) in many.contact_force.iter().enumerate() {
        assert!((forces.iter().sum::<f64>() - 1.0).abs() < 1e-10, "{k}: {forces:?}");
    }
    for (a, b) in few.contact_force[20].iter().zip(&many.contact_force[90]) {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
}

#[test]
fn a_beam_on_many_circles_needs_few_sets() {
    let count = 48;
    let mesh = block([0.0, 0.0], [count as f64, 1.0], [2 * count, 1]).unwrap();
    let conditions = BoundaryConditions::new().traction("top", [0.0.into(), (-1.0).into()]);
    let beam = Body::new(mesh, material(), &conditions.displace("left", Some(0.0.into()), None)).unwrap();
    let mut problem = ContactProblem::new(vec![beam.clone()]);
    for k in 0..count {
        let centre = Vector::new(k as f64 + 0.5, -1.0);
        let obstacle = Obstacle::fixed(RigidLine::Circle { centre, radius: 1.0, inside: false });
        let interface = contact_geometry::against(&beam, "bottom", &obstacle, Some(&Gap::Geometric)).unwrap();
        problem = problem.obstacle(0, interface, obstacle);
    }
    // Each node is in the pairs of several circles: all closed at first, it takes 10 sets.
    let solution = solved(&problem);
    assert!(solution.iterations <= 7, "{}", solution.iterations);
    let force = solution.contact_force.iter().flatten().sum::<f64>();
    assert!((force - count as f64).abs() < 1e-9 * count as f64, "{force}");
}

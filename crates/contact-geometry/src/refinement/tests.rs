use super::*;
use crate::ContactNormal;
use crate::common_refinement::common_refinement;
use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
use fem_core::geometry::Vector;
use fem_core::interface::Roles;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{Facing, block, half_disc};
use fem_core::mesh::id::FacetId;

fn problem(cells: [usize; 2]) -> ContactProblem {
    problem_with(cells, ScalarData::function(|x| x[0] * x[0]))
}

fn problem_with(cells: [usize; 2], gap: ScalarData) -> ContactProblem {
    let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let pressed = FacetSelection::group("top").within([[0.0, 0.9], everywhere]);
    let rest = FacetSelection::group("top").within([[1.0, 2.0], everywhere]);
    let upper = Body::new(
        block([0.0, 1.0], [2.0, 1.0], [4, 2]).unwrap(),
        material.clone(),
        &BoundaryConditions::new()
            .displace("left", Some(0.0.into()), None)
            .displace(pressed, None, Some(ScalarData::function(|x| x[0] * x[0])))
            .traction(rest, [0.0.into(), ScalarData::function(|x| x[0])]),
    )
    .unwrap();
    let lower = block([0.0, 0.0], [2.0, 1.0], cells).unwrap();
    let lower = Body::new(lower, material, &BoundaryConditions::new().fix("bottom")).unwrap();
    let interface = crate::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(gap)).unwrap();
    ContactProblem::between([upper, lower], interface)
}

fn labels(problem: &ContactProblem) -> Vec<RefinementEdges> {
    problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect()
}

fn unmarked(problem: &ContactProblem) -> Vec<Vec<bool>> {
    problem.bodies.iter().map(|body| vec![false; body.mesh().topology().facets().len()]).collect()
}

fn refine(problem: &ContactProblem, labels: &[RefinementEdges], marked: &[Vec<bool>]) -> RefinedProblem {
    super::refined(problem, labels, marked).unwrap()
}

#[test]
fn an_edge_marked_in_one_body_is_halved_in_both() {
    let coarse = problem([4, 3]);
    let labels = labels(&coarse);
    for (body, edge) in [(0, 1), (1, 2)] {
        let mut marked = unmarked(&coarse);
        marked[body][coarse.contacts[0].interface.facets()[edge].facets[body]] = true;
        let predicted = super::close(&coarse, &labels, &mut marked.clone());
        let finer = refine(&coarse, &labels, &marked);
        assert_eq!(predicted, [0, 1].map(|b| finer.problem.bodies[b].mesh().points().len()));
        let interface = &finer.problem.contacts[0].interface;
        assert_eq!((interface.pairs().len(), interface.facets().len()), (6, 5));
        assert!((interface.measure() - 2.0).abs() < 1e-15);
        let (new, at) = (&interface.pairs()[edge + 1], interface.arc_lengths()[edge + 1]);
        assert_eq!(finer.pairs[0].parents[edge + 1], [edge as u32, edge as u32 + 1]);
        assert_eq!(at, 0.5 * edge as f64 + 0.25);
        // The gap is measured at the new node; it is not the mean of its neighbours.
        assert_eq!(new.gap, at * at);
        assert_eq!(new.normal, Vector::new(0.0, -1.0));
    }
}

#[test]
fn a_refined_interface_is_the_one_that_pairing_finds() {
    let mut coarse = problem([4, 3]);
    let mut edges = labels(&coarse);
    for round in 0..4 {
        let mut marked = unmarked(&coarse);
        for (b, marks) in marked.iter_mut().enumerate() {
            let mesh = coarse.bodies[b].mesh();
            for (e, mark) in marks.iter_mut().enumerate() {
                let [x, y] = (mesh.points()[mesh.topology().facets()[e][0]]).into();
                *mark = (x - 0.7).hypot(y - 1.0) < 1.0 / f64::from(1 << round);
            }
        }
        let finer = refine(&coarse, &edges, &marked);
        let [upper, lower] = finer.problem.bodies.as_slice() else { unreachable!() };
        let gap = Gap::Given(ScalarData::function(|x| x[0] * x[0]));
        let found = crate::pair(upper, lower, ["bottom", "top"], &gap).unwrap();
        let interface = &finer.problem.contacts[0].interface;
        assert_eq!(interface.facets(), found.facets());
        assert_eq!([0, 1].map(|s| interface.side(s)), [0, 1].map(|s| found.side(s)));
        for (a, b) in interface.pairs().iter().zip(found.pairs()) {
            assert_eq!((a.nodes, a.normal, a.gap), (b.nodes, b.normal, b.gap));
            assert!((a.weight - b.weight).abs() < 1e-15);
        }
        for (a, b) in interface.arc_lengths().iter().zip(found.arc_lengths()) {
            assert!((a - b).abs() < 1e-14);
        }
        let line: Vec<f64> =
            coarse.contacts[0].interface.arc_lengths().iter().map(|s| 3.0 * s - 1.0).collect();
        for (value, s) in finer.pairs[0].prolong(&line).iter().zip(interface.arc_lengths()) {
            assert!((value - (3.0 * s - 1.0)).abs() < 1e-14);
        }
        // The roles stay.
        let turned = coarse.clone().with_roles(Roles::SECOND);
        let turned = super::refined(&turned, &edges, &marked).unwrap().problem;
        assert_eq!(turned.contacts[0].roles, Roles::SECOND);
        assert_eq!(turned.contacts[0].interface.pairs(), interface.pairs());
        edges = finer.refinements.into_iter().map(|r| r.refinement_edges).collect();
        coarse = finer.problem;
    }
    assert!(coarse.contacts[0].interface.pairs().len() > 15);
}

#[test]
fn conditions_stay_on_the_edges_they_were_given_on() {
    // x <= 0.9 selects the first edge of the top, [0, 0.5], only; on the finer mesh it would select [0, 0.75].
    let coarse = problem([4, 3]);
    let edges = labels(&coarse);
    let marked = [0, 1].map(|b| vec![true; coarse.bodies[b].mesh().topology().facets().len()]);
    let finer = refine(&coarse, &edges, &marked).problem;
    let body = &finer.bodies[0];
    let x = |n: &NodeId| body.mesh().points()[*n][0];
    let mut held: Vec<f64> = body.supports()[1].nodes.iter().map(x).collect();
    held.sort_by(f64::total_cmp);
    assert_eq!(held, [0.0, 0.25, 0.5]);
    for node in &body.supports()[1].nodes {
        let expected = x(node) * x(node);
        let constraint = &body.node_constraints()[*node];
        assert!(constraint.supported().contains(Vector::y(), 0.0), "node {node}");
        assert_eq!(constraint.displacement()[1], expected);
    }
    let loaded = |e: &&FacetId| body.facet_condition(**e).unwrap().traction != [Vector::zeros(); 2];
    let top = body.mesh().group("top").unwrap();
    assert_eq!(top.iter().filter(loaded).count(), 4);
    for edge in top.iter().filter(loaded) {
        let nodes = body.mesh().topology().facets()[*edge];
        for (node, t) in nodes.iter().zip(body.facet_condition(*edge).unwrap().traction) {
            assert!((t[1] - x(node)).abs() < 1e-14);
        }
    }
}

#[test]
fn a_gap_that_is_not_finite_between_the_nodes_is_refused() {
    // Zero at every node of the first mesh.
    let at = |x: f64| if (2.0 * std::f64::consts::PI * x).sin().abs() > 1e-9 { f64::NAN } else { 0.0 };
    let gap = ScalarData::function(move |x| at(x[0]));
    let coarse = problem_with([4, 3], gap);
    let marked = [0, 1].map(|b| vec![true; coarse.bodies[b].mesh().topology().facets().len()]);
    let edges = labels(&coarse);
    let error = super::refined(&coarse, &edges, &marked).unwrap_err();
    assert!(matches!(error, RefineError::Interface(InterfaceError::BadGap { .. })), "{error}");
}

/// The gap between two discs above and below the origin, along y.
fn between_discs(radii: [f64; 2], x: f64) -> f64 {
    radii.iter().map(|r| r - (r * r - x * x).sqrt()).sum()
}

#[test]
fn a_measured_gap_follows_the_curves_between_the_nodes_of_the_first_meshes() {
    let material = || LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = |radius: f64, facing, cells| {
        let mesh = half_disc([0.0; 2], radius, facing, 0.2, cells).unwrap();
        Body::new(mesh, material(), &BoundaryConditions::new().fix("flat")).unwrap()
    };
    let radii = [1.0, 1.5];
    // Node by node, and with a common refinement.
    for cells in [[3, 3], [3, 4]] {
        let bodies = [body(radii[0], Facing::Down, cells[0]), body(radii[1], Facing::Up, cells[1])];
        let normal = ContactNormal::Fixed(Vector::new(0.0, -1.0));
        let mut problem = if cells[0] == cells[1] {
            let [a, b] = &bodies;
            let interface = crate::pair_along(a, b, ["contact"; 2], &Gap::Geometric, normal).unwrap();
            ContactProblem::between(bodies, interface)
        } else {
            let common = common_refinement(bodies, ["contact"; 2], normal).unwrap();
            let interface = crate::pair_refined(&common, ["contact"; 2], &Gap::Geometric, normal).unwrap();
            ContactProblem::between(common.bodies, interface)
        };
        let mut noted = problem.interpolated_gaps()[0].unwrap().largest;
        let mut labels = labels(&problem);
        for _ in 0..3 {
            let marked = [0, 1].map(|b| vec![true; problem.bodies[b].mesh().topology().facets().len()]);
            let finer = refine(&problem, &labels, &marked);
            labels = finer.refinements.iter().map(|r| r.refinement_edges.clone()).collect();
            problem = finer.problem;
            let now = problem.interpolated_gaps()[0].unwrap().largest;
            assert!(
                (3.0..5.0).contains(&(noted / now)),
                "{cells:?}: the difference falls from {noted:e} to {now:e}"
            );
            noted = now;
        }
        let mut errors = [0.0f64; 2];
        for pair in problem.contacts[0].interface.pairs() {
            let x = problem.bodies[0].mesh().points()[pair.nodes[0]][0];
            // Straight from one node of the first mesh to the next.
            let edge = 0.2 / cells[0] as f64;
            let [low, high] = [(x / edge).floor() * edge, (x / edge).ceil() * edge];
            let t = if high > low { (x - low) / (high - low) } else { 0.0 };
            let straight = (1.0 - t) * between_discs(radii, low) + t * between_discs(radii, high);
            let exact = between_discs(radii, x);
            errors[0] = errors[0].max((pair.gap - exact).abs());
            errors[1] = errors[1].max((straight - exact).abs());
        }
        assert!(errors[0] < 0.05 * errors[1], "{cells:?}: {errors:?}");
    }
}

use super::*;
use crate::recovery::relax;
use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
use fem_core::field;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::{block, cuboid, ring};
use fem_core::mesh::id::NodeId;
use fem_core::mesh::{TetMesh, TriMesh};
use fem_core::space::{Plane, Solid};

/// Removes the cells whose middle a hole contains; facets of groups that are left keep their names.
fn carved<S: Space>(mesh: &Mesh<S>, hole: impl Fn(S::Vector) -> bool) -> Mesh<S> {
    let middle = |cell: usize| {
        mesh.corners(cell).into_iter().sum::<S::Vector>() * (1.0 / (S::DIM + 1) as f64)
    };
    let kept: Vec<usize> = (0..mesh.cells().len()).filter(|cell| !hole(middle(*cell))).collect();
    let mut numbers = vec![u32::MAX; mesh.points().len()];
    let mut points = Vec::new();
    for node in kept.iter().flat_map(|cell| mesh.cells()[*cell]) {
        if numbers[node] == u32::MAX {
            numbers[node] = points.len() as u32;
            points.push(mesh.points()[node]);
        }
    }
    let cells = kept.iter().map(|cell| S::corners(|k| numbers[mesh.cells()[*cell][k]]));
    let facets = |facets: &Vec<fem_core::mesh::id::FacetId>| -> Vec<S::Axes<u32>> {
        let all = facets.iter().filter(|f| !hole(middle(mesh.topology().facet_cells()[**f][0] as usize)));
        let nodes = all.map(|facet| mesh.topology().facets()[*facet]);
        let all = nodes;
        all.map(|nodes| S::axes(|k| numbers[nodes[k]])).collect()
    };
    let groups = mesh.groups().iter().map(|(name, of)| (name.clone(), facets(of))).collect();
    Mesh::new(points, cells.collect(), groups).unwrap()
}

/// A square frame of `3 n × 3 n` cells with a square hole of `n × n`.
fn frame(n: usize) -> TriMesh {
    let inside = |x: f64| x > 1.0 / 3.0 && x < 2.0 / 3.0;
    carved(&block([0.0, 0.0], [1.0, 1.0], [3 * n; 2]).unwrap(), |x| inside(x[0]) && inside(x[1]))
}

/// A cube of `3 n` cells each way with a square hole along z.
fn tube(n: usize) -> TetMesh {
    let inside = |x: f64| x > 1.0 / 3.0 && x < 2.0 / 3.0;
    carved(&cuboid([0.0; 3], [1.0; 3], [3 * n; 3]).unwrap(), |x| inside(x[0]) && inside(x[1]))
}

fn plane(mesh: TriMesh, conditions: &BoundaryConditions) -> Body {
    Body::new(mesh, LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap(), conditions).unwrap()
}

fn solid(mesh: TetMesh, conditions: &BoundaryConditions<Solid>) -> Body<Solid> {
    Body::new(mesh, LinearElastic::isotropic_solid(1.0, 0.3).unwrap(), conditions).unwrap()
}

fn recovered<S: Recovery>(body: &Body<S>) -> EquilibratedStress<S> {
    let u = factorised(body).unwrap().displacement_from_force(&[]);
    EquilibratedStress::recover(body, field::stresses(body, &u), body.facet_conditions().to_vec())
}

/// The least energy over all facet moments in equilibrium, by dense algebra without stars.
fn best<S: Recovery>(body: &Body<S>, given: &EquilibratedStress<S>) -> f64 {
    let (mesh, topology) = (body.mesh(), body.mesh().topology());
    let of_facet = S::DIM * S::DIM;
    let unknowns = of_facet * topology.facets().len();
    let numbers = given.facet_moments.iter().flat_map(|of| of.as_ref().iter().map(|m| m.largest()));
    let unit = numbers.fold(0.0, f64::max);
    let (mut squares, mut gradient) = (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns));
    let mut conditions = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut require = |row: Vec<(usize, f64)>| {
        for (i, a) in &row {
            row.iter().for_each(|(j, b)| conditions[(*i, *j)] += a * b);
        }
    };
    let mut work = given.clone();
    for cell in 0..mesh.cells().len() {
        let facets = topology.cell_facets()[cell];
        let own: Vec<usize> = facets.into_iter().flat_map(|f| (0..of_facet).map(move |k| of_facet * f.index() + k)).collect();
        let mut energy = |moved: &[(usize, f64)]| {
            let mut add = |sign: f64| {
                for (i, amount) in moved {
                    work.facet_moments[i / of_facet][i % of_facet / S::DIM][i % S::DIM] += sign * amount * unit;
                }
            };
            add(1.0);
            let found = S::cell_distance_squared(body, &work, cell, work.finite_element[cell]);
            work = given.clone();
            found
        };
        let before = energy(&[]);
        let single: Vec<[f64; 2]> = own.iter().map(|i| [1.0, -1.0].map(|sign| energy(&[(*i, sign)]))).collect();
        for (k, i) in own.iter().enumerate() {
            gradient[*i] += 0.25 * (single[k][0] - single[k][1]);
            squares[(*i, *i)] += 0.5 * (single[k][0] + single[k][1]) - before;
            for (l, j) in own[..k].iter().enumerate() {
                let both = energy(&[(*i, 1.0), (*j, 1.0)]);
                let product = 0.5 * (both - single[k][0] - single[l][0] + before);
                squares[(*i, *j)] += product;
                squares[(*j, *i)] += product;
            }
        }
        for component in 0..S::COMPONENTS {
            let part = |i: &usize| {
                let facet = i / of_facet;
                let x = mesh.points()[topology.facets()[facet][i % of_facet / S::DIM]];
                let sign = if topology.facet_cells()[facet][0] as usize == cell { 1.0 } else { -1.0 };
                (*i, sign * S::work(S::AXES[i % S::DIM], x, 1.0)[component])
            };
            require(own.iter().map(part).collect());
        }
    }
    for (facet, condition) in topology.boundary_facets().iter().zip(&given.conditions) {
        for d in condition.reaction.complement().basis() {
            for place in 0..S::DIM {
                let first = of_facet * facet.index() + S::DIM * place;
                require((0..S::DIM).map(|c| (first + c, d[c])).collect());
            }
        }
    }
    let eigen = conditions.symmetric_eigen();
    let free: Vec<usize> = (0..unknowns).filter(|k| eigen.eigenvalues[*k].abs() < 1e-11).collect();
    let basis = eigen.eigenvectors.select_columns(&free);
    let squares = basis.transpose() * squares * &basis;
    let gradient = basis.transpose() * gradient;
    given.distance_squared(body) - gradient.dot(&squares.cholesky().unwrap().solve(&gradient))
}

/// Relaxes by stars alone.
fn by_stars<S: Recovery>(body: &Body<S>, steps: usize) -> EquilibratedStress<S> {
    let mut stress = recovered(body);
    S::relax_with(body, &mut stress, Relaxation::Steps(steps), &mut None, None);
    stress
}

fn relaxed<S: Recovery>(body: &Body<S>, relaxation: Relaxation) -> (EquilibratedStress<S>, RelaxationReport) {
    let mut stress = recovered(body);
    let report = relax(body, &mut stress, relaxation);
    let found = check_stress(body, &stress);
    assert!(found.is_valid(), "{found:?}");
    (stress, report)
}

fn along(f: impl Fn(nalgebra::Vector3<f64>) -> f64 + Send + Sync + 'static) -> ScalarData<Solid> {
    ScalarData::Function(std::sync::Arc::new(f))
}

fn linear() -> ScalarData {
    ScalarData::function(|x| 2.0 + 3.0 * x[0] - x[1])
}

/// Checks the number of columns, that the stress with them is the best of all, and that stars alone reach it only if there is none.
fn is_the_best<S: Recovery>(name: &str, body: &Body<S>, columns: usize) {
    let (stress, report) = relaxed(body, Relaxation::Steps(100));
    assert_eq!(report.columns, columns, "{name}");
    let (found, best) = (stress.distance_squared(body), best(body, &recovered(body)));
    assert!((found / best - 1.0).abs() < 1e-9, "{name}: {found} instead of {best}");
    let stars = by_stars(body, 100).distance_squared(body) / best;
    assert_eq!(stars > 1.001, columns > 0, "{name}: {stars}");
}

/// The last three values: stars alone after many steps over the best of all.
#[test]
fn the_best_stress_of_all_is_reached() {
    let new = BoundaryConditions::new;
    let bar = block([0.0; 2], [1.5, 1.0], [3, 2]).unwrap();
    let heavy = new().fix("left").fix("right").pressure("top", linear()).body_force([0.3, -1.0]);
    let rollers = new().roller("left", 0.0).roller("right", 0.0);
    let both = rollers.clone().displace(FacetSelection::node("bottom", [0.5, 0.0]), None, Some(0.0.into()));
    is_the_best("bar", &plane(bar.clone(), &heavy), 3);
    is_the_best("bar on one support", &plane(bar, &new().fix("left").pressure("top", linear())), 0);
    is_the_best("frame", &plane(frame(1), &new().fix("left").pressure("right", linear())), 3);
    is_the_best("heavy frame", &plane(frame(1), &heavy), 6);
    let _ = both;
    let joined = rollers.fix("bottom").pressure("top", linear());
    is_the_best("frame on joined supports", &plane(frame(1), &joined), 3);
    let new = BoundaryConditions::<Solid>::default;
    let column = |cells| cuboid([0.0; 3], [1.0; 3], cells).unwrap();
    let pressed = |conditions: BoundaryConditions<Solid>| conditions.pressure("left", along(|x| 1.0 + x[2]));
    let mut heavy = pressed(new().fix("bottom").fix("top"));
    heavy.body_force = [0.2, 0.1, -1.0].into();
    is_the_best("column", &solid(column([1, 1, 2]), &heavy), 6);
    let roller = pressed(new().fix("bottom").roller("top", 0.0));
    is_the_best("column under a roller", &solid(column([2, 1, 2]), &roller), 3);
    let inside = |x: f64| x > 1.0 / 3.0 && x < 2.0 / 3.0;
    let ring = || carved(&column([3, 3, 1]), |x| inside(x[0]) && inside(x[1]));
    is_the_best("ring clamped all around its hole", &solid(ring(), &pressed(new().fix("bottom"))), 0);
    let held = new().roller("bottom", 0.0).roller("right", 0.0).roller("front", 0.0);
    is_the_best("ring on rollers", &solid(ring(), &pressed(held)), 3);
}

#[test]
fn counts() {
    let new = BoundaryConditions::<Solid>::default;
    let count = |name: &str, mesh: TetMesh, conditions: BoundaryConditions<Solid>| {
        let body = solid(mesh, &conditions);
        let j = Jumps::new(&body, holes(body.mesh()) > 0);
        println!("{name}: {} {}", j.len(), holes(body.mesh()));
    };
    let cube = || cuboid([0.0; 3], [1.0; 3], [3; 3]).unwrap();
    count("clamped", cube(), new().fix("bottom").fix("top"));
    count("clamp+roller", cube(), new().fix("bottom").roller("top", 0.0));
    count("rollers", cube(), new().roller("left", 0.0).roller("right", 0.0));
    count("3 rollers", cube(), new().roller("left", 0.0).roller("bottom", 0.0).roller("front", 0.0));
    count("6 rollers", cube(), new().roller("left", 0.0).roller("bottom", 0.0).roller("front", 0.0).roller("right", 0.0).roller("top", 0.0).roller("back", 0.0));
    count("clamp beside roller", cube(), new().fix("bottom").roller("left", 0.0));
    count("tube clamped left", tube(1), new().fix("left"));
    count("tube clamped bottom", tube(1), new().fix("bottom"));
    count("tube clamped bottom, top", tube(1), new().fix("bottom").fix("top"));
    count("tube roller bottom", tube(1), new().roller("bottom", 0.0));
    count("tube rollers 3", tube(1), new().roller("left", 0.0).roller("bottom", 0.0).roller("front", 0.0));
    let mid = |x: f64| x > 1.0 / 3.0 && x < 2.0 / 3.0;
    count("void", carved(&cube(), |x| mid(x[0]) && mid(x[1]) && mid(x[2])), new().fix("bottom"));
}

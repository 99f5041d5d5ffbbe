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
        let nodes = facets.iter().map(|facet| mesh.topology().facets()[*facet]);
        let all = nodes.filter(|nodes| nodes.as_ref().iter().all(|n: &NodeId| numbers[*n] != u32::MAX));
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

#[test]
fn experiment() {
    for n in [1, 2, 3] {
        for (name, body) in [
            ("fixed left, pulled", plane(frame(n), &BoundaryConditions::new().fix("left").traction("right", [1.0.into(), 0.0.into()]))),
            ("bottom shear", plane(frame(n), &BoundaryConditions::new().fix("bottom").pressure("top", ScalarData::function(|x| x[0])))),
            ("bar", plane(block([0.0, 0.0], [3.0, 1.0], [3*n, n]).unwrap(), &BoundaryConditions::new().fix("left").fix("right").pressure("top", ScalarData::function(|x| 1.0 + x[0])))),
        ] {
            let eet = recovered(&body);
            let mut stars = eet.clone();
            crate::StarRelaxation::new(&body, body.facet_conditions()).relax(&mut stars, Relaxation::Steps(400));
            let star = stars.distance_squared(&body).sqrt();
            let mut last = eet.clone();
            for _ in 0..5 { relax(&body, &mut last, Relaxation::Steps(100)); }
            let best = last.distance_squared(&body).sqrt();
            let at = |steps: usize| { let mut s = eet.clone(); let r = relax(&body, &mut s, Relaxation::Steps(steps)); (s.distance_squared(&body).sqrt() / best, r.columns, check_stress(&body, &s).is_valid()) };
            println!("{name} {n}: star/best {:.5} steps 2 {:?} 5 {:?} 100 {:?}", star / best, at(2), at(5), at(100));
        }
    }
    let body = solid(cuboid([0.0; 3], [1.0; 3], [3; 3]).unwrap(), &BoundaryConditions::default().fix("bottom").fix("top").pressure("left", ScalarData::Function(std::sync::Arc::new(|x: nalgebra::Vector3<f64>| x[2]))));
    let eet = recovered(&body);
    let mut stars = eet.clone();
    let mut s = None;
    Solid::relax_with(&body, &mut stars, Relaxation::Steps(100), &mut s, None);
    let star = stars.distance_squared(&body).sqrt();
    let mut last = eet.clone();
    let report = relax(&body, &mut last, Relaxation::Steps(100));
    println!("cube star/best {} columns {} valid {}", star / last.distance_squared(&body).sqrt(), report.columns, check_stress(&body, &last).is_valid());
}

//! The certificate of a contact state, with EET alone and with relaxation, and its parts for one body.
#![allow(clippy::unwrap_used, missing_docs)] // The data are fixed and valid; criterion's macros are not documented.

use cre_estimator::{EquilibratedStress, Relaxation, StarRelaxation, estimate, estimate_with};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::field;
use fem_core::interface::{ContactProblem, ContactState, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::prepared::PreparedProblem;

fn certificates(c: &mut Criterion) {
    let mut group = c.benchmark_group("cre-estimator");
    group.sample_size(10);
    for cells in [[18, 9], [80, 36], [320, 160]] {
        let material = || LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = |y: f64, held: &str| {
            let conditions = BoundaryConditions::new().fix(held).body_force([0.1, -1.0]);
            Body::new(block([0.0, y], [2.0, 1.0], cells).unwrap(), material(), &conditions).unwrap()
        };
        let (upper, lower) = (body(1.0, "top"), body(0.0, "bottom"));
        let interface =
            contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(1.0.into())).unwrap();
        let prepared = PreparedProblem::new(ContactProblem::between([upper, lower], interface)).unwrap();
        let (problem, bodies) = (prepared.problem(), prepared.bodies());
        // A wide gap: the bodies are not in contact, which does not change the cost of the estimator.
        let n = prepared.node_pairs();
        let none = vec![0.0; n];
        let u = [0, 1].map(|b| bodies[b].whole().unwrap().displacement_from_force(&none));
        let opening: Vec<f64> = problem.contacts[0]
            .interface
            .pairs()
            .iter()
            .map(|p| {
                let [a, b] = [u[0][p.nodes[0]], u[1][p.nodes[1]]];
                p.gap - (a - b).dot(&p.normal)
            })
            .collect();
        let state = ContactState::between([&u[0], &u[1]], &none, &opening);
        let name = format!("{}x{}", cells[0], cells[1]);
        group.bench_function(BenchmarkId::new("certificate", &name), |b| {
            b.iter(|| estimate(&prepared, &state).unwrap());
        });
        group.bench_function(BenchmarkId::new("certificate, relaxed", &name), |b| {
            b.iter(|| estimate_with(&prepared, &state, Relaxation::default()).unwrap());
        });
        let body = &problem.bodies[1];
        let stress = field::stresses(body, &u[1]);
        group.bench_function(BenchmarkId::new("equilibrated edge tractions", &name), |b| {
            b.iter(|| EquilibratedStress::recover(body, stress.clone(), body.facet_conditions().to_vec()));
        });
        let eet = EquilibratedStress::recover(body, stress.clone(), body.facet_conditions().to_vec());
        group.bench_function(BenchmarkId::new("Johnson-Mercier distances", &name), |b| {
            let triangles = 0..stress.len();
            b.iter(|| triangles.clone().map(|t| eet.cell_distance_squared(body, t, stress[t])).sum::<f64>());
        });
        group.bench_function(BenchmarkId::new("stars prepared", &name), |b| {
            b.iter(|| StarRelaxation::new(body, &eet.conditions));
        });
        let stars = StarRelaxation::new(body, &eet.conditions);
        group.bench_function(BenchmarkId::new("two steps of relaxation", &name), |b| {
            let relax = |mut copy| stars.relax(&mut copy, Relaxation::default());
            b.iter_batched(|| eet.clone(), relax, BatchSize::LargeInput);
        });
    }
    group.finish();
}

criterion_group!(benches, certificates);
criterion_main!(benches);

//! Steps of the set-up of one body: order, assembly, analysis, factorisation, condensation, one solve.
#![allow(clippy::unwrap_used, missing_docs)] // The data are fixed and valid; criterion's macros are not documented.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use fem_core::assembly::System;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::cholesky::{Cholesky, SymbolicCholesky};
use fem_core::condensation::CondensedBody;
use fem_core::dof::DofMap;
use fem_core::geometry::Vector;
use fem_core::interface::{InterfaceSide, Retained};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::id::NodeId;
use std::collections::BTreeSet;
use std::sync::Arc;

fn set_up(c: &mut Criterion) {
    let material = || LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = |y: f64, cells, held: &str| {
        let conditions = BoundaryConditions::new().fix(held);
        Body::new(block([0.0, y], [2.0, 1.0], cells).unwrap(), material(), &conditions).unwrap()
    };
    let mut group = c.benchmark_group("fem-core");
    group.sample_size(10);
    for cells in [[80, 36], [320, 160]] {
        let lower = body(0.0, cells, "bottom");
        let name = format!("{}x{}", cells[0], cells[1]);
        let direction = Vector::new(0.0, -1.0);
        let edges = lower.mesh().group("top").unwrap().iter();
        let nodes: BTreeSet<NodeId> = edges.flat_map(|e| lower.mesh().topology().facets()[*e]).collect();
        let retained = nodes.into_iter().map(|node| Retained { node, direction });
        let side = &InterfaceSide::default().with_block(retained);
        let dofs = DofMap::new(&lower, side);
        let system = System::with_dofs(&lower, dofs.clone()).unwrap();
        let symbolic = Arc::new(SymbolicCholesky::analyse(&system.stiffness, dofs.fronts()).unwrap());
        let points = lower.mesh().points();
        let condensed = CondensedBody::factorise(system.clone(), points).unwrap();
        let trace = vec![0.01; condensed.interface().len()];
        group.bench_function(BenchmarkId::new("order", &name), |b| b.iter(|| DofMap::new(&lower, side)));
        group.bench_function(BenchmarkId::new("assembly", &name), |b| {
            b.iter_batched(|| dofs.clone(), |d| System::with_dofs(&lower, d).unwrap(), BatchSize::LargeInput);
        });
        group.bench_function(BenchmarkId::new("analysis", &name), |b| {
            b.iter(|| SymbolicCholesky::analyse(&system.stiffness, dofs.fronts()).unwrap());
        });
        group.bench_function(BenchmarkId::new("factorisation", &name), |b| {
            b.iter(|| Cholesky::factorise(Arc::clone(&symbolic), &system.stiffness).unwrap());
        });
        group.bench_function(BenchmarkId::new("condensation", &name), |b| {
            b.iter_batched(
                || system.clone(),
                |s| CondensedBody::factorise(s, points).unwrap(),
                BatchSize::LargeInput,
            );
        });
        group.bench_function(BenchmarkId::new("recovery", &name), |b| {
            b.iter(|| condensed.displacement_from_trace(&trace));
        });
    }
    group.finish();
}

criterion_group!(benches, set_up);
criterion_main!(benches);

//! Whole iterations on condensed bodies: the paper's settings and the default ones, and the reference; one
//! separate iteration, for an interface as long as that of 1280x640 cells per body.
#![allow(clippy::unwrap_used, missing_docs)] // The data are fixed and valid; criterion's macros are not documented.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::prepared::PreparedProblem;
use nndd::stopping::{Decision, EtaNndd, Never, StoppingCriterion};
use nndd::{Iterate, NewtonSettings, NnddSettings};
use std::error::Error;
use std::time::{Duration, Instant};

fn problem(cells: [usize; 2]) -> PreparedProblem {
    let material = |e| LinearElastic::isotropic(e, 0.3, Hypothesis::PlaneStrain).unwrap();
    let upper = BoundaryConditions::new()
        .displace("left", Some(0.0.into()), None)
        .displace("top", None, Some((-0.02).into()))
        .traction("right", [0.0.into(), 30.0.into()]);
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], cells).unwrap(), material(2000.0), &upper).unwrap();
    let lower = BoundaryConditions::new().fix("bottom");
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], cells).unwrap(), material(1000.0), &lower).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    PreparedProblem::new(ContactProblem::between([upper, lower], interface)).unwrap()
}

fn iterations(c: &mut Criterion) {
    let mut group = c.benchmark_group("nndd");
    group.sample_size(10);
    for cells in [[18, 9], [80, 36], [320, 160]] {
        let problem = problem(cells);
        let pairs = problem.node_pairs();
        let start = vec![0.0; pairs];
        let mut ten = NnddSettings::paper(0.4);
        ten.max_iterations = 10;
        group.bench_function(BenchmarkId::new("ten iterations, paper", pairs), |b| {
            b.iter(|| nndd::solve(&problem.system(), start.clone(), &ten, &mut Never).unwrap());
        });
        let default = NnddSettings::default();
        group.bench_function(BenchmarkId::new("to 1e-10, default", pairs), |b| {
            b.iter(|| {
                nndd::solve(&problem.system(), start.clone(), &default, &mut EtaNndd::new(1e-10)).unwrap()
            });
        });
        let mut newton = NewtonSettings::default();
        newton.qp = newton.qp.with_method(contact_qp::QpMethod::ActiveSet);
        group.bench_function(BenchmarkId::new("interface Newton", pairs), |b| {
            b.iter(|| nndd::solve(&problem.system(), start.clone(), newton.clone(), &mut Never).unwrap());
        });
    }
    group.finish();
}

/// Iterations timed in one run, after the first, whose contact problem has a cold start.
const TIMED: u32 = 10;

/// Measures the time from the end of the first iteration to the end of the last.
#[derive(Default)]
struct Watch {
    first: Option<Instant>,
    iterations: u32,
    elapsed: Duration,
}

impl StoppingCriterion for Watch {
    fn check(&mut self, _: &Iterate) -> Result<Decision, Box<dyn Error + Send + Sync>> {
        let first = *self.first.get_or_insert_with(Instant::now);
        self.elapsed = first.elapsed();
        let done = self.iterations == TIMED;
        self.iterations += 1;
        Ok(if done { Decision::Stop } else { Decision::Continue })
    }
}

fn one_iteration(c: &mut Criterion) {
    let mut group = c.benchmark_group("nndd");
    group.sample_size(10);
    // Flat cells: the interface decides the time, and the bodies below it are quickly condensed.
    for cells in [[320, 160], [1280, 40]] {
        let problem = problem(cells);
        let pairs = problem.node_pairs();
        let start = vec![0.0; pairs];
        let mut settings = NnddSettings::paper(0.4);
        settings.qp = settings.qp.with_method(contact_qp::QpMethod::ActiveSet);
        group.bench_function(BenchmarkId::new("one iteration", pairs), |b| {
            b.iter_custom(|wanted| {
                let (mut elapsed, mut done) = (Duration::ZERO, 0);
                while done < wanted {
                    let mut watch = Watch::default();
                    nndd::solve(&problem.system(), start.clone(), &settings, &mut watch).unwrap();
                    assert_eq!(watch.iterations, TIMED + 1);
                    elapsed += watch.elapsed;
                    done += u64::from(TIMED);
                }
                elapsed.mul_f64(wanted as f64 / done as f64)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, iterations, one_iteration);
criterion_main!(benches);

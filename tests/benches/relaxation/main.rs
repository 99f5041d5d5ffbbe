//! The certificate of solid boxes beside the factorisation of their stiffness.
//!
//! ```text
//! cargo bench -p tests --bench relaxation -- ROUNDS CELLS… [--threads N]
//! ```
//! with the cells along each axis of a box, by default `16 26 36`. Each line has the nodes of all boxes, what was measured, the microseconds per node (median of the rounds), and
//! their ratio to those of the factorisation in the same run. There are as many boxes as threads: they are factorised at the same time, and all else is done box by box with all
//! threads, as in a solve. A step is a sweep over all edges, one back, and a product with the energy matrix; a relaxation without its steps
//! prepares the edge stars and computes the residual. With one thread, times are on Linux those of the thread on the processor, whatever else runs on the machine.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // The data are fixed and valid; the lines are for a reader.

use cre_estimator::{EquilibratedStress, Relaxation, relax};
use fem_core::assembly::System;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::condensation::CondensedBody;
use fem_core::field;
use fem_core::interface::InterfaceSide;
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::space::Solid;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::time::Instant;

/// Cells along each axis of a box: 5, 20 and 50 thousand nodes.
const BOXES: [usize; 3] = [16, 26, 36];
/// Steps of the two relaxations whose difference is the time of a step.
const STEPS: [usize; 2] = [1, 4];
const NAMES: [&str; 5] = ["factorisation", "face tractions", "without steps", "step", "distance"];

fn main() {
    // Cargo adds `--bench`.
    let (mut numbers, mut threads) = (Vec::new(), 1);
    let mut arguments = std::env::args();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--threads" => threads = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(1),
            number => numbers.extend(number.parse::<usize>().ok()),
        }
    }
    let rounds = numbers.first().copied().unwrap_or(3);
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    println!("nodes,what,microseconds_per_node,over_factorisation");
    let cells = numbers.get(1..).filter(|cells| !cells.is_empty()).unwrap_or(&BOXES);
    for &cells in cells {
        pool.install(|| measure(cells, rounds, threads));
    }
}

/// The nanoseconds that this thread has been on the processor, if the system counts them.
fn on_processor() -> Option<f64> {
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
}

/// Times a function: of one thread on the processor, of several on the wall.
fn seconds<T>(threads: usize, f: impl FnOnce() -> T) -> (f64, T) {
    let (start, before) = (Instant::now(), on_processor().filter(|_| threads == 1));
    let result = f();
    let counted = before.and_then(|before| Some((on_processor()? - before) / 1e9));
    (counted.unwrap_or(start.elapsed().as_secs_f64()), result)
}

fn body(cells: usize) -> Body<Solid> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [cells; 3]).unwrap();
    let conditions =
        BoundaryConditions::default().fix("bottom").traction("top", [0.3.into(), 0.1.into(), (-1.0).into()]);
    Body::new(mesh, LinearElastic::isotropic_solid(1.0, 0.3).unwrap(), &conditions).unwrap()
}

fn measure(cells: usize, rounds: usize, threads: usize) {
    let bodies: Vec<Body<Solid>> = (0..threads).map(|_| body(cells)).collect();
    let nodes: usize = bodies.iter().map(|body| body.mesh().points().len()).sum();
    let mut times = NAMES.map(|_| Vec::new());
    for _ in 0..rounds {
        let systems = bodies.iter().map(|body| System::assemble(body, &InterfaceSide::default()).unwrap());
        let systems: Vec<_> = systems.zip(&bodies).collect();
        let (factorisation, condensed) = seconds(threads, || {
            let factors = systems
                .into_par_iter()
                .map(|(system, body)| CondensedBody::factorise(system, body.mesh().points()).unwrap());
            factors.collect::<Vec<_>>()
        });
        let fields = condensed.iter().zip(&bodies);
        let fields: Vec<_> =
            fields.map(|(c, body)| field::stresses(body, &c.displacement_from_force(&[]))).collect();
        drop(condensed);
        let mut found = [factorisation, 0.0, 0.0, 0.0, 0.0];
        for (body, stress) in bodies.iter().zip(fields) {
            let conditions = body.facet_conditions().to_vec();
            let (tractions, recovered) =
                seconds(threads, || EquilibratedStress::recover(body, stress, conditions));
            let [first, last] = STEPS.map(|steps| {
                let mut stress = recovered.clone();
                seconds(threads, || relax(body, &mut stress, Relaxation::Steps(steps))).0
            });
            let step = (last - first) / (STEPS[1] - STEPS[0]) as f64;
            let distance = seconds(threads, || recovered.distance_squared(body)).0;
            let of_body = [0.0, tractions, first - STEPS[0] as f64 * step, step, distance];
            found.iter_mut().zip(of_body).for_each(|(sum, time)| *sum += time);
        }
        times.iter_mut().zip(found).for_each(|(times, time)| times.push(1e6 * time / nodes as f64));
    }
    let medians = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    for (name, median) in NAMES.iter().zip(medians) {
        println!("{nodes},{name},{median:.1},{:.3}", median / medians[0]);
    }
}

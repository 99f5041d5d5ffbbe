//! The relaxation of the equilibrated stress of solid boxes beside the factorisation of their stiffness, with one thread.
//!
//! ```text
//! cargo bench -p tests --bench relaxation -- ROUNDS CELLS…
//! ```
//! with the cells along each axis of a box, by default `16 26 36`. Each line has the nodes, what was measured, the microseconds per node (median of the rounds), and their ratio to those of the factorisation of the
//! same body in the same run. A step is a sweep over all edges, one back, and a product with the energy matrix; a relaxation without its steps
//! prepares the edge stars and computes the residual. On Linux times are those of the thread on the processor, whatever else runs on the machine.
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
use std::time::Instant;

/// Cells along each axis of a box: 5, 20 and 50 thousand nodes.
const BOXES: [usize; 3] = [16, 26, 36];
/// Steps of the two relaxations whose difference is the time of a step.
const STEPS: [usize; 2] = [1, 4];
const NAMES: [&str; 4] = ["factorisation", "face tractions", "without steps", "step"];

fn main() {
    // Cargo adds `--bench`.
    let numbers: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let rounds = numbers.first().copied().unwrap_or(3);
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    println!("nodes,what,microseconds_per_node,over_factorisation");
    let cells = numbers.get(1..).filter(|cells| !cells.is_empty()).unwrap_or(&BOXES);
    for &cells in cells {
        pool.install(|| measure(cells, rounds));
    }
}

/// The nanoseconds that this thread has been on the processor, if the system counts them.
fn on_processor() -> Option<f64> {
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
}

fn seconds<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let (start, before) = (Instant::now(), on_processor());
    let result = f();
    let counted = on_processor().zip(before).map(|(now, before)| (now - before) / 1e9);
    (counted.unwrap_or(start.elapsed().as_secs_f64()), result)
}

fn measure(cells: usize, rounds: usize) {
    let mesh = cuboid([0.0; 3], [1.0; 3], [cells; 3]).unwrap();
    let conditions =
        BoundaryConditions::default().fix("bottom").traction("top", [0.3.into(), 0.1.into(), (-1.0).into()]);
    let body =
        Body::<Solid>::new(mesh, LinearElastic::isotropic_solid(1.0, 0.3).unwrap(), &conditions).unwrap();
    let nodes = body.mesh().points().len();
    let mut times = NAMES.map(|_| Vec::new());
    for _ in 0..rounds {
        let system = System::assemble(&body, &InterfaceSide::default()).unwrap();
        let (factorisation, condensed) =
            seconds(|| CondensedBody::factorise(system, body.mesh().points()).unwrap());
        let stress = field::stresses(&body, &condensed.displacement_from_force(&[]));
        drop(condensed);
        let (tractions, recovered) =
            seconds(|| EquilibratedStress::recover(&body, stress, body.facet_conditions().to_vec()));
        let [first, last] = STEPS.map(|steps| {
            let mut stress = recovered.clone();
            seconds(|| relax(&body, &mut stress, Relaxation::Steps(steps))).0
        });
        let step = (last - first) / (STEPS[1] - STEPS[0]) as f64;
        let found = [factorisation, tractions, first - STEPS[0] as f64 * step, step];
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

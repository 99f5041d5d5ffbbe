//! The sparse Cholesky of fem-core beside faer's, on the stiffness of the paper's lower body and of boxes of tetrahedra.
//!
//! `cargo xtask bench --factor` runs it and writes the page. It is a plain program, since criterion records times only.
//! Each line has the cells, the number of unknowns, the method, its threads, the seconds of order and analysis, of the
//! factorisation and of one solve, and the number of values the factor stores.
//!
//! ```text
//! cargo bench -p tests --bench factor --features faer/rayon -- ROUNDS
//! ```
//! Without the feature faer has one thread.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // The data are fixed and valid; the lines are for a reader.

mod solid;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use fem_core::assembly::System;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::cholesky::{Cholesky, Front, SymbolicCholesky};
use fem_core::dof::DofMap;
use fem_core::interface::{Gap, InterfaceSide};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::sparse::SymmetricCsc;
use rayon::{ThreadPool, ThreadPoolBuilder};
use solid::Solid;
use std::fmt::Display;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const CELLS: [[usize; 2]; 3] = [[80, 36], [320, 160], [640, 320]];
/// Cells along each axis of a box.
const BOXES: [usize; 3] = [10, 16, 24];
/// Largest residual over the largest entry of the right-hand side.
const TOLERANCE: f64 = 1e-9;

/// One measured factorisation.
struct Measured {
    method: &'static str,
    /// Of order and analysis, of the factorisation, of one solve.
    seconds: [f64; 3],
    /// Values that the factor stores.
    stored: usize,
    solution: Vec<f64>,
}

fn main() {
    // Cargo adds `--bench`.
    let rounds: usize = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(3);
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let pools: Vec<ThreadPool> = if all == 1 { vec![1] } else { vec![1, all] }
        .into_iter()
        .map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap())
        .collect();
    for [a, b] in CELLS {
        let (body, side) = lower_body([a, b]);
        let dofs = DofMap::new(&body, &side);
        let matrix = System::with_dofs(&body, dofs.clone()).unwrap().stiffness;
        let mut order: Vec<usize> = (0..matrix.dimension()).collect();
        order.sort_by_key(|&number| dofs.unknown(number));
        let natural = permuted(&matrix, &places(&order));
        let fronts = || DofMap::new(&body, &side).fronts().to_vec();
        compare(format_args!("{a}x{b}"), [&matrix, &natural], &fronts, &pools, rounds);
    }
    for cells in BOXES {
        let solid = Solid { cells };
        let natural = solid.stiffness();
        let matrix = permuted(&natural, &places(&solid.dissection().0));
        let fronts = || solid.dissection().1;
        compare(format_args!("{cells}x{cells}x{cells}"), [&matrix, &natural], &fronts, &pools, rounds);
    }
}

/// Prints the rounds of one matrix.
///
/// * `[matrix, natural]`: it in the order of elimination, and as another program would have it.
/// * `fronts`: computes that order's tree.
fn compare(
    cells: impl Display,
    [matrix, natural]: [&SymmetricCsc; 2],
    fronts: &(dyn Fn() -> Vec<Front> + Sync),
    pools: &[ThreadPool],
    rounds: usize,
) {
    let mut of_faer = vec![Par::Seq];
    of_faer.extend(Some(faer::get_global_parallelism()).filter(|par| par.degree() > 1));
    // The first round warms up and is not printed.
    for round in 0..=rounds {
        let print = |threads: usize, matrix: &SymmetricCsc, m: &Measured| {
            check(matrix, &m.solution);
            if round > 0 {
                let (n, [symbolic, numeric, solve]) = (matrix.dimension(), m.seconds);
                println!("{cells},{n},{},{threads},{symbolic},{numeric},{solve},{}", m.method, m.stored);
            }
        };
        for pool in pools {
            let measured = pool.install(|| multifrontal(fronts, matrix));
            print(pool.current_num_threads(), matrix, &measured);
        }
        for &par in &of_faer {
            print(par.degree(), natural, &of_library(natural, par));
        }
    }
}

/// The lower body of the paper's problem, with its side of the contact line.
fn lower_body(cells: [usize; 2]) -> (Body, InterfaceSide) {
    let body = |y: f64, young: f64, held: &str| {
        let material = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([0.0, y], [2.0, 1.0], cells).unwrap();
        Body::new(mesh, material, &BoundaryConditions::new().fix(held)).unwrap()
    };
    let (upper, lower) = (body(1.0, 2000.0, "top"), body(0.0, 1000.0, "bottom"));
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    let side = interface.side(1);
    (lower, side)
}

/// The place of each unknown in an order.
fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        places[old] = new;
    }
    places
}

/// The same matrix with the unknowns in other places.
fn permuted(matrix: &SymmetricCsc, place: &[usize]) -> SymmetricCsc {
    let n = matrix.dimension();
    let mut columns = vec![vec![]; n];
    for j in 0..n {
        for (i, value) in matrix.column(j) {
            let (a, b) = (place[i], place[j]);
            columns[a.min(b)].push((a.max(b) as u32, value));
        }
    }
    let mut moved = SymmetricCsc { starts: vec![0], rows: vec![], values: vec![] };
    for mut column in columns {
        column.sort_by_key(|entry| entry.0);
        moved.rows.extend(column.iter().map(|entry| entry.0));
        moved.values.extend(column.iter().map(|entry| entry.1));
        moved.starts.push(moved.rows.len() as u32);
    }
    moved
}

fn right_hand_side(n: usize) -> Vec<f64> {
    (0..n).map(|i| (i as f64).sin()).collect()
}

/// Stops the program if the factor does not solve the system.
fn check(matrix: &SymmetricCsc, solution: &[f64]) {
    let product = matrix.multiply(solution);
    let b = right_hand_side(solution.len());
    let worst = product.iter().zip(&b).map(|(p, b)| (p - b).abs()).fold(0.0, f64::max);
    assert!(worst <= TOLERANCE, "residual {worst:e}");
}

/// The factor of fem-core: nested dissection of the mesh, then the multifrontal method.
fn multifrontal(fronts: &dyn Fn() -> Vec<Front>, matrix: &SymmetricCsc) -> Measured {
    let start = Instant::now();
    let symbolic = Arc::new(SymbolicCholesky::analyse(matrix, &fronts()).unwrap());
    let analysed = start.elapsed();
    let factor = Cholesky::factorise(symbolic, matrix).unwrap();
    let factorised = start.elapsed();
    let mut solution = right_hand_side(matrix.dimension());
    let before = Instant::now();
    factor.solve(black_box(&mut solution));
    let solve = before.elapsed();
    let seconds = [analysed, factorised - analysed, solve].map(|t| t.as_secs_f64());
    Measured { method: "this project", seconds, stored: factor.stored_values(), solution }
}

/// faer's factor: approximate minimum degree, then single columns or supernodes, as faer chooses.
fn of_library(matrix: &SymmetricCsc, par: Par) -> Measured {
    let n = matrix.dimension();
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &matrix.starts, None, &matrix.rows);
    let start = Instant::now();
    let order = SymmetricOrdering::Amd;
    let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, order, Default::default()).unwrap();
    let analysed = start.elapsed();
    let mut values = vec![0.0; symbolic.len_val()];
    let mut memory = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default()));
    symbolic
        .factorize_numeric_llt(
            &mut values,
            SparseColMatRef::new(pattern, &matrix.values),
            Side::Lower,
            Default::default(),
            par,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .unwrap();
    let factorised = start.elapsed();
    let mut solution = right_hand_side(n);
    let before = Instant::now();
    let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(1, par));
    LltRef::new(&symbolic, &values).solve_in_place_with_conj(
        Conj::No,
        MatMut::from_column_major_slice_mut(black_box(&mut solution), n, 1),
        par,
        MemStack::new(&mut memory),
    );
    let solve = before.elapsed();
    let seconds = [analysed, factorised - analysed, solve].map(|t| t.as_secs_f64());
    let method = match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(_) => "faer simplicial",
        SymbolicCholeskyRaw::Supernodal(_) => "faer supernodal",
    };
    Measured { method, seconds, stored: values.len(), solution }
}

//! Adaptive runs: the target is met, every certificate holds, the rate is the best there is, limits are kept.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Criterion, IterationRecord, Observer,
    Settings, Silent, Step, solve, solve_adaptively,
};
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::energy_norm_squared;
use tests::blocks::Blocks;
use tests::{heavy, paper, shapes};

/// Keeps what every mesh of a run said.
#[derive(Default)]
struct Record {
    potential_energy: Vec<[f64; 2]>,
    energy_norm: Vec<[f64; 2]>,
    contact_force: Vec<[f64; 2]>,
    valid: Vec<bool>,
    split: Vec<f64>,
    clarabel_calls: Vec<usize>,
    /// Ask to stop after this many iterations in all.
    patience: Option<usize>,
    /// Memory for this many nodes.
    room: Option<usize>,
    iterations: usize,
}

impl Observer for Record {
    fn iteration(&mut self, _row: &IterationRecord) {
        self.iterations += 1;
    }

    fn step(&mut self, step: &Step, solution: &CertifiedSolution) {
        assert_eq!(step.certified, solution.is_certified());
        let bounds = solution.bounds.unwrap();
        self.potential_energy.push(bounds.potential_energy);
        self.energy_norm.push(bounds.energy_norm);
        self.contact_force.push(bounds.contact_force.unwrap());
        let estimate = solution.estimate.as_ref().unwrap();
        self.valid.push(estimate.admissibility.is_valid());
        self.split.push(estimate.cre.split_defect());
        self.clarabel_calls.push(solution.nndd.clarabel_calls);
        let [a, b] = [0, 1].map(|b| solution.problem.bodies[b].mesh().points().len());
        assert_eq!(step.nodes, a + b);
    }

    fn should_stop(&mut self) -> bool {
        self.patience.is_some_and(|p| self.iterations >= p)
    }

    fn fits_in_memory(&mut self, problem: &ContactProblem) -> bool {
        let nodes: usize = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
        self.room.is_none_or(|room| nodes <= room)
    }
}

fn run(problem: ContactProblem, adapt: &AdaptSettings, record: &mut Record) -> AdaptiveSolution {
    solve_adaptively(problem, &Settings::default(), adapt, record).unwrap()
}

fn coarse_paper() -> ContactProblem {
    paper::problem(paper::COARSE).unwrap()
}

/// The observed rate `r` of `e ~ N^(-r)` from the first to the last step.
fn rate(steps: &[Step]) -> f64 {
    let (a, b) = (steps.first().unwrap(), steps.last().unwrap());
    (a.relative.unwrap() / b.relative.unwrap()).ln() / (b.nodes as f64 / a.nodes as f64).ln()
}

#[test]
fn the_papers_problem_is_certified_to_five_per_cent() {
    let mut record = Record::default();
    let answer = run(coarse_paper(), &AdaptSettings::new(0.05), &mut record);
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(answer.solution.relative().unwrap() <= 0.05 && answer.solution.is_certified());
    assert_eq!(answer.step, answer.history.len());
    // Uniform meshes need more than 5000 nodes for that.
    let last = answer.history.last().unwrap();
    assert!(answer.history.len() > 2 && last.nodes < 3000, "{:?}", answer.history);
    assert!(record.valid.iter().all(|v| *v));
    assert!(record.split.iter().all(|d| *d < 1e-12), "{:?}", record.split);
    // Active sets find the first one, and each mesh hands its own on.
    assert!(record.clarabel_calls.iter().all(|c| *c == 0), "{:?}", record.clarabel_calls);
    // Every mesh grows, and none is marked after the last.
    assert!(answer.history.windows(2).all(|w| w[1].nodes > w[0].nodes));
}

#[test]
fn every_bound_of_every_mesh_holds_for_a_much_finer_solution() {
    // J(u) ≤ J(u_p) on every mesh, and ≥ J(u_p) − e²/2: the intervals of all meshes have the exact value in common.
    // Data of these problems are represented exactly.
    let problems = [coarse_paper(), Blocks::half_open(1.0).cells(16).problem().unwrap()];
    for problem in problems {
        let mut record = Record::default();
        let answer = run(problem, &AdaptSettings::new(0.03), &mut record);
        assert!(answer.history.len() > 3);
        let common = |intervals: &[[f64; 2]]| {
            let low = intervals.iter().map(|i| i[0]).fold(f64::NEG_INFINITY, f64::max);
            let high = intervals.iter().map(|i| i[1]).fold(f64::INFINITY, f64::min);
            assert!(low <= high, "{intervals:?}");
            // The last mesh is the sharpest.
            let widths: Vec<f64> = intervals.iter().map(|i| i[1] - i[0]).collect();
            assert!(widths.last() < widths.first(), "{widths:?}");
            [low, high]
        };
        let energy = common(&record.potential_energy);
        common(&record.energy_norm);
        common(&record.contact_force);
        // The error of a mesh, from below: ½‖u − u_p‖² ≤ J(u_p) − J(u) for every admissible pair, and J(u) is at least
        // the best lower bound; from above, J(u) ≤ the best upper one. The bound is at least the part of the distance
        // that is certain.
        for (step, potential) in answer.history.iter().zip(&record.potential_energy) {
            let certain = (2.0 * (potential[1] - energy[1])).max(0.0).sqrt();
            assert!(step.e_cre.unwrap() >= certain, "step {}: {certain}", step.step);
        }
    }
}

#[test]
fn the_bound_of_every_mesh_is_at_least_the_distance_to_a_nested_finer_solution() {
    // The finer solution is on the last mesh, which contains the first one. By Galerkin orthogonality in the bodies
    // the distance of energies is not the error in contact; the distance of the fields is, up to the finer mesh's own
    // error: ‖u − u_1‖ ≥ ‖u_2 − u_1‖ − ‖u − u_2‖ ≥ ‖u_2 − u_1‖ − e_2.
    let first = solve(coarse_paper(), &Settings::default(), &mut Silent).unwrap();
    let mut problem = first.problem.clone();
    let coarse = first.estimate.as_ref().unwrap();
    let mut fields: Vec<_> = coarse.pair.bodies.iter().map(|b| b.displacement.clone()).collect();
    for _ in 0..3 {
        let finer = tests::finer::halve(&problem).unwrap();
        fields = finer.refinements.iter().zip(&fields).map(|(r, u)| r.prolong(u)).collect();
        problem = finer.problem;
    }
    // Carried over exactly: the same energy on the finer mesh.
    for b in 0..2 {
        let energy = energy_norm_squared(&problem.bodies[b], &fields[b]);
        assert!((energy - coarse.energy_norm_squared[b]).abs() < 1e-11 * energy);
    }
    let second = solve(problem, &Settings::default(), &mut Silent).unwrap();
    let fine = second.estimate.as_ref().unwrap();
    let mut squared = 0.0;
    for b in 0..2 {
        let distance = fem_core::norm::energy_distance_squared(
            &second.problem.bodies[b],
            &fine.pair.bodies[b].displacement,
            &fields[b],
        );
        squared += distance;
    }
    let distance = squared.sqrt();
    assert!(distance > 2.0 * fine.unchecked().e_cre, "{distance} against {}", fine.unchecked().e_cre);
    assert!(coarse.unchecked().e_cre >= distance - fine.unchecked().e_cre);
    assert!(
        coarse.unchecked().e_cre <= 1.5 * (distance + fine.unchecked().e_cre),
        "{} against {distance}",
        coarse.unchecked().e_cre
    );
}

#[test]
fn a_singular_problem_has_the_best_rate_adaptively_and_half_of_it_uniformly() {
    // At the end of the pressed part of the top the stress is of the order r^(-1/2): uniform meshes converge with
    // N^(-1/4), meshes refined by the local errors with N^(-1/2), the best rate of linear triangles.
    let uniform: Vec<Step> = [16, 32, 64]
        .into_iter()
        .map(|cells| {
            let mut adapt = AdaptSettings::new(0.5);
            adapt.max_steps = 1;
            let problem = Blocks::half_open(1.0).cells(cells).problem().unwrap();
            run(problem, &adapt, &mut Record::default()).history[0]
        })
        .collect();
    let problem = Blocks::half_open(1.0).cells(16).problem().unwrap();
    let adaptive = run(problem, &AdaptSettings::new(0.03), &mut Record::default()).history;
    // The first steps cut the singularity out; from then on it is the rate.
    let late: Vec<Step> = adaptive.iter().copied().filter(|s| s.nodes > 1500).collect();
    assert!(late.len() >= 3, "{adaptive:?}");
    let (slow, fast) = (rate(&uniform), rate(&late));
    assert!((0.18..0.36).contains(&slow), "uniform rate {slow}");
    assert!((0.45..0.8).contains(&fast), "adaptive rate {fast}");
    // With fewer nodes, a fraction of the error.
    assert!(adaptive.last().unwrap().relative.unwrap() < 0.3 * uniform.last().unwrap().relative.unwrap());
}

#[test]
fn a_limit_of_nodes_is_kept_and_leaves_the_best_certificate() {
    let mut adapt = AdaptSettings::new(0.001);
    adapt.max_nodes = 2500;
    let answer = run(coarse_paper(), &adapt, &mut Record::default());
    assert!(matches!(answer.end, AdaptiveEnd::MaxNodes), "{:?}", answer.end);
    let nodes: Vec<usize> = answer.history.iter().map(|s| s.nodes).collect();
    assert!(*nodes.last().unwrap() <= 2500 && *nodes.last().unwrap() > 2300, "{nodes:?}");
    assert!(answer.solution.is_certified() && answer.solution.relative().unwrap() < 0.04);
    // The first mesh is solved whatever its size.
    adapt.max_nodes = 10;
    let answer = run(coarse_paper(), &adapt, &mut Record::default());
    assert!(matches!(answer.end, AdaptiveEnd::MaxNodes) && answer.history.len() == 1);
    assert!(answer.solution.is_certified());
}

#[test]
fn other_limits_end_a_run_with_its_certificate() {
    let mut adapt = AdaptSettings::new(0.001);
    adapt.max_steps = 2;
    let answer = run(coarse_paper(), &adapt, &mut Record::default());
    assert!(matches!(answer.end, AdaptiveEnd::MaxSteps) && answer.history.len() == 2);
    adapt.max_steps = 30;
    let mut record = Record { room: Some(1200), ..Record::default() };
    let answer = run(coarse_paper(), &adapt, &mut record);
    assert!(matches!(answer.end, AdaptiveEnd::OutOfMemory { nodes } if nodes > 1200), "{:?}", answer.end);
    assert!(answer.solution.is_certified() && answer.history.last().unwrap().nodes <= 1200);
    // Interrupted in the first iteration of a later mesh: whatever is better stays.
    let mut record = Record::default();
    let whole = run(coarse_paper(), &AdaptSettings::new(0.05), &mut record);
    let on_two: usize = whole.history[..2].iter().map(|s| s.iterations).sum();
    let mut record = Record { patience: Some(on_two + 1), ..Record::default() };
    let answer = run(coarse_paper(), &AdaptSettings::new(0.001), &mut record);
    assert!(matches!(answer.end, AdaptiveEnd::Interrupted), "{:?}", answer.end);
    assert!(answer.solution.is_certified());
    let best = answer.history.iter().filter_map(|s| s.relative).fold(f64::INFINITY, f64::min);
    assert_eq!(answer.solution.relative(), Some(best));
    assert_eq!(answer.history[answer.step - 1].relative, Some(best));
}

#[test]
fn a_target_below_round_off_is_recognised() {
    // Constant stresses: the mesh is exact, and what is left is the allowance for round-off.
    let materials = [(2000.0, 0.3), (1000.0, 0.2)];
    let problem = tests::patch::problem(materials, Hypothesis::PlaneStrain, 0.0).unwrap();
    let answer = run(problem, &AdaptSettings::new(1e-17), &mut Record::default());
    let AdaptiveEnd::RoundOff { floor } = answer.end else { panic!("{:?}", answer.end) };
    assert!(floor > 1e-17 && floor < 1e-10, "{floor:e}");
    assert_eq!(answer.history.len(), 1);
}

#[test]
fn an_error_of_the_iteration_is_not_refined() {
    // One iteration from λ = 0: nearly all of the bound is the iteration's.
    let mut settings = Settings::default();
    settings.criterion = Criterion::Iterations;
    settings.method = settings.method.with_max_iterations(1);
    let answer = solve_adaptively(coarse_paper(), &settings, &AdaptSettings::new(0.05), &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::IterationError), "{:?}", answer.end);
    assert_eq!(answer.history.len(), 1);
    // Enough of them do.
    settings.method = settings.method.with_max_iterations(8);
    let answer = solve_adaptively(coarse_paper(), &settings, &AdaptSettings::new(0.05), &mut Silent).unwrap();
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert!(answer.history.iter().all(|s| s.iterations == 8));
}

#[test]
fn nothing_to_do_is_done_at_once() {
    let problem = paper::problem_with(paper::COARSE, paper::YOUNG, 0.0, 0.0, 0.0).unwrap();
    let answer = run(problem, &AdaptSettings::new(0.02), &mut Record::default());
    assert!(matches!(answer.end, AdaptiveEnd::TargetMet), "{:?}", answer.end);
    assert_eq!((answer.history.len(), answer.history[0].e_cre), (1, Some(0.0)));
}

#[test]
fn a_run_is_the_same_on_1_and_2_threads() {
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let answer = pool.install(|| {
            run(heavy::problem(0.3, 6).unwrap(), &AdaptSettings::new(0.04), &mut Record::default())
        });
        assert!(answer.history.len() > 2);
        answer
    });
    assert_eq!(one.history, two.history);
    let bits = |a: &AdaptiveSolution| -> Vec<u64> {
        let estimate = a.solution.estimate.as_ref().unwrap();
        let fields = estimate.pair.bodies.iter().flat_map(|b| b.displacement.iter().flatten());
        fields
            .chain(&a.solution.last().lambda)
            .chain(estimate.cre.by_cell.iter().flatten())
            .map(|x| x.to_bits())
            .collect()
    };
    assert_eq!(bits(&one), bits(&two));
}

#[test]
fn a_run_that_is_stopped_on_its_last_mesh_says_so_whatever_it_has_certified() {
    let whole = |patience| {
        let mut record = Record { patience, ..Record::default() };
        (run(coarse_paper(), &AdaptSettings::new(0.05), &mut record), record.iterations)
    };
    let (answer, iterations) = whole(None);
    let last = answer.history.last().unwrap();
    assert!(last.iterations > 1);
    // After the first iteration on the last mesh, whose bound meets the target already.
    let (stopped, _) = whole(Some(iterations - last.iterations + 1));
    assert!(matches!(stopped.end, AdaptiveEnd::Interrupted), "{:?}", stopped.end);
    assert_eq!(stopped.history.len(), answer.history.len());
    assert!(stopped.solution.is_certified());
}

/// Two blocks under a contact line inclined by `slope`, whose end at `x = 0` is held in x.
fn held_obliquely(slope: f64, cells: usize) -> ContactProblem {
    let body = |y: f64, young: f64, sides: BoundaryConditions| {
        let sheared = |x: Vector| Vector::new(x[0], x[1] + slope * x[0]);
        let mesh = shapes::moved(&block([0.0, y], [2.0, 1.0], [2 * cells, cells]).unwrap(), sheared).unwrap();
        let material = LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, material, &sides.displace("left", Some(0.0.into()), None)).unwrap()
    };
    let upper = BoundaryConditions::new().displace("top", None, Some((-0.02).into()));
    let upper = body(0.0, 2000.0, upper);
    let lower = body(-1.0, 1000.0, BoundaryConditions::new().fix("bottom"));
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    ContactProblem::between([upper, lower], interface)
}

#[test]
fn every_first_mesh_leads_to_the_same_energy_where_a_support_is_oblique_to_the_contact_line() {
    for slope in [0.4, -0.4] {
        let mut all: Vec<[f64; 2]> = Vec::new();
        for (cells, target) in [(2, 0.04), (3, 0.04), (8, 1.0), (24, 1.0)] {
            let mut record = Record::default();
            run(held_obliquely(slope, cells), &AdaptSettings::new(target), &mut record);
            assert!(record.valid.iter().all(|v| *v), "{slope} {cells}");
            all.extend(record.potential_energy);
        }
        let low = all.iter().map(|i| i[0]).fold(f64::NEG_INFINITY, f64::max);
        let high = all.iter().map(|i| i[1]).fold(f64::INFINITY, f64::min);
        assert!(low <= high, "{slope}: {all:?}");
        assert!(high - low < 2e-3 * high.abs(), "{slope}: {all:?} is too wide");
    }
}

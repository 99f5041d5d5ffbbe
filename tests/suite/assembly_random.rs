//! Random assemblies: which are held, and the exact solution against Clarabel.

use certified_contact::support;
use contact_qp::{QpMethod, QpSettings};
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::mesh::id::NodeId;
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::BodyMotion;
use nndd::{NnddError, solve_exactly};
use tests::distance::{Outcome, outcome};
use tests::random::Random;
use tests::rollers::Roller;
use tests::{prepare, random_assemblies};

/// The forces on the top block of a pile.
#[derive(Clone, Copy)]
struct Load {
    /// The place of the resultant along the width of 2, and its size downwards.
    at: f64,
    down: f64,
    /// On the left side of a floating block.
    sideways: f64,
}

/// Two to five blocks of 2 × 1 on top of each other, the lowest one clamped, all others held by contact only.
fn pile(random: &mut Random, load: Load) -> ContactProblem {
    let count = 2 + (4.0 * random.unit()) as usize;
    let body = |k: usize, random: &mut Random| {
        let young = 10f64.powf(1.0 + 2.5 * random.unit());
        let material =
            LinearElastic::isotropic(young, 0.45 * random.unit(), Hypothesis::PlaneStrain).unwrap();
        let mut conditions = BoundaryConditions::new();
        if k == 0 {
            conditions = conditions.fix("bottom");
        }
        if k == count - 1 {
            // A linear pressure with this resultant: on the width of 2 its moment about the middle is 2/3 of its slope.
            let (mean, slope) = (0.5 * load.down, 1.5 * load.down * (load.at - 1.0));
            let pressure = ScalarData::function(move |x| -(mean + slope * (x[0] - 1.0)));
            conditions = conditions.traction("top", [0.0.into(), pressure]);
        }
        if k == 1 && load.sideways != 0.0 {
            conditions = conditions.traction("left", [load.sideways.into(), 0.0.into()]);
        }
        Body::new(block([0.0, k as f64], [2.0, 1.0], [6, 3]).unwrap(), material, &conditions).unwrap()
    };
    let bodies: Vec<Body> = (0..count).map(|k| body(k, random)).collect();
    let gap = Gap::Given(0.0.into());
    let interfaces: Vec<ContactInterface> = (1..count)
        .map(|k| contact_geometry::pair(&bodies[k], &bodies[k - 1], ["bottom", "top"], &gap).unwrap())
        .collect();
    let problem = ContactProblem::new(bodies);
    interfaces.into_iter().enumerate().fold(problem, |all, (k, interface)| all.contact([k + 1, k], interface))
}

/// A load that the contacts can carry.
fn carried(random: &mut Random) -> Load {
    Load { at: 0.02 + 1.96 * random.unit(), down: 0.1 + 10.0 * random.unit(), sideways: 0.0 }
}

#[test]
fn two_hundred_assemblies_that_contact_holds_are_accepted() {
    let mut random = Random::new(15);
    for k in 0..200 {
        let load = carried(&mut random);
        let found = support(&pile(&mut random, load)).unwrap();
        assert!(found.unresisted.is_none(), "{k}, at {}: {:?}", load.at, found.unresisted);
        // Each floating block can slide.
        assert!(!found.free_motions.is_empty());
    }
}

#[test]
fn two_hundred_assemblies_that_nothing_holds_are_refused() {
    let mut random = Random::new(16);
    for k in 0..200 {
        let mut load = carried(&mut random);
        match k % 3 {
            // Beside the block, pulled, or pushed to the side.
            0 => load.at = if random.unit() < 0.5 { -0.02 - random.unit() } else { 2.02 + random.unit() },
            1 => load.down = -load.down,
            _ => load.sideways = 0.01 + random.unit(),
        }
        let problem = pile(&mut random, load);
        let motion = support(&problem).unwrap().unresisted;
        let motion = motion.unwrap_or_else(|| panic!("{k}: at {}, {} down", load.at, load.down));
        assert!(motion.load > 0.0 && !motion.bodies.is_empty());
        let largest =
            motion.bodies.iter().flat_map(|(of, motion)| problem.moved_by(&BodyMotion::new(*of, *motion)));
        let largest = largest.map(|u| u.norm()).fold(0.0, f64::max);
        assert!((largest - 1.0).abs() < 1e-9, "{k}: {largest}");
        if k < 30 {
            let refused = solve_exactly(&prepare(&problem).system(), &QpSettings::default());
            assert!(matches!(refused, Err(NnddError::NotHeld { .. })));
        }
    }
}

/// Everything of a pile in one system, without condensation: `K u + Bᵀ P = f`, assembled here.
struct Full {
    /// Entries of `K`, and of a row that keeps one node of each floating block from sliding, which no load drives.
    entries: Vec<Triplet<usize, usize, f64>>,
    /// `f`, then zeros for the rows of the gauge.
    load: Vec<f64>,
    /// The two unknowns of each row of `B`, along y: of the upper block and of the lower one; `None`: clamped.
    rows: Vec<[Option<usize>; 2]>,
}

impl Full {
    fn new(problem: &ContactProblem, load: Load) -> Self {
        let mut number: Vec<Vec<Option<usize>>> = Vec::new();
        let mut count = 0;
        for (k, body) in problem.bodies.iter().enumerate() {
            let clamped = |x: &Vector| k == 0 && x[1] == 0.0;
            let mut next = |x: &Vector| {
                if clamped(x) {
                    return None;
                }
                count += 2;
                Some(count - 2)
            };
            number.push(body.mesh().points().iter().map(&mut next).collect());
        }
        let mut entries = Vec::new();
        for (body, number) in problem.bodies.iter().zip(&number) {
            for (t, nodes) in body.mesh().cells().iter().enumerate() {
                let x = nodes.map(|n| body.mesh().points()[n]);
                let twice = (x[1] - x[0])[0] * (x[2] - x[0])[1] - (x[1] - x[0])[1] * (x[2] - x[0])[0];
                // Strains (xx, yy, 2xy) of the unknown `c` at corner `i`.
                let strain = |i: usize, c: usize| {
                    let across = x[(i + 2) % 3] - x[(i + 1) % 3];
                    let [dx, dy] = [-across[1] / twice, across[0] / twice];
                    if c == 0 { [dx, 0.0, dy] } else { [0.0, dy, dx] }
                };
                let stiffness = body.material(t).stiffness();
                for (i, c) in (0..3).flat_map(|i| [(i, 0), (i, 1)]) {
                    for (j, d) in (0..3).flat_map(|j| [(j, 0), (j, 1)]) {
                        let (Some(row), Some(column)) = (number[nodes[i].index()], number[nodes[j].index()])
                        else {
                            continue;
                        };
                        let (a, b) = (strain(i, c), strain(j, d));
                        let work: f64 = (0..3)
                            .flat_map(|m| (0..3).map(move |n| (m, n)))
                            .map(|(m, n)| a[m] * stiffness[(m, n)] * b[n])
                            .sum();
                        entries.push(Triplet::new(row + c, column + d, 0.5 * twice * work));
                    }
                }
            }
        }
        let mut forces = vec![0.0; count];
        let last = problem.bodies.len() - 1;
        let (mean, slope) = (0.5 * load.down, 1.5 * load.down * (load.at - 1.0));
        let top: Vec<(usize, f64)> = problem.bodies[last]
            .mesh()
            .points()
            .iter()
            .enumerate()
            .filter(|(_, x)| x[1] == last as f64 + 1.0)
            .filter_map(|(n, x)| Some((number[last][n]?, x[0])))
            .collect();
        for (n, x) in &top {
            for (_, y) in top.iter().filter(|(_, y)| (x - y).abs() > 0.1 && (x - y).abs() < 0.4) {
                // ∫ φ_n q over the edge, q linear.
                let pressure = |x: f64| mean + slope * (x - 1.0);
                forces[n + 1] -= (x - y).abs() / 6.0 * (2.0 * pressure(*x) + pressure(*y));
            }
        }
        for number in &number[1..] {
            let first = number.iter().flatten().next().copied().unwrap_or_default();
            let gauge = forces.len();
            entries.push(Triplet::new(gauge, first, 1.0));
            entries.push(Triplet::new(first, gauge, 1.0));
            forces.push(0.0);
        }
        let rows = problem.contacts.iter().flat_map(|contact| {
            let of = |side: usize, node: NodeId| {
                number[contact.partners()[side].place(number.len())][node.index()].map(|n| n + 1)
            };
            contact
                .interface
                .pairs()
                .iter()
                .map(move |pair| [0, 1].map(|side: usize| of(side, pair.nodes[side])))
        });
        let rows = rows.collect();
        Self { entries, load: forces, rows }
    }

    /// Solves with the pairs of a set closed; returns the contact forces and the openings.
    fn solve(&self, closed: &[bool]) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut entries = self.entries.clone();
        let mut right = self.load.clone();
        let mut place = vec![None; closed.len()];
        for (row, unknowns) in self.rows.iter().enumerate().filter(|(row, _)| closed[*row]) {
            // The normal points down, out of the upper block.
            for (unknown, value) in unknowns.iter().zip([-1.0, 1.0]) {
                if let Some(unknown) = *unknown {
                    entries.push(Triplet::new(unknown, right.len(), value));
                    entries.push(Triplet::new(right.len(), unknown, value));
                }
            }
            place[row] = Some(right.len());
            right.push(0.0);
        }
        let n = right.len();
        let matrix = SparseColMat::try_new_from_triplets(n, n, &entries).ok()?;
        let factor = matrix.sp_lu().ok()?;
        let mut x = vec![0.0; n];
        for _ in 0..3 {
            let mut residual = right.clone();
            entries.iter().for_each(|e| residual[e.row] -= e.val * x[e.col]);
            let step = factor.solve(faer::ColRef::from_slice(&residual));
            x.iter_mut().zip(step.iter()).for_each(|(x, s)| *x += s);
        }
        let forces = place.iter().map(|place| place.map_or(0.0, |k: usize| x[k])).collect();
        let at = |unknown: Option<usize>| unknown.map_or(0.0, |k| x[k]);
        let opening = self.rows.iter().map(|[upper, lower]| at(*upper) - at(*lower)).collect();
        x.iter().all(|x| x.is_finite()).then_some((forces, opening))
    }

    /// Runs the active set from full contact; `None` if a set comes back or leaves a block free.
    fn active_set(&self) -> Option<Vec<f64>> {
        let mut closed = vec![true; self.rows.len()];
        let mut seen = Vec::new();
        while !seen.contains(&closed) {
            let (forces, opening) = self.solve(&closed)?;
            let largest = |values: &[f64]| values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let (force, apart) = (1e-12 * largest(&forces), 1e-12 * largest(&opening));
            let next: Vec<bool> = (0..closed.len())
                .map(|k| if closed[k] { forces[k] > -force } else { opening[k] < -apart })
                .collect();
            if next == closed {
                return Some(forces);
            }
            seen.push(std::mem::replace(&mut closed, next));
        }
        None
    }
}

#[test]
fn five_hundred_exact_solutions_agree_with_the_active_set_of_the_full_system() {
    let mut random = Random::new(18);
    let mut compared = 0;
    for k in 0..520 {
        let load = carried(&mut random);
        let problem = pile(&mut random, load);
        let found = solve_exactly(&prepare(&problem).system(), &QpSettings::default()).unwrap();
        let Some(judge) = Full::new(&problem, load).active_set() else { continue };
        compared += 1;
        for (p, q) in found.contact_force.iter().flatten().zip(&judge) {
            assert!((p - q).abs() <= 1e-10 * load.down, "{k}: {p} {q}");
        }
    }
    println!("{compared} of 520 compared");
    assert!(compared >= 500, "{compared}");
}

#[test]
fn five_hundred_exact_solutions_agree_with_an_interior_point_method() {
    let mut random = Random::new(17);
    let mut without = 0;
    for k in 0..500 {
        let load = carried(&mut random);
        let prepared = prepare(&pile(&mut random, load));
        let found = solve_exactly(&prepared.system(), &QpSettings::default()).unwrap();
        let judge = solve_exactly(&prepared.system(), &QpSettings::default().with_method(QpMethod::Clarabel))
            .unwrap();
        assert!(found.status.is_solved() && judge.status.is_solved(), "{k}");
        assert!(found.kkt.max() < 1e-10, "{k}: {:?}", found.kkt);
        without += usize::from(found.clarabel_calls == 0);
        let energies = |u: &[Vec<fem_core::geometry::Vector>]| -> Vec<f64> {
            prepared.problem().bodies.iter().zip(u).map(|(b, u)| energy_norm_squared(b, u)).collect()
        };
        let [a, b] = [&found, &judge].map(|of| energies(&prepared.displacements(&of.fields)));
        let size: f64 = b.iter().sum();
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-6 * size), "{k}: {a:?} {b:?}");
        for (p, q) in found.contact_force.iter().flatten().zip(judge.contact_force.iter().flatten()) {
            assert!((p - q).abs() <= 1e-6 * load.down, "{k}: {p} {q}");
        }
    }
    println!("{without} of 500 without Clarabel");
    assert!(without >= 480, "{without}");
}

/// Tells whether a random problem is certified, or its data give the reason why not.
fn has_a_reason(found: &Outcome) -> bool {
    match found {
        Outcome::Certified { .. } => true,
        // Rigid rotations that are not small.
        Outcome::NotValid { checks } => checks.iter().all(|(check, _)| *check == "rotation"),
        Outcome::Refused(said) => said.contains("is not held"),
    }
}

#[test]
fn no_bound_of_a_random_assembly_is_below_the_distance_to_a_finer_mesh() {
    let mut certified = 0;
    for number in (0..150).chain([274, 292, 430, 568, 1108, 1192, 1246]) {
        let kind = random_assemblies::case(number).0;
        let found = random_assemblies::trial(number, 1).unwrap();
        println!("{number}, {kind}: {found:?}");
        assert!(has_a_reason(&found), "{number}, {kind}: {found:?}");
        if let Outcome::Certified { bound, error } = found {
            certified += 1;
            assert!(bound >= error, "{number}, {kind}: {bound} {error}");
        }
    }
    println!("{certified} of 157 certified");
    assert!(certified >= 125, "{certified}");
}

#[test]
fn random_coarse_rollers_are_certified_or_refused_for_a_reason() {
    let mut counts = [0; 3];
    // In the last ones a few nodes carry the roller: the forces are nearly a vertex of what is in balance.
    for number in (0..60).chain([247, 442, 551, 902, 915, 1035, 1181, 2317, 2497, 2995]) {
        let roller = Roller::new(number, number % 2 == 1).unwrap();
        let found = match roller.problem() {
            Ok(problem) => outcome(problem, 2).unwrap(),
            Err(error) => Outcome::Refused(error.to_string()),
        };
        let edges = roller.edges;
        println!("{number}: {edges} edges, vertical normals {}: {found:?}", roller.vertical);
        assert!(has_a_reason(&found), "{number}: {found:?}");
        match found {
            Outcome::Certified { bound, error } => {
                counts[0] += 1;
                assert!(bound >= error, "{number}: {bound} {error}");
            }
            Outcome::NotValid { .. } => counts[1] += 1,
            Outcome::Refused(_) => counts[2] += 1,
        }
    }
    println!("{counts:?}: certified, not valid, refused");
    assert!(counts[0] >= 64, "{counts:?}");
}

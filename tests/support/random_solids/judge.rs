//! Runs of one assembly by several settings and on halved cells, and the promises that they must keep together.

use super::grid::prolonged;
use super::{Problem, Trial};
use crate::matrix::Promise;
use crate::random::Random;
use certified_contact::{
    Bounds, CertifiedSolution, Criterion, Imposed, Results, Settings, Silent, SolveError, free_motions, solve,
};
use cre_estimator::Relaxation;
use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::interface::ContactProblem;
use fem_core::mesh_field::MeshField;
use fem_core::norm::energy_distance_squared;
use fem_core::space::{Solid, Space};
use nalgebra::Vector3;
use nndd::{Acceleration, Method, NewtonSettings, NnddError, NnddSettings, NnddStatus, Weights};

/// Numbers whose difference is below this part of them are equal: the judge computes in double precision.
pub(super) const ROUNDING: f64 = 1e-11;
/// Forces on a body balance to this part of their size.
const BALANCE: f64 = 1e-12;
/// The forces of an iteration with an error below this part of the energy norm are those of the discrete solution.
const CONVERGED: f64 = 1e-9;
/// A finest mesh has at most this many nodes.
const FINEST: usize = 2_500;

/// A certified run.
pub(super) struct Claim {
    name: &'static str,
    /// How often the cells are halved.
    pub(super) halved: u32,
    /// By body.
    pub(super) displacement: Vec<Vec<Vector3<f64>>>,
    /// By body, of its cuts.
    shortenings: Vec<Vec<f64>>,
    /// The bound.
    pub(super) e_cre: f64,
    /// The bound of the distance to the solution on this mesh.
    pub(super) eta_nndd: f64,
    /// The energy norm.
    pub(super) norm: f64,
    /// The part of the bound that is rounding.
    pub(super) round_off: f64,
    /// The part of the lift, see [`cre_estimator::Parts`].
    pub(super) lift: f64,
    /// The part of the bound of a closed contact that opens by the last digit of the displacements, `√(2 Σ P ε max |u|)`.
    pub(super) last_digit: f64,
    /// How stresses were relaxed.
    pub(super) relaxation: Relaxation,
    bounds: Bounds,
}

impl Claim {
    fn new(
        name: &'static str,
        halved: u32,
        (settings, solution): (&Settings<Solid>, &CertifiedSolution<Solid>),
    ) -> Option<Self> {
        let estimate = solution.estimate.as_ref().filter(|_| solution.is_certified())?;
        let found = estimate.unchecked();
        let results = solution.results.as_ref()?;
        Some(Self {
            name,
            halved,
            displacement: estimate.pair.bodies.iter().map(|body| body.displacement.clone()).collect(),
            shortenings: solution.problem.bodies.iter().map(shortenings).collect(),
            e_cre: found.e_cre,
            eta_nndd: found.eta_nndd.max(solution.last().eta_nndd),
            norm: estimate.energy_norm(),
            round_off: estimate.round_off,
            lift: found.parts.lift,
            last_digit: (2.0 * f64::EPSILON * results.contact_force * results.max_displacement).sqrt(),
            relaxation: settings.relaxation,
            bounds: solution.bounds?,
        })
    }
}

/// Draws settings: any method, early stops, little relaxation.
pub(super) fn random_settings(random: &mut Random) -> Settings<Solid> {
    let mut settings = Settings::<Solid>::default();
    settings.relaxation = match random.integer(0, 3) {
        0 => Relaxation::NONE,
        1 => Relaxation::Steps(random.integer(1, 5)),
        2 => Relaxation::Tolerance { tolerance: 0.1 * random.unit(), max_steps: random.integer(2, 20) },
        _ => Relaxation::default(),
    };
    settings.estimate_every = [0, 0, 0, 1, 2][random.integer(0, 4)];
    settings.imposed = [Imposed::Auto, Imposed::First, Imposed::Second][random.integer(0, 2)];
    let early = random.unit() < 0.5;
    settings.criterion = match random.integer(0, 3) {
        _ if early => Criterion::Iterations,
        0 => Criterion::Precision { tolerance: 10f64.powf(-1.0 - 8.0 * random.unit()) },
        1 => Criterion::EtaNndd { tolerance: 10f64.powf(-1.0 - 8.0 * random.unit()) },
        _ => Criterion::Estimator { ratio: 10f64.powf(-3.0 * random.unit()), force_balance: None },
    };
    let most = if early { random.integer(0, 6) } else { random.integer(10, 60) };
    let method = match random.integer(0, 3) {
        0 => Method::from(NewtonSettings::default()),
        1 => Method::NewtonNn(NewtonSettings::default()),
        _ => {
            let mut nndd = NnddSettings::default();
            if random.unit() < 0.3 {
                nndd.theta = Some(0.1 + 0.8 * random.unit());
            }
            if random.unit() < 0.2 {
                nndd.weights = Weights::Half;
            }
            if random.unit() < 0.3 {
                nndd.acceleration = Acceleration::None;
            }
            nndd.into()
        }
    };
    settings.with_method(method.with_max_iterations(most))
}

/// Returns the first settings with bodies in subdomains.
fn in_subdomains(problem: &Problem) -> Settings<Solid> {
    let method = Method::NewtonNn(NewtonSettings::default());
    let most = problem.first.method.max_iterations().max(1);
    let mut settings = problem.first.clone().with_method(method.with_max_iterations(most));
    settings.subdomains = 2 + (problem.number % 11) as usize;
    settings.recomputes = problem.number.is_multiple_of(2);
    settings
}

/// Runs and judges a problem; returns the certified runs, the last one by the exact method.
pub(super) fn judge(problem: &Problem, trial: &mut Trial) -> Vec<Claim> {
    let mut exact = Settings::<Solid>::default().with_method(NewtonSettings::default());
    exact.relaxation = Relaxation::Steps(2);
    let mut runs = vec![
        ("first", 0, problem.first.clone()),
        ("second", 0, problem.second.clone()),
        ("in subdomains", 0, in_subdomains(problem)),
        ("finer", 1, exact.clone()),
    ];
    if problem.number.is_multiple_of(3) && trial.nodes << 6 <= FINEST {
        runs.push(("finest", 2, exact));
    }
    let mut claims: Vec<Claim> = Vec::new();
    let mut held = Vec::new();
    for (name, halved, settings) in runs {
        let made = match problem.assembly.problem(halved) {
            Ok(made) => made,
            Err(error) => {
                trial.say(Promise::Status, false, || format!("{name}: {error}"));
                continue;
            }
        };
        trial.runs += 1;
        match solve(made, &settings, &mut Silent) {
            Ok(solution) => {
                held.push((name, halved, None));
                of_run(name, &solution, &settings, trial);
                claims.extend(Claim::new(name, halved, (&settings, &solution)));
                if name == "first" {
                    trial.ended = format!("{:?}", solution.nndd.status);
                }
                if name == "first" && !solution.is_certified() {
                    trial.refused = Some(match (&solution.estimate, &solution.no_estimate) {
                        (Some(found), _) => {
                            let failed: Vec<String> = found
                                .admissibility
                                .failed()
                                .map(|(name, by)| format!("{name} {by:.0e}"))
                                .collect();
                            format!("no certificate: {}", failed.join("; "))
                        }
                        (None, Some(error)) => format!("no estimate: {error}"),
                        (None, None) => "no estimate".into(),
                    });
                }
            }
            Err(error) => {
                // The paper's iteration says that it does not take a node with two pairs in one direction, nor pairs within a bonded body.
                let refused = |of: &NnddError| {
                    matches!(of, NnddError::DependentRows { .. } | NnddError::WithinABody { .. })
                };
                let of_method = matches!(&error, SolveError::Nndd(of) if refused(of))
                    && matches!(settings.method, Method::Nndd(_));
                // Offsets of bonds may press clamped nodes into each other.
                let refusal = matches!(
                    error,
                    SolveError::NotHeld { .. } | SolveError::CutForce { .. } | SolveError::Bonds(_)
                );
                // A force in a cut needs the exact solution.
                let in_one_piece =
                    matches!(error, SolveError::Subdomains { .. } | SolveError::CutMethod { .. });
                let of_method = of_method || name == "in subdomains" && in_one_piece;
                if !of_method {
                    held.push((name, halved, Some(error.to_string())));
                }
                trial.say(Promise::Status, refusal || of_method, || format!("{name}: {error}"));
                trial.say(Promise::Words, !error.to_string().is_empty(), || "nothing is said".into());
                if name == "first" {
                    trial.refused = Some(error.to_string());
                }
            }
        }
    }
    // Other methods do not change what is held, nor do finer meshes of flat surfaces; on others they have more normals.
    let agree = |two: &[(_, u32, Option<String>)]| {
        let [before, after] = [two[0].2.is_none(), two[1].2.is_none()];
        before == after
            || after && two[1].1 > two[0].1 && (problem.is_round() || problem.assembly.grid.is_bent())
            // Bonds and supports may hold all nodes of a small contact.
            || after && two[1].1 > two[0].1 && problem.family == super::draw::BONDED
            // Forces at few nodes resist more torsion than those at many within the same limit.
            || two[1].1 > two[0].1 && problem.family.contains("friction")
    };
    let same = held.windows(2).all(agree);
    trial.say(Promise::Status, same, || format!("held by one run and not by another: {held:?}"));
    together(problem, &claims, trial);
    claims
}

/// Judges the numbers of one run.
pub(super) fn of_run(
    name: &'static str,
    solution: &CertifiedSolution<Solid>,
    settings: &Settings<Solid>,
    trial: &mut Trial,
) {
    let certified = solution.is_certified();
    let numbers = [solution.relative(), solution.relative_guaranteed()];
    if !certified {
        trial
            .say(Promise::Words, numbers == [None; 2], || format!("{name}: {numbers:?} without certificate"));
        let spoken = solution.no_estimate.is_some()
            || solution.estimate.as_ref().is_some_and(|e| e.reason().is_some());
        trial.say(Promise::Words, spoken, || format!("{name}: no reason is given"));
    }
    let Some(estimate) = solution.estimate.as_ref().filter(|_| certified) else { return };
    let found = estimate.unchecked();
    let sound = [found.e_cre, found.eta_dis, found.eta_nndd, estimate.round_off, estimate.energy_norm()]
        .iter()
        .all(|x| x.is_finite() && *x >= 0.0);
    let fair = match numbers {
        [Some(relative), Some(guaranteed)] => guaranteed >= relative && relative >= 0.0,
        [None, _] => estimate.holds_no_energy(),
        _ => true,
    };
    trial.say(Promise::Words, sound && fair, || format!("{name}: {found:?}, {numbers:?}"));
    // Of squares that are not rounding themselves.
    let split = estimate.cre.split_defect();
    let exact =
        split <= 1e-10 + 2.0 * estimate.round_off / found.e_cre || found.e_cre <= 10.0 * estimate.round_off;
    trial.say(Promise::Words, exact, || format!("{name}: the split is off by {split:e}, {found:?}"));
    let Some(bounds) = solution.bounds else {
        trial.say(Promise::Words, false, || format!("{name}: no intervals"));
        return;
    };
    let ends = [Some(bounds.energy_norm), Some(bounds.potential_energy), bounds.contact_force.ok()];
    let ordered = ends.iter().flatten().all(|[a, b]| a.is_finite() && b.is_finite() && a <= b);
    trial.say(Promise::Words, ordered, || format!("{name}: {bounds:?}"));
    if let (Criterion::Estimator { .. }, NnddStatus::StoppedByCriterion) =
        (settings.criterion, &solution.nndd.status)
    {
        let bound = found.eta_nndd <= found.e_cre + estimate.round_off;
        trial.say(Promise::Status, bound, || format!("{name}: stopped by its criterion with {found:?}"));
    }
    match &solution.results {
        Some(results) => of_forces(name, solution, (settings, results), trial),
        None => trial.say(Promise::Words, false, || format!("{name}: no results")),
    }
}

/// Judges that forces are numbers and balance each body.
fn of_forces(
    name: &'static str,
    solution: &CertifiedSolution<Solid>,
    (settings, results): (&Settings<Solid>, &Results<Solid>),
    trial: &mut Trial,
) {
    let scalars = [
        results.contact_force,
        results.max_pressure,
        results.max_facet_pressure,
        results.min_opening,
        results.max_displacement,
        results.max_von_mises.unwrap_or(f64::NAN),
        results.peak_stress.map_or(f64::NAN, |peak| peak.von_mises),
    ];
    trial.say(Promise::Words, scalars.iter().all(|x| x.is_finite()), || format!("{name}: {scalars:?}"));
    if solution.nndd.status != NnddStatus::StoppedByCriterion || settings.criterion == Criterion::Iterations {
        return;
    }
    // Bodies that nothing presses have forces of rounding.
    let forces: Vec<Forces> =
        (0..results.balance.len()).map(|b| Forces::new(&solution.problem, results, b)).collect();
    let largest = forces.iter().map(|of| of.size).fold(0.0, f64::max);
    // The same force presses on both bodies of a pair, up to the error of the iteration.
    let (norm, round_off) = solution.estimate.as_ref().map_or((0.0, 0.0), |e| (e.energy_norm(), e.round_off));
    let eta_nndd = solution.last().eta_nndd;
    let exact = matches!(solution.method, Method::Newton(_));
    let converged = exact && eta_nndd <= CONVERGED * norm;
    let total = forces.iter().map(|of| of.sum).sum::<Vector3<f64>>().norm();
    // Along a motion that only the error of normals resists, forces balance up to this error.
    let weak = match free_motions(&solution.problem) {
        Ok(free) if free.iter().any(|motion| motion.weak) => Solid::NORMAL_ERROR,
        _ => 0.0,
    };
    for (b, (of, balance)) in forces.iter().zip(&results.balance).enumerate() {
        // An iterate that is not the discrete solution leaves forces that its error can explain; the exact method leaves rounding.
        let error = if exact { eta_nndd.min(round_off) } else { eta_nndd };
        let inexact = error * of.stiffness.sqrt();
        let least = (BALANCE + weak) * largest + of.rounding + inexact;
        let rest = balance.force.norm().max(balance.moment.norm() / of.arm);
        trial.worst = trial.worst.max(rest / largest);
        trial.say(Promise::Balance, rest <= least, || {
            format!("{name}: body {b}: {balance:?}, of {:e} with arms of {:e}, {least:e}", of.size, of.arm)
        });
        // A support at a bond takes the forces of both bodies.
        let bonded = solution.problem.contacts.iter().any(|pair| pair.is_bonded());
        if converged {
            let both = if bonded { total } else { of.sum.norm() };
            trial.worst_pair = trial.worst_pair.max(both / largest);
            trial.say(Promise::Balance, both <= least, || {
                format!(
                    "{name}: pairs, supports and loads of body {b} leave {both:e} of {largest:e}, {least:e}"
                )
            });
        }
    }
}

/// The forces on a body, as the results have them.
struct Forces {
    /// Of supports, springs, rigid sides, pairs and loads together, N.
    sum: Vector3<f64>,
    /// The sum of their sizes, N.
    size: f64,
    /// The size of the body, m.
    arm: f64,
    /// The sum of the stiffnesses of its cells, N/m.
    stiffness: f64,
    /// The rounding of stresses of displacements of this size, N.
    rounding: f64,
}

impl Forces {
    fn new(problem: &ContactProblem<Solid>, results: &Results<Solid>, b: usize) -> Self {
        let body = &problem.bodies[b];
        let of_reactions = results.reactions.iter().filter(|r| r.body == b).map(|r| r.force);
        let of_sides = results.rigid_sides.iter().filter(|r| r.body == b).map(|r| r.force);
        let of_springs = results.springs.iter().filter(|s| s.body == b).map(|s| s.force);
        let of_pairs = problem.contacts.iter().zip(&results.contacts).filter_map(|(pair, found)| {
            let side = pair.elastic_sides().find(|(_, of)| *of == b)?.0;
            Some(found.resultant * [1.0, -1.0][side])
        });
        // The force of a rigid side contains its load.
        let loads = external_forces(body);
        let on_sides = body.rigid_sides().iter().flat_map(|side| &side.forces).map(|f| -f);
        let all: Vec<Vector3<f64>> = of_reactions
            .chain(of_sides)
            .chain(of_springs)
            .chain(of_pairs)
            .chain(on_sides)
            .chain(loads)
            .collect();
        let of_cell = |t: usize| {
            let (corners, volume) = (body.mesh().corners(t), body.mesh().measure(t));
            let steepest =
                Solid::gradients(&corners, volume).iter().map(|g| g.norm_squared()).fold(0.0, f64::max);
            body.material(t).stiffness().amax() * volume * steepest
        };
        let stiffness: f64 = (0..body.mesh().cells().len()).map(of_cell).sum();
        Self {
            sum: all.iter().sum(),
            size: all.iter().map(|f| f.norm()).sum(),
            arm: body.mesh().diagonal(),
            stiffness,
            rounding: 4.0 * f64::EPSILON * results.max_displacement * stiffness,
        }
    }
}

/// Judges the claims of all runs together.
fn together(problem: &Problem, claims: &[Claim], trial: &mut Trial) {
    let finest = claims.iter().map(|claim| claim.halved).max().unwrap_or(0);
    for (k, a) in claims.iter().enumerate() {
        for b in &claims[k + 1..] {
            let (coarse, fine) = if a.halved <= b.halved { (a, b) } else { (b, a) };
            let names = format!("{} and {}", coarse.name, fine.name);
            let intervals = [
                (Promise::Norm, Some((a.bounds.energy_norm, b.bounds.energy_norm))),
                (Promise::Energy, Some((a.bounds.potential_energy, b.bounds.potential_energy))),
                (Promise::Force, a.bounds.contact_force.ok().zip(b.bounds.contact_force.ok())),
            ];
            for (promise, both) in intervals {
                let Some((x, y)) = both else { continue };
                let slack = ROUNDING * x.iter().chain(&y).fold(0.0f64, |m, x| m.max(x.abs()));
                let meet = x[0] <= y[1] + slack && y[0] <= x[1] + slack;
                trial.say(promise, meet, || format!("{names}: {x:?} and {y:?} are apart"));
            }
            let distance = match problem.assembly.parts.iter().any(|part| part.cut.is_some()) {
                true => distance_with_cuts(problem, coarse, fine),
                false => distance(problem, (&coarse.displacement, coarse.halved), fine),
            };
            let Some(distance) = distance else {
                trial.say(Promise::Error, false, || format!("{names}: no distance"));
                continue;
            };
            let slack = ROUNDING * fine.norm;
            if coarse.halved == fine.halved {
                let both = coarse.eta_nndd + fine.eta_nndd;
                trial.say(Promise::Iteration, distance <= both + slack, || {
                    format!("{names}: {distance:e} apart, {:e} and {:e}", coarse.eta_nndd, fine.eta_nndd)
                });
                let both = coarse.e_cre + fine.e_cre;
                trial.say(Promise::Error, distance <= both + slack, || {
                    format!("{names}: {distance:e} apart, {:e} and {:e}", coarse.e_cre, fine.e_cre)
                });
                continue;
            }
            // The solution of the finer mesh is nearer than the bound, up to its own iteration error and rounding.
            let inexact = fine.eta_nndd + fine.round_off;
            trial.say(Promise::Error, distance <= coarse.e_cre + inexact + slack, || {
                format!("{names}: {distance:e} apart, e_cre {:e}, finer one {inexact:e}", coarse.e_cre)
            });
            if coarse.name == "first" && fine.halved == finest {
                let above = distance > 10.0 * (coarse.round_off + inexact + slack);
                trial.effectivity = above.then(|| coarse.e_cre / distance);
            }
        }
    }
}

fn shortenings(body: &Body<Solid>) -> Vec<f64> {
    body.cuts().iter().map(|cut| cut.shortening).collect()
}

/// [`distance`] of the fields of two runs, with the jumps at cuts.
fn distance_with_cuts(problem: &Problem, coarse: &Claim, fine: &Claim) -> Option<f64> {
    let bodies = |claim: &Claim| {
        let mut bodies = problem.assembly.problem(claim.halved).ok()?.bodies;
        bodies.iter_mut().zip(&claim.shortenings).for_each(|(body, of)| body.shorten(of));
        Some(bodies)
    };
    let (a, b) = (bodies(coarse)?, bodies(fine)?);
    let of_body = |k: usize| {
        let field = MeshField::of_body(&a[k], &coarse.displacement[k]);
        field.energy_distance_squared(&b[k], &fine.displacement[k])
    };
    Some((0..a.len()).map(of_body).sum::<f64>().max(0.0).sqrt())
}

/// Computes the distance of a field from that of a run, in the energy norm, on the finer mesh of the run.
///
/// * `halved`: how often the cells of the field are.
pub(super) fn distance(
    problem: &Problem,
    (field, halved): (&[Vec<Vector3<f64>>], u32),
    fine: &Claim,
) -> Option<f64> {
    let mut squared = 0.0;
    let mut field = field.to_vec();
    for (part, field) in problem.assembly.parts.iter().zip(&mut field) {
        for halved in halved..fine.halved {
            *field = prolonged(part.cells.counts().map(|n| n << halved), field);
        }
    }
    let made = problem.assembly.problem(fine.halved).ok()?;
    for (body, (u, v)) in made.bodies.iter().zip(field.iter().zip(&fine.displacement)) {
        squared += energy_distance_squared(body, u, v);
    }
    Some(squared.max(0.0).sqrt())
}

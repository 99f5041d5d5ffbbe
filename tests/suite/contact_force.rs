//! Bounds of the contact force: what they must hold for, and which lines have no bounds.

use case_io::Case;
use certified_contact::{Criterion, NoContactForce, Settings, Silent, solve};
use contact_geometry::ContactNormal;
use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Friction, Gap, Obstacle, RigidLine};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use nndd::{NewtonSettings, NnddSettings};
use tests::assemblies::{stamped, tower};
use tests::paper;
use tests::random::Random;
use tests::run::paired_in_common;

type Interval = Result<[f64; 2], NoContactForce>;

fn force(problem: ContactProblem, settings: &Settings) -> Option<Interval> {
    let answer = solve(problem, settings, &mut Silent).ok()?;
    answer.is_certified().then(|| answer.bounds.unwrap().contact_force)
}

fn of_case(text: &str) -> ContactProblem {
    Case::parse(text, "case.toml", &[]).unwrap().build().unwrap().0
}

/// Stops after some iterations from λ = `lambda`, converged or not.
fn early(iterations: usize, theta: f64, lambda: f64) -> Settings {
    let mut settings = Settings::default();
    settings.method = NnddSettings::paper(theta).into();
    settings.method = settings.method.with_max_iterations(iterations);
    settings.criterion = Criterion::Iterations;
    settings.lambda = lambda.into();
    settings
}

#[test]
fn a_line_that_both_bodies_clamp_at_its_ends_has_no_interval() {
    // On finer meshes the force is 9.365, 9.668, 9.809, 9.869, ...: intervals of a displacement that drops to zero on the last edges missed it.
    for text in [
        include_str!("../cases/true_numbers/force-clamped-8.toml"),
        include_str!("../cases/true_numbers/force-clamped-32.toml"),
    ] {
        assert_eq!(force(of_case(text), &Settings::default()), Some(Err(NoContactForce::Held { pair: 0 })));
    }
}

#[test]
fn the_force_on_a_floating_body_is_that_of_equilibrium_however_far_the_iteration_is() {
    let problem = of_case(include_str!("../cases/true_numbers/force-interval.toml"));
    for lambda in [0.1, 0.0, -0.03] {
        for iterations in [1, 2, 5] {
            let [low, high] = force(problem.clone(), &early(iterations, 0.4, lambda)).unwrap().unwrap();
            assert!(low <= 2.0 && 2.0 <= high && high - low < 1e-12, "{lambda} {iterations}: {low} {high}");
        }
    }
}

#[test]
fn a_body_that_touches_nothing_does_not_remove_the_interval() {
    let mut problem = paper::problem([6, 3]).unwrap();
    let alone = force(problem.clone(), &Settings::default()).unwrap().unwrap();
    let idle = block([10.0, 0.0], [1.0, 1.0], [2, 2]).unwrap();
    let material = problem.bodies[0].material(0).clone();
    problem.bodies.push(Body::new(idle, material, &BoundaryConditions::new().fix("bottom")).unwrap());
    let [low, high] = force(problem, &Settings::default()).unwrap().unwrap();
    assert!(low <= paper::FORCE && paper::FORCE <= high && low <= alone[1] && alone[0] <= high);
    assert!(high - low < 1.1 * (alone[1] - alone[0]), "{low} {high} {alone:?}");
}

#[test]
fn a_press_under_a_given_force_and_stacks_have_intervals() {
    // 20 on each of three lines: known by the stamp's equilibrium on the first of them.
    let [low, high] = force(stamped().unwrap(), &Settings::default()).unwrap().unwrap();
    assert!(low <= 60.0 && 60.0 <= high && high - low < 4.0, "{low} {high}");
    let mut last: Option<[f64; 2]> = None;
    for cells in [6, 12, 24] {
        let found = force(tower(3, [cells, cells / 2]).unwrap(), &Settings::default()).unwrap().unwrap();
        if let Some(last) = last {
            assert!(found[0] <= last[1] && last[0] <= found[1], "{found:?} {last:?}");
            assert!(found[1] - found[0] < 0.8 * (last[1] - last[0]), "{found:?} {last:?}");
        }
        last = Some(found);
    }
}

/// A random problem of two blocks, or of a block and a plane: numbers that do not depend on the mesh.
struct Blocks {
    young: [f64; 2],
    poisson: [f64; 2],
    height: [f64; 2],
    /// Of each body: the left and the right side, free, on a roller, or clamped.
    sides: [[usize; 2]; 2],
    /// Of the bottom of the lower and the top of the upper body.
    push: Option<f64>,
    pressure: f64,
    pull: f64,
    gap: [f64; 2],
    limit: Option<f64>,
    cells: [usize; 2],
    obstacle: bool,
}

impl Blocks {
    fn new(random: &mut Random) -> Self {
        let mut pick =
            |values: &[f64]| values[((random.unit() * values.len() as f64) as usize).min(values.len() - 1)];
        let side = |x: f64| x as usize;
        let matching = pick(&[0.0, 1.0]) > 0.0;
        let first = side(pick(&[2.0, 3.0, 4.0]));
        Self {
            young: [pick(&[100.0, 1000.0, 3e4]), pick(&[100.0, 1000.0, 2000.0])],
            poisson: [pick(&[0.0, 0.3, 0.45]), pick(&[0.0, 0.3, 0.45])],
            height: [pick(&[0.05, 0.3, 1.0]), pick(&[0.05, 0.3, 1.0])],
            sides: [0, 1].map(|_| [0, 1].map(|_| side(pick(&[0.0, 0.0, 1.0, 2.0])))),
            push: (pick(&[0.0, 1.0]) > 0.0).then(|| pick(&[-0.01, -0.003])),
            pressure: pick(&[0.0, 2.0, 10.0]),
            pull: pick(&[0.0, 0.0, 3.0, -3.0]),
            gap: [pick(&[0.0, 0.0, 0.002]), pick(&[0.0, 0.0, 0.004])],
            limit: (pick(&[0.0, 0.0, 1.0]) > 0.0).then(|| pick(&[0.5, 3.0])),
            cells: if matching { [first; 2] } else { [first, side(pick(&[2.0, 3.0, 4.0, 5.0]))] },
            obstacle: pick(&[0.0, 0.0, 0.0, 1.0]) > 0.0,
        }
    }

    fn body(&self, b: usize, level: usize) -> Option<Body> {
        let mut conditions = BoundaryConditions::new();
        for (name, how) in ["left", "right"].into_iter().zip(self.sides[b]) {
            conditions = match how {
                1 => conditions.displace(name, Some(0.0.into()), None),
                2 => conditions.fix(name),
                _ => conditions,
            };
        }
        if b == 1 {
            conditions = conditions.fix("bottom");
        } else {
            if let Some(push) = self.push {
                conditions = conditions.displace("top", None, Some(push.into()));
            } else {
                conditions = conditions.pressure("top", self.pressure);
            }
            if self.sides[0][1] == 0 {
                conditions = conditions.traction("right", [0.0.into(), self.pull.into()]);
            }
        }
        let origin = [0.0, [0.0, -self.height[1]][b]];
        let cells = [self.cells[b] << level, (1 + b) << level];
        let mesh = block(origin, [1.0, self.height[b]], cells).ok()?;
        let material =
            LinearElastic::isotropic(self.young[b], self.poisson[b], Hypothesis::PlaneStrain).ok()?;
        Body::new(mesh, material, &conditions).ok()
    }

    fn problem(&self, level: usize) -> Option<ContactProblem> {
        let upper = self.body(0, level)?;
        let [from, to] = self.gap;
        let gap = Gap::Given(fem_core::boundary::ScalarData::function(move |x| from + x[0] * (to - from)));
        let problem = if self.obstacle {
            let plane = RigidLine::Plane { point: [0.0, 0.0].into(), normal: [0.0, 1.0].into() };
            let obstacle = Obstacle::fixed(plane);
            let interface = contact_geometry::against(&upper, "bottom", &obstacle, Some(&gap)).ok()?;
            ContactProblem::new(vec![upper]).obstacle(0, interface, obstacle)
        } else {
            let bodies = [upper, self.body(1, level)?];
            paired_in_common(bodies, ["bottom", "top"], &gap, ContactNormal::Averaged).ok()?.0
        };
        match self.limit {
            Some(limit) => problem.with_friction(0, Friction::tresca(limit)).ok(),
            None => Some(problem),
        }
    }
}

#[test]
fn intervals_of_one_problem_on_nested_meshes_and_by_all_methods_meet() {
    let (mut compared, mut without, mut known) = (0, 0, 0);
    for number in 0..80 {
        let mut random = Random::new(number);
        let blocks = Blocks::new(&mut random);
        let mut meet = [0.0f64, f64::INFINITY];
        let mut found = 0;
        for level in 0..3 {
            let Some(problem) = blocks.problem(level) else { continue };
            let mut newton = Settings::default();
            newton.method = NewtonSettings::default().into();
            let mut all = vec![Settings::default(), newton];
            if level < 2 {
                let iterations = 1 + (random.unit() * 4.0) as usize;
                all.push(early(iterations, 0.2 + 0.3 * random.unit(), 0.02 * (random.unit() - 0.5)));
            }
            for settings in all {
                match force(problem.clone(), &settings) {
                    Some(Ok([low, high])) => {
                        found += 1;
                        known += usize::from(high - low <= 1e-9 * high);
                        let slack = 1e-12 * high;
                        meet = [meet[0].max(low - slack), meet[1].min(high + slack)];
                        assert!(
                            meet[0] <= meet[1],
                            "{number}, level {level}: [{low}, {high}] misses the others: {meet:?}"
                        );
                    }
                    Some(Err(_)) => without += 1,
                    None => {}
                }
            }
        }
        compared += usize::from(found > 1);
    }
    println!("{compared} problems compared, {known} intervals by equilibrium, {without} without");
    assert!(compared >= 40 && without >= 10 && known >= 10, "{compared} {without} {known}");
}

//! The bound over the true error, at every iteration of a problem.

use crate::columns::Columns;
use crate::model::{ContactProblem, Made, SymTensor2, Vector};
use crate::overkill::Overkill;
use crate::run::{certify_with, displacements, iterates, prepare};
use crate::signorini;
use certified_contact::{Settings, Silent, solve};
use cre_estimator::Relaxation;
use fem_core::norm::energy_error_squared;

/// The relaxations of every iteration: EET alone, two steps, and until next to nothing is left to gain.
pub const RELAXATIONS: [Relaxation; 3] =
    [Relaxation::NONE, Relaxation::Steps(2), Relaxation::Tolerance { tolerance: 1e-4, max_steps: 50 }];

/// The contrasts `E₁/E₂` that the bound is tried on.
pub const CONTRASTS: [f64; 5] = [1e-3, 0.05, 1.0, 20.0, 1e3];

/// An exact stress of one body.
pub type Stress<'a> = Box<dyn Fn(Vector) -> SymTensor2 + Sync + 'a>;

/// The source of the true error.
pub enum Truth<'a> {
    /// The exact stresses of the two bodies, in the order of the problem handed over.
    Exact([Stress<'a>; 2]),
    /// A finer solution, this many times more exact than the certified error of the converged one.
    Overkill(f64),
}

impl Truth<'_> {
    /// The exact stresses of reference problem 2, see [`signorini`].
    pub fn signorini(materials: [(f64, f64); 2], k: f64) -> Self {
        Self::Exact(signorini::exact(materials, k).map(|e| Box::new(move |x| e.stress(x)) as Stress<'_>))
    }

    /// The exact stresses of heavy columns.
    pub fn columns(columns: Columns) -> Self {
        Self::Exact([0, 1].map(|b| Box::new(move |x| columns.stress(b, x)) as Stress<'_>))
    }
}

/// One iteration of one problem.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Number, from 1.
    pub iteration: usize,
    /// True if the default criterion stops here.
    pub stops: bool,
    /// An enclosure of `‖u − u_p‖`; both ends are the same for an exact solution.
    pub error: [f64; 2],
    /// `e_CRE` for each relaxation asked for; `None` if its checks fail.
    pub bounds: Vec<Option<f64>>,
    /// Steps made in both bodies together, for each relaxation.
    pub steps: Vec<usize>,
}

impl Sample {
    /// Encloses the effectivity for one of the relaxations: bound over error.
    pub fn effectivity(&self, relaxation: usize) -> Option<[f64; 2]> {
        self.bounds[relaxation].map(|bound| [bound / self.error[1], bound / self.error[0]])
    }
}

/// The iterations of a problem and what they were measured by.
#[derive(Clone, Debug)]
pub struct Course {
    /// Nodes of both bodies.
    pub nodes: usize,
    /// The iterations, from the first.
    pub samples: Vec<Sample>,
    /// Nodes and certified relative error of the finer solution, if there is one.
    pub overkill: Option<(usize, f64)>,
}

impl Course {
    /// Returns the iteration at which the default criterion stops.
    pub fn stop(&self) -> Option<&Sample> {
        self.samples.iter().find(|s| s.stops)
    }
}

/// Which iterations to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// All of them.
    Every,
    /// The one at which the default criterion stops.
    Stop,
}

/// Iterates from λ = 0 with the default settings until `η_NNDD` has fallen by 1e-6, and measures the iterations.
///
/// # Errors
/// The problem cannot be solved, or the finer solution is not certified.
pub fn course(
    problem: ContactProblem,
    truth: &Truth<'_>,
    relaxations: &[Relaxation],
    which: Which,
) -> Made<Course> {
    let nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
    // The roles, and where the default criterion stops.
    let default = solve(problem, &Settings::default(), &mut Silent)?;
    let stop = default.rows.len();
    let prepared = prepare(&default.problem);
    let (_, mut all) = iterates(&prepared, &nndd::NnddSettings::default(), 1e-6)?;
    if all.iter().all(|i| i.iteration != stop) {
        // The answer of the default method.
        all.push(default.last().clone());
    }
    let finer = match truth {
        Truth::Exact(_) => None,
        Truth::Overkill(factor) => {
            let own = default.relative().ok_or("a problem without energy")?;
            Some(Overkill::new(default.problem.clone(), own / factor)?)
        }
    };
    let mut samples = Vec::new();
    for iterate in all.iter().filter(|i| which == Which::Every || i.iteration == stop) {
        let u = displacements(&prepared, iterate);
        let error = match (truth, &finer) {
            (Truth::Exact(exact), _) => {
                let squared =
                    |b: usize| energy_error_squared(&default.problem.bodies[b], &u[b], |x| exact[b](x));
                [(squared(0) + squared(1)).sqrt(); 2]
            }
            (_, Some(finer)) => finer.error([&u[0], &u[1]], &iterate.opening)?,
            (_, None) => [f64::NAN; 2],
        };
        let mut sample = Sample {
            iteration: iterate.iteration,
            stops: iterate.iteration == stop,
            error,
            bounds: vec![],
            steps: vec![],
        };
        for &relaxation in relaxations {
            let e = certify_with(&prepared, iterate, relaxation)?;
            sample.bounds.push(e.certificate().map(|bound| bound.e_cre));
            sample.steps.push(e.pair.bodies.iter().map(|b| b.relaxation.steps).sum());
        }
        samples.push(sample);
    }
    Ok(Course { nodes, samples, overkill: finer.map(|f| (f.nodes(), f.relative())) })
}

//! Improves the solution to the accuracy that double precision allows.
//!
//! The factorised operators belong to the rounded stiffness. If a soft part supports a stiff one, their solution may
//! have few correct digits or no correct digit. Defect correction repairs that: the forces of the current fields are
//! evaluated without rounding, and the same contact problem is solved for the *increments* with the same operators,
//! ```math
//! r^α = r₀^α + S_α x^α,   r₀^α = K u₀^α − f,   o = (g − [v₀]) − (x^1 − x^2) ≥ 0
//! ```
//! until the increments vanish: (28) of [`crate::theory`].

use fem_core::condensation::InterfaceLoad;
use fem_core::double_double::DoubleDouble;
use fem_core::interface::{ContactPair, NodePair, Partner};
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use fem_core::space::{Plane, Space};
use nndd::stopping::EtaNndd;
use nndd::{Iterate, Method, NnddError, NnddSettings, Start, UnilateralSolution};
use rayon::prelude::*;

/// An increment larger than this fraction of the previous one is the last.
const WORTHWHILE: f64 = 0.7;
/// Maximum number of corrections.
const MOST_CORRECTIONS: usize = 40;
/// In each correction the iteration lowers η_NNDD by this factor.
const REDUCTION: f64 = 1e-2;
/// Maximum number of iterations of one correction.
const MOST_ITERATIONS: usize = 30;

/// An iterate and its fields.
pub(crate) struct Corrected<S: Space = Plane> {
    pub(crate) iterate: Iterate,
    pub(crate) fields: Vec<SplitField<S>>,
}

/// Corrects an iterate by its own defect.
///
/// * `problem`: its gaps and condensed loads change and are restored.
/// * `fields`: of the iterate.
/// * `advance`: whether λ may change; if not, only step 1 is repeated for the same λ.
///
/// Returns `None` if no improvement is possible: the first increment is not finite, a body is in subdomains, or the traces of the bodies in contact do not
/// determine their fields: bodies that contact alone holds, obstacles, friction, contact nodes on supports.
///
/// # Errors
/// See [`nndd::solve_from`].
pub(crate) fn correct<S: Space>(
    problem: &mut PreparedProblem<S>,
    iterate: &Iterate,
    fields: Vec<SplitField<S>>,
    method: &Method,
    advance: bool,
) -> Result<Option<Corrected<S>>, NnddError> {
    let contact = problem.problem();
    let bodies = 0..contact.bodies.len();
    let touching: Vec<usize> =
        bodies.filter(|b| contact.sides_of(Partner::Body(*b)).next().is_some()).collect();
    let system = problem.system();
    let free = |b: &usize| {
        let mut rows = system.of_body[*b].iter();
        rows.all(|row| row.imposed == 0.0) && iterate.interface_unknowns(&system, *b).is_some()
    };
    let whole = problem.bodies().iter().all(|body| body.whole().is_some());
    if !whole || !contact.obstacles.is_empty() || !touching.iter().all(free) {
        return Ok(None);
    }
    let contacts = contact.contacts.clone();
    // Increments leave the set alone: the iteration corrects λ.
    let method = match method {
        // The iteration does not know pairs within a bonded body.
        Method::NewtonNn(settings) if contacts.iter().any(ContactPair::<S>::is_within_a_body) => {
            settings.clone().into()
        }
        Method::NewtonNn(settings) => {
            let mut iteration = NnddSettings::default();
            iteration.qp = settings.qp.clone();
            iteration.into()
        }
        other => other.clone(),
    };
    let method = method.with_max_iterations(if advance { MOST_ITERATIONS } else { 1 });
    let mut correction = Correction { increments: problem, contacts, touching, loads: Vec::new(), method };
    let found = correction.run(iterate, fields);
    let Correction { increments: problem, contacts, loads, .. } = correction;
    for (k, pair) in contacts.iter().enumerate() {
        problem.replace_gaps(k, &pair.interface.pairs().iter().map(|p| p.gap).collect::<Vec<f64>>());
    }
    for (b, load) in loads.into_iter().enumerate() {
        if let Some(body) = problem.whole_mut(b) {
            body.restore_load(load);
        }
    }
    found
}

struct Correction<'a, S: Space> {
    /// The problem for increments about the current fields: its gaps and condensed loads are what the fields leave.
    increments: &'a mut PreparedProblem<S>,
    /// The pairs, with their own gaps.
    contacts: Vec<ContactPair<S>>,
    /// The bodies in contact.
    touching: Vec<usize>,
    /// The loads of all bodies, once they are replaced.
    loads: Vec<InterfaceLoad>,
    method: Method,
}

impl<S: Space> Correction<'_, S> {
    fn run(
        &mut self,
        iterate: &Iterate,
        mut fields: Vec<SplitField<S>>,
    ) -> Result<Option<Corrected<S>>, NnddError> {
        let mut best: Option<Corrected<S>> = None;
        let mut active = iterate.contact.active.clone();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            self.restate(&mut fields);
            let start = Start { lambda: vec![0.0; active.len()], active: Some(active) };
            let mut stop = EtaNndd::new(REDUCTION);
            let system = self.increments.system();
            let found = nndd::solve_from(&system, start, &self.method, &mut stop)?.last;
            let unknowns = |b: &usize| Some((*b, found.interface_unknowns(&system, *b)?));
            let increments: Vec<(usize, Vec<f64>)> = self.touching.iter().filter_map(unknowns).collect();
            let size = self.energy(&increments);
            if !(size < before) {
                break;
            }
            for (b, x) in &increments {
                let whole = self.increments.bodies()[*b].whole();
                whole.into_iter().for_each(|body| fields[*b].add(&body.correction_from_trace(x)));
            }
            active = found.contact.active.clone();
            let worthwhile = size < WORTHWHILE * before && size > 0.0;
            before = size;
            best = Some(Corrected { iterate: self.total(iterate, found, &fields), fields: fields.clone() });
            if !worthwhile {
                break;
            }
        }
        Ok(best)
    }

    /// Brings the fields into equilibrium for their traces and sets up the problem for increments from them.
    fn restate(&mut self, fields: &mut [SplitField<S>]) {
        let Self { increments, contacts, loads, .. } = self;
        let of_body = |b: usize, field: &mut SplitField<S>| {
            let body = &increments.problem().bodies[b];
            let Some(condensed) = increments.bodies()[b].whole() else { return Vec::new() };
            condensed.refine(body, &[], true, field);
            condensed.interface_forces(&residual::of_field(body, field))
        };
        let forces: Vec<Vec<f64>> =
            fields.par_iter_mut().enumerate().map(|(b, field)| of_body(b, field)).collect();
        let replace = |(b, r): (usize, Vec<f64>)| {
            let body = increments.whole_mut(b)?;
            Some(body.replace_condensed_load(r.iter().map(|r| -r).collect()))
        };
        let replaced: Vec<InterfaceLoad> = forces.into_iter().enumerate().filter_map(replace).collect();
        if loads.is_empty() {
            *loads = replaced;
        }
        for (k, pair) in contacts.iter().enumerate() {
            let sides = increments.problem().places_of(pair).map(|place| &fields[place]);
            let openings = pair.interface.pairs().iter().map(|p| opening(sides, p).rounded());
            increments.replace_gaps(k, &openings.collect::<Vec<f64>>());
        }
    }

    /// Computes `Σ x·S x` of the increments, J/m.
    fn energy(&self, increments: &[(usize, Vec<f64>)]) -> f64 {
        let of_body = |(b, x): &(usize, Vec<f64>)| {
            let mut force = vec![0.0; x.len()];
            let whole = self.increments.bodies()[*b].whole();
            whole.into_iter().for_each(|body| body.interface().apply_schur(x, &mut force));
            x.iter().zip(&force).map(|(x, f)| x * f).sum::<f64>()
        };
        increments.iter().map(of_body).sum()
    }

    /// Converts an iterate of the increments into one of the problem.
    fn total(&self, iterate: &Iterate, found: Iterate, fields: &[SplitField<S>]) -> Iterate {
        let trace = |role: usize| -> Vec<f64> {
            let of_pair = |pair: &ContactPair<S>| -> Vec<f64> {
                let (roles, side) = (pair.roles, pair.roles.sides()[role]);
                let field = &fields[self.increments.problem().places_of(pair)[side]];
                let of_node = |p: &NodePair<S>| {
                    let u = field.at(p.nodes[side].index());
                    roles.sign() * along_normal(p, |c| u[c]).rounded()
                };
                pair.interface.pairs().iter().map(of_node).collect()
            };
            self.contacts.iter().flat_map(of_pair).collect()
        };
        Iterate {
            lambda: trace(0),
            contact: UnilateralSolution { normal_trace: trace(1), ..found.contact },
            programme: iterate.programme,
            iteration: iterate.iteration,
            theta: iterate.theta,
            own: None,
            ..found
        }
    }
}

/// Computes the opening `g − (u¹ − u²)·n` of a pair.
fn opening<S: Space>(fields: [&SplitField<S>; 2], pair: &NodePair<S>) -> DoubleDouble {
    let [a, b] = [0, 1].map(|b: usize| fields[b].at(pair.nodes[b].index()));
    along_normal(pair, |c| b[c] - a[c]) + pair.gap
}

/// Computes the component along the normal of a pair, times its length.
fn along_normal<S: Space>(pair: &NodePair<S>, vector: impl Fn(usize) -> DoubleDouble) -> DoubleDouble {
    (1..S::DIM).fold(vector(0) * pair.normal[0], |sum, c| sum + vector(c) * pair.normal[c])
}

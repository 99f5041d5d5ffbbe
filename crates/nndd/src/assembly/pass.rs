//! Steps 1 and 2 of an assembly, and the bound of the iteration's error.

use super::correction::Correction;
use super::exact;
use super::response::{Response, Unilateral, imposed};
use super::subdomain::{Carrier, Subdomain};
use crate::balance::Balance;
use crate::error::NnddError;
use crate::iterate::{ContactAnswer, Iterate, Programme, Recovery, Tangential, precision};
use crate::iteration::Pass;
use crate::rows::Rows;
use crate::vector::{add, dot};
use contact_qp::{
    ActiveSet, BoxResiduals, Place, QpPath, QpSettings, QpStatus, SparseRows, nearest_balanced,
};
use fem_core::body::RigidMotion;
use fem_core::norm::from_squared;
use fem_core::prepared::{BodyMotion, PreparedProblem};
use fem_core::{each_body, try_each_body};
use nalgebra::DVector;

/// Forces are nearly in balance if the square of their distance to balanced ones is this fraction of their own square.
const NEARLY: f64 = 0.25;

/// The bodies of an assembly and what the steps share.
pub(super) struct Assembly<'a> {
    problem: &'a PreparedProblem,
    /// The lines of the balance that the pairs resist, and their loads.
    lines: (SparseRows, Vec<f64>),
    bodies: &'a [Subdomain<'a>],
    correction: &'a Correction<'a>,
    qp: &'a QpSettings,
    rows: &'a Rows,
    /// Initial gaps by row, m, and the inverse tributary lengths, 1/m.
    gaps: Vec<f64>,
    weights: Vec<f64>,
    /// The bounds of the unilateral forces by row, N/m.
    bounds: [Vec<f64>; 2],
    /// The imposed trace of the obstacle of each row, m.
    obstacles: Vec<Option<f64>>,
    programmes: Vec<Option<Unilateral>>,
    /// Where the forces of each body were in the last iteration.
    places: Vec<Option<Vec<Place>>>,
}

/// Step 1, by row of the assembly.
struct Answers {
    /// Forces that press on the bodies that carry λ, and on the others, N/m.
    carried: Vec<f64>,
    unilateral: Vec<f64>,
    /// Along tangents the slip with the opposite sign.
    opening: Vec<f64>,
    active: Vec<bool>,
}

impl<'a> Assembly<'a> {
    pub(super) fn new(
        problem: &'a PreparedProblem,
        rows: &'a Rows,
        balance: &Balance,
        bodies: &'a [Subdomain<'a>],
        correction: &'a Correction<'a>,
        qp: &'a QpSettings,
    ) -> Self {
        let bounds = rows.bounds(rows.limits());
        Self {
            problem,
            lines: balance.resisted(),
            bodies,
            correction,
            qp,
            rows,
            gaps: rows.gaps(problem),
            weights: rows.lengths(problem).iter().map(|length| 1.0 / length).collect(),
            obstacles: rows.obstacles(problem),
            programmes: each_body(bodies.len(), |b| Unilateral::new(&bodies[b], &bounds)),
            bounds,
            places: vec![None; bodies.len()],
        }
    }

    /// Starts with a known active set of all rows along normals, and full stick.
    pub(super) fn start_from(&mut self, active: &ActiveSet) {
        let normal: Vec<bool> = (0..active.len()).map(|i| active.is_active(i)).collect();
        let stick: Vec<bool> = self.rows.tangentials(self.rows.limits()).iter().map(|s| *s > 0.0).collect();
        let free = self.rows.joined(&normal, &stick);
        let place = |(carrier, row): (&Carrier, &usize)| {
            let free = *carrier == Carrier::Itself || free[*row];
            if free { Place::Free } else { Place::Lower }
        };
        let of_body = |body: &Subdomain<'_>| Some(body.carriers.iter().zip(&body.rows).map(place).collect());
        self.places = self.bodies.iter().map(of_body).collect();
    }

    /// Steps 1 and 2.
    pub(super) fn pass(&mut self, mut lambda: Vec<f64>) -> Result<Pass, NnddError> {
        let imposed = lambda.iter_mut().zip(&self.obstacles);
        imposed.for_each(|(lambda, obstacle)| *lambda = obstacle.unwrap_or(*lambda));
        // Step 1: each body answers to λ, imposed in some rows and unilateral in the others.
        let responses = self.step_1(&lambda)?;
        let answers = self.answers(&responses);
        // Step 2: the correction under the imbalance P¹ − P².
        let imbalance: Vec<f64> =
            answers.carried.iter().zip(&answers.unilateral).map(|(first, second)| first - second).collect();
        let direction = self.correction.apply(&imbalance);
        let eta_nndd = self.eta_nndd(&responses, &answers)?;
        let motions = self.motions(&responses);
        self.move_obstacles(&motions, &mut lambda);
        let iterate = self.iterate_of(eta_nndd, &lambda, (&responses, motions), answers);
        Ok(Pass { iterate, lambda, direction })
    }

    fn step_1(&mut self, lambda: &[f64]) -> Result<Vec<Response>, NnddError> {
        let respond = |b: usize| {
            let body = &self.bodies[b];
            let bound = |(carrier, row): (&Carrier, &usize)| match carrier {
                Carrier::Itself => lambda[*row],
                Carrier::Other | Carrier::Obstacle => self.gaps[*row] - lambda[*row],
            };
            let traces = DVector::from_iterator(body.len(), body.carriers.iter().zip(&body.rows).map(bound));
            match &self.programmes[b] {
                None => Ok(imposed(body, &traces)),
                Some(programme) => programme.solve(body, &traces, self.places[b].as_deref(), self.qp),
            }
        };
        let responses: Vec<Response> = try_each_body(self.bodies.len(), respond)?;
        self.places = responses.iter().map(|response| Some(response.places.clone())).collect();
        Ok(responses)
    }

    fn answers(&self, responses: &[Response]) -> Answers {
        let rows = self.gaps.len();
        let mut found = Answers {
            carried: vec![0.0; rows],
            unilateral: vec![0.0; rows],
            opening: vec![0.0; rows],
            active: vec![false; rows],
        };
        for (body, response) in self.bodies.iter().zip(responses) {
            for (i, &row) in body.rows.iter().enumerate() {
                if body.carriers[i] != Carrier::Other {
                    found.carried[row] = response.force[i];
                }
                if body.carriers[i] != Carrier::Itself {
                    found.unilateral[row] = response.force[i];
                    found.opening[row] = response.opening[i];
                    found.active[row] = response.places[i] == Place::Free;
                }
            }
        }
        found
    }

    /// Computes `η² = Σ_α (P̃ − P^α)ᵀ Φ_α (P̃ − P^α) + 2 P̃ᵀ o` with the forces `P̃ ≥ 0` in balance that are
    /// nearest, as pressures, to those of the unilateral bodies; infinite if no forces are in balance. Friction adds
    /// `2 Σ (S|w| − Q̃ w)`, with `|Q̃| ≤ S`.
    fn eta_nndd(&self, responses: &[Response], answers: &Answers) -> Result<f64, NnddError> {
        let Answers { unilateral, opening, .. } = answers;
        let loaded: Vec<bool> = unilateral.iter().map(|p| *p > 0.0).collect();
        let [lower, upper] = &self.bounds;
        let nearest = |allowed: Option<&[bool]>| {
            let open = |i: usize| allowed.is_some_and(|allowed| !allowed[i] && !self.rows.is_tangential(i));
            let upper: Vec<f64> =
                upper.iter().enumerate().map(|(i, u)| if open(i) { 0.0 } else { *u }).collect();
            let (lines, loads) = &self.lines;
            nearest_balanced(unilateral, &self.weights, [lower, &upper], lines, loads)
        };
        let distance = |forces: &[f64]| -> f64 {
            let change = forces.iter().zip(unilateral).zip(&self.weights);
            change.map(|((a, b), weight)| weight * (a - b) * (a - b)).sum()
        };
        let size = distance(&vec![0.0; unilateral.len()]);
        // Forces in open rows do work there, even the smallest: they appear only if the loaded rows are far from balance.
        let found = match nearest(Some(&loaded))? {
            Some(found) if distance(&found.values) <= NEARLY * size => Some(found),
            far => nearest(None)?.or(far),
        };
        let Some(forces) = found.map(|found| found.values) else { return Ok(f64::INFINITY) };
        let squares = each_body(self.bodies.len(), |b| {
            let body = &self.bodies[b];
            let change = body.gather(&forces) - DVector::from_column_slice(&responses[b].force);
            change.dot(&body.flexibility(&change))
        });
        let work = dot(&forces, opening) + self.sliding(opening);
        Ok(from_squared(squares.iter().sum::<f64>() + 2.0 * work))
    }

    /// Computes `Σ S|w|`, J/m.
    fn sliding(&self, opening: &[f64]) -> f64 {
        let limits = self.rows.tangentials(self.rows.limits());
        self.rows.tangentials(opening).iter().zip(limits).map(|(y, limit)| limit * y.abs()).sum()
    }

    fn iterate_of(
        &self,
        eta_nndd: f64,
        lambda: &[f64],
        (responses, motions): (&[Response], Vec<(usize, RigidMotion, f64)>),
        answers: Answers,
    ) -> Iterate {
        let rows = self.rows;
        let reaction: Vec<f64> = answers.carried.iter().map(|p| 0.0 - p).collect();
        let tangential = Tangential {
            lambda: rows.tangentials(lambda),
            reaction: rows.tangentials(&reaction),
            force: rows.tangentials(&answers.unilateral),
            slip: rows.tangentials(&answers.opening).iter().map(|y| 0.0 - y).collect(),
            limit: rows.tangentials(rows.limits()),
        };
        let (lambda, reaction) = (rows.normals(lambda), rows.normals(&reaction));
        let [force, opening] = [&answers.unilateral, &answers.opening].map(|values| rows.normals(values));
        let pairs = self.problem.problem().contacts.iter().flat_map(|pair| pair.interface.pairs());
        let gaps = rows.normals(&self.gaps);
        let bound: Vec<f64> = lambda.iter().zip(gaps).map(|(l, g)| l - g).collect();
        let unsolved = responses.iter().map(|r| r.status).find(|status| !status.is_solved());
        let contact = ContactAnswer {
            normal_trace: add(&bound, &opening),
            active: ActiveSet::new(rows.normals(&answers.active)),
            status: unsolved.unwrap_or(QpStatus::Solved),
            path: slowest(responses),
            iterations: responses.iter().map(|r| r.iterations).max().unwrap_or(0),
            clarabel_calls: responses.iter().map(|r| r.clarabel_calls).sum(),
            kkt: exact::residuals(&worst(responses)),
            normal_reaction: force,
        };
        Iterate {
            iteration: 0,
            theta: 0.0,
            precision: precision(pairs, &reaction, &contact.normal_reaction),
            eta_nndd,
            lambda,
            reaction,
            opening,
            programme: Programme { path: contact.path, iterations: contact.iterations },
            contact,
            recovery: Recovery::Forces,
            motions,
            tangential,
        }
    }

    /// Returns the rigid motions of all bodies and obstacles, and by how much.
    fn motions(&self, responses: &[Response]) -> Vec<(usize, RigidMotion, f64)> {
        let all = self.problem.rigid_motions();
        let mut motions: Vec<_> = all.iter().map(|of| (of.body, of.motion, 0.0)).collect();
        for (body, response) in self.bodies.iter().zip(responses) {
            for (number, amount) in body.balanced.amounts(&response.motion) {
                motions[number].2 = amount;
            }
        }
        motions
    }

    /// Adds the free motions of the obstacles to their λ.
    fn move_obstacles(&self, motions: &[(usize, RigidMotion, f64)], lambda: &mut [f64]) {
        let mut start = 0;
        for pair in &self.problem.problem().contacts {
            for (_, motion, amount) in
                motions.iter().filter(|of| of.0 == pair.bodies[1] && of.0 >= self.bodies.len())
            {
                let moved = self.problem.moved_by(&BodyMotion::new(pair.bodies[1], *motion));
                let rows = lambda[start..start + pair.row_count()].iter_mut().zip(pair.rows());
                rows.for_each(|(l, row)| *l -= amount * moved[row.nodes[1]].dot(&row.direction));
            }
            start += pair.row_count();
        }
    }
}

/// Returns the slowest method that solved the programme of a body.
fn slowest(responses: &[Response]) -> QpPath {
    let any = |path: QpPath| responses.iter().any(|r| r.path == path).then_some(path);
    any(QpPath::Clarabel).or(any(QpPath::ActiveSet)).unwrap_or(QpPath::WarmStart)
}

/// Returns the largest residuals of the programmes of all bodies.
fn worst(responses: &[Response]) -> BoxResiduals {
    responses.iter().fold(BoxResiduals::default(), |worst, Response { kkt, .. }| {
        let mut next = worst;
        next.stationarity = worst.stationarity.max(kkt.stationarity);
        next.rows = worst.rows.max(kkt.rows);
        next.primal = worst.primal.max(kkt.primal);
        next.dual = worst.dual.max(kkt.dual);
        next.complementarity = worst.complementarity.max(kkt.complementarity);
        next
    })
}

//! The true error of a coarse solution, enclosed by a finer one whose own certified error is known.
//!
//! The finer solution `u_f` is on meshes made from the coarse ones by bisection, so the coarse field `v` lies in its
//! space, and both problems have the same data. With its stress `τ_f`, its pressure `p_f` and its bound `e_f`,
//! ```text
//! ‖u − v‖² = ‖u_f − v‖² + ‖u − u_f‖² + 2 C + 2 Y,      C = −(σ(u_f) − σ̂_f, ε(u_f − v))
//! Y = −∫ (p − p_f)(o_v − o_f) ds = (σ − τ_f, ε(w))     for every w with the jump o_v − o_f on Γ_C, zero on Γ_D
//! ```
//! since `τ_f` and `σ` are in equilibrium with the same loads, and `τ_f − σ̂_f` is orthogonal to FE strains. With
//! `‖u − u_f‖² + ‖σ − τ_f‖² ≤ e_f²` and the `w` of least energy this encloses the error nearly to the second order of
//! `e_f/‖u − v‖`; the triangle inequality `‖u_f − v‖ ± e_f` would do so to the first order only.

use crate::model::{ContactProblem, Made, TriMesh, Vector};
use crate::run::prepare;
use certified_contact::{AdaptSettings, CertifiedSolution, Settings, Silent, solve_adaptively};
use cre_estimator::Estimate;
use fem_core::field::stresses;
use fem_core::geometry::{bounding_box, norm, signed_area};
use fem_core::prepared::PreparedProblem;

/// A finer solution, ready to measure fields on the coarse meshes it was refined from.
pub struct Overkill {
    coarse: ContactProblem,
    fine: CertifiedSolution,
    prepared: PreparedProblem,
    /// Coarse triangle of each fine one.
    parents: [Vec<u32>; 2],
    /// Two coarse pairs of each fine one and the weight of the second.
    pairs: Vec<(usize, usize, f64)>,
}

impl Overkill {
    /// Refines a problem until its certified relative error is at most `target`.
    ///
    /// * `coarse`: in the roles of the iteration, index 0 carrying λ; straight interface, data linear on each edge.
    ///
    /// # Errors
    /// The problem cannot be solved, or the target is not met with at most 400 000 nodes.
    pub fn new(coarse: ContactProblem, target: f64) -> Made<Self> {
        let mut settings = Settings::default();
        settings.imposed = certified_contact::Imposed::First;
        let mut adapt = AdaptSettings::new(target);
        adapt.max_nodes = 400_000;
        let answer = solve_adaptively(coarse.clone(), &settings, &adapt, &mut Silent)?;
        let fine = answer.solution;
        if !fine.is_certified() || fine.relative().is_none_or(|r| r > target) {
            return Err(format!("the finer solution is not certified to {target}: {:?}", answer.end).into());
        }
        let prepared = prepare(&fine.problem);
        let meshes = |p: &ContactProblem, b: usize| p.bodies[b].mesh().clone();
        let mut parents = [vec![], vec![]];
        for (b, found) in parents.iter_mut().enumerate() {
            *found = parents_of(&meshes(&fine.problem, b), &meshes(&coarse, b))?;
        }
        let pairs = pairs_of(&fine.problem, &coarse);
        Ok(Self { coarse, fine, prepared, parents, pairs })
    }

    /// Returns the finer solution's estimate.
    ///
    /// # Errors
    /// None: [`Self::new`] makes sure that there is one.
    fn estimate(&self) -> Made<&Estimate> {
        self.fine.estimate.as_ref().ok_or_else(|| "the finer solution has no estimate".into())
    }

    /// Returns the certified relative error of the finer solution.
    pub fn relative(&self) -> f64 {
        self.fine.relative().unwrap_or(f64::NAN)
    }

    /// Counts its nodes.
    pub fn nodes(&self) -> usize {
        self.fine.problem.bodies.iter().map(|b| b.mesh().points().len()).sum()
    }

    /// Encloses `‖u − v‖`, u the exact solution.
    ///
    /// * `v`: displacements on the coarse meshes; `opening`: theirs at each coarse pair.
    ///
    /// # Errors
    /// None, for arrays of the right length.
    pub fn error(&self, v: [&[Vector]; 2], opening: &[f64]) -> Made<[f64; 2]> {
        let estimate = self.estimate()?;
        let e_f = estimate.unchecked().e_cre;
        // ‖u_f − v‖² and C, triangle by triangle of the finer mesh.
        let (mut distance, mut defect) = (0.0, 0.0);
        for (b, displacement) in v.into_iter().enumerate() {
            let body = &self.fine.problem.bodies[b];
            let coarse = stresses(&self.coarse.bodies[b], displacement);
            let balanced = &estimate.pair.bodies[b].equilibrated.finite_element;
            for (t, &parent) in self.parents[b].iter().enumerate() {
                let own = estimate.pair.bodies[b].stress[t];
                let d = own.minus(coarse[parent as usize]);
                let (area, material) = (body.mesh().measure(t), body.material(t));
                distance += area * material.complementary(d, d);
                defect -= area * material.complementary(own.minus(balanced[t]), d);
            }
        }
        let middle = distance + 2.0 * defect;
        let spread = 2.0 * e_f * self.extension(opening, &estimate.pair.contacts[0].opening);
        let triangle = [distance.sqrt() - e_f, distance.sqrt() + e_f].map(|x| x.max(0.0));
        let low = (middle - spread).max(0.0).sqrt().max(triangle[0]);
        let high = (middle + spread + e_f * e_f).max(0.0).sqrt().min(triangle[1]);
        Ok([low, high])
    }

    /// Computes the energy norm of an extension of the jump `o_v − o_f`, shared between the bodies so that it is small.
    fn extension(&self, coarse: &[f64], fine: &[f64]) -> f64 {
        let jump: Vec<f64> = (self.pairs.iter().zip(fine))
            .map(|((i, j, s), o_f)| (1.0 - s) * coarse[*i] + s * coarse[*j] - o_f)
            .collect();
        let energy = |b: usize| {
            let Some(body) = self.prepared.bodies()[b].whole() else { return 0.0 };
            let mut force = vec![0.0; jump.len()];
            body.interface().apply_schur(&jump, &mut force);
            force.iter().zip(&jump).map(|(f, d)| f * d).sum::<f64>().max(0.0)
        };
        // A share t of the jump in the one body and 1 − t in the other: the least of t²a + (1 − t)²b.
        let [a, b] = [0, 1].map(energy);
        if a + b > 0.0 { (a * b / (a + b)).sqrt() } else { 0.0 }
    }
}

/// Finds the coarse triangle in which each fine one lies, by its centroid.
fn parents_of(fine: &TriMesh, coarse: &TriMesh) -> Made<Vec<u32>> {
    let [low, high] = bounding_box(coarse.points());
    let bins = ((coarse.cells().len() as f64 / 2.0).sqrt().ceil() as usize).max(1);
    let bin = |x: f64, c: usize| {
        let part = (x - low[c]) / (high[c] - low[c]) * bins as f64;
        (part.max(0.0) as usize).min(bins - 1)
    };
    let mut inside: Vec<Vec<u32>> = vec![vec![]; bins * bins];
    for t in 0..coarse.cells().len() {
        let [a, b] = bounding_box(&coarse.corners(t));
        for i in bin(a[0], 0)..=bin(b[0], 0) {
            for j in bin(a[1], 1)..=bin(b[1], 1) {
                inside[i * bins + j].push(t as u32);
            }
        }
    }
    let holds = |t: u32, x: Vector| {
        let c = coarse.corners(t as usize);
        (0..3).all(|k| signed_area([c[k], c[(k + 1) % 3], x]) > 0.0)
    };
    let parent = |t: usize| {
        let c = fine.corners(t);
        let x = (c[0] + c[1] + c[2]) / 3.0;
        let found = inside[bin(x[0], 0) * bins + bin(x[1], 1)].iter().find(|&&t| holds(t, x));
        found.copied().ok_or_else(|| format!("no coarse triangle holds {x:?}").into())
    };
    (0..fine.cells().len()).map(parent).collect()
}

/// Finds the coarse contact edge on which each fine pair lies.
fn pairs_of(fine: &ContactProblem, coarse: &ContactProblem) -> Vec<(usize, usize, f64)> {
    let at = |p: &ContactProblem, k: usize| {
        p.bodies[0].mesh().points()[p.contacts[0].interface.pairs()[k].nodes[0]]
    };
    let on = |x: Vector| {
        let candidates = coarse.contacts[0].interface.facets().iter().map(|edge| {
            let [i, j] = edge.pairs.map(|k| k as usize);
            let [to_i, to_j] = [i, j].map(|k| norm(at(coarse, k) - x));
            (to_i + to_j - edge.measure, (i, j, to_i / (to_i + to_j)))
        });
        candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map_or((0, 0, 0.0), |(_, found)| found)
    };
    (0..fine.contacts[0].interface.pairs().len()).map(|k| on(at(fine, k))).collect()
}

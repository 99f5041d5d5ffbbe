//! Effects of rounding on forces, strains and energies: the scale below which the checks detect nothing, and the
//! allowance of the bound for it.

use crate::admissible::{AdmissibleContact, AdmissiblePair, pressure_forces};
use crate::equilibrated::EquilibratedStress;
use crate::lift;
use crate::measures::{Accuracy, CellMeasures, Shape};
use crate::recovery::Recovery;
use crate::size::{larger, largest_displacement};
use fem_core::body::Body;
use fem_core::double_double::PreciseVector;
use fem_core::each_body;
use fem_core::field;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactInterface, ContactProblem};
use fem_core::mesh::id::NodeId;
use fem_core::parallel::each_task;
use fem_core::residual;
use fem_core::space::Matrix;
use neumann_neumann::{BodySolver, BodySolvers};

/// Rounding errors of a strain, in units of ε: of one term `u ∇φ` of its sum.
///
/// The displacements come from two triangular solves. Their rounding leaves a nodal imbalance
/// `|R_i| ≤ γ (|L||Lᵀ||u|)_i` (Higham 2002, theorem 10.4), where the roundings of one row add up like a random walk: since
/// `Σ_j L_ij² = K_ii`, that is a few ε of `√(K_ii K_jj)|u|`, whatever the condition of K and the length of the row. EET
/// passes the imbalance of a vertex on around its star and uses end values `4 b_a − 2 b_b` of the moments: a
/// factor 6. Measured on bodies moved without strain, 4 to 16,000 cells: 2 to 9 in total, growing with the depth of the
/// elimination. The remainder is margin. In flat triangles the errors are larger, in proportion to
/// [`Shape::flatness`], by which the bounds below are multiplied: cells 5 to 200 times as long as high have 2 to 4
/// times their flatness.
const STRAIN_ROUNDINGS: f64 = 32.0;

/// Bounds the relative error of each term of a strain by rounding alone.
const STRAIN_NOISE: f64 = STRAIN_ROUNDINGS * f64::EPSILON;

/// Triangles of one task. Fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// Effects of rounding of a body's displacements, per metre of the largest displacement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Of [`Self::force`], N/m².
    force: f64,
    /// Of [`Self::energy`], square root of J/m³.
    energy: f64,
}

impl Noise {
    /// Computes them from the triangles of a body.
    pub(crate) fn of<S: Recovery>(body: &Body<S>) -> Self {
        let (triangles, dim) = (body.mesh().cells().len(), S::DIM as f64);
        let chunks = each_task(triangles.div_ceil(CHUNK), |k| {
            let (mut force, mut energy) = (0.0, 0.0);
            for t in k * CHUNK..triangles.min((k + 1) * CHUNK) {
                let measure = body.mesh().measure(t);
                let Shape { boundary, largest, flatness } = S::shape(&body.mesh().corners(t), measure);
                let traction = body.material(t).stiffness().largest() * boundary;
                force = larger(force, traction * largest / (dim * measure) * flatness);
                // No partial product is much larger or smaller than the result.
                energy += traction * softness(body, t) * traction / (dim * dim * measure) * flatness.powi(3);
            }
            (force, energy)
        });
        let force = chunks.iter().fold(0.0, |m, (force, _)| larger(m, *force));
        let energy: f64 = chunks.iter().map(|(_, energy)| energy).sum();
        let spread = 1.0 + (triangles as f64).ln();
        Self { force: STRAIN_NOISE * force, energy: STRAIN_NOISE * (spread * energy).sqrt() }
    }

    /// [`Self::of`] each body of a problem.
    pub(crate) fn of_bodies<S: Recovery>(problem: &ContactProblem<S>) -> Vec<Self> {
        problem.bodies.iter().map(Self::of).collect()
    }

    /// Computes the edge forces that rounding of the displacements causes, N/m: a body that is moved without strain
    /// has no other forces. `δ C |u| Σ|∇φ|` of stress on the longest edge of a triangle, with `Σ|∇φ|` its perimeter over
    /// twice its area, times its flatness.
    pub(crate) fn force<V: Coordinates>(self, displacement: &[V]) -> f64 {
        largest_displacement(displacement) * self.force
    }

    /// Bounds the energy norm of the error that rounding of the displacements may hide in a body's bound, square root of
    /// J/m.
    ///
    /// A stress that violates equilibrium by `R` gives a bound up to `√(Rᵀ K⁻¹ R)`. For independent `R_i` of the size of
    /// [`Self::force`] the expected square is their sum over the diagonal of `K⁻¹`: in the plane `(1 + ln N)` times the
    /// contribution of each triangle alone, `(δ C |u| Σ|∇φ|)² A tr C⁻¹`: forces as large as the stiffest direction makes
    /// them, on the softest one, which matters if a material is nearly incompressible. In flat triangles the `R_i` are
    /// larger by the flatness, and their squares by the flatness over the diagonal of `K` that goes with the area: its
    /// third power in all.
    fn energy<V: Coordinates>(self, displacement: &[V]) -> f64 {
        largest_displacement(displacement) * self.energy
    }
}

/// Computes the trace of the compliance in a cell, 1/Pa: at least the compliance of the softest direction.
fn softness<S: Recovery>(body: &Body<S>, cell: usize) -> f64 {
    let unit = |component: usize| {
        let s = S::components(|k| if k == component { 1.0 } else { 0.0 }).into();
        body.material(cell).complementary(s, s)
    };
    (1..S::COMPONENTS).fold(unit(0), |sum, component| sum + unit(component))
}

/// Safety factor on measured rounding: the factorised matrix is the stiffness only to its own rounding, and
/// jumps of the stress between the nodes are not included.
const MARGIN: f64 = 2.0;

/// Computes the residual of the FE equilibrium of each body's equilibrated stress, along its unknowns, N/m. The bound contains
/// `2 √(Rᵀ K⁻¹ R)` (27), square root of J/m.
pub(crate) fn residuals<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    pair: &AdmissiblePair<S>,
    cells: &[CellMeasures<S>],
    accuracy: Accuracy,
) -> Vec<Vec<f64>> {
    let (problem, bodies) = (solvers.problem(), solvers.bodies());
    let of_body = |b: usize| {
        let forces = pressure_forces(problem, b, &pair.contacts);
        stress_residual(
            &problem.bodies[b],
            &bodies[b],
            (&pair.bodies[b].equilibrated, &cells[b], accuracy),
            forces,
        )
    };
    each_body(problem.bodies.len(), of_body)
}

/// Computes `R_i = ∫ τ : ε(φ_i) − f(φ_i)` of a measured stress under the body's loads and further nodal forces, along the unknowns, N/m: from the
/// stress itself, in double-double numbers if the solves were refined, and before that in double precision, whose own rounding
/// makes it larger.
pub(crate) fn stress_residual<S: Recovery>(
    body: &Body<S>,
    solver: &BodySolver<'_, S>,
    (stress, cells, accuracy): (&EquilibratedStress<S>, &CellMeasures<S>, Accuracy),
    mut forces: Vec<(NodeId, S::Vector)>,
) -> Vec<f64> {
    forces.extend(stress.spring_forces(body));
    match accuracy {
        Accuracy::Double => {
            let residual = field::stress_residual(body, &cells.mean);
            solver.rough_along_unknowns(&less_rough::<S>(residual, &forces))
        }
        Accuracy::Refined => {
            let residual = residual::of_stress(body, &cells.exact_mean);
            solver.along_unknowns(&less::<S>(residual, &forces))
        }
    }
}

/// Subtracts nodal forces from a residual.
pub(crate) fn less<S: Recovery>(
    mut residual: Vec<PreciseVector<S>>,
    forces: &[(NodeId, S::Vector)],
) -> Vec<PreciseVector<S>> {
    for &(node, force) in forces {
        let r = &mut residual[node];
        *r = S::axes(|c| r[c] + -force[c]);
    }
    residual
}

/// [`less`] in double precision.
pub(crate) fn less_rough<S: Recovery>(
    mut residual: Vec<S::Vector>,
    forces: &[(NodeId, S::Vector)],
) -> Vec<S::Vector> {
    for &(node, force) in forces {
        residual[node] -= force;
    }
    residual
}

/// Models the rounding in each body, see [`Noise::energy`].
pub(crate) fn model<S: Recovery>(noise: &[Noise], pair: &AdmissiblePair<S>) -> Vec<f64> {
    noise.iter().zip(&pair.bodies).map(|(noise, fields)| noise.energy(&fields.displacement)).collect()
}

/// Bounds the amount by which round-off may have lowered `e_CRE`, so that the printed number is still a bound:
/// rounding of the stresses, of the energies, and the work of the pressure on openings that are negative by less
/// than the tolerance of the checks.
///
/// * `energy`: of all bodies, J/m.
/// * `noise`: for each body [`model`] and `√(Rᵀ K⁻¹ R)` of [`residuals`]. The larger one is used.
pub(crate) fn allowance<'a, S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &AdmissiblePair<S>,
    energy: f64,
    noise: impl Iterator<Item = (f64, &'a f64)>,
) -> f64 {
    let contacts = problem.contacts.iter().zip(&pair.contacts);
    let penetration: f64 = contacts.map(|(of, contact)| work_of_penetration(&of.interface, contact)).sum();
    let of_energies = 64.0 * f64::EPSILON * energy.sqrt();
    noise.fold(of_energies, |sum, (model, residual)| sum + larger(model, MARGIN * residual))
        + (2.0 * penetration).sqrt()
}

/// Computes the work of the pressure on openings that are negative, J/m.
fn work_of_penetration<S: Recovery>(interface: &ContactInterface<S>, contact: &AdmissibleContact<S>) -> f64 {
    let pairs = interface.pairs().iter().zip(&contact.opening).zip(&contact.pressure);
    let at_pairs: f64 = pairs.map(|((of, o), p)| (-o).max(0.0) * p.abs() * of.weight).sum();
    let facets = lift::with_middles(interface, &contact.middle_opening).zip(&contact.edge_pressure);
    let between: f64 = facets
        .filter(|((facet, _), _)| facet.bent)
        .map(|((facet, middle), p)| {
            S::depth(&facet.openings(&contact.opening), middle).max(0.0) * p[0].abs() * facet.measure
        })
        .sum();
    at_pairs + between
}

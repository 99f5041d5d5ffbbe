//! Stresses without loads that no star of the relaxation reaches, and the least distance over them.
//!
//! The stars span all stresses in equilibrium with zero loads only if the body has no hole and one support. A stress that passes a wrench from one
//! support to another, or around a hole, is missing: 3 for a hole and for each further clamped part in the plane, 6 in space, fewer for rollers. The
//! columns are EET stresses of FE fields without loads: the unit motions of a support, or a rigid jump across a cut from a hole to the outside. They
//! depend on the body alone. After the steps of the relaxation,
//! ```math
//! min_c ‖τ + ∑ c_k τ_k − σ̂‖²,   c_k = ⟨σ̂ − τ, τ_k⟩
//! ```
//! over columns that are orthonormal in the complementary norm.

mod cocycles;
mod jumps;
mod patches;
#[cfg(test)]
mod tests;

use crate::check::check_stress;
use crate::equilibrated::{EquilibratedStress, FacetMoments, add, cut_resultant, product};
use crate::recovery::{Recovery, StarMemory};
use crate::relaxation::{LEAST, ROUND_OFF, Relaxation, RelaxationReport};
use crate::springs::released;
use cocycles::Sets;
use fem_core::assembly::System;
use fem_core::body::{Body, Cut, FacetCondition, FacetSprings};
use fem_core::condensation::CondensedBody;
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::interface::InterfaceSide;
use fem_core::mesh::Mesh;
use fem_core::parallel::each_task;
use fem_core::space::Space;
use jumps::Jumps;
use nalgebra::{DMatrix, DVector};
use neumann_neumann::BodySolver;

/// Columns whose share in others is larger than 1 minus this are not independent.
const DEPENDENT: f64 = 1e-8;

/// A resultant below this fraction of its terms is rounding.
const NO_RESULTANT: f64 = 1e-12;

/// A relaxation to a tolerance leaves columns out if they can be expected to gain less than this fraction of the tolerance.
const SHARE: f64 = 0.25;

/// The columns of a body, each made when it is needed for the first time.
#[derive(Debug, Default)]
pub(crate) struct Columns<S: Space> {
    jumps: Option<Jumps<S>>,
    /// Facet moments, orthonormal in the complementary norm.
    moments: Option<Vec<FacetMoments<S>>>,
    /// True if stars of their own compute their coefficients again, see [`StarMemory`].
    pub(crate) recomputes: bool,
}

/// Counts the holes of a mesh, in space those that go through: from its boundary alone.
pub(crate) fn holes<S: Recovery>(mesh: &Mesh<S>) -> usize {
    let topology = mesh.topology();
    let mut sets = Sets::new(mesh.points().len());
    let mut on_boundary = vec![false; mesh.points().len()];
    let (mut nodes, mut parts) = (0, 0);
    for facet in topology.boundary_facets() {
        let corners = topology.facets()[*facet];
        for node in corners {
            let new = !std::mem::replace(&mut on_boundary[node], true);
            nodes += usize::from(new);
            parts += usize::from(new);
            parts -= usize::from(sets.join(corners[0].index(), node.index()));
        }
    }
    S::holes([nodes, topology.boundary_facets().len()], parts, topology.pieces().1)
}

impl<S: Recovery> Columns<S> {
    /// Returns how far the steps before the columns go: in a body with columns to half of the tolerance, since the columns may be left out.
    pub(crate) fn leave_room(&mut self, body: &Body<S>, relaxation: Relaxation) -> Relaxation {
        match relaxation {
            Relaxation::Tolerance { tolerance, max_steps } if self.jumps(body).len() > 0 => {
                Relaxation::Tolerance { tolerance: 0.5 * tolerance, max_steps }
            }
            other => other,
        }
    }

    /// Finds the jumps of a body when they are needed for the first time.
    fn jumps(&mut self, body: &Body<S>) -> &Jumps<S> {
        self.jumps.get_or_insert_with(|| Jumps::new(body, holes(body.mesh()) > 0))
    }

    /// Lowers `‖τ − σ̂‖` in place after the last step of a relaxation, and the last entry of its record. It changes nothing in a body on one support
    /// without a hole, or if there was to be no step.
    ///
    /// If columns have the relative error of the stress itself, they gain at most its square for each column. A relaxation to a tolerance leaves
    /// them out if that is little.
    ///
    /// * `factor`: of the free body; `None`: it is factorised if there is a column.
    /// * `stars`: of the body, prepared for the reactions of its own conditions or of the stress.
    pub(crate) fn lower<'a>(
        &mut self,
        (body, factor): (&'a Body<S>, Option<&BodySolver<'_, S>>),
        (stress, report): (&mut EquilibratedStress<S>, &mut RelaxationReport),
        relaxation: Relaxation,
        stars: &mut Option<S::Stars<'a>>,
    ) {
        if relaxation.max_steps() == 0 {
            return;
        }
        let count = self.jumps(body).len();
        let Some(jumps) = self.jumps.as_ref().filter(|_| count > 0) else { return };
        let before = stress.distance_squared(body);
        let whole = product(body, &stress.finite_element, &stress.finite_element);
        if !(before > ROUND_OFF * whole) {
            return;
        }
        if let Relaxation::Tolerance { tolerance, .. } = relaxation
            && 0.5 * count as f64 * before < SHARE * tolerance * whole
        {
            return;
        }
        let recomputes = self.recomputes;
        let make = || make((body, factor), jumps, relaxation, (stars, recomputes)).unwrap_or_default();
        let moments = self.moments.get_or_insert_with(make);
        if let Some(after) = minimise(body, stress, moments, before) {
            report.columns = moments.len();
            if let Some(last) = report.energy_history.last_mut() {
                *last = last.min(after);
            }
        }
    }
}

/// Relaxes an equilibrated stress in place: steps of
/// ```math
/// min_φ ‖τ_EET + R ∇²φ Rᵀ − σ̂‖²,   φ of Hsieh, Clough and Tocher     (21)
/// ```
/// in the plane, and in space with bars and wrenches instead of `φ`; then the minimum over the few stresses that no step reaches, if the body has
/// holes or several supports. For these the body is factorised.
///
/// * `stress`: as recovered by EET; on return with the facet moments of the last iterate, in exact equilibrium
///   with the same loads and given tractions.
///
/// If no reduction is possible (a body at rest, a uniform stress), it is not changed. To relax several stresses of
/// one body of the plane under the same kind of conditions, prepare a [`crate::StarRelaxation`] once.
pub fn relax<S: Recovery>(
    body: &Body<S>,
    stress: &mut EquilibratedStress<S>,
    relaxation: Relaxation,
) -> RelaxationReport {
    relax_body((body, None), stress, relaxation)
}

/// [`relax`] of a body whose factor is known.
pub(crate) fn relax_body<S: Recovery>(
    (body, factor): (&Body<S>, Option<&BodySolver<'_, S>>),
    stress: &mut EquilibratedStress<S>,
    relaxation: Relaxation,
) -> RelaxationReport {
    let (mut stars, mut columns) = (None, Columns::default());
    let mut report = S::relax_with(
        body,
        stress,
        columns.leave_room(body, relaxation),
        &mut stars,
        StarMemory::Stored(None),
    );
    columns.lower((body, factor), (stress, &mut report), relaxation, &mut stars);
    report
}

/// Makes the columns of jumps, as many as are independent; `None` if the body cannot be factorised.
fn make<'a, S: Recovery>(
    (body, factor): (&'a Body<S>, Option<&BodySolver<'_, S>>),
    jumps: &Jumps<S>,
    relaxation: Relaxation,
    (stars, recomputes): (&mut Option<S::Stars<'a>>, bool),
) -> Option<Vec<FacetMoments<S>>> {
    let fields = match factor {
        Some(factor) => each_task(jumps.len(), |k| field(body, factor, jumps, k)),
        None => {
            let own = factorised(body)?;
            each_task(jumps.len(), |k| field(body, &BodySolver::Whole(&own), jumps, k))
        }
    };
    let fields = orthonormal_fields(body, &fields);
    let conditions: Vec<_> = body.facet_conditions().iter().map(unloaded).collect();
    let relaxation = match relaxation {
        Relaxation::Tolerance { .. } => Relaxation::Steps(LEAST),
        fixed => fixed,
    };
    let recover = |body: &Body<S>, field: Field<S>| {
        let conditions = released(body, conditions.clone(), &[&field.moved]);
        EquilibratedStress::recover(body, field.stress, conditions)
    };
    if !body.has_force() && !body.has_initial_strain() {
        let relaxed = fields.into_iter().map(|field| {
            let mut column = recover(body, field);
            S::relax_with(body, &mut column, relaxation, stars, StarMemory::Stored(None));
            column
        });
        return Some(keeping_cut_forces(body, orthonormal(body, relaxed.collect())));
    }
    let whole = body;
    let (body, mut stars) = (body.weightless(), None);
    let mut columns: Vec<_> = fields.into_iter().map(|field| recover(&body, field)).collect();
    for column in &mut columns {
        S::relax_with(&body, column, relaxation, &mut stars, StarMemory::new(recomputes, None));
    }
    Some(keeping_cut_forces(whole, orthonormal(&body, columns)))
}

/// Combines orthonormal columns to those that do not change the given forces in cuts.
fn keeping_cut_forces<S: Recovery>(body: &Body<S>, columns: Vec<FacetMoments<S>>) -> Vec<FacetMoments<S>> {
    let cuts: Vec<&Cut<S>> = body.cuts().iter().filter(|cut| cut.force.is_some()).collect();
    if cuts.is_empty() || columns.is_empty() {
        return columns;
    }
    let resultant = |i: usize, k: usize| {
        let [sum, size] = cut_resultant(body, cuts[i], &columns[k]);
        if sum.abs() > NO_RESULTANT * size { sum } else { 0.0 }
    };
    let mut resultants = DMatrix::from_fn(cuts.len(), columns.len(), resultant);
    // Each cut counts alike: eigenvalues are squares, and those of a small force must not be taken for rounding.
    for mut row in resultants.row_iter_mut().filter(|row| row.amax() > 0.0) {
        row /= row.amax();
    }
    let eigen = (resultants.transpose() * &resultants).symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let kept = (0..columns.len()).filter(|k| eigen.eigenvalues[*k] <= NO_RESULTANT * largest);
    let combined = |k: usize| {
        let mut sum = vec![S::ZEROS; columns[0].len()];
        let factors = eigen.eigenvectors.column(k);
        factors.iter().zip(&columns).for_each(|(factor, column)| add::<S>(&mut sum, *factor, column));
        sum
    };
    kept.map(combined).collect()
}

/// Returns a condition without a load, with its springs relaxed.
fn unloaded<S: Space>(of: &FacetCondition<S>) -> FacetCondition<S> {
    let springs = FacetSprings { stretch: S::ZEROS, ..of.springs };
    FacetCondition { traction: S::ZEROS, springs, ..*of }
}

/// Combines columns in equilibrium to orthonormal ones, as many as are independent.
///
/// * `body`: without a body force.
fn orthonormal<S: Recovery>(body: &Body<S>, mut columns: Vec<EquilibratedStress<S>>) -> Vec<FacetMoments<S>> {
    columns.retain(|column| check_stress(body, column).is_valid());
    let mut work = match columns.first() {
        Some(first) => EquilibratedStress {
            finite_element: vec![S::Tensor::default(); first.finite_element.len()],
            conditions: first.conditions.iter().map(unloaded).collect(),
            ..first.clone()
        },
        None => return Vec::new(),
    };
    let moments: Vec<FacetMoments<S>> = columns.into_iter().map(|column| column.facet_moments).collect();
    let mut energy = |parts: [&FacetMoments<S>; 2]| {
        work.facet_moments.clone_from(parts[0]);
        add::<S>(&mut work.facet_moments, 1.0, parts[1]);
        work.distance_squared(body)
    };
    let count = moments.len();
    let sizes = moments.iter().map(|column| 0.25 * energy([column, column]));
    let mut gram = DMatrix::from_diagonal(&DVector::from_iterator(count, sizes));
    for (k, l) in (0..count).flat_map(|k| (0..k).map(move |l| (k, l))) {
        let product = 0.5 * (energy([&moments[k], &moments[l]]) - gram[(k, k)] - gram[(l, l)]);
        (gram[(k, l)], gram[(l, k)]) = (product, product);
    }
    let combined = |factors: Vec<f64>| {
        let mut sum = vec![S::ZEROS; moments[0].len()];
        factors.iter().zip(&moments).for_each(|(factor, column)| add::<S>(&mut sum, *factor, column));
        sum
    };
    inverse_roots(gram).into_iter().map(combined).collect()
}

/// Adds orthonormal columns to a stress so that its distance to the FE stress is least, and returns the distance²; `None` if it does not fall.
///
/// * `before`: the distance² at first.
fn minimise<S: Recovery>(
    body: &Body<S>,
    stress: &mut EquilibratedStress<S>,
    columns: &[FacetMoments<S>],
    before: f64,
) -> Option<f64> {
    let (given, size) = (stress.facet_moments.clone(), before.sqrt());
    let mut sum = given.clone();
    for column in columns {
        // ‖τ + s τ_k − σ̂‖² = ‖τ − σ̂‖² − 2 s c_k + s² with s = ‖τ − σ̂‖
        add::<S>(&mut stress.facet_moments, size, column);
        let factor = 0.5 * (2.0 * before - stress.distance_squared(body)) / size;
        add::<S>(&mut sum, factor, column);
        stress.facet_moments.clone_from(&given);
    }
    stress.facet_moments = sum;
    let after = stress.distance_squared(body);
    if after < before {
        return Some(after);
    }
    stress.facet_moments = given;
    None
}

/// Factorises a body without contact sides.
fn factorised<S: Space>(body: &Body<S>) -> Option<CondensedBody<S>> {
    let dofs = fem_core::dof::DofMap::new(body, &InterfaceSide::default());
    let system = System::stabilised(body, dofs).ok()?;
    CondensedBody::factorise(system, body.mesh().points()).ok()
}

/// An FE field without loads.
struct Field<S: Space> {
    /// The stress of each cell, Pa.
    stress: Vec<S::Tensor>,
    /// The displacement of each node beyond the jump, which stretches springs, m; empty without springs.
    moved: Vec<S::Vector>,
}

/// Computes the FE field of a jump without loads, per unit of the jump.
fn field<S: Space>(body: &Body<S>, factor: &BodySolver<'_, S>, jumps: &Jumps<S>, k: usize) -> Field<S> {
    let mesh = body.mesh();
    let elements: Vec<Element<S>> =
        (0..mesh.cells().len()).map(|cell| Element::new(mesh.corners(cell))).collect();
    let beyond: Vec<_> = (0..elements.len()).map(|cell| jumps.beyond_cuts(body, k, cell)).collect();
    let stresses = |displacement: &[S::Vector]| -> Vec<S::Tensor> {
        let of_cell = |cell: usize| {
            let nodes = mesh.cells()[cell];
            let moved = S::corners(|corner| displacement[nodes[corner]] + beyond[cell][corner]);
            body.material(cell).stress(elements[cell].strain(moved))
        };
        (0..elements.len()).map(of_cell).collect()
    };
    let mut displacement = jumps.imposed(body, k);
    let mut forces = vec![S::Vector::ZERO; mesh.points().len()];
    for ((stress, element), nodes) in stresses(&displacement).into_iter().zip(&elements).zip(mesh.cells()) {
        for corner in 0..=S::DIM {
            forces[nodes[corner]] -= S::applied(stress, element.gradients[corner]) * element.measure;
        }
    }
    let correction = factor.correction(factor.rough_along_unknowns(&forces));
    displacement.iter_mut().zip(&correction).for_each(|(sum, correction)| *sum += *correction);
    let moved = if body.springs().is_empty() { Vec::new() } else { correction };
    Field { stress: stresses(&displacement), moved }
}

/// Combines FE fields to ones with orthonormal stresses, as many as are independent.
fn orthonormal_fields<S: Space>(body: &Body<S>, fields: &[Field<S>]) -> Vec<Field<S>> {
    let entry = |k: usize, l: usize| product(body, &fields[k.max(l)].stress, &fields[k.min(l)].stress);
    let gram = DMatrix::from_fn(fields.len(), fields.len(), entry);
    let combined = |factors: Vec<f64>| {
        let at = |cell: usize| -> S::Tensor {
            let mut sum = S::components(|_| 0.0);
            for (factor, field) in factors.iter().zip(fields) {
                let part: S::Components<f64> = field.stress[cell].into();
                (0..S::COMPONENTS).for_each(|c| sum[c] += factor * part[c]);
            }
            sum.into()
        };
        let moved = |node: usize| {
            factors.iter().zip(fields).map(|(factor, field)| field.moved[node] * *factor).sum::<S::Vector>()
        };
        Field {
            stress: (0..body.mesh().cells().len()).map(at).collect(),
            moved: (0..fields[0].moved.len()).map(moved).collect(),
        }
    };
    inverse_roots(gram).into_iter().map(combined).collect()
}

/// Finds the factors of the combinations that make vectors with the given products orthonormal.
fn inverse_roots(mut gram: DMatrix<f64>) -> Vec<Vec<f64>> {
    let sizes: Vec<f64> = gram.diagonal().iter().map(|square| square.sqrt()).collect();
    let scale = |k: usize| if sizes[k] > 0.0 { 1.0 / sizes[k] } else { 0.0 };
    (0..gram.nrows()).for_each(|k| (0..gram.ncols()).for_each(|l| gram[(k, l)] *= scale(k) * scale(l)));
    if !gram.iter().all(|product| product.is_finite()) {
        return Vec::new();
    }
    let eigen = gram.symmetric_eigen();
    let independent = (0..sizes.len()).filter(|k| eigen.eigenvalues[*k] > DEPENDENT);
    let factor = |k: usize, l: usize| scale(l) * eigen.eigenvectors[(l, k)] / eigen.eigenvalues[k].sqrt();
    independent.map(|k| (0..sizes.len()).map(|l| factor(k, l)).collect()).collect()
}

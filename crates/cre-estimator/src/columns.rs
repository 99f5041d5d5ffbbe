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

use crate::check::{FORCE_TOLERANCE, check_stress};
use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::recovery::Recovery;
use crate::relaxation::{Relaxation, RelaxationReport};
use cocycles::Sets;
use fem_core::assembly::System;
use fem_core::body::{Body, FacetCondition};
use fem_core::condensation::CondensedBody;
use fem_core::element::Element;
use fem_core::geometry::Coordinates;
use fem_core::interface::InterfaceSide;
use fem_core::mesh::Mesh;
use fem_core::norm::sum_over_cells;
use fem_core::space::Space;
use jumps::Jumps;
use nalgebra::DMatrix;
use std::borrow::Cow;

/// Columns whose share in others is larger than 1 minus this are not independent.
const DEPENDENT: f64 = 1e-8;

/// The columns of a body: facet moments, orthonormal in the complementary norm.
#[derive(Clone, Debug)]
pub(crate) struct Columns<S: Space> {
    moments: Vec<FacetMoments<S>>,
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
    /// Makes the columns of a body; none if it has one support and no hole.
    ///
    /// * `factor`: of the body; `None`: it is factorised if there is a column. With contact sides it is the factor of the free body.
    /// * `stars`: of the body under its own conditions, with which columns are relaxed, too, unless it has a body force.
    pub(crate) fn new<'a>(
        body: &'a Body<S>,
        factor: Option<&CondensedBody<S>>,
        relaxation: Relaxation,
        stars: &mut Option<S::Stars<'a>>,
    ) -> Self {
        let none = Self { moments: Vec::new() };
        let jumps = Jumps::new(body, holes(body.mesh()) > 0);
        if jumps.len() == 0 {
            return none;
        }
        let factor = match factor {
            Some(factor) => Cow::Borrowed(factor),
            None => match factorised(body) {
                Some(factor) => Cow::Owned(factor),
                None => return none,
            },
        };
        let fields = orthonormal_fields(body, (0..jumps.len()).map(|k| field(body, &factor, &jumps, k)).collect());
        let conditions = || {
            let unloaded = |of: &FacetCondition<S>| FacetCondition { traction: S::ZEROS, ..*of };
            body.facet_conditions().iter().map(unloaded).collect()
        };
        let weightless = (body.body_force() != S::Vector::ZERO).then(|| body.weightless());
        let mut own = None;
        let mut columns = Vec::new();
        for field in fields {
            let column = match &weightless {
                None => {
                    let mut column = EquilibratedStress::recover(body, field, conditions());
                    S::relax_with(body, &mut column, relaxation, stars, None);
                    column
                }
                Some(body) => {
                    let mut column = EquilibratedStress::recover(body, field, conditions());
                    S::relax_with(body, &mut column, relaxation, &mut own, None);
                    column
                }
            };
            let checked = check_stress(weightless.as_ref().unwrap_or(body), &column);
            if checked.failed().all(|(_, found)| found <= FORCE_TOLERANCE) {
                columns.push(column);
            }
        }
        drop(own);
        Self::orthonormal(weightless.as_ref().unwrap_or(body), columns)
    }

    /// Makes columns orthonormal; of dependent ones fewer remain.
    ///
    /// * `body`: without a body force.
    fn orthonormal(body: &Body<S>, columns: Vec<EquilibratedStress<S>>) -> Self {
        let Some(first) = columns.first() else { return Self { moments: Vec::new() } };
        let finite_element = vec![S::Tensor::default(); first.finite_element.len()];
        let mut work = EquilibratedStress { finite_element, ..first.clone() };
        let moments: Vec<FacetMoments<S>> = columns.into_iter().map(|column| column.facet_moments).collect();
        let mut energy = |moments: FacetMoments<S>| {
            work.facet_moments = moments;
            work.distance_squared(body)
        };
        let sizes: Vec<f64> = moments.iter().map(|column| energy(column.clone())).collect();
        let mut gram = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(sizes));
        for (k, l) in (0..moments.len()).flat_map(|k| (0..k).map(move |l| (k, l))) {
            let mut sum = moments[k].clone();
            add::<S>(&mut sum, 1.0, &moments[l]);
            let product = 0.5 * (energy(sum) - gram[(k, k)] - gram[(l, l)]);
            (gram[(k, l)], gram[(l, k)]) = (product, product);
        }
        let combined = |factors: Vec<f64>| {
            let mut sum = vec![S::ZEROS; moments[0].len()];
            factors.iter().zip(&moments).for_each(|(factor, column)| add::<S>(&mut sum, *factor, column));
            sum
        };
        Self { moments: inverse_roots(gram).into_iter().map(combined).collect() }
    }

    /// Returns how many there are.
    pub(crate) fn len(&self) -> usize {
        self.moments.len()
    }

    /// Lowers `‖τ − σ̂‖` in place, and the last entry of the record by what that gained.
    pub(crate) fn lower(
        &self,
        body: &Body<S>,
        stress: &mut EquilibratedStress<S>,
        report: &mut RelaxationReport,
    ) {
        report.columns = self.len();
        if self.moments.is_empty() {
            return;
        }
        let before = stress.distance_squared(body);
        let size = before.sqrt();
        let given = stress.facet_moments.clone();
        let mut factors = Vec::new();
        for column in &self.moments {
            // ‖τ + s τ_k − σ̂‖² = ‖τ − σ̂‖² − 2 s c_k + s²
            add::<S>(&mut stress.facet_moments, size, column);
            factors.push(0.5 * (before - stress.distance_squared(body) + before) / size);
            stress.facet_moments.clone_from(&given);
        }
        for (factor, column) in factors.iter().zip(&self.moments) {
            add::<S>(&mut stress.facet_moments, *factor, column);
        }
        let after = stress.distance_squared(body);
        if !(after < before) {
            stress.facet_moments = given;
            return;
        }
        if let Some(last) = report.energy_history.last_mut() {
            *last = after.min(*last);
        }
    }
}

/// Factorises a body without contact sides.
fn factorised<S: Space>(body: &Body<S>) -> Option<CondensedBody<S>> {
    let dofs = fem_core::dof::DofMap::new(body, &InterfaceSide::default());
    let system = System::with_springs(body, dofs).ok()?;
    CondensedBody::factorise(system, body.mesh().points()).ok()
}

/// Computes the FE stress of a jump without loads, Pa per unit of the jump.
fn field<S: Space>(
    body: &Body<S>,
    factor: &CondensedBody<S>,
    jumps: &Jumps<S>,
    k: usize,
) -> Vec<S::Tensor> {
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
    // The second time only the rounding of the first is left.
    for _ in 0..2 {
        let mut forces = vec![S::Vector::ZERO; mesh.points().len()];
        for ((stress, element), nodes) in stresses(&displacement).into_iter().zip(&elements).zip(mesh.cells()) {
            for corner in 0..=S::DIM {
                forces[nodes[corner]] -= S::applied(stress, element.gradients[corner]) * element.measure;
            }
        }
        let mut solution = factor.rough_along_unknowns(&forces);
        factor.factor().solve(&mut solution);
        let correction = factor.dofs().correction(&solution);
        displacement.iter_mut().zip(correction).for_each(|(sum, correction)| *sum += correction);
    }
    stresses(&displacement)
}

/// Combines FE stresses to orthonormal ones, as many as are independent.
fn orthonormal_fields<S: Space>(body: &Body<S>, fields: Vec<Vec<S::Tensor>>) -> Vec<Vec<S::Tensor>> {
    let product = |k: usize, l: usize| {
        sum_over_cells(body.mesh().cells().len(), |cell| {
            body.mesh().measure(cell) * body.material(cell).complementary(fields[k][cell], fields[l][cell])
        })
    };
    let gram = DMatrix::from_fn(fields.len(), fields.len(), product);
    let combined = |factors: Vec<f64>| {
        let at = |cell: usize| -> S::Tensor {
            let parts: Vec<S::Components<f64>> = fields.iter().map(|field| field[cell].into()).collect();
            S::components(|c| factors.iter().zip(&parts).map(|(factor, part)| factor * part[c]).sum()).into()
        };
        (0..body.mesh().cells().len()).map(at).collect()
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

/// Adds a multiple of a column to facet moments.
fn add<S: Space>(moments: &mut FacetMoments<S>, factor: f64, column: &FacetMoments<S>) {
    let numbers = moments.iter_mut().flat_map(|of| of.as_mut());
    let column = column.iter().flat_map(|of| of.as_ref());
    numbers.zip(column).for_each(|(sum, part)| *sum += *part * factor);
}

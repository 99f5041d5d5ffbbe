//! Body forces that are linear in each cell: of expressions, of a rotation, of an acceleration.

use super::{Body, BodyError, ConditionList, ConditionPlace};
use crate::boundary::{BoundaryConditions, ScalarData};
use crate::element::Element;
use crate::geometry::{Coordinates, bounding_box};
use crate::linear_field::{LinearField, along};
use crate::material::Materials;
use crate::mesh::Mesh;
use crate::space::{Plane, Space};
use rayon::prelude::*;

/// A function that is off its linear interpolant by less, relative to its largest value, is linear.
const ROUND_OFF: f64 = 1e-12;

/// Smallest number of cells per parallel task.
const FEWEST_PER_TASK: usize = 1024;

/// The body force in a cell, `b(x) = mean + Σ_j gradient_j (x − c)_j` about its centroid `c`, N/m³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellForce<S: Space = Plane> {
    /// The mean, which is the value at the centroid.
    pub mean: S::Vector,
    /// The derivative along each axis, N/m⁴.
    pub gradient: S::Axes<S::Vector>,
}

impl<S: Space> CellForce<S> {
    /// Tells whether it is the same everywhere in the cell.
    pub fn is_constant(&self) -> bool {
        self.gradient == S::ZEROS
    }

    /// Evaluates the force.
    ///
    /// * `arm`: from the centroid, m.
    pub fn at(&self, arm: S::Vector) -> S::Vector {
        self.mean + along::<S>(&self.gradient, arm)
    }
}

/// Returns the corners of a cell relative to its centroid. Far from the origin the centroid itself is rounded.
pub fn arms<S: Space>(corners: &S::Corners<S::Vector>) -> S::Corners<S::Vector> {
    let from_first = S::corners(|k| corners[k] - corners[0]);
    let middle = from_first.into_iter().sum::<S::Vector>() / (S::DIM + 1) as f64;
    S::corners(|k| from_first[k] - middle)
}

/// Evaluates the body force of each cell; none if it is constant: then it is [`BoundaryConditions::body_force`].
pub(super) fn evaluate<S: Space>(
    mesh: &Mesh<S>,
    materials: &Materials<S>,
    conditions: &BoundaryConditions<S>,
) -> Result<Vec<CellForce<S>>, BodyError> {
    let (field, per_mass) = (conditions.force_field.as_ref(), conditions.per_mass.as_ref());
    if field.is_none() && per_mass.is_none() {
        return Ok(Vec::new());
    }
    let linear = field.and_then(|field| linear_field(mesh, field));
    let of_field = |field: &S::Data<ScalarData<S>>, corners: &S::Corners<S::Vector>| -> CellForce<S> {
        let value = |x: S::Vector| S::Vector::of(|c| field[c].at(x));
        let centre = corners[0] - arms::<S>(corners)[0];
        if let Some(linear) = &linear {
            return CellForce { mean: linear.at(centre), gradient: linear.gradient };
        }
        let values = S::corners(|k| value(corners[k]));
        let element = Element::<S>::new(*corners);
        let slope = |j: usize| {
            let terms = values.into_iter().zip(element.gradients).map(|(b, g)| b * g[j]);
            terms.sum::<S::Vector>()
        };
        CellForce {
            mean: values.into_iter().sum::<S::Vector>() / (S::DIM + 1) as f64,
            gradient: S::axes(slope),
        }
    };
    let of_cell = |t: usize| {
        let corners = mesh.corners(t);
        let mut force = CellForce::<S> { mean: conditions.body_force, gradient: S::ZEROS };
        if let Some(field) = field {
            let found = of_field(field, &corners);
            force.mean += found.mean;
            force.gradient = found.gradient;
        }
        if let Some(per_mass) = per_mass {
            let density = materials.of(t).density();
            force.mean += per_mass.at(corners[0] - arms::<S>(&corners)[0]) * density;
            let slope = |j: usize| force.gradient[j] + per_mass.gradient[j] * density;
            force.gradient = S::axes(slope);
        }
        let finite = force.mean.is_finite() && force.gradient.into_iter().all(|slope| slope.is_finite());
        if finite { Ok(force) } else { Err(BodyError::BodyForce { force: force.mean.into() }) }
    };
    (0..mesh.cells().len()).into_par_iter().with_min_len(FEWEST_PER_TASK).map(of_cell).collect()
}

/// Finds the linear field that some functions are at all nodes; `None` if they are not linear.
fn linear_field<S: Space>(mesh: &Mesh<S>, field: &S::Data<ScalarData<S>>) -> Option<LinearField<S>> {
    let value = |x: S::Vector| S::Vector::of(|c| field[c].at(x));
    let [low, high] = bounding_box(mesh.points());
    let point = (low + high) * 0.5;
    let gradient = S::axes(|j| {
        let step = S::AXES[j] * (0.5 * (high[j] - low[j]));
        (value(point + step) - value(point - step)) / (high[j] - low[j])
    });
    let linear = LinearField { point, value: value(point), gradient };
    let points = || mesh.points().iter().copied();
    let largest = points().map(|x| value(x).largest()).fold(0.0, f64::max);
    points().all(|x| (value(x) - linear.at(x)).largest() <= ROUND_OFF * largest).then_some(linear)
}

impl<S: Space> Body<S> {
    /// Returns the body force in a cell.
    #[inline]
    pub fn force(&self, cell: usize) -> CellForce<S> {
        let constant = CellForce { mean: self.conditions.body_force, gradient: S::ZEROS };
        self.forces.get(cell).copied().unwrap_or(constant)
    }

    /// Tells whether a body force acts.
    #[inline]
    pub fn has_force(&self) -> bool {
        !self.forces.is_empty() || self.conditions.body_force != S::Vector::ZERO
    }

    /// Tells whether the body force may differ between cells or in a cell.
    #[inline]
    pub fn has_varying_force(&self) -> bool {
        !self.forces.is_empty()
    }

    /// Computes the nodal forces of the body force in a cell, `∫ b φ_k`, N/m in the plane, N in space.
    #[inline]
    pub fn nodal_forces_inside(&self, cell: usize) -> S::Corners<S::Vector> {
        let (force, n) = (self.force(cell), (S::DIM + 1) as f64);
        let share = force.mean * (self.mesh.measure(cell) / n);
        let beyond = self.nodal_forces_beyond_mean(cell);
        S::corners(|k| share + beyond[k])
    }

    /// Computes the part of [`Self::nodal_forces_inside`] that the mean does not have.
    pub(crate) fn nodal_forces_beyond_mean(&self, cell: usize) -> S::Corners<S::Vector> {
        let (force, n) = (self.force(cell), (S::DIM + 1) as f64);
        if force.is_constant() {
            return S::corners(|_| S::Vector::ZERO);
        }
        let arms = arms::<S>(&self.mesh.corners(cell));
        let factor = self.mesh.measure(cell) / (n * (n + 1.0));
        S::corners(|k| along::<S>(&force.gradient, arms[k]) * factor)
    }

    /// Computes the resultant of the body force, N/m in the plane, N in space.
    pub fn resultant_inside(&self) -> S::Vector {
        (0..self.mesh.cells().len()).map(|t| self.force(t).mean * self.mesh.measure(t)).sum()
    }

    /// Compares each component of a body force given by functions with the force of the mesh, in the order of the axes.
    pub(super) fn force_data(&self) -> Vec<(usize, ConditionPlace, &ScalarData<S>)> {
        let place = ConditionPlace { list: ConditionList::BodyForce, index: 0 };
        let field = self.conditions.force_field.iter();
        field.flat_map(|field| field.as_ref().iter().enumerate()).map(|(c, data)| (c, place, data)).collect()
    }
}

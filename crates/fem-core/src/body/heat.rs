//! The initial strain of a change of temperature, `ε₀ = α T`, and data inside a body that the mesh does not represent.
//!
//! The temperature is linear in each cell between its values at the nodes; the stress of a displacement is `σ(v) = E (ε(v) − ε₀)`.

use super::interpolation::Sum;
use super::{Body, BodyError, ConditionList, ConditionPlace, Difference, force};
use crate::boundary::{BoundaryConditions, ScalarData};
use crate::mesh::Mesh;
use crate::norm::sum_over_cells;
use crate::quadrature::GAUSS5;
use crate::space::Space;

/// A datum inside a body, given by a function that is not linear in the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsideDifference {
    /// The datum.
    pub place: ConditionPlace,
    /// The Cartesian component of a body force; `None` of a temperature.
    pub component: Option<usize>,
    /// The difference from the linear datum of the mesh, at the points of a quadrature in each cell.
    pub difference: Difference,
    /// Of a temperature: `‖ε₀ − ε₀'‖`, the energy norm of the difference of the initial strains by quadrature, square root of J/m (of J in
    /// space). The displacements of the two problems differ by at most this.
    pub energy: Option<f64>,
}

/// Adds up the temperatures at the nodes; none if there is no condition.
pub(super) fn evaluate<S: Space>(
    mesh: &Mesh<S>,
    conditions: &BoundaryConditions<S>,
) -> Result<Vec<f64>, BodyError> {
    if conditions.temperatures.is_empty() {
        return Ok(Vec::new());
    }
    let mut sum = vec![0.0; mesh.points().len()];
    for (index, data) in conditions.temperatures.iter().enumerate() {
        let place = ConditionPlace { list: ConditionList::Temperature, index };
        for (sum, &point) in sum.iter_mut().zip(mesh.points()) {
            let value = data.at(point);
            if !value.is_finite() {
                return Err(BodyError::NotFinite { place, point: point.into(), value });
            }
            *sum += value;
        }
    }
    Ok(sum)
}

/// Makes a quadrature rule on a cell, products of Gauss's with five points: barycentric coordinates, and weights of sum 1.
fn rule<S: Space>() -> Vec<(S::Corners<f64>, f64)> {
    let count = GAUSS5.len().pow(S::DIM as u32);
    let point = |number: usize| {
        let (mut left, mut weight, mut at) = (1.0, 1.0, S::corners(|_| 0.0));
        for axis in 0..S::DIM {
            let (s, share) = GAUSS5[number / GAUSS5.len().pow(axis as u32) % GAUSS5.len()];
            // The cross-section shrinks towards the corner.
            let shrinking = (1.0 - s).powi((S::DIM - 1 - axis) as i32);
            weight *= share * shrinking * (S::DIM - axis) as f64;
            at[axis] = left * s;
            left *= 1.0 - s;
        }
        at[S::DIM] = left;
        (at, weight)
    };
    (0..count).map(point).collect()
}

impl<S: Space> Body<S> {
    /// Returns the change of temperature at each node; empty without heat.
    pub fn temperature(&self) -> &[f64] {
        &self.temperature
    }

    /// Tells whether the temperature changes.
    #[inline]
    pub fn has_heat(&self) -> bool {
        !self.temperature.is_empty()
    }

    /// Returns the mean change of temperature in a cell.
    #[inline]
    pub fn cell_temperature(&self, cell: usize) -> f64 {
        if !self.has_heat() {
            return 0.0;
        }
        let nodes = self.mesh.cells()[cell];
        nodes.into_iter().map(|n| self.temperature[n.index()]).sum::<f64>() / (S::DIM + 1) as f64
    }

    /// Returns the mean initial strain in a cell.
    #[inline]
    pub fn initial_strain(&self, cell: usize) -> S::Tensor {
        times::<S>(self.material(cell).thermal_strain(), self.cell_temperature(cell))
    }

    /// Computes the mean stress in a cell of a displacement, `σ = E (ε − ε₀)`.
    #[inline]
    pub fn stress(&self, cell: usize, strain: S::Tensor) -> S::Tensor {
        if !self.has_heat() {
            return self.material(cell).stress(strain);
        }
        let (a, b): (S::Components<f64>, S::Components<f64>) =
            (strain.into(), self.initial_strain(cell).into());
        self.material(cell).stress(S::components(|k| a[k] - b[k]).into())
    }

    /// Computes `E (ε₀ − ε̄₀)` at the corners of a cell, Pa: the mean stress of a displacement less its stress there.
    pub fn heat_beyond_mean(&self, cell: usize) -> S::Corners<S::Tensor> {
        let (nodes, mean) = (self.mesh.cells()[cell], self.cell_temperature(cell));
        let unit = self.material(cell).stress(self.material(cell).thermal_strain());
        S::corners(|k| match self.temperature.get(nodes[k].index()) {
            Some(temperature) => times::<S>(unit, temperature - mean),
            None => S::Tensor::default(),
        })
    }

    /// Computes `∫ (σ − σ̄) : E⁻¹ (σ − σ̄)` of any displacement in a cell, J/m in the plane, J in space.
    pub fn heat_energy(&self, cell: usize) -> f64 {
        if !self.has_heat() {
            return 0.0;
        }
        let n = (S::DIM + 1) as f64;
        let squares =
            self.heat_beyond_mean(cell).into_iter().map(|s| self.material(cell).complementary(s, s));
        squares.sum::<f64>() * self.mesh.measure(cell) / (n * (n + 1.0))
    }

    /// Measures how far temperatures and body forces given by functions are from the linear ones of the mesh, by sampling each cell.
    /// Data that differ by round-off alone are left out.
    pub fn interpolated_inside(&self) -> Vec<InsideDifference> {
        let temperatures = self.conditions.temperatures.iter().enumerate().map(|(index, data)| {
            let place = ConditionPlace { list: ConditionList::Temperature, index };
            (None, place, data)
        });
        let forces = self.force_data().into_iter().map(|(c, place, data)| (Some(c), place, data));
        let data = temperatures.chain(forces).filter(|(_, _, data)| data.constant().is_none());
        let rule = rule::<S>();
        let found = data.filter_map(|(component, place, data)| {
            let difference = self.difference(data, &rule)?;
            let energy = component.is_none().then(|| self.strain_difference(data, &rule).sqrt());
            Some(InsideDifference { place, component, difference, energy })
        });
        found.collect()
    }

    /// Compares a function with its linear interpolant in each cell.
    fn difference(&self, data: &ScalarData<S>, rule: &[(S::Corners<f64>, f64)]) -> Option<Difference> {
        let cells: Vec<usize> = (0..self.mesh.cells().len()).collect();
        let add = |sum: &mut Sum, cell: &usize| {
            let values = S::corners(|k| data.at(self.mesh.corners(*cell)[k]));
            sum.cell(self.mesh.measure(*cell), values.as_ref(), &self.samples(*cell, &values, data, rule));
        };
        Sum::of(&cells, add).difference()
    }

    /// Computes `‖α E^½ (T − T')‖²` of a function and its linear interpolant.
    fn strain_difference(&self, data: &ScalarData<S>, rule: &[(S::Corners<f64>, f64)]) -> f64 {
        sum_over_cells(self.mesh.cells().len(), |t| {
            let values = S::corners(|k| data.at(self.mesh.corners(t)[k]));
            let strain = self.material(t).thermal_strain();
            let stiffness = S::contracted(self.material(t).stress(strain), strain);
            let squares = self.samples(t, &values, data, rule).into_iter();
            let mean: f64 = squares.map(|[exact, linear, weight]| weight * (exact - linear).powi(2)).sum();
            stiffness * mean * self.mesh.measure(t)
        })
    }

    /// Evaluates a function and its linear interpolant at the points of a rule: each with its weight.
    fn samples(
        &self,
        cell: usize,
        values: &S::Corners<f64>,
        data: &ScalarData<S>,
        rule: &[(S::Corners<f64>, f64)],
    ) -> Vec<[f64; 3]> {
        let corners = self.mesh.corners(cell);
        let arms = force::arms::<S>(&corners);
        let centre = corners[0] - arms[0];
        let of_point = |(at, weight): &(S::Corners<f64>, f64)| {
            let arm: S::Vector = arms.into_iter().zip(*at).map(|(arm, share)| arm * share).sum();
            let linear: f64 = values.into_iter().zip(*at).map(|(value, share)| value * share).sum();
            [data.at(centre + arm), linear, *weight]
        };
        rule.iter().map(of_point).collect()
    }
}

/// Multiplies a tensor by a number.
fn times<S: Space>(tensor: S::Tensor, factor: f64) -> S::Tensor {
    let components: S::Components<f64> = tensor.into();
    S::components(|k| components[k] * factor).into()
}

//! The initial strain of a change of temperature, `ε₀ = α T`, to which cuts add theirs.
//!
//! The temperature is linear in each cell between its values at the nodes; the stress of a displacement is `σ(v) = E (ε(v) − ε₀)`.

use super::{Body, BodyError, ConditionList, ConditionPlace};
use crate::boundary::BoundaryConditions;
use crate::mesh::Mesh;
use crate::space::Space;

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

    /// Tells whether cells have an initial strain: of heat or of cuts.
    #[inline]
    pub fn has_initial_strain(&self) -> bool {
        self.has_heat() || !self.cuts().is_empty()
    }

    /// Returns the mean initial strain in a cell, of heat and of cuts.
    #[inline]
    pub fn initial_strain(&self, cell: usize) -> S::Tensor {
        let of_heat = times::<S>(self.material(cell).thermal_strain(), self.cell_temperature(cell));
        let Some(of_cuts) = self.cut_strains.get(cell) else { return of_heat };
        let [a, b]: [S::Components<f64>; 2] = [of_heat.into(), (*of_cuts).into()];
        S::components(|k| a[k] + b[k]).into()
    }

    /// Computes the mean stress in a cell of a displacement, `σ = E (ε − ε₀)`.
    #[inline]
    pub fn stress(&self, cell: usize, strain: S::Tensor) -> S::Tensor {
        if !self.has_initial_strain() {
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
}

/// Multiplies a tensor by a number.
fn times<S: Space>(tensor: S::Tensor, factor: f64) -> S::Tensor {
    let components: S::Components<f64> = tensor.into();
    S::components(|k| components[k] * factor).into()
}

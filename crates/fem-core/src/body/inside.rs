//! Data inside a body that are not linear in the cells: temperatures and body forces.

use super::interpolation::Sum;
use super::{Body, ConditionList, ConditionPlace, Difference, force};
use crate::boundary::ScalarData;
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
        let of_cell = |t: usize| {
            let values = S::corners(|k| data.at(self.mesh.corners(t)[k]));
            let strain = self.material(t).thermal_strain();
            let stiffness = S::contracted(self.material(t).stress(strain), strain);
            let squares = self.samples(t, &values, data, rule).into_iter();
            let mean: f64 = squares.map(|[exact, linear, weight]| weight * (exact - linear).powi(2)).sum();
            stiffness * mean * self.mesh.measure(t)
        };
        (0..self.mesh.cells().len()).map(of_cell).sum()
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

//! Displacements on a mesh of their own, compared with the displacements of a body that has another mesh.

use crate::body::Body;
use crate::element::Element;
use crate::geometry::Coordinates;
use crate::mesh::Mesh;
use crate::mesh::cell_tree::{CellAt, CellTree};
use crate::norm::{energy_distance_squared, spring_energy, sum_over_cells};
use crate::space::{Plane, Space};
use std::sync::OnceLock;

/// A field that is linear in the cells of its mesh, such as displacements, m.
pub struct MeshField<'a, S: Space = Plane> {
    mesh: &'a Mesh<S>,
    values: &'a [S::Vector],
    /// The body of the field, if it has cuts.
    cut: Option<&'a Body<S>>,
    tree: OnceLock<CellTree<'a, S>>,
}

impl<'a, S: Space> MeshField<'a, S> {
    /// Takes a field.
    ///
    /// * `values`: at the nodes of the mesh.
    ///
    /// # Panics
    /// If there is not one value per node.
    pub fn new(mesh: &'a Mesh<S>, values: &'a [S::Vector]) -> Self {
        let nodes = mesh.points().len();
        assert!(values.len() == nodes, "{} values on {nodes} nodes", values.len());
        Self { mesh, values, cut: None, tree: OnceLock::new() }
    }

    /// Takes a displacement field of a body, with the jumps at its cuts.
    ///
    /// # Panics
    /// If there is not one value per node.
    pub fn of_body(body: &'a Body<S>, values: &'a [S::Vector]) -> Self {
        let cut = (!body.cuts().is_empty()).then_some(body);
        Self { cut, ..Self::new(body.mesh(), values) }
    }

    /// Returns the values at the nodes.
    pub fn values(&self) -> &'a [S::Vector] {
        self.values
    }

    /// Evaluates the field at the nodes of another mesh. Outside of its own mesh it continues as in a cell nearby.
    pub fn on(&self, mesh: &Mesh<S>) -> Vec<S::Vector> {
        if self.has_mesh(mesh) {
            return self.values.to_vec();
        }
        let own = self.mesh.points();
        let value = |(k, point): (usize, &S::Vector)| match own.get(k) {
            Some(unmoved) if unmoved == point => self.values[k],
            _ => self.tree().nearest(*point).map_or_else(S::Vector::default, |at| self.value(at)),
        };
        mesh.points().iter().enumerate().map(value).collect()
    }

    /// Computes `‖u − v‖²` for this field `u` and a field `v` of a body, J/m, exactly, if sides on springs are unchanged or finer: over the common parts of the cells of
    /// both meshes, on which both are linear. Regions that only one of the meshes covers are left out.
    ///
    /// * `field`: `v`, at the nodes of the body's mesh.
    ///
    /// # Panics
    /// If `field` does not have one entry per node.
    pub fn energy_distance_squared(&self, body: &Body<S>, field: &[S::Vector]) -> f64 {
        let mesh = body.mesh();
        let uncut = self.cut.is_none() && body.cuts().is_empty();
        if uncut && self.has_mesh(mesh) {
            return energy_distance_squared(body, self.values, field);
        }
        let cells = sum_over_cells(mesh.cells().len(), |t| {
            let nodes = mesh.cells()[t];
            let corners = mesh.corners(t);
            if uncut && self.has_cell(mesh, t) {
                let difference = S::corners(|k| self.values[nodes[k]] - field[nodes[k]]);
                let element = Element::<S>::new(corners);
                return element.measure * energy_density(body, t, element.strain(difference));
            }
            let beyond = body.cut_displacement(t);
            let strain: S::Components<f64> =
                Element::<S>::new(corners).strain(S::corners(|k| field[nodes[k]] + beyond[k])).into();
            let part = |(cell, measure): (usize, f64)| {
                let own = self.mesh.cells()[cell];
                let beyond = self.cut.map(|body| body.cut_displacement(cell));
                let beyond = |k: usize| beyond.as_ref().map_or(S::Vector::ZERO, |beyond| beyond[k]);
                let own = S::corners(|k| self.values[own[k]] + beyond(k));
                let own: S::Components<f64> = Element::<S>::new(self.mesh.corners(cell)).strain(own).into();
                let difference = S::components(|k| strain[k] - own[k]).into();
                measure * energy_density(body, t, difference)
            };
            self.tree().common_measures(corners).into_iter().map(part).sum()
        });
        let own = if body.springs().is_empty() { Vec::new() } else { self.on(mesh) };
        let difference: Vec<S::Vector> = own.iter().zip(field).map(|(u, v)| *u - *v).collect();
        cells + spring_energy(body, &difference)
    }

    /// Tells whether the field is on the nodes of this mesh.
    pub fn has_mesh(&self, mesh: &Mesh<S>) -> bool {
        std::ptr::eq(self.mesh, mesh)
            || (self.mesh.points() == mesh.points() && self.mesh.cells() == mesh.cells())
    }

    /// Tells whether its mesh has the same cell of the same nodes.
    fn has_cell(&self, mesh: &Mesh<S>, t: usize) -> bool {
        let nodes = mesh.cells()[t];
        let own = self.mesh.points();
        let unmoved = nodes.into_iter().all(|n| own.get(n.index()).is_some_and(|p| *p == mesh.points()[n]));
        let mut around = if unmoved { self.mesh.topology().cells_around(nodes[0]) } else { &[] }.iter();
        around.any(|cell| self.mesh.cells()[*cell as usize].into_iter().all(|n| nodes.as_ref().contains(&n)))
    }

    fn value(&self, at: CellAt<S>) -> S::Vector {
        let nodes = self.mesh.cells()[at.cell];
        nodes.into_iter().zip(at.weights).map(|(n, weight)| self.values[n] * weight).sum()
    }

    fn tree(&self) -> &CellTree<'a, S> {
        self.tree.get_or_init(|| CellTree::new(self.mesh))
    }
}

fn energy_density<S: Space>(body: &Body<S>, t: usize, strain: S::Tensor) -> f64 {
    S::contracted(body.material(t).stress(strain), strain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryConditions;
    use crate::geometry::Vector;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::TriMesh;
    use crate::mesh::generate::block;
    use crate::norm::energy_norm_squared;

    fn body(mesh: TriMesh) -> Body {
        let material = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(mesh, material, &BoundaryConditions::new()).unwrap()
    }

    fn wave(mesh: &TriMesh) -> Vec<Vector> {
        let at = |x: &Vector| Vector::new((3.0 * x[0]).sin() * x[1], 1.0 + x[0] * x[1] - x[1].cos());
        mesh.points().iter().map(at).collect()
    }

    #[test]
    fn a_field_on_a_nested_mesh_has_no_distance_from_itself() {
        let coarse = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let values = wave(&coarse);
        let field = MeshField::new(&coarse, &values);
        let fine = body(block([0.0, 0.0], [2.0, 1.0], [12, 6]).unwrap());
        let same = field.on(fine.mesh());
        let energy = energy_norm_squared(&fine, &same);
        // Rounded corners of the cells reach into neighbours.
        assert!(field.energy_distance_squared(&fine, &same) < 1e-14 * energy);
        // Its distance from zero is its own norm, on whatever mesh.
        let zero = vec![Vector::zeros(); same.len()];
        let found = field.energy_distance_squared(&fine, &zero);
        assert!((found / energy - 1.0).abs() < 1e-13, "{found} {energy}");
    }

    #[test]
    fn a_moved_node_changes_the_field_by_the_norm_on_the_common_parts_of_the_cells() {
        let before = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let values = wave(&before);
        let field = MeshField::new(&before, &values);
        let mut points = before.points().to_vec();
        points[1][0] += 0.07;
        let after = body(TriMesh::new(points, before.cells().to_vec(), Vec::new()).unwrap());
        let moved = field.on(after.mesh());
        let found = field.energy_distance_squared(&after, &moved);
        // A mesh in which both are nearly linear says the same.
        let fine = body(block([0.0, 0.0], [2.0, 1.0], [400, 200]).unwrap());
        let on_after = MeshField::new(after.mesh(), &moved);
        let sampled =
            crate::norm::energy_distance_squared(&fine, &field.on(fine.mesh()), &on_after.on(fine.mesh()));
        assert!(found > 0.01 && (sampled / found - 1.0).abs() < 0.03, "{found} {sampled}");
    }
}

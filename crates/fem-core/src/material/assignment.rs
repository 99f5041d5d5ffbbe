//! The material of each cell of a body.

use super::LinearElastic;
use crate::space::{Plane, Space};

/// The materials of a body, each cell with one of them.
///
/// ```
/// use fem_core::material::{Hypothesis, LinearElastic, Materials};
/// let [soft, hard] = [1.0, 5.0].map(|e| LinearElastic::isotropic(e, 0.3, Hypothesis::PlaneStrain));
/// let materials = Materials::by_cell(vec![soft?, hard?], vec![0, 0, 1]);
/// assert!(materials.of(2).stiffness()[(0, 0)] > materials.of(1).stiffness()[(0, 0)]);
/// # Ok::<(), fem_core::material::MaterialError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Materials<S: Space = Plane> {
    list: Vec<LinearElastic<S>>,
    /// Place in the list by cell; empty if there is one material.
    of_cell: Vec<u32>,
}

impl<S: Space> Materials<S> {
    /// Gives each cell a material.
    ///
    /// * `list`: the materials.
    /// * `of_cell`: by cell, the place of its material in the list. [`crate::body::Body::new`] rejects places
    ///   that do not exist, and a length other than the number of cells.
    pub fn by_cell(list: Vec<LinearElastic<S>>, of_cell: Vec<u32>) -> Self {
        Self { list, of_cell }
    }

    /// Returns the materials.
    pub fn list(&self) -> &[LinearElastic<S>] {
        &self.list
    }

    /// Returns the material of a cell.
    #[inline]
    pub fn of(&self, cell: usize) -> &LinearElastic<S> {
        &self.list[self.index(cell)]
    }

    /// Returns the place in [`Self::list`] of the material of a cell.
    #[inline]
    pub fn index(&self, cell: usize) -> usize {
        self.of_cell.get(cell).map_or(0, |&k| k as usize)
    }

    /// Counts the cells that have an assigned material, 0 if one material is used for all.
    pub fn len(&self) -> usize {
        self.of_cell.len()
    }

    /// Tells whether one material is used for all cells.
    pub fn is_empty(&self) -> bool {
        self.of_cell.is_empty()
    }

    /// Tells whether each of a number of cells has an existing material.
    pub(crate) fn fit(&self, cells: usize) -> bool {
        let known = self.of_cell.iter().all(|&k| (k as usize) < self.list.len());
        match self.is_empty() {
            true => self.list.len() == 1,
            false => known && self.len() == cells,
        }
    }

    /// Transfers the materials of the parents to the cells of a finer mesh.
    pub(crate) fn inherited(&self, parent_cell: &[u32]) -> Self {
        let of_cell = match self.is_empty() {
            true => Vec::new(),
            false => parent_cell.iter().map(|&p| self.of_cell[p as usize]).collect(),
        };
        Self { list: self.list.clone(), of_cell }
    }
}

impl<S: Space> From<LinearElastic<S>> for Materials<S> {
    fn from(material: LinearElastic<S>) -> Self {
        Self { list: vec![material], of_cell: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, BodyError};
    use crate::boundary::BoundaryConditions;
    use crate::material::Hypothesis;
    use crate::mesh::generate::block;
    use crate::mesh::refine::{RefinementEdges, close, refine};

    fn two() -> Vec<LinearElastic> {
        [1.0, 5.0].map(|e| LinearElastic::isotropic(e, 0.3, Hypothesis::PlaneStress).unwrap()).to_vec()
    }

    #[test]
    fn materials_must_fit_the_mesh() {
        let mesh = || block([0.0, 0.0], [1.0, 1.0], [2, 1]).unwrap();
        let body = |list, of| Body::new(mesh(), Materials::by_cell(list, of), &BoundaryConditions::new());
        assert!(body(two(), vec![0, 1, 0, 1]).is_ok());
        for (list, of) in [
            (two(), vec![0, 1, 0]),
            (two(), vec![0, 1, 0, 2]),
            (two(), vec![]),
            (vec![], vec![]),
            (vec![], vec![0; 4]),
        ] {
            assert!(matches!(body(list, of), Err(BodyError::Materials { .. })));
        }
    }

    #[test]
    fn finer_cells_have_the_material_of_the_cell_they_lie_in() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let centroid = |mesh: &crate::mesh::TriMesh, t: usize| {
            let c = mesh.corners(t);
            [0, 1].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0)
        };
        let of = (0..mesh.cells().len()).map(|t| u32::from(centroid(&mesh, t)[0] > 1.0)).collect();
        let body =
            Body::new(mesh.clone(), Materials::by_cell(two(), of), &BoundaryConditions::new()).unwrap();
        let edges = RefinementEdges::longest(&mesh);
        let mut marked: Vec<bool> = (0..mesh.topology().facets().len()).map(|e| e % 3 == 0).collect();
        close(&mesh, &edges, &mut marked);
        let finer = body.refined(&refine(&mesh, &edges, &marked).unwrap()).unwrap();
        assert!(finer.mesh().cells().len() > mesh.cells().len());
        for t in 0..finer.mesh().cells().len() {
            let expected = usize::from(centroid(finer.mesh(), t)[0] > 1.0);
            assert_eq!(finer.material(t), &two()[expected]);
        }
    }
}

//! The material of each triangle of a body.

use super::LinearElastic;

/// The materials of a body, each triangle with one of them.
///
/// ```
/// use fem_core::material::{Hypothesis, LinearElastic, Materials};
/// let [soft, hard] = [1.0, 5.0].map(|e| LinearElastic::isotropic(e, 0.3, Hypothesis::PlaneStrain));
/// let materials = Materials::by_cell(vec![soft?, hard?], vec![0, 0, 1]);
/// assert!(materials.of(2).stiffness()[(0, 0)] > materials.of(1).stiffness()[(0, 0)]);
/// # Ok::<(), fem_core::material::MaterialError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Materials {
    list: Vec<LinearElastic>,
    /// Place in the list by triangle; empty if there is one material.
    of_triangle: Vec<u32>,
}

impl Materials {
    /// Gives each triangle a material.
    ///
    /// * `list`: the materials.
    /// * `of_triangle`: by triangle, the place of its material in the list. [`crate::body::Body::new`] rejects places
    ///   that do not exist, and a length other than the number of triangles.
    pub fn by_cell(list: Vec<LinearElastic>, of_triangle: Vec<u32>) -> Self {
        Self { list, of_triangle }
    }

    /// Returns the materials.
    pub fn list(&self) -> &[LinearElastic] {
        &self.list
    }

    /// Returns the material of a triangle.
    #[inline]
    pub fn of(&self, triangle: usize) -> &LinearElastic {
        &self.list[self.index(triangle)]
    }

    /// Returns the place in [`Self::list`] of the material of a triangle.
    #[inline]
    pub fn index(&self, triangle: usize) -> usize {
        self.of_triangle.get(triangle).map_or(0, |&k| k as usize)
    }

    /// Counts the triangles that have an assigned material, 0 if one material is used for all.
    pub fn len(&self) -> usize {
        self.of_triangle.len()
    }

    /// Tells whether one material is used for all triangles.
    pub fn is_empty(&self) -> bool {
        self.of_triangle.is_empty()
    }

    /// Tells whether each of a number of triangles has an existing material.
    pub(crate) fn fit(&self, triangles: usize) -> bool {
        let known = self.of_triangle.iter().all(|&k| (k as usize) < self.list.len());
        match self.is_empty() {
            true => self.list.len() == 1,
            false => known && self.len() == triangles,
        }
    }

    /// Transfers the materials of the parents to the cells of a finer mesh.
    pub(crate) fn inherited(&self, parent_cell: &[u32]) -> Self {
        let of_triangle = match self.is_empty() {
            true => Vec::new(),
            false => parent_cell.iter().map(|&p| self.of_triangle[p as usize]).collect(),
        };
        Self { list: self.list.clone(), of_triangle }
    }
}

impl From<LinearElastic> for Materials {
    fn from(material: LinearElastic) -> Self {
        Self { list: vec![material], of_triangle: Vec::new() }
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

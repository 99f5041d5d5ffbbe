//! From a region to fem-core's mesh, with fem-core's errors in the file's own numbers.

use super::{MeshFault, MeshFileError, MeshPlace, Region};
use fem_core::geometry::Point;
use fem_core::mesh::{Mesh, MeshError};
use fem_core::space::Space;

impl<S: Space> Region<S> {
    /// Refuses a mesh of this region if two of its cells overlap.
    ///
    /// # Errors
    /// The first two cells that overlap, with a point in both.
    pub fn without_overlaps(&self, mesh: Mesh<S>) -> Result<Mesh<S>, MeshFileError> {
        let Some(found) = mesh.overlapping_cells() else { return Ok(mesh) };
        let [a, b] = found.cells.map(|t| self.cell_numbers.get(t).copied().unwrap_or_default());
        let what =
            format!("{}: the elements {a} and {b} overlap at {}", self.title, Point::from(found.point));
        Err(MeshFileError::new(MeshFault::Content, &self.file, MeshPlace::File, what)
            .expected(format!("cells that touch along their {} and cover no place twice", S::WORDS.facets))
            .help("take one of the two parts out of the region, or make it a body of its own"))
    }

    /// Makes the mesh.
    ///
    /// # Errors
    /// Meshes that fem-core refuses: facets with more than two cells, parts that touch in one node.
    pub fn mesh(&self) -> Result<Mesh<S>, MeshFileError> {
        Mesh::new(self.points.clone(), self.cells.clone(), self.groups.clone())
            .map_err(|error| self.explain(&error))
    }

    /// Says of a node its number and place.
    fn node(&self, node: usize) -> String {
        match (self.node_numbers.get(node), self.points.get(node)) {
            (Some(number), Some(p)) => format!("{number} at {}", Point::from(*p)),
            _ => format!("number {node} of {}", self.title),
        }
    }

    fn explain(&self, error: &MeshError) -> MeshFileError {
        let fault =
            |found: String| MeshFileError::new(MeshFault::Content, &self.file, MeshPlace::File, found);
        match error {
            MeshError::NonManifold { nodes, .. } => {
                let nodes: Vec<String> = nodes.iter().map(|n| self.node(*n)).collect();
                let found = format!(
                    "{}: the {} between nodes {} belongs to more than two cells, or to two on the same side",
                    self.title,
                    S::WORDS.facet,
                    nodes.join(" and ")
                );
                fault(found)
                    .expected(format!("one or two cells at every {}", S::WORDS.facet))
                    .help("cells overlap there or are in the file twice")
            }
            MeshError::BowTie { node, .. } => {
                let found = format!("{}: two parts touch in node {} alone", self.title, self.node(*node));
                fault(found).expected(format!(
                    "parts that share {} {}, or no node",
                    S::WORDS.article,
                    S::WORDS.facet
                ))
            }
            MeshError::Measure { cell, .. } => {
                let number = self.cell_numbers.get(*cell).copied().unwrap_or_default();
                fault(format!("{}: element {number} has no {}", self.title, S::WORDS.measure))
            }
            MeshError::Scale { .. } => fault(format!("{}: {error}", self.title))
                .expected("lengths whose cubes are numbers too")
                .help("check the unit of the lengths"),
            other => fault(format!("{}: {other}", self.title)),
        }
    }
}

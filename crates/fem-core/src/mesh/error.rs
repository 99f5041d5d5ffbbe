//! Why a mesh is refused.

use crate::geometry::{Point, shown};
use crate::space::Words;
use thiserror::Error;

/// Largest coordinate, m: its cube, the size of a moment of an area, is finite.
pub(super) const LARGEST_COORDINATE: f64 = 1e100;

/// Shortest edge, m: the inverse of its square, the size of a stiffness over a modulus, and its cube are finite and not zero.
pub(super) const SHORTEST_EDGE: f64 = 1e-100;

/// Lists nodes: `1 and 2`, `1, 2 and 3`.
fn listed(nodes: &[usize]) -> String {
    let all: Vec<String> = nodes.iter().map(usize::to_string).collect();
    match all.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => all.concat(),
    }
}

/// Why a set of points and cells is not a valid mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// The mesh is empty.
    #[error("the mesh has {points} nodes and {cells} {}; at least one {} is needed", words.cells, words.cell)]
    Empty {
        /// Number of nodes.
        points: usize,
        /// Number of cells.
        cells: usize,
        /// The words for its cells.
        words: &'static Words,
    },
    /// More nodes or cells than 32-bit numbers can address.
    #[error("the mesh has {found} {what}; at most {limit} are supported")]
    TooLarge {
        /// The counted items.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The largest supported number.
        limit: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("node {node} has the coordinates {point}; finite numbers are needed")]
    NotFinite {
        /// Node number, from 0.
        node: usize,
        /// Its coordinates.
        point: Point,
    },
    /// A coordinate or an edge is so large or small that areas and moments would overflow or underflow.
    #[error(
        "node {node} has the coordinates {point}{}; coordinates of at most {LARGEST_COORDINATE:e} and edges of at least \
         {SHORTEST_EDGE:e} are needed",
        if *edge > 0.0 { format!(" and an edge of length {}", shown(*edge)) } else { String::new() }
    )]
    Scale {
        /// Node number, from 0.
        node: usize,
        /// Its coordinates.
        point: Point,
        /// Largest component of an edge of the node that is too short, m; 0 if a coordinate is too large.
        edge: f64,
    },
    /// A cell names a node that does not exist.
    #[error("{} {cell} uses node {node}, but the mesh has {nodes} nodes", words.cell)]
    NoSuchNode {
        /// Cell number, from 0.
        cell: usize,
        /// The node it names.
        node: usize,
        /// Number of nodes of the mesh.
        nodes: usize,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A cell has no area or volume, or a cut or a motion of nodes turned it over.
    #[error(
        "{} {cell} at {point} has the signed {} {measure:e}; a positive one is needed ({})",
        words.cell, words.measure, words.sound
    )]
    Measure {
        /// Cell number, from 0.
        cell: usize,
        /// Signed area or volume found.
        measure: f64,
        /// Centroid.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A node belongs to no cell: it would make the stiffness singular.
    #[error("node {node} at {point} belongs to no {}; remove it", words.cell)]
    LooseNode {
        /// Node number, from 0.
        node: usize,
        /// Its coordinates.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// More than two cells meet in a facet, or two of them lie on the same side of it.
    #[error(
        "the {} between nodes {} belongs to more than two {}, or to two on the same side",
        words.facet, listed(nodes), words.cells
    )]
    NonManifold {
        /// The nodes of the facet, ascending.
        nodes: Vec<usize>,
        /// The words for its cells.
        words: &'static Words,
    },
    /// Two parts of the body touch only in a single node, or in space in edges.
    #[error(
        "at node {node} {point} two parts of the body touch only in that node; separate them or join them by {} {}",
        words.article, words.facet
    )]
    BowTie {
        /// Node number, from 0.
        node: usize,
        /// Its coordinates.
        point: Point,
        /// The words for its cells.
        words: &'static Words,
    },
    /// A group names a facet that no cell has.
    #[error(
        "group \"{group}\" contains the {} between nodes {}, which no {} has",
        words.facet, listed(nodes), words.cell
    )]
    NoSuchFacet {
        /// Group name.
        group: String,
        /// The nodes of the facet.
        nodes: Vec<usize>,
        /// The words for its cells.
        words: &'static Words,
    },
    /// Two groups have the same name.
    #[error("two groups of {} are called \"{group}\"", words.facets)]
    DuplicateGroup {
        /// Group name.
        group: String,
        /// The words for its cells.
        words: &'static Words,
    },
    /// The generator of a rectangle or a box was given invalid sizes.
    #[error("a block of {cells:?} cells and size {size:?} at {origin:?} cannot be meshed: {reason}")]
    Block {
        /// Lower left corner.
        origin: Vec<f64>,
        /// Size along each axis.
        size: Vec<f64>,
        /// Number of cells along each axis.
        cells: Vec<usize>,
        /// The requirement that is violated.
        reason: &'static str,
    },
    /// Another generator was given invalid input.
    #[error("the {kind} cannot be meshed: {reason}")]
    Generator {
        /// "ring" and so on.
        kind: &'static str,
        /// The requirement that is violated.
        reason: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::space::{Plane, Solid, Space};

    #[test]
    fn coordinates_of_300_digits_are_shown_with_an_exponent() {
        let (node, point, words) = (7, Point::from(Vector::new(1e300, -1e-300)), Plane::WORDS);
        for error in [
            MeshError::NotFinite { node, point },
            MeshError::Measure { cell: 7, measure: 0.0, point, words },
            MeshError::LooseNode { node, point, words },
            MeshError::BowTie { node, point, words },
        ] {
            let said = error.to_string();
            assert!(said.contains("(1e300, -1e-300)") && said.len() < 200, "{said}");
        }
    }

    #[test]
    fn words_fit_the_space() {
        let said =
            |nodes: &[usize], words| MeshError::NonManifold { nodes: nodes.to_vec(), words }.to_string();
        assert!(
            said(&[1, 2], Plane::WORDS)
                .starts_with("the edge between nodes 1 and 2 belongs to more than two triangles")
        );
        assert!(
            said(&[1, 2, 7], Solid::WORDS)
                .starts_with("the face between nodes 1, 2 and 7 belongs to more than two tetrahedra")
        );
    }
}

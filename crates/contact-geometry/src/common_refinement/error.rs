//! Why two surfaces have no common refinement.

use fem_core::body::BodyError;
use fem_core::geometry::{Vector, shown};
use fem_core::mesh::MeshError;
use thiserror::Error;

/// Why two surfaces have no common refinement.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CommonRefinementError {
    /// There is no such group, or it has an edge inside the body.
    #[error("the contact surface \"{group}\" of body {body} is not a group of boundary edges")]
    NoSurface {
        /// 0 or 1.
        body: usize,
        /// The name given.
        group: String,
    },
    /// The surfaces lie side by side, or face the same direction.
    #[error(
        "the two contact surfaces do not overlap: seen along the contact normal, no edge of the one (around ({}, {})) faces \
         an edge of the other (around ({}, {}))",
        shown(points[0][0]), shown(points[0][1]), shown(points[1][0]), shown(points[1][1])
    )]
    NoOverlap {
        /// The mean of each surface's nodes.
        points: [Vector; 2],
    },
    /// The projection of one surface onto the other is not one to one.
    #[error(
        "near ({}, {}) the contact surfaces fold: along the contact normal a point of the one faces several of the other; \
         end the contact surface at the corner",
        shown(point[0]), shown(point[1])
    )]
    Folded {
        /// A point of the fold.
        point: Vector,
    },
    /// The cut mesh is too large, or its triangles are too small for floating-point numbers.
    #[error("the mesh of body {body}, cut at the other side's nodes: {source}")]
    Mesh {
        /// 0 or 1.
        body: usize,
        /// The error of its cut mesh.
        source: MeshError,
    },
    /// A condition cannot be evaluated on the cut mesh.
    #[error("body {body}, cut at the other side's nodes: {source}")]
    Body {
        /// 0 or 1.
        body: usize,
        /// The error of its conditions.
        source: BodyError,
    },
}

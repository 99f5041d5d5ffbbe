//! The bodies of a report.

use super::Spin;
use serde::{Deserialize, Serialize};

/// The size of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodySummary {
    /// Its name.
    pub name: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of cells, under the name of their kind.
    #[serde(flatten)]
    pub cells: CellCount,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Number of subdomains; none of a body in one piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subdomains: Option<usize>,
    /// True if its supports leave a rigid motion free.
    #[serde(default)]
    pub floating: bool,
    /// Its part in the motions of the assembly that nothing resists; they stay at zero.
    #[serde(default)]
    pub free_motions: Vec<FreeMotion>,
    /// Its rigid sides.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_sides: Vec<RigidSideSummary>,
}

/// The number of cells of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellCount {
    /// In the plane.
    Triangles(usize),
    /// Of solids.
    Tetrahedra(usize),
}

impl Default for CellCount {
    fn default() -> Self {
        Self::Triangles(0)
    }
}

impl CellCount {
    /// Returns the number.
    pub fn count(self) -> usize {
        match self {
            Self::Triangles(count) | Self::Tetrahedra(count) => count,
        }
    }
}

/// The motion of a rigid side, and the force that moves it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RigidSideSummary {
    /// The group of facets.
    pub on: String,
    /// The displacement of the point `about`, m, then its rotation, radians: `[ux, uy, rotation]`, of solids `[ux, uy, uz, rx, ry, rz]`.
    pub motion: Vec<f64>,
    /// Resultant on the body, N/m, of solids N.
    pub force: Vec<f64>,
    /// Moment about `about`, N, of solids N·m.
    pub moment: Spin,
    /// The point about which it rotates, m.
    pub about: Vec<f64>,
}

/// The motion of one body: `u(x) = translation + rotation × (x − centre)`; in the plane the rotation is about the z axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FreeMotion {
    /// Translation of the centre.
    pub translation: Vec<f64>,
    /// Rotation, in the plane counter-clockwise, 1/m.
    pub rotation: Spin,
    /// The centre, m.
    pub centre: Vec<f64>,
}

//! The bodies of a report.

use serde::Serialize;

/// The size of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "read-report", derive(serde::Deserialize))]
pub struct BodySummary {
    /// Its name.
    pub name: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// True if its supports leave a rigid motion free.
    #[serde(default)]
    pub floating: bool,
    /// Its part in the motions of the assembly that nothing resists and no load drives; they stay at zero.
    #[serde(default)]
    pub free_motions: Vec<FreeMotion>,
    /// Its rigid sides.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_sides: Vec<RigidSideSummary>,
}

/// The motion of a rigid side, and the force that moves it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "read-report", derive(serde::Deserialize))]
pub struct RigidSideSummary {
    /// The edge group.
    pub on: String,
    /// `[ux, uy, rotation]`, m and radians, of the point `about`.
    pub motion: [f64; 3],
    /// Resultant on the body, N/m.
    pub force: [f64; 2],
    /// Moment about `about`, N.
    pub moment: f64,
    /// The point about which it rotates, m.
    pub about: [f64; 2],
}

/// The motion of one body: `u(x) = translation + rotation e_z × (x − centre)`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "read-report", derive(serde::Deserialize))]
pub struct FreeMotion {
    /// Translation of the centre.
    pub translation: [f64; 2],
    /// Rotation, counter-clockwise, 1/m.
    pub rotation: f64,
    /// The centre, m.
    pub centre: [f64; 2],
}

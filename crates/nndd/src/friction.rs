//! Results of friction at the contact nodes.

/// What a pair of nodes with friction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeState {
    /// No contact force.
    Open,
    /// Contact, and friction below its limit.
    Stick,
    /// Contact, and friction at its limit.
    Slip,
}

/// Friction forces, slips and states at the pairs of nodes of one pair; empty without friction.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PairFriction {
    /// Friction force `Q` in each row along a tangent, `|Q| ≤ S`, N/m.
    pub force: Vec<f64>,
    /// Slip `w = (u^a − u^b)·t` of this load step in each of these rows, exactly 0 if the nodes stick, m.
    pub slip: Vec<f64>,
    /// The limit `S = ℓ s` of the friction force in each of these rows, N/m.
    pub limit: Vec<f64>,
    /// The state of each pair of nodes, from the active set.
    pub state: Vec<NodeState>,
}

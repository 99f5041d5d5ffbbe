//! The geometry of contact: pairs of nodes, normals, gaps, lengths. It knows no contact law.

pub mod common_refinement;
mod interpolation;
mod pairing;
mod refinement;

use crate::body::Body;
use crate::boundary::ScalarData;
use crate::geometry::Vector;
use thiserror::Error;

pub use refinement::{RefineError, RefinedProblem};

/// Two facing nodes, one of each body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Node of the first and of the second body.
    pub nodes: [u32; 2],
    /// Unit normal out of the first body, into the second.
    pub normal: Vector,
    /// Initial gap `g ≥ 0` along the normal, m.
    pub gap: f64,
    /// `ℓ = ∫ φ ds`, m.
    pub tributary_length: f64,
    /// Arc length along the first body's surface, m.
    pub arc_length: f64,
}

/// Two facing edges, one of each body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactEdge {
    /// The pairs at its two ends, in the sense of increasing arc length.
    pub pairs: [u32; 2],
    /// The mesh edge of each body.
    pub edges: [u32; 2],
    /// Length on the first body, m.
    pub length: f64,
}

/// The directions that one body keeps as interface unknowns: today the normal of each contact node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceSide {
    /// Contact nodes of the body, in the order of the pairs.
    pub nodes: Vec<u32>,
    /// Unit normal of each pair (out of the *first* body), the positive direction of traces and forces.
    pub normals: Vec<Vector>,
}

/// What the initial gap is.
#[derive(Clone, Debug)]
pub enum Gap {
    /// Given, ≥ 0: it overrides what the meshes say.
    Given(ScalarData),
}

/// Why two surfaces cannot be paired.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InterfaceError {
    /// No group of that name.
    #[error("body {body} has no edge group \"{group}\" for its contact surface; the groups are: {known}")]
    UnknownSurface {
        /// 0 or 1.
        body: usize,
        /// The name given.
        group: String,
        /// The names there are.
        known: String,
    },
    /// The group has no edge, or one inside the body.
    #[error("the contact surface \"{group}\" of body {body} {reason}")]
    NoSurface {
        /// 0 or 1.
        body: usize,
        /// The name given.
        group: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A contact edge is held or loaded as well.
    #[error("the contact edge of body {body} at ({}, {}) also has {what}; a contact edge can have neither load nor imposed displacement", point[0], point[1])]
    Occupied {
        /// 0 or 1.
        body: usize,
        /// Middle of the edge.
        point: Vector,
        /// "a load" or "an imposed displacement".
        what: &'static str,
    },
    /// A contact node has no partner.
    #[error(
        "the surfaces do not match: the contact node of body {body} at ({}, {}) is {distance:.3e} from the nearest \
         contact node of the other body, with edges of length {spacing:.3e} around it; use matching meshes \
         (at most 5 % of the edge apart)",
        point[0], point[1]
    )]
    NotMatching {
        /// 0 or 1.
        body: usize,
        /// The node.
        point: Vector,
        /// Distance to the nearest node of the other surface.
        distance: f64,
        /// Local edge length.
        spacing: f64,
    },
    /// Paired nodes are joined by an edge in one body only.
    #[error("the surfaces do not match: the contact edge of body {body} at ({}, {}) has no partner", point[0], point[1])]
    EdgeWithoutPartner {
        /// 0 or 1.
        body: usize,
        /// Middle of the edge.
        point: Vector,
    },
    /// The two surfaces look in the same direction.
    #[error("the two surfaces do not face each other at ({}, {})", point[0], point[1])]
    NotFacing {
        /// Middle of the edge.
        point: Vector,
    },
    /// The contact line bends.
    #[error("the contact line bends by {degrees:.3} degrees at ({}, {}); this version needs a straight one", point[0], point[1])]
    Curved {
        /// The node.
        point: Vector,
        /// Angle between neighbouring edge normals.
        degrees: f64,
    },
    /// The normal displacement of a contact node is imposed by a support.
    #[error(
        "the contact node of body {body} at ({}, {}) is held by a support in a direction that is not tangential to the \
         contact line; this version needs the normal direction of every contact node free: end the contact surface or \
         the support one edge earlier",
        point[0], point[1]
    )]
    SupportedNode {
        /// 0 or 1.
        body: usize,
        /// The node.
        point: Vector,
    },
    /// The initial gap is negative or not a number.
    #[error("the initial gap at ({}, {}) is {value}; it must be a finite number >= 0", point[0], point[1])]
    BadGap {
        /// The node.
        point: Vector,
        /// What was found.
        value: f64,
    },
}

/// A matching contact interface: pairs of nodes ordered by arc length, and the edges between them.
#[derive(Clone, Debug)]
pub struct ContactInterface {
    pairs: Vec<Pair>,
    edges: Vec<ContactEdge>,
    sides: [InterfaceSide; 2],
    /// What gives the gap, and the body on whose surface it, arc lengths and lengths are measured.
    gap: Gap,
    measured_on: usize,
}

impl ContactInterface {
    /// Pairs the contact surfaces of two bodies node by node.
    ///
    /// * `surfaces`: the edge group of the first and of the second body.
    /// * `gap`: the initial gap along the normal.
    ///
    /// # Errors
    /// Surfaces that do not match, do not face each other, bend, or are held or loaded, see [`InterfaceError`].
    pub fn pair(first: &Body, second: &Body, surfaces: [&str; 2], gap: &Gap) -> Result<Self, InterfaceError> {
        pairing::pair([first, second], surfaces, gap)
    }

    /// Returns the pairs by increasing arc length.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Returns the edges between pairs.
    pub fn edges(&self) -> &[ContactEdge] {
        &self.edges
    }

    /// Returns what each body keeps of the interface.
    pub fn sides(&self) -> &[InterfaceSide; 2] {
        &self.sides
    }

    /// Computes the length of the contact line, m.
    pub fn length(&self) -> f64 {
        self.edges.iter().map(|e| e.length).sum()
    }

    /// Applies the consistent interface mass matrix, `(M p)_i = ∫ p φ_i ds`; P1 `p` in Pa gives N/m.
    pub fn mass(&self, p: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; self.pairs.len()];
        for edge in &self.edges {
            let [i, j] = edge.pairs.map(|k| k as usize);
            forces[i] += edge.length / 6.0 * (2.0 * p[i] + p[j]);
            forces[j] += edge.length / 6.0 * (p[i] + 2.0 * p[j]);
        }
        forces
    }

    /// Exchanges the two bodies' roles: pairs, edges and sides swap, normals turn round.
    pub fn swapped(mut self) -> Self {
        for pair in &mut self.pairs {
            pair.nodes.reverse();
            pair.normal = [-pair.normal[0], -pair.normal[1]];
        }
        for edge in &mut self.edges {
            edge.edges.reverse();
        }
        self.measured_on = 1 - self.measured_on;
        self.sides.reverse();
        for side in &mut self.sides {
            for n in &mut side.normals {
                *n = [-n[0], -n[1]];
            }
        }
        self
    }
}

/// Two bodies and the interface between them. Index 0 is Ω₁ (λ imposed), index 1 is Ω₂ (unilateral).
#[derive(Clone, Debug)]
pub struct ContactProblem {
    /// The bodies.
    pub bodies: [Body; 2],
    /// The interface.
    pub interface: ContactInterface,
}

impl ContactProblem {
    /// Exchanges the two bodies' roles.
    pub fn swapped(self) -> Self {
        let [first, second] = self.bodies;
        Self { bodies: [second, first], interface: self.interface.swapped() }
    }
}

/// A pair of displacement fields with the nodal contact forces that belong to it, whoever computed it.
#[derive(Clone, Copy, Debug)]
pub struct ContactState<'a> {
    /// Nodal displacements of the two bodies, Cartesian, m.
    pub displacement: [&'a [Vector]; 2],
    /// Contact force on Ω₂ at each pair, `r²_i ≥ 0`, N/m.
    pub contact_force: &'a [f64],
    /// Opening `o_i = g_i − (v¹_i − v²_i) ≥ 0` at each pair, m.
    pub opening: &'a [f64],
}

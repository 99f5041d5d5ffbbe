//! A body cut into subdomains: each is condensed on the displacements that it shares with others, and on its contact directions.
//!
//! Subdomains of one body are bonded bodies: an unknown at a node that several of them share is one displacement. All of them have the same frame there,
//! so equal numbers in [`Subdomain::shared`] mean equal unknowns. With all `S_α` condensed, the body is
//! ```math
//! S = Σ_α N_αᵀ S_α N_α,   g̃ = Σ_α N_αᵀ g̃_α
//! ```

use crate::assembly::{AssemblyError, System, external_forces, spring_forces};
use crate::body::Body;
use crate::condensation::{CondensationError, CondensedBody};
use crate::directions::Directions;
use crate::dof::{DofMap, TraceRow};
use crate::geometry::{Coordinates, PARALLEL, norm};
use crate::interface::{InterfaceSide, Retained};
use crate::mesh::MeshError;
use crate::mesh::id::NodeId;
use crate::parallel::try_each_body;
use crate::space::{Plane, Space};
use std::collections::BTreeMap;

/// Why a subdomain could not be factorised.
#[derive(Debug)]
pub(crate) enum FactorError {
    /// Its cells make no mesh.
    Mesh(MeshError),
    /// It cannot be assembled.
    Assembly(AssemblyError),
    /// Its stiffness cannot be factorised.
    Condensation(CondensationError),
}

/// A body cut into subdomains.
#[derive(Clone, Debug)]
pub struct CutBody<S: Space = Plane> {
    subdomains: Vec<Subdomain<S>>,
    /// The first subdomain with each node, and the number of the node there.
    homes: Vec<(u32, NodeId)>,
    /// Of each retained direction, block by block: its place among those of the same block in the home of its node.
    places: Vec<Vec<(u32, u32)>>,
    unknowns: usize,
}

/// A connected part of a body, condensed on its shared displacements and its contact directions.
#[derive(Clone, Debug)]
pub struct Subdomain<S: Space = Plane> {
    /// Its nodes by their numbers in the body, ascending.
    pub nodes: Vec<NodeId>,
    /// Its stiffness; on springs at interface unknowns if it floats.
    pub condensed: CondensedBody<S>,
    /// The number of each interface unknown: unknowns of several subdomains with one number are one displacement.
    pub shared: Vec<u32>,
    /// The diagonal of its stiffness at the interface unknowns, N/m², by which forces are shared.
    pub stiffness: Vec<f64>,
    /// The rigid motions that its own supports leave free: the displacement of each of its nodes.
    pub free: Vec<Vec<S::Vector>>,
    /// All rigid motions in its interface unknowns, without what supports impose; empty if all of them are free.
    pub rigid: Vec<Vec<f64>>,
    /// The load along each of `free`, N/m.
    pub loads: Vec<f64>,
}

/// Tells whether a body may be cut into subdomains: neither a rigid side nor a cut of a bolt ties its nodes.
pub fn may_be_cut<S: Space>(body: &Body<S>) -> bool {
    body.rigid_sides().is_empty() && body.cuts().is_empty()
}

impl<S: Space> CutBody<S> {
    /// Cuts a body and factorises its subdomains, in parallel.
    ///
    /// * `side`: its contact directions; `count`: how many subdomains are wanted.
    ///
    /// # Errors
    /// A subdomain without unknowns or with overflowing data; a stiffness that is not positive definite.
    pub(crate) fn new(body: &Body<S>, side: &InterfaceSide<S>, count: usize) -> Result<Self, FactorError> {
        let cells = body.mesh().subdomains(count);
        let nodes: Vec<Vec<NodeId>> = cells.iter().map(|cells| body.mesh().nodes_of(cells)).collect();
        let count = body.mesh().points().len();
        let (mut homes, mut uses) = (vec![(u32::MAX, NodeId::default()); count], vec![0u32; count]);
        for (k, nodes) in nodes.iter().enumerate() {
            for (own, node) in nodes.iter().enumerate() {
                uses[*node] += 1;
                if homes[*node].0 == u32::MAX {
                    homes[*node] = (k as u32, NodeId::new(own));
                }
            }
        }
        let directions = RetainedByNode::new(body, side, &uses);
        let sides: Vec<NumberedBlocks<S>> =
            nodes.iter().map(|nodes| directions.of_subdomain(nodes, side.blocks())).collect();
        let subdomains = try_each_body(cells.len(), |k| {
            let blocks = sides[k].iter().map(|block| block.iter().map(|(_, retained)| *retained));
            let side = blocks.fold(InterfaceSide::default(), InterfaceSide::with_block);
            Subdomain::new(body, &side, (&nodes[k], &cells[k]))
        })?;
        let mut places: Vec<Vec<(u32, u32)>> =
            (0..side.blocks()).map(|block| vec![(0, 0); side.block(block).len()]).collect();
        for (k, blocks) in sides.iter().enumerate() {
            for (places, own) in places.iter_mut().zip(blocks) {
                for (place, (number, retained)) in own.iter().enumerate() {
                    if homes[nodes[k][retained.node.index()]].0 == k as u32 {
                        places[*number as usize] = (k as u32, place as u32);
                    }
                }
            }
        }
        let inner: usize = subdomains.iter().map(|of| of.condensed.dofs().len() - of.shared.len()).sum();
        let mut numbers: Vec<u32> = subdomains.iter().flat_map(|of| of.shared.iter().copied()).collect();
        numbers.sort_unstable();
        numbers.dedup();
        Ok(Self { subdomains, homes, places, unknowns: inner + numbers.len() })
    }

    /// Returns the subdomains.
    pub fn subdomains(&self) -> &[Subdomain<S>] {
        &self.subdomains
    }

    /// Counts the nodes of the body.
    pub fn nodes(&self) -> usize {
        self.homes.len()
    }

    /// Counts the unknowns of the body; shared ones count once.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Returns the trace along each contact direction of a block, with the subdomain that has it.
    ///
    /// # Panics
    /// If there is no such block.
    pub fn rows(&self, block: usize) -> impl Iterator<Item = (usize, &TraceRow)> + '_ {
        let row = move |&(home, place): &(u32, u32)| {
            let dofs = self.subdomains[home as usize].condensed.dofs();
            (home as usize, &dofs.rows(block)[place as usize])
        };
        self.places[block].iter().map(row)
    }

    /// Shares values at the nodes of the body among its subdomains: each goes to the first one that has the node.
    ///
    /// * `values`: by node; `zero`: at the nodes of other subdomains.
    pub fn at_homes<T: Copy>(&self, values: &[T], zero: T) -> Vec<Vec<T>> {
        let of = |(k, of): (usize, &Subdomain<S>)| {
            let own =
                |node: &NodeId| if self.homes[*node].0 == k as u32 { values[node.index()] } else { zero };
            of.nodes.iter().map(own).collect()
        };
        self.subdomains.iter().enumerate().map(of).collect()
    }

    /// Joins the displacements of the subdomains: at a shared node that of the first one.
    ///
    /// * `fields`: by subdomain, each by node.
    pub fn joined(&self, fields: &[Vec<S::Vector>]) -> Vec<S::Vector> {
        self.homes.iter().map(|(k, node)| fields[*k as usize][node.index()]).collect()
    }
}

impl<S: Space> Subdomain<S> {
    /// * `side`: its retained directions, shared nodes last.
    fn new(
        body: &Body<S>,
        side: &InterfaceSide<S>,
        (nodes, cells): (&[NodeId], &[u32]),
    ) -> Result<Self, FactorError> {
        let part = body.part(nodes, cells).map_err(FactorError::Mesh)?;
        let dofs = DofMap::new(&part, side);
        let (system, stiffness) =
            System::stabilised_on_interface(&part, dofs).map_err(FactorError::Assembly)?;
        let condensed =
            CondensedBody::factorise(system, part.mesh().points()).map_err(FactorError::Condensation)?;
        let dofs = condensed.dofs();
        let interface = dofs.len() - dofs.interface_len()..dofs.len();
        let number = |unknown: usize| {
            let (node, c) = dofs.unknown(unknown);
            (S::DIM * nodes[node].index() + c) as u32
        };
        let free: Vec<Vec<S::Vector>> =
            part.rigid_motions().iter().map(|motion| motion.displacements(&part)).collect();
        let mut forces = external_forces(&part);
        spring_forces(&part, &[]).for_each(|(node, force)| forces[node] += force);
        let load = |moved: &Vec<S::Vector>| forces.iter().zip(moved).map(|(f, u)| f.times(u)).sum();
        let loads = free.iter().map(load).collect();
        let rigid = rigid_motions(&part, dofs, free.len());
        let shared = interface.map(number).collect();
        Ok(Self { nodes: nodes.to_vec(), shared, stiffness, free, rigid, loads, condensed })
    }
}

/// Returns all rigid motions of a body in its interface unknowns, without what supports impose; none if all of them are free.
///
/// * `free`: how many of them its supports leave free.
pub(crate) fn rigid_motions<S: Space>(body: &Body<S>, dofs: &DofMap<S>, free: usize) -> Vec<Vec<f64>> {
    if free == S::COMPONENTS {
        return Vec::new();
    }
    let points = body.mesh().points();
    let centre = points.iter().copied().sum::<S::Vector>() / points.len().max(1) as f64;
    let of = |k: usize| {
        let (translation, spin) = S::parts(&S::components(|j| if j == k { 1.0 } else { 0.0 }));
        dofs.interface_components(|node| translation + S::turned(spin, points[node] - centre))
    };
    (0..S::COMPONENTS).map(of).collect()
}

/// Directions block by block, each with its number in the block of the body.
type NumberedBlocks<S> = Vec<Vec<(u32, Retained<S>)>>;

/// The directions that nodes retain.
struct RetainedByNode<S: Space> {
    /// The contact directions of the nodes that have some: block, number there, direction.
    contact: BTreeMap<NodeId, Vec<(usize, u32, S::Vector)>>,
    /// What else a shared node retains, so that all that supports do not hold is retained: by node, empty for the others.
    rest: Vec<Directions<S>>,
}

impl<S: Space> RetainedByNode<S> {
    /// * `uses`: by node, in how many subdomains it is.
    fn new(body: &Body<S>, side: &InterfaceSide<S>, uses: &[u32]) -> Self {
        let mut known: Vec<Directions<S>> = body.node_constraints().iter().map(|of| of.held).collect();
        let mut contact: BTreeMap<NodeId, Vec<(usize, u32, S::Vector)>> = BTreeMap::new();
        for block in 0..side.blocks() {
            for (number, &Retained { node, direction }) in
                side.retained()[side.block(block)].iter().enumerate()
            {
                contact.entry(node).or_default().push((block, number as u32, direction));
                let of = &mut known[node.index()];
                *of = of.with(direction / norm(direction), PARALLEL);
            }
        }
        let rest = |(known, uses): (&Directions<S>, &u32)| match *uses > 1 {
            true => known.complement(),
            false => Directions::NONE,
        };
        Self { contact, rest: known.iter().zip(uses).map(rest).collect() }
    }

    /// Lists the directions of a subdomain, block by block, in its own numbers, each with its number in the block of the body. The last block has those
    /// of shared nodes.
    fn of_subdomain(&self, nodes: &[NodeId], blocks: usize) -> NumberedBlocks<S> {
        let mut found = vec![Vec::new(); blocks + 1];
        for (own, node) in nodes.iter().enumerate() {
            let node_here = NodeId::new(own);
            for &(block, number, direction) in self.contact.get(node).into_iter().flatten() {
                found[block].push((number, Retained { node: node_here, direction }));
            }
            for &direction in self.rest[node.index()].basis() {
                found[blocks].push((0, Retained { node: node_here, direction }));
            }
        }
        found[..blocks].iter_mut().for_each(|block| block.sort_by_key(|(number, _)| *number));
        found
    }
}

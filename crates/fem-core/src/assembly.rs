//! Assembles stiffness and load of a body: `K u = f` in the unknowns of a [`DofMap`].
//!
//! Every column is gathered separately from the cells around its node, in a fixed order: columns run
//! in parallel and the result does not depend on the number of threads, bit for bit.

mod springs;

pub use springs::spring_forces;

use crate::body::{Body, FreeMotion, RigidMotion, moments};
use crate::dof::{DofMap, IMPOSED};
use crate::element::{Block, Element};
use crate::geometry::Coordinates;
use crate::interface::InterfaceSide;
use crate::memory::fits_in_memory;
use crate::mesh::id::NodeId;
use crate::space::{Plane, Space};
use crate::sparse::SymmetricCsc;
use rayon::prelude::*;
use springs::SpringsAround;
use std::ops::Range;
use thiserror::Error;

/// Why a body cannot be assembled.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AssemblyError {
    /// The supports leave a rigid motion free, so the displacement is not unique.
    #[error("the body {motion} (piece at {}); support it in that direction", motion.near())]
    Floating {
        /// The motion.
        motion: FreeMotion,
    },
    /// Every displacement is imposed: there are no unknowns.
    #[error("every displacement of the body is imposed; there are no unknowns")]
    NothingUnknown,
    /// The matrix has more entries than 32-bit numbers can address.
    #[error("the stiffness matrix has {entries} entries; at most {limit} are supported")]
    TooLarge {
        /// Entries of the lower triangle.
        entries: usize,
        /// Largest supported number.
        limit: usize,
    },
    /// The stiffness matrix does not fit in memory.
    #[error("the stiffness matrix of {entries} entries does not fit in memory")]
    OutOfMemory {
        /// Entries of the lower triangle.
        entries: usize,
    },
    /// Stiffness or load overflow.
    #[error("{what} of the body is not finite; check the size of moduli, coordinates and loads")]
    NotFinite {
        /// "the stiffness" or "the load".
        what: &'static str,
    },
}

/// The assembled problem of one body: lower triangle of `K`, and `f` with the imposed displacements moved
/// to the right-hand side.
#[derive(Clone, Debug)]
pub struct System<S: Space = Plane> {
    /// The unknowns.
    pub dofs: DofMap<S>,
    /// Stiffness, N/m² in the plane, N/m in space.
    pub stiffness: SymmetricCsc,
    /// Load, N/m in the plane, N in space.
    pub load: Vec<f64>,
}

impl<S: Space> System<S> {
    /// Numbers the unknowns of a body, with the interface unknowns of `side` last, and assembles it.
    ///
    /// # Errors
    /// A floating body, with its free motion; a body without unknowns; a body with overflowing data.
    pub fn assemble(body: &Body<S>, side: &InterfaceSide<S>) -> Result<Self, AssemblyError> {
        Self::with_dofs(body, DofMap::new(body, side))
    }

    /// Assembles a body in given unknowns.
    ///
    /// # Errors
    /// See [`Self::assemble`].
    pub fn with_dofs(body: &Body<S>, dofs: DofMap<S>) -> Result<Self, AssemblyError> {
        if let Some(motion) = body.free_motion() {
            return Err(AssemblyError::Floating { motion });
        }
        Self::bare(body, dofs)
    }

    /// Assembles a body that may float: each rigid motion that its supports leave free gets a spring at one unknown, as
    /// stiff as the unknown itself. The springs are chosen so that no rigid motion leaves all of them unloaded, and as many as
    /// there are motions: so forces in balance do not load them, and the solution is one of the body alone.
    ///
    /// # Errors
    /// A body without unknowns; a body with overflowing data.
    pub fn stabilised(body: &Body<S>, dofs: DofMap<S>) -> Result<Self, AssemblyError> {
        let all = 0..dofs.len();
        let mut system = Self::bare(body, dofs)?;
        system.put_springs(body, all);
        Ok(system)
    }

    /// [`Self::stabilised`] with all springs on the interface: inside, the stiffness is that of the body alone. Returns also the diagonal of that stiffness
    /// on the interface.
    pub(crate) fn stabilised_on_interface(
        body: &Body<S>,
        dofs: DofMap<S>,
    ) -> Result<(Self, Vec<f64>), AssemblyError> {
        let interface = dofs.len() - dofs.interface_len()..dofs.len();
        let mut system = Self::bare(body, dofs)?;
        // The diagonal comes first in its column.
        let diagonal = |unknown: usize| system.stiffness.values[system.stiffness.starts[unknown] as usize];
        let diagonal = interface.clone().map(diagonal).collect();
        system.put_springs(body, interface);
        Ok((system, diagonal))
    }

    /// * `among`: the unknowns that may have a spring.
    fn put_springs(&mut self, body: &Body<S>, among: Range<usize>) {
        let system = self;
        for unknown in stabilised_unknowns(body, &system.dofs, among) {
            let SymmetricCsc { starts, rows, values } = &mut system.stiffness;
            let column = starts[unknown] as usize..starts[unknown + 1] as usize;
            for entry in column.filter(|entry| rows[*entry] as usize == unknown) {
                values[entry] *= 2.0;
            }
        }
    }

    fn bare(body: &Body<S>, dofs: DofMap<S>) -> Result<Self, AssemblyError> {
        if dofs.is_empty() {
            return Err(AssemblyError::NothingUnknown);
        }
        let mut external = external_forces(body);
        spring_forces(body, &[]).for_each(|(node, force)| external[node] += force);
        add_initial_strain(body, &mut external);
        let (first_beside, beside) = body.mesh().topology().node_neighbours();
        let springs = SpringsAround::new(body);
        let columns = Columns { body, dofs: &dofs, external: &external, springs, first_beside, beside };
        let starts = columns.starts()?;
        debug_assert!(starts.is_sorted(), "the columns of the stiffness overlap");
        let entries = starts[dofs.len()] as usize;
        if !fits_in_memory(entries.saturating_mul(size_of::<u32>() + size_of::<f64>())) {
            return Err(AssemblyError::OutOfMemory { entries });
        }
        let mut rows = vec![0u32; entries];
        let mut values = vec![0.0; rows.len()];
        let mut load = vec![0.0; dofs.len()];
        columns.fill(&starts, &mut rows, &mut values, &mut load);
        for (what, numbers) in [("the stiffness", &values), ("the load", &load)] {
            if !numbers.iter().all(|x| x.is_finite()) {
                return Err(AssemblyError::NotFinite { what });
            }
        }
        Ok(Self { stiffness: SymmetricCsc { starts, rows, values }, load, dofs })
    }
}

/// A node with several directions is chosen for a spring only if all others move by less than this fraction of it.
const PREFERRED: f64 = 0.1;

/// Chooses one unknown per rigid motion of a floating body, by elimination with pivots: the unknown that moves most, then
/// the one that moves most in what the springs so far leave free. If nearly all nodes have several directions, as at corners of two
/// pairs, the others do not move in every motion.
fn stabilised_unknowns<S: Space>(body: &Body<S>, dofs: &DofMap<S>, among: Range<usize>) -> Vec<usize> {
    let mut motions = body.rigid_motions();
    if motions.is_empty() {
        return Vec::new();
    }
    let (piece_of, _) = body.mesh().topology().pieces();
    let points = body.mesh().points();
    let moved = |motion: &RigidMotion<S>, unknown: usize| {
        let (node, c) = dofs.unknown(unknown);
        let moves = piece_of[node] == motion.piece && !dofs.is_rigid(unknown);
        if moves { dofs.component(node, c, motion.at(points[node])) } else { 0.0 }
    };
    let mut chosen = Vec::new();
    while let Some(last) = motions.pop() {
        let most = |unknown: &usize| moved(&last, *unknown).abs();
        let weighted = |unknown: &usize| {
            let preferred = dofs.is_orthonormal(dofs.unknown(*unknown).0);
            most(unknown) * if preferred { 1.0 } else { PREFERRED }
        };
        let Some(unknown) = among.clone().max_by(|i, j| weighted(i).total_cmp(&weighted(j))) else { break };
        chosen.push(unknown);
        // The other motions of the piece, combined with this one so that they do not move the unknown.
        for motion in motions.iter_mut().filter(|motion| motion.piece == last.piece) {
            let part = moved(motion, unknown) / moved(&last, unknown);
            motion.translation -= last.translation * part;
            motion.spin -= last.spin * part;
        }
    }
    chosen
}

/// Computes the nodal forces of tractions, body force and the loads of rigid sides, Cartesian, N/m in the plane, N in space.
pub fn external_forces<S: Space>(body: &Body<S>) -> Vec<S::Vector> {
    let mesh = body.mesh();
    let mut forces = vec![S::Vector::ZERO; mesh.points().len()];
    for (condition, &facet) in body.facet_conditions().iter().zip(mesh.topology().boundary_facets()) {
        let traction = condition.traction;
        if traction == S::ZEROS {
            continue;
        }
        let moments = moments::<S>(&traction, mesh.facet_measure(facet));
        for (node, moment) in mesh.topology().facets()[facet].into_iter().zip(moments) {
            forces[node] += moment;
        }
    }
    for (node, force) in body.rigid_forces() {
        forces[node] += force;
    }
    if body.has_force() {
        for (t, corners) in mesh.cells().iter().enumerate() {
            for (n, force) in corners.into_iter().zip(body.nodal_forces_inside(t)) {
                forces[n] += force;
            }
        }
    }
    forces
}

/// Adds the nodal forces of the initial strain, `∫ E ε₀ : ε(φ)`: loads of the displacements, but no external forces.
fn add_initial_strain<S: Space>(body: &Body<S>, forces: &mut [S::Vector]) {
    if !body.has_initial_strain() {
        return;
    }
    for (t, corners) in body.mesh().cells().iter().enumerate() {
        let stress = body.material(t).stress(body.initial_strain(t));
        let own = Element::<S>::new(body.mesh().corners(t)).internal_forces(stress);
        corners.into_iter().zip(own).for_each(|(n, force)| forces[n] += force);
    }
}

/// Columns of the stiffness, node by node.
struct Columns<'a, S: Space> {
    body: &'a Body<S>,
    dofs: &'a DofMap<S>,
    external: &'a [S::Vector],
    springs: SpringsAround,
    /// The beginning of each node's list in `beside`.
    first_beside: Vec<u32>,
    /// The nodes joined to each node by a cell, ascending.
    beside: Vec<NodeId>,
}

/// Columns handled as one unit of parallel work.
const CHUNK: usize = 2048;

impl<S: Space> Columns<'_, S> {
    /// The nodes joined to `node` by a cell.
    fn beside(&self, node: usize) -> &[NodeId] {
        &self.beside[self.first_beside[node] as usize..self.first_beside[node + 1] as usize]
    }

    /// The nodes joined to `node` by a cell, and the node itself.
    fn around(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        self.beside(node).iter().map(|n| n.index()).chain([node])
    }

    /// Lists the unknowns of rigid sides that a node or one beside it follows, ascending.
    fn followed(&self, node: usize) -> Vec<usize> {
        if !self.dofs.has_rigid() {
            return Vec::new();
        }
        let mut all: Vec<usize> =
            self.around(node).flat_map(|n| self.dofs.followed(n).map(|(i, _)| i)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Lists the rows from the diagonal on in the column of a rigid side's unknown.
    fn below_rigid(&self, j: usize) -> Vec<usize> {
        let mut all = Vec::new();
        for (node, _) in self.dofs.moved(j) {
            let numbers = self.around(node).flat_map(|n| (0..S::DIM).map(move |c| self.dofs.number(n, c)));
            all.extend(numbers.filter(|i| *i != IMPOSED).map(|i| i as usize));
            all.extend(self.followed(node));
        }
        all.sort_unstable();
        all.dedup();
        all.retain(|i| *i >= j);
        all
    }

    fn starts(&self) -> Result<Vec<u32>, AssemblyError> {
        let counts: Vec<u32> = (0..self.dofs.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|j| {
                if self.dofs.is_rigid(j) {
                    return self.below_rigid(j).len() as u32;
                }
                let node = self.dofs.unknown(j).0;
                let rigid = self.followed(node).into_iter().filter(|i| *i >= j).count() as u32;
                let below = |n: usize, c| {
                    let i = self.dofs.number(n, c);
                    u32::from(i != IMPOSED && i as usize >= j)
                };
                let of_node = |n: usize| (0..S::DIM).map(|c| below(n, c)).sum::<u32>();
                rigid + self.around(node).map(of_node).sum::<u32>()
            })
            .collect();
        let entries: usize = counts.iter().map(|&c| c as usize).sum();
        if entries > u32::MAX as usize {
            return Err(AssemblyError::TooLarge { entries, limit: u32::MAX as usize });
        }
        let mut starts = Vec::with_capacity(counts.len() + 1);
        let mut total = 0;
        starts.push(0);
        for c in counts {
            total += c;
            starts.push(total);
        }
        Ok(starts)
    }

    fn fill(&self, starts: &[u32], rows: &mut [u32], values: &mut [f64], load: &mut [f64]) {
        // Split the arrays at the chunks' ends, so that each task owns its slice.
        let mut tasks = Vec::new();
        let (mut rows, mut values) = (rows, values);
        for (k, load) in load.chunks_mut(CHUNK).enumerate() {
            let first = k * CHUNK;
            let size = (starts[first + load.len()] - starts[first]) as usize;
            let (r, rest) = rows.split_at_mut(size);
            rows = rest;
            let (v, rest) = values.split_at_mut(size);
            values = rest;
            tasks.push((first, load, r, v));
        }
        tasks.into_par_iter().for_each(|(first, load, rows, values)| {
            let mut gather = Gather::default();
            let mut filled = 0;
            for (offset, f) in load.iter_mut().enumerate() {
                gather.entries.clear();
                *f = if self.dofs.is_rigid(first + offset) {
                    let moved = self.dofs.moved(first + offset);
                    moved.map(|(node, axis)| gather.column(self, first + offset, node, axis)).sum()
                } else {
                    let (node, c) = self.dofs.unknown(first + offset);
                    gather.column(self, first + offset, node, self.dofs.axis(node, c))
                };
                gather.finish();
                for &(i, value) in &gather.entries {
                    rows[filled] = i;
                    values[filled] = value;
                    filled += 1;
                }
            }
        });
    }
}

/// Work space of one thread: the blocks of one node's columns, reused for its other columns.
#[derive(Default)]
struct Gather<S: Space> {
    node: Option<usize>,
    /// In the order of [`Columns::around`].
    blocks: Vec<Block<S>>,
    entries: Vec<(u32, f64)>,
}

impl<S: Space> Gather<S> {
    /// Computes the blocks `K_{b,node}` for all neighbours `b`, Cartesian.
    fn node(&mut self, columns: &Columns<'_, S>, node: usize) {
        if self.node == Some(node) {
            return;
        }
        self.node = Some(node);
        let beside = columns.beside(node);
        self.blocks.clear();
        self.blocks.resize(beside.len() + 1, S::ZEROS);
        let mesh = columns.body.mesh();
        for &t in mesh.topology().cells_around(NodeId::new(node)) {
            let t = t as usize;
            let corners = mesh.cells()[t];
            let element = Element::<S>::new(mesh.corners(t));
            let material = columns.body.material(t);
            let Some(column) = corners.into_iter().position(|n| n.index() == node) else {
                unreachable!("node {node} is not one of the corners {corners:?} of cell {t}")
            };
            for (row, block) in element.stiffness_column(material, column).into_iter().enumerate() {
                // The node itself comes last.
                let place = if row == column {
                    beside.len()
                } else if let Some(place) = beside.iter().position(|n| *n == corners[row]) {
                    place
                } else {
                    unreachable!("node {} of cell {t} is not beside node {node}", corners[row])
                };
                for c in 0..S::DIM {
                    self.blocks[place][c] += block[c];
                }
            }
        }
        self.add_springs(columns, NodeId::new(node));
    }

    /// Adds the blocks of the springs on the facets around a node.
    fn add_springs(&mut self, columns: &Columns<'_, S>, node: NodeId) {
        let (body, beside) = (columns.body, columns.beside(node.index()));
        for facet in columns.springs.of(node) {
            let Some(condition) = body.facet_condition(facet) else { continue };
            let share = body.mesh().facet_measure(facet) / (S::DIM * (S::DIM + 1)) as f64;
            for other in body.mesh().topology().facets()[facet] {
                let (place, share) = match beside.binary_search(&other) {
                    Ok(place) => (place, share),
                    Err(_) => (beside.len(), 2.0 * share),
                };
                for c in 0..S::DIM {
                    self.blocks[place][c] += condition.springs.stiffness[c] * share;
                }
            }
        }
    }

    /// Adds to `entries` the lower part of column `j` under a displacement of one node, and returns its load.
    fn column(&mut self, columns: &Columns<'_, S>, j: usize, node: usize, axis: S::Vector) -> f64 {
        self.node(columns, node);
        let dofs = columns.dofs;
        let mut load = columns.external[node].times(&axis);
        for (n, block) in columns.around(node).zip(&self.blocks) {
            let force = (1..S::DIM).fold(block[0] * axis[0], |sum, c| sum + block[c] * axis[c]);
            for d in 0..S::DIM {
                let entry = || dofs.axis(n, d).times(&force);
                match dofs.number(n, d) {
                    IMPOSED => load -= entry() * dofs.imposed(n, d),
                    i if i as usize >= j => self.entries.push((i, entry())),
                    _ => {}
                }
            }
            if dofs.has_rigid() {
                let followed = dofs.followed(n).filter(|(i, _)| *i >= j);
                self.entries.extend(followed.map(|(i, per_unit)| (i as u32, per_unit.times(&force))));
            }
        }
        load
    }

    /// Sorts the entries of a column by rows, each row once.
    fn finish(&mut self) {
        self.entries.sort_by_key(|e| e.0);
        self.entries.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryConditions;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    fn body(conditions: BoundaryConditions, cells: [usize; 2]) -> Body {
        let material = LinearElastic::isotropic(10.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(block([0.0, 0.0], [2.0, 1.0], cells).unwrap(), material, &conditions).unwrap()
    }

    #[test]
    fn assembly_does_not_depend_on_threads() {
        let b = body(BoundaryConditions::new().fix("bottom").pressure("top", 3.0), [40, 40]);
        let systems: Vec<System> = [1, 2, 7]
            .into_iter()
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| System::assemble(&b, &InterfaceSide::default()).unwrap())
            })
            .collect();
        for s in &systems[1..] {
            assert_eq!(s.stiffness, systems[0].stiffness);
            assert_eq!(s.load, systems[0].load);
        }
    }

    #[test]
    fn stiffness_annihilates_what_it_should() {
        // Imposed rigid rotation on the whole boundary of a body: the solution of K x = f is that rotation.
        let rotation = |b: BoundaryConditions, side: &str| {
            b.displace(
                side,
                Some(crate::boundary::ScalarData::function(|x| -x[1])),
                Some(crate::boundary::ScalarData::function(|x| x[0])),
            )
        };
        let mut c = BoundaryConditions::new();
        for side in ["bottom", "right", "top", "left"] {
            c = rotation(c, side);
        }
        let b = body(c, [6, 4]);
        let s = System::assemble(&b, &InterfaceSide::default()).unwrap();
        let exact: Vec<f64> = (0..s.dofs.len())
            .map(|j| {
                let (node, c) = s.dofs.unknown(j);
                let x = b.mesh().points()[node];
                crate::geometry::perpendicular(x).dot(&s.dofs.axis(node, c))
            })
            .collect();
        let residual = s.stiffness.multiply(&exact);
        for (r, f) in residual.iter().zip(&s.load) {
            assert!((r - f).abs() < 1e-12);
        }
    }

    #[test]
    fn a_floating_body_is_named() {
        let b = body(BoundaryConditions::new().roller("bottom", 0.0), [2, 2]);
        let e = System::assemble(&b, &InterfaceSide::default()).unwrap_err();
        assert!(e.to_string().contains("can translate along"), "{e}");
    }
}

//! A body: mesh, material and the boundary conditions evaluated on the mesh.

mod conditions;
mod constraint;
mod curves;
mod cuts;
mod error;
mod facet_functions;
mod force;
mod heat;
mod inside;
mod interpolation;
mod joined;
mod motion;
mod onto_surfaces;
mod part;
mod rigid;
mod springs;
mod surfaces;

use crate::boundary::{BoundaryConditions, Support};
use crate::directions::Directions;
use crate::geometry::{Point, perpendicular};
use crate::material::{LinearElastic, Materials};
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::refine::Refinement;
use crate::rigid_line::RigidLine;
use crate::space::{Plane, Space};
use std::collections::BTreeMap;
use std::sync::OnceLock;

pub use crate::boundary::{ConditionList, ConditionPlace};
pub use constraint::NodeConstraint;
pub use curves::Piece;
pub use curves::{CurveKind, CurvedSide};
pub use cuts::Cut;
pub(crate) use cuts::PERPENDICULAR;
pub use error::BodyError;
pub use facet_functions::{moments, tractions};
pub use force::{CellForce, arms};
pub use inside::InsideDifference;
pub(crate) use interpolation::Sum as DifferenceSum;
pub use interpolation::{DataDifference, Difference, SAMPLES};
pub use joined::JoinError;
pub(crate) use joined::Merged;
pub use motion::{FreeMotion, RigidMotion};
pub use onto_surfaces::{FinerBody, move_onto_surfaces};
pub use rigid::RigidSide;
pub use springs::{FacetSprings, SpringFacet, SpringSide};
pub use surfaces::{DeclaredSurface, SurfaceKind};

/// The condition on one boundary facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetCondition<S: Space = Plane> {
    /// The directions in which the traction is an unknown reaction: none on a Neumann facet, one on a roller, all on a clamped facet or one of a
    /// rigid side. Springs do not count here.
    pub reaction: Directions<S>,
    /// Given traction at the facet's nodes (in the order of [`crate::mesh::topology::Topology::facets`]), Pa;
    /// linear between them. Zero in the directions of a support's reaction.
    pub traction: S::Axes<S::Vector>,
    /// Springs on the facet. Their traction is not part of the given one.
    pub springs: FacetSprings<S>,
}

impl<S: Space> FacetCondition<S> {
    /// Neither a load nor a support.
    pub const FREE: Self =
        Self { reaction: Directions::NONE, traction: S::ZEROS, springs: FacetSprings::NONE };

    /// Returns the directions in which supports and springs carry the traction: in all others it is given.
    pub fn carried(&self) -> Directions<S> {
        self.reaction.joined(&self.springs.directions, conditions::SAME_DIRECTION)
    }

    /// Returns the directions in which the traction is given or springs carry it.
    pub fn given_or_on_springs(&self) -> Directions<S> {
        self.reaction.complement().joined(&self.springs.directions, conditions::SAME_DIRECTION)
    }

    /// Returns the given traction and that of the springs in their stretch, Pa.
    pub fn expected_traction(&self) -> S::Axes<S::Vector> {
        if self.springs.directions.is_none() {
            return self.traction;
        }
        let of_springs = self.springs.traction();
        S::axes(|k| self.traction[k] + of_springs[k])
    }
}

/// The nodes of one displacement condition, and how it holds them. A support on a single node has one node, any other at least two.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportSet<S: Space = Plane> {
    /// The group of facets the condition names.
    pub group: String,
    /// Nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The directions in which it holds each node.
    pub reactions: Vec<Directions<S>>,
}

/// Returns the facets of a declared side.
///
/// # Errors
/// No such group, one without facets, or with facets inside the body.
fn group<'a, S: Space>(
    mesh: &'a Mesh<S>,
    name: &str,
    place: ConditionPlace,
) -> Result<&'a [FacetId], BodyError> {
    let (group, words) = (name.to_owned(), S::WORDS);
    let Some(facets) = mesh.group(name) else {
        let names: Vec<&str> = mesh.groups().keys().map(String::as_str).collect();
        return Err(BodyError::UnknownGroup { place, group, known: names.join(", "), words });
    };
    if let Some(&facet) = facets.iter().find(|facet| !mesh.topology().is_boundary(**facet)) {
        let corners = mesh.facet_corners(facet).as_ref().iter().map(|x| Point::from(*x)).collect();
        return Err(BodyError::InteriorFacet { place, group, corners, words });
    }
    if facets.is_empty() {
        return Err(BodyError::EmptySelection { place, group, words });
    }
    Ok(facets)
}

/// A body: mesh, material and evaluated boundary conditions. It is not assembled: see
/// [`crate::assembly::System`].
#[derive(Clone, Debug)]
pub struct Body<S: Space = Plane> {
    mesh: Mesh<S>,
    materials: Materials<S>,
    node_constraints: Vec<NodeConstraint<S>>,
    /// By position in `mesh.topology().boundary_facets()`.
    facet_conditions: Vec<FacetCondition<S>>,
    /// Nodes of each displacement condition.
    supports: Vec<SupportSet<S>>,
    rigid_sides: Vec<RigidSide<S>>,
    springs: Vec<SpringSide<S>>,
    /// See [`Body::roller_turn`].
    roller_turn: f64,
    /// The change of temperature at each node; empty without heat.
    temperature: Vec<f64>,
    cuts: Vec<Cut<S>>,
    /// The initial strain of each cell by the cuts; empty without cuts.
    cut_strains: Vec<S::Tensor>,
    /// The body force of each cell; empty if it is constant.
    forces: Vec<CellForce<S>>,
    /// The conditions and their facets, to evaluate them again on a finer mesh.
    conditions: BoundaryConditions<S>,
    selected: conditions::Selected,
    /// None in space.
    curves: curves::Curves,
    /// None in the plane.
    surfaces: BTreeMap<FacetId, RigidLine<S>>,
    /// See [`Body::is_inserted`]; ascending.
    inserted: Vec<NodeId>,
    /// Computed on the first request: the checks before a run and the assembly both need it.
    free_motion: OnceLock<Option<FreeMotion>>,
}

impl<S: Space> Body<S> {
    /// Evaluates boundary conditions on a mesh.
    ///
    /// Displacements are interpolated at the nodes. Tractions become linear on each edge by their two
    /// moments `∫ F φ_i ds` (five-point Gauss), which is exact for linear ones.
    ///
    /// * `materials`: one [`LinearElastic`] for the whole body, or [`Materials`] by cell.
    ///
    /// # Errors
    /// Conditions without edges, contradictory or non-finite ones, see [`BodyError`].
    pub fn new(
        mesh: Mesh<S>,
        materials: impl Into<Materials<S>>,
        conditions: &BoundaryConditions<S>,
    ) -> Result<Self, BodyError> {
        conditions::evaluate(mesh, materials.into(), conditions, None)
    }

    /// Creates the same body with other amounts of what its conditions impose: displacements, tractions, temperatures, and loads and motions of rigid sides.
    ///
    /// * `factor`: of each condition; the body force has none.
    ///
    /// # Errors
    /// Values that are not finite, or contradict each other, see [`BodyError`].
    pub(crate) fn with_factors(&self, factor: &dyn Fn(ConditionPlace) -> f64) -> Result<Self, BodyError> {
        let scaled = self.conditions.scaled(factor);
        let (mesh, materials) = (self.mesh.clone(), self.materials.clone());
        let body = conditions::evaluate(mesh, materials, &scaled, Some(self.selected.clone()))?;
        Ok(self.declared_on(body))
    }

    /// Gives the same body with other conditions the declared curves and surfaces, and the inserted nodes, of this one.
    fn declared_on(&self, other: Self) -> Self {
        let (curves, surfaces) = (self.curves.clone(), self.surfaces.clone());
        Self { curves, surfaces, inserted: self.inserted.clone(), ..other }
    }

    /// Returns the declared surface on which a facet lies, with the body on its side, as a [`RigidLine`] has it.
    pub fn surface(&self, facet: FacetId) -> Option<&RigidLine<S>> {
        self.surfaces.get(&facet)
    }

    /// Creates the same body without its body force, its change of temperature and its cuts.
    pub fn weightless(&self) -> Self {
        let mut body = self.clone();
        body.conditions.body_force = S::Vector::default();
        (body.forces, body.temperature) = (Vec::new(), Vec::new());
        (body.cuts, body.cut_strains) = (Vec::new(), Vec::new());
        body
    }

    /// Tells whether nothing but contact holds the body: no support, no rigid side, and it is one piece.
    pub(crate) fn has_no_support(&self) -> bool {
        self.node_constraints.iter().all(|constraint| constraint.held.is_none())
            && self.rigid_sides.is_empty()
            && self.springs.is_empty()
            && self.mesh.topology().pieces().1 == 1
    }

    /// Evaluates the parts of sides again, after nodes were put into the mesh: a part may end at a new node. Edges that
    /// a condition had keep it.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn reselected(&self) -> Result<Self, BodyError> {
        let conditions = &self.conditions;
        let displacements = conditions.displacements.iter().map(|c| &c.edges);
        let others =
            conditions.tractions.iter().map(|c| &c.edges).chain(conditions.rigid.iter().map(|c| &c.edges));
        let mut selections = displacements.chain(others).chain(conditions.springs.iter().map(|c| &c.edges));
        if selections.all(|edges| edges.part.is_none()) {
            return Ok(self.clone());
        }
        let again = |known: Option<_>| {
            let again =
                conditions::evaluate(self.mesh.clone(), self.materials.clone(), &self.conditions, known)?;
            Ok::<_, BodyError>(self.declared_on(again))
        };
        // A part that has lost all its edges keeps the old ones.
        let Ok(found) = again(None) else { return Ok(self.clone()) };
        let both = |a: &[Vec<FacetId>], b: &[Vec<FacetId>]| -> Vec<Vec<FacetId>> {
            let union = |(a, b): (&Vec<FacetId>, &Vec<FacetId>)| {
                let mut all = [a.as_slice(), b].concat();
                all.sort_unstable();
                all.dedup();
                all
            };
            a.iter().zip(b).map(union).collect()
        };
        again(Some(conditions::Selected {
            displacements: both(&self.selected.displacements, &found.selected.displacements),
            nodes: self.selected.nodes.clone(),
            tractions: both(&self.selected.tractions, &found.selected.tractions),
            rigid: both(&self.selected.rigid, &found.selected.rigid),
            springs: both(&self.selected.springs, &found.selected.springs),
        }))
    }

    /// Tells whether a common refinement put a node into this body so that it matches another one.
    pub fn is_inserted(&self, node: NodeId) -> bool {
        self.inserted.binary_search(&node).is_ok()
    }

    /// Notes that all nodes from a number on were put in by a common refinement.
    pub fn note_inserted(&mut self, from: usize) {
        self.inserted.extend((from..self.mesh.points().len()).map(NodeId::new));
    }

    /// Adds a group of edges to the mesh.
    pub fn add_group(&mut self, name: &str, edges: Vec<FacetId>) {
        self.mesh.add_group(name, edges);
    }

    /// Tells whether an edge has neither a load nor springs nor an imposed displacement.
    pub fn is_free(&self, edge: FacetId) -> bool {
        let free = |c: &FacetCondition<S>| {
            c.reaction.is_none() && c.traction == S::ZEROS && c.springs.directions.is_none()
        };
        self.facet_condition(edge).is_none_or(free)
    }

    /// Returns the mesh.
    #[inline]
    pub fn mesh(&self) -> &Mesh<S> {
        &self.mesh
    }

    /// Returns the material of a cell.
    #[inline]
    pub fn material(&self, cell: usize) -> &LinearElastic<S> {
        self.materials.of(cell)
    }

    /// Returns the materials of all cells.
    pub fn materials(&self) -> &Materials<S> {
        &self.materials
    }

    /// Returns the displacement condition of each node.
    pub fn node_constraints(&self) -> &[NodeConstraint<S>] {
        &self.node_constraints
    }

    /// Returns the condition on each boundary edge, in the order of
    /// [`crate::mesh::topology::Topology::boundary_facets`].
    pub fn facet_conditions(&self) -> &[FacetCondition<S>] {
        &self.facet_conditions
    }

    /// Returns the nodes of each displacement condition, in the order of the conditions.
    pub fn supports(&self) -> &[SupportSet<S>] {
        &self.supports
    }

    /// Returns the sides that stay rigid, in the order of the conditions.
    pub fn rigid_sides(&self) -> &[RigidSide<S>] {
        &self.rigid_sides
    }

    /// Returns the sides on springs, in the order of the conditions.
    pub fn springs(&self) -> &[SpringSide<S>] {
        &self.springs
    }

    /// Lists the boundary facets on springs, each with the sum of its springs.
    pub fn facet_springs(&self) -> impl Iterator<Item = (FacetId, &FacetSprings<S>)> + '_ {
        let facets = self.mesh.topology().boundary_facets().iter().copied();
        let all = facets.zip(self.facet_conditions.iter().map(|condition| &condition.springs));
        let all = (!self.springs.is_empty()).then_some(all);
        all.into_iter().flatten().filter(|(_, springs)| !springs.directions.is_none())
    }

    /// Lists the nodal forces of the loads of its rigid sides, N/m, see [`RigidSide::forces`].
    pub(crate) fn rigid_forces(&self) -> impl Iterator<Item = (NodeId, S::Vector)> + '_ {
        self.rigid_sides.iter().flat_map(|side| side.nodes.iter().copied().zip(side.forces.iter().copied()))
    }

    /// Finds the condition of a boundary edge.
    pub fn facet_condition(&self, edge: FacetId) -> Option<&FacetCondition<S>> {
        let place = self.mesh.topology().boundary_facets().binary_search(&edge).ok()?;
        self.facet_conditions.get(place)
    }

    /// Returns the largest sine of the angle between the normal of an edge on a roller and the direction in which one of its
    /// nodes is fixed: zero on straight sides, and also if other conditions make the node's displacement agree with
    /// the edge's normal. If it is not zero, the displacement along the edge violates the roller, so no bound of
    /// the error is strict.
    pub fn roller_turn(&self) -> f64 {
        self.roller_turn
    }

    /// Lists the nodes that conditions fix along the normals of their edges; these normals turn if a node moves.
    pub fn roller_nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let rollers = self.conditions.displacements.iter().zip(&self.selected.displacements);
        let rollers = rollers.filter(|(condition, _)| matches!(condition.support, Support::Normal(_)));
        rollers.flat_map(|(_, edges)| edges).flat_map(|&e| self.mesh.topology().facets()[e])
    }

    /// Finds a rigid motion that the supports allow, if there is one: then no statically loaded solution
    /// is unique. Each connected part is checked separately.
    pub fn free_motion(&self) -> Option<FreeMotion> {
        *self.free_motion.get_or_init(|| motion::find(self))
    }

    /// Lists a basis of the rigid motions that the supports leave free; none if the body is held.
    pub fn rigid_motions(&self) -> Vec<RigidMotion<S>> {
        if self.free_motion().is_none() { Vec::new() } else { motion::basis(self) }
    }

    /// Creates the same body on a finer mesh, without its curves and surfaces.
    ///
    /// * `parent_cell`: of each new cell; `parts`: of a facet in the finer mesh.
    fn on_finer(
        &self,
        mesh: &Mesh<S>,
        parent_cell: &[u32],
        parts: impl Fn(FacetId) -> Vec<FacetId>,
    ) -> Result<Self, BodyError> {
        let finer = |facets: &Vec<FacetId>| {
            let mut parts: Vec<FacetId> = facets.iter().flat_map(|facet| parts(*facet)).collect();
            parts.sort_unstable();
            parts
        };
        let selected = conditions::Selected {
            displacements: self.selected.displacements.iter().map(finer).collect(),
            nodes: self.selected.nodes.clone(),
            tractions: self.selected.tractions.iter().map(finer).collect(),
            rigid: self.selected.rigid.iter().map(finer).collect(),
            springs: self.selected.springs.iter().map(finer).collect(),
        };
        let materials = self.materials.inherited(parent_cell);
        let mut finer = conditions::evaluate(mesh.clone(), materials, &self.conditions, Some(selected))?;
        let known: Vec<f64> = self.cuts.iter().map(|cut| cut.shortening).collect();
        finer.shorten(&known);
        Ok(Self { inserted: self.inserted.clone(), ..finer })
    }
}

impl Body {
    /// Creates the same body on a finer mesh: the parts of an edge inherit its conditions and its curve, the selections are not
    /// evaluated again, and functions are evaluated at the new nodes.
    ///
    /// * `refinement`: of this body's mesh.
    ///
    /// # Errors
    /// Functions whose values at new nodes are not finite, or contradict each other, see [`BodyError`].
    pub fn refined(&self, refinement: &Refinement) -> Result<Self, BodyError> {
        let parts = |edge: FacetId| refinement.parts(&self.mesh, edge);
        let finer = self.on_finer(&refinement.mesh, &refinement.parent_cell, parts)?;
        Ok(Self { curves: self.curves.refined(&self.mesh, refinement), ..finer })
    }

    /// Adds a constant traction along the whole boundary, counter-clockwise, Pa. It has no resultant, and a moment of `2 A` times it with the
    /// area `A`, about any point.
    pub(crate) fn turn(&mut self, traction: f64) {
        let edges = self.mesh.topology().boundary_facets();
        for (condition, edge) in self.facet_conditions.iter_mut().zip(edges) {
            let along = perpendicular(self.mesh.facet_normal(*edge));
            condition.traction.iter_mut().for_each(|t| *t += traction * along);
        }
    }
}

//! A part of a body: some of its cells, with what acts on them.

use super::{Body, FacetCondition, FacetSprings, SpringSide};
use crate::boundary::BoundaryConditions;
use crate::mesh::id::NodeId;
use crate::mesh::{Cell, Mesh, MeshError};
use crate::space::Space;
use std::sync::OnceLock;

impl<S: Space> Body<S> {
    /// Creates a body of some cells: with their loads, their initial strain, the supports of their nodes, and the conditions of those of their facets
    /// that are on the boundary. The facets at which it was cut are free. Rigid sides and cuts of bolts are left out.
    ///
    /// It is solved, and not refined: curves and what its conditions were made of are left out.
    ///
    /// * `nodes`: of these cells, ascending; `cells`: at least one.
    ///
    /// # Errors
    /// Cells that make no mesh.
    pub(crate) fn part(&self, nodes: &[NodeId], cells: &[u32]) -> Result<Self, MeshError> {
        let own = |node: NodeId| NodeId::new(nodes.partition_point(|n| *n < node));
        let numbered = |t: &u32| -> Cell<S> {
            let corners = self.mesh.cells()[*t as usize];
            S::corners(|k| own(corners[k]))
        };
        let points = nodes.iter().map(|node| self.mesh.points()[*node]).collect();
        let mesh = Mesh::of_cells(points, cells.iter().map(numbered).collect())?;
        let facet_conditions = mesh.topology().boundary_facets().iter().map(|facet| {
            let (whole, order) = self.mesh.facet_of_part(&mesh, *facet, nodes);
            let Some(condition) = whole.and_then(|whole| self.facet_condition(whole)) else {
                return FacetCondition::FREE;
            };
            // Corner `order[k]` of the part is corner `k` of the whole.
            let place = |corner: usize| order.into_iter().position(|k| k == corner).unwrap_or(corner);
            let springs = FacetSprings {
                stretch: S::axes(|corner| condition.springs.stretch[place(corner)]),
                ..condition.springs
            };
            let traction = S::axes(|corner| condition.traction[place(corner)]);
            FacetCondition { traction, springs, ..*condition }
        });
        let temperature = match self.temperature.is_empty() {
            true => Vec::new(),
            false => nodes.iter().map(|node| self.temperature[node.index()]).collect(),
        };
        let forces = match self.forces.is_empty() {
            true => Vec::new(),
            false => cells.iter().map(|t| self.forces[*t as usize]).collect(),
        };
        let body_force = self.conditions.body_force;
        // Its facets have their own.
        let side = |side: &SpringSide<S>| SpringSide { group: side.group.clone(), facets: Vec::new() };
        let springs = self.springs.iter().take(1).map(side).collect();
        Ok(Self {
            materials: self.materials.inherited(cells),
            node_constraints: nodes.iter().map(|node| self.node_constraints[node.index()]).collect(),
            facet_conditions: facet_conditions.collect(),
            supports: Vec::new(),
            rigid_sides: Vec::new(),
            springs,
            roller_turn: self.roller_turn,
            temperature,
            cuts: Vec::new(),
            cut_strains: Vec::new(),
            forces,
            conditions: BoundaryConditions { body_force, ..BoundaryConditions::default() },
            selected: Default::default(),
            curves: Default::default(),
            surfaces: Default::default(),
            inserted: Vec::new(),
            free_motion: OnceLock::new(),
            mesh,
        })
    }
}

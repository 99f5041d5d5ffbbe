//! Cuts: bolts that are tightened.
//!
//! A cut parts the cells on its two sides, a and b. Across it the displacement jumps by `u^a − u^b = δ e`, with the unit axis `e` out of a and the
//! shortening `δ`; the traction does not jump. The nodal displacements of the body are those of a, `w`: in the cells of b at the nodes of the cut
//! the displacement is `u = w − δ e Σ φ_i`, with the sum over these nodes. So a shortening is an initial strain of these cells:
//! ```math
//! σ = E (ε(w) − ε₀),   ε₀ = δ sym(e ⊗ Σ ∇φ_i)
//! ```
//! The force in the cut, positive if it pulls, is the derivative of the potential energy: `F = a(u, −e Σ φ_i) − ℓ(−e Σ φ_i)` over the cells of b.

use super::facet_functions::moments;
use super::{Body, BodyError, ConditionList, ConditionPlace, FacetCondition, NodeConstraint};
use crate::boundary::{BoundaryConditions, CutCondition, CutLoad};
use crate::element::Element;
use crate::geometry::{Coordinates, norm};
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::mesh::topology::NONE;
use crate::space::{Plane, Space};

/// Nodes this near to the plane, as a part of the body's diagonal, are on it.
const ON_PLANE: f64 = 1e-6;
/// The largest component along the axis of a direction that is perpendicular to it.
pub(crate) const PERPENDICULAR: f64 = 1e-9;

/// A cut on its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut<S: Space = Plane> {
    /// Its name.
    pub name: String,
    /// The unit axis `e`, along the normal of its plane.
    pub axis: S::Vector,
    /// The shortening `δ`, m: given, or found for the force.
    pub shortening: f64,
    /// The given force, N/m in the plane, N in space; `None` if the shortening is given.
    pub force: Option<f64>,
    /// Its facets, ascending, and of each the cell of a.
    pub facets: Vec<(FacetId, u32)>,
    /// Its nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The cells of b at its nodes, ascending.
    beyond: Vec<u32>,
}

impl<S: Space> Cut<S> {
    /// Tells whether a node is on the cut.
    pub fn has(&self, node: NodeId) -> bool {
        self.nodes.binary_search(&node).is_ok()
    }

    /// Creates the same cut of the body that several became.
    ///
    /// * `facet`: of its facets there; `numbers`: of the nodes of its body; `first_cell`: of its body.
    pub(super) fn on_joined(
        &self,
        facet: impl Fn(FacetId) -> Option<FacetId>,
        numbers: &[NodeId],
        first_cell: u32,
    ) -> Self {
        let facets = self.facets.iter().filter_map(|(of, a)| Some((facet(*of)?, a + first_cell)));
        let mut cut = Self {
            facets: facets.collect(),
            nodes: self.nodes.iter().map(|node| numbers[node.index()]).collect(),
            beyond: self.beyond.iter().map(|cell| cell + first_cell).collect(),
            ..self.clone()
        };
        cut.facets.sort_unstable();
        cut.nodes.sort_unstable();
        cut
    }

    /// Computes the displacement of a cell beyond the cut per unit of shortening, without `w`: `−e` at the nodes of the cut.
    fn jump(&self, corners: S::Corners<NodeId>) -> S::Corners<S::Vector> {
        S::corners(|k| if self.has(corners[k]) { -self.axis } else { S::Vector::ZERO })
    }
}

/// Finds the cuts of the conditions on a mesh.
pub(super) fn evaluate<S: Space>(
    mesh: &Mesh<S>,
    conditions: &BoundaryConditions<S>,
    constraints: &[NodeConstraint<S>],
    facets: &[FacetCondition<S>],
) -> Result<Vec<Cut<S>>, BodyError> {
    let mut cuts: Vec<Cut<S>> = Vec::new();
    for (index, condition) in conditions.cuts.iter().enumerate() {
        let place = ConditionPlace { list: ConditionList::Cut, index };
        let found = cut(mesh, place, condition)?;
        if let Some(node) = found.nodes.iter().find(|node| cuts.iter().any(|other| other.has(**node))) {
            return Err(BodyError::CutTwice { place, point: mesh.points()[*node].into() });
        }
        let held = |node: &&NodeId| norm(constraints[**node].held.components(found.axis)) > PERPENDICULAR;
        if let Some(node) = found.nodes.iter().find(held) {
            return Err(BodyError::CutHeld { place, point: mesh.points()[*node].into() });
        }
        for (condition, facet) in facets.iter().zip(mesh.topology().boundary_facets()) {
            let on_springs = norm(condition.springs.directions.components(found.axis)) > PERPENDICULAR;
            if on_springs && mesh.topology().facets()[*facet].into_iter().any(|node| found.has(node)) {
                return Err(BodyError::CutHeld { place, point: mesh.facet_middle(*facet).into() });
            }
        }
        cuts.push(found);
    }
    Ok(cuts)
}

fn cut<S: Space>(
    mesh: &Mesh<S>,
    place: ConditionPlace,
    condition: &CutCondition<S>,
) -> Result<Cut<S>, BodyError> {
    let length = norm(condition.normal);
    let axis = condition.normal / length;
    let (shortening, force) = match condition.load {
        CutLoad::Shortening(value) => (value, None),
        CutLoad::Force(value) => (0.0, Some(value)),
    };
    let value = force.unwrap_or(shortening);
    let finite = value.is_finite() && condition.point.is_finite() && axis.is_finite();
    if !finite {
        return Err(BodyError::NotFinite { place, point: condition.point.into(), value });
    }
    let tolerance = ON_PLANE * mesh.diagonal();
    let side = |node: NodeId| (mesh.points()[node] - condition.point).times(&axis);
    let inside = |node: NodeId| {
        let x = mesh.points()[node];
        condition.part.is_none_or(|part| {
            (0..S::DIM).all(|c| x[c] >= part[c][0] - tolerance && x[c] <= part[c][1] + tolerance)
        })
    };
    let topology = mesh.topology();
    let mut facets = Vec::new();
    for (number, nodes) in topology.facets().iter().enumerate() {
        let cells = topology.facet_cells()[number];
        if cells[1] == NONE || !nodes.into_iter().all(|node| side(node).abs() <= tolerance && inside(node)) {
            continue;
        }
        let below = |cell: u32| mesh.cells()[cell as usize].into_iter().map(side).sum::<f64>() < 0.0;
        facets.push((FacetId::new(number), cells[usize::from(!below(cells[0]))]));
    }
    let mut nodes: Vec<NodeId> = facets.iter().flat_map(|(facet, _)| topology.facets()[*facet]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    if facets.is_empty() {
        return Err(BodyError::CutMisses { place, words: S::WORDS });
    }
    let mut found =
        Cut { name: condition.name.clone(), axis, shortening, force, facets, nodes, beyond: Vec::new() };
    let parts = parts(mesh, &found);
    if parts > 1 {
        return Err(BodyError::CutParts { place, parts });
    }
    for node in &found.nodes {
        let around = beyond(mesh, &found, *node).ok_or_else(|| BodyError::CutEnds {
            place,
            point: mesh.points()[*node].into(),
            words: S::WORDS,
        })?;
        found.beyond.extend(around);
    }
    found.beyond.sort_unstable();
    found.beyond.dedup();
    Ok(found)
}

/// Lists the cells of b around a node of a cut; `None` if they are joined with those of a there: the cut ends inside the body.
fn beyond<S: Space>(mesh: &Mesh<S>, cut: &Cut<S>, node: NodeId) -> Option<Vec<u32>> {
    let topology = mesh.topology();
    let of_cut = |facet: FacetId| cut.facets.binary_search_by_key(&facet, |(facet, _)| *facet).ok();
    let (mut found, mut of_a) = (Vec::new(), Vec::new());
    for &cell in topology.cells_around(node) {
        for place in topology.cell_facets()[cell as usize].into_iter().filter_map(of_cut) {
            let (facet, a) = cut.facets[place];
            if topology.facets()[facet].into_iter().any(|corner| corner == node) {
                if a == cell { of_a.push(cell) } else { found.push(cell) }
            }
        }
    }
    let mut next = 0;
    while next < found.len() {
        let cell = found[next];
        next += 1;
        for facet in topology.cell_facets()[cell as usize] {
            let around = topology.facets()[facet].into_iter().any(|corner| corner == node);
            if !around || of_cut(facet).is_some() {
                continue;
            }
            let other = topology.facet_cells()[facet].into_iter().find(|other| *other != cell);
            found.extend(other.filter(|other| *other != NONE && !found.contains(other)));
        }
    }
    (!found.iter().any(|cell| of_a.contains(cell))).then_some(found)
}

/// Counts the parts of a cut that have no common node.
fn parts<S: Space>(mesh: &Mesh<S>, cut: &Cut<S>) -> usize {
    let mut left: Vec<FacetId> = cut.facets.iter().map(|(facet, _)| *facet).collect();
    let mut parts = 0;
    while let Some(first) = left.pop() {
        parts += 1;
        let mut open = vec![first];
        while let Some(facet) = open.pop() {
            let nodes = mesh.topology().facets()[facet];
            let beside = |other: &FacetId| {
                mesh.topology().facets()[*other].into_iter().any(|n| nodes.into_iter().any(|m| m == n))
            };
            let (joined, others) = left.into_iter().partition(beside);
            open.extend::<Vec<FacetId>>(joined);
            left = others;
        }
    }
    parts
}

impl<S: Space> Body<S> {
    /// Returns the cuts, in the order of the conditions.
    pub fn cuts(&self) -> &[Cut<S>] {
        &self.cuts
    }

    /// Tells whether the force in a cut is given.
    pub fn has_cut_forces(&self) -> bool {
        self.cuts.iter().any(|cut| cut.force.is_some())
    }

    /// Sets the shortenings of the cuts, m.
    ///
    /// # Panics
    /// If there is not one per cut.
    pub fn shorten(&mut self, shortenings: &[f64]) {
        let (found, expected) = (shortenings.len(), self.cuts.len());
        assert!(found == expected, "{found} shortenings are given, the body has {expected} cuts");
        self.cuts.iter_mut().zip(shortenings).for_each(|(cut, shortening)| cut.shortening = *shortening);
        self.cut_strains = strains(&self.mesh, &self.cuts);
    }

    /// Returns what the displacement of a cell has beyond the nodal displacements at its corners, `−δ e` at the nodes of a cut, m.
    pub fn cut_displacement(&self, cell: usize) -> S::Corners<S::Vector> {
        let mut sum = S::corners(|_| S::Vector::ZERO);
        let corners = self.mesh.cells()[cell];
        for cut in self.cuts.iter().filter(|cut| cut.beyond.binary_search(&(cell as u32)).is_ok()) {
            let jump = cut.jump(corners);
            sum = S::corners(|k| sum[k] + jump[k] * cut.shortening);
        }
        sum
    }

    /// Computes the force in each cut, which pulls if it is positive, and the sum of the sizes of its terms, N/m in the plane, N in space.
    ///
    /// * `displacement`: of the nodes, m.
    pub fn cut_forces(&self, displacement: &[S::Vector]) -> Vec<[f64; 2]> {
        let of_cut = |cut: &Cut<S>| {
            let mut sum = [0.0; 2];
            let mut add = |term: f64| {
                sum[0] += term;
                sum[1] += term.abs();
            };
            for &cell in &cut.beyond {
                let (t, corners) = (cell as usize, self.mesh.cells()[cell as usize]);
                let element = Element::<S>::new(self.mesh.corners(t));
                let strain = element.strain(S::corners(|k| displacement[corners[k]]));
                let forces = element.internal_forces(self.stress(t, strain));
                cut.jump(corners).into_iter().zip(forces).for_each(|(jump, force)| add(jump.times(&force)));
            }
            add(-self.cut_load(cut));
            sum
        };
        self.cuts.iter().map(of_cut).collect()
    }

    /// Computes the stiffness of the cells beyond a cut alone, N/m per m in the plane: the change of its force per unit of shortening if no node moves.
    pub fn cut_stiffness(&self, cut: &Cut<S>) -> f64 {
        let of_cell = |cell: &u32| {
            let t = *cell as usize;
            let element = Element::<S>::new(self.mesh.corners(t));
            let strain = element.strain(cut.jump(self.mesh.cells()[t]));
            element.measure * S::contracted(self.material(t).stress(strain), strain)
        };
        cut.beyond.iter().map(of_cell).sum()
    }

    /// Computes the nodal forces `∫ E ε₀ : ε(φ)` of a unit shortening of a cut, Cartesian, N/m per m.
    pub(crate) fn unit_cut_forces(&self, cut: &Cut<S>) -> Vec<S::Vector> {
        let mut forces = vec![S::Vector::ZERO; self.mesh.points().len()];
        for &cell in &cut.beyond {
            let (t, corners) = (cell as usize, self.mesh.cells()[cell as usize]);
            let element = Element::<S>::new(self.mesh.corners(t));
            let stress = self.material(t).stress(element.strain(cut.jump(corners)));
            let own = element.internal_forces(stress);
            corners.into_iter().zip(own).for_each(|(node, force)| forces[node] -= force);
        }
        forces
    }

    /// Computes the work of the loads in the jumps of all cuts, J/m in the plane, J in space: of body force and tractions beyond them, and of given
    /// forces in them.
    pub fn cut_work(&self) -> f64 {
        let of_cut = |cut: &Cut<S>| cut.shortening * (self.cut_load(cut) + cut.force.unwrap_or_default());
        self.cuts.iter().map(of_cut).sum()
    }

    /// Computes the work of body force and tractions on the jump of a cut, per unit of shortening.
    fn cut_load(&self, cut: &Cut<S>) -> f64 {
        let mut work = 0.0;
        for &cell in &cut.beyond {
            let jump = cut.jump(self.mesh.cells()[cell as usize]);
            if self.has_force() {
                let forces = self.nodal_forces_inside(cell as usize);
                work += jump.into_iter().zip(forces).map(|(jump, force)| jump.times(&force)).sum::<f64>();
            }
            for facet in self.mesh.topology().cell_facets()[cell as usize] {
                let Some(condition) = self.facet_condition(facet) else { continue };
                let forces = moments::<S>(&condition.traction, self.mesh.facet_measure(facet));
                let of_node = |(node, force): (NodeId, S::Vector)| {
                    if cut.has(node) { -cut.axis.times(&force) } else { 0.0 }
                };
                work +=
                    self.mesh.topology().facets()[facet].into_iter().zip(forces).map(of_node).sum::<f64>();
            }
        }
        work
    }
}

/// Computes the initial strain of each cell by the cuts; none without cuts.
pub(super) fn strains<S: Space>(mesh: &Mesh<S>, cuts: &[Cut<S>]) -> Vec<S::Tensor> {
    if cuts.is_empty() {
        return Vec::new();
    }
    let mut strains = vec![S::Tensor::default(); mesh.cells().len()];
    for cut in cuts {
        for &cell in &cut.beyond {
            let element = Element::<S>::new(mesh.corners(cell as usize));
            // The strain of the displacement beyond `w`, with the other sign.
            let jump = cut.jump(mesh.cells()[cell as usize]);
            let own: S::Components<f64> = element.strain(S::corners(|k| jump[k] * -cut.shortening)).into();
            let sum: S::Components<f64> = strains[cell as usize].into();
            strains[cell as usize] = S::components(|k| sum[k] + own[k]).into();
        }
    }
    strains
}

//! The estimate of bodies that bonds joined, given back to each of them.

use crate::admissible::{AdmissibleBody, AdmissibleContact, AdmissiblePair};
use crate::cre::Cre;
use crate::equilibrated::EquilibratedStress;
use crate::estimate::{Estimate, energies, energy_rounding};
use crate::friction::FacetFriction;
use crate::lift::Lift;
use crate::recovery::Recovery;
use fem_core::body::{Body, FacetCondition};
use fem_core::interface::{Bonds, ContactFacet, ContactPair, ContactProblem, Part};
use fem_core::mesh::Mesh;
use fem_core::mesh::id::FacetId;
use fem_core::space::Space;
use std::ops::Range;

impl<S: Recovery> Estimate<S> {
    /// Returns the estimate of the joined problem as one of the bodies that were joined. The numbers of the whole are the same; bonded pairs have no
    /// opening, no pressure and no contribution.
    ///
    /// * `problem`: the given one; `bonds`: made of it.
    ///
    /// # Panics
    /// If the estimate is not one of the joined problem.
    #[must_use]
    pub fn of_parts(self, problem: &ContactProblem<S>, bonds: &Bonds<S>) -> Self {
        let parts = || problem.bodies.iter().zip(&bonds.parts);
        let own = |by_cell: &[Vec<f64>]| -> Vec<Vec<f64>> {
            parts().map(|(body, part)| by_cell[part.body][cells(body, part)].to_vec()).collect()
        };
        let whole = &self.pair;
        let bodies: Vec<AdmissibleBody<S>> = parts()
            .map(|(body, part)| {
                let joined = bonds.joined.bodies[part.body].mesh();
                of_part((body, part), joined, &whole.bodies[part.body])
            })
            .collect();
        let blocks: Vec<Range<usize>> = bonds.joined.blocks().collect();
        let of_pair = |(k, (pair, block)): (usize, (&ContactPair<S>, Range<usize>))| {
            let Some(joined) = bonds.pairs[k] else { return AdmissibleContact::bonded(pair) };
            let start = blocks[joined].start;
            let places: Vec<Option<usize>> =
                bonds.node_pairs[block].iter().map(|kept| Some((*kept)? - start)).collect();
            whole.contacts[joined].spread(pair, &places, &bonds.facets[k])
        };
        let pair = AdmissiblePair {
            contacts: problem.contacts.iter().zip(problem.blocks()).enumerate().map(of_pair).collect(),
            obstacles: whole.obstacles.clone(),
            lift_energy: whole.lift_energy,
            pressure_shift: whole.pressure_shift,
            rigid_balance: whole.rigid_balance,
            bodies,
        };
        let energy_norm_squared = energies(problem, &pair);
        let energy_rounding = energy_rounding(problem, &pair);
        let by_edge = |terms: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let of_pair = |(joined, facets): (&Option<usize>, &Vec<Option<usize>>)| match joined {
                Some(k) => by_facet(facets, &terms[*k], 1, 0.0),
                None => vec![0.0; facets.len()],
            };
            bonds.pairs.iter().zip(&bonds.facets).map(of_pair).collect()
        };
        let cre = Cre {
            by_cell: own(&self.cre.by_cell),
            discretisation_by_cell: own(&self.cre.discretisation_by_cell),
            by_contact_edge: by_edge(&self.cre.by_contact_edge),
            friction_by_contact_edge: vec![Vec::new(); problem.contacts.len()],
            ..self.cre
        };
        let mean_stress =
            parts().map(|(body, part)| self.mean_stress[part.body][cells(body, part)].to_vec()).collect();
        Self { pair, cre, energy_norm_squared, energy_rounding, mean_stress, ..self }
    }
}

/// Returns the places of the cells of a part among those of the whole.
fn cells<S: Space>(body: &Body<S>, part: &Part<S>) -> Range<usize> {
    part.first_cell..part.first_cell + body.mesh().cells().len()
}

/// Lists the values of the facets of a pair from those of the joined pair, `each` for every facet.
fn by_facet<T: Clone>(facets: &[Option<usize>], values: &[T], each: usize, none: T) -> Vec<T> {
    let of_facet = |facet: &Option<usize>| match facet {
        Some(k) => values[k * each..(k + 1) * each].to_vec(),
        None => vec![none.clone(); each],
    };
    facets.iter().flat_map(of_facet).collect()
}

/// Takes the fields of a part out of those of the whole.
fn of_part<S: Recovery>(
    (body, part): (&Body<S>, &Part<S>),
    joined: &Mesh<S>,
    whole: &AdmissibleBody<S>,
) -> AdmissibleBody<S> {
    let cells = cells(body, part);
    let topology = body.mesh().topology();
    let mut conditions: Vec<FacetCondition<S>> = body.facet_conditions().to_vec();
    let mut facet_moments = Vec::with_capacity(topology.facets().len());
    for facet in (0..topology.facets().len()).map(FacetId::new) {
        let (Some(own), order) = joined.facet_of_part(body.mesh(), facet, &part.nodes) else {
            facet_moments.push(S::ZEROS);
            continue;
        };
        // The corner of the whole for each corner of the part.
        let back = S::axes(|k| (0..S::DIM).position(|corner| order[corner] == k).unwrap_or(k));
        let first = topology.facet_cells()[facet][0] as usize + part.first_cell;
        let sign = if joined.topology().facet_cells()[own][0] as usize == first { 1.0 } else { -1.0 };
        facet_moments.push(S::axes(|k| whole.equilibrated.facet_moments[own][back[k]] * sign));
        if joined.topology().is_boundary(own) {
            let found = &whole.equilibrated.conditions[joined.topology().boundary_place(own)];
            let traction = S::axes(|k| found.traction[back[k]]);
            conditions[topology.boundary_place(facet)] = FacetCondition { traction, ..*found };
        }
    }
    AdmissibleBody {
        displacement: part.nodes.iter().map(|node| whole.displacement[node.index()] + part.offset).collect(),
        stress: whole.stress[cells.clone()].to_vec(),
        equilibrated: EquilibratedStress {
            facet_moments,
            conditions,
            finite_element: whole.equilibrated.finite_element[cells].to_vec(),
        },
        relaxation: whole.relaxation.clone(),
    }
}

impl<S: Recovery> AdmissibleContact<S> {
    /// Creates the part of a bonded pair: no opening and no pressure.
    fn bonded(pair: &ContactPair<S>) -> Self {
        let (pairs, facets) = (pair.interface.pairs().len(), pair.interface.facets());
        let middles = facets.len() * ContactFacet::<S>::EDGES;
        Self {
            opening: vec![0.0; pairs],
            added: [Vec::new(), Vec::new()],
            middle_opening: vec![0.0; middles],
            lift: Lift { by_pair: vec![0.0; pairs], ..Lift::default() },
            pressure: vec![0.0; pairs],
            edge_pressure: facets.iter().map(|_| S::axes(|_| 0.0)).collect(),
            pressure_force: vec![S::Vector::default(); pairs],
            friction: Vec::new(),
            friction_limit: Vec::new(),
            slip: Vec::new(),
            facet_friction: FacetFriction::default(),
        }
    }

    /// Creates the part of a pair some of whose nodes were merged.
    ///
    /// * `places`, `of_facets`: of its pairs of nodes and of its facets in this one.
    fn spread(&self, pair: &ContactPair<S>, places: &[Option<usize>], of_facets: &[Option<usize>]) -> Self {
        let numbers = |values: &[f64]| -> Vec<f64> {
            places.iter().map(|place| place.and_then(|k| values.get(k)).copied().unwrap_or(0.0)).collect()
        };
        let force = |place: &Option<usize>| place.map_or(S::Vector::default(), |k| self.pressure_force[k]);
        let body = pair.elastic_sides().find(|(side, _)| *side == self.lift.side);
        let body = body.map_or(self.lift.body, |(_, body)| body);
        let edges = ContactFacet::<S>::EDGES;
        Self {
            added: self.added.each_ref().map(|of| if of.is_empty() { Vec::new() } else { numbers(of) }),
            lift: Lift { by_pair: numbers(&self.lift.by_pair), body, ..self.lift.clone() },
            middle_opening: by_facet(of_facets, &self.middle_opening, edges, 0.0),
            edge_pressure: by_facet(of_facets, &self.edge_pressure, 1, S::axes(|_| 0.0)),
            pressure_force: places.iter().map(force).collect(),
            opening: numbers(&self.opening),
            pressure: numbers(&self.pressure),
            ..self.clone()
        }
    }
}

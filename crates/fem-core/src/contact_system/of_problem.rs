//! The algebra of a prepared problem.

use super::{
    BodyField, BodyFields, BodyRow, ContactRow, ContactRows, ContactSystem, PairRows, RowLaw, RowMotion,
    SharedUnknowns, sign, without_rounding,
};
use crate::condensation::CondensedBody;
use crate::dof::TraceRow;
use crate::geometry::Coordinates;
use crate::interface::{ContactPair, ContactProblem, Partner};
use crate::motions::{BodyMotion, largest};
use crate::prepared::{FactorisedBody, PreparedProblem};
use crate::space::Space;
use crate::subdomains::{Subdomain, rigid_motions};

impl ContactRows {
    /// Takes the rows of a problem.
    ///
    /// * `motions`: see [`ContactProblem::rigid_motions`]; `load_sizes`: the sum of the sizes of the loads of each body and obstacle, N/m.
    fn new<S: Space>(problem: &ContactProblem<S>, motions: &[BodyMotion<S>], load_sizes: &[f64]) -> Self {
        let (mut pairs, mut rows) = (Vec::with_capacity(problem.contacts.len()), Vec::new());
        for ((k, pair), block) in problem.contacts.iter().enumerate().zip(problem.blocks()) {
            let start = rows.len();
            rows.extend(rows_of(problem, k, pair, block.start));
            let normal = start..start + block.len();
            pairs.push(PairRows {
                body: pair.body,
                partner: pair.partner,
                roles: pair.roles,
                tangential: normal.end..rows.len(),
                normal,
            });
        }
        let mut found = Self {
            bodies: problem.bodies.len(),
            pairs,
            rows,
            motions: Vec::with_capacity(motions.len()),
            load_size: load_sizes.iter().sum(),
            balancing: problem.balancing.clone(),
            normal_error: S::NORMAL_ERROR,
        };
        let sides = problem.sides();
        for of in motions {
            let moved = problem.moved_by(of);
            let place = of.partner.place(found.bodies);
            let traces = sides[place].iter().flat_map(|side| found.traces_of(problem, *side, &moved));
            let mut traces: Vec<(usize, f64)> = traces.collect();
            // A pair within a body has both sides there.
            traces.sort_by_key(|(row, _)| *row);
            traces.dedup_by(|next, sum| {
                let same = next.0 == sum.0;
                sum.1 += if same { next.1 } else { 0.0 };
                same
            });
            let largest = largest(&moved);
            let traces =
                traces.into_iter().map(|(row, trace)| (row, without_rounding(trace, largest))).collect();
            let load = without_rounding(of.load, load_sizes[place] * largest);
            found.motions.push(RowMotion { partner: of.partner, traces, load });
        }
        found
    }

    /// Lists the traces of the moved nodes of one side of a pair, with their rows.
    fn traces_of<S: Space>(
        &self,
        problem: &ContactProblem<S>,
        (pair, side): (usize, usize),
        moved: &[S::Vector],
    ) -> Vec<(usize, f64)> {
        let rows = self.pairs[pair].all().zip(problem.contacts[pair].rows());
        rows.map(|(row, of)| (row, sign(side) * moved[of.nodes[side]].times(&of.direction))).collect()
    }
}

/// Lists the rows of a pair.
///
/// * `first`: number of its first pair of nodes among all.
fn rows_of<S: Space>(
    problem: &ContactProblem<S>,
    number: usize,
    pair: &ContactPair<S>,
    first: usize,
) -> Vec<ContactRow> {
    let imposed = problem.obstacle_of(pair).map(|obstacle| obstacle.imposed());
    let limits = pair.friction_limit(&problem.bodies[pair.body]);
    let nodes = pair.interface.pairs();
    let row = |(place, row): (usize, crate::interface::PairRow<S>)| {
        let (node, k) = (&nodes[row.pair], row.pair);
        let tangential = place >= nodes.len();
        let before = |row: usize| pair.slip_before.as_ref().map_or(0.0, |before| before.rows[row]);
        let law = match (tangential, pair.friction.coulomb(), &limits) {
            (false, ..) => RowLaw::Unilateral,
            (true, Some(mu), _) => RowLaw::Coulomb { mu },
            (true, None, limits) => {
                let limit = limits.as_ref().map_or(0.0, |limits| limits[k]);
                RowLaw::Tresca { limit: node.weight * limit }
            }
        };
        ContactRow {
            pair: number,
            node_pair: first + k,
            law,
            gap: if tangential { before(place - nodes.len()) } else { node.gap },
            length: node.weight,
            obstacle: imposed.as_ref().map(|imposed| sign(1) * imposed[k].times(&row.direction)),
        }
    };
    pair.rows().enumerate().map(row).collect()
}

impl<S: Space> ContactProblem<S> {
    /// Returns the rows of the contacts: what can be asked before a body is factorised.
    pub fn contact_rows(&self) -> ContactRows {
        let forces: Vec<Vec<S::Vector>> = self.bodies.iter().map(crate::assembly::external_forces).collect();
        self.contact_rows_under(&forces, &self.rigid_motions_under(&forces))
    }

    fn contact_rows_under(&self, forces: &[Vec<S::Vector>], motions: &[BodyMotion<S>]) -> ContactRows {
        let of_bodies = forces.iter().map(|forces| forces.iter().map(|f| f.times(f).sqrt()).sum());
        let of_obstacles = self.obstacles.iter().map(|obstacle| obstacle.load_size());
        ContactRows::new(self, motions, &of_bodies.chain(of_obstacles).collect::<Vec<f64>>())
    }
}

impl<S: Space> PreparedProblem<S> {
    /// Returns the algebra of the problem, for a solver of contact.
    pub fn system(&self) -> ContactSystem<'_> {
        let rows = self.problem().contact_rows_under(self.external_forces(), self.rigid_motions());
        let mut system = ContactSystem {
            bodies: Vec::new(),
            body_of: Vec::new(),
            subdomains: Vec::new(),
            of_body: Vec::new(),
            free: self.rigid_motions().iter().map(|of| self.in_unknowns(of)).collect(),
            rigid: Vec::new(),
            rows,
        };
        for b in 0..self.bodies().len() {
            self.add_body(b, &mut system);
        }
        system
    }

    /// Returns the algebra of one body alone, without the loads along its motions. Its rows, if there are any, have given traces: their gaps, along the
    /// retained directions.
    ///
    /// * `traces`: block by block, m; none: there are no rows.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn system_of(&self, body: usize, traces: &[Vec<f64>]) -> ContactSystem<'_> {
        let mut system = ContactSystem {
            bodies: Vec::new(),
            body_of: Vec::new(),
            subdomains: Vec::new(),
            of_body: Vec::new(),
            free: Vec::new(),
            rigid: Vec::new(),
            rows: ContactRows { normal_error: S::NORMAL_ERROR, ..ContactRows::default() },
        };
        self.add_body(body, &mut system);
        for (block, traces) in traces.iter().enumerate() {
            for ((place, row), trace) in self.rows_of(body, block).into_iter().zip(traces) {
                let number = system.rows.rows.len();
                let terms = row.terms().collect();
                system.of_body[place].push(BodyRow { row: number, side: 0, terms, imposed: 0.0 });
                system.rows.rows.push(ContactRow {
                    pair: block,
                    node_pair: number,
                    law: RowLaw::Unilateral,
                    gap: *trace,
                    length: 0.0,
                    obstacle: Some(0.0),
                });
            }
        }
        let partner = Partner::Body(body);
        for of in self.rigid_motions().iter().filter(|of| of.partner == partner) {
            let free = self.in_unknowns(of);
            let (mut rest, mut traces) = (&free[..], Vec::new());
            for (rows, body) in system.of_body.iter().zip(&system.bodies) {
                let (own, others) = rest.split_at(body.len());
                traces.extend(rows.iter().map(|row| (row.row, row.of(own))));
                rest = others;
            }
            system.rows.motions.push(RowMotion { partner, traces, load: 0.0 });
            system.free.push(free);
        }
        system
    }

    /// Lists the rows of a block of a body, each with the number of its subdomain.
    fn rows_of(&self, body: usize, block: usize) -> Vec<(usize, &TraceRow)> {
        match &self.bodies()[body] {
            FactorisedBody::Whole(body) => body.dofs().rows(block).iter().map(|row| (0, row)).collect(),
            FactorisedBody::Cut(body) => body.rows(block).collect(),
        }
    }

    /// Appends a body, or its subdomains.
    fn add_body<'a>(&'a self, b: usize, system: &mut ContactSystem<'a>) {
        let first = system.bodies.len();
        match &self.bodies()[b] {
            FactorisedBody::Whole(body) => {
                system.bodies.push(body.interface());
                system.subdomains.push(SharedUnknowns::default());
                system.rigid.push(self.held_motions(b, body));
            }
            FactorisedBody::Cut(body) => {
                for of in body.subdomains() {
                    let dofs = of.condensed.dofs();
                    let free = of.free.iter().map(|moved| dofs.interface_components(|node| moved[node]));
                    system.bodies.push(of.condensed.interface());
                    system.subdomains.push(SharedUnknowns {
                        numbers: of.shared.clone(),
                        stiffness: of.stiffness.clone(),
                        free: free.collect(),
                        loads: of.loads.clone(),
                    });
                    system.rigid.push(of.rigid.clone());
                }
            }
        }
        system.body_of.resize(system.bodies.len(), b);
        system.of_body.resize(system.bodies.len(), Vec::new());
        for (block, (pair, side)) in self.problem().sides_of(Partner::Body(b)).enumerate() {
            let Some(of_pair) = system.rows.pairs.get(pair) else { continue };
            for (number, (place, row)) in of_pair.all().zip(self.rows_of(b, block)) {
                system.of_body[first + place].push(BodyRow {
                    row: number,
                    side,
                    terms: row.terms().map(|(k, a)| (k, sign(side) * a)).collect(),
                    imposed: sign(side) * row.imposed,
                });
            }
        }
    }

    /// Returns a rigid motion in the interface unknowns of its body; none of an obstacle.
    fn in_unknowns(&self, of: &BodyMotion<S>) -> Vec<f64> {
        let Some(body) = of.partner.body() else { return Vec::new() };
        let moved = self.moved_by(of);
        match &self.bodies()[body] {
            FactorisedBody::Whole(body) => body.dofs().interface_components(|node| moved[node]),
            FactorisedBody::Cut(body) => {
                let of = |of: &Subdomain<S>| {
                    of.condensed.dofs().interface_components(|node| moved[of.nodes[node]])
                };
                body.subdomains().iter().flat_map(of).collect()
            }
        }
    }

    /// Returns the rigid motions of a body that its supports hold in its interface unknowns, without the imposed ones.
    fn held_motions(&self, b: usize, body: &CondensedBody<S>) -> Vec<Vec<f64>> {
        let free = self.rigid_motions().iter().filter(|of| of.partner == Partner::Body(b)).count();
        rigid_motions(&self.problem().bodies[b], body.dofs(), free)
    }

    /// Computes the displacement of each body, and then of the points of each obstacle, Cartesian, m.
    ///
    /// # Panics
    /// If there is not one field for each of [`ContactSystem::bodies`] and one amount per rigid motion.
    pub fn displacements(&self, of: &BodyFields) -> Vec<Vec<S::Vector>> {
        let factors = self.bodies().iter().map(FactorisedBody::factors);
        let first: Vec<usize> =
            factors.scan(0, |sum, own| Some(std::mem::replace(sum, *sum + own))).collect();
        let count = self.bodies().iter().map(FactorisedBody::factors).sum();
        let (found, expected) = ((of.bodies.len(), of.amounts.len()), (count, self.rigid_motions().len()));
        assert!(found == expected, "{found:?} fields and amounts, and {expected:?} bodies and rigid motions");
        let moved = |partner: Partner, u: &mut [S::Vector]| {
            let motions = self.rigid_motions().iter().zip(&of.amounts);
            for (motion, amount) in motions.filter(|(motion, _)| motion.partner == partner) {
                u.iter_mut().zip(self.moved_by(motion)).for_each(|(u, moved)| *u += moved * *amount);
            }
        };
        let field = |condensed: &CondensedBody<S>, field: &BodyField| match field {
            BodyField::Traces(unknowns) => condensed.displacement_from_trace(unknowns),
            BodyField::Forces(forces) => condensed.displacement_from_force(forces),
        };
        let mut all = crate::each_body(self.bodies().len(), |b| match &self.bodies()[b] {
            FactorisedBody::Whole(body) => {
                let own = &of.bodies[first[b]];
                let mut u = field(body, own);
                if let BodyField::Forces(_) = own {
                    moved(Partner::Body(b), &mut u);
                }
                u
            }
            FactorisedBody::Cut(body) => {
                let parts = body.subdomains();
                let own = |k: usize| field(&parts[k].condensed, &of.bodies[first[b] + k]);
                body.joined(&crate::each_body(parts.len(), own))
            }
        });
        for (k, obstacle) in self.problem().obstacles.iter().enumerate() {
            let mut u = obstacle.imposed();
            moved(Partner::Obstacle(k), &mut u);
            all.push(u);
        }
        all
    }
}

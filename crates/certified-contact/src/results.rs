//! The quantities of interest: forces, pressures, openings, reactions.

use crate::reactions::{Balance, Reaction, RigidSideResults, nodal_forces, support_reactions};
use crate::recovered_pressure::recovered_pressure;
use cre_estimator::{AdmissibleBody, Estimate, RecoveredStress};
use fem_core::body::Body;
use fem_core::geometry::{Vector, cross, norm, perpendicular};
use fem_core::interface::{ContactFacet, ContactInterface, ContactProblem};
use fem_core::prepared::PreparedProblem;
use nndd::Iterate;

/// One connected part of a contact line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Stretch {
    /// Arc lengths of its first and last pair, m; a closed one ends at the place where it begins.
    pub s: [f64; 2],
    /// Number of pairs.
    pub pairs: usize,
    /// Length, m; for a closed part it includes the last edge.
    pub length: f64,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// The force of the contact on the first body, friction included, N/m.
    pub resultant: Vector,
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    pub moment: f64,
    /// Largest nodal pressure, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of an edge, Pa: at most `max_pressure`.
    pub max_edge_pressure: f64,
    /// Smallest opening, m.
    pub min_opening: f64,
}

/// The results of one pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairResults {
    /// The force of the contact on the first body, friction included, N/m.
    pub resultant: Vector,
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    pub moment: f64,
    /// The mean of the contact nodes weighted by their forces, m; on a straight line the resultant acts there. `None` without a force.
    pub centre: Option<Vector>,
    /// The node of the first body with the largest pressure, m; `None` without a force.
    pub max_pressure_at: Option<Vector>,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// Intervals of arc length under pressure, m.
    pub contact_intervals: Vec<[f64; 2]>,
    /// Largest nodal pressure, Pa.
    pub max_pressure: f64,
    /// Largest pressure of [`recovered_pressure`], Pa, if there is one.
    pub max_recovered_pressure: Option<f64>,
    /// Pairs of nodes with a force.
    pub active: usize,
    /// Smallest opening, m.
    pub min_opening: f64,
    /// The results of friction; `None` without friction.
    pub friction: Option<FrictionResults>,
}

/// The results of friction along a pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrictionResults {
    /// `Σ Q_i`, N/m: on the second body along the tangent `(−n_y, n_x)`, on the first against it.
    pub force: f64,
    /// Largest slip `|w|`, m.
    pub max_slip: f64,
    /// Intervals of arc length that are in contact and stick, m.
    pub stick_intervals: Vec<[f64; 2]>,
    /// Intervals of arc length that are in contact and slip, m.
    pub slip_intervals: Vec<[f64; 2]>,
}

/// The largest von Mises stress of the recovered stress.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PeakStress {
    /// The stress, Pa.
    pub von_mises: f64,
    /// The body, in the order of [`Results`].
    pub body: usize,
    /// The node with this stress, m.
    pub point: Vector,
}

/// The results of a run; arrays by body in the order of the problem passed to [`crate::solve`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Results {
    /// `a(u, u)`, J/m.
    pub energy_norm_squared: Vec<f64>,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// The results of each pair.
    pub contacts: Vec<PairResults>,
    /// Intervals of arc length under pressure on the first contact line, m.
    pub contact_intervals: Vec<[f64; 2]>,
    /// The connected parts of all contact lines.
    pub contact_stretches: Vec<Stretch>,
    /// Largest nodal pressure, `max r²_i/ℓ_i`, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of an interface edge, Pa: at most `max_pressure`.
    pub max_edge_pressure: f64,
    /// Smallest opening of the iteration, m.
    pub min_opening: f64,
    /// Reactions of the supports.
    pub reactions: Vec<Reaction>,
    /// Motions and forces of the rigid sides.
    pub rigid_sides: Vec<RigidSideResults>,
    /// Sum of loads, reactions and contact forces of each body: zero to round-off.
    pub balance: Vec<Balance>,
    /// Largest displacement, m.
    pub max_displacement: f64,
    /// Largest von Mises stress of the displacements, Pa; `None` if the out-of-plane stress of a material is unknown.
    pub max_von_mises: Option<f64>,
    /// The recovered stress of each body: continuous, one value per node and material.
    pub recovered: Vec<RecoveredStress>,
    /// Its largest von Mises stress; `None` if the out-of-plane stress of a material is unknown.
    pub peak_stress: Option<PeakStress>,
}

/// Computes the results of an iteration.
///
/// * `low`: low-order parts of the displacements (their rounding errors), if known.
pub(crate) fn results(
    prepared: &PreparedProblem,
    iterate: &Iterate,
    estimate: &Estimate,
    low: Option<Vec<Vec<Vector>>>,
) -> Results {
    let problem = prepared.problem();
    let pair = &estimate.pair;
    let low = |b: usize| low.as_ref().map(|low| &low[b]);
    let (mut reactions, mut rigid_sides) = (Vec::new(), Vec::new());
    let mut balance = Vec::new();
    for (b, fields) in pair.bodies.iter().enumerate() {
        let forces = nodal_forces(&problem.bodies[b], &fields.displacement, low(b));
        let held = (&mut reactions, &mut rigid_sides);
        balance.push(support_reactions(prepared, iterate, (b, &fields.displacement), forces, held));
    }
    let von_mises = |(body, fields): (&Body, &AdmissibleBody)| {
        let values = fields.stress.iter().enumerate().map(|(t, s)| body.material(t).von_mises(*s));
        values.collect::<Option<Vec<f64>>>().map(largest)
    };
    let lines = || lines(problem, iterate);
    let means = problem.bodies.iter().zip(&estimate.mean_stress);
    let recovered: Vec<RecoveredStress> = means.map(|(body, of)| RecoveredStress::new(body, of)).collect();
    let peak_stress = peak_stress(problem, &recovered);
    let contacts: Vec<PairResults> = lines().map(|line| line.results()).collect();
    let stretches: Vec<Stretch> = lines().flat_map(|line| line.stretches()).collect();
    Results {
        energy_norm_squared: estimate.energy_norm_squared.clone(),
        contact_force: contacts.iter().map(|pair| pair.contact_force).sum(),
        contact_intervals: lines().next().map(|line| line.intervals()).unwrap_or_default(),
        max_pressure: largest(contacts.iter().map(|pair| pair.max_pressure)),
        max_edge_pressure: largest(stretches.iter().map(|stretch| stretch.max_edge_pressure)),
        min_opening: contacts.iter().map(|pair| pair.min_opening).reduce(f64::min).unwrap_or(0.0),
        contacts,
        contact_stretches: stretches,
        reactions,
        rigid_sides,
        balance,
        max_displacement: largest(pair.bodies.iter().flat_map(|body| &body.displacement).map(|u| norm(*u))),
        max_von_mises: problem
            .bodies
            .iter()
            .zip(&pair.bodies)
            .map(von_mises)
            .collect::<Option<Vec<f64>>>()
            .map(largest),
        recovered,
        peak_stress,
    }
}

/// Finds the largest von Mises stress of all bodies.
fn peak_stress(problem: &ContactProblem, recovered: &[RecoveredStress]) -> Option<PeakStress> {
    let of_body = |(b, (body, stress)): (usize, (&Body, &RecoveredStress))| {
        let (von_mises, node) = stress.largest_von_mises(body)?;
        Some(PeakStress { von_mises, body: b, point: body.mesh().points()[node] })
    };
    let all = problem.bodies.iter().zip(recovered).enumerate().map(of_body).collect::<Option<Vec<_>>>()?;
    all.into_iter().max_by(|a, b| a.von_mises.total_cmp(&b.von_mises))
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// One contact line with its forces and openings.
#[derive(Clone, Copy)]
struct Line<'a> {
    problem: &'a ContactProblem,
    /// The number of the pair.
    pair: usize,
    interface: &'a ContactInterface,
    /// `r²_i`, N/m.
    force: &'a [f64],
    /// Of the iteration, m.
    opening: &'a [f64],
    /// Friction forces, N/m, and slips, m; empty without friction.
    friction: &'a [f64],
    slip: &'a [f64],
    /// The nodes of the first body, m.
    points: &'a [Vector],
}

/// Lists the contact lines of all pairs.
fn lines<'a>(problem: &'a ContactProblem, iterate: &'a Iterate) -> impl Iterator<Item = Line<'a>> {
    let blocks = problem.blocks().zip(problem.tangential_blocks());
    problem.contacts.iter().zip(blocks).enumerate().map(|(pair, (of, (block, tangents)))| Line {
        problem,
        pair,
        interface: &of.interface,
        force: &iterate.contact.normal_reaction[block.clone()],
        opening: &iterate.opening[block],
        friction: &iterate.tangential.force[tangents.clone()],
        slip: &iterate.tangential.slip[tangents],
        points: problem.bodies[of.body].mesh().points(),
    })
}

impl<'a> Line<'a> {
    /// Returns the pressure `|n_i| r²_i/ℓ_i` at each pair, Pa.
    fn pressures(&self) -> impl Iterator<Item = f64> + '_ {
        self.pressed().zip(self.interface.pairs()).map(|(r, pair)| r / pair.weight)
    }

    /// Returns the sizes `|n_i| r²_i` of the normal forces, N/m.
    fn pressed(&self) -> impl Iterator<Item = f64> + '_ {
        self.interface.pairs().iter().zip(self.force).map(|(pair, r)| r * pair.normal_length())
    }

    /// Returns distances along the normals and tangents, from numbers over their lengths, m.
    fn distances(&self, by_pair: &'a [f64]) -> impl Iterator<Item = f64> + '_ {
        self.interface.pairs().iter().zip(by_pair).map(|(pair, o)| o / pair.normal_length())
    }

    /// Returns the force of pair `k` on the first body, N/m.
    fn on_first(&self, k: usize) -> Vector {
        let normal = self.interface.pairs()[k].normal;
        let pressed = -self.force[k] * normal;
        self.friction.get(k).map_or(pressed, |q| pressed - *q * perpendicular(normal))
    }

    /// Computes the results of friction; `None` without it.
    fn friction(&self) -> Option<FrictionResults> {
        let sticks = |k: usize| self.slip[k] == 0.0;
        (!self.friction.is_empty()).then(|| FrictionResults {
            force: self
                .interface
                .pairs()
                .iter()
                .zip(self.friction)
                .map(|(pair, q)| q * pair.normal_length())
                .sum(),
            max_slip: largest(self.distances(self.slip).map(f64::abs)),
            stick_intervals: self.intervals_of(|k| self.force[k] > 0.0 && sticks(k)),
            slip_intervals: self.intervals_of(|k| self.force[k] > 0.0 && !sticks(k)),
        })
    }

    fn results(&self) -> PairResults {
        let place = |k: usize| self.points[self.interface.pairs()[k].nodes[0]];
        let contact_force: f64 = self.pressed().sum();
        let weighted: Vector = self.pressed().enumerate().map(|(k, r)| r * place(k)).sum();
        let pressures: Vec<f64> = self.pressures().collect();
        let most = (0..pressures.len()).max_by(|a, b| pressures[*a].total_cmp(&pressures[*b]));
        PairResults {
            resultant: (0..self.force.len()).map(|k| self.on_first(k)).sum(),
            moment: (0..self.force.len()).map(|k| cross(place(k), self.on_first(k))).sum(),
            centre: (contact_force > 0.0).then(|| 1.0 / contact_force * weighted),
            max_pressure_at: most.filter(|k| pressures[*k] > 0.0).map(place),
            contact_force,
            contact_intervals: self.intervals(),
            max_pressure: largest(pressures),
            max_recovered_pressure: {
                let forces: Vec<f64> = self.pressed().collect();
                recovered_pressure(self.problem, self.pair, &forces).map(largest)
            },
            active: self.force.iter().filter(|r| **r > 0.0).count(),
            min_opening: self.distances(self.opening).fold(f64::INFINITY, f64::min),
            friction: self.friction(),
        }
    }

    /// Computes the mean pressure of an edge, Pa.
    ///
    /// * `pressures`: at the pairs, Pa.
    fn mean(pressures: &[f64], edge: &ContactFacet) -> f64 {
        0.5 * edge.pairs.map(|k| pressures[k as usize]).iter().sum::<f64>()
    }

    /// Adds up the forces of each connected part: consecutive pairs that are joined by edges.
    fn stretches(&self) -> Vec<Stretch> {
        let joined = joined(self.interface);
        let pressures: Vec<f64> = self.pressures().collect();
        let mut number = Vec::with_capacity(joined.len());
        let mut found: Vec<Stretch> = Vec::new();
        let arc_lengths = self.interface.arc_lengths();
        for (k, p) in self.interface.pairs().iter().enumerate() {
            if !joined[k] {
                found.push(Stretch {
                    s: [arc_lengths[k]; 2],
                    pairs: 0,
                    length: 0.0,
                    contact_force: 0.0,
                    resultant: Vector::zeros(),
                    moment: 0.0,
                    max_pressure: 0.0,
                    max_edge_pressure: 0.0,
                    min_opening: f64::INFINITY,
                });
            }
            number.push(found.len() - 1);
            if let Some(last) = found.last_mut() {
                last.s[1] = arc_lengths[k];
                last.pairs += 1;
                last.contact_force += pressures[k] * p.weight;
                let force = self.on_first(k);
                last.resultant += force;
                last.moment += cross(self.points[p.nodes[0]], force);
                last.max_pressure = last.max_pressure.max(pressures[k]);
                last.min_opening = last.min_opening.min(self.opening[k] / p.normal_length());
            }
        }
        for edge in self.interface.facets() {
            let [i, j] = edge.pairs.map(|k| k as usize);
            let stretch = &mut found[number[i]];
            stretch.length += edge.measure;
            if edge.clamped.is_none() && j <= i {
                stretch.s[1] = arc_lengths[i] + edge.measure;
            }
            stretch.max_edge_pressure = stretch.max_edge_pressure.max(Self::mean(&pressures, edge));
        }
        found
    }

    /// Finds the intervals of arc length whose nodes carry a contact force; they may cross the edge that closes a line.
    fn intervals(&self) -> Vec<[f64; 2]> {
        self.intervals_of(|k| self.force[k] > 0.0)
    }

    /// Finds the intervals of arc length whose nodes have a property.
    fn intervals_of(&self, carries: impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
        let pairs = self.interface.pairs();
        let joined = joined(self.interface);
        let mut found: Vec<[f64; 2]> = Vec::new();
        let mut open = false;
        let arc_lengths = self.interface.arc_lengths();
        for k in 0..pairs.len() {
            match found.last_mut() {
                Some(last) if carries(k) && open && joined[k] => last[1] = arc_lengths[k],
                _ if carries(k) => found.push([arc_lengths[k]; 2]),
                _ => {}
            }
            open = carries(k);
        }
        for edge in self.interface.facets() {
            let [i, j] = edge.pairs.map(|k| k as usize);
            let end = arc_lengths[i];
            // The pressure reaches a clamped end.
            if let Some(clamped) = edge.clamped.filter(|_| carries(i)) {
                let own = found.iter_mut().find(|interval| (interval[0]..=interval[1]).contains(&end));
                if let Some(interval) = own {
                    interval[clamped.end] = end + [-1.0, 1.0][clamped.end] * edge.measure;
                }
                continue;
            }
            if edge.clamped.is_none()
                && j <= i
                && carries(i)
                && carries(j)
                && let Some(last) = found.iter_mut().find(|interval| interval[1] == end)
            {
                last[1] = end + edge.measure;
            }
        }
        found
    }
}

/// Tells for each pair whether an edge joins it to the previous one.
fn joined(interface: &ContactInterface) -> Vec<bool> {
    let mut joined = vec![false; interface.pairs().len()];
    for edge in interface.facets() {
        let [i, j] = edge.pairs.map(|k| k as usize);
        if j == i + 1 {
            joined[j] = true;
        }
    }
    joined
}

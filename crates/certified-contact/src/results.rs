//! The quantities of interest: forces, pressures, openings, reactions.

use crate::lines::Stretch;
use crate::pair_forces::{PairForces, mean, pair_forces};
use crate::reactions::{
    Acting, Balance, Reaction, RigidSideResults, SpringForce, spring_sides, support_reactions,
};
use crate::recovered_pressure::recovered_pressure;
use crate::space::ContactSpace;
use cre_estimator::{AdmissibleBody, Estimate, RecoveredStress, Recovery};
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactArea, ContactPatch, ContactProblem};
use fem_core::mesh::id::NodeId;
use fem_core::space::{Plane, Space};
use nndd::Iterate;

/// The results of one pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairResults<S: Space = Plane> {
    /// The force of the contact on the first body, friction included, N/m.
    pub resultant: S::Vector,
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    pub moment: S::Spin,
    /// The mean of the contact nodes weighted by their forces, m; on a straight line or a plane the resultant acts there. `None` without a force.
    pub centre: Option<S::Vector>,
    /// The node of the first body with the largest pressure, m; `None` without a force.
    pub max_pressure_at: Option<S::Vector>,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// Intervals of arc length under pressure, m; empty in space.
    pub contact_intervals: Vec<[f64; 2]>,
    /// The area in contact from both sides, and its patches; in the plane a length.
    pub area: ContactArea,
    /// The resultants of these patches.
    pub patches: Vec<PatchResults<S>>,
    /// Largest nodal pressure, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of a facet, Pa: at most `max_pressure`.
    pub max_facet_pressure: f64,
    /// Largest pressure of [`crate::recovered_pressure`], Pa, if there is one.
    pub max_recovered_pressure: Option<f64>,
    /// Pairs of nodes with a force.
    pub active: usize,
    /// Smallest opening, m.
    pub min_opening: f64,
    /// The results of friction; `None` without friction.
    pub friction: Option<FrictionResults<S>>,
    /// The results of a bond; `None` if the pair is in contact. A bonded pair has no pressure.
    pub bond: Option<BondResults<S>>,
}

/// The results of a bonded pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BondResults<S: Space = Plane> {
    /// The largest mean normal traction of a facet, Pa, by the equilibrated stress; 0 without tension.
    pub max_tension: f64,
    /// The middle of that facet, m; `None` without tension.
    pub at: Option<S::Vector>,
    /// The normal traction at each pair of nodes, the mean of the facets around, Pa: negative in tension, like a pressure.
    pub pressure: Vec<f64>,
}

/// The force of a patch of [`ContactArea::patches`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PatchResults<S: Space = Plane> {
    /// The mean of its nodes weighted by their forces, m.
    pub centre: S::Vector,
    /// The force on the first body, friction included, N/m.
    pub resultant: S::Vector,
}

/// The results of friction along a pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrictionResults<S: Space = Plane> {
    /// `Σ Q_i`, N/m: in the plane on the second body along the tangent `(−n_y, n_x)`, on the first against it. In space the length of the resultant.
    pub force: f64,
    /// The resultant of friction on the second body, N/m.
    pub resultant: S::Vector,
    /// Largest slip `|w|`, m.
    pub max_slip: f64,
    /// The tributary lengths or areas of the nodes in contact that stick and that slip, m or m².
    pub measures: [f64; 2],
    /// Intervals of arc length that are in contact and stick, m; empty in space.
    pub stick_intervals: Vec<[f64; 2]>,
    /// Intervals of arc length that are in contact and slip, m; empty in space.
    pub slip_intervals: Vec<[f64; 2]>,
}

/// The results of a cut.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CutResults {
    /// The body, in the order of [`Results`].
    pub body: usize,
    /// Its name.
    pub name: String,
    /// The force in it, N/m in the plane, N in space; it pulls if it is positive.
    pub force: f64,
    /// Its shortening, m.
    pub shortening: f64,
}

/// The largest von Mises stress of the recovered stress.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PeakStress<S: Space = Plane> {
    /// The stress, Pa.
    pub von_mises: f64,
    /// The body, in the order of [`Results`].
    pub body: usize,
    /// The node with this stress, m.
    pub point: S::Vector,
}

/// A principal stress of the recovered stress, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrincipalStress<S: Space = Plane> {
    /// The stress, Pa, tension positive.
    pub value: f64,
    /// The body, in the order of [`Results`].
    pub body: usize,
    /// The node with this stress, m.
    pub point: S::Vector,
}

/// The results of a run; arrays by body in the order of the problem passed to [`crate::solve`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Results<S: Space = Plane> {
    /// `a(u, u)` with `∫ k u²` of springs, J/m.
    pub energy_norm_squared: Vec<f64>,
    /// `Σ r²_i`, N/m.
    pub contact_force: f64,
    /// The results of each pair.
    pub contacts: Vec<PairResults<S>>,
    /// Intervals of arc length under pressure on the first contact line, m; empty in space.
    pub contact_intervals: Vec<[f64; 2]>,
    /// The connected parts of all contact lines; empty in space.
    pub contact_stretches: Vec<Stretch>,
    /// Largest nodal pressure, `max r²_i/ℓ_i`, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of an interface facet, Pa: at most `max_pressure`.
    pub max_facet_pressure: f64,
    /// Smallest opening of the iteration, m.
    pub min_opening: f64,
    /// Reactions of the supports.
    pub reactions: Vec<Reaction<S>>,
    /// Forces of the springs.
    pub springs: Vec<SpringForce<S>>,
    /// Forces and shortenings of the cuts.
    pub cuts: Vec<CutResults>,
    /// Motions and forces of the rigid sides.
    pub rigid_sides: Vec<RigidSideResults<S>>,
    /// Sum of loads, reactions, contact forces and springs of each body: zero to round-off.
    pub balance: Vec<Balance<S>>,
    /// Largest displacement, m.
    pub max_displacement: f64,
    /// Largest von Mises stress of the displacements, Pa; `None` if the out-of-plane stress of a material is unknown.
    pub max_von_mises: Option<f64>,
    /// The recovered stress of each body: continuous, one value per node and material.
    pub recovered: Vec<RecoveredStress<S>>,
    /// Its largest von Mises stress; `None` if the out-of-plane stress of a material is unknown.
    pub peak_stress: Option<PeakStress<S>>,
    /// Its smallest and its largest principal stress; in the plane those in the plane.
    pub principal_stress: Option<[PrincipalStress<S>; 2]>,
}

/// A problem with the external forces of each body, N/m, and how many subdomains each has.
type Posed<'a, S> = (&'a ContactProblem<S>, &'a [Vec<<S as Space>::Vector>], &'a [usize]);

/// Computes the results of an iteration.
///
/// * `low`: low-order parts of the displacements (their rounding errors), if known.
pub(crate) fn results<S: ContactSpace>(
    (problem, external_forces, subdomains): Posed<'_, S>,
    iterate: &Iterate,
    estimate: &Estimate<S>,
    low: Option<Vec<Vec<S::Vector>>>,
) -> Results<S> {
    let pair = &estimate.pair;
    let low = |b: usize| low.as_ref().map(|low| &low[b]);
    let (mut reactions, mut rigid_sides) = (Vec::new(), Vec::new());
    let (mut balance, mut springs, mut cuts) = (Vec::new(), Vec::new(), Vec::new());
    for (b, fields) in pair.bodies.iter().enumerate() {
        let acting = match subdomains.get(b).is_some_and(|count| *count > 1) {
            true => Acting::of_stress(problem, estimate, b),
            false => Acting::of_displacement(problem, iterate, (b, &fields.displacement), low(b)),
        };
        let held = (&mut reactions, &mut rigid_sides);
        balance.push(support_reactions((problem, external_forces), (b, &fields.displacement), acting, held));
        springs.extend(spring_sides((&problem.bodies[b], b), &fields.displacement));
        cuts.extend(cut_results((&problem.bodies[b], b), &fields.displacement));
    }
    let von_mises = |(body, fields): (&Body<S>, &AdmissibleBody<S>)| {
        let values = fields.stress.iter().enumerate();
        let values = values.map(|(t, s)| S::von_mises(body.material(t), *s, body.cell_temperature(t)));
        values.collect::<Option<Vec<f64>>>().map(largest)
    };
    let pairs = || pair_forces(problem, iterate);
    let means = problem.bodies.iter().zip(&estimate.mean_stress);
    let recovered: Vec<RecoveredStress<S>> = means.map(|(body, of)| RecoveredStress::new(body, of)).collect();
    let peak_stress = peak_stress(problem, &recovered);
    let contacts: Vec<PairResults<S>> =
        pairs().map(|pair| with_bond(of_pair(&pair), &pair, estimate)).collect();
    let stretches: Vec<Stretch> = pairs().flat_map(|pair| S::stretches(&pair)).collect();
    Results {
        energy_norm_squared: estimate.energy_norm_squared.clone(),
        contact_force: contacts.iter().map(|pair| pair.contact_force).sum(),
        contact_intervals: contacts.first().map(|pair| pair.contact_intervals.clone()).unwrap_or_default(),
        max_pressure: largest(contacts.iter().map(|pair| pair.max_pressure)),
        max_facet_pressure: largest(contacts.iter().map(|pair| pair.max_facet_pressure)),
        min_opening: contacts
            .iter()
            .filter(|pair| pair.bond.is_none())
            .map(|pair| pair.min_opening)
            .reduce(f64::min)
            .unwrap_or(0.0),
        contacts,
        contact_stretches: stretches,
        reactions,
        springs,
        cuts,
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
        principal_stress: principal_stress(problem, &recovered),
        recovered,
        peak_stress,
    }
}

/// Computes the forces in the cuts of a body.
fn cut_results<S: Space>(
    (body, b): (&Body<S>, usize),
    displacement: &[S::Vector],
) -> impl Iterator<Item = CutResults> {
    let forces = body.cuts().iter().zip(body.cut_forces(displacement));
    forces.map(move |(cut, [force, _])| CutResults {
        body: b,
        name: cut.name.clone(),
        force,
        shortening: cut.shortening,
    })
}

/// Finds the largest von Mises stress of all bodies.
fn peak_stress<S: Recovery>(
    problem: &ContactProblem<S>,
    recovered: &[RecoveredStress<S>],
) -> Option<PeakStress<S>> {
    let of_body = |(b, (body, stress)): (usize, (&Body<S>, &RecoveredStress<S>))| {
        let (von_mises, node) = stress.largest_von_mises(body)?;
        Some(PeakStress { von_mises, body: b, point: body.mesh().points()[node] })
    };
    let all = problem.bodies.iter().zip(recovered).enumerate().map(of_body).collect::<Option<Vec<_>>>()?;
    all.into_iter().max_by(|a, b| a.von_mises.total_cmp(&b.von_mises))
}

/// Finds the smallest and the largest principal stress of all bodies.
fn principal_stress<S: Recovery>(
    problem: &ContactProblem<S>,
    recovered: &[RecoveredStress<S>],
) -> Option<[PrincipalStress<S>; 2]> {
    let bodies = problem.bodies.iter().zip(recovered).enumerate();
    let of_body = |(b, (body, stress)): (usize, (&Body<S>, &RecoveredStress<S>))| {
        let at = |(value, node): (f64, NodeId)| PrincipalStress {
            value,
            body: b,
            point: body.mesh().points()[node],
        };
        Some(stress.extreme_principal()?.map(at))
    };
    bodies.filter_map(of_body).reduce(|[a, b], [c, d]| {
        [if c.value < a.value { c } else { a }, if d.value > b.value { d } else { b }]
    })
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// Computes the results of friction; `None` without it.
fn friction<S: ContactSpace>(of: &PairForces<'_, S>) -> Option<FrictionResults<S>> {
    if of.friction.is_empty() {
        return None;
    }
    let nodes = of.interface.pairs();
    let sticks = |k: usize| of.slip_size(k) == 0.0;
    let resultant: S::Vector = (0..nodes.len()).map(|k| of.friction_force(k)).sum();
    let mut measures = [0.0; 2];
    for (k, node) in nodes.iter().enumerate().filter(|(k, _)| of.is_pressed(*k)) {
        measures[usize::from(!sticks(k))] += node.weight;
    }
    let along = nodes.iter().zip(of.friction).map(|(node, q)| q * node.normal_length());
    Some(FrictionResults {
        force: if S::ONE_TANGENT { along.sum() } else { norm(resultant) },
        resultant,
        max_slip: largest((0..nodes.len()).map(|k| of.slip_size(k))),
        measures,
        stick_intervals: S::intervals(of.interface, &|k| of.is_pressed(k) && sticks(k)),
        slip_intervals: S::intervals(of.interface, &|k| of.is_pressed(k) && !sticks(k)),
    })
}

/// Computes the results of a pair.
fn of_pair<S: ContactSpace>(of: &PairForces<'_, S>) -> PairResults<S> {
    let place = |k: usize| of.points[of.interface.pairs()[k].nodes[0].index()];
    let contact_force: f64 = of.pressed().sum();
    let weighted: S::Vector = of.pressed().enumerate().map(|(k, r)| place(k) * r).sum();
    let pressures: Vec<f64> = of.pressures().collect();
    let most = (0..pressures.len()).max_by(|a, b| pressures[*a].total_cmp(&pressures[*b]));
    let mut moment = S::Spin::default();
    for k in 0..of.force.len() {
        moment += S::moment(place(k), of.on_first(k));
    }
    let facets = of.interface.facets().iter();
    let area = of.interface.contact_area(|k| of.is_pressed(k));
    let forces: Vec<f64> = of.pressed().collect();
    let patch = |patch: &ContactPatch| {
        let pairs = || patch.pairs.iter().copied();
        let force: f64 = pairs().map(|k| forces[k]).sum();
        PatchResults {
            centre: pairs().map(|k| place(k) * (forces[k] / force)).sum(),
            resultant: pairs().map(|k| of.on_first(k)).sum(),
        }
    };
    PairResults {
        resultant: (0..of.force.len()).map(|k| of.on_first(k)).sum(),
        moment,
        centre: (contact_force > 0.0).then(|| weighted * (1.0 / contact_force)),
        max_pressure_at: most.filter(|k| pressures[*k] > 0.0).map(place),
        contact_force,
        contact_intervals: S::intervals(of.interface, &|k| of.is_pressed(k)),
        patches: area.patches.iter().map(patch).collect(),
        area,
        max_pressure: largest(pressures.iter().copied()),
        max_facet_pressure: largest(facets.map(|facet| mean(of.interface, &pressures, facet))),
        max_recovered_pressure: recovered_pressure(of.problem, of.pair, &forces).map(largest),
        active: of.force.iter().filter(|r| **r > 0.0).count(),
        min_opening: of.distances(of.opening).fold(f64::INFINITY, f64::min),
        friction: friction(of),
        bond: None,
    }
}

/// Adds what the bond of a pair carries to its results, which are zero otherwise: by the tractions of the equilibrated stress.
fn with_bond<S: ContactSpace>(
    results: PairResults<S>,
    of: &PairForces<'_, S>,
    estimate: &Estimate<S>,
) -> PairResults<S> {
    let pair = &of.problem.contacts[of.pair];
    if !pair.is_bonded() {
        return results;
    }
    let mesh = of.problem.bodies[pair.body].mesh();
    let moments = &estimate.pair.bodies[pair.body].equilibrated.facet_moments;
    let (mut resultant, mut moment) = (S::Vector::default(), S::Spin::default());
    let mut bond = BondResults { max_tension: 0.0, at: None, pressure: vec![0.0; of.force.len()] };
    for contact in of.interface.facets() {
        let facet = contact.facets[0];
        let (nodes, normal) = (mesh.topology().facets()[facet], mesh.facet_normal(facet));
        let mut sum = S::Vector::default();
        for (node, force) in nodes.into_iter().zip(moments[facet]) {
            sum += force;
            moment += S::moment(of.points[node.index()], force);
            for k in contact.pairs {
                let of_pair = &of.interface.pairs()[k as usize];
                if of_pair.nodes[0] == node {
                    bond.pressure[k as usize] -= force.times(&normal) / of_pair.weight;
                }
            }
        }
        resultant += sum;
        let tension = sum.times(&normal) / mesh.facet_measure(facet);
        if tension > bond.max_tension {
            (bond.max_tension, bond.at) = (tension, Some(mesh.facet_middle(facet)));
        }
    }
    PairResults { resultant, moment, max_recovered_pressure: None, bond: Some(bond), ..results }
}

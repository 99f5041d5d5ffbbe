//! Bounds of the contact force, `N = ∫ p_ex ds`, from the two stresses of the certificate.
//!
//! Take a displacement `w` of one body that vanishes where displacements are imposed, has `w·n = ∓1` on the **whole** contact line (− on the
//! first body, from which `n` points) and does no work on the other contact lines of the body. Virtual work gives
//! ```math
//! N = ∫ σ : ε(w) − ℓ(w),   ∫ p = ∫ τ : ε(w) − ℓ(w),   W = ∫ σ(v) : ε(w) − ℓ(w)
//! ```
//! for the exact stress, the equilibrated one with its own pressure, and the computed one, whether or not it is in equilibrium. The mean of
//! the last two is near the exact stress:
//! ```math
//! ‖σ − ½(τ + σ(v))‖² = ¼ (‖σ−τ‖² + ‖σ−σ(v)‖² − 2∫ p o_ex − 2∫ p_ex o + 2∫ p o)  ≤  ¼ (e² + 2∫ p o)
//! |N − ½(∫ p + W)| ≤ ½ √(e² + 2∫ p o) ‖w‖
//! ```
//! With friction `∫ p o` is joined by the terms of (32), and `w` has no part along the tangent. With a lift `l` the admissible displacement is
//! `v + l`, so `‖τ − σ(v)‖` and the distance to the mean grow by `‖l‖` and `½ ‖l‖`. Two bodies with the shares `s₂/(s₁+s₂)`, `s₁/(s₁+s₂)` of
//! their `w`, `s = ‖w‖²`, have the least energy `s₁ s₂/(s₁+s₂)`. A rigid motion has none: the force is then known by equilibrium.
//!
//! A line on which the normal changes has no such P1 displacement, nor has one with a node that supports hold in both bodies.

use cre_estimator::{Estimate, Recovery};
use fem_core::assembly::spring_forces;
use fem_core::condensation::CondensedBody;
use fem_core::each_body;
use fem_core::element::Element;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactPair, Partner};
use fem_core::norm::{energy_norm_squared, from_squared, sum_over_cells};
use fem_core::prepared::{BodyMotion, FactorisedBody, PreparedProblem};
use fem_core::space::Space;
use nalgebra::{DMatrix, DVector};
use neumann_neumann::correction_from_traces;
use thiserror::Error;

/// A displacement whose traces are off by more than this does not have the wanted ones. A smaller difference goes to the allowance for round-off.
const TRACE: f64 = 1e-9;
/// Eigenvalues below this fraction of the largest one are zero.
const FREE: f64 = 1e-12;
/// Each `w` takes a solve with the whole body: a body with more contact lines is used only if the other one cannot be.
const FEW_LINES: usize = 8;

/// Why the contact force has no bounds.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoContactForce {
    /// There are no pairs.
    #[error("there is no contact line")]
    NoLine,
    /// The normal changes along a contact line.
    #[error("contact line {} is bent: no displacement moves all of it by one length along its normal", pair + 1)]
    Bent {
        /// The pair, from 0.
        pair: usize,
    },
    /// Both sides belong to one body, which bonds made.
    #[error("both sides of contact line {} belong to bonded bodies", pair + 1)]
    WithinABody {
        /// The pair, from 0.
        pair: usize,
    },
    /// Neither body can move the whole line along its normal.
    #[error(
        "neither body can move all of contact line {} by one length along its normal: supports or other contact lines hold a node of it",
        pair + 1
    )]
    Held {
        /// The pair, from 0.
        pair: usize,
    },
    /// The bound of the error overflows.
    #[error("the bound of the error is not finite")]
    NotFinite,
}

impl NoContactForce {
    /// Gives the pair another number.
    pub(crate) fn renumbered(self, number: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::Bent { pair } => Self::Bent { pair: number(pair) },
            Self::WithinABody { pair } => Self::WithinABody { pair: number(pair) },
            Self::Held { pair } => Self::Held { pair: number(pair) },
            Self::NoLine | Self::NotFinite => self,
        }
    }
}

/// The displacement `w` of one body.
#[derive(Clone, Copy, Debug)]
struct Displacement {
    /// `‖w‖²`, J/m.
    squared: f64,
    /// `W`, N/m, and the sum of the sizes of its terms.
    work: f64,
    size: f64,
    /// The largest difference from the wanted traces, dimensionless.
    defect: f64,
}

/// Bounds the sum of the contact forces of all pairs, N/m.
///
/// # Errors
/// A pair whose force has no bounds.
pub(crate) fn contact_force<S: Recovery>(
    problem: &PreparedProblem<S>,
    estimate: &Estimate<S>,
) -> Result<[f64; 2], NoContactForce> {
    let contacts = &problem.problem().contacts;
    if contacts.is_empty() {
        return Err(NoContactForce::NoLine);
    }
    let motions: Vec<Motions<S>> =
        problem.problem().partners().map(|partner| Motions::new(problem, partner)).collect();
    let forces = estimate.pressure_forces(problem.problem());
    let mut sum = [0.0; 2];
    for pair in 0..contacts.len() {
        let found = of_pair(problem, estimate, (&motions, &forces), pair)?;
        sum.iter_mut().zip(found).for_each(|(sum, bound)| *sum += bound);
    }
    if sum.iter().all(|x| x.is_finite()) { Ok(sum) } else { Err(NoContactForce::NotFinite) }
}

/// Bounds the contact force of one pair, N/m.
fn of_pair<S: Recovery>(
    problem: &PreparedProblem<S>,
    estimate: &Estimate<S>,
    (motions, forces): (&[Motions<S>], &[f64]),
    k: usize,
) -> Result<[f64; 2], NoContactForce> {
    let pair = &problem.problem().contacts[k];
    let held = NoContactForce::Held { pair: k };
    if pair.is_within_a_body() {
        return Err(NoContactForce::WithinABody { pair: k });
    }
    if pair.interface.has_bent_facets() || pair.interface.pairs().iter().any(|p| p.normal_length() != 1.0) {
        return Err(NoContactForce::Bent { pair: k });
    }
    // At a removed end both bodies are clamped.
    if !pair.interface.is_whole() {
        return Err(held);
    }
    let rigid = pair
        .partners()
        .into_iter()
        .filter_map(|partner| motions[partner.place(problem.bodies().len())].along(problem, partner, k));
    let shares: Vec<(f64, Displacement)> = match rigid.min_by(|a, b| a.size.total_cmp(&b.size)) {
        Some(rigid) => vec![(1.0, rigid)],
        None => shared(&elastic(problem, estimate, pair, k)),
    };
    if shares.is_empty() {
        return Err(held);
    }
    Ok(interval(estimate, (forces, k), &shares))
}

/// Shares one `w` between the bodies of a pair so that its energy is least.
fn shared(found: &[Displacement]) -> Vec<(f64, Displacement)> {
    match *found {
        [first, second] => {
            let share = second.squared / (first.squared + second.squared);
            vec![(share, first), (1.0 - share, second)]
        }
        _ => found.iter().map(|only| (1.0, *only)).collect(),
    }
}

/// Computes the interval of a pair from the displacements `w` of its bodies and their shares.
///
/// * `forces`: `∫ p` of each pair, N/m.
fn interval<S: Recovery>(
    estimate: &Estimate<S>,
    (forces, k): (&[f64], usize),
    shares: &[(f64, Displacement)],
) -> [f64; 2] {
    let sum = |of: &dyn Fn(&Displacement) -> f64| shares.iter().map(|(share, w)| share * of(w)).sum::<f64>();
    let squared: f64 = shares.iter().map(|(share, w)| share * share * w.squared).sum();
    let norm = from_squared(squared);
    let e_squared = estimate.unchecked().e_cre.powi(2);
    let lift = from_squared(estimate.pair.lift_energy);
    let contact = estimate.cre.contact_squared().max(0.0);
    // ‖τ − σ(v + l)‖, and what contact and friction add without ‖l‖².
    let stress = from_squared(e_squared - contact) + lift;
    let laws = (contact - lift * lift).max(0.0);
    let radius = 0.5 * ((stress * stress + 2.0 * laws).sqrt() + lift) * norm;
    let (work, size) = (sum(&|w| w.work), sum(&|w| w.size));

    // A rigid motion needs no pressure.
    let (middle, of_pressure) =
        if squared > 0.0 { (0.5 * (forces[k] + work), forces[k]) } else { (work, 0.0) };
    let defect = sum(&|w| w.defect) * (forces.iter().sum::<f64>() + work.abs() + radius);
    let noise = 64.0 * f64::EPSILON * (size + of_pressure) + estimate.round_off * norm + defect;
    [(middle - radius - noise).max(0.0), middle + radius + noise]
}

/// Finds the displacements `w` of least energy of the bodies of a pair.
fn elastic<S: Recovery>(
    problem: &PreparedProblem<S>,
    estimate: &Estimate<S>,
    pair: &ContactPair<S>,
    k: usize,
) -> Vec<Displacement> {
    let mut bodies: Vec<usize> = pair.elastic_sides().map(|(_, b)| b).collect();
    let lines = |b: usize| problem.problem().sides_of(Partner::Body(b)).count();
    bodies.sort_by_key(|b| lines(*b));
    let of_body = |b: usize| of_trace(problem, estimate, b, k);
    let few = bodies.iter().filter(|b| lines(**b) <= FEW_LINES).count();
    let (near, far) = bodies.split_at(few);
    let found: Vec<Displacement> =
        each_body(near.len(), |i| of_body(near[i])).into_iter().flatten().collect();
    if found.is_empty() { far.iter().find_map(|b| of_body(*b)).into_iter().collect() } else { found }
}

/// Lists the wanted traces of a body along the rows of its pairs: ∓1 along the normals of pair `k`, 0 along all others.
fn wanted<S: Recovery>(problem: &PreparedProblem<S>, partner: Partner, k: usize) -> Vec<Vec<f64>> {
    let contacts = &problem.problem().contacts;
    let of_side = |(line, side): (usize, usize)| {
        let along = [-1.0, 1.0][side];
        let normals = contacts[line].interface.pairs().len();
        let trace = |row: usize| if line == k && row < normals { along } else { 0.0 };
        (0..contacts[line].row_count()).map(trace).collect()
    };
    problem.problem().sides_of(partner).map(of_side).collect()
}

/// Computes the `w` of least energy with the wanted traces of a body; `None` if its supports do not allow them.
fn of_trace<S: Recovery>(
    problem: &PreparedProblem<S>,
    estimate: &Estimate<S>,
    b: usize,
    k: usize,
) -> Option<Displacement> {
    let wanted = wanted(problem, Partner::Body(b), k);
    let (w, defect) = match &problem.bodies()[b] {
        FactorisedBody::Whole(condensed) => in_one_piece(condensed, &wanted),
        FactorisedBody::Cut(_) => correction_from_traces(problem, b, &wanted).ok()?,
    };
    if !(defect <= TRACE) {
        return None;
    }
    let body = &problem.problem().bodies[b];
    let (mesh, stress) = (body.mesh(), &estimate.pair.bodies[b].stress);
    let inner = sum_over_cells(mesh.cells().len(), |t| {
        let nodes = &mesh.cells()[t];
        let strain = Element::<S>::new(mesh.corners(t)).strain(S::corners(|k| w[nodes[k]]));
        mesh.measure(t) * S::contracted(stress[t], strain)
    });
    let squared = energy_norm_squared(body, &w).max(0.0);
    let displacement = &estimate.pair.bodies[b].displacement;
    let of_springs = spring_forces(body, displacement).map(|(node, f)| f.times(&w[node]));
    let of_loads = problem.external_forces()[b].iter().zip(&w).map(|(f, w)| f.times(w));
    let (loads, sizes) =
        of_loads.chain(of_springs).fold((0.0, 0.0), |(sum, size), f| (sum + f, size + f.abs()));
    let size = (estimate.energy_norm_squared[b].max(0.0) * squared).sqrt() + sizes;
    Some(Displacement { squared, work: inner - loads, size, defect })
}

/// Computes the displacement of least energy with given traces, and the largest difference of its traces from them, m.
fn in_one_piece<S: Recovery>(condensed: &CondensedBody<S>, wanted: &[Vec<f64>]) -> (Vec<S::Vector>, f64) {
    let mut unknowns = vec![0.0; condensed.interface().len()];
    for (block, traces) in wanted.iter().enumerate() {
        for (row, trace) in
            condensed.dofs().rows(block).iter().zip(traces).filter(|(_, trace)| **trace != 0.0)
        {
            if let Some((unknown, factor)) = row.terms().next() {
                unknowns[unknown] = trace / factor;
            }
        }
    }
    let mut defect: f64 = 0.0;
    for (block, traces) in wanted.iter().enumerate() {
        for (row, trace) in condensed.dofs().rows(block).iter().zip(traces) {
            let found: f64 = row.terms().map(|(j, a)| a * unknowns[j]).sum();
            defect = defect.max((found - trace).abs());
        }
    }
    (condensed.correction_from_trace(&unknowns), defect)
}

/// The rigid motions of a body or of an obstacle: displacements of its nodes and the load along each.
struct Motions<S: Space>(Vec<Motion<S>>);

struct Motion<S: Space> {
    moved: Vec<S::Vector>,
    load: f64,
    /// The sum of the sizes of the terms of the load, of forces across the motion as well: their work is rounding.
    size: f64,
}

impl<S: Recovery> Motions<S> {
    fn new(problem: &PreparedProblem<S>, partner: Partner) -> Self {
        let of = |of: &BodyMotion<S>| {
            let moved = problem.moved_by(of);
            let size = match partner {
                Partner::Obstacle(_) => of.load.abs(),
                Partner::Body(b) => {
                    problem.external_forces()[b].iter().zip(&moved).map(|(f, u)| norm(*f) * norm(*u)).sum()
                }
            };
            Motion { moved, load: of.load, size }
        };
        Self(problem.rigid_motions().iter().filter(|of| of.partner == partner).map(of).collect())
    }

    /// Finds the rigid motion with the wanted traces; `None` if the body has no such motion.
    fn along(&self, problem: &PreparedProblem<S>, partner: Partner, k: usize) -> Option<Displacement> {
        if self.0.is_empty() {
            return None;
        }
        let wanted = DVector::from_vec(wanted(problem, partner, k).concat());
        let contacts = &problem.problem().contacts;
        let column = |motion: &Motion<S>| -> Vec<f64> {
            let sides = problem.problem().sides_of(partner);
            let rows = sides.flat_map(|(line, side)| contacts[line].rows().map(move |row| (row, side)));
            rows.map(|(row, side)| motion.moved[row.nodes[side].index()].times(&row.direction)).collect()
        };
        let columns: Vec<f64> = self.0.iter().flat_map(column).collect();
        let columns = DMatrix::from_vec(wanted.len(), self.0.len(), columns);
        // The traces of a motion along the contact are rounding.
        let scale = columns.column_iter().zip(&self.0).map(|(column, motion)| {
            let (most, size) = (column.amax(), motion.moved.iter().map(|u| norm(*u)).fold(0.0, f64::max));
            if most > TRACE * size { 1.0 / most } else { 0.0 }
        });
        let scale = DMatrix::from_diagonal(&DVector::from_iterator(self.0.len(), scale));
        let columns = columns * &scale;
        let eigen = columns.tr_mul(&columns).symmetric_eigen();
        let least = FREE * eigen.eigenvalues.max();
        let inverse = eigen.eigenvalues.map(|value| if value > least { 1.0 / value } else { 0.0 });
        let amounts = &eigen.eigenvectors
            * DMatrix::from_diagonal(&inverse)
            * eigen.eigenvectors.tr_mul(&columns.tr_mul(&wanted));
        let defect = (&columns * &amounts - wanted).amax();
        let amounts = scale * amounts;
        let sum = |of: &dyn Fn(&Motion<S>) -> f64| -> f64 {
            self.0.iter().zip(&amounts).map(|(motion, amount)| amount * of(motion)).sum()
        };
        let size = self.0.iter().zip(&amounts).map(|(motion, amount)| amount.abs() * motion.size).sum();
        (defect <= TRACE).then(|| Displacement {
            squared: 0.0,
            work: -sum(&|motion| motion.load),
            size,
            defect,
        })
    }
}

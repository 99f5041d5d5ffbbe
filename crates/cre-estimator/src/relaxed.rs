//! The admissible pair with relaxed stresses, and the stresses for a frozen λ.

use crate::admissible::{AdmissibleBody, AdmissiblePair, check_state, recovered_pair, with_imposed_normal};
use crate::columns::{Columns, relax_body};
use crate::equilibrated::{EquilibratedStress, FacetMoments, add};
use crate::error::EstimatorError;
use crate::measures::Accuracy;
use crate::recovery::{Recovery, StarMemory};
use crate::relaxation::{LEAST, Relaxation};
use crate::springs::released;
use fem_core::interface::{ContactState, Partner};
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use neumann_neumann::BodySolvers;
use rayon::prelude::*;

/// The equilibrated stress of each body for a frozen λ; `None` if it has none, or if it is not known yet.
pub(crate) type FrozenStresses<S> = Vec<Option<EquilibratedStress<S>>>;

/// Builds the admissible pair of a contact state.
///
/// The pressure is `p_i = r²_i/ℓ_i`, linear along straight contact edges, its mean on edges along which the normal changes.
/// There a lift opens the bodies until they penetrate nowhere (theory: the contact line is a
/// polygon with a frozen normal field, linear along the edges). One Neumann problem per body with the consistent load
/// `∫ p n φ_i` gives an FE stress in FE equilibrium with exactly this pressure; EET and Johnson-Mercier make it equilibrated, and the
/// relaxation sharpens it.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite.
pub fn admissible_pair<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    relaxation: Relaxation,
) -> Result<AdmissiblePair<S>, EstimatorError> {
    check_state(prepared, state)?;
    let solvers = BodySolvers::new(prepared)?;
    let mut pair = recovered_pair(&solvers, state, Accuracy::Double)?;
    relax_bodies(&solvers, &mut pair, (relaxation, None), &mut KeptStars::default());
    Ok(pair)
}

/// [`admissible_pair`] of a state that has been checked, and, if there are stars, the stresses for a frozen λ: the same stars relax both stresses
/// of a body.
///
/// * `kept`: the stars of estimates before.
pub(crate) fn pair_and_frozen<'a, S: Recovery>(
    solvers: &BodySolvers<'a, S>,
    state: &ContactState<'_, S>,
    (relaxation, accuracy): (Relaxation, Accuracy),
    kept: &mut KeptStars<'a, S>,
) -> Result<(AdmissiblePair<S>, FrozenStresses<S>), EstimatorError> {
    let mut pair = recovered_pair(solvers, state, accuracy)?;
    let frozen = relax_bodies(solvers, &mut pair, (relaxation, Some(accuracy)), kept);
    Ok((pair, frozen))
}

/// The stars of each body of a problem, for several estimates. Large bodies keep theirs from the second one on: in the first one they share
/// their memory, because the first access to new memory is slow, and most problems have one estimate.
pub(crate) struct KeptStars<'a, S: Recovery> {
    of_body: Vec<Option<S::Stars<'a>>>,
    /// What the stars of each body do not reach.
    columns: Vec<Columns<S>>,
    /// True after the first estimate.
    estimated: bool,
    /// True if coefficients are computed again, see [`StarMemory`].
    pub(crate) recomputes: bool,
}

impl<S: Recovery> Default for KeptStars<'_, S> {
    fn default() -> Self {
        Self { of_body: Vec::new(), columns: Vec::new(), estimated: false, recomputes: false }
    }
}

impl<S: Recovery> KeptStars<'_, S> {
    /// Tells whether a body has its stars.
    pub(crate) fn has(&self, body: usize) -> bool {
        self.of_body.get(body).is_some_and(Option::is_some)
    }
}

/// Bodies with no more vertices than this are relaxed at the same time, each by one thread: their bands are too few for several.
const SMALL: usize = 2048;

/// The stars of a body, if it has any, its columns, and what the relaxation added to the facet moments of its stress.
pub(crate) type Found<'s, 'b, S> =
    (&'s mut Option<<S as Recovery>::Stars<'b>>, &'s mut Columns<S>, FacetMoments<S>);

/// The stars of a body, if they are known, and its columns.
type Of<'s, 'b, S> = (&'s mut Option<<S as Recovery>::Stars<'b>>, &'s mut Columns<S>);

/// Relaxes the stresses of each body. Large bodies follow one after the other, each in parallel.
///
/// * `accuracy`: of the stresses for a frozen λ, if they are asked for.
fn relax_bodies<'a, S: Recovery>(
    solvers: &BodySolvers<'a, S>,
    pair: &mut AdmissiblePair<S>,
    (relaxation, accuracy): (Relaxation, Option<Accuracy>),
    kept: &mut KeptStars<'a, S>,
) -> FrozenStresses<S> {
    let problem = solvers.problem();
    let recomputes = kept.recomputes;
    let is_small = |b: usize| problem.bodies[b].mesh().points().len() <= SMALL;
    kept.of_body.resize_with(problem.bodies.len(), || None);
    kept.columns.resize_with(problem.bodies.len(), Columns::default);
    // Relaxes one body with its stars and columns, which are made if they are missing.
    let relax = |b: usize, fields: &mut AdmissibleBody<S>, (stars, columns): Of<'_, 'a, S>, used| {
        let memory = StarMemory::new(recomputes, used);
        let (body, stress) = (&problem.bodies[b], &mut fields.equilibrated);
        columns.recomputes = recomputes;
        let accuracy = accuracy.filter(|_| freezes_lambda(solvers, b));
        let before = accuracy.map(|accuracy| (accuracy, stress.facet_moments.clone()));
        fields.relaxation = S::relax_with(body, stress, columns.leave_room(body, relaxation), stars, memory);
        let of_body = (body, Some(&solvers.bodies()[b]));
        columns.lower(of_body, (stress, &mut fields.relaxation), relaxation, stars);
        let (accuracy, mut added) = before?;
        let moments = added.iter_mut().flat_map(|of| of.as_mut());
        let now = fields.equilibrated.facet_moments.iter().flat_map(|of| of.as_ref());
        moments.zip(now).for_each(|(m, now)| *m = *now - *m);
        Some(frozen_stress((solvers, b, fields), (relaxation, accuracy), Some((stars, columns, added))))
    };
    let bodies = pair.bodies.par_iter_mut().zip(&mut kept.of_body).zip(&mut kept.columns).enumerate();
    let small = bodies.map(
        |(b, ((fields, stars), columns))| {
            if is_small(b) { relax(b, fields, (stars, columns), None) } else { None }
        },
    );
    let mut frozen: FrozenStresses<S> = small.collect();
    let mut used = None;
    for b in problem.by_role().into_iter().rev().filter(|b| !is_small(*b)) {
        let of_body = (&mut kept.of_body[b], &mut kept.columns[b]);
        frozen[b] = relax(b, &mut pair.bodies[b], of_body, used.take());
        if !kept.estimated {
            used = kept.of_body[b].take();
        }
    }
    kept.estimated = true;
    frozen
}

/// Tells whether a body in one piece carries λ in all its pairs, along straight edges: then its stress for a frozen λ counts. The displacement of a body in
/// subdomains is in equilibrium with its trace only when the iteration has ended.
pub(crate) fn freezes_lambda<S: Recovery>(solvers: &BodySolvers<'_, S>, b: usize) -> bool {
    let problem = solvers.problem();
    let imposed = |(k, _): (usize, usize)| {
        let pair = &problem.contacts[k];
        pair.imposed() == Partner::Body(b) && !pair.is_within_a_body()
    };
    let straight = |(k, _): (usize, usize)| !problem.contacts[k].interface.has_bent_facets();
    let sides = || problem.sides_of(Partner::Body(b));
    let whole = solvers.bodies()[b].whole().is_some();
    whole && problem.carries_lambda(b) && sides().all(imposed) && sides().all(straight)
}

/// Recovers the stress of a body for a frozen λ, and relaxes it.
///
/// A relaxation to a tolerance begins with what the stress of the bound gained and takes two steps: little is left to gain then. If the stress is not
/// as sharp as the one of the bound, it takes more, but no more than that one did: a frozen λ leaves strong singularities at ends of the contact line,
/// for which an indicator would take up to 100 steps.
///
/// * `found`: stars of the body, prepared for whatever reactions; without them they are made for this stress. The moments that they added to the
///   stress of the bound are in equilibrium with a frozen λ as well.
pub(crate) fn frozen_stress<'a, S: Recovery>(
    (solvers, b, fields): (&BodySolvers<'a, S>, usize, &AdmissibleBody<S>),
    (relaxation, accuracy): (Relaxation, Accuracy),
    found: Option<Found<'_, 'a, S>>,
) -> EquilibratedStress<S> {
    let (body, solver) = (&solvers.problem().bodies[b], &solvers.bodies()[b]);
    let mut field = SplitField::new(fields.displacement.clone());
    let stress = match accuracy {
        Accuracy::Double => fields.stress.clone(),
        Accuracy::Refined => {
            solver.refine(body, &[], true, &mut field);
            residual::stresses(body, &field)
        }
    };
    let conditions = with_imposed_normal(solvers.problem(), b, &field.high);
    let conditions = released(body, conditions, &[&field.high, &field.low]);
    let mut recovered = EquilibratedStress::recover(body, stress, conditions);
    let bound = &fields.relaxation;
    let up_to = |steps: usize| match relaxation {
        Relaxation::Tolerance { tolerance, max_steps } => {
            Relaxation::Tolerance { tolerance, max_steps: max_steps.min(steps.max(LEAST)) }
        }
        fixed => fixed,
    };
    let Some((stars, columns, added)) = found else {
        relax_body((body, Some(solver)), &mut recovered, up_to(bound.steps));
        return recovered;
    };
    if let Relaxation::Tolerance { .. } = relaxation {
        add::<S>(&mut recovered.facet_moments, 1.0, &added);
    }
    let mut relax = |relaxation| {
        let mut report = S::relax_with(body, &mut recovered, relaxation, stars, StarMemory::Stored(None));
        columns.lower((body, Some(solver)), (&mut recovered, &mut report), relaxation, stars);
        report.energy()
    };
    let found = relax(up_to(LEAST));
    if let Relaxation::Tolerance { tolerance, .. } = relaxation
        && bound.steps > LEAST
        && found > (1.0 + tolerance).powi(2) * bound.energy()
    {
        relax(up_to(bound.steps));
    }
    recovered
}

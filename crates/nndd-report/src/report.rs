//! From a solution to the rows and tables of report.json.

use crate::motion;
use crate::notes;
use crate::solved::{Fields, Solved};
use case_io::Case;
use case_io::case::Factors;
use case_io::report::{
    BodySummary, Bounds, Certificate, Checks, ContactStretch, ContactSummary, Coulomb, FreeMotion,
    FrictionSummary, IterationRow, PeakStress, ProjectedLoad, Reaction, Report, Results, RigidSideSummary,
    SCHEMA, Split, StepSummary, Timings,
};
use case_io::table::{ContactRow, FrictionRow};
use certified_contact::cre_estimator::{Admissibility, Parts};
use certified_contact::{
    CertifiedSolution, CoulombResult, IterationRecord, PairResults, RigidSideResults, recovered_pressure,
};
use fem_core::interface::{ContactProblem, LeftOut, Partner};
use serde_json::{Map, Value};

/// Makes a row of `iterations` in report.json.
pub fn iteration_row(row: &IterationRecord) -> IterationRow {
    let it = &row.iteration;
    let finite = |x: f64| x.is_finite().then_some(x);
    IterationRow {
        iteration: it.iteration,
        theta: finite(it.theta).filter(|theta| *theta > 0.0),
        precision: finite(it.precision),
        eta_nndd: finite(it.eta_nndd),
        eta_dis: row.eta_dis,
        e_cre: row.e_cre,
        contact_nodes: it.contact_nodes,
        contact_force: finite(it.contact_force),
        contact_forces: row.contact_forces.map(finite),
        qp_path: Some(it.qp_path.to_string()),
        qp_iterations: it.qp_iterations,
        step: Some(it.step[0]).filter(|step| *step > 0),
        inner: Some(it.step[1]).filter(|_| it.step[0] > 0),
    }
}

fn rigid_sides(solution: &Fields<'_>, body: usize) -> Vec<RigidSideSummary> {
    let results = solution.results.iter().flat_map(|r| &r.rigid_sides).filter(|side| side.body == body);
    let summary = |side: &RigidSideResults| RigidSideSummary {
        on: side.on.clone(),
        motion: [side.motion.translation[0], side.motion.translation[1], side.motion.spin],
        force: side.force.into(),
        moment: side.moment,
        about: side.motion.centre.into(),
    };
    results.map(summary).collect()
}

/// Collects the report; its timings are filled in when everything else is written.
pub(crate) fn report(case: &Case, solved: &Solved, run: Map<String, Value>) -> Report {
    let solution = &solved.answer.fields();
    let name = |b: usize| case.bodies[b].name.clone();
    let free = certified_contact::free_motions(solution.problem).unwrap_or_default();
    let bodies = solution.problem.bodies.iter().zip(solution.unknowns).enumerate();
    let bodies = bodies.map(|(b, (body, &unknowns))| {
        let mesh = body.mesh();
        let own = free.iter().flatten().filter(|(of, _)| *of == Partner::Body(b));
        let free_motions = own.map(|(_, motion)| FreeMotion {
            translation: motion.translation.into(),
            rotation: motion.spin,
            centre: motion.centre.into(),
        });
        BodySummary {
            name: name(b),
            nodes: mesh.points().len(),
            triangles: mesh.cells().len(),
            unknowns,
            floating: body.free_motion().is_some(),
            free_motions: free_motions.collect(),
            rigid_sides: rigid_sides(solution, b),
        }
    });
    let contact = (0..solution.problem.contacts.len()).map(|k| contact_summary(case, solution, k));
    Report {
        schema: SCHEMA,
        status: solved.status.clone(),
        case: case.settings_json(),
        bodies: bodies.collect(),
        contact: contact.collect(),
        iterations: solution.rows.iter().map(iteration_row).collect(),
        problem: law(solution.problem).to_owned(),
        certificate: solved.answer.certified().map(|solution| Certificate {
            smallest_mesh: solved.smallest_mesh,
            ..certificate(case, solution)
        }),
        coulomb: solved.answer.coulomb().map(coulomb),
        results: results(case, solution, solved.peak_change),
        adaptive: solved.adaptive.clone(),
        steps: solved.steps.iter().map(|step| step.summary.clone()).collect(),
        notes: notes::of_report(case, solved),
        timings: Timings::default(),
        run,
    }
}

/// Makes the entry of a load step, from 1.
pub(crate) fn step_summary(case: &Case, solved: &Solved, step: usize, factors: &Factors) -> StepSummary {
    let solution = &solved.answer.fields();
    StepSummary {
        step,
        factors: factors.named.iter().map(|(name, factor)| (name.clone(), (*factor).into())).collect(),
        status: solved.status.clone(),
        contact: (0..solution.problem.contacts.len()).map(|k| contact_summary(case, solution, k)).collect(),
        results: results(case, solution, None),
        certificate: solved.answer.certified().map(|solution| certificate(case, solution)),
        coulomb: solved.answer.coulomb().map(coulomb),
    }
}

fn contact_summary(case: &Case, solution: &Fields<'_>, k: usize) -> ContactSummary {
    let pair = &solution.problem.contacts[k];
    let name = |of: Partner| of.body().map(|body| case.bodies[body].name.clone());
    let found = solution.results.and_then(|results| results.contacts.get(k));
    let kind = if pair.partner.is_obstacle() { "obstacle" } else { "bodies" };
    ContactSummary {
        name: case.contacts[k].name.clone(),
        kind: kind.to_owned(),
        bodies: pair.partners().into_iter().filter_map(name).collect(),
        imposed: name(pair.imposed()).unwrap_or_default(),
        pairs: pair.interface.pairs().len(),
        length: pair.interface.measure(),
        resultant: found.map(|found| found.resultant.into()),
        moment: found.map(|found| found.moment),
        centre: found.and_then(|found| found.centre).map(Into::into),
        max_pressure_at: found.and_then(|found| found.max_pressure_at).map(Into::into),
        contact_force: found.map(|found| found.contact_force),
        contact_intervals: found.map(|found| found.contact_intervals.clone()),
        max_pressure: found.map(|found| found.max_pressure),
        max_pressure_recovered: found.and_then(|found| found.max_recovered_pressure),
        active: found.map(|found| found.active),
        min_opening: found.map(|found| found.min_opening),
        friction: found.and_then(|found| found.friction.as_ref()).map(|found| FrictionSummary {
            law: case.contacts[k].friction.as_ref().map_or("", |friction| friction.law()).to_owned(),
            mu: pair.friction.coulomb(),
            tangential_force: found.force,
            stick_intervals: found.stick_intervals.clone(),
            slip_intervals: found.slip_intervals.clone(),
            max_slip: found.max_slip,
        }),
    }
}

fn certificate(case: &Case, solution: &CertifiedSolution) -> Certificate {
    let Some(estimate) = &solution.estimate else { return Certificate::default() };
    let a = &estimate.admissibility;
    let found = estimate.unchecked();
    // The allowance for round-off counts as algebraic, so that the two still make the whole.
    let discretisation = found.parts.mesh;
    let algebraic = (found.e_cre.powi(2) - discretisation.powi(2)).max(0.0).sqrt();
    let Parts { mesh, iteration, contact, lift, gap_data, friction, round_off, .. } = found.parts;
    let parts = [mesh, iteration, contact, lift, gap_data, friction, round_off].map(Some);
    let [mesh, iteration, contact, lift, gap_data, friction, round_off] = parts;
    Certificate {
        valid: solution.is_certified(),
        reason: estimate.reason().map(str::to_owned),
        e_cre: Some(found.e_cre),
        relative: solution.relative(),
        relative_guaranteed: solution.relative_guaranteed(),
        eta_dis: Some(found.eta_dis),
        eta_nndd: Some(found.eta_nndd.max(solution.last().eta_nndd)).filter(|eta| eta.is_finite()),
        split: Split { discretisation: Some(discretisation), algebraic: Some(algebraic) },
        parts: case_io::report::Parts { mesh, iteration, contact, lift, gap_data, friction, round_off },
        problem: law(&solution.problem).to_owned(),
        pressure_shift: Some(estimate.pair.pressure_shift),
        projected_load: projected(case, &solution.problem.left_out),
        smallest_mesh: None,
        bounds: bounds(solution),
        checks: checks(a),
    }
}

/// Writes down the loads that were left out.
pub(crate) fn projected(case: &Case, loads: &[LeftOut]) -> Vec<ProjectedLoad> {
    let of = |of: &LeftOut| {
        let body = case.bodies[of.body].name.clone();
        ProjectedLoad { body, motion: motion::moves(&of.motion), load: of.load, share: of.share }
    };
    loads.iter().map(of).collect()
}

fn checks(a: &Admissibility) -> Checks {
    // A residual without anything to compare it with fails, and has no number.
    let finite = |x: f64| x.is_finite().then_some(x);
    Checks {
        equilibrium: finite(a.equilibrium),
        traction_jump: finite(a.traction_jump),
        boundary_traction: finite(a.boundary_traction),
        penetration: finite(a.penetration),
        pressure_sign: finite(a.pressure_sign),
        supports: finite(a.supports),
        imposed_displacement: finite(a.imposed_displacement),
        rigid_balance: finite(a.rigid_balance),
        rotation: finite(a.rotation),
        friction_cone: finite(a.friction_cone),
    }
}

/// Names the law of a problem: Coulomb's if any pair has it.
fn law(problem: &ContactProblem) -> &'static str {
    match problem.contacts.iter().any(|pair| pair.friction.coulomb().is_some()) {
        true => "coulomb",
        false if problem.has_friction() => "tresca",
        false => "frictionless",
    }
}

/// Makes the summary of a residual, with Coulomb friction.
fn coulomb(result: &CoulombResult) -> Coulomb {
    let (norm, estimate) = (result.energy_norm(), result.conditional_estimate());
    Coulomb {
        e_b: result.residual(),
        frozen_bound: result.bound_for_frozen_limit(),
        relative: result.relative_residual(),
        kappa: result.kappa(),
        one_sign: result.has_one_sign(),
        estimate,
        relative_estimate: result.relative_residual().and(estimate).map(|estimate| estimate / norm),
        coupling: result.coupling(),
        steps: result.solution.steps,
        change: result.solution.changes.last().copied().filter(|change| change.is_finite()),
        restarts: result.solution.restarts,
        checks: checks(&result.estimate().admissibility),
    }
}

fn bounds(solution: &CertifiedSolution) -> Bounds {
    let Some(bounds) = solution.bounds.filter(|_| solution.is_certified()) else { return Bounds::default() };
    Bounds {
        energy_norm: Some(bounds.energy_norm),
        potential_energy: Some(bounds.potential_energy),
        contact_force: bounds.contact_force.ok(),
        contact_force_reason: bounds.contact_force.err().map(|reason| reason.to_string()),
    }
}

fn results(case: &Case, solution: &Fields<'_>, change: Option<f64>) -> Results {
    let Some(r) = solution.results else { return Results::default() };
    let reactions = r.reactions.iter().map(|reaction| Reaction {
        body: case.bodies[reaction.body].name.clone(),
        on: reaction.on.clone(),
        fx: reaction.force[0],
        fy: reaction.force[1],
    });
    let stretches = r.contact_stretches.iter().map(|s| ContactStretch {
        s: s.s,
        pairs: s.pairs,
        length: s.length,
        contact_force: s.contact_force,
        resultant: s.resultant.into(),
        moment: s.moment,
        max_pressure: s.max_pressure,
        max_edge_pressure: s.max_edge_pressure,
        min_opening: s.min_opening,
    });
    Results {
        energy_norm_squared: Some(r.energy_norm_squared.clone()),
        contact_force: Some(r.contact_force),
        contact_intervals: Some(r.contact_intervals.clone()),
        contact_stretches: Some(stretches.collect()),
        max_pressure: Some(r.max_pressure),
        max_pressure_recovered: max_recovered(r),
        max_edge_pressure: Some(r.max_facet_pressure),
        min_opening: Some(r.min_opening),
        reactions: Some(reactions.collect()),
        balance: Some(r.balance.iter().map(|b| [b.force[0], b.force[1], b.moment]).collect()),
        max_displacement: Some(r.max_displacement),
        max_von_mises: r.max_von_mises,
        peak_stress: r.peak_stress.map(|peak| PeakStress {
            von_mises: peak.von_mises,
            body: case.bodies[peak.body].name.clone(),
            x: peak.point[0],
            y: peak.point[1],
            change,
        }),
    }
}

/// The largest pressure of all pairs, if any is recovered; the nodal ones of the others count.
fn max_recovered(results: &certified_contact::Results) -> Option<f64> {
    let recovered = results.contacts.iter().any(|pair| pair.max_recovered_pressure.is_some());
    let largest = |pair: &PairResults| pair.max_recovered_pressure.unwrap_or(pair.max_pressure);
    results.contacts.iter().map(largest).reduce(f64::max).filter(|_| recovered)
}

/// Arc lengths, gaps, openings, pressures along the contact line of a pair; s runs along its first body.
pub(crate) fn contact_rows(solution: &Fields<'_>, pair: usize) -> Vec<ContactRow> {
    let first = solution.problem.blocks().nth(pair).map_or(0, |block| block.start);
    let tangents = solution.problem.tangential_blocks().nth(pair).unwrap_or_default();
    let tangential = &solution.last.tangential;
    // With Coulomb friction the bound holds for the problem with these frozen limits.
    let given = solution.problem.contacts[pair].friction.coulomb().is_none();
    let frozen = solution.frozen_limit.as_ref().filter(|_| !given).map(|limits| limits[pair]);
    let friction = |k: usize, pressed: bool, (length, normal): (f64, f64)| {
        let row = tangents.clone().nth(k)?;
        let slip = tangential.slip[row];
        Some(FrictionRow {
            tangential: tangential.force[row] * normal / length,
            slip: slip / normal,
            limit: normal * frozen.map_or(tangential.limit[row] / length, |frozen| frozen[k]),
            state: match (pressed, slip == 0.0) {
                (false, _) => "open",
                (true, true) => "stick",
                (true, false) => "slip",
            }
            .to_owned(),
        })
    };
    let forces: Vec<f64> = {
        let nodes = solution.problem.contacts[pair].interface.pairs().iter().enumerate();
        nodes
            .map(|(k, node)| node.normal_length() * solution.last.contact.normal_reaction[first + k])
            .collect()
    };
    let recovered = recovered_pressure(solution.problem, pair, &forces);
    let pair = &solution.problem.contacts[pair];
    let points = solution.problem.bodies[pair.body].mesh().points();
    let (last, arc_lengths) = (solution.last, pair.interface.arc_lengths());
    pair.interface
        .pairs()
        .iter()
        .enumerate()
        .map(|(k, pair)| {
            let [x, y] = (points[pair.nodes[0]]).into();
            let (length, normal) = (pair.weight, pair.normal_length());
            let force = last.contact.normal_reaction[first + k];
            ContactRow {
                s: arc_lengths[k],
                x,
                y,
                gap: pair.gap / normal,
                opening: last.opening[first + k] / normal,
                pressure: force * normal / length,
                active: u8::from(force > 0.0),
                pressure_recovered: recovered.as_ref().map(|recovered| recovered[k]),
                step: None,
                friction: friction(k, force > 0.0, (length, normal)),
            }
        })
        .collect()
}

//! From a solution to the rows and tables of report.json.

use crate::motion;
use crate::notes;
use crate::solved::{Fields, Solved};
use crate::space::ReportSpace;
use crate::stress_limits;
use case_io::Case;
use case_io::case::Factors;
use case_io::report::{
    BodySummary, Bounds, Certificate, Checks, ContactSummary, Coulomb, CutResult, FreeMotion,
    FrictionSummary, IterationRow, PeakStress, PrincipalStress, PrincipalStresses, ProjectedLoad, Reaction,
    Report, Results, RigidSideSummary, SCHEMA, Split, StepSummary, Timings,
};
use case_io::table::{ContactRow, FrictionRow};
use certified_contact::cre_estimator::{Admissibility, Parts};
use certified_contact::{
    CertifiedSolution, CoulombResult, IterationRecord, PairResults, RigidSideResults, recovered_pressure,
};
use fem_core::geometry::{Coordinates, norm};
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

fn rigid_sides<S: ReportSpace>(solution: &Fields<'_, S>, body: usize) -> Vec<RigidSideSummary> {
    let results = solution.results.iter().flat_map(|r| &r.rigid_sides).filter(|side| side.body == body);
    let summary = |side: &RigidSideResults<S>| RigidSideSummary {
        on: side.on.clone(),
        motion: S::motion(side.motion.translation, side.motion.spin).as_ref().to_vec(),
        force: side.force.entries().to_vec(),
        moment: S::spin_written(side.moment),
        about: side.motion.centre.entries().to_vec(),
    };
    results.map(summary).collect()
}

/// Collects the report; its timings are filled in when everything else is written.
pub(crate) fn report<S: ReportSpace>(case: &Case<S>, solved: &Solved<S>, run: Map<String, Value>) -> Report {
    let solution = &solved.answer.fields();
    let name = |b: usize| case.bodies[b].name.clone();
    let free = certified_contact::free_motions(solution.problem).unwrap_or_default();
    let bodies = solution.problem.bodies.iter().zip(solution.unknowns).enumerate();
    let bodies = bodies.map(|(b, (body, &unknowns))| {
        let mesh = body.mesh();
        let own = free.iter().flat_map(|motion| &motion.bodies).filter(|(of, _)| *of == Partner::Body(b));
        let free_motions = own.map(|(_, motion)| FreeMotion {
            translation: motion.translation.entries().to_vec(),
            rotation: S::spin_written(motion.spin),
            centre: motion.centre.entries().to_vec(),
        });
        BodySummary {
            name: name(b),
            nodes: mesh.points().len(),
            cells: S::cells_written(mesh.cells().len()),
            unknowns,
            subdomains: solution.subdomains.get(b).copied().filter(|count| *count > 1),
            floating: body.free_motion().is_some(),
            free_motions: free_motions.collect(),
            rigid_sides: rigid_sides(solution, b),
        }
    });
    let contact = (0..solution.problem.contacts.len()).map(|k| contact_summary(case, solution, k));
    let results = results(case, solution, solved.peak_change);
    let limits = stress_limits::notes(case, &results);
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
        results,
        adaptive: solved.adaptive.clone(),
        steps: solved.steps.iter().map(|step| step.summary.clone()).collect(),
        notes: [notes::of_report(case, solved), limits].concat(),
        timings: Timings::default(),
        run,
    }
}

/// Makes the entry of a load step, from 1.
pub(crate) fn step_summary<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    step: usize,
    factors: &Factors,
) -> StepSummary {
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

fn contact_summary<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>, k: usize) -> ContactSummary {
    let pair = &solution.problem.contacts[k];
    let name = |of: Partner| of.body().map(|body| case.bodies[body].name.clone());
    let found = solution.results.and_then(|results| results.contacts.get(k));
    let kind = if pair.partner.is_obstacle() { "obstacle" } else { "bodies" };
    ContactSummary {
        name: case.contacts[k].name.clone(),
        law: if pair.is_bonded() { "bonded" } else { "unilateral" }.to_owned(),
        kind: kind.to_owned(),
        bodies: pair.partners().into_iter().filter_map(name).collect(),
        imposed: name(pair.imposed()).filter(|_| !pair.is_bonded()).unwrap_or_default(),
        pairs: pair.interface.pairs().len(),
        line: S::contact_line(pair, found),
        surface: S::contact_surface(pair, found),
        resultant: found.map(|found| found.resultant.entries().to_vec()),
        moment: found.map(|found| S::spin_written(found.moment)),
        centre: found.and_then(|found| found.centre).map(|centre| centre.entries().to_vec()),
        max_pressure_at: found.and_then(|found| found.max_pressure_at).map(|at| at.entries().to_vec()),
        contact_force: found.map(|found| found.contact_force),
        max_pressure: found.map(|found| found.max_pressure),
        max_pressure_recovered: found.and_then(|found| found.max_recovered_pressure),
        active: found.map(|found| found.active),
        min_opening: found.map(|found| found.min_opening),
        max_tension: found.and_then(|found| found.bond.as_ref()).map(|bond| bond.max_tension),
        friction: found.and_then(|found| found.friction.as_ref()).map(|found| FrictionSummary {
            law: case.contacts[k].friction.as_ref().map_or("", |friction| friction.law()).to_owned(),
            mu: pair.friction.coulomb(),
            tangential_force: S::friction_written(found),
            line: S::friction_line(found),
            surface: S::friction_surface(found),
            max_slip: found.max_slip,
        }),
    }
}

fn certificate<S: ReportSpace>(case: &Case<S>, solution: &CertifiedSolution<S>) -> Certificate {
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
pub(crate) fn projected<S: ReportSpace>(case: &Case<S>, loads: &[LeftOut<S>]) -> Vec<ProjectedLoad> {
    let of = |of: &LeftOut<S>| {
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
fn law<S: ReportSpace>(problem: &ContactProblem<S>) -> &'static str {
    match problem.contacts.iter().any(|pair| pair.friction.coulomb().is_some()) {
        true => "coulomb",
        false if problem.has_friction() => "tresca",
        false => "frictionless",
    }
}

/// Makes the summary of a residual, with Coulomb friction.
fn coulomb<S: ReportSpace>(result: &CoulombResult<S>) -> Coulomb {
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

fn bounds<S: ReportSpace>(solution: &CertifiedSolution<S>) -> Bounds {
    let Some(bounds) = solution.bounds.filter(|_| solution.is_certified()) else { return Bounds::default() };
    Bounds {
        energy_norm: Some(bounds.energy_norm),
        potential_energy: Some(bounds.potential_energy),
        contact_force: bounds.contact_force.ok(),
        contact_force_reason: bounds.contact_force.err().map(|reason| reason.to_string()),
    }
}

fn results<S: ReportSpace>(case: &Case<S>, solution: &Fields<'_, S>, change: Option<f64>) -> Results {
    let lines = S::line_results(solution.results);
    let Some(r) = solution.results else { return Results { lines, ..Results::default() } };
    let force = |body: usize, on: &str, force: S::Vector| Reaction {
        body: case.bodies[body].name.clone(),
        on: on.to_owned(),
        fx: force[0],
        fy: force[1],
        fz: force.entries().get(2).copied(),
    };
    let cut = |of: &certified_contact::CutResults| CutResult {
        name: of.name.clone(),
        force: of.force,
        shortening: of.shortening,
    };
    let reactions = r.reactions.iter().map(|of| force(of.body, &of.on, of.force));
    let springs = r.springs.iter().map(|of| force(of.body, &of.on, of.force));
    Results {
        energy_norm_squared: Some(r.energy_norm_squared.clone()),
        contact_force: Some(r.contact_force),
        lines,
        max_pressure: Some(r.max_pressure),
        max_pressure_recovered: max_recovered(r),
        max_edge_pressure: Some(r.max_facet_pressure),
        min_opening: Some(r.min_opening),
        reactions: Some(reactions.collect()),
        springs: (!r.springs.is_empty()).then(|| springs.collect()),
        cuts: (!r.cuts.is_empty()).then(|| r.cuts.iter().map(cut).collect()),
        balance: Some(r.balance.iter().map(|b| S::motion(b.force, b.moment).as_ref().to_vec()).collect()),
        max_displacement: Some(r.max_displacement),
        max_von_mises: r.max_von_mises,
        peak_stress: r.peak_stress.map(|peak| PeakStress {
            von_mises: peak.von_mises,
            body: case.bodies[peak.body].name.clone(),
            x: peak.point[0],
            y: peak.point[1],
            z: peak.point.entries().get(2).copied(),
            change,
        }),
        principal_stress: r.principal_stress.as_ref().map(|both| {
            let [smallest, largest] = both.each_ref().map(|found| PrincipalStress {
                value: found.value,
                body: case.bodies[found.body].name.clone(),
                x: found.point[0],
                y: found.point[1],
                z: found.point.entries().get(2).copied(),
            });
            PrincipalStresses { smallest, largest }
        }),
        stress_limits: stress_limits::found(case, solution),
    }
}

/// The largest pressure of all pairs, if any is recovered; the nodal ones of the others count.
fn max_recovered<S: ReportSpace>(results: &certified_contact::Results<S>) -> Option<f64> {
    let recovered = results.contacts.iter().any(|pair| pair.max_recovered_pressure.is_some());
    let largest = |pair: &PairResults<S>| pair.max_recovered_pressure.unwrap_or(pair.max_pressure);
    results.contacts.iter().map(largest).reduce(f64::max).filter(|_| recovered)
}

/// Gaps, openings and pressures at the nodes of a pair; in the plane with arc lengths along its first body.
pub(crate) fn contact_rows<S: ReportSpace>(solution: &Fields<'_, S>, pair: usize) -> Vec<ContactRow> {
    let first = solution.problem.blocks().nth(pair).map_or(0, |block| block.start);
    let tangents = solution.problem.tangential_blocks().nth(pair).unwrap_or_default();
    let tangential = &solution.last.tangential;
    // With Coulomb friction the bound holds for the problem with these frozen limits.
    let given = solution.problem.contacts[pair].friction.coulomb().is_none();
    let frozen = solution.frozen_limit.as_ref().filter(|_| !given).map(|limits| limits[pair]);
    let of = &solution.problem.contacts[pair];
    let friction = |k: usize, pressed: bool, (length, normal): (f64, f64)| {
        let row = tangents.clone().nth(k)?;
        let [force, slips] =
            [&tangential.force, &tangential.slip].map(|all| of.along_tangents(k, &all[tangents.clone()]));
        let both = [force * (1.0 / length), slips * (1.0 / (normal * normal))];
        let in_space = S::friction_in_space(both);
        let (traction, slip) = match in_space {
            Some(_) => (norm(both[0]), norm(both[1])),
            None => (tangential.force[row] * normal / length, tangential.slip[row] / normal),
        };
        Some(FrictionRow {
            tangential: traction,
            slip,
            in_space,
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
    let recovered = recovered_pressure(solution.problem, pair, &forces).filter(|_| !of.is_bonded());
    let bond = solution.results.and_then(|results| results.contacts.get(pair)?.bond.as_ref());
    let pair = &solution.problem.contacts[pair];
    let points = solution.problem.bodies[pair.body].mesh().points();
    let (last, interface) = (solution.last, &pair.interface);
    interface
        .pairs()
        .iter()
        .enumerate()
        .map(|(k, pair)| {
            let place = points[pair.nodes[0]];
            let (length, normal) = (pair.weight, pair.normal_length());
            let force = last.contact.normal_reaction[first + k];
            ContactRow {
                s: S::arc_length(interface, k),
                x: place[0],
                y: place[1],
                z: place.entries().get(2).copied(),
                gap: pair.gap / normal,
                opening: last.opening[first + k] / normal,
                pressure: bond.map_or(force * normal / length, |bond| bond.pressure[k]),
                active: u8::from(force > 0.0 || bond.is_some()),
                pressure_recovered: recovered.as_ref().map(|recovered| recovered[k]),
                step: None,
                friction: friction(k, force > 0.0, (length, normal)),
            }
        })
        .collect()
}

//! The contract of report.json: keys, order, finite numbers.

use super::*;

pub(crate) fn sample(hash: &str) -> Report {
    let mut run = Map::new();
    run.insert("threads".into(), 2.into());
    run.insert(CASE_HASH.into(), hash.into());
    let row = IterationRow {
        iteration: 1,
        theta: Some(0.4),
        precision: Some(2.0),
        eta_nndd: Some(1.2270569444),
        qp_path: Some("clarabel".into()),
        qp_iterations: 11,
        ..IterationRow::default()
    };
    Report {
        schema: SCHEMA,
        status: Status { word: "converged".into(), code: 0, reason: "eta_nndd <= 0.1 eta_dis".into() },
        case: serde_json::json!({ "schema": 1, "title": "t" }),
        bodies: vec![BodySummary {
            name: "upper".into(),
            nodes: 190,
            cells: CellCount::Triangles(324),
            unknowns: 351,
            ..BodySummary::default()
        }],
        contact: vec![ContactSummary {
            bodies: vec!["upper".into(), "lower".into()],
            imposed: "upper".into(),
            pairs: 19,
            line: Some(ContactLine { length: 2.0, ..ContactLine::default() }),
            ..ContactSummary::default()
        }],
        iterations: vec![row],
        problem: "frictionless".into(),
        certificate: Some(Certificate { valid: true, e_cre: Some(0.1), ..Certificate::default() }),
        coulomb: None,
        results: Results {
            lines: Some(lines(vec![[0.0, 1.6666666666666667]])),
            reactions: Some(vec![Reaction {
                body: "upper".into(),
                on: "left".into(),
                fx: 1.0,
                fy: -0.5,
                ..Reaction::default()
            }]),
            ..Results::default()
        },
        adaptive: vec![],
        steps: vec![],
        notes: vec![],
        timings: Timings::default(),
        run,
    }
}

fn lines(intervals: Vec<[f64; 2]>) -> LineResults {
    LineResults { contact_intervals: Some(intervals), ..LineResults::default() }
}

#[test]
fn a_report_of_solids_has_three_components_and_no_contact_line() {
    let surface = ContactSurface {
        area: SurfaceArea { certain: Some(0.5), possible: Some(0.75), total: 1.0 },
        patches: Some(vec![SurfacePatch { area: 0.5, centre: vec![0.0; 3], force: vec![0.0, 0.0, 2.0] }]),
    };
    let contact = ContactSummary {
        surface: Some(surface),
        moment: Some(Spin::Solid([1.0, 2.0, 3.0])),
        ..ContactSummary::default()
    };
    let value = serde_json::to_value(contact).unwrap();
    assert_eq!(value["area"], serde_json::json!({ "certain": 0.5, "possible": 0.75, "total": 1.0 }));
    assert_eq!((&value["patches"][0]["force"][2], &value["moment"][2]), (&2.0.into(), &3.0.into()));
    assert!(value.get("length").is_none() && value.get("contact_intervals").is_none());
    let results = serde_json::to_value(Results::default()).unwrap();
    assert!(results.get("contact_intervals").is_none());
}

#[test]
fn a_report_comes_back_as_it_was() {
    let report = sample("abc");
    let text = report.to_json().unwrap();
    assert_eq!(Report::from_json(&text).unwrap(), report);
    assert_eq!(report.case_hash(), Some("abc"));
    assert!(Report::from_json("{}").is_err());
}

#[test]
fn keys_and_their_order_are_the_contract() {
    let value: Value = serde_json::from_str(&sample("abc").to_json().unwrap()).unwrap();
    let keys = |v: &Value| v.as_object().unwrap().keys().cloned().collect::<Vec<_>>().join(" ");
    assert_eq!(
        keys(&value),
        "schema status case bodies contact iterations problem certificate results adaptive notes timings run"
    );
    assert_eq!(keys(&value["status"]), "word code reason");
    assert_eq!(keys(&value["bodies"][0]), "name nodes triangles unknowns floating free_motions");
    assert_eq!(
        keys(&value["contact"][0]),
        "name law kind bodies imposed pairs length contact_intervals width resultant moment centre max_pressure_at contact_force \
         max_pressure active min_opening"
    );
    assert_eq!(
        keys(&value["iterations"][0]),
        "iteration theta precision eta_nndd eta_dis e_cre contact_nodes contact_force contact_forces qp_path qp_iterations \
         step inner"
    );
    assert_eq!(
        keys(&value["certificate"]),
        "valid reason problem e_cre relative relative_guaranteed eta_dis eta_nndd split parts pressure_shift \
         projected_load checks bounds"
    );
    assert_eq!(keys(&value["certificate"]["split"]), "discretisation algebraic");
    let parts = keys(&value["certificate"]["parts"]);
    assert_eq!(parts, "mesh iteration contact lift gap_data friction round_off");
    let bounds = keys(&value["certificate"]["bounds"]);
    assert_eq!(bounds, "energy_norm potential_energy contact_force contact_force_reason");
    let step = serde_json::to_value(AdaptiveRow::default()).unwrap();
    assert_eq!(keys(&step), "step nodes pairs e_cre relative iterations energy_norm_squared peak_stress");
    assert_eq!(
        keys(&value["certificate"]["checks"]),
        "equilibrium traction_jump boundary_traction penetration pressure_sign supports imposed_displacement \
         rigid_balance rotation friction_cone"
    );
    assert_eq!(
        keys(&value["results"]),
        "energy_norm_squared contact_force contact_intervals contact_stretches max_pressure max_edge_pressure \
         min_opening reactions balance max_displacement max_von_mises peak_stress principal_stress"
    );
    assert_eq!(keys(&value["results"]["reactions"][0]), "body on fx fy");
    assert_eq!(keys(&value["timings"]), "mesh assembly factorisation iterations estimate write total");
    assert!(value["iterations"][0]["eta_dis"].is_null());
}

#[test]
fn with_coulomb_friction_there_is_no_certificate() {
    let mut report = sample("abc");
    (report.certificate, report.coulomb) = (None, Some(Coulomb::default()));
    let text = report.to_json().unwrap();
    assert_eq!(Report::from_json(&text).unwrap(), report);
    let value: Value = serde_json::from_str(&text).unwrap();
    assert!(value["certificate"].is_null() && report.valid_certificate().is_none());
    let keys: Vec<&String> = value["coulomb"].as_object().unwrap().keys().collect();
    assert_eq!(keys[..5], ["e_b", "relative", "kappa", "one_sign", "estimate"]);
}

#[test]
fn lists_are_null_where_nothing_is_known_and_empty_where_there_is_none() {
    let unknown = Results { lines: Some(LineResults::default()), ..Results::default() };
    let unknown = serde_json::to_value(unknown).unwrap();
    assert!(unknown.as_object().unwrap().contains_key("contact_intervals"));
    assert!(unknown.as_object().unwrap().values().all(serde_json::Value::is_null), "{unknown}");
    let open = Results { lines: Some(lines(Vec::new())), ..Results::default() };
    assert_eq!(serde_json::to_value(open).unwrap()["contact_intervals"], serde_json::json!([]));
}

#[test]
fn numbers_that_are_not_finite_are_named_and_refused() {
    let field = |change: &dyn Fn(&mut Report)| {
        let mut report = sample("abc");
        change(&mut report);
        match report.to_json() {
            Err(ReportError::NotFinite { field, .. }) => field,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(field(&|r| r.certificate.as_mut().unwrap().e_cre = Some(f64::NAN)), "certificate.e_cre");
    assert_eq!(field(&|r| r.iterations[0].theta = Some(f64::INFINITY)), "iterations.0.theta");
    assert_eq!(
        field(&|r| r.results.lines = Some(lines(vec![[0.0, 1.0], [0.0, f64::NEG_INFINITY]]))),
        "results.contact_intervals.1.1"
    );
}

#[test]
fn a_load_step_is_checked_before_it_takes_the_place_of_the_one_before() {
    let mut step = StepSummary {
        results: Results { max_pressure: Some(1.0), ..Results::default() },
        ..Default::default()
    };
    assert!(step.check().is_ok());
    step.results.max_pressure = Some(f64::INFINITY);
    let Err(ReportError::NotFinite { field, .. }) = step.check() else { panic!("{step:?}") };
    assert_eq!(field, "results.max_pressure");
}

//! Cases whose results say more than an exit status and a message.

use super::*;

#[test]
fn a_load_along_the_free_direction_of_a_support_is_allowed() {
    // Decision: a side held in x may well be sheared in y; only a
    // load in the held direction is a contradiction (case_load_along_support.toml).
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let more = ["--set", "body.0.traction.0.on=\"left\""];
    let output = solve(&cases().join("paper.toml"), &out, &more);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(report(&out).certificate.as_ref().unwrap().valid);
}

#[test]
fn without_any_data_the_bound_is_absolute() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("bad/case_no_load.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let certificate = report(&out).certificate.unwrap();
    assert_eq!((certificate.relative, certificate.relative_guaranteed), (None, None));
    assert!(certificate.valid && certificate.e_cre == Some(0.0), "{:?}", certificate.e_cre);
}

#[test]
fn the_direction_of_the_edges_in_a_file_does_not_matter() {
    // The contact edges the other way round, and in another order.
    let temp = tempfile::tempdir().unwrap();
    let mesh = std::fs::read_to_string(cases().join("bad/meshes/sound.msh")).unwrap();
    let edges = "1 1 2 1 1 1 2\n2 1 2 1 1 2 3\n";
    assert!(mesh.contains(edges));
    let case = std::fs::read_to_string(cases().join("bad/mesh_holes.toml")).unwrap();
    std::fs::write(temp.path().join("case.toml"), case.replace("meshes/holes.msh", "mesh.msh")).unwrap();
    let results = [edges, "1 1 2 1 1 2 1\n2 1 2 1 1 3 2\n", "1 1 2 1 1 3 2\n2 1 2 1 1 2 1\n"].map(|turned| {
        std::fs::write(temp.path().join("mesh.msh"), mesh.replace(edges, turned)).unwrap();
        let out = temp.path().join("out");
        let output = solve(&temp.path().join("case.toml"), &out, &["--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        numbers(&out)
    });
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}

#[test]
fn no_iterations_still_give_a_valid_bound() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("bad/case_no_iterations.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(5), "{}", said(&output));
    let report = report(&out);
    assert_eq!(report.status.word, "max_iterations");
    assert!(
        report.certificate.as_ref().unwrap().valid
            && report.certificate.as_ref().unwrap().e_cre.unwrap() > 0.0
    );
}

#[test]
fn each_stretch_of_a_contact_has_its_results() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("bad/mesh_stretches.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    // Half a metre each, a metre of free surface between them.
    assert_eq!(report(&out).results.lines.unwrap().contact_intervals.unwrap(), [[0.0, 0.5], [0.5, 1.0]]);
    // The page has the force of each.
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for what in ["resultant x", "resultant y", "∫ p ds"] {
        for part in ["0 to 0.5000", "0.5000 to 1.000"] {
            assert!(
                page.contains(&format!("<td>{what} of the stretch s = {part}</td>")),
                "{what} {part}: {page}"
            );
        }
    }
}

#[test]
fn a_theta_too_large_is_noticed_early() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("bad/case_theta_too_large.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(5), "{}", said(&output));
    let report = report(&out);
    assert!(report.iterations.len() < 20, "{} iterations", report.iterations.len());
    // Its iterate is useless, but the bound of its error is still valid.
    assert!(report.certificate.as_ref().unwrap().valid && report.notes.is_empty(), "{:?}", report.notes);
}

#[test]
fn a_stagnation_keeps_its_bound() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = solve(&cases().join("bad/case_stagnation.toml"), &out, &[]);
    assert_eq!(output.status.code(), Some(5), "{}", said(&output));
    let report = report(&out);
    assert_eq!(report.status.word, "stalled");
    assert!(
        report.certificate.as_ref().unwrap().valid
            && report.certificate.as_ref().unwrap().e_cre.unwrap() > 0.0
    );
}

//! An adaptive run whose bound rises on two meshes in a row ends with the mesh of the smallest bound: status, words, report and pictures.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::Path;
use std::process::Command;

/// Solves the case in a directory; returns the exit status, what was said, and the report.
fn solved(directory: &Path, settings: &[&str]) -> (i32, String, Report) {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/bad/adapt_bound_rises.toml");
    let mut program = Command::new(env!("CARGO_BIN_EXE_nndd"));
    program.current_dir(directory).arg("solve").arg(case).args(["--out", "out"]);
    settings.iter().for_each(|setting| {
        program.args(["--set", setting]);
    });
    let output = program.output().unwrap();
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let report = std::fs::read_to_string(directory.join("out/report.json"));
    let report = Report::from_json(&report.unwrap_or_else(|_| panic!("no report: {said}"))).unwrap();
    (output.status.code().unwrap(), said, report)
}

/// Finds the attribute `NumberOfPoints` of a ParaView file.
fn points(file: &Path) -> usize {
    let bytes = std::fs::read(file).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    text.split("NumberOfPoints=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
}

#[test]
fn the_answer_is_that_of_the_mesh_with_the_smallest_bound() {
    let whole = tempfile::tempdir().unwrap();
    let (code, said, report) = solved(whole.path(), &[]);
    assert_eq!((code, report.status.code, report.status.word.as_str()), (6, 6, "target_missed"), "{said}");
    let bounds: Vec<f64> = report.adaptive.iter().map(|step| step.relative.unwrap()).collect();
    let [.., before, third, last] = bounds[..] else { panic!("{bounds:?}") };
    assert!(before < third && third < last, "{bounds:?}");
    let certificate = report.certificate.unwrap();
    assert!(certificate.valid, "{said}");
    let mesh = certificate.smallest_mesh.unwrap();
    let best = &report.adaptive[mesh - 1];
    assert!(mesh < bounds.len() && bounds.iter().all(|bound| best.relative.unwrap() <= *bound), "{bounds:?}");
    assert_eq!((certificate.relative, certificate.e_cre), (best.relative, best.e_cre));
    let of_mesh = format!("the certificate is that of mesh {mesh}");
    for words in ["the bound rose on two meshes in a row", &of_mesh] {
        assert!(said.contains(words) && report.status.reason.contains(words), "{said}");
    }
    // The waves are there on finer meshes; what is said does not deny that these would lower the bound.
    assert!(said.contains("not linear along the edges") && !said.contains("do not lower it"), "{said}");
    let nodes: Vec<usize> = report.bodies.iter().map(|body| body.nodes).collect();
    assert_eq!(nodes.iter().sum::<usize>(), best.nodes);
    let out = whole.path().join("out");
    for (body, nodes) in report.bodies.iter().zip(&nodes) {
        assert_eq!(points(&out.join(format!("{}.vtu", body.name))), *nodes);
    }

    // Fields and pictures are those of a run that ends with that mesh.
    let short = tempfile::tempdir().unwrap();
    let (code, said, report) = solved(short.path(), &[&format!("adapt.max_steps={mesh}")]);
    assert_eq!((code, report.adaptive.len()), (6, mesh), "{said}");
    assert_eq!(report.certificate.unwrap().e_cre, certificate.e_cre);
    let files =
        ["problem", "deformed", "displacement", "von_mises", "contact"].map(|f| format!("figures/{f}.svg"));
    let files =
        files.iter().map(String::as_str).chain(["upper.vtu", "lower.vtu", "contact.vtu", "contact.csv"]);
    for file in files {
        let [a, b] = [&out, &short.path().join("out")].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
}

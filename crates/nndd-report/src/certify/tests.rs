use super::field_file::read;
use super::matched::matched;
use super::*;
use fem_core::geometry::Vector;
use std::path::Path;

/// The paper's problem, and its displacements.
fn solved() -> (Case, ContactProblem, Vec<Vec<Vector>>) {
    let case = Case::parse(case_io::template::PAPER, "paper.toml", &[]).unwrap();
    let problem = case.build().unwrap().0;
    let settings = convert::settings(&case);
    let found = certified_contact::solve(problem.clone(), &settings, &mut certified_contact::Silent);
    let bodies = found.unwrap().estimate.unwrap().pair.bodies;
    (case, problem, bodies.into_iter().map(|body| body.displacement).collect())
}

#[test]
fn fields_in_memory_are_certified_as_those_of_files() {
    let (case, problem, fields) = solved();
    let folder = tempfile::tempdir().unwrap();
    let written = |(k, field): (usize, &Vec<Vector>)| {
        let rows = problem.bodies[k].mesh().points().iter().zip(field);
        let rows = rows.map(|(x, u)| format!("{:e},{:e},{:e},{:e}\n", x[0], x[1], u[0], u[1]));
        let path = folder.path().join(format!("{k}.csv"));
        std::fs::write(&path, format!("x,y,ux,uy\n{}", rows.collect::<String>())).unwrap();
        path
    };
    let files: Vec<PathBuf> = fields.iter().enumerate().map(written).collect();
    let of_files = certify(&case, &problem, &files).unwrap();
    let in_memory = of_fields(&case, &problem, &fields, None).unwrap();
    assert!(in_memory.bound().is_some());
    assert_eq!(summary(&case, &of_files), summary(&case, &in_memory));
    assert_eq!(in_memory.missed_support, None);
    // Pressures of the nodes that are not in contact do not count.
    let mut pressure = vec![f64::MAX; fields[0].len()];
    let pair = &problem.contacts[0];
    for node in pair.interface.pairs() {
        pressure[node.nodes[0].index()] = 0.0;
    }
    let without = of_fields(&case, &problem, &fields, Some(&[pressure])).unwrap();
    assert!(without.estimate.unchecked().e_cre > in_memory.estimate.unchecked().e_cre);
}

#[test]
fn fields_of_other_lengths_are_refused() {
    let (case, problem, mut fields) = solved();
    let said = |fields: &[Vec<Vector>], pressures: Option<&[Vec<f64>]>| {
        of_fields(&case, &problem, fields, pressures).unwrap_err().message.unwrap()
    };
    assert!(said(&fields[..1], None).starts_with("fields of displacements: found 1, and the case has 2"));
    assert!(said(&fields, Some(&[])).starts_with("pressures: found 0, and the case has 1"));
    let short = said(&fields, Some(&[vec![0.0; 3]]));
    assert!(
        short.starts_with("pressures of the pair \"upper-lower\": found 3, and the case has 190"),
        "{short}"
    );
    fields[1].pop();
    assert!(
        said(&fields, None).starts_with("displacements of body \"lower\": found 189, and the case has 190")
    );
}

/// Random numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[((self.next() * all.len() as f64) as usize).min(all.len() - 1)]
    }
}

/// Two blocks under pressure whose meshes do not match: nodes of both are moved so that they do. The exact solution is linear.
fn unmatched() -> (Case, ContactProblem, Vec<Body>, PathBuf) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/true_numbers/certify-snap");
    let case = crate::run::read_case(&folder.join("case.toml"), &[]).unwrap().into_plane().unwrap();
    let problem = case.build().unwrap().0;
    let bodies = case.build_bodies().unwrap();
    (case, problem, bodies, folder)
}

fn exact(bodies: &[Body]) -> Vec<Vec<Vector>> {
    let at = |x: &Vector| Vector::new(0.0039 * x[0], -0.0091 * x[1]);
    bodies.iter().map(|body| body.mesh().points().iter().map(at).collect()).collect()
}

/// The energy norm of the error of fields on the meshes of the case.
fn true_error(bodies: &[Body], fields: &[Vec<Vector>]) -> f64 {
    let all = bodies.iter().zip(fields).zip(exact(bodies));
    let squared = all.map(|((body, u), v)| fem_core::norm::energy_distance_squared(body, u, &v));
    squared.sum::<f64>().sqrt()
}

#[test]
fn the_bound_is_for_the_field_of_the_file_though_nodes_are_moved() {
    let (case, problem, bodies, folder) = unmatched();
    let files = ["u.csv", "l.csv"].map(|name| folder.join(name));
    let fields: Vec<Vec<Vector>> = files
        .iter()
        .zip(&bodies)
        .map(|(file, body)| matched(&read(file).unwrap(), body.mesh()).ok().unwrap().field)
        .collect();
    let truth = true_error(&bodies, &fields);
    assert!((truth - 1.592).abs() < 1e-3, "{truth}");
    let found = certify(&case, &problem, &files).unwrap();
    let bound = found.bound().unwrap();
    assert!(bound >= truth && bound < 1.5 * truth, "{bound} {truth}");
    // Without the change of the field there would be no bound.
    assert!(found.estimate.unchecked().e_cre < truth && found.change > 0.0, "{}", found.change);
}

#[test]
fn no_field_and_no_pressure_gets_a_false_bound() {
    let (case, problem, bodies, _) = unmatched();
    let mut random = Random(7);
    let mut valid = 0;
    for k in 0..60 {
        let amplitude = random.pick(&[0.0, 1e-9, 1e-5, 1e-3, 0.03, 10.0]);
        let keeps_supports = k % 4 != 0;
        let mut fields = exact(&bodies);
        for (field, body) in fields.iter_mut().zip(&bodies) {
            for (u, x) in field.iter_mut().zip(body.mesh().points()) {
                let free = [x[0] > 0.0 || !keeps_supports, x[1] > 0.0 || !keeps_supports];
                for c in (0..2).filter(|c| free[*c]) {
                    u[c] += amplitude * (random.next() - 0.5);
                }
            }
        }
        let size = random.pick(&[0.0, 1e-3, 10.0, 1e6]);
        let kind = random.pick(&[0, 1, 2, 3]);
        let nodes = bodies[0].mesh().points().len();
        let pressures: Vec<f64> = (0..nodes).map(|_| size * (random.next() - 0.3)).collect();
        let given = [vec![10.0; nodes], pressures];
        let given = (kind > 0).then(|| &given[usize::from(kind > 1)..][..1]);
        let found = of_fields(&case, &problem, &fields, given).unwrap();
        let truth = true_error(&bodies, &fields);
        if let Some(bound) = found.bound() {
            assert!(bound >= truth, "{k}: amplitude {amplitude}, kind {kind}: {bound} {truth}");
            valid += 1;
        }
    }
    assert!(valid >= 30, "{valid}");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let (case, problem, bodies, _) = unmatched();
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut fields = exact(&bodies);
        let mut pressure = vec![10.0; fields[0].len()];
        let side = bodies[0].mesh().group("u_bottom").unwrap()[1];
        pressure[bodies[0].mesh().topology().facets()[side][0].index()] = bad;
        let found = of_fields(&case, &problem, &fields, Some(&[pressure]));
        // A finite pressure is brought into balance.
        let sound = found.as_ref().is_ok_and(|found| found.bound().is_none_or(f64::is_finite));
        assert!(found.is_err() || (bad == 1e300 && sound), "{bad}");
        fields[1][7][0] = bad;
        assert!(of_fields(&case, &problem, &fields, None).is_err(), "{bad}");
    }
}

#[test]
fn damaged_tables_are_refused_or_bounded() {
    let (case, problem, _, folder) = unmatched();
    let temp = tempfile::tempdir().unwrap();
    let [upper, lower] = ["u.csv", "l.csv"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
    let files = ["u.csv", "l.csv"].map(|name| temp.path().join(name));
    std::fs::write(&files[1], lower).unwrap();
    let mut random = Random(3);
    for _ in 0..80 {
        let mut lines: Vec<Vec<String>> =
            upper.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
        let at = 1 + (random.next() * (lines.len() - 1) as f64) as usize;
        let column = random.pick(&[0, 1, 2, 3]);
        let bad = ["nan", "inf", "1e308", "-1e308", "5e-324", "1e300", "9e999", "-0", "", "0x1", "1e17"];
        let added = if random.next() < 0.5 { at } else { lines.len() };
        let mut line = lines[at].clone();
        line[column] = random.pick(&bad).to_owned();
        lines.insert(added, line);
        let text: Vec<String> = lines.iter().map(|cells| cells.join(",")).collect();
        std::fs::write(&files[0], text.join("\n")).unwrap();
        if let Ok(found) = certify(&case, &problem, &files) {
            assert!(found.bound().is_none_or(|bound| bound >= 1.592), "{}", lines[added].join(","));
        }
    }
}

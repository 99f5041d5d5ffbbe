//! Grids of blocks between planes, and beams on circles, with the friction of Tresca on every line: nodes belong to several lines, and supports
//! impose slips at the ends of some.

use case_io::Case;
use certified_contact::{CertifiedSolution, Settings, Silent, solve};
use nndd::{Method, NewtonSettings, NnddStatus};
use std::fmt::Write;
use tests::random::Random;

/// Solves a case exactly.
fn solved(text: &str) -> CertifiedSolution {
    let case = Case::parse(text, "case.toml", &[]).unwrap();
    let mut settings = Settings::default();
    settings.method = NewtonSettings::default().into();
    solve(case.build().unwrap().0, &settings, &mut Silent).unwrap()
}

/// Draws a number between two, evenly in its logarithm.
fn size(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.unit())
}

/// Makes a random grid: gravity, pressures on the right and the top, a support that presses the last block of the top row down, and a plane that pushes
/// it to the left.
fn grid(random: &mut Random) -> String {
    let [columns, rows] = [random.integer(1, 3), random.integer(1, 3)];
    let [presses, pushes] = [0, 1].map(|_| random.unit() < 0.6);
    let lines = |random: &mut Random, count: usize| -> (Vec<f64>, Vec<usize>) {
        let widths: Vec<f64> = (0..count).map(|_| 0.8 + 0.5 * random.unit()).collect();
        let starts = (0..=count).map(|k| widths[..k].iter().sum()).collect();
        (starts, (0..count).map(|_| random.integer(1, 4)).collect())
    };
    let ((x, across), (y, up)) = (lines(random, columns), lines(random, rows));
    let mut text = "schema = 1\n".to_owned();
    let mut contacts = String::new();
    for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let last = i + 1 == columns && j + 1 == rows;
        let [young, nu] = [size(random, 0.3, 3.0), 0.05 + 0.4 * random.unit()];
        let [width, height] = [x[i + 1] - x[i], y[j + 1] - y[j]];
        write!(text, "[materials.m{i}{j}]\nyoung = {young:?}\npoisson = {nu:?}\n").unwrap();
        write!(text, "[[body]]\nname = \"g{i}{j}\"\nmaterial = \"m{i}{j}\"\n").unwrap();
        writeln!(text, "body_force = [0.0, {:?}]", -size(random, 1e-5, 3e-4)).unwrap();
        write!(text, "generator = {{ kind = \"block\", origin = [{:?}, {:?}], ", x[i], y[j]).unwrap();
        writeln!(text, "size = [{width:?}, {height:?}], cells = [{}, {}] }}", across[i], up[j]).unwrap();
        let mut pressure = |on: &str| {
            let p = size(random, 1e-4, 2e-3);
            write!(text, "[[body.traction]]\non = \"{on}\"\npressure = {p:?}\n").unwrap();
        };
        if i + 1 == columns && !(last && pushes) {
            pressure("right");
        }
        if j + 1 == rows && !(last && presses) {
            pressure("top");
        }
        if last && presses {
            let uy = -size(random, 1e-4, 2e-3);
            write!(text, "[[body.displacement]]\non = \"top\"\nuy = {uy:?}\n").unwrap();
        }
        let mut contact = |bodies: &str, sides: &str, more: &str| {
            let limit = size(random, 3e-5, 8e-3);
            write!(contacts, "[[contact]]\nbodies = [\"g{i}{j}\"{bodies}]\nsurfaces = [{sides}]\n{more}")
                .unwrap();
            writeln!(contacts, "friction = {{ law = \"tresca\", limit = {limit:?} }}").unwrap();
        };
        let plane = |point: f64, normal: f64| {
            format!(
                "obstacle = {{ kind = \"plane\", point = [{point:?}, 0.0], normal = [{normal:?}, 0.0] }}\n"
            )
        };
        match i {
            0 => contact("", "\"left\"", &plane(0.0, 1.0)),
            _ => contact(&format!(", \"g{}{j}\"", i - 1), "\"left\", \"right\"", ""),
        }
        match j {
            0 => contact(
                "",
                "\"bottom\"",
                "obstacle = { kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }\n",
            ),
            _ => contact(&format!(", \"g{i}{}\"", j - 1), "\"bottom\", \"top\"", ""),
        }
        if last && pushes {
            contact("", "\"right\"", &format!("{}motion = [-3e-4, 0.0]\n", plane(x[columns], -1.0)));
        }
    }
    text + &contacts
}

#[test]
fn random_grids_with_friction_on_both_sides_of_corners_are_solved_and_certified() {
    let mut random = Random::new(7);
    let mut driven = 0;
    for number in 0..60 {
        let text = grid(&mut random);
        let found = solved(&text);
        assert_eq!(found.nndd.status, NnddStatus::StoppedByCriterion, "{number}:\n{text}");
        assert!(found.is_certified(), "{number}:\n{text}");
        driven += usize::from(text.contains("uy"));
    }
    assert!(driven > 20, "{driven}");
}

#[test]
fn friction_beside_a_driven_side_is_at_its_limit_and_the_bound_takes_what_the_mesh_carries() {
    let text = include_str!("../cases/true_numbers/stall-gridtresca-7.toml");
    let found = solved(text);
    assert_eq!(found.nndd.status, NnddStatus::StoppedByCriterion);
    // The upper end of the line on which the moved plane and the support of the top impose the slip.
    let limit = 0.0072315851974436495;
    let at_end = |values: &[f64]| values.iter().fold(0.0f64, |most, q| most.max(q.abs()));
    let of_pair = |values: &[f64]| -> Vec<f64> {
        let blocks: Vec<_> = found.problem.tangential_blocks().collect();
        values[blocks[6].clone()].to_vec()
    };
    let tangential = &found.last().tangential;
    let [forces, limits, slips] =
        [&tangential.force, &tangential.limit, &tangential.slip].map(|values| of_pair(values));
    let end = (0..slips.len()).find(|i| (slips[*i].abs() - 7.085020627719964e-4).abs() < 1e-12).unwrap();
    assert_eq!(forces[end], limits[end].copysign(slips[end]));
    let estimate = found.estimate.as_ref().unwrap();
    let friction = &estimate.pair.contacts[6].friction;
    assert!(friction[end] * slips[end] >= 0.0 && at_end(friction) < 0.5 * limit, "{friction:?}");
}

/// Makes a beam on circles, two cells for each.
///
/// * `pitch`: between the circles; `radius`: of them; `friction`: line of the key.
fn beam(count: u32, [pitch, radius]: [f64; 2], pressure: f64, friction: &str) -> String {
    let mut text = format!(
        "schema = 1\n[materials.a]\nyoung = 100.0\npoisson = 0.1\n[[body]]\nname = \"b\"\nmaterial = \"a\"\n\
         generator = {{ kind = \"block\", origin = [0.0, 0.0], size = [{:?}, 1.0], cells = [{}, 1] }}\n\
         [[body.traction]]\non = \"top\"\npressure = {pressure:?}\n",
        f64::from(count) * pitch,
        2 * count
    );
    for k in 0..count {
        let centre = (f64::from(k) + 0.5) * pitch;
        write!(
            text,
            "[[contact]]\nname = \"o{k}\"\nbodies = [\"b\"]\nsurfaces = [\"bottom\"]\ngap = \"geometric\"\n\
             obstacle = {{ kind = \"circle\", centre = [{centre:?}, {:?}], radius = {radius:?} }}\n{friction}",
            -radius
        )
        .unwrap();
    }
    text
}

#[test]
fn a_beam_on_many_circles_is_certified() {
    // The longer the beam, the more the openings and slips of its displacements differ from those of the programme by rounding.
    let tresca = "friction = { law = \"tresca\", limit = 0.0037 }\n";
    for (count, sizes, friction) in [
        (16, [1.0, 1.0], ""),
        (64, [1.0, 1.0], ""),
        (128, [1.0, 0.7], ""),
        (16, [1.24, 2.5], tresca),
        (32, [1.24, 2.5], tresca),
        (64, [1.84, 1.84], tresca),
    ] {
        let found = solved(&beam(count, sizes, 0.37, friction));
        assert_eq!(found.nndd.status, NnddStatus::StoppedByCriterion, "{count} {sizes:?}");
        assert!(found.is_certified(), "{count} {sizes:?}: {:?}", found.estimate.unwrap().admissibility);
    }
}

#[test]
fn a_beam_on_circles_takes_few_steps_of_newton_nn() {
    // Without the circles that a set closes, step 2 would see a beam that its left end alone holds, and hardly converge.
    let held = "[[body.displacement]]\non = \"left\"\nux = 0.0\n[[contact]]";
    let text = beam(64, [1.0, 1.0], 1.0, "").replacen("[[contact]]", held, 1);
    let text = text.replace("young = 100.0\npoisson = 0.1", "young = 1000.0\npoisson = 0.2");
    let solved = |settings: &Settings| {
        let problem = Case::parse(&text, "case.toml", &[]).unwrap().build().unwrap().0;
        solve(problem, settings, &mut Silent).unwrap()
    };
    let exact = solved(&Settings::default());
    assert!(matches!(exact.method, Method::Newton(_)) && exact.is_certified());
    let found = solved(&Settings::default().with_method(Method::NewtonNn(NewtonSettings::default())));
    assert_eq!(found.nndd.status, NnddStatus::StoppedByCriterion);
    assert!(found.is_certified() && found.nndd.last.step[0] <= 6, "{:?}", found.nndd.history);
    assert!(found.nndd.history.iter().all(|row| row.step[1] <= 2), "{:?}", found.nndd.history);
    let [found, exact] = [found, exact].map(|of| of.nndd.last.contact.normal_reaction);
    for (found, expected) in found.iter().zip(&exact) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}
